"""What is read from a dataset: peaks and their points, rows of contacts, colours of states."""

import numpy as np
import pytest
from report.synthetic import KT, LIMIT, synthetic

from stickslip.results.view import (
    along_curve,
    contact_rows,
    dissipated,
    failed_points,
    highest_peak,
    is_folded,
    largest_loops,
    length_unit,
    level_text,
    linear_peak,
    loop_areas,
    shares_at_peak,
)
from stickslip.show.plots.look import level_colours, state_colour


def test_highest_peak_points_at_its_point(dataset):
    peak = highest_peak(dataset, 2)
    assert peak.local
    assert dataset.frequency[2, peak.point] == peak.frequency
    assert dataset.amplitude[2, peak.point, 0] == peak.amplitude


def test_without_a_local_maximum_the_largest_point_stands_in(dataset):
    dataset.peak_amplitude[2] = np.nan
    peak = highest_peak(dataset, 2)
    assert not peak.local
    assert peak.amplitude == float(dataset.amplitude[2, :, 0].max())


def test_no_converged_point_gives_no_peak(dataset):
    dataset.outcome[1] = np.where(dataset.outcome[1] == 1, 2, 0)
    assert highest_peak(dataset, 1) is None


def test_failed_points_break_the_curve(dataset_with_failures):
    assert failed_points(dataset_with_failures, 1).tolist() == [40, 41]
    amplitude = along_curve(dataset_with_failures, "amplitude", 1)[:, 0]
    assert np.flatnonzero(np.isnan(amplitude)).tolist() == [40, 41]


def test_failed_points_never_show_a_number(dataset_with_failures):
    dataset_with_failures.amplitude[1, 40] = 1.0
    assert np.isnan(along_curve(dataset_with_failures, "amplitude", 1)[40, 0])


def test_contacts_give_their_tangential_rows_or_the_normal_one(dataset):
    assert [row.label for row in contact_rows(dataset)] == ["cylinder", "flat"]
    for name in ("share_stick", "share_slip", "share_open"):
        dataset[name][:, :, 0, 0] = np.nan
        dataset[name][:, :, 1, 1] = 0.0
    assert [row.label for row in contact_rows(dataset)] == ["cylinder, n", "flat, t1", "flat, t2"]


def test_directions_at_rest_are_left_out(dataset):
    for name in ("share_stick", "share_slip", "share_open"):
        dataset[name][:, :, :, 1] = dataset[name][:, :, :, 0]
    dataset.contact_motion[:, :, :, 0] = 1e-6
    dataset.contact_motion[:, :, 0, 1], dataset.contact_motion[:, :, 1, 1] = 1e-6, 1e-18
    assert [row.label for row in contact_rows(dataset)] == ["cylinder, t1", "cylinder, t2", "flat"]


def test_loop_areas_are_the_energy_of_the_elements(dataset):
    amplitude = float(dataset.peak_amplitude[3, 0, 0])
    exact = 4 * LIMIT * (amplitude - LIMIT / KT)
    assert loop_areas(dataset)[:, 0] == pytest.approx(exact, rel=2e-2)


def test_largest_loops_keep_their_order(dataset):
    rows = contact_rows(dataset)
    assert largest_loops(dataset, rows, 2) == rows
    assert [row.label for row in largest_loops(dataset, rows, 1)] == ["flat"]


def test_rounding_is_no_dissipation(dataset):
    dataset.dissipated[0] = 1e-25
    assert np.all(dissipated(dataset, 0)[:200] == 0.0)
    assert np.array_equal(dissipated(dataset, 3)[:9], dataset.dissipated.values[3, :9])


def test_small_shares_are_summed(dataset):
    names, energy, total = shares_at_peak(dataset, 2)
    assert names == ["cylinder", "flat"]
    grouped_names, grouped, _ = shares_at_peak(dataset, 1)
    assert grouped_names == ["2 others"]
    assert grouped[:, 0] == pytest.approx(energy.sum(axis=1))
    assert total[3] == float(dataset.dissipated[3, highest_peak(dataset, 3).point].sum())


def test_linear_peak_is_a_maximum_inside_the_band(dataset):
    assert linear_peak(dataset, "stuck", 0, 500.0)[0] == pytest.approx(561.0, abs=0.5)
    dataset.stuck_amplitude[0, :, 0] = np.linspace(0.0, 1.0, dataset.sizes["linear_point"])
    assert linear_peak(dataset, "stuck", 0, 500.0) is None


def test_of_several_resonances_that_of_the_same_mode_is_compared(dataset):
    """A higher second mode, 530 Hz free and 590 Hz stuck: the peak of the first, 494.75 Hz, lies between 410 and 561 Hz."""
    hertz = dataset.linear_frequency.values
    for which, second in (("free", 530.0), ("stuck", 590.0)):
        linear = dataset[f"{which}_amplitude"]
        linear[2, :, 0] += 3.0 * float(linear[2, :, 0].max()) / (1.0 + (hertz - second) ** 2)
    peak = highest_peak(dataset, 2)
    assert linear_peak(dataset, "stuck", 2, peak.frequency)[0] == pytest.approx(561.0, abs=0.6)
    above = 1.5 * float(linear[2, np.abs(hertz - 561.0).argmin(), 0])
    excited = linear_peak(dataset, "stuck", 2, peak.frequency, amplitude=2.0 * above)
    assert excited[0] == pytest.approx(590.0, abs=0.6), "friction takes energy: no peak is so much higher than its resonance"
    assert linear_peak(dataset, "free", 2, peak.frequency)[0] == pytest.approx(410.0, abs=0.6)
    assert linear_peak(dataset, "free", 2, 400.0)[0] == pytest.approx(410.0, abs=0.6), "the nearest where none lies below"
    assert linear_peak(dataset, "stuck", 2, 595.0)[0] == pytest.approx(590.0, abs=0.6), "within 1 %"


def test_lengths_are_shown_in_metres_where_micrometres_would_be_absurd(dataset):
    assert length_unit(dataset).name == "µm"
    large = dataset.assign(amplitude=1e4 * dataset.amplitude)
    assert length_unit(large).name == length_unit(dataset, large).name == "m"


def test_levels_are_newtons_only_where_the_dataset_says_so(dataset):
    assert level_text(dataset, 2) == "force × 20"
    dataset.force_level.attrs["units"] = "N"
    assert level_text(dataset, 2) == "20 N"


def test_folded_curves_are_noticed(dataset):
    assert not is_folded(dataset, 0)
    dataset.frequency[0, 50] = 1.0
    assert is_folded(dataset, 0)


@pytest.mark.parametrize("dark", [False, True])
def test_levels_differ_in_lightness(dark):
    colours = [[int(colour[i : i + 2], 16) for i in (1, 3, 5)] for colour in level_colours(6, dark)]
    lightness = np.array(colours) @ [0.2126, 0.7152, 0.0722]
    assert np.all(np.diff(lightness) > 5.0)


def test_states_differ_in_lightness():
    lightness = state_colour([1, 0, 0], [0, 1, 0], [0, 0, 1]) @ [0.2126, 0.7152, 0.0722]
    assert np.all(np.diff(lightness) > 0.2)


def test_synthetic_response_is_between_its_linear_limits():
    peaks = [highest_peak(synthetic(), case) for case in range(4)]
    assert all(410.0 < peak.frequency < 561.0 for peak in peaks)
    assert np.all(np.diff([peak.frequency for peak in peaks]) < 0.0)
