"""Results are shown in the units that their study states: the same blade stated in m and in mm-t-s gives the same numbers.

Console, tables, figures, report and exported files of the study in mm carry mm, N, N/mm, MPa and mJ; the dataset is in SI.
"""

import base64
import gzip
import json
import re
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy import io
from typer.testing import CliRunner

import stickslip as ss
from stickslip.cli import app
from stickslip.results.schema import attributes_of, in_system, shown_dataset, shown_sentence, shown_table, system_of
from stickslip.runs.cases import CheckpointFolder
from stickslip.show.plots.chart import Axis, Bars, Chart, Line, Panel, Rule, shown_chart
from stickslip.show.plots.look import Style
from stickslip.show.report.answer import failures_of, warnings_of
from stickslip.show.report.markup import presentation_of
from stickslip.show.report.page import page
from stickslip.study.reading import job
from stickslip.study.run import Run
from stickslip.support.units import UNIT_SYSTEMS, UnitSystem

STUDY = """
{units}
[study]
analysis = "forced_response"
title = "blade"
[structure]
matrices = {{ M = [[{M}]], K = [[{K}]] }}
dofs = ["m.x"]
[damping]
modal = 0.01
[[contact]]
name = "pad"
law = "macroslip"
between = ["m.x", "ground"]
kt = {kt}
mu = 0.5
normal_load = 20.0
[[force]]
direction = "m.x"
amplitude = 1.0
[sweep]
frequency = [200.0, 300.0]
outputs = ["m.x"]
force_levels = [2.0, 4.0]
harmonics = 1
samples = 64
"""
IN_M = STUDY.format(units="", M=0.5, K=1e6, kt=2e5)
IN_MM = STUDY.format(units='units = "mm-t-s"', M=5e-4, K=1e3, kt=2e2)
SYSTEM = UNIT_SYSTEMS["mm-t-s"]


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Results of both studies by their units, and the folder of each."""
    found = {}
    for name, text in (("m", IN_M), ("mm", IN_MM)):
        folder = tmp_path_factory.mktemp(name)
        run = Run({"": job(text, folder, name)}, folder)
        found[name] = run.computed(CheckpointFolder(folder / "kept", {}), lambda *_: None)[""], folder
    return found


@pytest.mark.parametrize(
    ("unit", "factor", "name"),
    [
        ("m", 1e3, "mm"),
        ("µm", 1e-3, "mm"),
        ("m/N", 1e3, "mm/N"),
        ("m/(s2 N)", 1e3, "mm/(s2 N)"),
        ("N/m", 1e-3, "N/mm"),
        ("N/um", 1e3, "N/mm"),
        ("Pa", 1e-6, "MPa"),
        ("MPa", 1.0, "MPa"),
        ("J", 1e3, "mJ"),
        ("µJ", 1e-3, "mJ"),
        ("kg", 1e-3, "t"),
        ("kg m2", 1e3, "t mm2"),
        ("m kg^0.5", 1e3 * 1e-3**0.5, "mm t^0.5"),
        ("m per unit level", 1e3, "mm per unit level"),
        ("Hz", 1.0, "Hz"),
        ("rev/min", 1.0, "rev/min"),
        ("s", 1.0, "s"),
        ("1", 1.0, "1"),
        ("", 1.0, ""),
    ],
)
def test_each_unit_in_mm_t_s(unit, factor, name):
    """N/mm² is MPa, N mm is mJ."""
    assert in_system(unit, SYSTEM) == (pytest.approx(factor, rel=1e-12), name)
    assert in_system(unit, None) == (1.0, unit)


@pytest.mark.parametrize(
    ("system", "force", "stress", "energy"),
    [("mm-kg-ms", "kN", ("GPa", 1e-9), ("J", 1.0)), ("mm-kg-s", "mN", ("kPa", 1e-3), ("µJ", 1e6))],
)
def test_stress_and_energy_of_other_systems(system, force, stress, energy):
    """kN/mm² is GPa and kN mm is J; mN/mm² is kPa and mN mm is µJ."""
    own = UNIT_SYSTEMS[system]
    assert in_system("N", own)[1] == force
    assert in_system("Pa", own) == (pytest.approx(stress[1]), stress[0])
    assert in_system("J", own) == (pytest.approx(energy[1]), energy[0])


def test_the_dataset_is_the_same_in_si(results):
    """The units of the study do not change what is computed, only an attribute says how to show it."""
    metres, millimetres = results["m"][0], results["mm"][0]
    assert "unit_system" not in metres.attrs
    assert system_of(millimetres) == SYSTEM
    for name in ("peak_frequency", "peak_amplitude", "dissipated", "loop_force"):
        np.testing.assert_allclose(millimetres[name], metres[name], rtol=1e-6, atol=1e-15)
        assert millimetres[name].attrs["units"] == metres[name].attrs["units"]


def test_the_file_keeps_the_units(results):
    assert system_of(ss.open_results(results["mm"][1])) == SYSTEM


def test_the_console_says_mm(results):
    dataset, _ = results["mm"]
    line = next(line for line in presentation_of(dataset).sentences(dataset) if line.startswith("  force 4"))
    assert re.search(r"amplitude +([\d.e-]+) mm ", line)[1] == f"{1e3 * float(dataset['peak_amplitude'][1, 0, 0]):.4g}"


def test_tables_are_in_mm_and_those_of_m_in_m(results):
    for name, unit, factor in (("m", "m", 1.0), ("mm", "mm", 1e3)):
        dataset = results[name][0]
        table = presentation_of(dataset).tables(dataset)["peaks"]
        np.testing.assert_allclose(table[f"amplitude [{unit}]"], factor * dataset["peak_amplitude"].values[:, 0, 0], rtol=1e-12)


def test_exported_files_are_in_mm(results, tmp_path):
    dataset, folder = results["mm"]
    for suffix, more in (("csv", []), ("mat", [])):
        found = CliRunner().invoke(app, ["export", str(folder), "--out", str(tmp_path / f"a.{suffix}"), *more])
        assert found.exit_code == 0, found.output
    peaks = pd.read_csv(tmp_path / "a_peaks.csv")
    np.testing.assert_allclose(peaks["amplitude [mm]"], 1e3 * dataset["peak_amplitude"].values[:, 0, 0], rtol=1e-9)
    curves = pd.read_csv(tmp_path / "a.csv")
    assert {"amplitude [mm]", "rms [mm]", "frequency [Hz]"} <= set(curves)
    content = io.loadmat(tmp_path / "a.mat")
    np.testing.assert_allclose(content["peak_amplitude"], 1e3 * dataset["peak_amplitude"], rtol=1e-12)
    units = content["units"][0, 0]
    assert [str(units[name][0]) for name in ("peak_amplitude", "dissipated", "contact_force")] == ["mm", "mJ", "N"]


def test_velocities_are_in_mm_per_second(results, tmp_path):
    _, folder = results["mm"]
    options = ["--quantity", "acceleration", "--per-force"]
    found = CliRunner().invoke(app, ["export", str(folder), "--out", str(tmp_path / "a.csv"), *options])
    assert found.exit_code == 0, found.output
    assert "amplitude [mm/(s2 N)]" in pd.read_csv(tmp_path / "a.csv")


def test_the_report_is_in_mm(results):
    html = page({"blade": results["mm"][0]})
    body = re.sub(r"<[^>]+>", " ", html[html.index("<main>") : html.index("</main>")])
    assert "Amplitude in mm" in body
    assert "mm/N" in body
    assert not re.search(r"µm|\bin m\b|\d J\b", body)
    data = gzip.decompress(base64.b64decode(re.search(r'id="data">(.*?)</script>', html)[1])).decode()
    text = json.dumps(json.loads(data), ensure_ascii=False)
    assert "amplitude |X₁| in mm" in text
    assert "energy per period in mJ" in text
    assert "µm" not in text


def test_figures_carry_the_numbers_of_their_axes(results):
    """The highest point of the drawn curve is the peak, in the unit of the axis."""
    dataset, _ = results["mm"]
    chart = presentation_of(dataset).figures(dataset)["loops"](dataset)
    panel = chart.panels[-1]
    assert (panel.x.unit, panel.y.unit) == ("mm", "N")
    drawn = max(float(np.nanmax(layer.x)) for layer in panel.layers if isinstance(layer, Line))
    assert drawn == pytest.approx(1e3 * float(np.nanmax(dataset["loop_motion"].values[1])), rel=1e-9)


def test_a_response_from_the_file_is_drawn_in_mm(results, tmp_path):
    (tmp_path / "mm.toml").write_text(IN_MM)
    response = ss.ForcedResponse(results["mm"][0], ss.read_problem(tmp_path / "mm.toml"))
    assert " mm " in repr(response)
    assert response.plot().axes[0].get_ylabel().endswith("in mm")
    assert "mm" in response.animate(1).to_plotly().layout.xaxis.title.text


def test_a_chart_is_converted_axis_by_axis():
    """Lines, bars, rules, limits and hover texts go with the unit of their axis; numbers without a unit stay."""
    style = Style("ink")
    layers = [
        Line([1.0], [20.0], style, hover={"energy in J": [0.5], "curve": ["a"]}),
        Bars([1.0], [20.0], style, base=10.0),
        Bars([20.0], [1.0], style, horizontal=True),
        Rule(30.0, style, along="y"),
    ]
    across = Panel(Axis("force", "N"), Axis("motion", "m", limits=(0.0, 50.0)), layers)
    panel = shown_chart(Chart("t", [across]), UnitSystem("mm", "kN", "kg", "ms")).panels[0]
    line, upright, flat, rule = panel.layers
    assert (panel.x.label, panel.y.label, panel.y.limits) == ("force in kN", "motion in mm", (0.0, pytest.approx(5e4)))
    assert (line.x, line.y) == (pytest.approx([1e-3]), pytest.approx([2e4]))
    assert line.hover == {"energy in J": [0.5], "curve": ["a"]}
    assert (upright.at, upright.size, upright.base, upright.width) == tuple(map(pytest.approx, ([1e-3], [2e4], 1e4, 0.8e-3)))
    assert (flat.at, flat.size, flat.width) == tuple(map(pytest.approx, ([2e4], [1e-3], 800.0)))
    assert rule.at == pytest.approx(3e4)


def test_a_table_is_converted_column_by_column():
    dataset = xr.Dataset(attrs=attributes_of(SYSTEM))
    table = pd.DataFrame({"stress [Pa]": [2e8], "kt in N/um": [0.5], "share": [0.1], "name": ["a"], "at Hz": [80.0]})
    shown = shown_table(table, dataset)
    assert shown.to_dict("list") == {
        "stress [MPa]": [pytest.approx(200.0)],
        "kt in N/mm": [pytest.approx(500.0)],
        "share": [0.1],
        "name": ["a"],
        "at Hz": [80.0],
    }
    assert shown_table(table, xr.Dataset()).equals(table)


@pytest.mark.parametrize(
    ("sentence", "shown"),
    [
        ("limit cycle: 12.3 µm of 1.x at 80 Hz.", "limit cycle: 0.0123 mm of 1.x at 80 Hz."),
        ("0.002 m, then 1e-3 m.", "2 mm, then 1 mm."),
        ("from the modal amplitude 0.001 m kg^0.5 on", "from the modal amplitude 0.03162 mm t^0.5 on"),
        ("A spring of 2e+05 N/m holds it", "A spring of 200 N/mm holds it"),
        (
            "kt × 1.8 = 90050 N/m, 95 % interval 89982 to 90120 N/m (× 1.79 to 1.81)",
            "kt × 1.8 = 90.05 N/mm, 95 % interval 89.98 to 90.12 N/mm (× 1.79 to 1.81)",
        ),
        ("3 m^2, 4 mm, 5 N m and 6 masses", "3 m^2, 4 mm, 5 N m and 6 masses"),
        ("6.216 m/s2 where 4.72 m/s, 0.002 m/N or 3 m/(s2 N)", "6216 mm/s² where 4720 mm/s, 2 mm/N or 3000 mm/(s² N)"),
    ],
)
def test_a_kept_sentence_is_shown_in_the_units_of_the_study(sentence, shown):
    dataset = xr.Dataset(attrs=attributes_of(SYSTEM))
    assert shown_sentence(sentence, dataset) == shown
    assert shown_sentence(shown, dataset) == shown
    assert shown_sentence(sentence, xr.Dataset()) == sentence


def test_a_small_length_of_a_kept_sentence_has_the_unit_of_the_tables():
    assert shown_sentence("4.678e-07 m at 551 Hz; 0.0005 m", xr.Dataset()) == "0.4678 µm at 551 Hz; 0.0005 m"


def test_forces_of_a_kept_sentence_are_shown_in_the_units_of_the_study():
    dataset = xr.Dataset(attrs=attributes_of(UnitSystem("mm", "kN", "kg", "ms")))
    assert shown_sentence("A preload of 100 N, of which 9.09 N are left; 5 N m", dataset) == (
        "A preload of 0.1 kN, of which 0.00909 kN are left; 5 N m"
    )


def test_limit_cycles_and_modes_are_told_in_mm(tmp_path):
    """The message that the result keeps, and the modal amplitude of the table, with its unit."""
    alone = IN_MM.replace("forced_response", "limit_cycles").replace("force_levels = [2.0, 4.0]\n", "")
    text = alone + "[limit_cycles]\naerodynamic_damping = [-0.03]\n"
    run = Run({"": job(text, tmp_path, "mm")}, tmp_path)
    dataset = run.computed(CheckpointFolder(tmp_path / "kept", {}), lambda *_: None)[""]
    size = float(dataset["amplitude"][0, 0, 0, 0])
    said = "\n".join(presentation_of(dataset).sentences(dataset))
    assert f"limit cycle: {1e3 * size:.4g} mm of m.x" in said
    assert "µm" not in said
    assert f"{1e6 * size:.4g} µm" in str(dataset["limit_cycle_message"].values)
    assert "µm" not in str(shown_dataset(dataset)["limit_cycle_message"].values)
    text = IN_MM.replace("forced_response", "nonlinear_modes")
    dataset = Run({"": job(text, tmp_path, "mm")}, tmp_path).computed(CheckpointFolder(tmp_path / "k", {}), lambda *_: None)[""]
    table = presentation_of(dataset).tables(dataset)["nonlinear modes"]
    found = table["modal amplitude [mm t^0.5]"].to_numpy()
    np.testing.assert_allclose(found, table["m.x [mm]"] * 5e-4**0.5, rtol=1e-6)


def test_old_results_and_those_of_different_units_are_shown_in_si(results):
    """A file of an earlier version does not say its units: its numbers stay in SI, with their unit."""
    dataset = results["mm"][0]
    kept = {key: value for key, value in dataset.attrs.items() if key != "unit_system"}
    old = dataset.drop_attrs(deep=False).assign_attrs(kept)
    assert any(re.search(r"amplitude +[\d.]+ µm ", line) for line in presentation_of(old).sentences(old))
    assert system_of(dataset, old) is None
    xr.testing.assert_identical(shown_dataset(old), old)


def test_the_explorer_is_in_mm(tmp_path):
    pytest.importorskip("dash")
    from stickslip.show.explorer.solving import Solver, clicked_point, curve_figure, peak_words

    (tmp_path / "mm.toml").write_text(IN_MM.replace("force_levels = [2.0, 4.0]", "force_levels = [4.0]"))
    solver = Solver.of(tmp_path / "mm.toml")
    assert {slider.name: slider.unit for slider in solver.sliders} == {
        "force_level": "",
        "damping": "",
        "kt": "N/mm",
        "mu": "",
        "normal_load": "N",
    }
    answer = solver.answer({})
    dataset = answer.response.dataset
    assert peak_words(answer, "m.x")[1].endswith(" mm")
    figure = curve_figure(answer, None, "m.x", True, False)
    assert figure["layout"]["yaxis"]["title"]["text"].endswith("in mm")
    k = int(np.nanargmax(dataset["amplitude"].values[0, :, 0]))
    x, y = float(dataset["frequency"][0, k]), 1e3 * float(dataset["amplitude"][0, k, 0])
    assert clicked_point(answer, None, "m.x", x, y) == k
    assert replace(answer).response.dataset.attrs["unit_system"] == "mm N t s"


def test_warnings_and_failures_are_shown_in_the_units_of_the_study(results):
    """On the page, at a glance, on the console and in JSON, whatever reads them."""
    dataset = results["mm"][0].copy(deep=True)
    dataset["case_message"] = dataset["case_message"].astype(object)
    dataset["case_message"].values[:] = "The curve ended. The peak changes: 0.000221 m at 321 Hz."
    assert sum("0.221 mm at 321 Hz" in sentence for sentence in warnings_of(dataset)) == 2
    assert "0.000221 m at 321" not in page({"one": dataset})
    dataset["case_outcome"].values[:] = 2
    assert all("0.000221 m" not in sentence for sentence in failures_of(dataset))
    assert any("0.221 mm" in sentence for sentence in failures_of(dataset))
