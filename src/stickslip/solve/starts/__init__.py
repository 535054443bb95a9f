"""Start states of friction: responses that are not unique because contacts that stick keep the forces they began with.

The space of start states, solutions for given ones, their extremes by exact gradients, and loading histories. Imports
`continuation` and below. Begin with `space.py` (what may vary), then `solutions.py` and `extremes.py`.
"""
