"""Clouds of responses: draws, laws, percentiles."""

import pickle

import numpy as np
import pytest
from scipy import stats
from scipy.stats import qmc

from stickslip.analyses.variability import samples
from stickslip.analyses.variability.samples import SamplesWork, draw, named_law, percentiles, response_samples
from stickslip.model.rigs import three_mass_wedge
from stickslip.show.plots.variability import response_percentiles
from stickslip.solve.starts.states import StartSolutions, virgin_solutions
from stickslip.support.checks import InputError
from stickslip.support.units import hertz


def test_draws_cover_the_cube_and_repeat():
    latin = draw(3, 11, "latin", 5)
    assert np.all(latin[0] == 0.0)
    assert np.all(np.sort(np.floor((latin[1:] + 1.0) * 5.0), axis=0) == np.arange(10)[:, None])
    np.testing.assert_array_equal(latin, draw(3, 11, "latin", 5))
    assert len(np.unique(draw(3, 9, "corners")[1:], axis=0)) == 8
    many = draw(13, 50, "corners", 1)
    assert np.all(np.abs(many[1:]) == 1.0)
    assert len(np.unique(many, axis=0)) == len(many)


@pytest.mark.parametrize(("size", "count", "seed"), [(1, 1, 0), (5, 8, 3), (40, 60, 9)])
def test_a_latin_hypercube_is_that_of_scipy(size, count, seed):
    drawn = draw(size, count + 1, "latin", seed)[1:]
    expected = qmc.LatinHypercube(size, rng=np.random.default_rng(seed)).random(count)
    np.testing.assert_array_equal(drawn, 2.0 * expected - 1.0)


def test_a_law_is_mapped_from_its_support():
    arcsine = draw(2, 4000, "random", 0, stats.beta(0.5, 0.5))
    assert np.mean(np.abs(arcsine) > np.sqrt(0.5)) == pytest.approx(0.5, abs=0.02)
    uniform = draw(2, 4000, "latin", 0, stats.uniform(10.0, 4.0))
    assert np.var(uniform) == pytest.approx(1.0 / 3.0, rel=1e-2)
    bell = draw(2, 4000, "latin", 0, stats.norm(0.0, 2.0))
    assert np.mean(bell < 0.5) == pytest.approx(stats.truncnorm(-0.5, 0.5, 0.0, 2.0).cdf(0.5), abs=1e-3)
    with pytest.raises(InputError, match="weight between"):
        draw(2, 10, "latin", 0, stats.norm(50.0, 0.1))
    with pytest.raises(InputError, match="must lie in"):
        draw(2, np.full((3, 2), 1.5))


def test_start_states_are_explored_once_and_the_result_travels(monkeypatch):
    """A process would repeat what takes seconds on a blade."""
    explored = []
    monkeypatch.setattr(samples.states, "virgin_solutions", lambda *given: explored.append(given[2]) or virgin_solutions(*given))
    response_samples(three_mass_wedge(), [145.0, 222.0], [1.0, 2.0], 3)
    assert explored == [1.0, 2.0]
    work = SamplesWork(three_mass_wedge(), [145.0, 222.0])
    space, virgin = work.explored_at(1.0)
    other = pickle.loads(pickle.dumps(work))  # noqa: S301
    np.testing.assert_array_equal(other.explored_at(1.0)[0].scale, space.scale)
    np.testing.assert_array_equal(other.explored_at(1.0)[1], virgin)
    assert explored == [1.0, 2.0, 1.0]


@pytest.mark.parametrize(("rule", "known"), [("slider_offset", True), ("traction_ratio", False), ("mean_traction", False)])
def test_a_case_begins_at_the_solution_of_variables_zero_at_the_first_frequency(rule, known):
    """Only offsets of zero are virgin: a traction of zero is prescribed, and its solution another one, which each case finds."""
    work = SamplesWork(three_mass_wedge(), [222.0, 145.0], 1.0, rule=rule)
    space, virgin = work.explored_at(1.0)
    assert (virgin is not None) == known
    begin = StartSolutions(work.balance, space, 2.0 * np.pi * 222.0, 1.0)
    zero = begin.solve(np.zeros(space.size))[1].point.forces
    if known:
        np.testing.assert_array_equal(virgin, zero)
    else:
        first = virgin_solutions(work.balance, [begin.omega], 1.0)[0].point.forces
        assert np.abs(first - zero).max() > 1e-3 * np.abs(zero).max()


