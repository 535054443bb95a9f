"""Mistuned wheels with local contact unknowns: many of one tuned disk, each in seconds.

Imports `continuation` and below. Begin with `tuned.py`, what all wheels of a disk share; `balance.py` is the balance of one
with its factors, `curve.py` its corrector, which continuation and searches of peaks take in place of the compiled one.
"""
