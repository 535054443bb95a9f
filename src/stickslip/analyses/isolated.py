"""Motions of a force level that its swept curve does not meet: isolas and other detached curves, and a curve that enters the band
from outside.

A sweep follows the curve that it begins on. Where the force that a mode needs in resonance falls with the amplitude, one force
level has several resonance peaks, and those above the first may lie on a curve of their own. A motion over p periods of the
excitation meets a mode whose frequency is that of the excitation over p.

At a fixed frequency the motions of all force levels form an S-curve: from rest it rises, falls back at a fold and rises again
where one level has several motions. Wherever it crosses the level of a swept curve there is a motion of that level; one that no
known curve passes begins another curve. Just below the level of a fold the motion of its size lies at another frequency; where
the fold is lowest over all frequencies a detached curve begins.

The amplitude that a level can hold is bounded: with passive contacts and D = ½(C + Cᵀ) ≥ 0 the power that damping takes,
½ ω² Σ h² X_hᴴ D X_h, is no more than that of the force, ½ F ω Im(fᴴ X_1). Where f = D g and an output is c = D d, X_1 lies in a
ball about F g/(2 i ω), and

    |cᵀ X_1| ≤ F/(2 ω) (|dᵀ f| + √(dᵀ c) √(gᴴ f)).

An S-curve beyond the bound may still come back: that is where a search ends, and no proof.

Where a resonance leans over the band, a curve that begins inside stays below it, and one that begins outside climbs it: the band
then decides which of the two a sweep follows. Newton's method from other starts at the same frequencies finds neither more often
than the curve itself; a curve from beyond an end does.
"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.further_curves import NEAR, SolvedCurve, passes
from stickslip.analyses.response_dataset import ContactRows, of_parts
from stickslip.model.loads import excited_harmonics
from stickslip.model.problem import Problem
from stickslip.model.problem.contraction import contracts
from stickslip.model.problem.problem import HELD_ALONE
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, PathCondition, Point
from stickslip.solve.balance.fourier import real_harmonics
from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.continuation import solve_cold, trace
from stickslip.solve.continuation.curve_points import CurvePoint, LostCurveError, Tangent, solve_at
from stickslip.solve.continuation.newton import Correction, correct, fixed
from stickslip.solve.continuation.steps import StepControl
from stickslip.solve.continuation.sweep import Followed, followed_both_ways
from stickslip.solve.continuation.truncation import pad, resolved
from stickslip.solve.curves.curve import Curve
from stickslip.support.checks import SMALLEST, Array, counted
from stickslip.support.late import xr
from stickslip.support.outcome import Outcome

PLACES = 16
"""Points of a mode from which subharmonic motions are sought."""

PHASES = 6
"""Phases of a subharmonic motion that are tried within a period of the excitation."""

SUBHARMONIC = 1e-3
"""Share of the motion between the harmonics of the excitation from which it is subharmonic."""


@dataclass(frozen=True, eq=False)
class Start:
    """A motion that may lie near a solution: λ and ω, and the motion itself (motion rows, 2H+1), m."""

    point: Point
    motion: Array


@dataclass(frozen=True, eq=False)
class ModeMotions:
    """The motions of one mode along its curve, (points, rows, H+1) complex, with ω [rad/s], the force level that has its
    resonance peak there, the phases of motions in resonance against the mode's, and modal amplitudes, (points,)."""

    omega: Array
    level: Array
    force: NDArray[np.complex128]
    motion: NDArray[np.complex128]
    phase: Array
    amplitude: Array

    @classmethod
    def of(cls, balance: HarmonicBalance, modes: "xr.Dataset", case: int) -> "ModeMotions":
        """A case of the dataset of modes; the balance knows the problem."""
        rows = ContactRows(balance.problem)
        good = np.flatnonzero(np.isfinite(modes["frequency"].values[case]))
        chosen = modes.isel(case=case, point=good)
        carried, moved = (
            np.array([rows.collected(each) for each in of_parts(chosen[name].values)]).reshape(good.size, balance.rows, -1)
            for name in ("contact_force", "contact_motion")
        )
        motion = np.concatenate([moved, of_parts(chosen["response"].values)], axis=1)
        force = carried - balance.stiffness[:, None] * moved
        load = balance.problem.load_powers(max(h for each in balance.problem.forces for h in each.factors))[0]
        first = balance.first
        driven = load[:, first.start] - 1j * load[:, first.start + 1]
        phase = np.angle(-1j * (of_parts(chosen["mode_shape"].values).conj() @ driven))
        level = chosen["peak_force_level"].values if "peak_force_level" in chosen else np.full(good.size, np.nan)
        amplitude = chosen["modal_amplitude"].values
        return cls(2.0 * np.pi * chosen["frequency"].values, level, force, motion, phase, amplitude)

    def start(self, balance: HarmonicBalance, place: float, phase: float, level: float) -> Start:
        """The motion at a place between the points, its first harmonic turned by a phase."""
        k = min(int(place), self.omega.size - 2)
        share = place - k
        turned = np.exp(1j * phase * np.arange(self.force.shape[2]))
        force, motion = (((1.0 - share) * part[k] + share * part[k + 1]) * turned for part in (self.force, self.motion))
        omega = (1.0 - share) * self.omega[k] + share * self.omega[k + 1]
        point = Point(pad(real_harmonics(force), balance.columns), float(omega), level)
        return Start(point, pad(real_harmonics(motion), balance.columns))


