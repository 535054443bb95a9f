"""Forced response: steady vibration under harmonic forces over a frequency band, at one or several force levels."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property, lru_cache, partial
from math import lcm
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.analyses import harmonic_choice, peak_shapes, solved_points, truncation
from stickslip.analyses.further_curves import SolvedCurve, all_branches, branch_point_table, branches
from stickslip.analyses.isolated import Isolated, other_motion_warning, searched, sought_unasked, take_from_modes, unsought
from stickslip.analyses.motion import response_motion, with_motion
from stickslip.analyses.nodal_diameters import with_disk
from stickslip.analyses.reached import reached, with_reached
from stickslip.analyses.response_dataset import (
    absolute,
    apart_of,
    arrays_of,
    as_given,
    beside,
    curve_arrays,
    response_dataset,
)
from stickslip.analyses.sensitivity import Parameter, Sensitivity, point_sensitivity
from stickslip.analyses.settings import OR_AUTO, ForcedResponseSettings, OneBalance, takes
from stickslip.analyses.stability import flags, judged, stability_warning, with_stability
from stickslip.analyses.static_load import Seated, history_change, opened, rest_of, seated_balance
from stickslip.analyses.stress import Equivalent, own_recovery, stress, with_fatigue, with_stress
from stickslip.analyses.time_response import TimeCheck, verify_in_time
from stickslip.model.problem import Problem
from stickslip.model.problem.contraction import contracts
from stickslip.model.problem.speed import over_periods
from stickslip.model.problem.systems import on_few_coordinates
from stickslip.model.problem.warnings import negative_damping
from stickslip.model.rigs import single_mass
from stickslip.model.structure.stress import FatigueLimit, StressRecovery
from stickslip.model.structure.stuck_mesh import NEGLIGIBLE
from stickslip.results.files import save
from stickslip.results.quantities import as_quantity, has_stability, words_of_flags
from stickslip.results.schema import CurveKind, Result, described, kinds_in, with_kinds
from stickslip.results.view import measure_in, nearest_point, periods_of, sizes
from stickslip.runs.cases import Arrays, CaseStopped, Checkpoint, Progress, Report, Workers, all_cases
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.energy import ContactCycle, contact_cycle
from stickslip.solve.balance.fourier import Harmonics, attribute, fourier, harmonics_for, highest, in_fractions, of_attribute
from stickslip.solve.balance.measure import Measure, measure_of
from stickslip.solve.curves.curve import Curve, CurveStopped, refined, refuse_hidden, solve_curve, stopped_curve
from stickslip.solve.peaks.search import TOLERANCE
from stickslip.solve.time.period import DEFAULT_METHOD, Method
from stickslip.support.checks import InputError, between, fault, of_kind
from stickslip.support.late import pd, xr
from stickslip.support.machine import one_blas_thread
from stickslip.support.outcome import Outcome
from stickslip.support.renderers import FIGURES
from stickslip.support.units import Band


@dataclass(frozen=True, eq=False, repr=False)
class ForcedResponse(Result):
    """Curves for every force level: `dataset` (labelled, with units) and the problem that made them."""

    dataset: xr.Dataset
    problem: Problem

    def peaks(self, quantity: str | None = None, measure: str | None = None) -> pd.DataFrame:
        """All peaks: force level, output, frequency [Hz], size, largest value in time, loss factor; highest first.

        The size is in the column `amplitude` (of the first harmonic), `rms` or `max_abs`, by the measure; in SI units of the
        quantity, also of the largest value: m, m/s, m/s², or these per force level for receptance, mobility, inertance.
        quantity, measure: those that the response was computed for unless given; peaks of others are searched and solved between
        its points, for a response over a band. Figures, report and tables keep to their own.
        """
        own = measure_in(self.dataset)
        wanted = measure_of(quantity or own.name, measure or own.kind)
        if self.dataset.attrs.get("listed_frequencies"):
            raise InputError(f"The peaks of {wanted.words} need a response over a band, but this one is at listed frequencies.")
        solved_points.refuse_unexcited(self.problem, wanted)
        if wanted != own:
            return solved_points.peaks_of_another(self.dataset, self.problem, wanted)
        names = {"peak_frequency": "frequency", "peak_amplitude": own.kind, "peak_max_abs": "max_abs"}
        names = {key: name for key, name in names.items() if name != own.kind or key == "peak_amplitude"}
        names["peak_loss_factor"] = "loss_factor"
        if has_stability(self.dataset):
            names["peak_stability"] = "stability"
        table = self.dataset[list(names)].to_dataframe().reset_index().dropna(subset=["peak_frequency"]).rename(columns=names)
        if "curve_kind" in self.dataset:
            table["curve"] = words_of_flags(self.dataset["curve_kind"], self.dataset["curve_kind"].to_numpy()[table["case"]])
            names["curve"] = "curve"
        if has_stability(self.dataset):
            table["stability"] = words_of_flags(self.dataset["peak_stability"], table["stability"].to_numpy())
        return table[["force_level", "output", "peak", *names.values()]].sort_values(
            ["force_level", "output", "peak"], ignore_index=True
        )

    def peak_point(self, case: int = 0, output: int = 0, peak: int = 0) -> int:
        """The point of a case that is the highest peak of an output, or a lower one: for `verify_in_time`, `cycle`, `stress`,
        `sensitivity`."""
        dataset = self.dataset
        row, column = (between(f, value, 0, dataset.sizes[f] - 1) for f, value in (("case", case), ("output", output)))
        frequencies, amplitudes = (dataset[f"peak_{name}"].to_numpy()[row, :, column] for name in ("frequency", "amplitude"))
        amplitudes = amplitudes * measure_in(dataset).per(float(dataset["force_level"][row]))
        count = int(np.isfinite(frequencies).sum())
        if not count:
            raise fault(f"The curve of case {row} and output {column}", "must have a peak inside the band", "one without")
        rank = between("peak", peak, 0, count - 1)
        return nearest_point(dataset, row, column, float(frequencies[rank]), float(amplitudes[rank]))

    def at(self, frequencies: ArrayLike, tolerance: float = 1e-3) -> xr.Dataset:
        """The curves at given frequencies in Hz, without solving at each: on a grid to compare codes by, or along a run-up.

        Contact forces λ(ω) are cubics through solved points and their tangents. Each value is checked by the residual at its
        frequency: Newton's step to the curve, twice, is its estimated `error`, relative to the amplitudes of the outputs, all
        harmonics counted. Where it exceeds `tolerance`, and at every fold, the balance is solved.

        Returns a dataset with axes (case, branch, frequency, ...): response, amplitude, rms, max_abs, contact_motion,
        contact_force, residual, error, solved (1 or 0) and outcome. branch: the times that a curve passes a frequency, in the
        order of travel; more than one where it overhangs (`.max("branch")` is the largest), outcome 0 where it passes no more.
        At frequencies of the band that a broken curve does not reach, values are NaN and the outcome is that of the curve.
        A response at listed frequencies has no points between them to show folds: give a band.
        """
        return solved_points.response_at(self.dataset, self.problem, frequencies, tolerance)

    def cycle(self, case: int, point: int) -> ContactCycle:
        """Motion, force and state of every contact row over the period of one point."""
        points = solved_points.SolvedPoints(self.dataset, self.problem)
        motion, omega = points.contact_motion(case, point), points.point(case, point).omega
        return contact_cycle(points.balance.table, points.balance.tables, motion, omega)

    def animate(self, case: int = 0, point: int | None = None) -> Any:
        """One period of a point in moving pictures: its highest peak unless given.

        The section of each damper between the faces that it touches, true to its dimensions where it has them (ready rigs,
        shapes of dampers, `[[body]]` with a shape): displacements about their means, magnified by a factor that the picture
        says; contact points coloured by state; forces on the damper as arrows; the largest hysteresis loops with a dot that
        goes round; contact states over the period; of a disk its blades. Contacts without a section show loops and states.

        Returns an `Animation`: a notebook shows it with play, pause, speed and slider; `.to_html()`, `.to_plotly()`,
        `.save("x.gif")`, `.plot(frame)`. Raises `InputError` for a point that did not converge and for a problem without
        contacts.
        """
        at = self.peak_point(case) if point is None else point
        return FIGURES.known("PeriodOfMotion")[""](response_motion(self.dataset, self.problem, case, at))

    def deformed_shape(self, case: int = 0, point: int | None = None, harmonic: int | None = None) -> Any:
        """The deformed shape of meshed bodies at a point, its highest peak unless given: their surface coloured by amplitude.

        u = Re Û exp(i h ω t), one harmonic h of the displacement about the mean, that in which the first output moves most
        unless given, magnified by a factor that the picture says; of a tuned disk the wave round the wheel, of a full disk,
        mistuned or not, each sector with its own motion. Dampers are not drawn. The problem must have a mesh: the single blade,
        a disk of finite elements, models read with the elements of their deck (CalculiX, Abaqus, Nastran, Ansys).

        Returns a `DeformedShape`: a notebook shows it with play, pause, speed, slider and steps, and it can be turned;
        `.motion.displacement` (p, 3) [m] at `.motion.points`, `.to_html()`, `.to_plotly()`, `.save("x.gif")`, `.plot(frame)`.
        Raises `InputError` for a point that did not converge and for a problem without a mesh.
        """
        at = self.peak_point(case) if point is None else point
        return FIGURES.known("SurfaceMotion")[""](solved_points.deformed_shape(self.dataset, self.problem, case, at, harmonic))

    def verify_in_time(
        self,
        case: int,
        point: int,
        *,
        steps_per_period: int = 2000,
        method: Method = DEFAULT_METHOD,
        tolerance: float = 1e-6,
        periods: int = 1000,
    ) -> TimeCheck:
        """Integrate one point in time from its own state, until periodic, and say how far harmonics and time are apart."""
        return verify_in_time(self.dataset, self.problem, case, point, steps_per_period, method, tolerance, periods)

    def reached(
        self,
        output: int = 0,
        *,
        steps_per_period: int = 500,
        periods: int = 2000,
        progress: Callable[[float, str], None] | None = None,
    ) -> pd.DataFrame:
        """Which motions a machine shows: how the highest peak of an output on each curve is reached.

        Columns: force_level, curve, frequency [Hz], amplitude (|X₁|, m), next_lower (the largest |X₁| below it at that frequency,
        which a disturbance must roughly exceed if nothing else leads to the peak), stability, from_rest, sweep_up,
        sweep_down: True, False, or None if time integration did not become periodic within `periods` or ended on a motion of no
        curve of the response; unknown: which of these, and where. from_rest: the load starts at the frequency of the peak, as in
        `time_response`. A slow sweep through the band starts at rest, follows its curve to a fold, and continues on the motion
        that time integration ends on; unstable parts of the curve before the fold are not considered. progress(fraction, text) is
        called before each level and each peak. Search for detached curves first (`isolated=True`).

        Raises `InputError` for listed frequencies, subharmonic motions, and what time integration cannot take, such as a tuned
        sector: solve the disk with all its sectors, `disk.full()`.
        """
        row = between("output", output, 0, self.dataset.sizes["output"] - 1)
        return reached(self.dataset, self.problem, row, steps_per_period, periods, progress).drop(columns="case", errors="ignore")

    def with_reached(
        self,
        output: int = 0,
        *,
        steps_per_period: int = 500,
        periods: int = 2000,
        progress: Callable[[float, str], None] | None = None,
    ) -> ForcedResponse:
        """A copy whose dataset also contains the result of `reached`, for report and tables: `reached` (case, question), with the
        questions from_rest, sweep_up and sweep_down, `next_lower` (case) [m] and `reached_unknown` (case)."""
        row = between("output", output, 0, self.dataset.sizes["output"] - 1)
        began = time.process_time()
        table = reached(self.dataset, self.problem, row, steps_per_period, periods, progress)
        seconds = self.dataset.attrs["cpu_seconds"] + time.process_time() - began
        return replace(self, dataset=with_reached(self.dataset, table, row).assign_attrs(cpu_seconds=seconds))

    def sensitivity(self, case: int, point: int, parameters: Mapping[str, Parameter]) -> Sensitivity:
        """dX/dθ of any solved point at its frequency, those of an overhanging branch included, as by `stickslip.sensitivity`.

        At a peak (`peak_point`) it is not the slope of the peak's height: sampled friction puts peaks on kinks, and by a
        parameter that shifts the resonance a point beside the top has another slope, even another sign. Slopes of peaks:
        `sensitivity_indices`.
        """
        return point_sensitivity(self.dataset, self.problem, case, point, parameters)

    def as_quantity(self, name: str, per_force: bool = False) -> xr.Dataset:
        """Response, amplitude and rms as displacement, velocity or acceleration, absolute or per force: receptance, mobility,
        inertance, which are names too."""
        return as_quantity(self.dataset, name, per_force)

    def stress(self, case: int, point: int, recovery: StressRecovery | None = None) -> xr.Dataset:
        """Stress of one point: harmonics and largest values, Pa, at the places that its models name
        (`read_structure(stress=...)`)
        unless a recovery is given (`stickslip.model.structure.stress`).
        """
        problem = solved_points.on_its_coordinates(self.problem, self.dataset)
        return stress(self.dataset, problem, case, point, _recovery(problem, recovery))

    def with_stress(self, recovery: StressRecovery | None = None) -> ForcedResponse:
        """A copy whose dataset also holds the stress along its curves, for figures, report and tables; places as in `stress`."""
        problem = solved_points.on_its_coordinates(self.problem, self.dataset)
        return replace(self, dataset=with_stress(self.dataset, problem, _recovery(problem, recovery)))

    def with_fatigue(
        self, limit: FatigueLimit, mean: Mapping[str, float] | None = None, equivalent: Equivalent = "sines"
    ) -> ForcedResponse:
        """A copy of a response with stress whose dataset also holds its fatigue margin, for figures, report and tables.

        The margin `fatigue_limit` / `fatigue_amplitude` is the factor by which the vibration may grow at the same mean stress.
        mean: stress that the response does not contain, such as that due to rotation, in Pa by place. equivalent: the stress in
        tension that replaces a stress of several components. "sines": the largest von Mises stress of the vibration, and the sum
        of the mean normal stresses; "von_mises": the same amplitude, and the von Mises stress of the mean with the sign of that
        sum; "principal": the normal stress on the plane where its amplitude is largest.
        """
        return replace(self, dataset=with_fatigue(self.dataset, limit, mean, equivalent))

    def with_motion(self) -> ForcedResponse:
        """A copy whose dataset also holds the motion of the dampers and of meshed bodies at its highest peaks, which the report
        then shows; studies do so. As it is where no damper has a section and no body a mesh."""
        return replace(self, dataset=solved_points.with_shapes(with_motion(self.dataset, self.problem), self.problem))

    def with_stability(self, highest: float | None = None) -> ForcedResponse:
        """A copy whose dataset also says which of its points are stable, for figures, report and tables.

        The perturbation δx of a periodic motion, with velocities and what sliders remember, is integrated over one period, δx(T)
        = Φ δx(0). The motion is stable where all eigenvalues of Φ, Floquet's multipliers, are smaller than 1. A slider that never
        slips has a multiplier of exactly 1, which is not counted: it may stand anywhere between two limits.
        highest: highest natural frequency [Hz] of dynamic modes of the stuck structure; higher modes respond statically, so an
        instability of such a mode is not detected. Default: eight times the highest harmonic, and the effect of higher modes is
        estimated; `float("inf")` for all.

        The dataset gains `stability` (case, point): stable, unstable or undecided, `multiplier` (case, point, part), the
        largest, `multiplier_error`, `multiplier_resolved` (0 where too few harmonics leave a point
        undecided), `stuck_sliders`, `peak_stability` (case, peak, output), and `stability_change` with its frequency (case,
        change): fold, branch_point, period_doubling or neimark_sacker. Of a tuned disk all sectors are disturbed, each by
        itself; `stuck_sliders` are those of all of them.
        Source: Hsu, J. Appl. Mech. 39 (1972) 551-559, for the period map; the treatment of contacts is ours.
        """
        return replace(self, dataset=with_stability(self.dataset, self.problem, highest))

    def branch_points(self, case: int = 0, periods: int = 1) -> pd.DataFrame:
        """The branch points of a curve, where other solutions cross it: frequency [Hz], amplitude of the first output [m], and
        the number of directions that lead away.

        There the Jacobian of the balance, with the tangent of the curve as its last row, is singular, which it is not at a fold.
        periods=2 finds where motions of twice the period branch off: period doublings.
        """
        return branch_point_table(self._solved_curve(case, periods))

    def branch(self, at: float | None = None, case: int = 0, periods: int = 1) -> ForcedResponse:
        """The curves that cross a curve at one of its branch points: at the one nearest to `at` in Hz, or at the first.

        Each is a case of the response that is returned, from the branch point on followed both ways until it leaves the band or
        closes on itself. periods=2: motions of twice the period, from a period doubling; their response has that expansion.
        Source: the direction away is in the null space of the bordered Jacobian, H. B. Keller, in Applications of Bifurcation
        Theory (1977), 359-384.
        """
        curve = self._solved_curve(case, periods)
        found = branches(curve, at)
        return self._of_curves(curve, found, CurveKind.BRANCH)

    def with_branches(self, periods: int = 1) -> ForcedResponse:
        """A copy with the branches at all branch points of the sweeps added; periods: as for `branch`."""
        cases = [case for case, kind in enumerate(kinds_in(self.dataset)) if kind == CurveKind.SWEEP]
        found: list[Curve] = []
        for case in cases:
            curve = self._solved_curve(case, periods)
            found += all_branches(curve)
        return self.with_curves(self._of_curves(curve, found, CurveKind.BRANCH)) if found else self

    def with_isolated(self, *modes: Any) -> ForcedResponse:
        """A copy with isolated curves added, which the sweeps do not reach; each is a case marked `isolated`.

        Their starts are the resonance peaks of the force level on nonlinear modes of the problem (`nonlinear_modes`), of which a
        level has several where the force that a mode needs falls with its amplitude. Of a response over several `periods` they
        are motions of modes at a fraction of the excitation's frequency, in several phases, and the curves are subharmonic. The
        attribute `isolated_starts` gives the number of starts tried; if none leads to a new curve, this does not prove that there
        is none. If friction and damping allow only one motion (attribute `one_motion`), there is no search.
        """
        if not modes:
            raise fault("modes", "must be results of `nonlinear_modes`", "none")
        for each in modes:
            if "mode_number" not in getattr(each, "dataset", ()):
                raise fault("modes", "must be results of `nonlinear_modes`", each)
            if each.problem.fingerprint != self.problem.fingerprint:
                raise fault("The problem of the modes", "must be that of the response", "another")
        of_kinds: dict[CurveKind, list[int]] = {kind: [] for kind in CurveKind}
        for case, kind in enumerate([] if contracts(self.problem) else kinds_in(self.dataset)):
            of_kinds[kind].append(case)
        found: list[Curve] = []
        tried = 0
        with one_blas_thread():
            known = [self._solved_curve(case, 1) for case in of_kinds[CurveKind.ISOLATED]]
            for case in of_kinds[CurveKind.SWEEP]:
                curve = self._solved_curve(case, 1)
                isolated = Isolated(curve, [each.points for each in known if each.level == curve.level])
                tried += take_from_modes(isolated, [each.dataset for each in modes])
                found += isolated.curves
        response = self
        if found:
            response = self.with_curves(self._of_curves(curve, found, CurveKind.ISOLATED))
        count = len(found) + len(of_kinds[CurveKind.ISOLATED])
        return replace(response, dataset=response.dataset.assign_attrs(isolated_starts=tried, isolated_curves=count))

    def with_curves(self, other: ForcedResponse) -> ForcedResponse:
        """A copy with the curves of another response of the same problem added, of its branches for instance."""
        of_kind("other", other, ForcedResponse)
        names = ("harmonics", "samples", "quantity", "measure", "listed_frequencies")
        same = {name: [each.dataset.attrs.get(name) for each in (self, other)] for name in names}
        for what, values in ({"problem": [each.problem.fingerprint for each in (self, other)]} | same).items():
            if values[0] != values[1]:
                raise fault(f"The {what} of the other response", f"must be {values[0]}", values[1])
        periods = lcm(periods_of(self.dataset), periods_of(other.dataset))
        curves, levels, kinds = [], [], []
        for dataset in (self.dataset, other.dataset):
            levels += dataset["force_level"].values.tolist()
            kinds += kinds_in(dataset)
            longer = periods // periods_of(dataset)
            parts = [arrays_of(dataset, case, longer) for case in range(dataset.sizes["case"])]
            parts[0]["cpu_seconds"] = np.array(dataset.attrs["cpu_seconds"])
            curves += parts
        joined = self._work(levels, periods).gathered(curves, kinds)
        own = ("isolated", "coordinates_chosen", "static_history")
        kept = {name: value for name, value in self.dataset.attrs.items() if name.startswith(own)}
        joined = replace(joined, dataset=joined.dataset.assign_attrs(kept | {"study": self.dataset.attrs["study"]}))
        return joined.with_stability() if has_stability(self.dataset) else joined

    def _solved_curve(self, case: int, periods: int) -> SolvedCurve:
        with one_blas_thread():
            return SolvedCurve.of(self.dataset, self.problem, case, periods, self._peak_tolerance)

    def _work(self, levels: Sequence[float], periods: int) -> ForcedResponseWork:
        """The work that more curves over the band of this response are the results of."""
        attrs, ends = self.dataset.attrs, self.dataset["linear_frequency"].values[[0, -1]].tolist()
        harmonics, samples, measure = of_attribute(attrs["harmonics"]), int(attrs["samples"]), measure_in(self.dataset)
        settings = ForcedResponseSettings(
            self.problem,
            list(dict.fromkeys(ends)) if attrs.get("listed_frequencies") else Band(*ends),
            harmonics=harmonics,
            samples=samples,
            peak_tolerance=self._peak_tolerance,
            periods=periods,
            quantity=measure.name,
            measure=measure.kind,
        )
        choice = str(attrs.get("harmonics_chosen", ""))
        return ForcedResponseWork(
            settings, problem=self.problem, levels=tuple(levels), harmonics=harmonics, samples=samples, choice=choice
        )

    @property
    def _peak_tolerance(self) -> float:
        return float(self.dataset.attrs.get("peak_tolerance", TOLERANCE))

    def _of_curves(self, curve: SolvedCurve, found: Sequence[Curve], kind: CurveKind) -> ForcedResponse:
        """A response of curves that were found from one of this response."""
        work = self._work([each.level for each in found], curve.balance.periods)
        with one_blas_thread():
            arrays = [work.arrays(each) | {"cpu_seconds": np.zeros(())} for each in found]
        return work.gathered(arrays, [kind] * len(arrays))

    def absolute(self) -> xr.Dataset:
        """Response and amplitude with the motion of the base added (`BaseMotion`); those of `dataset` are relative to it."""
        return absolute(self.dataset, self.problem)

    def save(self, path: str | Path) -> Path:
        """Write the dataset as NetCDF."""
        return save(self.dataset, path)


def _recovery(problem: Problem, given: StressRecovery | None) -> StressRecovery:
    """That of the places of a problem unless one is given; a given one knows nothing of the coordinates of a mesh."""
    if given is not None and problem.mesh is not None:
        remedy = "Leave it out: stress is that at the places which the models name."
        raise fault("A stress recovery", "must not be given for a problem on few coordinates of a mesh", "given", remedy)
    found = own_recovery(problem) if given is None else given
    if found is None:
        raise InputError("Stress needs places: give a recovery, or read the model with stress={NAME: node, set or coordinates}.")
    return found


@takes(ForcedResponseSettings)
def forced_response(settings: ForcedResponseSettings) -> ForcedResponse:
    """Steady response X_h(ω) of M q̈ + C q̇ + K q + Bᵀ f(B q) = p over a band, by harmonic balance.

    band: a `Band` in Hz, continued from start to stop; or frequencies in Hz, solved exactly there in the order given: reached by
    continuation upwards where they rise and downwards where they fall, so that a list up and down shows a hysteresis of jumps.
    force: level or levels that multiply every harmonic force. harmonics H: 0..H are solved; of a list that contains 1, such as
    [0, 1, 3, 5], only these, and the others are zero in the results; "auto" raises H until the omitted motion of the contacts
    along the curve is below `tolerance` of the whole, and doubles the samples likewise. samples: per period, at least 4H + 2, H
    the highest harmonic; of a disk raised to the next number with which the delay from sector to sector is whole.
    quantity, measure: what the peaks are of; a damped structure peaks at another frequency in acceleration than in displacement.
    quantity: displacement, velocity, acceleration, or per force level receptance, mobility, inertance; measure: "amplitude" of
    the first harmonic, "rms" or "max_abs", the largest value in time (both with all harmonics, and the mean of a displacement).
    periods p: of the excitation, after which a motion may repeat itself: it is expanded in multiples of ω/p, so that it may be
    subharmonic. A sweep begins where all repeat after one period; `branch` and `with_isolated` lead to those that do not.
    harmonics and samples stay those of one period, amplitudes those of the frequency of the excitation.
    isolated: whether to search for detached curves by following the force level at a few frequencies, which takes somewhat longer
    than the sweep; each is a case marked `isolated`, and the attribute `isolated_search` states how far was searched. By default
    the search takes place if a contact has no friction (gaps, cubic springs); with True also for contacts under a varying load,
    and the attribute states why there is no search otherwise.
    workers: processes that compute force levels side by side, with the same results (a script that asks for more than one keeps
    its work under `if __name__ == "__main__":`), or a `DaskCluster`. checkpoint: keeps the curve of each completed force level
    for an interrupted run to resume from (`stickslip.CheckpointFolder`). progress(fraction, text) is called as the work goes on.

    Returns a `ForcedResponse`; its dataset has axes (case, point, ...), one case per force level.
    """
    settings.progress(0.0, "preparing")
    work = ForcedResponseWork.of(settings).with_shapes(settings.progress)
    curves = all_cases(work, settings.checkpoint, settings.workers, settings.progress)
    work, curves = work.settled(curves, settings.checkpoint, settings.workers, settings.progress)
    settings.progress(1.0, "linear curves")
    return work.gathered(curves)


TRACED, STAGES = 0.5, 6
"""Progress of a case when its curve is traced, about its share of the time where contacts are many, and as how many equal parts
what follows counts."""

LARGE = 0.1
"""Largest motion over the size of the structure from where on a theory of small motions is left."""

AUTOMATIC = 9
"""Harmonics up to which modes are kept where their number is still to be chosen."""


def compile_forced_response() -> None:
    """Compile the kernels, or load them from disk, with the smallest problem there is."""
    forced_response(single_mass(), [0.1], harmonics=1, samples=8)


def _seeks(settings: ForcedResponseSettings, problem: Problem) -> bool:
    """Whether curves apart from the sweeps are sought where there may be some."""
    return sought_unasked(problem) if settings.isolated is None else settings.isolated


@dataclass(frozen=True, eq=False)
class ForcedResponseWork(OneBalance):
    """A forced response as independent cases, one level each: its settings, and what they come to for the problem.

    problem, harmonics, samples: as they are solved; choice: a sentence on how harmonics were chosen. levels: of the force, which
    repeat where several curves of one level are gathered. finer: the problem on all its modes and with a contact at each node,
    where `problem` is truncated or has patches.
    """

    settings: ForcedResponseSettings
    _: KW_ONLY
    problem: Problem
    levels: tuple[float, ...]
    harmonics: Harmonics
    samples: int
    choice: str = ""
    finer: Problem | None = None

    @classmethod
    def of(cls, settings: ForcedResponseSettings) -> ForcedResponseWork:
        """The work of settings, whose "auto" becomes a number here."""
        problem, asked, levels = settings.problem, settings.harmonics, settings.levels
        Nt, choice, finer = problem.systems.enough_samples(settings.samples), "", problem.at_nodes
        reach = AUTOMATIC if isinstance(asked, str) else highest(harmonics_for(problem, asked, OR_AUTO))
        problem = on_few_coordinates(problem, reach * max(settings.frequencies))
        refuse_hidden(problem, levels)
        if isinstance(asked, str):
            detached = _seeks(settings, problem) and not settings.listed and settings.periods == 1 and not unsought(problem)
            chosen = harmonic_choice.sufficient_harmonics(problem, settings.frequencies, levels, settings.tolerance, Nt, detached)
            asked, Nt, choice = chosen.harmonics, chosen.samples, chosen.sentence
        H = harmonics_for(problem, asked, OR_AUTO)
        fourier(highest(H), Nt)
        over_periods(problem, settings.periods)
        highest(in_fractions(H, settings.periods))
        if not settings.listed:
            solved_points.refuse_unexcited(problem, settings.measured)
        return cls(
            settings,
            problem=problem,
            levels=levels,
            harmonics=H,
            samples=Nt,
            choice=choice,
            finer=None if finer is problem or problem.mesh is not None else finer,
        )

    @property
    def periods(self) -> int:
        return self.settings.periods

    def with_shapes(self, progress: Progress) -> ForcedResponseWork:
        """Of a finite-element model, the work on coordinates with the shapes of the contact forces at the highest peaks of all
        levels; else itself."""
        if self.problem.mesh is None:
            return self
        measure, curves = self.measure.over(self.periods), []

        def report(case: int, share: float) -> None:
            progress((case + share) / len(self.words), f"first solution: {self.words[case]}")

        with one_blas_thread():
            rough = peak_shapes.with_loaded_harmonics(self.balance)
            tolerance = max(peak_shapes.SETTLED, self.settings.peak_tolerance)
            for case in range(len(self.levels)):
                report(case, 0.0)
                curve = self._curve(rough, case, partial(report, case), tolerance)
                # Without a peak the band may hold one of a higher harmonic.
                curves.append(curve if any(curve.peaks) else self._curve(self.balance, case, partial(report, case), tolerance))
            highest = [each for curve in curves for each in peak_shapes.highest_of(rough, curve, measure)]
            return replace(self, problem=peak_shapes.with_shapes_of_peaks(rough, self._balance_of, highest, measure, progress))

    def _balance_of(self, problem: Problem) -> HarmonicBalance:
        """The balance on other coordinates of the mesh."""
        return self.balance if problem is self.problem else replace(self, problem=problem).balance

    def settled(
        self, curves: list[Arrays], checkpoint: Checkpoint | None, workers: Workers, progress: Progress
    ) -> tuple[ForcedResponseWork, list[Arrays]]:
        """The work and its curves, solved again with the shapes of the contact forces at their highest points as long as an error
        by the shapes left out is beyond what is allowed, and less than half of that before.

        Contacts far stiffer than what they join have other forces at these points than in the first solutions, and need more of
        their shapes: the work of what is left out goes with the square of the error.
        """
        work, before, unknown = self, np.inf, np.full(len(self.problem.outputs), np.nan)
        measure = self.measure.over(self.periods)
        while work.problem.mesh is not None:
            errors = [np.abs(curve.get(truncation.OWN_FORCES.variable, unknown)) for curve in curves]
            if all(np.all(each <= truncation.ALLOWED) for each in errors):
                break
            response, worst, highest = work.gathered(curves), 0.0, []
            dataset = response.dataset
            points, every = solved_points.SolvedPoints(dataset, work.problem), np.arange(dataset.sizes["point"])
            for case, output in np.ndindex(dataset.sizes["case"], dataset.sizes["output"]):
                size = np.nan_to_num(sizes(dataset, case, output, self.measure, every))
                if size.any():
                    k = int(np.argmax(size))
                    found, of_peaks = points.evaluation(case, k), dataset["peak_frequency"].values[case, :, output]
                    X = found.w[points.balance.rows + output][points.balance.first]
                    peak = X if np.isfinite(of_peaks).any() and response.peak_point(case, output) == k else None
                    highest.append(peak_shapes.Highest(output, found.point, peak, float(size[k])))
                    of_sweep = errors[case][output] if case < len(curves) else 0.0
                    worst = max(worst, 1.0 if np.isnan(of_sweep) else float(of_sweep))  # too far away to be solved
            if not truncation.ALLOWED < worst < 0.5 * before:
                break
            share = NEGLIGIBLE * (peak_shapes.SETTLED / worst) ** 2
            problem = peak_shapes.with_shapes_of_peaks(points.balance, work._balance_of, highest, measure, progress, share)
            if problem.structure.size == work.problem.structure.size:
                break
            work, before = replace(work, problem=problem), worst
            progress(0.0, f"curves on {problem.structure.size} coordinates")
            curves = all_cases(work, checkpoint, workers, progress)
        return work, curves

    @property
    def measure(self) -> Measure:
        """What peaks are of."""
        return self.settings.measured

    @property
    def others(self) -> str:
        """The settings that curves depend on as they are given."""
        return self.settings.identity("problem", "force", "harmonics", "samples", "tolerance")

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Everything that a curve depends on: of the settings, and what they come to."""
        how = f"{self.harmonics} harmonics, {self.samples} samples, problem {self.problem.fingerprint}, {self.others}"
        how += ", with isolated curves" if _seeks(self.settings, self.problem) else ""
        return tuple(f"forced response, level {level!r}, {how}" for level in self.levels)

    @property
    def words(self) -> tuple[str, ...]:
        return tuple(f"force level {level:g}" for level in self.levels)

    prepare = staticmethod(compile_forced_response)

    def solve(self, case: int, report: Report) -> Arrays:
        """The arrays of the curve of one force level."""
        started, curve = time.process_time(), None
        try:
            curve = self._traced(case, lambda share: report(TRACED * share))
            arrays = self.arrays(curve, report) | self._isolated(curve)
            return arrays | {"cpu_seconds": np.array(time.process_time() - started)}
        except KeyboardInterrupt as stop:
            if isinstance(stop, CurveStopped):
                curve = stop.curve
            elif curve is not None:
                curve = replace(
                    curve, message=f"{curve.message} The run was stopped before the errors of its peaks were estimated."
                )
            if curve is None or not curve.points:
                raise
            raise CaseStopped(self._plain_arrays(curve)) from stop

    def solve_without_errors(self, case: int, report: Report) -> Arrays:
        """As `solve`, but for a first look: without the errors and the stability of the peaks, and without their warnings."""
        return self._plain_arrays(self._dense(self._traced(case, report)))

    def _traced(self, case: int, report: Report) -> Curve:
        """The curve of one force level."""
        return self._curve(self.balance, case, report, self.settings.peak_tolerance)

    def _curve(self, balance: HarmonicBalance, case: int, report: Report, tolerance: float) -> Curve:
        """The curve of one force level with a balance; tolerance: relative, of the heights of its peaks."""
        omegas = [2.0 * np.pi * frequency / self.periods for frequency in self.settings.frequencies]
        measure = self.measure.over(self.periods)
        return solve_curve(
            balance, omegas, self.levels[case], self.settings.listed, report, peak_tolerance=tolerance, measure=measure
        )

    def _isolated(self, curve: Curve) -> dict[str, NDArray[Any]]:
        """The arrays of the curves that lie apart from that of a level, one beside the other, and what was searched."""
        if not _seeks(self.settings, self.problem):
            return {}
        if reason := self._unsought(curve):
            sentence = f"There was no search for detached curves: {reason}."
            return {"isolated_search": np.array(sentence)} if self.settings.isolated else {}
        low, high = (2.0 * np.pi * frequency for frequency in sorted(self.settings.frequencies))
        solved = SolvedCurve(
            self.balance, list(curve.points), curve.level, (low, high), self.settings.peak_tolerance, self.measure, 1
        )
        found, sentence = searched(solved)
        arrays = [self.arrays(each) for each in found]
        return beside(arrays) | {"isolated_search": np.array(sentence)}

    def _unsought(self, curve: Curve) -> str:
        """Why no curves apart from that of a level are sought; empty where they are."""
        if self.settings.listed:
            return "it needs a frequency band"
        if self.periods > 1:
            return "the motion has several periods"
        if curve.outcome != Outcome.CONVERGED or curve.level == 0.0:
            return "the sweep broke off" if curve.level else "there is no force"
        return unsought(self.problem)

    def _dense(self, curve: Curve) -> Curve:
        """A curve dense enough to draw; at listed frequencies as it is."""
        return curve if self.settings.listed else harmonic_choice.without_ripples(self.balance, refined(self.balance, curve))

    def so_far(self, results: Mapping[int, Arrays]) -> xr.Dataset:
        """The response of some force levels; the others are curves without points."""
        none = [stopped_curve(self.balance, level, (), (0.0, 0.0), self.measure.over(self.periods)) for level in self.levels]
        curves = [results[case] if case in results else self._plain_arrays(curve) for case, curve in enumerate(none)]
        return self.gathered(curves).dataset

    def _plain_arrays(self, curve: Curve) -> dict[str, NDArray[Any]]:
        """The arrays of a curve as it is."""
        arrays = curve_arrays(self.balance, curve)
        return arrays | {"frequency": as_given(arrays["frequency"], self.settings.frequencies, self.periods)}

    @cached_property
    def negative_damping(self) -> str:
        """What to say of a mode that damping feeds, where no unstable peak says so."""
        if self.problem.speed is None:
            return negative_damping(self.problem)
        low, high = min(self.settings.frequencies), max(self.settings.frequencies)
        return negative_damping(self.problem.at_frequency(2.0 * np.pi * 0.5 * (low + high)))

    @cached_property
    def opened(self) -> str:
        """What to say of contacts that the static load leaves open."""
        return opened(self.problem, min(self.settings.frequencies), max(self.settings.frequencies))

    @cached_property
    def seated_at(self) -> Callable[[float], Seated]:
        """`seated_balance` at a frequency, rad/s: found once for all levels where the static load is that of all frequencies."""
        found = lru_cache(maxsize=1)(partial(seated_balance, self.balance))
        return lambda omega: found(0.0 if self.problem.speed is None else omega)

    @property
    def finer_problem(self) -> truncation.FinerProblem:
        """What `finer` has more."""
        return truncation.ALL_NODES if any(contact.nodes for contact in self.problem.contacts) else truncation.ALL_MODES

    @cached_property
    def finer_balances(self) -> tuple[HarmonicBalance, HarmonicBalance] | None:
        """The balance of `finer`, and of the same contacts on few coordinates."""
        if self.finer is None:
            return None
        how = self.harmonics, self.samples, self.periods
        nodes, modes_to = self.finer_problem is truncation.ALL_NODES, self.problem.modes_to
        few = self.problem if not nodes else self.finer if modes_to is None else on_few_coordinates(self.finer, 0.0, modes_to)
        whole = self.finer
        if few.mean_springs != whole.mean_springs:  # the damping of the modes is known already
            structure = replace(whole.structure, C=whole.structural_damping, damping=None)
            whole = replace(whole, structure=structure, mean_springs=few.mean_springs)
        finer = HarmonicBalance(whole, *how)
        if not nodes:
            return finer, self.balance
        return finer, finer if modes_to is None else HarmonicBalance(few, *how)

    def arrays(self, curve: Curve, report: Report = lambda share: None) -> dict[str, NDArray[Any]]:
        """The arrays of a curve, dense enough to draw, with the warnings of its peaks."""

        def stage(number: int, share: float = 0.0) -> None:
            report(TRACED + (1.0 - TRACED) * (number + share) / STAGES)

        curve = self._dense(curve)
        stage(1)
        arrays = self._plain_arrays(curve)
        stage(2)
        measure = self.measure.over(self.periods)
        stability = judged(self.balance, curve, measure)
        errors = truncation.discretisation_errors(self.balance, curve, measure)
        along = truncation.point_errors(self.balance, curve, measure, self.settings.listed, partial(stage, 3))
        stage(4)
        names = self.problem.output_names
        finer, by_finer, held_mean = {}, "", ""
        if self.finer is not None and self.finer_balances is not None:
            change = truncation.errors_by(*self.finer_balances, self.balance, curve, measure)
            finer, by_finer = {self.finer_problem.variable: change}, self.finer_problem.warning(names, change)
            springs = len(self.problem.mean_springs) - len(self.finer.mean_springs)
            held_mean = truncation.held_mean_warning(self.balance, springs, curve, measure)
        elif self.problem.mesh is not None:
            change = peak_shapes.own_shapes_error(self.balance, curve, measure)
            finer, by_finer = {truncation.OWN_FORCES.variable: change}, truncation.OWN_FORCES.warning(names, change)
            springs = len(self.problem.mean_springs) - len(self.settings.problem.mean_springs)
            held_mean = truncation.held_mean_warning(self.balance, springs, curve, measure)
        stage(5)
        history, by_history, unsought = history_change(self.balance, curve, measure, self.seated_at)
        sought = not (self.settings.listed or contracts(self.problem))
        other = other_motion_warning(self.balance, curve, self.measure.over(self.periods)) if sought else ""
        warnings = (
            stability_warning(self.balance, curve, stability) or self.negative_damping,
            other,
            truncation.truncation_warning(self.harmonics, names, errors["truncation_error"], self.choice) if curve.points else "",
            truncation.away_warning(self.balance, curve, measure, along, errors["truncation_error"]),
            truncation.work_warning(self.harmonics, names, errors["work_error"]),
            by_finer,
            by_history,
            held_mean,
            large_motion_warning(self.problem, self.measure, np.delete(arrays["max_abs"], curve.places_outside, axis=0)),
            harmonic_choice.sampling_warning(self.balance, curve)
            or ("" if self.settings.listed else harmonic_choice.fold_warning(self.balance, curve))
            or harmonic_choice.samples_warning(self.samples, names, errors["sampling_error"])
            or harmonic_choice.broken_warning(self.balance.problem.contacts, self.samples, curve, arrays["share_open"]),
        )
        message = np.array(" ".join(filter(None, (curve.message, *warnings))))
        errors["point_truncation_error"] = np.full(arrays["amplitude"].shape, np.nan)
        errors["point_truncation_error"][arrays["outcome"] == Outcome.CONVERGED] = along
        said = {"case_message": message, "history_change": history, "static_history": np.array(unsought)}
        return arrays | errors | finer | stability.flags(len(names)) | said

    def gathered(self, curves: Sequence[Arrays], kinds: Sequence[CurveKind] = ()) -> ForcedResponse:
        """The response of the curves of all force levels; kinds: of the curves, all of sweeps unless given."""
        attrs: dict[str, Any] = {
            "title": self.problem.heading,
            "study": "",
            "harmonics": attribute(self.harmonics),
            "samples": self.samples,
        }
        attrs |= {"harmonics_chosen": self.choice, "one_motion": int(contracts(self.problem))}
        attrs |= {"listed_frequencies": int(self.settings.listed), "peak_tolerance": self.settings.peak_tolerance}
        attrs["settings"] = self.others
        attrs["cpu_seconds"] = sum(float(curve.get("cpu_seconds", 0.0)) for curve in curves)
        low, high = min(self.settings.frequencies), max(self.settings.frequencies)
        ends = (low, high) if low < high else (0.9 * low, 1.1 * low)
        sentences = [str(curve.get("isolated_search", "")) for curve in curves]
        apart = [(level, each) for level, curve in zip(self.levels, curves, strict=True) for each in apart_of(curve)]
        levels, curves = (*self.levels, *(level for level, _ in apart)), [*curves, *(each for _, each in apart)]
        kinds = [*(kinds or [CurveKind.SWEEP] * len(sentences)), *[CurveKind.ISOLATED] * len(apart)]
        if any(sentences):
            attrs |= {"isolated_search": _by_level(self.levels, sentences), "isolated_curves": len(apart)}
        histories = [str(curve.get("static_history", "")) for curve in curves]
        attrs["static_history"] = " ".join(filter(None, (self.opened, next(filter(None, histories), ""))))
        with one_blas_thread():
            plain = self.balance if self.periods == 1 else HarmonicBalance(self.problem, self.harmonics, self.samples)
            found = response_dataset(self.balance, levels, curves, ends, attrs, self.measure, plain)
            dataset = with_disk(found, self.problem).assign(described("contacts_at_rest", rest_of(self.problem)))
        kept = {
            "truncation_error": truncation.TRUNCATION_ERROR,
            "sampling_error": truncation.SAMPLING_ERROR,
            "work_error": truncation.WORK_ERROR,
        }
        for each in (truncation.ALL_MODES if self.problem.mesh is None else truncation.OWN_FORCES, truncation.ALL_NODES):
            if any(each.variable in curve for curve in curves):
                kept[each.variable] = each.attributes
        if self.problem.modes_to is not None:
            dataset.attrs |= {"modes_to": self.problem.modes_to, "coordinates": self.problem.systems.coordinates}
            dataset = solved_points.with_shape_forces(dataset, self.problem)
            whole = self.finer if self.problem.mesh is None else self.settings.problem
            if whole is not None:
                dataset.attrs["coordinates_chosen"] = truncation.coordinates_note(self.problem, whole)
        unknown, axes = np.full(dataset.sizes["output"], np.nan), ("case", "output")
        errors = {name: (axes, [curve.get(name, unknown) for curve in curves], attributes) for name, attributes in kept.items()}
        along = np.full((len(curves), dataset.sizes["point"], dataset.sizes["output"]), np.nan)
        for case, curve in enumerate(curves):
            known = curve.get("point_truncation_error", along[case, :0])
            along[case, : len(known)] = known
        at_points = {"point_truncation_error": (("case", "point", "output"), along, truncation.POINT_ERROR)}
        dataset = dataset.assign(errors | at_points | flags(curves, dataset.sizes["output"]))
        return ForcedResponse(with_kinds(dataset, list(kinds)), self.problem)


def _by_level(levels: Sequence[float], sentences: Sequence[str]) -> str | list[str]:
    """What is said of each level; of one level alone without it."""
    if len(sentences) == 1:
        return sentences[0]
    return [f"Force level {level:g}: {each}" for level, each in zip(levels, sentences, strict=True) if each]


def large_motion_warning(problem: Problem, measure: Measure, max_abs: NDArray[Any]) -> str:
    """A sentence where an output moves by a part of the structure's size; max_abs (points, outputs)."""
    size, rotations = problem.structure.extent, (".rx", ".ry", ".rz")
    if not size or measure.quantity.name != "displacement" or not max_abs.size:
        return ""
    moved = np.nan_to_num(max_abs).max(axis=0)
    moved[[name.endswith(rotations) for name in problem.output_names]] = 0.0
    most = int(np.argmax(moved))
    if moved[most] <= LARGE * size:
        return ""
    return (
        f"{problem.output_names[most]} moves by up to {moved[most]:.3g} m, {moved[most] / size:.2g} times the size of the "
        "structure, but the theory assumes small motions."
    )
