"""Pseudo-arclength continuation of harmonic balance through folds and kinks, in ω or in the force level.

A curve is an iterator of solved points, whose steps `steps.py` takes; here stands how it begins and how it may end.

A controlled response begins at a point with the force level that holds an amplitude, at a frequency or where force and motion are
at 90°. The balance then has one unknown more, the force level, and one equation more, ω^k |X_1| = A (`HarmonicBalance.holding`).
"""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from stickslip.model.problem.at_rest import at_rest
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Parameter, PathCondition, Point
from stickslip.solve.balance.system import Control
from stickslip.solve.continuation.curve_points import CurvePoint, LostCurveError, solve_at
from stickslip.solve.continuation.newton import Correction, correct, fixed
from stickslip.solve.continuation.steps import StepControl, Steps
from stickslip.solve.continuation.truncation import resolved

CLOSED = "The curve closed on itself."
TURNED_BACK = "The curve turned back and left the band through its start."

DRIFTS = "A body drifts: all contacts that hold it slip, and nothing else does."

DRIFT_STEPS = 10
"""Steps in a row in which means alone move, after which a body drifts."""

STANDS_STILL = (
    "The sweep no longer advances: mean positions change and nothing else does. A body that friction alone holds may drift."
)

STANDING_STEPS = 300
"""Steps in a row within `STILL` of the parameter, after which a curve stands still."""

STILL = 1e-6
"""Share of a step up to which everything but the means stands still."""

FOLDS = "The curve folds again and again without advancing, as it does if contacts open and close many times in a period."

FOLDING_STEPS = 2000
"""Steps in a row without `ADVANCE`, after which a curve folds for ever. Of 110 random problems with barely pressed contacts, the
class of `robustness/problems.py` that folds most, none that arrived took more than 1215, and all others but one below 520."""

ADVANCE = 1e-3
"""Share of the way to the end by which a curve must pass the furthest place so far to count as getting further."""

INFINITE = "The response grows without bound."

GROWN = 100.0
"""Growth of the vibration within `STILL` of the frequency, after which nothing bounds the response of an undamped structure."""

FEW = 20
"""Harmonics up to which a ramp is cheap; more are reached from fewer."""

RISES, LEAST_RISE = 200, 1e-3
"""How often start offsets are raised at most, and the least share of them at a time."""

MET = 1e-7
"""Arc length within which a curve is back at a point; below the smallest step."""


def first_point(balance: HarmonicBalance, omega: float, level: float) -> Correction:
    """A solved point at a frequency and level: Newton from the stuck state by descent, else with few harmonics first, else a
    ramp of the force level from a thousandth of it, else Newton with the patience to cross kinks, which costs more than the ramp
    and fails more often; else from the point without start offsets, which are raised then.

    Where the balance holds an amplitude, the level is the one that holds it.
    """
    if balance.control is not None:
        return first_held(balance, omega)
    descent = _descended(balance, omega, level, iterations=20)
    if descent.converged:
        return descent
    if balance.highest > FEW:
        carried = _from_fewer(balance, omega, level)
        if carried is not None and carried.converged:
            return carried
    ramped = _ramped(balance, omega, level)
    if ramped is not None and ramped.converged:
        return ramped
    patient = _patient(balance, omega, level)
    if patient.converged:
        return patient
    raised = _with_raised_offsets(balance, omega, level)
    return descent if raised is None else raised


def _with_raised_offsets(balance: HarmonicBalance, omega: float, level: float) -> Correction | None:
    """The point reached from that without start offsets, which are raised in steps that Newton's method can follow; None where
    there are none, and where no such point is found."""
    offsets = balance.table.start_value
    if not np.any(offsets):
        return None
    found = first_point(balance.with_starts(np.zeros_like(offsets)), omega, level)
    if not found.converged:
        return None
    share, step = 0.0, 1.0
    for _ in range(RISES):
        ahead = min(share + step, 1.0)
        raised = balance.with_starts(ahead * offsets)
        moved = correct(raised, found.evaluation.point, fixed("omega", omega), iterations=30, halvings=12)
        if moved.converged and ahead == 1.0:
            return moved
        found, share, step = (moved, ahead, 1.5 * step) if moved.converged else (found, share, 0.5 * step)
        if step < LEAST_RISE:
            break
    return None


def _from_fewer(balance: HarmonicBalance, omega: float, level: float) -> Correction | None:
    """The first point with a third of the harmonics, carried to all of them; None where there is none, and where the load acts on
    more than these."""
    fewer = balance.highest // 3
    if any(harmonic > fewer for force in balance.problem.forces for harmonic in force.factors):
        return None
    first = first_point(balance.with_harmonics(fewer), omega, level)
    return resolved(balance, first.evaluation) if first.converged else None


def solve_cold(balance: HarmonicBalance, omega: float, level: float) -> Correction:
    """Newton from the stuck state at a given frequency and level: by descent, else with the patience to cross kinks; else from
    the contacts at rest."""
    descent = _descended(balance, omega, level, iterations=40)
    if descent.converged:
        return descent
    patient = descent if descent.singular else _patient(balance, omega, level)
    if patient.converged:
        return patient
    rested = _from_rest(balance, omega, level)
    return descent if rested is None or not rested.converged else rested


