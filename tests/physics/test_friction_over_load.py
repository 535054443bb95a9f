"""Friction that depends on the normal load, against closed forms, integration in time, and states of rest."""

import numpy as np
import pytest
from laws.kernel import cycle, forces
from laws.samples import Sample
from scipy.integrate import quad
from scipy.optimize import brentq

import stickslip as ss
from stickslip.analyses.damper_alone.cycle import damper_cycle
from stickslip.analyses.forced_response import forced_response
from stickslip.model.contact.point import SliderOffset
from stickslip.model.dampers.between_platforms import BetweenPlatforms
from stickslip.model.problem.at_rest import unbearable_loads
from stickslip.solve.balance.energy import cycle_work

TABLE = ss.LoadDependentFriction((0.5, 1.0, 2.5), (0.8, 0.5, 0.3))
POWER = ss.LoadDependentFriction.power(0.5, 1.0, -1.0 / 3.0)


@pytest.mark.parametrize(("mu", "tolerance"), [(TABLE, 2e-5), (POWER, 3e-3)], ids=["table", "power"])
def test_energy_of_full_slip_under_a_harmonic_load(mu, tolerance):
    """u = A cos θ under N = N0 + N1 cos θ, rigid: W = ∮ L(N) |du| = (2A/N1) ∫ L dN from N0 − N1 to N0 + N1, of a power law with
    L = μ1 N^(1+p) that is (2A/N1) μ1 [N^(2+p)]/(2 + p). kt is a million times L/A."""
    A, N0, N1, kt = 1.0, 1.6, 1.2, 1e6
    sample = Sample("in phase", ss.Macroslip(kt, mu, N1 / A, N0), 1, ())
    motion = np.array([[0.0, A, 0.0], [0.0, A, 0.0]])
    low, high = N0 - N1, N0 + N1
    if mu is TABLE:
        knots = np.array([0.0, *TABLE.over, high])
        limits = np.array([0.0, *np.multiply(TABLE.over, TABLE.values), TABLE.values[-1] * high])
        exact = 2.0 * A / N1 * quad(lambda N: np.interp(N, knots, limits), low, high, points=TABLE.over[:])[0]
    else:
        exact = 2.0 * A / N1 * 0.5 * (high ** (5.0 / 3.0) - low ** (5.0 / 3.0)) / (5.0 / 3.0)
    assert cycle_work(forces(sample, SliderOffset(), motion, 8192), motion)[0] == pytest.approx(exact, rel=tolerance)


def test_traction_in_full_slip_is_the_limit():
    sample = Sample("quadrature", ss.Macroslip(1e6, TABLE, 1.2, 1.6), 1, ())
    loop = cycle(sample, SliderOffset(), np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), 512)
    load, traction = loop.force[1], loop.force[0]
    limit = np.interp(load, [0.0, 0.5, 1.0, 2.5, 2.8], [0.0, 0.4, 0.5, 0.75, 0.84])
    slipping = loop.state[0] == 1
    assert slipping.mean() > 0.98
    np.testing.assert_allclose(np.abs(traction[slipping]), limit[slipping], rtol=1e-9)
    assert np.all(np.abs(traction) <= limit * (1.0 + 1e-9))


def rubbing(mu):
    """A mass in the plane that lifts off the ground, lands and rubs."""
    structure = ss.Structure(np.eye(2), np.eye(2), ("1.x", "1.y"), C=0.05 * np.eye(2))
    law = ss.Macroslip(kt=3.0, mu=mu, kn=4.0, preload=0.2)
    contact = ss.Contact("ground", law, (ss.between("1.x", "ground"),), ss.between("1.y", "ground"))
    loads = (ss.Force("1.x", 1.0), ss.Force("1.y", 0.3 - 0.6j, static=0.4))
    return ss.Problem(structure, (contact,), loads, ("1.x", "1.y"))


def test_harmonic_balance_and_integration_in_time_agree_where_the_contact_lands():
    """At 31 harmonics to 2e-4, as with a constant coefficient; the coefficient goes from 0.8 to 0.35 over the period."""
    response = forced_response(
        rubbing(ss.LoadDependentFriction((0.3, 1.0, 3.0), (0.8, 0.5, 0.35))), [0.3 / 6.3, 0.9 / 6.3], harmonics=31, samples=2048
    )
    found = response.verify_in_time(0, 1)
    assert found.periodic, found.sentence
    assert found.agrees(3e-4), found.sentence
    assert float(found.time.dataset.energy_residual) < 5e-5
    constant = forced_response(rubbing(0.5), [0.9 / 6.3], harmonics=31, samples=2048)
    assert abs(float(response.dataset.amplitude[0, 1, 0]) / float(constant.dataset.amplitude[0, 0, 0]) - 1.0) > 0.02


