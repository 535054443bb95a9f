"""Errors of harmonics, samples and modes at the highest peaks of a curve: numbers for every result, and their warnings."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from stickslip.analyses.further_curves import NEAR
from stickslip.model.contact.point import Contact
from stickslip.model.problem import Problem
from stickslip.results.schema import shown_sentence
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, PathCondition, Point
from stickslip.solve.balance.fourier import Harmonics, in_words
from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.curve_points import CurvePoint
from stickslip.solve.continuation.finer_peak import finer_peak, phase_condition, solved_on_all_modes
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.continuation.truncation import Beside, beside, beyond_within, contact_work, moving
from stickslip.solve.curves.curve import Curve
from stickslip.solve.peaks.search import SAME_PEAK
from stickslip.support.checks import Array, in_percent
from stickslip.support.late import xr

ALLOWED = 0.004
"""The estimate above which a curve comes with a warning: the change by many more harmonics was up to 2.3
times as large on ready rigs (docs/choose.md), so 1 % does not pass without one.
"""

TRUNCATION_ERROR = {
    "units": "1",
    "long_name": "change of the size of the output at its highest peak by more harmonics, estimated",
}

POINT_ERROR = {
    "units": "1",
    "long_name": "distance of the curve with more harmonics, relative to the size of the output, estimated",
}

WORK_ALLOWED = 0.01
"""The same of the work of the contacts."""

ROUNDED_WORK = 1e-9
"""Work of contacts over the product of their forces and motions below which nothing rubs."""

WORK_ERROR = {
    "units": "1",
    "long_name": "estimated change of the energy dissipated in contacts at the highest peak with more harmonics and samples",
}

SAMPLING_ERROR = {"units": "1", "long_name": "change of the size of the output at its highest peak by more samples, estimated"}


ROUGH = 0.05
"""Change of a peak beyond which that peak is too far from the curve for its change to be known: −20 % stood for −9 %."""


@dataclass(frozen=True)
class FinerProblem:
    """That on which the highest peaks are solved once more: `variable` of the results holds the relative change of the outputs;
    allowed: the change from which on a curve comes with a warning; remedy: said of a change beyond `ROUGH`."""

    variable: str
    words: str
    allowed: float
    remedy: str = ""

    @property
    def attributes(self) -> dict[str, str]:
        return {"units": "1", "long_name": f"relative change of the output at its highest peak when it is solved {self.words}"}

    def warning(self, outputs: tuple[str, ...], errors: Array) -> str:
        """What to say where a highest peak changes, or could not be solved; empty where neither is so."""
        if np.isnan(errors).all():
            return f"The highest peak could not be solved {self.words}, so this change is unknown."
        worst = int(np.nanargmax(np.abs(errors)))
        if not abs(errors[worst]) > self.allowed:
            return ""
        rough = f" {self.remedy}" if self.remedy and abs(errors[worst]) > ROUGH else ""
        change = f"{100.0 * errors[worst]:.1f} %"
        return f"{outputs[worst]} changes at its highest peak by {change} when it is solved {self.words}.{rough}"


MORE_POINTS = "So large a change is known only to a factor of about two: use more `points` until it is small."
ALL_MODES = FinerProblem("modal_error", "on all coordinates of the structure", ALLOWED)
OWN_FORCES = FinerProblem("modal_error", "on the mesh with all shapes of its contact forces and their inertia", ALLOWED)
ALL_NODES = FinerProblem("patch_error", "with a contact at each node of the patches", 0.01, MORE_POINTS)
SEATED = FinerProblem("history_change", "with contacts that the static load seats before friction acts", 0.01)

SAMPLES_PER_HARMONIC = 8

INDEPENDENT = 1e-4
"""Relative change by ten times stiffer springs on means up to which a peak counts as independent of them."""

MORE_SAMPLES = 4
"""Times as many samples as the curve has show what sampling leaves, whose error falls with their square."""

AT_POINTS, AT_PEAKS = 200, 1200
"""Unknowns up to which points, and the few highest peaks, are looked at with all harmonics that an estimate takes."""

FEW_POINTS = 30
"""Points of a curve at which the error is solved first."""


def discretisation_errors(balance: HarmonicBalance, curve: Curve, measure: Measure) -> dict[str, Array]:
    """`truncation_error` and `sampling_error`: what more harmonics, and what more samples, change of the size of every output at
    its highest peak, else at its largest point, relative, and `work_error` of the work of all contacts there: (outputs,) each.

    NaN without a point, and where so many contacts slip that no harmonic beyond H can be looked at. The finer peaks are solved
    at the phase of the peak, where their height is stationary, whichever way the resonance has shifted.
    """
    names = ("truncation_error", "sampling_error", "work_error")
    errors, known = np.full((3, len(balance.problem.outputs)), np.nan), list[tuple[CurvePoint, Array]]()
    finer = affordable(balance, curve.points, AT_PEAKS, MORE_SAMPLES)
    if finer is None:
        return dict(zip(names, errors, strict=True))
    for output, highest in highest_points(balance, curve, measure).items():
        own = next((each for other, each in known if same_motion(highest, other)), None)
        if own is None:
            across = fixed("omega", highest.point.omega)
            if curve.peaks and curve.peaks[output]:
                across = _phase_of(balance, highest, output, measure)
            own = _errors_at(balance, finer, highest.evaluation, across, measure)
            known.append((highest, own))
        errors[:, output] = own[:, output]
    return dict(zip(names, errors, strict=True))


def _phase_of(balance: HarmonicBalance, peak: CurvePoint, output: int, measure: Measure) -> PathCondition:
    """The phase of an output at its peak: of the first harmonic where peaks are of its amplitude, else of the largest one."""
    motion = peak.evaluation.w[balance.rows + output]
    columns = balance.first
    if measure.kind != "amplitude":
        largest = int(np.argmax(np.linalg.norm(motion[1:].reshape(-1, 2), axis=1)))
        columns = slice(1 + 2 * largest, 3 + 2 * largest)
    return phase_condition(balance, output, motion[columns], columns)


def same_motion(point: CurvePoint, other: CurvePoint) -> bool:
    """Whether two points are one motion, such as a peak of two outputs: a fold may lie beside a peak in frequency alone."""
    (omega, motion), (near, beside) = ((each.point.omega, each.evaluation.w) for each in (point, other))
    apart = float(np.linalg.norm(motion - beside))
    return abs(omega - near) <= SAME_PEAK * omega and apart <= NEAR * float(np.linalg.norm(motion))


def point_errors(
    balance: HarmonicBalance, curve: Curve, measure: Measure, listed: bool, report: Callable[[float], None] = lambda share: None
) -> Array:
    """How far a curve with more harmonics passes from every point, |ΔX|/|X| of each output, (points, outputs).

    Solved on the plane across the curve, or at the frequency of listed points: at `FEW_POINTS` of them, at the highest peaks, and
    between any two of these of which one is beyond `ALLOWED` and the other is not, or both together would be; interpolated
    over the points between them. NaN where it is unknown.
    """
    points, rows, counted = curve.points, balance.rows, _counted(balance, measure)
    errors = np.full((len(points), len(balance.problem.outputs)), np.nan)
    finer = affordable(balance, points, AT_POINTS)
    if finer is None or not points:
        return errors

    near: Beside | None = None

    def solve_at(k: int) -> None:
        nonlocal near
        evaluation = points[k].evaluation
        across = fixed("omega", points[k].point.omega) if listed else points[k].across("omega")
        sizes, moves = moving(evaluation.w, rows, counted)
        found = beside(finer, evaluation, across, near)
        # Only the first point is worth the long ways to a solution; where it has none, the others are tried once.
        near, change = found if found.solved or near is None else near, found.change(counted)[rows:]
        errors[k] = np.where(moves, change / np.where(moves, sizes, 1.0), 0.0)

    highest = {id(point) for point in highest_points(balance, curve, measure).values()}
    even = np.linspace(0, len(points) - 1, min(FEW_POINTS, len(points))).round().astype(int)
    known = sorted({*even.tolist(), *(k for k, point in enumerate(points) if id(point) in highest)})
    for done, k in enumerate(known):
        report(done / len(known))
        solve_at(k)
    between = [(low, high) for low, high in pairwise(known)]
    while between:
        low, high = between.pop()
        together = errors[low] + errors[high] > ALLOWED
        if high - low > 1 and np.any(together & ((errors[low] <= ALLOWED) | (errors[high] <= ALLOWED))):
            known.append((low + high) // 2)
            report(1.0)
            solve_at(known[-1])
            between += [(low, known[-1]), (known[-1], high)]
    errors[~np.isfinite(errors)] = np.nan
    known.sort()
    for row in errors.T:
        row[:] = np.interp(range(len(points)), known, row[known])
    return errors


def affordable(balance: HarmonicBalance, points: Sequence[CurvePoint], unknowns: int, samples: int = 1) -> HarmonicBalance | None:
    """The balance with more harmonics and so many times the samples for an estimate; None where it would cost too much."""
    rows = min(max((point.active for point in points), default=0) / balance.kept.size, balance.problem.structure.size)
    beyond = beyond_within(balance.highest, max(rows, 1.0), unknowns)
    return finer_balance(balance, beyond, samples) if beyond else None


def _errors_at(
    balance: HarmonicBalance, finer: HarmonicBalance, evaluation: Evaluation, across: PathCondition, measure: Measure
) -> Array:
    """By harmonics and by samples, with the same many samples, so that neither counts the other, and by both of the work of
    the contacts, (3, outputs)."""
    sampled = balance.with_samples(finer.tables.E.shape[0])
    solutions = [beside(each, evaluation, across) for each in (finer, sampled)]
    more, fewer = (each.evaluation for each in solutions)
    sizes = [
        np.array([measure.size(row, each.point.omega) for row in each.w[balance.rows :]]) for each in (more, fewer, evaluation)
    ]
    moves = moving(evaluation.w, balance.rows, _counted(balance, measure))[1]
    own = np.where(moves, sizes[2], np.inf)
    least = ROUNDED_WORK * float(np.vdot(np.abs(evaluation.point.forces), np.abs(evaluation.w[: balance.rows])))
    work = _relative(contact_work(finer, more), contact_work(balance, evaluation), least)
    errors = np.array([abs(sizes[0] - sizes[1]) / own, abs(sizes[1] - sizes[2]) / own, np.full(own.size, work)])
    lost = [not np.isfinite(each.way).all() for each in solutions]  # a singular matrix says nothing, and not that all is well
    errors[[lost[0] or lost[1], lost[1], lost[0]]] = np.nan
    return errors


def highest_points(balance: HarmonicBalance, curve: Curve, measure: Measure) -> dict[int, CurvePoint]:
    """The highest peak of each output, else the largest point; outputs without a point are left out."""
    found = {}
    for output in range(len(balance.problem.outputs)):
        points, row = curve.tops(output), balance.rows + output
        if points:
            found[output] = max(points, key=lambda point: measure.size(point.evaluation.w[row], point.point.omega))
    return found


def errors_by(finer: HarmonicBalance, few: HarmonicBalance, balance: HarmonicBalance, curve: Curve, measure: Measure) -> Array:
    """The relative change of each output (outputs,) at its highest peak when it is solved with `finer`.

    finer: the problem of the curve, that of `balance`, on all modes and with a contact at each node of its patches; few: the
    contacts of `finer` on few coordinates.

    The finer peak is a little beside that of the curve. There the phase of the output is the same in the first order, while its
    amplitude is at its maximum; so the output is solved at the phase it had, with the frequency as an unknown. Outputs whose
    curve has no peak are solved at the frequency of their largest point. NaN where Newton's method does not arrive.
    """
    errors = np.full(len(balance.problem.outputs), np.nan)
    for output, highest in highest_points(balance, curve, measure).items():
        point, X = highest.point, highest.evaluation.w[balance.rows + output]
        start = replace(point, forces=_at_nodes(balance.problem.contacts, point.forces))
        solution = solved_again(finer, few, start, output, X[balance.first] if curve.peaks and curve.peaks[output] else None)
        if solution is not None:
            row = finer.rows + output
            errors[output] = measure.size(solution.w[row], solution.point.omega) / measure.size(X, point.omega) - 1.0
    return errors


def solved_again(
    finer: HarmonicBalance, few: HarmonicBalance, start: Point, output: int, peak: Array | None
) -> Evaluation | None:
    """A point with `finer`: a peak of an output, whose first harmonic is `peak` (2,), at that phase; another, None, at its
    frequency. None where Newton's method does not arrive."""
    if peak is not None:
        return finer_peak(finer, few, start, output, peak)
    return solved_on_all_modes(finer, few, start, fixed("omega", start.omega))


