"""Detached curves of a force level, sought along the force level: at a few frequencies of the band the level is an unknown.

At a fixed frequency the motions of all force levels form an S-curve: from rest it rises, falls back at a fold and rises again
where one level has several motions. Wherever it crosses the level of a swept curve there is a motion of that level; one that no
known curve passes begins another curve. The amplitude that a level can hold is bounded: with passive contacts and
D = ½(C + Cᵀ) ≥ 0 the power that damping takes, ½ ω² Σ h² X_hᴴ D X_h, is no more than that of the force, ½ F ω Im(fᴴ X_1). Where
f = D g and an output is c = D d, X_1 lies in a ball about F g/(2 i ω), and

    |cᵀ X_1| ≤ F/(2 ω) (|dᵀ f| + √(dᵀ c) √(gᴴ f)).

An S-curve beyond the bound may still come back: that is where a search ends, and no proof.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.further_curves import SolvedCurve
from stickslip.analyses.isolated import Isolated
from stickslip.model.loads import excited_harmonics
from stickslip.model.problem import Problem
from stickslip.model.problem.contraction import contracts
from stickslip.model.problem.problem import HELD_ALONE
from stickslip.solve.balance.balance import Evaluation
from stickslip.solve.continuation.continuation import solve_cold, trace
from stickslip.solve.continuation.curve_points import CurvePoint, LostCurveError, solve_at
from stickslip.solve.continuation.more_harmonics import resolved
from stickslip.solve.continuation.steps import StepControl
from stickslip.solve.curves.curve import Curve
from stickslip.support.checks import SMALLEST, Array, counted

FREQUENCIES = 4
"""Frequencies evenly inside the band, and as many more beside the lowest fold."""

BEGIN, END = 0.02, 100.0
"""Force levels where an S-curve begins and ends, relative to that of the swept curve."""

REACH = 8.0
"""Level of a fold, relative to that of the swept curve, up to which more frequencies are tried beside it: a curve that is as
narrow as the distance of two frequencies has its fold a few times higher there."""

NARROWEST = 0.01
"""Share of the band below which the distance of two frequencies is not halved."""

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
        return "friction and damping leave one motion"
    if excited_harmonics(problem.forces) != {1}:
        return "the force acts in other harmonics than the first"
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

    def search(self) -> None:
        """S-curves evenly inside the band, and beside the lowest fold until another curve is found there."""
        low, high = self.curve.band
        for omega in np.linspace(low, high, FREQUENCIES + 2)[1:-1]:
            self._add(float(omega))
        for _ in range(FREQUENCIES):
            between = self._beside_lowest_fold()
            if self.isolated.found or between is None:
                return
            self._add(between)

    def _add(self, omega: float) -> None:
        """The S-curve of a frequency, unless nothing is left to spend."""
        if self.left <= 0:
            return
        levels: list[float] = []
        try:
            levels.extend(self._levels(omega))
        except LostCurveError:
            self.lost.append(omega)
        turns = [level for before, level, after in zip(levels, levels[1:], levels[2:], strict=False) if before > level <= after]
        self.fold[omega] = min((turn for turn in turns if turn > abs(self.curve.level)), default=np.inf)

    def _levels(self, omega: float) -> Iterator[float]:
        """The force levels along an S-curve, whose motions of the swept curve's level are taken on the way."""
        level = self.curve.level
        balance = self.curve.balance.with_harmonics(min(HARMONICS, self.curve.balance.highest))
        first = solve_cold(balance, omega, BEGIN * level)
        if not first.converged:
            raise LostCurveError("No motion of a small force level was found.")
        most = sustained(balance.problem, omega * balance.periods, abs(level))
        before: CurvePoint | None = None
        for point in trace(balance, first, "level", END * level, StepControl(points=self.left)):
            self.left -= 1
            yield abs(point.point.level)
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
        reach = f"{'the largest vibration that damping lets it sustain or ' if bounded else ''}{END:g} times this level"
        found = self.isolated.found
        led = f"{counted(len(found), 'curve')} apart from the sweep" if found else "no motion that the sweep does not pass"
        short = f" At {self._hertz(self.lost)} the search ended before." if self.lost else ""
        return f"Detached curves were sought at {self._hertz(list(self.fold))}, up to {reach}: {led} was met.{short}"

    def _hertz(self, omegas: list[float]) -> str:
        return f"{', '.join(f'{self.curve.balance.hertz(omega):.5g}' for omega in sorted(set(omegas)))} Hz"

    def _beside_lowest_fold(self) -> float | None:
        """The middle between the frequency of the lowest fold and its farther neighbour; None where no fold is near the level."""
        low, high = self.curve.band
        known = sorted(self.fold)
        lowest = min(known, key=lambda omega: self.fold[omega], default=None)
        if lowest is None or self.fold[lowest] >= REACH * abs(self.curve.level):
            return None
        place = known.index(lowest)
        ends = [known[place - 1] if place else low, known[place + 1] if place + 1 < len(known) else high]
        wide = [end for end in ends if abs(end - lowest) > NARROWEST * (high - low)]
        beside = max(wide, key=lambda omega: abs(omega - lowest), default=None)
        return None if beside is None else 0.5 * (lowest + beside)


def searched(curve: SolvedCurve) -> tuple[list[Curve], str]:
    """The curves of the level of a swept one that lie apart from it, and what was searched, as a sentence."""
    isolated = Isolated(curve)
    each = POINTS if curve.balance.rows <= FEW_ROWS else POINTS_OF_MANY
    search = LevelCurves(curve, isolated, int(each * len(curve.points)))
    search.search()
    return isolated.curves, search.sentence
