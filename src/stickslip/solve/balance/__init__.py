"""Harmonic balance at one frequency: dynamic stiffness, contact forces by alternating frequency/time (AFT), residual, Jacobian.

Nothing is solved here; `continuation` iterates on what `HarmonicBalance` evaluates. Imports `problem`, `contact`, `structure` and
below. Begin with `balance.py`; `linear_part.py` holds the structure, `contact_forces.py` the contacts, `newton_matrix.py` the
Jacobian.
"""
