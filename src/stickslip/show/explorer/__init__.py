"""The explorer: a local page on which sliders change a study and its response is solved anew, `stickslip explore STUDY`.

Imports study, report and plots, and alone in the package Dash, an optional extra. `sliders.py` finds what can vary, `solving.py`
solves the newest request, `figures.py` and `export.py` say what is shown and saved, `page.py` is the page, `server.py` serves it.
Begin with `solving.py`.
"""
