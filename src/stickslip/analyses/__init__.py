"""Analyses: what users compute with a problem. Each returns a frozen result that holds a labelled dataset.

Independent cases run in parallel processes, are kept as they finish and resume. Imports everything below `plots`, and those
only for `plot()`. Begin with `forced_response.py`; `runs` says how cases are run.
"""
