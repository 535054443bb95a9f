"""Nonlinear modes as independent cases, one curve each, and which modes and amplitudes the arguments of an analysis mean.

Peaks of all force levels from a mode, as columns of its dataset.

Forced motions solved at the peaks that a nonlinear mode synthesises: what the synthesis misses is known, not estimated.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property
from typing import Annotated, Any, Literal, Self, get_args

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.isolated import ModeMotions
from stickslip.analyses.modes.slow_decay import SHARED, SlowDecay, slow_decay
from stickslip.analyses.modes.synthesis import Synthesis
from stickslip.analyses.peak_shapes import ROUNDS, SETTLED, few_combinations, scaled
from stickslip.analyses.response_dataset import ContactRows, labels_of, parts
from stickslip.analyses.settings import AnyProblem, Execution, OneOf, OutputNumber, Samples, Setting, Settings, output_of
from stickslip.analyses.solved_points import with_shape_forces
from stickslip.model.problem import Problem
from stickslip.model.problem.meshed import finer, with_forces
from stickslip.model.rigs import single_mass
from stickslip.model.structure.stuck_mesh import NEGLIGIBLE
from stickslip.results.schema import described, named, stacked, variables_in
from stickslip.results.view import spread
from stickslip.runs.cases import Arrays, Progress, Report
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, PathCondition, Point
from stickslip.solve.balance.energy import contact_cycle
from stickslip.solve.balance.fourier import (
    Harmonics,
    attribute,
    checked_harmonics,
    complex_harmonics,
    fourier,
    harmonics_for,
    highest,
    largest_absolute,
    of_attribute,
)
from stickslip.solve.balance.mode_balance import ModalStructures, ModeBalance, mode_energy
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.curves import mode_curve
from stickslip.support.checks import (
    Array,
    InputError,
    between,
    fault,
    in_percent,
    of_kind,
    positive,
    rounded,
    unique,
    vector,
    whole,
)
from stickslip.support.late import pd, xr
from stickslip.support.machine import one_blas_thread
from stickslip.support.outcome import Outcome
from stickslip.support.units import um

VARIABLES = variables_in("nonlinear_modes")

OF_DECAYS = variables_in("free_decay_of_a_mode")
"""The variables of decays, which take longer than a mode."""

INTERNAL = 0.05
"""Share of the energy in one stuck mode at one harmonic above the first from which this is called an internal resonance."""

ITERATIONS, HALVINGS = 30, 8

LEAST_RATIO, FINEST, MOST_STEPS = 1e-5, 1e-5, 40
"""Of a climb: the damping ratio that its first step has at least, its last step relative to the frequency, and steps at most."""

FARTHEST = 0.2
"""Relative distance in frequency beyond which a solution is that of another peak."""


def with_solved(table: pd.DataFrame, modes: xr.Dataset, problem: Problem, case: int, output: int) -> pd.DataFrame:
    """Peaks of `Synthesis.peaks` with solved_frequency [Hz] and solved_amplitude [m] of the first harmonic of the output; NaN
    where Newton's method does not arrive.

    The harmonic balance of the forced motion is solved from the motion of the mode, with the phase of the synthesis and the
    frequency as an unknown, and then beside it, upwards, until no frequency at either side has a larger amplitude.
    """
    balance = HarmonicBalance(problem, of_attribute(modes.attrs["harmonics"]), int(modes.attrs["samples"]))
    motions = ModeMotions.of(balance, modes, case)
    columns = ["force_level", "frequency", "modal_amplitude", "phase", "damping_ratio"]
    solved = [_solved(balance, motions, output, *row) for row in table[columns].to_numpy()]
    frequencies, amplitudes = np.array(solved).reshape(-1, 2).T
    return table.assign(solved_frequency=frequencies, solved_amplitude=amplitudes)


def _solved(
    balance: HarmonicBalance,
    motions: ModeMotions,
    output: int,
    level: float,
    hertz: float,
    amplitude: float,
    phase: float,
    ratio: float,
) -> tuple[float, float]:
    """Frequency [Hz] and amplitude [m] of one peak."""
    omega = 2.0 * np.pi * hertz
    place = float(np.interp(amplitude, motions.amplitude, np.arange(motions.amplitude.size)))
    start = motions.start(balance, place, float(motions.phase[int(place)]), level).point
    near = correct(balance, start, fixed("omega", omega), ITERATIONS, HALVINGS)
    for begin in (*((near.evaluation.point,) if near.converged else ()), start):
        solution = correct(balance, begin, _phase_of(balance, phase, output), ITERATIONS, HALVINGS)
        found = solution.evaluation.point.omega
        if solution.converged and abs(found / omega - 1.0) < FARTHEST:
            return _climbed(balance, solution.evaluation, output, abs(ratio))
    return np.nan, np.nan


def _climbed(balance: HarmonicBalance, begin: Evaluation, output: int, ratio: float) -> tuple[float, float]:
    """The peak above a point: steps in frequency from the half-power width on, shortened where neither side is higher, there from
    the top of the parabola through all three."""

    def size(evaluation: Evaluation) -> float:
        return float(np.hypot(*evaluation.w[balance.rows + output, balance.first]))

    def beside(change: float) -> Evaluation | None:
        solution = correct(balance, best.point, fixed("omega", best.point.omega + change))
        return solution.evaluation if solution.converged else None

    best, step = begin, max(ratio, LEAST_RATIO) * begin.point.omega
    sides: dict[float, Evaluation | None] = {}
    for _ in range(MOST_STEPS):
        if step < FINEST * best.point.omega:
            break
        sides |= {way: beside(way * step) for way in (-1.0, 1.0) if way not in sides}
        solved = {way: each for way, each in sides.items() if each is not None}
        higher = max(solved, key=lambda way: size(solved[way]), default=0.0)
        if solved and size(solved[higher]) > size(best):
            sides, best = {-higher: best}, solved[higher]
            continue
        if len(solved) == 2:
            low, middle, high = size(solved[-1.0]), size(best), size(solved[1.0])
            bend = 2.0 * middle - low - high
            top = beside(0.5 * step * (high - low) / bend) if bend > 0.0 else None
            best = best if top is None else max(best, top, key=size)
        sides, step = {}, (0.2 if len(solved) == 2 else 0.5) * step
    return best.point.omega / (2.0 * np.pi), size(best)


def _phase_of(balance: HarmonicBalance, phase: float, output: int) -> PathCondition:
    """The first harmonic x of an output, a real and a imaginary part a − ib, has a phase: Im(x exp(−i phase)) = 0, relative to
    the motion of a micrometre.
    """
    weight = np.zeros((balance.rows + len(balance.problem.outputs), balance.columns))
    weight[balance.rows + output, balance.first] = -np.sin(phase) / um, -np.cos(phase) / um
    return PathCondition("omega", weight, 0.0, 0.0)


CONSIDERABLE = 0.05
"""Linear response of the other modes relative to the mode's motion above which peaks of force levels come with a warning. Below,
peaks of chains, blade and three masses are at most 1.3 % off. From 0.05 to 0.2 they are up to 9 % off, of two weakly coupled
masses 34 %; from 0.2 to 0.4 up to 38 %, although those of the blade and of mode 1 of the chain of 20 masses stay within 3 %."""

OFF = 0.01
"""Relative difference of a solved peak from the synthesised one above which it is said."""


def with_peaks(dataset: xr.Dataset, problem: Problem, levels: Sequence[float] = ()) -> xr.Dataset:
    """The dataset with the peaks that belong to its points, and those of force levels; NaN where the forces of the problem do not
    excite a mode, or a level is beyond its amplitudes. `synthesis_message` says why."""
    sizes = {**dataset.sizes, "force_level": len(levels)}
    names = variables_in("peaks_of_modes") | (variables_in("peaks_of_force_levels") if levels else {})
    data = {name: np.full([sizes[dim] for dim in dims], np.nan) for name, (dims, _, _) in names.items()}
    messages, warnings = [], []
    for case in range(sizes["case"]):
        try:
            synthesis = Synthesis.of(dataset, problem, case, None)
        except InputError as reason:
            messages.append(str(reason))
            warnings.append("")
            continue
        messages.append("")
        mode, omega = synthesis.mode, synthesis.mode.easiest()
        own_levels, count = mode.level_of_peak(), mode.omega.size
        data["peak_force_level"][case, :count], data["peak_frequency"][case, :count] = own_levels, omega / (2.0 * np.pi)
        data["quadrature_force_level"][case, :count] = mode.quadrature
        data["peak_other_modes"][case, :count] = synthesis.other_modes(mode, omega, own_levels)
        for output in range(sizes["output"]):
            data["peak_amplitude"][case, :count, output] = np.abs(synthesis.moved(mode, omega, own_levels, output))
        said = [_others_move(data["peak_force_level"][case], data["peak_other_modes"][case])]
        if levels:
            _fill_levels(data, case, synthesis, levels, dataset, problem)
            said.append(_misses(np.array(levels), *(data[name][case] for name in ("level_amplitude", "level_solved_amplitude"))))
        warnings.append(" ".join(filter(None, said)))
    peaks = {name: named(dims, data[name], words, units) for name, (dims, units, words) in names.items()}
    found = dataset.assign(peaks).assign(
        synthesis_message=named("case", np.array(messages, dtype=np.str_), "why there are no peaks of force levels"),
        synthesis_warning=named("case", np.array(warnings, dtype=np.str_), "why peaks of force levels may be wrong"),
    )
    if not levels:
        return found
    return found.assign_coords(force_level=named("force_level", list(levels), "force level"))


def _others_move(levels: Array, shares: Array) -> str:
    """A warning where the other modes move so much that it matters that they respond linearly, as if contacts stuck; else ""."""
    large = np.flatnonzero(shares > CONSIDERABLE)
    if not large.size:
        return ""
    ends, most = (levels[large].min(), levels[large].max()), int(np.nanargmax(shares))
    return (
        f"Between force levels {ends[0]:.3g} and {ends[1]:.3g} other modes contribute more than {100.0 * CONSIDERABLE:g} % of "
        f"the motion (up to {rounded(100.0 * shares[most], 2)} % at force level {levels[most]:.3g}). Peaks computed from this "
        "mode may be wrong by that much: use solved peaks or a forced response."
    )


def _misses(levels: Array, synthesised: Array, solved: Array) -> str:
    """A warning where forced motions have other peaks than the synthesis, or none was found; else ""."""
    unsolved = np.isfinite(synthesised) & np.isnan(solved)
    words = []
    if np.isfinite(solved).any():
        off = np.abs(solved / synthesised - 1.0)
        worst = int(np.nanargmax(off))
        if off[worst] > OFF:
            words.append(
                f"Peaks that are solved as forced motions differ from the synthesised ones by up to {in_percent(off[worst])} "
                f"(force level {levels[worst]:g}). Use the solved peaks."
            )
    if unsolved.any():
        listed = ", ".join(f"{level:g}" for level in levels[unsolved])
        words.append(
            f"No forced motion was found at the peaks of force levels {listed}, so the error of the synthesis is unknown there."
        )
    return " ".join(words)


def _fill_levels(
    data: dict[str, np.ndarray], case: int, synthesis: Synthesis, levels: Sequence[float], dataset: xr.Dataset, problem: Problem
) -> None:
    """The highest peak of each force level that the mode reaches."""
    reached = [level for level in levels if level <= synthesis.mode.level_of_peak().max()]
    if not reached:
        return
    table = with_solved(synthesis.peaks(np.array(reached), 0).drop_duplicates("force_level"), dataset, problem, case, 0)
    places = [list(levels).index(level) for level in table["force_level"]]
    for name in ("frequency", "amplitude", "solved_frequency", "solved_amplitude"):
        data[f"level_{name}"][case, places] = table[name]


MESH_ERRORS = "mesh_errors"
"""Of frequencies and damping ratios, relative: what the coordinates of a finite-element model leave out."""

MEASURED = 9
"""Points along a curve at which that is measured: errors are largest where the damping ratio rises, between its end and the most
damped point."""

Extended = Literal["first", "all"]

LOWEST = 1e-3
"""Where a curve begins whose largest amplitude alone is given, as a share of it."""

AMPLITUDES = (
    "[smallest, largest] amplitude of the first output, in the shape of the stuck mode; default: from half to 1000 times "
    "the amplitude at which the first contact slips"
)

NO_AUTO = 'A mode has no "auto": take the number that a forced response chooses, `response.dataset.attrs["harmonics"]`.'
HarmonicsOfModes = Annotated[int | Sequence[int], Setting(lambda name, value: checked_harmonics(value, NO_AUTO))]


def listed_modes(name: str, mode: Any) -> tuple[int, ...]:
    """Whole numbers, each once."""
    found = tuple(whole(name, number) for number in ([mode] if np.ndim(mode) == 0 else mode))
    if not found:
        raise InputError(f"{name} must hold at least one number, but is empty.")
    unique(name, found)
    return found


def ends_of(name: str, amplitude: Any) -> tuple[float, float]:
    """The ends of a curve."""
    if np.ndim(amplitude) == 0:
        return LOWEST * positive(name, amplitude), float(amplitude)
    ends: Array = vector(name, amplitude, 2)
    low, high = (positive(name, end) for end in ends.tolist())
    if not low < high:
        raise fault(name, "must be (low, high) with low below high", amplitude)
    return low, high


@dataclass(frozen=True, eq=False)
class Modes(Settings):
    """Which modes, from 1 on, over which amplitudes of the output in m, and how finely; a case is a mode."""

    problem: AnyProblem
    mode: Annotated[
        int | Sequence[int] | None,
        Setting(listed_modes, "number of a mode of the stuck structure, or a list; default: those in the band of [sweep]"),
    ] = None
    amplitude: Annotated[float | tuple[float, float] | None, Setting(ends_of, AMPLITUDES)] = None
    harmonics: HarmonicsOfModes = 5
    samples: Samples = 256
    _: KW_ONLY
    frequency: float | None = None
    output: OutputNumber = 0
    largest_at_output: bool = False
    extended: Annotated[
        Extended, Setting(OneOf(get_args(Extended)), "harmonics whose equation contains the negative damping of the mode")
    ] = "first"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.problem.structure.coriolis is not None:
            raise InputError("Nonlinear modes must be of a problem without Coriolis forces. Leave coriolis out.")
        output_of(self.problem, self.output)
        object.__setattr__(self, "samples", self.problem.systems.enough_samples(self.samples))
        harmonics_for(self.problem, self.harmonics)
        fourier(highest(self.kept_harmonics), self.samples)
        _ = self.modes

    @property
    def kept_harmonics(self) -> Harmonics:
        return checked_harmonics(self.harmonics)

    @cached_property
    def modes(self) -> tuple[int, ...]:
        """The numbers of the modes."""
        by_output = of_kind("largest_at_output", self.largest_at_output, bool)
        if (self.mode is not None) + (self.frequency is not None) + by_output > 1:
            raise InputError("Of mode, frequency and largest_at_output one must be given at most, but there are several.")
        if self.frequency is None and not by_output:
            numbers = (1,) if self.mode is None else listed_modes("mode", self.mode)
            return tuple(self._known(between("mode", number, 1, self.problem.structure.size)) for number in numbers)
        with one_blas_thread():
            structures = ModalStructures(self.problem, (1,), 1)
        squares, shapes = structures.squares[structures.key[1]], structures.shapes[structures.key[1]]
        if self.frequency is not None:
            wanted = 2.0 * np.pi * positive("frequency", self.frequency)
            with np.errstate(divide="ignore"):
                return (self._known(int(np.argmin(np.abs(1.0 / np.sqrt(squares) - wanted))) + 1),)
        return (self._known(int(np.argmax(np.abs(shapes[len(self.problem.B) + self.output]) ** 2)) + 1),)

    def _known(self, number: int) -> int:
        """The number of a mode; of a finite-element model refused above those that are computed: beyond lie static shapes."""
        mesh = self.problem.mesh
        if mesh is not None and number > mesh.coordinates.modes:
            highest_mode = f"{mesh.coordinates.modes}, the modes up to {mesh.stuck.modes_to:.5g} Hz"
            remedy = "Let the band of [sweep] reach to the frequency of the mode, or take more harmonics."
            raise fault("mode", f"must be at most {highest_mode}", number, remedy)
        return number

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Everything that a curve depends on."""
        others = self.identity("mode", "frequency", "largest_at_output")
        return tuple(f"{type(self).__name__}, mode {mode}, {others}" for mode in self.modes)

    @property
    def words(self) -> tuple[str, ...]:
        return tuple(f"mode {mode}" for mode in self.modes)

    @property
    def attributes(self) -> dict[str, Any]:
        """What results remember."""
        return {"harmonics": attribute(self.kept_harmonics), "samples": self.samples, "extended": self.extended}

    def refuse_amplitudes(self) -> None:
        """What would stop a curve where it begins."""
        with one_blas_thread():
            for case in range(len(self.modes)):
                self.levels(self.balance(case))

    def balance(self, case: int) -> ModeBalance:
        """The balance of a mode."""
        return self.balance_of(self.problem, self.modes[case] - 1)

    def balance_of(self, problem: Problem, followed: int) -> ModeBalance:
        """The balance of a mode, counted from 0 on, of the problem on some coordinates."""
        extended = 1 if self.extended == "first" else highest(self.kept_harmonics)
        return ModeBalance(problem, self.kept_harmonics, self.samples, followed, extended)

    def with_shapes(self, progress: Progress) -> Self:
        """Of a finite-element model, the work on coordinates with the shapes of the contact forces along its modes; else itself.

        They are followed, on the shapes found so far, until what these leave out is at most `SETTLED`, or more of them do not
        halve it. The work of the forces on shapes left out goes with the square of the error.
        """
        work, share, before = self, NEGLIGIBLE, np.inf
        with one_blas_thread():
            for number in range(ROUNDS if self.problem.mesh else 0):
                errors, forces = [np.zeros(2)], []
                for case, words in enumerate(work.words):
                    progress(case / len(work.modes), f"{words} on {work.problem.structure.size} coordinates")
                    balance = work.balance(case)
                    points = [point.point for point in mode_curve.followed(balance, *work.levels(balance))]
                    if number and points:
                        error, solved = work.mesh_errors(balance, points)
                        errors.append(error)
                        points += solved  # contacts far stiffer than what they join carry other forces there
                    forces += [scaled(point.forces[: balance.rows]) for point in points]
                worst = float(np.max(np.nan_to_num(errors, nan=1.0)))  # too far away to be solved
                if not forces or (number and not SETTLED < worst < 0.5 * before):
                    break
                if number:
                    before = worst
                    share = NEGLIGIBLE * (SETTLED / worst) ** 2 if np.isfinite(errors).all() else share
                work = replace(work, problem=with_forces(work.problem, few_combinations(np.hstack(forces), share), share))
        return work

    def errors_on_mesh(self, balance: ModeBalance, curve: mode_curve.ModeCurve) -> dict[str, NDArray[Any]]:
        """The variable with the errors of a curve of a finite-element model."""
        points = [point.point for point in curve.points]
        return {MESH_ERRORS: self.mesh_errors(balance, points)[0]} if balance.problem.mesh and points else {}

    def mesh_errors(self, balance: ModeBalance, points: Sequence[Point]) -> tuple[Array, list[Point]]:
        """The largest errors (2,) by the coordinates of a mesh, of the frequency and, relative to the largest one, of the damping
        ratio, at points spread along a curve; and the points solved with more coordinates.

        All shapes of the contact forces there, and what the inertia of all shapes deforms, change them by a step, the forces then
        by another one. The steps decrease by a ratio r, so that all of them come to step/(1 − r). NaN where they do not decrease,
        or where fewer than half of the points are found: beside a fold the finer curve may not reach the amplitude.
        """
        most = max(range(len(points)), key=lambda k: balance.damping_of(points[k]))
        chosen = [points[k] for k in sorted({most, *spread(len(points), MEASURED)})]
        count, steps = len(chosen), []
        forces: list[Array] = []
        solved: list[Point] = []
        for _ in range(2):
            forces += [scaled(point.forces[: balance.rows]) for point in chosen]
            whole, solved = self.balance_of(finer(self.problem, np.hstack(forces)), balance.followed), []
            known = []
            for point in chosen:
                start = replace(point, omega=whole.linear_omega, level=whole.level_of(balance.amplitude_of(point)))
                solution = correct(whole, start, fixed("level", start.level), ITERATIONS, HALVINGS)
                if solution.converged:
                    known.append(point)
                    solved.append(solution.evaluation.point)
            if 2 * len(solved) < count:
                return np.full(2, np.nan), solved
            moved, before = _places(whole, solved), _places(balance, known)
            scales = np.maximum(np.abs(before).max(axis=1), np.finfo(float).tiny)
            steps.append(np.abs(moved - before).max(axis=1) / scales)
            chosen, balance = solved, whole
        first, second = steps
        with np.errstate(divide="ignore", invalid="ignore"):
            error = np.where(second < first, first**2 / (first - second), first + second)
        return np.where((second < first) | (second <= SETTLED), error, np.nan), solved

    def levels(self, balance: ModeBalance) -> tuple[float, float]:
        """The path parameter at both ends of the curve."""
        if self.amplitude is None:
            slip = mode_curve.slip_level(balance)
            return slip + float(np.log(mode_curve.BEFORE_SLIP)), slip + float(np.log(mode_curve.BEYOND_SLIP))
        shape = np.abs(balance.shape[balance.rows :])
        if shape[self.output] <= mode_curve.NODE * balance.largest_motion:
            what = f"Output {self.problem.output_names[self.output]!r}"
            raise fault(what, "must move in the mode, since amplitudes are given at it", float(shape[self.output]))
        low, high = (balance.level_of(end / float(shape[self.output])) for end in ends_of("amplitude", self.amplitude))
        return low, high