def _at_nodes(contacts: tuple[Contact, ...], forces: Array) -> Array:
    """λ of contacts with that of patches shared by their nodes, as if these all moved as their mean: (rows, 2H+1)."""
    shared, row = [], 0
    for contact in contacts:
        own = forces[row : row + len(contact.directions)]
        shared += [node.share * own for node in contact.nodes] or [own]
        row += len(own)
    return np.concatenate(shared)


def sampling_error(balance: HarmonicBalance, point: CurvePoint, output: int, measure: Measure) -> float:
    """What `MORE_SAMPLES` times as many samples would change of an output at one of its peaks, relative; NaN where that cannot be
    solved."""
    sampled = balance.with_samples(MORE_SAMPLES * balance.tables.E.shape[0])
    row = balance.rows + output
    found = beside(sampled, point.evaluation, _phase_of(balance, point, output, measure))
    size = measure.size(point.evaluation.w[row], point.point.omega)
    solution = found.evaluation
    return abs(measure.size(solution.w[row], solution.point.omega) / size - 1.0) if found.solved else np.nan


def _counted(balance: HarmonicBalance, measure: Measure) -> slice:
    """The columns of a motion that a measure is of."""
    return balance.first if measure.kind == "amplitude" else slice(1, None)


def _relative(work: float, own: float, least: float) -> float:
    """By how much a work differs from that of the curve, relative to the larger; 0 where both are less than rounding leaves."""
    scale = max(abs(work), abs(own))
    return abs(work - own) / scale if scale > least else 0.0


