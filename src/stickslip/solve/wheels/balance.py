"""The balance of one mistuned wheel on the forces of its contacts: λ − λ̂(w) on few shapes of each sector.

The forces of a `Point` are μ (N r, 2H+1) and its motions z and the outputs (N r + N outputs, 2H+1), so that continuation and
searches of peaks take a wheel as they take any other balance. The contact laws see the contacts themselves, √K_c w = U z, and
λ̂ of each sector is brought back to its shapes. K_c is that of the tuned disk: where contacts have springs K_c + ΔK of their own,
λ̂ = F − K_c w = (F − (K_c + ΔK) w) + ΔK w, of which their table gives the first part.

Newton's systems of a wheel: GMRES with a preconditioner of one block a sector and the resonant modes.

J = I + D R with D = ∂λ̂/∂z block diagonal by sector, R the receptance. M has of R what a sector does to itself and the modes of
the wheel that resonate, Σ P_k g_k P_kᵀ: blocks I + D R_own, and a small system (Woodbury's formula). Neighbours beyond these
modes hardly couple, so that GMRES takes five products to 1e-3, each of which meets the path condition exactly. D and M are kept
in single precision: neither is in the residual.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.contact.point import Contact, ContactTable, contact_table, stuck_stiffness
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Parameter, PathCondition, Point
from stickslip.solve.balance.contact_forces import compile_contact_forces, contact_answer
from stickslip.solve.balance.fourier import Fourier, complex_harmonics, fourier, real_harmonics
from stickslip.solve.balance.resonances import Limit, Resonances, contacts_and_outputs
from stickslip.solve.balance.system import Direction, State
from stickslip.solve.wheels.tuned import NEAR, Complex, Shapes, TunedWheel
from stickslip.support.checks import Array, Index

Single = NDArray[np.float32]

MOST = 60
"""Most products of GMRES."""


class Change(NamedTuple):
    """A change of μ (N r, 2H+1), of the motion (N r + outputs, 2H+1) and of ω."""

    forces: Array
    motion: Array
    omega: float


class Preconditioner(NamedTuple):
    """M⁻¹ v = x − spread (small (Pᵀ x)), x = inverse v; inverse (N, r (2H+1), r (2H+1)), spread (N r (2H+1), k), small (k, k)."""

    inverse: Single
    spread: Single
    small: Single

    @classmethod
    def of(cls, balance: WheelBalance, D: Single, omega: float) -> Preconditioner:
        """D: ∂λ̂/∂z of each sector, (N, r (2H+1), r (2H+1)); ω in rad/s."""
        N, size, r = len(D), D.shape[1], balance.shapes.size
        inverse: Single = np.linalg.inv(np.eye(size, dtype=np.float32) + D @ balance.shapes.block).astype(np.float32)
        by_column = D.reshape(N, size, r, -1)
        pushed = [by_column[..., part] @ shapes.reshape(N, r, -1) for part, shapes in balance.resonant]
        spread: Single = (inverse @ np.concatenate(pushed, axis=2)).reshape(N * size, -1)
        stiffness = []
        for h, near in balance.near:
            own = balance.modes.omega[near]
            real, imaginary = np.diag(own**2 - (h * omega) ** 2), np.diag(2.0 * balance.wheel.ratio * own * h * omega)
            stiffness.append(np.block([[real, imaginary], [-imaginary, real]]))
        columns = spread.reshape(balance.rows, balance.columns, -1)
        met = np.concatenate([shapes.T @ columns[:, part] for part, shapes in balance.resonant])
        return cls(inverse, spread, np.linalg.inv(linalg.block_diag(*stiffness) + met).astype(np.float32))


class WheelFactors:
    """Newton's system of an evaluation with its path condition, ready to be solved; products: of the last solution."""

    def __init__(
        self, balance: WheelBalance, evaluation: Evaluation, condition: PathCondition, D: Single, M: Preconditioner
    ) -> None:
        self.balance, self.evaluation, self.condition, self.D, self.preconditioner = balance, evaluation, condition, D, M
        by_omega, self.products = balance.slope(evaluation.point), 0
        self.along = self._inverted(self._pushed(by_omega) + evaluation.state.by_omega)
        self.moved = by_omega + balance.change(self.along, evaluation.point.omega)
        self.rate = condition.rate(self.moved, 1.0)

    @classmethod
    def of(cls, balance: WheelBalance, evaluation: Evaluation, condition: PathCondition) -> WheelFactors:
        """Those of an evaluation itself."""
        D = balance.derivative(evaluation)
        return cls(balance, evaluation, condition, D, Preconditioner.of(balance, D, evaluation.point.omega))

    def at(self, evaluation: Evaluation) -> WheelFactors:
        """Those of another evaluation, with the same M."""
        return WheelFactors(self.balance, evaluation, self.condition, self.balance.derivative(evaluation), self.preconditioner)

    @property
    def orientation(self) -> float:
        """Sign of the determinant of the system with its path condition, that of J times that of dω as the condition grows; 1
        where the curve goes on as its planes are numbered."""
        balance, (N, size, _) = self.balance, self.D.shape
        if not balance.oriented:
            return 1.0
        pushed = self.D @ balance.receptance(self.evaluation.point.omega).reshape(N, size, -1)
        J = np.eye(N * size, dtype=np.float32) + pushed.reshape(N * size, -1)
        return float(np.linalg.slogdet(J)[0] * np.sign(balance.tangent(self.evaluation, "omega", self).rate))

    @property
    def size(self) -> int:
        """How many contact rows slip or open."""
        return int(np.count_nonzero(self.evaluation.unknown))

    def _pushed(self, motion: Array) -> Array:
        """∂λ̂/∂z dz, (N r, 2H+1)."""
        size = float(np.abs(motion).max()) or 1.0
        z = (motion[: self.balance.rows] / size).astype(np.float32).reshape(*self.D.shape[:2], 1)
        return np.asarray(size * (self.D @ z).reshape(self.balance.rows, -1), dtype=float)

    def _inverted(self, v: Array) -> Array:
        """M⁻¹ v, (N r, 2H+1)."""
        inverse, spread, small = self.preconditioner
        size = float(np.abs(v).max()) or 1.0
        x = (inverse @ (v / size).astype(np.float32).reshape(*inverse.shape[:2], 1)).reshape(v.shape)
        modal = small @ np.concatenate([shapes.T @ x[:, part] for part, shapes in self.balance.resonant])
        return np.asarray(size * (x - (spread @ modal).reshape(v.shape)), dtype=float)

    def estimate(self, v: Array, short: float) -> Change:
        """The solution with M in place of J, of the path condition exactly."""
        x = self._inverted(v)
        dx = self.balance.change(x, self.evaluation.point.omega)
        amount = (short - self.condition.rate(dx, 0.0)) / self.rate
        return Change(x + amount * self.along, dx + amount * self.moved, amount)

    def _applied(self, x: Change) -> Array:
        """J δμ + ∂R/∂ω δω."""
        return np.asarray(x.forces - self._pushed(x.motion) - x.omega * self.evaluation.state.by_omega)

    def solve(self, v: Array, short: float, tolerance: float) -> Change:
        """The change for which J δμ + ∂R/∂ω δω = v to a tolerance, and the path condition changes by `short`.

        The tolerance is relative to the smaller of v and δμ. Near a fold δμ is much larger than v: to a share of it alone no
        step would reduce the residual.
        """
        first = self.estimate(v, short)
        missed = v - self._applied(first)
        size, changed, given = (float(np.linalg.norm(each)) for each in (missed, first.forces, v))
        goal = tolerance * (min(changed, given) if given else changed)
        if not size > goal:
            return first
        basis, found, products = np.empty((MOST + 1, v.size)), [first], np.zeros((MOST + 1, MOST))
        basis[0] = missed.ravel() / size
        for k in range(MOST):
            found.append(self.estimate(basis[k].reshape(v.shape), 0.0))
            following, column = self._applied(found[-1]).ravel(), products[:, k]
            column[: k + 1] = basis[: k + 1] @ following
            following -= column[: k + 1] @ basis[: k + 1]
            column[k + 1] = np.linalg.norm(following)
            basis[k + 1] = following / max(column[k + 1], np.finfo(float).tiny)  # nothing is left where it is solved exactly
            right, matrix = size * np.eye(k + 2)[0], products[: k + 2, : k + 1]
            shares = linalg.lstsq(matrix, right, check_finite=False)[0]
            self.products = k + 1
            if not np.linalg.norm(right - matrix @ shares) > goal:
                break
        return Change(*(sum(a * each[n] for a, each in zip((1.0, *shares), found, strict=True)) for n in range(3)))


