"""The report as a browser shows it: its numbers are those of results.nc, its charts are drawn, a click shows loops."""

import numpy as np
import pytest
from report.synthetic import poor, synthetic
from system.browser import browser, program
from typer.testing import CliRunner

import stickslip as ss
from stickslip.cli import app
from stickslip.results.files import open_results
from stickslip.show.report import write

pytestmark = [pytest.mark.system, pytest.mark.skipif(program() is None, reason="no Chromium: see make verify-system")]

STUDY = """
[study]
title = "Two blades and a wedge damper, with a title that is longer than the lines of a telephone"
analysis = "forced_response"
[structure]
rig = "three_mass_wedge"
[sweep]
frequency = [145.0, 235.0]
force_levels = [0.2, 1.0]
"""


PERFORMANCE = """
[study]
analysis = "performance_curve"
[structure]
rig = "blade_and_wedge"
[sweep]
frequency = [280.0, 390.0]
harmonics = 1
samples = 64
[performance_curve]
force_ratio = [3.0, 100.0]
points = 6
friction = [0.2, 0.4]
"""


def results_of(study, folder):
    (folder / "study.toml").write_text(study)
    result = CliRunner().invoke(app, ["run", str(folder / "study.toml"), "--out", str(folder / "out"), "--workers", "1"])
    assert result.exit_code == 0, result.output
    return folder / "out"


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    return results_of(STUDY, tmp_path_factory.mktemp("report"))


@pytest.fixture(scope="module")
def performance(tmp_path_factory):
    return results_of(PERFORMANCE, tmp_path_factory.mktemp("performance"))


@pytest.fixture(scope="module")
def page(results):
    with browser() as page:
        page.open(results / "report.html")
        yield page


def test_the_peak_table_shows_the_numbers_of_the_results(page, results):
    data = open_results(results / "results.nc")
    rows = page.value(
        "[...document.querySelectorAll('#peaks tbody tr')].map(row => [Number(row.dataset.case), Number(row.dataset.rank), "
        "[...row.querySelectorAll('td')].map(cell => cell.textContent), "
        "[...row.querySelectorAll('td')].map(cell => cell.dataset.value ?? '')])"
    )
    assert len([rank for _, rank, _, _ in rows if rank]) == int(np.isfinite(data["peak_amplitude"]).sum())
    for case, rank, shown, values in (row for row in rows if row[1]):
        at = {"case": case, "peak": rank - 1, "output": list(data["output"].values).index(shown[1])}
        frequency, amplitude = (float(data[name][at]) for name in ("peak_frequency", "peak_amplitude"))
        assert (float(values[3]), float(values[4])) == (frequency, amplitude)
        assert float(shown[3]) == pytest.approx(frequency, abs=0.005)
        assert float(shown[4]) == pytest.approx(1e6 * amplitude, rel=1e-3)


def test_every_chart_is_drawn_and_nothing_goes_wrong(page):
    charts = page.value(
        "[...document.querySelectorAll('.place .chart')].map(c => [c.id, c.querySelectorAll('.main-svg').length])"
    )
    assert len(charts) >= 6
    assert [name for name, drawn in charts if not drawn] == []
    assert page.log == []


def test_a_click_on_a_curve_shows_its_loops(page):
    opened = "document.querySelector('[data-opened=\"chart-curves\"]')"
    assert page.value(f"{opened}.hidden")
    page.value("document.getElementById('chart-curves').scrollIntoView()")
    place = page.value(
        "(() => { const chart = document.getElementById('chart-curves'), k = 20;"
        "const curve = chart.data.find(t => t.name === 'force × 1' && t.mode === 'lines' && t.showlegend);"
        "const box = chart.getBoundingClientRect(), l = chart._fullLayout;"
        "return [box.x + l._size.l + l.xaxis.d2p(curve.x[k]), box.y + l._size.t + l.yaxis.d2p(curve.y[k])]; })()"
    )
    page.click(*place)
    page.until(f"!{opened}.hidden")
    caption = page.value(f"{opened}.querySelector('figcaption').textContent")
    assert caption.startswith("force × 1, ")
    assert "truncated to 5 harmonics" in caption
    assert page.value("document.getElementById('chart-curves-opened').data.length") >= 1


def test_accelerations_are_those_of_the_results(page, results):
    page.value("document.querySelector('[data-place=\"chart-curves\"] input[value=acceleration]').click()")
    shown = "document.getElementById('chart-curves').data.find(t => t.name === 'force × 1' && t.mode === 'lines' && t.showlegend)"
    data = open_results(results / "results.nc").isel(case=1)
    computed = data["amplitude"].isel(output=0) * (2 * np.pi * data["frequency"]) ** 2
    good = data["outcome"].values == 1
    np.testing.assert_allclose(page.value(f"{shown}.y"), computed.values[good], rtol=1e-5)
    parts = data["response"].values[good, 0, 1] @ [1.0, 1.0j]
    phases = np.array(page.value(f"{shown}.customdata.map(row => row[0])"))
    np.testing.assert_allclose(np.exp(1j * np.radians(phases)), -parts / np.abs(parts), atol=1e-5)
    assert "phase %{customdata[0]" in page.value(f"{shown}.hovertemplate")
    assert page.log == []