def work_warning(harmonics: Harmonics, outputs: tuple[str, ...], errors: Array) -> str:
    """What to say where the work of the contacts at a highest peak is not known well; empty where it is."""
    if not np.any(errors > WORK_ALLOWED):
        return ""
    worst = int(np.nanargmax(errors))
    other = "more than" if isinstance(harmonics, int) else "harmonics other than"
    more = f"more samples and {other} {in_words(harmonics).removeprefix('harmonics ')}"
    return (
        f"The energy dissipated in contacts at the highest peak of {outputs[worst]} would change {_much(errors[worst])} "
        f"with {more}."
    )


def finer_balance(balance: HarmonicBalance, beyond: int, times: int = MORE_SAMPLES) -> HarmonicBalance:
    """The balance with all harmonics up to `beyond` and so many times the samples, or more. The mean stays out where a list
    leaves it out: it is zero there, and where friction alone holds a body it would make the matrix singular."""
    harmonics = beyond if balance.kept[0] == 0 else tuple(range(1, beyond + 1))
    samples = max(times * balance.tables.E.shape[0], SAMPLES_PER_HARMONIC * beyond)
    finer = HarmonicBalance(balance.problem, harmonics, balance.problem.systems.enough_samples(samples))
    finer.periods = balance.periods
    return finer


