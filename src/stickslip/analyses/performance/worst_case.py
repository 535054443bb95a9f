"""Worst case of one design over a range of force, uncertain friction and start states.

Operating conditions of a design: force levels, friction coefficients and start states.

Constraints of damper design: no jamming, no lift-off, bounded contact forces.

A constraint is a function of a `Trial` that is positive where it is met, of order one.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import radians, tan
from typing import ClassVar

import numpy as np

from stickslip.analyses.performance.work import resonance_band
from stickslip.analyses.variability.bounds import UPPER, BoundsWork
from stickslip.model.contact.point import remembering
from stickslip.model.problem import Problem
from stickslip.runs.cases import Report
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.energy import contact_cycle, friction_reach
from stickslip.solve.balance.fourier import Harmonics
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE, Measure
from stickslip.solve.continuation.curve_points import LostCurveError
from stickslip.solve.peaks.climb import NoPeakError, PeakSolver, SolvedPeak, followed
from stickslip.solve.peaks.continuation import PeakContinuation, swept_peaks
from stickslip.solve.starts.states import UnsolvedError
from stickslip.support.checks import Array, InputError, fault, finite, positive


@dataclass(frozen=True, eq=False)
class Trial:
    """A design at the resonance under one friction coefficient, force level and start state.

    variables: the design; friction; force: level; normal_forces: {contact: N over one period (samples,)} [N].
    """

    variables: Mapping[str, float]
    friction: float
    force: float
    normal_forces: Mapping[str, Array]


Constraint = Callable[[Trial], float]
"""Positive where it is met. One with an attribute `geometric` = True reads no normal forces: a design that breaks it is refused
before it is computed.
"""


@dataclass(frozen=True)
class NoJamming:
    """1 − μ tan α > 0: the symmetric damper leaves its platforms by itself, whatever presses them together.

    angle: the variable that holds the platform angle, or the angle itself [degrees].
    """

    angle: str | float = "angle"
    geometric: ClassVar[bool] = True

    def __call__(self, trial: Trial) -> float:
        degrees = self.angle
        if isinstance(degrees, str):
            if degrees not in trial.variables:
                known = f"Variables: {', '.join(trial.variables)}."
                raise fault("angle", "must be a variable of the design, or a number", degrees, known)
            degrees = trial.variables[degrees]
        return 1.0 - trial.friction * tan(radians(degrees))


@dataclass(frozen=True)
class NoLiftOff:
    """Every contact keeps at least `share` of its mean normal force all through the period."""

    share: float = 0.0

    def __call__(self, trial: Trial) -> float:
        least = [force.min() / max(force.mean(), np.finfo(float).tiny) for force in trial.normal_forces.values()]
        return float(min(least, default=1.0)) - self.share - 1e-12


@dataclass(frozen=True)
class LargestForce:
    """No contact point carries more than `limit` [N]."""

    limit: float

    def __post_init__(self) -> None:
        positive("limit", self.limit)

    def __call__(self, trial: Trial) -> float:
        return 1.0 - max((float(force.max()) for force in trial.normal_forces.values()), default=0.0) / self.limit


Case = tuple[float, float, int]
"""Force level, friction and start state of one case of a design."""


@dataclass(frozen=True)
class Conditions:
    """What a design has to stand: force levels ascending; friction coefficients; sampled start states and their seed; output;
    whether amplitudes count per force; harmonics and samples; whether all start states are searched in the worst case; what
    amplitudes are of. Without sampled start states contacts are virgin ones, and nothing is searched.
    """

    forces: tuple[float, ...]
    frictions: tuple[float, ...]
    starts: int
    seed: int
    output: int
    per_force: bool
    harmonics: Harmonics
    samples: int
    search: bool = False
    measure: Measure = DISPLACEMENT_AMPLITUDE


SHARE = 0.7
"""Drawn start states reach this share of the largest offset that a slider can have."""


@dataclass(frozen=True, eq=False)
class WorstCase:
    """The worst case of a design: size, as the conditions measure it, where it is, the least of each constraint (NaN where it
    was not asked), and the cases without a solved peak as (force level, friction, start); start: 0 for virgin contacts, else
    the number of the drawn state, −1 for a searched one.

    each (frictions, 3): for every friction coefficient the highest peak from virgin contacts and sampled starts, its force level,
    and the highest over all start states at that level (NaN where not searched).
    """

    size: float
    frequency: float
    force: float
    friction: float
    start: int
    margins: tuple[float, ...]
    each: Array
    failed: tuple[Case, ...] = ()


def worst_case(
    problem_of: Callable[[float], Problem],
    variables: dict[str, float],
    conditions: Conditions,
    constraints: Mapping[str, Constraint],
    report: Report = lambda fraction: None,
) -> WorstCase:
    """The highest resonance over all conditions, and the least margin of each constraint over them.

    problem_of(μ) is the problem of the design. The virgin peak is followed over the force levels for every friction coefficient;
    at each of them the sampled start states are tried from it; at the worst of them all start states are searched, if asked for.
    A design that breaks a geometric constraint is not computed.
    """
    trials = [Trial(variables, mu, conditions.forces[-1], {}) for mu in conditions.frictions]
    margins = tuple(
        min(asked(name, constraint, trial) for trial in trials) if getattr(constraint, "geometric", False) else np.nan
        for name, constraint in constraints.items()
    )
    if any(margin <= 0.0 for margin in margins):
        return WorstCase(np.inf, np.nan, np.nan, np.nan, -1, margins, np.full((len(conditions.frictions), 3), np.nan))
    search = _Search(variables, conditions, constraints)
    for k, mu in enumerate(conditions.frictions):
        report(k / len(conditions.frictions))
        search.with_friction(mu, problem_of(mu))
    if conditions.search and np.isfinite(search.size):
        search.search_all_starts(problem_of(search.place[2]))
    return search.worst()


def asked(name: str, constraint: Constraint, trial: Trial) -> float:
    """The margin of a constraint; refused unless it is a number, and where the constraint fails."""
    where = ", ".join([*(f"{key}={value:g}" for key, value in trial.variables.items()), f"friction={trial.friction:g}"])
    try:
        margin = constraint(trial)
    except InputError:
        raise
    except Exception as error:
        raise InputError(
            f"Constraint {name!r} must return a number, but raises {type(error).__name__} at {where}: {error}."
        ) from error
    return finite(f"What constraint {name!r} returns at {where}", margin)


CLOUD, BEGIN = 8, 1
"""Start states sampled for the search of the worst one, and how many of them begin it."""


def searched_peak(problem: Problem, level: float, conditions: Conditions) -> float:
    """The highest resonance over all start states, one variable per contact: the best that a search finds.

    NaN with friction discs, whose start states cannot be searched, with laws that forget theirs, and where no solution is found.
    Per force level where amplitudes count so.
    """
    if any(contact.law.couples_directions for contact in problem.contacts) or not np.all(remembering(problem.contacts)):
        return np.nan
    band = resonance_band(HarmonicBalance(problem, conditions.harmonics, conditions.samples), conditions.output)
    work = BoundsWork(
        problem,
        band,
        level,
        "peak",
        output=conditions.output,
        cloud=CLOUD,
        starts=BEGIN,
        share="contact",
        seed=conditions.seed,
        harmonics=conditions.harmonics,
        samples=conditions.samples,
        quantity=conditions.measure.name,
        measure=conditions.measure.kind,
    )
    try:
        search = work.search(0, work.balance)
        search.run(lambda fraction: None, [UPPER])
    except UnsolvedError:
        return np.nan
    found = search.best[UPPER][0]
    highest = np.nan if found is None else found.value
    return highest / level if conditions.per_force else highest


class _Search:
    def __init__(self, variables: dict[str, float], conditions: Conditions, constraints: Mapping[str, Constraint]) -> None:
        self.variables, self.conditions, self.constraints = variables, conditions, constraints
        self.size, self.place = -np.inf, (np.nan, np.nan, np.nan, -1)
        self.each = np.full((len(conditions.frictions), 3), np.nan)
        self.margins = np.full(len(constraints), np.inf)
        self.failed: list[Case] = []

    def worst(self) -> WorstCase:
        """What was found; a design without any peak is infinitely bad."""
        size = self.size if np.isfinite(self.size) else np.inf
        return WorstCase(size, *self.place, tuple(self.margins.tolist()), self.each, tuple(self.failed))

    def search_all_starts(self, problem: Problem) -> None:
        """Search all start states in the worst case, whose problem this is."""
        frequency, level, mu, _ = self.place
        found = searched_peak(problem, level, self.conditions)
        self.each[self.conditions.frictions.index(mu), 2] = found
        if found > self.size:
            self.size, self.place = found, (frequency, level, mu, -1)

    def with_friction(self, mu: float, problem: Problem) -> None:
        """All force levels and start states under one friction coefficient."""
        conditions = self.conditions
        balance = HarmonicBalance(problem, conditions.harmonics, conditions.samples)
        band = resonance_band(balance, conditions.output)
        ends = (2.0 * np.pi * band.low, 2.0 * np.pi * band.high)
        continuation = PeakContinuation(lambda level: (balance, level), ends, conditions.output, conditions.measure)
        found = continuation.follow(conditions.forces, every=max(len(conditions.forces) - 1, 1))
        for level in conditions.forces:
            highest = found.highest(level)
            if highest is None:
                self.failed += [(level, mu, start) for start in range(conditions.starts + 1)]
                continue
            virgin = highest[1].peak
            self._met(mu, level, 0, virgin, balance)
            for start in range(1, conditions.starts + 1):
                self._from_start(mu, level, start, virgin, balance, continuation.band)

    def _from_start(
        self, mu: float, level: float, start: int, virgin: SolvedPeak, balance: HarmonicBalance, band: tuple[float, float]
    ) -> None:
        """The peak from a sampled start state: every slider off its virgin place, in a direction drawn for each contact row."""
        reach, _ = friction_reach(balance.table, balance.tables, virgin.evaluation.w)
        conditions, first = self.conditions, balance.table.friction_first
        drawn = np.random.default_rng((conditions.seed, start)).choice([-1.0, 1.0], first.size - 1)
        offsets = SHARE * np.repeat(drawn, np.diff(first)) * reach
        other = balance.with_starts(offsets, kind=0)
        peak = self._climbed(other, virgin) or self._swept(other, level, band)
        if peak is None:  # no curve can be solved from end to end

            def solver_at(share: float) -> PeakSolver:
                return PeakSolver(balance.with_starts(share * offsets, kind=0), conditions.output, conditions.measure)

            peak = followed(solver_at, virgin)
        if peak is None:
            self.failed.append((level, mu, start))
        else:
            self._met(mu, level, start, peak, other)

    def _climbed(self, balance: HarmonicBalance, known: SolvedPeak) -> SolvedPeak | None:
        """The peak near a known one."""
        try:
            return PeakSolver(balance, self.conditions.output, self.conditions.measure).from_near(known.point, known.plane)
        except NoPeakError:
            return None

    def _swept(self, balance: HarmonicBalance, level: float, band: tuple[float, float]) -> SolvedPeak | None:
        """The highest peak of a full sweep, where none lies near the virgin one."""
        try:
            found = swept_peaks(balance, level, band, self.conditions.output, self.conditions.measure)[0]
        except LostCurveError:
            return None
        return max(found, key=lambda peak: peak.amplitude, default=None)

    def _met(self, mu: float, level: float, start: int, peak: SolvedPeak, balance: HarmonicBalance) -> None:
        """Take one case into account."""
        size = peak.amplitude / (level if self.conditions.per_force else 1.0)
        evaluation = peak.evaluation
        cycle = contact_cycle(evaluation.table, balance.tables, evaluation.w, evaluation.point.omega)
        normal = {
            contact.name: cycle.force[row]
            for contact, row in zip(balance.problem.contacts, balance.table.normal_row, strict=True)
            if row >= 0
        }
        trial = Trial(self.variables, mu, level, normal)
        margins = [asked(name, constraint, trial) for name, constraint in self.constraints.items()]
        self.margins = np.minimum(self.margins, margins) if margins else self.margins
        own = self.each[self.conditions.frictions.index(mu)]
        if not size <= own[0]:
            own[:2] = size, level
        if size > self.size:
            self.size, self.place = size, (peak.omega / (2.0 * np.pi), level, mu, start)
