"""Derivatives of the response at a frequency with respect to any parameter of a problem: stiffness, friction, mass, geometry."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from stickslip.checks import Array, Index, fault, finite, of_kind, positive
from stickslip.contact.table import contact_table
from stickslip.harmonic.balance import HarmonicBalance
from stickslip.harmonic.fourier import complex_harmonics
from stickslip.outcome import Outcome
from stickslip.problem import Problem
from stickslip.solve.curve import solve_curve
from stickslip.solve.sensitivity import parameter_slopes, respond, solved_factors, start_slopes

RELATIVE_STEP = 1e-5


@dataclass(frozen=True)
class Parameter:
    """A parameter of a problem: its value, and the problem it makes of another value."""

    value: float
    problem: Callable[[float], Problem]


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Response X (outputs, H+1) [m] at one frequency, and its derivatives.

    by_parameter: {name: dX/dθ (outputs, H+1)}; by_start: dX/d(start value) (elements, outputs, H+1) of the friction elements
    `elements` whose start state acts on the response (the others have none).
    """

    frequency: float
    response: Array
    by_parameter: Mapping[str, Array]
    elements: Index
    by_start: Array

    def amplitude_slopes(self) -> dict[str, Array]:
        """d|X_1|/dθ of every output, by name."""
        return {name: _amplitude_slope(self.response, slope) for name, slope in self.by_parameter.items()}


def _amplitude_slope(response: Array, slope: Array) -> Array:
    return np.asarray(np.real(np.conj(response[..., 1]) * slope[..., 1]) / np.abs(response[..., 1]))


def _check(name: str, parameter: Parameter, problem: Problem) -> None:
    of_kind(f"parameter {name!r}", parameter, Parameter)
    if not _alike(parameter.problem(parameter.value), problem):
        remedy = "A derivative is taken where the problem is: give the value that it was made with."
        raise fault(f"parameter {name!r}", "must make the problem itself of its value", parameter.value, remedy)


def _alike(one: Problem, other: Problem) -> bool:
    """Whether two problems are the same but for rounding: their matrices, contacts and outputs."""
    pairs = list(zip(_arrays(one), _arrays(other), strict=True))
    return all(a.shape == b.shape and np.allclose(a, b, rtol=1e-9, atol=1e-12 * np.abs(b).max(initial=0.0)) for a, b in pairs)


def _arrays(problem: Problem) -> tuple[NDArray[Any], ...]:
    return problem.structure.M, problem.structure.K, problem.B, problem.output_rows, *contact_table(problem.contacts)


def sensitivity(
    problem: Problem,
    frequency: float,
    parameters: Mapping[str, Parameter],
    force: float = 1.0,
    harmonics: int = 5,
    samples: int = 256,
) -> Sensitivity:
    """dX/dθ at a frequency in Hz by the implicit function theorem, for each parameter and for the start states.

    parameters: {name: Parameter(value, problem_of)}, where problem_of(value) is `problem`, say
    Parameter(0.5, lambda mu: rig(friction=mu)); refused where it is another.
    """
    of_kind("problem", problem, Problem)
    for name, parameter in of_kind("parameters", parameters, Mapping).items():  # type: ignore[type-abstract]
        _check(name, parameter, problem)
    positive("frequency", frequency)
    finite("force", force)
    with threadpool_limits(1, user_api="blas"):
        balance = HarmonicBalance(problem, harmonics, samples)
        omega = 2.0 * np.pi * frequency
        curve = solve_curve(balance, (omega, omega), force, exactly=True)
        if curve.outcome != Outcome.CONVERGED:
            raise fault("The point", "must be solvable", f"{frequency:g} Hz", curve.message)
        evaluation = curve.points[0].evaluation
        factors = solved_factors(balance, evaluation)
        by_parameter = {}
        for name, parameter in parameters.items():
            step = RELATIVE_STEP * (abs(parameter.value) or 1.0)
            forces, motion = parameter_slopes(parameter.problem, parameter.value, balance, evaluation.point, step)
            change = respond(balance, evaluation, factors, forces[None], motion[None])
            by_parameter[name] = complex_harmonics(change.motion[0, balance.rows :])
        elements, slopes = start_slopes(balance, evaluation)
        by_start = respond(balance, evaluation, factors, slopes).motion[:, balance.rows :]
    response = complex_harmonics(evaluation.w[balance.rows :])
    return Sensitivity(frequency, response, by_parameter, elements, complex_harmonics(by_start))
