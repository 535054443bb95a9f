"""The balance of one mistuned wheel on the forces of its contacts, sector by sector."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy import linalg

from stickslip.model.contact.point import ContactTable
from stickslip.model.contact.protocol import HELD
from stickslip.model.problem import Problem
from stickslip.solve.balance.balance import Evaluation, Factors, HarmonicBalance, PathCondition, Point
from stickslip.solve.balance.contact_answer import contact_answer
from stickslip.solve.balance.contact_forces import compile_contact_forces
from stickslip.solve.balance.fourier import Fourier, complex_harmonics, fourier, real_harmonics
from stickslip.solve.balance.system import Direction, State
from stickslip.solve.wheels.tuned import NEAR, Complex, Residual, TunedWheel
from stickslip.support.checks import Array, Index

INNER, MOST = 1e-6, 60


class Shapes:
    """Shapes U (rows, r) of a sector's contacts, scaled by √K_c, with what the tuned disk does on them."""

    def __init__(self, wheel: TunedWheel, U: Array) -> None:
        self.U, self.size = U, U.shape[1]
        self.ends = [wheel.residual(U, omega) for omega in wheel.band]
        middle = 0.5 * sum(wheel.band)
        self.local = wheel.local(U, middle)
        c = 2 * wheel.highest + 1
        block = np.zeros((self.size, c, self.size, c))
        for h, R in enumerate(self.local):
            if h == 0:
                block[:, 0, :, 0] = R.real
                continue
            a, b = 2 * h - 1, 2 * h
            block[:, a, :, a] = block[:, b, :, b] = R.real
            block[:, a, :, b], block[:, b, :, a] = R.imag, -R.imag
        self.block = block.reshape(self.size * c, self.size * c)


@dataclass(eq=False)
class WheelFactors:
    """M ≈ J = I + D R of an evaluation, ready to be solved: inverse blocks of the sectors, and what the resonant modes add."""

    balance: "WheelBalance"
    evaluation: Evaluation
    condition: PathCondition
    inverse: Array
    spread: Array
    small: Array
    along: tuple[Array, Array] | None = None
    orientation: float = 1.0
    products: int = 0

    @property
    def size(self) -> int:
        return int(self.inverse.shape[0] * self.inverse.shape[1])

    def precondition(self, v: Array) -> Array:
        """M⁻¹ v, v (N r, 2H+1)."""
        N, size = self.inverse.shape[:2]
        x = self.inverse @ v.reshape(N, size, 1)
        modal = self.small @ (self.balance.resonant.T @ x.reshape(-1)) if self.small.size else None
        if modal is None:
            return x.reshape(v.shape)
        return (x.reshape(-1) - self.spread @ modal).reshape(v.shape)

    def solve(self, b: Array) -> Array:
        """J⁻¹ b by GMRES on M."""
        balance, D = self.balance, self.evaluation.state.own
        beta = float(np.linalg.norm(b))
        if beta == 0.0:
            return np.zeros_like(b)
        V, Z, Hm = [b / beta], [], np.zeros((MOST + 1, MOST))
        for k in range(MOST):
            Z.append(self.precondition(V[k]))
            pushed = (D @ -balance.change(Z[k], self.evaluation.point.omega)[: balance.rows].reshape(D.shape[0], -1, 1))
            v = Z[k] + pushed.reshape(b.shape)
            for i in range(k + 1):
                Hm[i, k] = np.vdot(V[i], v)
                v = v - Hm[i, k] * V[i]
            Hm[k + 1, k] = np.linalg.norm(v)
            e = np.zeros(k + 2)
            e[0] = beta
            y = np.linalg.lstsq(Hm[: k + 2, : k + 1], e, rcond=None)[0]
            if np.linalg.norm(e - Hm[: k + 2, : k + 1] @ y) <= INNER * beta:
                break
            V.append(v / Hm[k + 1, k])
        self.products += k + 1
        balance.products += k + 1
        return np.asarray(sum(a * z for a, z in zip(y, Z, strict=True)))

    def tangent(self) -> tuple[Array, Array]:
        """dλ/dω and dw/dω along the curve."""
        if self.along is None:
            balance, state, point = self.balance, self.evaluation.state, self.evaluation.point
            by_omega = balance.slope(point)
            N = balance.wheel.sectors
            push = (state.own @ by_omega[: balance.rows].reshape(N, -1, 1)).reshape(point.forces.shape) + state.by_omega
            forces = self.solve(push)
            self.along = forces, by_omega + balance.change(forces, point.omega)
        return self.along


