"""Contact parameters of a damper from measured cycles of its platforms' motion and forces.

`work.py` has the front door, the case that studies keep, what to check before and after, and the result; `fit.py` unknowns and
laws of the lines, the least squares, the search and refits.
"""
