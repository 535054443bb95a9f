"""Energy over one period of a solution: input, viscous and contact work, loss factor, and the two numbers that check them.

The work of a force F along a displacement X per period is π Σ h Im(F_h conj X_h) = π Σ h (F_a X_b − F_b X_a) in real storage.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.balance.cycle import ContactCycle
from stickslip.solve.balance.fourier import complex_harmonics, real_harmonics
from stickslip.support.checks import Array, Index


def cycle_work(force: Array, motion: Array) -> Array:
    """Work per period of forces along motions, both (..., 2H+1): (...), J."""
    order = np.arange(1, (force.shape[-1] + 1) // 2)
    crossed = force[..., 1::2] * motion[..., 2::2] - force[..., 2::2] * motion[..., 1::2]
    return np.asarray(np.pi * np.sum(order * crossed, axis=-1))


@dataclass(frozen=True)
class Energy:
    """Energy of one solved point. dissipated (rows,): contact work of each row, J.

    Contact work is that of λ̂ = F − K_c w, since springs do no net work: a stuck contact dissipates exactly nothing.
    loss_factor = (W_contact + W_viscous)/(2π h U) with the work per period, h the excited harmonic that the load does most work
    on (the period holds h cycles of that vibration), U the largest ½ q̃ᵀ(K + BᵀK_cB) q̃ over the period, q̃ = q minus its mean.
    energy_residual = |input − viscous − contact|/|input|: consistency of the solution.
    slip_work_error = |Σ μN|Δs| − contact|/|input|: the physics, of second order in the samples. Both are relative to the input:
    where a slip lasts only a few samples, its own work is too small to be a scale.
    """

    dissipated: Array
    loss_factor: float
    energy_residual: float
    slip_work_error: float


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

    def at(self, evaluation: Evaluation, cycle: ContactCycle) -> Energy:
        """Energies of one solved point."""
        balance, point = self.balance, evaluation.point
        q = balance.linear.whole_motion(point.forces, point.omega, point.level)
        beyond_springs = evaluation.point.forces - evaluation.residual
        dissipated = cycle_work(beyond_springs, evaluation.w[: balance.rows])
        contact = float(dissipated.sum())
        excitation = self._excitation(point)
        given = float(cycle_work(excitation, q[self.loaded]).sum())
        order = np.repeat(np.arange(1, balance.highest + 1), 2)
        viscous = float(np.pi * point.omega * np.sum(order**2 * np.einsum("ih,ih->h", q[:, 1:], self._damped(q))))
        slipped = float(cycle.slip_work.sum())
        scale = max(abs(given), np.finfo(float).tiny)
        return Energy(
            dissipated / balance.periods,
            (contact + viscous) / (2.0 * np.pi * self._cycles(excitation, q) * self._potential(q, point.omega)[0]),
            abs(given - viscous - contact) / scale,
            abs(slipped - contact) / scale,
        )

    def loss_factor_slopes(self, evaluation: Evaluation, forces: Array, motion: Array) -> Array:
        """dη for changes of λ (k, rows, 2H+1) and w (k, motion rows, 2H+1) between solutions, (k,)."""
        balance, point = self.balance, evaluation.point
        rows, order = balance.rows, np.repeat(np.arange(1, balance.highest + 1), 2)
        q = balance.linear.whole_motion(point.forces, point.omega, point.level)
        potential, potential_weight = self._potential(q, point.omega)
        viscous_weight = 2.0 * np.pi * point.omega * order**2 * self._damped(q)
        work = float(cycle_work(point.forces, evaluation.w[:rows]).sum())
        work += 0.5 * float(np.sum(viscous_weight * q[:, 1:]))
        slopes = np.empty(len(forces))
        for k, change in enumerate(forces):
            dq = balance.linear.whole_change(change, point.omega)[:, 1:]
            work_slope = float(cycle_work(change, evaluation.w[:rows]).sum() + cycle_work(point.forces, motion[k, :rows]).sum())
            work_slope += float(np.sum(viscous_weight * dq))
            slopes[k] = work_slope - work * float(np.sum(potential_weight * dq)) / potential
        slopes /= 2.0 * np.pi * self._cycles(self._excitation(point), q) * potential
        return slopes

    def _cycles(self, excitation: Array, q: Array) -> int:
        """Cycles of the vibration in the period of the balance: the order of the excited harmonic with most work of the load."""
        if self.excited.size < 2:
            return int(self.excited[0]) if self.excited.size else self.balance.periods
        force, motion = complex_harmonics(excitation), complex_harmonics(q[self.loaded])
        work = self.excited * np.sum(force * motion.conj(), axis=0).imag[self.excited]
        return int(self.excited[np.argmax(np.abs(work))])

    def _excitation(self, point: Point) -> Array:
        """The harmonic loads of the loaded degrees of freedom, (loaded, 2H+1), N."""
        weights = point.level * point.omega ** np.arange(len(self.powers))
        return np.asarray(np.einsum("k,knh->nh", weights, self.powers[:, self.loaded]))

    def _damped(self, q: Array) -> Array:
        """C of each harmonic's structure times its motion q (n, 2H+1), without the mean: (n, 2H)."""
        return self._applied(lambda h: self.systems[self.problem.systems.key(h)].C, q)

    def _elastic(self, harmonic: int, omega: float) -> NDArray[Any]:
        """K + BᵀK_cB of a harmonic, at the speed of a frequency."""
        systems, key = self.problem.systems, self.problem.systems.key(harmonic)
        stiffness = self.systems[key].K
        if not systems.stiffens:
            return stiffness
        return np.asarray(stiffness + (harmonic * omega) ** 2 * (systems.mass(harmonic) - self.systems[key].M))

    def _applied(self, matrix: Callable[[int], NDArray[Any]], q: Array) -> Array:
        """A matrix by harmonic times the motion q (n, 2H+1), without the mean: (n, 2H)."""
        if self.problem.systems.alike:
            return np.asarray(matrix(1) @ q[:, 1:])
        motion = complex_harmonics(q)
        motion[:, 0] = 0.0
        for h in range(1, motion.shape[1]):
            motion[:, h] = matrix(h) @ motion[:, h]
        return real_harmonics(motion)[:, 1:]

    def _potential(self, q: Array, omega: float) -> tuple[float, Array]:
        """U = max over the period of ½ q̃ᵀK'q̃ [J] and its derivative by the harmonics of q̃, (n, 2H), K' = K + BᵀK_cB.

        On a tuned disk it is the energy of the whole disk over its sectors, whose motions are q̃ delayed step by step.
        """
        systems = self.problem.systems
        moving = q[:, 1:]
        stress = self._applied(lambda h: self._elastic(h, omega), q)
        E, repeats = self.balance.tables.E[:, 1:], systems.repeats
        energies = 0.5 * np.sum((E @ (moving.T @ stress)) * E, axis=1)
        spectrum = np.fft.rfft(energies)
        spectrum[np.arange(spectrum.size) % repeats != 0] = 0.0
        averaged = np.fft.irfft(spectrum, energies.size) if repeats > 1 else energies
        instant = int(np.argmax(averaged))
        angles = 2.0 * np.pi * (instant / energies.size + np.arange(repeats) / repeats)
        order = np.arange(1, self.balance.highest + 1)
        rows = np.stack([np.cos(np.outer(angles, order)), np.sin(np.outer(angles, order))], axis=2).reshape(repeats, -1)
        return float(averaged[instant]), np.asarray(stress @ (rows.T @ rows) / repeats)
