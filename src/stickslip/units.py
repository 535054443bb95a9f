"""Units and frequency bands: the public name of `stickslip.support.units`."""

from stickslip.support.units import *  # noqa: F403
