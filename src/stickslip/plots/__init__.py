"""Figures of results, drawn with matplotlib: one function each, named by the class of its result (`results/result.py`).

Imports results, never an analysis. Begin with `look.py`, the style, and `forced_response.py`.
"""
