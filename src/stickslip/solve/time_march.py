"""Time integration until the motion repeats itself: the independent referee of every frequency-domain result.

It shares the structure, the contact tables and the step law with the harmonic balance, but neither harmonics nor Newton's
method over a period. The periods are marched one by one and compared.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from threadpoolctl import threadpool_limits

from stickslip.checks import Array, fault, positive
from stickslip.problem import Problem
from stickslip.solve.time_start import TimeStart
from stickslip.time.contact_step import ContactState
from stickslip.time.methods import DEFAULT_METHOD, Method
from stickslip.time.model import StepMatrices, TimeModel, time_model
from stickslip.time.period import History, Loads, PeriodWork, State, march_period, settle

RATE_PERIODS = 5
"""Over how many periods the rate of decay is measured."""


class MarchOutcome(IntEnum):
    """How a march ended."""

    PERIODIC = 1
    NOT_PERIODIC = 2
    STEP_FAILED = 3


@dataclass(frozen=True)
class March:
    """Settings: steps per period, method, tolerance of periodicity, limit in periods.

    A motion counts as periodic when its estimated distance from the limit, c r/(1 − r) with c the relative change from
    period to period and r its rate of decay, is below `tolerance`.
    """

    steps_per_period: int = 2000
    method: Method = DEFAULT_METHOD
    tolerance: float = 1e-6
    periods: int = 1000

    def __post_init__(self) -> None:
        if int(self.steps_per_period) != self.steps_per_period or self.steps_per_period < 8:
            raise fault("steps_per_period", "must be a whole number of at least 8", self.steps_per_period, "Take thousands.")
        if int(self.periods) != self.periods or self.periods < 2:
            raise fault("periods", "must be a whole number of at least 2", self.periods)
        positive("tolerance", self.tolerance)


@dataclass(frozen=True, eq=False)
class TimeCycle:
    """The last period of a march, N steps; column n is the time t_n = n T/N.

    outputs (outputs, N) [m]; contact_motion [m], contact_force [N] (rows, N); friction_work (rows,) Σ L |Δs|, given, viscous:
    energies of the period [J]; periods marched; change from the period before and estimated distance from the limit, relative;
    end: the state at the end, from which a march may go on.
    """

    omega: float
    level: float
    outputs: Array
    contact_motion: Array
    contact_force: Array
    friction_work: Array
    given: float
    viscous: float
    outcome: MarchOutcome
    periods: int
    change: float
    distance: float
    end: TimeStart

    @property
    def energy_residual(self) -> float:
        """|input − friction − viscous| relative to the input: what the method of integration adds or takes."""
        lost = self.given - float(self.friction_work.sum()) - self.viscous
        return abs(lost) / max(abs(self.given), np.finfo(float).tiny)

    @property
    def sentence(self) -> str:
        """How the march ended, for people."""
        match self.outcome:
            case MarchOutcome.PERIODIC:
                return f"Periodic after {self.periods} periods, to about {self.distance:.1e}."
            case MarchOutcome.NOT_PERIODIC:
                return (
                    f"Not periodic within {self.periods} periods: the last one still differs by {self.change:.1e} from the one "
                    "before. Allow more periods; a lightly damped motion needs about 2/ζ of them, a subharmonic never ends."
                )
            case MarchOutcome.STEP_FAILED:
                return f"A step of period {self.periods} has no solution that Newton's method finds. Take more steps per period."


def march(problem: Problem, omega: float, level: float, start: TimeStart, settings: March) -> TimeCycle:
    """Integrate M q̈ + C q̇ + K q + Bᵀ f(B q) = p(t) from a state at t = 0 until it is periodic, or the limit in periods."""
    model = time_model(problem)
    period = 2.0 * np.pi / positive("omega", omega)
    with threadpool_limits(1, user_api="blas"):
        matrices = model.step_matrices(settings.method.coefficients, period / settings.steps_per_period)
        loads = _loads(model, level, settings.steps_per_period)
        state = _state(model, start)
        settle(model.table, matrices, loads, state)
        return _until_periodic(model, matrices, loads, state, omega, level, settings)


def _until_periodic(
    model: TimeModel, matrices: StepMatrices, loads: Loads, state: State, omega: float, level: float, settings: March
) -> TimeCycle:
    last, history = (_history(model, settings.steps_per_period) for _ in range(2))
    changes: list[float] = []
    outcome = MarchOutcome.NOT_PERIODIC
    work = PeriodWork(0.0, 0.0, 0, -1)
    count = 0
    while outcome == MarchOutcome.NOT_PERIODIC and count < settings.periods:
        last, history = history, last
        work = march_period(model.table, matrices, loads, state, history)
        count += 1
        if work.failed >= 0:
            outcome = MarchOutcome.STEP_FAILED
        elif count > 1:
            changes.append(_change(last, history))
            if distance(changes) <= settings.tolerance:
                outcome = MarchOutcome.PERIODIC
    contacts = state.contacts
    end = TimeStart(model.shapes @ state.motion, model.shapes @ state.velocity, contacts.intercept.copy())
    return TimeCycle(
        omega=omega,
        level=level,
        outputs=history.outputs,
        contact_motion=history.contact_motion,
        contact_force=history.contact_force,
        friction_work=history.friction_work,
        given=work.given,
        viscous=work.viscous,
        outcome=outcome,
        periods=count,
        change=changes[-1] if changes else np.inf,
        distance=distance(changes),
        end=end,
    )


def distance(changes: Sequence[float]) -> float:
    """Estimated relative distance of the last period from the limit, from the changes between successive periods."""
    if not changes:
        return np.inf
    last = changes[-1]
    if last <= 1e-13:
        return last
    back = min(RATE_PERIODS, len(changes) - 1)
    if back < 2:
        return np.inf
    rate = (last / changes[-1 - back]) ** (1.0 / back)
    return last * rate / (1.0 - rate) if rate < 1.0 else np.inf


def _change(before: History, after: History) -> float:
    """Change between two periods relative to the vibration, of the outputs or of the contact forces, whichever is larger."""
    found = 0.0
    for old, new in ((before.outputs, after.outputs), (before.contact_force, after.contact_force)):
        size = float(np.linalg.norm(new - new.mean(axis=1, keepdims=True)))
        difference = float(np.linalg.norm(new - old))
        found = max(found, difference / size if size > 0.0 else float(difference > 0.0))
    return found


def _loads(model: TimeModel, level: float, steps: int) -> Loads:
    static, harmonic = model.load(level)
    highest = (harmonic.shape[1] - 1) // 2
    if steps < 4 * highest:
        raise fault("steps_per_period", f"must resolve the load's harmonic {highest}", steps)
    angles = 2.0 * np.pi * ((np.arange(steps)[:, None] * np.arange(1, highest + 1)) % steps) / steps
    rows = np.zeros((steps, 2 * highest + 1))
    rows[:, 1::2], rows[:, 2::2] = np.cos(angles), np.sin(angles)
    return Loads(static, harmonic, rows)


def _state(model: TimeModel, start: TimeStart) -> State:
    modes, rows, elements = model.mass.size, model.table.rows, model.table.stiffness.size
    contacts = ContactState(np.zeros(rows), np.zeros(rows), np.array(start.intercepts, dtype=float), np.zeros(elements))
    return State(model.weight @ start.motion, model.weight @ start.velocity, np.zeros(modes), contacts, np.zeros(rows))


def _history(model: TimeModel, steps: int) -> History:
    rows, outputs = model.table.rows, model.problem.output_rows.shape[0]
    return History(np.zeros((outputs, steps)), np.zeros((rows, steps)), np.zeros((rows, steps)), np.zeros(rows))
