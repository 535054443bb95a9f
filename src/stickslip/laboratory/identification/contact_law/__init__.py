"""The law of one contact, its stiffness and friction, from measured loops.

`work.py` has the front door, the case that studies keep, the result with its sentences and what to check; `fit.py` loops, the
force of each law and the least squares with errors.
"""
