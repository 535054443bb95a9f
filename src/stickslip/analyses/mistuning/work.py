"""A population of mistuned disks as independent cases: the tuned disk first, then one sample each.

A tuned disk after running in: its sliders start where slip has moved them.

Response of one mistuned disk or of a random population of them, compared with the tuned disk.

Labelled dataset of mistuned disks, from the arrays of the tuned disk and of all samples.

Fatigue margins of the blades of mistuned disks, each at its largest amplitude.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import cached_property
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.linalg import LinAlgError

from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.mistuning.disk import (
    RELATIVE,
    Mistuning,
    Scatter,
    blade_dofs,
    deviating_contacts,
    mistuned_disk,
    refuse_unmet,
)
from stickslip.analyses.response_dataset import levels_are_newtons
from stickslip.analyses.settings import (
    Execution,
    ForcedResponseSettings,
    MeasuredOutput,
    OfKind,
    Samples,
    Seed,
    Setting,
    Whole,
    takes,
)
from stickslip.analyses.stress import SIZES, Equivalent, has_fatigue, own_recovery, sector_stresses, with_fatigue
from stickslip.model.contact.point import Contact, SliderOffset
from stickslip.model.disks.tuned import LARGE, REACH, FullDisk, TunedDisk, few_waves, most_coordinates
from stickslip.model.problem import Problem
from stickslip.model.structure.matrices import ModalDamping
from stickslip.model.structure.stress import COMPONENTS, FatigueLimit
from stickslip.results.schema import Result, stacked, tabulated
from stickslip.runs.cases import Arrays, Report, all_cases
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.energy import contact_cycle, cycle_work
from stickslip.solve.balance.fourier import Harmonics, attribute, checked_harmonics, orders
from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.curve_points import CurvePoint, LostCurveError
from stickslip.solve.continuation.sweep import swept_curve
from stickslip.solve.curves.curve import solve_curve
from stickslip.solve.peaks.search import PeakSearch
from stickslip.solve.wheels.curve import LEAST, Wheels, sizes_of
from stickslip.support.checks import Array, InputError, between, fault, of_kind
from stickslip.support.late import xr
from stickslip.support.outcome import Outcome
from stickslip.support.units import Band


def run_in(
    disk: TunedDisk, band: Band | Sequence[float], force: float, harmonics: int | Sequence[int] = 5, samples: int = 256
) -> TunedDisk:
    """A copy whose contacts start from the mean slider positions s̄ = ū − T̄/kt at the highest point of the response to `force`.

    Whatever slips there has forgotten where it began. A contact that starts at s̄ and sticks carries the mean traction of one
    that slips; a virgin one (s = 0) carries another, which the first slip wears off in many small steps, each contact at a
    place of its own. band, force (one level), harmonics, samples: as of `forced_response`. Raises `InputError` where the
    response is not found.
    """
    of_kind("disk", disk, TunedDisk)
    work = ForcedResponseWork.of(ForcedResponseSettings(disk, band, force, harmonics, samples))
    return run_in_by(work, disk)


def run_in_by(work: ForcedResponseWork, disk: TunedDisk) -> TunedDisk:
    """As `run_in`, by the response of a work with one force level."""
    balance = HarmonicBalance(disk, work.harmonics, work.samples)
    omegas = [2.0 * np.pi * frequency for frequency in work.settings.frequencies]
    curve = solve_curve(balance, omegas, work.levels[0], work.settings.listed)
    if not curve.inside:
        raise InputError(f"The tuned disk must have a response to be run in by, but none was found. {curve.message}")
    row = balance.rows
    highest = max((point.evaluation for point in curve.inside), key=lambda found: float(np.hypot(*found.w[row, 1:3])))
    sliders = contact_cycle(balance.table, balance.tables, highest.w, highest.point.omega).mean_slider
    return replace(disk, contacts=tuple(_started(disk.contacts, sliders)))


def _started(contacts: Sequence[Contact], sliders: Array) -> Iterator[Contact]:
    """The contacts with slider offsets (elements,) of all their friction elements, one after the other."""
    first = 0
    for contact in contacts:
        starts = []
        for friction in contact.elements.friction:
            last = first + friction.stiffness.size
            starts.append(SliderOffset(tuple(sliders[first:last].tolist())))
            first = last
        yield contact.with_start(tuple(starts)) if starts else contact


PEAK_TOLERANCE = 1e-4
"""Relative amplitude by which the maximum of a blade may be too low; a tenth of it doubles the work."""

BEGUN, CURVE = 0.1, 0.5
"""Shares of the time of a sample until its matrices are ready and until its curve is solved; the maxima of the blades follow."""

LARGEST_DRAW = 4.0
"""Standard deviations that hardly a blade exceeds: the coordinates of a large disk are chosen for such."""


def _disk(name: str, disk: Any) -> TunedDisk:
    if not isinstance(disk, TunedDisk):
        raise InputError("The disk must be a tuned one, of which sectors then deviate. Make it by `TunedDisk`.")
    return disk


def _harmonics(name: str, harmonics: Any) -> Harmonics:
    return checked_harmonics(harmonics, "A forced response of the tuned disk shows how many are enough.")


SHIFTED = 0.1
"""Mean deviation of contact stiffness from which a disk is solved as a whole: at half the stiffness in all sectors peaks were 1 %
too low, at a tenth 3 %, as the damping ratio belongs to the tuned modes; at ±80 % about the tuned one 0.3 %."""

LIFTING = "Take a lower force, or solve at single frequencies, a list (`at` of [sweep])."


@dataclass(frozen=True, eq=False)
class PopulationWork(MeasuredOutput, Execution):
    """Case 0 is the tuned disk, solved as one sector; case k is sample k − 1."""

    disk: Annotated[TunedDisk, Setting(_disk)]
    band: Band | Sequence[float]
    count: Annotated[int, Setting(Whole(1))]
    scatter: Annotated[Scatter, Setting(OfKind(Scatter))]
    mistuning: Annotated[Mistuning | None, Setting(OfKind(Mistuning))] = None
    force: float = 1.0
    harmonics: Annotated[int | Sequence[int], Setting(_harmonics)] = 5
    samples: Samples = 256
    _: KW_ONLY
    seed: Seed = 0
    blade: Sequence[str] | None = None
    peak_tolerance: float = PEAK_TOLERANCE
    run_in: bool | None = None
    sweep: ForcedResponseWork = field(init=False, repr=False)
    """Where and how finely the tuned disk and every mistuned one are solved, for one output of a sector."""

    def __post_init__(self) -> None:
        super().__post_init__()
        outputs = self.disk.outputs
        kept = replace(self.disk, outputs=(outputs[between("output", self.output, 0, len(outputs) - 1)],))
        given = ForcedResponseSettings(
            kept,
            self.band,
            self.force,
            self.harmonics,
            self.samples,
            peak_tolerance=self.peak_tolerance,
            quantity=self.quantity,
            measure=self.measure,
        )
        sweep = ForcedResponseWork.of(given)
        if len(sweep.levels) != 1:
            raise fault("force", "must be one level", sweep.levels, "Compute a population for each.")
        object.__setattr__(self, "sweep", sweep)
        refuse_unmet(self.disk, [*self.base.names, *self.scatter.names])
        _ = self.blade_dofs

    @cached_property
    def base(self) -> Mistuning:
        """Deviations that all samples share, as arrays."""
        return (self.mistuning or Mistuning()).of(self.disk.sectors)

    @cached_property
    def blade_dofs(self) -> list[str]:
        """Degrees of freedom of a sector that make up its blade."""
        return blade_dofs(self.tuned, self.blade)

    @property
    def tuned(self) -> TunedDisk:
        """The tuned disk as it is solved."""
        return of_kind("disk", self.sweep.problem, TunedDisk)

    @cached_property
    def places(self) -> tuple[str, ...]:
        """Places of stress of a sector."""
        recovery = own_recovery(self.disk)
        return () if recovery is None else recovery.places

    @cached_property
    def started(self) -> TunedDisk:
        """The tuned disk with the start states of all samples."""
        run_in = self.by_sector if self.run_in is None else self.run_in
        return run_in_by(self.sweep, self.tuned) if run_in else self.tuned

    @cached_property
    def by_sector(self) -> bool:
        """Whether each disk is solved sector by sector on few shapes of its contacts (`solve/wheels`): where all modes have one
        damping ratio, every damper is there, contact stiffness is that of the tuned disk in the mean, since the ratio belongs to
        the modes of that, and no stress is asked for."""
        disk, sweep, rule = self.tuned, self.sweep, self.tuned.structure.damping
        if (
            not isinstance(rule, ModalDamping)
            or np.ndim(rule.ratio)
            or rule.on != "stuck"
            or not np.all(np.greater(rule.ratio, 0.0))
        ):
            return False
        other = disk.speed is not None or disk.aerodynamics or disk.modes_to is not None or self.places or sweep.settings.listed
        lacking = self.base.missing or self.scatter.missing
        shifted = any(abs(float(np.mean(self.base.deviation(name)))) > SHIFTED for name in ("kt", "kn"))
        if other or lacking or shifted or any(f.power for f in disk.forces) or not isinstance(sweep.harmonics, int):
            return False
        try:
            return bool(self._shapes < len(disk.contact_stiffness))
        except LinAlgError:  # degrees of freedom without mass
            return False

    @cached_property
    def _shapes(self) -> int:
        """On how many shapes of its contacts a sector is solved."""
        return int(self._wheels_of(self.tuned).few.size)

    @cached_property
    def wheels(self) -> Wheels:
        """What all disks that are solved sector by sector share."""
        return self._wheels_of(self.started)

    def _wheels_of(self, disk: TunedDisk) -> Wheels:
        sweep, (first, *_, last) = self.sweep, [2.0 * np.pi * frequency for frequency in self.sweep.settings.frequencies]
        assert isinstance(sweep.harmonics, int)
        band = min(first, last), max(first, last)
        return Wheels(disk, self.blade_dofs, sweep.harmonics, sweep.samples, band, sweep.levels[0])

    @property
    def _modes_to(self) -> float:
        """Natural frequency up to which a large disk keeps the modes of every nodal diameter, Hz."""
        return REACH * max(self.sweep.settings.frequencies) * orders(self.sweep.harmonics)[-1]

    @property
    def large(self) -> bool:
        """Whether the whole disk is put on few coordinates."""
        return self.disk.sectors * self.disk.structure.size > LARGE

    @cached_property
    def coordinates(self) -> int:
        """On how many coordinates a mistuned disk is solved, at most."""
        disk = self.tuned
        size, sectors = disk.structure.size, disk.sectors
        if self.by_sector:
            return sectors * self._shapes
        return sectors * (min(size, most_coordinates(disk, self._modes_to, self.blade_dofs)) if self.large else size)

    @cached_property
    def whole(self) -> FullDisk:
        """The tuned disk with all its sectors, a large one on few coordinates of each nodal diameter."""
        disk, shapes = self.started, None
        if self.large:
            pattern = float(np.abs(self.base.deviation("blade")).max(initial=0.0))
            shapes = few_waves(disk, self._modes_to, self.blade_dofs, pattern + LARGEST_DRAW * self.scatter.blade)
            shapes = shapes if shapes.shape[2] < disk.structure.size else None
        return disk.full(shapes=shapes)

    def deviations(self, sample: int) -> Mistuning:
        """The deviations of a sample, counted from 0."""
        return self.scatter.draw(self.disk.sectors, self.seed, sample).on_top_of(self.base)

    def mistuned(self, sample: int) -> FullDisk:
        """The disk of a sample, counted from 0."""
        return mistuned_disk(self.started, self.deviations(sample), self.blade_dofs, self.whole)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Everything that a sample depends on."""
        shared = [self.base.deviation(name).tolist() for name in RELATIVE]
        what = f"{shared!r}, missing {self.base.missing!r}, {self.identity('count', 'mistuning', 'sweep')}"
        return tuple(f"{'tuned' if k == 0 else f'sample {k - 1}'} of {what}" for k in range(self.count + 1))

    @property
    def words(self) -> tuple[str, ...]:
        return ("the tuned disk", *(f"sample {k + 1}" for k in range(self.count)))

    def prepare(self) -> None:
        """Compile the kernels, or load them from disk."""
        self.sweep.prepare()

    def solve(self, case: int, report: Report) -> Arrays:
        """Amplitudes of the blades and their maxima; of a sample that fails its outcome and a sentence."""
        started = time.process_time()
        try:
            if case and self.by_sector:
                arrays = self._wheel(self.deviations(case - 1).of(self.disk.sectors), report)
            else:
                arrays = self._solved(self.started if case == 0 else self.mistuned(case - 1), report)
        except (LostCurveError, LinAlgError, InputError) as reason:
            blades = 1 if case == 0 else self.disk.sectors
            stress = np.full((blades, len(self.places), len(SIZES) + len(COMPONENTS)), np.nan)
            nothing = {"frequency": np.empty(0), "amplitude": np.empty((0, blades)), "stress": stress}
            unknown = {name: np.full(blades, np.nan) for name in ("peak", "peak_frequency", "damper_work")}
            arrays = {**nothing, **unknown, "outcome": np.array(int(Outcome.NOT_CONVERGED)), "message": np.array(str(reason))}
        return {**arrays, "cpu_seconds": np.array(time.process_time() - started)}

    def _wheel(self, given: Mistuning, report: Report) -> Arrays:
        """Of a disk that is solved sector by sector; where that loses it or leaves a maximum unproven, as a whole, which would
        take hours for a large disk."""
        if not given.names:
            tuned, N = self._solved(self.started, report), self.disk.sectors
            each = {name: np.repeat(tuned[name], N, axis=-1) for name in ("amplitude", "peak", "peak_frequency", "damper_work")}
            return {**tuned, **each, "stress": np.repeat(tuned["stress"], N, axis=0)}
        measure, blade, pull = self.sweep.measure, given.deviation("blade"), 1.0 + given.deviation("pull")
        contacts = deviating_contacts(self.started.contacts * self.disk.sectors, given)
        found, reasons = None, []
        for oriented in (False,) if self.large else (False, True):
            try:
                found = self.wheels.curve(blade, pull, contacts, measure, self.peak_tolerance, report, oriented)
            except (LostCurveError, LinAlgError) as lost:
                reasons.append(str(lost))
            if found is not None and not found.unproven:
                break
        else:
            try:
                if not self.large:
                    whole = self._solved(mistuned_disk(self.started, given, self.blade_dofs, self.whole), report)
                    return {**whole, "message": np.array("Solved as a whole: sector by sector it was lost.")}
            except (LostCurveError, LinAlgError) as lost:
                reasons.append(f"As a whole: {lost}")
        if found is None:
            raise LostCurveError(" ".join((*reasons[-2:], LIFTING)))
        per, hertz = measure.per(self.sweep.levels[0]), 0.5 / np.pi
        stress = np.zeros((blade.size, 0, len(SIZES) + len(COMPONENTS)))
        arrays = {"frequency": hertz * found.omega, "amplitude": found.sizes / per, "peak": found.peak / per}
        message = Outcome.CONVERGED.sentence
        if found.unproven:
            worst = max(found.unproven, key=lambda each: each.bound)
            message = (
                f"A blade may be higher by {worst.share:.1%} at {hertz * worst.omega:.6g} Hz: Newton's method failed beside its "
                f"peak, or divisions ran out."
            )
        status = {"outcome": np.array(int(Outcome.CONVERGED)), "message": np.array(message)}
        return {**arrays, "peak_frequency": hertz * found.place, "stress": stress, "damper_work": found.work, **status}

    def _solved(self, problem: Problem, report: Report) -> Arrays:
        sweep = self.sweep
        balance = HarmonicBalance(problem, sweep.harmonics, sweep.samples)
        omegas = [2.0 * np.pi * frequency for frequency in sweep.settings.frequencies]
        if sweep.settings.listed:
            curve = solve_curve(balance, omegas, sweep.levels[0], True, report)
            if curve.outcome != Outcome.CONVERGED:
                raise LostCurveError(curve.message)
            return _blades(balance, curve.points, None, sweep.measure)
        report(BEGUN)
        band = omegas[0], omegas[-1]
        points = swept_curve(balance, sweep.levels[0], band, lambda share: report(BEGUN + share * (CURVE - BEGUN)))
        search = PeakSearch(balance, points, self.peak_tolerance, band=(min(band), max(band)))
        return _blades(balance, points, search, sweep.measure, lambda share: report(CURVE + share * (1.0 - CURVE)))


