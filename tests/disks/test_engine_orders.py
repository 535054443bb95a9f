"""Several engine orders at once on a tuned disk: sums of linear responses, the full disk, wakes of blade rows."""

from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from stickslip.results.view import has_linear_curves
from stickslip.show.plots.chart import Line, Rule
from stickslip.show.plots.disk import nodal_diameter_diagram
from stickslip.show.plots.response_curves import response_curves
from stickslip.show.report.answer import peaks_at_a_glance
from stickslip.support.checks import InputError


@pytest.fixture(scope="module")
def disk():
    return ss.rigs.lumped_blisk("W", sectors=12)


@pytest.fixture(scope="module")
def speeds(disk):
    """Turns a second at which engine orders 2 and 3 meet the first mode of their nodal diameters, all contacts stuck."""
    return [float(disk.modes(order).frequencies[0]) / order for order in (2, 3)]


def harmonic(response, point, h):
    return complex(*response.dataset.response.values[0, point, 0, h])


def test_far_below_slip_each_engine_order_moves_as_if_alone(disk, speeds):
    amplitudes = {2: 1.0, 3: 0.5 - 0.2j}
    both = ss.forced_response(disk.with_engine_orders(amplitudes), speeds, force=1e-3, harmonics=3)
    for order, factor in amplitudes.items():
        alone = disk.with_engine_order(order)
        for point, speed in enumerate(speeds):
            expected = factor * harmonic(ss.forced_response(alone, [order * speed], force=1e-3, harmonics=1), 0, 1)
            assert harmonic(both, point, order) == pytest.approx(expected, rel=1e-9)


def test_one_sector_moves_as_the_full_disk_does_in_slip(disk, speeds):
    excited = disk.with_engine_orders({2: 1.0, 3: 0.5})
    how = {"force": 0.4, "harmonics": 4, "samples": 96}
    sector = ss.forced_response(excited, speeds[:1], **how)
    whole = ss.forced_response(excited.full([1, 2]), speeds[:1], **how).dataset.response.values[0, 0]
    assert float(sector.dataset.share_slip.max()) > 0.1
    one = sector.dataset.response.values[0, 0, 0] @ [1.0, 1j]
    first, second = whole @ [1.0, 1j]
    np.testing.assert_allclose(first, one, atol=1e-8 * abs(one).max())
    late = np.exp(-2j * np.pi * np.arange(5) / 12)
    np.testing.assert_allclose(second, one * late, atol=1e-8 * abs(one).max())


def test_truncation_is_judged_by_the_whole_motion_where_the_first_harmonic_is_not_excited(disk, speeds):
    excited = disk.with_engine_orders({2: 1.0, 3: 0.5})
    few, many = (
        ss.forced_response(excited, speeds[:1], force=0.4, harmonics=H, samples=528, measure="max_abs").dataset for H in (5, 24)
    )
    change = abs(float(few.max_abs[0, 0, 0]) / float(many.max_abs[0, 0, 0]) - 1.0)
    assert change < 0.01
    assert change / 10.0 < float(few.truncation_error[0, 0]) < 0.05


