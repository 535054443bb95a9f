"""Dahl's and Valanis' law and tanh-regularised friction: harmonic balance against time integration, at frequencies and at a peak;
derivatives by the frequency, which forces that depend on the velocity have of their own."""

import numpy as np
import pytest
from time_domain.systems import rubbing_mass

import stickslip as ss
from stickslip.analyses.forced_response import forced_response
from stickslip.model.contact.dahl import Dahl
from stickslip.model.contact.lugre import LuGre
from stickslip.model.contact.point import Contact, between
from stickslip.model.contact.tanh_coulomb import TanhCoulomb
from stickslip.model.contact.valanis import Valanis
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.structure.matrices import Structure
from stickslip.solve.balance.balance import HarmonicBalance, Point
from stickslip.solve.continuation.continuation import first_point
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.support.units import radians_per_second

CONSTANT = {
    "dahl": Dahl(kt=2.0, mu=0.5, normal_load=0.6),
    "valanis": Valanis(kt=2.0, mu=0.5, kappa=0.7, normal_load=0.6),
    "lugre": LuGre(kt=2.0, mu=0.4, mu_static=0.5, stribeck=0.3, damping=0.1, viscosity=0.05, normal_load=0.6),
    "tanh": TanhCoulomb(mu=0.5, v0=0.2, normal_load=0.6),
}
VARYING = {
    "dahl": Dahl(kt=3.0, mu=0.5, kn=4.0, preload=0.2),
    "valanis": Valanis(kt=3.0, mu=0.5, kappa=0.7, kn=4.0, preload=0.2),
    "lugre": LuGre(kt=3.0, mu=0.4, mu_static=0.5, stribeck=0.3, damping=0.1, viscosity=0.05, kn=4.0, preload=0.2),
    "tanh": TanhCoulomb(mu=0.5, v0=0.2, kn=4.0, preload=0.2),
}


def resting_mass(law) -> Problem:
    """One mass on a spring that rubs under a constant load."""
    structure = Structure(np.eye(1), np.eye(1), ("1.x",), C=0.02 * np.eye(1))
    return Problem(structure, (Contact("ground", law, (between("1.x", "ground"),)),), (Force("1.x", 0.5),), ("1.x",))


@pytest.mark.slow
@pytest.mark.parametrize("name", CONSTANT)
@pytest.mark.parametrize(
    ("make", "omega", "tolerance"), [(resting_mass, 1.05, 5e-5), pytest.param(rubbing_mass, 0.9, 3e-4, marks=pytest.mark.nightly)]
)
def test_harmonic_balance_against_time_integration(name, make, omega, tolerance):
    """Constant load, and with lift-off; slip work counted by the law equals the work of the force in both."""
    law = (CONSTANT if make is resting_mass else VARYING)[name]
    response = forced_response(make(law), [0.05, omega / (2.0 * np.pi)], harmonics=31, samples=2048)
    found = response.verify_in_time(0, 1)
    assert found.periodic, found.sentence
    assert found.agrees(tolerance), found.sentence
    assert float(found.time.dataset.energy_residual) < 1e-4
    assert float(response.dataset.slip_work_error[0, 1]) < 1e-4
    assert float(response.dataset.energy_residual[0, 1]) < 1e-9


@pytest.mark.parametrize("law", [*CONSTANT.values(), *VARYING.values()], ids=lambda law: type(law).__name__)
def test_the_curve_has_the_slope_of_its_own_solutions(law):
    """dλ/dω and dw/dω along the curve against differences of solutions beside."""
    problem = resting_mass(law) if law.kn is None else rubbing_mass(law)
    balance = HarmonicBalance(problem, 5, 128)

    omega, step = 0.93, 1e-6
    here = first_point(balance, omega, 1.0).evaluation

    def solved(omega):
        found = correct(balance, Point(here.point.forces, omega, 1.0), fixed("omega", omega), iterations=20, halvings=8)
        assert found.converged
        return found.evaluation

    tangent = balance.tangent(here, "omega", balance.factorise(here, fixed("omega", omega)))
    low, high = solved(omega - step), solved(omega + step)
    for found, ends in ((tangent.forces, (low.point.forces, high.point.forces)), (tangent.motion, (low.w, high.w))):
        expected = (ends[1] - ends[0]) / (2.0 * step)
        np.testing.assert_allclose(found / tangent.rate, expected, atol=2e-6 * np.abs(expected).max())


@pytest.mark.nightly
@pytest.mark.parametrize("name", CONSTANT)
def test_a_peak_against_time_integration(name):
    """The peak that continuation finds: highest among its neighbours, and as high in time."""
    problem = resting_mass(CONSTANT[name])
    peak = forced_response(problem, radians_per_second(0.6, 2.5), harmonics=15, samples=1024).peaks().iloc[0]
    beside = [float(peak["frequency"]) * (1.0 + shift) for shift in (-2e-3, 0.0, 2e-3)]
    listed = forced_response(problem, [0.5 * beside[0], *beside], harmonics=15, samples=1024)
    low, here, high = listed.dataset.amplitude.values[0, 1:, 0]
    assert here > max(low, high)
    assert float(peak["amplitude"]) == pytest.approx(here, rel=1e-7)
    middle = 0.5 * (low - high) / (low - 2.0 * here + high)
    assert abs(middle) < 2e-2, "the parabola through the three has its top at the peak, cusps of the samples aside"
    check = listed.verify_in_time(0, 2)
    assert check.time_amplitude[0] == pytest.approx(here, rel=2e-4)


@pytest.mark.parametrize("law", [*CONSTANT.values()], ids=lambda law: type(law).__name__)
def test_start_states_are_not_varied_where_they_are_forgotten(law):
    problem, band = resting_mass(law), [0.1, 0.15]
    for ask in (
        lambda: ss.response_samples(problem, band, starts=3),
        lambda: ss.response_bounds(problem, band),
    ):
        with pytest.raises(ss.InputError, match="'ground' must have a start state"):
            ask()


def test_a_start_without_effect_is_warned_of():
    law = ss.Dahl(1.0, 0.3, normal_load=1.0)
    structure = Structure(np.eye(1), np.eye(1), ("1.x",), C=0.05 * np.eye(1))
    starts = (ss.SliderOffset(), ss.SliderOffset(1e-3), ss.MeanTraction(0.1))
    contacts = [ss.Contact("c", law, (ss.between("1.x", "ground"),), start=start) for start in starts]
    warnings = [ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0),), ("1.x",)).warnings for contact in contacts]
    assert warnings == [(), *[("Start states without effect (c): a contact of Dahl has none.",)] * 2]


def test_a_law_that_forgets_its_start_has_no_slope_by_it():
    """Beside a slider that remembers: one start value acts, not two."""
    structure = Structure(np.eye(2), 2.0 * np.eye(2), ("1.x", "2.x"), C=0.05 * np.eye(2))
    contacts = (
        Contact("dahl", CONSTANT["dahl"], (between("1.x", "2.x"),)),
        Contact("slider", ss.Macroslip(kt=1.0, mu=1.0, normal_load=50.0), (between("2.x", "ground"),)),
    )
    problem = Problem(structure, contacts, (Force("1.x", 0.5),), ("1.x",))
    found = ss.sensitivity(problem, 0.2, {})
    assert list(found.elements) == [1]
