"""One compiled period of time integration: N steps of size h, advancing the state in place and recording histories.

The linear part of a step is a product with constant matrices; the contacts are solved by `stickslip.solve.time.contact_law`.

A problem in the modes of its stuck structure, with the constant matrices of one time step size.

With q = Φη and Φᵀ(K + BᵀK_cB)Φ = I:  m η̈ + c η̇ + η = Φᵀp − Rᵀλ,  R = BΦ,  λ = f − K_c w. Massless motions have m = 0 and
need no special case. What slips or opens enters through λ alone, so the effective matrix S of a step never changes.

Time integration methods as settings: Newmark and generalised-α in one form with four coefficients.

M a_{n+1−αm} + C v_{n+1−αf} + K q_{n+1−αf} + Bᵀ f_{n+1−αf} = p_{n+1−αf},  x_{n+1−α} = (1 − α) x_{n+1} + α x_n,
q_{n+1} = q_n + h v_n + h² ((½ − β) a_n + β a_{n+1}),   v_{n+1} = v_n + h ((1 − γ) a_n + γ a_{n+1}).
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import linalg

from stickslip.model.contact.law import SLIDERS
from stickslip.model.contact.point import ContactTable, contact_table
from stickslip.model.problem import Problem
from stickslip.model.problem.speed import refuse_speed
from stickslip.model.problem.systems import lasting_stiffness
from stickslip.solve.time.contact_law import ContactState, Earlier, Slopes, contact_law, no_slopes, solve_contacts
from stickslip.support.checks import Array, InputError, fault, finite
from stickslip.support.kernels import boxed, inlined, inner, kernel, uncompiled


class Coefficients(NamedTuple):
    """αm, αf, β, γ of the module's equations."""

    mass_weight: float
    force_weight: float
    beta: float
    gamma: float


@dataclass(frozen=True)
class GeneralisedAlpha:
    """Second order, unconditionally stable; motions far above the step rate shrink by `spectral_radius` at every step.

    spectral_radius ρ in [0, 1]: 1 damps nothing, as the trapezoidal rule, and rings or even gains energy where a contact lands
    whose own vibration the steps do not resolve; 0 removes within one step what the step cannot resolve.
    αm = (2ρ − 1)/(ρ + 1), αf = ρ/(ρ + 1), γ = ½ − αm + αf, β = ¼ (1 − αm + αf)².
    Source: Chung and Hulbert, J. Appl. Mech. 60 (1993) 371-375, equations 17, 18 and 25.
    """

    spectral_radius: float = 0.5

    def __post_init__(self) -> None:
        if not 0.0 <= finite("spectral_radius", self.spectral_radius) <= 1.0:
            raise fault("spectral_radius", "must lie in [0, 1]", self.spectral_radius)

    @property
    def coefficients(self) -> Coefficients:
        radius = self.spectral_radius
        mass, force = (2.0 * radius - 1.0) / (radius + 1.0), radius / (radius + 1.0)
        return Coefficients(mass, force, 0.25 * (1.0 - mass + force) ** 2, 0.5 - mass + force)


@dataclass(frozen=True)
class Newmark:
    """Newmark's rule; β = ¼, γ = ½ is the trapezoidal rule, of second order and without numerical damping.

    γ > ½ damps, at first order. Source: Newmark, J. Eng. Mech. Div. ASCE 85 (1959) 67-94.
    """

    beta: float = 0.25
    gamma: float = 0.5

    def __post_init__(self) -> None:
        if not 0.5 <= finite("gamma", self.gamma) <= 2.0 * finite("beta", self.beta):
            values = {"beta": self.beta, "gamma": self.gamma}
            raise fault("Newmark", "must be unconditionally stable, 1/2 <= gamma <= 2 beta", values, "Take 1/4 and 1/2.")

    @property
    def coefficients(self) -> Coefficients:
        return Coefficients(0.0, 0.0, self.beta, self.gamma)


Method = GeneralisedAlpha | Newmark

