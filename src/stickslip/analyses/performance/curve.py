"""Damper performance curves: resonance amplitude and frequency against F_C/F_E, the standard chart of damper design.

F_C is the static pull on a damper, F_E the amplitude of the excitation. The resonance itself is followed along the ratio.

The band of a performance curve over the start states of the contacts: friction forces of stuck contacts are not unique, so
neither is the resonance, and one curve alone misleads.

Resonance peaks along any parameter of a problem: force, preload, friction, stiffness, or several scaled together.
"""

import warnings
from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.analyses.performance.work import (
    OPTIMUM,
    OverRatios,
    PerformanceWork,
    Pull,
    centrifugal_pull,
    excitation,
    no_resonance,
    resonance_band,
)
from stickslip.analyses.response_dataset import levels_are_newtons
from stickslip.analyses.settings import (
    Rule,
    Seed,
    Setting,
    Share,
    Whole,
    ends_of,
    fineness_of,
    made,
    maker,
    output_of,
    takes,
)
from stickslip.analyses.variability.bounds import BoundsWork
from stickslip.model.problem import Problem
from stickslip.results.schema import Result, named, stacked, tabulated, variables_in
from stickslip.runs.cases import Arrays, Progress, all_cases
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.fourier import attribute
from stickslip.solve.balance.measure import Measure, measure_of
from stickslip.solve.peaks.continuation import ContinuedPeaks, Event, PeakContinuation
from stickslip.support.checks import between, fault, positive, vector
from stickslip.support.late import xr
from stickslip.support.machine import one_blas_thread
from stickslip.support.units import Band


@dataclass(frozen=True, eq=False, repr=False)
class PerformanceCurve(Result):
    """Curves of several friction coefficients: `dataset` with axes (case, point), a case per coefficient, points by F_C/F_E."""

    dataset: "xr.Dataset"
    problem: Problem

    def optimum(self, case: int = 0) -> dict[str, float]:
        """The lowest peak of a curve: ratio, size per force (SI), frequency [Hz], and the ends of the plateau.

        Warns, in the words of `optimum_warning` of the dataset, where it may not be the lowest: at an end of the values, or where
        a curve between them could not be solved.
        """
        warning = str(self.dataset["optimum_warning"].values[case])
        if warning:
            warnings.warn(warning, stacklevel=2)
        return {name: float(self.dataset[name][case]) for name in OPTIMUM}

    def events(self, case: int = 0) -> list[str]:
        """What happened to peaks along a curve: born, ended, merged, swapped."""
        return [str(words) for words in self.dataset["event"].values[case] if words]

    def collapse(self) -> tuple[float, float]:
        """How far the curves are from falling together over μ F_C/F_E, as they do for one mass: the largest spread between them,
        relative to their mean, of the peak amplitude per force and of the frequency, where all of them reach. Between the values
        of a curve straight lines are drawn over the logarithms: they must lie close where curves bend.
        """
        dataset = self.dataset
        x = [np.log(float(mu) * dataset["force_ratio"].values) for mu in dataset["friction"].values]
        common = np.linspace(max(row[0] for row in x), min(row[-1] for row in x), 200)
        if len(x) < 2 or not common[0] < common[-1]:
            raise fault("The curves", "must be of two or more friction coefficients that overlap in μ F_C/F_E", len(x))
        spreads = []
        for name in ("amplitude_per_force", "frequency"):
            rows = [np.interp(common, at, row) for at, row in zip(x, np.log(dataset[name].values), strict=True)]
            spreads.append(float(np.max(np.ptp(rows, axis=0))))
        return spreads[0], spreads[1]


@takes(PerformanceWork)
def performance_curve(work: PerformanceWork) -> PerformanceCurve:
    """Peak amplitude and frequency of the highest resonance against F_C/F_E, for one or several friction coefficients.

    force_ratio: values of F_C/F_E, as many as the curve is to have points; friction: coefficients put at every contact (those
    of the problem unless given). vary: "force" scales the excitation at the given preload, "preload" scales all static forces
    and preloads at the given excitation; the two agree where contacts have no gaps.
    band: in which resonances are sought, unless given around the free and the stuck one. pull: F_C of the problem as it
    stands, N; unless given its largest static force, or the largest preload of a contact law.
    check_every: how many points lie between two full sweeps that look for peaks born on the way.

    quantity, measure: what the peaks are of, and so `amplitude`, `amplitude_per_force` (m/N, m/(s N) or m/(s² N)), the optimum
    and the plateau; as for `forced_response`. `inertance` is that of the first harmonic at the same point: that point is the
    highest of the inertance only with quantity "inertance". `normalised_...` are relative to the highest peak without contacts
    inside the band, of the same measure but of the first harmonic alone. `region` indexes stick, microslip, slip, lift-off.
    The curve is that of the peaks which a sweep of the excitation meets; where a higher one was followed onto an isola,
    `detached_amplitude_per_force` and `detached_frequency` say so (which ones are found depends on the points).
    Source: S. M. Cameron et al. (1990); the one-mass model is Griffin's (1980).
    """
    return gathered(work, all_cases(work, work.checkpoint, work.workers, work.progress))