TANGENT = 1e-4
"""Relative accuracy of directions along a curve: they are slopes of searches of peaks to as much."""


class At(NamedTuple):
    """Linear parts at one frequency: gains of the modes (k, H+1) and their derivatives by ω; what the modes above add by μ
    (H+1, N, r + outputs, r) and by the load (H+1, N, r + outputs), and the derivatives of both."""

    gains: Complex
    slopes: Complex
    by_forces: Complex
    by_load: Complex
    forces_slope: Complex
    load_slope: Complex


class WheelBalance(HarmonicBalance):
    """One wheel on shapes; contacts: of one sector after the other; blade, pull: deviations of blade frequencies and factors of
    static loads, (N,). oriented: whether a determinant shows the way along a curve beyond sharp folds, which takes longer.
    """

    oriented = False

    def __init__(
        self, wheel: TunedWheel, shapes: Shapes, samples: int, contacts: Sequence[Contact], blade: Array, pull: Array
    ) -> None:
        table = contact_table(contacts)
        self.wheel, self.shapes, self.problem, self._table = wheel, shapes, wheel.disk, table
        self.highest = self.harmonics = H = wheel.highest
        self.columns, self.rows = 2 * H + 1, wheel.sectors * shapes.size
        self.kept, self.dropped = np.arange(self.columns), np.arange(0)
        self._fourier = fourier(H, samples)
        compile_contact_forces(table)
        self.modes = wheel.ritz(blade, pull, shapes.U)
        self.pull = np.fft.ifft(pull)
        self.scaled = shapes.U / np.sqrt(wheel.stiffness)[:, None]
        self.near = [
            (h, np.flatnonzero(np.abs(1.0 - (h * wheel.middle / self.modes.omega) ** 2) < NEAR)) for h in range(1, H + 1)
        ]
        self.stiffer = stuck_stiffness(contacts) - np.tile(wheel.stiffness, wheel.sectors)
        moved = self.modes.contacts.astype(np.float32)
        self.resonant = [(part, np.ascontiguousarray(moved[:, k])) for h, k in self.near for part in (2 * h - 1, 2 * h)]
        own = np.arange(len(shapes.U))
        self.pairs = [self._pairs(other[: own.size]) for other in (own, table.loading_row, table.partner_row)]
        self._at: tuple[float, At] | None = None

    def _pairs(self, other: Index) -> NDArray[np.float32]:
        """What the derivative of a row by another one counts for between two shapes, (r², rows); other (rows,), −1 for none."""
        rows = np.where((other >= 0)[:, None], self.scaled[other], 0.0)
        both = self.scaled[:, :, None] * rows[:, None, :]
        return np.ascontiguousarray(both.reshape(len(both), -1).T, dtype=np.float32)

    @property
    def table(self) -> ContactTable:
        return self._table

    @property
    def tables(self) -> Fourier:
        return self._fourier

    @property
    def linear(self) -> Self:  # type: ignore[override]
        """What looks for resonances asks the linear part for them."""
        return self

    @cached_property
    def resonances(self) -> WheelResonances:
        """Where the harmonics may meet a resonance of the stuck wheel."""
        return WheelResonances(self)

    def at(self, omega: float) -> At:
        """The linear parts at a frequency; the last ones are kept."""
        if self._at is None or self._at[0] != omega:
            own, h, zeta = self.modes.omega[:, None], np.arange(self.highest + 1), self.wheel.ratio
            gains = 1.0 / (own**2 - (h * omega) ** 2 + 2j * zeta * own * h * omega)
            slopes = gains**2 * (2.0 * h**2 * omega - 2j * zeta * own * h)
            low, high = (end**2 for end in self.wheel.band)
            share, rate = (omega**2 - low) / (high - low), 2.0 * omega / (high - low)
            parts = [((1.0 - share) * a + share * b, rate * (b - a)) for a, b in zip(*self.shapes.ends, strict=True)]
            self._at = omega, At(gains, slopes, parts[0][0], parts[1][0], parts[0][1], parts[1][1])
        return self._at[1]

    def _moved(self, modal: Complex, waves: Complex) -> Array:
        """Motion of modal amplitudes (k, H+1) and of waves of each nodal diameter (H+1, N, r + outputs)."""
        r, found = self.shapes.size, self.modes.motion @ real_harmonics(modal)
        rest = real_harmonics(np.fft.fft(waves, axis=1).transpose(1, 2, 0))
        found[: self.rows] += rest[:, :r].reshape(self.rows, -1)
        found[self.rows :] += rest[:, r:].reshape(len(found) - self.rows, -1)
        return np.asarray(found)

    def _driven(self, forces: Array) -> tuple[Complex, Complex]:
        """Modal forces (k, H+1) and waves (H+1, N, r, 1) of −μ."""
        modal = -complex_harmonics(self.modes.contacts.T @ forces)
        by_sector = complex_harmonics(forces.reshape(self.wheel.sectors, -1, self.columns))
        return modal, -np.fft.ifft(by_sector, axis=0).transpose(2, 0, 1)[..., None]

    def _loaded(self, by_load: Complex, level: float) -> Complex:
        """Waves (H+1, N, r + outputs) that the harmonic load drives through the modes above; each harmonic has one."""
        waves = np.zeros(by_load.shape, dtype=complex)
        for h in range(1, self.highest + 1):
            n = h * self.wheel.disk.engine_order % self.wheel.sectors
            waves[h, n] = level * by_load[h, n]
        return waves

    def _amplitudes(self, gains: Complex, modal: Complex) -> Complex:
        found = gains * modal
        found[:, 0] = self.modes.held @ modal[:, 0]
        return np.asarray(found)

    def motion(self, point: Point) -> Array:
        """z and outputs at a point."""
        at = self.at(point.omega)
        modal, waves = self._driven(point.forces)
        modal += point.level * self.modes.driven
        modal[:, 0] += self.modes.static
        rest = (at.by_forces @ waves)[..., 0] + self._loaded(at.by_load, point.level)
        rest[0] += self.pull[:, None] * at.by_load[0]
        return self._moved(self._amplitudes(at.gains, modal), rest)

    def change(self, forces: Array, omega: float) -> Array:
        """Change of the motion for a change of μ."""
        at = self.at(omega)
        modal, waves = self._driven(forces)
        return self._moved(self._amplitudes(at.gains, modal), (at.by_forces @ waves)[..., 0])

    def receptance(self, omega: float) -> NDArray[np.float32]:
        """R of the contacts of all sectors, (N r, 2H+1, N r, 2H+1)."""
        at, N, r, moved = self.at(omega), self.wheel.sectors, self.shapes.size, self.modes.contacts
        found = np.zeros((self.rows, self.columns, self.rows, self.columns), dtype=np.float32)
        apart = (np.arange(N)[:, None] - np.arange(N)) % N
        for h, between in enumerate(np.fft.fft(at.by_forces[:, :, :r], axis=1) / N):
            gained = moved @ self.modes.held if h == 0 else moved * at.gains[:, h]
            R = gained @ moved.T + between[apart].transpose(0, 2, 1, 3).reshape(self.rows, self.rows)
            a, b = max(2 * h - 1, 0), 2 * h
            found[:, a, :, a] = found[:, b, :, b] = R.real
            if h:
                found[:, a, :, b], found[:, b, :, a] = R.imag, -R.imag
        return found

    def slope(self, point: Point) -> Array:
        """Derivative of the motion by ω at fixed μ."""
        at = self.at(point.omega)
        modal, waves = self._driven(point.forces)
        rest = (at.forces_slope @ waves)[..., 0] + self._loaded(at.load_slope, point.level)
        return self._moved(at.slopes * (modal + point.level * self.modes.driven), rest)

    def evaluate(self, point: Point) -> Evaluation:
        """Motion, residual and the derivatives of the contacts themselves, which `WheelFactors` brings to the shapes."""
        c, w = self.columns, self.motion(point)
        contacts = self.contacts_of(w)
        target, unknown, own, coupling, cross, by_omega = contact_answer(self.table, self.tables, contacts, point.omega)
        target += self.stiffer[:, None] * contacts
        own[:, np.arange(c), np.arange(c)] += self.stiffer[:, None]
        residual, by = (self._on_shapes(each) for each in (target, by_omega))
        residual = point.forces - residual
        carried = point.forces - residual + w[: self.rows]
        error = float(np.linalg.norm(residual) / max(np.linalg.norm(carried), np.finfo(float).tiny))
        state = State(point.forces, np.empty((0, 0, 0), dtype=complex), w, residual, unknown, own, coupling, cross, by, error)
        return Evaluation(point, self.table, state)

    def contacts_of(self, w: Array) -> Array:
        """Motion of the contacts of all sectors, (N rows, 2H+1), from that of the shapes."""
        c = self.columns
        return np.asarray((self.scaled @ w[: self.rows].reshape(self.wheel.sectors, -1, c)).reshape(-1, c))

    def _on_shapes(self, rows: Array) -> Array:
        return np.asarray((self.scaled.T @ rows.reshape(self.wheel.sectors, -1, self.columns)).reshape(self.rows, self.columns))

    def derivative(self, evaluation: Evaluation) -> NDArray[np.float32]:
        """∂λ̂/∂z of each sector on its shapes, (N, r (2H+1), r (2H+1))."""
        state, N, r, c = evaluation.state, self.wheel.sectors, self.shapes.size, self.columns
        blocks = zip(self.pairs, (state.own, state.coupling, state.cross), strict=True)
        found = sum(pairs @ block.reshape(N, -1, c * c).astype(np.float32) for pairs, block in blocks if block.size)
        return np.ascontiguousarray(found.reshape(N, r, r, c, c).transpose(0, 1, 3, 2, 4)).reshape(N, r * c, r * c)  # type: ignore[union-attr]

    def factorise(self, evaluation: Evaluation, condition: PathCondition) -> WheelFactors:  # type: ignore[override]
        """The preconditioner of Newton's system at an evaluation."""
        return WheelFactors.of(self, replace(evaluation, state=self._derived(evaluation)), condition)

    def tangent(self, evaluation: Evaluation, parameter: Parameter, factors: WheelFactors) -> Direction:  # type: ignore[override]
        """Direction along the curve over ω, the path condition growing at rate one."""
        return Direction(*factors.solve(np.zeros((self.rows, self.columns)), 1.0, TANGENT), 0.0)

    def carried_forces(self, evaluation: Evaluation) -> Array:
        """Contact forces F = λ̂ + K_c w on the shapes, (N r, 2H+1)."""
        return np.asarray(evaluation.point.forces - evaluation.residual + evaluation.w[: self.rows])


