"""Contact parameters from measured frequency responses: several tests at once, by least squares with exact derivatives.

`computed_response.py` computes a test at its points, `response_fit.py` holds variables and residuals; this is the front door.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, fields, replace
from functools import partial
from hashlib import sha256
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from stickslip.analyses.arguments import fineness_of, made, maker
from stickslip.laboratory.identification.computed_response import FittedTest
from stickslip.laboratory.identification.enclosed_test import EnclosedTest
from stickslip.laboratory.identification.enclosure import enclosed, notes_on_bounds, resumed, with_bounds
from stickslip.laboratory.identification.least_friction import friction_bounds
from stickslip.laboratory.identification.mistakes import POOR, amplitudes_alone, notes_on_mistakes
from stickslip.laboratory.identification.outliers import fitted_without
from stickslip.laboratory.identification.response_fit import GAIN, PHASE, FreeParameter, ResponseFit
from stickslip.laboratory.identification.response_result import dataset_of_fit, misfit, notes_of_fit
from stickslip.laboratory.identification.response_summary import summary
from stickslip.laboratory.measurement.measured_response import MeasuredResponse, flat_top
from stickslip.laboratory.measurement.response_scales import assumed_units, joined, mixed_units
from stickslip.model.problem import Problem
from stickslip.results.result import Result
from stickslip.runs.cases import all_cases
from stickslip.runs.work import Arrays, Checkpoint, Progress, Report, Workers
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.orders import Harmonics, attribute
from stickslip.solve.continuation.continuation import first_point
from stickslip.solve.starts.space import Rules, Sharing, StartSpace, refuse_forgetful, rules_of, start_space
from stickslip.support.checks import (
    Array,
    InputError,
    among,
    between,
    fault,
    numbers,
    of_kind,
    positive,
    seed_of,
    several,
    truth,
    unique,
)
from stickslip.support.machine import one_blas_thread

if TYPE_CHECKING:
    import xarray as xr

StartStates = Literal["virgin", "free", "bounds"]


@dataclass(frozen=True, eq=False, repr=False)
class ResponseIdentification(Result):
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
    checkpoint: Checkpoint | None = None,
    progress: Progress = lambda fraction, text: None,
) -> ResponseIdentification:
    """Parameters θ of a problem that minimise Σ |ln h(θ) − ln h_measured|²/σ², h the response per force at every point.

    σ is the relative error of a test; where that is one of its largest response, h takes the place of ln h.
    problem_of(**values, **settings of the test) makes the problem. parameters: {name: FreeParameter, or (start, low, high)},
    anything that the problem depends on. tests: measured responses at several force levels, preloads or mountings; each point
    takes its own measured force, or its own measured response. Derivatives are exact, by the implicit function theorem.

    start_states: "virgin", those of the problem; or "free": each test has start variables of its own (`rule`, `share` as for
    `response_samples`), with a normal prior of mean 0 and start_deviation: tests that are equal by name differ in how their
    contacts were put together; or "bounds": each measured amplitude is compared with the bounds of the response over all start
    states. A point inside them costs nothing, one outside its distance to the nearer bound, h; phases are not used. Intervals
    are then those of the profile: all values at which, with the others adapted, the sum of squares is at most 3.84 above the
    least one; the values are a point inside. tries: further starts between the bounds, of which the best is taken.
    leave_one_out: fit again without each test and compare it with what the others predict; its own variables are fitted to it.

    Intervals hold 95 % with errors as large as the residuals. Where these go together along the curves, they count by the number
    of independent ones, and from three tests on an interval is at least as wide as the tests disagree (cluster-robust errors).
    So it holds what differs from test to test; what all tests share, such as a wrong contact law, it does not.
    """
    rules_of(rule)
    among("share", share, get_args(Sharing))
    H, Nt = fineness_of(harmonics, samples)
    work = ResponseIdentificationWork(
        maker(problem_of),
        free=_parameters(parameters),
        tests=_tests(tests),
        start_states=among("start_states", start_states, get_args(StartStates)),
        rule=rule,
        share=share,
        start_deviation=positive("start_deviation", start_deviation),
        leave_one_out=truth("leave_one_out", leave_one_out),
        tries=between("tries", tries, 0),
        seed=seed_of(seed),
        evaluations=between("evaluations", evaluations, 1),
        harmonics=H,
        samples=Nt,
    )
    return work.finished(all_cases(work, checkpoint, 1, progress), checkpoint, 1, progress)


@dataclass(frozen=True, eq=False)
class ResponseIdentificationWork:
    """An identification as one case, the fit; `finished` then leaves out its tests one by one, if that is asked for.

    factors: of parameters that are factors, least and largest value of the problem that they multiply, if any, and its unit.
    """

    problem_of: Callable[..., Problem]
    _: KW_ONLY
    free: Mapping[str, FreeParameter]
    tests: Sequence[MeasuredResponse]
    start_states: str
    rule: Rules
    share: Sharing
    start_deviation: float
    leave_one_out: bool
    tries: int
    seed: int
    evaluations: int
    harmonics: Harmonics
    samples: int
    remarks: tuple[str, ...] = ()
    factors: Mapping[str, tuple[tuple[float, ...], str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for test in self.tests:
            twice = sorted({*test.settings} & {*self.free})
            if twice:
                raise fault(f"The settings of {test.name}", "must not name what is free", twice)
            problem = self._at_the_start(test)
            if not 0 <= test.output < len(problem.outputs):
                raise fault(f"The output of {test.name}", f"must be a number from 0 to {len(problem.outputs) - 1}", test.output)

    def _at_the_start(self, test: MeasuredResponse) -> Problem:
        """The problem of a test at the start values."""
        return made(partial(self.problem_of, **test.settings), **{name: each.start for name, each in self.free.items()})

    @property
    def names(self) -> tuple[str, ...]:
        """Everything that the fit depends on."""
        digest = sha256()
        for test in self.tests:
            digest.update(self._at_the_start(test).fingerprint.encode())
            for values in (test.frequency, test.amplitude, test.force, np.zeros(0) if test.phase is None else test.phase):
                digest.update(np.asarray(values, dtype=float).tobytes())
            digest.update(
                repr(replace(test, frequency=(1, 2, 3), amplitude=1.0, force=1.0, phase=None, free_phase=False)).encode()
            )
            digest.update(repr(test.free_phase).encode())
        rest = [getattr(self, one.name) for one in fields(self) if one.name not in ("problem_of", "tests")]
        return (f"identification of responses {digest.hexdigest()}, {rest!r}",)

    @property
    def words(self) -> tuple[str, ...]:
        return ("fitting responses",)

    def prepare(self) -> None:
        """Nothing: there is one case, and this process computes it."""

    def fit(self) -> ResponseFit:
        """The least squares, before its first evaluation."""
        if self.start_states == "bounds":
            about = (self.problem_of, (self.harmonics, self.samples), (self.rule, self.share, self.seed))
            return ResponseFit([EnclosedTest.of(test, *about) for test in self.tests], self.free)
        models = [FittedTest.of(test, self.problem_of, self.harmonics, self.samples) for test in self.tests]
        if self.start_states == "free":
            models = [replace(model, space=self._space(model)) for model in models]
        return ResponseFit(models, self.free, self.start_deviation)

    def _space(self, model: FittedTest) -> StartSpace:
        """The start states of a test, scaled by its first point."""
        problem = self._at_the_start(model.test)
        refuse_forgetful(problem)
        balance = HarmonicBalance(problem, model.harmonics, model.samples)
        omega = 2.0 * np.pi * float(np.asarray(model.test.frequency)[0])
        found = first_point(balance, omega, float(np.asarray(model.test.force)[0]))
        return start_space(balance, found.evaluation, self.rule, self.share)

    def solve(self, case: int, report: Report) -> Arrays:
        """The variables of the fit; and where tests have outliers, those without them."""
        started = time.process_time()
        with one_blas_thread():
            fit = self.fit()
            most = self.tries + self.evaluations
            fit.evaluated = lambda count: report(min(count / most, 0.95))
            x = fit.best(self.tries, self.seed, self.evaluations)
            found: dict[str, Any] = {}
            if self.start_states == "bounds":
                x, bounds = enclosed(fit, x, self.evaluations)
                found |= bounds
            else:
                x, found["least"] = friction_bounds(fit, x, self.evaluations)
            outliers = fitted_without(fit, x, self.evaluations)
            found |= {"x_without": outliers.x, "outlier": outliers.errors, "outlier_deviation": outliers.deviation}
            if max(misfit(fit, x, t) for t in range(len(fit.tests))) > POOR:
                found |= amplitudes_alone(fit, (self.tries, self.seed, self.evaluations))
        return {"x": x, "cpu_seconds": np.array(time.process_time() - started), **found}

    def finished(
        self, results: Sequence[Arrays], checkpoint: Checkpoint | None, workers: Workers, progress: Progress
    ) -> ResponseIdentification:
        """The result, from that of the fit."""
        held_out: Sequence[Arrays] = ()
        if self.leave_one_out and len(self.tests) > 1:
            held_out = all_cases(HeldOutWork(self, np.asarray(results[0]["x"])), checkpoint, workers, progress)
        return self.gathered(results, held_out)

    def gathered(self, results: Sequence[Arrays], held_out: Sequence[Arrays] = ()) -> ResponseIdentification:
        """The result of the variables that were found, and of the tests that were left out."""
        x = np.asarray(results[0]["x"])
        with one_blas_thread():
            fit = self.fit()
            if self.start_states == "bounds":
                resumed(fit, np.asarray(results[0]["starts"]))
            fit.residuals(x)
            statistics = fit.statistics(x)
            predicted = [float(one["misfit"]) for one in held_out] or [np.nan] * len(self.tests)
            dataset = dataset_of_fit(fit, x, statistics, np.array(predicted), results[0])
            mistakes = notes_on_mistakes(self.tests, dataset["misfit"].values, results[0]) if "plain_gain" in results[0] else []
            about = [(test.name, note) for test in self.tests for note in (*test.notes, *([] if mistakes else flat_top(test)))]
            scales = () if mistakes else mixed_units(self.tests)
            notes = (*mistakes, *assumed_units(self.tests), *scales, *joined(about), *self.remarks)
            if self.start_states == "bounds":
                dataset, statistics = with_bounds(dataset, fit, results[0]), statistics.without_curvature
                notes += tuple(notes_on_bounds(dataset, fit))
            notes += tuple(notes_of_fit(fit, x, statistics, dataset, known_mistake=bool(mistakes)))
        seconds = sum(float(one["cpu_seconds"]) for one in (*results, *held_out))
        dataset.attrs |= {"harmonics": attribute(self.harmonics), "samples": self.samples, "notes": "\n".join(notes)}
        dataset.attrs |= {"start_states": self.start_states, "cpu_seconds": seconds, "factors": json.dumps(self.factors)}
        return ResponseIdentification(dataset, self.problem_of, notes)


@dataclass(frozen=True, eq=False)
class HeldOutWork:
    """One case for each test: its misfit with the shared parameters of the others; what it has by itself is fitted to it.

    x: the variables of the fit to all tests, from which each begins.
    """

    whole: ResponseIdentificationWork
    x: Array

    @property
    def names(self) -> tuple[str, ...]:
        (name,) = self.whole.names
        return tuple(f"{name}, without {test.name}" for test in self.whole.tests)

    @property
    def words(self) -> tuple[str, ...]:
        return tuple(f"without {test.name}" for test in self.whole.tests)

    def prepare(self) -> None:
        """Nothing: the fit has compiled all."""

    def solve(self, case: int, report: Report) -> Arrays:
        """The misfit of a test."""
        started, x, evaluations = time.process_time(), self.x, self.whole.evaluations
        with one_blas_thread():
            fit = self.whole.fit()
            shared = [k for k, variable in enumerate(fit.variables) if variable.test < 0]
            rest = ResponseFit([fit.tests[k] for k in range(len(fit.tests)) if k != case], fit.free, fit.start_deviation)
            rest.evaluated = lambda count: report(min(count / evaluations, 0.95))
            fitted = rest.solved(x[[k for k, v in enumerate(fit.variables) if v.test != case]], evaluations)
            alone = ResponseFit([fit.tests[case]], fit.free, fit.start_deviation)
            own = [k for k, v in enumerate(fit.variables) if v.test == case]
            start = np.concatenate([fitted[: len(shared)], x[own]])
            found = misfit(alone, alone.solved_others(start, range(len(shared)), evaluations), 0)
        return {"misfit": np.array(found), "cpu_seconds": np.array(time.process_time() - started)}


def _parameters(parameters: Mapping[str, FreeParameter | tuple[float, float, float]]) -> dict[str, FreeParameter]:
    """The free parameters, checked; at least one that all tests share."""
    found = {}
    if not isinstance(parameters, Mapping):
        raise fault("parameters", "must be {name: (start, low, high)}", parameters)
    for name, given in parameters.items():
        if not isinstance(name, str):
            raise fault("The name of a parameter", "must be a text", name)
        found[name] = given if isinstance(given, FreeParameter) else _three(name, given)
        if name in (GAIN, PHASE, "start"):
            raise fault("The name of a parameter", f"must not be {name}, which means a variable of a test", name)
    if not any(not free.each_test for free in found.values()):
        raise fault("parameters", "must hold one that all tests have in common", list(found))
    return found


def _three(name: str, given: Any) -> FreeParameter:
    """The free parameter of (start, low, high)."""
    values = numbers(f"parameter {name!r}", given)
    if values.shape != (3,):
        raise fault(f"parameter {name!r}", "must be a FreeParameter or (start, low, high)", given)
    start, low, high = map(float, values)
    try:
        return FreeParameter(start, low, high)
    except InputError as error:
        raise InputError(f"parameter {name!r}: {error}") from None


def _tests(tests: Sequence[MeasuredResponse]) -> list[MeasuredResponse]:
    """The tests, checked and with names."""
    found = [of_kind("A test", test, MeasuredResponse) for test in several("tests", tests)]
    if not found:
        raise fault("tests", "must hold at least one measured response", [])
    named = [test if test.name else replace(test, name=f"test {k}") for k, test in enumerate(found, start=1)]
    unique("Names of tests", [test.name for test in named])
    return named