DEFAULT_METHOD = GeneralisedAlpha()
"""Enough numerical damping to keep a landing contact from ringing, too little to be seen in what the steps resolve."""


DIAGONAL = 1e-9
"""Couplings of the modal damping below this share of √(c_ii c_jj) are rounding."""


class StepMatrices(NamedTuple):
    """What a step needs. m modes, r contact rows; a diagonal matrix is stored as one column (m, 1).

    mass (m,); damping c and inverse S⁻¹, (m, m) or (m, 1), S = (1 − αm)/(βh²) m + (1 − αf)(γ/(βh) c + 1);
    shape R (r, m), receiver Rᵀ (m, r), driven P = (1 − αf) R S⁻ᵀ (r, m), compliance G = R Pᵀ (r, r), (0, 0) where there are more
    rows than modes: w = w_free − G λ; stiffness K_c (r,); outputs (outputs, m); coefficients of the method; step h [s].
    """

    mass: Array
    damping: Array
    inverse: Array
    shape: Array
    receiver: Array
    driven: Array
    compliance: Array
    stiffness: Array
    outputs: Array
    coefficients: Coefficients
    step: float


@dataclass(frozen=True, eq=False)
class TimeModel:
    """Modes of the stuck structure: shapes Φ (n, m), mass (m,), damping (m, m) or (m, 1); weight = ΦᵀK' (m, n), η = weight q."""

    problem: Problem
    table: ContactTable
    shapes: Array
    mass: Array
    damping: Array
    weight: Array

    def load(self, omega: float, level: float) -> tuple[Array, Array]:
        """Modal loads, static (m,) and harmonic (m, 2H+1) in real storage, H the highest harmonic of the forces."""
        highest = max(harmonic for force in self.problem.forces for harmonic in force.amplitudes)
        harmonic = self.problem.load(highest, level, omega)
        harmonic[:, 0] = 0.0
        return self.shapes.T @ self.problem.static_load, np.ascontiguousarray(self.shapes.T @ harmonic)

    def step_matrices(self, coefficients: Coefficients, step: float) -> StepMatrices:
        """The matrices of a step of size h = `step`, s."""
        free = 1.0 - coefficients.force_weight
        inertia = (1.0 - coefficients.mass_weight) / (coefficients.beta * step**2) * self.mass
        rate = coefficients.gamma / (coefficients.beta * step)
        if self.damping.shape[1] == 1:
            inverse = 1.0 / (inertia[:, None] + free * (rate * self.damping + 1.0))
        else:
            inverse = linalg.inv(np.diag(inertia + free) + free * rate * self.damping)
        shape = np.ascontiguousarray(self.problem.B @ self.shapes)
        receiver = np.ascontiguousarray(shape.T)
        passed = free * (inverse * receiver if self.damping.shape[1] == 1 else inverse @ receiver)
        many = shape.shape[0] > shape.shape[1]
        return StepMatrices(
            mass=self.mass,
            damping=self.damping,
            inverse=np.ascontiguousarray(inverse),
            shape=shape,
            receiver=receiver,
            driven=np.ascontiguousarray(passed.T),
            compliance=np.empty((0, 0)) if many else np.ascontiguousarray(shape @ passed),
            stiffness=self.problem.contact_stiffness,
            outputs=np.ascontiguousarray(self.problem.output_rows @ self.shapes),
            coefficients=coefficients,
            step=step,
        )


def refuse_waves(problem: Problem) -> None:
    """Refuse problems whose harmonics do not move one structure."""
    refuse_speed(problem, "Time integration")
    if not problem.systems.alike or lasting_stiffness(problem) is None:
        raise InputError(
            "Time integration needs one structure for all harmonics. A tuned disk has one for each nodal diameter; mean springs "
            "act on harmonic 0 only, unless they are soft and restrain what friction alone restrains; aerodynamics of a disk "
            "acts on vibration only. Integrate the full disk, `disk.full()`, without stiff mean springs and aerodynamics."
        )