VARIABLES = variables_in("performance_curve")


def described(measure: Measure, name: str, units: str, words: str) -> dict[str, str]:
    """Unit and meaning of a variable of `VARIABLES`, whose metres are those of the quantity that is measured."""
    if name == "amplitude":
        words = f"{measure.words} at the resonance"
    if measure.order and name == "normalised_amplitude":
        words = f"{measure.quantity.name} peak relative to that without contacts"
    if measure.order < 2 and name.endswith("inertance"):
        words = words.replace("inertance peak", "inertance").replace(
            "inertance", f"inertance at the {measure.quantity.name} peak"
        )
    if units in ("m", "m/N"):
        units = measure.units if units == "m" else measure.quantity.units_per_force
    return {"units": units, "long_name": words}


def gathered(work: PerformanceWork, results: Sequence[Arrays]) -> PerformanceCurve:
    """All curves as one labelled dataset."""
    # A band in which sweeps went well, but no curve has a peak anywhere, is refused.
    found = any(np.isfinite(result["amplitude"]).any() for result in results)
    if not found and any(np.any(result["check_points"] > 0) for result in results):
        low, high = results[0]["band"]
        balance = HarmonicBalance(work.problem, work.harmonics, work.samples)
        raise no_resonance(balance, work.output, (float(low), float(high)), " at one of the values of F_C/F_E")
    data = {
        name: (dims, stacked([result[name] for result in results]), described(work.measured, name, units, words))
        for name, (dims, units, words) in VARIABLES.items()
        if name in results[0]
    }
    coords: dict[str, Any] = {
        "friction": named("case", list(work.frictions), "friction coefficient"),
        "force_ratio": named("point", list(work.ratios), "F_C/F_E"),
        "contact": named("contact", [contact.name for contact in work.problem.contacts], "contact"),
    }
    attrs: dict[str, Any] = {"title": work.problem.heading, "output": work.problem.output_names[work.output], "vary": work.vary}
    attrs |= {"harmonics": attribute(work.harmonics), "samples": work.samples, **work.measured.attributes}
    attrs["cpu_seconds"] = sum(float(result["cpu_seconds"]) for result in results)
    return PerformanceCurve(xr.Dataset(data, coords, attrs), work.problem)


@dataclass(frozen=True, eq=False, repr=False)
class PerformanceBand(Result):
    """`dataset`: amplitude_per_force, frequency [Hz] and loss_factor of the lowest and the highest peak, axes (point,
    bound); virgin_amplitude_per_force and solves by point.
    """

    dataset: "xr.Dataset"
    problem: Problem


@dataclass(frozen=True, eq=False)
class BandSettings(OverRatios):
    """What a performance band is searched for by: bounds of the peak, at the force levels of values of F_C/F_E."""

    _: KW_ONLY
    pull: Pull = None
    cloud: Annotated[int, Setting(Whole(0), "number of start states sampled at each value")] = 20
    starts: Annotated[int, Setting(Whole(0), "number of the best of these states, from each of which a search begins")] = 2
    rule: Rule = "slider_offset"
    share: Share = "contact"
    seed: Seed = 0

    @cached_property
    def bounds(self) -> BoundsWork:
        """Its cases. That amplitudes are per force goes without saying."""
        own = centrifugal_pull(self.problem) if self.pull is None else self.pull
        unit = excitation(self.problem)
        balance = HarmonicBalance(self.problem, self.harmonics, self.samples)
        shared = ("output", "measure", "cloud", "starts", "rule", "share", "seed", "harmonics", "samples")
        return BoundsWork(
            self.problem,
            self.band or resonance_band(balance, self.output),
            [own / (ratio * unit) for ratio in self.ratios],
            "peak",
            quantity=self.measured.quantity.name,
            **{name: getattr(self, name) for name in shared},
        )


@takes(BandSettings)
def performance_band(work: BandSettings) -> PerformanceBand:
    """Lowest and highest resonance peak over all start states at values of F_C/F_E; the excitation is varied.

    The search is that of `response_bounds` with objective "peak": cloud, starts, rule, share and seed are its arguments.
    quantity, measure: what the peaks are of, as for `forced_response`; `amplitude_per_force` is in m/N, m/(s N) or m/(s² N).
    """
    results = all_cases(work.bounds, work.checkpoint, work.workers, work.progress)
    return PerformanceBand(band_dataset(work, results), work.problem)


