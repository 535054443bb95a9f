"""Jenkins arrays as samplings of continuous microslip laws: the half-ellipse of a Hertz contact, and Iwan's power law.

A continuous law T(u) of the Masing kind has the slider density −T''(u); an array of n elements with slip displacements x_i and
stiffnesses T'(x before) − T'(x after) has the virgin curve and, by Masing's rule, the loops of T as n grows.
"""

import numpy as np
import pytest
from laws.kernel import forces
from laws.samples import Element, Sample

from stickslip.model.contact.microslip import MicroslipArray
from stickslip.model.contact.point import SliderOffset
from stickslip.solve.balance.energy import cycle_work

F, KT = 1.3, 2.1
XS = 4.0 * F / (np.pi * KT)


def sampled_law(slope, largest: float, elements: int) -> MicroslipArray:
    """Elements that slip at the middles of n equal steps up to `largest`; each takes the drop of the slope over its step."""
    edges = np.linspace(0.0, largest, elements + 1)
    stiffness = -np.diff([slope(edge) for edge in edges])
    middles = 0.5 * (edges[1:] + edges[:-1])
    return MicroslipArray(tuple(stiffness), 1.0, normal_load=tuple(stiffness * middles))


def half_ellipse(elements: int) -> MicroslipArray:
    """T'(x) = kt √(1 − (x/x_s)²): brush model with Hertz line pressure; T = (2F/π)(asin s + s √(1 − s²))."""
    return sampled_law(lambda x: KT * np.sqrt(max(1.0 - (x / XS) ** 2, 0.0)), XS, elements)


def test_virgin_curve_and_saturation():
    law, s = half_ellipse(2000), np.array([0.1, 0.4, 0.8, 0.99])
    exact = 2.0 * F / np.pi * (np.arcsin(s) + s * np.sqrt(1.0 - s**2))
    np.testing.assert_allclose([law.virgin_curve(x * XS) for x in s], exact, rtol=1e-6)
    assert law.virgin_curve(2.0 * XS) == pytest.approx(F, rel=1e-5)
    assert sum(law.kt) == pytest.approx(KT, rel=1e-12)


ENERGIES = [(0.1, 4.3575e-5), (0.5, 2.86961625e-2), (0.9, 0.359961965), (1.5, 2.668912461)]
"""A/x_s and energy per cycle for F = 1.3, kt = 2.1: independent script of this project."""


@pytest.mark.parametrize(("ratio", "energy"), ENERGIES)
def test_loop_energy(ratio, energy):
    """Order 2 in the number of elements inside; 1.5 where the vertical end of the ellipse slips too."""
    s, c = ratio, np.sqrt(max(1.0 - ratio**2, 0.0))
    loop = 8.0 * F * XS / np.pi * (s * np.arcsin(min(s, 1.0)) + 2.0 * c - 2.0 + 2.0 / 3.0 * (1.0 - c**3) - s**2 * c)
    exact = 4.0 * F * (ratio * XS - 8.0 * XS / (3.0 * np.pi)) if ratio > 1.0 else loop
    assert exact == pytest.approx(energy, rel=1e-5 if ratio == 0.1 else 1e-8)
    errors = [abs(half_ellipse(n).loop_energy(ratio * XS) / exact - 1.0) for n in (625, 10000)]
    assert errors[-1] < 1e-6
    assert np.log2(errors[0] / errors[-1]) / 4.0 > 1.45


def test_gaps_spread_evenly_from_nothing_to_the_largest():
    """n equal springs with gaps from 0 to g: at z = g the last one only touches, and N = kn g/2."""
    gap = 0.2
    forces = MicroslipArray.from_totals(3.0, 5.0, 0.4, gap, elements=7).elements(1, True).normal.forces(gap)
    assert forces.sum() == pytest.approx(0.5 * 5.0 * gap, rel=1e-12)
    assert forces[-1] == pytest.approx(0.0, abs=1e-15)


def test_loop_energy_of_the_kernel():
    """The same from forces sampled over the cycle, 100 elements: the closed sum of the array, and near the continuous law."""
    law = half_ellipse(100)
    elements = tuple(Element(k, 1.0, load=n) for k, n in zip(law.kt, law.normal_load, strict=True))
    w = np.array([[0.0, 0.9 * XS, 0.0]])
    found = cycle_work(forces(Sample("array", law, 1, elements), SliderOffset(), w, 4096), w)[0]
    assert found == pytest.approx(law.loop_energy(0.9 * XS), rel=1e-6)
    assert found == pytest.approx(0.359961965, rel=1e-3)


def test_small_loops_grow_with_the_fourth_power():
    law = half_ellipse(20000)
    energies = [law.loop_energy(a * XS) for a in (0.02, 0.04)]
    assert np.log2(energies[1] / energies[0]) == pytest.approx(4.0, abs=0.01)
    assert energies[1] == pytest.approx(4.0 * F * XS / (3.0 * np.pi) * 0.04**4, rel=2e-3)


@pytest.mark.parametrize("exponent", [-0.5, 0.3])
def test_four_parameter_iwan_law(exponent):
    """Segalman's density R f^χ on (0, f_max) and S δ(f − f_max): T = K_T u − R u^(χ+2)/((χ+1)(χ+2)),
    dW = 4 R A^(χ+3)/((χ+2)(χ+3))."""
    R, S, largest, n = 1.7, 0.6, 0.8, 20000
    initial = R * largest ** (exponent + 1.0) / (exponent + 1.0) + S
    edges = largest * np.linspace(0.0, 1.0, n + 1) ** 2
    drop = R * np.diff(edges ** (exponent + 1.0)) / (exponent + 1.0)
    moment = R * np.diff(edges ** (exponent + 2.0)) / (exponent + 2.0)
    law = MicroslipArray((*drop, S), 1.0, normal_load=(*moment, S * largest))
    amplitude = 0.4
    exact = 4.0 * R * amplitude ** (exponent + 3.0) / ((exponent + 2.0) * (exponent + 3.0))
    assert law.loop_energy(amplitude) == pytest.approx(exact, rel=1e-6)
    curve = initial * amplitude - R * amplitude ** (exponent + 2.0) / ((exponent + 1.0) * (exponent + 2.0))
    assert law.virgin_curve(amplitude) == pytest.approx(curve, rel=1e-6)
    saturation = R * largest ** (exponent + 2.0) / (exponent + 2.0) + S * largest
    assert law.virgin_curve(9.0) == pytest.approx(saturation, rel=1e-9)
