"""Solving harmonic balance: Newton's method, arc-length continuation through folds and kinks, sweeps and sensitivities.

One sweep at one force level is the largest thing here. Imports `balance` and below. Begin with `newton.py` (one solution), then
`continuation.py` (the steps along a curve) and `sweep.py` (from one end of a band to the other).
"""
