"""Solver states of a forced response, restored from its dataset."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from stickslip.analyses.contact_rows import ContactRows
from stickslip.model.problem import Problem
from stickslip.model.problem.truncation import on_few_coordinates
from stickslip.results.view import periods_of
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.balance.fourier import real_harmonics
from stickslip.solve.balance.orders import of_attribute
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.support.checks import SMALLEST, Array, fault, whole
from stickslip.support.late import xr
from stickslip.support.outcome import Outcome

KEPT = ("outcome", "frequency", "force_level", "response", "contact_force", "contact_motion")
"""The variables of a dataset that a point is made of, and is known again by."""

ROUNDINGS = 8.0
"""How many roundings the stored forces of a point may have gone through."""

MISMATCH = 1e-6
"""How far a kept point may miss the balance and its own motion. Those of a finite-element blade miss them by 1e-14; by 6e-11
where another processor reduced it; by 1e-4 where a friction coefficient differs by a thousandth."""

AMPLIFIED = 1e-5
"""How far Newton's method may take the motion of a kept point, where a resonance of little damping amplifies rounding."""

REMEDY = (
    "The results are of another problem: give the one that made them (of a study, dataset.attrs['study']; of a sample, with its "
    "start state), or run this one."
)


class SolvedPoints:
    """The converged points of a dataset; `balance`: the one that solved them.

    Whether they belong to `problem` is checked with the points themselves: the stored motion must solve its balance.
    """

    def __init__(self, dataset: xr.Dataset, problem: Problem) -> None:
        for what, own in (("contact", [contact.name for contact in problem.contacts]), ("output", list(problem.output_names))):
            kept = [str(name) for name in dataset[what].to_numpy()]
            if kept != own:
                raise fault(f"The {what}s of the problem", f"must be those of the results, {kept}", own, REMEDY)
        if "modes_to" in dataset.attrs:
            problem = on_few_coordinates(problem, 0.0, float(dataset.attrs["modes_to"]))
        self.problem = problem
        self.kept = {name: dataset[name].to_numpy() for name in KEPT}
        self.rows = ContactRows(problem)
        harmonics, samples = of_attribute(dataset.attrs["harmonics"]), int(dataset.attrs["samples"])
        self.balance = HarmonicBalance(problem, harmonics, samples, periods_of(dataset))

    def evaluation(self, case: int, point: int) -> Evaluation:
        """A point of the balance; refused where it is the solution of another problem."""
        place = self._place(case, point)
        motion = self._rows(self.kept["contact_motion"][place])
        # λ, what contacts carry beyond the springs of the stuck ones.
        forces = self._rows(self.kept["contact_force"][place]) - self.balance.stiffness[:, None] * motion
        omega, level = self.omega(self.kept["frequency"][place]), float(self.kept["force_level"][place[0]])
        found = self.balance.evaluate(Point(forces, omega, level))
        known = np.concatenate([motion, _real(self.kept["response"][place])])
        missed = max(found.error, _apart(found.w, known), _apart(found.w[:, 1:], known[:, 1:]))
        if not missed <= MISMATCH and not missed <= self._rounding(found, motion) and not self._returns(found, known):
            what = f"The share by which point {place[1]} of case {place[0]} misses the balance of the problem"
            raise fault(what, f"must be at most {MISMATCH:g}", float(f"{missed:.3g}"), REMEDY)
        return found

    def _rounding(self, found: Evaluation, motion: Array) -> float:
        """What rounding of the stored forces and motions may change of a motion: much near a resonance of very little damping."""
        spread = ROUNDINGS * np.finfo(float).eps
        forces = found.point.forces + spread * (np.abs(found.point.forces) + np.abs(self.balance.stiffness[:, None] * motion))
        return _apart(self.balance.evaluate(replace(found.point, forces=forces)).w, found.w)

    def _returns(self, found: Evaluation, known: Array) -> bool:
        """Whether Newton's method solves the balance beside a kept point."""
        solved = correct(self.balance, found.point, fixed("omega", found.point.omega))
        w = solved.evaluation.w
        return solved.converged and max(_apart(w, known), _apart(w[:, 1:], known[:, 1:])) <= AMPLIFIED

    def at_one_speed(self, case: int, point: int) -> tuple[HarmonicBalance, Evaluation]:
        """A point with the balance of the rotor speed it is at, or with that of all where the problem has no `speed`."""
        balance, found = self.balance, self.evaluation(case, point)
        if balance.problem.speed is None:
            return balance, found
        one = balance.problem.at_frequency(found.point.omega)
        alone = HarmonicBalance(one, balance.harmonics, balance.tables.E.shape[0])
        return alone, alone.evaluate(found.point)

    def omega(self, frequency: Any) -> float:
        """ω of the balance, rad/s, at a frequency of the excitation, Hz."""
        return 2.0 * np.pi * float(frequency) / self.balance.periods

    def point(self, case: int, point: int) -> Point:
        """λ with frequency and force level."""
        return self.evaluation(case, point).point

    def converged(self, case: int) -> list[Point]:
        """All converged points of a case, in the order of travel."""
        return [self.point(case, int(k)) for k in np.flatnonzero(self.kept["outcome"][case] == Outcome.CONVERGED)]

    def contact_motion(self, case: int, point: int) -> Array:
        """Relative displacement of every contact row, (rows, 2H+1), m."""
        return self.evaluation(case, point).w[: self.balance.rows]

    def whole_motion(self, case: int, point: int) -> Array:
        """Displacement of every degree of freedom, (n, 2H+1), m."""
        solved = self.point(case, point)
        y = self.balance.linear.whole_motion(solved.forces, solved.omega, solved.level)
        return self.balance.problem.structure.motion(y)

    def _place(self, case: int, point: int) -> tuple[int, int]:
        """The two numbers, checked."""
        outcomes = self.kept["outcome"]
        for name, number, size in zip(("case", "point"), (case, point), outcomes.shape, strict=True):
            if not 0 <= whole(name, number) < size:
                raise fault(name, f"must be a whole number from 0 to {size - 1}", number)
        outcome = Outcome(int(outcomes[case, point]))
        if outcome != Outcome.CONVERGED:
            raise fault(f"Point {point} of case {case}", "must have converged", outcome.sentence)
        return int(case), int(point)

    def _rows(self, parts: Array) -> Array:
        """Real storage (rows, 2H+1) from (contact, direction, harmonic, part)."""
        return _real(self.rows.collected(parts))


def _apart(found: Array, known: Array) -> float:
    """How far two motions are apart, relative to the known one."""
    return float(np.linalg.norm(found - known)) / max(float(np.linalg.norm(known)), SMALLEST)


def _real(parts: Array) -> Array:
    """Real storage (..., 2H+1) of (..., harmonic, part)."""
    return real_harmonics(parts[..., 0] + 1j * parts[..., 1])