def band_dataset(asked: BandSettings, results: Sequence[Arrays]) -> "xr.Dataset":
    """Bounds of the peak as a band over F_C/F_E."""
    work = asked.bounds
    bounds, unit = work.gathered(results), excitation(work.problem)
    if not np.isfinite(bounds["amplitude"].values).any():
        ends = (min(work.frequencies), max(work.frequencies))
        raise no_resonance(work.balance, work.output, ends, " at one of the values of F_C/F_E")
    force = unit * bounds["force_level"].values[:, None]
    at_peak = bounds.isel(frequency=0)
    per_force = at_peak["amplitude"].values / force
    virgin = at_peak["sampled_amplitude"].isel(start=0).values / force[:, 0]
    data = {"amplitude_per_force": per_force, "frequency": at_peak["resonance"].values, "virgin_amplitude_per_force": virgin}
    data |= {name: at_peak[name].values for name in ("loss_factor", "outcome", "unsolved_share", "solves")}
    coords = {"force_ratio": list(asked.ratios), "bound": bounds["bound"].values}
    keys = ("title", "output", *work.measured.attributes, "rule", "share", "seed", "cloud", "starts", "harmonics", "samples")
    keys = (*keys, "cpu_seconds")
    units = work.measured.quantity.units_per_force
    return tabulated("performance_band", data, coords, {key: bounds.attrs[key] for key in keys}, units)


@dataclass(frozen=True, eq=False)
class PeakPath:
    """`dataset`: frequency and frequency_width (middle and half of the band within 0.1 % of the peak), amplitude and on_kink of
    every peak, axes (value, branch), NaN where a peak is not there; highest (value,); events: what happened to peaks, each with
    the values between which it did. The attributes quantity and measure say what `amplitude` is of.
    """

    dataset: "xr.Dataset"
    events: tuple[Event, ...]


def follow_peaks(
    problem_of: Callable[[float], Problem],
    values: ArrayLike,
    band: Band,
    force: float | Callable[[float], float] = 1.0,
    *,
    output: int = 0,
    quantity: str = "displacement",
    measure: str = "amplitude",
    check_every: int = 10,
    harmonics: int | Sequence[int] = 5,
    samples: int = 256,
    progress: Progress = lambda fraction, text: None,
) -> PeakPath:
    """All peaks over a band as a parameter goes through `values`, in this order; begin where contacts stick.

    problem_of(value) is the problem of a value: one function may change several things at once. force: its force level, or
    force(value). quantity, measure: what they are peaks of, as for `forced_response`. Every `check_every` values a full sweep
    looks for peaks born on the way. Peaks are solved as R = 0 with a stationary amplitude along the curve; one on a kink has
    one-sided slopes only and is marked.
    """
    chosen = vector("values", values)
    if chosen.size == 0 or np.unique(chosen).size < chosen.size:
        raise fault("values", "must be different and at least one", chosen.tolist())
    every, (low, high), fineness = between("check_every", check_every, 1), ends_of(band), fineness_of(harmonics, samples)
    make = maker("problem_of", problem_of)
    row, size = output_of(made(make, float(chosen[0])), output), measure_of(quantity, measure)
    known: dict[float, tuple[HarmonicBalance, float]] = {}

    def balance_and_level(value: float) -> tuple[HarmonicBalance, float]:
        if value not in known:
            level = force(value) if callable(force) else force
            known[value] = HarmonicBalance(made(make, value), *fineness), positive("force", level)
        return known[value]

    with one_blas_thread():
        continuation = PeakContinuation(balance_and_level, (2.0 * np.pi * low, 2.0 * np.pi * high), row, size)
        found = continuation.follow(chosen.tolist(), every, lambda fraction: progress(fraction, "following peaks"))
        dataset = _dataset(continuation, found)
    return PeakPath(dataset, tuple(found.events))


def _dataset(continuation: PeakContinuation, found: ContinuedPeaks) -> "xr.Dataset":
    shape, measure = (len(found.values), len(found.branches)), continuation.measure
    arrays = {name: np.full(shape, np.nan) for name in ("frequency", "amplitude", "frequency_width", "on_kink")}
    for b, branch in enumerate(found.branches):
        for k, value in enumerate(found.values):
            if value in branch.places:
                branch.places[value], peak_band = continuation.settled(branch.places[value])
                peak = branch.places[value].peak
                amplitude = peak.amplitude / measure.per(peak.point.level)
                row = (peak_band.omega / (2.0 * np.pi), amplitude, peak_band.width / (2.0 * np.pi), float(peak.on_kink))
                for name, number in zip(arrays, row, strict=True):
                    arrays[name][k, b] = number
    newtons = levels_are_newtons(continuation.problem_of(found.values[0])[0].problem)
    units = {"frequency": "Hz", "amplitude": measure.reported_units(newtons), "frequency_width": "Hz", "on_kink": "1"}
    data = {name: (("value", "branch"), array, {"units": units[name]}) for name, array in arrays.items()}
    highest = [place[0] if (place := found.highest(value)) is not None else -1 for value in found.values]
    attrs: dict[str, Any] = {"solves": found.solves, "iterations": found.iterations}
    attrs |= {"check_points": sum(c.points for c in found.checks), **measure.attributes}
    return xr.Dataset(data | {"highest": ("value", highest)}, {"value": list(found.values)}, attrs)
