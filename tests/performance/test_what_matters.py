"""Which parameter matters: exact slopes and indices where a closed form gives them."""

from math import pi

import numpy as np
import pytest

import stickslip as ss

BAND = ss.radians_per_second(0.85, 1.35)


def test_slopes_and_ends_against_the_closed_form():
    """Undamped, one harmonic: A = Fc²/(kd (Fc − π/4)), so d ln A = −d kd/kd + (2/Fc − 1/(Fc − π/4)) d Fc."""

    def rig(*, kd: float, limit: float) -> ss.Problem:
        return ss.rigs.single_mass(damping=0.0, kt=kd, limit=limit)

    found = ss.what_matters(rig, {"kd": (0.45, 0.55), "limit": (1.8, 2.2)}, BAND, draws=2, harmonics=1, samples=2048).dataset
    exact = [-0.1 / 0.5, 0.4 * (2.0 / 2.0 - 1.0 / (2.0 - pi / 4.0))]
    assert found.slope.values == pytest.approx(exact, rel=1e-3)
    for k, (kd, limit) in enumerate([(0.45, 2.0), (0.5, 1.8)]):
        assert float(found.low_end[k, 0]) == pytest.approx(limit**2 / (kd * (limit - pi / 4.0)), rel=3e-5)


def test_all_variance_belongs_to_the_only_parameter_that_acts():
    """A stuck contact: the slip limit does nothing, damping everything."""

    def rig(*, damping: float, limit: float) -> ss.Problem:
        return ss.rigs.single_mass(damping=damping, kt=0.5, limit=limit)

    found = ss.what_matters(
        rig, {"damping": (0.01, 0.02), "limit": (500.0, 900.0)}, BAND, draws=64, harmonics=1, samples=64
    ).dataset
    assert float(found.total[1, 0]) == pytest.approx(0.0, abs=1e-6)
    assert float(found.total[0, 0]) > 0.8
    assert np.all(found.high_end.values[1] == pytest.approx(found.low_end.values[1], rel=1e-4))


def test_one_parameter_alone_and_any_number_of_workers():
    """One range alone has all the variance; 16 draws are two cases, which share nothing but the middle."""
    found = ss.what_matters(OneLimit(), {"limit": (1.6, 2.4)}, BAND, draws=16, harmonics=1, samples=64).dataset
    other = ss.what_matters(OneLimit(), {"limit": (1.6, 2.4)}, BAND, draws=16, harmonics=1, samples=64, workers=2).dataset
    assert found.total.shape == (1, 2)
    assert float(found.first_order[0, 0]) == pytest.approx(1.0, abs=0.35)
    assert np.array_equal(found.total.values, other.total.values)


class OneLimit:
    def __call__(self, *, limit: float) -> ss.Problem:
        return ss.rigs.single_mass(damping=0.01, kt=0.5, limit=limit)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"draws": 6}, "draws must be a power of two"),
        ({"parameters": {"limit": (2.0, 1.0)}}, r"parameters, limit must be \(low, high\)"),
    ],
)
def test_wrong_input_is_said(changed, words):
    settings = {"parameters": {"limit": (1.0, 2.0)}, "band": BAND} | changed
    with pytest.raises(ss.InputError, match=words):
        ss.what_matters(lambda limit: ss.rigs.single_mass(limit=limit), **settings)