def _blades(
    balance: HarmonicBalance,
    points: Sequence[CurvePoint],
    search: PeakSearch | None,
    measure: Measure,
    report: Report = lambda share: None,
) -> Arrays:
    """Sizes of all blades at the points (points, blades), the maximum of each inside the band and where it is, and the stress of
    each there."""
    amplitude = np.array([sizes_of(balance, point, measure) for point in points])
    frequency = np.array([point.point.omega for point in points]) / (2.0 * np.pi)
    inside = [k for k, point in enumerate(points) if search is None or search.holds(point.point.omega)]
    peak, highest = amplitude[inside].max(axis=0), [points[inside[k]] for k in amplitude[inside].argmax(axis=0)]
    for blade in range(peak.size if search is not None else 0):
        assert search is not None
        report(blade / peak.size)
        for found in search.peaks(blade, measure, least=LEAST).points:
            size = sizes_of(balance, found, measure)[blade]
            if size > peak[blade] and search.holds(found.point.omega):
                peak[blade], highest[blade] = size, found
    place = np.array([point.point.omega for point in highest]) / (2.0 * np.pi)
    work = damper_work(balance, highest[int(peak.argmax())])
    stress = sector_stresses(balance, [found.point for found in highest])
    status = {"outcome": np.array(int(Outcome.CONVERGED)), "message": np.array(Outcome.CONVERGED.sentence)}
    per = measure.per(points[0].point.level)
    found_arrays = {"frequency": frequency, "amplitude": amplitude / per, "peak": peak / per, "peak_frequency": place}
    return {**found_arrays, "stress": stress, "damper_work": work, **status}


