"""Friction of constant limits and damping bring any two motions together, and nothing else is said to."""

from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from stickslip.model import rigs
from stickslip.model.problem.contraction import Contraction, contraction, contracts
from stickslip.solve.stability.event_march import EventMarch, State

UNKNOWN, NEVER_GROWS, VANISHES = Contraction

SLIDER = ss.Macroslip(kt=3.0, mu=0.5, normal_load=0.4)
LOADED = ss.Macroslip(kt=3.0, mu=0.5, kn=2.0, preload=0.4)


def problem(law=SLIDER, K=((2.0, -1.0), (-1.0, 1.0)), C=((0.2, 0.0), (0.0, 0.1)), **more):
    """Two masses, the second of which rubs on the ground along x."""
    structure = ss.Structure(np.diag([1.0, 0.5]), K, ("1.x", "2.x"), None if C is None else C)
    normal = ss.between("1.x", "ground") if law.has_normal else None
    contact = ss.Contact("rub", law, (ss.between("2.x", "ground"),), normal)
    return ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0),), ("1.x",), **more)


def in_the_plane(law):
    """A mass that circles on a contact with two directions."""
    structure = ss.Structure(np.eye(2), np.diag([1.0, 1.4]), ("1.x", "1.y"), C=0.04 * np.eye(2))
    contact = ss.Contact("c", law, (ss.between("1.x", "ground"), ss.between("1.y", "ground")))
    return ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0), ss.Force("1.y", 0.6j)), ("1.x",))


SKEW = np.array([[0.0, 0.7], [-0.7, 0.0]])

CASES = {
    "slider": (problem(), VANISHES),
    "stiff slider": (problem(replace(SLIDER, kt=1e6)), VANISHES),
    "Coriolis forces": (problem(C=np.diag([0.2, 0.1]) + SKEW), VANISHES),
    "Iwan": (problem(ss.Iwan(3.0, 0.5, normal_load=0.4, count=8)), VANISHES),
    "friction disc": (in_the_plane(ss.FrictionDisc(1.0, 0.5, normal_load=1.0)), VANISHES),
    "friction over velocity": (problem(ss.TanhCoulomb(0.5, 0.1, normal_load=0.4)), VANISHES),
    "a free body on the slider": (problem(K=((2.0, 0.0), (0.0, 0.0))), VANISHES),
    "mean spring": (problem(mean_springs=(ss.Spring({"2.x": 1.0}, 10.0),)), VANISHES),
    "one mass undamped": (problem(C=((0.2, 0.0), (0.0, 0.0))), NEVER_GROWS),
    "undamped": (problem(C=None), NEVER_GROWS),
    "load that varies": (problem(LOADED), UNKNOWN),
    "cubic spring": (problem(ss.CubicSpring(1.0)), UNKNOWN),
    "Dahl": (problem(ss.Dahl(3.0, 0.5, normal_load=0.4)), UNKNOWN),
    "negative damping": (problem(dashpots=(ss.AerodynamicDamping({"1.x": 1.0}, -0.3),)), UNKNOWN),
    "negative stiffness": (problem(K=((2.0, -1.0), (-1.0, 0.4))), UNKNOWN),
    "tuned disk whose loads vary": (rigs.lumped_blisk("W", sectors=6, engine_order=2), UNKNOWN),
}


@pytest.mark.parametrize("name", CASES)
def test_what_is_known_of_any_two_motions(name):
    given, expected = CASES[name]
    assert contraction(given) == expected
    assert contracts(given) == (expected == VANISHES)


@pytest.mark.parametrize("length", [4e-6, 2.5e5])
def test_the_units_of_degrees_of_freedom_do_not_matter(length):
    """One of two masses in another unit of length, as a rotation beside a displacement."""
    given = problem()
    scale = np.outer(*2 * [np.array([1.0, length])])
    s = given.structure
    other = ss.Structure(scale * s.M, scale * s.K, s.dofs, scale * s.C)
    contact = replace(given.contacts[0], tangential=({"2.x": length},))
    assert contracts(replace(given, structure=other, contacts=(contact,)))


def energy(march, one, other):
    """½Δq̇ᵀMΔq̇ + ½ΔqᵀKΔq + ΣΔT²/2kt of two states."""
    k, kt = march.coordinates.size, march.table.stiffness
    away = one.motion - other.motion
    u = march.coordinates.rows @ away[:k]
    traction = one.intercept - other.intercept + kt * u[march.row]
    K = march.coordinates.stiffness
    return 0.5 * (away[k:] @ away[k:] + away[:k] @ K @ away[:k] + np.sum(traction**2 / kt))


@pytest.mark.parametrize("name", ["slider", "stiff slider", "Coriolis forces", "Iwan", "undamped"])
def test_the_energy_of_the_difference_never_grows(name):
    """Marched exactly from event to event from two states, period after period."""
    march = EventMarch(CASES[name][0], np.inf, 40, 2.0)
    march.at(0.9, 3.0, np.ones(march.table.rows))
    rng, count = np.random.default_rng(3), march.table.stiffness.size
    motions = [State(rng.normal(size=2 * march.coordinates.size), np.zeros(count)) for _ in range(2)]
    motions = [State(each.motion, march.entry(each)[1]) for each in motions]
    energies = []
    for _ in range(6):
        energies.append(energy(march, *motions))
        motions = [march.travel(each).end for each in motions]
    assert np.all(np.diff(energies) <= 1e-9 * energies[0])
    assert energies[-1] < 0.99 * energies[0]
