"""One response curve at one force level: swept over a band or solved at listed frequencies, with its peaks.

What analyses are made of. Imports `peaks`, `continuation` and below. Begin with `curve.py`.
"""
