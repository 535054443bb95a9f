"""Energy over one period of a solution: input, viscous and contact work, loss factor, and the two numbers that check them.

The work of a force F along a displacement X per period is π Σ h Im(F_h conj X_h) = π Σ h (F_a X_b − F_b X_a) in real storage.

One steady period of every contact, sample by sample: motion, force, state and slip work, for results only.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.model.contact.law import SLIDERS
from stickslip.model.contact.point import ContactTable, contact_data
from stickslip.model.contact.protocol import OPEN, SLIP, STICK, PeriodMotion, friction_period, law_period, no_forces
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.balance.contact_forces import element_limits
from stickslip.solve.balance.fourier import Fourier, complex_harmonics, real_harmonics
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import inlined, inner, kernel


def cycle_work(force: Array, motion: Array) -> Array:
    """Work per period of forces along motions, both (..., 2H+1): (...), J."""
    order = np.arange(1, (force.shape[-1] + 1) // 2)
    crossed = force[..., 1::2] * motion[..., 2::2] - force[..., 2::2] * motion[..., 1::2]
    return np.asarray(np.pi * np.sum(order * crossed, axis=-1))


def work_weights(motion: Array) -> Array:
    """Derivatives of `cycle_work` by the forces (..., 2H+1); those by the motion are −`work_weights(force)`."""
    weights = np.zeros_like(motion)
    order = np.pi * np.arange(1, (motion.shape[-1] + 1) // 2)
    weights[..., 1::2], weights[..., 2::2] = order * motion[..., 2::2], -order * motion[..., 1::2]
    return weights


@dataclass(frozen=True)
class Energy:
    """Energies of solved points, (points,) each; dissipated (points, rows): contact work of each row, J.

    Contact work is that of λ̂ = F − K_c w, since springs do no net work: a stuck contact dissipates exactly nothing.
    loss_factor = (W_contact + W_viscous)/(2π h U) with the work per period, h the excited harmonic that the load does most work
    on (the period holds h cycles of that vibration), U the largest ½ q̃ᵀ(K + BᵀK_cB) q̃ over the period, q̃ = q minus its mean.
    energy_residual = |input − viscous − contact|/|input|: consistency of the solution.
    """

    dissipated: Array
    loss_factor: Array
    energy_residual: Array
    input: Array
    contact: Array

    def slip_work_error(self, slip_work: Array) -> Array:
        """|Σ μN|Δs| − contact|/|input| from the work of friction of all rows (points,): the physics, of second order in the
        samples. Relative to the input: where a slip lasts only a few samples, its own work is too small to be a scale.
        """
        return np.asarray(np.abs(slip_work - self.contact) / _scale(self.input))


def _scale(given: Array) -> Array:
    """The input that errors are relative to, J."""
    return np.maximum(np.abs(given), np.finfo(float).tiny)


class EnergyBalance:
    """What the energies of a problem need, prepared once."""

    def __init__(self, balance: HarmonicBalance) -> None:
        problem = balance.problem
        self.balance = balance
        self.problem = problem
        self.systems = {problem.systems.key(h): problem.systems.at(h) for h in range(1, balance.highest + 1)}
        self.powers = problem.load_powers(balance.highest)
        self.loaded: Index = np.flatnonzero(np.any(self.powers != 0.0, axis=(0, 2)))
        excited = np.any(self.powers[..., 1:].reshape(*self.powers.shape[:2], -1, 2) != 0.0, axis=(0, 1, 3))
        self.excited: Index = np.flatnonzero(excited) + 1

    def along(self, evaluations: Sequence[Evaluation]) -> Energy:
        """Energies of solved points."""
        balance, linear, points = self.balance, self.balance.linear, [each.point for each in evaluations]
        q = np.array([linear.whole_motion(each.forces, each.omega, each.level) for each in points])
        beyond_springs = np.array([each.point.forces - each.residual for each in evaluations])
        dissipated = cycle_work(beyond_springs, np.array([each.w[: balance.rows] for each in evaluations]))
        contact = dissipated.sum(axis=1)
        excitation = np.array([self._excitation(each) for each in points])
        given = cycle_work(excitation, q[:, self.loaded]).sum(axis=1)
        order, omega = np.repeat(np.arange(1, balance.highest + 1), 2), np.array([each.omega for each in points])
        viscous = np.pi * omega * np.einsum("h,pih,pih->p", order**2, q[..., 1:], self._damped(q))
        potential = self._potential(q, omega)[0]
        return Energy(
            dissipated / balance.periods,
            (contact + viscous) / (2.0 * np.pi * self._cycles(excitation, q) * potential),
            np.abs(given - viscous - contact) / _scale(given),
            given,
            contact,
        )

    def loss_factor(self, evaluation: Evaluation) -> float:
        """The loss factor of one solved point."""
        return float(self.along([evaluation]).loss_factor[0])

    def loss_factor_weights(self, evaluation: Evaluation) -> tuple[Array, Array]:
        """Weights of changes of λ (rows, 2H+1) and w (motion rows, 2H+1) between solutions, whose sum is dη."""
        balance, point = self.balance, evaluation.point
        rows, order = balance.rows, np.repeat(np.arange(1, balance.highest + 1), 2)
        q, omega = balance.linear.whole_motion(point.forces, point.omega, point.level)[None], np.array([point.omega])
        potential, instant, stress = self._potential(q, omega)
        viscous_weight = 2.0 * np.pi * point.omega * order**2 * self._damped(q)[0]
        work = float(cycle_work(point.forces, evaluation.w[:rows]).sum())
        work += 0.5 * float(np.sum(viscous_weight * q[0, :, 1:]))
        of_q = np.zeros(q.shape[1:])
        of_q[:, 1:] = viscous_weight - work / potential[0] * self._potential_weight(int(instant[0]), stress[0])
        of_forces = work_weights(evaluation.w[:rows]) + balance.linear.weights_of_whole_change(of_q, point.omega)
        of_motion = np.zeros_like(evaluation.w)
        of_motion[:rows] = -work_weights(point.forces)
        scale = 1.0 / (2.0 * np.pi * self._cycles(self._excitation(point)[None], q)[0] * potential[0])
        return scale * of_forces, scale * of_motion

    def _cycles(self, excitation: Array, q: Array) -> Index:
        """Cycles of the vibration in the period of the balance (points,): the order of the excited harmonic with most work of the
        load."""
        if self.excited.size < 2:
            return np.full(len(q), self.excited[0] if self.excited.size else self.balance.periods)
        force, motion = complex_harmonics(excitation), complex_harmonics(q[:, self.loaded])
        work = self.excited * np.sum(force * motion.conj(), axis=1).imag[:, self.excited]
        return np.asarray(self.excited[np.argmax(np.abs(work), axis=1)])

    def _excitation(self, point: Point) -> Array:
        """The harmonic loads of the loaded degrees of freedom, (loaded, 2H+1), N."""
        weights = point.level * point.omega ** np.arange(len(self.powers))
        return np.asarray(np.einsum("k,knh->nh", weights, self.powers[:, self.loaded]))

    def _damped(self, q: Array) -> Array:
        """C of each harmonic's structure times its motion q (points, n, 2H+1), without the mean: (points, n, 2H)."""
        return self._applied(lambda h: self.systems[self.problem.systems.key(h)].C, q)

    def _stress(self, q: Array, omega: Array) -> Array:
        """K' = K + BᵀK_cB, at the speed of each frequency, times the motion q, without the mean: (points, n, 2H)."""
        systems, own = self.problem.systems, self.systems
        stress = self._applied(lambda h: own[systems.key(h)].K, q)
        if not systems.stiffens:
            return stress
        softened = self._applied(lambda h: h**2 * (systems.mass(h) - own[systems.key(h)].M), q)
        return np.asarray(stress + omega[:, None, None] ** 2 * softened)

    def _applied(self, matrix: Callable[[int], NDArray[Any]], q: Array) -> Array:
        """A matrix by harmonic times the motion q (points, n, 2H+1), without the mean: (points, n, 2H)."""
        if self.problem.systems.alike:
            return np.asarray(matrix(1) @ q[..., 1:])
        motion = complex_harmonics(q)
        motion[..., 0] = 0.0
        for h in range(1, motion.shape[-1]):
            motion[..., h] = motion[..., h] @ matrix(h).T
        return real_harmonics(motion)[..., 1:]

    def _potential(self, q: Array, omega: Array) -> tuple[Array, Index, Array]:
        """U = max over the period of ½ q̃ᵀK'q̃ (points,), J, the sample of that instant, and K'q̃ (points, n, 2H).

        On a tuned disk it is the energy of the whole disk over its sectors, whose motions are q̃ delayed step by step.
        """
        stress, E = self._stress(q, omega), self.balance.tables.E[:, 1:]
        energies = 0.5 * np.sum((E @ (q[..., 1:].swapaxes(1, 2) @ stress)) * E, axis=2)
        energies = energies.reshape(len(q), self.problem.systems.repeats, -1).mean(axis=1)
        return energies.max(axis=1), np.argmax(energies, axis=1), stress

    def _potential_weight(self, instant: int, stress: Array) -> Array:
        """The derivative of U by the harmonics of q̃ (n, 2H) of one point, from its instant and K'q̃."""
        E, repeats = self.balance.tables.E, self.problem.systems.repeats
        rows = E[instant :: len(E) // repeats, 1:]
        return np.asarray(stress @ (rows.T @ rows) / repeats)


@dataclass(frozen=True, eq=False)
class ContactCycle:
    """Samples over one period of every row: displacement [m], force [N], state (STICK, SLIP or OPEN), each (rows, Nt).

    slip_work (rows,): work of friction over the period, of sliders Σ μN |Δs|, J; a friction disc has it on its first row.
    slider (elements,): where the slider of each friction element stands at the last sample, s = u − T/kt, m; mean_slider: its
    mean over the period. Zero without a spring kt. intercept (elements,): T − kt u there, N, or a further state.
    """

    displacement: Array
    force: Array
    state: Index
    slip_work: Array
    slider: Array
    mean_slider: Array
    intercept: Array

    def shares(self) -> Array:
        """Shares of the period in stick, slip and without contact, (3, rows). A closed normal direction counts as stick."""
        return np.asarray(np.mean(self.state == np.array([STICK, SLIP, OPEN])[:, None, None], axis=2))


def contact_cycle(table: ContactTable, tables: Fourier, w: Array, omega: float) -> ContactCycle:
    """The period of every contact for motion w (rows, 2H+1) [m] at omega [rad/s]."""
    rows, samples = table.rows, tables.E.shape[0]
    displacement = np.ascontiguousarray(w[:rows] @ tables.E.T)
    velocity = np.ascontiguousarray(omega * (w[:rows] @ tables.D.T))
    force, state = np.zeros((rows, samples)), np.zeros((rows, samples), dtype=np.int64)
    slip_work, intercept = np.zeros(rows), np.zeros((2, table.stiffness.size))
    _fill_cycle(table, displacement, velocity, omega, np.ascontiguousarray(w[:rows, 0]), force, state, slip_work, intercept)
    slider = np.divide(-intercept, table.stiffness, out=np.zeros_like(intercept), where=table.stiffness > 0.0)
    return ContactCycle(displacement, force, state, slip_work, slider[0], slider[1], intercept[0])


def forces_of_motion(table: ContactTable, displacement: Array, omega: float) -> Array:
    """Steady forces (rows, Nt) [N] under a prescribed period of motion (rows, Nt) [m] at omega [rad/s]; velocities by central
    differences."""
    displacement = np.ascontiguousarray(displacement)
    step = 2.0 * np.pi / (omega * displacement.shape[1])
    velocity = (np.roll(displacement, -1, axis=1) - np.roll(displacement, 1, axis=1)) / (2.0 * step)
    force, state = np.zeros(displacement.shape), np.zeros(displacement.shape, dtype=np.int64)
    slip_work, intercept = np.zeros(table.rows), np.zeros((2, table.stiffness.size))
    _fill_cycle(table, displacement, velocity, omega, displacement.mean(axis=1), force, state, slip_work, intercept)
    return force


@kernel
def _fill_cycle(
    table: ContactTable,
    displacement: Array,
    velocity: Array,
    omega: float,
    mean: Array,
    force: Array,
    state: Index,
    slip_work: Array,
    intercept: Array,
) -> None:
    """intercept (2, elements): at the last sample, and the mean."""
    samples = displacement.shape[1]
    limit, slope, landing, y = np.empty(samples), np.empty(samples), np.empty(samples), np.empty(samples)
    event, none = np.empty(samples, dtype=np.int64), np.zeros(samples)
    for c in range(table.normal_row.size):
        first, last = table.normal_first[c], table.normal_first[c + 1]
        loads, slopes = np.zeros((max(last - first, 1), samples)), np.zeros((max(last - first, 1), samples))
        row = table.normal_row[c]
        for e in range(first, last):
            for n in range(samples):
                loads[e - first, n] = max(table.normal_stiffness[e] * displacement[row, n] + table.normal_constant[e], 0.0)
                slopes[e - first, n] = table.normal_stiffness[e] if loads[e - first, n] > 0.0 else 0.0
                force[row, n] += loads[e - first, n]
        if row >= 0:
            for n in range(samples):
                state[row, n] = STICK if force[row, n] > 0.0 else OPEN
        z = displacement[row] if row >= 0 else none
        if table.kind[c] != SLIDERS:
            _fill_law(table, c, displacement, velocity, z, omega, loads, slopes, force, state, slip_work, intercept)
            continue
        for r in range(table.first_row[c], table.first_row[c + 1]):
            if r == row:
                continue
            state[r, :] = OPEN
            for e in range(table.friction_first[r], table.friction_first[r + 1]):
                kt = table.stiffness[e]
                element_limits(table, e, first, z, loads, slopes, limit, slope, landing)
                ku = kt * displacement[r]
                kind, value = table.start_kind[e], table.start_value[e]
                friction_period(kind, value, kt, ku, limit, landing, kt * mean[r], y, event)
                force[r] += y + ku
                slip_work[r] += _slip_work(kt, y, limit)
                intercept[0, e], intercept[1, e] = y[-1], np.mean(y)
                for n in range(samples):
                    if event[n] != OPEN and state[r, n] != SLIP:
                        state[r, n] = STICK if event[n] == STICK else SLIP


@inlined
def _fill_law(
    table: ContactTable,
    c: int,
    displacement: Array,
    velocity: Array,
    z: Array,
    omega: float,
    loads: Array,
    slopes: Array,
    force: Array,
    state: Index,
    slip_work: Array,
    intercept: Array,
) -> None:
    """The tangential rows of contact c by the kernel of its law."""
    first, samples, data = table.first_row[c], displacement.shape[1], contact_data(table, c)
    last = first + data.kt.size
    limit, slope, landing, none = np.zeros(samples), np.zeros(samples), np.zeros(samples), np.empty((samples, 0))
    e = table.friction_first[first]
    if table.friction_first[first + 1] > e:
        element_limits(table, e, table.normal_first[c], z, loads, slopes, limit, slope, landing)
    found = no_forces(data, samples, 0)
    motion = PeriodMotion(displacement[first:last], velocity[first:last], z, limit, slope, landing, omega, none, none)
    law_period(table.kind[c], data, motion, found)
    for d in range(data.kt.size):
        kt, y = data.kt[d], found.y[d]
        for n in range(samples):
            force[first + d, n] = y[n] + kt * displacement[first + d, n]
            state[first + d, n] = found.event[n]
        slip_work[first + d] = found.work[d]
    for i in range(data.spring.size):
        intercept[0, e + i], intercept[1, e + i] = found.intercept[i, -1], np.mean(found.intercept[i])


@inner
def _slip_work(kt: float, y: Array, limit: Array) -> float:
    """Σ L |Δs| of one element, s = −y/kt the slider; L taken at the middle of each step."""
    work = 0.0
    for n in range(y.size):
        work += 0.5 * (limit[n] + limit[n - 1]) * abs(y[n] - y[n - 1]) / kt
    return work


def friction_limits(table: ContactTable, tables: Fourier, w: Array) -> Iterator[tuple[int, int, Array, Array, Array]]:
    """For motion w, element by element: friction element, its row, displacement u, limit L and `landing_shares`, each (Nt,)."""
    samples = tables.E.shape[0]
    z = np.zeros(samples)
    for c in range(table.normal_row.size):
        first, last = table.normal_first[c], table.normal_first[c + 1]
        loads, slopes = np.zeros((max(last - first, 1), samples)), np.zeros((max(last - first, 1), samples))
        if last > first:
            z = tables.E @ w[table.normal_row[c]]
            loads = np.maximum(table.normal_stiffness[first:last, None] * z + table.normal_constant[first:last, None], 0.0)
            slopes = np.where(loads > 0.0, table.normal_stiffness[first:last, None], 0.0)
        for r in range(table.first_row[c], table.first_row[c + 1]):
            u = tables.E @ w[r]
            for e in range(table.friction_first[r], table.friction_first[r + 1]):
                limit, slope, landing = np.empty(samples), np.empty(samples), np.empty(samples)
                element_limits(table, e, first, z, loads, slopes, limit, slope, landing)
                yield e, r, u, limit, landing


def friction_reach(table: ContactTable, tables: Fourier, w: Array) -> tuple[Array, Array]:
    """For each friction element, over the period of motion w: max|u| + max L/kt [m], 0 without a spring kt, and max L [N]."""
    reach, largest = np.zeros(table.stiffness.size), np.zeros(table.stiffness.size)
    for e, _, u, limit, _ in friction_limits(table, tables, w):
        largest[e] = limit.max()
        if table.stiffness[e] > 0.0:
            reach[e] = np.abs(u).max() + limit.max() / table.stiffness[e]
    return reach, largest
