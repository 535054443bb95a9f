"""Truncation error: the effect of the harmonics above H on a solution, by solving a balance with more of them beside it.

Two small H can agree with each other and both be wrong: contact forces have harmonics that the solution drops, and where one of
them falls on a mode of the dampers it matters. Newton's method starts from the solution padded with zeros and ends on a plane
across the curve, so that it is regular at folds and measures how far the two curves are apart, not how far a resonance has
shifted; or, where it carries a solution to more harmonics (`resolved`), at the same frequency.

Where contacts are stiff the Newton matrix is nearly singular in what slips: a step may be right and yet raise the residual, and a
line search stops. Then steps are damped by their own length, which no scaling of the equations changes: `_damped` with a matrix
at each step, `_by_few_matrices` where a matrix costs far more than the rest of a step.
Source: P. Deuflhard, Newton Methods for Nonlinear Problems (2004), sections 2.1.2 and 3.3.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.model.contact.protocol import SLIPPING
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, PathCondition, Point
from stickslip.solve.balance.energy import cycle_work
from stickslip.solve.balance.newton_matrix import FEWEST_UNKNOWNS
from stickslip.solve.continuation.newton import FLOOR, Correction, correct, fixed
from stickslip.support.checks import Array

MARGIN = 16
"""Harmonics beyond H that are estimated, at least; up to 2H if that is more."""

MOST_UNKNOWNS = 3000
"""Size of a Newton matrix beyond which a step would cost as much as a curve."""

AT_REST, ROUNDING = 1e-6, 1e-10
"""Amplitudes of an output, relative to the largest output and to the largest motion of all, below which it counts as being at
rest."""

PATIENCE = 20
"""Full steps that may raise the residual, where no shorter one reduces it: kinks of friction lie on the way."""

DETOUR = 60
"""Damped steps of a way round at the frequency of the solution, where no other start arrives."""

ACCURATE = 1e-3
"""Share of the way to the finer curve to which it is known where few matrices lead there."""

MATRICES = 10
"""So many of Newton's matrices are tried: of 19 hard points of a blade root that arrived 18 took at most nine."""

SHORTEST = 3e-3
"""Share of a step that is taken whatever it does: kinks of friction lie so close that shorter ones do not get across. Of 3e-3,
1e-2 and 1e-3, that with which most of 56 solutions of a rubbing mass were found, from 13 to 151 harmonics.
"""

STEPS = 200
"""Damped steps before a solution is given up."""

TINY = float(np.finfo(float).tiny)


def enough_beyond(harmonics: int) -> int:
    """The harmonics with which those beyond H are estimated."""
    return max(2 * harmonics, harmonics + MARGIN)


def beyond_within(harmonics: int, rows: float, unknowns: int) -> int:
    """With how many harmonics those beyond H are estimated where `rows` rows of contacts move, so that Newton's matrix has no
    more than so many unknowns: with two more at least, and 0 for none where these are too many."""
    fitting = min(enough_beyond(harmonics), max(harmonics + 2, int((unknowns / rows - 1.0) / 2.0)))
    return fitting if rows * (2 * fitting + 1) <= MOST_UNKNOWNS else 0


@dataclass(frozen=True, eq=False)
class Truncation:
    """share (h,): motion of the contacts in harmonic h = 1, 2, ... that is truncated, relative to their whole dynamic motion;
    total: change of the dynamic motion, in all harmonics, of contacts or an output, whichever is relatively larger."""

    share: Array
    total: float

    def needed(self, tolerance: float) -> int:
        """The least H beyond which the shares sum to no more than the tolerance."""
        beyond = np.sqrt(np.cumsum((self.share**2)[::-1])[::-1])
        return int(np.count_nonzero(beyond > tolerance))


def moving(w: Array, rows: int, counted: slice) -> tuple[Array, NDArray[np.bool_]]:
    """The sizes of outputs in the counted columns, and which of them move by more than rounding."""
    sizes, whole = np.linalg.norm(w[rows:, counted], axis=1), np.linalg.norm(w[:, 1:], axis=1)
    return sizes, sizes > max(AT_REST * whole[rows:].max(initial=0.0), ROUNDING * whole.max(initial=0.0))


def pad(forces: Array, columns: int) -> Array:
    """λ with more harmonics (zeros) or fewer."""
    padded = np.zeros((forces.shape[0], columns))
    kept = min(forces.shape[1], columns)
    padded[:, :kept] = forces[:, :kept]
    return padded


