"""Contact parameters from measured frequency responses: several tests at once, by least squares with exact derivatives."""

import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from functools import partial
from hashlib import sha256
from typing import Annotated, Any, Literal, get_args

import numpy as np

from stickslip.analyses.settings import OneOf, Rule, Sampled, Seed, Setting, Share, Whole, fineness_of, made, maker, takes
from stickslip.laboratory.identification.least_squares import FreeParameter
from stickslip.laboratory.identification.response.fit import GAIN, PHASE, FittedTest, ResponseFit
from stickslip.laboratory.identification.response.intervals import friction_bounds, statistics
from stickslip.laboratory.identification.response.mistakes import POOR, amplitudes_alone, fitted_without
from stickslip.laboratory.identification.response.result import ResponseIdentification, dataset_of_fit, notes
from stickslip.laboratory.measurement.measured_response import MeasuredResponse, by_joint
from stickslip.model.problem import Problem
from stickslip.results.schema import stacked
from stickslip.runs.cases import Arrays, Checkpoint, Progress, Report, Workers, all_cases, silent
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.fourier import attribute
from stickslip.solve.continuation.continuation import first_point
from stickslip.solve.starts.states import StartSpace, refuse_forgetful, rules_of, start_space
from stickslip.support.checks import Array, InputError, fault, numbers, of_kind, positive, several, truth, unique
from stickslip.support.machine import one_blas_thread

Starts = Literal["virgin", "free"]
StartStates = Annotated[Starts, Setting(OneOf(get_args(Starts)), "start states: those of the problem, or free for each test")]
OfValues = Annotated[Callable[..., Problem], Setting(maker)]
Three = tuple[float, float, float]


def free_parameters(name: str, parameters: Any) -> dict[str, FreeParameter]:
    """The free parameters, checked; at least one that all tests share."""
    found = {}
    if not isinstance(parameters, Mapping):
        raise fault(name, "must be {name: (start, low, high)}", parameters)
    for key, given in parameters.items():
        if not isinstance(key, str):
            raise fault("The name of a parameter", "must be a text", key)
        found[key] = given if isinstance(given, FreeParameter) else _three(key, given)
        if key in (GAIN, PHASE, "start"):
            raise fault("The name of a parameter", f"must not be {key}, which means a variable of a test", key)
    if not any(not free.each_test for free in found.values()):
        raise fault(name, "must hold one that all tests have in common", list(found))
    return found


def _three(name: str, given: Any) -> FreeParameter:
    """The free parameter of (start, low, high)."""
    values = numbers(f"parameter {name!r}", given)
    if values.shape != (3,):
        raise fault(f"parameter {name!r}", "must be a FreeParameter or (start, low, high)", given)
    try:
        return FreeParameter(*values.tolist())
    except InputError as error:
        raise InputError(f"parameter {name!r}: {error}") from None


def named_tests(name: str, tests: Any) -> list[MeasuredResponse]:
    """The tests, checked and with names."""
    found = [of_kind("A test", test, MeasuredResponse) for test in several(name, tests)]
    if not found:
        raise fault(name, "must hold at least one measured response", [])
    named = [test if test.name else replace(test, name=f"test {k}") for k, test in enumerate(found, start=1)]
    unique("Names of tests", [test.name for test in named])
    if 0 < sum(bool(test.joint) for test in named) < len(named):
        raise fault("joint", "must be named for all tests or for none", [test.joint for test in named])
    return named


