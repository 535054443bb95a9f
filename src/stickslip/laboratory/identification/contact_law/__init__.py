"""The law of one contact, its stiffness and friction, from measured loops.

`work.py` has the front door and the case that studies keep, `model.py` loops and the force of each law, `fit.py` the least
squares with errors, `result.py` the dataset, its sentences and what to check.
"""
