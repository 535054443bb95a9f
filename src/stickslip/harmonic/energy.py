"""Energy over one period of a solution: input, viscous and contact work, loss factor, and the two numbers that check them.

The work of a force F along a displacement X per period is π Σ h Im(F_h conj X_h) = π Σ h (F_a X_b − F_b X_a) in real storage.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.checks import Array, Index
from stickslip.harmonic.balance import Evaluation, HarmonicBalance
from stickslip.harmonic.cycle import ContactCycle


def cycle_work(force: Array, motion: Array) -> Array:
    """Work per period of forces along motions, both (..., 2H+1): (...), J."""
    order = np.arange(1, (force.shape[-1] + 1) // 2)
    crossed = force[..., 1::2] * motion[..., 2::2] - force[..., 2::2] * motion[..., 1::2]
    return np.asarray(np.pi * np.sum(order * crossed, axis=-1))


@dataclass(frozen=True)
class Energy:
    """Energy of one solved point. dissipated (rows,): contact work of each row, J.

    Contact work is that of λ̂ = F − K_c w, since springs do no net work: a stuck contact dissipates exactly nothing.
    loss_factor = (W_contact + W_viscous)/(2π U), U the largest ½ q̃ᵀ(K + BᵀK_cB) q̃ over the period, q̃ = q minus its mean.
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
        self.stiffness = problem.stuck_stiffness
        self.damping = problem.C
        self.static = problem.load(balance.harmonics, 0.0)
        self.dynamic = problem.load(balance.harmonics, 1.0) - self.static
        self.loaded: Index = np.flatnonzero(np.any(self.dynamic != 0.0, axis=1))

    def at(self, evaluation: Evaluation, cycle: ContactCycle) -> Energy:
        """Energies of one solved point."""
        balance, point = self.balance, evaluation.point
        q = balance.linear.whole_motion(point.forces, point.omega, point.level)
        beyond_springs = evaluation.point.forces - evaluation.residual
        dissipated = cycle_work(beyond_springs, evaluation.w[: balance.rows])
        contact = float(dissipated.sum())
        given = float(cycle_work(point.level * self.dynamic[self.loaded], q[self.loaded]).sum())
        order = np.repeat(np.arange(1, balance.harmonics + 1), 2)
        viscous = float(np.pi * point.omega * np.sum(order**2 * np.einsum("ih,ih->h", q[:, 1:], self.damping @ q[:, 1:])))
        slipped = float(cycle.slip_work.sum())
        scale = max(abs(given), np.finfo(float).tiny)
        return Energy(
            dissipated,
            (contact + viscous) / (2.0 * np.pi * self._largest_potential(q)),
            abs(given - viscous - contact) / scale,
            abs(slipped - contact) / scale,
        )

    def _largest_potential(self, q: Array) -> float:
        """max over the period of ½ q̃ᵀ(K + BᵀK_cB) q̃, J."""
        moving = q[:, 1:]
        form = moving.T @ (self.stiffness @ moving)
        E = self.balance.tables.E[:, 1:]
        return 0.5 * float(np.max(np.einsum("ni,ij,nj->n", E, form, E)))
