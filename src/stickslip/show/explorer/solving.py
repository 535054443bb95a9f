"""Solving of what the sliders ask for: the newest request of each tab wins, older ones end as soon as they can.

A tab numbers its requests. One request is solved at a time; those that a newer one of the same tab has overtaken are dropped
before they begin, or at the next progress report of their curve. So no answer comes after that of a newer request.
"""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from threading import Lock
from typing import Any

from stickslip.analyses.forced_response import TRACING, ForcedResponse, ForcedResponseWork
from stickslip.analyses.performance.curve import PerformanceCurve, performance_curve
from stickslip.analyses.response_settings import ForcedResponseSettings
from stickslip.model.problem import Problem
from stickslip.model.readers.reduction import Progress, quiet
from stickslip.results.shown_units import attributes_of
from stickslip.show.explorer.sliders import Slider, sliders_of, varied
from stickslip.show.report.conclusions import failures_of, warnings_of
from stickslip.solve.balance.orders import in_words
from stickslip.study.analyses.performance_curve import PerformanceTable
from stickslip.study.faults import parsed
from stickslip.study.kinds import COMMON_KEYS
from stickslip.study.reading import Job, job, text_of, toml, units_of
from stickslip.study.toml_text import toml_text
from stickslip.study.units import in_si
from stickslip.support.checks import InputError, fault
from stickslip.support.units import Band, UnitSystem

KEPT = 24
"""Responses that are kept."""
COARSE, COARSE_SAMPLES = 3, 64
"""Harmonics and samples of a coarse answer, at most."""
COARSE_PEAKS = 1e-4
"""Relative amplitude by which its peaks may be too low, at least."""
REMEMBERED = 1000
"""Tabs whose newest request is known."""

Values = Mapping[str, float]


class OutdatedError(Exception):
    """A newer request of the same tab has come."""


@dataclass(frozen=True, eq=False)
class Answer:
    """A solved request: the response, sentences on what failed or deserves a warning, and seconds that it took."""

    response: ForcedResponse
    sentences: tuple[str, ...]
    seconds: float

    def place(self, output: str) -> int:
        """Where an output stands among those of the response."""
        return list(self.response.dataset.output.values).index(output)


@dataclass(frozen=True)
class Doing:
    """What is solved for a tab now: in words, which share of it is done, and when it began."""

    words: str
    share: float
    started: float