def test_the_first_point_of_a_case_does_not_depend_on_where_the_virgin_solution_was_found():
    work = SamplesWork(three_mass_wedge(), [222.0, 180.0], 1.0)
    space, virgin = work.explored_at(1.0)
    given = (work.balance, space, np.linspace(-0.9, 0.8, space.size), work.frequencies, 1.0, True)
    known, solved = samples.start_curve(*given, virgin=virgin), samples.start_curve(*given)
    assert len(known.points) == len(solved.points) == 2
    for one, other in zip(known.points, solved.points, strict=True):
        np.testing.assert_array_equal(one.point.forces, other.point.forces)


def test_percentiles_follow_the_law():
    """The amplitude of the wedge grows with its ratio, so percentiles of shared ratios are those of the law."""
    law = stats.uniform(-1.0, 2.0)
    found = response_samples(
        three_mass_wedge(), [145.0, 222.0], 1.0, 41, distribution=law, rule="traction_ratio", share="all", method="latin"
    )
    table = found.percentiles([0.0, 50.0, 100.0])
    assert table.dims == ("force_level", "percent", "frequency")
    middle = table.sel(force_level=1.0, frequency=222.0)
    assert float(middle.sel(percent=50.0)) == pytest.approx(4.928118e-5, rel=0.03)
    assert float(middle.sel(percent=100.0)) == pytest.approx(6.228618e-5, rel=0.02)
    cloud = found.dataset.amplitude.values[:, 1, 0]
    np.testing.assert_allclose(middle.values, np.percentile(cloud, [0.0, 50.0, 100.0]), rtol=1e-12)


def test_a_law_by_its_name():
    arcsine, bell = named_law("beta", {"a": 0.5, "b": 0.5}), named_law("norm", {"scale": 0.4})
    assert arcsine.ppf(0.25) == pytest.approx(np.sin(np.pi / 8.0) ** 2)
    assert bell.cdf(0.0) == 0.5
    for name, parameters, message in (
        ("bets", {}, "law must be a continuous distribution of scipy.stats"),
        ("beta", {"a": 1.0}, "parameters must be a, b, loc, scale"),
        ("beta", {"a": -1.0, "b": 1.0}, "valid parameters"),
    ):
        with pytest.raises(InputError, match=message):
            named_law(name, parameters)


def test_percentiles_say_of_how_many_and_are_drawn():
    found = response_samples(three_mass_wedge(), [221.0, 222.0], [0.5, 1.0], 7)
    table = found.percentiles()
    np.testing.assert_array_equal(table["solved"].values, np.full((2, 2), 7))
    axes = response_percentiles(found.dataset).plot().axes
    assert len(axes) == 2
    np.testing.assert_allclose(axes[1].lines[0].get_ydata(), 1e6 * table.sel(force_level=1.0, percent=50.0))
    with pytest.raises(InputError, match="percent must lie"):
        found.percentiles([101.0])


def test_the_largest_of_several_solutions_at_a_frequency_counts():
    """A curve that passes a frequency again on another branch has two points there; none has any at the other frequency."""
    found = response_samples(three_mass_wedge(), [221.0, 222.0], 1.0, 5)
    folded = found.dataset.assign(frequency=0.0 * found.dataset["frequency"] + 222.0)
    table, both = percentiles(folded, [0.0, 100.0]), found.dataset["amplitude"].values[:, :2, 0]
    assert np.all(np.ptp(both, axis=1) > 0.0)
    largest = both.max(axis=1)
    np.testing.assert_allclose(table.sel(force_level=1.0, frequency=222.0), [largest.min(), largest.max()])
    assert table["solved"].values.tolist() == [[0, 5]]
    assert np.isnan(table.sel(frequency=221.0)).all()


def test_percentiles_are_not_interpolated():
    found = response_samples(three_mass_wedge(), hertz(215.0, 225.0), 1.0, 2)
    with pytest.raises(InputError, match="common frequencies"):
        found.percentiles()
    assert list(found.dataset.start.values) == [0, 1]


@pytest.mark.nightly
def test_curves_do_not_depend_on_the_workers():
    one, two = (response_samples(three_mass_wedge(), hertz(215.0, 225.0), [0.5, 1.0], 3, workers=n).dataset for n in (1, 2))
    np.testing.assert_array_equal(one.amplitude.values, two.amplitude.values)
    np.testing.assert_array_equal(one.force_level.values, [0.5] * 3 + [1.0] * 3)


def test_peaks_table():
    peaks = response_samples(three_mass_wedge(), hertz(150.0, 175.0), 1.0, 3).peaks()
    assert list(peaks.columns) == ["force_level", "start", "frequency", "amplitude", "loss_factor"]
    assert peaks.amplitude.to_numpy() == pytest.approx(2.275e-4, rel=1e-3)
