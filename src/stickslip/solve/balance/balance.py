"""Harmonic balance of a problem: the residual R = λ − λ̂(w), w = e' − G'λ, and Newton's linear system for it.

λ = F − K_c w are the contact forces beyond the linear springs of the stuck contacts. λ of a held row (stuck, closed) is a
constant, so the dense system holds 2H+1 unknowns per direction that slips or opens (two less for each harmonic that a list
leaves out) and one per direction that is clipped or tied to its normal load, plus the path parameter. Where these are many
more than the states of the structure, it is solved on the states (`modal_matrix`).

Solutions with the transpose of a bordered Newton matrix, for its singular values; compiled when first called.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from stickslip.model.contact.point import ContactTable, contact_table
from stickslip.model.contact.protocol import HELD
from stickslip.model.problem import Problem
from stickslip.model.problem.speed import over_periods
from stickslip.solve.balance import newton_parts
from stickslip.solve.balance.fourier import (
    Fourier,
    Harmonics,
    columns_of,
    fineness,
    fourier,
    harmonics_for,
    highest,
    in_fractions,
    orders,
)
from stickslip.solve.balance.linear_part import LinearPart
from stickslip.solve.balance.newton_matrix import (
    from_line,
    in_line,
    lu_solve_transposed,
    places,
    pushed,
    pushed_back,
    three_blocks,
    weights_on,
)
from stickslip.solve.balance.receptance import driven_states, frequency_gains, pulled_by_states
from stickslip.solve.balance.system import FREE, SMALLER, Border, Bordered, Control, Direction, State, System
from stickslip.support.checks import Array, Index, fault
from stickslip.support.kernels import kernel
from stickslip.support.kernels.arrays import empty_table, zero_table
from stickslip.support.kernels.views import Placed, view


@kernel
def solve_transposed(given: System, bordered: Bordered, right: Array) -> None:
    """Overwrite right-hand sides (k, rows) with the solutions of Jᵀ x = r, J with its borders.

    On coordinates of the structure, J = I + A B with A = E Φ and B = g Ψᵀ: x = r + Bᵀz, (I + B A)ᵀ z = −Aᵀ r.
    """
    system = view(given)
    if not bordered.columns.shape[0]:
        lu_solve_transposed(bordered.lu, bordered.pivots, right)
        return
    modes, kept, offsets = system.modes, system.kept, bordered.offsets
    starts, size, columns = places(modes, kept), offsets[-1], bordered.mask.shape[1]
    states, borders = starts[-1], bordered.columns.shape[0]
    active = np.flatnonzero(offsets[1:] > offsets[:-1])
    gains = frequency_gains(modes, bordered.omega, (columns - 1) // 2)
    driven = driven_states(modes, gains, bordered.omega, active)
    line, blocks = empty_table(1, states + borders), three_blocks(bordered)
    normal, partner = system.table.loading_row, system.table.partner_row
    for each in right:
        back = zero_table(modes.shape.shape[0], columns)
        pushed_back(offsets, kept, normal, partner, blocks, each, back)
        in_line(modes, kept, starts, weights_on(modes, back), -1.0, line[0])
        for n in range(borders):
            line[0, states + n] = each[size + n]
            for k in range(size):
                line[0, states + n] -= bordered.columns[n, k] * each[k]
        lu_solve_transposed(bordered.lu, bordered.pivots, line)
        found = from_line(modes, kept, starts, line[0], columns)
        pull = pulled_by_states(modes, driven, np.dot(modes.output.T, found) if modes.basis.shape[1] else found)
        for a in range(active.size):
            for k in range(offsets[active[a] + 1] - offsets[active[a]]):
                each[offsets[active[a]] + k] -= pull[a, kept[k]]
        for n in range(borders):
            each[size + n] = line[0, states + n]


Parameter = Literal["omega", "level"]


@dataclass(frozen=True, slots=True, eq=False)
class Point:
    """A place in the space of the balance: forces λ (rows, 2H+1) [N], omega [rad/s], force level."""

    forces: Array
    omega: float
    level: float

    def moved(self, change: Array, parameter: Parameter, amount: float, raised: float = 0.0) -> Point:
        """The point with λ and the parameter changed; raised: change of a level that holds an amplitude."""
        omega = self.omega + (amount if parameter == "omega" else 0.0)
        level = self.level + (amount if parameter == "level" else raised)
        return Point(self.forces + change, omega, level)

    def value(self, parameter: Parameter) -> float:
        """Value of the path parameter."""
        return self.omega if parameter == "omega" else self.level


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """Everything about a point that Newton's method needs, and the contacts with the start state of this solution."""

    point: Point
    table: ContactTable
    state: State

    def without_derivatives(self) -> Evaluation:
        """The same for points of a curve that are kept: the derivatives, (rows, 2H+1, 2H+1) three times, are by far the largest
        part, 3 MB at 950 rows and H = 5, and 90 MB at H = 31. `HarmonicBalance` computes them again where they are asked for,
        with the derivative by ω.
        """
        if not self.state.own.size:
            return self
        none = np.empty((0, 0, 0))
        return replace(self, state=self.state._replace(own=none, coupling=none, cross=none, by_omega=np.empty((0, 0))))

    @property
    def w(self) -> Array:
        """Motion of contact rows and outputs (rows + outputs, 2H+1)."""
        return self.state.w

    @property
    def residual(self) -> Array:
        """λ − λ̂ (rows, 2H+1)."""
        return self.state.residual

    @property
    def unknown(self) -> Index:
        """How much of each row is unknown (rows,)."""
        return self.state.unknown

    @property
    def error(self) -> float:
        """‖residual‖ relative to the contact forces or the harmonic load, whichever is larger."""
        return self.state.error


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

    @property
    def border(self) -> Border:
        """The condition as the kernels read it."""
        return Border(NO_WEIGHT if self.weight is None else self.weight, self.slope, self.target, self.parameter == "level")


