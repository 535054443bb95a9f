"""Isolas, closed curves that the swept one does not meet, from nonlinear modes and from other force levels.

A sweep follows the curve that it begins on. Where the force that a mode needs in resonance falls with the amplitude, one force
level has several resonance peaks, and those above the first may lie on a curve of their own. A motion over p periods of the
excitation meets a mode whose frequency is that of the excitation over p.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.contact_rows import ContactRows
from stickslip.analyses.further_curves import SolvedCurve, passes
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, PathCondition, Point
from stickslip.solve.balance.fourier import real_harmonics
from stickslip.solve.continuation.continuation import trace
from stickslip.solve.continuation.curve_points import LostCurveError, Tangent
from stickslip.solve.continuation.more_harmonics import pad
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.continuation.steps import StepControl
from stickslip.solve.continuation.two_ways import Followed, followed_both_ways
from stickslip.solve.curves.curve import Curve
from stickslip.support.checks import Array

if TYPE_CHECKING:
    import xarray as xr

PLACES = 16
"""Points of a mode from which subharmonic motions are sought."""

RAMPS = 40
"""Points of another force level's curve from which the level is changed."""

PHASES = 6
"""Phases of a subharmonic motion that are tried within a period of the excitation."""

RAMP = StepControl(points=200)
"""Steps in the force level to a neighbouring one."""

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
    def of(cls, balance: HarmonicBalance, modes: xr.Dataset, case: int) -> ModeMotions:
        """A case of the dataset of modes; the balance knows the problem."""
        rows = ContactRows(balance.problem)
        good = np.flatnonzero(np.isfinite(modes["frequency"].values[case]))
        chosen = modes.isel(case=case, point=good)
        carried, moved = (
            np.array([rows.collected(each) for each in _complex(chosen[name])]).reshape(good.size, balance.rows, -1)
            for name in ("contact_force", "contact_motion")
        )
        motion = np.concatenate([moved, _complex(chosen["response"])], axis=1)
        force = carried - balance.stiffness[:, None] * moved
        load = balance.problem.load_powers(max(h for each in balance.problem.forces for h in each.factors))[0]
        first = balance.first
        driven = load[:, first.start] - 1j * load[:, first.start + 1]
        phase = np.angle(-1j * (_complex(chosen["mode_shape"]).conj() @ driven))
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


def _complex(array: xr.DataArray) -> NDArray[np.complex128]:
    parts = array.transpose(..., "part").to_numpy()
    return np.asarray(parts[..., 0] + 1j * parts[..., 1])


def isolated_curves(curve: SolvedCurve, modes: Sequence[xr.Dataset], others: Sequence[SolvedCurve]) -> tuple[list[Curve], int]:
    """The curves of a force level that its swept curve does not meet, and from how many starts they were sought.

    modes: datasets of nonlinear modes of the problem; others: swept curves of other force levels.
    """
    found: list[Followed] = []
    tried = 0
    for evaluation in _solutions(curve, modes, others):
        tried += 1
        if evaluation is None or not curve.band[0] <= evaluation.point.omega <= curve.band[1]:
            continue
        if curve.balance.periods > 1 and not _subharmonic(curve.balance, evaluation):
            continue
        if curve.meets(evaluation) or any(passes(curve.balance, each.points, evaluation) for each in found):
            continue
        found.append(_followed(curve, evaluation))
    return [curve.followed(each, _kind_of(curve, each)) for each in found], tried


def _kind_of(curve: SolvedCurve, found: Followed) -> str:
    """What a curve is, as the beginning of a sentence; an open one may be the rest of the sweep, outside the band."""
    if curve.balance.periods > 1:
        return "A subharmonic curve"
    if found.closed or found.lost is not None:
        return "An isolated curve"
    return "A curve that the sweep does not meet in this band, though it may in a wider one"


def _solutions(curve: SolvedCurve, modes: Sequence[xr.Dataset], others: Sequence[SolvedCurve]) -> Iterator[Evaluation | None]:
    """What Newton's method makes of every start; None where it fails."""
    for dataset in modes:
        for case in range(dataset.sizes["case"]):
            for start in _mode_starts(curve, ModeMotions.of(curve.balance, dataset, case)):
                yield _corrected(curve.balance, start)
    for other in others:
        yield from _from_level(curve, other)


def _mode_starts(curve: SolvedCurve, mode: ModeMotions) -> Iterator[Start]:
    """Resonance peaks of a force level on a mode; for motions over several periods all amplitudes, in several phases."""
    balance, level = curve.balance, curve.level
    if balance.periods == 1:
        beyond = mode.level - level
        for crossed in np.flatnonzero(beyond[1:] * beyond[:-1] < 0.0):
            k = int(crossed)
            share = beyond[k] / (beyond[k] - beyond[k + 1])
            yield mode.start(balance, k + float(share), float(mode.phase[k]), level)
        return
    inside = np.flatnonzero((mode.omega >= curve.band[0]) & (mode.omega <= curve.band[1]))
    for k in sorted({int(inside[round(k)]) for k in np.linspace(0, inside.size - 1, min(inside.size, PLACES))}):
        for turn in range(PHASES):
            yield mode.start(balance, float(k), 2.0 * np.pi * turn / (PHASES * balance.periods), level)


def _along(curve: SolvedCurve) -> list[int]:
    """Points spread evenly over the frequency and the logarithm of the motion."""
    if not curve.points:
        return []
    omega = np.array([point.point.omega for point in curve.points])
    sizes = np.array([np.linalg.norm(point.evaluation.w[:, 1:]) for point in curve.points])
    steps = 10.0 * np.abs(np.diff(omega)) / (curve.band[1] - curve.band[0]) + np.abs(np.diff(np.log(sizes)))
    along = np.concatenate([[0.0], np.cumsum(steps)])
    return sorted({int(k) for k in np.searchsorted(along, np.linspace(0.0, along[-1], RAMPS))})


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


def _from_level(curve: SolvedCurve, other: SolvedCurve) -> Iterator[Evaluation | None]:
    """Points of another level's curve, followed in the force level at their frequencies."""
    balance = curve.balance
    for k in _along(other):
        point = other.points[k].point
        first = correct(balance, point, fixed("level", point.level))
        try:
            *_, last = trace(balance, first, "level", curve.level, RAMP)
        except LostCurveError:
            yield None
            continue
        yield last.evaluation


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
