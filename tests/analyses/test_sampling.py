"""Samples too few for a law whose force follows the velocity are named, with a number that is enough."""

from types import SimpleNamespace

import numpy as np
import pytest
from stability.test_multipliers import lifting

import stickslip as ss
from stickslip.analyses.harmonic_choice import fold_warning
from stickslip.solve.balance.balance import HarmonicBalance


def response(v0: float, samples: int) -> ss.ForcedResponse:
    """A mass on a spring, ζ = 1e-4, with Coulomb friction smoothed over ±v0, driven a little beyond what friction holds."""
    structure = ss.Structure(M=[[1.0]], K=[[1e6]], C=[[0.2]], dofs=("1.x",))
    contact = ss.Contact("slider", ss.TanhCoulomb(mu=0.5, normal_load=20.0, v0=v0), (ss.between("1.x", "ground"),))
    problem = ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0),), ("1.x",))
    return ss.forced_response(problem, ss.hertz(155.0, 163.0), force=13.0, harmonics=7, samples=samples)


def test_too_few_samples_are_named_with_enough():
    message = str(response(1e-3, 256).dataset.case_message.values[0])
    assert "The friction of slider changes its sign within 0.061 of a sample" in message
    assert "Use 16384 samples" in message


@pytest.mark.parametrize("v0", [0.05, 0.1])
def test_nothing_is_said_where_samples_resolve_the_law(v0):
    assert "samples" not in str(response(v0, 256).dataset.case_message.values[0])


def test_the_share_of_a_period_is_that_of_a_harmonic_motion():
    """v = V cos τ lies within ±v0 for the share 2 asin(v0/V)/2π at each reversal; its limit for v0 much below V is v0/(πV)."""
    law, velocity = ss.TanhCoulomb(mu=0.3, normal_load=1.0, v0=1e-4), 0.7
    tau = np.linspace(0.0, np.pi, 2_000_001)
    share = np.mean(np.abs(velocity * np.cos(tau)) < law.v0) / 2.0
    assert law.passage(velocity) == pytest.approx(share, rel=1e-2)


@pytest.mark.parametrize(("problem", "omegas", "said"), [
    (ss.rigs.single_mass(), (1.0, 1.1, 1.05, 1.2), True),
    (ss.rigs.single_mass(), (1.0, 1.1, 1.2), False),
    (lifting(), (1.0, 1.1, 1.05, 1.2), False),
])  # fmt: skip
def test_a_curve_that_turns_back_where_there_is_one_motion_has_too_few_samples(problem, omegas, said):
    """Which curves of few samples turn back is decided by rounding, so the points are given."""
    points = [SimpleNamespace(point=SimpleNamespace(omega=omega)) for omega in omegas]
    found = fold_warning(HarmonicBalance(problem, 1, 16), SimpleNamespace(points=points))
    assert (found == "") != said
    assert not said or "turns back in frequency near 0.17507 Hz" in found
    assert not said or "Take 32." in found