@dataclass(frozen=True, eq=False)
class Isolated:
    """The curves of a force level that its swept curve does not meet, as solutions on them are found; known: curves of that level
    found before."""

    curve: SolvedCurve
    known: Sequence[Sequence[CurvePoint]] = ()
    found: list[Followed] = field(default_factory=list)

    def take(self, evaluation: Evaluation | None) -> bool:
        """Follow the curve through a solution, if it lies in the band and no curve passes it; whether it is another one."""
        curve = self.curve
        if evaluation is None or not curve.band[0] <= evaluation.point.omega <= curve.band[1]:
            return False
        if curve.balance.periods > 1 and not _subharmonic(curve.balance, evaluation):
            return False
        others = (*self.known, *(each.points for each in self.found))
        if curve.meets(evaluation) or any(passes(curve.balance, points, evaluation) for points in others):
            return False
        self.found.append(_followed(curve, evaluation))
        return True

    @property
    def curves(self) -> list[Curve]:
        """With their peaks."""
        return [self.curve.followed(each, _kind_of(self.curve, each)) for each in self.found]


IN_THIS_BAND = "A curve that the sweep does not meet in this band"
"""How the message of an open curve begins."""


def _kind_of(curve: SolvedCurve, found: Followed) -> str:
    """What a curve is, as the beginning of a sentence; an open one may be the rest of the sweep, outside the band."""
    if curve.balance.periods > 1:
        return "A subharmonic curve"
    if found.closed or found.lost is not None:
        return "An isolated curve"
    return f"{IN_THIS_BAND}, though it may in a wider one"


def take_from_modes(isolated: Isolated, modes: "Sequence[xr.Dataset]") -> int:
    """Take what Newton's method makes of the motions of nonlinear modes of the problem; how many starts there were."""
    tried = 0
    for dataset in modes:
        for case in range(dataset.sizes["case"]):
            for start in _mode_starts(isolated.curve, ModeMotions.of(isolated.curve.balance, dataset, case)):
                isolated.take(_corrected(isolated.curve.balance, start))
                tried += 1
    return tried


def _mode_starts(curve: SolvedCurve, mode: "ModeMotions") -> Iterator[Start]:
    """Resonance peaks of a force level on a mode; for motions over several periods all amplitudes, in several phases."""
    balance, level = curve.balance, curve.level
    if balance.periods == 1:
        beyond = mode.level - level
        for crossed in np.flatnonzero(beyond[1:] * beyond[:-1] < 0.0):
            k = int(crossed)
            share = beyond[k] / (beyond[k] - beyond[k + 1])
            yield mode.start(balance, k + float(share), float(mode.phase[k]), level)
        # The level may also be met between the points beside its minimum, where it is no straight line.
        for lowest in 1 + np.flatnonzero((beyond[1:-1] <= beyond[:-2]) & (beyond[1:-1] < beyond[2:])):
            k = int(lowest)
            yield mode.start(balance, float(k), float(mode.phase[k]), level)
        return
    inside = np.flatnonzero((mode.omega >= curve.band[0]) & (mode.omega <= curve.band[1]))
    for k in sorted({int(inside[round(k)]) for k in np.linspace(0, inside.size - 1, min(inside.size, PLACES))}):
        for turn in range(PHASES):
            yield mode.start(balance, float(k), 2.0 * np.pi * turn / (PHASES * balance.periods), level)