def time_model(problem: Problem) -> TimeModel:
    """Decompose a problem once; `step_matrices` then serves every step size. Soft mean springs act at all times."""
    refuse_waves(problem)
    lasting = lasting_stiffness(problem)
    stiffness = problem.stuck_stiffness if lasting is None else problem.stuck_stiffness + lasting
    mass, shapes = linalg.eigh(problem.structure.M, stiffness)
    mass = np.where(mass > 1e-15 * mass.max(), mass, 0.0)
    damping = shapes.T @ problem.C @ shapes
    return TimeModel(
        problem=problem,
        table=contact_table(problem.contacts),
        shapes=np.ascontiguousarray(shapes),
        mass=mass,
        damping=_compact(damping),
        weight=np.ascontiguousarray(shapes.T @ stiffness),
    )


def _compact(damping: Array) -> Array:
    """The matrix, or its diagonal as one column where the rest is rounding."""
    diagonal = np.diag(damping).copy()
    size = np.sqrt(np.abs(np.outer(diagonal, diagonal)))
    if np.all(np.abs(damping - np.diag(diagonal)) <= DIAGONAL * np.maximum(size, 1e-3 * size.max(initial=0.0))):
        return diagonal[:, None]
    return np.ascontiguousarray(damping)


class State(NamedTuple):
    """Everything that evolves, changed in place: modal motion η, velocity, acceleration (m,), the contacts and their λ of the
    step before (rows,)."""

    motion: Array
    velocity: Array
    acceleration: Array
    contacts: ContactState
    forces_before: Array


class Loads(NamedTuple):
    """Modal loads: static (m,), harmonic (m, 2H+1), and the Fourier rows of the samples (N, 2H+1)."""

    static: Array
    harmonic: Array
    rows: Array


class History(NamedTuple):
    """Samples t_0 .. t_{N−1} of a period: outputs, contact motion, contact force f (rows, N); friction work of rows (rows,), that
    of a law with kernels of its own on its first row."""

    outputs: Array
    contact_motion: Array
    contact_force: Array
    friction_work: Array


class PeriodWork(NamedTuple):
    """Input and viscous work over a period, J; iterations of all steps; the step that failed, or −1."""

    given: float
    viscous: float
    iterations: int
    failed: int


@inner
def _times(matrix: Array, vector: Array) -> Array:
    """matrix · vector, a diagonal matrix being stored as one column."""
    if matrix.shape[1] == 1 and vector.size != 1:
        return matrix[:, 0] * vector
    return matrix @ vector


def settle(table: ContactTable, matrices: StepMatrices, loads: Loads, state: State) -> None:
    """Make a start consistent: λ, sliders and limits from the motion, accelerations from the equation of motion.

    Motions too fast for the step (m < h²) and massless ones start without acceleration.
    """
    contacts = state.contacts
    slopes = uncompiled(no_slopes)(contacts.w.size)
    contacts.w[:] = matrices.shape @ state.motion
    drift = matrices.shape @ state.velocity
    before = Earlier(contacts.intercept.copy(), contacts.w.copy(), contacts.limit.copy(), drift, 0.0, True, 0.0)
    contact_law(table, contacts.w, before, contacts.intercept, contacts.limit, slopes)
    contacts.forces[:] = slopes.target
    state.forces_before[:] = slopes.target
    force = loads.static + loads.harmonic @ loads.rows[0] - matrices.receiver @ contacts.forces - state.motion
    force -= uncompiled(_times)(matrices.damping, state.velocity)
    resolved = matrices.mass >= matrices.step**2
    state.acceleration[:] = np.where(resolved, force / np.where(resolved, matrices.mass, 1.0), 0.0)


