"""Energies of a nonlinear mode over one period, and what a synthesis of forced responses needs of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.solve.balance.balance import Evaluation
from stickslip.solve.balance.energy import cycle_work
from stickslip.solve.balance.mode_balance import ModeBalance
from stickslip.support.checks import Array


@dataclass(frozen=True)
class ModeEnergy:
    """Energies of one point, J, and where they are.

    mechanical: twice the mean kinetic energy, Σ ½ (hω)² Q_hᴴ M Q_h, of a linear mode its mechanical energy; dissipated (rows,):
    contact work of each row per period; viscous: that of C; residual: |dissipated + viscous − fed| over the
    larger of |fed| and dissipated, fed by −2ζωM.
    modal_mass, modal_damping: Q₁ᴴ M Q₁ [kg m²] and Q₁ᴴ C Q₁ of the first harmonic.
    others: share of the first harmonic's energy in the stuck modes beside the followed one; harmonics: share of the energy in
    the harmonics above the first; strongest: the harmonic and the stuck mode, from 1 on, with most of it, whose share is
    `resonant`.
    """

    mechanical: float
    dissipated: Array
    viscous: float
    residual: float
    modal_mass: float
    modal_damping: float
    others: float
    harmonics: float
    strongest: tuple[int, int]
    resonant: float


def mode_energy(balance: ModeBalance, evaluation: Evaluation) -> ModeEnergy:
    """Energies of a solved point."""
    point, structures = evaluation.point, balance.structures
    omega, zeta = balance.omega_of(point), balance.damping_of(point)
    state, order = balance.modal_coordinates(evaluation), np.arange(balance.highest + 1)
    squares, viscous = np.zeros(state.shape), np.zeros(order.size)
    for h in order[structures.key >= 0]:
        k = structures.key[h]
        squares[:, h] = structures.squares[k] * np.abs(state[:, h]) ** 2
        damping, x = structures.damping[k], state[:, h]
        product = damping[0] * x if damping.shape[0] == 1 else damping @ x
        viscous[h] = float(np.real(np.vdot(x, product)))
    fed_by = (order > 0) & (order <= balance.mode_system.structure.extended)
    shares = 0.5 * (order * omega) ** 2 * squares
    fed = 2.0 * np.pi * zeta * omega**2 * float(np.sum(fed_by * order**2 * squares))
    beyond_springs = (point.forces - evaluation.residual)[: balance.rows]
    dissipated = cycle_work(beyond_springs, evaluation.w[: balance.rows])
    lost = np.pi * omega * float(np.sum(order**2 * viscous))
    scale = max(abs(fed), float(dissipated.sum()), np.finfo(float).tiny)
    total, first = float(shares.sum()), float(shares[:, 1].sum())
    above = np.where(order > 1, shares, 0.0) / total
    mode, harmonic = np.unravel_index(int(np.argmax(above)), above.shape)
    return ModeEnergy(
        mechanical=total,
        dissipated=dissipated,
        viscous=lost,
        residual=abs(float(dissipated.sum()) + lost - fed) / scale,
        modal_mass=float(squares[:, 1].sum()),
        modal_damping=float(viscous[1]),
        others=1.0 - float(shares[balance.followed, 1]) / first,
        harmonics=float(above.sum()),
        strongest=(int(harmonic), int(mode) + 1),
        resonant=float(above[mode, harmonic]),
    )
