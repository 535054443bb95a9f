"""Contact stiffness from geometry, against published digits, closed forms and differences."""

import numpy as np
import pytest

from stickslip.analyses.hysteresis_loop import contact_stiffness
from stickslip.model.contact.stiffness import (
    NORMAL_STIFFNESS,
    LineContact,
    SphereContact,
    brandlein_approach,
    harris_approach,
    static_normal_load,
)
from stickslip.support.checks import InputError

CYLINDER = LineContact(27.6e-3, 5e-3)


# The damper of "On the choice of contact parameters ...", equations 8 to 15, evaluated by an independent script.
@pytest.mark.parametrize(
    ("load", "half_width", "peak", "normal"),
    [
        (73.5, 12.12, 139.9, (6.321, 6.182, 5.938)),
        (84.9, 13.03, 150.3, (6.413, 6.249, 5.990)),
        (103.9, 14.41, 166.3, (6.544, 6.345, 6.063)),
        (147.0, 17.14, 197.8, (6.775, 6.512, 6.193)),
    ],
)
def test_published_cylinder(load, half_width, peak, normal):
    assert CYLINDER.half_width(load) * 1e6 == pytest.approx(half_width, abs=0.006)
    assert CYLINDER.peak_pressure(load) / 1e6 == pytest.approx(peak, abs=0.06)
    found = [float(formula(CYLINDER, load)) / 1e8 for formula in NORMAL_STIFFNESS.values()]
    assert found == pytest.approx(normal, abs=6e-4)


def test_static_load_of_the_damper():
    assert static_normal_load(147.0, 45.0) == pytest.approx(103.9447, abs=1e-4)


def test_newtons_and_millimetres():
    """The empirical formulas as they stand, in N and mm: 84.9 N on 27.6 mm."""
    assert harris_approach(84.9, 27.6e-3) == pytest.approx(3.84e-5 * 84.9**0.9 / 27.6**0.8 * 1e-3, rel=1e-14)
    assert brandlein_approach(84.9, 27.6e-3) == pytest.approx(4.05e-5 * 84.9**0.925 / 27.6**0.85 * 1e-3, rel=1e-14)


def test_allara_stiffness_is_the_slope_of_the_approach():
    """δ = C N/L (1 + ln (2L/b)²), b ~ √N, and k = dN/dδ: the square under the logarithm doubles it."""
    C, N, h = 2.0 * (1.0 - 0.09) / (np.pi * 210e9), 84.9, 1e-3

    def approach(load):
        return C * load / 27.6e-3 * (1.0 + np.log((2.0 * 27.6e-3 / CYLINDER.half_width(load)) ** 2))

    assert CYLINDER.approach(N) == pytest.approx(approach(N), rel=1e-12)
    assert CYLINDER.normal_stiffness(N) == pytest.approx(2.0 * h / (approach(N + h) - approach(N - h)), rel=1e-8)


@pytest.mark.parametrize("edge", [0.2, 0.7, 1.2])
def test_rounded_punch(edge):
    """Pressure in equilibrium with the load; half width from the angle; the sides of the formula are independent."""
    flat = 1e-5
    b = flat / np.sin(edge)
    punch = LineContact(27.6e-3, 5e-3, flat=flat)
    load = punch.length * (np.pi - 2 * edge - np.sin(2 * edge)) * punch.plane_modulus * b**2 / (4 * 5e-3)
    assert punch.half_width(load) == pytest.approx(b, rel=1e-12)
    nodes, weights = np.polynomial.legendre.leggauss(300)
    total = sum(
        0.5 * (high - low) * weights @ (punch.pressure(load, b * np.sin(angle)) * b * np.cos(angle))
        for low, high in ((0.0, edge), (edge, 0.5 * np.pi))
        for angle in [0.5 * (high + low) + 0.5 * (high - low) * nodes]
    )
    assert 2.0 * total * punch.length == pytest.approx(load, rel=1e-7)


