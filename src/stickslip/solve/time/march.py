"""Time integration to a steady state, the independent check of all frequency-domain results.

It shares the structure, the contact tables and the step law with the harmonic balance, but neither harmonics nor Newton's
method over a period. The periods are marched one by one and compared.

Initial conditions of a time integration: rest, or a harmonic balance solution with its sliders.

Friction remembers: an element that never slips in the steady period keeps its slider where it starts, in time as in the
harmonic balance. Starting with the sliders of a harmonic solution is what makes the two comparable where forces are not unique.

The periodic motion of the time steps by shooting, and its largest Floquet multiplier, by differences of marched periods.

Nothing but marches of one period is used, no harmonics and no linearised contact: an independent check of stability. States
are x = (η, √m η̇, y/√kt), so that ‖x‖² is twice an energy.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.contact.point import contact_table
from stickslip.model.problem import Problem
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.energy import contact_cycle
from stickslip.solve.balance.fourier import fourier
from stickslip.solve.time.contact_law import ContactState
from stickslip.solve.time.period import (
    DEFAULT_METHOD,
    History,
    Loads,
    Method,
    PeriodWork,
    State,
    StepMatrices,
    TimeModel,
    march_period,
    settle,
    time_model,
)
from stickslip.support.checks import Array, fault, of_kind, positive, whole
from stickslip.support.machine import one_blas_thread


@dataclass(frozen=True, eq=False)
class TimeStart:
    """State at t = 0: motion q (n,) [m], velocity (n,) [m/s], intercepts y = T − kt u (elements,) [N]."""

    motion: Array
    velocity: Array
    intercepts: Array

    @property
    def fingerprint(self) -> str:
        """Everything in it, as `Settings.identity` names it."""
        return repr([values.tolist() for values in (self.motion, self.velocity, self.intercepts)])


def from_rest(problem: Problem) -> TimeStart:
    """No motion, and every slider where its start rule puts it: offset s, T = m L, or T = T̄, clipped to the limits."""
    table = contact_table(problem.contacts)
    rest = contact_cycle(table, fourier(1, 6), np.zeros((table.rows, 3)), 0.0)
    nothing = np.zeros(problem.structure.size)
    return TimeStart(nothing, nothing.copy(), rest.intercept)


def checked_start(problem: Problem, start: TimeStart) -> TimeStart:
    """A start, refused unless its motion, velocity and intercepts have the sizes of a problem."""
    states = of_kind("start", start, TimeStart), from_rest(problem)
    sizes, wanted = ([np.shape(values) for values in vars(state).values()] for state in states)
    if sizes != wanted:
        rule = f"must have motion, velocity and intercepts of shapes {wanted}"
        raise fault("start", rule, sizes, "Take a start state of this problem.")
    return start


def from_harmonics(balance: HarmonicBalance, forces: Array, omega: float, level: float) -> TimeStart:
    """The state at t = 0 of a solution with λ = `forces` (rows, 2H+1) [N], at omega [rad/s] and a force level.

    The sliders are those of the last sample, from which the first step at t = 0 moves them to where the solution has them.
    """
    q = balance.linear.whole_motion(forces, omega, level)
    order = np.arange(1, balance.highest + 1)
    cycle = contact_cycle(balance.table, balance.tables, balance.problem.B @ q, omega)
    return TimeStart(q[:, 0] + q[:, 1::2].sum(axis=1), omega * (q[:, 2::2] @ order), cycle.intercept)


LOAD_STEPS = 4
"""The fewest steps per period of the highest harmonic of the loads."""

RATE_PERIODS = 5
"""Over how many periods, at least, the rate of decay is measured; over a third of all of them if that is more."""

GROWTH = 100.0
"""A change from period to period that has risen by this factor from its least value says that the motion left an unstable one."""

NEAR = 1e-3
"""An estimated distance from a periodic motion below which a march that did not reach its tolerance has all but settled."""

LONGEST = 4
"""Periods of the excitation after which a motion may repeat itself that is looked for."""

UNBOUNDED = 1e8
"""Growth of the largest output since the first period beyond which a march is given up."""


class MarchOutcome(IntEnum):
    """How a march ended."""

    PERIODIC = 1
    NOT_PERIODIC = 2
    STEP_FAILED = 3
    UNBOUNDED = 4
    SUBHARMONIC = 5


@dataclass(frozen=True)
class March:
    """Settings: steps per period, method, tolerance of periodicity, limit in periods.

    A motion counts as periodic when its estimated distance from the limit, c r/(1 − r) with c the relative change from
    period to period and r its rate of decay, is below `tolerance`. It is subharmonic when the distance from a motion over 2, 3 or
    4 periods is that share of the change from period to period, which goes on.
    """

    steps_per_period: int = 2000
    method: Method = DEFAULT_METHOD
    tolerance: float = 1e-6
    periods: int = 1000

    def __post_init__(self) -> None:
        for name, least, remedy in (("steps_per_period", 8, "Take thousands."), ("periods", 2, "")):
            if whole(name, getattr(self, name), remedy) < least:
                raise fault(name, f"must be a whole number of at least {least}", getattr(self, name), remedy)
        positive("tolerance", self.tolerance)
        if not isinstance(self.method, Method):
            raise fault("method", "must be a GeneralisedAlpha or a Newmark", self.method)


@dataclass(frozen=True, eq=False)
class TimeCycle:
    """The last period of a march, N steps; column n is the time t_n = n T/N.

    outputs and first_outputs, those of the first period (outputs, N) [m]; contact_motion [m], contact_force [N] (rows, N);
    friction_work (rows,) Σ L |Δs|, given, viscous: energies of the period [J]; periods marched; change from the period before and
    estimated distance from the limit, relative; growth: the factor per period by which changes rose, 1 where they did not;
    end: the state, from which a march may go on; repeats: periods of the excitation after which the motion does, 0 where
    it is not known.
    """

    omega: float
    level: float
    outputs: Array
    first_outputs: Array
    contact_motion: Array
    contact_force: Array
    friction_work: Array
    given: float
    viscous: float
    outcome: MarchOutcome
    periods: int
    change: float
    distance: float
    growth: float
    end: TimeStart
    repeats: int

    @property
    def energy_residual(self) -> float:
        """|input − friction − viscous| relative to the input: what the method of integration adds or takes."""
        lost = self.given - float(self.friction_work.sum()) - self.viscous
        return abs(lost) / max(abs(self.given), np.finfo(float).tiny)

    @property
    def sentence(self) -> str:
        """How the march ended, as a sentence."""
        match self.outcome:
            case MarchOutcome.PERIODIC:
                return f"Periodic after {self.periods} periods, to about {self.distance:.1e}."
            case MarchOutcome.SUBHARMONIC:
                return (
                    f"Subharmonic after {self.periods} periods: the motion repeats itself after {self.repeats} periods of the "
                    f"excitation, and its last period differs by {self.change:.1e} from the one before."
                )
            case MarchOutcome.NOT_PERIODIC:
                return self._not_periodic
            case MarchOutcome.STEP_FAILED:
                return f"A step of period {self.periods} has no solution that Newton's method finds. Take more steps per period."
            case MarchOutcome.UNBOUNDED:
                return (
                    f"The motion grew without bound within {self.periods} periods. Where contacts land, steps that do not "
                    "resolve their vibration can gain energy: take more steps or a smaller spectral radius. Else the structure "
                    "itself is unstable."
                )

    @property
    def _not_periodic(self) -> str:
        found = f"Not periodic within {self.periods} periods: the last one differs by {self.change:.1e} from the one before"
        if self.growth > 1.0:
            return f"{found}, and the difference has grown: a periodic motion is unstable here."
        if self.distance < NEAR:
            enough = 10.0 ** np.ceil(np.log10(self.distance))
            return (
                f"{found} and at most about {self.distance:.1e} from a periodic motion, more than `tolerance`. If this is "
                f"close enough, pass tolerance={enough:.0e}. Lightly damped motion decays slowly."
            )
        never = f"A motion that repeats itself after more than {LONGEST}, or never, does not settle."
        return f"{found}. Allow more periods: about 2/ζ for a damping ratio ζ. {never}"


def march(problem: Problem, omega: float, level: float, start: TimeStart, settings: March) -> TimeCycle:
    """Integrate M q̈ + C q̇ + K q + Bᵀ f(B q) = p(t) from a state at t = 0 until it is periodic, or the limit in periods."""
    model = time_model(problem)
    period = 2.0 * np.pi / positive("omega", omega)
    with one_blas_thread():
        matrices = model.step_matrices(settings.method.coefficients, period / settings.steps_per_period)
        loads = loads_of_steps(model, omega, level, settings.steps_per_period)
        state = state_at(model, start)
        settle(model.table, matrices, loads, state)
        return _until_periodic(model, matrices, loads, state, omega, level, settings)


def _until_periodic(
    model: TimeModel, matrices: StepMatrices, loads: Loads, state: State, omega: float, level: float, settings: March
) -> TimeCycle:
    last, history = (no_history(model, settings.steps_per_period) for _ in range(2))
    changes: list[float] = []
    subharmonic = Repetition(settings.tolerance)
    outcome = MarchOutcome.NOT_PERIODIC
    work = PeriodWork(0.0, 0.0, 0, -1)
    first_outputs = last.outputs
    count = 0
    while outcome == MarchOutcome.NOT_PERIODIC and count < settings.periods:
        last, history = history, last
        work = march_period(model.table, matrices, loads, state, history)
        count += 1
        first_outputs = history.outputs.copy() if count == 1 else first_outputs
        if work.failed >= 0:
            outcome = MarchOutcome.STEP_FAILED
        elif not np.max(np.abs(history.outputs)) <= UNBOUNDED * np.max(np.abs(first_outputs)):
            outcome = MarchOutcome.UNBOUNDED
        elif count > 1:
            changes.append(_change(last, history, matrices.stiffness))
            if distance(changes) <= settings.tolerance:
                outcome = MarchOutcome.PERIODIC
            elif subharmonic.found(np.concatenate([state.motion, state.velocity / omega])):
                outcome = MarchOutcome.SUBHARMONIC
    contacts = state.contacts
    end = TimeStart(model.shapes @ state.motion, model.shapes @ state.velocity, contacts.intercept.copy())
    return TimeCycle(
        omega=omega,
        level=level,
        outputs=history.outputs,
        first_outputs=first_outputs,
        contact_motion=history.contact_motion,
        contact_force=history.contact_force,
        friction_work=history.friction_work,
        given=work.given,
        viscous=work.viscous,
        outcome=outcome,
        periods=count,
        change=changes[-1] if changes else np.inf,
        distance=distance(changes),
        growth=growth(changes),
        end=end,
        repeats=1 if outcome == MarchOutcome.PERIODIC else subharmonic.periods,
    )


class Repetition:
    """After how many periods of the excitation, more than one, a motion repeats itself, from its states between them; 0: none."""

    def __init__(self, tolerance: float) -> None:
        self.tolerance, self.periods = tolerance, 0
        self._states: deque[Array] = deque(maxlen=2 * LONGEST)
        self._changes: dict[int, list[float]] = {periods: [] for periods in range(1, LONGEST + 1)}

    def found(self, state: Array) -> bool:
        """Whether the motion up to this state is known to repeat itself."""
        self._states.append(state)
        if len(self._states) < 2 * LONGEST:
            return False
        states = np.array(self._states)
        # The largest of some periods in a row: where a transient has a frequency of its own, single changes are small by chance.
        for back, changes in self._changes.items():
            changes.append(float(np.linalg.norm(states[LONGEST:] - states[LONGEST - back : -back], axis=1).max()))
        # A transient of half the frequency alternates, too, but its distance then is all of the change.
        change = self._changes[1][-1]
        away = {back: distance(changes) for back, changes in self._changes.items()}
        # Twice as long a motion passes for settled first where the change over the shorter one still turns as it dies out.
        dying = {back for back in range(2, LONGEST + 1) if self.tolerance * change < away[back] < change}
        settled = (back for back in range(2, LONGEST + 1) if away[back] <= self.tolerance * change)
        self.periods = next((back for back in settled if not any(back % shorter == 0 for shorter in dying - {back})), 0)
        return self.periods > 0


def distance(changes: Sequence[float]) -> float:
    """Estimated relative distance of the last period from the limit, from the changes between successive periods."""
    if not changes:
        return np.inf
    last = changes[-1]
    if last <= 1e-13:
        return last
    back = min(max(RATE_PERIODS, len(changes) // 3), len(changes) - 1)
    if back < 2:
        return np.inf
    rate = (last / changes[-1 - back]) ** (1.0 / back)
    return last * rate / (1.0 - rate) if rate < 1.0 else np.inf


def growth(changes: Sequence[float]) -> float:
    """Factor per period of the first rise of the changes by `GROWTH` from their least value, 1 where they never rise so far.

    Near an unstable periodic motion every change is |μ| times the one before, μ the largest multiplier of Floquet. Sliders that
    creep from one stuck state to another change by as much or less in every period.
    """
    least = 0
    for k, change in enumerate(changes):
        if change > GROWTH * changes[least]:
            return float((change / changes[least]) ** (1.0 / (k - least)))
        least = k if change < changes[least] else least
    return 1.0


def _change(before: History, after: History, stiffness: Array) -> float:
    """Change between two periods relative to the vibration, of the outputs or of the contact forces, whichever is larger.

    The vibration of contact forces is taken no smaller than that of the stuck springs, K_c w: an open contact has none.
    """
    forces = float(np.linalg.norm(after.contact_force - before.contact_force))
    springs = stiffness[:, None] * after.contact_motion
    return max(
        _share(float(np.linalg.norm(after.outputs - before.outputs)), _vibration(after.outputs)),
        _share(forces, max(_vibration(after.contact_force), _vibration(springs))),
    )


def _vibration(signals: Array) -> float:
    """Size of signals (rows, N) about their means."""
    return float(np.linalg.norm(signals - signals.mean(axis=1, keepdims=True)))


def _share(difference: float, size: float) -> float:
    return difference / size if size > 0.0 else float(difference > 0.0)


def loads_of_steps(model: TimeModel, omega: float, level: float, steps: int) -> Loads:
    static, harmonic = model.load(omega, level)
    highest = (harmonic.shape[1] - 1) // 2
    if steps < LOAD_STEPS * highest:
        raise fault("steps_per_period", f"must resolve the load's harmonic {highest}", steps)
    angles = 2.0 * np.pi * ((np.arange(steps)[:, None] * np.arange(1, highest + 1)) % steps) / steps
    rows = np.zeros((steps, 2 * highest + 1))
    rows[:, 1::2], rows[:, 2::2] = np.cos(angles), np.sin(angles)
    return Loads(static, harmonic, rows)


def state_at(model: TimeModel, start: TimeStart) -> State:
    modes, rows, elements = model.mass.size, model.table.rows, model.table.stiffness.size
    contacts = ContactState(np.zeros(rows), np.zeros(rows), np.array(start.intercepts, dtype=float), np.zeros(elements))
    return State(model.weight @ start.motion, model.weight @ start.velocity, np.zeros(modes), contacts, np.zeros(rows))


def no_history(model: TimeModel, steps: int) -> History:
    rows, outputs = model.table.rows, model.problem.output_rows.shape[0]
    return History(np.zeros((outputs, steps)), np.zeros((rows, steps)), np.zeros((rows, steps)), np.zeros(rows))


DISTURBANCE = 1e-5
"""Size of a disturbance relative to the vibration; the solution of a step leaves 1e-11 of the forces."""

CLOSED = 1e-7
"""Defect of a period, relative to the vibration, at which a motion is periodic."""

CORRECTIONS = 12

SMALLEST_STEP = 1.0 / 64.0
"""Share of a correction below which none helps."""

MOST_VECTORS = 80
"""Size of the Krylov spaces."""

FEWEST_VECTORS = 12

EXHAUSTED = 1e-5
"""Part of a new vector outside the space, relative, below which the space holds all that the map makes of it."""

SETTLED = 1e-4
"""Residual of the largest multiplier, relative to it, at which the space is large enough; twice in succession."""

KINK = 0.03
"""Difference of the one-sided derivatives beyond which there is none: a contact just touches, or a slider just slips."""

SOLVED = 1e-2
"""Residual of the linear system of a correction, relative."""


@dataclass(frozen=True, eq=False)
class Shooting:
    """start: a state of the periodic motion, at t = 0; defect: what a period changes of it, relative to the vibration; outputs
    (outputs, N): over the period; multipliers: those found, largest first, without those of exactly 1 of sliders that never
    slip. closed: whether the motion was found; without it there are no multipliers, nor where the period has no derivative."""

    start: TimeStart
    defect: float
    outputs: Array
    multipliers: NDArray[np.complex128]
    closed: bool

    @property
    def leading(self) -> complex:
        """The largest multiplier; NaN where no periodic motion was found."""
        return complex(self.multipliers[0]) if self.multipliers.size else complex(np.nan)


def shoot(problem: Problem, omega: float, level: float, start: TimeStart, motion: Array, settings: March) -> Shooting:
    """The periodic motion near a state at t = 0, and its multipliers. motion q (n, 2H+1) [m]: of the harmonic balance, for scale.

    Newton's method: (1 − Φ) δx = P(x) − x by GMRES, Φ by differences of the map P of a period.
    """
    with one_blas_thread():
        march = PeriodMarch(problem, omega, level, settings)
        vibration = float(np.linalg.norm(march.model.weight @ motion[:, 1:])) / np.sqrt(2.0)
        x, defect = _closed(march, march.packed(start), vibration)
        closed = bool(vibration > 0.0 and np.linalg.norm(defect) <= CLOSED * vibration)
        values = _multipliers(march, x, x + defect, vibration) if closed else np.empty(0, dtype=complex)
        march(x)
        return Shooting(march.start(x), float(np.linalg.norm(defect)) / vibration, march.history.outputs.copy(), values, closed)


class PeriodMarch:
    """The map of a period of N steps, from a state x (k,) at t = 0 to the one a period later; NaN where a step fails."""

    def __init__(self, problem: Problem, omega: float, level: float, settings: March) -> None:
        self.model, steps = time_model(problem), settings.steps_per_period
        self.matrices = self.model.step_matrices(settings.method.coefficients, 2.0 * np.pi / omega / steps)
        self.loads = loads_of_steps(self.model, omega, level, steps)
        self.history = no_history(self.model, steps)
        # Massless modes have a velocity too; its scale only has to be a number.
        inertia = np.maximum(np.sqrt(self.model.mass), self.matrices.step)
        stiffness = np.sqrt(self.model.table.stiffness)
        self.scale = np.concatenate([np.ones(inertia.size), inertia, 1.0 / np.where(stiffness > 0.0, stiffness, np.inf)])

    def __call__(self, x: Array) -> Array:
        state = state_at(self.model, self.start(x))
        settle(self.model.table, self.matrices, self.loads, state)
        if march_period(self.model.table, self.matrices, self.loads, state, self.history).failed >= 0:
            return np.full(x.size, np.nan)
        return np.asarray(self.scale * np.concatenate([state.motion, state.velocity, state.contacts.intercept]))

    def packed(self, start: TimeStart) -> Array:
        """x of a state."""
        weight = self.model.weight
        return np.asarray(self.scale * np.concatenate([weight @ start.motion, weight @ start.velocity, start.intercepts]))

    def start(self, x: Array) -> TimeStart:
        """The state of x."""
        parts, modes = x / np.where(self.scale > 0.0, self.scale, 1.0), self.model.mass.size
        shapes = self.model.shapes
        return TimeStart(shapes @ parts[:modes], shapes @ parts[modes : 2 * modes], parts[2 * modes :])


class Differences:
    """Φ v ≈ (P(x + ε v) − P(x − ε v))/2ε for unit vectors v; kink: the largest difference of the two one-sided ones."""

    def __init__(self, march: PeriodMarch, x: Array, after: Array, vibration: float) -> None:
        self.march, self.x, self.after, self.size, self.kink = march, x, after, DISTURBANCE * vibration, 0.0

    def __call__(self, v: Array) -> Array:
        up, down = (self.march(self.x + sign * self.size * v) for sign in (1.0, -1.0))
        self.kink = max(self.kink, float(np.linalg.norm(up + down - 2.0 * self.after)) / self.size)
        return np.asarray((up - down) / (2.0 * self.size))


class Krylov:
    """Arnoldi's vectors of a map, orthonormal (k, j+1), and its projection, `matrix` (j+1, j)."""

    def __init__(self, derivative: Differences, first: Array) -> None:
        self.derivative = derivative
        self.vectors = [first / np.linalg.norm(first)]
        self.matrix = np.zeros((1, 0))
        self.exhausted = False

    def grow(self) -> None:
        """One vector more."""
        new = self.derivative(self.vectors[-1])
        size, column = float(np.linalg.norm(new)), np.zeros(len(self.vectors) + 1)
        for _ in range(2):
            for k, vector in enumerate(self.vectors):
                part = float(vector @ new)
                column[k] += part
                new = new - part * vector
        column[-1] = np.linalg.norm(new)
        self.matrix = np.pad(self.matrix, (0, 1))
        self.matrix[:, -1] = column
        self.exhausted = not column[-1] > EXHAUSTED * max(size, 1.0)
        self.vectors.append(new / column[-1] if column[-1] > 0.0 else new)