def damper_work(balance: HarmonicBalance, point: CurvePoint) -> Array:
    """Work per period that the contacts of each damper take out, J: of all sectors, or of the one of a tuned disk."""
    disk = balance.problem
    sectors = disk.sectors if isinstance(disk, FullDisk) else 1
    forces = point.point.forces - point.evaluation.residual
    rows = cycle_work(forces, point.evaluation.w[: balance.rows])
    found, first = np.zeros(sectors), balance.table.first_row
    for c, contact in enumerate(disk.contacts):
        sector = int(contact.name.split()[0]) if sectors > 1 else 1
        found[sector - 1] += rows[first[c] : first[c + 1]].sum()
    return found


NO_WORK = 1e-18
"""J per period: a damper that sticks works less than this, by rounding."""


def population_dataset(work: PopulationWork, results: Sequence[Arrays]) -> xr.Dataset:
    """Axes sample, point (padded with NaN), blade (from 1); the tuned disk beside them."""
    tuned, samples = results[0], results[1:]
    N, measure = work.disk.sectors, work.sweep.measure
    coords: dict[str, Any] = {"blade": np.arange(1, N + 1)}
    data = _samples(samples) | _tuned(tuned) | _amplification(samples, tuned) | _deviations(work)
    if work.places:
        data |= _stresses(samples, tuned)
        coords |= {"place": list(work.places), "component": list(COMPONENTS)}
    attrs: dict[str, Any] = {"title": work.disk.heading, "study": "", "analysis": "mistuned_population"}
    attrs |= {"sectors": N, "engine_order": work.disk.engine_order, "seed": work.seed, "force_level": work.sweep.levels[0]}
    attrs |= {"harmonics": attribute(work.sweep.harmonics), "samples": work.sweep.samples, "whitehead": 0.5 * (1.0 + np.sqrt(N))}
    attrs |= measure.attributes
    attrs["cpu_seconds"] = sum(float(arrays["cpu_seconds"]) for arrays in results)
    found = tabulated("mistuned_population", data, coords, attrs, measure.reported_units(levels_are_newtons(work.disk)))
    found["amplitude"].attrs["long_name"] = f"{measure.words} of each blade"
    return found