def _corrected(balance: HarmonicBalance, start: Start) -> Evaluation | None:
    """The solution with the size of a motion, its frequency free, which is best at a resonance peak; else at its frequency."""
    weight = np.zeros_like(start.motion)
    for part in (slice(0, balance.rows), slice(balance.rows, None)):
        size = float(np.sum(start.motion[part, 1:] ** 2))
        if size > 0.0:
            weight[part, 1:] = start.motion[part, 1:] / size
    plane = PathCondition("omega", weight, 0.0, float(np.vdot(weight, start.motion)))
    for condition in (plane, fixed("omega", start.point.omega)):
        found = correct(balance, start.point, condition, iterations=40, halvings=12)
        if found.converged:
            return found.evaluation
    return None


def _subharmonic(balance: HarmonicBalance, evaluation: Evaluation) -> bool:
    """Whether a motion does not repeat after each period of the excitation."""
    columns = np.arange(1, balance.columns)
    between = columns[((columns + 1) // 2) % balance.periods != 0]
    motion = evaluation.w
    return float(np.linalg.norm(motion[:, between])) > SUBHARMONIC * float(np.linalg.norm(motion[:, 1:]))


def _followed(curve: SolvedCurve, evaluation: Evaluation) -> Followed:
    """The curve through a solution; a closed one from its lowest frequency on."""
    still = np.zeros_like(evaluation.point.forces), np.zeros_like(evaluation.w)
    found = followed_both_ways(curve.balance, evaluation, Tangent(*still, 1.0), curve.band)
    if not found.closed:
        return found
    points = found.points[1:]
    lowest = min(range(len(points)), key=lambda k: points[k].point.omega)
    turned = [*points[lowest:], *points[: lowest + 1]]
    return replace(found, points=[replace(turned[0], length=0.0), *turned[1:]])


APART = "apart from the sweep"

FREQUENCIES = 4
"""Frequencies evenly inside the band, and the most beside them where the fold may be lowest."""

FARTHEST = 100.0
"""An S-curve goes from a force level this many times below that of the swept curve to one as many times above."""

HARMONICS = 3
"""Harmonics of S-curves; the motions of a level found on them are solved with those of the swept curve. Where all contacts open
and close, 18 would take fifteen times as long, more than the swept curve."""

IN_RANGE = 1e-6
"""Share of a force or an output outside of what the damping acts on, up to which it is rounding."""

POINTS, FEW_ROWS, POINTS_OF_MANY = 8.0, 60, 0.1
"""Points of S-curves that may be solved for each point of the swept curve, which with its peaks and their errors takes as long as
six to nine of them; contact rows beyond which they are fewer, and how many then."""


def unsought(problem: Problem) -> str:
    """Why detached curves of a problem are not sought; empty where they are: where contacts have a normal direction, so that they
    may lift off, or do not rub."""
    if contracts(problem):
        return "friction and damping allow only one motion"
    if excited_harmonics(problem.forces) != {1}:
        return "the force has other harmonics than the first"
    if all(contact.normal is None and contact.law.rubs for contact in problem.contacts):
        return "no contact lifts off or is a nonlinear spring"
    return ""


def sought_unasked(problem: Problem) -> bool:
    """Whether detached curves are sought unless it is said otherwise: where a contact does not rub, such as a stop or a spring.

    Contacts that rub and lift off take up to five times the time of the sweep, and half of their curves are found.
    """
    return any(not contact.law.rubs for contact in problem.contacts)


def sustained(problem: Problem, omega: float, level: float) -> Array:
    """The amplitude of the first harmonic that a force level can sustain at ω [rad/s], of each output, (outputs,) m.

    Infinite for an output, or a force, that moves what no damping takes energy from, and where damping or gas forces may give
    energy.
    """
    outputs, load = problem.systems.at(1).outputs, problem.load_powers(1)
    force = (omega ** np.arange(len(load))) @ (load[:, :, 1] - 1j * load[:, :, 2])
    inverse = None if problem.systems.gas else _inverse_damping(problem)
    if inverse is None:
        return np.full(len(outputs), np.inf)
    damping, generalised = inverse
    by_force, by_output = generalised @ force, generalised @ outputs.conj().T
    if not np.allclose(damping @ by_force, force, rtol=0.0, atol=IN_RANGE * float(np.abs(force).max())):
        return np.full(len(outputs), np.inf)
    reached = np.all(np.abs(damping @ by_output - outputs.conj().T) <= IN_RANGE * np.abs(outputs).max(axis=1), axis=0)
    directly = np.abs(outputs @ by_force)
    power = np.sqrt(np.real(np.vdot(force, by_force)) * np.real(np.einsum("on,no->o", outputs, by_output)))
    return np.where(reached, level / (2.0 * omega) * (directly + power), np.inf)


def _inverse_damping(problem: Problem) -> tuple[NDArray[Any], NDArray[Any]] | None:
    """The damping D of harmonic 1 and a generalised inverse of it; None where a system of the structure gains energy by it."""
    for _, _, C in problem.systems.without_contacts():
        if _scaled(C)[0][0] < -HELD_ALONE:
            return None
    C = problem.systems.at(1).C
    values, vectors, scale = _scaled(C)
    kept = values > HELD_ALONE
    scaled = vectors[:, kept] / scale[:, None]
    return 0.5 * (C + C.conj().T), (scaled / values[kept]) @ scaled.conj().T


def _scaled(C: NDArray[Any]) -> tuple[Array, NDArray[Any], Array]:
    """Eigenvalues and vectors of ½(C + Cᴴ) with ones on its diagonal, which takes the units out, and the scale of rows."""
    D = 0.5 * (C + C.conj().T)
    diagonal = np.abs(np.diag(D))
    scale = np.sqrt(np.where(diagonal > SMALLEST, diagonal, 1.0))
    return *np.linalg.eigh(D / np.outer(scale, scale)), scale


@dataclass(eq=False)
class LevelCurves:
    """The search along the force level. fold: by ω of each S-curve the lowest level above that of the swept curve at which it
    turns up again, infinite without; left: points that may still be solved; lost: ω where Newton's method or the points
    ended before."""

    curve: SolvedCurve
    isolated: Isolated
    left: int
    fold: dict[float, float] = field(default_factory=dict)
    lost: list[float] = field(default_factory=list)

    @cached_property
    def _few_harmonics(self) -> HarmonicBalance:
        return self.curve.balance.with_harmonics(min(HARMONICS, self.curve.balance.highest))

    def search(self) -> None:
        """S-curves evenly inside the band, and where the fold may be lowest until another curve is found."""
        low, high = self.curve.band
        for omega in np.linspace(low, high, FREQUENCIES + 2)[1:-1]:
            self._add(float(omega))
        for _ in range(FREQUENCIES):
            between = self._at_lowest_fold()
            if self.isolated.found or between is None:
                return
            self._add(between)

    def _add(self, omega: float) -> None:
        """The S-curve of a frequency, unless nothing is left to spend."""
        if self.left <= 0:
            return
        passed: list[CurvePoint] = []
        try:
            passed.extend(self._points(omega))
        except LostCurveError:
            self.lost.append(omega)
        along = np.cumsum([point.length for point in passed])
        levels, own = np.abs([point.point.level for point in passed]), abs(self.curve.level)
        folds = []
        for k in range(1, levels.size - 1):
            if levels[k - 1] > levels[k] <= levels[k + 1] and levels[k] > own:
                folds.append(_lowest(along[k - 1 : k + 2], levels[k - 1 : k + 2])[1])
                self._take_beside(passed[k])
        self.fold[omega] = max(min(folds, default=np.inf), own)

    def _take_beside(self, fold: CurvePoint) -> None:
        """Take a motion of the swept curve's level with the size of that at a fold just above it, at another frequency."""
        found = _corrected(self._few_harmonics, Start(replace(fold.point, level=self.curve.level), fold.evaluation.w))
        if found is not None:
            with suppress(LostCurveError):
                self._take(found)

    def _points(self, omega: float) -> Iterator[CurvePoint]:
        """The points of an S-curve, whose motions of the swept curve's level are taken on the way."""
        level = self.curve.level
        balance = self._few_harmonics
        first = solve_cold(balance, omega, level / FARTHEST)
        if not first.converged:
            raise LostCurveError("No motion of a small force level was found.")
        most = sustained(balance.problem, omega * balance.periods, abs(level))
        before: CurvePoint | None = None
        for point in trace(balance, first, "level", FARTHEST * level, StepControl(points=self.left)):
            self.left -= 1
            yield point
            if before is not None and (before.point.level - level) * (point.point.level - level) < 0.0:
                try:
                    self._take(solve_at(balance, before, point, "level", level).evaluation)
                except LostCurveError:
                    self.lost.append(omega)
            before = point
            sizes = np.hypot(*point.evaluation.w[balance.rows :, balance.first].T)
            if np.isfinite(most).any() and np.all((sizes > most)[np.isfinite(most)]):
                return

    def _take(self, rough: Evaluation) -> None:
        """The curve through a motion of an S-curve, solved with the harmonics of the swept curve."""
        solution = resolved(self.curve.balance, rough)
        if not solution.converged:
            raise LostCurveError("No motion with all harmonics was found beside it.")
        self.isolated.take(solution.evaluation)

    @property
    def sentence(self) -> str:
        """What was searched."""
        bounded = np.isfinite(sustained(self.curve.balance.problem, self.curve.band[1], 1.0)).any()
        reach = f"{'what damping lets the force sustain, or ' if bounded else ''}{FARTHEST:g} times this force level"
        found = self.isolated.found
        led = f"{counted(len(found), 'curve')} {APART}" if found else "no motion off the sweep"
        short = f" At {self._hertz(self.lost)} the search ended earlier." if self.lost else ""
        met = f"{led} {'were' if len(found) > 1 else 'was'} found"
        return f"The search for detached curves at {self._hertz(list(self.fold))} went up to {reach}: {met}.{short}"

    def _hertz(self, omegas: list[float]) -> str:
        return f"{', '.join(f'{self.curve.balance.hertz(omega):.5g}' for omega in sorted(set(omegas)))} Hz"

    def _at_lowest_fold(self) -> float | None:
        """Where the fold is lowest, by the parabola through the lowest one and both neighbours; where one of them has none, the
        middle between the lowest and its farther neighbour. None without a fold, and where the parabola, tried once, stays
        farther above the level than it goes below the lowest fold."""
        low, high = self.curve.band
        known = sorted(self.fold)
        lowest = min(known, key=lambda omega: self.fold[omega], default=None)
        if lowest is None or not np.isfinite(self.fold[lowest]):
            return None
        place = known.index(lowest)
        ends = [known[place - 1] if place else low, known[place + 1] if place + 1 < len(known) else high]
        places = np.array([ends[0], lowest, ends[1]])
        folds = np.array([self.fold.get(omega, np.inf) for omega in places])
        if np.all(np.isfinite(folds)):
            omega, fold = _lowest(places, folds)
            coarse = len(known) == FREQUENCIES
            return omega if coarse or fold - abs(self.curve.level) < self.fold[lowest] - fold else None
        return 0.5 * (lowest + max(ends, key=lambda omega: abs(omega - lowest)))


def _lowest(places: Array, values: Array) -> tuple[float, float]:
    """The lowest point of the parabola through three points, of which that in the middle is not above the others."""
    (back, on), middle = np.diff(values) / np.diff(places), values[1]
    curvature = (on - back) / (places[2] - places[0])
    if curvature <= 0.0:
        return float(places[1]), float(middle)
    slope = on - curvature * (places[2] - places[1])
    return float(places[1] - 0.5 * slope / curvature), float(middle - 0.25 * slope**2 / curvature)


def searched(curve: SolvedCurve) -> tuple[list[Curve], str]:
    """The curves of the level of a swept one that lie apart from it, and what was searched, as a sentence."""
    isolated = Isolated(curve)
    each = POINTS if curve.balance.rows <= FEW_ROWS else POINTS_OF_MANY
    search = LevelCurves(curve, isolated, int(each * len(curve.points)))
    search.search()
    return isolated.curves, search.sentence


BEYOND = (1.25, 2.0)
"""How many times beyond an end of the band, in frequency, other curves begin: a resonance may lean farther than the first."""

MOST_POINTS = 600

HIGHER = 1.1
"""How many times as high as the curve another one must rise inside the band for a warning."""

LEAST_SPENT, SHARE = 3e9, 0.1
"""(Rows of the Newton matrix)³ times steps that may be taken, a fifth of a second or so, or this share of what the curve took."""


def other_motion_warning(balance: HarmonicBalance, curve: Curve, measure: Measure) -> str:
    """What to say where a higher motion enters the band through one of its ends; empty where none is met."""
    if curve.outcome != Outcome.CONVERGED or len(curve.points) < 2:
        return ""
    ends = curve.points[0], curve.points[-1]
    if ends[0].point.omega > ends[1].point.omega:
        ends = ends[1], ends[0]
    own = _sizes(balance, curve.inside, measure)
    upwards, downwards = [1.0 / factor for factor in BEYOND], BEYOND
    for begin, points in chain(_entering(balance, curve, *ends[::-1], downwards), _entering(balance, curve, *ends, upwards)):
        sizes = _sizes(balance, points, measure)
        ratios = sizes.max(axis=0) / np.maximum(own.max(axis=0), np.finfo(float).tiny)
        output = int(np.argmax(np.where(own.max(axis=0) > 0.0, ratios, 0.0)))
        if ratios[output] > HIGHER:
            highest = balance.hertz(points[int(np.argmax(sizes[:, output]))].point.omega)
            enters, begins = (balance.hertz(omega) for omega in (points[0].point.omega, begin))
            return (
                f"Another motion enters the band at {enters:.6g} Hz, with {ratios[output]:.3g} times the highest "
                f"{balance.problem.output_names[output]} of this curve, at {highest:.6g} Hz. Which one occurs depends on "
                f"how the vibration starts: repeat the run with a band that starts at {begins:.4g} Hz."
            )
    return ""


def _entering(
    balance: HarmonicBalance, curve: Curve, edge: CurvePoint, far: CurvePoint, beyond: Sequence[float]
) -> Iterator[tuple[float, list[CurvePoint]]]:
    """The curves that enter the band through an edge: ω in rad/s at which each begins, and its points inside, that at the edge
    first. The one from nearby is not followed where that from farther away leads through its first point."""
    near, away = (solve_cold(balance, factor * edge.point.omega, curve.level) for factor in beyond)
    farther, through = _inside(balance, curve, edge, far, away, near)
    found = [(near, farther)] if through else [(near, _inside(balance, curve, edge, far, near)[0]), (away, farther)]
    yield from ((first.evaluation.point.omega, points) for first, points in found if points)


def _inside(
    balance: HarmonicBalance,
    curve: Curve,
    edge: CurvePoint,
    far: CurvePoint,
    first: Correction,
    between: Correction | None = None,
) -> tuple[list[CurvePoint], bool]:
    """The points inside the band of the curve from a motion outside, and whether it led through another motion to the edge.

    None where it is the curve itself that it meets at the edge, which it may pass several times, and where it cannot be followed
    with what may be spent.
    """
    if not first.converged:
        return [], False
    left = max(LEAST_SPENT, SHARE * sum(float(point.iterations) * point.active**3 for point in curve.points))
    inside: list[CurvePoint] = []
    through, omega = False, edge.point.omega
    low, high = sorted((omega, far.point.omega))
    try:
        for before, point in pairwise(trace(balance, first, "omega", far.point.omega, StepControl(points=MOST_POINTS))):
            left -= max(point.iterations, 1.0) * float(point.active) ** 3
            if between is not None and between.converged and not inside:
                through = through or _passes(balance, before, point, between.evaluation)
            if not inside and (before.point.omega - omega) * (point.point.omega - omega) < 0.0:
                inside.append(solve_at(balance, before, point, "omega", omega))
                if any(_same(inside[0].evaluation, each.evaluation) for each in curve.points if each.point.omega == omega):
                    return [], through
            if inside and low <= point.point.omega <= high:
                inside.append(point)
            if left < 0.0:
                break
    except LostCurveError:
        pass
    return inside, through and len(inside) > 0


def _passes(balance: HarmonicBalance, before: CurvePoint, point: CurvePoint, motion: Evaluation) -> bool:
    """Whether a step passes a motion."""
    omega = motion.point.omega
    if (before.point.omega - omega) * (point.point.omega - omega) >= 0.0:
        return False
    with suppress(LostCurveError):
        return _same(solve_at(balance, before, point, "omega", omega).evaluation, motion)
    return False


def _same(one: Evaluation, other: Evaluation) -> bool:
    """Whether two solutions at one frequency are one motion."""
    a, b = one.w[:, 1:], other.w[:, 1:]
    return float(np.linalg.norm(a - b)) <= NEAR * float(np.linalg.norm(b))


def _sizes(balance: HarmonicBalance, points: tuple[CurvePoint, ...] | list[CurvePoint], measure: Measure) -> Array:
    """The measure of every output, (points, outputs)."""
    outputs = range(balance.rows, balance.rows + len(balance.problem.outputs))
    return np.array([[measure.size(point.evaluation.w[row], point.point.omega) for row in outputs] for point in points])
