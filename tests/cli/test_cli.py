"""The command line end to end: what it writes, what it says, how it ends."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

import stickslip
from stickslip.cli import app, studies
from stickslip.cli.app import claimed
from stickslip.results.files import open_results
from stickslip.runs.cases import CheckpointFolder
from stickslip.show.report import markup
from stickslip.support import console
from stickslip.support.files import LIST

COMMAND = [sys.executable, "-m", "stickslip"]

ONE_MASS = """
[study]
title = "One mass and a slider"
analysis = "forced_response"
[structure]
matrices = "one.npz"
dofs = ["1.x"]
[[contact]]
law = "macroslip"
between = ["1.x", "ground"]
kt = 1.0
mu = 1.0
normal_load = 1.0
[[force]]
direction = "1.x"
amplitude = 1.0
[sweep]
frequency = [0.07957747154594767, 0.3183098861837907]  # 0.5 to 2 rad/s
force_levels = [0.1, 0.5, 1.0, 2.0]
harmonics = 7
samples = 256
outputs = ["1.x"]
"""


WEDGE = """
[study]
analysis = "forced_response"
[structure]
rig = "blade_and_wedge"
[sweep]
frequency = [300.0, 370.0]
force_levels = [10.0]
harmonics = 1
samples = 24
"""

QUICK = ONE_MASS.replace("[0.1, 0.5, 1.0, 2.0]", "[0.5]").replace("harmonics = 7", "harmonics = 1")


def test_finished_curves_of_an_interrupted_run_are_kept_until_told(tmp_path, one_mass):
    """A study that was edited, or the same one, started without --resume: 21 finished curves were deleted in silence."""
    out = tmp_path / "out"
    kept = CheckpointFolder(out / "unfinished", {"study": "another"})
    kept.save("a curve", {"response": np.ones(3)})
    again = stickslip_command("run", one_mass, "--out", out)
    assert_refused(again, "holds 1 finished curve of an interrupted run", "--resume", "--overwrite")
    assert len(kept) == 1
    assert_refused(stickslip_command("run", one_mass, "--out", out, "--resume"), "but the content of the matrices", "study")
    assert len(kept) == 1
    one_mass.write_text(QUICK)
    assert stickslip_command("run", one_mass, "--out", out, "--overwrite").exit_code == 0
    assert not kept.folder.exists()


def test_a_study_without_end_is_refused():
    assert_refused(stickslip_command("check", "/dev/zero"), "The study file must have at most 16 MiB")


def stickslip_command(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def one_mass(tmp_path):
    np.savez(tmp_path / "one.npz", M=[[1.0]], K=[[1.0]], C=[[0.02]])
    path = tmp_path / "one.toml"
    path.write_text(ONE_MASS)
    return path


@pytest.mark.slow
def test_a_reader_that_leaves_does_not_stop_a_run(one_mass, tmp_path):
    """As `stickslip run ... | head -1`: everything is written all the same."""
    one_mass.write_text(QUICK)
    command = [*COMMAND, "run", str(one_mass), "--out", str(tmp_path / "out"), "--workers", "1"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    process.stdout.readline()
    process.stdout.close()
    try:
        errors = process.stderr.read()
        assert process.wait(timeout=120) == 0, errors
    finally:
        process.kill()
        process.stderr.close()
        process.wait()
    assert "Traceback" not in errors
    assert (tmp_path / "out" / "report.html").exists()


@pytest.mark.usefixtures("unsaved_figures")
def test_the_peaks_of_one_mass(one_mass, tmp_path):
    """Peaks of |x| and of the first harmonic, maximised over frequency to 1e-9 by an independent script of this project."""
    result = stickslip_command("run", one_mass, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    data = open_results(tmp_path / "out" / "results.nc")
    first_harmonic = [1.060053763, 1.572294392, 3.537416372, 37.82571321]
    largest = [1.05850631, 1.567292339, 3.560423909, 37.86808498]
    np.testing.assert_allclose(data["peak_amplitude"].isel(peak=0, output=0), first_harmonic, rtol=1e-6)
    np.testing.assert_allclose(data["peak_max_abs"].isel(peak=0, output=0), largest, rtol=1e-6)
    rates = 2.0 * np.pi * data["peak_frequency"].isel(peak=0, output=0)
    np.testing.assert_allclose(rates, [1.406102402, 1.293482118, 1.108840082, 1.003282071], rtol=1e-6)
    assert data.attrs["study"] == ONE_MASS
    assert data.attrs["title"] == "One mass and a slider"


@pytest.mark.slow
def test_figures_are_drawn_on_request(one_mass, tmp_path):
    """By the run itself or afterwards, all or some, in other formats and places; a report renews those that lie there."""
    one_mass.write_text(QUICK)
    out = tmp_path / "out"
    assert stickslip_command("run", one_mass, "--out", out, "--figures").exit_code == 0
    written = {path.name for path in (out / "figures").iterdir()}
    assert {"response.png", "response.svg", "loops.png"} <= written
    os.utime(out / "figures" / "response.svg", (0.0, 0.0))
    assert stickslip_command("report", out).exit_code == 0
    assert (out / "figures" / "response.svg").stat().st_mtime > 0.0
    shown = stickslip_command("plot", out / "results.nc", "--figure", "response", "--format", "pdf", "--out", tmp_path / "slides")
    assert shown.exit_code == 0
    assert [path.name for path in (tmp_path / "slides").glob("[!.]*")] == ["response.pdf"]
    assert "response.pdf" in shown.output
    assert stickslip_command("plot", out).exit_code == 0
    assert {path.name for path in (out / "figures").iterdir()} == written
    wrong = stickslip_command("plot", out, "--figure", "loop")
    assert wrong.exit_code == 2
    assert "must be a figure of these results, but is 'loop'. Did you mean 'loops'?" in wrong.output
    wrong = stickslip_command("plot", out, "--format", "gif")
    assert "--format must be png, svg or pdf, but is 'gif'" in wrong.output


@pytest.mark.slow
def test_moving_pictures_of_results_become_films_and_pages(one_mass, tmp_path):
    one_mass.write_text(WEDGE)
    out = tmp_path / "out"
    assert stickslip_command("run", one_mass, "--out", out).exit_code == 0
    film = stickslip_command("plot", out, "--figure", "motion")
    assert film.exit_code == 0, film.output
    assert [path.name for path in (out / "figures").glob("[!.]*")] == ["motion.gif"]
    both = stickslip_command("plot", out, "--figure", "motion", "--figure", "peaks", "--format", "svg", "--format", "html")
    assert both.exit_code == 0, both.output
    assert {path.name for path in (out / "figures").glob("[!.]*")} == {"motion.gif", "motion.html", "peaks.svg"}
    for options, sentence in (
        (("--figure", "motion", "--format", "png"), "--format must be gif, mp4, webp, html for motion, but is 'png'"),
        (("--figure", "peaks", "--format", "gif"), "--format must be png, svg, pdf for peaks, but is 'gif'"),
        (("--figure", "deformed_shape"), "must be a figure of these results, but is 'deformed_shape'"),
        (("--format", "bmp"), "--format must be png, svg, pdf, gif, mp4, webp or html, but is 'bmp'"),
    ):
        wrong = stickslip_command("plot", out, *options)
        assert wrong.exit_code == 2
        assert sentence in " ".join(wrong.output.split())


def test_what_a_run_writes_and_report_writes_again(one_mass, tmp_path):
    one_mass.write_text(QUICK)
    out = tmp_path / "deep" / "out"
    result = stickslip_command("run", one_mass, "--out", out)
    assert result.exit_code == 0
    assert "highest peaks of 1.x" in result.output
    assert "force 0.5" in result.output
    assert {path.relative_to(out).as_posix() for path in out.rglob("*")} == {"results.nc", "report.html", LIST}
    (out / "report.html").unlink()
    for place in (out, out / "results.nc"):
        assert stickslip_command("report", place).exit_code == 0
    assert "One mass and a slider" in (out / "report.html").read_text()


@pytest.mark.usefixtures("unsaved_figures")
def test_new_check_and_run_of_a_template(tmp_path):
    study = tmp_path / "wedge.toml"
    assert stickslip_command("new", "lumped", study).exit_code == 0
    checked = stickslip_command("check", study)
    assert checked.exit_code == 0
    assert "6 degrees of freedom, 2 contacts, 3 force levels over a band, 5 harmonics, 256 samples" in checked.output
    study.write_text(study.read_text().replace("frequency = [145.0, 235.0]", "at = [222.0]").replace("[0.2, 0.5, 1.0]", "[1.0]"))
    result = stickslip_command("run", study, "--out", tmp_path / "out")
    assert result.exit_code == 0
    assert "largest of the listed frequencies, at 222.00 Hz: amplitude 49.28 µm" in result.output
    amplitude = open_results(tmp_path / "out" / "results.nc")["amplitude"].sel(output="2.y").values.ravel()
    np.testing.assert_allclose(amplitude, [4.928118e-5], rtol=1e-5)  # an independent script of this project


@pytest.mark.slow
@pytest.mark.usefixtures("unsaved_figures")
def test_several_results_share_a_report(one_mass, tmp_path):
    one_mass.write_text(QUICK)
    for name in ("first", "second"):
        assert stickslip_command("run", one_mass, "--out", tmp_path / "both" / name).exit_code == 0
    result = stickslip_command("report", tmp_path / "both")
    assert result.exit_code == 0
    assert "holds no results.nc itself; together, those of its folders: first, second." in result.output
    text = (tmp_path / "both" / "report.html").read_text()
    assert "first" in text
    assert "second" in text


@pytest.mark.usefixtures("unsaved_figures")
def test_results_are_not_overwritten_unless_asked(one_mass, tmp_path):
    one_mass.write_text(QUICK)
    out = tmp_path / "out"
    assert stickslip_command("run", one_mass, "--out", out, "--workers", 1).exit_code == 0
    before = (out / "results.nc").read_bytes()
    again = stickslip_command("run", one_mass, "--out", out)
    assert_refused(
        again, "--out must name a folder without results, but", "holds 'results.nc'. Name another", "--overwrite", "--resume"
    )
    assert "Nothing to compute" in stickslip_command("run", one_mass, "--out", out, "--resume").output
    assert_refused(stickslip_command("run", one_mass, "--out", out, "--resume", "--overwrite"), "must not be given together")
    one_mass.write_text(QUICK.replace("[0.5]", "[0.6]"))
    assert_refused(
        stickslip_command("run", one_mass, "--out", out, "--resume"),
        "come from another study or version",
        "0.6]' now, ",
        "0.5]' then",
        "--overwrite",
    )
    assert (out / "results.nc").read_bytes() == before
    assert stickslip_command("run", one_mass, "--out", out, "--overwrite", "--workers", 1).exit_code == 0
    assert open_results(out / "results.nc")["force_level"].values == [0.6]


def test_the_demo_overwrites_only_when_asked(tmp_path):
    (tmp_path / "4.6kg").mkdir()
    (tmp_path / "4.6kg" / "results.nc").write_text("a result")
    assert_refused(stickslip_command("demo", "--fast", "--out", tmp_path), "must name a folder without results", "--overwrite")
    twice = ("--preload-mass", 2.6, "--preload-mass", 2.6)
    assert_refused(
        stickslip_command("demo", "--out", tmp_path / "new", *twice),
        "--preload-mass must be unique, but '2.6kg' is given more than once",
    )


@pytest.mark.slow
@pytest.mark.usefixtures("unsaved_figures")
def test_results_and_study_of_a_run_are_a_response_in_python(one_mass, tmp_path):
    stickslip_command("run", one_mass, "--out", tmp_path / "out", "--workers", 1)
    response = stickslip.ForcedResponse(stickslip.open_results(tmp_path / "out" / "results.nc"), stickslip.read_problem(one_mass))
    assert response.verify_in_time(case=1, point=3).agrees(2e-3)
    grid = response.at([0.15, 0.2])
    np.testing.assert_allclose(
        grid.amplitude.sel(case=2),
        stickslip.forced_response(response.problem, [0.15, 0.2], harmonics=7).dataset.amplitude.sel(case=0).values[None],
        rtol=2e-3,
    )
    one_mass.write_text(one_mass.read_text().replace("mu = 1.0", "mu = 1.001"))
    other = stickslip.ForcedResponse(response.dataset, stickslip.read_problem(one_mass))
    with pytest.raises(stickslip.InputError, match=r"results are of another problem: .*attrs\['study'\]"):
        other.verify_in_time(case=2, point=other.peak_point(2))
    alone = tmp_path / "alone.toml"
    stickslip_command("new", "damper_cycle", alone)
    with pytest.raises(stickslip.InputError, match="must be of a problem"):
        stickslip.read_problem(alone)
    with pytest.raises(stickslip.InputError, match="must exist"):
        stickslip.read_problem(tmp_path / "none.toml")


@pytest.mark.usefixtures("unsaved_figures")
def test_a_run_says_how_many_harmonics_auto_took_and_why(one_mass, tmp_path):
    text = ONE_MASS.replace("harmonics = 7", 'harmonics = "auto"\ntolerance = 1e-4').replace("[0.1, 0.5, 1.0, 2.0]", "[1.0]")
    one_mass.write_text(text)
    checked = stickslip_command("check", one_mass).output
    assert 'harmonics = "auto"' in checked
    result = stickslip_command("run", one_mass, "--out", tmp_path / "out", "--workers", 1)
    chosen = open_results(tmp_path / "out" / "results.nc").attrs["harmonics_chosen"]
    assert "harmonics: fewer leave an error of" in chosen
    for output in (checked, result.output):
        assert f"Chosen: {chosen.partition(':')[0]}, " in output
    assert "stuck mode" not in chosen  # which is at 0.2251 Hz, below all harmonics that are left out
    assert chosen in result.output
    assert chosen in (tmp_path / "out" / "report.html").read_text()


def test_one_is_singular(one_mass):
    one_mass.write_text(ONE_MASS.replace("[0.1, 0.5, 1.0, 2.0]", "[1.0]").replace("harmonics = 7", "harmonics = 1"))
    said = "1 degree of freedom, 1 contact, 1 force level over a band, 1 harmonic, 256 samples"
    assert said in stickslip_command("check", one_mass).output


def test_help_names_debug():
    assert "--debug" in stickslip_command("--help").output


def assert_refused(result, *said, code=console.WRONG_INPUT):
    assert result.exit_code == code
    assert "Traceback" not in result.output
    for words in said:
        assert words in result.output


def test_check_names_all_faults(one_mass):
    text = (
        ONE_MASS.replace("kt = 1.0", "kt = -1.0")
        .replace('direction = "1.x"', 'direction = "2.x"')
        .replace("harmonics", "harmonic")
    )
    one_mass.write_text(text)
    assert_refused(
        stickslip_command("check", one_mass),
        "3 errors",
        "[[contact]] 1: kt must be above 0, but is -1.0",
        "'2.x' does not exist. Did you mean '1.x'?",
        "'harmonic'. Did you mean 'harmonics'?",
    )


def test_wrong_use_is_refused(one_mass, tmp_path):
    assert_refused(stickslip_command("check", tmp_path / "missing.toml"), "must exist", "missing.toml")
    assert_refused(stickslip_command("run", tmp_path / "missing.toml", "--out", tmp_path / "o"), "must exist")
    assert_refused(stickslip_command("run", one_mass), "--out")
    assert_refused(stickslip_command("checks", one_mass), "checks")
    assert_refused(stickslip_command("check", one_mass, "--fats"), "--fats")
    assert_refused(stickslip_command("new", "lumpd", tmp_path / "a.toml"), "'lumpd'. Did you mean 'lumped'?")
    assert_refused(stickslip_command("new", "lumped", one_mass), "must not exist yet")
    assert_refused(stickslip_command("new", "lumped", tmp_path / "a.txt"), "must end in .toml")
    assert_refused(stickslip_command("report", tmp_path), "RESULTS must be results.nc")
    assert_refused(stickslip_command("report", tmp_path / "no.nc"), "must exist")
    assert_refused(stickslip_command("report", one_mass), "must be NetCDF-4")
    assert_refused(stickslip_command("demo", "--out", tmp_path / "o", "--preload-mass", "much"), "--preload-mass")
    assert_refused(stickslip_command("demo", "--out", tmp_path / "o", "--preload-mass", "-1"), "--preload-mass must be positive")
    assert_refused(stickslip_command("demo", "--out", tmp_path / "o", "--preload-mass", "nan"), "--preload-mass must be finite")
    assert_refused(
        stickslip_command("demo", "--out", tmp_path / "o", "--preload-mass", "3"), "--preload-mass must be 2.6, 4.6 or 6.6"
    )


def test_a_folder_that_cannot_be_written(one_mass, tmp_path):
    (tmp_path / "file").write_text("")
    for place in (tmp_path / "file", tmp_path / "file" / "below"):
        assert_refused(
            stickslip_command("run", one_mass, "--out", place), "The output folder must be a folder that can be written"
        )
    if os.geteuid() != 0:
        (tmp_path / "locked").mkdir(mode=0o500)
        assert_refused(stickslip_command("run", one_mass, "--out", tmp_path / "locked"), "can be written")


def test_a_fault_of_the_program_has_no_traceback_unless_asked(one_mass, monkeypatch):
    def broken(path, progress):
        raise ZeroDivisionError("a bug")

    monkeypatch.setattr("stickslip.study.read", broken)
    assert_refused(stickslip_command("check", one_mass), "Error inside stickslip (ZeroDivisionError: a bug)", code=console.FAILED)
    with pytest.raises(ZeroDivisionError):
        CliRunner().invoke(app, ["--debug", "check", str(one_mass)], catch_exceptions=False)


@pytest.mark.usefixtures("unsaved_figures")
def test_a_curve_that_breaks_off_is_said(one_mass, tmp_path, monkeypatch):
    """Results are written all the same; scripts see the exit code."""
    one_mass.write_text(QUICK)
    broken = replace(
        markup.presentations()["forced_response"], failures=lambda dataset: ["force 0.5: the curve stopped at 0.2 Hz."]
    )
    monkeypatch.setitem(markup._PRESENTATIONS, "forced_response", broken)
    markup.presentation_named.cache_clear()
    result = stickslip_command("run", one_mass, "--out", tmp_path / "out")
    assert_refused(result, "force 0.5: the curve stopped at 0.2 Hz.", code=console.INCOMPLETE)
    assert (tmp_path / "out" / "results.nc").is_file()
    markup.presentation_named.cache_clear()


def test_the_version_and_no_command():
    assert stickslip_command("--version").output == f"stickslip {stickslip.__version__}\n"
    assert "Commands" in stickslip_command().output


@pytest.mark.parametrize("command", ["demo", "run", "identify"])
def test_whatever_computes_long_can_go_on(command):
    shown = stickslip_command(command, "--help").output
    assert "--resume" in shown
    assert "--overwrite" in shown


@pytest.mark.slow
def test_interrupted_while_the_report_is_written(one_mass, tmp_path, monkeypatch):
    """The results are complete and kept nowhere else; `--resume` writes the report."""

    def interrupted(*arguments, **options):
        raise KeyboardInterrupt

    out = tmp_path / "out"
    with monkeypatch.context() as context:
        context.setattr(studies, "write_reports", interrupted)
        stopped = stickslip_command("run", one_mass, "--out", out)
    assert stopped.exit_code == console.INTERRUPTED
    assert f"The results in {out} are complete; `stickslip report {out}` writes the report." in stopped.output
    assert [path.name for path in out.glob("[!.]*")] == ["results.nc"]
    resumed = stickslip_command("run", one_mass, "--out", out, "--resume")
    assert resumed.exit_code == 0
    assert "Nothing to compute" in resumed.output
    assert (out / "report.html").is_file()


@pytest.mark.slow
def test_interrupted_from_the_keyboard(one_mass, tmp_path):
    """Ctrl-C while it computes: a sentence, exit code 130, no half-written file."""
    one_mass.write_text(ONE_MASS.replace("[0.1, 0.5, 1.0, 2.0]", str(np.linspace(0.5, 2.0, 400).tolist())))
    arguments = [*COMMAND, "run", str(one_mass), "--out", str(tmp_path / "out")]
    process = subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert "One mass and a slider" in process.stdout.readline()
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=60)
    assert process.returncode == console.INTERRUPTED, errors
    assert errors.strip().endswith("Interrupted. All files written so far are complete.")
    assert "Traceback" not in output + errors
    kept = tmp_path / "out" / "unfinished"
    assert kept.exists() == (tmp_path / "out").exists()  # what holds nothing is not left behind


def test_the_process_ends_with_a_message_on_the_error_stream(tmp_path):
    process = subprocess.run([*COMMAND, "check", str(tmp_path / "no.toml")], capture_output=True, text=True, check=False)
    assert process.returncode == console.WRONG_INPUT
    assert process.stdout == ""
    assert process.stderr.startswith("Error: The study file must exist, but is ")
    assert process.stderr.count("\n") == 1


def test_contact_stiffness_is_printed_and_drawn(tmp_path):
    damper = ["contact-stiffness", "--length", 27.6, "--radius", 5]
    result = stickslip_command(*damper, "--pull", 147, "--platform-angle", 45, "--out", tmp_path / "stiffness.png")
    assert result.exit_code == 0
    assert "6.544e+08" in result.output
    assert (tmp_path / "stiffness.png").stat().st_size > 10_000
    assert (
        "Did you give metres?" in stickslip_command("contact-stiffness", "--length", 0.0276, "--radius", 5, "--load", 80).output
    )
    assert stickslip_command(*damper).exit_code == 2


def test_two_runs_do_not_share_a_folder(one_mass, tmp_path):
    """The second one is refused while the first one runs, and neither loses anything."""
    with claimed(tmp_path):
        assert_refused(stickslip_command("run", one_mass, "--out", tmp_path), "--out must not be in use by another run")
    assert not list(tmp_path.glob("results*"))


def test_a_mode_that_does_not_exist_is_refused_before_the_sweep(one_mass):
    one_mass.write_text(ONE_MASS + "\n[isolated]\nmode = 9\n")
    shown = stickslip_command("check", one_mass)
    assert shown.exit_code == console.WRONG_INPUT
    assert "mode must be at most 1, but is 9" in shown.output


def test_a_quantity_of_results_that_have_none_is_refused(one_mass, tmp_path):
    text = QUICK.replace('"forced_response"', '"nonlinear_modes"')
    one_mass.write_text(text + "\n[nonlinear_modes]\nmode = 1\namplitude = [0.5, 5.0]\n")
    assert stickslip_command("run", one_mass, "--out", tmp_path / "out", "--workers", 1).exit_code == 0
    shown = stickslip_command("export", tmp_path / "out", "--out", tmp_path / "modes.csv", "--quantity", "inertance")
    assert shown.exit_code == console.WRONG_INPUT
    assert "--quantity must stand with response curves" in " ".join(shown.output.split())
    assert not list(tmp_path.glob("*.csv"))