class WheelResonances(Resonances):
    """Natural frequencies over h of the wheel stuck with its own springs, from its Ritz modes."""

    def __init__(self, balance: WheelBalance) -> None:
        modes, N, k = balance.modes, balance.wheel.sectors, balance.modes.omega.size
        moved = balance.scaled @ modes.contacts.reshape(N, -1, k)
        K = np.diag(modes.omega**2) + np.einsum("jrk,jr,jrl->kl", moved, balance.stiffer.reshape(N, -1), moved, optimize=True)
        squares, V = np.linalg.eigh(K)
        omega, ratios, held = np.sqrt(squares), np.full(k, balance.wheel.ratio), np.ones(balance.rows, dtype=bool)
        sizes, load = contacts_and_outputs((modes.motion @ V) ** 2, balance.rows), real_harmonics(V.T @ modes.driven)[None]
        self.limits = [Limit(held, omega, ratios, modes.contacts @ V, sizes, load)]
        harmonic, mode = (each.ravel() for each in np.mgrid[1 : balance.highest + 1, 0:k])
        self._arrange(omega[mode] / harmonic, harmonic, balance.wheel.ratio * omega[mode] / harmonic, 0 * mode, mode)

    def where_stuck(self, unknown: Index) -> None:
        """Not known: the wheel is too large to be decomposed for each of its contact states."""
        return
