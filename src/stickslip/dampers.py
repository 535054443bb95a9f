"""Damper shapes and platform motions: the public name of `stickslip.model.dampers`."""

from stickslip.model.dampers import *  # noqa: F403
