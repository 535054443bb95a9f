"""Resonance peaks, for any measured quantity: found on a traced curve, and followed as a parameter changes.

Imports `continuation` and below. Begin with `search.py` (all peaks of a curve, proven highest), then `climb.py` (one peak from a
point near it) and `continuation.py` (peaks along a parameter).
"""
