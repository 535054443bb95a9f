"""Finite-element models of other programs. Start at `read.py`; each format has one file that returns a `Content`."""
