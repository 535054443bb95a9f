"""Which parameter matters: slopes and indices where a closed form gives them."""

from math import pi

import numpy as np
import pytest
from scipy.stats import qmc

import stickslip as ss
from stickslip.analyses.performance.sensitivity_indices import DrawsWork, _indices, _intervals, gathered
from stickslip.show.plots.variability import tornado
from stickslip.show.report.performance import index_sentences as sentences
from stickslip.show.report.performance import index_tables as tables

BAND = ss.radians_per_second(0.85, 1.35)


def test_slopes_and_ends_against_the_closed_form():
    """Undamped, one harmonic: A = Fc²/(kd (Fc − π/4)), so d ln A = −d kd/kd + (2/Fc − 1/(Fc − π/4)) d Fc."""

    def rig(*, kd: float, limit: float) -> ss.Problem:
        return ss.rigs.single_mass(damping=0.0, kt=kd, limit=limit)

    found = ss.sensitivity_indices(
        rig, {"kd": (0.45, 0.55), "limit": (1.8, 2.2)}, BAND, draws=2, harmonics=1, samples=2048
    ).dataset
    exact = [-0.1 / 0.5, 0.4 * (2.0 / 2.0 - 1.0 / (2.0 - pi / 4.0))]
    assert found.slope.values == pytest.approx(exact, rel=1e-3)
    for k, (kd, limit) in enumerate([(0.45, 2.0), (0.5, 1.8)]):
        assert float(found.low_end[k, 0]) == pytest.approx(limit**2 / (kd * (limit - pi / 4.0)), rel=3e-5)


@pytest.fixture(scope="module")
def linear():
    """A = 1/(c √(k/m − (c/2m)²)): d ln A = −d ln c − (d ln k − d ln m)/2 but for c²/(4 k m) = 10⁻⁴, halved."""

    def rig(*, c: float, k: float, m: float) -> ss.Problem:
        return ss.rigs.single_mass(mass=m, damping=c, kt=1e-9, stiffness=k)

    ranges = {"c": (0.018, 0.022), "k": (0.9, 1.1), "m": (0.9, 1.1)}
    return ss.sensitivity_indices(rig, ranges, ss.radians_per_second(0.85, 1.15), draws=32, harmonics=1, samples=32).dataset


@pytest.mark.slow
def test_slopes_of_a_linear_mass(linear):
    """At the frequency of a peak that is 1e-5 rad/s off its top the slopes by k and m would be −0.109 and 0.109."""
    small = 1e-4
    assert linear.slope.values == pytest.approx([-0.2 * (1.0 - small), -0.1 * (1.0 + small), 0.1 * (1.0 - small)], abs=1e-5)


@pytest.mark.parametrize(
    ("limit", "exact"), [(20.0, [-0.39345, 0.38427, -0.00131, 0.00196]), (1.5, [-0.37711, 0.01278, -0.00507, 0.00637])]
)
def test_slopes_of_a_mass_that_slips(limit, exact):
    """Exact solution of one harmonic, maximised over the frequency and differenced: an independent script."""

    def rig(*, kt: float, limit: float, k: float, m: float) -> ss.Problem:
        return ss.rigs.single_mass(mass=m, damping=0.01, kt=kt, limit=limit, stiffness=k)

    ranges = {"kt": (0.4, 0.6), "limit": (0.8 * limit, 1.2 * limit), "k": (0.9, 1.1), "m": (0.9, 1.1)}
    found = ss.sensitivity_indices(rig, ranges, ss.radians_per_second(0.8, 1.5), draws=2, harmonics=1, samples=256).dataset
    assert found.slope.values == pytest.approx(exact, abs=60.0 / 256**2)


def test_indices_lie_in_their_intervals_and_are_reported_with_them(linear):
    """Var ln A by c, k, m: 0.2²/12 and twice 0.1²/12, in shares 2/3, 1/6, 1/6."""
    low, high = np.moveaxis(linear.total_interval.values[:, 0], -1, 0)
    shares = np.array([4.0, 1.0, 1.0]) / 6.0
    assert np.all((low < shares) & (shares < high))
    assert np.all(high - low > 0.02)
    assert f"c {float(linear.total[0, 0]):.2f} ({low[0]:.2f} to {high[0]:.2f})" in sentences(linear)[0]
    assert tables(linear)["parameters"]["amplitude, total, 95 % to"].tolist() == high.tolist()


def test_intervals_hold_95_per_cent_of_the_bootstrap():
    """The share of indices of other samples of the draws inside, of 200 to 0.06."""
    drawn = np.random.default_rng(4).normal(size=(512, 4, 1))
    low, high = np.moveaxis(_intervals(drawn, 0), -1, 0)
    rng = np.random.default_rng(1)
    again = [_indices(drawn[rng.integers(512, size=512)]) for _ in range(200)]
    np.testing.assert_allclose(np.mean((low <= again) & (again <= high), axis=0), 0.95, atol=0.06)