@kernel
def march_period(table: ContactTable, matrices: StepMatrices, loads: Loads, state: State, history: History) -> PeriodWork:
    """March N steps from t = 0 of a period. Column n of the histories holds t_n, column 0 the end of the period."""
    contacts, step = state.contacts, matrices.step
    mass_weight, force_weight, beta, gamma = matrices.coefficients
    history.friction_work[:] = 0.0
    given, viscous, iterations = 0.0, 0.0, 0
    compliance = (matrices.compliance, matrices.shape, matrices.driven)
    rate, slopes = gamma / (beta * step), no_slopes(contacts.w.size)
    resistance = _times(matrices.damping, state.velocity)
    pushed = matrices.receiver @ contacts.forces
    rest = loads.static + loads.harmonic @ loads.rows[0] - pushed - state.motion - resistance
    for n in range(1, loads.rows.shape[0] + 1):
        column = n % loads.rows.shape[0]
        shaken = loads.harmonic @ loads.rows[column]
        predicted = state.motion + step * state.velocity + step**2 * (0.5 - beta) * state.acceleration
        drifted = state.velocity + step * (1.0 - gamma) * state.acceleration
        right = (1.0 - force_weight) * (loads.static + shaken - predicted - _times(matrices.damping, drifted))
        right += force_weight * rest - mass_weight * matrices.mass * state.acceleration
        free = matrices.shape @ (predicted + _times(matrices.inverse, right))
        drift = matrices.shape @ (drifted - rate * predicted)
        before = Earlier(contacts.intercept.copy(), contacts.w.copy(), contacts.limit.copy(), drift, rate, True, step)
        guess = 2.0 * contacts.forces - state.forces_before
        state.forces_before[:] = contacts.forces
        used = -1
        for attempt in range(2):
            if attempt:
                guess[:] = state.forces_before
            used = solve_contacts(table, matrices.stiffness, compliance, free, guess, before, contacts, slopes)
            if used >= 0:
                break
        if used < 0:
            return boxed(PeriodWork(given, viscous, iterations, n))
        iterations += used
        pushed = matrices.receiver @ contacts.forces
        change = _times(matrices.inverse, right - (1.0 - force_weight) * pushed)
        state.motion[:] = predicted + change
        state.velocity[:] = drifted + rate * change
        state.acceleration[:] = change / (beta * step**2)
        resistance = _times(matrices.damping, state.velocity)
        rest = loads.static + shaken - pushed - state.motion - resistance
        given += step * float(np.sum(shaken * state.velocity))
        viscous += step * float(np.sum(resistance * state.velocity))
        _record(table, matrices, state, before, slopes, column, history)
    return boxed(PeriodWork(given, viscous, iterations, -1))


@inlined
def _record(
    table: ContactTable, matrices: StepMatrices, state: State, before: Earlier, slopes: Slopes, column: int, history: History
) -> None:
    """Fill a column of the histories and add the friction work of the step, of sliders L |Δs|, s = −y/kt, L at its middle; of a
    law of its own that of its states and, by the trapezoidal rule, of what no spring carries."""
    contacts = state.contacts
    history.outputs[:, column] = matrices.outputs @ state.motion
    history.contact_motion[:, column] = contacts.w
    history.contact_force[:, column] = contacts.forces + matrices.stiffness * contacts.w
    for c in range(table.kind.size):
        if table.kind[c] != SLIDERS:
            history.friction_work[table.first_row[c]] += slopes.work[table.first_row[c]]
            for r in range(table.first_row[c], table.first_row[c + 1]):
                if table.friction_first[r + 1] > table.friction_first[r]:
                    direct = state.forces_before[r] + contacts.forces[r]
                    for e in range(table.friction_first[r], table.friction_first[r + 1]):
                        if table.stiffness[e] > 0.0:
                            direct -= before.intercept[e] + contacts.intercept[e]
                    history.friction_work[r] += 0.5 * direct * (contacts.w[r] - before.w[r])
            continue
        for r in range(table.first_row[c], table.first_row[c + 1]):
            for e in range(table.friction_first[r], table.friction_first[r + 1]):
                slid = abs(contacts.intercept[e] - before.intercept[e]) / table.stiffness[e]
                history.friction_work[r] += 0.5 * (contacts.limit[e] + before.limit[e]) * slid