def _samples(samples: Sequence[Arrays]) -> dict[str, Any]:
    """Curves, maxima and outcomes."""
    frequency, amplitude = (stacked([arrays[name] for arrays in samples]) for name in ("frequency", "amplitude"))
    peak, place, work = (np.array([arrays[name] for arrays in samples]) for name in ("peak", "peak_frequency", "damper_work"))
    busiest = np.where(np.nan_to_num(work).max(axis=1) > NO_WORK, np.nan_to_num(work).argmax(axis=1) + 1, 0)
    return {
        "frequency": frequency,
        "amplitude": amplitude,
        "envelope": amplitude.max(axis=2),
        "blade_peak": peak,
        "blade_peak_frequency": place,
        "damper_work": work,
        "busiest_damper": busiest,
        "sample_outcome": np.array([int(arrays["outcome"]) for arrays in samples], dtype=np.int8),
        "sample_message": [str(arrays["message"]) for arrays in samples],
        "cpu_time": [float(arrays["cpu_seconds"]) for arrays in samples],
    }


def _stresses(samples: Sequence[Arrays], tuned: Arrays) -> dict[str, Any]:
    """Of each blade at its largest amplitude, and of the tuned disk."""
    data: dict[str, Any] = {}
    for prefix, values in (("", np.array([arrays["stress"] for arrays in samples])), (TUNED, tuned["stress"][0])):
        data |= {prefix + name: values[..., k] for k, name in enumerate(SIZES)}
        data[f"{prefix}stress_mean"] = values[..., len(SIZES) :]
    return data


