"""Parts of a Newton iteration for either kind of balance, chosen by the type of the system when a kernel is compiled.

Newton's method and the continuation are so the same for forced motions (`iteration`) and for nonlinear modes (`mode_iteration`).
"""

from __future__ import annotations

from typing import Any

from numba.extending import overload

from stickslip.solve.balance import iteration, mode_iteration, on_states
from stickslip.solve.balance.contact_forces import compile_contact_forces
from stickslip.solve.balance.mode_iteration import ModeSystem, ModeSystemAddress
from stickslip.solve.balance.system import Border, Bordered, Direction, State, System, SystemAddress
from stickslip.support.checks import Array
from stickslip.support.kernels import boxed, compiled, kernel
from stickslip.support.kernels.views import Placed, view

AnySystem = System | ModeSystem


def evaluate(system: AnySystem, forces: Array, omega: float, level: float) -> State:
    """Motion, residual and derivatives at a point."""
    return _evaluate_called(system, forces, omega, level)


def factorise(system: AnySystem, state: State, omega: float, level: float, border: Border) -> Bordered:
    """J on the unknowns, bordered by the derivative by the parameter and the path condition."""
    return _factorise_called(system, state, omega, level, border)


def newton_step(
    system: AnySystem, state: State, omega: float, level: float, border: Border, short: float, bordered: Bordered
) -> tuple[Array, float, float]:
    """Newton's change of the unknowns, of the parameter, and of a force level that holds an amplitude; short: by how much the
    path condition is missed."""
    return _newton_step_called(system, state, omega, level, border, short, bordered)


def tangent(system: AnySystem, state: State, omega: float, level: float, by_level: bool, bordered: Bordered) -> Direction:
    """The direction of the curve at a point, with the factors there."""
    return _tangent_called(system, state, omega, level, by_level, bordered)


_EVALUATE = iteration.evaluate, mode_iteration.evaluate_mode
_FACTORISE = iteration.factorise, mode_iteration.factorise_mode
_NEWTON_STEP = iteration.newton_step, mode_iteration.newton_step_mode
_TANGENT = iteration.tangent, mode_iteration.tangent_mode


def _chosen(system: Any, forced: Any, mode: Any) -> Any:
    """Of two kernels that of a system, or of its type while a kernel is compiled."""
    return mode if getattr(system, "instance_class", type(system)) is ModeSystem else forced


@overload(evaluate, strict=False, inline="always")
def _evaluate(system: Any, forces: Any, omega: Any, level: Any) -> Any:
    part = _chosen(system, *_EVALUATE)
    return lambda system, forces, omega, level: part(system, forces, omega, level)


@overload(factorise, strict=False, inline="always")
def _factorise(system: Any, state: Any, omega: Any, level: Any, border: Any) -> Any:
    part = _chosen(system, *_FACTORISE)
    return lambda system, state, omega, level, border: part(system, state, omega, level, border)


@overload(newton_step, strict=False, inline="always")
def _newton_step(system: Any, state: Any, omega: Any, level: Any, border: Any, short: Any, bordered: Any) -> Any:
    part = _chosen(system, *_NEWTON_STEP)
    return lambda system, state, omega, level, border, short, bordered: part(system, state, omega, level, border, short, bordered)


@overload(tangent, strict=False, inline="always")
def _tangent(system: Any, state: Any, omega: Any, level: Any, by_level: Any, bordered: Any) -> Any:
    part = _chosen(system, *_TANGENT)
    return lambda system, state, omega, level, by_level, bordered: part(system, state, omega, level, by_level, bordered)


@kernel
def _evaluate_called(system: AnySystem, forces: Array, omega: float, level: float) -> State:
    """`evaluate` for calls from Python."""
    return boxed(evaluate(view(system), forces, omega, level))


@kernel
def _factorise_called(system: AnySystem, state: State, omega: float, level: float, border: Border) -> Bordered:
    """`factorise` for calls from Python."""
    return boxed(factorise(view(system), state, omega, level, border))


@kernel
def _newton_step_called(
    system: AnySystem, state: State, omega: float, level: float, border: Border, short: float, bordered: Bordered
) -> tuple[Array, float, float]:
    """`newton_step` for calls from Python."""
    return boxed(newton_step(view(system), state, omega, level, border, short, bordered))


@kernel
def _tangent_called(system: AnySystem, state: State, omega: float, level: float, by_level: bool, bordered: Bordered) -> Direction:
    """`tangent` for calls from Python."""
    return boxed(tangent(view(system), state, omega, level, by_level, bordered))


@kernel
def solve(system: System, bordered: Bordered, right: Array) -> None:
    """`iteration.solve` for calls from Python."""
    iteration.solve(view(system), bordered, right)


def placed(system: AnySystem) -> Placed:
    """A system where kernels read it."""
    return Placed(system, SystemAddress if isinstance(system, System) else ModeSystemAddress)


def compile_parts(system: AnySystem) -> None:
    """Compile the parts for a kind of system, or take them from disk."""
    compile_contact_forces(system.table)
    compiled(*(_chosen(system, *part) for part in (_EVALUATE, _FACTORISE, _NEWTON_STEP, _TANGENT)))
    if isinstance(system, System):
        on_states.compile_on_states(system)
