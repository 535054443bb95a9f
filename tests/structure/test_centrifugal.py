"""Rotation: Southwell's coefficients of a beam, and Wright's frequencies at speed."""

import numpy as np
import pytest
from scipy import integrate, optimize
from scipy.sparse import linalg

from stickslip.model.structure.centrifugal import spin_stiffness, spinning
from stickslip.model.structure.solid import Material, box_mesh, solid

LENGTH, DEPTH, THICKNESS = 1.0, 0.03, 0.02
SOFT = Material(210e9, 0.0, 7850.0)
"""Without lateral contraction the clamped end is that of a beam."""


def beam(hub):
    mesh = box_mesh(hub + np.linspace(0.0, LENGTH, 13), [-0.5 * DEPTH, 0.5 * DEPTH], [-0.5 * THICKNESS, 0.5 * THICKNESS])
    return mesh, solid(mesh, SOFT).clamp(lambda p: p[:, 0] < hub + 1e-9)


def first_mode(body, axis):
    squares, shapes = linalg.eigsh(body.K, 4, body.M, sigma=0.0)
    tip = [abs(shape[body.numbers[body.node([body.points[:, 0].max(), 0.5 * DEPTH, 0.0]), axis]]) for shape in shapes.T]
    k = next(k for k in range(4) if tip[k] > 0.5 * max(tip))
    return squares[k], shapes[:, k]


def southwell(hub):
    """∫ (½(L² − x²) + r(L − x)) φ'² dx / ∫ φ² dx with the cantilever's first mode: dω²/dΩ² of bending along the axis, exactly."""
    k = optimize.brentq(lambda k: np.cos(k) * np.cosh(k) + 1.0, 1.5, 2.5)
    ratio = (np.cos(k) + np.cosh(k)) / (np.sin(k) + np.sinh(k))

    def shape(x):
        return np.cosh(k * x) - np.cos(k * x) - ratio * (np.sinh(k * x) - np.sin(k * x))

    def slope(x):
        return k * (np.sinh(k * x) + np.sin(k * x) - ratio * (np.cosh(k * x) - np.cos(k * x)))

    pull = integrate.quad(lambda x: (0.5 * (1.0 - x**2) + hub * (1.0 - x)) * slope(x) ** 2, 0.0, 1.0)[0]
    return pull / integrate.quad(lambda x: shape(x) ** 2, 0.0, 1.0)[0]


@pytest.mark.parametrize("hub", [0.0, 0.5])
def test_southwell_coefficients_of_a_beam(hub):
    """Bending along the axis of rotation, and in its plane, where the softening takes 1 away. Slenderness leaves 3e-3."""
    mesh, body = beam(hub)
    S = spin_stiffness(body, mesh, SOFT)
    for axis, softening in ((2, 0.0), (1, 1.0)):
        _, shape = first_mode(body, axis)
        found = (shape @ (S @ shape)) / (shape @ (body.M @ shape))
        assert found == pytest.approx(southwell(hub) - softening, abs=3e-3 * southwell(hub))


def test_a_spinning_beam_has_the_published_frequency():
    """Wright et al., J. Appl. Mech. 49 (1982): 3.5160 at rest, 4.1373 at 2 and 4.7973 at 3, in units of √(EI/ρA)/L²."""
    mesh, body = beam(0.0)
    unit = THICKNESS * np.sqrt(SOFT.young / (12.0 * SOFT.density)) / LENGTH**2
    for speed, published in ((2.0, 4.1373), (3.0, 4.7973)):
        square, _ = first_mode(spinning(body, mesh, SOFT, speed * unit), 2)
        assert np.sqrt(square) / unit == pytest.approx(published, rel=3e-3)