def test_each_harmonic_meets_what_the_speed_adds_to_its_own_nodal_diameter(disk):
    """K + Ω² K₁ at ω = EO Ω is a mass M − K₁/(h EO)², K₁ of the nodal diameter h EO mod N; N − n is the conjugate of n."""
    size, N = disk.disk.size, disk.sectors
    drawn = np.random.default_rng(1).normal(size=(2, N // 2 + 1, size, size))
    waves = (drawn[0] + drawn[0].swapaxes(1, 2)) + 1j * (drawn[1] - drawn[1].swapaxes(1, 2))
    waves[[0, -1]] = waves[[0, -1]].real
    stiffened = replace(disk, engine_order=5, speed=ss.SpeedDependence(5, 1e-6 * waves))
    for h in (1, 2, 3):
        n = 5 * h % N
        added = 1e-6 * (waves[n] if n <= N // 2 else waves[N - n].conj())
        M = stiffened.disk.at(n).M - added / (5 * h) ** 2
        np.testing.assert_allclose(stiffened.systems.at(h).M, M, atol=1e-15)


def test_wakes_of_blade_rows_are_engine_orders(disk):
    rows = disk.with_blade_rows({4: [1.0, 0.25], 8: [0.5j]})
    orders = disk.with_engine_orders({4: 1.0, 8: 0.25 + 0.5j})
    assert rows.engine_order == orders.engine_order == 4
    assert rows.forces[0].amplitudes == orders.forces[0].amplitudes == {1: 1.0, 2: 0.25 + 0.5j}
    assert disk.with_engine_orders({16: 1.0, 32: 1.0}).engine_order == 16 % 12
    assert rows.forces[1:] == disk.forces[1:]


@pytest.mark.parametrize(
    ("amplitudes", "words"),
    [
        ({}, "must hold at least one"),
        ({2: 0.0, 3: 0j}, "must hold at least one with a factor other than zero"),
        ({0: 1.0}, "engine order must be at least 1"),
        ({2.5: 1.0}, "engine order must be a whole number"),
        ({True: 1.0}, "engine order must be a whole number"),
        ({"a": 1.0}, "engine order must be a whole number"),
        ({10**6: 1.0}, "engine order must be at most"),
        ({2: float("nan")}, "The factor of engine order 2 must be finite"),
        ({2: "a"}, "The factor of engine order 2 must be a number"),
        ({2: None}, "The factor of engine order 2 must be a number"),
        ({2: 10**400}, "The factor of engine order 2 must not be larger"),
        ([2, 3], "engine orders must be a dict"),
    ],
)
def test_wrong_engine_orders_are_refused(disk, amplitudes, words):
    with pytest.raises(InputError, match=words):
        disk.with_engine_orders(amplitudes)


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ({}, "must hold at least one"),
        ({12: []}, "must hold at least one"),
        ({12: 1.0}, "The pressures of 12 blades must be a tuple or list"),
        ({12: "ab"}, "The pressures of 12 blades must be a tuple or list"),
        ({12: [1.0, float("inf")]}, "Pressure 2 of 12 blades must be finite"),
        ({-3: [1.0]}, "number of blades must be at least 1"),
        ([12], "blade rows must be a dict"),
    ],
)
def test_wrong_blade_rows_are_refused(disk, rows, words):
    with pytest.raises(InputError, match=words):
        disk.with_blade_rows(rows)


def test_a_force_with_harmonics_of_its_own_is_refused(disk):
    with pytest.raises(InputError, match="must have the first harmonic alone"):
        disk.with_forces([ss.Force("tip.t", {1: 1.0, 2: 0.5})]).with_engine_orders({1: 1.0})


def test_titles_name_the_engine_orders_and_one_order_replaces_several(disk):
    both = disk.with_engine_orders({2: 1.0, 3: 0.5j})
    assert both.heading.endswith("case W, engine orders 2 and 3")
    assert both.excited_orders == (2, 3)
    assert disk.with_blade_rows({12: [1.0] * 8}).heading.endswith("engine orders 12, 24, 36, 48, 60, 72, ... (8 in all)")
    for again in (both.with_engine_order(3), disk.with_blade_rows({12: [1.0] * 8}).with_engine_orders({3: 1.0})):
        assert again.heading.endswith("case W, engine order 3")
        assert [force.amplitudes for force in again.forces] == [force.amplitudes for force in disk.forces]
        assert again.excited_orders == (again.engine_order,) == (3,)
    assert both.with_engine_orders({4: 1.0, 6: 1.0}).forces[0].amplitudes == {2: 1.0, 3: 1.0}
    assert "engine orders 2 and 3" in both.full([1]).title
    own = replace(both, title="Stage 2, engine order 1")
    assert own.with_engine_order(3).heading == "Stage 2, engine order 1, engine order 3"


@pytest.mark.parametrize("stiffening", [False, True])
def test_frequencies_are_those_of_each_engine_orders_own_nodal_diameter(disk, stiffening):
    if stiffening:
        added = 1e-4 * disk.disk.stiffnesses
        disk = replace(disk, speed=ss.SpeedDependence(1, added))
    both = disk.with_engine_orders({2: 1.0, 3: 0.5, 10: 0.1})  # 10 and 2 of 12 sectors are one nodal diameter
    for stuck in (False, True):
        found = both.frequencies_by_order(stuck)
        assert list(found) == [2, 3, 10]
        for order, frequencies in found.items():
            alone = disk.with_engine_order(order)
            alone = replace(alone, speed=ss.SpeedDependence(order, disk.speed.stiffness)) if stiffening else alone
            np.testing.assert_allclose(frequencies, alone.frequencies(stuck), rtol=1e-9, atol=1e-6)
        distinct = found.values() if stiffening else (found[2], found[3])
        np.testing.assert_allclose(both.frequencies(stuck), np.sort(np.concatenate(list(distinct))), rtol=1e-9, atol=1e-6)
        np.testing.assert_allclose(
            both.systems.met(stuck), np.sort(np.concatenate([f / order for order, f in found.items()])), rtol=1e-12
        )


def test_peaks_of_an_unexcited_first_harmonic_are_refused_with_the_remedy(disk, speeds):
    band = ss.Band(0.99 * speeds[0], 1.01 * speeds[0])
    both = disk.with_engine_orders({2: 1.0, 3: 0.5})
    response = ss.forced_response(both, band, force=0.1, harmonics=3, samples=96, measure="max_abs")
    assert len(response.peaks())
    assert len(response.peaks(measure="rms"))
    with pytest.raises(InputError, match="max_abs"):
        response.peaks(measure="amplitude")


def test_the_loss_factor_is_per_cycle_of_the_engine_order_that_is_worked_on_most(disk):
    weak = {2: 1e-4, 3: 1.0, 4: 1e-4}
    both, alone = disk.with_engine_orders(weak), disk.with_engine_order(3)
    for force, tolerance in ((1e-3, 1e-6), (0.4, 1e-3)):
        speed = float(alone.modes(3).frequencies[0]) / 3
        many = ss.forced_response(both, [speed], force=force, harmonics=9, samples=432, measure="max_abs").dataset
        one = ss.forced_response(alone, [3 * speed], force=force, harmonics=3, samples=144).dataset
        assert float(many.loss_factor[0, 0]) == pytest.approx(float(one.loss_factor[0, 0]), rel=tolerance)
        assert float(many.dissipated.sum()) == pytest.approx(3 * float(one.dissipated.sum()), rel=1e-3, abs=1e-15)


def test_no_linear_curves_where_they_would_be_of_another_harmonic(disk, speeds):
    """Those of the first harmonic are no reference for the largest value of several."""
    band, how = ss.Band(0.99 * speeds[0], 1.01 * speeds[0]), {"force": [0.1, 0.4], "harmonics": 3, "samples": 96}
    both = disk.with_engine_orders({2: 1.0, 3: 0.5})
    response = ss.forced_response(both, band, measure="max_abs", **how)
    assert not has_linear_curves(response.dataset)
    lines = [layer.label for layer in response_curves(response.dataset).panels[0].layers if isinstance(layer, Line)]
    assert "contacts stuck" not in lines
    assert "Against" not in peaks_at_a_glance("a", response.dataset)
    alone = ss.forced_response(disk, ss.Band(2 * band.start, 2 * band.stop), measure="max_abs", **how)
    assert has_linear_curves(alone.dataset)
    lines = [layer.label for layer in response_curves(alone.dataset).panels[0].layers if isinstance(layer, Line)]
    assert "contacts stuck" in lines
    with pytest.raises(InputError, match="max_abs"):
        ss.forced_response(both, band, **how)


def test_figures_mark_every_excited_order(disk):
    found = ss.nodal_diameters(disk.with_engine_orders({2: 1.0, 3: 1.0, 11: 1.0})).dataset
    rules = [layer for layer in nodal_diameter_diagram(found).panels[0].layers if isinstance(layer, Rule)]
    assert [(rule.at, rule.label) for rule in rules] == [(2, "engine order 2"), (3, "engine order 3"), (1, "engine order 11")]