def _tuned(tuned: Arrays) -> dict[str, Any]:
    single = {f"tuned_{name}": float(tuned[name][0]) for name in ("damper_work", "peak", "peak_frequency")}
    return {"tuned_frequency": tuned["frequency"], "tuned_amplitude": tuned["amplitude"][:, 0]} | single


def _amplification(samples: Sequence[Arrays], tuned: Arrays) -> dict[str, Any]:
    """Largest over all blades against the tuned disk, and the blade that has it; NaN and 0 where a sample failed."""
    largest = np.array([arrays["peak"].max() for arrays in samples])
    worst = [0 if np.isnan(arrays["peak"]).any() else int(arrays["peak"].argmax()) + 1 for arrays in samples]
    return {"amplification": largest / float(tuned["peak"][0]), "worst_blade": worst}


def _deviations(work: PopulationWork) -> dict[str, Any]:
    drawn = [work.deviations(sample) for sample in range(work.count)]
    data: dict[str, Any] = {f"{name}_deviation": np.array([each.deviation(name) for each in drawn]) for name in RELATIVE}
    missing = [np.isin(np.arange(1, work.disk.sectors + 1), each.missing) for each in drawn]
    return data | {"damper_missing": np.array(missing, dtype=np.int8)}


TUNED = "tuned_"
KEPT = ("fatigue_amplitude", "fatigue_mean", "fatigue_limit")


