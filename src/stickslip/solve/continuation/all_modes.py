"""Newton's method for a problem on all its modes, from a solution on few coordinates (`Problem.truncated`).

With hundreds of contacts and modes Newton's matrix is too large to be factorised: 10 000 rows. But the matrix with the receptance
of the few coordinates in place of all modes is nearly the same: what it lacks is the flexibility of the modes left out, a share
of at most σ² of the compliance of the contacts. So its factors precondition GMRES, which ends after a few products, each a
sum over contacts and modes (Newton-Krylov: D. A. Knoll, D. E. Keyes, J. Comput. Phys. 193 (2004) 357-397).
"""

import numpy as np
from scipy.sparse.linalg import LinearOperator, gmres

from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, PathCondition, Point
from stickslip.solve.continuation.newton import CONDITION_TOLERANCE
from stickslip.support.checks import Array

ERROR = 1e-8
"""Relative residual at which a point counts as solved: its amplitude is then right to far more digits than the truncation."""

FORCING = 1e-3
"""Relative residual to which GMRES solves for a Newton step."""

PRODUCTS = 60
"""Products that a step may take."""


def solved_on_all_modes(
    whole: HarmonicBalance, few: HarmonicBalance, start: Point, condition: PathCondition, iterations: int = 20
) -> Evaluation | None:
    """The solution of `whole` with a path condition, from that of `few`, the same problem on fewer coordinates.

    None where Newton's method does not arrive.
    """
    evaluation = whole.evaluate(start)
    for _ in range(iterations):
        missed = condition.gap(evaluation)
        if evaluation.error <= ERROR and abs(missed) <= CONDITION_TOLERANCE:
            return evaluation
        following = _searched(whole, evaluation, condition, *_step(whole, few, evaluation, condition))
        if following is None:
            return None
        evaluation = following
    return None


def _step(whole: HarmonicBalance, few: HarmonicBalance, evaluation: Evaluation, condition: PathCondition) -> tuple[Array, float]:
    """Newton's change of λ (rows, 2H+1) and of the parameter: J dλ = −R on the unknown entries, the known ones at once."""
    point = evaluation.point
    # Called by itself, the kernel of these gains would be compiled anew in every process: more than all the rest takes.
    gains = few.evaluate(point).state.gains
    factors = few.factorise(Evaluation(point, evaluation.table, evaluation.state._replace(gains=gains)), condition)
    mask, offsets = factors.mask, factors.offsets
    size = factors.size
    by = whole.linear.slope(point.forces, point.omega, point.level, condition.parameter == "level")
    jump = whole.pushed(evaluation, offsets, by)
    if condition.parameter == "omega":
        jump += evaluation.state.by_omega[mask]
    rate = condition.rate(by, 1.0)

    def product(x: Array) -> Array:
        forces = np.zeros(mask.shape)
        forces[mask] = x[:size]
        moved = whole.linear.change(forces, point.omega)
        result = np.empty(size + 1)
        result[:size] = x[:size] - whole.pushed(evaluation, offsets, moved) - x[size] * jump
        result[size] = condition.rate(moved, 0.0) + x[size] * rate
        return result

    known = np.where(mask, 0.0, -evaluation.residual)
    moved = whole.linear.change(known, point.omega)
    right = np.append(whole.pushed(evaluation, offsets, moved) - evaluation.residual[mask], 0.0)
    right[size] = -condition.gap(evaluation) - condition.rate(moved, 0.0)
    shape = (size + 1, size + 1)
    preconditioner = LinearOperator(shape, lambda x: factors.solve_many(x.reshape(1, -1))[0], dtype=float)
    solution, _ = gmres(
        LinearOperator(shape, product, dtype=float), right, M=preconditioner, rtol=FORCING, restart=PRODUCTS, maxiter=1
    )
    step = known
    step[mask] = solution[:size]
    return step, float(solution[size])


def _searched(
    whole: HarmonicBalance, evaluation: Evaluation, condition: PathCondition, step: Array, amount: float
) -> Evaluation | None:
    """The evaluation after the longest of the steps 1, 1/2, 1/4, ... that reduces what is missed."""
    before, length = np.hypot(evaluation.error, condition.gap(evaluation)), 1.0
    for _ in range(8):
        moved = evaluation.point.moved(length * step, condition.parameter, length * amount)
        if moved.omega > 0.0:
            trial = whole.evaluate(moved)
            if np.hypot(trial.error, condition.gap(trial)) < (1.0 - 1e-4 * length) * before:
                return trial
        length *= 0.5
    return None