@dataclass(frozen=True, eq=False, kw_only=True)
class NonlinearModesWork(Modes, Execution):
    """Nonlinear modes as independent cases."""

    phase_at: int | None = None

    def prepare(self) -> None:
        """Compile the kernels, or load them from disk, with the smallest problem there is."""
        smallest = NonlinearModesWork(single_mass(), amplitude=(0.5, 0.6), harmonics=1, samples=8)
        smallest.dataset([smallest.solve(0, lambda share: None)])

    def solve(self, case: int, report: Report) -> Arrays:
        """The arrays of the curve of one mode."""
        started = time.process_time()
        balance = self.balance(case)
        curve = mode_curve.solve_mode(balance, *self.levels(balance), report)
        arrays = mode_arrays(balance, curve) | self.errors_on_mesh(balance, curve)
        return arrays | {"cpu_seconds": np.array(time.process_time() - started)}

    def dataset(self, results: Sequence[Arrays], levels: Sequence[float] = ()) -> xr.Dataset:
        """The curves of all cases as one dataset; levels: of the forces whose peaks it is to hold."""
        attrs = self.attributes | attributes_of(results)
        return with_peaks(modes_dataset(self.problem, results, attrs), self.problem, levels)


def _places(balance: ModeBalance, points: Sequence[Point]) -> Array:
    """Frequency and damping ratio of points, (2, points)."""
    return np.array([[of(point) for point in points] for of in (balance.omega_of, balance.damping_of)])


