"""The report: exact numbers in its tables, nothing loaded from elsewhere, and no way for a name to become code."""

import base64
import gzip
import hashlib
import json
import re

import numpy as np
import pytest
from report.pages import decoded, page_of
from report.synthetic import KINDS, poor, synthetic

from stickslip.results.view import highest_peak, level_text
from stickslip.show.report import write
from stickslip.show.report.answer import failures_of
from stickslip.show.report.markup import packed
from stickslip.show.report.page import page
from stickslip.show.report.responses import message_sentences
from stickslip.show.report.sections import OPENED
from stickslip.support.checks import InputError

HOSTILE = "</script><script>alert(1)</script><img src=x onerror=alert(2)>\"' & <!-- \u2028"


def test_peak_table_holds_the_exact_numbers(dataset, tmp_path):
    rows = page_of(dataset, tmp_path).numbers("peaks")
    expected = [
        [
            float(dataset.force_level[case]),
            float(dataset.peak_frequency[case, 0, output]),
            float(dataset.peak_amplitude[case, 0, output]),
            float(dataset.peak_amplitude[case, 0, output]) / float(dataset.force_level[case]),
            float(dataset.peak_max_abs[case, 0, output]),
            float(dataset.peak_loss_factor[case, 0, output]),
        ]
        for case in range(4)
        for output in range(2)
    ]
    assert rows == expected


@pytest.mark.slow
def test_the_largest_value_in_time_stands_in_one_column(dataset, tmp_path):
    """Also where the peaks are of it, which need no second table then."""
    dataset.highest_max_abs[0, 0], dataset.highest_max_abs_frequency[0, 0] = 3.5e-6, 512.25
    plain, largest = (page_of(each, tmp_path) for each in (dataset, dataset.assign_attrs(measure="max_abs")))
    head = re.compile(r"Largest( of \S+)? in µm")
    columns = [sum(head.fullmatch(words) is not None for words in page.words) for page in (plain, largest)]
    assert columns == [2, 2]  # the first screen has one of the latter, with the name of the output
    assert [len(row) for row in largest.numbers("peaks")] == [5] * 8
    assert plain.numbers("largest")
    assert not largest.numbers("largest")


def test_energy_table_holds_the_maxima(dataset, tmp_path):
    dataset.slip_work_error[2, 7] = -0.02
    dataset.energy_residual[3, :] = np.nan
    rows = page_of(dataset, tmp_path).numbers("energies")
    assert [row[3] for row in rows] == [3e-4, 3e-4, 0.02, 3e-4]
    assert np.isnan(rows[3][2])
    text = page_of(dataset, tmp_path).text()
    assert text.count("above 0.001") == 1


def test_charts_hold_the_data(dataset, tmp_path):
    page = page_of(dataset, tmp_path)
    chart = page.charts("chart-curves")["root.x", "linear", "acceleration", "per force"]
    curve = next(
        trace for trace in chart["data"] if trace["name"] == "force × 5" and trace["mode"] == "lines" and trace["showlegend"]
    )
    size = (2 * np.pi * dataset.frequency.values[1]) ** 2 * dataset.amplitude.values[1, :, 1] / 5.0
    known = np.isfinite(size)
    np.testing.assert_allclose(curve["y"], size[known], rtol=1e-6)
    np.testing.assert_allclose(curve["x"], dataset.frequency.values[1][known], rtol=1e-6)
    response = dataset.response.values[1, known, 1, 1] @ [1.0, 1.0j]
    np.testing.assert_allclose(curve["customdata"][0], np.abs(np.degrees(np.angle(-response))), atol=1e-4)
    assert chart["wide"]["yaxis"]["title"]["text"] == "amplitude per force ω²|X₁|/F in m/s² per unit level"
    loop = page.charts("chart-loops")["flat", "in N and µm"]["data"][3]
    np.testing.assert_allclose(loop["x"][:-1], 1e6 * dataset.loop_motion.values[3, 1, 0], rtol=1e-6)
    np.testing.assert_allclose(loop["y"][:-1], dataset.loop_force.values[3, 1, 0], rtol=1e-6)


