"""What is unknown of a damper, and the contact laws of its lines, each with the same total stiffness and friction.

macroslip   one slider a line
iwan        equal springs and loads, limits that fall as the half ellipse of a cylinder on a flat
microslip   equal elements with gaps from 0 to 2 g N/kn, N the pull shared over the lines; the unknown `gaps` is g
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.laboratory.identification.contact_law.fit import half_ellipse
from stickslip.model.contact.law import LoadDependentFriction, line_of
from stickslip.model.dampers.between_platforms import BetweenPlatforms
from stickslip.solve.platforms.relaxation import Elements
from stickslip.support.checks import Array, fault

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
