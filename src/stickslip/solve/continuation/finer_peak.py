"""Solutions on all modes from those of a problem on fewer coordinates (`Problem.truncated`).

With hundreds of contacts and modes Newton's matrix is too large to be factorised: 10 000 rows. But the matrix with the receptance
of the few coordinates in place of all modes is nearly the same: what it lacks is the flexibility of the modes left out, a share
of at most σ² of the compliance of the contacts. So its factors precondition GMRES, which ends after a few products, each a
sum over contacts and modes (Newton-Krylov: D. A. Knoll, D. E. Keyes, J. Comput. Phys. 193 (2004) 357-397).

The resonance of the finer problem may lie many half-widths beside the peak.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.sparse.linalg import LinearOperator, gmres

from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, PathCondition, Point
from stickslip.solve.continuation.newton import CONDITION_TOLERANCE, fixed
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


BELIEVED, WIDTHS = 2.0, 2.0
"""Factor of the height, or else half-widths of the resonance, within which a solution at the phase of a peak is that peak. Beside
a resonance, where the motion of others is as large, the phase comes back at a fraction of the height."""

APART, STRIDE, REACH, MOST = 1e-3, 0.02, 0.1, 12
"""Relative distances: of the first three frequencies, at most of the next, at most of all from the peak; how many are tried."""


def phase_condition(balance: HarmonicBalance, output: int, X: Array, columns: slice | None = None) -> PathCondition:
    """ω as an unknown where the first harmonic of an output has the phase of X, (2,): that of a peak is the same, in the first
    order, where its height is the largest, whichever way the resonance shifts. columns: of another harmonic."""
    weight = np.zeros((balance.rows + len(balance.problem.outputs), balance.columns))
    weight[balance.rows + output, columns or balance.first] = np.array([-X[1], X[0]]) / float(X @ X)
    return PathCondition("omega", weight, 0.0, 0.0)


def finer_peak(whole: HarmonicBalance, few: HarmonicBalance, start: Point, output: int, X: Array) -> Evaluation | None:
    """The peak of an output, whose first harmonic is X (2,), with `whole`; few: its contacts on few coordinates.

    Solved at the phase of X from `start`, or from the solution at the same frequency, where the height is half to twice that of
    X. Else from solutions on the way to the resonance, in whose width it then must lie. None where none is found.
    """
    condition, row = phase_condition(whole, output, X), whole.rows + output
    found = solved_on_all_modes(whole, few, start, condition)
    if found is not None and _alike(found.w[row, whole.first], X):
        return found
    first = solved_on_all_modes(whole, few, start, fixed("omega", start.omega))
    if first is None:
        return None
    found = solved_on_all_modes(whole, few, first.point, condition)  # the frequency runs away unless λ is about right
    if found is not None and _alike(found.w[row, whole.first], X):
        return found
    for point, pole in _towards_the_resonance(whole, few, first, row):
        if abs(pole.real - point.omega) <= abs(pole.imag):
            found = solved_on_all_modes(whole, few, point, condition)
            if found is not None and abs(found.point.omega - pole.real) <= WIDTHS * abs(pole.imag):
                return found
    return None


def _alike(X: Array, Y: Array) -> bool:
    return bool(1.0 / BELIEVED < np.hypot(*X) / np.hypot(*Y) < BELIEVED)


def _towards_the_resonance(
    whole: HarmonicBalance, few: HarmonicBalance, first: Evaluation, row: int
) -> Iterator[tuple[Point, complex]]:
    """Solutions nearer and nearer to the resonance next to `first`, and its pole as known by then.

    Three of them give X(ω) = c + r/(ω − p), a resonance and what others move beside it; the next is at the real part of p. Its λ
    are predicted as such sums too, which is exact while contacts stick, else as those of the last solution at another time.
    """
    omega, points = first.point.omega, [first.point]
    known = [(omega, _complex(first, row, whole))]
    following, share = omega * (1.0 + APART), 1.0
    for _ in range(MOST):
        starts = [points[-1].forces]
        if len(known) > 2:
            p, r, c = _resonance(known)
            turn = float(np.angle((c + r / (following - p)) / known[-1][1]))  # by how much the phase of X grows from the last
            turn /= (whole.first.start + 1) // 2  # over several periods X is not harmonic 1
            starts = [_extrapolated(points[-2:], p, following), _delayed(points[-1].forces, turn)]
        for forces in starts:
            start = replace(points[-1], omega=following, forces=forces)
            solution = solved_on_all_modes(whole, few, start, fixed("omega", following))
            if solution is not None:
                break
        else:
            if len(known) < 3:
                return
            share = 0.5  # friction begins on the way
            following = 0.5 * (following + points[-1].omega)
            continue
        points.append(solution.point)
        known.append((following, _complex(solution, row, whole)))
        if len(known) == 2:
            following = omega * (1.0 - APART)
            continue
        pole = _resonance(known)[0]
        yield points[-1], pole
        way = pole.real - following
        following += float(np.clip(way if abs(way) <= WIDTHS * abs(pole.imag) else share * way, -STRIDE * omega, STRIDE * omega))
        if not abs(following / omega - 1.0) <= REACH:
            return


def _extrapolated(points: Sequence[Point], pole: complex, omega: float) -> Array:
    """λ (rows, 2H+1) at ω from two points, each cosine and sine as c + r/(ω − p) with the pole of X."""
    (before, last), predicted = points, points[-1].forces.copy()
    shares = [1.0 / (point.omega - pole) for point in points]
    share = (1.0 / (omega - pole) - shares[1]) / (shares[1] - shares[0])
    step = (last.forces[:, 1::2] - before.forces[:, 1::2]) - 1j * (last.forces[:, 2::2] - before.forces[:, 2::2])
    predicted[:, 1::2] += (share * step).real
    predicted[:, 2::2] -= (share * step).imag
    return predicted


def _complex(evaluation: Evaluation, row: int, balance: HarmonicBalance) -> complex:
    a, b = evaluation.w[row, balance.first]
    return complex(a, -b)  # of Re X exp(iωt) = a cos ωt + b sin ωt


def _resonance(known: list[tuple[float, complex]]) -> tuple[complex, complex, complex]:
    """p, r and c of X(ω) = c + r/(ω − p) through the last three points; not finite where X does not change."""
    (w1, X1), (w2, X2), (w3, X3) = ((w, np.complex128(X)) for w, X in known[-3:])
    with np.errstate(all="ignore"):
        # (X1 − X2)/(w2 − w1) = r/((w1 − p)(w2 − p)), and the same of 2 and 3: their ratio is (w3 − p)/(w1 − p).
        ratio = (X1 - X2) / (w2 - w1) * (w3 - w2) / (X2 - X3)
        p = (ratio * w1 - w3) / (ratio - 1.0)
        r = (X1 - X2) / (w2 - w1) * (w1 - p) * (w2 - p)
        return p, r, X1 - r / (w1 - p)


def _delayed(forces: Array, turn: float) -> Array:
    """λ (rows, 2H+1) of a motion whose first harmonic turns by an angle as a whole: harmonic h by h times as much."""
    turned = forces.copy()
    for h in range(1, (forces.shape[1] - 1) // 2 + 1):
        a, b = forces[:, 2 * h - 1], forces[:, 2 * h]
        c, s = np.cos(h * turn), np.sin(h * turn)
        turned[:, 2 * h - 1], turned[:, 2 * h] = c * a + s * b, c * b - s * a
    return turned
