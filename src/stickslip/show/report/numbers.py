"""Numbers as text: Hz, per cent, energies with prefix."""

from __future__ import annotations

import math


def number(value: float, digits: int = 4) -> str:
    """A number with so many digits, never in exponents where a reader would not write them."""
    if not math.isfinite(value):
        return "–"
    return f"{value:.{digits}g}" if not 1e4 <= abs(value) < 1e7 else f"{value:.0f}"


def hertz(value: float) -> str:
    """A frequency, to a hundredth, or to five digits below 10 Hz."""
    if not math.isfinite(value):
        return "–"
    return f"{value:.2f}" if abs(value) >= 10.0 else f"{value:.5g}"


def percent(value: float) -> str:
    """A share in percent; more digits where it is near 100 %."""
    return f"{100.0 * value:.1f} %" if 0.0 < abs(1.0 - value) < 0.02 or abs(value) < 0.1 else f"{100.0 * value:.0f} %"
