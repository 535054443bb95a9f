"""Velocities, accelerations and receptances of a result, against the linear single mass and against time."""

import csv

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import stickslip as ss
from stickslip.cli import app
from stickslip.cli.results import without_formulas
from stickslip.results.files import save


@pytest.fixture(scope="module")
def response():
    """A mass of 2 kg on a spring of 50 N/m whose slider never slips: X = F/(k + kt − m ω² + i c ω)."""
    mass = ss.rigs.single_mass(mass=2.0, damping=0.4, stiffness=50.0, kt=10.0, limit=1e6, force=1.0)
    return ss.forced_response(mass, [0.3, 0.8, 1.5], force=[1.0, 4.0], harmonics=3)


def receptance(frequency):
    omega = 2 * np.pi * frequency
    return 1.0 / (60.0 - 2.0 * omega**2 + 0.4j * omega)


@pytest.mark.parametrize(("name", "order"), [("displacement", 0), ("velocity", 1), ("acceleration", 2)])
def test_receptance_mobility_and_inertance(response, name, order):
    found = response.as_quantity(name, per_force=True)
    frequency = found["frequency"].values
    expected = receptance(frequency) * (2j * np.pi * frequency) ** order
    first = found["response"].isel(output=0, harmonic=1).values
    np.testing.assert_allclose(first[..., 0] + 1j * first[..., 1], expected, rtol=1e-9)
    np.testing.assert_allclose(found["amplitude"].isel(output=0), np.abs(expected), rtol=1e-9)
    np.testing.assert_allclose(found["rms"].isel(output=0), np.abs(expected) / np.sqrt(2), rtol=1e-9)
    assert found["amplitude"].attrs["units"] == ("m/N", "m/(s N)", "m/(s2 N)")[order]


@pytest.mark.parametrize(
    ("name", "of"),
    [
        ("receptance", "displacement"),
        ("compliance", "displacement"),
        ("mobility", "velocity"),
        ("inertance", "acceleration"),
        ("accelerance", "acceleration"),
    ],
)
def test_what_a_quantity_per_force_is_called_names_it(response, name, of):
    assert response.as_quantity(name).identical(response.as_quantity(of, per_force=True))
    assert ss.quantity_table(response.dataset, name).equals(ss.quantity_table(response.dataset, of, per_force=True))
    assert ss.peak_table(response.dataset, name).equals(ss.peak_table(response.dataset, of, per_force=True))
    labels = [
        response.plot(quantity=quantity, **options).axes[0].get_ylabel()
        for quantity, options in ((name, {}), (of, {"per_force": True}))
    ]
    assert labels[0] == labels[1]
    assert labels[0].startswith("amplitude per force")


def test_an_acceleration_is_the_second_derivative_in_time():
    """Of a motion with mean and harmonics, by its samples."""
    data = ss.forced_response(ss.rigs.three_mass_wedge(), [222.0]).dataset
    motion, other = data["response"], ss.as_quantity(data, "acceleration")["response"]
    omega, t = 2 * np.pi * 222.0, np.linspace(0, 1 / 222.0, 2001)
    x, a = (
        sum((v[h, 0] - 1j * -v[h, 1]) * np.exp(1j * h * omega * t) for h in range(6)).real
        for v in (part.isel(case=0, point=0, output=0).values for part in (motion, other))
    )
    np.testing.assert_allclose(a[1:-1], np.diff(x, 2) / (t[1] - t[0]) ** 2, atol=1e-4 * np.max(np.abs(a)))


def test_levels_are_newtons_where_the_force_is_one_newton(response):
    assert response.dataset["force_level"].attrs["units"] == "N"
    two = ss.forced_response(ss.rigs.three_mass_wedge(), [222.0]).dataset
    assert two["force_level"].attrs["units"] == "1"


def test_tables(response, tmp_path):
    table = ss.quantity_table(response.dataset, "velocity")
    assert len(table) == 6
    row = table.iloc[-1]
    assert row["amplitude [m/s]"] == pytest.approx(4.0 * abs(receptance(1.5)) * 2 * np.pi * 1.5, rel=1e-9)
    assert row["phase [deg]"] == pytest.approx(np.degrees(np.angle(1j * receptance(1.5))), rel=1e-9)
    with pytest.raises(
        ss.InputError, match=r"must be displacement, velocity, acceleration, or per force receptance, mobility, .* but is 'speed'"
    ):
        ss.quantity_table(response.dataset, "speed")


def test_a_table_of_points_has_their_errors_by_harmonics():
    """Of the quantity of the result, whatever it is called."""
    data = ss.forced_response(ss.rigs.three_mass_wedge(), ss.hertz(215.0, 230.0), 40.0, harmonics=1).dataset
    errors = data["point_truncation_error"].values
    assert np.nanmax(errors) > 1e-4
    for name in (None, "displacement", "receptance"):
        table = ss.quantity_table(data, name)
        at = 0, table["point"], [data["output"].values.tolist().index(each) for each in table["output"]]
        np.testing.assert_array_equal(table["point_truncation_error"], errors[at])
    assert "point_truncation_error" not in ss.quantity_table(data, "velocity")


@pytest.fixture(scope="module")
def swept():
    return ss.forced_response(ss.rigs.single_mass(), ss.radians_per_second(0.5, 2.0), force=[0.5], harmonics=1)