def attributes_of(results: Sequence[Arrays]) -> dict[str, Any]:
    """What results of cases say together: their time, and of a finite-element model the largest errors by its coordinates."""
    said: dict[str, Any] = {"cpu_seconds": sum(float(result["cpu_seconds"]) for result in results)}
    errors = [result[MESH_ERRORS] for result in results if MESH_ERRORS in result]
    return said | ({MESH_ERRORS: np.max(errors, axis=0)} if errors else {})


def with_decays(dataset: xr.Dataset, problem: Problem) -> xr.Dataset:
    """The same modes with the variables of decays; they are followed again, since results do not hold the tangents of curves."""
    kept = of_attribute(dataset.attrs["harmonics"])
    extended = 1 if dataset.attrs["extended"] == "first" else highest(kept)
    results = []
    with one_blas_thread():
        for number, sizes in zip(dataset["mode_number"].values, dataset["modal_amplitude"].values, strict=True):
            balance = ModeBalance(problem, kept, int(dataset.attrs["samples"]), int(number) - 1, extended)
            known = sizes[np.isfinite(sizes)]
            curve = mode_curve.ModeCurve((), Outcome.NOT_CONVERGED, "")
            if known.size:
                curve = mode_curve.solve_mode(balance, balance.level_of(float(known[0])), balance.level_of(float(known[-1])))
            results.append(mode_arrays(balance, curve) | decay_arrays(balance, curve))
    return modes_dataset(problem, results, dict(dataset.attrs))


