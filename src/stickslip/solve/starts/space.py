"""Parametrisation of start states by variables in [−1, 1]: the elements that share one, and the meaning of ±1.

Every admissible solution has its tractions at the last sample in their own [LO, HI]; slider offsets reach all of them, and so
do traction ratios. Ratios and mean tractions take the static tangential stiffness of a stuck contact away: a body that
only friction holds is then held by nothing. Offsets always have an equilibrium. A rule for each tangential direction combines
them: ratios in the plane of a damper, and offsets along its axis, where nothing but friction holds it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from stickslip.model.contact.period import OFFSET
from stickslip.model.contact.start import STARTS
from stickslip.model.problem import Problem
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance
from stickslip.solve.balance.cycle import friction_reach
from stickslip.support.checks import Array, Index, among, fault

Rule = Literal["slider_offset", "traction_ratio", "mean_traction", "virgin"]
Sharing = Literal["element", "direction", "contact", "all"]

Rules = Rule | Sequence[Rule]
"""One rule, or one for each tangential direction t1, t2 of every contact; "virgin" sliders rest at 0 and are no variables."""

RULES = {start.key: start.code for start in STARTS}


@dataclass(frozen=True, eq=False)
class StartSpace:
    """By friction element, (elements,): code of its rule, its variable (−1: none, virgin), and its start value at variable 1."""

    kind: Index
    group: Index
    scale: Array

    @property
    def size(self) -> int:
        """Number of variables."""
        return int(self.group.max(initial=-1)) + 1

    def values(self, variables: Array) -> Array:
        """Start values of every element for variables (size,)."""
        return np.asarray(np.where(self.varied, self.scale * np.append(variables, 0.0)[self.group], 0.0))

    @property
    def varied(self) -> np.ndarray:
        """Elements that have a variable."""
        return np.asarray(self.group >= 0)

    def balance(self, balance: HarmonicBalance, variables: Array) -> HarmonicBalance:
        """The balance that starts there."""
        return balance.with_starts(self.values(variables), self.kind)

    @property
    def prescribes(self) -> bool:
        """Whether some traction is prescribed, so that a body may be held by nothing."""
        return bool(np.any(self.kind != OFFSET))

    def by_rule(self, **values: Array) -> Array:
        """Of an array (elements,) for each rule, the entries of each element's own one."""
        return np.choose(self.kind, [values[rule] for rule in RULES])

    def gradient(self, elements: Index, slopes: Array) -> Array:
        """Derivative by the variables from derivatives (k,) by the start values of `elements`."""
        varied = self.varied[elements]
        elements, slopes = elements[varied], slopes[varied]
        return np.asarray(np.bincount(self.group[elements], self.scale[elements] * slopes, minlength=self.size), dtype=float)


def number_of_variables(balance: HarmonicBalance, rule: Rules = "slider_offset", share: Sharing = "element") -> int:
    """How many variables the start states of a problem have, which no solution is needed for."""
    kind, group = _variables(balance, rule, share)
    return StartSpace(kind, group, np.zeros(kind.size)).size


def start_space(
    balance: HarmonicBalance, virgin: Evaluation, rule: Rules = "slider_offset", share: Sharing = "element"
) -> StartSpace:
    """The space of start states of a problem; offsets and mean tractions are scaled by what the virgin solution allows.

    An offset beyond max|u| + max L/kt is clipped; a mean traction beyond max L too.
    """
    kind, group = _variables(balance, rule, share)
    reach, limit = friction_reach(virgin.table, balance.tables, virgin.w)
    space = StartSpace(kind, group, reach)
    return replace(space, scale=space.by_rule(slider_offset=reach, traction_ratio=np.ones_like(reach), mean_traction=limit))


def _variables(balance: HarmonicBalance, rule: Rules, share: Sharing) -> tuple[Index, Index]:
    """Code of the rule and variable of each element."""
    refuse_forgetful(balance.problem)
    rules = rules_of(rule)
    coupled = any(contact.law.couples_directions for contact in balance.problem.contacts)
    if coupled and (len(set(rules)) > 1 or "mean_traction" in rules):
        raise fault("rule", "must be slider_offset or traction_ratio, the same in both directions, with friction discs", rule)
    table = balance.table
    row = np.repeat(np.arange(table.rows), np.diff(table.friction_first))
    contact = np.searchsorted(table.first_row, row, side="right") - 1
    names = [rules[min(d, len(rules) - 1)] for d in row - table.first_row[contact]]
    kind = np.array([RULES.get(name, OFFSET) for name in names], dtype=np.int64)
    varied = np.array([name != "virgin" for name in names], dtype=bool)
    if names and not varied.any():
        raise fault("rule", "must vary some start state", rule_words(rule), 'Take another rule than "virgin" for one direction.')
    return kind, _groups(row, contact, kind, varied, share)


def refuse_forgetful(problem: Problem) -> None:
    """Start states must matter to every law with friction; a law without friction has none."""
    for contact in problem.contacts:
        if contact.has_no_start:
            raise fault(
                f"The law of {contact.name!r}",
                "must have a start state, which this analysis varies",
                type(contact.law).__name__,
                "Its response is unique: use forced_response, or use macroslip.",
            )


def rules_of(rule: Rules) -> tuple[Rule, ...]:
    """The rules of the tangential directions, checked: one for all, or one each for t1 and t2."""
    rules = tuple(rule) if isinstance(rule, list | tuple) else (rule,)
    if isinstance(rule, list | tuple) and len(rules) != 2:
        raise fault("rule", "must be one rule, or two, for the tangential directions t1 and t2", rule)
    for one in rules:
        among("rule", one, get_args(Rule))
    return rules


def rule_words(rule: Rules) -> str:
    """The rules as text: "traction_ratio, slider_offset"."""
    return ", ".join(rules_of(rule))


def _groups(row: Index, contact: Index, kind: Index, varied: np.ndarray, share: Sharing) -> Index:
    """The variable of each element; elements with different rules have none in common."""
    elements = np.arange(row.size)
    keys = {"element": elements, "direction": row, "contact": contact, "all": np.zeros_like(elements)}
    key = len(RULES) * keys[among("share", share, keys)] + kind
    group = np.full(row.size, -1, dtype=np.int64)
    group[varied] = np.unique(key[varied], return_inverse=True)[1]
    return group