def _descended(balance: HarmonicBalance, omega: float, level: float, iterations: int) -> Correction:
    return correct(balance, balance.stuck_point(omega, level), fixed("omega", omega), iterations, halvings=12)


def _from_rest(balance: HarmonicBalance, omega: float, level: float) -> Correction | None:
    """Newton from the contacts at rest: from the stuck state so many of them may slip that nothing holds a body. None where no
    state of rest is known."""
    problem = balance.problem.at_frequency(omega)
    rest = at_rest(problem) if balance.kept[0] == 0 else None
    if rest is None:
        return None
    forces = np.zeros((balance.rows, balance.columns))
    forces[:, 0] = rest.forces - problem.contact_stiffness * rest.motion
    return correct(balance, Point(forces, omega, level), fixed("omega", omega), iterations=40, halvings=12)


def _patient(balance: HarmonicBalance, omega: float, level: float) -> Correction:
    return correct(balance, balance.stuck_point(omega, level), fixed("omega", omega), iterations=40, patience=30)


def _ramped(balance: HarmonicBalance, omega: float, level: float) -> Correction | None:
    """The end of a curve in the force level from a thousandth of it; None if the curve does not begin or breaks off."""
    low = solve_cold(balance, omega, 1e-3 * level)
    if not low.converged:
        return None
    try:
        *_, last = trace(balance, low, "level", level, StepControl(points=400))
    except LostCurveError:
        return None
    return correct(balance, last.point, fixed("omega", omega), iterations=40, halvings=12)


def trace(
    balance: HarmonicBalance, first: Correction, parameter: Parameter, end: float, control: StepControl | None = None
) -> Iterator[CurvePoint]:
    """The curve from a solved point until its parameter reaches `end`, that point included; raises `LostCurveError` on the way,
    also where the curve turns back and leaves through its start.
    """
    return _Tracer(balance, parameter, first, end, control or StepControl()).points(first)


class _Tracer:
    """One continuation to an end of its parameter, and the ways in which it may be lost before."""

    def __init__(
        self, balance: HarmonicBalance, parameter: Parameter, first: Correction, end: float, control: StepControl
    ) -> None:
        self.parameter = parameter
        self.start = first.evaluation.point.value(parameter)
        self.end = end
        self.direction = 1.0 if end > self.start else -1.0
        self.steps = Steps(balance, parameter, abs(end - self.start) / 10.0, control)
        self.undamped = parameter == "omega" and not balance.problem.damped

    def points(self, first: Correction) -> Iterator[CurvePoint]:
        current = self.steps.starting_point(first, self.direction)
        yield current
        before: CurvePoint | None = None
        mark, renewal, drifting = current, 64, 0
        place, standing, size = current.point.value(self.parameter), 0, self._vibration(current)
        furthest, folding = place, 0
        for count in range(self.steps.control.points):
            if self.direction * (self.end - current.point.value(self.parameter)) <= 0.0:
                return
            following = self.steps.advance(current, before)
            value = following.point.value(self.parameter)
            if self.direction * (value - self.end) >= 0.0:
                yield solve_at(self.steps.balance, current, following, self.parameter, self.end)
                return
            if self.direction * (value - self.start) < 0.0:
                raise LostCurveError(TURNED_BACK)
            before = current
            drifting = drifting + 1 if self._means_alone_move(current, following) else 0
            current = following
            yield current
            if drifting == DRIFT_STEPS:
                raise LostCurveError(DRIFTS)
            if abs(value - place) >= STILL * self.steps.scale:
                place, standing, size = value, 0, self._vibration(current)
            standing += 1
            if self._vibration(current) > GROWN * size:
                raise LostCurveError(INFINITE)
            if standing > STANDING_STEPS:
                raise LostCurveError(STANDS_STILL)
            folding += 1
            if self.direction * (value - furthest) > ADVANCE * abs(self.end - self.start):
                furthest, folding = value, 0
            if folding > FOLDING_STEPS:
                raise LostCurveError(FOLDS)
            if self._meets(mark, current):
                raise LostCurveError(CLOSED)
            if count == renewal:
                mark, renewal = current, 2 * renewal
        raise LostCurveError(f"The curve was not finished within {self.steps.control.points} points.")

    def _means_alone_move(self, current: CurvePoint, following: CurvePoint) -> bool:
        """Whether a step changes harmonic 0 and nothing else: a family of solutions along which a body lies elsewhere."""
        change = following.point.value(self.parameter) - current.point.value(self.parameter)
        if abs(change) > STILL * self.steps.scale:
            return False
        motion = following.evaluation.w - current.evaluation.w
        whole = current.metric.length(motion, change)
        motion[:, 0] = 0.0
        return current.metric.length(motion, change) < STILL * whole

    def _meets(self, mark: CurvePoint, current: CurvePoint) -> bool:
        """Whether the curve is back where it was, in the same direction: then it goes round for ever (Brent's test)."""
        change = current.point.value(self.parameter) - mark.point.value(self.parameter)
        if abs(change) > MET * self.steps.scale or mark.chord(current, self.parameter) > MET:
            return False
        return mark.turn(current) > 0.9

    def _vibration(self, point: CurvePoint) -> float:
        """The largest harmonic of a point, the mean left out; 0 where damping bounds it."""
        return float(np.abs(point.evaluation.w[:, 1:]).max(initial=0.0)) if self.undamped else 0.0


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