def mode_arrays(balance: ModeBalance, curve: mode_curve.ModeCurve) -> dict[str, NDArray[Any]]:
    """The variables of one curve by name, without the axis `case`."""
    rows, met, places = ContactRows(balance.problem), dict[tuple[int, int], float](), []
    for point in curve.points:
        values, strongest = point_values(balance, rows, point.evaluation)
        values |= {"iterations": point.iterations, "active_rows": point.active}
        values |= dict(zip(("amplitude_slope", "frequency_slope", "damping_slope"), mode_curve.pace(point), strict=True))
        values["shape_slope"] = parts(mode_curve.first_harmonic_pace(balance, point))
        places.append(values)
        if strongest is not None:
            met.setdefault(strongest, balance.amplitude_of(point.point))
    sizes = {"output": len(balance.problem.outputs), "harmonic": balance.highest + 1, "part": 2}
    sizes |= {"contact": len(balance.problem.contacts), "direction": 3, "dof": balance.problem.structure.size}
    arrays: dict[str, NDArray[Any]] = {}
    for name, (dims, _, _) in VARIABLES.items():
        if dims[:2] == ("case", "point"):
            empty = np.empty((0, *(sizes[dim] for dim in dims[2:])))
            arrays[name] = np.array([values[name] for values in places], dtype=float) if places else empty
    resonances = [
        f"Internal resonance: from the modal amplitude {amplitude:.3g} m kg^0.5 on, harmonic {harmonic} excites mode {mode} of "
        f"the stuck structure with at least {100.0 * INTERNAL:g} % of the energy."
        for (harmonic, mode), amplitude in met.items()
    ]
    return arrays | {
        "mode_number": np.array(float(balance.followed + 1)),
        "case_outcome": np.array(float(curve.outcome)),
        "case_message": np.array(" ".join([curve.message, *resonances])),
        "stuck_frequency": np.array(balance.linear_omega / (2.0 * np.pi)),
        "stuck_damping": np.array(balance.linear_damping),
    }