def test_several_results_stand_in_one_report(dataset, tmp_path):
    page = page_of({"2.6 kg": synthetic(levels=(1.0, 5.0)), "4.6 kg": dataset}, tmp_path)
    assert len(page.numbers("peaks")) == 4 + 8
    data = page.data()
    assert data["results"] == ["2.6 kg", "4.6 kg"]
    assert [entry["result"] for entry in data["places"]["chart-curves"]] == data["results"]
    assert {trace["name"] for trace in page.charts("chart-trend")["tip.x",]["data"]} == {*data["results"]}
    assert any(attrs.get("id") == "result" for tag, attrs in page.elements if tag == "select")


def test_nothing_is_loaded_from_elsewhere(dataset, tmp_path):
    page = page_of(dataset, tmp_path)
    links = [value for _, attrs in page.elements for key, value in attrs.items() if key in ("src", "href", "data", "action")]
    assert links
    assert all(link.startswith("#") for link in links)
    assert not {"link", "iframe", "object", "embed", "base"} & {tag for tag, _ in page.elements}
    style = re.search(r"<style>(.*?)</style>", (tmp_path / "report.html").read_text(encoding="utf-8"), re.S).group(1)
    assert "url(" not in style
    assert "@import" not in style


def test_plotly_is_inlined_once_and_cannot_upload(dataset, tmp_path):
    page = page_of({"a": dataset, "b": dataset}, tmp_path)
    large = [attrs["id"] for attrs, text in page.scripts if len(text) > 1_000_000]
    assert large == ["library"]
    own = page.scripts[-1][1]
    assert "showSendToCloud: false" in own
    assert 'plotlyServerURL: ""' in own


def test_policy_allows_these_scripts_only(dataset, tmp_path):
    page = page_of(dataset, tmp_path)
    policy = next(attrs["content"] for tag, attrs in page.elements if attrs.get("http-equiv") == "Content-Security-Policy")
    code = [page.unpacked("library"), *(text for attrs, text in page.scripts if "type" not in attrs)]
    digests = [base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in code]
    assert re.search(r"script-src ([^;]*)", policy).group(1).split() == [f"'sha256-{digest}'" for digest in digests]
    assert "default-src 'none'" in policy


@pytest.mark.nightly
def test_hostile_names_stay_text(tmp_path):
    hostile = {"title": HOSTILE, "study": HOSTILE + "</pre>", HOSTILE: HOSTILE}
    dataset = synthetic(outputs=(HOSTILE,), contacts=(HOSTILE, "b"), **hostile)
    dataset.case_message[0] = HOSTILE
    dataset.case_outcome[0] = 2
    page, plain = page_of({HOSTILE: dataset, "b": dataset}, tmp_path), page_of({"a": synthetic(), "b": synthetic()}, tmp_path)
    assert [attrs for tag, attrs in page.elements if tag in ("img", "script")] == [
        attrs for tag, attrs in plain.elements if tag in ("img", "script")
    ]
    assert not any(key.startswith("on") for _, attrs in page.elements for key in attrs)
    assert page.data()["results"] == [HOSTILE, "b"]
    title = page.charts("chart-loops")[HOSTILE, "in N and µm"]["title"]
    assert title == f"Loops at the highest peak: {HOSTILE}"
    drawn = page.charts("chart-states")[()]["wide"]["yaxis"]["ticktext"][0]
    assert "<" not in drawn.replace("<br>", "")
    assert "alert(1)" in page.text()


def test_a_title_that_looks_like_the_name_of_a_colour_is_a_title(tmp_path):
    page = page_of(synthetic(title="@title", outputs=("@level",), contacts=("@a", "@b")), tmp_path)
    chart = next(iter(page.charts("chart-curves").values()))
    assert chart["title"] == "@title: @level"
    assert {*page.data()["colours"]["light"]} == {*page.data()["colours"]["dark"]}


def test_packed_text_cannot_leave_its_element():
    encoded = packed("data", HOSTILE)
    assert encoded.count("<") == 2
    assert gzip.decompress(base64.b64decode(encoded[encoded.index(">") + 1 : encoded.rindex("<")])).decode() == HOSTILE


