"""Least squares between a damper model and measured cycles: misfit, search of the whole range, error on loops held out.

The computed cycle is smoothed to the harmonics of the measured one. Gains of the channels are unknown, with a prior, the same in
all cases; so is the lag of the forces behind the motions, and so are the zeros of the cells, one a case; lasers have no zero. All
are solved for inside the misfit.

Intervals from refits: cycles resampled, errors of the rig drawn, the misfit turned about, contacts with and without gaps.

Each refit begins where the loops themselves led, in turn where they led to several minima. Refits that find no way down although
they see one, and cycles that are missing, are counted.

What is unknown of a damper, and the contact laws of its lines, each with the same total stiffness and friction.

macroslip   one slider a line
iwan        equal springs and loads, limits that fall as the half ellipse of a cylinder on a flat
microslip   equal elements with gaps from 0 to 2 g N/kn, N the pull shared over the lines; the unknown `gaps` is g
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, Self

import numpy as np
from scipy.optimize import Bounds, differential_evolution

from stickslip.laboratory.identification.contact_law.fit import half_ellipse
from stickslip.laboratory.identification.least_squares import LeastSquares, Solution
from stickslip.laboratory.measurement.cycles import CycleSet, analysis, delayed, synthesis
from stickslip.laboratory.measurement.reconstruction import SIGNALS, RigErrors, distorted
from stickslip.model.contact.law import LoadDependentFriction, line_of
from stickslip.model.dampers.between_platforms import BetweenPlatforms
from stickslip.solve.platforms.relaxation import Elements, elements_of, relaxed_cycle
from stickslip.support.checks import Array, InputError, fault

PARTS = ("kt", "kn", "mu")
TENFOLD = "tenfold"
"""The unknown factor of all coefficients of friction from a normal load to one ten times as large: μ ∝ N^e, e its log10."""
BOUNDS = {"kt": (2e6, 1e9), "kn": (2e6, 2e9), "mu": (0.02, 1.2), "gaps": (0.02, 2.0), TENFOLD: (0.25, 4.0)}
"""Range in which an unknown is looked for, N/m and 1, unless given."""

LOADS = np.geomspace(1.0 / 30.0, 10.0, 16)
"""Loads, as shares of the middle one, between which the slip limit of a power of the load is straight: exact to 0.3 %."""

IWAN_ELEMENTS, GAP_ELEMENTS = 10, 5
"""Jenkins elements of a contact line: of an Iwan law, and one behind the other where gaps open in turn."""

Values = Mapping[str, Array]
"""kt, kn, mu and gaps of every line, (lines,)."""


@dataclass(frozen=True)
class Parameter:
    """An unknown: its name (kt, kn or mu, then _ and how the names of its lines begin: mu_L1, mu_L, kt; or tenfold), and its
    bounds."""

    name: str
    low: float
    high: float

    @property
    def part(self) -> str:
        """kt, kn or mu."""
        return self.name.split("_")[0]

    def lines(self, names: Sequence[str]) -> list[int]:
        """Which lines of contact it belongs to."""
        start = self.name.partition("_")[2]
        return [i for i, name in enumerate(names) if name.startswith(start)]


def parameters(names: Sequence[str], rig: BetweenPlatforms, bounds: Mapping[str, tuple[float, float]]) -> tuple[Parameter, ...]:
    """The unknowns by name, checked."""
    lines, found = [point.name for point in rig.points], []
    for name in names:
        part = name.split("_")[0]
        if part not in PARTS and name != TENFOLD:
            raise fault("unknown", f"must begin with kt, kn or mu, or be {TENFOLD}", name)
        low, high = bounds.get(name, BOUNDS[part])
        if not 0.0 < low < high:
            raise fault(f"Bounds of {name}", "must be positive and ascending", (low, high))
        one = Parameter(name, low, high)
        if not one.lines(lines):
            raise fault("unknown", f"must name lines of contact among {', '.join(lines)}", name)
        found.append(one)
    if not found or len({p.name for p in found}) < len(found):
        raise fault("unknown", "must be at least one, each once", list(names))
    return tuple(found)


def usual_unknowns(damper: BetweenPlatforms) -> tuple[str, ...]:
    """kt, kn, and friction of every line at a side of one or two lines, of the whole side where there are more."""
    found = ["kt", "kn"]
    for side in ("left", "right"):
        lines = [point.name for point in damper.points if point.side == side]
        found += [f"mu_{name}" for name in (lines if len(lines) <= 2 else [side[0].upper()])]
    return tuple(found)


def macroslip(elements: Elements, values: Values, load: float) -> Elements:
    """One element a line."""
    return elements._replace(kt=values["kt"], kn=values["kn"], mu=values["mu"])


def iwan(elements: Elements, values: Values, load: float) -> Elements:
    """Elements that slip one after the other under any load."""
    parts = _parted(elements, values, IWAN_ELEMENTS)
    return parts._replace(mu=parts.mu * np.tile(half_ellipse(IWAN_ELEMENTS), values["mu"].size))


def microslip(elements: Elements, values: Values, load: float, count: int = GAP_ELEMENTS) -> Elements:
    """Elements that close one after the other; load: of a line, N."""
    gaps = 2.0 * load * np.outer(values["gaps"], np.linspace(0.0, 1.0, count))
    return _parted(elements, values, count)._replace(constant=-gaps.ravel() / count)


def over_load(elements: Elements, tenfold: float, at: float) -> Elements:
    """Elements whose mu holds at a normal load `at` [N] of their line, and changes by a factor with a load ten times as large."""
    parts = elements.line.size / elements.arm.shape[0]
    line = line_of(LoadDependentFriction(tuple(at * LOADS), tuple(tenfold ** np.log10(LOADS))))
    return elements._replace(mu=line.slope * elements.mu, bend=line.loads / parts, change=line.changes)


def _parted(elements: Elements, values: Values, count: int) -> Elements:
    """Every line in so many equal parts."""
    kt, kn, mu = (np.repeat(values[part], count) for part in ("kt", "kn", "mu"))
    line = np.repeat(np.arange(values["kt"].size), count)
    return elements._replace(line=line, kt=kt / count, kn=kn / count, mu=mu, constant=np.zeros(line.size))


LINE_LAWS: dict[str, tuple[Callable[[Elements, Values, float], Elements], tuple[str, ...]]] = {
    "macroslip": (macroslip, ()),
    "iwan": (iwan, ()),
    "microslip": (microslip, ("gaps",)),
}
"""Of each law, the simplest first: its elements, and what it has unknown beside kt, kn and mu."""


FLOOR = {"force": 0.12, "rotation": 8e-6, "damper": 0.06e-6}
"""Standard deviation of one harmonic's amplitude that no model of a rig is held to: N, rad, m."""