def decay_arrays(balance: ModeBalance, curve: mode_curve.ModeCurve) -> dict[str, NDArray[Any]]:
    """The variables of decays of one curve by name, without the axis `case`."""
    decay, energies = slow_decay(balance, curve.points), [mode_energy(balance, point.evaluation) for point in curve.points]
    shared = np.array([energy.resonant > INTERNAL for energy in energies], dtype=bool)[:, None] | (decay.others > SHARED)
    return {
        "swing": decay.swing,
        "decay_damping_ratio": decay.damping_ratio,
        "decay_message": np.array(decay_message(balance.problem.output_names, decay, shared)),
    }


def decay_message(outputs: Sequence[str], decay: SlowDecay, shared: NDArray[np.bool_]) -> str:
    """Where along the swing of the first output a decay has no damping ratio, or is not that of one mode; shared (points,
    outputs): where another mode moves an output too."""
    known = np.isfinite(decay.damping_ratio[:, 0]) if decay.swing.size else np.zeros(0, dtype=bool)
    sentences = []
    lagging = (
        "the static forces of the contacts change with the amplitude faster than a decay follows, whose damping is uncertain"
    )
    beyond = "a decay has no damping ratio: it leaves the computed amplitudes, or a larger motion stores no more energy"
    several = "another mode takes part, so that a decay, there and afterwards, is not that of one mode"
    for output, where, sentence in (
        (0, decay.sticks, "friction stops a decay within two half cycles, so that it has no damping ratio"),
        (0, decay.lags, lagging),
        *((output, shared[:, output], several) for output in range(len(outputs))),
        (0, ~known & ~decay.sticks, beyond),
    ):
        if where.any():
            size = decay.swing[where, output]
            sentences.append(f"Where {outputs[output]} moves {size.min():.3g} m to {size.max():.3g} m, {sentence}.")
    return " ".join(sentences)


