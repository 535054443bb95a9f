"""Every command that writes leaves what a user has as it was: files of the same names, links, folders, protected files."""

import os
import shutil
import stat
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from stickslip.cli import app
from stickslip.results.files import open_results
from stickslip.support.console import WRONG_INPUT
from stickslip.support.files import LIST, WrittenFiles

STUDY = """
[study]
title = "One mass and a slider"
analysis = "forced_response"
[structure]
matrices = { M = [[1.0]], K = [[1.0]], C = [[0.02]] }
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
frequency = [0.08, 0.3]
force_levels = [0.5]
harmonics = 1
samples = 64
outputs = ["1.x"]
"""
STOPPED = STUDY.replace("[0.5]", "[0.6]")
RESULT, REPORT = "results.nc", "report.html"


def command(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def everything(folder):
    """Every path below a folder with its kind, its mode and its content; links are not followed."""
    found = {}
    for path in sorted(folder.rglob("*")):
        mode = path.lstat().st_mode
        content = os.readlink(path) if stat.S_ISLNK(mode) else path.read_bytes() if stat.S_ISREG(mode) else None
        found[path.relative_to(folder).as_posix()] = (mode, content)
    return found


def assert_nothing_lost(folder, before, but=()):
    after = everything(folder)
    assert {name: after.get(name) for name in before if name not in but} == {n: v for n, v in before.items() if n not in but}


@pytest.fixture(autouse=True)
def files(tmp_path, monkeypatch):
    """A working folder with a study, a record of a decay and a loop, and what is precious beside it."""
    work, precious = tmp_path / "work", tmp_path / "precious"
    for folder in (work, precious):
        folder.mkdir()
    (precious / "thesis.doc").write_text("years")
    monkeypatch.chdir(work)
    (work / "study.toml").write_text(STUDY)
    time = np.arange(2000) / 2000.0
    decay = np.exp(-4.0 * time) * np.cos(2.0 * np.pi * 60.0 * time)
    np.savetxt(work / "decay.csv", np.c_[time, decay], delimiter=",", header="time [s],displacement [mm]", comments="")
    angle = np.linspace(0.0, 4.0 * np.pi, 400)
    np.savetxt(
        work / "loop.csv", np.c_[np.sin(angle), np.cos(angle)], delimiter=",", header="position [um],force [N]", comments=""
    )
    return tmp_path


@pytest.fixture(scope="session")
def computed(tmp_path_factory):
    """A folder of results."""
    folder = tmp_path_factory.mktemp("computed")
    (folder / "study.toml").write_text(STUDY)
    shown = command("run", folder / "study.toml", "--out", folder / "out", "--workers", 1)
    assert shown.exit_code == 0, shown.output
    return folder / "out"


WRITERS = {
    "run": lambda out: ("run", "study.toml", "--workers", 1, "--out", out),
    "demo": lambda out: ("demo", "--fast", "--out", out),
    "contact-law": lambda out: ("contact-law", "loop.csv", "--normal-load", 100, "--out", out),
    "decay": lambda out: ("decay", "decay.csv", "--out", out),
    "identify-response": lambda out: ("identify-response", "decay.csv", "--problem", "study.toml", "--force", 1, "--out", out),
}
FLAGS = ((), ("--overwrite",), ("--resume",), ("--figures",), ("--overwrite", "--figures"))


def user_folder_unfinished(out, precious):
    (out / "unfinished").mkdir()
    (out / "unfinished" / "thesis.doc").write_text("years")


def empty_folder_unfinished(out, precious):
    (out / "unfinished").mkdir()


def file_unfinished(out, precious):
    (out / "unfinished").write_text("mine")


def linked_unfinished(out, precious):
    (out / "unfinished").symlink_to(precious)


def linked_result(out, precious):
    (out / RESULT).symlink_to(precious / "thesis.doc")


def dangling_result(out, precious):
    (out / RESULT).symlink_to(precious / "nothing")


def linked_report(out, precious):
    (out / REPORT).symlink_to(precious / "thesis.doc")


def own_report(out, precious):
    (out / REPORT).write_text("mine")


def own_result(out, precious):
    (out / RESULT).write_text("mine")


def folder_for_result(out, precious):
    (out / RESULT).mkdir()


def foreign_list(out, precious):
    (out / LIST).write_text("mine")


def linked_list(out, precious):
    (out / LIST).symlink_to(precious / "thesis.doc")


TRAPS = (
    *(user_folder_unfinished, empty_folder_unfinished, file_unfinished, linked_unfinished, linked_result, dangling_result),
    *(linked_report, own_report, own_result, folder_for_result, foreign_list, linked_list),
)


@pytest.mark.parametrize("trap", TRAPS)
def test_a_trap_in_the_folder_of_results_is_refused_before_anything_is_computed(files, trap, monkeypatch):
    out = files / "work" / "out"
    out.mkdir()
    trap(out, files / "precious")
    monkeypatch.setattr("stickslip.study.run.Run.computed", None)
    before = everything(files)
    for name, arguments in WRITERS.items():
        for flags in FLAGS if name == "run" else FLAGS[:2]:
            if name == "demo" and "result" in trap.__name__:
                continue  # which writes into folders below
            shown = command(*arguments("out"), *flags)
            assert shown.exit_code == WRONG_INPUT, (arguments("out"), flags, shown.output)
            assert everything(files) == before, (arguments("out"), flags)


@pytest.mark.parametrize("name", WRITERS)
def test_a_link_or_a_file_in_place_of_the_folder_is_refused(files, name):
    (files / "work" / "linked").symlink_to(files / "precious")
    (files / "work" / "dangling").symlink_to(files / "nowhere")
    (files / "work" / "file").write_text("mine")
    before = everything(files)
    for out in ("linked", "dangling", "file", "file/below"):
        for flags in ((), ("--overwrite",)):
            shown = command(*WRITERS[name](out), *flags)
            assert shown.exit_code == WRONG_INPUT, (out, shown.output)
            assert everything(files) == before, out


@pytest.mark.parametrize("name", ["run", "decay"])
def test_everything_else_in_the_folder_stays(files, name):
    """Hidden files with names like those of temporary ones, folders, links, a folder of pictures; whatever the flags."""
    out = files / "work" / "out"
    for folder in (out / "deep", out / "figures", out / "locked"):
        folder.mkdir(parents=True)
    for hidden in (out / ".settings.deadbeef.json", out / "deep" / ".settings.deadbeef.json", out / ".unfinished.removed"):
        hidden.write_text("mine")
    (out / "figures" / "response.png").write_text("mine")
    (out / "linked").symlink_to(files / "precious")
    (out / "locked" / "notes.txt").write_text("mine")
    (out / "locked" / "notes.txt").chmod(0o400)
    before = everything(files)
    flags = [(), ("--overwrite",)] + [("--resume",)] * (name == "run")
    for flag in flags:
        shown = command(*WRITERS[name]("out"), *flag)
        assert shown.exit_code == 0, shown.output
        assert_nothing_lost(files, before)
    with_figures = command(*WRITERS[name]("out"), "--overwrite", "--figures")
    if name == "run":
        assert (with_figures.exit_code, "response.png" in with_figures.output) == (WRONG_INPUT, True)
    assert_nothing_lost(files, before)


def test_results_are_replaced_only_as_they_were_written(files, computed):
    """Own ones are; protected, changed or linked ones are not, whatever the flags."""
    for change in ("none", "protected", "changed", "moved and linked", "without its list"):
        out = files / "work" / change
        shutil.copytree(computed, out)
        before = (out / RESULT).read_bytes()
        if change == "protected":
            (out / RESULT).chmod(0o444)
        elif change == "changed":
            (out / REPORT).write_text("mine")
        elif change == "moved and linked":
            (out / RESULT).rename(files / "precious" / RESULT)
            (out / RESULT).symlink_to(files / "precious" / RESULT)
        elif change == "without its list":
            (out / LIST).unlink()
        everywhere = everything(files)
        (files / "work" / "study.toml").write_text(STOPPED)
        shown = command("run", "study.toml", "--workers", 1, "--out", change, "--overwrite")
        if change == "none":
            assert shown.exit_code == 0, shown.output
            assert (out / RESULT).read_bytes() != before
            assert WrittenFiles(out).has(out / RESULT)
        else:
            assert shown.exit_code == WRONG_INPUT, change
            (files / "work" / "study.toml").write_text(STUDY)
            assert_nothing_lost(files, everywhere, ["work/study.toml"])


def test_a_folder_of_the_user_that_is_empty_stays_when_nothing_is_written(files):
    (files / "work" / "out").mkdir()
    (files / "work" / "study.toml").write_text(STUDY.replace("[0.5]", "[-0.5]"))
    assert command(*WRITERS["run"]("out")).exit_code == WRONG_INPUT
    assert command(*WRITERS["run"]("new/folder")).exit_code == WRONG_INPUT
    assert (files / "work" / "out").is_dir()
    assert not (files / "work" / "new").exists()


@pytest.fixture
def shown_model(monkeypatch):
    """`check --show` writes a page although the study has no nodes to draw."""
    drawn = SimpleNamespace(to_plotly=lambda: SimpleNamespace(to_html=lambda **options: "page"))
    monkeypatch.setattr("stickslip.show.plots.model_view.model_view", lambda problem, units: drawn)


@pytest.mark.usefixtures("shown_model")
def test_commands_on_results_replace_nothing_of_the_user(files, computed):
    """`report`, `plot`, `export`, `check --show`, `new` and `contact-stiffness`."""
    work = files / "work"
    shutil.copytree(computed, work / "out")
    (work / "out" / REPORT).write_text("mine")
    (work / "out" / "figures").symlink_to(files / "precious")
    (work / "pictures").mkdir()
    (work / "pictures" / "response.png").write_text("mine")
    (work / "linked").symlink_to(files / "precious")
    for name in ("study_model.html", "a_peaks.csv", "kt.png", "mine.toml", "new.npz", "law.csv"):
        (work / name).write_text("mine")
    for suffix in ("csv", "mat", "vtu", "png"):
        (work / f"linked.{suffix}").symlink_to(files / "precious" / "thesis.doc")
        (work / f"folder.{suffix}").mkdir()
    stiffness = ("contact-stiffness", "--length", 27.6, "--radius", 5, "--load", 80, "--out")
    refused = [
        ("report", "out"),
        ("plot", "out"),
        ("plot", "out", "--figure", "response", "--format", "png", "--out", "pictures"),
        ("plot", "out", "--figure", "response", "--format", "png", "--out", "linked"),
        ("check", "study.toml", "--show"),
        ("export", "out", "--out", "a.csv"),
        (*stiffness, "kt.png"),
        (*stiffness, "linked.png", "--overwrite"),
        ("new", "lumped", "mine.toml"),
        ("new", "lumped", "new.toml"),
        ("new", "contact_law", "law.toml"),
        *(
            ("export", "out", "--out", f"{kind}.{suffix}", "--overwrite")
            for kind in ("linked", "folder")
            for suffix in ("csv", "mat")
        ),
        *(("export", "out", "--out", f"{kind}.vtu", "--overwrite") for kind in ("linked", "folder")),
    ]
    before = everything(files)
    for arguments in refused:
        shown = command(*arguments)
        assert shown.exit_code == WRONG_INPUT, (arguments, shown.output)
        assert everything(files) == before, arguments


@pytest.mark.usefixtures("shown_model")
def test_what_stickslip_wrote_it_replaces(files, computed):
    work = files / "work"
    shutil.copytree(computed, work / "out")
    figure = ("plot", "out", "--figure", "response", "--format", "png")
    for arguments in (("report", "out"), figure, figure, ("check", "study.toml", "--show"), ("check", "study.toml", "--show")):
        shown = command(*arguments)
        assert shown.exit_code == 0, (arguments, shown.output)
    assert open_results(work / "out").attrs["title"] == "One mass and a slider"


def test_the_list_is_that_of_sha256sum_and_survives_half_a_line(tmp_path):
    """A killed process leaves a temporary file and half a line; names with folders are no names of the list."""
    tmp_path = tmp_path / "list"
    tmp_path.mkdir()
    files = WrittenFiles(tmp_path)
    files.add(".a.01234567.npz")
    files.add(".b.txt")
    for name in (".a.01234567.npz", ".b.txt", ".c.01234567.npz"):
        (tmp_path / name).write_text("x")
    with (tmp_path / LIST).open("a") as file:
        file.write("unfinished  ../.d.01234567.npz\nunfinished  half")
    files.add("x.txt", "0" * 64)
    assert list(files.entries()) == [".a.01234567.npz", ".b.txt", "half", "x.txt"]
    files.remove_temporary()
    assert {path.name for path in tmp_path.iterdir()} == {LIST, ".b.txt", ".c.01234567.npz"}
    assert not files.has(tmp_path / "x.txt")
    for size in (0, 7):  # what a full disk leaves of the first line
        (tmp_path / LIST).write_bytes((tmp_path / LIST).read_bytes()[:size])
        assert files.exists
        assert files.entries() == {}
        files.add("y.txt", "0" * 64)
        assert list(files.entries()) == ["y.txt"]
