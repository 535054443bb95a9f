"""What every other folder uses and no engineer looks for: checks of input, files, units, progress, Ctrl-C, compiled kernels.

Knows nothing of mechanics. Begin with `checks.py` (how wrong input is refused) and `outcome.py` (what went wrong in a solution).
"""
