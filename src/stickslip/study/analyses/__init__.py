"""Analyses of study files: a module for each, which has its name, with its tables, its `Plan`, and its `KIND`, by which files
are read and run.

Imports `study` and below. `study/analysis.py` lists the modules of this folder: a new one is found without a line elsewhere.
Begin with `forced_response.py`, then `response_samples.py`.
"""
