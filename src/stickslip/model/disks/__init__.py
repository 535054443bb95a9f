"""Bladed disks as problems: a tuned one solved as one sector, and one with every sector of its own.

Imports `problem` and below. Begin with `tuned.py`; `full.py` holds all sectors together, for mistuning and as a check;
`systems.py` holds what each harmonic sees of them.
"""
