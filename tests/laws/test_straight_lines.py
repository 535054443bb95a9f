"""Motion exactly along a line, which symmetric loads give: derivatives of every law, also across the line.

Along the line the state of a friction disc repeats after one period; a deviation across it dies out over many.
"""

import numpy as np
import pytest
from each import each
from laws.kernel import answer, random_motion
from laws.marching import harmonics_of
from laws.samples import DISC_SAMPLES, SAMPLES, SPRING_SAMPLES, Sample
from scipy.integrate import solve_ivp

from stickslip.model.contact.point import SliderOffset, TractionRatio
from stickslip.model.contact.protocol import SLIPPING
from stickslip.solve.balance.energy import cycle_work

H, NT = 3, 64
STEP = 1e-6
VIRGIN = SliderOffset()
LINES = {"first": (1.0, 0.0), "second": (0.0, 1.0), "oblique": (0.6, 0.8), "backwards": (-0.8, 0.6)}


def straight(sample: Sample, line: tuple[float, float], seed: int, normal: bool) -> np.ndarray:
    """Motion w (rows, 2H+1) with both tangential directions on a line, and the normal one on it too where `normal`."""
    w = random_motion(sample, H, np.random.default_rng(seed), size=(0.3, 1.0, 4.0)[seed])
    along = w[0].copy()
    w[: sample.tangential] = np.outer(line[: sample.tangential], along)
    if normal and sample.law.has_normal:
        w[-1, 1:] = 0.7 * along[1:]
    return w


def derivative(sample: Sample, w: np.ndarray, row: int, start=VIRGIN) -> np.ndarray:
    """dλ̂/dw[row] of all rows, (rows, 2H+1, 2H+1)."""
    here = answer(sample, start, w, NT)
    blocks = []
    for d in range(w.shape[0]):
        if d == row:
            blocks.append(here.own[d])
        elif d < sample.tangential:
            blocks.append(here.cross[d] if row < sample.tangential else here.normal[d])
        else:
            blocks.append(np.zeros_like(here.own[d]))
    return np.array(blocks)


@each("normal", [False, True], ids=["", "normal too"])
@each("line", LINES.values(), ids=LINES)
@pytest.mark.parametrize("sample", [*SAMPLES, *DISC_SAMPLES, *SPRING_SAMPLES], ids=lambda sample: sample.name)
def test_derivatives_on_a_line_equal_central_differences(sample, line, normal):
    for seed in range(3):
        w = straight(sample, line, seed, normal)
        for row in range(w.shape[0]):
            found = derivative(sample, w, row)
            for column in range(w.shape[1]):
                ahead, behind = w.copy(), w.copy()
                ahead[row, column] += STEP
                behind[row, column] -= STEP
                ends = [answer(sample, VIRGIN, moved, NT).target for moved in (ahead, behind)]
                np.testing.assert_allclose(found[:, :, column], (ends[0] - ends[1]) / (2.0 * STEP), atol=2e-7)


@pytest.mark.parametrize("start", [(SliderOffset(0.4), SliderOffset(-0.9)), (TractionRatio(0.3), TractionRatio(-0.6))])
@pytest.mark.parametrize("sample", DISC_SAMPLES, ids=lambda sample: sample.name)
def test_the_derivative_of_a_disc_that_slips_forgets_the_start(sample, start):
    """Not of one that only touches its limit in each period: whether that counts as slip is a matter of rounding."""
    slipping = 0
    for line in LINES.values():
        for seed in range(3):
            w = straight(sample, line, seed, False)
            found = answer(sample, VIRGIN, w, NT)
            if found.unknown[0] == SLIPPING and cycle_work(found.target, w).sum() > 1e-9:
                slipping += 1
                for row in range(w.shape[0]):
                    expected = derivative(sample, w, row, start)
                    np.testing.assert_allclose(derivative(sample, w, row), expected, atol=2e-9)
    assert slipping >= 8


def test_a_shift_across_the_line_changes_no_traction():
    """The slider follows a constant shift, so T stays and λ̂ = T − kt u falls by kt in its mean alone."""
    disc = DISC_SAMPLES[0]
    for amplitude in (0.35, 0.6, 3.0):  # a little beyond the limit, 0.3 m, and far
        w = np.zeros((2, 2 * H + 1))
        w[0, 1] = amplitude
        expected = np.zeros(2 * H + 1)
        expected[0] = -2.0
        np.testing.assert_allclose(derivative(disc, w, 1)[1, :, 0], expected, atol=2e-9)
        np.testing.assert_allclose(derivative(disc, w, 1)[0, :, 0], 0.0, atol=2e-9)


def test_a_small_motion_across_a_rubbing_line_solves_its_own_equation():
    """u = A cos θ slips once it has come 2L/kt from a reversal. Across it T' = kt v' − (kt|u'|/L) T in slip, kt v' in stick."""
    disc, kt, limit, amplitude, samples = DISC_SAMPLES[0], 2.0, 0.6, 0.5, 2048
    w = np.zeros((2, 2 * H + 1))
    w[0, 1] = amplitude
    onset = np.arccos(1.0 - 2.0 * limit / (kt * amplitude))
    found = answer(disc, VIRGIN, w, samples).own[1]

    def across(column: int) -> np.ndarray:
        """Harmonics of T for v = cos θ (column 1) or sin θ (column 2), by its antisymmetry T(θ + π) = −T(θ)."""

        def slope(angle: float, T: np.ndarray) -> np.ndarray:
            given = -np.sin(angle) if column == 1 else np.cos(angle)
            return np.array([kt * given, 0.0]) - (kt * amplitude * np.sin(angle) / limit * T if angle > onset else 0.0)

        times = np.pi * np.arange(samples // 2 + 1) / (samples // 2)
        stuck = solve_ivp(slope, (0.0, onset), [0.0, 1.0], rtol=1e-10, atol=1e-12, dense_output=True)
        slips = solve_ivp(slope, (onset + 1e-15, np.pi), stuck.y[:, -1], rtol=1e-10, atol=1e-12, dense_output=True)
        both = np.where(times <= onset, stuck.sol(times), slips.sol(np.maximum(times, onset)))
        half = both[0] - both[0, -1] / (1.0 + both[1, -1]) * both[1]
        return harmonics_of(np.concatenate([half[:-1], -half[:-1]]), H)

    for column in (1, 2):
        moved = np.eye(2 * H + 1)[column]
        np.testing.assert_allclose(found[:, column], across(column) - kt * moved, atol=2e-5)
