"""A peak solved once more with a contact at each node where its resonance lies many half-widths away, against traced curves."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.solve.balance.balance import Point
from stickslip.solve.continuation.finer_peak import _delayed, _extrapolated, _resonance
from stickslip.study.templates import write_new


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("blades")
    write_new("two_blades", folder / "blades.toml")
    return folder


def peaks(folder, points, level, band, damping):
    text = (folder / "blades.toml").read_text().replace("points = 12 ", f"{points} ").replace("points = 12\n", f"{points}\n")
    (folder / "study.toml").write_text(text.replace("modal = 2e-3", f"modal = {damping}"))
    return ss.forced_response(ss.read_problem(folder / "study.toml"), ss.hertz(*band), [level], harmonics=1, samples=64).dataset


@pytest.mark.parametrize(
    ("level", "band", "damping", "widths"),
    [
        pytest.param(1e-3, (405.0, 440.0), 2e-3, 4, marks=pytest.mark.slow),
        pytest.param(1.0, (380.0, 440.0), 2e-3, 4, marks=pytest.mark.slow),
        pytest.param(1e-3, (415.0, 430.0), 2e-4, 30, marks=pytest.mark.slow),
        (0.03, (405.0, 430.0), 2e-4, 30),
    ],
)
def test_the_error_of_four_points_is_that_against_all_nodes(folder, level, band, damping, widths):
    """Stuck, where the resonance moves by 1 %, five half-widths, and slipping; and ten times less damped."""
    few, every = peaks(folder, "points = 4", level, band, damping), peaks(folder, "", level, band, damping)
    change = every["peak_amplitude"].values[0, 0, 0] / few["peak_amplitude"].values[0, 0, 0] - 1.0
    moved = every["peak_frequency"].values[0, 0, 0] / few["peak_frequency"].values[0, 0, 0] - 1.0
    assert abs(moved) > widths * damping
    assert few["patch_error"].values[0, 0] == pytest.approx(change, abs=2e-3)


def test_a_resonance_beside_a_constant_is_found_from_three_points():
    p, r, c = 100.0 + 0.2j, 3.0 - 1.0j, 0.5 + 0.1j
    known = [(w, c + r / (w - p)) for w in (90.0, 91.0, 89.5)]
    np.testing.assert_allclose(_resonance(known), (p, r, c), rtol=1e-10)


def test_a_delayed_motion_is_the_same_at_another_time():
    rng = np.random.default_rng(0)
    forces, turn, t = rng.normal(size=(1, 7)), 0.7, np.linspace(0.0, 6.0, 9)

    def motion(coefficients, time):
        found = coefficients[0, 0] + 0.0 * time
        for h in (1, 2, 3):
            found = found + coefficients[0, 2 * h - 1] * np.cos(h * time) + coefficients[0, 2 * h] * np.sin(h * time)
        return found

    np.testing.assert_allclose(motion(_delayed(forces, turn), t), motion(forces, t + turn), atol=1e-12)


def test_forces_of_a_resonance_are_extrapolated():
    """λ of each row and harmonic as c + r/(ω − p), the mean as it was last."""
    rng = np.random.default_rng(1)
    p, (c, r) = 100.0 + 0.2j, rng.normal(size=(2, 2, 3)) + 1j * rng.normal(size=(2, 2, 3))

    def point(omega):
        forces, sums = np.full((2, 7), omega), c + r / (omega - p)
        forces[:, 1::2], forces[:, 2::2] = sums.real, -sums.imag
        return Point(forces, omega, 1.0)

    found = _extrapolated([point(90.0), point(93.0)], p, 99.5)
    np.testing.assert_allclose(found[:, 1:], point(99.5).forces[:, 1:], rtol=1e-10)
    assert found[:, 0] == pytest.approx(93.0)
