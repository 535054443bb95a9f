"""Solving of what the sliders ask for: the newest request of each tab wins, older ones end as soon as they can.

A tab numbers its requests. One request is solved at a time; those that a newer one of the same tab has overtaken are dropped
before they begin, or at the next progress report of their curve. So no answer comes after that of a newer request.

What of a study can vary: numbers of its document with the range of a slider each.

What the explorer shows of an answer: the curve beside its reference, the peak in two numbers, and one point in detail.
"""

import inspect
import time
from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from threading import Lock
from typing import Any, Self

import numpy as np

from stickslip.analyses.forced_response import TRACED, ForcedResponse, ForcedResponseWork
from stickslip.analyses.performance.curve import PerformanceCurve, performance_curve
from stickslip.analyses.settings import ForcedResponseSettings
from stickslip.analyses.solved_points import has_surface
from stickslip.model import rigs
from stickslip.model.problem import Problem
from stickslip.model.readers.reduction import Progress, quiet
from stickslip.results import view
from stickslip.results.schema import attributes_of, in_system, system_of
from stickslip.show.plots.chart import Axis, Bars, Chart, Layer, Line, Panel, Rule, shown_chart
from stickslip.show.plots.interactive import plotly_figure
from stickslip.show.plots.look import Style, contact
from stickslip.show.plots.performance_curve import performance_curves
from stickslip.show.plots.response_curves import HERTZ, LINEAR, parted, response_axis
from stickslip.show.report.answer import failures_of, warnings_of
from stickslip.solve.balance.fourier import in_words
from stickslip.study.analyses.performance_curve import PerformanceTable
from stickslip.study.analysis import COMMON_KEYS
from stickslip.study.faults import parsed
from stickslip.study.fields import in_si
from stickslip.study.reading import Job, job, text_of, toml, units_of
from stickslip.study.toml_text import toml_text
from stickslip.support.checks import InputError, fault
from stickslip.support.late import xr
from stickslip.support.units import Band, UnitSystem

FACTOR = 4.0
"""A slider reaches from the value of the study divided by this to the value times this, on a logarithmic scale."""
LEVELS = 100.0
"""The same of force levels, unless the study's reach further."""
ANGLES = (5.0, 85.0)
"""Ends of a slider for an angle in degrees."""
MOST = 24
"""Sliders of one page."""
UNITS = {
    "pull": "N",
    "limit": "N",
    "angle": "°",
    "stagger": "°",
    "mass": "kg",
    "length": "m",
    "offset": "m",
    "kt": "N/m",
    "kn": "N/m",
}
UNITS |= {"stiffness": "N/m", "ktx": "N/m", "kty": "N/m"}
"""Of arguments of rigs, by the last word of their names; others are numbers, or have none here."""
OWN_UNITS = {"kt": "N/m", "kn": "N/m", "normal_load": "N", "preload": "N", "static": "N", "pull": "N"}
"""Of numbers of a study's own tables, in SI, by their key."""

Keys = tuple[str | int, ...]
"""Keys and places in a list that lead to a value of the document."""


@dataclass(frozen=True)
class Slider:
    """A number that can vary: its name in the address and on the page, value in the study, ends, scale, and the places of the
    document that hold it."""

    name: str
    value: float
    low: float
    high: float
    logarithmic: bool
    paths: tuple[Keys, ...]
    unit: str = ""


