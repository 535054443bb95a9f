"""What is unknown of a damper, and the contact laws of its lines, each with the same total stiffness and friction.

macroslip   one slider a line
iwan        equal springs and loads, limits that fall as the half ellipse of a cylinder on a flat
microslip   equal elements with gaps from 0 to 2 g N/kn, N the pull shared over the lines; the unknown `gaps` is g

Initial values of contact parameters from the loops alone: the stiffness from slopes while every contact sticks, and friction
coefficients from plateaus of T/N, where the ratio stays constant while the contact slides.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.laboratory.identification.contact_law.fit import half_ellipse
from stickslip.laboratory.measurement.cycles import CycleSet
from stickslip.laboratory.measurement.reconstruction import RigErrors, distorted, feet_loads, reconstructed
from stickslip.model.contact.law import LoadDependentFriction, line_of
from stickslip.model.dampers.between_platforms import BetweenPlatforms, PlanePoint
from stickslip.solve.platforms.relaxation import Elements
from stickslip.support.checks import Array, InputError, fault, positive

Marks = NDArray[np.bool_]

FLAT = 0.04
"""Share of the largest ratio within which a plateau stays."""

ALONE = 0.04
"""A foot touches alone where the load on the other is less than this share of the whole."""


@dataclass(frozen=True)
class Plateau:
    """A plateau of |T/N|: its level, standard deviation over the plateau, its share of the cycle, and the standard deviation of
    the level by errors of the rig (NaN where they were not drawn, or where most draws have no plateau)."""

    level: float
    scatter: float
    share: float
    error: float = np.nan


def plateau(ratio: ArrayLike, where: ArrayLike | None = None, shortest: float = 0.04) -> Plateau:
    """The highest level of |T/N| (n,) that holds for at least `shortest` of the cycle among the samples `where` (all).

    A ratio that touches its largest value only in passing has no plateau, and is refused: that contact never slides.
    """
    values = np.abs(np.asarray(ratio, dtype=float))
    allowed = np.isfinite(values) if where is None else np.isfinite(values) & np.asarray(where, dtype=bool)
    if np.count_nonzero(allowed) < shortest * values.size:
        raise fault("The stage of a plateau", f"must last {shortest:.0%} of the cycle", f"{np.mean(allowed):.1%}")
    chosen = values[allowed]
    bins = np.sort(chosen)
    width = FLAT * bins[-1]
    counts = np.searchsorted(bins, bins + width, side="right") - np.arange(bins.size)
    long = counts >= shortest * values.size
    mostly = counts >= 0.5 * counts.max()
    candidates = np.flatnonzero(long & mostly)
    if not candidates.size:
        raise fault("T/N", "must stand still where the contact slides", "no plateau", "The contact may never slide.")
    first = int(candidates[-1])
    inside = bins[first : first + counts[first]]
    return Plateau(float(np.median(inside)), float(inside.std()), float(inside.size / values.size))


def one_foot_alone(lower: Array, upper: Array) -> tuple[Marks, Marks]:
    """Where only the lower and where only the upper foot touches, (n,) each, from their normal loads [N]."""
    whole = lower + upper
    pressed = whole > 0.0
    return np.asarray((upper < ALONE * whole) & pressed), np.asarray((lower < ALONE * whole) & pressed)


def friction_from_ratios(left_ratio: Array, right_ratio: Array, feet: tuple[Array, Array] | None) -> dict[str, Plateau]:
    """Plateaux of {"R", "L1", "L2", "L"}, as far as they exist: R and L (all lines of a side together, a load-weighted mean) from
    the whole cycle, L1 and L2 from the stages in which that foot touches alone (feet: their loads, None where unknown)."""
    stages: dict[str, tuple[Array, Marks | None]] = {"R": (right_ratio, None), "L": (left_ratio, None)}
    if feet is not None:
        stages |= {name: (left_ratio, alone) for name, alone in zip(("L1", "L2"), one_foot_alone(*feet), strict=True)}
    found = {}
    for name, (ratio, where) in stages.items():
        try:
            found[name] = plateau(ratio, where)
        except ValueError:
            continue
    return found


WORST_CONDITION = 100.0
"""Condition number from which the inversion is refused."""


@dataclass(frozen=True)
class StuckStiffness:
    """kt, kn of every line of contact [N/m]; condition: by what the relative error of the slopes is multiplied at worst, over
    by what it is at best."""

    kt: float
    kn: float
    condition: float


def compliance_parts(rig: BetweenPlatforms) -> tuple[Array, Array]:
    """(2, 2) matrices A, B of C = A/kt + B/kn for a damper on two lines at the left and one at the right."""
    first, second, right = _three(rig.points)
    feet = np.subtract(second.arm, first.arm)
    across = np.subtract(right.arm, 0.5 * np.add(first.arm, second.arm))
    a = np.array([-across[1], across[0]])
    left_t, left_n = np.outer(first.tangent, first.tangent), np.outer(first.normal, first.normal)
    right_t, right_n = np.outer(right.tangent, right.tangent), np.outer(right.normal, right.normal)
    return 0.5 * left_t + right_t, 0.5 * left_n + right_n + 2.0 * np.outer(a, a) / float(feet @ feet)


def _three(points: tuple[PlanePoint, ...]) -> tuple[PlanePoint, PlanePoint, PlanePoint]:
    left, right = [p for p in points if p.side == "left"], [p for p in points if p.side == "right"]
    if len(left) != 2 or len(right) != 1:
        found = ", ".join(p.name for p in points)
        raise fault("Stuck slopes", "must come from a damper on two lines at the left and one at the right", found)
    feet = np.subtract(left[1].arm, left[0].arm)
    if abs(float(feet @ np.array(left[0].normal))) > 1e-9:
        raise fault("The left lines of contact", "must lie on one platform", (left[0].arm, left[1].arm))
    return left[0], left[1], right[0]


def stiffness_from_slopes(rig: BetweenPlatforms, kH: float, kV: float) -> StuckStiffness:
    """kt and kn, equal at all lines, from the slopes kH (platforms out of phase) and kV (in phase) [N/m], without iteration.

    ρ = (B_VV − φ B_HH)/(φ A_HH − A_VV), φ = kH/kV. Refused near the angle at which A_HH B_VV = B_HH A_VV (57° for the
    laboratory damper, 45° when its rotation is blocked), and where no positive stiffness gives these slopes.
    """
    A, B = compliance_parts(rig)
    phi = positive("kH", kH) / positive("kV", kV)
    singular = abs(A[0, 0] * B[1, 1] - B[0, 0] * A[1, 1]) / (A[0, 0] * B[1, 1] + B[0, 0] * A[1, 1])
    remedy = "Identify from whole loops instead, which also see the rotation."
    if singular < 1.0 / WORST_CONDITION:
        raise InputError(
            f"The slopes do not separate kt from kn: this geometry is within {singular:.1%} of a singular one. {remedy}"
        )
    above, below = B[1, 1] - phi * B[0, 0], phi * A[0, 0] - A[1, 1]
    if above * below <= 0.0:
        low, high = sorted((A[1, 1] / A[0, 0], B[1, 1] / B[0, 0]))
        rule = f"must lie between {low:.4g} and {high:.4g} for this geometry"
        raise fault("kH/kV", rule, float(f"{phi:.5g}"), f"A slope is not one of all contacts stuck. {remedy}")
    rho = above / below
    C = A + B / rho
    kt = kH * float(np.linalg.det(C)) / C[1, 1]
    kn = rho * kt
    K = np.linalg.inv(A / kt + B / kn)
    slopes = np.diag(K)
    by_kt, by_kn = np.diag(K @ (A / kt) @ K) / slopes, np.diag(K @ (B / kn) @ K) / slopes
    # of d(ln kH, ln kV)/d(ln kt, ln kn)
    condition = float(np.linalg.cond(np.stack([by_kt, by_kn], axis=1)))
    if condition > WORST_CONDITION:
        raise InputError(f"The slopes do not separate kt from kn here: condition number {condition:.3g}. {remedy}")
    return StuckStiffness(float(kt), float(kn), condition)


@dataclass(frozen=True)
class StuckStretch:
    """A straight stretch of a loop: its slope [N/m], standard error, first and last sample (may wrap), share of the range."""

    slope: float
    error: float
    first: int
    last: int
    share: float


def stuck_stretch(displacement: ArrayLike, force: ArrayLike, tolerance: float = 0.01, shortest: float = 0.05) -> StuckStretch:
    """The all-stuck stretch of one mean cycle (n,): after each reversal of the motion the longest one that stays straight.

    A stretch ends where the force leaves the line through it by more than `tolerance` of its range over the loop. Both
    reversals are tried and the longer stretch is taken; below `shortest` of the displacement's range it is refused. A loop
    in gross slip from the reversal on has none; contacts that slip early make the slope too small.
    """
    u, f = np.asarray(displacement, dtype=float), np.asarray(force, dtype=float)
    if u.ndim != 1 or u.shape != f.shape or u.size < 40:
        raise fault("Displacement and force of a loop", "must be one cycle of at least 40 samples each", (u.shape, f.shape))
    found = [_after(u, f, start, tolerance) for start in (int(u.argmax()), int(u.argmin()))]
    best = max(found, key=lambda stretch: stretch.share)
    if best.share < shortest or best.slope <= 0.0:
        rule = f"must have a straight rising stretch of at least {shortest:.0%} of the motion after a reversal"
        raise fault("The loop", rule, f"{best.share:.1%}", "Take larger pull or smaller motion, or fit whole loops.")
    return best


def _after(u: Array, f: Array, start: int, tolerance: float) -> StuckStretch:
    order = (start + np.arange(u.size // 2)) % u.size
    x, y, allowed = u[order] - u[start], f[order], tolerance * float(np.ptp(f))
    fewest, last, line = max(6, u.size // 50), 0, (0.0, 0.0)
    for end in range(fewest, x.size):
        slope, offset = np.polyfit(x[:end], y[:end], 1)
        if np.max(np.abs(y[:end] - slope * x[:end] - offset)) > allowed:
            break
        last, line = end, (float(slope), float(offset))
    if last == 0:
        return StuckStretch(0.0, np.inf, start, start, 0.0)
    left = y[:last] - line[0] * x[:last] - line[1]
    error = float(np.sqrt(np.sum(left**2) / max(last - 2, 1) / np.sum((x[:last] - x[:last].mean()) ** 2)))
    share = float(np.ptp(x[:last]) / np.ptp(u))
    return StuckStretch(line[0], error, start, int(order[last - 1]), share)


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


DRAWS = 24
"""Draws of the errors of the rig for those of plateaux."""


@dataclass(frozen=True, eq=False)
class Clues:
    """Plateaux by case and line ("R", "L", "L1", "L2"), stuck slopes by case, the stiffness that they give, and why not."""

    plateaux: dict[str, dict[str, Plateau]]
    slopes: dict[str, StuckStretch]
    stiffness: StuckStiffness | None
    remarks: tuple[str, ...]

    def guess(self, name: str, otherwise: float) -> float:
        """A first value of an unknown."""
        part, _, line = name.partition("_")
        if part == "mu":
            levels = [p.level for case in self.plateaux.values() for key, p in case.items() if key in (line, line[:1])]
            return float(np.median(levels)) if levels else 0.25
        return float(getattr(self.stiffness, part, otherwise)) if self.stiffness is not None else otherwise


def clues(cases: Sequence[CycleSet], rig: BetweenPlatforms, errors: RigErrors) -> Clues:
    """What the mean cycles show, plateaux with their errors by those of the rig; what they do not show is noted in `remarks`."""
    plateaux, slopes, remarks = {}, {}, []
    directions: dict[str, list[float]] = {"x": [], "y": []}
    for case in cases:
        signals = {name: case.cycle(name) for name in case.channels}
        pull, own = float(rig.pull[1]) if case.pull is None else case.pull, errors.with_zeros(case.zero_errors)
        plateaux[case.name] = plateaux_with_errors(rig, signals, pull, own)
        axis = max("xy", key=lambda a: float(np.ptp(signals.get(f"platform_{a}", np.zeros(2)))))
        sign = 1.0 if axis == "x" else -1.0
        try:
            motion, resisting = signals[f"platform_{axis}"], signals[f"force_{axis}"] * sign
            # The force that resists the motion, turned so that it rises with it.
            rising = resisting if np.corrcoef(resisting * sign, motion)[0, 1] >= 0.0 else -resisting
            slopes[case.name] = stuck_stretch(motion, sign * rising)
            directions[axis].append(slopes[case.name].slope)
        except InputError as missing:
            remarks.append(f"{case.name}: no stuck slope. {missing}")
    stiffness = None
    try:
        if directions["x"] and directions["y"]:
            stiffness = stiffness_from_slopes(rig, max(directions["x"]), max(directions["y"]))
    except InputError as missing:
        remarks.append(f"No stiffness from slopes. {missing}")
    return Clues(plateaux, slopes, stiffness, tuple(remarks))


def plateaux_with_errors(rig: BetweenPlatforms, signals: dict[str, Array], pull: float, errors: RigErrors) -> dict[str, Plateau]:
    """Plateaux of T/N of one mean cycle, their errors from draws of the systematic errors of the rig."""
    best, generator = _plateaux(rig, signals, pull), np.random.default_rng(0)
    drawn = []
    for _ in range(DRAWS):
        one = errors.draw(generator)
        drawn.append(_plateaux(rig, {n: distorted(v, one[n]) if n in one else v for n, v in signals.items()}, pull))
    found = {}
    for name, plateau in best.items():
        apart = [one[name].level - plateau.level for one in drawn if name in one]
        error = float(np.sqrt(np.mean(np.square(apart)))) if 2 * len(apart) >= DRAWS else np.nan
        found[name] = replace(plateau, error=error)
    return found


def _plateaux(rig: BetweenPlatforms, signals: dict[str, Array], pull: float) -> dict[str, Plateau]:
    values, sides = reconstructed(rig, signals, pull), [point.side for point in rig.points]
    lever = sides.count("left") == 2 and sides.count("right") == 1
    feet = feet_loads(rig, values["left_normal"], values["left_place"]) if lever else None
    return friction_from_ratios(values["left_ratio"], values["right_ratio"], feet)
