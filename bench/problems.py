"""The benchmark problems as stickslip's rigs."""

from __future__ import annotations

from cases import Case

from stickslip import Problem
from stickslip.model import rigs

RIGS = {"B1": rigs.single_mass, "B2a": rigs.chain, "B2b": rigs.chain_varying_load, "blade": rigs.single_blade}


def problem_of(case: Case) -> Problem:
    """The rig of a case."""
    return RIGS[case.problem]()
