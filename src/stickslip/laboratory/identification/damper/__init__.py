"""Contact parameters of a damper from measured cycles of its platforms' motion and forces.

`work.py` has the front door and the case that studies keep, `clues.py` what the loops show without a model, `model.py` unknowns
and laws of the lines, `fit.py` the least squares and the search, `intervals.py` refits, `diagnosis.py` what to check before and
after, `result.py` the dataset, its sentences and parameters over the cycles.
"""
