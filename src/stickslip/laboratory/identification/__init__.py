"""Contact parameters and laws from what was measured, by one core of least squares (`least_squares.py`).

`contact_law` fits loops of one contact, `damper` cycles of a damper rig, `response` frequency responses. Each has the same files:
`fit` (or `model`, what parameters lead to), `result` with what to check, and `work`, the front door. Imports
`analyses`, `measurement` and below. Begin with `least_squares.py`.
"""
