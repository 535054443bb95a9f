"""Contact parameters from measured frequency responses: several tests at once, by least squares with exact derivatives.

`computed_response.py` computes a test at its points, `response_fit.py` holds variables and residuals; this is the front door.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from threadpoolctl import threadpool_limits

from stickslip.analyses.arguments import fineness_of, made
from stickslip.analyses.identification.computed_response import FittedTest
from stickslip.analyses.identification.response_fit import GAIN, PHASE, FreeParameter, ResponseFit
from stickslip.analyses.identification.response_result import dataset_of_fit, misfit, notes_of_fit, summary
from stickslip.checks import Array, among, between, fault, of_kind, positive, seed_of, several, unique
from stickslip.harmonic.balance import HarmonicBalance
from stickslip.harmonic.orders import attribute
from stickslip.measurement.measured_response import MeasuredResponse
from stickslip.problem import Problem
from stickslip.results.result import Result
from stickslip.runs.work import Progress, checked_progress
from stickslip.solve.continuation import first_point
from stickslip.starts.space import Rules, Sharing, StartSpace, refuse_forgetful, start_space

if TYPE_CHECKING:
    import xarray as xr

StartStates = Literal["virgin", "free"]


@dataclass(frozen=True, eq=False)
class ResponseIdentification(
    Result,
    figure="response_identification:measured_and_computed",
    misfits="response_identification:misfits",
    intervals="response_identification:intervals",
):
    """`dataset`: value, low, high (parameter) of the 95 % intervals and their correlation; own_value (test, own) of what each
    test has by itself; along the tests (test, point) frequency, measured and computed response per force, and phase; misfit
    (test), the root mean square of computed − measured relative to the largest measured; held_out (test), the same with the
    parameters of the other tests; start_variables. `notes`: what the tests cannot say.
    """

    dataset: xr.Dataset
    problem_of: Callable[..., Problem]
    notes: tuple[str, ...]

    @property
    def values(self) -> dict[str, float]:
        """The parameters that all tests have in common."""
        return {
            str(name): float(v) for name, v in zip(self.dataset["parameter"].values, self.dataset["value"].values, strict=True)
        }

    def problem(self, **others: Any) -> Problem:
        """The problem with the identified parameters, for predictions; others: what each test has by itself, settings."""
        return self.problem_of(**{**self.values, **others})

    def __str__(self) -> str:
        """Parameters with intervals, misfit of each test, notes."""
        return "\n".join(summary(self.dataset))


def identify_response(
    problem_of: Callable[..., Problem],
    parameters: Mapping[str, FreeParameter | tuple[float, float, float]],
    tests: Sequence[MeasuredResponse],
    *,
    start_states: StartStates = "virgin",
    rule: Rules = "traction_ratio",
    share: Sharing = "element",
    start_deviation: float = 0.5,
    leave_one_out: bool = False,
    tries: int = 8,
    seed: int = 0,
    evaluations: int = 60,
    harmonics: int | Sequence[int] = 5,
    samples: int = 256,
    progress: Progress = lambda fraction, text: None,
) -> ResponseIdentification:
    """Parameters θ of a problem that minimise Σ |h(θ) − h_measured|²/σ², h the response per force at every point of all tests.

    problem_of(**values, **settings of the test) makes the problem. parameters: {name: FreeParameter, or (start, low, high)},
    anything that the problem depends on. tests: measured responses at several force levels, preloads or mountings; each point
    takes its own measured force, or its own measured response. Derivatives are exact, by the implicit function theorem.

    start_states: "virgin", those of the problem; or "free": each test has start variables of its own (`rule`, `share` as for
    `response_samples`), with a normal prior of mean 0 and start_deviation: tests that are equal by name differ in how their
    contacts were put together. tries: further starts between the bounds, of which the best is taken.
    leave_one_out: fit again without each test and compare it with what the others predict; its own variables are fitted to it.

    Intervals hold 95 % with errors as large as the residuals; they do not know of errors that all points share.
    """
    free, several_tests = _parameters(parameters), _tests(tests)
    among("start_states", start_states, ("virgin", "free"))
    fineness = fineness_of(harmonics, samples)
    checked_progress(progress)
    fit_settings = (between("tries", tries, 0), seed_of(seed), between("evaluations", evaluations, 1))
    models = [FittedTest.of(test, problem_of, *fineness) for test in several_tests]
    with threadpool_limits(1, user_api="blas"):
        spaces = [_space(model, free, rule, share) if start_states == "free" else None for model in models]
        models = [replace(model, space=space) for model, space in zip(models, spaces, strict=True)]
        fit = ResponseFit(models, free, positive("start_deviation", start_deviation))
        progress(0.0, "fitting responses")
        x = fit.solved(fit.best_start(*fit_settings[:2]), fit_settings[2])
        held_out = _held_out(fit, x, fit_settings[2], progress) if leave_one_out and len(models) > 1 else None
        if held_out is not None:
            fit.forget()
        fit.residuals(x)
        statistics = fit.statistics(x)
    dataset = dataset_of_fit(fit, x, statistics, held_out)
    notes = tuple(notes_of_fit(fit, x, statistics, dataset))
    dataset.attrs |= {"harmonics": attribute(fineness[0]), "samples": fineness[1], "notes": "\n".join(notes)}
    dataset.attrs["start_states"] = start_states
    return ResponseIdentification(dataset, problem_of, notes)


def _parameters(parameters: Mapping[str, FreeParameter | tuple[float, float, float]]) -> dict[str, FreeParameter]:
    """The free parameters, checked; at least one that all tests share."""
    found = {}
    for name, given in of_kind("parameters", parameters, Mapping).items():  # type: ignore[type-abstract]
        if not isinstance(given, FreeParameter) and len(given) != 3:
            raise fault(f"parameter {name!r}", "must be a FreeParameter or (start, low, high)", given)
        found[name] = given if isinstance(given, FreeParameter) else FreeParameter(*given)
        if name in (GAIN, PHASE, "start"):
            raise fault("The name of a parameter", f"must not be {name}, which means a variable of a test", name)
    if not any(not free.each_test for free in found.values()):
        raise fault("parameters", "must hold one that all tests have in common", list(found))
    return found


def _tests(tests: Sequence[MeasuredResponse]) -> list[MeasuredResponse]:
    """The tests, checked and with names."""
    found = [of_kind("A test", test, MeasuredResponse) for test in several("tests", tests)]
    if not found:
        raise fault("tests", "must hold at least one measured response", [])
    named = [test if test.name else replace(test, name=f"test {k}") for k, test in enumerate(found, start=1)]
    unique("Names of tests", [test.name for test in named])
    return named


def _space(model: FittedTest, free: Mapping[str, FreeParameter], rule: Rules, share: Sharing) -> StartSpace:
    """The start states of a test, scaled by its first point."""
    problem = made(model.problem_of, **{name: each.start for name, each in free.items()}, **model.test.settings)
    refuse_forgetful(problem)
    balance = HarmonicBalance(problem, model.harmonics, model.samples)
    omega = 2.0 * np.pi * float(np.asarray(model.test.frequency)[0])
    found = first_point(balance, omega, float(np.asarray(model.test.force)[0]))
    return start_space(balance, found.evaluation, rule, share)


def _held_out(fit: ResponseFit, x: Array, evaluations: int, progress: Progress) -> Array:
    """Misfit of each test with the shared parameters of the others; what it has by itself is fitted to it."""
    found = np.full(len(fit.tests), np.nan)
    shared = [k for k, variable in enumerate(fit.variables) if variable.test < 0]
    for t in range(len(fit.tests)):
        progress((t + 1) / (len(fit.tests) + 1), "leaving tests out")
        fit.forget()
        others = [k for k in range(len(fit.tests)) if k != t]
        rest = ResponseFit([fit.tests[k] for k in others], fit.free, fit.start_deviation)
        begin = [k for k, v in enumerate(fit.variables) if v.test != t]
        fitted = rest.solved(x[begin], evaluations)
        alone = ResponseFit([fit.tests[t]], fit.free, fit.start_deviation)
        own = [k for k, v in enumerate(fit.variables) if v.test == t]
        start = np.concatenate([fitted[: len(shared)], x[own]])
        found[t] = misfit(alone, alone.solved_own(start, len(shared), evaluations), 0)
    return found
