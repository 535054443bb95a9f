"""Energies, loss factor and shares of a forced response against closed forms; the two energy numbers reveal wrong solutions."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from balance.problems import everything

from stickslip.analyses.forced_response import forced_response
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.rigs import chain_varying_load, single_mass, three_mass_wedge
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.energy import EnergyBalance, cycle_work
from stickslip.solve.continuation.newton import correct, fixed

LIMIT, KT = 1.2, 0.5


@pytest.mark.parametrize("omega", [1.05, 1.1, 1.15])
def test_one_harmonic_of_a_single_mass(omega):
    """W = 4 Fc (A − Fc/kt), W_viscous = π c ω A², U = ½ (k + kt) A², input = π F A sin φ; stick for t*/π of the period."""
    dataset = forced_response(
        single_mass(damping=0.01, kt=KT, limit=LIMIT), [omega / (2 * pi)], harmonics=1, samples=16384
    ).dataset
    point = dataset.isel(case=0, point=0)
    amplitude = float(point.amplitude[0])
    friction, viscous = 4.0 * LIMIT * (amplitude - LIMIT / KT), pi * 0.01 * omega * amplitude**2
    assert amplitude > LIMIT / KT
    assert float(point.dissipated[0]) == pytest.approx(friction, rel=1e-6)
    eta = (friction + viscous) / (2.0 * pi * 0.5 * (1.0 + KT) * amplitude**2)
    assert float(point.loss_factor) == pytest.approx(eta, rel=1e-6)
    given = pi * -float(point.response[0, 1, 1])
    assert given == pytest.approx(friction + viscous, rel=1e-6)
    stick = np.arccos(1.0 - 2.0 * LIMIT / KT / amplitude) / pi
    assert float(point.share_stick[0, 0]) == pytest.approx(stick, abs=3e-4)
    assert float(point.share_slip[0, 0]) == pytest.approx(1.0 - stick, abs=3e-4)
    assert float(point.share_open[0, 0]) == 0.0


def test_loss_factor_of_a_stuck_resonance_is_twice_the_damping_ratio():
    """η = c ω/k_stuck for one viscous mode: at resonance 2ζ."""
    problem = single_mass(damping=0.03, kt=1.0, limit=1e6)
    point = forced_response(problem, [2.0**0.5 / (2 * pi)], harmonics=2).dataset.isel(case=0, point=0)
    assert float(point.loss_factor) == pytest.approx(0.03 * 2.0**0.5 / 2.0, rel=1e-9)
    assert float(point.dissipated[0]) == 0.0


def test_work_of_a_harmonic_force():
    """∮ F dx for F = 3 cos(θ + 1), x = 2 cos θ and two harmonics more, by quadrature over the period."""
    theta = 2.0 * pi * np.arange(4000) / 4000
    force, motion = np.array([1.0, 3.0 * np.cos(1.0), -3.0 * np.sin(1.0), 0.5, 0.2]), np.array([0.3, 2.0, 0.0, -0.4, 0.7])
    f = (
        force[0]
        + force[1] * np.cos(theta)
        + force[2] * np.sin(theta)
        + force[3] * np.cos(2 * theta)
        + force[4] * np.sin(2 * theta)
    )
    slope = -motion[1] * np.sin(theta) + 2.0 * (-motion[3] * np.sin(2 * theta) + motion[4] * np.cos(2 * theta))
    assert float(cycle_work(force, motion)) == pytest.approx(float(np.mean(f * slope)) * 2.0 * pi, rel=1e-12)


CASES = {
    "everything": (everything(), 0.9),
    "wedge": (three_mass_wedge(0.0), 2 * pi * 222.0),
    "chain": (chain_varying_load(), 0.2419),
}


@pytest.mark.parametrize("name", CASES)
def test_slip_work_converges_with_second_order(name):
    """|Σ μN|Δs| − contact work| falls with the square of the samples: slope fitted over six numbers of samples."""
    problem, omega = CASES[name]
    samples = np.array([64, 128, 256, 512, 1024, 2048])
    errors = [
        float(forced_response(problem, [omega / (2 * pi)], harmonics=4, samples=int(n)).dataset.slip_work_error[0, 0])
        for n in samples
    ]
    assert errors[2] < 1e-3
    slope = np.polyfit(np.log(samples), np.log(errors), 1)[0]
    assert slope == pytest.approx(-2.0, abs=0.5)


@pytest.mark.parametrize("name", CASES)
def test_energy_residual_tells_a_solution_from_a_near_miss(name):
    """Input − viscous − contact work: nothing at a solution, of the order of the error beside it."""
    problem, omega = CASES[name]
    balance = HarmonicBalance(problem, 4, 128)
    solved = correct(balance, balance.stuck_point(omega, 1.0), fixed("omega", omega), iterations=60, halvings=12).evaluation
    energy = EnergyBalance(balance)
    wrong = balance.evaluate(solved.point.moved(1e-3 * np.roll(solved.point.forces, 1, axis=0), "omega", 0.0))
    numbers = energy.along([solved, wrong]).energy_residual
    assert numbers[0] < 1e-9
    assert numbers[1] > 1e-6


@pytest.mark.parametrize("name", CASES)
def test_contacts_never_create_energy(name):
    problem, omega = CASES[name]
    frequencies = np.linspace(0.8, 1.2, 7) * omega / (2 * pi)
    dataset = forced_response(problem, frequencies, [0.2, 1.0, 3.0], harmonics=4).dataset
    dissipated = dataset.dissipated.where(dataset.outcome == 1)
    assert float(dissipated.min()) > -1e-3 * float(dissipated.max())
    assert float(dataset.energy_residual.max()) < 1e-8


def test_stuck_contacts_dissipate_exactly_nothing():
    problem = three_mass_wedge(0.0)
    stiff = problem.with_contacts(lambda c: replace(c, law=Macroslip(3e5, 0.7, 3e5)))
    point = forced_response(stiff, [222.0], 0.05, harmonics=3).dataset.isel(case=0, point=0)
    stuck = (point.share_stick.sel(direction="t1") == 1.0) & (point.share_stick.sel(direction="n") == 1.0)
    assert bool(stuck.any())
    assert np.all(point.dissipated.to_numpy()[stuck.to_numpy()] == 0.0)
