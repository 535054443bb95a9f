"""Parameters of a problem from measured frequency responses.

`work.py` has the front door and the case that studies keep, `fit.py` the response of a test and the least squares,
`intervals.py` errors, profiles and lower bounds of friction, `mistakes.py` (with outliers) what to check, `result.py` the dataset
and all sentences.
"""
