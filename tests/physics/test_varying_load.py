"""One Jenkins element whose normal load varies in phase with its motion, N = n0 + κu, u = A sin θ: the loop is a quadrilateral.

Corners (A, μ(n0 + κA)), (u1, −μ(n0 + κu1)), (−A, −μ(n0 − κA)), (u2, μ(n0 + κu2)) with
u1 = (kd A − 2μ n0 − μκA)/(kd + μκ), u2 = (2μ n0 − (kd + μκ)A)/(kd − μκ).
"""

import numpy as np
import pytest
from laws.kernel import cycle, forces
from laws.samples import Element, Sample

from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import SliderOffset
from stickslip.solve.balance.energy import cycle_work

KD, MU, N0, KAPPA, A = 2.0, 0.5, 1.0, 0.3, 2.0
SAMPLE = Sample("in phase", Macroslip(KD, MU, KAPPA, N0), 1, (Element(KD, MU, KAPPA, preload=N0),))
MOTION = np.array([[0.0, 0.0, A], [0.0, 0.0, A]])


def quadrilateral() -> np.ndarray:
    u1 = (KD * A - 2.0 * MU * N0 - MU * KAPPA * A) / (KD + MU * KAPPA)
    u2 = (2.0 * MU * N0 - (KD + MU * KAPPA) * A) / (KD - MU * KAPPA)
    limits = {u: MU * (N0 + KAPPA * u) for u in (A, u1, -A, u2)}
    return np.array([[A, limits[A]], [u1, -limits[u1]], [-A, -limits[-A]], [u2, limits[u2]]])


def area(corners: np.ndarray) -> float:
    x, y = corners.T
    return 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))


def test_energy_of_the_quadrilateral():
    """3.36140792 J: independent script of this project."""
    assert area(quadrilateral()) == pytest.approx(3.36140792, rel=1e-8)
    works = {n: cycle_work(forces(SAMPLE, SliderOffset(), MOTION, n), MOTION)[0] for n in (4096, 16384)}
    assert works[4096] == pytest.approx(3.36140792, rel=1e-6)
    assert works[16384] == pytest.approx(3.36140792, rel=1e-7)


def test_every_sample_lies_on_the_quadrilateral():
    """Distance of the sampled loop from the four sides, but for the samples at the corners' sides."""
    loop = cycle(SAMPLE, SliderOffset(), MOTION, 4096)
    points = np.column_stack([loop.displacement[0], loop.force[0]])
    corners = quadrilateral()
    sides = np.roll(corners, -1, axis=0) - corners
    offsets = points[:, None, :] - corners[None, :, :]
    distance = np.abs(offsets[..., 0] * sides[:, 1] - offsets[..., 1] * sides[:, 0]) / np.hypot(*sides.T)
    assert np.max(np.min(distance, axis=1)) < 1e-6
    assert len(np.unique(np.argmin(distance, axis=1))) == 4


def test_second_order_in_the_samples():
    def error(samples: int) -> float:
        gaps = []
        for phase in np.linspace(0.1, 1.4, 10):
            w = A * np.array([[0.0, np.sin(phase), np.cos(phase)]] * 2)
            gaps.append(cycle_work(forces(SAMPLE, SliderOffset(), w, samples), w)[0] - area(quadrilateral()))
        return float(np.sqrt(np.mean(np.square(gaps))))

    assert np.log2(error(256) / error(4096)) / 4.0 == pytest.approx(2.0, abs=0.25)
