"""Finite-element models of other programs: one file per format turns bytes into a `Content` of named matrices.

Files are read in a child process, since damaged ones can end it. Imports `structure` and below.
Begin with `read.py`; `model.py` assembles what was read, `reduction.py` reduces it.
"""