def resolved(finer: HarmonicBalance, evaluation: Evaluation, steps: int = STEPS) -> Correction:
    """The same point with the harmonics of `finer`, started from the padded solution; by way of half as many more harmonics where
    it is not found at once."""
    correction = _carried(finer, evaluation, steps)
    known = (evaluation.point.forces.shape[1] - 1) // 2
    half = (known + finer.highest) // 2
    if correction.converged or half <= known:
        return correction
    between = _carried(finer.with_harmonics(half), evaluation, steps)
    return _carried(finer, between.evaluation, steps) if between.converged else correction


def _carried(finer: HarmonicBalance, evaluation: Evaluation, steps: int) -> Correction:
    point = evaluation.point
    start = Point(pad(point.forces, finer.columns), point.omega, point.level)
    correction = correct(finer, start, fixed("omega", point.omega), iterations=30, halvings=10)
    if correction.converged or correction.singular:
        return correction
    near = _damped(finer, start, steps)
    return correction if near is None else correct(finer, near, fixed("omega", point.omega), iterations=30, halvings=10)


@np.errstate(over="ignore")  # a step of a body that drifts may exceed all numbers: its length is infinite, and the search ends
def _damped(balance: HarmonicBalance, start: Point, steps: int) -> Point | None:
    """A point with a residual below `FLOOR` at the frequency and level of the start; None where the steps do not lead to one.

    A share s of a step d is taken if the next step with the same matrix, d', is shorter than d. How much d' differs from
    (1 − s) d, which it is where the residual is straight, says which share to try instead; how much it differs from the next step
    with its own matrix, which share that begins with.
    """
    condition, evaluation = fixed("omega", start.omega), balance.evaluate(start)
    share, before, following = 1.0, 0.0, start.forces
    for _ in range(steps):
        if evaluation.error <= FLOOR:
            return evaluation.point
        factors = balance.factorise(evaluation, condition)
        step = balance.newton_step(evaluation, condition, factors)[0]
        length = float(np.linalg.norm(step))
        if factors.orientation == 0.0 or not np.isfinite(length):
            return None
        if before:
            straight = share * before * float(np.linalg.norm(following))
            share = max(SHORTEST, straight / max(float(np.linalg.norm(following - step)) * length, straight, TINY))
        while True:
            trial = balance.evaluate(evaluation.point.moved(share * step, "omega", 0.0))
            following = balance.newton_step(trial, condition, factors)[0]
            if share <= SHORTEST or np.linalg.norm(following) < length:
                break
            bent = float(np.linalg.norm(following - (1.0 - share) * step))
            share = max(SHORTEST, min(0.5 * share, 0.5 * length * share**2 / bent))
        evaluation, before = trial, length
    return None


class Beside(NamedTuple):
    """Where the curve of a finer balance passes a solution, on a plane across the curve.

    padded: the solution as the finer balance sees it; condition: the plane through it; evaluation: of the finer curve where it is
    solved, else after two Newton steps; way: the motion on the way there, m, (1 or 2 steps, rows + outputs, 2H+1), infinite where
    Newton's matrix is singular or gives no step.
    """

    padded: Evaluation
    condition: PathCondition
    evaluation: Evaluation
    way: Array
    solved: bool

    @property
    def moved(self) -> Array:
        """The motion from the solution to the finer curve, (rows + outputs, 2H+1); infinite where it is unknown."""
        return np.asarray(self.way.sum(axis=0))

    def change(self, columns: slice) -> Array:
        """How far each row moves in some columns, m, (rows + outputs,): two steps count both, as a second one may lead back."""
        return np.asarray(np.linalg.norm(self.way[:, :, columns], axis=2).sum(axis=0))


def beside(finer: HarmonicBalance, evaluation: Evaluation, across: PathCondition, near: Beside | None = None) -> Beside:
    """Solve `finer`, a balance of the same problem with more harmonics or samples, next to a solution.

    across: a plane across the curve, or a prescribed frequency, whatever its target: the one through the solution is taken;
    near: the same at a neighbouring solution, whose way is tried first if it was solved; without one, Newton's method goes on
    behind kinks of friction, where no step reduces the residual, and takes a way round at the same frequency. Many contacts,
    whose steps take long, take `_by_few_matrices` from the solution itself, and those ways where there is no neighbour alone.
    """
    point = evaluation.point
    padded = finer.evaluate(Point(pad(point.forces, finer.columns), point.omega, point.level))
    weight = None if across.weight is None else pad(across.weight, finer.columns)
    condition = replace(across, weight=weight, target=0.0)
    condition = replace(condition, target=condition.gap(padded))
    if np.count_nonzero(padded.unknown == SLIPPING) * finer.columns >= FEWEST_UNKNOWNS:
        quick = _by_few_matrices(finer, padded, condition)
        if quick is None and near is not None:
            return _by_two_steps(finer, padded, condition)
        if quick is not None:
            return Beside(padded, condition, quick, (quick.w - padded.w)[None], True)
    attempts = [(padded.point, 0)]
    if near is not None and near.solved:
        off = near.evaluation.point.forces - near.padded.point.forces
        moved = padded.point.moved(off, "omega", near.evaluation.point.omega - near.padded.point.omega)
        attempts = [(moved, 0), *attempts]
    elif near is None:
        attempts.append((padded.point, PATIENCE))
    for start, patience in attempts:
        solution = correct(finer, start, condition, 30, 10, patience)
        if solution.converged:
            break
    if near is None and not solution.converged and (carried := resolved(finer, evaluation, DETOUR)).converged:
        solution = correct(finer, carried.evaluation.point, condition, 30, 10, PATIENCE)
    if solution.converged:
        return Beside(padded, condition, solution.evaluation, (solution.evaluation.w - padded.w)[None], True)
    return _by_two_steps(finer, padded, condition)