class BladeMargin(NamedTuple):
    """The smallest margin of a population: sample and blade, from 1; the place and Hz; amplitude and mean of the stress there and
    the amplitude that the material stands, Pa; the smallest margin of the tuned disk."""

    sample: int
    blade: int
    place: str
    frequency: float
    alternating: float
    mean: float
    allowed: float
    tuned: float

    @property
    def size(self) -> float:
        """By how much the vibration may grow; infinite where nothing vibrates."""
        return self.allowed / self.alternating if self.alternating > 0.0 else np.inf


def with_blade_fatigue(
    dataset: xr.Dataset, limit: FatigueLimit, mean: Mapping[str, float] | None = None, equivalent: Equivalent = "sines"
) -> xr.Dataset:
    """A population with stress and its fatigue margins: `fatigue_amplitude`, `fatigue_mean` and `fatigue_limit` (sample, blade,
    place) as of `with_fatigue`, each blade at its largest amplitude, and those of the tuned disk, `tuned_fatigue_amplitude`, ...

    Where several modes are excited, stress may be larger at another frequency than that of the largest amplitude.
    """
    if "stress_mean" not in dataset:
        raise InputError(
            "A fatigue margin of mistuned disks needs the stress of their blades. Name places of stress with the model of the "
            "sector (stress = ...), and compute results of an older version again."
        )
    found = with_fatigue(dataset, limit, mean, equivalent)
    own_names = {TUNED + name: name for name in (*SIZES, "stress_mean")}
    tuned = with_fatigue(dataset[list(own_names)].rename(own_names), limit, mean, equivalent)
    return found.assign({TUNED + name: tuned[name] for name in KEPT})


def blade_margins(dataset: xr.Dataset, prefix: str = "") -> xr.DataArray:
    """The margin of each blade at each place, (sample, blade, place), or of the tuned disk (place,); NaN where it failed."""
    allowed, alternating = dataset[f"{prefix}fatigue_limit"], dataset[f"{prefix}fatigue_amplitude"]
    with np.errstate(divide="ignore", invalid="ignore"):
        return (allowed / alternating).where(alternating != 0.0, np.inf).where(np.isfinite(alternating))


