"""The ready problems: the public name of `stickslip.model.rigs`."""

from stickslip.model.rigs import *  # noqa: F403