@dataclass(eq=False)
class Solver:
    """A study that can vary, and its responses that are known."""

    text: str
    folder: Path
    name: str
    newest: OrderedDict[str, int] = field(default_factory=OrderedDict)
    doing: dict[str, Doing] = field(default_factory=dict)
    read: tuple[Any, Job] | None = None
    known: OrderedDict[Any, Answer] = field(default_factory=OrderedDict)
    solving: Lock = field(default_factory=Lock)
    performing: Lock = field(default_factory=Lock)
    noting: Lock = field(default_factory=Lock)

    @classmethod
    def of(cls, path: Path) -> Solver:
        """The study at a path, checked as a whole. Raises `InputError` where it has no band to show a response over."""
        solver = cls(text_of(path), path.parent, path.stem)
        checked = job(solver.text, solver.folder, solver.name)
        what, remedy = "The study of the explorer", "Explore a forced response: `stickslip new forced_response` writes one."
        if checked.sweep is None:
            raise fault(what, "must be of a problem, with a [sweep]", checked.analysis, remedy)
        if not {"frequency", "at"} & solver.document["sweep"].keys():
            raise fault(what, "must have a band, [sweep] frequency", checked.analysis, remedy)
        return solver

    @cached_property
    def document(self) -> dict[str, Any]:
        """The study as tables, its analysis a forced response."""
        document = toml(self.text)
        kept = {key: document[key] for key in COMMON_KEYS if key in document}
        return kept | {"study": {**document["study"], "analysis": "forced_response"}}

    @cached_property
    def performance_settings(self) -> dict[str, Any]:
        """What [performance_curve] of the study says of curves at other ratios; nothing without that table."""
        table = toml(self.text).get("performance_curve")
        if table is None:
            return {}
        settings = in_si(parsed(PerformanceTable, table), units_of(self.document.get("units", "SI")))
        return {key: settings[key] for key in ("vary", "pull", "friction")}

    @cached_property
    def not_computed(self) -> str:
        """A sentence on the tables of the study that no view computes; empty where there are none."""
        tables = sorted(toml(self.text).keys() - self.document.keys() - {"performance_curve"})
        return (
            f"The explorer leaves out {', '.join(f'[{key}]' for key in tables)}; `stickslip run` computes this." if tables else ""
        )

    @cached_property
    def analysis(self) -> str:
        """What the study itself asks for."""
        return str(toml(self.text)["study"]["analysis"])

    @cached_property
    def units(self) -> UnitSystem:
        """The units of the study, in which its numbers vary and answers are shown."""
        return units_of(self.document.get("units", "SI")).system

    @cached_property
    def sliders(self) -> tuple[Slider, ...]:
        """What can vary."""
        return sliders_of(self.document, self.units)

    def study(self, values: Values) -> str:
        """The study with the values of sliders, as a file."""
        return toml_text(varied(self.document, self.sliders, values))

    def job(self, values: Values, progress: Progress = quiet) -> Job:
        """The study with the values of sliders, checked; the last one is kept. Raises `InputError` with its faults."""
        key, last = tuple(sorted(values.items())), self.read
        if last is None or last[0] != key:
            last = self.read = key, job(self.study(values), self.folder, self.name, progress)
        return last[1]

    def ask(self, tab: str, version: int) -> None:
        """Note the newest request of a tab."""
        with self.noting:
            self.newest[tab] = max(version, self.newest.pop(tab, 0))
            while len(self.newest) > REMEMBERED:
                self.newest.popitem(last=False)

    @cached_property
    def outputs(self) -> list[str]:
        """Names of the outputs."""
        return list(self.problem({}).output_names)

    def answer(self, values: Values, output: str | None = None, tab: str = "", version: int = 0) -> Answer:
        """The response for these values, with the harmonics of the study; with few and of one output alone where one is named.

        Raises `OutdatedError` where the tab has asked anew meanwhile, and `InputError` with the faults of the study.
        """
        key = (tuple(sorted(values.items())), output)
        with self.solving:
            self._refuse_outdated(tab, version)
            if key not in self.known:
                try:
                    self.known[key] = self._solved(values, output, tab, version)
                finally:
                    self.doing.pop(tab, None)
            self.known.move_to_end(key)
            while len(self.known) > KEPT:
                self.known.popitem(last=False)
            return self.known[key]

    def kept(self, values: Values) -> Answer | None:
        """The response for these values, where it is known."""
        return self.known.get((tuple(sorted(values.items())), None))

    def performance(
        self, values: Values, ratios: Any, output: str, tab: str = "", version: int = 0
    ) -> tuple[PerformanceCurve, str]:
        """The performance curve for these values in the band of the study, of its measure and an output, coarse, and a sentence
        on what is coarse. It takes seconds: answers to sliders do not wait for it.

        A study of frequencies in a list has no band: resonances are then sought around the linear ones, and the sentence says so.
        """
        sweep, given = self._sweep(values), dict(self.performance_settings)
        problem, measure, where = sweep.problem, sweep.measured, sweep.band
        few, samples = _few(sweep)
        given |= {"band": where if isinstance(where, Band) else None, "output": problem.output_names.index(output)}
        given |= {"quantity": measure.quantity.name, "measure": measure.kind, "harmonics": few, "samples": samples}

        def report(fraction: float, words: str) -> None:
            self._refuse_outdated(tab, version)

        with self.performing:
            curve = performance_curve(problem, ratios, progress=report, check_every=len(ratios), **given)
        curve = replace(curve, dataset=curve.dataset.assign_attrs(attributes_of(self.units)))
        said = f"Coarse settings for {output}: {in_words(few)}, {samples} samples, no sweeps for new peaks between the points."
        if not isinstance(where, Band):
            said += " The study lists frequencies, so peaks are searched around the linear resonances."
        return curve, said

    def problem(self, values: Values) -> Problem:
        """The problem with these values."""
        return self._sweep(values).problem

    def _sweep(self, values: Values, progress: Progress = quiet) -> ForcedResponseSettings:
        sweep = self.job(values, progress).sweep
        if sweep is None:
            raise InputError("The study has no [sweep] to solve.")
        return sweep

    def _solved(self, values: Values, output: str | None, tab: str, version: int) -> Answer:
        """The response as `answer` describes it, solved now."""
        started = time.perf_counter()

        def report(words: str, share: float) -> None:
            self._refuse_outdated(tab, version)
            self.doing[tab] = Doing("Estimating the errors" if fine and share >= TRACING else words, share, started)

        fine = output is None
        report("Reading the model", 0.0)
        sweep = self._sweep(values, lambda share, text: report("Reading the model", TRACING * share))
        words = "Solving the curve" if fine else "Solving a preview"
        report(words, 0.0)
        work = ForcedResponseWork.of(sweep) if output is None else _coarse(sweep, output)
        solve = work.solve if fine else work.solve_without_errors
        curve = solve(0, lambda share: report(words, share))
        response = work.gathered([curve])
        response = replace(response, dataset=response.dataset.assign_attrs(attributes_of(self.units)))
        sentences = failures_of(response.dataset)
        if fine:
            sentences += [*warnings_of(response.dataset), *filter(None, [self.not_computed])]
        return Answer(response, tuple(sentences), time.perf_counter() - started)

    def _refuse_outdated(self, tab: str, version: int) -> None:
        if self.newest.get(tab, 0) > version:
            raise OutdatedError


def _coarse(sweep: ForcedResponseSettings, output: str) -> ForcedResponseWork:
    """The same with few harmonics, those that the excitation has are kept, and one output: peaks of others take their time."""
    problem = sweep.problem
    shown = replace(problem, outputs=(problem.outputs[problem.output_names.index(output)],))
    few, samples = _few(sweep)
    tolerance = max(sweep.peak_tolerance, COARSE_PEAKS)
    coarse = replace(sweep, problem=shown, harmonics=few, samples=samples, peak_tolerance=tolerance)
    return ForcedResponseWork.of(coarse)


def _few(sweep: ForcedResponseSettings) -> tuple[int | tuple[int, ...], int]:
    """Harmonics of the study up to `COARSE`, or to the highest that is excited, and samples that go with them. Of a list those
    that are left, so that a mean that it leaves out stays out.
    """
    highest = max(COARSE, *(h for force in sweep.problem.forces for h in force.amplitudes))
    if isinstance(sweep.harmonics, int | str):
        few: int | tuple[int, ...] = highest if isinstance(sweep.harmonics, str) else min(sweep.harmonics, highest)
    else:
        few = tuple(h for h in sweep.harmonics if h <= highest)
    return few, max(min(sweep.samples, COARSE_SAMPLES), 4 * (few if isinstance(few, int) else max(few)) + 2)