def smallest_blade_margin(dataset: xr.Dataset) -> BladeMargin | None:
    """The smallest margin of all blades, samples and places; None without a fatigue limit or where every sample failed."""
    if not has_fatigue(dataset):
        return None
    sizes = blade_margins(dataset)
    if not sizes.notnull().any():
        return None
    sample, blade, place = np.unravel_index(int(np.nanargmin(sizes.values)), sizes.shape)
    here = dataset.isel(sample=int(sample), blade=int(blade), place=int(place))
    alternating, mean, allowed = (float(here[name]) for name in KEPT)
    where = int(sample) + 1, int(here["blade"]), str(here["place"].values), float(here["blade_peak_frequency"])
    return BladeMargin(*where, alternating, mean, allowed, float(blade_margins(dataset, TUNED).min()))


def quantile_interval(values: Array, share: float, confidence: float = 0.95) -> tuple[float, float]:
    """The confidence interval of a quantile from independent samples, whatever their distribution; ∓inf where they are too few.

    How many of n samples lie below the quantile of share p is binomial, B(n, p): of the sorted ones the l-th and the u-th enclose
    it with the probability that l ≤ B < u (W. J. Conover, Practical Nonparametric Statistics, 3rd ed. 1999, section 3.2).
    """
    from scipy.stats import binom

    ends = [-np.inf, *np.sort(values).tolist(), np.inf]
    rest = 0.5 * (1.0 - confidence)
    lower, upper = (int(binom.ppf(each, values.size, share)) for each in (rest, 1.0 - rest))
    return ends[lower], ends[upper + 1]


@dataclass(frozen=True, eq=False, repr=False)
class MistunedPopulation(Result):
    """One mistuned disk or many: `dataset` has an axis `sample`, and for each of them the amplitudes of all blades over the
    frequency, the envelope, the maximum of each blade, the worst blade, the amplification and the deviations drawn.
    """

    dataset: xr.Dataset
    disk: TunedDisk

    def with_fatigue(
        self, limit: FatigueLimit, mean: Mapping[str, float] | None = None, equivalent: Equivalent = "sines"
    ) -> MistunedPopulation:
        """A copy whose dataset also holds the fatigue margin of each blade at its largest amplitude, for report and tables.

        The sector must have places of stress. Arguments: `ForcedResponse.with_fatigue`.
        """
        return replace(self, dataset=with_blade_fatigue(self.dataset, limit, mean, equivalent))


def mistuned_response(
    disk: TunedDisk,
    band: Band | Sequence[float],
    mistuning: Mistuning,
    force: float = 1.0,
    harmonics: int | Sequence[int] = 5,
    samples: int = 256,
    **options: Any,
) -> MistunedPopulation:
    """The response of all blades of one mistuned disk; arguments and options as of `mistuned_population`."""
    return mistuned_population(disk, band, 1, Scatter(), mistuning, force, harmonics, samples, **options)


@takes(PopulationWork)
def mistuned_population(work: PopulationWork) -> MistunedPopulation:
    """Responses of `count` disks whose sectors deviate at random, all under one engine order and one force level.

    mistuning: deviations that all samples share; with a pattern of the blades there and scatter of contacts alone, the samples
    are one disk mounted again and again. blade: what makes up a blade, see `mistuned_disk`. output: which output of a sector
    is the amplitude of its blade. band, force, harmonics, samples, workers, checkpoint, progress: see `forced_response`; at a
    list of frequencies, maxima are the largest values there. peak_tolerance: by how much maxima over a band may be too low.
    run_in: all start from the sliders of the tuned disk at its highest point (`stickslip.run_in`).
    quantity, measure: what amplitudes and their maxima are of, as for `forced_response`.

    Amplification is the highest amplitude of any blade over the band, divided by that of the tuned disk with the same dampers and
    force. Sample k depends on the seed and k alone, whatever the number of samples and workers. One that fails is marked.
    """
    results = all_cases(work, work.checkpoint, work.workers, work.progress)
    return MistunedPopulation(population_dataset(work, results), work.disk)
