"""Stability of periodic motions: multipliers of Floquet by the period map of a perturbation with its contact states.

Imports `balance` and `time`; used by the analyses. Begin with `multipliers.py` (one solved point); `contact_path.py` finds what
the contacts do between the samples, `period_map.py` carries the perturbation round the period on stuck modes.
"""
