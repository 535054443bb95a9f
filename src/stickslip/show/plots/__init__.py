"""Figures of results: a function each from a dataset to a chart, named by the class of its result (`results/schema.py`).

A chart (`chart.py`) is drawn by `paper.py` with matplotlib and by `interactive.py` with plotly. Pictures of disks are no
charts and are drawn with matplotlib. Imports results, never an analysis that computes. Begin with `chart.py`, `look.py`
and `contacts.py`.
"""