def test_interactions_count_in_the_total_index_alone():
    """x₁ + x₁ x₂ with both in [−1, 1]: variances 1/3 and 1/9, so first-order 3/4 and 0, total 1 and 1/4."""
    draws = 4096
    work = DrawsWork(
        OneLimitAndDamping(), {"limit": (1.6, 2.4), "damping": (0.01, 0.02)}, BAND, draws=draws, harmonics=1, samples=64
    )
    A, B = np.split(2.0 * qmc.Sobol(4, rng=1).random(draws) - 1.0, 2, axis=1)
    columns = [A, B, np.column_stack([B[:, 0], A[:, 1]]), np.column_stack([A[:, 0], B[:, 1]])]
    values = np.column_stack([x[:, 0] + x[:, 0] * x[:, 1] for x in columns])
    first = {"middle": np.ones(2), "ends": np.ones((2, 2, 2)), "slopes": np.ones(2), "cpu_seconds": 0.0}
    drawn = {"peaks": np.stack([values, values], axis=-1), "cpu_seconds": 0.0}
    found = gathered(work, [first, drawn])
    assert found.first_order.values[:, 1] == pytest.approx([0.75, 0.0], abs=0.02)
    assert found.total.values[:, 1] == pytest.approx([1.0, 0.25], abs=0.02)
    for index, interval in ((found.first_order, found.first_order_interval), (found.total, found.total_interval)):
        assert np.all((interval[..., 0] <= index) & (index <= interval[..., 1]))
        assert np.all(interval[..., 1] - interval[..., 0] < 0.2)


def test_each_mixed_point_takes_one_value_from_the_other_draw():
    """Points A, B and, of each parameter, A with its value from B; all within their ranges."""
    ranges = {"limit": (1.6, 2.4), "damping": (0.01, 0.02)}
    asked = {"force": 1.0, "draws": 8, "output": 0, "seed": 3, "harmonics": 1, "samples": 64}
    A, B, *mixed = np.moveaxis(DrawsWork(OneLimitAndDamping(), ranges, BAND, **asked).points(), 1, 0)
    for k, points in enumerate(mixed):
        np.testing.assert_array_equal(points[:, k], B[:, k])
        np.testing.assert_array_equal(points[:, 1 - k], A[:, 1 - k])
        assert not np.any(A[:, k] == B[:, k])
    low, high = np.array(list(ranges.values())).T
    for points in (A, B):
        np.testing.assert_array_equal(np.clip(points, low, high), points)


def test_both_bars_are_seen_where_both_ends_move_the_peak_the_same_way(linear):
    same = linear.copy(deep=True)
    same.low_end[:], same.high_end[:] = 1.1 * same.middle, 1.2 * same.middle
    bars = [bar.get_bbox() for bar in tornado(same).plot().axes[0].patches]
    assert not any(a.overlaps(b) and min(a.y1, b.y1) > max(a.y0, b.y0) + 1e-9 for a in bars for b in bars if a is not b)


def test_all_variance_belongs_to_the_only_parameter_that_acts():
    """A stuck contact: the slip limit does nothing, damping everything."""

    def rig(*, damping: float, limit: float) -> ss.Problem:
        return ss.rigs.single_mass(damping=damping, kt=0.5, limit=limit)

    found = ss.sensitivity_indices(
        rig, {"damping": (0.01, 0.02), "limit": (500.0, 900.0)}, BAND, draws=64, harmonics=1, samples=64
    ).dataset
    assert float(found.total[1, 0]) == pytest.approx(0.0, abs=1e-6)
    assert float(found.total[0, 0]) > 0.8
    assert np.all(found.high_end.values[1] == pytest.approx(found.low_end.values[1], rel=1e-4))


def test_one_parameter_alone_and_any_number_of_workers():
    """One range alone has all the variance; 16 draws are two cases, which share nothing but the middle."""
    found = ss.sensitivity_indices(OneLimit(), {"limit": (1.6, 2.4)}, BAND, draws=16, harmonics=1, samples=64).dataset
    other = ss.sensitivity_indices(OneLimit(), {"limit": (1.6, 2.4)}, BAND, draws=16, harmonics=1, samples=64, workers=2).dataset
    assert found.total.shape == (1, 2)
    assert float(found.first_order[0, 0]) == pytest.approx(1.0, abs=0.35)
    assert np.array_equal(found.total.values, other.total.values)


class OneLimitAndDamping:
    def __call__(self, *, limit: float, damping: float) -> ss.Problem:
        return ss.rigs.single_mass(damping=damping, kt=0.5, limit=limit)


class OneLimit:
    def __call__(self, *, limit: float) -> ss.Problem:
        return ss.rigs.single_mass(damping=0.01, kt=0.5, limit=limit)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"draws": 6}, "draws must be a power of two"),
        ({"parameters": {"limit": (2.0, 1.0)}}, r"parameters, limit must be \(low, high\)"),
    ],
)
def test_wrong_input_is_said(changed, words):
    settings = {"parameters": {"limit": (1.0, 2.0)}, "band": BAND} | changed
    with pytest.raises(ss.InputError, match=words):
        ss.sensitivity_indices(lambda limit: ss.rigs.single_mass(limit=limit), **settings)