NO_WEIGHT = np.empty((0, 0))


def constant_size(problem: Problem, table: ContactTable) -> float:
    """Size of the constant forces that cancel in a residual, N: static loads, and −k g of open gaps. It rounds like these.

    Loads that go with the speed count at the first natural frequency of the stuck structure at rest.
    """
    powers = problem.static_powers
    omega = problem.first_omega_at_rest if len(powers) > 1 else 0.0
    loads = omega ** np.arange(len(powers)) @ np.linalg.norm(powers, axis=1)
    return float(loads + np.linalg.norm(np.minimum(table.normal_constant, 0.0)))


@dataclass(frozen=True, slots=True, eq=False)
class Factors:
    """The factorised bordered system of an evaluation.

    mask (rows, 2H+1): which entries of λ are unknown; orientation: sign of the determinant, 0 when singular.
    """

    bordered: Bordered
    system: System

    @property
    def offsets(self) -> Index:
        """Where the unknowns of each row start (rows + 1)."""
        return self.bordered.offsets

    @property
    def mask(self) -> NDArray[np.bool_]:
        """Which entries of λ (rows, 2H+1) are unknown."""
        return self.bordered.mask

    @property
    def orientation(self) -> float:
        """Sign of the determinant, 0 when singular."""
        return self.bordered.sign

    @property
    def pivots(self) -> Array:
        """Diagonal of the factors (N+1,)."""
        return np.asarray(np.diag(self.bordered.lu))

    @property
    def size(self) -> int:
        """Number of unknown harmonics of λ; the system has one row more, or two where an amplitude is held."""
        return int(self.bordered.offsets[-1])

    @property
    def rows(self) -> int:
        """Number of rows of the system."""
        small = self.bordered.columns
        return self.size + small.shape[0] if small.size else int(self.bordered.lu.shape[0])

    def solve_many(self, right: Array) -> Array:
        """Solutions (k, rows) for several right-hand sides (k, rows)."""
        solutions = np.array(right, order="C")
        newton_parts.solve_called(self.system, self.bordered, solutions)
        return solutions

    def solve_transposed(self, right: Array) -> Array:
        """Solutions (k, rows) with the transpose of the matrix for several right-hand sides (k, rows)."""
        solutions = np.array(right, order="C")
        solve_transposed(self.system, self.bordered, solutions)
        return solutions