COLUMNS = {"force_x": 0, "force_y": 1, "damper_y": 3, "rotation": 4}
"""Where a computed cycle holds each channel."""

LAYERS = 3
"""Parallel elements of a contact with gaps."""

NOISE = 2.2
"""A harmonic of the platform's motion is noise below so many standard errors of its mean (one in a hundred stays)."""

UNSOLVED = 1e3
"""Residual where no steady cycle was found."""

LAG_ROUNDS, SAME_LAG = 8, 1e-8
"""Newton's steps for the lag, and the change [s] at which they end."""

MOST_LAG = 0.08
"""Share of the shortest period within which the lag is looked for."""

COARSE = 120
"""Steps a cycle in the search, and in refits where they are enough."""

WIDE, NARROW = 5e-3, 5e-4
"""Steps of the logarithms for derivatives: wide in the search, since the cost has kinks where a contact begins to slip or to lift
off, and narrow at its end. Near lift-off there are many, and narrow ones alone lead to the next best."""

EVALUATIONS = 20
"""Of a search from one start, at most."""

STARTS = 8
"""Members of the population from which least squares begin, until the smallest sum of squares is found twice."""

AGAIN, NEXT_TO_NOTHING = 0.02, 0.1
"""Relative and absolute difference of sums of squares from which they count as one."""

ALIKE = 4.0
"""Sums of squares are divided by this to weigh how likely gaps are: errors of neighbouring harmonics are alike. Minima whose sums
differ by less are about as good."""

FIRST_GAPS = 0.3
"""Where the search of a microslip law begins."""


