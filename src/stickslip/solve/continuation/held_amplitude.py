"""Points of a controlled response: the force level that holds an amplitude, at a frequency or where force and motion are at 90°.

The balance has one unknown more, the force level, and one equation more, ω^k |X_1| = A (`HarmonicBalance.holding`).
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, PathCondition, Point
from stickslip.solve.balance.system import Control
from stickslip.solve.continuation.newton import Correction, correct, fixed

LOWEST = 1e-4
"""Share of the amplitude from which a ramp begins where Newton's method does not find the point at once."""

SHORTEST = 1.02
"""The smallest ratio of two amplitudes of a ramp before it is given up."""

GROWTH = 3.0
"""The largest ratio of two amplitudes of a ramp."""


def first_held(balance: HarmonicBalance, omega: float) -> Correction:
    """The point at a frequency whose amplitude is held: Newton from the stuck state, else a ramp of the amplitude."""
    condition = fixed("omega", omega)
    correction = correct(balance, stuck_held(balance, omega), condition, iterations=40, halvings=12)
    if correction.converged or correction.singular:
        return correction
    return ramped(balance, lambda one: correct(one, stuck_held(one, omega), condition, 40, 12), condition) or correction


def stuck_held(balance: HarmonicBalance, omega: float) -> Point:
    """Where Newton starts: all contacts held, and the level that would then hold the amplitude."""
    control = held(balance)
    plain = balance.holding(None)
    size = control_size(control, plain.evaluate(plain.stuck_point(omega, 1.0)))
    return plain.stuck_point(omega, control.amplitude / max(size, np.finfo(float).tiny))


def control_size(control: Control, evaluation: Evaluation) -> float:
    """ω^k |X_1| of the row that a control holds."""
    return evaluation.point.omega**control.order * float(np.hypot(*evaluation.w[control.row, 1:3]))


def ramped(
    balance: HarmonicBalance, begin: Callable[[HarmonicBalance], Correction], condition: PathCondition
) -> Correction | None:
    """The point at the whole amplitude, from a small one on; None where a step fails however short it is."""
    control = held(balance)
    share, growth = LOWEST, GROWTH
    found = begin(balance.holding(control._replace(amplitude=LOWEST * control.amplitude)))
    while found.converged and share < 1.0:
        wanted = min(share * growth, 1.0)
        one = balance.holding(control._replace(amplitude=wanted * control.amplitude))
        following = correct(one, scaled(found.evaluation.point, wanted / share), condition, iterations=20, halvings=8)
        if following.converged:
            found, share, growth = following, wanted, min(growth * 1.5, GROWTH)
        elif growth > SHORTEST:
            growth = float(np.sqrt(growth))
        else:
            return None
    return found if found.converged else None


def scaled(point: Point, ratio: float) -> Point:
    """A point with its harmonic forces and level times a ratio; the mean stays."""
    forces = point.forces.copy()
    forces[:, 1:] *= ratio
    return replace(point, forces=forces, level=ratio * point.level)


def at_right_angle(balance: HarmonicBalance, omega: float, force_phase: float) -> PathCondition:
    """Force and held motion at 90°: Re(X_1 e^{−iφ}) = 0 for a force of phase φ, relative to the amplitude."""
    control = held(balance)
    weight = np.zeros((balance.rows + balance.problem.output_rows.shape[0], balance.columns))
    # X_1 = a − ib, so that its part in phase with the force is a cos φ − b sin φ.
    weight[control.row, 1:3] = np.cos(force_phase), -np.sin(force_phase)
    return PathCondition("omega", weight * omega**control.order / control.amplitude, 0.0, 0.0)


def held(balance: HarmonicBalance) -> Control:
    """The held amplitude of a balance that holds one."""
    control = balance.control
    if control is None:
        raise AssertionError("the balance holds no amplitude")
    return control