@dataclass(frozen=True, eq=False)
class ResponseIdentificationWork(Sampled):
    """An identification as one case, the fit; `finished` then leaves out its tests one by one, if that is asked for."""

    problem_of: OfValues
    parameters: Annotated[Mapping[str, FreeParameter | Three], Setting(free_parameters)]
    tests: Annotated[Sequence[MeasuredResponse], Setting(named_tests)]
    _: KW_ONLY
    start_states: StartStates = "virgin"
    rule: Rule = "traction_ratio"
    share: Share = "element"
    start_deviation: Annotated[float, Setting(positive, "standard deviation of free start variables about 0, their prior")] = 0.5
    leave_one_out: Annotated[bool, Setting(truth, "also predict each curve, or each joint, from the others")] = False
    tries: Annotated[int, Setting(Whole(0), "number of further starts of the fit; the best result is used")] = 8
    seed: Seed = 0
    evaluations: Annotated[int, Setting(Whole(1), "largest number of evaluations of the residuals in one fit")] = 60
    checkpoint: Checkpoint | None = None
    progress: Progress = silent

    def __post_init__(self) -> None:
        super().__post_init__()
        fineness_of(self.harmonics, self.samples)
        if self.leave_one_out and any(test.joint for test in self.tests) and len(by_joint(self.tests)) == 1:
            remedy = "Name another joint for some of the tests, or none to leave out test by test."
            raise fault("leave_one_out", "must have another joint to predict from", self.tests[0].joint, remedy)
        for test in self.tests:
            twice = sorted({*test.settings} & {*self.parameters})
            if twice:
                raise fault(f"The settings of {test.name}", "must not name what is free", twice)
            problem = self._at_the_start(test)
            if not 0 <= test.output < len(problem.outputs):
                raise fault(f"The output of {test.name}", f"must be a number from 0 to {len(problem.outputs) - 1}", test.output)

    @property
    def free(self) -> dict[str, FreeParameter]:
        return {name: each for name, each in self.parameters.items() if isinstance(each, FreeParameter)}

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
        return (f"identification of responses {digest.hexdigest()}, {self.identity('problem_of', 'tests')}",)

    @property
    def words(self) -> tuple[str, ...]:
        return ("fitting responses",)

    def fit(self) -> ResponseFit:
        """The least squares, before its first evaluation."""
        fine = fineness_of(self.harmonics, self.samples)
        models = [FittedTest.of(test, self.problem_of, *fine) for test in self.tests]
        if self.start_states == "free":
            models = [replace(model, space=self._space(model)) for model in models]
        return ResponseFit(models, self.free, self.start_deviation)

    def fitted(self, solution: Mapping[str, Any]) -> ResponseFit:
        """The least squares that begin again at a solution: a point with several ones takes that which was fitted."""
        fit = self.fit()
        for t, model in enumerate(fit.tests):
            model.solutions = np.asarray(solution["solutions"])[t]
        return fit

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
            x, least = friction_bounds(fit, x, self.evaluations)
            fit.jacobian(x)
            found: dict[str, Any] = {"least": least, "solutions": stacked([model.solutions for model in fit.tests])}
            outliers = fitted_without(fit, x, self.evaluations)
            found |= {"x_without": outliers.x, "outlier": outliers.errors, "outlier_deviation": outliers.deviation}
            if max(fit.misfit(x, t) for t in range(len(fit.tests))) > POOR:
                found |= amplitudes_alone(fit, (self.tries, self.seed, self.evaluations))
        return {"x": x, "cpu_seconds": np.array(time.process_time() - started), **found}

    def finished(
        self, results: Sequence[Arrays], checkpoint: Checkpoint | None, workers: Workers, progress: Progress, **about: Any
    ) -> ResponseIdentification:
        """The result, from that of the fit."""
        held_out: Sequence[Arrays] = ()
        if self.leave_one_out and len(by_joint(self.tests)) > 1:
            held_out = all_cases(HeldOutWork(self, results[0]), checkpoint, workers, progress)
        return self.gathered(results, held_out, **about)

    def gathered(
        self,
        results: Sequence[Arrays],
        held_out: Sequence[Arrays] = (),
        remarks: Sequence[str] = (),
        factors: Mapping[str, Any] | None = None,
    ) -> ResponseIdentification:
        """The result of the variables that were found, and of the tests that were left out.

        factors: of parameters that are factors, least and largest value of the problem that they multiply, if any, and its unit.
        """
        solution = results[0]
        x = np.asarray(solution["x"])
        with one_blas_thread():
            fit = self.fitted(solution)
            fit.residuals(x)
            known = statistics(fit, x)
            predicted = np.full(len(self.tests), np.nan)
            if held_out:
                for (_, absent), one in zip(by_joint(self.tests), held_out, strict=True):
                    predicted[absent] = one["misfit"]
            dataset = dataset_of_fit(fit, x, known, predicted, solution)
            said = notes(self.tests, (fit, x, known), dataset, solution, remarks)
        seconds = sum(float(one["cpu_seconds"]) for one in (*results, *held_out))
        dataset.attrs |= {"harmonics": attribute(self.harmonics), "samples": self.samples, "notes": "\n".join(said)}
        dataset.attrs |= {"start_states": self.start_states, "cpu_seconds": seconds, "factors": json.dumps(factors or {})}
        dataset.attrs |= {"rule": list(rules_of(self.rule)), "share": self.share, "start_deviation": self.start_deviation}
        return ResponseIdentification(dataset, self.problem_of, said)


