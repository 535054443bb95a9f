"""Analyses of study files, a module each: its tables, its `Plan`, and its `KINDS`, by which files are read and run.

Imports `study` and below. `study/kinds.py` lists the modules of this folder: a new one is found without a line elsewhere.
Begin with `forced_response.py`, then `response_variability.py`.
"""