def _by_two_steps(finer: HarmonicBalance, padded: Evaluation, condition: PathCondition) -> Beside:
    """Two of Newton's steps towards a curve that is not reached; none where his matrix is singular or nothing moves."""
    found, way = padded, list[Array]()
    for _ in range(2):
        step = correct(finer, found.point, condition, iterations=1, halvings=0, patience=1)
        stands = not way and np.array_equal(step.evaluation.w, found.w)  # which would say that nothing changes
        if step.singular or stands or not np.isfinite(step.evaluation.w).all():
            return Beside(padded, condition, padded, np.full_like(padded.w, np.inf)[None], False)
        way.append(step.evaluation.w - found.w)
        found = step.evaluation
    return Beside(padded, condition, found, np.array(way), False)


def _by_few_matrices(finer: HarmonicBalance, padded: Evaluation, condition: PathCondition) -> Evaluation | None:
    """Where the finer curve passes, with as few of Newton's matrices as do, which cost far more than the rest of a step with many
    contacts; None where `MATRICES` of them do not arrive.

    Of the steps 1, 1/2, 1/4, ... the longest counts after which the same matrix gives a shorter one: where many contacts lift
    off, the residual, which kinks keep large, says less. The matrix is kept while whole steps shrink to a half. Where each step d
    is θ times as long as the one before, θ/(1 − θ) |d| is left: at most `ACCURATE` of the way in the end, and of the residual, as
    the second step beyond a kink may be short by chance.
    """
    found, fresh, matrices, before = padded, True, 0, np.inf
    while matrices < MATRICES or not fresh:
        if fresh:
            factors, matrices = finer.factorise(found, condition), matrices + 1
            step, amount = finer.newton_step(found, condition, factors)
        share, left, whole = 2.0, np.inf, float(np.linalg.norm(step))
        while not left < whole:
            share *= 0.5
            if share < SHORTEST:
                return None
            following = finer.evaluate(found.point.moved(share * step, condition.parameter, share * amount))
            after, further = finer.newton_step(following, condition, factors)
            left = float(np.linalg.norm(after))
        length, way = (float(np.linalg.norm(following.w - each.w)) for each in (found, padded))
        near = length <= 0.5 * before and length**2 <= ACCURATE * (before - length) * way
        if not fresh and near and following.error <= ACCURATE * padded.error:
            return following
        found, fresh, before = following, share < 1.0 or left > 0.5 * whole, length
        step, amount = after, further
    return None


def truncation_at(balance: HarmonicBalance, finer: HarmonicBalance, evaluation: Evaluation, across: PathCondition) -> Truncation:
    """What the harmonics of `finer` change of a solved point on a plane across the curve: solved, else by two steps."""
    found, rows = beside(finer, evaluation, across), finer.rows
    size = max(float(np.linalg.norm(found.padded.w[:rows, 1:])), TINY)
    sizes, moves = moving(found.padded.w, rows, slice(1, None))
    of_outputs = found.change(slice(1, None))[rows:][moves] / sizes[moves]
    remainder = found.moved[:rows].copy()
    remainder[:, balance.kept] = 0.0
    share = np.sqrt(np.sum(remainder[:, 1::2] ** 2 + remainder[:, 2::2] ** 2, axis=0)) / size
    of_contacts = float(np.linalg.norm(found.moved[:rows, 1:])) / size
    return Truncation(share, max(of_contacts, float(of_outputs.max(initial=0.0))))


def contact_work(balance: HarmonicBalance, evaluation: Evaluation) -> float:
    """Work of all contacts in a period of the balance, J."""
    return float(cycle_work(evaluation.point.forces - evaluation.residual, evaluation.w[: balance.rows]).sum())
