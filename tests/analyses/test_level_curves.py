"""Detached curves found along the force level: beside their closed form, and the amplitude that a level can sustain."""

import numpy as np
import pytest
from analyses.closed_form_isolas import BAND, is_found, isolas

import stickslip as ss
from stickslip.analyses.isolated import Isolated, LevelCurves, sustained


def found(cases):
    band = ss.radians_per_second(*BAND)
    results = (ss.forced_response(each.problem, band, each.level, harmonics=1, samples=64, isolated=True) for each in cases)
    return sum(is_found(each, result.dataset) for each, result in zip(cases, results, strict=True))


def test_isolas_in_closed_form_are_found():
    assert found(isolas(5, 3)) == 3


@pytest.mark.nightly
def test_of_a_hundred_isolas_in_closed_form_95_are_found():
    assert found(isolas(2, 100)) >= 95


def oscillator(damping):
    structure = ss.Structure(np.diag([1.0, 2.0]), np.diag([1.0, 4.0]), ("a.x", "b.x"), C=np.diag(damping))
    stop = ss.Contact("stop", ss.Gap(1.0, gap=1.0), (), {"a.x": 1.0})
    return ss.Problem(structure, (stop,), (ss.Force("a.x", 3.0),), ("a.x", "b.x"))


def test_the_bound_is_the_linear_resonance_of_one_mass():
    """At its resonance X = F/(ω c), which no contact can raise; what the force cannot feed does not vibrate by it."""
    np.testing.assert_allclose(sustained(oscillator([0.1, 0.3]), 1.0, 0.5), [15.0, 0.5 * 0.5 * 3.0 / np.sqrt(0.03)])


def test_no_linear_structure_vibrates_more_than_the_bound():
    """Symmetric contacts of any stiffness, gyroscopic forces, forces out of phase, damping over seven decades."""
    random, closest = np.random.default_rng(3), 0.0
    for size in (1, 2, 3, 4) * 5:
        root, other, skew, K = random.standard_normal((4, size, size))
        M, C = other @ other.T + 0.3 * np.eye(size), 10.0 ** random.uniform(-6, 1) * root @ root.T + 0.3 * (skew - skew.T)
        K = K + K.T + 3.0 * size * np.eye(size)
        names, phases = tuple(f"{k}.x" for k in range(size)), np.exp(2j * np.pi * random.uniform(size=size))
        stop = ss.Contact("stop", ss.Gap(1.0, gap=1.0), (), {names[0]: 1.0})
        forces = tuple(ss.Force(name, complex(phase)) for name, phase in zip(names, phases, strict=True))
        problem = ss.Problem(ss.Structure(M, K, names, C=C), (stop,), forces, names)
        natural = np.sqrt(np.abs(np.linalg.eigvals(np.linalg.solve(M, K))))
        for omega in [*natural, *random.uniform(0.1, 3.0, 3)]:
            most = sustained(problem, float(omega), 2.0)
            for added in (0.0, random.uniform(-3.0, 3.0)):
                stiffness = K + added * np.diag(np.arange(size) == 0)
                X = np.linalg.solve(stiffness - omega**2 * M + 1j * omega * C, 2.0 * phases)
                assert np.all(np.abs(X) <= most * (1.0 + 1e-6))
                closest = max(closest, float((np.abs(X) / most).max()))
    assert closest > 0.999


def test_a_search_says_where_it_ended_before():
    """With few points to spend, as on a model of many contacts."""
    (case,) = isolas(5, 1)
    band = ss.radians_per_second(*BAND)
    swept = ss.forced_response(case.problem, band, case.level, harmonics=1, samples=64)
    curve = swept._solved_curve(0, 1)
    search = LevelCurves(curve, Isolated(curve), 8)
    search.search()
    assert search.left <= 0
    assert search.sentence.endswith(f"At {curve.balance.hertz(search.lost[0]):.5g} Hz the search ended earlier.")


def test_no_bound_without_damping_of_what_is_driven_or_asked_for():
    np.testing.assert_allclose(sustained(oscillator([0.1, 0.0]), 1.0, 0.5), [15.0, np.inf])
    assert np.isinf(sustained(oscillator([0.0, 0.1]), 1.0, 0.5)).all()
