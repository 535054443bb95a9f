"""Balance of a nonlinear mode: the periodic motion of M q̈ + (C − 2ζωM) q̇ + K q + Bᵀf = static loads at a modal amplitude.

The extended periodic motion concept (M. Krack, Computers and Structures 154, 2015): the negative damping −2ζωM makes the free,
decaying motion periodic. ω and ζ are unknowns beside λ, ln a is the path parameter; the phase is that of the followed stuck mode,
whose coordinate at harmonic 1 is real.

Energies of a nonlinear mode over one period, and what a synthesis of forced responses needs of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stickslip.model.contact.point import contact_table
from stickslip.model.contact.protocol import HELD
from stickslip.model.problem import Problem
from stickslip.model.problem.speed import refuse_speed
from stickslip.model.problem.systems import LinearSystem
from stickslip.solve.balance import newton_parts
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point, constant_size
from stickslip.solve.balance.energy import cycle_work
from stickslip.solve.balance.fourier import (
    Harmonics,
    columns_of,
    fineness,
    fourier,
    harmonics_for,
    highest,
    orders,
    real_harmonics,
)
from stickslip.solve.balance.linear_part import is_diagonal, stuck_modes
from stickslip.solve.balance.mode_iteration import ExtendedStructure, ModeSystem, coordinates_called, coordinates_slope
from stickslip.solve.balance.system import FREE, SMALLER
from stickslip.support.checks import Array, Index, fault

EQUAL = 1e-9
"""Relative difference of squared frequencies up to which two modes are one pair, of which any combination is a mode."""


class ModeBalance(HarmonicBalance):
    """The balance of one nonlinear mode; followed: its place among the stuck modes, from 0 on.

    λ of a `Point` has one more row, that of ω/omega_m and ζ; its `omega` is the stuck natural frequency omega_m, its `level`
    ln of the coordinate of the followed mode in √J, with φᴴK'φ = 1.
    """

    def __init__(
        self, problem: Problem, harmonics: Harmonics | Sequence[int], samples: int, followed: int, extended: int = 1
    ) -> None:
        _, samples = fineness(harmonics, samples)
        refuse_speed(problem, "A nonlinear mode")
        self.problem = problem
        self.harmonics = harmonics_for(problem, harmonics)
        self.highest = highest(self.harmonics)
        self.columns = 2 * self.highest + 1
        held = orders(self.harmonics)
        self.kept = columns_of(held)
        self.dropped = np.setdiff1d(np.arange(self.columns), self.kept)
        self.stiffness = problem.contact_stiffness
        table = contact_table(problem.contacts)
        self.rows, self.followed = table.rows, followed
        self.structures = ModalStructures(problem, held, self.highest)
        self.squares = self.structures.squares[self.structures.key[1]]
        self._refuse_a_pair()
        least = 1e-3 * constant_size(problem, table) + np.finfo(float).tiny
        structure, effort = self.structures.extended(followed, extended), np.zeros(3, dtype=np.int64)
        kept = self.kept, self.dropped
        self.mode_system = ModeSystem(
            table, fourier(self.highest, samples), structure, self.stiffness, *kept, least, effort, FREE, SMALLER
        )
        self.system = self.mode_system  # type: ignore[assignment]
        newton_parts.compile_parts(self.mode_system)

    def _refuse_a_pair(self) -> None:
        if not 0 <= self.followed < self.squares.size or self.squares[self.followed] <= 0.0:
            count = int(np.count_nonzero(self.squares > 0.0))
            raise fault("mode", f"must lie between 1 and {count}, the number of modes with mass", self.followed + 1)
        apart = np.abs(np.delete(self.squares, self.followed) / self.squares[self.followed] - 1.0)
        if np.any(apart < EQUAL):
            raise fault(
                "mode",
                "must have a frequency of its own",
                f"{self.followed + 1}, one of a pair",
                "Of a disk of equal sectors take the travelling wave of one sector, a `TunedDisk`.",
            )

    @property
    def linear_omega(self) -> float:
        """Natural frequency of the stuck mode, rad/s."""
        return float(1.0 / np.sqrt(self.squares[self.followed]))

    @property
    def linear_damping(self) -> float:
        """Modal damping ratio of the stuck mode, φᴴCφ/(2ω)."""
        damping = self.structures.damping[self.structures.key[1]]
        own = damping[self.followed if damping.shape[0] > 1 else 0, self.followed]
        return float(own.real) * self.linear_omega / 2.0

    @property
    def shape(self) -> NDArray[np.complex128]:
        """The stuck mode at contact rows and outputs, per unit of the mass-normalised coordinate, (motion rows,)."""
        return np.asarray(self.linear_omega * self.structures.shapes[self.structures.key[1]][:, self.followed])

    @property
    def largest_motion(self) -> float:
        """The largest motion of a degree of freedom in the stuck mode, per unit of the mass-normalised coordinate."""
        return float(self.linear_omega * np.max(np.abs(self.structures.whole[self.structures.key[1]][:, self.followed])))

    def level_of(self, amplitude: float) -> float:
        """The path parameter of a mass-normalised modal amplitude in m √kg."""
        return float(np.log(self.linear_omega * amplitude))

    def amplitude_of(self, point: Point) -> float:
        """Modal amplitude a, φᴴMφ = 1, in m √kg."""
        return float(np.exp(point.level)) / self.linear_omega

    def omega_of(self, point: Point) -> float:
        """Frequency of the motion, rad/s."""
        return float(point.omega * point.forces[-1, 1])

    def damping_of(self, point: Point) -> float:
        """Damping ratio of the mode."""
        return float(point.forces[-1, 2])

    def linear_point(self, level: float) -> Point:
        """The stuck mode at an amplitude: λ of all contacts held at their start offsets."""
        forces = np.zeros((self.rows + 1, self.columns))
        forces[self.rows, 1:3] = 1.0, self.linear_damping
        evaluation = self.evaluate(Point(forces, self.linear_omega, level))
        held = np.flatnonzero(evaluation.unknown == HELD)
        forces = forces.copy()
        forces[held] = (evaluation.point.forces - evaluation.residual)[held]
        return Point(forces, self.linear_omega, level)

    def stuck_point(self, omega: float, level: float) -> Point:
        """Where Newton starts without better knowledge."""
        return self.linear_point(level)

    def carried_forces(self, evaluation: Evaluation) -> Array:
        """The contact forces F = λ̂ + K_c w, (rows, 2H+1), N."""
        target = (evaluation.point.forces - evaluation.residual)[: self.rows]
        return np.asarray(target + self.stiffness[:, None] * evaluation.w[: self.rows])

    def modal_coordinates(self, evaluation: Evaluation) -> NDArray[np.complex128]:
        """Coordinates η of the stuck modes, φᴴK'φ = 1, of every harmonic (m, H+1), √J."""
        point, structure = evaluation.point, self.mode_system.structure
        forces = np.ascontiguousarray(point.forces[: self.rows])
        return np.asarray(
            coordinates_called(structure, evaluation.state.gains, forces, self.omega_of(point), float(np.exp(point.level)))
        )

    def coordinates_slope(self, evaluation: Evaluation, forces: Array, rate: float) -> NDArray[np.complex128]:
        """Derivative of the `modal_coordinates` along the curve (m, H+1), for those of the forces of `Point` and of ln a."""
        point, structure = evaluation.point, self.mode_system.structure
        amounts = np.array([point.omega * forces[-1, 1], forces[-1, 2], rate])
        state, own = self.modal_coordinates(evaluation), np.ascontiguousarray(forces[:-1])
        place = self.omega_of(point), self.damping_of(point), float(np.exp(point.level))
        return np.asarray(coordinates_slope(structure, evaluation.state.gains, state, own, amounts, *place))

    def whole_motion(self, evaluation: Evaluation) -> Array:
        """q of every degree of freedom (n, 2H+1), m."""
        state = self.modal_coordinates(evaluation)
        motion = np.zeros((self.problem.structure.size, self.highest + 1), dtype=complex)
        for h in orders(self.harmonics):
            motion[:, h] = self.structures.whole[self.structures.key[h]] @ state[:, h]
        return np.asarray(real_harmonics(motion))


