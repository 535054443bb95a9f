"""Derivatives of a solved point by the implicit function theorem, at fixed frequency: J dλ = dλ̂ + E dw, with one factorisation.

dλ̂ is what a parameter does to λ̂ at fixed motion (contact laws, start states), dw what it does to the motion at fixed λ
(structure, loads). Start states come in closed form; any other parameter by differences of the assembled residual, never of
solutions.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stickslip.model.contact.point import remembering
from stickslip.model.contact.protocol import MEAN, OFFSET, friction_period
from stickslip.model.problem import Problem
from stickslip.model.problem.speed import over_periods
from stickslip.solve.balance.balance import Evaluation, Factors, HarmonicBalance, Point
from stickslip.solve.balance.energy import friction_limits
from stickslip.solve.continuation.newton import fixed
from stickslip.support.checks import Array, Index


@dataclass(frozen=True, eq=False)
class Change:
    """Changes with k parameters: λ (k, rows, 2H+1), motion (k, motion rows, 2H+1), a level that holds an amplitude (k,)."""

    forces: Array
    motion: Array
    level: Array


def respond(
    balance: HarmonicBalance, evaluation: Evaluation, factors: Factors, forces: Array, motion: Array | None = None
) -> Change:
    """The whole change for a change of λ̂ at fixed λ, `forces` (k, rows, 2H+1), and of w at fixed λ, `motion` (k, ..), if any.

    Where the balance holds an amplitude, the force level changes too, so that the amplitude stays.
    """
    omega, size = evaluation.point.omega, factors.size
    changed = np.where(factors.mask, 0.0, forces)
    right = np.zeros((forces.shape[0], factors.rows))
    held = _held_slope(balance, evaluation)
    for k, known in enumerate(changed):
        right[k, :size] = forces[k][factors.mask]
        explicit = None if motion is None else motion[k]
        if known.any():
            moved = balance.linear.change(known, omega)
            right[k, :size] += balance.pushed(evaluation, factors.offsets, moved)
            explicit = moved if explicit is None else explicit + moved
        if held is not None and explicit is not None:
            right[k, size + 1] = -float(np.vdot(held, explicit))
    solution = factors.solve_many(right)
    changed[:, factors.mask] = solution[:, :size]
    whole = np.stack([balance.linear.change(change, omega) for change in changed]) if len(changed) else changed
    level = np.zeros(len(changed)) if held is None else solution[:, size + 1]
    if held is not None:
        by_level = balance.linear.slope(evaluation.point.forces, omega, evaluation.point.level, by_level=True)
        whole = whole + level[:, None, None] * by_level
    return Change(changed, whole if motion is None else whole + motion, level)


def weights_of_contact_forces(
    balance: HarmonicBalance, evaluation: Evaluation, factors: Factors, forces: Array, motion: Array
) -> Array:
    """Weights of changes of λ̂ at fixed λ (rows, 2H+1) in a sum of the changes of λ and w that follow, which have the weights
    `forces` (rows, 2H+1) and `motion` (motion rows, 2H+1).

    The transpose of `respond`: one solution for any number of changes.
    """
    omega, size = evaluation.point.omega, factors.size
    held = _held_slope(balance, evaluation)
    weights = forces + balance.linear.weights_of_change(motion, omega)
    right = np.zeros((1, factors.rows))
    right[0, :size] = weights[factors.mask]
    if held is not None:
        by_level = balance.linear.slope(evaluation.point.forces, omega, evaluation.point.level, by_level=True)
        right[0, size + 1] = float(np.vdot(motion, by_level))
    (solution,) = factors.solve_transposed(right)
    through = balance.pushed_back(evaluation, factors.offsets, solution)
    if held is not None:
        through -= solution[size + 1] * held
    weights += balance.linear.weights_of_change(through, omega)
    weights[factors.mask] = solution[:size]
    return weights


def _held_slope(balance: HarmonicBalance, evaluation: Evaluation) -> Array | None:
    """The derivative of a held amplitude by the motion, relative to it, or None where the force level is given."""
    control = balance.control
    if control is None:
        return None
    motion, weight = evaluation.w[control.row], np.zeros_like(evaluation.w)
    size = float(np.hypot(*motion[1:3]))
    weight[control.row, 1:3] = evaluation.point.omega**control.order * motion[1:3] / (size * control.amplitude)
    return weight


def mean_slopes(balance: HarmonicBalance, evaluation: Evaluation) -> tuple[Index, Index, Array]:
    """Elements whose start value acts on the force, the row of each, and ∂λ̂/∂(value) there, of the mean alone, (k,) each.

    An element acts when it sticks all through the steady period and its start is not clipped: offset −kt, ratio μN_last,
    mean traction 1. One whose law forgets its start never does.
    """
    remember = remembering(balance.problem.contacts)
    table, tables, w = evaluation.table, balance.tables, evaluation.w
    samples = tables.E.shape[0]
    y, event = np.empty(samples), np.empty(samples, dtype=np.int64)
    found: list[tuple[int, int]] = []
    slopes: list[float] = []
    for e, r, u, limit, landing in friction_limits(table, tables, w):
        kt, kind, value = table.stiffness[e], int(table.start_kind[e]), table.start_value[e]
        state = friction_period(kind, value, kt, kt * u, limit, landing, kt * w[r, 0], y, event)
        acts = _start_slope(state, kind, kt, limit) if remember[e] else None
        if acts is not None:
            found.append((e, r))
            slopes.append(acts)
    elements, rows = np.array(found, dtype=np.int64).reshape(-1, 2).T
    return elements, rows, np.array(slopes)


def _start_slope(state: tuple[int, int, float], kind: int, kt: float, limit: Array) -> float | None:
    """d(mean traction)/d(start value) of one element in the state `friction_period` found, None where it has no effect."""
    unknown, sample, _ = state
    if kind == OFFSET:
        return -kt if unknown == 0 else None
    if kind == MEAN:
        return 1.0 if unknown == 1 and sample == -1 else None
    return float(limit[-1]) if unknown == 1 and sample == limit.size - 1 else None


def parameter_slopes(
    problem_of: Callable[[float], Problem], value: float, balance: HarmonicBalance, point: Point, step: float
) -> tuple[Array, Array]:
    """dλ̂/dθ (rows, 2H+1) and dw/dθ (motion rows, 2H+1) at fixed λ, by central differences of the assembled residual.

    λ counts from the contact springs of each problem, so kt and kn need no special case; no solution is differenced.
    """
    sides = []
    for side in (value + step, value - step):
        other = HarmonicBalance(over_periods(problem_of(side), balance.periods), balance.harmonics, balance.tables.E.shape[0])
        sides.append(other.evaluate(point))
    high, low = sides
    return (low.residual - high.residual) / (2.0 * step), (high.w - low.w) / (2.0 * step)


def solved_factors(balance: HarmonicBalance, evaluation: Evaluation) -> Factors:
    """The factorised Newton matrix of a solved point at fixed frequency."""
    return balance.factorise(evaluation, fixed("omega", evaluation.point.omega))
