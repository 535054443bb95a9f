"""`stickslip predict`: from the results of an identification to what was not measured, by commands alone; and what it refuses."""

import numpy as np
import pytest
from typer.testing import CliRunner

import stickslip as ss
from stickslip.cli import app
from stickslip.cli.identification import of_decay
from stickslip.study.reading import units_of
from stickslip.support import console

FREQUENCIES = np.linspace(0.14, 0.24, 13)
FREE = ("--free", "kt=0.6:0.1:3", "--free", "limit=0.8:0.2:5", "--free", "damping=0.03:0.002:0.2")


STUDY = """
[study]
title = "One mass"
analysis = "response_identification"
[structure]
rig = "single_mass"
[sweep]
harmonics = 3
samples = 128
[response_identification]
tries = 0
"""


def command(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def write_universal(path, forces):
    """Receptances of one mass on a slider at several forces as pyuff writes them, one function each."""
    pyuff = pytest.importorskip("pyuff")
    problem, rng = ss.rigs.single_mass(kt=0.5, limit=1.0, damping=0.02), np.random.default_rng(0)
    data = ss.forced_response(problem, FREQUENCIES.tolist(), list(forces), 3, 128).dataset
    file = pyuff.UFF(str(path))
    for k, force in enumerate(forces):
        H = data["response"].values[k, :, 0, 1] @ np.array([1.0, 1j]) / force
        H = H * (1.0 + 0.002 * (rng.normal(size=H.size) + 1j * rng.normal(size=H.size)))
        one = pyuff.prepare_58(
            binary=0,
            func_type=4,
            rsp_node=2,
            rsp_dir=3,
            ref_node=2,
            ref_dir=3,
            data=H,
            x=FREQUENCIES,
            id1=f"{force} N",
            rsp_ent_name="NONE",
            ref_ent_name="NONE",
            abscissa_spacing=0,
            abscissa_spec_data_type=18,
            abscissa_axis_units_lab="Hz",
            ordinate_spec_data_type=8,
            ordinate_axis_units_lab="m",
            orddenom_spec_data_type=13,
            orddenom_axis_units_lab="N",
            ver_num=0,
        )
        file.write_sets(one, mode="add")
    return path


@pytest.fixture(scope="module")
def identified(tmp_path_factory):
    """The folder of an identification by a universal file of three functions, and of another measured at 0.6 N."""
    folder = tmp_path_factory.mktemp("test")
    levels, other = write_universal(folder / "levels.uff", (0.3, 1.0, 2.0)), write_universal(folder / "other.uff", (0.6,))
    (folder / "mass.toml").write_text(STUDY)
    how = ("--by", "function", "--force", "0.3,1,2", "--error", "0.002")
    shown = command("identify-response", folder / "mass.toml", levels, *how, *FREE, "--out", folder / "found")
    assert shown.exit_code == 0, shown.output
    return folder, other


@pytest.mark.slow
def test_a_universal_file_becomes_a_prediction_by_commands_alone(identified):
    """Levels are those of the compared file; peaks of the truth lie inside, and so do the measured points."""
    folder, other = identified
    shown = command("predict", folder / "found", "--compare", other, "--compare-force", "0.6", "--draws", "20", "--workers", "1")
    assert shown.exit_code == 0, shown.output
    lines = shown.output.splitlines()
    assert "Free: kt, limit, damping. Measured forces from 0.3 to 2 N: 0.6 N interpolated." in lines
    data = ss.open_results(folder / "found_prediction")
    assert (folder / "found_prediction" / "report.html").is_file()
    truth = ss.forced_response(ss.rigs.single_mass(kt=0.5, limit=1.0, damping=0.02), ss.hertz(0.14, 0.24), 0.6, 3, 128).peaks()
    assert float(data["peak_amplitude_low"][0]) <= truth["amplitude"][0] <= float(data["peak_amplitude_high"][0])
    assert float(data["peak_frequency"][0]) == pytest.approx(truth["frequency"][0], rel=1e-3)
    assert float(data["inside"][0]) >= 0.8
    assert any("predicted against measured frequency" in line for line in lines)
    again = command("predict", folder / "found" / "results.nc", "--force", "0.6", "--workers", "1")
    assert again.exit_code == console.WRONG_INPUT
    assert "--overwrite" in again.output


@pytest.mark.slow
def test_held_amplitudes_and_a_band(identified, tmp_path):
    folder, _ = identified
    options = (
        "--amplitude",
        "3",
        "--amplitude",
        "50",
        "--band",
        "0.15:0.2",
        "--draws",
        "20",
        "--workers",
        "1",
        "--out",
        tmp_path / "held",
    )
    shown = command("predict", folder / "found", *options)
    assert shown.exit_code == 0, shown.output
    assert "3 m interpolated, 50 m extrapolated" in shown.output
    data = ss.open_results(tmp_path / "held")
    assert data["frequency"].values[0, 0] == pytest.approx(0.15)
    assert list(data["level"].values) == [3.0, 50.0]


@pytest.fixture(scope="module")
def ring_down(identified):
    """A measured decay of the same mass, released at 2 m, as a signal and as results of `stickslip decay`."""
    folder, _ = identified
    problem = ss.rigs.single_mass(kt=0.5, limit=1.0, damping=0.02)
    decay = ss.free_decay(problem, 60.0, displacement={"1.x": 2.0}, steps=6000).dataset
    rows = zip(decay["time"].values[::5], decay["displacement"].values[0, ::5], strict=True)
    signal = folder / "ring_down.csv"
    signal.write_text("\n".join(["time [s],displacement [m]", *(f"{t:.6g},{u:.8g}" for t, u in rows)]))
    shown = command("decay", signal, "--out", folder / "measured")
    assert shown.exit_code == 0, shown.output
    return signal, folder / "measured"


@pytest.mark.slow
def test_a_decay_is_predicted_beside_a_measured_one(identified, ring_down, tmp_path):
    """From the signal and from its evaluation alike; while it sticks both are viscous, at a damping ratio of 0.82 %."""
    folder, _ = identified
    texts = []
    for k, given in enumerate(ring_down):
        options = ("--draws", "20", "--workers", "1", "--out", tmp_path / str(k))
        shown = command("predict", folder / "found", "--decay", given, *options)
        assert shown.exit_code == 0, shown.output
        texts.append([line for line in shown.output.splitlines() if "predicted against measured" in line])
    assert texts[0] == texts[1]
    assert len(texts[0]) == 1
    data = ss.open_results(tmp_path / "0")
    assert float(data["damping_ratio"][0]) == pytest.approx(0.02 / (2.0 * np.sqrt(1.5)), rel=0.02)
    assert float(data["frequency"][0]) == pytest.approx(np.sqrt(1.5) / (2.0 * np.pi), rel=1e-3)
    assert float(data["inside_damping_ratio"][0]) > 0.7
    assert (tmp_path / "0" / "report.html").is_file()


def test_amplitudes_of_a_decay_are_in_metres_whatever_the_study_says():
    assert of_decay(["1e-4:2e-3"], units_of("mm-t-s"))["amplitude"] == pytest.approx([0.1, 2.0])
    assert of_decay(["1e-4:2e-3"], units_of({}))["amplitude"] == [1e-4, 2e-3]


@pytest.mark.slow
def test_wrong_decays_are_refused(identified, ring_down):
    folder, other = identified
    signal, _ = ring_down
    wrong = {
        ("--decay", "1e-5"): "--decay must be a file that exists",
        ("--decay", "1:2", "--decay", "2:3"): "--decay must give one range of amplitudes at most",
        ("--decay", "1:2:3"): "--decay must be LOW:HIGH in m, or a file",
        ("--decay", "2:1"): "amplitude must be [smallest, largest], the smaller first, but is [2.0, 1.0]",
        ("--decay", "1:x"): "--decay must give numbers",
        ("--decay", "1:2", "--mode", "2"): "mode must be at most 1, but is 2",
        ("--force", "1", "--mode", "1"): "--mode 1 needs --decay",
        ("--decay", "1:2", "--force", "3"): "--decay and --force must not be given together",
        ("--decay", "1:2", "--column", "real=3"): "--decay and --column must not be given together",
        ("--decay", "1:2", "--compare", str(other)): "--decay and --compare must not be given together",
        ("--decay", "100:200", "--decay", str(signal)): "The amplitudes of ring_down must reach into those that are predicted",
        ("--decay", str(folder / "found")): "must be results of `stickslip decay`, or recorded signals",
        ("--decay", str(other)): "",
    }
    for options, message in wrong.items():
        shown = command("predict", folder / "found", *options, "--out", folder / "none")
        assert shown.exit_code == console.WRONG_INPUT, (options, shown.output)
        assert message in " ".join(shown.output.split()), (options, shown.output)
        assert "Traceback" not in shown.output
        assert not (folder / "none").exists()


@pytest.mark.slow
def test_what_is_refused_comes_with_its_remedy(identified, tmp_path):
    folder, other = identified
    wrong = {
        ("--force", "1", "--setting", "load"): "--setting must be NAME=VALUE, such as pull=50",
        ("--force", "1", "--setting", "kt=3"): "settings must not name what is free, but is 'kt'",
        ("--force", "x"): "--force must give numbers",
        ("--force", "1", "--setting", "pull=3"): "settings must name some of",
        ("--force", "1", "--band", "0.1"): "--band must be LOW:HIGH",
        ("--force", "1", "--compare", tmp_path / "none.uff"): "none.uff",
        (
            "--force",
            "1",
            "--compare",
            other,
            "--compare-force",
            "0.6",
        ): "must be one that is predicted, 1, but is 0.6. Add 0.6 to",
    }
    for options, message in wrong.items():
        shown = command("predict", folder / "found", *options, "--out", tmp_path / "wrong", "--workers", "1")
        assert shown.exit_code == console.WRONG_INPUT, (options, shown.output)
        assert message in " ".join(shown.output.split()), (options, shown.output)
        assert "Traceback" not in shown.output


def test_results_without_a_study_are_refused(identified, tmp_path):
    """An identification in Python knows its problem as a function alone; other results hold no identification."""
    folder, _ = identified
    found = ss.ResponseIdentification(ss.open_results(folder / "found"), ss.rigs.single_mass, ())
    found.dataset.attrs["study"] = ""
    found.save(tmp_path / "python.nc")
    shown = command("predict", tmp_path / "python.nc", "--force", "1")
    assert shown.exit_code == console.WRONG_INPUT
    assert "found.predict(force)" in " ".join(shown.output.split())
    response = ss.forced_response(ss.rigs.single_mass(), [0.1], harmonics=1, samples=8)
    response.save(tmp_path / "curve.nc")
    shown = command("predict", tmp_path / "curve.nc", "--force", "1")
    assert shown.exit_code == console.WRONG_INPUT
    assert "identify-response" in shown.output


def test_levels_are_of_one_kind(identified, tmp_path):
    folder, _ = identified
    wrong = {
        ("--draws", "20"): "--force must be given, or --amplitude for held amplitudes, --compare or --decay",
        ("--force", "1", "--amplitude", "2"): "--force and --amplitude must not be given together, but are: 1 and 2.",
    }
    for options, message in wrong.items():
        shown = command("predict", folder / "found", *options, "--out", tmp_path / "wrong")
        assert shown.exit_code == console.WRONG_INPUT, (options, shown.output)
        assert message in " ".join(shown.output.split()), (options, shown.output)


def predicting(folder, table, changed=lambda text: text):
    """A study that predicts from the identification of a folder, its text changed."""
    text = changed(ss.open_results(folder / "found").attrs["study"].replace("response_identification", "response_prediction", 1))
    study = folder / "predict.toml"
    study.write_text(f'{text}\n[response_prediction]\nidentification = "found"\n{table}\n')
    return study


def test_the_identification_that_is_read_is_not_replaced(identified):
    """By the command and by a study, whatever else is said."""
    folder, _ = identified
    before = (folder / "found" / "results.nc").read_bytes()
    study = predicting(folder, "force = [0.6]\ndraws = 20")
    for start in (("predict", folder / "found", "--force", "0.6"), ("run", study)):
        for option in ("--overwrite", "--resume"):
            shown = command(*start, "--out", folder / "found", option)
            assert shown.exit_code == console.WRONG_INPUT, shown.output
            assert "must not be the folder of the results that are read" in " ".join(shown.output.split())
    assert (folder / "found" / "results.nc").read_bytes() == before


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        (
            "[sweep]",
            "[structure.parameters]\nmass = 2.0\n[sweep]",
            "structure.parameters.mass is 2.0 here and not given in the identification",
        ),
        ("harmonics = 3", "harmonics = 5", "sweep.harmonics is 5 here and 3 in the identification"),
        ("limit = [", "stiffness = [", "must have the identified parameters free, kt, limit, damping, but is"),
        ("[sweep]", "[structure.parameters]\nkt = 2.0\n[sweep]", ""),  # it is free
    ],
)
def test_an_identification_of_another_problem_is_refused(identified, before, after, message):
    folder, _ = identified
    study = predicting(folder, "force = [0.6]", lambda text: text.replace(before, after))
    shown = command("check", study)
    assert shown.exit_code == (console.WRONG_INPUT if message else 0), shown.output
    assert message in " ".join(shown.output.split())


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ('force = [3.0]\ncompare = ["none.csv"]', "none.csv"),
        ('force = [3.0]\ncompare = ["predict_10_N.csv"]', "must be one that is predicted, 3, but is 10.0. Add 10 to these"),
        ('force = [0.01]\ncompare = ["predict_10_N.csv"]', "Is the unit of its force right?"),
        ('compare = ["khz.csv"]', "must be at least three, but is 0. Measured are 0.31"),
        ('compare = ["displacement.csv"]', "The quantity of displacement must be acceleration"),
        ("force = [3.0, 3.0]", "force must be unique"),
        ("force = [3.0]\namplitude = [2.0]", "force and amplitude must not be given together, but force = [3.0] and"),
        ("draws = 20", "force must be given, or amplitude, or files to compare with, but is []"),
    ],
)
def test_check_finds_what_is_wrong_with_the_levels_and_the_compared_curves(tmp_path, table, message):
    """Before the identification, which is the most of the work."""
    study = tmp_path / "predict.toml"
    assert command("new", "response_prediction", study).exit_code == 0
    measured = (tmp_path / "predict_10_N.csv").read_text().splitlines()
    first, *rows = (line.split(",") for line in measured if not line.startswith("#"))
    in_khz = [",".join([str(float(row[0]) / 1e3), *row[1:]]) for row in rows]
    (tmp_path / "khz.csv").write_text("\n".join([",".join(first), *in_khz]))
    other = ",".join(first).replace("acceleration [m/s2]", "displacement [m]")
    (tmp_path / "displacement.csv").write_text("\n".join([other, *map(",".join, rows)]))
    start, _, _ = study.read_text().partition("[response_prediction]")
    study.write_text(f"{start}[response_prediction]\n{table}\n")
    shown = command("check", study)
    assert shown.exit_code == console.WRONG_INPUT, shown.output
    assert message in " ".join(shown.output.split())
