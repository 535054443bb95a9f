"""Bladed disks as problems: a tuned one solved as one sector, and one with every sector of its own.

Imports `problem` and below. Begin with `tuned.py`, which holds all sectors together, too, for mistuning and as a check.
"""
