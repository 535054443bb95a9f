"""A damper alone between two platforms that move as prescribed: its steady cycle, by relaxation or by marching.

Imports `dampers`, `contact` and `time`. Used by the damper analyses and by identification. Begin with `cycle.py` (the steady
cycle); `relaxation.py` is the fast way through a cycle, `march.py` the safe one.
"""
