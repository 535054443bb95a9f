"""Derivatives of the response with respect to any parameter of a problem: stiffness, friction, mass, geometry."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.solved_points import SolvedPoints
from stickslip.model.contact.point import contact_table
from stickslip.model.problem import Problem
from stickslip.model.problem.speed import refuse_speed
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance
from stickslip.solve.balance.fourier import complex_harmonics
from stickslip.solve.continuation.sensitivity import mean_slopes, parameter_slopes, respond, solved_factors
from stickslip.solve.curves.curve import solve_curve
from stickslip.support.checks import Array, Index, InputError, fault, finite, of_kind, positive
from stickslip.support.late import xr
from stickslip.support.machine import one_blas_thread
from stickslip.support.outcome import Outcome

RELATIVE_STEP = 1e-5
"""Of the differences of matrices and tables, relative to the value of the parameter."""

SCALED_STEP = 1e-7
"""The shortest step, as a share of what would change the problem as a whole; rounding (1e-16) is still negligible at it."""

SEEN = 1e-12
"""A relative change of an entry that is not rounding."""

WIDER = 1e5
"""By how much a trial step grows that no entry of the problem shows."""


@dataclass(frozen=True)
class Parameter:
    """A parameter of a problem: its value, and the problem it makes of another value.

    The derivative is taken by differences of the equations over values beside it, which `problem` must take: a part in 1e5 away,
    or further where the value is near zero for what it acts on (a gap of 0, a mass of 1e-12 kg beside one of 1 kg).
    `single_blade`, say, takes any preload mass once its six contact parameters are given.
    """

    value: float
    problem: Callable[[float], Problem]


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Response X (outputs, H+1) [m] at one frequency of the excitation, and its derivatives. Of motions over several periods the
    harmonics are those of all `periods` together.

    by_parameter: {name: dX/dθ (outputs, H+1)}; by_start: dX/d(start value) (elements, outputs, H+1) of the friction elements
    `elements` whose start state acts on the response (the others have none).
    """

    frequency: float
    response: Array
    by_parameter: Mapping[str, Array]
    elements: Index
    by_start: Array
    periods: int = 1

    def amplitude_slopes(self) -> dict[str, Array]:
        """d|X_1|/dθ of every output at the frequency of the excitation, by name."""
        main = self.response[..., self.periods]
        return {
            name: np.asarray(np.real(np.conj(main) * slope[..., self.periods]) / np.abs(main))
            for name, slope in self.by_parameter.items()
        }


def _arrays(problem: Problem) -> tuple[NDArray[Any], ...]:
    structure, highest = problem.structure, max((h for force in problem.forces for h in force.amplitudes), default=0)
    linear = (structure.M, structure.K, problem.mean_stiffness, problem.C, problem.B, problem.output_rows)
    return *linear, problem.static_load, problem.load_powers(highest), *contact_table(problem.contacts)


def sensitivity(
    problem: Problem,
    frequency: float,
    parameters: Mapping[str, Parameter],
    force: float = 1.0,
    harmonics: int | Sequence[int] = 5,
    samples: int = 256,
) -> Sensitivity:
    """dX/dθ at a frequency in Hz by the implicit function theorem, for each parameter and for the start states.

    parameters: {name: Parameter(value, problem_of)}, where problem_of(value) is `problem`, say
    Parameter(0.5, lambda mu: rig(friction=mu)); refused where it is another. The point is solved afresh: where a curve overhangs,
    `ForcedResponse.sensitivity` takes the one that is meant.
    """
    refuse_speed(of_kind("problem", problem, Problem), "A sensitivity")
    _check_all(parameters, problem)
    positive("frequency", frequency)
    finite("force", force)
    with one_blas_thread():
        balance = HarmonicBalance(problem, harmonics, samples)
        omega = 2.0 * np.pi * frequency
        curve = solve_curve(balance, (omega, omega), force, exactly=True)
        if curve.outcome != Outcome.CONVERGED:
            raise fault("The point", "must be solvable", f"{frequency:g} Hz", curve.message)
        return _slopes(balance, curve.points[0].evaluation, parameters)


def point_sensitivity(
    dataset: "xr.Dataset", problem: Problem, case: int, point: int, parameters: Mapping[str, Parameter]
) -> Sensitivity:
    """What `ForcedResponse.sensitivity` says."""
    _check_all(parameters, problem)
    points = SolvedPoints(dataset, problem)
    with one_blas_thread():
        balance, evaluation = points.at_one_speed(case, point)
        if problem.speed is not None:
            parameters = {name: _at_frequency(parameter, evaluation.point.omega) for name, parameter in parameters.items()}
        return _slopes(balance, evaluation, parameters)


def _at_frequency(parameter: Parameter, omega: float) -> Parameter:
    """The parameter of the problem at the rotor speed of a frequency, rad/s."""
    return Parameter(parameter.value, lambda value: parameter.problem(value).at_frequency(omega))


def _check_all(parameters: Mapping[str, Parameter], problem: Problem) -> None:
    for name, parameter in of_kind("parameters", parameters, Mapping).items():  # type: ignore[type-abstract]
        of_kind(f"parameter {name!r}", parameter, Parameter)
        # The same but for rounding: matrices, contacts, loads and outputs.
        pairs = list(zip(_arrays(parameter.problem(parameter.value)), _arrays(problem), strict=True))
        if not all(
            a.shape == b.shape and np.allclose(a, b, rtol=1e-9, atol=1e-12 * np.abs(b).max(initial=0.0)) for a, b in pairs
        ):
            remedy = "A derivative is taken where the problem is: give the value that it was made with."
            raise fault(f"parameter {name!r}", "must make the problem itself of its value", parameter.value, remedy)


