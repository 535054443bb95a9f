"""Energy over one period of a solution: input, viscous and contact work, loss factor, and the two numbers that check them.

The work of a force F along a displacement X per period is π Σ h Im(F_h conj X_h) = π Σ h (F_a X_b − F_b X_a) in real storage.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.balance.fourier import complex_harmonics, real_harmonics
from stickslip.support.checks import Array, Index


def cycle_work(force: Array, motion: Array) -> Array:
    """Work per period of forces along motions, both (..., 2H+1): (...), J."""
    order = np.arange(1, (force.shape[-1] + 1) // 2)
    crossed = force[..., 1::2] * motion[..., 2::2] - force[..., 2::2] * motion[..., 1::2]
    return np.asarray(np.pi * np.sum(order * crossed, axis=-1))


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

    def loss_factor_slopes(self, evaluation: Evaluation, forces: Array, motion: Array) -> Array:
        """dη for changes of λ (k, rows, 2H+1) and w (k, motion rows, 2H+1) between solutions, (k,)."""
        balance, point = self.balance, evaluation.point
        rows, order = balance.rows, np.repeat(np.arange(1, balance.highest + 1), 2)
        q, omega = balance.linear.whole_motion(point.forces, point.omega, point.level)[None], np.array([point.omega])
        potential, instant, stress = self._potential(q, omega)
        potential_weight = self._potential_weight(int(instant[0]), stress[0])
        viscous_weight = 2.0 * np.pi * point.omega * order**2 * self._damped(q)[0]
        work = float(cycle_work(point.forces, evaluation.w[:rows]).sum())
        work += 0.5 * float(np.sum(viscous_weight * q[0, :, 1:]))
        slopes = np.empty(len(forces))
        for k, change in enumerate(forces):
            dq = balance.linear.whole_change(change, point.omega)[:, 1:]
            work_slope = float(cycle_work(change, evaluation.w[:rows]).sum() + cycle_work(point.forces, motion[k, :rows]).sum())
            work_slope += float(np.sum(viscous_weight * dq))
            slopes[k] = work_slope - work * float(np.sum(potential_weight * dq)) / potential[0]
        slopes /= 2.0 * np.pi * self._cycles(self._excitation(point)[None], q) * potential
        return slopes

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