def truncation_warning(harmonics: Harmonics, outputs: tuple[str, ...], errors: Array, choice: str = "") -> str:
    """What to say where the largest of the errors is not small, or none is known; empty where it is small. choice: how "auto"
    chose the harmonics, where it did."""
    more = f"{'More' if isinstance(harmonics, int) else 'Others'} than {in_words(harmonics)}"
    if np.isnan(errors).all():
        return f"What {more[0].lower()}{more[1:]} would change at the highest peaks is not known."
    if not np.any(errors > ALLOWED):
        return ""
    worst = int(np.nanargmax(errors))
    remedy = "take more" if choice else 'take more, or harmonics = "auto"'
    return f"{more} would change {outputs[worst]} at its highest peak {_much(errors[worst])}: {remedy}."


def away_warning(balance: HarmonicBalance, curve: Curve, measure: Measure, errors: Array, at_peaks: Array) -> str:
    """What to say where more harmonics move a curve, away from its highest peaks, by what matters there; empty where they do not.

    errors: those of all points of the curve, (points, outputs); at_peaks: those of the highest peaks, (outputs,). Beside a
    warning of these only a change that is larger and rough is said: the curve leads to another peak then.
    """
    places = np.setdiff1d(np.arange(len(curve.points)), curve.places_outside)
    if not places.size:
        return ""
    inside = [curve.points[place] for place in places]
    sizes = np.array([[measure.size(row, p.point.omega) for row in p.evaluation.w[balance.rows :]] for p in inside])
    moved = np.nan_to_num(errors[places] * sizes / np.maximum(sizes.max(axis=0), np.finfo(float).tiny))
    point, output = np.unravel_index(int(np.argmax(moved)), moved.shape)
    much = float(moved[point, output])
    highest = float(np.nan_to_num(at_peaks).max(initial=0.0))
    if much <= (ALLOWED if highest <= ALLOWED else max(highest, ROUGH)):
        return ""
    of_it = f"{_much(much)} of its largest value" if much < 1.0 else _much(much)
    where = f"{balance.hertz(inside[point].point.omega):.5g} Hz"
    return f"More harmonics would change the curve of {balance.problem.output_names[output]} at {where} {of_it}."


