"""Parameters of a problem from measured frequency responses.

`work.py` has the front door and the case that studies keep, `model.py` the response of a test and its bounds over all start
states, `fit.py` the least squares, `intervals.py` errors, profiles and lower bounds of friction, `mistakes.py` (with
outliers) what to check, `result.py` the dataset and all sentences.
"""