def test_a_choice_keeps_the_other_choices_and_the_focus(page):
    place = "document.querySelector('[data-place=\"chart-curves\"]')"
    page.value(f"{place}.querySelector('input[value=acceleration]').click()")
    page.value(f"{place}.querySelector('input[value=linear]').focus(); {place}.querySelector('input[value=linear]').click()")
    assert page.value(f"[...{place}.querySelectorAll('input:checked')].map(i => i.value)")[:2] == ["linear", "acceleration"]
    assert page.value("document.activeElement.value") == "linear"
    assert page.value("document.getElementById('chart-curves').layout.yaxis.type ?? 'linear'") == "linear"


def test_a_result_without_contacts_shows_no_loops_of_another(tmp_path):
    write({"with": synthetic(), "without": poor("no contacts")}, tmp_path / "report.html")
    with browser() as page:
        page.open(tmp_path / "report.html")
        hidden = "document.querySelector('[data-place=\"chart-loops\"]').hidden"
        assert not page.value(hidden)
        page.value("{ const s = document.getElementById('result'); s.value = 'without'; s.dispatchEvent(new Event('change')); }")
        assert page.value(hidden)
        assert (
            page.value("document.getElementById('chart-curves').data.filter(t => t.mode === 'lines' && t.showlegend).length") == 3
        )
        assert page.log == []


@pytest.mark.parametrize("kind", ["results", "performance"])
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1280, 390])
def test_charts_are_legible_on_every_screen(request, kind, width, scheme):
    """No chart is wider than the screen, none is lower than its legend needs, and text stands out from the background."""
    with browser() as page:
        page.call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=width < 600)
        page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        page.open(request.getfixturevalue(kind) / "report.html")
        assert page.value("document.documentElement.scrollWidth") <= width
        tops = page.value("[...document.querySelectorAll('.place')].map(p => p.getBoundingClientRect().top)")
        assert min(tops) < 900
        legends = page.value(
            "[...document.querySelectorAll('.place .chart')].filter(c => c.querySelector('.legend')).map(c => {"
            "const b = c.querySelector('.legend').getBoundingClientRect(), box = c.getBoundingClientRect();"
            "const s = c._fullLayout._size;"
            "return { left: b.left, top: b.top, right: b.right, across: box.left + s.l + s.w, below: box.top + s.t + s.h }; })"
        )
        for legend in legends:
            assert legend["top"] > legend["below"] + 30 if width < 600 else legend["left"] > legend["across"]
            assert legend["right"] <= width
        shown = page.value("[...document.querySelectorAll('figcaption')].map(c => c.textContent).join(' ')")
        assert len(shown) > 20
        assert "object" not in shown
        dark = page.value("getComputedStyle(document.querySelector('.ytick text')).fill") == "rgb(230, 233, 236)"
        assert dark == (scheme == "dark")
        assert page.log == []


FRAME = "document.getElementById('{}').layout.sliders[0].active || 0"


def press(page, selector, key="Enter", code=13):
    """A key on a control that has the focus."""
    page.value(f"document.querySelector('{selector}').focus()")
    for kind in ("keyDown", "keyUp"):
        page.call("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code, text="\r")


def errors(log):
    """What the console said but for remarks on the speed of drawing, which the software renderer of a headless browser makes."""
    return [line for line in log if '"source": "rendering"' not in line]


def test_moving_pictures_step_by_the_keyboard_and_shapes_turn_by_the_mouse(tmp_path):
    rig = ss.rigs.single_blade(modes=20)
    response = ss.forced_response(rig, [528.7], [20.0, 80.0], harmonics=1, samples=64).with_motion()
    write({"blade": response.dataset}, tmp_path / "report.html")
    with browser() as page:
        page.open(tmp_path / "report.html")
        page.until("document.querySelectorAll('#chart-shape canvas').length > 0")
        for chart, count in (("chart-motion", 48), ("chart-shape", 24)):
            buttons = [f'[data-place="{chart}"] .steps button[title="one frame {way}"]' for way in ("forward", "back")]
            press(page, buttons[0])
            page.until(f"({FRAME.format(chart)}) === 1")
            press(page, buttons[1])
            press(page, buttons[1])
            page.until(f"({FRAME.format(chart)}) === {count - 1}")
        shape = "document.getElementById('chart-shape')"
        drawn = np.array([page.value(f"Array.from({shape}._fullData[0].{axis})") for axis in "xyz"]).T
        expected = response.deformed_shape(0, 0).moved(23)
        np.testing.assert_allclose(drawn, expected, atol=1e-6)
        page.value(f"{shape}.scrollIntoView()")
        box = page.value(f"(b => [b.x, b.y, b.width, b.height])({shape}.getBoundingClientRect())")
        x, y = box[0] + 0.4 * box[2], box[1] + 0.4 * box[3]
        before = page.value(f"JSON.stringify({shape}._fullLayout.scene.camera.eye)")
        page.drag(x, y, x + 120, y + 30)
        page.until(f"JSON.stringify({shape}._fullLayout.scene.camera.eye) !== '{before}'")
        turned = page.value(f"{shape}._fullLayout.scene.camera.eye.x")
        press(page, buttons[0])
        page.until(f"({FRAME.format('chart-shape')}) === 0")
        assert page.value(f"{shape}._fullLayout.scene.camera.eye.x") == pytest.approx(turned)
        page.value('document.querySelector(\'[data-place="chart-shape"] input[value="80 N"]\').click()')
        page.until(f"{shape}._fullData[0].cmax > 2.0")
        assert page.value(f"{shape}._fullLayout.scene.camera.eye.x") == pytest.approx(turned)
        assert errors(page.log) == []
