"""Every kind of study: the charts of its report and its matplotlib figures hold the numbers of its results, with units and words.

Kinds are found by their templates, so that a new one must say here which numbers its charts show.
"""

import json
import re

import numpy as np
import pytest
from plots.small_runs import LESS, small_run
from report.pages import Page

from stickslip.results.files import open_results
from stickslip.show.plots.chart import Chart
from stickslip.show.report.markup import presentation_of
from stickslip.study.templates import KINDS

"""Keys of each template that are changed so that it runs in seconds; None: left out."""


def per_metre(data):
    """Shown units of length in a metre: millimetres in studies of mm, t and s, else micrometres."""
    return 1e3 if data.attrs.get("unit_system", "").startswith("mm") else 1e6


def response(data):
    yield data["frequency"].values[0], per_metre(data) * data["amplitude"].values[0, :, 0]
    yield per_metre(data) * data["loop_motion"].values[0, 0, 0], data["loop_force"].values[0, 0, 0]
    yield data["frequency"].values[0], data["loss_factor"].values[0]


def many_contacts(data):
    """Loops of the contacts that dissipate most are drawn; where all stick, rounding decides which."""
    yield data["frequency"].values[0], per_metre(data) * data["amplitude"].values[0, :, 0]
    yield data["frequency"].values[0], data["loss_factor"].values[0]


def bounds(data):
    for k in range(2):
        yield data["bounds_frequency"].values, 1e6 * data["bounds_amplitude"].values[0, k]


def samples(data):
    yield data["frequency"].values[0], 1e6 * data["amplitude"].values[0, :, 0]
    yield data["frequency"].values[0], 1e6 * np.median(data["amplitude"].values[:3, :, 0], axis=0)


def controlled(data):
    yield data["frequency"].values[0], data["force_level"].values[0]
    yield data["held_amplitude"].values, data["resonance_frequency"].values[:, 0]


def identified_responses(data):
    for key in ("measured", "computed"):
        yield data["frequency"].values[0], data[key].values[0]
    yield None, 100.0 * data["misfit"].values


def predicted_responses(data):
    for k in range(2):
        yield data["frequency"].values[k], data["amplitude"].values[k]
    yield data["level"].values, data["peak_amplitude"].values


def predicted_decays(data):
    size = 1e6 * data["amplitude"].values
    yield size, data["frequency"].values
    yield size, 100.0 * data["damping_ratio"].values
    yield 1e6 * data["measured_amplitude"].values[0], 100.0 * data["measured_damping_ratio"].values[0]


def decays(data):
    yield 1e3 * data["time"].values, 1e6 * data["displacement"].values[0]
    yield 1e6 * data["amplitude"].values[0], data["frequency"].values[0]
    yield 1e6 * data["mode_amplitude"].values[0, :, 0], 100.0 * data["mode_damping_ratio"].values[0, :, 0]


def stepped_sines(data):
    for key in ("amplitude", "balance_amplitude"):
        yield data["frequency"].values, 1e6 * data[key].values[:, 0]
    yield data["frequency"].values, data["distance"].values


def performance(data):
    for case in range(2):
        yield data["force_ratio"].values, data["normalised_amplitude"].values[case]
        yield data["force_ratio"].values, data["frequency"].values[case]


def modes(data):
    yield 1e6 * data["amplitude"].values[0, :, 0], data["frequency"].values[0]
    yield 1e6 * data["amplitude"].values[0, :, 0], 100.0 * data["damping_ratio"].values[0]
    yield data["peak_force_level"].values[0], 1e6 * data["peak_amplitude"].values[0, :, 0]


def speed_sweep(data):
    solved = data["outcome"].values[0, 0] == 1
    yield data["speed"].values[0, 0][solved], 1e6 * data["amplitude"].values[0, 0][solved, 0]


def campbell(data):
    yield data["speed"].values, data["frequency"].sel(state="nonlinear", mode=1).values[0]
    yield data["crossing_speed"].values[:, 0, 0], data["crossing_frequency"].values[:, 0, 0]


def run_up(data):
    yield data["speed"].values[0], 1e6 * data["amplitude"].values[0, :, 0]