class WheelBalance(HarmonicBalance):
    """The balance of one mistuned wheel; forces of a `Point` are μ (N r, 2H+1), motions z and outputs (N r + outputs, 2H+1)."""

    def __init__(
        self, wheel: TunedWheel, shapes: Shapes, samples: int, blade: Array, pull: Array, table: ContactTable, problem: Problem
    ) -> None:
        self.wheel, self.shapes, self.problem = wheel, shapes, problem
        N, r, o, H = wheel.sectors, shapes.size, wheel.outputs, wheel.highest
        self.harmonics = self.highest = H
        self.columns = 2 * H + 1
        self.kept, self.dropped = np.arange(self.columns), np.arange(0)
        self.rows = N * r
        self.contact_table, self.fourier = table, fourier(H, samples)
        compile_contact_forces(table)
        self.modes = wheel.ritz(blade, shapes.U, pull)
        motion = self.modes.shapes
        self.contacts = np.ascontiguousarray(motion[:, :r].reshape(N * r, -1))
        self.all_rows = np.ascontiguousarray(np.vstack([self.contacts, motion[:, r:].reshape(N * o, -1)]))
        self.pull = np.fft.ifft(pull)
        self.scale = 1.0 / np.sqrt(wheel.stiffness)
        self._known: dict[float, Any] = {}
        middle = 0.5 * sum(wheel.band)
        columns = []
        inverse_gains = []
        for h in range(1, H + 1):
            near = np.flatnonzero(np.abs(1.0 - (h * middle / self.modes.omega) ** 2) < NEAR)
            for part in (2 * h - 1, 2 * h):
                placed = np.zeros((N * r, self.columns, near.size))
                placed[:, part] = self.contacts[:, near]
                columns.append(placed.reshape(N * r * self.columns, near.size))
            inverse_gains.append((h, near))
        self.resonant = np.hstack(columns)
        self.near = inverse_gains
        U = shapes.U
        first = np.arange(N * wheel.rows).reshape(N, -1)[0]
        normal, partner = table.loading_row[first], table.partner_row[first]
        S = self.scale[:, None] * U
        def pairs(other: Index) -> Array:
            chosen = other >= 0
            return np.where(chosen[:, None, None], S[:, :, None] * S[np.where(chosen, other, 0)][:, None, :], 0.0).reshape(len(U), -1).T
        self.S = S
        self.pairs = [np.ascontiguousarray(pairs(other)) for other in (first, normal, partner)]
        self.evaluations = self.factorisations = self.products = 0
        self.seconds: dict[str, float] = {}

    @property
    def table(self) -> ContactTable:
        return self.contact_table

    @property
    def tables(self) -> Fourier:
        return self.fourier

    def _gains(self, omega: float) -> tuple[Complex, Complex, Complex, Complex]:
        """Gains of the modes (k, H+1), their derivatives by ω, the residual receptance and its derivative."""
        if omega not in self._known:
            h, own = np.arange(self.highest + 1), self.modes.omega[:, None]
            zeta = self.wheel.ratio
            g = 1.0 / (own**2 - (h * omega) ** 2 + 2j * zeta * own * h * omega)
            slope = g**2 * (2.0 * h**2 * omega - 2j * zeta * own * h)
            low, high = (omega_end**2 for omega_end in self.wheel.band)
            share = (omega**2 - low) / (high - low)
            a, b = self.shapes.ends
            R = (1.0 - share) * a.by_forces + share * b.by_forces
            L = (1.0 - share) * a.by_load + share * b.by_load
            rate = 2.0 * omega / (high - low)
            self._known = {omega: (g, slope, R, L, rate * (b.by_forces - a.by_forces), rate * (b.by_load - a.by_load))}
        return self._known[omega]

    def _waves(self, R: Complex, forces: Array) -> Complex:
        """−R μ, (N, r + o, H+1), by the receptance of each nodal diameter (H+1, N, r + o, r)."""
        N = self.wheel.sectors
        waves = np.fft.ifft(complex_harmonics(forces.reshape(N, -1, self.columns)), axis=0)
        return np.fft.fft(-(R @ waves.transpose(2, 0, 1)[..., None])[..., 0], axis=1).transpose(1, 2, 0)

    def _loaded(self, L: Complex, level: float, static: bool) -> Complex:
        """What the load adds through the higher families, (N, r + o, H+1)."""
        N, H, EO = self.wheel.sectors, self.highest, self.wheel.disk.engine_order
        waves = np.zeros((H + 1, N, L.shape[2]), dtype=complex)
        if static:
            waves[0] = self.pull[:, None] * L[0]
        for h in range(1, H + 1):
            waves[h, h * EO % N] = level * L[h, h * EO % N]
        return np.fft.fft(waves, axis=1).transpose(1, 2, 0)

    def _rows(self, modal: Complex, rest: Complex) -> Array:
        """Motion (N r + outputs, 2H+1) of modal amplitudes (k, H+1) and of the rest (N, r + o, H+1)."""
        r = self.shapes.size
        found = self.all_rows @ real_harmonics(modal)
        real = real_harmonics(rest)
        found[: self.rows] += real[:, :r].reshape(self.rows, -1)
        found[self.rows :] += real[:, r:].reshape(found.shape[0] - self.rows, -1)
        return found

    def _pulled(self, forces: Array) -> Complex:
        return complex_harmonics(self.contacts.T @ forces)

    def motion(self, point: Point) -> Array:
        g, _, R, L, *_ = self._gains(point.omega)
        drive = point.level * self.modes.driven.T - self._pulled(point.forces)
        drive[:, 0] += self.modes.static
        modal = g * drive
        modal[:, 0] = self.modes.held @ drive[:, 0]
        return self._rows(modal, self._waves(R, point.forces) + self._loaded(L, point.level, True))

    def change(self, forces: Array, omega: float) -> Array:
        """Change of motion for a change of forces."""
        g, _, R, *_ = self._gains(omega)
        drive = -self._pulled(forces)
        modal = g * drive
        modal[:, 0] = self.modes.held @ drive[:, 0]
        return self._rows(modal, self._waves(R, forces))

    def slope(self, point: Point) -> Array:
        """Derivative of the motion by ω at fixed forces."""
        _, slope, _, _, R, L = self._gains(point.omega)
        modal = slope * (point.level * self.modes.driven.T - self._pulled(point.forces))
        modal[:, 0] = 0.0
        return self._rows(modal, self._waves(R, point.forces) + self._loaded(L, point.level, False))

    def evaluate(self, point: Point) -> Evaluation:
        self.evaluations += 1
        N, r, c = self.wheel.sectors, self.shapes.size, self.columns
        w = self.motion(point)
        contacts = (self.S @ w[: self.rows].reshape(N, r, c)).reshape(-1, c)
        target, unknown, own, coupling, cross, by_omega = contact_answer(self.contact_table, self.fourier, contacts, point.omega)
        reduced = (self.S.T @ target.reshape(N, -1, c)).reshape(-1, c)
        D = sum(
            pairs @ blocks.reshape(N, -1, c * c) for pairs, blocks in zip(self.pairs, (own, coupling, cross), strict=True) if blocks.size
        )
        D = np.ascontiguousarray(D.reshape(N, r, r, c, c).transpose(0, 1, 3, 2, 4)).reshape(N, r * c, r * c)
        residual = point.forces - reduced
        error = np.linalg.norm(residual) / max(np.linalg.norm(reduced + w[: self.rows]), np.finfo(float).tiny)
        none = np.empty((0, 0, 0))
        by = (self.S.T @ by_omega.reshape(N, -1, c)).reshape(-1, c)
        state = State(point.forces, none.astype(complex), w, residual, unknown, D, none, none, by, float(error))
        return Evaluation(point, self.contact_table, state)

    def factorise(self, evaluation: Evaluation, condition: PathCondition) -> Factors:
        self.factorisations += 1
        D = self._derived(evaluation).own
        evaluation = replace(evaluation, state=self._derived(evaluation))
        inverse = np.linalg.inv(np.eye(D.shape[1]) + D @ self.shapes.block)
        N, size = D.shape[:2]
        by_sector = self.resonant.reshape(N, size, -1)
        spread = (inverse @ (D @ by_sector)).reshape(N * size, -1)
        omega, blocks = evaluation.point.omega, []
        for h, near in self.near:
            own = self.modes.omega[near]
            inv = own**2 - (h * omega) ** 2 + 2j * self.wheel.ratio * own * h * omega
            blocks.append(np.block([[np.diag(inv.real), np.diag(inv.imag)], [-np.diag(inv.imag), np.diag(inv.real)]]))
        small = np.linalg.inv(linalg.block_diag(*blocks) + self.resonant.T @ spread)
        return WheelFactors(self, evaluation, condition, inverse, spread, small)  # type: ignore[return-value]

    def tangent(self, evaluation: Evaluation, parameter: Any, factors: Any) -> Direction:
        forces, motion = factors.tangent()
        rate = 1.0 / factors.condition.rate(motion, 1.0)
        return Direction(rate * forces, rate * motion, rate, 0.0)

    def carried_forces(self, evaluation: Evaluation) -> Array:
        return np.asarray(evaluation.point.forces - evaluation.residual + evaluation.w[: self.rows])