def test_failures_are_grouped_by_cause(dataset_with_failures):
    sentences = failures_of(dataset_with_failures)
    assert len(sentences) == 2
    low, high = dataset_with_failures.frequency.values[1, [40, 41]]
    assert sentences[0].startswith("3 points: Newton's method did not converge")
    assert f"force × 5: {low:.2f} to {high:.2f} Hz; force × 80: " in sentences[0]
    assert sentences[1].startswith("1 point: With the prescribed start state no static equilibrium was found")


def test_a_curve_that_stopped_is_said(dataset):
    dataset.case_outcome[2] = 2
    dataset.case_message[2] = "Steps shrank to nothing at 500 Hz."
    assert failures_of(dataset) == ["force × 20: the curve did not reach the end of the band. Steps shrank to nothing at 500 Hz."]


def test_success_is_said(dataset, tmp_path):
    text = page_of(dataset, tmp_path).text()
    count = int(np.count_nonzero(dataset.outcome == 1))
    assert f"Every point converged: {count} points on 4 curves." in text
    assert f"All {count} points converged" in text


@pytest.mark.parametrize(
    "kind", [pytest.param(kind, marks=pytest.mark.nightly) if k % 2 else kind for k, kind in enumerate(KINDS)]
)
def test_poor_datasets_are_reported(kind, tmp_path):
    page = page_of(poor(kind), tmp_path)
    assert page.data()["places"]["chart-curves"][0]["charts"]
    assert "NaN" not in json.dumps(page.data())


def test_nothing_to_report_is_refused(tmp_path):
    with pytest.raises(InputError, match="at least one result"):
        write({}, tmp_path / "report.html")
    assert list(tmp_path.iterdir()) == []


def test_warnings_and_missing_peaks_are_said(dataset):
    dataset["case_message"] = dataset.case_message.astype("U200")
    dataset.case_message[1] = "The curve reached the end of the band. 2 places beside peaks could not be solved."
    dataset.peak_amplitude[2, :, 0] = np.nan
    dataset.highest_max_abs[0, 0], dataset.highest_max_abs_frequency[0, 0] = 3.5e-6, 512.25
    text = page({"one": dataset})
    assert "force × 5: 2 places beside peaks could not be solved." in text
    assert "force × 20: tip.x has no peak inside the band." in text
    assert "no peak inside the band; the largest point" in text
    assert re.search(r'data-value="3.5e-06">3.5</td><td [^>]*data-value="512.25">512.25</td>', text)


def test_the_console_prints_what_the_message_of_a_completed_curve_warns_of(dataset):
    places = "2 places beside peaks could not be solved, near 0.2 Hz; a peak there may be higher than reported."
    before = message_sentences(dataset)
    dataset = dataset.assign(case_message=dataset.case_message.astype(object))
    dataset.case_message[1] = f"The curve reached the end of the band. {places}"
    assert before == []
    assert message_sentences(dataset) == [f"warning, force {level_text(dataset, 1).removeprefix('force ')}: {places}"]


def test_loops_of_points_stay_within_their_share_of_the_page(dataset, tmp_path):
    """Clicks find loops at some points of every curve, one of them the peak: the sum of the harmonics that the result keeps."""
    dataset.contact_motion[:], dataset.contact_force[:] = 1e-6, 2.0
    page = page_of(dataset, tmp_path)
    opening = page.data()["places"]["chart-curves"][0]["opening"]
    assert len(opening["charts"]) <= OPENED + dataset.sizes["case"]
    peak = highest_peak(dataset, 2).point
    assert opening["points"]["force × 20"][peak] is not None
    x = decoded(opening["charts"][0], page.data()["parts"])["data"][0]["x"]
    angle = 2.0 * np.pi * np.arange(len(x)) / (len(x) - 1)
    np.testing.assert_allclose(x, 1.0 + sum(np.cos(h * angle) - np.sin(h * angle) for h in (1, 2, 3)), atol=1e-5)
