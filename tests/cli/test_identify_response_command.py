"""`stickslip identify-response`: from measured curves to parameters in one command, and what it refuses."""

import re
import subprocess
import sys
import tomllib

import numpy as np
import pytest
from measurement import universal_writer as write
from typer.testing import CliRunner

import stickslip as ss
from stickslip import study
from stickslip.cli import app
from stickslip.show.report.identification import response_tables as tables
from stickslip.show.report.page import page
from stickslip.study.measured_curves import with_curves
from stickslip.support import console

FREQUENCIES = np.linspace(0.14, 0.24, 13)
KT, LIMIT, DAMPING = 0.5, 1.0, 0.02

MODEL = """
[study]
title = "One mass"
analysis = "forced_response"
[structure]
dofs = ["1.x"]
matrices = { M = [[1.0]], K = [[1.0]] , C = [[0.03]] }
[[contact]]
tangential = { "1.x" = 1.0 }
law = "macroslip"
kt = 0.4
mu = 2.0
normal_load = 1.0
[[force]]
direction = "1.x"
amplitude = 1.0
[sweep]
frequency = [0.145, 0.25]
harmonics = "auto"
outputs = ["1.x"]
"""


@pytest.fixture(scope="module")
def curves(tmp_path_factory):
    """Responses of one mass with a slider at three force levels, in files of two layouts."""
    folder, paths = tmp_path_factory.mktemp("curves"), []
    for force in (0.3, 1.0, 2.0):
        problem = ss.rigs.single_mass(kt=KT, limit=LIMIT, damping=DAMPING)
        data = ss.forced_response(problem, FREQUENCIES.tolist(), force).dataset
        X = data["response"].values[0, :, 0, 1] @ np.array([1.0, 1j])
        rows = [f"{f:.6g};{1e3 * abs(x):.8g};{force};{np.degrees(np.angle(x)):.6g}" for f, x in zip(FREQUENCIES, X, strict=True)]
        paths.append(folder / f"level_{force:g}.csv")
        paths[-1].write_text("Frequency [Hz];Displacement [mm];Force [N];Phase [deg]\n" + "\n".join(rows) + "\n")
    return paths