def _slopes(balance: HarmonicBalance, evaluation: Evaluation, parameters: Mapping[str, Parameter]) -> Sensitivity:
    """The derivatives at a solved point, at its frequency."""
    factors = solved_factors(balance, evaluation)
    by_parameter = {}
    for name, parameter in parameters.items():
        beside = partial(_beside, name, parameter)
        step = _step(parameter, balance, evaluation)
        forces, motion = parameter_slopes(beside, parameter.value, balance, evaluation.point, step)
        change = respond(balance, evaluation, factors, forces[None], motion[None])
        by_parameter[name] = complex_harmonics(change.motion[0, balance.rows :])
    elements, rows, means = mean_slopes(balance, evaluation)
    slopes = np.zeros((elements.size, balance.rows, balance.columns))
    slopes[np.arange(elements.size), rows, 0] = means
    by_start = respond(balance, evaluation, factors, slopes).motion[:, balance.rows :]
    response, periods = complex_harmonics(evaluation.w[balance.rows :]), balance.periods
    frequency = periods * evaluation.point.omega / (2.0 * np.pi)
    return Sensitivity(frequency, response, by_parameter, elements, complex_harmonics(by_start), periods)


def _step(parameter: Parameter, balance: HarmonicBalance, evaluation: Evaluation) -> float:
    """The step of the differences: relative to the value, and not below what rounding leaves of it."""
    own = RELATIVE_STEP * abs(parameter.value)
    trial = own or RELATIVE_STEP
    problem, least = parameter.problem(parameter.value), 0.0
    with suppress(InputError):
        for _ in range(4):
            reach = _reach(problem, parameter.problem(parameter.value + trial), evaluation)
            if np.isfinite(reach):
                least = SCALED_STEP * reach * trial
                parameter.problem(parameter.value + least), parameter.problem(parameter.value - least)
                return max(own, least)
            trial *= WIDER
    return own or RELATIVE_STEP


def _reach(problem: Problem, other: Problem, evaluation: Evaluation) -> float:
    """How many times the change from a problem to another would matter wholly to it; infinite where rounding hides the change."""
    reach = np.inf
    for before, after, scale in zip(_arrays(problem), _arrays(other), _scales(problem, evaluation), strict=True):
        change = np.abs(after - before)
        seen = change > SEEN * np.maximum(np.abs(before), np.abs(after))
        reach = min(reach, float(np.min((np.broadcast_to(scale, change.shape)[seen] / change[seen]), initial=np.inf)))
    return reach


def _scales(problem: Problem, evaluation: Evaluation) -> tuple[Array, ...]:
    """What a whole change of each of `_arrays` is: of matrices the stiffness, damping and inertia of their rows together, of
    contacts and loads what balances the forces and the motion of the solution.
    """
    omega, powers, table = evaluation.point.omega, _arrays(problem)[7], evaluation.table
    loads = omega ** np.arange(len(powers))[:, None, None] * np.abs(evaluation.point.level * powers)
    forces = (evaluation.point.forces - evaluation.residual, problem.static_load, loads)
    force = max(1e-300, *(float(np.abs(each).max(initial=0.0)) for each in forces))
    width = max(1e-300, float(np.abs(evaluation.w).max(initial=0.0)))
    diagonal = np.abs(problem.stuck_stiffness + problem.mean_stiffness).diagonal() + omega * np.abs(problem.C).diagonal()
    rows = np.sqrt(np.abs(np.outer(*2 * [diagonal + omega**2 * problem.structure.M.diagonal()])))
    linear = (rows / omega**2, rows, rows, rows / omega, np.ones(1), np.ones(1))
    start = np.choose(table.start_kind, [np.full_like(table.start_value, size) for size in (width, 1.0, force)])
    contacts = {
        "normal_stiffness": np.maximum(table.normal_stiffness, force / width),
        "normal_constant": np.full(1, force),
        "stiffness": np.maximum(table.stiffness, force / width),
        "friction": np.ones(1),
        "constant_limit": np.full(1, force),
        "bend": np.full(1, force),
        "change": np.ones(1),
        "start_value": start,
        "parameter": np.concatenate([c.law.parameter_scales(force, width) for c in problem.contacts] or [np.zeros(0)]),
    }
    tables = (contacts.get(field, np.full(1, np.inf)) for field in table._fields)
    return (*linear, np.full(1, force), force / omega ** np.arange(len(powers))[:, None, None], *tables)


def _beside(name: str, parameter: Parameter, value: float) -> Problem:
    """The problem of a value beside the parameter's own; a refusal says where this value comes from."""
    try:
        return parameter.problem(value)
    except InputError as reason:
        raise InputError(
            f"parameter {name!r} must make a problem of values beside {parameter.value!r} too, since its derivative is taken by "
            f"differences over a part in 1e5, but of {value!r} it makes none: {reason} Where a rig knows only some values, give "
            "what stands behind them too, or vary the contact or force that they set."
        ) from reason
