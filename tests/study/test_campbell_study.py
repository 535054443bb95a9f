"""Campbell diagrams and run-ups of study files: what goes with the speed, margins, whirl, disks, resuming, and faults."""

import re

import numpy as np
import pytest
from each import each
from study.test_speed_sweep_study import STUDY as SWEEP
from typer.testing import CliRunner

import stickslip as ss
from stickslip.cli import app
from stickslip.results.files import open_results
from stickslip.results.schema import check_results
from stickslip.show.report.markup import presentation_named
from stickslip.study import job
from stickslip.study.templates import write_new
from stickslip.support.checks import InputError

OMEGA = 600.0 * 2.0 * np.pi / 60.0
STUDY = SWEEP.replace("speed_sweep", "campbell").replace("[300.0, 900.0]", "[0.0, 900.0]") + "operating_speed = 300.0\n"
RISE = 3000.0 / OMEGA**2
"""K₁ of the first row, N s²/m."""


def computed(text, folder):
    plan = job(text, folder, "study").plan
    return plan.dataset({"": [plan.works[""].solve(k, lambda share: None) for k in range(len(plan.works[""].names))]})


def test_crossings_and_margins_are_those_of_the_closed_form(tmp_path):
    """(EO² − K₁) Ω² = K₀ of one mass, with the spring of the contact where it sticks."""
    found = computed(STUDY, tmp_path)
    check_results(found.assign_attrs(title="x", analysis="campbell", stickslip_version="", file_format="", study=""))
    for state, spring in (("free", 0.0), ("stuck", 3000.0)):
        for order in (2, 4):
            one = found.sel(state=state, mode=1, engine_order=order)
            met = np.sqrt((10000.0 + spring) / (order**2 - RISE)) * 60.0 / (2.0 * np.pi)
            there = np.sqrt(10000.0 + spring + RISE * (OMEGA / 2.0) ** 2) / (2.0 * np.pi)
            assert float(one["crossing_speed"]) == pytest.approx(met, rel=1e-8)
            assert float(one["speed_margin"]) == pytest.approx(met / 300.0 - 1.0, rel=1e-7)
            assert float(one["operating_frequency"]) == pytest.approx(there, rel=1e-9)
            assert float(one["margin"]) == pytest.approx(there / (order * 5.0) - 1.0, rel=1e-9)


def test_the_report_has_margins_as_rows_and_says_what_has_no_error(tmp_path):
    found, shown = computed(STUDY, tmp_path), presentation_named("campbell")
    lines = list(shown.sentences(found))
    margin = np.sqrt(13000.0 + RISE * (OMEGA / 2.0) ** 2) / (2.0 * np.pi) / 20.0 - 1.0
    assert lines[0].startswith(
        "smallest margin at 300 rev/min: mode 1 (stuck contacts) lies at 18.66 Hz, 6.7 % below engine order 4"
    )
    rows = shown.tables(found)["nearest crossings"]
    first = rows.iloc[0]
    assert [first[name] for name in ("engine order", "mode", "contacts")] == [4, 1, "stuck contacts"]
    assert first["frequency to the engine order [%]"] == pytest.approx(100.0 * margin, rel=1e-9)
    assert first["speed to the operating one [%]"] == pytest.approx(100.0 * float(found["speed_margin"][1, 0, 1]), rel=1e-9)
    assert any("exact for the matrices" in line for line in lines)
    assert not any("warning" in line for line in lines)
    assert not shown.failures(found)


def test_the_resonance_with_friction_has_the_pull_of_each_speed(tmp_path):
    """It lies between both linear modes, and nearer to the stuck one the faster the rotor presses the contact."""
    text = STUDY.replace("[0.0, 900.0]", "[300.0, 900.0]") + "force_level = 6.0\npoints = 3\nmode = 1\n"
    found = computed(text, tmp_path)
    free, stuck, resonance = (
        found["frequency"].sel(state=state, mode=1, engine_order=4).values for state in found["state"].values
    )
    share = (resonance - free) / (stuck - free)
    assert np.all(np.diff(share) > 0.0)
    assert -0.01 < share[0] < share[-1] < 1.01
    at = job(text, tmp_path, "study").plan.works[""].models(600.0)
    swept = ss.forced_response(at, ss.hertz(16.0, 22.0), 6.0, harmonics=1, samples=64).peaks().iloc[0]
    assert resonance[1] == pytest.approx(swept["frequency"], rel=1e-4)
    assert float(found["amplitude"].sel(mode=1, engine_order=4, speed=600.0)) == pytest.approx(swept["amplitude"], rel=1e-4)
    assert "harmonics = 1 and samples = 64" in " ".join(presentation_named("campbell").sentences(found))


