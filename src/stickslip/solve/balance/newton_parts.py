"""Parts of a Newton iteration for either kind of balance, chosen by the type of the system when a kernel is compiled.

Newton's method and the continuation are so the same for forced motions (`iteration`) and for nonlinear modes (`mode_iteration`).
"""

from collections.abc import Callable

from stickslip.solve.balance import iteration, mode_iteration
from stickslip.solve.balance.contact_forces import compile_contact_forces
from stickslip.solve.balance.mode_iteration import ModeSystem, ModeSystemAddress, compile_on_coordinates
from stickslip.solve.balance.newton_matrix import compile_on_states
from stickslip.solve.balance.system import Border, Bordered, Direction, State, System, SystemAddress
from stickslip.support.checks import Array
from stickslip.support.kernels import boxed, by_types, compiled, kernel
from stickslip.support.kernels.views import Placed, view

AnySystem = System | ModeSystem

evaluate: Callable[[AnySystem, Array, float, float], State] = by_types(iteration.evaluate, mode_iteration.evaluate_mode)
factorise: Callable[[AnySystem, State, float, float, Border], Bordered] = by_types(
    iteration.factorise, mode_iteration.factorise_mode
)
newton_step: Callable[[AnySystem, State, float, float, Border, float, Bordered], tuple[Array, float, float]] = by_types(
    iteration.newton_step, mode_iteration.newton_step_mode
)
tangent: Callable[[AnySystem, State, float, float, bool, Bordered], Direction] = by_types(
    iteration.tangent, mode_iteration.tangent_mode
)


@kernel
def evaluate_called(system: AnySystem, forces: Array, omega: float, level: float) -> State:
    """Motion, residual and derivatives at a point."""
    return boxed(evaluate(view(system), forces, omega, level))


@kernel
def factorise_called(system: AnySystem, state: State, omega: float, level: float, border: Border) -> Bordered:
    """J on the unknowns, bordered by the derivative by the parameter and the path condition."""
    return boxed(factorise(view(system), state, omega, level, border))


@kernel
def newton_step_called(
    system: AnySystem, state: State, omega: float, level: float, border: Border, short: float, bordered: Bordered
) -> tuple[Array, float, float]:
    """Newton's change of the unknowns, of the parameter, and of a force level that holds an amplitude; short: by how much the
    path condition is missed."""
    return boxed(newton_step(view(system), state, omega, level, border, short, bordered))


@kernel
def tangent_called(system: AnySystem, state: State, omega: float, level: float, by_level: bool, bordered: Bordered) -> Direction:
    """The direction of the curve at a point, with the factors there."""
    return boxed(tangent(view(system), state, omega, level, by_level, bordered))


@kernel
def solve_called(system: System, bordered: Bordered, right: Array) -> None:
    """Overwrite right-hand sides with the solutions."""
    iteration.solve(view(system), bordered, right)


def kind_of(system: AnySystem) -> int:
    """Which of the two kinds a system is of, as `compiled` counts them."""
    return 0 if isinstance(system, System) else 1


def placed(system: AnySystem) -> Placed:
    """A system where kernels read it."""
    return Placed(system, SystemAddress if isinstance(system, System) else ModeSystemAddress)


def compile_parts(system: AnySystem) -> None:
    """Compile the parts for a kind of system, or take them from disk."""
    compile_contact_forces(system.table)
    compiled(evaluate, factorise, newton_step, tangent, number=kind_of(system))
    if isinstance(system, System):
        compile_on_states(system)
    else:
        compile_on_coordinates(system)