def point_values(
    balance: ModeBalance, rows: ContactRows, evaluation: Evaluation
) -> tuple[dict[str, Any], tuple[int, int] | None]:
    """The variables of a point; the harmonic and the mode of an internal resonance, or None."""
    point, omega = evaluation.point, balance.omega_of(evaluation.point)
    motion, outputs = evaluation.w[: balance.rows], evaluation.w[balance.rows :]
    energy = mode_energy(balance, evaluation)
    cycle = contact_cycle(evaluation.table, balance.tables, evaluation.w, omega)
    values: dict[str, Any] = {
        "modal_amplitude": balance.amplitude_of(point),
        "frequency": omega / (2.0 * np.pi),
        "damping_ratio": balance.damping_of(point),
        "energy": energy.mechanical,
        "viscous_work": energy.viscous,
        "energy_residual": energy.residual,
        "other_modes": energy.others,
        "higher_harmonics": energy.harmonics,
        "modal_mass": energy.modal_mass,
        "modal_damping": energy.modal_damping,
        "residual": evaluation.error,
        "amplitude": np.hypot(outputs[:, 1], outputs[:, 2]),
        "max_abs": np.array([largest_absolute(row)[0] for row in outputs]),
        "response": parts(complex_harmonics(outputs)),
        "dissipated": np.bincount(rows.contact, energy.dissipated, minlength=rows.contacts),
        "contact_motion": rows.spread(parts(complex_harmonics(motion))),
        "contact_force": rows.spread(parts(complex_harmonics(balance.carried_forces(evaluation)))),
        "mode_shape": parts(complex_harmonics(balance.whole_motion(evaluation))[:, 1]),
    }
    for name, share in zip(("share_stick", "share_slip", "share_open"), cycle.shares(), strict=True):
        values[name] = rows.spread(share)
    return values, energy.strongest if energy.resonant > INTERNAL else None


def modes_dataset(problem: Problem, results: Sequence[Arrays], attrs: dict[str, Any]) -> xr.Dataset:
    """All curves as one labelled dataset."""
    data = {
        name: named(dims, stacked([result[name] for result in results]), words, units)
        for name, (dims, units, words) in (VARIABLES | OF_DECAYS).items()
        if name in results[0]
    }
    harmonics = data["response"][1].shape[3]
    coords = labels(problem) | {"harmonic": named("harmonic", np.arange(harmonics), "harmonic")}
    return with_shape_forces(xr.Dataset(data, coords, {"title": problem.heading, "study": "", **attrs}), problem)


def labels(problem: Problem) -> dict[str, Any]:
    """The coordinates of modes and limit cycles that the problem gives."""
    # The coordinates themselves, behind the degrees of freedom that are combinations of them.
    dofs = list(problem.structure.dofs[-problem.structure.size :])
    return described("labels_of_modes", labels_of(problem) | {"part": ["re", "im"], "dof": dofs})
