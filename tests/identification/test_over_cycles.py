"""Friction of a damper that changes during its records is followed in parts of them."""

import numpy as np
import pytest

from stickslip.laboratory.identification.damper.work import identify
from stickslip.laboratory.measurement.cycles import CycleSet, whole_cycles
from stickslip.laboratory.measurement.reconstruction import RigErrors
from stickslip.model.dampers.between_platforms import in_phase, out_of_phase
from stickslip.model.dampers.laboratory import laboratory_damper
from stickslip.support.checks import InputError
from verify.synthetic_records import synthetic_record, true_cycle

MOTIONS = {"out": out_of_phase(30e-6), "in": in_phase(30e-6)}
LATER = (0.36, 0.33)
"""Friction at the right in the first and in the last six cycles."""


def cycles(name, motion, number):
    """Six cycles with the friction of each half, by the same cells."""
    errors = RigErrors()
    gains = errors.draw(np.random.default_rng(3))
    halves = [
        whole_cycles(
            synthetic_record(
                true_cycle(laboratory_damper(37.0, 80.0, (0.18, 0.199, mu)), motion, 1200),
                errors,
                seed=number,  # the same zeros
                systematic=gains,
                cycles=6,
                name=name,
            )
        )
        for mu in LATER
    ]
    return CycleSet(name, halves[0].channels, np.concatenate([half.harmonics for half in halves]), halves[0].frequency)


@pytest.fixture(scope="module")
def found():
    loops = [cycles(name, motion, number) for number, (name, motion) in enumerate(MOTIONS.items())]
    damper = laboratory_damper(37.0, 80.0, (0.18, 0.199, 0.3))
    return identify(loops, damper, unknown=["mu_R"], resamples=8, population=4, generations=4)


def test_friction_is_followed(found):
    data = found.over_cycles(4)
    assert data["mu_R"].values == pytest.approx([LATER[0], LATER[0], LATER[1], LATER[1]], rel=0.02)
    assert data["cycles"].values.tolist() == [[1, 3], [4, 6], [7, 9], [10, 12]]
    assert min(LATER) < found.values["mu_R"] < max(LATER)


def test_groups_need_cycles(found):
    with pytest.raises(InputError, match="points must be at most 6"):
        found.over_cycles(7)
