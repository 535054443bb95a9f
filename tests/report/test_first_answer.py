"""The table that a report of responses opens with, against the result itself."""

import re

import numpy as np
import pytest

import stickslip as ss
from stickslip.analyses.truncation import ALL_NODES
from stickslip.show.report.answer import comparison, peaks_at_a_glance, warnings_of
from stickslip.show.report.markup import Charts
from stickslip.show.report.responses import level_line
from stickslip.show.report.sections import energies, overview
from stickslip.support.outcome import Outcome


@pytest.fixture(scope="module")
def dataset():
    """Three levels: stuck, slipping a little, slipping much."""
    return ss.forced_response(ss.rigs.single_mass(), ss.radians_per_second(0.5, 2.0), [0.01, 1.0, 2.0], harmonics=3).dataset


def cells_of(html):
    rows = re.findall(r"<tr>(.*?)</tr>", html.partition("<tbody>")[2].partition("</tbody>")[0])
    return [re.findall(r"<td[^>]*>(.*?)</td>", row) for row in rows]


def test_a_row_for_each_level(dataset):
    html = peaks_at_a_glance("a", dataset)
    cells = cells_of(html)
    assert len(cells) == 3
    levels = re.findall(r'data-value="([^"]+)"', html)[0::3]
    assert [float(level) for level in levels] == [0.01, 1.0, 2.0]
    peaks = re.findall(r'data-value="([^"]+)"', html)
    assert [float(value) for value in peaks[2::3]] == pytest.approx(dataset["peak_amplitude"].values[:, 0, 0])
    assert [float(value) for value in peaks[1::3]] == pytest.approx(dataset["peak_frequency"].values[:, 0, 0])


def test_stuck_peaks_are_those_of_the_stuck_structure(dataset):
    """Friction that never slips changes nothing; where it slips the peak is lower than with stuck contacts."""
    stuck = [row[4] for row in cells_of(peaks_at_a_glance("a", dataset))]
    assert stuck[0] == "the same"
    assert stuck[1].startswith("−")
    assert "−" in stuck[1].partition(", ")[2]
    near = dataset.copy(deep=True)
    near["peak_amplitude"][0] *= 0.9
    near["peak_frequency"][0] *= 1.0 - 4e-4
    assert cells_of(peaks_at_a_glance("a", near))[0][4] == "−10.0\xa0%, same frequency", "0.0001 Hz are below what is estimated"


def test_the_largest_estimate_is_shown_with_its_cause(dataset):
    found = dataset.copy(deep=True)
    found["truncation_error"][:] = [[0.02], [0.0004], [np.nan]]
    found["sampling_error"][:] = [[0.01], [0.0002], [np.nan]]
    found[ALL_NODES.variable] = ("case", "output"), np.array([[-0.05], [0.0], [np.nan]])
    sure = [row[3] for row in cells_of(peaks_at_a_glance("a", found))]
    assert sure == ["5.0\xa0%, contact points", "below 0.1\xa0%", "not estimated"]
    found[ALL_NODES.variable][0] = np.nan  # the peak could not be solved with a contact at each node
    sure = [row[3] for row in cells_of(peaks_at_a_glance("a", found))]
    assert sure[0] == "2.0\xa0%, harmonics; that of contact points is unknown"


def test_the_least_certain_curve_warns_first(dataset):
    found = dataset.copy(deep=True)
    found["truncation_error"][:] = [[0.01], [0.4], [0.02]]
    found["case_message"] = "case", np.array([f"Arrived. Warning {name}." for name in "abc"])
    html = peaks_at_a_glance("a", found)
    assert re.findall(r"Warning (\w)", html) == ["b", "c", "a"]
    assert html.index("1 more warning") < html.index("Warning a")
    assert sum("Warning" in sentence for sentence in warnings_of(found)) == 3


def test_warnings_that_differ_in_their_numbers_are_one_that_opens_with_the_largest(dataset):
    found = dataset.copy(deep=True)
    change = ("+2.5 %", "-32.9 %", "+4.0 %")
    found["case_message"] = (
        "case",
        np.array([f"Arrived. The load changes it: {k}.5 µm ({much})." for k, much in enumerate(change)]),
    )
    html = peaks_at_a_glance("a", found)
    first = re.search(r'<details class="warning"><summary>(.*?)</summary>', html)[1]
    assert first == "1 N: The load changes it: 1.5 µm (-32.9 %). 2 more curves have the same warning, with smaller changes."
    assert "more warning" not in html
    assert re.findall(r"<li>([\d.]+ N): ", html) == ["2 N", "0.01 N"]