ROUGH = 0.1
"""Change from which an estimate is rough, since one step of Newton's method or few steps lead to it."""


def _much(error: float) -> str:
    """An estimated change in words."""
    if error < ROUGH:
        return f"by about {100.0 * error:.1f} %"
    return f"by roughly {100.0 * error:.0f} %" if error < 1.0 else "by more than can be estimated"


def held_mean_warning(balance: HarmonicBalance, springs: int, curve: Curve, measure: Measure) -> str:
    """What to say where the highest peaks depend on the last `springs` springs, which hold means; empty where they do not.

    The peaks are solved with springs ten times as stiff, at their frequencies.
    """
    problem = balance.problem
    kept = problem.mean_springs[: len(problem.mean_springs) - springs]
    stiffer = [replace(spring, stiffness=10.0 * spring.stiffness) for spring in problem.mean_springs[len(kept) :]]
    if not stiffer:
        return ""
    other = HarmonicBalance(replace(problem, mean_springs=(*kept, *stiffer)), balance.harmonics, balance.tables.E.shape[0])
    for output, highest in highest_points(balance, curve, measure).items():
        point, row = highest.point, balance.rows + output
        solution = correct(other, point, fixed("omega", point.omega), iterations=20, halvings=8)
        sizes = [measure.size(each.w[row], point.omega) for each in (highest.evaluation, solution.evaluation)]
        if not solution.converged or abs(sizes[1] / sizes[0] - 1.0) > INDEPENDENT:
            return (
                f"{problem.output_names[output]} depends on the springs that hold mean positions: say by mean_springs of the "
                "problem (in Python) what holds them."
            )
    return ""


def coordinates_note(few: Problem, whole: Problem) -> str:
    """On which coordinates a problem was solved, and which means were held, for the first lines of a result."""
    wave = " for each nodal diameter" if few.structure.shapes is None else ""
    shapes = "shapes for the effect of higher modes on contacts, loads and outputs"
    if few.mesh is not None:
        shapes = "shapes of rigid motions, loads, outputs and the contact forces at the highest peaks"
    note = (
        f"Solved on {few.systems.coordinates} coordinates of {whole.freedoms}{wave}: the modes up to {few.modes_to:.4g} Hz "
        f"with all contacts stuck, and {shapes}."
    )
    for spring in few.mean_springs[len(whole.mean_springs) :]:
        along = ", ".join(spring.direction)
        note += (
            f" A spring of {spring.stiffness:.2g} N/m holds the mean position along {along}, which friction alone restrains; the "
            "highest peaks are solved with a stiffer one too, and a warning says where they depend on it."
        )
    return note


def finer_sentences(dataset: "xr.Dataset") -> list[str]:
    """On which coordinates a response was solved, and how much its highest peaks change on all modes, or with all nodes."""
    sentences = (
        [shown_sentence(str(dataset.attrs["coordinates_chosen"]), dataset)] if "coordinates_chosen" in dataset.attrs else []
    )
    for finer in (OWN_FORCES, ALL_MODES, ALL_NODES, SEATED):
        solved = finer.variable in dataset and dataset[finer.variable].attrs.get("long_name") == finer.attributes["long_name"]
        if solved and np.isfinite(dataset[finer.variable].values).any():
            errors, levels = dataset[finer.variable].values, dataset["force_level"].values
            case, output = np.unravel_index(np.nanargmax(np.abs(errors)), errors.shape)
            unknown = [f"{level:g}" for level in levels[np.isnan(errors).all(axis=1)]]
            sentences.append(
                f"Solved again {finer.words}, the highest peaks change by at most {in_percent(abs(errors[case, output]))} "
                f"({dataset['output'].values[output]} at force level {levels[case]:g})"
                + (f"; at force level {', '.join(unknown)} this solution failed, and the change is unknown." if unknown else ".")
            )
    return [*sentences, *filter(None, [str(dataset.attrs.get("static_history", ""))])]