def limit_cycles(data):
    heights = data["amplitude"].values[0, ..., 0]
    there = np.isfinite(heights)
    yield np.broadcast_to(100.0 * data["aerodynamic_damping"].values[:, None], there.shape)[there], 1e6 * heights[there]


def performance_band(data):
    yield from ((data["force_ratio"].values, 1e6 * values) for values in data["amplitude_per_force"].values.T)


def design(data):
    allowed = data["allowed"].values == 1
    yield data["value"].values[allowed, 0], data["value"].values[allowed, 1]
    yield None, data["sensitivity"].values[:, 0]


def indices(data):
    for end in ("low_end", "high_end"):
        change = 100.0 * (data[end].values[:, 0] / float(data["middle"][0]) - 1.0)
        yield None, change


def mistuned(data):
    worst = data.isel(sample=int(np.nanargmax(data["amplification"].values)))
    yield worst["frequency"].values, 1e6 * worst["envelope"].values
    yield data["tuned_frequency"].values, 1e6 * data["tuned_amplitude"].values


def cycle(data):
    yield 1e6 * data["platform_motion"].values[:, 1], data["force_on_right"].values[:, 1]
    yield data["phase"].values, data["force_ratio"].values[:, 0]


def cycles(data):
    moving = int(np.argmax(np.ptp(data["platform_motion"].values[0], axis=0)))
    yield 1e6 * data["platform_motion"].values[0, :, moving], data["force_on_right"].values[0, :, moving]
    yield None, 1e6 * data["loop_energy"].values


def identification(data):
    one = data.isel(case=0)
    larger = int(np.argmax(np.ptp(one["platform_motion"].values, axis=1)))
    yield 1e6 * one["platform_motion"].values[larger], one["measured"].sel(channel="force_x").values
    yield one["replicates"].values[:, 0] / 1e6, one["replicates"].values[:, 1] / 1e6


def contact_law(data):
    one = data.isel(loop=0)
    yield 1e6 * one["displacement"].values, one["force_measured"].values
    yield data["cycle_number"].values, 1e-6 * data["cycle_kt"].values


SHOWN = {
    **dict.fromkeys(("bladed_disk", "blisk", "forced_response", "lumped", "model", "ring_damper", "shrouded_blades"), response),
    **dict.fromkeys(("beams_with_a_gap", "blade_root", "jointed_beams", "strip_damper", "two_blades"), many_contacts),
    "controlled_response": controlled,
    "response_bounds": bounds,
    "response_samples": samples,
    "nonlinear_modes": modes,
    **dict.fromkeys(("flutter", "limit_cycles"), limit_cycles),
    "speed_sweep": speed_sweep,
    "campbell": campbell,
    "run_up": run_up,
    "performance_curve": performance,
    "performance_band": performance_band,
    "damper_design": design,
    "sensitivity_indices": indices,
    "mistuned_population": mistuned,
    "damper_cycle": cycle,
    **dict.fromkeys(("steady_cycles", "damper_evolution"), cycles),
    "identification": identification,
    "contact_law": contact_law,
    "response_identification": identified_responses,
    "response_prediction": predicted_responses,
    "free_decay": decays,
    "decay_prediction": predicted_decays,
    "stepped_sine": stepped_sines,
}
"""Numbers that a curve, points or bars show, x and y in the units of the axes; None: places of bars, in any order."""

