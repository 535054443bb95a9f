"""The start states of a problem as a vector of variables in [−1, 1]: which elements share one, and what ±1 means.

Every admissible solution has its tractions at the last sample in their own [LO, HI]; slider offsets reach all of them, and so
do traction ratios. Ratios and mean tractions take the static tangential stiffness of a stuck contact away: a body that
only friction holds is then held by nothing. Offsets always have an equilibrium.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from stickslip.checks import Array, Index, among, fault
from stickslip.contact.start import STARTS
from stickslip.harmonic.balance import Evaluation, HarmonicBalance
from stickslip.harmonic.cycle import friction_reach

Rule = Literal["slider_offset", "traction_ratio", "mean_traction"]
Sharing = Literal["element", "direction", "contact", "all"]

RULES = {start.key: start.code for start in STARTS}


@dataclass(frozen=True, eq=False)
class StartSpace:
    """group (elements,): the variable of each friction element; scale (elements,): its start value at variable 1."""

    rule: Rule
    group: Index
    scale: Array

    @property
    def size(self) -> int:
        """Number of variables."""
        return int(self.group.max(initial=-1)) + 1

    def values(self, variables: Array) -> Array:
        """Start values of every element for variables (size,)."""
        return np.asarray(self.scale * variables[self.group])

    def balance(self, balance: HarmonicBalance, variables: Array) -> HarmonicBalance:
        """The balance that starts there."""
        return balance.with_starts(self.values(variables), RULES[self.rule])

    def gradient(self, elements: Index, slopes: Array) -> Array:
        """Derivative by the variables from derivatives (k,) by the start values of `elements`."""
        return np.asarray(np.bincount(self.group[elements], self.scale[elements] * slopes, minlength=self.size), dtype=float)


def start_space(
    balance: HarmonicBalance, virgin: Evaluation, rule: Rule = "slider_offset", share: Sharing = "element"
) -> StartSpace:
    """The space of start states of a problem; offsets and mean tractions are scaled by what the virgin solution allows.

    An offset beyond max|u| + max L/kt is clipped; a mean traction beyond max L too.
    """
    among("rule", rule, RULES)
    if balance.table.coupled.any() and rule == "mean_traction":
        raise fault("rule", "must be slider_offset or traction_ratio with friction discs", rule)
    reach, limit = friction_reach(virgin.table, balance.tables, virgin.w)
    scale = {"slider_offset": reach, "traction_ratio": np.ones_like(reach), "mean_traction": limit}[rule]
    return StartSpace(rule, _groups(balance, share), scale)


def _groups(balance: HarmonicBalance, share: Sharing) -> Index:
    table = balance.table
    elements = table.stiffness.size
    row = np.repeat(np.arange(table.rows), np.diff(table.friction_first))
    contact = np.searchsorted(table.first_row, row, side="right") - 1
    keys = {"element": np.arange(elements), "direction": row, "contact": contact, "all": np.zeros(elements, dtype=int)}
    return np.asarray(np.unique(keys[among("share", share, keys)], return_inverse=True)[1], dtype=np.int64)
