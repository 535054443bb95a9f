"""The law of one contact, its stiffness and friction, from measured loops.

`work.py` has the front door and the case that studies keep, `fit.py` loops, the force of each law and the
least squares with errors, `result.py` the dataset, its sentences and what to check.
"""
