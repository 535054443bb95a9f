"""Newton's method with line search, compiled: the corrector of every point of every curve.

The unknowns are the harmonics λ of the forces by which the contacts differ from stuck ones, (rows, 2H+1), and one parameter p: ω
or the force level. The structure with stuck contacts is linear. Its receptance G gives the motion of the contacts,
w = w_F(p) − G(ω) λ, and the contacts answer to this motion with λ̂(w, ω). The equations are

    R = λ − λ̂(w(λ, p)) = 0      with the path condition      g = weight · w + slope p − target = 0,

which prescribes p (weight none, slope 1/p) or keeps the solution on the plane of a continuation step. With E = ∂λ̂/∂w Newton's
system is

    [    I + E G        −E ∂w/∂p − ∂λ̂/∂p   ] [δλ]     [R]
    [ −weight · G     weight · ∂w/∂p + slope ] [δp] = − [g] .

Rows that stay stuck have E = 0: there δλ = −R, and only the rows that move remain to be factorised. If the force level is unknown
as well, because an amplitude is held, a second row and column of the same kind stand beside p.

The parts, in the order of an iteration (compiled in `balance.iteration`, for nonlinear modes in `balance.mode_iteration`):

* `evaluate`: w, λ̂, R and E at a point; the size of R relative to the contact forces or to the load is the error;
* `gap`: g, in arc length;
* `factorise`: the matrix on the rows that move, its factors and the sign of its determinant, 0 where it is singular;
* `newton_step`: δλ and δp;
* `_search`: of the steps 1, 1/2, 1/4, ... the longest that reduces error and g together. λ̂ has kinks, where a contact begins
  to slip within a sample: behind one the full step may increase the error, and `patience` takes it all the same;
* a point is accepted with an error below `TOLERANCE`, or below `FLOOR` where rounding lets no step reduce it further;
* `tangent`: the direction of the curve there, of which the next prediction is made.
"""

from dataclasses import dataclass
from functools import singledispatch
from typing import Any, NamedTuple

import numpy as np
from numba import float64, int64, typeof

from stickslip.solve.balance.balance import Evaluation, Factors, HarmonicBalance, Parameter, PathCondition, Point
from stickslip.solve.balance.iteration import gap, missed_amplitude, no_factors
from stickslip.solve.balance.mode_iteration import empty_mode_system
from stickslip.solve.balance.newton_parts import AnySystem, evaluate, factorise, kind_of, newton_step, tangent
from stickslip.solve.balance.system import BORDER, BORDERED, DIRECTION, STATE, Border, Bordered, Direction, State, empty_system
from stickslip.support.checks import Array
from stickslip.support.kernels import boxed, compiled, inlined, inner, kernel, separate
from stickslip.support.kernels.arrays import all_finite, empty_table, moved_by, same_numbers, zero_table
from stickslip.support.kernels.views import view, view_of

TOLERANCE = 1e-12
"""Residual relative to the contact forces, or to the harmonic load, at which a point counts as solved."""

FLOOR = 1e-9
"""Residual that is still accepted where rounding lets no step reduce it further."""

CONDITION_TOLERANCE = 1e-7
"""Distance from the plane of a step, in arc length, that a solution may keep."""

AMPLITUDE_TOLERANCE = 1e-10
"""Relative amount by which a held amplitude may be missed."""

LOST = 1e-4
"""Rounding of λ over the static load and the carried contact forces from which on these are lost in it."""

NEAR = 1e-3
"""Residual up to which the factors of a point serve for the direction of the curve at its solution."""


@dataclass(frozen=True, slots=True, eq=False)
class Correction:
    """Outcome of Newton's method: the motion at the start, the last evaluation, the last factors, if any.

    direction: along the curve, if it was asked for and the point converged. history (iterations + 1, 2): the error of each
    iterate, and the share of Newton's step that led to it; 0 at the start, and where no step was found.
    """

    start_motion: Array
    evaluation: Evaluation
    factors: Factors | None
    direction: Direction | None
    history: Array
    converged: bool
    singular: bool

    @property
    def iterations(self) -> int:
        """How many steps were taken."""
        return len(self.history) - 1


def fixed(parameter: Parameter, value: float) -> PathCondition:
    """The condition that prescribes the parameter alone."""
    scale = 1.0 / max(abs(value), 1e-300)
    return PathCondition(parameter, None, scale, scale * value)


@singledispatch
def correct(
    balance: HarmonicBalance,
    start: Point,
    condition: PathCondition,
    iterations: int = 10,
    halvings: int = 4,
    patience: int = 0,
    direction: float | None = None,
) -> Correction:
    """Solve R = 0 with a path condition from a start; where the balance holds an amplitude, its force level is found too.

    patience: how many times a full step is taken although no step reduces the residual; on the far side of a kink it often
    falls again. Without patience Newton fails there. direction: find the direction of the curve too, with factors of the
    last iterate that has no larger residual than this and the same unknowns, else with those of the solution.
    """
    compile_newton(balance.system)
    forces, omega, level = np.ascontiguousarray(start.forces), float(start.omega), float(start.level)
    wanted = -1.0 if direction is None else direction
    found = _newton_called(balance.placed_system, forces, omega, level, condition.border, iterations, halvings, patience, wanted)
    evaluation = Evaluation(Point(found.state.forces, found.omega, found.level), balance.table, found.state)
    factors = Factors(found.bordered, balance.system) if found.bordered.lu.size else None
    converged = found.converged and not _lost(balance, evaluation)
    along = found.direction if direction is not None and converged else None
    return Correction(found.start_motion, evaluation, factors, along, found.history, converged, found.singular)


