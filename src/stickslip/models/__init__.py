"""Finite-element models of other programs. `read.py` is the way in; one file a format turns bytes into a `Content`."""