def command(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def values(output):
    """Parameters, and factors, by name."""
    return {name: float(value) for name, value in re.findall(r"^(\w+) [=×] ([\d.e+-]+)(?: = [^,]*)?, 95 %", output, re.M)}


def test_a_rig_and_curves_become_parameters_and_a_report(curves, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    free = ("--free", "kt=0.1:3", "--free", "limit=2:0.2:5", "--free", "damping")
    shown = command("identify-response", "single_mass", *curves, *free)
    assert shown.exit_code == 0, shown.output
    assert values(shown.output) == pytest.approx({"kt": KT, "limit": LIMIT, "damping": DAMPING}, rel=1e-3)
    folder = tmp_path / "results" / "single_mass"
    overview, _, rest = (folder / "report.html").read_text().partition('id="tables"')
    assert overview.index('id="table-0-parameters"') < overview.index('id="chart-0')
    assert "table-0-parameters" not in rest
    assert "kt = " not in overview
    warned = ss.open_results(folder / "results.nc").assign_attrs(notes="kt is not determined: its 95 % interval is 0.1 to 3.")
    overview = page({"one": warned})
    assert overview.index('<p class="warning">kt is not determined') < overview.index('id="chart-0')
    assert list(ss.open_results(folder / "results.nc")["test"].values) == ["level_0.3", "level_1", "level_2"]
    again = command("identify-response", "single_mass", *curves, "--quantity", "displacement", *free)
    assert again.exit_code == console.WRONG_INPUT
    assert "--overwrite" in again.output


def test_functions_of_a_universal_file_are_tests(curves, tmp_path, monkeypatch):
    """The same responses per force as functions of one file; a file of several responses lists them, without a traceback."""
    monkeypatch.chdir(tmp_path)
    tests = [ss.read_measured_response(path) for path in curves]
    sets = [
        write.function(
            np.asarray(test.frequency),
            test.per_force,
            response=(2, 3),
            ordinate=(8, "m"),
            denominator=(13, "N"),
            double=True,
            even=False,
        )
        for test in tests
    ]
    other = write.function(
        np.asarray(tests[0].frequency), tests[0].per_force, response=(1, 3), ordinate=(8, "m"), denominator=(13, "N")
    )
    (tmp_path / "levels.unv").write_bytes(b"".join([*sets, other]))
    free = ("--free", "kt=0.1:3", "--free", "limit=2:0.2:5", "--free", "damping", "--force", "0.3,1,2", "--by", "function")
    refused = command("identify-response", "single_mass", "levels.unv", *free)
    assert refused.exit_code == console.WRONG_INPUT
    assert "4 = 1:+Z / 1:+X" in refused.output.replace("\n", " ")
    assert "Traceback" not in refused.output
    shown = command("identify-response", "single_mass", "levels.unv", *free, "--column", "amplitude=2:Z")
    assert shown.exit_code == 0, shown.output
    assert values(shown.output) == pytest.approx({"kt": KT, "limit": LIMIT, "damping": DAMPING}, rel=1e-3)


@pytest.mark.slow
def test_the_contacts_of_a_study_are_scaled(curves, tmp_path):
    """Factors on what the study says; its band leaves out a point of each curve, which is said. Measured forces are in N, though
    force level 1 of the study is 4 N."""
    path = tmp_path / "mass.toml"
    path.write_text(MODEL.replace("amplitude = 1.0", "amplitude = 4.0"))
    free = ("--free", "kt=0.2:5", "--free", "mu", "--free", "damping=0.1:10")
    shown = command("identify-response", path, *curves, "--quantity", "displacement", *free, "--out", tmp_path / "out")
    assert shown.exit_code == 0, shown.output
    truth = {"kt": KT / 0.4, "mu": LIMIT / 2.0, "damping": DAMPING / 0.03}
    assert values(shown.output) == pytest.approx(truth, rel=1e-3)
    times = re.search(r"^kt × (\S+) = (\S+) N/m, 95 % interval (\S+) to (\S+) N/m \(× (\S+) to (\S+)\)$", shown.output, re.M)
    factor, kt, low, high, *ends = map(float, times.groups())
    assert (kt, low, high) == pytest.approx((0.4 * factor, 0.4 * ends[0], 0.4 * ends[1]), rel=1e-3)
    assert re.search(r"^mu × \S+ = \S+, 95 % interval \S+ to \S+ \(× \S+ to \S+\)$", shown.output, re.M)
    assert re.search(r"^damping × \S+, 95 % interval × \S+ to \S+$", shown.output, re.M)
    assert "Measured forces are the amplitude of the force in N, whatever its amplitude in the study (4 N)." in shown.output
    assert "3 of 39 points lie outside the band of [sweep] and are not used." in shown.output
    table = tables(ss.open_results(tmp_path / "out" / "results.nc"))["parameters"]
    assert table["parameter"].tolist() == ["kt ×", "mu ×", "damping ×"]
    assert table["in the problem"].tolist() == [f"{kt:.5g} N/m", f"{2.0 * table['value'][1]:.5g}", ""]


def test_bounds_of_a_factor_need_not_hold_one(curves, tmp_path):
    """kt of the study is a tenth of the true one: the fit starts midway between the bounds."""
    path = tmp_path / "mass.toml"
    path.write_text(MODEL.replace("kt = 0.4", "kt = 0.05").replace("C = [[0.03]]", f"C = [[{DAMPING}]]"))
    shown = command("identify-response", path, *curves, "--free", "kt=2:50", "--free", "mu=0.1:0.9", "--out", tmp_path / "out")
    assert shown.exit_code == 0, shown.output
    assert values(shown.output) == pytest.approx({"kt": KT / 0.05, "mu": LIMIT / 2.0}, rel=1e-3)
    for wrong, words in (("kt=5:2", "kt must be [low, high], the lower end first"), ("kt=-2:5", "must be above 0")):
        shown = command("identify-response", path, *curves, "--free", wrong, "--out", tmp_path / "wrong")
        assert shown.exit_code == console.WRONG_INPUT
        assert words in " ".join(shown.output.split())


@pytest.mark.slow
def test_frequency_response_functions(curves, tmp_path):
    """Complex accelerances, one with titles that say all and one with none; the force levels are given."""
    paths = []
    for curve, force in zip(curves, (0.3, 1.0, 2.0), strict=True):
        f, x, _, phase = np.loadtxt(curve, delimiter=";", skiprows=1).T
        H = -((2.0 * np.pi * f) ** 2) * 1e-3 * x / force * np.exp(1j * np.radians(phase)) / 9.80665
        paths.append(tmp_path / f"frf_{force:g}.txt")
        head = "f [Hz]\tRe(H) [g/N]\tIm(H) [g/N]\n" if force != 2.0 else ""
        paths[-1].write_text(
            head + "\n".join(f"{a:.10g}\t{b.real:.10g}\t{b.imag:.10g}" for a, b in zip(f, H, strict=True)) + "\n"
        )
    free = ("--free", "kt=0.1:3", "--free", "limit=2:0.2:5", "--free", "damping")
    shown = command("identify-response", "single_mass", *paths[:2], *free, "--force", "0.3,1", "--out", tmp_path / "titled")
    assert shown.exit_code == 0, shown.output
    assert values(shown.output) == pytest.approx({"kt": KT, "limit": LIMIT, "damping": DAMPING}, rel=1e-3)
    columns = [word for one in ("frequency=1", "real=2", "imaginary=3") for word in ("--column", one)]
    about = (*columns, "--unit", "real=g/N", "--force", "2", "--out", tmp_path / "named")
    shown = command("identify-response", "single_mass", paths[2], "--free", "kt=0.1:3", "--set", f"damping={DAMPING}", *about)
    assert shown.exit_code == 0, shown.output
    assert values(shown.output) == pytest.approx({"kt": KT}, rel=1e-3)
    shown = command("identify-response", "single_mass", *paths[:2], *free, "--force", "1,2,3", "--out", tmp_path / "wrong")
    assert shown.exit_code == console.WRONG_INPUT
    assert "force must be one, or one for each of 2 files" in " ".join(shown.output.split())


@pytest.mark.slow
def test_curves_of_one_file_are_split_by_a_column(curves, tmp_path):
    """The three curves in one file, with settings of each; numbers of --set may be whole."""
    rows = [f"{k};{line}" for k, path in enumerate(curves, start=1) for line in path.read_text().splitlines()[1:]]
    whole = tmp_path / "all.csv"
    whole.write_text("test;Frequency [Hz];Displacement [mm];Force [N];Phase [deg]\n" + "\n".join(rows) + "\n")
    known = ("identify-response", "single_mass", whole, "--free", "kt=0.1:3", "--free", "damping", "--out", tmp_path / "out")
    shown = command(*known)
    assert shown.exit_code == console.WRONG_INPUT
    assert "--by 'test'" in " ".join(shown.output.split())
    shown = command(*known, "--by", "test", "--setting", "limit=1,1,1", "--set", "mass=1")
    assert shown.exit_code == 0, shown.output
    assert values(shown.output) == pytest.approx({"kt": KT, "damping": DAMPING}, rel=1e-3)
    assert list(ss.open_results(tmp_path / "out" / "results.nc")["test"].values) == ["all test 1", "all test 2", "all test 3"]
    for options, words in (
        (("--setting", "limit=1,1"), "settings must be one for each of 3 curves"),
        (("--force", "1,2"), "must be given once"),
    ):
        shown = command(*known, "--by", "test", *options, "--overwrite")
        assert shown.exit_code == console.WRONG_INPUT
        assert words in " ".join(shown.output.split())


@pytest.mark.slow
def test_joints_are_left_out_one_by_one(curves, tmp_path):
    known = ("identify-response", "single_mass", *curves, "--free", "kt=0.1:3", "--free", "damping", "--free", "limit=2:0.2:5")
    shown = command(*known, "--joints", "A, A,B", "--leave-one-out", "--out", tmp_path / "out")
    assert shown.exit_code == 0, shown.output
    assert "each joint left out and predicted by the others: at most" in shown.output
    assert list(ss.open_results(tmp_path / "out" / "results.nc")["joint"].values) == ["A", "A", "B"]


@pytest.mark.slow
def test_force_levels_of_curves_of_one_file(curves, tmp_path):
    """Responses per force, whose levels the file does not have."""
    rows = []
    for k, (path, force) in enumerate(zip(curves, (0.3, 1.0, 2.0), strict=True)):
        table = np.loadtxt(path, delimiter=";", skiprows=1)
        rows += [f"{k},{f:.10g},{x / force:.10g},{phase:.10g}" for f, x, _, phase in table]
    (tmp_path / "all.csv").write_text("run,Frequency [Hz],Receptance [mm/N],Phase [deg]\n" + "\n".join(rows) + "\n")
    known = (
        "identify-response",
        "single_mass",
        tmp_path / "all.csv",
        "--by",
        "run",
        "--free",
        "kt=0.1:3",
        "--free",
        "limit=2:0.2:5",
    )
    shown = command(*known, "--set", f"damping={DAMPING}", "--force", "0.3,1,2", "--out", tmp_path / "out")
    assert shown.exit_code == 0, shown.output
    assert values(shown.output) == pytest.approx({"kt": KT, "limit": LIMIT}, rel=1e-3)
    shown = command(*known, "--force", "0.3,1", "--out", tmp_path / "wrong")
    assert shown.exit_code == console.WRONG_INPUT
    assert "force must be one for each of 3 curves" in " ".join(shown.output.split())


def test_what_only_the_analysis_of_the_study_uses_is_left_out(curves):
    """The study states the problem; force levels, of a forced response, have no effect here."""
    document = tomllib.loads(MODEL.replace("[sweep]", "[sweep]\nforce_levels = [0.5, 1.0]\npeak_tolerance = 1e-4"))
    sweep = with_curves(document, curves, ["kt"], {}, {})["sweep"]
    assert sweep == {"frequency": [0.145, 0.25], "outputs": ["1.x"]}


def test_a_factor_on_what_no_contact_has_is_refused(curves, tmp_path):
    path = tmp_path / "mass.toml"
    path.write_text(MODEL)
    shown = command("identify-response", path, *curves, "--free", "kt", "--free", "kn", "--out", tmp_path / "out")
    assert shown.exit_code == console.WRONG_INPUT
    words = "kn must be a parameter of a contact of the problem, but is 'Macroslip'. A contact has kn where"
    assert words in " ".join(shown.output.split())


def test_very_long_curves_are_thinned(tmp_path):
    """Each point is solved in every evaluation: 400 000 of them would take hours."""
    rows = "".join(f"{80 + 1e-4 * k:.6f},1,1\n" for k in range(20_001))
    (tmp_path / "swept.csv").write_text("frequency [Hz],displacement [m],force [N]\n" + rows)
    (tmp_path / "study.toml").write_text(
        '[study]\nanalysis = "response_identification"\n[structure]\nrig = "single_mass"\n[sweep]\nfrequency = [81.0, 90.0]\n'
        '[response_identification]\nfiles = ["swept.csv"]\nrig = { kt = [0.5, 0.1, 1.0] }\n'
    )
    plan = study.read(tmp_path / "study.toml").plan
    work = plan.works[""]
    assert np.size(work.tests[0].frequency) == 910
    assert "910 of 10001 points of swept are used, one in 11: most_points says other." in work.tests[0].notes
    assert "10000 of 20001 points lie outside the band of [sweep] and are not used." in plan.about["remarks"]


def test_a_band_without_points_is_refused(curves, tmp_path):
    path = tmp_path / "mass.toml"
    path.write_text(MODEL.replace("[0.145, 0.25]", "[145.0, 250.0]"))
    shown = command("identify-response", path, curves[0], "--free", "kt", "--out", tmp_path / "out")
    assert shown.exit_code == console.WRONG_INPUT
    assert "in the band of [sweep], 145 to 250 Hz, must be at least three" in " ".join(shown.output.split())


@pytest.mark.slow
def test_settings_of_each_curve_and_a_curve_named_twice(curves, tmp_path):
    free, settings = ("--free", "kt=0.1:3", "--free", "damping"), ("--setting", "limit=1,1,1,1", "--set", "mass=1")
    known = ("--quantity", "displacement", "--out", tmp_path / "out")
    shown = command("identify-response", "single_mass", *curves, curves[0], *free, *settings, *known)
    assert shown.exit_code == 0, shown.output
    assert values(shown.output)["kt"] == pytest.approx(KT, rel=1e-3)
    assert "count twice" in shown.output


@pytest.mark.parametrize(
    ("problem", "options", "words"),
    [
        ("single_mas", ("--free", "kt"), "PROBLEM must be a study file that exists, or a ready rig"),
        ("single_mass", (), "--free must name a parameter at least"),
        ("single_mass", ("--free", "ky=1:2"), "--free must name one of"),
        ("single_mass", ("--free", "kt=1"), "--free must be NAME, NAME=LOW:HIGH or NAME=START:LOW:HIGH"),
        ("single_mass", ("--free", "kt=2:1"), "kt must be [start, low, high]"),
        ("single_mass", ("--free", "preload=1:0.5:2"), "factors on the problem's own value"),
        ("single_mass", ("--free", "kt", "--set", "mass=heavy"), "--set must give numbers"),
        ("single_mass", ("--free", "kt", "--setting", "limit=1,2"), "must have 3 values, one for each curve"),
        ("single_mass", ("--free", "kt", "--setting", "kt=1,2,3"), "settings must not name what is free"),
        ("single_mass", ("--free", "kt", "--setting", "kz=1,2,3"), "settings must name some of"),
        ("single_mass", ("--free", "kt", "--free", "kt=1:2"), "--free must give each parameter once"),
        ("single_mass", ("--free", "kt", "--each-test", "kt"), "each_test must leave out one that all tests have in common"),
        ("single_mass", ("--free", "kt", "--unit", "phase=rad", "--unit", "phase=deg"), "--unit must give phase once"),
        ("single_mass", ("--free", "kt", "--error", "nan"), "error must be finite"),
        ("single_mass", ("--free", "kt", "--start-states", "worn"), "start_states"),
        ("single_mass", ("--free", "kt", "--quantity", "velocity"), "must name amplitude"),
        ("single_mass", ("--free", "kt", "--joints", "A,B"), "joints must be one for each of 3 curves"),
        ("single_mass", ("--free", "kt", "--joints", "A,,B"), "joint must be named for all tests or for none"),
    ],
)
def test_what_is_refused_leaves_nothing_behind(curves, tmp_path, problem, options, words):
    shown = command("identify-response", problem, *curves, *options, "--out", tmp_path / "out")
    assert shown.exit_code == console.WRONG_INPUT
    assert words in " ".join(shown.output.split())
    assert not (tmp_path / "out").exists()


# Ctrl-C at a moment that no processor's speed decides: as the first finished case is about to be kept, or once it is.
INTERRUPTED_AT_THE_FIRST_CASE = """
import os, runpy, signal, sys
from stickslip.runs.cases import CheckpointFolder

moment = sys.argv.pop(1)
save = CheckpointFolder.save


def interrupted(self, name, arrays):
    if moment == "kept":
        save(self, name, arrays)
    os.kill(os.getpid(), signal.SIGINT)


CheckpointFolder.save = interrupted
runpy.run_module("stickslip", run_name="__main__", alter_sys=True)
"""


def interrupted(moment, *arguments):
    """Messages of a command that gets Ctrl-C as its first case is `finished`, or `kept`."""
    call = [sys.executable, "-c", INTERRUPTED_AT_THE_FIRST_CASE, moment, *map(str, arguments)]
    process = subprocess.run(call, capture_output=True, text=True, check=False, timeout=300)
    assert process.returncode == console.INTERRUPTED, process.stdout + process.stderr
    assert "Traceback" not in process.stdout + process.stderr
    return process.stderr.strip()


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_finished(curves, tmp_path):
    """During the fit there is nothing to keep; afterwards the fit is kept, and the tests left out go on from it."""
    free = ("--free", "kt=0.1:3", "--free", "limit=0.2:5", "--free", "damping", "--leave-one-out")
    arguments = ("identify-response", "single_mass", *curves, *free)
    assert interrupted("finished", *arguments, "--out", tmp_path / "early").splitlines() == [
        "Nothing was kept yet: no part of the work was completed.",
        "Interrupted. All files written so far are complete.",
    ]
    folder = tmp_path / "late"
    errors = interrupted("kept", *arguments, "--out", folder)
    assert errors.startswith(f"Kept 1 completed curve in {folder / 'unfinished'}")
    assert errors.endswith("Interrupted. All files written so far are complete.")
    resumed = command(*arguments, "--out", folder, "--resume")
    assert resumed.exit_code == 0, resumed.output
    assert "Resuming from" in resumed.output
    assert "left out and predicted by the others" in resumed.output
    whole = command(*arguments, "--out", tmp_path / "whole")
    assert values(resumed.output) == values(whole.output)
