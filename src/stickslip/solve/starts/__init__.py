"""Start states of friction: responses that are not unique because contacts that stick keep the forces they began with.

The space of start states, solutions for given ones, their extremes by exact gradients, and loading histories. Imports
`continuation` and below. Begin with `states.py` (what may vary, and solutions for it), then `extremes.py`.
"""
