"""Performance curves as independent cases, one friction coefficient each: peak continuation, optimum and contact states.

Copies of a problem with scaled friction or preload, the forces in F_C/F_E, and the search band for resonances, from the free to
the stuck one, with the message if it holds none.

Contact states over a steady period as performance curves name them: stick, microslip, slip, lift-off.

Optimum of a performance curve (lowest peak per force) and its plateau, both solved between the given values.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, fields, replace
from functools import cached_property, lru_cache
from math import exp, log
from typing import Annotated, Any, Literal, get_args

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from stickslip.analyses.forced_response import compile_forced_response
from stickslip.analyses.peak_shapes import own_shapes_change
from stickslip.analyses.settings import (
    Ends,
    Execution,
    MeasuredOutput,
    OfProblem,
    OneOf,
    ProblemWithShapes,
    Sampled,
    Setting,
    Whole,
    ends_of,
    fineness_of,
    frictions_of,
    output_of,
    over_a_band,
    ratios_of,
)
from stickslip.model.contact.law import SLIDERS, Law
from stickslip.model.contact.point import Contact
from stickslip.model.contact.protocol import OPEN, STICK, friction_period
from stickslip.model.loads import BaseMotion
from stickslip.model.problem import Problem
from stickslip.model.problem.speed import CentrifugalLoad
from stickslip.runs.cases import Arrays, Report
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance
from stickslip.solve.balance.energy import ContactCycle, EnergyBalance, contact_cycle, friction_limits
from stickslip.solve.balance.linear_response import linear_peak
from stickslip.solve.continuation.curve_points import LostCurveError
from stickslip.solve.curves.curve import refuse_hidden
from stickslip.solve.peaks.climb import PeakBand
from stickslip.solve.peaks.continuation import ContinuedPeaks, ParameterPeak, PeakContinuation
from stickslip.support.checks import Array, Index, InputError, fault, not_negative, positive
from stickslip.support.machine import one_blas_thread
from stickslip.support.outcome import Outcome
from stickslip.support.units import Band

PRELOADS = ("normal_load", "preload")
"""Fields of contact laws that hold a load in newtons."""


def with_friction(problem: Problem, mu: float) -> Problem:
    """A copy with one friction coefficient at every contact that rubs."""
    not_negative("friction", mu)
    if not any(_has(contact.law, "mu") for contact in problem.contacts):
        raise fault("friction", "must meet a contact law with a coefficient mu", "none has one")
    return problem.with_contacts(lambda contact: _changed(contact, mu=mu))


def with_preload_factor(problem: Problem, factor: float) -> Problem:
    """A copy with every static force and every preload of a contact law times a factor; gaps and stiffness stay."""
    positive("preload factor", factor)
    forces, speed = [replace(force, static=factor * force.static) for force in problem.forces], problem.speed
    if speed is not None:
        speed = replace(speed, loads=tuple(replace(load, static=factor * load.static) for load in speed.loads))

    def loaded(contact: Contact) -> Contact:
        values = {key: getattr(contact.law, key) for key in PRELOADS if _has(contact.law, key)}
        return _changed(contact, **{key: _times(factor, value) for key, value in values.items()})

    return replace(problem, forces=tuple(forces), speed=speed).with_contacts(loaded)


def with_factors(contact: Contact, factors: Mapping[str, float]) -> Contact:
    """A copy with fields of its law times factors; fields that the law does not have are passed over."""
    law = contact.law
    return _changed(contact, **{key: _times(factor, getattr(law, key)) for key, factor in factors.items() if _has(law, key)})


def centrifugal_pull(problem: Problem) -> float:
    """F_C, N: the largest static force, or without any the largest preload of a contact law."""
    static = [
        float(np.linalg.norm(force.resultant))
        if isinstance(force, CentrifugalLoad)
        else abs(force.static) * _length(force.coefficients)
        for force in problem.forces
    ]
    if max(static, default=0.0) > 0.0:
        return max(static)
    loads = [
        np.sum(getattr(contact.law, key) or 0.0) for contact in problem.contacts for key in PRELOADS if _has(contact.law, key)
    ]
    largest = float(max(loads, default=0.0))
    if largest <= 0.0:
        raise fault("The problem", "must have a static force or a preload, F_C", "neither", "Give `pull`.")
    return largest


def excitation(problem: Problem) -> float:
    """F_E at force level one, N: the largest amplitude of a harmonic force."""
    if any(isinstance(force, BaseMotion) or force.power for force in problem.forces if any(force.amplitudes.values())):
        remedy = "Follow the peak in another parameter, `follow_peaks`."
        raise fault("F_E", "must be a force of one amplitude", "a moving base, or goes by a power of the frequency", remedy)
    sizes = [abs(a) * _length(force.coefficients) for force in problem.forces for a in force.amplitudes.values()]
    return float(max(sizes))


def _has(law: Law, key: str) -> bool:
    return any(field.name == key for field in fields(law))  # type: ignore[arg-type]


def _changed(contact: Contact, **values: Any) -> Contact:
    known = {key: value for key, value in values.items() if _has(contact.law, key)}
    return contact.with_law(replace(contact.law, **known)) if known else contact  # type: ignore[type-var]


def _times(factor: float, value: Any) -> Any:
    if value is None:
        return None
    return factor * value if np.ndim(value) == 0 else tuple(factor * np.asarray(value, dtype=float))


def _length(direction: Mapping[str, float]) -> float:
    """The size of a force along a direction: of its resultant, or of one side of a force that balances itself."""
    nodes: dict[str, dict[str, float]] = {}
    whole: dict[str, float] = {}
    for dof, share in direction.items():
        node, _, axis = dof.rpartition(".")
        nodes.setdefault(node, {})[axis] = share
        whole[axis] = whole.get(axis, 0.0) + share
    sides = sum(float(np.linalg.norm(list(each.values()))) for each in nodes.values())
    return max(float(np.linalg.norm(list(whole.values()))), 0.5 * sides)


OUTSIDE = (0.9, 1.1)
"""How far the band reaches beyond the free and the stuck resonance."""


def resonance_band(balance: HarmonicBalance, output: int) -> Band:
    """A band that holds the free and the stuck resonance of an output."""
    peaks = [linear_peak(balance, output, stuck).frequency for stuck in (False, True)]
    return Band(OUTSIDE[0] * min(peaks), OUTSIDE[1] * max(peaks))


def no_resonance(balance: HarmonicBalance, output: int, band: Ends, where: str = "") -> InputError:
    """The fault of a band in Hz that holds no resonance of an output; where: " at 5 N", say."""
    free, stuck = (linear_peak(balance, output, stuck).frequency for stuck in (False, True))
    remedy = f"The highest resonance without contacts is at {free:.5g} Hz, that with contacts stuck at {stuck:.5g} Hz."
    return fault("The band of frequencies", f"must hold a resonance{where}", f"{band[0]:g} to {band[1]:g} Hz", remedy)


PLATEAU = 0.1
"""The plateau is where the peak is higher than at the optimum by at most this share."""

CLOSE, TRIALS = 2e-4, 40
"""To how much of its logarithm F_C/F_E is searched, and the most peaks that each search solves."""


@dataclass(frozen=True)
class LowestPeak:
    """F_C/F_E of the lowest peak, its amplitude per force in m/N and frequency in Hz; the ends of the plateau, NaN where the
    values end before; warning: why the optimum may not be the lowest, "" where none is known.
    """

    ratio: float
    amplitude_per_force: float
    frequency: float
    plateau: tuple[float, float]
    warning: str


class PeakBetween:
    """Peaks per force at any F_C/F_E, by its logarithm: those known, else followed from the values, else swept.

    force_at: excitation amplitude in N at a ratio.
    """

    def __init__(self, continuation: PeakContinuation, found: ContinuedPeaks, force_at: Callable[[float], float]) -> None:
        self.continuation, self.found, self.force_at = continuation, found, force_at
        known = {value: place[1] for value in found.values if (place := found.highest(value)) is not None}
        self.places: dict[float, ParameterPeak] = {log(value): place for value, place in known.items()}

    def __call__(self, x: float) -> float:
        """The peak per force, m/N, at ln(F_C/F_E); raises `LostCurveError` where no peak is found."""
        x = float(x)
        if x not in self.places:
            place = self.continuation.at(self.found, exp(x)) or self.continuation.swept(exp(x))
            if place is None:
                raise LostCurveError(f"no peak was found at F_C/F_E = {exp(x):.4g}")
            self.places[x] = place
        return self.places[x].peak.amplitude / self.force_at(self.places[x].value)

    @property
    def known(self) -> Array:
        """All ln(F_C/F_E) at which the peak is known, ascending."""
        return np.array(sorted(self.places))

    @property
    def lowest(self) -> float:
        """ln(F_C/F_E) of the lowest peak known."""
        return min(self.places, key=self)


def lowest_peak(peak: PeakBetween) -> LowestPeak:
    """The lowest peak, searched between the neighbours of the lowest known one, and the plateau around it."""
    values, best = peak.known, peak.lowest
    k, messages = int(np.searchsorted(values, best)), []
    if 0 < k < values.size - 1:
        try:
            ends = (float(values[k - 1]), float(values[k + 1]))
            scipy.optimize.minimize_scalar(peak, bounds=ends, method="bounded", options={"xatol": CLOSE, "maxiter": TRIALS})
        except LostCurveError as lost:
            messages.append(f"the search for the lowest peak ended, since {lost}")
    else:
        messages.append(f"the lowest peak is at an end of the values, F_C/F_E = {exp(best):.4g}: it may be lower beyond")
    best = peak.lowest
    peak.places[best], peak_band = peak.continuation.settled(peak.places[best])
    plateau = []
    for side in (-1, 1):
        try:
            plateau.append(_reached(peak, best, side))
        except LostCurveError as lost:
            plateau.append(np.nan)
            messages.append(f"an end of the plateau is not known, since {lost}")
    return LowestPeak(exp(best), peak(best), peak_band.omega / (2.0 * np.pi), (plateau[0], plateau[1]), "; ".join(messages))


def _reached(peak: PeakBetween, best: float, side: int) -> float:
    """The ratio beside the best one at which the peak is higher by the share of the plateau; NaN where the values end before."""
    height = (1.0 + PLATEAU) * peak(best)
    inner = best
    for x in peak.known[::side]:
        if (x - best) * side > 0.0:
            if peak(x) > height:
                return exp(
                    scipy.optimize.brentq(lambda x: log(peak(x) / height), inner, x, xtol=CLOSE, maxiter=TRIALS, disp=False)
                )
            inner = x
    return np.nan


REGIONS = ("stick", "microslip", "slip", "lift-off")
STUCK, MICROSLIP, SLIP, LIFT_OFF = range(4)


def contact_regions(balance: HarmonicBalance, evaluation: Evaluation, cycle: ContactCycle) -> Index:
    """The region of each contact, (contacts,): it opens, or all, some or none of its closed elements slip.

    Elements count in the tangential direction in which the contact moves most. Index into `REGIONS`.
    """
    slips = _slipping_elements(balance, evaluation, cycle)
    travel = np.ptp(cycle.displacement, axis=1)
    found, row = [], 0
    for contact in balance.problem.contacts:
        tangential = range(row, row + len(contact.tangential))
        normal = row + len(contact.tangential) if contact.normal is not None else None
        row += len(contact.directions)
        if normal is not None and bool(np.any(cycle.state[normal] == OPEN)):
            found.append(LIFT_OFF)
        elif not tangential:
            found.append(STUCK)
        else:
            shares = slips[max(tangential, key=lambda r: travel[r])]
            found.append(STUCK if not any(shares) else SLIP if all(shares) else MICROSLIP)
    return np.array(found, dtype=np.int64)


def whole_region(regions: Index, friction: Index) -> int:
    """The region of all contacts together: lift-off of any; slip of all with friction; stick of all; else microslip."""
    rubbing = regions[friction]
    if np.any(regions == LIFT_OFF):
        return LIFT_OFF
    if rubbing.size == 0 or np.all(rubbing == STUCK):
        return STUCK
    return SLIP if np.all(rubbing == SLIP) else MICROSLIP


def _slipping_elements(balance: HarmonicBalance, evaluation: Evaluation, cycle: ContactCycle) -> dict[int, list[bool]]:
    """For each tangential row, whether each of its elements slips; elements open all the time are left out."""
    table, tables, w = evaluation.table, balance.tables, evaluation.w
    samples = tables.E.shape[0]
    y, event = np.empty(samples), np.empty(samples, dtype=np.int64)
    found: dict[int, list[bool]] = {row: [] for row in range(balance.rows)}
    for e, row, u, limit, landing in friction_limits(table, tables, w):
        if table.kind[np.searchsorted(table.first_row, row, side="right") - 1] != SLIDERS:
            found[row] = [bool(np.any((cycle.state[row] != STICK) & (cycle.state[row] != OPEN)))]
            continue
        kt, kind, value = table.stiffness[e], int(table.start_kind[e]), table.start_value[e]
        friction_period(kind, value, kt, kt * u, limit, landing, kt * w[row, 0], y, event)
        if not np.all(event == OPEN):
            found[row].append(bool(np.any((event != STICK) & (event != OPEN))))
    return found


Vary = Literal["force", "preload"]
Pull = Annotated[float | None, Setting(positive, "centrifugal load F_C of the problem; default: its largest static force")]


@dataclass(frozen=True, eq=False)
class OverRatios(Sampled, MeasuredOutput, Execution):
    """Resonances at values of F_C/F_E, in a band of the excitation."""

    problem: OfProblem
    force_ratio: Annotated[ArrayLike, Setting(ratios_of, "[low, high] of F_C/F_E")]
    _: KW_ONLY
    band: Annotated[Band | None, Setting(over_a_band)] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        output_of(self.problem, self.output)
        fineness_of(self.harmonics, self.samples)

    @cached_property
    def ratios(self) -> tuple[float, ...]:
        """Values of F_C/F_E, ascending."""
        return ratios_of("force_ratio", self.force_ratio)


@dataclass(frozen=True, eq=False)
class PerformanceWork(OverRatios):
    """Performance curves as independent cases, a friction coefficient each."""

    problem: ProblemWithShapes
    friction: Annotated[
        float | Sequence[float] | None,
        Setting(frictions_of, "friction coefficients of all contacts; default: those of the problem"),
    ] = None
    vary: Annotated[
        Vary, Setting(OneOf(get_args(Vary)), "load that changes: the excitation, or the static forces and preloads")
    ] = "force"
    _: KW_ONLY
    pull: Pull = None
    check_every: Annotated[int, Setting(Whole(1), "points between two full sweeps that look for new peaks")] = 10

    @property
    def frictions(self) -> tuple[float, ...]:
        """Friction coefficients, NaN for those of the problem."""
        return (np.nan,) if self.friction is None else frictions_of("friction", self.friction)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Everything that a case depends on."""
        others = self.identity("friction")
        return tuple(f"performance curve, friction {mu!r}, {others}" for mu in self.frictions)

    @property
    def words(self) -> tuple[str, ...]:
        return tuple("performance curve" if np.isnan(mu) else f"performance curve, μ = {mu:g}" for mu in self.frictions)

    prepare = staticmethod(compile_forced_response)

    def solve(self, case: int, report: Report) -> Arrays:
        """The performance curve of one friction coefficient."""
        started = time.process_time()
        mu = self.frictions[case]
        problem = self.problem if np.isnan(mu) else with_friction(self.problem, mu)
        with one_blas_thread():
            arrays = _Curve(self, problem).arrays(report)
        return arrays | {"cpu_seconds": np.array(time.process_time() - started)}


