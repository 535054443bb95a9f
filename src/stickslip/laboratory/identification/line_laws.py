"""Contact laws available to an identification, each with the same total stiffness and friction.

macroslip   one slider a line
iwan        equal springs and loads, limits that fall as the half ellipse of a cylinder on a flat
microslip   equal elements with gaps from 0 to 2 g N/kn, N the pull shared over the lines; the unknown `gaps` is g
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from stickslip.laboratory.identification.contact_law.model import half_ellipse
from stickslip.solve.platforms.relaxation import Elements
from stickslip.support.checks import Array

IWAN_ELEMENTS, GAP_ELEMENTS = 10, 5
"""Jenkins elements of a contact line: of an Iwan law, and one behind the other where gaps open in turn."""

Values = Mapping[str, Array]
"""kt, kn, mu and gaps of every line, (lines,)."""


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