class HarmonicBalance:
    """The balance of one problem with Nt samples; harmonics: H for 0..H, or a list of them.

    periods p: of the excitation, over which motions are expanded. With more than one, harmonics and samples are those of one
    period, `problem` is the problem over all of them, whose loads act on harmonics p h, and ω of a point is that of the whole
    expansion: the excitation's over p.
    highest: H, of the expansion p H; columns: 2H+1; kept, dropped: the columns of the harmonics that are balanced, and of those
    that a list leaves out.
    """

    periods = 1
    _placed: Placed | None = None
    _again: tuple[Evaluation, State] | None = None

    def __init__(self, problem: Problem, harmonics: Harmonics | Sequence[int], samples: int, periods: int = 1) -> None:
        _, samples = fineness(harmonics, samples)
        harmonics = harmonics_for(problem, harmonics)
        problem, samples = over_periods(problem, periods), periods * samples
        self.problem, self.periods = problem, periods
        self.harmonics = in_fractions(harmonics, periods)
        self.highest = highest(self.harmonics)
        self.columns = 2 * self.highest + 1
        self.kept = columns_of(orders(self.harmonics))
        self.dropped = np.setdiff1d(np.arange(self.columns), self.kept)
        self.linear = LinearPart(problem, self.harmonics)
        self.stiffness = problem.contact_stiffness
        table, powers = contact_table(problem.contacts), problem.load_powers(self.highest)
        self.rows = table.rows
        self.system = System(
            table,
            fourier(self.highest, samples),
            self.linear.modes,
            self.stiffness,
            self.kept,
            self.dropped,
            np.linalg.norm(powers, axis=(1, 2)),
            1e-3 * constant_size(problem, table) + np.finfo(float).tiny,
            np.zeros(3, dtype=np.int64),
            FREE,
            SMALLER,
        )
        newton_parts.compile_parts(self.system)

    @property
    def placed_system(self) -> System:
        """The system as kernels take it, by its address."""
        if self._placed is None or self._placed.whole is not self.system:
            self._placed = newton_parts.placed(self.system)
        return self._placed.address  # type: ignore[no-any-return]

    @property
    def first(self) -> slice:
        """The columns of the first harmonic of the excitation."""
        return slice(2 * self.periods - 1, 2 * self.periods + 1)

    def hertz(self, omega: float) -> float:
        """Frequency of the excitation, Hz, at ω of a point, rad/s."""
        return self.periods * (omega / (2.0 * np.pi))

    @property
    def table(self) -> ContactTable:
        return self.system.table

    @property
    def tables(self) -> Fourier:
        return self.system.tables

    def with_starts(self, values: Array, kind: int | Index | None = None) -> HarmonicBalance:
        """The same balance from other start values (friction elements,), and with other start rules if `kind` is given."""
        if self.kept[0] != 0:
            raise fault("harmonics", "must hold 0, the mean, since start states shift it", list(orders(self.harmonics)))
        kinds = self.table.start_kind if kind is None else np.broadcast_to(kind, self.table.start_kind.shape).astype(np.int64)
        table = self.table._replace(start_value=np.ascontiguousarray(values, dtype=float), start_kind=kinds)
        return self._with(table=table)

    def with_samples(self, samples: int) -> HarmonicBalance:
        """The same balance with another number of samples over all its periods."""
        return self._with(tables=fourier(self.highest, samples))

    def with_harmonics(self, most: int) -> HarmonicBalance:
        """The same balance with its harmonics up to another number: of a list those that it holds, else all of them."""
        listed = most if isinstance(self.harmonics, int) else [h for h in self.harmonics if h <= most]
        other = HarmonicBalance(self.problem, listed, self.tables.E.shape[0])
        other.periods, other.system = self.periods, other.system._replace(table=self.table, control=self.system.control)
        return other

    @property
    def control(self) -> Control | None:
        """The amplitude that the force level holds, or None where the level is given."""
        return self.system.control if self.system.control.row >= 0 else None

    def holding(self, control: Control | None) -> HarmonicBalance:
        """The same balance with the amplitude of a row of motion held by the force level, or with a given level for None."""
        own = FREE if control is None else Control(int(control.row), int(control.order), float(control.amplitude))
        return self._with(control=own)

    def _with(self, **parts: Any) -> HarmonicBalance:
        """The same balance with other parts of its system."""
        other = copy(self)
        other.system, other._again = self.system._replace(**parts), None
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
        state = newton_parts.evaluate_called(
            self.placed_system, np.ascontiguousarray(point.forces), float(point.omega), float(point.level)
        )
        return Evaluation(point, self.table, state)

    def _derived(self, evaluation: Evaluation) -> State:
        """The state of an evaluation with its derivatives: evaluated again where it was kept without them."""
        if evaluation.state.own.size:
            return evaluation.state
        if self._again is None or self._again[0] is not evaluation:
            self._again = evaluation, self.evaluate(evaluation.point).state
        return self._again[1]

    def carried_forces(self, evaluation: Evaluation) -> Array:
        """The contact forces F = λ̂ + K_c w, (rows, 2H+1), N."""
        target = evaluation.point.forces - evaluation.residual
        return np.asarray(target + self.stiffness[:, None] * evaluation.w[: self.rows])

    def factorise(self, evaluation: Evaluation, condition: PathCondition) -> Factors:
        """The bordered Newton matrix of an evaluation, factorised once."""
        point = evaluation.point
        state = self._derived(evaluation)
        bordered = newton_parts.factorise_called(self.placed_system, state, point.omega, point.level, condition.border)
        return Factors(bordered, self.system)

    def newton_step(self, evaluation: Evaluation, condition: PathCondition, factors: Factors) -> tuple[Array, float]:
        """Newton's change of λ (rows, 2H+1) and of the parameter."""
        point, short = evaluation.point, condition.gap(evaluation)
        return newton_parts.newton_step_called(
            self.placed_system, self._derived(evaluation), point.omega, point.level, condition.border, short, factors.bordered
        )[:2]

    def tangent(self, evaluation: Evaluation, parameter: Parameter, factors: Factors) -> Direction:
        """Direction along the curve, the path condition growing at rate one."""
        point, by_level = evaluation.point, parameter == "level"
        state = self._derived(evaluation)
        return newton_parts.tangent_called(self.placed_system, state, point.omega, point.level, by_level, factors.bordered)

    def pushed(self, evaluation: Evaluation, offsets: Index, dw: Array) -> Array:
        """E dw on the unknowns (N,): what a change of motion (rows, 2H+1) does to λ̂ there."""
        result = np.empty(int(offsets[-1]))
        state = self._derived(evaluation)
        normal, partner = self.table.loading_row, self.table.partner_row
        pushed(offsets, self.kept, normal, partner, state.own, state.coupling, state.cross, dw, result)
        return result

    def pushed_back(self, evaluation: Evaluation, offsets: Index, values: Array) -> Array:
        """Eᵀ x (motion rows, 2H+1) of unknowns x, which stand first in values: weights of the motion in a weighted sum of λ̂."""
        result, state = np.zeros_like(evaluation.w), self._derived(evaluation)
        normal, partner = self.table.loading_row, self.table.partner_row
        pushed_back(offsets, self.kept, normal, partner, (state.own, state.coupling, state.cross), values, result)
        return result
