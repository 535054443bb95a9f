"""The numerical methods: harmonic balance, continuation, peaks, stability and time integration.

`balance` evaluates the residual, `continuation` follows its solutions, `peaks` finds and proves maxima, `curves` joins both for
one force level, `starts` varies the start state of the contacts, `stability` judges solutions, `time` integrates the same problem
as a referee, `platforms` solves the cycle of a damper alone. Imports `model` and below.
"""
