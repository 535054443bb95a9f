"""Results: labelled datasets, their files, what the outputs are in other quantities, and the view that figures and reports share.

Imports `balance` for quantities and measures. Begin with `schema.py` and `variables.toml` (what a result must hold),
then `files.py` (open and save) and `view.py` (peaks and curves as figures and reports need them).
"""