class ModalStructures:
    """Stuck modes of every structure that the harmonics see: squares (keys, m), damping (keys, m or 1, m), static (m,), key
    (H+1,) as in `ExtendedStructure`; shapes at contact rows and outputs (keys, motion rows, m), and whole (keys, n, m)."""

    def __init__(self, problem: Problem, held: Sequence[int], H: int) -> None:
        systems = problem.systems
        numbers = list(dict.fromkeys(systems.key(h) for h in held))
        self.key: Index = np.full(H + 1, -1, dtype=np.int64)
        for h in held:
            self.key[h] = numbers.index(systems.key(h))
        parts = [_modes(systems.at(next(h for h in held if systems.key(h) == number))) for number in numbers]
        self.squares = np.array([part[0] for part in parts])
        self.whole = np.array([part[1] for part in parts])
        self.shapes = np.array([part[2] for part in parts])
        self.damping = _damping([part[3] for part in parts], self.key[1:])
        self.outputs = len(problem.outputs)
        mean = self.whole[self.key[0]] if self.key[0] >= 0 else np.zeros_like(self.whole[0])
        self.static = np.asarray(mean.conj().T @ problem.static_load, dtype=complex)

    def extended(self, followed: int, extended: int) -> ExtendedStructure:
        """As the kernels read it."""
        imaginary = self.shapes.imag if np.any(self.shapes.imag) else np.empty((0, 0, 0))
        parts = (np.ascontiguousarray(self.shapes.real), np.ascontiguousarray(imaginary), self.squares)
        return ExtendedStructure(
            *parts, np.ascontiguousarray(self.damping, dtype=complex), self.static, self.key, followed, extended
        )


def _modes(system: LinearSystem) -> tuple[Array, Array, Array, Array]:
    """Squares (m,), shapes of the whole (n, m), of motion rows (rows, m), and φᴴCφ (m, m)."""
    modes = stuck_modes(system.M, system.K)
    shapes = np.asarray(modes.shapes)
    return modes.inverse_squares, shapes, np.vstack([system.B, system.outputs]) @ shapes, shapes.conj().T @ system.C @ shapes


def _damping(matrices: Sequence[Array], used: Index) -> Array:
    """Modal damping of each structure, (keys, m, m); its diagonal (keys, 1, m) where those that vibrate are uncoupled."""
    coupled = any(not is_diagonal(matrices[k]) for k in set(used[used >= 0].tolist()))
    return np.array(matrices) if coupled else np.array([np.diag(matrix)[None] for matrix in matrices])


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
