"""The explorer: a local page on which sliders change a study and its response is solved anew, `stickslip explore STUDY`.

Imports study, report and plots, and alone in the package Dash, an optional extra. `solving.py` finds what can vary, solves the
newest request and says what is shown, `page.py` is the page, what it saves and how it is served. Begin with `solving.py`.
"""