def _lost(balance: HarmonicBalance, evaluation: Evaluation) -> bool:
    """Whether a body is so far away that its forces are rounding: λ = F − K_c w then no longer holds F, and the balance is met by
    any load. So end bodies whose contacts slip under more than they carry: the stiffness that is left is a rounding too.
    """
    load = float(np.linalg.norm(balance.problem.static_load))
    rounding = float(np.finfo(float).eps * np.linalg.norm(evaluation.point.forces))
    if load == 0.0 or rounding <= LOST * load:
        return False
    return rounding > LOST * float(np.linalg.norm(balance.carried_forces(evaluation)))


class Found(NamedTuple):
    """What Newton's method came to; `bordered` and `direction` hold nothing where they were not needed."""

    start_motion: Array
    state: State
    omega: float
    level: float
    bordered: Bordered
    direction: Direction
    history: Array
    converged: bool
    singular: bool

    @property
    def iterations(self) -> int:
        """How many steps were taken."""
        return len(self.history) - 1


def _signature(system: NamedTuple) -> Any:
    """Types of `newton` for a kind of system."""
    found = Found(STATE.forces, STATE, 0.0, 0.0, BORDERED, DIRECTION, STATE.forces, False, False)
    return typeof(found)(view_of(system), float64[:, ::1], float64, float64, typeof(BORDER), int64, int64, int64, float64)


@separate(lambda: _signature(empty_system()), lambda: _signature(empty_mode_system()))
def newton(
    system: AnySystem,
    forces: Array,
    omega: float,
    level: float,
    border: Border,
    iterations: int,
    halvings: int,
    patience: int,
    wanted: float,
) -> Found:
    """Newton's method with a line search; the arguments are those of `correct`."""
    state = first = evaluate(system, forces, omega, level)
    bordered = no_factors(state)
    history = zero_table(iterations + 1, 2)
    done, near, converged, singular, length = 0, False, False, False, 1.0
    history[0, 0] = state.error
    while True:
        missed, off = gap(border, state, omega, level), missed_amplitude(system.control, state.w, omega)
        if state.error <= TOLERANCE and abs(missed) <= CONDITION_TOLERANCE and abs(off) <= AMPLITUDE_TOLERANCE:
            converged = True
            break
        if done == iterations:
            break
        bordered = factorise(system, state, omega, level, border)
        if bordered.sign == 0.0:
            singular = True
            break
        done += 1
        step, amount, raised = newton_step(system, state, omega, level, border, missed, bordered)
        short = np.hypot(missed, off)
        length, following = _search(system, state, omega, level, border, short, step, amount, raised, halvings)
        if length == 0.0 and patience > 0 and state.error > FLOOR:
            patience -= 1
            length, following = _full_step(system, state, omega, level, border, step, amount, raised)
        if length == 0.0:
            near = True
            converged = state.error <= FLOOR and max(abs(missed), abs(off)) <= CONDITION_TOLERANCE
            break
        near = state.error <= wanted and same_numbers(state.unknown, following.unknown)
        state = following
        omega, level = moved(border, omega, level, length * amount, length * raised)
        history[done, 0], history[done, 1] = state.error, length
    if length == 0.0:
        history[done, 0] = state.error
    direction = Direction(empty_table(0, 0), empty_table(0, 0), 0.0, 0.0)
    if converged and wanted >= 0.0:
        if not near:
            bordered = factorise(system, state, omega, level, border)
        direction = tangent(system, state, omega, level, border.by_level, bordered)
    return Found(first.w, state, omega, level, bordered, direction, history[: done + 1], converged, singular)


def compile_newton(system: AnySystem) -> None:
    """Compile `newton` for a kind of system, or take it from disk."""
    compiled(newton, number=kind_of(system))


@kernel
def _newton_called(
    given: AnySystem,
    forces: Array,
    omega: float,
    level: float,
    border: Border,
    iterations: int,
    halvings: int,
    patience: int,
    wanted: float,
) -> Found:
    """`newton` for calls from Python."""
    return boxed(newton(view(given), forces, omega, level, border, iterations, halvings, patience, wanted))


@inner
def moved(border: Border, omega: float, level: float, amount: float, raised: float) -> tuple[float, float]:
    """ω and level with the parameter changed, and the level by `raised` too."""
    return (omega, level + amount) if border.by_level else (omega + amount, level + raised)


@inlined
def _full_step(
    system: AnySystem, state: State, omega: float, level: float, border: Border, step: Array, amount: float, raised: float
) -> tuple[float, State]:
    """The state after Newton's whole step, whatever it does to the residual; length 0 where there is none."""
    after, lifted = moved(border, omega, level, amount, raised)
    if not (after > 0.0 and np.isfinite(amount) and np.isfinite(raised) and all_finite(step)):
        return 0.0, state
    return 1.0, evaluate(system, moved_by(state.forces, 1.0, step), after, lifted)


@inlined
def _search(
    system: AnySystem,
    state: State,
    omega: float,
    level: float,
    border: Border,
    short: float,
    step: Array,
    amount: float,
    raised: float,
    halvings: int,
) -> tuple[float, State]:
    """The longest of the steps 1, 1/2, 1/4, ... that reduces residual and missed conditions together, and the state after it; 0
    for none."""
    if not (np.isfinite(amount) and np.isfinite(raised) and all_finite(step)):
        return 0.0, state
    before = np.hypot(state.error, short)
    length = 1.0
    for _ in range(halvings + 1):
        after, lifted = moved(border, omega, level, length * amount, length * raised)
        if after > 0.0:
            trial = evaluate(system, moved_by(state.forces, length, step), after, lifted)
            missed = np.hypot(gap(border, trial, after, lifted), missed_amplitude(system.control, trial.w, after))
            if np.hypot(trial.error, missed) < (1.0 - 1e-4 * length) * before:
                return length, trial
        length *= 0.5
    return 0.0, state