def _closed(march: PeriodMarch, x: Array, vibration: float) -> tuple[Array, Array]:
    """x and P(x) − x of the periodic motion, or as near to it as Newton's method comes."""
    defect = march(x) - x
    for _ in range(CORRECTIONS):
        if not np.linalg.norm(defect) > CLOSED * vibration:
            break
        change = _correction(Differences(march, x, x + defect, vibration), defect)
        length = 1.0
        while length >= SMALLEST_STEP:
            trial = x + length * change
            left = march(trial) - trial
            if np.linalg.norm(left) < (1.0 - 0.1 * length) * np.linalg.norm(defect):
                break
            length *= 0.5
        else:
            break
        x, defect = trial, left
    return x, defect


def _correction(derivative: Differences, defect: Array) -> Array:
    """δx of (1 − Φ) δx = defect by GMRES."""
    krylov, size = Krylov(derivative, defect), float(np.linalg.norm(defect))
    while True:
        krylov.grow()
        H = krylov.matrix
        right = size * np.eye(H.shape[0])[0]
        matrix = np.eye(*H.shape) - H
        if not np.all(np.isfinite(H)):
            return np.full(defect.size, np.nan)
        found = linalg.lstsq(matrix, right)[0]
        left = float(np.linalg.norm(right - matrix @ found))
        if left <= SOLVED * size or krylov.exhausted or H.shape[1] >= min(MOST_VECTORS, defect.size):
            return np.asarray(np.array(krylov.vectors[: found.size]).T @ found)


def _multipliers(march: PeriodMarch, x: Array, after: Array, vibration: float) -> NDArray[np.complex128]:
    """Eigenvalues of Φ in the Krylov space of a random disturbance of motion and velocity, which leaves stuck sliders alone."""
    modes = march.model.mass.size
    first = np.concatenate([np.random.default_rng(0).normal(size=2 * modes), np.zeros(x.size - 2 * modes)])
    derivative, settled = Differences(march, x, after, vibration), 0
    krylov = Krylov(derivative, first)
    while True:
        krylov.grow()
        H = krylov.matrix
        if not np.all(np.isfinite(H)) or derivative.kink > KINK:
            return np.empty(0, dtype=complex)
        values, vectors = np.linalg.eig(H[:-1])
        order = np.argsort(-np.abs(values))
        leading = order[0]
        residual = H[-1, -1] * abs(vectors[-1, leading]) / np.linalg.norm(vectors[:, leading])
        settled = settled + 1 if residual <= SETTLED * max(abs(values[leading]), 1.0) else 0
        size = H.shape[1]
        if krylov.exhausted or size >= min(MOST_VECTORS, x.size) or (size >= FEWEST_VECTORS and settled >= 2):
            return np.asarray(values[order], dtype=complex)