class _Curve:
    """One performance curve."""

    def __init__(self, work: PerformanceWork, problem: Problem) -> None:
        self.work, self.problem = work, problem
        self.nominal = HarmonicBalance(problem, work.harmonics, work.samples)
        self.band = ends_of(work.band or resonance_band(self.nominal, work.output))
        self.free, self.stuck = (
            linear_peak(self.nominal, work.output, stuck, work.measured, self.band) for stuck in (False, True)
        )
        self.free_harmonic = self.free.amplitude / float(work.measured.of_harmonic(np.array(1.0), np.array(1.0)))
        self.pull = centrifugal_pull(problem) if work.pull is None else work.pull
        self.unit = excitation(problem)
        refuse_hidden(problem, [self.pull / (ratio * self.unit) if work.vary == "force" else 1.0 for ratio in work.ratios])
        self.balance_at = lru_cache(maxsize=None)(self._preloaded)

    def _preloaded(self, ratio: float) -> HarmonicBalance:
        factor = ratio * self.unit / self.pull
        return HarmonicBalance(with_preload_factor(self.problem, factor), self.work.harmonics, self.work.samples)

    def balance_and_level(self, ratio: float) -> tuple[HarmonicBalance, float]:
        """The balance and the force level at a ratio F_C/F_E."""
        if self.work.vary == "force":
            return self.nominal, self.pull / (ratio * self.unit)
        return self.balance_at(ratio), 1.0

    def arrays(self, report: Report) -> dict[str, NDArray[Any]]:
        """Everything about the curve, by name."""
        work = self.work
        low, high = self.band
        continuation = PeakContinuation(
            self.balance_and_level, (2.0 * np.pi * low, 2.0 * np.pi * high), work.output, work.measured
        )
        found = continuation.follow(work.ratios[::-1], work.check_every, lambda fraction: report(0.8 * fraction))
        points, contacts = len(work.ratios), len(self.problem.contacts)
        arrays: dict[str, NDArray[Any]] = {name: np.full(points, np.nan) for name in PER_POINT}
        arrays["outcome"] = np.full(points, int(Outcome.NOT_CONVERGED), dtype=np.int8)
        arrays["dissipated"], arrays["contact_region"] = np.full((points, contacts), np.nan), np.full((points, contacts), np.nan)
        for name in ("branch_frequency", "branch_amplitude_per_force"):
            arrays[name] = np.full((points, len(found.branches)), np.nan)
        for k in range(points):
            self._fill(arrays, k, continuation, found)
        arrays |= self._optimum(continuation, found)
        arrays |= _event_arrays(found)
        if self.problem.mesh is not None:
            arrays["modal_error"] = self._by_own_shapes(found, float(arrays["optimum_ratio"]))
        linear = {"free": self.free, "stuck": self.stuck}
        for name, peak in linear.items():
            arrays[f"{name}_frequency"] = np.array(peak.frequency)
            arrays[f"{name}_amplitude_per_force"] = np.array(peak.amplitude / self.unit)
        return arrays | {"pull": np.array(self.pull), "band": np.array([low, high])}

    def _fill(self, arrays: dict[str, NDArray[Any]], k: int, continuation: PeakContinuation, found: ContinuedPeaks) -> None:
        ratio = self.work.ratios[k]
        force = self.unit * self.balance_and_level(ratio)[1]
        highest = found.highest(ratio)
        if highest is not None:
            b, (place, peak_band) = highest[0], continuation.settled(highest[1])
            found.branches[b].places[ratio] = place
            arrays["branch"][k] = b
            self._fill_place(arrays, k, place, peak_band, force)
        for b, branch in enumerate(found.branches):
            if ratio in branch.places:
                peak = branch.places[ratio].peak
                arrays["branch_frequency"][k, b] = peak.omega / (2.0 * np.pi)
                arrays["branch_amplitude_per_force"][k, b] = peak.amplitude / force
        if highest is not None:
            arrays["branch_frequency"][k, highest[0]] = arrays["frequency"][k]
        detached = found.detached(ratio)
        if detached is not None:
            arrays["detached_frequency"][k] = detached[1].peak.omega / (2.0 * np.pi)
            arrays["detached_amplitude_per_force"][k] = detached[1].peak.amplitude / force

    def _fill_place(
        self, arrays: dict[str, NDArray[Any]], k: int, place: ParameterPeak, peak_band: PeakBand, force: float
    ) -> None:
        balance, peak = self.balance_and_level(place.value)[0], place.peak
        evaluation = peak.evaluation
        cycle = contact_cycle(evaluation.table, balance.tables, evaluation.w, evaluation.point.omega)
        energy = EnergyBalance(balance).along([evaluation])
        per_force = peak.amplitude / force
        frequency = peak_band.omega / (2.0 * np.pi)
        row = self.nominal.rows + self.work.output
        measured, further = self.work.measured, 2 - self.work.measured.order
        harmonic = measured.with_kind("amplitude").size(evaluation.w[row], peak.omega) / force
        regions = contact_regions(balance, evaluation, cycle)
        rubbing = np.array([bool(contact.tangential) for contact in self.problem.contacts])
        rows = [c for c, contact in enumerate(self.problem.contacts) for _ in contact.directions]
        values = {
            "frequency": frequency,
            "amplitude": peak.amplitude,
            "amplitude_per_force": per_force,
            "inertance": peak_band.omega**further * harmonic,
            "normalised_amplitude": per_force * self.unit / self.free.amplitude,
            "normalised_inertance": harmonic * self.unit / self.free_harmonic * (frequency / self.free.frequency) ** further,
            "normalised_frequency": frequency / self.free.frequency,
            "frequency_width": peak_band.width / (2.0 * np.pi),
            "on_kink": float(peak.on_kink),
            "region": whole_region(regions, rubbing),
            "loss_factor": energy.loss_factor[0],
            "residual": evaluation.error,
            "energy_residual": energy.energy_residual[0],
            "slip_work_error": energy.slip_work_error(cycle.slip_work.sum())[0],
        }
        for name, value in values.items():
            arrays[name][k] = value
        arrays["outcome"][k] = int(Outcome.CONVERGED)
        arrays["contact_region"][k] = regions
        arrays["dissipated"][k] = np.bincount(rows, energy.dissipated[0], minlength=len(self.problem.contacts))

    def _by_own_shapes(self, found: ContinuedPeaks, optimum: float) -> Array:
        """What all shapes of the contact forces of a mesh change of the peaks at the ends and next to the lowest one, relative,
        (points,); NaN at the others."""
        ratios, errors = self.work.ratios, np.full(len(self.work.ratios), np.nan)
        lowest = int(np.argmin(np.abs(np.log(np.array(ratios) / optimum)))) if np.isfinite(optimum) else 0
        for k in sorted({0, lowest, len(ratios) - 1}):
            highest = found.highest(ratios[k])
            if highest is not None:
                balance, peak = self.balance_and_level(ratios[k])[0], highest[1].peak.evaluation
                errors[k] = own_shapes_change(balance, peak, self.work.output, self.work.measured)
        return errors

    def _optimum(self, continuation: PeakContinuation, found: ContinuedPeaks) -> dict[str, NDArray[Any]]:
        """The lowest peak per force, the plateau around it, and the warnings about them."""
        peak = PeakBetween(continuation, found, lambda ratio: self.unit * self.balance_and_level(ratio)[1])
        if not peak.places:
            return {name: np.array(np.nan) for name in OPTIMUM} | {"optimum_warning": np.array("no peak was found")}
        best = lowest_peak(peak)
        numbers = (best.ratio, best.amplitude_per_force, best.frequency, *best.plateau)
        return dict(zip(OPTIMUM, map(np.array, numbers), strict=True)) | {"optimum_warning": np.array(best.warning)}