def test_surface_of_the_rounded_punch():
    """The pressure keeps the middle flat and follows the round of the edges: slope (2/(π E*)) PV∫ p/(x − s) ds."""
    punch, load = LineContact(27.6e-3, 5e-3, flat=1e-5), 30.0
    b = float(punch.half_width(load))
    assert b > 1.3e-5
    s = (np.arange(400000) + 0.5) / 400000 * 2 * b - b
    p = punch.pressure(load, s)
    step = s[1] - s[0]
    for x, expected in ((0.3e-5, 0.0), (0.5 * (1e-5 + b), (0.5 * (1e-5 + b) - 1e-5) / 5e-3)):
        place = s[np.argmin(np.abs(s - x))] + 0.5 * step
        slope = 2.0 * np.sum(p / (place - s)) * step / (np.pi * punch.plane_modulus)
        assert slope == pytest.approx(expected, abs=2e-5 * (b / 5e-3) + 1e-8)


def test_a_punch_without_flat_is_a_cylinder():
    punch = LineContact(27.6e-3, 5e-3, flat=1e-10)
    assert punch.half_width(100.0) == pytest.approx(CYLINDER.half_width(100.0), rel=1e-5)
    assert punch.approach(100.0) == pytest.approx(CYLINDER.approach(100.0), rel=1e-5)


def test_cattaneo():
    """Stick zone and traction of the cylinder in closed form; the tangential curve starts with k_n and slips at μN."""
    N, mu, T = 100.0, 0.6, 33.0
    b, p0 = float(CYLINDER.half_width(N)), float(CYLINDER.peak_pressure(N))
    c = b * np.sqrt(1.0 - T / (mu * N))
    assert CYLINDER.stick_half_width(T, N, mu) == pytest.approx(c, rel=1e-12)
    x = np.linspace(-0.99 * b, 0.99 * b, 41)
    inner = np.where(np.abs(x) < c, c / b * np.sqrt(np.maximum(1.0 - (x / c) ** 2, 0.0)), 0.0)
    assert CYLINDER.traction(x, T, N, mu) == pytest.approx(mu * p0 * (np.sqrt(1.0 - (x / b) ** 2) - inner), rel=1e-9)
    assert 1e-6 / CYLINDER.tangential_displacement(1e-6, N, mu) == pytest.approx(CYLINDER.tangential_stiffness(N)[0], rel=1e-5)
    slip = CYLINDER.tangential_displacement(mu * N, N, mu)
    ends = 2.0 * 0.3 * mu * N / (np.pi * CYLINDER.shear_modulus * CYLINDER.length)
    assert slip == pytest.approx(mu * CYLINDER.approach(N) + ends, rel=1e-12)


def cerruti(x, y, length, poisson):
    """Along a line at (x, y): integrals of 1/r, 1/r + ν/(1 − ν) x²/r³ and 1/r + ν/(1 − ν) y²/r³, from their primitives."""
    ratio = poisson / (1.0 - poisson)
    found = np.zeros(3)
    for sense, t in ((1.0, 0.5 * length - y), (-1.0, -0.5 * length - y)):
        r = np.hypot(x, t)
        found += sense * np.array(
            [np.arcsinh(t / x), np.arcsinh(t / x) + ratio * t / r, (1 + ratio) * np.arcsinh(t / x) - ratio * t / r]
        )
    return found


def test_tangential_stiffness_is_that_of_the_half_space():
    """Boussinesq and Cerruti: the middle of a line, loaded evenly along it and as by a rigid strip across it, on both bodies."""
    N = 78.2
    b, L = float(CYLINDER.half_width(N)), CYLINDER.length
    strip = b * np.cos(np.pi * (np.arange(4000) + 0.5) / 8000)
    compliance = sum(cerruti(x, 0.0, L, 0.3) for x in strip) / 4000 * (1 - 0.3) / (np.pi * CYLINDER.shear_modulus * L)
    assert [CYLINDER.normal_stiffness(N), *CYLINDER.tangential_stiffness(N)] == pytest.approx(1.0 / compliance, rel=1e-4)