@dataclass(frozen=True, eq=False)
class HeldOutWork:
    """One case for each test, or for each joint where tests name theirs: the misfits with the shared parameters of the others;
    what a test has by itself is fitted to it.

    solution: that of the fit to all tests, from which each begins.
    """

    whole: ResponseIdentificationWork
    solution: Arrays

    @property
    def groups(self) -> list[tuple[str, list[int]]]:
        return by_joint(self.whole.tests)

    @property
    def names(self) -> tuple[str, ...]:
        (name,) = self.whole.names
        return tuple(f"{name}, without {group} {tests}" for group, tests in self.groups)

    @property
    def words(self) -> tuple[str, ...]:
        return tuple(f"without {group}" for group, _ in self.groups)

    def prepare(self) -> None:
        """Nothing: the fit has compiled all."""

    def solve(self, case: int, report: Report) -> Arrays:
        """The misfits of the tests that are left out."""
        started, x, evaluations = time.process_time(), np.asarray(self.solution["x"]), self.whole.evaluations
        absent = self.groups[case][1]
        with one_blas_thread():
            fit = self.whole.fitted(self.solution)
            others = [k for k in range(len(fit.tests)) if k not in absent]
            rest = ResponseFit([fit.tests[k] for k in others], fit.free, fit.start_deviation)
            rest.evaluated = lambda count: report(min(count / evaluations, 0.95))
            begin = x[[k for k, v in enumerate(fit.variables) if v.test not in absent]]
            # What the others do not determine would keep the value that the absent ones gave it.
            blind = statistics(rest, begin).blind
            begin[blind] = rest.start[blind]
            fitted = rest.solved(begin, evaluations=evaluations).x
            found = [self._misfit(fit, t, fitted[: len(fit.shared)], x) for t in absent]
        return {"misfit": np.array(found), "cpu_seconds": np.array(time.process_time() - started)}

    def _misfit(self, fit: ResponseFit, t: int, shared: Array, x: Array) -> float:
        """The misfit of a test with given shared variables; its own ones begin as in x."""
        alone = ResponseFit([fit.tests[t]], fit.free, fit.start_deviation)
        start = np.concatenate([shared, x[[k for k, v in enumerate(fit.variables) if v.test == t]]])
        return alone.misfit(alone.solved(start, fit.shared, self.whole.evaluations).x, 0)


@takes(ResponseIdentificationWork)
def identify_response(work: ResponseIdentificationWork) -> ResponseIdentification:
    """Parameters θ of a problem that minimise Σ |ln h(θ) − ln h_measured|²/σ², h the response per force at every point.

    σ is the relative error of a test; where that is one of its largest response, h takes the place of ln h.
    problem_of(**values, **settings of the test) makes the problem. parameters: {name: FreeParameter, or (start, low, high)},
    anything that the problem depends on. tests: measured responses at several force levels, preloads or mountings; each point
    takes its own measured force, or its own measured response. Derivatives are exact, by the implicit function theorem.

    start_states: "virgin", those of the problem; or "free": each test has start variables of its own (`rule`, `share` as for
    `response_samples`), with a normal prior of mean 0 and start_deviation: nominally equal tests differ in how their contacts
    were assembled. tries: further starts between the bounds; the best result is used. leave_one_out: fit again without each test,
    or without each joint if tests name theirs, and compare it with the prediction from the others; its own variables are fitted
    to it.

    The 95 % intervals take the residuals as errors. Residuals that are correlated along the curves are counted by the number of
    independent ones, and from three tests on an interval is at least as wide as the disagreement of the tests, or of the joints
    if they are named (cluster-robust errors). So it includes differences from test to test, but no error common to all tests,
    such as a wrong contact law.
    """
    return work.finished(all_cases(work, work.checkpoint, 1, work.progress), work.checkpoint, 1, work.progress)
