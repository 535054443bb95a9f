"""Measured records of damper rigs: reading, cleaning, reconstruction of forces and motions; synthetic records for tests.

`identification` fits parameters to them. Imports `dampers`, `platforms` and below.
Begin with `records.py` (files) and `reconstruction.py` (forces and motions at the contacts).
"""