def test_a_rigid_strip_moved_along_its_line_is_softer_than_across_it():
    """Boundary elements: a strip 2b × L glued to a half-space and moved as a whole, the traction free to gather at its ends."""
    N, across, along = 78.2, 6, 60
    x = float(CYLINDER.half_width(N)) * np.cos(np.linspace(np.pi, 0.0, across + 1))
    y = 0.5 * CYLINDER.length * np.cos(np.linspace(np.pi, 0.0, along + 1))
    X, Y = (grid.ravel() for grid in np.meshgrid(0.5 * (x[1:] + x[:-1]), 0.5 * (y[1:] + y[:-1]), indexing="ij"))
    i, j = np.divmod(np.arange(across * along), along)
    # Integrals of x²/r³ and y²/r³ over a rectangle are y arsinh(x/y) and x arsinh(y/x), taken between its corners.
    squares = np.zeros((2, X.size, X.size))
    for sense, u, v in ((1, x[1:], y[1:]), (-1, x[:-1], y[1:]), (-1, x[1:], y[:-1]), (1, x[:-1], y[:-1])):
        dx, dy = u[i] - X[:, None], v[j] - Y[:, None]
        squares += sense * np.array([dy * np.arcsinh(dx / np.abs(dy)), dx * np.arcsinh(dy / np.abs(dx))])
    ones = np.ones(X.size)
    area = np.diff(x)[i] * np.diff(y)[j]
    normal, t_across, t_along = (
        area @ np.linalg.solve(matrix, ones)
        for matrix in (0.7 * squares.sum(axis=0), squares[0] + 0.7 * squares[1], 0.7 * squares[0] + squares[1])
    )
    assert [t_across / normal, t_along / normal] == pytest.approx([0.949, 0.727], abs=1e-3)
    k_tx, k_ty = CYLINDER.tangential_stiffness(N) / CYLINDER.normal_stiffness(N)
    assert k_tx == pytest.approx(t_across / normal, rel=5e-3)
    assert k_ty == pytest.approx(t_along / normal, rel=5e-3)


def test_mindlin():
    """Mindlin and Deresiewicz count one sphere; two bodies of one material move and dissipate twice as much."""
    young, a = 2.0 * 80e3 * 1.3, 0.2
    sphere = SphereContact(4.0 * young / (2.0 * 0.91) * a**3 / (3.0 * 10.0), young, 0.3)
    assert sphere.half_width(10.0) == pytest.approx(a, rel=1e-12)
    assert sphere.tangential_stiffness(10.0) / sphere.normal_stiffness(10.0) == pytest.approx(2 * 0.7 / 1.7, rel=1e-12)
    for traction, energy in ((0.3, 2.8467246e-8), (1.5, 5.0514546e-6), (2.7, 5.7552620e-5)):
        assert sphere.loop_energy(traction, 10.0, 0.3) == pytest.approx(2.0 * energy, rel=1e-7)
    T = np.linspace(0.0, 2.0, 20001)
    loading = np.array([sphere.tangential_displacement(t, 10.0, 0.3) for t in T])
    masing = 8.0 * np.trapezoid(T, loading) - 4.0 * T[-1] * loading[-1]
    assert sphere.loop_energy(2.0, 10.0, 0.3) == pytest.approx(masing, rel=1e-6)


def test_the_result_draws(tmp_path):
    result = contact_stiffness(CYLINDER, np.linspace(5.0, 200.0, 20), at=84.9)
    assert result.dataset.normal_stiffness.attrs["units"] == "N/m"
    figure = result.plot()
    figure.savefig(tmp_path / "stiffness.png")
    labels = [entry.get_text() for entry in figure.legends[0].get_texts()]
    assert sum(label.startswith("tangential") for label in labels) == 2


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: LineContact(-1.0, 5e-3), "length must be positive"),
        (lambda: LineContact(27.6e-3, 5e-3, poisson=0.5), "between -1 and 0.5"),
        (lambda: CYLINDER.normal_stiffness(np.nan), "must be finite"),
        (lambda: CYLINDER.normal_stiffness(1e9), "Check the load and the units"),
        (lambda: LineContact(27.6, 5.0, young=210e9).normal_stiffness(1e15), "small against the length"),
        (lambda: CYLINDER.tangential_displacement(61.0, 100.0, 0.6), "must not exceed mu N"),
        (lambda: LineContact(1e-2, 1e-3, flat=1e-3).peak_pressure(1.0), "must be 0"),
        (lambda: static_normal_load(147.0, 90.0), r"\[0, 90\)"),
        (lambda: LineContact(27.6e-3, 5e-3).normal_stiffness(0.0), "load must be positive"),
        (lambda: LineContact(27.6e-3, 5e-3).normal_stiffness("a"), "load must hold numbers"),
        (lambda: contact_stiffness(1, 2), "contact must be a LineContact"),
    ],
)
def test_wrong_input(make, words):
    with pytest.raises(InputError, match=words):
        make()
