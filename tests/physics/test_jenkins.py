"""One Jenkins element in harmonic motion u = A cos θ against Griffin's closed forms, with second-order convergence in samples.

kd spring, Fc = μN limit, Ac = Fc/kd. A ≤ Ac: F = kd u. A > Ac: t* = arccos(1 − 2 Ac/A),
k_eq = (kd/π)(t* − ½ sin 2t*), h = (4 Fc/(πA))(1 − Ac/A), dW = πhA² = 4 Fc (A − Ac). Griffin (1980), Caughey (1960).
"""

import numpy as np
import pytest
from laws.kernel import carried

from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact, between, contact_table
from stickslip.solve.balance.energy import contact_cycle
from stickslip.solve.balance.fourier import fourier

KD, FC = 2.0, 3.0
AMPLITUDES = (1.6, 1.9, 2.3, 3.0, 3.7, 5.1, 7.7, 10.0)


def k_eq_and_h(amplitude: float) -> tuple[float, float]:
    critical = FC / KD
    if amplitude <= critical:
        return KD, 0.0
    angle = np.arccos(1.0 - 2.0 * critical / amplitude)
    stiffness = KD / np.pi * (angle - 0.5 * np.sin(2.0 * angle))
    return float(stiffness), 4.0 * FC / (np.pi * amplitude) * (1.0 - critical / amplitude)


def measured(amplitude: float, samples: int, harmonics: int = 1, kd: float = KD, limit: float = FC) -> np.ndarray:
    """Force harmonics (2H+1,) for u = A cos θ."""
    contact = Contact("c", Macroslip(kd, 1.0, normal_load=limit), (between("1.x", "ground"),))
    w = np.zeros((1, 2 * harmonics + 1))
    w[0, 1] = amplitude
    return carried(contact, w, samples)[0]


def errors(samples: int) -> np.ndarray:
    """Relative errors of k_eq and h at all amplitudes, (2, amplitudes)."""
    found = np.array([[f[1] / a, -f[2] / a] for a, f in ((a, measured(a, samples)) for a in AMPLITUDES)])
    exact = np.array([k_eq_and_h(a) for a in AMPLITUDES])
    return (found / exact - 1.0).T


@pytest.mark.parametrize(
    ("amplitude", "stiffness", "damping"),
    [(1.6, 1.9479544512562, 0.1492077591486), (3.0, 1.0, 0.6366197723676), (10.0, 0.1881204043742, 0.3246760839075)],
)
def test_values_of_an_independent_script(amplitude, stiffness, damping):
    assert k_eq_and_h(amplitude) == pytest.approx((stiffness, damping), rel=1e-12)
    force = measured(amplitude, 8192)
    assert force[1] / amplitude == pytest.approx(stiffness, rel=1e-6)
    assert -force[2] / amplitude == pytest.approx(damping, rel=1e-6)


def test_one_part_in_a_million_at_4096_samples():
    assert np.abs(errors(4096)).max() < 1e-6


def test_second_order_in_the_samples():
    """Root mean square over amplitudes (where a slip falls between two samples is chance), 256 to 4096 samples."""
    size = {n: np.sqrt(np.mean(errors(n) ** 2)) for n in (256, 512, 1024, 2048, 4096)}
    assert np.log2(size[256] / size[4096]) / 4.0 == pytest.approx(2.0, abs=0.15)
    assert size[256] < 3e-4


@pytest.mark.parametrize("amplitude", [0.3, 1.0, 1.49999])
def test_stuck_below_the_limit_exactly(amplitude):
    force = measured(amplitude, 256, harmonics=5)
    np.testing.assert_array_equal(force, KD * np.array([0, amplitude, *np.zeros(9)]))


def test_force_leads_the_motion():
    """Dissipation is positive: with u = A cos θ, the part b₁ sin θ = −A h sin θ is in phase with the velocity."""
    assert measured(3.0, 256)[2] < 0.0


@pytest.mark.parametrize("amplitude", [2.0, 4.0])
def test_energy_per_cycle(amplitude):
    exact = 4.0 * FC * (amplitude - FC / KD)
    law = Macroslip(KD, 1.0, normal_load=FC)
    assert law.loop_energy(amplitude) == pytest.approx(exact, rel=1e-14)
    assert np.pi * amplitude * -measured(amplitude, 4096)[2] == pytest.approx(exact, rel=1e-6)
    contact = Contact("c", law, (between("1.x", "ground"),))
    w = np.array([[0.0, amplitude, 0.0]])
    slip_work = contact_cycle(contact_table([contact]), fourier(1, 4096), w, 1.0).slip_work
    assert slip_work[0] == pytest.approx(exact, rel=1e-5)


def test_large_motion_is_coulomb_friction():
    """A → ∞: sign(u̇) Fc, with harmonics 4 Fc/(π h) for odd h."""
    force = measured(1e6, 65536, harmonics=6)
    sine = -force[2::2]
    np.testing.assert_allclose(sine, 4.0 * FC / np.pi * np.array([1, 0, 1 / 3, 0, 1 / 5, 0]), atol=2e-4)
    np.testing.assert_allclose(force[1::2], 0.0, atol=1e-2)
