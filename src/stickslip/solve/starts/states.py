"""Start states at a solved point: the slider and the admissible interval of every friction element.

From it come the variables that describe a solution (several do, since a start state beyond the interval is clipped), and how
wide the space of start states must be so that every solution lies in it.

Loading history: the sliders of each solved point are the start state of the next, along frequency and between levels.

Parametrisation of start states by variables in [−1, 1]: the elements that share one, and the meaning of ±1.

Every admissible solution has its tractions at the last sample in their own [LO, HI]; slider offsets reach all of them, and so
do traction ratios. Ratios and mean tractions take the static tangential stiffness of a stuck contact away: a body that
only friction holds is then held by nothing. Offsets always have an equilibrium. A rule for each tangential direction combines
them: ratios in the plane of a damper, and offsets along its axis, where nothing but friction holds it.

Solutions at one frequency and level as a function of the start state, each reached from a known neighbour.
"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from stickslip.model.contact.point import STARTS
from stickslip.model.contact.protocol import OFFSET, friction_period, stick_interval
from stickslip.model.problem import Problem
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.balance.energy import contact_cycle, friction_limits, friction_reach
from stickslip.solve.continuation.continuation import first_point
from stickslip.solve.continuation.newton import Correction, correct, fixed
from stickslip.solve.continuation.sensitivity import solved_factors
from stickslip.solve.continuation.sweep import SINGULAR, failure
from stickslip.support.checks import Array, Index, InputError, among, fault
from stickslip.support.outcome import Outcome

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


KNOWN = 64
"""Solutions remembered; the oldest are forgotten first, the very first never."""

SHORTEST = 1.0 / 32.0
"""The shortest step on the way from a known start state to a wanted one, as a share of the way."""


class UnsolvedError(Exception):
    """No solution was found at a start state; `outcome` says why."""

    def __init__(self, outcome: Outcome = Outcome.NOT_CONVERGED) -> None:
        self.outcome = outcome
        super().__init__(outcome.sentence)


class StartSolutions:
    """Solves at a frequency in rad/s and a level, and remembers where solutions were found; `solves` counts them."""

    def __init__(self, balance: HarmonicBalance, space: StartSpace, omega: float, level: float) -> None:
        self.balance, self.space, self.omega, self.level = balance, space, omega, level
        self.known: list[tuple[Array, Array]] = []
        self.solves = 0

    def remember(self, variables: Array, forces: Array) -> None:
        """Keep forces λ as a place to start from."""
        if len(self.known) >= KNOWN:
            del self.known[1]
        self.known.append((variables.copy(), forces))

    def solve(self, variables: Array) -> tuple[HarmonicBalance, Evaluation]:
        """The balance and solution at a start state: from the nearest known solution, else along the way from it; raises
        `UnsolvedError`.
        """
        self.solves += 1
        balance, evaluation = self._from_known(variables) if self.known else self._first(variables)
        self.remember(variables, evaluation.point.forces)
        return balance, evaluation

    def _first(self, variables: Array) -> tuple[HarmonicBalance, Evaluation]:
        balance = self.space.balance(self.balance, variables)
        first = first_point(balance, self.omega, self.level)
        if not first.converged:
            raise UnsolvedError(failure(balance, first))
        if self.space.prescribes:
            # Prescribed friction may hold a body in balance, but does not hold it: it could then be anywhere.
            pivots = np.abs(solved_factors(balance, first.evaluation).pivots)
            if pivots.min() <= SINGULAR * pivots.max():
                raise UnsolvedError(Outcome.BODY_HELD_BY_NOTHING)
        return balance, first.evaluation

    def _from_known(self, variables: Array) -> tuple[HarmonicBalance, Evaluation]:
        origins = np.array([origin for origin, _ in self.known])
        origin, forces = self.known[int(np.argmin(np.linalg.norm(origins - variables, axis=1)))]
        done, step = 0.0, 1.0
        while True:
            share = min(done + step, 1.0)
            balance = self.space.balance(self.balance, origin + share * (variables - origin))
            start = Point(forces, self.omega, self.level)
            correction = correct(balance, start, fixed("omega", self.omega), iterations=15, halvings=6)
            if correction.converged and share == 1.0:
                return balance, correction.evaluation
            if correction.converged:
                done, step, forces = share, 2.0 * step, correction.evaluation.point.forces
            elif step <= SHORTEST:
                raise UnsolvedError
            else:
                step *= 0.5


ROUNDS, CORNERS, GROWTH = 2, 2, 0.02
"""Rounds of widening a space, corners of it that are solved in each, and the growth below which it is wide enough."""

MARGIN = 1.25
"""By how much the space is made wider than any solution seen allows; a start state beyond its interval is clipped."""


@dataclass(frozen=True, eq=False)
class ElementStates:
    """Per friction element of a solved point.

    At the last sample: slider s [m], traction `last` and its limit μN [N]. Over the period: mean traction and its admissible
    interval [low, high], N, of no length where the element slips; mean displacement [m] and mean limit [N].
    """

    slider: Array
    last: Array
    last_limit: Array
    mean: Array
    low: Array
    high: Array
    displacement: Array
    limit: Array

    @property
    def stuck(self) -> np.ndarray:
        """Elements that have a choice: those that never slip in the steady period."""
        return np.asarray(self.low < self.high)


def element_states(balance: HarmonicBalance, evaluation: Evaluation) -> ElementStates:
    """The states of all friction elements at a solved point.

    In the intercept y = T − kt u of a stuck element the interval of the period map is [LO, HI]; the mean traction is y + kt ū.
    """
    rows = list(_states(balance, evaluation))
    return ElementStates(*np.array(rows, dtype=float).reshape(len(rows), 8).T)


def _states(balance: HarmonicBalance, evaluation: Evaluation) -> Iterator[tuple[float, ...]]:
    table, w = evaluation.table, evaluation.w
    samples = balance.tables.E.shape[0]
    y, event = np.empty(samples), np.empty(samples, dtype=np.int64)
    for e, r, u, limit, landing in friction_limits(table, balance.tables, w):
        kt = table.stiffness[e]
        ku, shift = kt * u, kt * w[r, 0]
        friction_period(int(table.start_kind[e]), table.start_value[e], kt, ku, limit, landing, shift, y, event)
        low, high = stick_interval(ku, limit, landing)
        mean = float(y.mean() + shift)
        ends = (low + shift, high + shift) if low < high else (mean, mean)
        yield -y[-1] / kt, y[-1] + ku[-1], limit[-1], mean, *ends, w[r, 0], limit.mean()


def settled(space: StartSpace, balance: HarmonicBalance, evaluation: Evaluation) -> Array:
    """Variables (size,) that describe a solved point from inside the intervals of its elements; shared ones take the middle."""
    states = element_states(balance, evaluation)
    ratio = np.where(states.last_limit > 0.0, states.last / np.maximum(states.last_limit, 1e-300), 0.0)
    values = space.by_rule(slider_offset=states.slider, traction_ratio=ratio, mean_traction=states.mean)
    shares = np.where(space.scale > 0.0, values / np.maximum(space.scale, 1e-300), 0.0)
    group, shares, weight = (a[space.varied] for a in (space.group, shares, np.where(states.stuck, 1.0, 1e-9)))
    sums = np.bincount(group, weight * shares, minlength=space.size)
    return np.clip(sums / np.bincount(group, weight, minlength=space.size), -1.0, 1.0)


def widened(space: StartSpace, balance: HarmonicBalance, evaluations: Sequence[Evaluation]) -> StartSpace:
    """The space, at least as wide as each of some solved points allows: |s| ≤ |ū| + mean(μN)/kt, |T̄| ≤ mean(μN)."""
    scale = space.scale
    for evaluation in evaluations:
        states = element_states(balance, evaluation)
        reach = np.abs(states.displacement) + states.limit / balance.table.stiffness
        allowed = space.by_rule(slider_offset=reach, traction_ratio=np.ones_like(reach), mean_traction=states.limit)
        scale = np.maximum(scale, allowed)
    return replace(space, scale=scale)


def explored_space(
    balance: HarmonicBalance, omegas: Sequence[float], level: float, rule: Rules = "slider_offset", share: Sharing = "element"
) -> StartSpace:
    """The start states of a problem, wide enough for the solutions at some frequencies in rad/s."""
    return space_around(balance, virgin_solutions(balance, omegas, level), rule, share)


def virgin_solutions(balance: HarmonicBalance, omegas: Sequence[float], level: float) -> list[Evaluation]:
    """The solutions of the virgin contacts at those frequencies in rad/s where there are some; refused where there is none."""
    refuse_forgetful(balance.problem)
    virgin = balance.with_starts(np.zeros(balance.table.stiffness.size), OFFSET)
    firsts = [first_point(virgin, omega, level) for omega in omegas]
    solved = [first.evaluation for first in firsts if first.converged]
    if not solved:
        raise InputError(
            f"The virgin contact must have a solution at {omegas[0] / (2.0 * np.pi):g} Hz to scale the start states, but none "
            "was found. Start the band where contacts stick."
        )
    return solved


def space_around(balance: HarmonicBalance, solved: Sequence[Evaluation], rule: Rules, share: Sharing) -> StartSpace:
    """The start states of a problem, wide enough for the solutions at the frequencies of some virgin ones.

    The virgin solution alone is too narrow: another start state moves the bodies and shifts the normal loads, which allows
    sliders further out. Random corners are solved, and the space grows until they allow no more.
    """
    space = widened(start_space(balance, solved[0], rule, share), balance, solved)
    ratio = space.kind == RULES["traction_ratio"]
    if np.all(ratio):
        return space
    grown = _grown(space, balance, solved)
    return replace(grown, scale=np.where(ratio, 1.0, MARGIN * grown.scale))


def _grown(space: StartSpace, balance: HarmonicBalance, firsts: Sequence[Evaluation]) -> StartSpace:
    rng = np.random.default_rng(0)
    for _ in range(ROUNDS):
        found = []
        for first in firsts:
            solutions = StartSolutions(balance, space, first.point.omega, first.point.level)
            solutions.remember(np.zeros(space.size), first.point.forces)
            for corner in rng.choice([-1.0, 1.0], (CORNERS, space.size)):
                with suppress(UnsolvedError):
                    found.append(solutions.solve(corner)[1])
        before = space.scale
        space = widened(space, balance, found)
        if np.all(space.scale <= (1.0 + GROWTH) * before):
            break
    return space


def march(balance: HarmonicBalance, omegas: Sequence[float], levels: Sequence[float]) -> Iterator[tuple[float, Correction]]:
    """(level, solved point) for every level in order and every frequency in rad/s; sliders carried from point to point.

    A point that does not converge is handed out as it is, and the next one starts from the last converged state.
    """
    last: Evaluation | None = None
    for level in levels:
        for omega in omegas:
            if last is None:
                correction = first_point(balance, omega, level)
            else:
                cycle = contact_cycle(last.table, balance.tables, last.w, last.point.omega)
                carried = balance.with_starts(cycle.slider, OFFSET)
                start = Point(last.point.forces, omega, level)
                correction = correct(carried, start, fixed("omega", omega), iterations=40, halvings=10)
                if not correction.converged:
                    correction = first_point(carried, omega, level)
            if correction.converged:
                last = correction.evaluation
            yield level, correction