@pytest.mark.slow
def test_a_sweep_peaks_beyond_the_crossing_where_the_pull_grows_through_a_broad_resonance(tmp_path):
    """The template: 340.8 Hz at constant speed, which a forced response has too, and 347.8 Hz along engine order 3."""
    write_new("campbell", tmp_path / "blade.toml")
    text = re.sub("engine_orders = .*|mode = .*|points = .*", "", (tmp_path / "blade.toml").read_text())
    text = re.sub("speed = .3000.*", "speed = [6000.0, 7500.0]", text)
    own = "engine_orders = [3]\nmode = 1\npoints = 2\n"
    met = computed(text + own, tmp_path).sel(state="nonlinear", mode=1, engine_order=3)
    assert float(met["crossing_frequency"]) == pytest.approx(340.8, abs=0.06)
    problem = job(text + own, tmp_path, "blade").plan.works[""].models(float(met["crossing_speed"]))
    still = ss.forced_response(problem, ss.hertz(320.0, 370.0), 6.0, harmonics=3).peaks().iloc[0]
    assert still["frequency"] == pytest.approx(float(met["crossing_frequency"]), rel=1e-3)
    swept = re.sub("operating_speed.*|force_level = .*", "", text).replace("campbell", "speed_sweep")
    swept = swept.replace("[sweep]", "[sweep]\nforce_levels = [6.0]") + "engine_orders = [3]\n"
    assert float(computed(swept, tmp_path)["peak_frequency"][0, 0, 0, 0]) == pytest.approx(347.8, abs=0.06)


def test_one_stiffness_for_all_speeds_is_warned_of_and_needs_no_reference(tmp_path):
    text = re.sub("reference_speed.*\n|stiffness_at_rest.*\n", "", STUDY)
    found = computed(text, tmp_path)
    assert np.ptp(found["frequency"].sel(state="free", mode=1).values) == 0.0
    assert any("the same at all speeds" in line for line in presentation_named("campbell").sentences(found))
    far = computed(text.replace("[0.0, 900.0]", "[0.0, 15.0]").replace("operating_speed = 300.0", ""), tmp_path)
    first = presentation_named("campbell").sentences(far)[0]
    assert (
        first
        == "no engine order crosses a mode from 0 to 15 rev/min: they excite at 0 to 1 Hz, and the lowest mode is at 18.15 Hz"
    )


@each(
    ("before", "after", "words"),
    [
        ("speed = [0.0, 900.0]", "speed = [900.0, 0.0]", r"\[campbell\]: speed must be \[lowest, highest\]"),
        ("speed = [0.0, 900.0]", "speed = [900.0, 900.0]", r"\[lowest, highest\]"),
        ("speed = [0.0, 900.0]", "speed = [900.0]", "speed"),
        ("speed = [0.0, 900.0]", "speed = [-1.0, 900.0]", "speed"),
        ("[2, 4]", "[2, 2]", "unique"),
        ("[2, 4]", "[-2]", "engine_orders"),
        ("[2, 4]", "[]", "engine_orders"),
        ("operating_speed = 300.0", "operating_speed = 0.0", "operating_speed"),
        ("operating_speed = 300.0", "mode = 9", "mode must be at most 2"),
        ("operating_speed = 300.0", "points = 1", "points"),
        ("reference_speed = 600.0", "", "reference_speed must be given"),
        ("harmonics = 1", 'harmonics = "auto"', "harmonics must be a number"),
        ("harmonics = 1", "harmonics = 1\nforce_levels = [2.0]", "force_levels must be left out"),
        ("[[10000.0, 0.0], [0.0, 2000.0]]", "[[-10000.0, 0.0], [0.0, 2000.0]]", "positive definite"),
    ],
)
def test_faults_are_said(tmp_path, before, after, words):
    assert before in STUDY
    place = STUDY.rindex(before)
    with pytest.raises(InputError, match=words):
        job(STUDY[:place] + after + STUDY[place + len(before) :], tmp_path, "study")