@dataclass(frozen=True, eq=False)
class MeasuringChain:
    """What cells and lasers do to signals: gain errors (channels,), and the lag of the forces behind the motions [s]."""

    gains: Array
    lag: float


@dataclass(frozen=True, eq=False)
class DamperFit(LeastSquares):
    """Measured cases, the model of each, and the unknowns. Data (cases, channels, 2H+1) are kept apart from the model, so
    that resampled ones can be put in their place. at [N]: the load of a line at which mu holds where it depends on
    the load, the pulls' geometric mean shared over the lines. law: of every line. gaps: above 0, every contact is three
    parallel elements with gaps so wide: what a microslip law in place of macroslip changes. tally: cycles that were computed with
    this fit and its copies, and those of them that never became steady."""

    cases: tuple[CycleSet, ...]
    elements: Elements
    pulls: tuple[float, ...]
    drives: tuple[Array, ...]
    unknowns: tuple[Parameter, ...]
    lines: tuple[str, ...]
    channels: tuple[str, ...]
    data: Array
    spread: Array
    errors: RigErrors
    at: float = 1.0
    law: str = "macroslip"
    gaps: float = 0.0
    step: float = WIDE
    tally: list[int] = field(default_factory=lambda: [0, 0])

    stops = MappingProxyType({"x_scale": 0.1, "ftol": 1e-3, "xtol": 1e-4})

    @classmethod
    def of(
        cls, cases: Sequence[CycleSet], rig: BetweenPlatforms, unknowns: tuple[Parameter, ...], errors: RigErrors, steps: int
    ) -> Self:
        """The fit of cases to a damper with macroslip contacts, marched in so many steps a cycle."""
        if any(len(law.elements(1, True).friction[0].stiffness) != 1 for law in rig.laws):
            raise InputError(
                "Every law of the damper must be macroslip, as a frame for the fit. The law that is fitted is named apart."
            )
        channels = tuple(name for name in SIGNALS if all(case.has(name) for case in cases))
        pulls = tuple(float(rig.pull[1]) if case.pull is None else case.pull for case in cases)
        data = np.stack([[case.channel(name) for name in channels] for case in cases])
        noise = np.stack([[case.standard_error[case.channels.index(name)] for name in channels] for case in cases])
        floor = np.array([FLOOR[name.split("_")[0]] for name in channels])
        spread = np.sqrt(floor[:, None] ** 2 + noise**2)
        for c, name in enumerate(channels):
            zeros = [errors.with_zeros(case.zero_errors).zero_of(name) if name.startswith("force") else np.inf for case in cases]
            spread[:, c, 0] = np.hypot(spread[:, c, 0], zeros)
        names = tuple(point.name for point in rig.points)
        drives = tuple(_drive(case, steps) for case in cases)
        at = float(np.exp(np.mean(np.log(pulls)))) / len(names)
        return cls(tuple(cases), elements_of(rig), pulls, drives, unknowns, names, channels, data, spread, errors, at)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Of the logarithms of the unknowns."""
        return np.log([p.low for p in self.unknowns]), np.log([p.high for p in self.unknowns])

    def steps(self, count: int) -> Self:
        """A copy marched in so many steps a cycle."""
        drives = tuple(_drive(case, count) for case in self.cases)
        return replace(self, drives=drives)

    def with_cases(self, cases: Sequence[CycleSet], data: Array) -> Self:
        """A copy driven by other cycles of the same cases, with other data (cases, channels, 2H+1)."""
        drives = tuple(_drive(case, drive.shape[0]) for case, drive in zip(cases, self.drives, strict=True))
        return replace(self, cases=tuple(cases), drives=drives, data=data)

    def with_lag(self, prior: float) -> Self:
        """A copy whose forces lag behind the motions with this standard deviation [s]; 0: not at all."""
        return replace(self, errors=replace(self.errors, lag=prior))

    def with_law(self, law: str) -> Self:
        """A copy whose lines follow another law, with what that has unknown."""
        own = tuple(Parameter(name, *BOUNDS[name]) for name in LINE_LAWS[law][1])
        return replace(self, law=law, unknowns=(*(p for p in self.unknowns if p.part in (*PARTS, TENFOLD)), *own))

    def only(self, numbers: Sequence[int]) -> Self:
        """A copy with some of the cases."""
        cases, pulls = tuple(self.cases[i] for i in numbers), tuple(self.pulls[i] for i in numbers)
        drives = tuple(self.drives[i] for i in numbers)
        return replace(self, cases=cases, pulls=pulls, drives=drives, data=self.data[numbers], spread=self.spread[numbers])

    def values(self, theta: Array) -> dict[str, Array]:
        """kt, kn, mu and gaps of every line, (lines,), from logarithms of the unknowns."""
        found = {part: np.array(getattr(self.elements, part)) for part in PARTS} | {"gaps": np.full(len(self.lines), self.gaps)}
        found[TENFOLD] = np.ones(len(self.lines))
        for p, value in sorted(zip(self.unknowns, np.exp(theta), strict=True), key=lambda pair: len(pair[0].name)):
            found[p.part][p.lines(self.lines)] = value
        return found

    def predicted(self, theta: Array) -> Array | None:
        """Harmonics (cases, channels, 2H+1) of the computed cycles; None where a case has no steady one."""
        values, load = self.values(theta), max(self.pulls) / len(self.lines)
        if self.gaps:
            elements = microslip(self.elements, values, load, LAYERS)
        else:
            elements = LINE_LAWS[self.law][0](self.elements, values, load)
        tenfold = float(values[TENFOLD][0])
        elements = elements if tenfold == 1.0 else over_load(elements, tenfold, self.at)
        found, count = [], (self.data.shape[2] - 1) // 2
        for pull, drive in zip(self.pulls, self.drives, strict=True):
            cycle = relaxed_cycle(elements, pull, drive)
            if cycle is None:
                return None
            found.append(analysis(cycle[:, [COLUMNS[name] for name in self.channels]].T, count))
        return np.asarray(found)

    @property
    def forces(self) -> list[int]:
        """Which channels are of load cells."""
        return [c for c, name in enumerate(self.channels) if name.startswith("force")]

    def late(self, computed: Array, lag: float) -> Array:
        """Computed harmonics with forces that lag behind the motions [s]."""
        found, forces = computed.copy(), self.forces
        found[:, forces] = delayed(computed[:, forces], lag * self._omega)
        return found

    def recorded(self, computed: Array, chain: MeasuringChain) -> Array:
        """Harmonics (cases, channels, 2H+1) that the measuring chain shows of computed ones."""
        return np.asarray((1.0 + chain.gains[:, None]) * self.late(computed, chain.lag))

    def zeros(self, computed: Array, chain: MeasuringChain) -> Array:
        """Zeros of the cells, (cases, forces) [N]: mean forces measured less those recorded of computed ones."""
        forces = self.forces
        return np.asarray((self.data - self.recorded(computed, chain))[:, forces, 0])

    def chain(self, computed: Array) -> MeasuringChain:
        """The most likely gains and lag. Each is found with the other held: they hardly depend on each other, for a lag changes
        every harmonic at right angles to what a gain does."""
        if not self.errors.lag:
            return MeasuringChain(self._gains(computed), 0.0)
        forces, lag, most = self.forces, 0.0, MOST_LAG * 2.0 * np.pi / float(self._omega.max())
        weight, prior = 1.0 / self.spread[:, forces] ** 2, 1.0 / self.errors.lag**2
        for _ in range(LAG_ROUNDS):
            late = self.late(computed, lag)
            gains = self._gains(late)
            shown = (1.0 + gains[forces, None]) * late[:, forces]
            slope = self._omega[..., None] * _by_angle(shown)
            missed = float(np.sum(weight * slope * (self.data[:, forces] - shown))) - prior * lag
            step = missed / (float(np.sum(weight * slope**2)) + prior)
            lag = float(np.clip(lag + step, -most, most))
            if abs(step) < SAME_LAG:
                break
        return MeasuringChain(gains, lag)

    def lag_at(self, theta: Array) -> float:
        """The lag [s] that fits best with given contacts."""
        computed = self.predicted(theta)
        return 0.0 if computed is None else self.chain(computed).lag

    @property
    def _omega(self) -> Array:
        """Angular frequency of every case, (cases, 1) [rad/s]."""
        return 2.0 * np.pi * np.array([[case.frequency] for case in self.cases])

    def _gains(self, computed: Array) -> Array:
        """The most likely gain errors of the channels, (channels,)."""
        weight = 1.0 / self.spread**2
        prior = np.array([1.0 / max(self.errors.gain(name), 1e-9) ** 2 for name in self.channels])
        above = np.sum(weight * computed * (self.data - computed), axis=(0, 2))
        return np.asarray(above / (np.sum(weight * computed**2, axis=(0, 2)) + prior))

    def residuals(self, theta: Array) -> Array:
        """Weighted differences (cases × channels × (2H+1) + channels + 1,): measured less computed with the best gains and lag;
        gains; lag."""
        computed = self.predicted(theta)
        self.tally[0] += len(self.cases)
        if computed is None:
            self.tally[1] += len(self.cases)
            return np.full(self.data.size + len(self.channels) + 1, UNSOLVED)
        chain = self.chain(computed)
        left = (self.data - self.recorded(computed, chain)) / self.spread
        scale = np.array([max(self.errors.gain(name), 1e-9) for name in self.channels])
        return np.concatenate([left.ravel(), chain.gains / scale, [chain.lag / (self.errors.lag or 1.0)]])

    def misfit(self, theta: Array, chain: MeasuringChain) -> float:
        """Root mean square of the weighted differences (cases, channels, 2H+1) with given gains and lag: 1 where errors explain
        all."""
        computed = self.predicted(theta)
        if computed is None:
            return UNSOLVED
        left = (self.data - self.recorded(computed, chain)) / self.spread
        return float(np.sqrt(np.mean(left[np.isfinite(self.spread)] ** 2)))

    def polished(self, start: Array, evaluations: int = 30, exactly: float = 1e-6) -> Array:
        """The least squares near a start, by derivatives over narrow steps."""
        return replace(self, step=NARROW).solved(start, evaluations=evaluations, xtol=exactly, ftol=1e-7).x


def _by_angle(harmonics: Array) -> Array:
    """Derivative of `delayed` harmonics (..., 2H+1) by the angle."""
    orders, found = np.arange(1, (harmonics.shape[-1] + 1) // 2), np.zeros_like(harmonics)
    found[..., 1::2], found[..., 2::2] = -orders * harmonics[..., 2::2], orders * harmonics[..., 1::2]
    return found


def _drive(case: CycleSet, steps: int) -> Array:
    """Motion of the left platform in equal steps, (steps, 2) [m]; a direction that was not recorded is at rest."""
    table, found = synthesis(steps, (case.harmonics.shape[2] - 1) // 2), np.zeros((steps, 2))
    for axis, name in enumerate(("platform_x", "platform_y")):
        if case.has(name):
            index = case.channels.index(name)
            mean, error = case.mean[index], case.standard_error[index]
            # Harmonics that do not stand out of their scatter between cycles are left out: noise would move the contacts.
            seen = mean.copy()
            power = mean[1::2] ** 2 + mean[2::2] ** 2
            lost = power <= NOISE**2 * (error[1::2] ** 2 + error[2::2] ** 2)
            seen[1::2][lost] = seen[2::2][lost] = 0.0
            found[:, axis] = table @ seen
    return found


def population(fit: DamperFit, size: int, generations: int, seed: int, report: Callable[[float], object]) -> Array:
    """A population over the whole range, the best first, (members, unknowns)."""
    low, high = fit.bounds
    seen = 0

    def height(theta: Array) -> float:
        return float(np.log1p(0.5 * fit.cost(theta)))

    def generation_done(*_: Any, **__: Any) -> None:
        nonlocal seen
        seen += 1
        report(seen / generations)

    result = differential_evolution(
        height,
        Bounds(low, high),
        popsize=size,
        maxiter=generations,
        tol=1e-3,
        init="sobol",
        polish=False,
        rng=seed,
        callback=generation_done,
    )
    return np.asarray(result.population[np.argsort(result.population_energies)])


def fitted(fit: DamperFit, starts: Array) -> tuple[Array, Array]:
    """The least sum of squares that is reached from several starts, (starts, unknowns); and all minima (count, unknowns) that are
    about as good."""

    def twice(found: Sequence[Solution]) -> bool:
        least = min(one.cost for one in found)
        return sum(one.cost <= (1.0 + AGAIN) * least + NEXT_TO_NOTHING for one in found) > 1

    reached = fit.solutions(starts[:STARTS], twice, evaluations=EVALUATIONS)
    best = reached[0].x
    if fit.predicted(best) is None:
        raise InputError(
            "No steady cycle was found for any contact parameters. Check columns, units and timing of the records, and the "
            "geometry and the pull of the damper."
        )
    others = [one.x for one in reached if one.cost <= reached[0].cost + ALIKE]
    return min((best, fit.polished(best)), key=fit.cost), np.array(others)


def fitted_with_law(fit: DamperFit, macroslip: Array) -> Array:
    """Logarithms of the unknowns of the law of a fit, from those of macroslip."""
    if fit.law == "macroslip":
        return macroslip
    start = np.concatenate([macroslip, np.full(len(fit.unknowns) - macroslip.size, np.log(FIRST_GAPS))])
    return fit.polished(fit.steps(COARSE).polished(start), 8)


def held_out(fit: DamperFit, theta: Array) -> float:
    """Error of each case with unknowns and gains fitted to the others, root mean square in standard deviations."""
    coarse, numbers, squares = fit.steps(COARSE), range(len(fit.cases)), []
    for left in numbers:
        others = coarse.only([i for i in numbers if i != left])
        found = others.polished(theta, 8, 1e-4)
        computed = others.predicted(found)
        squares.append(UNSOLVED**2 if computed is None else coarse.only([left]).misfit(found, others.chain(computed)) ** 2)
    return float(np.sqrt(np.mean(squares)))


COST = 2.0
"""By how much coarser steps may raise the sum of squares of the final fit; refits take twice as many where they do more."""

LAW_GAPS = 0.6
"""Refits of macroslip take contacts with gaps up to this: the true law is not known to be it (`DamperFit.gaps`)."""

GAP_STEPS = 5
"""Gaps with which the loops themselves are fitted, to know how likely each is."""

LOST = 0.25
"""Share of refits that found no way down from which no interval is given."""

MISSING = 0.05
"""Share of cycles without a steady state in the refits from which no interval is given."""


@dataclass(frozen=True, eq=False)
class Refits:
    """Logarithms of the unknowns (refits, unknowns), shifted to the final fit; how many more refits found no way down, and the
    cycles that were computed and those of them that are missing. Changes of the lag (refits,) [s] and of the zeros of the cells
    (refits, cases, forces) [N] from the final fit, less what was drawn of them."""

    values: Array
    lost: int
    cycles: int
    missing: int
    lags: Array
    zeros: Array

    def errors(self, theta: Array) -> tuple[Array, float, Array]:
        """Standard deviations of the unknowns (unknowns,), of the lag [s] and of the zeros (cases, forces) [N] about the final
        fit; NaN where intervals are refused."""
        if self.refusal:
            return np.full(theta.size, np.nan), float("nan"), np.full(self.zeros.shape[1:], np.nan)
        values, lag, zeros = (np.sqrt(np.mean(x**2, axis=0)) for x in (self.values - theta, self.lags, self.zeros))
        return values, float(lag), zeros

    @property
    def refusal(self) -> str:
        """Why no interval is given, a sentence; empty where intervals may be given."""
        count = len(self.values) + self.lost
        if self.lost > LOST * count:
            return (
                f"No intervals are given: {self.lost} of {count} refits to resampled cycles did not reduce the misfit, which is "
                "not smooth there. Measure other amplitudes or pulls as well."
            )
        if self.missing > MISSING * self.cycles:
            return (
                f"No intervals are given: {self.missing} of {self.cycles} cycles in the refits never became steady. Narrow "
                "`bounds`, or measure where the damper settles."
            )
        return ""

    @property
    def remark(self) -> str:
        """The note on failed refits beside the intervals."""
        if not self.lost or self.refusal:
            return ""
        return f"{self.lost} of {len(self.values) + self.lost} refits did not reduce the misfit and are not in the intervals."


def enough_steps(fit: DamperFit, theta: Array) -> DamperFit:
    """The fit with as few steps a cycle as its cost at theta allows, at most its own."""
    own, cost, count = fit.drives[0].shape[0], fit.cost(theta), COARSE
    while count < own and fit.steps(count).cost(theta) > cost + COST:
        count *= 2
    return fit.steps(count) if count < own else fit


def refits(fit: DamperFit, theta: Array, minima: Array, count: int, seed: int, report: Callable[[float], object]) -> Refits:
    """Refits to perturbed data of a final fit theta; minima (count, unknowns): others that are about as good, to begin there."""
    coarse, generator = enough_steps(fit, theta), np.random.default_rng(seed)
    base = coarse.solved(theta, evaluations=EVALUATIONS).x
    computed = coarse.predicted(base)
    assert computed is not None
    chain = coarse.chain(computed)
    zeros, left = coarse.zeros(computed, chain), fit.data - coarse.recorded(computed, chain)
    left[..., 0] = 0.0
    gaps, weights, places = likely_gaps(coarse, base)
    before, found, lags, shifts = tuple(coarse.tally), [], [], []
    for number in range(count):
        cases, data, drawn_lag, drawn_zeros = _perturbed(fit, generator)
        data += generator.normal(size=(*left.shape[:2], 1)) * left
        gap = float(generator.choice(gaps, p=weights))
        start = np.array([np.interp(gap, places[0], values) for values in places[1].T])
        start = np.clip(start + minima[number % len(minima)] - theta, *fit.bounds)
        drawn = replace(coarse.with_cases(cases, data), gaps=gap)
        one = drawn.solved(start, evaluations=EVALUATIONS)
        computed = drawn.predicted(one.x) if one.moved else None
        if computed is not None:
            again = drawn.chain(computed)
            found.append(one.x - base + theta)
            lags.append(again.lag - drawn_lag - chain.lag)
            shifts.append(drawn.zeros(computed, again) - drawn_zeros - zeros)
        report((number + 1) / count)
    values = np.array(found).reshape(-1, theta.size)
    cycles, missing = np.subtract(coarse.tally, before).tolist()
    return Refits(values, count - len(found), cycles, missing, np.array(lags), np.array(shifts).reshape(-1, *zeros.shape))


def likely_gaps(fit: DamperFit, base: Array) -> tuple[Array, Array, tuple[Array, Array]]:
    """Gaps of the contacts and how likely each is by the loops themselves; some gaps and the unknowns fitted with them.

    A law other than macroslip stays as it is."""
    if fit.law != "macroslip":
        return np.zeros(1), np.ones(1), (np.zeros(1), base[None])
    some, places, costs = np.linspace(0.0, LAW_GAPS, GAP_STEPS), [base], [fit.cost(base)]
    for gap in some[1:]:
        one = replace(fit, gaps=float(gap)).solved(places[-1], evaluations=EVALUATIONS)
        places.append(one.x)
        costs.append(one.cost)
    gaps = np.linspace(0.0, LAW_GAPS, 12 * GAP_STEPS + 1)
    cost = np.interp(gaps, some, costs)
    weights = np.exp((cost.min() - cost) / ALIKE)
    return gaps, weights / weights.sum(), (some, np.array(places))


def _perturbed(fit: DamperFit, generator: np.random.Generator) -> tuple[list[CycleSet], Array, float, Array]:
    """Resampled cycles, which also drive the model anew, and their mean harmonics with drawn systematic errors: gains, shapes and
    the lag common to all cases, zeros not. The lag and the zeros (cases, forces) that were drawn."""
    count = (fit.data.shape[2] - 1) // 2
    table, shared = synthesis(4 * count + 4, count), fit.errors.draw(generator)
    cases = [case.resampled(generator) for case in fit.cases]
    found, zeros, lag = [], [], fit.errors.lag * float(generator.normal()) if fit.errors.lag else 0.0
    for case in cases:
        fresh, rows = fit.errors.with_zeros(case.zero_errors).draw(generator), []
        for name in fit.channels:
            gain, shape, _ = shared[name]
            rows.append(analysis(distorted(table @ case.channel(name), (gain, shape, fresh[name][2])), count))
        found.append(rows)
        zeros.append([fresh[fit.channels[c]][2] for c in fit.forces])
    return cases, fit.late(np.asarray(found), lag), lag, np.array(zeros)
