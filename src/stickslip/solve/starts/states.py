"""Start states at a solved point: the slider and the admissible interval of every friction element.

From it come the variables that describe a solution (several do, since a start state beyond the interval is clipped), and how
wide the space of start states must be so that every solution lies in it.

Loading history: the sliders of each solved point are the start state of the next, along frequency and between levels.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from stickslip.model.contact.period import OFFSET, friction_period, stick_interval
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.balance.cycle import contact_cycle, friction_limits
from stickslip.solve.continuation.continuation import first_point
from stickslip.solve.continuation.newton import Correction, correct, fixed
from stickslip.solve.starts.solutions import StartSolutions, UnsolvedError
from stickslip.solve.starts.space import RULES, Rules, Sharing, StartSpace, refuse_forgetful, start_space
from stickslip.support.checks import Array, InputError

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


def sliders(balance: HarmonicBalance, evaluation: Evaluation) -> Array:
    """Where the slider of every friction element stands at the last sample, s = u_last − T_last/kt, m, (elements,)."""
    return contact_cycle(evaluation.table, balance.tables, evaluation.w, evaluation.point.omega).slider


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
                carried = balance.with_starts(sliders(balance, last), OFFSET)
                start = Point(last.point.forces, omega, level)
                correction = correct(carried, start, fixed("omega", omega), iterations=40, halvings=10)
                if not correction.converged:
                    correction = first_point(carried, omega, level)
            if correction.converged:
                last = correction.evaluation
            yield level, correction
