"""Wrong arguments of the damper alone are refused by name, with rule and value: no raw error, nothing that never ends."""

import re

import numpy as np
import pytest

from stickslip.analyses.damper_alone.cycle import damper_cycle, damper_evolution, steady_cycles
from stickslip.model.dampers import Cylinder, ThreePoint, Wedge
from stickslip.model.dampers.between_platforms import BetweenPlatforms, measured, out_of_phase
from stickslip.model.dampers.laboratory import laboratory_damper
from stickslip.support.checks import InputError

RIG, MOTION = laboratory_damper(), out_of_phase(30e-6)

WRONG = [
    (lambda: damper_cycle(None, MOTION), "rig must be a BetweenPlatforms, but is None."),
    (lambda: damper_cycle(RIG, None), "motion must be a PlatformMotion, but is None."),
    (lambda: damper_cycle(RIG, MOTION, steps="a"), "steps must be a whole number, but is 'a'."),
    (lambda: damper_cycle(RIG, MOTION, cycles=None), "cycles must be a whole number, but is None."),
    (lambda: damper_evolution(RIG, MOTION, 0.3), "friction must be a tuple or list, but is 0.3."),
    (lambda: damper_evolution(RIG, MOTION, None), "friction must be a tuple or list, but is None."),
    (lambda: damper_evolution(None, MOTION, [0.3]), "rig must be a BetweenPlatforms, but is None."),
    (lambda: steady_cycles(RIG, MOTION, starts=None), "starts must be a whole number, but is None."),
    (lambda: steady_cycles(RIG, MOTION, seed="a"), "seed must be a whole number, but is 'a'."),
    (lambda: measured([1, 2, 3], [1, 2]), "x and y of a measured cycle must have equal length"),
    (lambda: measured("a", "b"), "x must hold numbers, but is 'a'."),
    (lambda: measured(np.ones(99), np.ones(99), harmonics=-1), "harmonics must be at least 1, but is -1."),
    (lambda: BetweenPlatforms.macroslip(ThreePoint(), 1e6, 1e6, 0.1), "A shape becomes one by shape.damper(pull=...)."),
    (lambda: BetweenPlatforms(ThreePoint().damper(pull=1.0), [1, 2, 3]), "The law of L1 must be a Law, but is 1."),
    (lambda: Cylinder(left_angle="a"), "left_angle must be a number, but is 'a'."),
    (lambda: laboratory_damper(platform_angle="45"), "left_angle must be a number, but is '45'."),
    (lambda: Wedge(lines=10**7), "lines must be at most 1000, but is 10000000."),
]


@pytest.mark.parametrize(("wrong", "words"), WRONG)
def test_wrong_arguments_are_refused_in_words(wrong, words):
    with pytest.raises(InputError, match=re.escape(words)):
        wrong()
