"""Solving harmonic balance: Newton's method, arc-length continuation through folds and kinks, peaks and sensitivities.

One curve at one force level is the largest thing here; analyses combine curves. Imports `harmonic` and below. Begin with
`curve.py` (one response curve), then `continuation.py` (the steps along it), `newton.py` (one solution) and `peak.py`.
"""