def test_one_table_compares_results_and_says_which_is_lowest(dataset):
    """Half the size is lowest beyond doubt; where the history of the load may double it, or an error is unknown, it is not."""
    small = dataset.copy(deep=True)
    for name in ("amplitude", "peak_amplitude"):
        small[name] *= 0.5
    small["history_change"] = ("case", "output"), np.array([[np.nan], [1.1], [-0.9]])
    html = comparison({"a": dataset, "b": small})
    name = str(dataset["output"].values[0])
    assert re.search('headline">(.*?)</p>', html)[1].replace("\xa0", " ") == (
        f"Lowest peak of {name}: b at 0.01 N and 2 N. "
        "At 1 N the order of the peaks is open: see their estimated errors and warnings."
    )
    rows = cells_of(html)
    assert [row[0] for row in rows] == ["a", "b"]
    sizes = [float(value) for value in re.findall(r'data-value="([^"]+)"', html)]
    peaks = dataset["peak_amplitude"].values[:, 0, 0]
    assert sizes == pytest.approx([*peaks, *(0.5 * peaks)])
    assert f"at {dataset['peak_frequency'].values[0, 0, 0]:.5g}" in rows[1][1]
    small["truncation_error"][0], small["sampling_error"][2] = np.nan, 1.1
    small["sampling_error"][0] = np.nan
    assert "Lowest" not in comparison({"a": dataset, "b": small})


def test_results_without_a_common_force_level_are_not_compared(dataset):
    other = dataset.assign_coords(force_level=dataset["force_level"] * 3.0)
    assert comparison({"a": dataset, "b": other}) == comparison({"a": dataset}) == ""
    page = overview({"a": dataset, "b": other}, Charts(["a", "b"]))
    assert page.count("<table") == 2
    page = overview({"a": dataset, "b": dataset}, Charts(["a", "b"]))
    assert page.count("<table") == 3
    assert "; its peaks: 6 stable</summary>" in page


def test_the_first_screen_says_what_is_known_of_stability(dataset):
    one = dataset.assign_attrs(one_motion=0, static_history="")
    one["highest_stability"] = ("case", "output"), np.array([[1], [0], [2]])
    html = peaks_at_a_glance("a", one)
    assert (
        '<p class="note">Highest peaks: stable at 0.01 N; stability not judged at 1 N; unstable at 2 N. '
        "[stability] judges all points.</p>"
    ) in html
    assert re.findall(r"unstable; ", html) == ["unstable; "]


def test_the_first_sentence_of_a_warning_stands_open(dataset):
    found = dataset.copy(deep=True)
    found["case_message"][:] = ["Arrived. Too few samples. Take 512.", "Arrived.", "Arrived."]
    html = peaks_at_a_glance("a", found)
    assert re.search(r'<details class="warning"><summary>[^<]*Too few samples.</summary>Take 512.</details>', html)


def test_a_curve_without_points_says_so(dataset):
    found = dataset.copy(deep=True)
    found["outcome"][1] = 2
    for name in ("peak_frequency", "peak_amplitude"):
        found[name][1] = np.nan
    assert cells_of(peaks_at_a_glance("a", found))[1][1:] == ["no point converged."]


def test_a_structure_without_contacts_is_compared_with_nothing():
    alone = ss.Problem(ss.Structure([[1.0]], [[1.0]], ("a.x",), C=[[0.1]]), (), (ss.Force("a.x", 1.0),), ("a.x",))
    html = peaks_at_a_glance("a", ss.forced_response(alone, ss.radians_per_second(0.5, 2.0), 1.0, harmonics=1).dataset)
    assert [len(row) for row in cells_of(html)] == [4]
    assert "Against" not in html


def test_an_infinite_response_has_no_estimated_error():
    """Undamped, the curve breaks off on its way up: how high it would go is not known, however small the estimates there."""
    alone = ss.Problem(ss.Structure([[1.0]], [[1.0]], ("a.x",)), (), (ss.Force("a.x", 1.0),), ("a.x",))
    found = ss.forced_response(alone, ss.radians_per_second(0.8, 1.2), 1.0, harmonics=1, samples=16).dataset
    assert found["case_outcome"][0] == Outcome.NOT_CONVERGED
    assert float(found["truncation_error"][0, 0]) == 0.0
    assert cells_of(peaks_at_a_glance("a", found))[0][3] == "cannot be judged"


def test_a_largest_point_is_not_compared_as_a_peak(dataset):
    """In a band on the flank the curve has no peak, and of a stopped curve none is known."""
    flank = ss.forced_response(ss.rigs.single_mass(), ss.radians_per_second(0.5, 0.8), 1.0, harmonics=3).dataset
    row = cells_of(peaks_at_a_glance("a", flank))[0]
    assert "no peak in the band" in row[1]
    assert len(row) == 4, "columns without anything to compare are left out"
    listed = ss.forced_response(ss.rigs.single_mass(), [0.15, 0.2, 0.23, 0.24], 1.0, harmonics=3).dataset
    row = cells_of(peaks_at_a_glance("a", listed))[0]
    assert "largest listed" in row[1]
    assert len(row) == 4
    flank["case_outcome"][:] = Outcome.STOPPED
    html = peaks_at_a_glance("a", flank)
    assert "not finished" in cells_of(html)[0][1]
    assert "no peak" not in html