NUMBERS = (
    *(
        "force ratio F_C/F_E",
        "force level",
        "loss factor",
        "share of the period",
        "share of the cycle",
        "nodal diameter",
        "blade",
    ),
    *(
        "cycle",
        "contact law",
        "force ratio T/N",
        "ratio T/N along t1",
        "probability density",
        "damper after blade",
        "start variable",
    ),
    *("damper mass", "platform angle", "friction coefficient μ", "distance from the steady motion"),
)
"""Axes without a unit that need none, and variables of a design, of which a study knows no unit."""
WITHOUT_UNIT = re.compile(r"(relative to|over (tuned|pull|its)|samples in which|number of|^μ of|amplification|half its range)")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Folder of the results of a kind, computed once."""
    kept = {}

    def of(kind):
        if kind not in kept:
            kept[kind] = small_run(kind, tmp_path_factory.mktemp(kind))
        return kept[kind]

    return of


def charts_of(data):
    """Every chart among the figures of a result."""
    found = {name: draw(data) for name, draw in presentation_of(data).figures(data).items()}
    return {name: chart for name, chart in found.items() if isinstance(chart, Chart)}


def same(x, y, drawn):
    """Whether drawn numbers are those, closed to a period or not; bars may stand in any order."""
    if x is None:
        return drawn[1].size == y.size and np.allclose(np.sort(drawn[1]), np.sort(y), rtol=1e-5, atol=1e-12)
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    shown = np.isfinite(drawn[0]) & np.isfinite(drawn[1])
    over, up = (values[shown][: x.size] for values in drawn)
    scales = np.abs(x).max(initial=0.0), np.abs(y).max(initial=0.0)
    return x.size == over.size > 0 and all(
        np.allclose(a, b, rtol=1e-5, atol=1e-6 * scale) for a, b, scale in ((over, x, scales[0]), (up, y, scales[1]))
    )


def in_the_page(page):
    """Numbers of every trace of every chart of a report."""
    for name, results in page.data()["places"].items():
        for chart in page.charts(name).values():
            for trace in chart["data"]:
                if trace["type"] in ("scatter", "bar"):
                    x, y = (np.array(trace[letter], dtype=float) for letter in "xy")
                    yield (x, x if trace.get("orientation") == "h" else y) if trace["type"] == "bar" else (x, y)
        assert results


def on_paper(charts):
    """Numbers of every line, of all bars of a label, and of all points of matplotlib figures."""
    for chart in charts.values():
        for axes in chart.plot().axes:
            yield from ((np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)) for line in axes.lines)
            yield from (np.asarray(points.get_offsets(), float).T for points in axes.collections if len(points.get_offsets()) > 1)
            for bars in axes.containers:
                level = all(np.isclose(bar.get_height(), bars[0].get_height()) for bar in bars) and len(bars) > 1
                yield np.zeros(len(bars)), np.array([bar.get_width() if level else bar.get_height() for bar in bars])


def test_every_kind_is_tried():
    assert {*LESS} == {*SHOWN} == {*KINDS}


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_charts_hold_the_numbers_of_the_results(kind, run):
    data = open_results(run(kind) / "results.nc")
    page = Page((run(kind) / "report.html").read_text(encoding="utf-8"))
    report, paper = list(in_the_page(page)), list(on_paper(charts_of(data)))
    for x, y in SHOWN[kind](data):
        assert any(same(x, y, drawn) for drawn in report), "not in the report"
        assert any(same(x, y, drawn) for drawn in paper), "not on paper"


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_axes_have_words_and_units(kind, run):
    charts = charts_of(open_results(run(kind) / "results.nc"))
    assert charts
    for name, chart in charts.items():
        for axis in [axis for panel in chart.panels if panel.layers for axis in (panel.x, panel.y)]:
            where = f"{kind}, {name}: {axis.label}"
            assert axis.unit or axis.names or axis.quantity in NUMBERS or WITHOUT_UNIT.search(axis.quantity), where
            words = axis.label.replace("F_C/F_E", "")
            assert not re.search(r"\w_\w", words), where


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_reports_open_with_the_answer_and_a_chart_and_load_nothing(kind, run):
    text = (run(kind) / "report.html").read_text(encoding="utf-8")
    page = Page(text)
    answer, chart = re.search(r'class="headline"|<table id="answer', text).start(), text.index('class="place"')
    assert answer < chart
    tables = re.findall(r'<table id="([\w-]+)"', text[text.index('id="overview"') : chart])
    shown = presentation_of(open_results(run(kind) / "results.nc"))
    expected = "answer-" if shown.responses else f"table-0-{shown.answer.replace(' ', '-')}"
    assert [table.startswith(expected) for table in tables] == [True] * (shown.responses or shown.answer != "")
    assert {attrs["data-place"] for tag, attrs in page.elements if tag == "figure" and "data-place" in attrs} == {
        *page.data()["places"]
    }
    assert not [
        link for _, attrs in page.elements for key, link in attrs.items() if key == "src" and not link.startswith("data:")
    ]
    shown = re.sub(r'<table id="energies">.*?</table>', "", text)  # its residuals are rounding
    assert not re.search(r"e-(1[5-9]|2\d)( µJ|<)", shown), "rounding is shown as 0"
    json.dumps(page.data(), allow_nan=False)
