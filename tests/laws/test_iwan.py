"""Iwan's law against closed forms: a cylinder on a flat, Segalman's joint, Mindlin's sphere, other pressures.

Hertz, F = μN, x_s = 4F/(π kt), s = A/x_s: W = (8 F x_s/π)[s asin s + 2c − 2 + (2/3)(1 − c³) − s² c], c = √(1 − s²); gross
slip 4F (A − 8 x_s/(3π)). Segalman: W = 4 R A^(χ+3)/((χ+2)(χ+3)). Sphere (Mindlin and Deresiewicz):
W = 9 (2 − ν)(μN)²/(10 G a) {1 − (1 − z)^(5/3) − (5z/6)[1 + (1 − z)^(2/3)]}, z = T/(μN).
"""

import numpy as np
import pytest
from scipy import integrate

from stickslip.analyses.forced_response import forced_response
from stickslip.analyses.time_response import time_response
from stickslip.model.contact.microslip import FourParameter, Hertz, Iwan, MicroslipArray, Parabolic
from stickslip.model.contact.point import Contact, between
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.structure.matrices import Structure
from stickslip.solve.time.period import GeneralisedAlpha
from stickslip.support.checks import InputError

SPECTRA = (
    Hertz(),
    Parabolic(0.0),
    Parabolic(0.4),
    Parabolic(1.0),
    Parabolic(3.0),
    FourParameter(-0.4, 0.7),
    FourParameter(0.674, 0.3),
)
F, KT = 1.3, 2.1
XS = 4.0 * F / (np.pi * KT)


def hertz(count: int) -> Iwan:
    return Iwan(KT, 1.0, normal_load=F, count=count)


def continuous_curve(law: Iwan, u: float) -> float:
    """Virgin curve of the spread itself, without elements, N."""
    limit = law.mu * law.normal_load
    return limit * float(law.spectrum.virgin(u * law.kt / limit))


def continuous_energy(law: Iwan, amplitude: float) -> float:
    """Loop energy of the spread itself, without elements, J."""
    limit = law.mu * law.normal_load
    return limit**2 / law.kt * float(law.spectrum.loop_energy(amplitude * law.kt / limit))


@pytest.mark.parametrize(("share", "energy"), [(0.1, 4.3575e-5), (0.5, 2.86961625e-2), (0.9, 0.359961965), (1.5, 2.668912461)])
def test_loop_energy_of_a_cylinder_on_a_flat(share, energy):
    """The printed values; 2000 elements keep them to 1e-5."""
    law = hertz(2000)
    assert continuous_energy(law, share * XS) == pytest.approx(energy, rel=1e-6 if share > 0.1 else 1e-5)
    assert law.loop_energy(share * XS) == pytest.approx(continuous_energy(law, share * XS), rel=1e-5)


def test_the_curve_of_the_published_law():
    """T of equation 1 of the source, arctangent and square root as printed."""
    for x in np.linspace(0.01, 0.99, 23) * XS:
        root = np.sqrt((4.0 * F) ** 2 - (np.pi * KT * x) ** 2)
        printed = 2.0 * F / np.pi * np.arctan(np.pi * KT * x / root) + KT * x / (8.0 * F) * root
        assert continuous_curve(hertz(20), x) == pytest.approx(printed, rel=1e-12)


def test_a_sphere_on_a_flat():
    G, nu, a, mu, N = 80e3, 0.3, 0.2, 0.3, 10.0
    for traction, energy in ((0.3, 2.8467246e-8), (1.5, 5.0514546e-6), (2.7, 5.7552620e-5)):
        motion = 3.0 * (2.0 - nu) * mu * N / (16.0 * G * a) * (1.0 - (1.0 - traction / (mu * N)) ** (2.0 / 3.0))
        law = Iwan(8.0 * G * a / (2.0 - nu), mu, normal_load=N, spectrum=Parabolic(0.0), count=2000)
        assert continuous_curve(law, motion) == pytest.approx(traction, rel=1e-12)
        assert continuous_energy(law, motion) == pytest.approx(energy, rel=1e-7)
        assert law.loop_energy(motion) == pytest.approx(energy, rel=1e-5)


@pytest.mark.parametrize("chi", [-0.4, 0.674, 2.0])
def test_the_four_parameters_of_segalman(chi):
    """χ = 0.674 is what the damping of a measured jointed beam asks for (the Brake-Reuss beam of Cenedese et al. 2021)."""
    beta, stiffness, limit = 0.7, 2.0, 1.5
    last = limit * (1.0 + beta) / (stiffness * (beta + (chi + 1.0) / (chi + 2.0)))
    R = stiffness * (chi + 1.0) / (last ** (chi + 1.0) * (1.0 + beta))
    law = Iwan(stiffness, 1.0, normal_load=limit, spectrum=FourParameter(chi, beta), count=2000)
    for A in (0.2 * last, 0.7 * last):
        power = 4.0 * R * A ** (chi + 3.0) / ((chi + 2.0) * (chi + 3.0))
        assert continuous_energy(law, A) == pytest.approx(power, rel=1e-12)
        assert law.loop_energy(A) == pytest.approx(power, rel=1e-5)
    assert continuous_curve(law, 2.0 * last) == pytest.approx(limit, rel=1e-12)


