"""Isolas, closed curves that the swept one does not meet, and what of nonlinear modes leads to them.

A sweep follows the curve that it begins on. Where the force that a mode needs in resonance falls with the amplitude, one force
level has several resonance peaks, and those above the first may lie on a curve of their own. A motion over p periods of the
excitation meets a mode whose frequency is that of the excitation over p.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.further_curves import SolvedCurve, passes
from stickslip.analyses.response_dataset import ContactRows
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, PathCondition, Point
from stickslip.solve.balance.fourier import real_harmonics
from stickslip.solve.continuation.curve_points import CurvePoint, Tangent
from stickslip.solve.continuation.more_harmonics import pad
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.continuation.two_ways import Followed, followed_both_ways
from stickslip.solve.curves.curve import Curve
from stickslip.support.checks import Array
from stickslip.support.late import xr

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


def _kind_of(curve: SolvedCurve, found: Followed) -> str:
    """What a curve is, as the beginning of a sentence; an open one may be the rest of the sweep, outside the band."""
    if curve.balance.periods > 1:
        return "A subharmonic curve"
    if found.closed or found.lost is not None:
        return "An isolated curve"
    return "A curve that the sweep does not meet in this band, though it may in a wider one"


def take_from_modes(isolated: Isolated, modes: Sequence[xr.Dataset]) -> int:
    """Take what Newton's method makes of the motions of nonlinear modes of the problem; how many starts there were."""
    tried = 0
    for dataset in modes:
        for case in range(dataset.sizes["case"]):
            for start in _mode_starts(isolated.curve, ModeMotions.of(isolated.curve.balance, dataset, case)):
                isolated.take(_corrected(isolated.curve.balance, start))
                tried += 1
    return tried


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