def sliders_of(document: Mapping[str, Any], units: UnitSystem | None = None) -> tuple[Slider, ...]:
    """The sliders of a study with [sweep]: force level first, then the parameters of its rig, or damping, contacts and forces.
    units: those of the study's numbers, SI unless given.
    """
    levels = [float(level) for level in document.get("sweep", {}).get("force_levels") or [1.0]]
    middle = levels[len(levels) // 2]
    low, high = min(middle / LEVELS**0.5, *levels), max(middle * LEVELS**0.5, *levels)
    sliders = [Slider("force_level", middle, low, high, True, (("sweep", "force_levels"),)), *_rig(document)]
    damping = document.get("damping")
    if isinstance(damping, Mapping) and isinstance(damping.get("modal"), float):
        sliders.append(_slider("damping", damping["modal"], (("damping", "modal"),)))
    sliders += [*_contacts(document), *_forces(document)]
    return tuple(replace(slider, unit=_unit_of(slider, units)) for slider in sliders[:MOST])


def _unit_of(slider: Slider, units: UnitSystem | None) -> str:
    """The unit of a slider's number: of rigs, which are in SI, and of the study's own tables."""
    first = slider.paths[0]
    if first[0] == "structure":
        return UNITS.get(slider.name.rpartition("_")[2], "")
    key = next((str(part) for part in reversed(first) if isinstance(part, str)), "")
    return in_system(OWN_UNITS.get(key, ""), units)[1]


def varied(document: Mapping[str, Any], sliders: Sequence[Slider], values: Mapping[str, float]) -> dict[str, Any]:
    """The document with the values of sliders by name; force levels become the one of its slider."""
    changed: dict[str, Any] = deepcopy(dict(document))
    for slider in sliders:
        value = float(values.get(slider.name, slider.value))
        if slider.name == "force_level":
            changed.setdefault("sweep", {})["force_levels"] = [value]
        elif value != slider.value:
            for path in slider.paths:
                _put(changed, path, value)
    return changed


def _put(document: dict[str, Any], path: Keys, value: float) -> None:
    """Set a value of the document, making the tables on the way to it."""
    place: Any = document
    for key in path[:-1]:
        place = place.setdefault(key, {}) if isinstance(place, dict) else place[key]
    place[path[-1]] = value


def _rig(document: Mapping[str, Any]) -> Iterator[Slider]:
    """Arguments of a ready rig that are numbers, given or by default; not the force, as the force level does the same."""
    structure = document.get("structure")
    maker = rigs.RIGS.get(str(structure.get("rig"))) if isinstance(structure, Mapping) else None
    if not isinstance(structure, Mapping) or maker is None:
        return
    given = structure.get("parameters", {})
    for name, argument in inspect.signature(maker).parameters.items():
        value = given.get(name, argument.default)
        varies = isinstance(argument.default, float) or (name in given and isinstance(value, float))
        if varies and isinstance(value, int | float) and not isinstance(value, bool) and name != "force":
            yield _slider(name, float(value), (("structure", "parameters", name),))


def _contacts(document: Mapping[str, Any]) -> Iterator[Slider]:
    """kt, kn, mu, ... of all contacts together where they are alike, else of each."""
    tables = document.get("contact", [])
    for key in ("kt", "kn", "mu", "normal_load", "preload"):
        places = [(k, table[key]) for k, table in enumerate(tables) if isinstance(table.get(key), int | float)]
        alike = len({value for _, value in places}) == 1
        if places and alike:
            yield _slider(key, float(places[0][1]), tuple(("contact", k, key) for k, _ in places))
        elif places:
            for k, value in places:
                yield _slider(f"{tables[k].get('name', f'contact {k + 1}')} {key}", float(value), (("contact", k, key),))


def _forces(document: Mapping[str, Any]) -> Iterator[Slider]:
    """Static forces, the pulls on dampers."""
    for k, table in enumerate(document.get("force", [])):
        if isinstance(table.get("static"), int | float) and table["static"]:
            place = table.get("direction") if isinstance(table.get("direction"), str) else f"force {k + 1}"
            yield _slider(f"static force {place}", float(table["static"]), (("force", k, "static"),))
    for k, table in enumerate(document.get("body", [])):
        for axis, value in enumerate(table.get("pull", [])):
            if value:
                yield _slider(f"pull on {table.get('name', k + 1)} {'xyz'[axis]}", float(value), (("body", k, "pull", axis),))


def _slider(name: str, value: float, paths: tuple[Keys, ...]) -> Slider:
    """Ranges by the kind of number: angles, positive ones on a logarithmic scale, zero and negative ones about themselves."""
    if name.endswith(("angle", "stagger")):
        return Slider(name, value, min(ANGLES[0], value), max(ANGLES[1], value), False, paths)
    if value > 0.0:
        return Slider(name, value, _rounded(value / FACTOR), _rounded(value * FACTOR), True, paths)
    reach = abs(value) * FACTOR or 1.0
    return Slider(name, value, -reach, reach, False, paths)


def _rounded(value: float) -> float:
    return float(f"{value:.3g}") if np.isfinite(value) else value


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
    def of(cls, path: Path) -> Self:
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
            self.doing[tab] = Doing("Estimating the errors" if fine and share >= TRACED else words, share, started)

        fine = output is None
        report("Reading the model", 0.0)
        sweep = self._sweep(values, lambda share, text: report("Reading the model", TRACED * share))
        sweep = replace(sweep, isolated=False)  # sliders wait for the curve alone
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


THIS, PINNED = "this study", "reference"


def curve_figure(answer: Answer, pinned: Answer | None, output: str, log: bool, dark: bool) -> dict[str, Any]:
    """The response, the reference, and the linear responses without contacts and with stuck ones."""
    dataset = answer.response.dataset
    shown = [(answer, THIS, Style("contact 5", width=2.4))]
    if pinned is not None:
        shown.insert(0, (pinned, PINNED, Style("contact 0", "dash", 1.6)))
    unit, measure, hertz = _unit(answer, pinned), view.measure_in(dataset), dataset.linear_frequency.values
    linear: list[Layer] = []
    for state, (label, style) in LINEAR.items():
        amplitudes = dataset[f"{state}_amplitude"].values[0, :, answer.place(output)]
        linear.append(Line(hertz, measure.of_harmonic(amplitudes, 2.0 * np.pi * hertz) / unit.metres, style, label))
    layers: list[Layer] = []
    for each, label, style in shown:
        own = each.response.dataset
        place = each.place(output)
        sizes = view.along_curve_as(own, measure, 0, place) / unit.metres
        layers += parted(Line(view.frequencies(own, 0), sizes, style, label), view.outside_steps(own, 0))
        peak = view.highest_peak(own, 0, place)
        if peak is not None:
            dot = Style(style.colour, "none", marker="circle", size=7.0)
            layers.append(Line([peak.frequency], [peak.amplitude / unit.metres], dot))
    axis = response_axis(dataset, False, measure, unit)
    heights = np.concatenate([np.asarray(layer.y, dtype=float) for layer in layers if isinstance(layer, Line)])
    low, high = float(np.nanmin(heights)), float(np.nanmax(heights))
    limits = (0.5 * low, 2.0 * high) if log else (0.0, 1.3 * high)
    axis = Axis(axis.quantity, axis.unit, log=log, limits=limits)
    panel = Panel(HERTZ, axis, [*linear, *layers], height=4.4)
    return _figure(Chart(output, [panel]), dataset, dark)


def peak_words(answer: Answer, output: str) -> tuple[str, str]:
    """Frequency and amplitude of the highest peak, the two large numbers."""
    dataset = answer.response.dataset
    peak = view.highest_peak(dataset, 0, answer.place(output))
    if peak is None:
        return "–", "–"
    measure, units = view.measure_in(dataset), str(dataset["peak_amplitude"].attrs["units"])
    per = measure.per(float(dataset.force_level[0]))
    return f"{peak.frequency:.6g} Hz", view.size_text(peak.amplitude / per, units, dataset)


def change_words(answer: Answer, pinned: Answer | None, output: str) -> tuple[str, str]:
    """How far frequency and amplitude are from those of the reference."""
    own = view.highest_peak(answer.response.dataset, 0, answer.place(output))
    other = None if pinned is None else view.highest_peak(pinned.response.dataset, 0, pinned.place(output))
    if own is None or other is None:
        return "", ""
    frequency, amplitude = own.frequency / other.frequency - 1.0, own.amplitude / other.amplitude - 1.0
    return f"{frequency:+.3%} from the reference", f"{amplitude:+.3%} from the reference"


def clicked_point(answer: Answer, pinned: Answer | None, output: str, x: float, y: float) -> int:
    """The converged point nearest to a place of the drawn curve, x in Hz and y in the unit of the axis."""
    return view.nearest_point(answer.response.dataset, 0, answer.place(output), x, y * _unit(answer, pinned).metres)


def _unit(answer: Answer, pinned: Answer | None) -> view.Length:
    """The unit of the curves."""
    return view.peak_unit(*(each.response.dataset for each in (answer, pinned) if each is not None))


def peak_place(answer: Answer, output: str) -> int | None:
    """The point of the highest peak."""
    peak = view.highest_peak(answer.response.dataset, 0, answer.place(output))
    return None if peak is None else peak.point


def detail_figures(answer: Answer, point: int, output: str, dark: bool, narrow: bool) -> list[dict[str, Any]]:
    """Motion with loops and contact states, deformed shape, energy by contact and harmonics at a point."""
    response = answer.response
    dataset = response.dataset
    figures = []
    if dataset.sizes["contact"]:
        figures.append(response.animate(0, point).to_plotly(dark=dark, narrow=narrow).to_dict())
    if has_surface(response.problem):
        figures.append(response.deformed_shape(0, point).to_plotly(dark=dark, narrow=narrow).to_dict())
    energy = np.nan_to_num(view.dissipated(dataset, 0)[int(np.searchsorted(view.points(dataset, 0), point))])
    joules, unit = view.energy_unit(float(energy.max(initial=0.0)))
    names = {float(k): str(name) for k, name in enumerate(dataset.contact.values)}
    contacts = Axis("", names=names if len(names) <= 16 else {}, upside_down=True)
    by_contact = Bars(np.arange(energy.size), energy / joules, contact(2), horizontal=True)
    parts, length = dataset["response"].values[0, point, answer.place(output)], view.peak_unit(dataset)
    sizes = np.hypot(parts[:, 0], parts[:, 1]) / length.metres
    harmonics, amplitude = Bars(np.arange(sizes.size), sizes, contact(0)), Axis("amplitude", length.name, log=True)
    panels = [
        Panel(Axis("energy per period", unit), contacts, [by_contact], "Energy by contact", 2.8),
        Panel(Axis("harmonic"), amplitude, [harmonics], "Harmonics of the displacement", 2.8),
    ]
    chart = Chart("Energy and harmonics", panels, columns=2, legend=False)
    return [*figures, _figure(chart, dataset, dark)]


def performance_figure(curve: PerformanceCurve, ratio: float, dark: bool) -> dict[str, Any]:
    """The performance curve with the present ratio of pull and excitation."""
    chart = performance_curves(curve.dataset)
    rule = Rule(ratio, Style("contact 5", "dash", 2.0), THIS)
    marked = replace(chart, panels=[replace(panel, layers=[*panel.layers, rule]) for panel in chart.panels])
    return _figure(marked, curve.dataset, dark)


def _figure(chart: Chart, dataset: "xr.Dataset", dark: bool) -> dict[str, Any]:
    """A chart in the units of the study."""
    shown = shown_chart(chart, system_of(dataset))
    found: dict[str, Any] = plotly_figure(shown, dark).update_layout(uirevision="kept", autosize=True).to_dict()
    return found