@pytest.mark.parametrize("closes", [True, False])
def test_a_sliding_cylinder_is_held_by_the_coefficient_of_its_own_load(closes):
    """Two lines at α = 40°, F_C = 80 N: N = F_C/(2 (cos α ± μ(N) sin α)) and H = N (sin α ∓ μ(N) cos α), with μ(N) of that N."""
    a, pull = np.radians(40.0), 80.0
    mu = ss.LoadDependentFriction((20.0, 45.0, 90.0), (0.5, 0.3, 0.2))
    damper = ss.dampers.Cylinder(left_angle=40.0, right_angle=40.0).damper(pull=pull)
    rig = BetweenPlatforms.macroslip(damper, 40e6, 60e6, mu)
    record = damper_cycle(rig, ss.dampers.out_of_phase(60e-6), steps=400).dataset
    sign = -1.0 if closes else 1.0

    def missing(N):
        return N * (2.0 * np.cos(a) + 2.0 * sign * float(mu.coefficient(N)) * np.sin(a)) - pull

    load = brentq(missing, 20.0, 200.0)
    H = load * (np.sin(a) - sign * float(mu.coefficient(load)) * np.cos(a))
    reached = np.abs(record.force_on_right.values[:, 0])
    normal = record.normal_force.values
    assert (reached.max() if closes else reached.min()) == pytest.approx(H, rel=1e-8)
    assert (normal.max() if closes else normal.min()) == pytest.approx(load, rel=1e-8)
    ratio = np.abs(record.friction_force.values) / normal
    assert np.all(ratio <= mu.coefficient(normal) * (1.0 + 1e-9))


def test_a_damper_alone_says_where_its_loads_lie_beyond_those_of_its_coefficient():
    damper, motion = ss.dampers.Cylinder().damper(pull=80.0), ss.dampers.in_phase(20e-6)
    for first, beyond in ((1000.0, True), (10.0, False)):
        mu = ss.LoadDependentFriction((first, 5.0 * first), (0.6, 0.4))
        found = damper_cycle(BetweenPlatforms.macroslip(damper, 40e6, 60e6, mu), motion, steps=200)
        assert (f"mu is given, {first:g} to" in found.dataset.attrs["message"]) == beyond


def box(push, mu, weight=10.0, half=0.2):
    """A box on four points, its mass centre half its width above them, pushed along x."""
    structure = ss.RigidBody(1.0, np.eye(3), node="box").structure()
    law, contacts = ss.Macroslip(1e3, mu, kn=1e4), []
    for x in (-half, half):
        for y in (-half, half):
            directions = []
            for axis in ((1, 0, 0), (0, 1, 0), (0, 0, -1)):
                turned = np.cross((x, y, -half), axis)
                names = zip(("x", "y", "z", "rx", "ry", "rz"), (*axis, *turned), strict=True)
                directions.append({f"box.{name}": float(c) for name, c in names if c})
            contacts.append(ss.Contact(f"{x:g} {y:g}", law, tuple(directions[:2]), directions[2]))
    loads = (ss.Force("box.x", 1.0), ss.Force("box.x", static=push), ss.Force("box.z", static=-weight))
    return ss.Problem(structure, tuple(contacts), loads, ("box.x",), "box")


def sliding(limit):
    """A push F at the mass centre loads the feet ahead by W/4 + F/4 each and those behind by W/4 − F/4; the box slides at
    F = 2 L(W/4 + F/4) + 2 L(W/4 − F/4)."""
    return brentq(lambda F: 2.0 * float(limit(2.5 + F / 4.0) + limit(2.5 - F / 4.0)) - F, 0.5, 9.9)


@pytest.mark.parametrize(
    ("loads", "values", "above"),
    [
        ((1.0, 3.0), (0.6, 0.3), lambda N: min(0.6 * N, 0.6 + 0.3 * (N - 1.0))),
        ((1.0, 2.0, 20.0), (0.8, 0.6, 0.2), lambda N: min(0.8 * N, 0.8 + 0.4 * (N - 1.0), 1.2 + 0.2 * (N - 2.0))),
        ((1.0, 3.0), (0.2, 0.4), lambda N: 0.4 * N),
    ],
)
def test_a_box_is_at_rest_below_its_limits_and_not_above_the_concave_curve_over_them(loads, values, above):
    """The program has straight lines: of a coefficient that falls they follow the limit but for its end, where it is constant."""
    mu = ss.LoadDependentFriction(loads, values)
    assert unbearable_loads(box(0.99 * sliding(mu.limit), mu)) == []
    assert unbearable_loads(box(0.99 * sliding(above), mu)) == []
    assert unbearable_loads(box(1.01 * sliding(above), mu)) == ["box"]