@pytest.mark.parametrize("spectrum", SPECTRA, ids=repr)
def test_every_spectrum_is_a_whole(spectrum):
    """Unit stiffness at rest, unit force in gross slip, energy of Masing's rule 8 ∫T − 4 A T(A), elements with both sums."""
    assert spectrum.virgin(1e-3 * max(spectrum.first, 1e-3)) / (1e-3 * max(spectrum.first, 1e-3)) == pytest.approx(1.0, abs=2e-2)
    assert spectrum.virgin(1.5 * spectrum.last) == pytest.approx(1.0, rel=1e-12)
    for A in (0.3, 0.9, 1.6):
        area, _ = integrate.quad(spectrum.virgin, 0.0, A, points=[min(spectrum.first, A), min(spectrum.last, A)], limit=200)
        assert spectrum.loop_energy(A) == pytest.approx(8.0 * area - 4.0 * A * spectrum.virgin(A), abs=2e-8)
    for count in (2, 7, 40):
        stiffness, slip = spectrum.elements(count)
        assert stiffness.sum() == pytest.approx(1.0, rel=1e-12)
        assert (stiffness * slip).sum() == pytest.approx(1.0, rel=1e-12)
        assert np.all(slip > 0.0)


@pytest.mark.parametrize("spectrum", [*SPECTRA, FourParameter(-0.9, 0.5), FourParameter(3.0, 1.0)], ids=repr)
def test_without_a_count_energy_and_curve_are_within_two_thousandths(spectrum):
    """At every amplitude from 1 % of full slip on, sums of the elements against the closed forms of the spread."""
    stiffness, slip = spectrum.elements()
    A = spectrum.first + (spectrum.last - spectrum.first) * np.geomspace(1e-2, 1.5, 3000)
    energy = np.array([np.sum(np.maximum(4.0 * stiffness * slip * (a - slip), 0.0)) for a in A])
    virgin = np.array([np.sum(stiffness * np.minimum(a, slip)) for a in A])
    assert energy == pytest.approx(spectrum.loop_energy(A), rel=2e-3, abs=1e-300)
    assert virgin == pytest.approx(spectrum.virgin(A), rel=2e-3)


def test_the_elements_hardly_ever_jump_with_a_parameter():
    """Derivatives by χ and β are differences: their steps must see a smooth law."""
    sizes = {FourParameter(0.674 * (1.0 + step), 0.3).elements()[1].size for step in (-1e-5, 0.0, 1e-5)}
    assert len(sizes) == 1
    low, high = (FourParameter(chi, 0.3).elements()[1] for chi in (0.674, 0.674001))
    assert high == pytest.approx(low, rel=1e-4)


def test_few_elements_move_the_damping_of_a_loop_more():
    """20 elements at 2 % of full slip: what the number of elements was before it followed from an error."""
    spectrum = FourParameter(0.674, 0.3)
    A = 0.02 * spectrum.last
    errors = []
    for count in (20, None):
        stiffness, slip = spectrum.elements(count)
        errors.append(abs(np.sum(np.maximum(4.0 * stiffness * slip * (A - slip), 0.0)) / spectrum.loop_energy(A) - 1.0))
    assert errors[0] > 0.01
    assert errors[1] < 2e-3


def test_uniform_pressure_is_macroslip_and_an_array_of_the_same_elements_is_the_law():
    assert Parabolic(1.0).elements(20)[0].size == 1
    share, slip = Hertz().elements(12)
    law = Iwan(KT, 0.5, normal_load=2.0, count=12)
    array = MicroslipArray(tuple(KT * share), 0.5, normal_load=tuple(2.0 * share * slip))
    for A in (0.1, 0.4, 2.0):
        assert law.loop_energy(A) == pytest.approx(array.loop_energy(A), rel=1e-14)


@pytest.mark.parametrize("spectrum", [Hertz(), Parabolic(0.0), FourParameter(-0.5, 0.0)], ids=repr)
def test_energy_grows_with_a_power_of_the_amplitude(spectrum):
    """4 for a line contact, 3 for a sphere, χ + 3 for Segalman's joint."""
    exponent = np.log2(spectrum.loop_energy(2e-3) / spectrum.loop_energy(1e-3))
    expected = {Hertz: 4.0, Parabolic: 3.0, FourParameter: 2.5}[type(spectrum)]
    assert exponent == pytest.approx(expected, abs=2e-3)


def test_separating_and_landing_in_time_and_in_harmonics():
    """A mass on an Iwan contact that lifts off in every period: harmonic balance against time integration."""
    law = Iwan(60.0, 0.5, 80.0, count=8)
    contact = Contact("joint", law, (between("1.x", "ground"),), between("1.y", "ground"))
    structure = Structure(np.eye(2), np.array([[40.0, -8.0], [-8.0, 60.0]]), ("1.x", "1.y"), C=np.diag([1.2, 1.5]))
    forces = (Force("1.x", 6.0), Force("1.y", 9.0j, static=4.0))
    problem = Problem(structure, (contact,), forces, ("1.x", "1.y"))
    frequency = 1.1
    balance = forced_response(problem, [frequency], [1.0], harmonics=21, samples=512).dataset
    time = time_response(problem, frequency, 1.0, steps_per_period=2000, method=GeneralisedAlpha(0.8)).dataset
    assert float(balance.share_open.max()) > 0.05
    assert float(balance.share_slip.max()) > 0.05
    for output in range(2):
        assert float(balance.amplitude[0, 0, output]) == pytest.approx(float(time.amplitude[output]), rel=1e-4)


def test_wrong_numbers_are_refused():
    with pytest.raises(InputError, match="either kn or normal_load"):
        Iwan(1.0, 0.5)
    with pytest.raises(InputError, match="count must be at least 2"):
        Iwan(1.0, 0.5, 1.0, count=1)
    for chi in (-1.0, np.nan, np.inf):
        with pytest.raises(InputError, match="chi must lie above -1"):
            FourParameter(chi)


def test_wrong_spectrum_and_count_are_refused():
    for change in ({"spectrum": "hertz"}, {"count": "many"}, {"count": 1}):
        with pytest.raises(InputError):
            Iwan(kt=1.0, mu=0.3, normal_load=1.0, **change)
