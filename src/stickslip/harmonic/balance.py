"""Harmonic balance of a problem: the residual R = λ − λ̂(w), w = e' − G'λ, and Newton's linear system for it.

λ = F − K_c w are the contact forces beyond the linear springs of the stuck contacts. λ of a held row (stuck, closed) is a
constant, so the dense system holds 2H+1 unknowns per direction that slips or opens and one per direction that is clipped
or tied to its normal load, plus the path parameter.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from stickslip.checks import Array, Index
from stickslip.contact.period import HELD
from stickslip.contact.table import ContactTable, contact_table
from stickslip.harmonic.contact_forces import contact_forces
from stickslip.harmonic.fourier import fourier
from stickslip.harmonic.linear_part import linear_part
from stickslip.harmonic.newton_matrix import moved_rows, newton_matrix, orientation, pushed, related_rows, unknown_entries
from stickslip.problem import Problem

Parameter = Literal["omega", "level"]


@dataclass(frozen=True, slots=True, eq=False)
class Point:
    """A place in the space of the balance: forces λ (rows, 2H+1) [N], omega [rad/s], force level."""

    forces: Array
    omega: float
    level: float

    def moved(self, change: Array, parameter: Parameter, amount: float) -> Point:
        """The point with λ and the parameter changed."""
        omega = self.omega + (amount if parameter == "omega" else 0.0)
        level = self.level + (amount if parameter == "level" else 0.0)
        return Point(self.forces + change, omega, level)

    def value(self, parameter: Parameter) -> float:
        """Value of the path parameter."""
        return self.omega if parameter == "omega" else self.level


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """Everything about a point that Newton's method needs.

    w (contact rows + outputs, 2H+1) and its derivatives by ω and by level at fixed λ; residual λ − λ̂ (rows, 2H+1);
    unknown: state of each row; own, coupling, cross: derivatives of λ̂; error: ‖residual‖ relative to the contact forces or the
    harmonic load, whichever is larger; table: the contacts with the start state of this solution.
    """

    point: Point
    table: ContactTable
    w: Array
    by_omega: Array
    by_level: Array
    residual: Array
    unknown: Index
    own: Array
    coupling: Array
    cross: Array
    error: float

    def by(self, parameter: Parameter) -> Array:
        """dw/d(parameter) at fixed λ."""
        return self.by_omega if parameter == "omega" else self.by_level


@dataclass(frozen=True, slots=True, eq=False)
class PathCondition:
    """weight · (w − w0) + slope (p − p0) = distance: one equation that picks a point of the curve.

    weight (rows, 2H+1), or None for none: then the parameter alone is prescribed.
    """

    parameter: Parameter
    weight: Array | None
    slope: float
    target: float

    def gap(self, evaluation: Evaluation) -> float:
        """How far the condition is from being met."""
        return self.rate(evaluation.w, evaluation.point.value(self.parameter)) - self.target

    def rate(self, dw: Array, dp: float) -> float:
        """How the left side changes with motion and parameter."""
        return self.slope * dp if self.weight is None else self.slope * dp + float(np.vdot(self.weight, dw))


@dataclass(frozen=True, slots=True, eq=False)
class Factors:
    """The factorised bordered system of an evaluation.

    mask (rows, 2H+1): which entries of λ are unknown; orientation: sign of the determinant, 0 when singular.
    """

    lu: NDArray[np.float64]
    pivots: NDArray[np.int32]
    offsets: Index
    mask: NDArray[np.bool_]
    orientation: float

    @property
    def size(self) -> int:
        """Number of unknown harmonics of λ; the system has one row more."""
        return int(self.offsets[-1])

    def solve(self, right: Array) -> tuple[Array, float]:
        """Unknown part (N,) and parameter of the solution for a right-hand side (N+1,)."""
        solution, _ = lapack.dgetrs(self.lu, self.pivots, right)
        return solution[:-1], float(solution[-1])

    def solve_many(self, right: Array) -> Array:
        """Solutions (N+1, k) for several right-hand sides (N+1, k)."""
        solutions, _ = lapack.dgetrs(self.lu, self.pivots, right)
        return np.asarray(solutions)


class HarmonicBalance:
    """The balance of one problem with H harmonics and Nt samples."""

    def __init__(self, problem: Problem, harmonics: int, samples: int) -> None:
        self.problem = problem
        self.harmonics = harmonics
        self.columns = 2 * harmonics + 1
        self.tables = fourier(harmonics, samples)
        self.table = contact_table(problem.contacts)
        self.rows = self.table.rows
        self.normal, self.partner = related_rows(self.table)
        self.coupled_rows = self.rows if self.table.coupled.any() else 0
        self.linear = linear_part(problem, harmonics)
        self.stiffness = problem.contact_stiffness
        load = problem.load(harmonics)
        self.load_size = float(np.linalg.norm(load[:, 1:]))
        self.least_scale = 1e-3 * float(np.linalg.norm(load[:, 0])) + np.finfo(float).tiny

    def with_starts(self, values: Array, kind: int | None = None) -> HarmonicBalance:
        """The same balance from other start values (friction elements,), and with another start rule if `kind` is given."""
        other = copy(self)
        kinds = self.table.start_kind if kind is None else np.full_like(self.table.start_kind, kind)
        other.table = self.table._replace(start_value=np.ascontiguousarray(values, dtype=float), start_kind=kinds)
        return other

    def stuck_point(self, omega: float, level: float) -> Point:
        """Where Newton starts without better knowledge: λ of all contacts held at their start offsets."""
        evaluation = self.evaluate(Point(np.zeros((self.rows, self.columns)), omega, level))
        forces = np.zeros((self.rows, self.columns))
        held = evaluation.unknown == HELD
        forces[held] = (evaluation.point.forces - evaluation.residual)[held]
        return Point(forces, omega, level)

    def evaluate(self, point: Point) -> Evaluation:
        """Motion, residual and derivatives at a point."""
        rows, columns = self.rows, self.columns
        motion_rows = rows + self.problem.output_rows.shape[0]
        w, by_omega, by_level = (np.empty((motion_rows, columns)) for _ in range(3))
        self.linear.motion(point.forces, point.omega, point.level, w, by_omega, by_level)
        target, unknown = np.empty((rows, columns)), np.zeros(rows, dtype=np.int64)
        own, coupling = np.empty((rows, columns, columns)), np.empty((rows, columns, columns))
        cross = np.empty((self.coupled_rows, columns, columns))
        contact_forces(self.table, self.tables, w, target, unknown, own, coupling, cross)
        residual = point.forces - target
        carried = target + self.stiffness[:, None] * w[:rows]
        scale = max(float(np.sqrt(np.vdot(carried, carried))), point.level * self.load_size, self.least_scale)
        error = float(np.sqrt(np.vdot(residual, residual))) / scale
        return Evaluation(point, self.table, w, by_omega, by_level, residual, unknown, own, coupling, cross, error)

    def carried_forces(self, evaluation: Evaluation) -> Array:
        """The contact forces F = λ̂ + K_c w, (rows, 2H+1), N."""
        target = evaluation.point.forces - evaluation.residual
        return np.asarray(target + self.stiffness[:, None] * evaluation.w[: self.rows])

    def factorise(self, evaluation: Evaluation, condition: PathCondition) -> Factors:
        """The bordered Newton matrix of an evaluation, factorised once."""
        offsets, mask = unknown_entries(evaluation.unknown, self.columns)
        active, moved, place = moved_rows(self.table, evaluation.unknown)
        size = int(offsets[-1])
        matrix = np.zeros((size + 1, size + 1))
        by = evaluation.by(condition.parameter)
        matrix[size, size] = condition.slope
        if size:
            G = self.linear.receptance(evaluation.point.omega, self.harmonics, moved, active)
            blocks = (evaluation.own, evaluation.coupling, evaluation.cross)
            newton_matrix(offsets, self.normal, self.partner, active, place, *blocks, G, matrix)
            matrix[:size, size] = -self.pushed(evaluation, offsets, by)
        if condition.weight is not None:
            matrix[size, size] += float(np.vdot(condition.weight, by))
            if size:
                pull = self.linear.pulled(evaluation.point.omega, condition.weight, active)
                matrix[size, :size] = pull[mask[active]]
        lu, pivots, _ = lapack.dgetrf(matrix, overwrite_a=1)
        return Factors(lu, pivots, offsets, mask, orientation(lu, pivots))

    def newton_step(self, evaluation: Evaluation, condition: PathCondition, factors: Factors) -> tuple[Array, float]:
        """Newton's change of λ (rows, 2H+1) and of the parameter."""
        change = np.where(factors.mask, 0.0, -evaluation.residual)
        right = np.empty(factors.size + 1)
        right[:-1] = -evaluation.residual[factors.mask]
        right[-1] = -condition.gap(evaluation)
        if change.any():
            moved = self.linear.change(change, evaluation.point.omega)
            right[:-1] += self.pushed(evaluation, factors.offsets, moved)
            right[-1] -= 0.0 if condition.weight is None else float(np.vdot(condition.weight, moved))
        solution, amount = factors.solve(right)
        change[factors.mask] = solution
        return change, amount

    def tangent(self, evaluation: Evaluation, parameter: Parameter, factors: Factors) -> tuple[Array, Array, float]:
        """Direction along the curve with path condition growing at rate one: dλ (rows, 2H+1), dw (motion rows, 2H+1), dp."""
        right = np.zeros(factors.size + 1)
        right[-1] = 1.0
        solution, amount = factors.solve(right)
        forces = np.zeros((self.rows, self.columns))
        forces[factors.mask] = solution
        dw = amount * evaluation.by(parameter)
        if factors.size:
            dw += self.linear.change(forces, evaluation.point.omega)
        return forces, dw, amount

    def pushed(self, evaluation: Evaluation, offsets: Index, dw: Array) -> Array:
        """E dw on the unknowns (N,): what a change of motion (rows, 2H+1) does to λ̂ there."""
        result = np.empty(int(offsets[-1]))
        blocks = (evaluation.own, evaluation.coupling, evaluation.cross)
        pushed(offsets, self.normal, self.partner, *blocks, dw, result)
        return result