DISK = """
[study]
analysis = "campbell"
[structure]
rig = "lumped_blisk"
parameters = { sectors = 6 }
[sweep]
[campbell]
speed = [0.0, 6000.0]
engine_orders = [1, 2, 5, 7]
operating_speed = 3000.0
"""


def test_a_disk_has_its_interference_diagram_at_the_operating_speed(tmp_path):
    found = computed(DISK, tmp_path)
    assert found["excited_diameter"].values.tolist() == [1, 2, 1, 1]
    assert found["wave"].values.tolist() == ["backward", "backward", "forward", "backward"]
    curves = found["frequency"].sel(state="stuck", mode=1).values[:, 0]
    assert curves[0] == curves[2] == curves[3] != curves[1]
    disk = ss.rigs.lumped_blisk(sectors=6)
    exact = ss.interference_diagram(disk, 3000.0, [1, 2, 5, 7]).dataset
    np.testing.assert_array_equal(found["disk_margin"].values, exact["disk_margin"].values)
    shown = presentation_named("campbell")
    table = shown.tables(found)["interference diagram at the operating speed"]
    assert len(table) == 8
    np.testing.assert_array_equal(table["nearest mode"], found["nearest_mode"].values.T.ravel())
    assert set(shown.figures(found)) == {"campbell", "interference"}
    assert shown.figures(found)["interference"](found).panels


RUN = STUDY[: STUDY.index("[campbell]")].replace('"campbell"', '"run_up"').replace("harmonics = 1\nsamples = 64\n", "")
RUN += """force_levels = [4.0, 8.0]
[run_up]
speed = [400.0, 700.0]
duration = 3.0
engine_orders = [2]
reference_speed = 600.0
stiffness_at_rest = [[10000.0, 0.0], [0.0, 2000.0]]
"""


def test_a_run_up_is_that_of_python_and_resumes(tmp_path):
    (tmp_path / "run.toml").write_text(RUN)
    command = ["run", str(tmp_path / "run.toml"), "--out", str(tmp_path / "out"), "--workers", "1"]
    said = CliRunner().invoke(app, command)
    assert said.exit_code == 0, said.output
    found = open_results(tmp_path / "out" / "results.nc")
    problem = job(RUN, tmp_path, "run").plan.works[""].problem
    python = ss.run_up(problem, (400.0, 700.0), 3.0, 2, 8.0).dataset.isel(case=0)
    np.testing.assert_array_equal(found["amplitude"].values[1], python["amplitude"].values)
    shown = presentation_named("run_up")
    table, top = shown.tables(found)["largest amplitudes"], int(np.argmax(python["amplitude"].values[:, 0]))
    assert table["speed [rev/min]"][1] == float(python["speed"][top])
    assert len(shown.exported(found)["every cycle"]) == 2 * python.sizes["cycle"]
    assert "engine order 2, 8 N: 1.x at most" in said.output
    assert len(shown.figures(found)["run_up"](found).panels[0].layers) == 2
    assert "are complete" in CliRunner().invoke(app, [*command, "--resume"]).output


@each(
    ("before", "after", "words"),
    [
        ("speed = [400.0, 700.0]", "speed = [400.0, 400.0]", "two different ends"),
        ("speed = [400.0, 700.0]", "speed = [0.0, 700.0]", "above 0"),
        ("duration = 3.0", "duration = 0.1", "4 cycles"),
        ("duration = 3.0", "duration = 0.0", "duration"),
        ("duration = 3.0", "duration = 3.0\nsteps_per_period = 3", "steps_per_period"),
        ("reference_speed = 600.0", "", "reference_speed must be given"),
    ],
)
def test_faults_of_a_run_up_are_said(tmp_path, before, after, words):
    with pytest.raises(InputError, match=words):
        job(RUN.replace(before, after, 1) if before in RUN else "", tmp_path, "run")


def test_one_sector_of_a_disk_is_refused_in_time(tmp_path):
    text = DISK.replace('"campbell"', '"run_up"').replace("[campbell]", "[run_up]\nduration = 1.0\nreference_speed = 3000.0")
    text = text.replace("[0.0, 6000.0]", "[1000.0, 6000.0]").replace("operating_speed = 3000.0\n", "")
    with pytest.raises(InputError, match="Integrate the full disk"):
        job(text, tmp_path, "run")