def test_a_warning_begins_with_its_largest_error_and_the_study_warns_first(dataset):
    found = dataset.copy(deep=True).assign_attrs(study_warnings=["the pull is large: check it."])
    words = "Arrived. More harmonics would change it by about 1.3 %. The energy would change by about 27 %. More."
    found["case_message"] = "case", np.array(["Arrived.", words, "Arrived."])
    html = peaks_at_a_glance("a", found)
    said = re.findall(r'<(?:summary|p class="warning")>(.*?)</(?:summary|p)>', html)
    assert said[0] == "the pull is large: check it."
    assert said[1] == "1 N: The energy would change by about 27 %."
    assert "</summary>More harmonics would change it by about 1.3 %. More.</details>" in html


def test_a_disk_shows_the_rotor_speed_of_each_peak(dataset):
    """A peak under engine order 3 is met at a third of its frequency in turns per second."""
    turning = dataset.assign_attrs(engine_order=3, excited_orders=[3, 6])
    html = peaks_at_a_glance("a", turning)
    assert "Rotor speed in rev/min, engine orders 3, 6" in html
    speeds = [float(value) for value in re.findall(r'data-value="([^"]+)"', html)[2::4]]
    assert speeds == pytest.approx(dataset["peak_frequency"].values[:, 0, 0] * 20.0)
    assert "Rotor speed" not in peaks_at_a_glance("a", dataset)


def test_the_output_stands_in_the_head_of_its_only_column(dataset):
    name = str(dataset["output"].values[0])
    html = peaks_at_a_glance("a", dataset)
    assert f">Amplitude of {name} in " in html
    assert not [row for row in cells_of(html) if name in row]


def test_the_console_shows_peaks_in_the_unit_of_the_report(dataset):
    small = dataset.copy(deep=True)
    for name in ("amplitude", "peak_amplitude"):
        small[name] *= 1e-5
    head = re.search(r"Amplitude of \S+ in ([^<]+)<", peaks_at_a_glance("a", small))[1]
    size = float(small["peak_amplitude"][1, 0, 0])
    assert head == "µm"
    assert f" {1e6 * size:.4g} µm (error " in level_line(small, 1)


def test_each_force_level_has_its_smallest_fatigue_margin(dataset):
    """Two places with 100 MPa allowed: the larger stress at the worst point of a curve decides; nothing vibrates in the first."""
    stressed = dataset.copy(deep=True)
    shape = (*stressed["amplitude"].shape[:2], 2)
    alternating = np.full(shape, 10e6)
    alternating[0] = np.nan
    alternating[1, 4, 1], alternating[2, 7, 0] = 25e6, 200e6
    dims = ("case", "point", "place")
    stressed = stressed.assign(
        place=["root", "tip"],
        fatigue_amplitude=(dims, alternating),
        fatigue_mean=(dims, np.zeros(shape)),
        fatigue_limit=(dims, np.full(shape, 100e6)),
    )
    shown = [row[-1] for row in cells_of(peaks_at_a_glance("a", stressed))]
    assert shown == ["–", "4", "0.5 <small>fails</small>"]


@pytest.mark.parametrize("round_a_disk", [False, True])
def test_the_report_says_what_a_damping_ratio_makes_of_the_loss_factor(round_a_disk):
    """Stuck contacts, so viscous damping alone: 2ζ is the half-power bandwidth over the frequency of the peak."""
    rig = ss.rigs.lumped_blisk() if round_a_disk else ss.rigs.single_mass(damping=0.01)
    band = ss.hertz(147.0, 150.0) if round_a_disk else ss.radians_per_second(1.3, 1.5)
    found = ss.forced_response(rig, band, 1e-4, harmonics=1).dataset
    frequency, amplitude = found["frequency"].values[0], found["amplitude"].values[0, :, 0]
    top, half = int(np.nanargmax(amplitude)), np.nanmax(amplitude) / np.sqrt(2.0)
    rising, falling = slice(0, top + 1), slice(top, int(np.isfinite(frequency).sum()))
    left = np.interp(half, amplitude[rising], frequency[rising])
    right = np.interp(-half, -amplitude[falling], frequency[falling])
    bandwidth = (right - left) / frequency[top]
    loss = float(found["peak_loss_factor"].values[0, 0, 0])
    assert loss == pytest.approx((2.0 if round_a_disk else 1.0) * bandwidth, rel=0.02)
    assert ("4ζ" in energies({"a": found}, Charts(["a"]))) == round_a_disk
