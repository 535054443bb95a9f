"""What must not matter: the run, the order of contacts, the phase of the force, the direction of the sweep, units."""

from dataclasses import replace

import numpy as np
import pytest
from balance.problems import everything

from stickslip.analyses.forced_response import forced_response
from stickslip.model.contact.point import MeanTraction, SliderOffset
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.rigs import chain_of_three, chain_varying_load, three_mass_wedge
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.continuation import first_point
from stickslip.support.units import Band, hertz, radians_per_second

CASES = {
    "wedge": (three_mass_wedge(0.3), hertz(145.0, 235.0), (145.0, 170.0, 222.0)),
    "chain": (chain_varying_load(), radians_per_second(0.2, 0.28), (0.032, 0.036, 0.04)),
    "three masses": (chain_of_three(), radians_per_second(1.0, 1.6), (0.16, 0.19, 0.22)),
    "everything": (everything(), radians_per_second(0.75, 1.15), (0.1, 0.14, 0.2)),
}


SOME_NIGHTLY = ["wedge", "everything", *(pytest.param(name, marks=pytest.mark.nightly) for name in ("chain", "three masses"))]


@pytest.mark.parametrize("name", SOME_NIGHTLY)
def test_the_same_input_gives_the_same_bits(name):
    problem, band, _ = CASES[name]
    first, second = (forced_response(problem, band, [0.5, 1.0], harmonics=4, samples=128).dataset for _ in range(2))
    first.attrs.pop("cpu_seconds"), second.attrs.pop("cpu_seconds")
    assert first.identical(second)


@pytest.mark.slow
@pytest.mark.parametrize("name", SOME_NIGHTLY)
def test_a_force_level_does_not_depend_on_the_others(name):
    problem, band, _ = CASES[name]
    alone = forced_response(problem, band, 1.0, harmonics=3, samples=128).dataset
    among = forced_response(problem, band, [0.5, 1.0], harmonics=3, samples=128).dataset.isel(case=1)
    points = alone.sizes["point"]
    np.testing.assert_array_equal(among.response[:points], alone.response[0])
    assert not among.outcome[points:].any()


@pytest.mark.parametrize("name", CASES)
def test_the_order_of_contacts_does_not_matter(name):
    problem, _, frequencies = CASES[name]
    turned = replace(problem, contacts=problem.contacts[::-1])
    plain, other = (forced_response(p, frequencies, harmonics=4, samples=128).dataset for p in (problem, turned))
    scale = float(np.abs(plain.response).max())
    np.testing.assert_allclose(other.response, plain.response, atol=1e-9 * scale)
    forces = other.contact_force.sel(contact=plain.contact)
    np.testing.assert_allclose(forces, plain.contact_force, atol=1e-8 * float(np.abs(plain.contact_force).max()))


def later(force: Force, angle: float) -> Force:
    return replace(force, amplitude={h: a * np.exp(-1j * h * angle) for h, a in force.amplitudes.items()})


def shifted(problem: Problem, angle: float) -> Problem:
    return problem.with_forces([later(force, angle) for force in problem.forces])


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("start", [SliderOffset(), MeanTraction(0.05)], ids=lambda start: start.key)
@pytest.mark.parametrize("shift", [pytest.param(1, marks=pytest.mark.nightly), 41])
def test_a_later_force_gives_a_later_response(name, start, shift):
    """A delay of all forces by whole samples delays the response: X_h exp(−i h φ)."""
    problem, _, frequencies = CASES[name]
    if name == "wedge" and start == MeanTraction(0.05):
        start = MeanTraction(5.0)
    problem = problem.with_start(start)
    angle = 2.0 * np.pi * shift / 128
    plain, delayed = (
        forced_response(p, frequencies, harmonics=4, samples=128).dataset for p in (problem, shifted(problem, angle))
    )
    assert plain.sizes["point"] == len(frequencies)
    X, Y = (np.asarray(d.response[..., 0] + 1j * d.response[..., 1]) for d in (plain, delayed))
    moved = X * np.exp(-1j * np.arange(5) * angle)
    np.testing.assert_allclose(Y[..., 1:], moved[..., 1:], atol=1e-8 * np.abs(X[..., 1:]).max())


@pytest.mark.parametrize("name", ["three masses", "chain"])
def test_up_and_down_give_the_same_peaks(name):
    problem, band, _ = CASES[name]
    up, down = (forced_response(problem, b, harmonics=4, samples=128).peaks() for b in (band, Band(band.stop, band.start)))
    for column in ("frequency", "amplitude", "loss_factor"):
        np.testing.assert_allclose(up[column], down[column], rtol=2e-4)
    np.testing.assert_allclose(up.amplitude, down.amplitude, rtol=1e-6)


@pytest.mark.parametrize("name", CASES)
def test_points_of_a_curve_are_the_points_solved_alone(name):
    """A frequency that the swept curve passes once (beside folds), solved by itself, has the same response.

    The bands avoid places where samples that events pass make many small folds, which a sweep may step over.
    """
    problem, band, _ = CASES[name]
    swept = forced_response(problem, band, harmonics=4, samples=128).dataset
    f = swept.frequency.values[0]
    once = [k for k in range(1, f.size - 1) if np.sum((f[:-1] - f[k]) * (f[1:] - f[k]) <= 0.0) == 2]
    assert len(once) > 0.5 * f.size
    some = swept.isel(case=0, point=once[::7])
    alone = forced_response(problem, [band.start / 1.000001, *some.frequency.values], harmonics=4, samples=128).dataset
    order = np.argsort(some.frequency.values)
    np.testing.assert_allclose(alone.frequency[0, 1:], some.frequency[order], rtol=1e-13)
    np.testing.assert_allclose(alone.response[0, 1:], some.response[order], atol=1e-8 * float(np.abs(some.response).max()))


def test_units_of_force_and_length_do_not_matter():
    """Newton and millimetre: K in N/mm, M in t (10³ kg), gaps in mm. The wedge, whose numbers are of engineering size."""
    plain = three_mass_wedge(0.3)
    structure = replace(plain.structure, M=1e-3 * plain.structure.M, K=1e-3 * plain.structure.K, C=1e-3 * plain.structure.C)
    changed = plain.with_structure(structure).with_contacts(lambda c: c.with_law(replace(c.law, kt=300.0, kn=300.0)))
    first, second = (forced_response(p, [145.0, 222.0], harmonics=4).dataset for p in (plain, changed))
    np.testing.assert_allclose(second.response, 1e3 * first.response, atol=1e-9 * float(np.abs(second.response).max()))
    np.testing.assert_allclose(second.contact_force, first.contact_force, atol=1e-7)


@pytest.mark.parametrize("omega", [0.9, 0.8999999999999999, 0.7, 1.3])
def test_a_prescribed_frequency_stays_to_the_last_bit(omega):
    """A frequency listed in a study is found again among the solved ones; pivoting alone would leave rounding in it."""
    found = first_point(HarmonicBalance(everything(), 4, 256), omega, 1.0)
    assert found.converged
    assert found.evaluation.point.omega == omega
