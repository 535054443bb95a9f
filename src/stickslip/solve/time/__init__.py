"""Time integration, the check of harmonic balance: one-step methods with implicit contacts, and the march to a steady state.

Imports `balance` only to start from its solutions. Used by `platforms` and by the analyses in time. Begin with `march.py`
(to a steady period); `period.py` lists the integration methods, `contact_law.py` solves the contacts of one step.
"""