def test_export(swept, tmp_path):
    for name in ("a", "b"):
        swept.save(tmp_path / "results" / name / "results.nc")
    arguments = [
        "export",
        str(tmp_path / "results"),
        "--out",
        str(tmp_path / "t.csv"),
        "--quantity",
        "acceleration",
        "--per-force",
    ]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    curves, peaks = pd.read_csv(tmp_path / "t.csv"), pd.read_csv(tmp_path / "t_peaks.csv")
    assert set(curves["result"]) == {"a", "b"}
    peak = swept.peaks().iloc[0]
    expected = peak["amplitude"] * (2 * np.pi * peak["frequency"]) ** 2 / 0.5
    np.testing.assert_allclose(peaks["inertance at the displacement peak [m/(s2 N)]"], expected, rtol=1e-12)
    assert 'for its own peaks run the study with quantity = "acceleration" in [sweep].' in " ".join(result.output.split())
    (tmp_path / "t_peaks.csv").write_text("mine")
    refused = CliRunner().invoke(app, arguments)
    assert refused.exit_code == 2
    assert "--out must name files that do not exist" in refused.output
    assert (tmp_path / "t_peaks.csv").read_text() == "mine"
    assert CliRunner().invoke(app, [*arguments, "--overwrite"]).exit_code == 0
    assert len(pd.read_csv(tmp_path / "t_peaks.csv")) == len(peaks)
    refused = CliRunner().invoke(app, ["export", str(tmp_path / "results"), "--out", str(tmp_path / "t.txt")])
    assert refused.exit_code == 2
    assert "--out must end in .csv" in refused.output


@pytest.mark.parametrize("begin", ["=", "\t"])
def test_a_name_in_an_exported_table_is_no_formula_of_a_spreadsheet(swept, tmp_path, begin):
    """Neither that of an output nor that of a result, whose folder has it."""
    name = f'{begin}HYPERLINK("http://evil.example")'
    folder = f"{begin}cmd" if begin != "\t" else "b"
    for place in ("a", folder):
        save(swept.dataset.assign_coords(output=[name]), tmp_path / "results" / place / "results.nc")
    result = CliRunner().invoke(app, ["export", str(tmp_path / "results"), "--out", str(tmp_path / "t.csv")])
    assert result.exit_code == 0, result.output
    for file in ("t.csv", "t_peaks.csv"):
        with (tmp_path / file).open(newline="", encoding="utf-8") as table:
            rows = list(csv.DictReader(table))
        assert {row["output"] for row in rows} == {f"'{name}"}
        assert {row["result"] for row in rows} == {"a", folder if folder == "b" else f"'{folder}"}
        assert all(row[key].lstrip("-")[0].isdigit() for row in rows for key in row if "[" in key)


def test_numbers_and_harmless_names_stay_as_they_are():
    table = pd.DataFrame({"a [Hz]": [-3.0, np.nan], "b": ["-3.0", "+1e-5"], "c": ["1.x", "a=b"], "d": [-1, 2], "e": [None, True]})
    pd.testing.assert_frame_equal(without_formulas(table), table)
    assert list(without_formulas(table.set_axis([-1, "-2", "c", "d", "e"], axis=1)).columns) == [-1, "-2", "c", "d", "e"]


@pytest.mark.parametrize("begin", [*"=+-@\t\r\n＝＋－＠"])
def test_formulas_of_a_spreadsheet(begin):
    assert without_formulas(pd.DataFrame({"a": [f"{begin}b"]})).iloc[0, 0] == f"'{begin}b"
    formulas = pd.DataFrame({"=a": ["-3.0+cmd", "-x", "+1e-5\n"]})
    assert without_formulas(formulas).to_dict("list") == {"'=a": ["'-3.0+cmd", "'-x", "'+1e-5\n"]}
    assert list(without_formulas(formulas[:0]).columns) == ["'=a"]


@pytest.mark.parametrize("end", [*";\t\r\n"])
def test_a_formula_behind_what_ends_a_cell_elsewhere(end):
    """Where commas are decimal, spreadsheets take semicolons as the ends of cells, and know no quotes in the midst of one."""
    table = without_formulas(pd.DataFrame({"a": [f"1.x{end}=cmd|' /C calc'!A0{end}2"]}))
    assert table.iloc[0, 0] == f"1.x{end}'=cmd|' /C calc'!A0{end}2"


def test_exported_peaks_carry_the_errors_that_the_console_prints(response):
    """At the highest peak of each level and output, as the result holds them: the others have none."""
    dataset = ss.forced_response(response.problem, ss.hertz(0.5, 1.2), force=[1.0, 4.0], harmonics=3).dataset
    errors = {"truncation_error": [[0.01], [0.02]], "modal_error": [[-0.03], [np.nan]], "patch_error": [[0.05], [0.06]]}
    dataset = dataset.assign({name: (("case", "output"), np.array(values)) for name, values in errors.items()})
    table = ss.peak_table(dataset)
    assert table["peak"].tolist() == [0, 0]
    for name, values in errors.items():
        np.testing.assert_array_equal(table[name], np.ravel(values))
    assert {"sampling_error", "work_error"} <= set(table)
    assert not {"modal_error", "patch_error"} & set(ss.peak_table(dataset.drop_vars(["modal_error", "patch_error"])))