OPTIMUM = ("optimum_ratio", "optimum_amplitude_per_force", "optimum_frequency", "plateau_low", "plateau_high")
PER_POINT = (
    *("frequency", "amplitude", "amplitude_per_force", "inertance", "normalised_amplitude", "normalised_inertance"),
    *("normalised_frequency", "frequency_width", "on_kink", "region", "loss_factor", "residual", "energy_residual"),
    *("slip_work_error", "branch", "detached_frequency", "detached_amplitude_per_force"),
)


def _event_arrays(found: ContinuedPeaks) -> dict[str, NDArray[Any]]:
    """Events in words, in the order of F_C/F_E, checks by full sweeps, and what following cost."""
    placed = sorted((min(e.low, e.high), max(e.low, e.high), e.frequency, e.kind, e.words) for e in found.events)
    events = [f"F_C/F_E {low:.4g} to {high:.4g}, {frequency:.5g} Hz: {words}" for low, high, frequency, _, words in placed]
    numbers = np.array([row[:3] for row in placed], dtype=float).reshape(-1, 3).T
    checks = np.array([(c.value, c.swept, c.followed, c.points) for c in found.checks], dtype=float).reshape(-1, 4).T
    return {
        "event": np.array(events, dtype=np.str_),
        "event_kind": np.array([kind for *_, kind, _ in placed], dtype=np.str_),
        "event_low": numbers[0],
        "event_high": numbers[1],
        "event_frequency": numbers[2],
        "check_ratio": checks[0],
        "check_swept": checks[1],
        "check_followed": checks[2],
        "check_points": checks[3],
        "solves": np.array(found.solves),
        "iterations": np.array(found.iterations),
    }
