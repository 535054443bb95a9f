"""The report as a browser shows it: its numbers are those of results.nc, its charts are drawn, a click shows loops."""

import numpy as np
import pytest
from system.browser import browser, program
from typer.testing import CliRunner

from stickslip.cli import app
from stickslip.results.files import open_results

pytestmark = [pytest.mark.system, pytest.mark.skipif(program() is None, reason="no Chromium: see make verify-system")]

STUDY = """
[study]
analysis = "forced_response"
[structure]
rig = "three_mass_wedge"
[sweep]
frequency = [145.0, 235.0]
force_levels = [0.2, 1.0]
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    (folder / "wedge.toml").write_text(STUDY)
    result = CliRunner().invoke(app, ["run", str(folder / "wedge.toml"), "--out", str(folder / "out"), "--workers", "1"])
    assert result.exit_code == 0, result.output
    return folder / "out"


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
        "[...document.querySelectorAll('.chart:not(#chart-cycle)')].map(c => [c.id, c.querySelectorAll('.main-svg').length])"
    )
    assert len(charts) >= 7
    assert [name for name, drawn in charts if not drawn] == []
    assert page.log == []


def test_a_click_on_a_curve_shows_its_loops(page):
    assert page.value("document.getElementById('cycle').hidden")
    page.value("document.getElementById('chart-curves').scrollIntoView()")
    place = page.value(
        "(() => { const chart = document.getElementById('chart-curves'), c = data.results[0].cases[1], k = 20;"
        "const box = chart.getBoundingClientRect(), l = chart._fullLayout;"
        "return [box.x + l._size.l + l.xaxis.d2p(c.frequency[k]), box.y + l._size.t + l.yaxis.d2p(c.amplitude[0][k])]; })()"
    )
    page.click(*place)
    page.until("!document.getElementById('cycle').hidden")
    assert "force × 1" in page.value("document.getElementById('point').textContent")
    title = page.value("document.getElementById('chart-cycle').layout.title.text")
    assert "truncated to 5 harmonics" in title
    assert page.value("document.getElementById('chart-cycle').data.length") >= 1


def test_accelerations_are_those_of_the_results(page, results):
    page.value('document.querySelector(\'input[name="quantity"][value="acceleration"]\').click()')
    drawn = page.value("document.getElementById('chart-curves').data.filter(t => t.meta === 1)[0].y")
    data = open_results(results / "results.nc").isel(case=1)
    computed = data["amplitude"].isel(output=0) * (2 * np.pi * data["frequency"]) ** 2
    computed = computed.values[data["outcome"].values == 1]
    np.testing.assert_allclose(drawn, computed, rtol=1e-4)
    assert page.log == []
