"""How long a run will take, as `check` says it."""

import pytest
from each import each

import stickslip as ss
from stickslip.cli import main
from stickslip.study import read
from stickslip.study.run_time import _in_words, _with_harmonics, estimated_seconds, stays_long
from stickslip.study.run_time import run_time as sentence
from stickslip.study.templates import write_new


def run_time(job):
    return sentence(job, estimated_seconds(job))


def study(tmp_path, kind="lumped", *changes):
    path, *_ = write_new(kind, tmp_path / "study.toml")
    text = path.read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text)
    return path


def test_a_check_says_how_long_a_run_takes(tmp_path, capsys):
    """Three curves of three masses take seconds on any machine; ten thousand do not."""
    path = study(tmp_path)
    ss.forced_response(ss.rigs.three_mass_wedge(), ss.hertz(215.0, 220.0), 1.0)  # compiles, where that is still to be done
    assert run_time(read(path)) == "Computing 3 curves takes seconds of one core, as roughly estimated from a few points."
    whole = path.read_text()
    path.write_text(f"{whole}\n[reached]\n")
    assert run_time(read(path)).endswith("The time integration of [reached] comes in addition and may take ten times as long.")
    path.write_text(whole)
    with pytest.raises(SystemExit) as end:
        main(["check", str(path)])
    assert not end.value.code
    assert "Computing 3 curves takes seconds of one core" in capsys.readouterr().out
    levels = ", ".join(f"{1.0 + 0.0001 * k:.4f}" for k in range(10000))
    old = next(line for line in path.read_text().splitlines() if line.startswith("force_levels"))
    many = run_time(read(study(tmp_path / "many", "lumped", (old, f"force_levels = [{levels}]"))))
    assert many.startswith("Computing 10000 curves takes ")
    assert "seconds" not in many


def test_listed_frequencies_and_other_analyses_have_no_estimate(tmp_path):
    old = next(line for line in study(tmp_path).read_text().splitlines() if line.startswith("frequency"))
    assert run_time(read(study(tmp_path / "at", "lumped", (old, "at = [160.0, 161.0]")))) == ""
    assert run_time(read(study(tmp_path / "other", "damper_cycle"))) == ""


def test_without_compiled_kernels_a_check_compiles_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr("stickslip.support.kernels.cache.FOLDER", tmp_path / "empty")
    assert "compiles for about a minute" in run_time(read(study(tmp_path)))


def test_chosen_harmonics_count(tmp_path):
    """With "auto" the estimate is of the harmonics and samples that were chosen, not of a usual number."""
    job = read(study(tmp_path))
    automatic = read(study(tmp_path / "auto", "lumped", ("harmonics = 5", 'harmonics = "auto"')))
    work = automatic.plan.works[""]
    assert work.harmonics != job.plan.works[""].harmonics
    chosen = _with_harmonics(automatic.sweep, automatic.plan)
    assert (chosen.harmonics, chosen.samples) == (work.harmonics, work.samples)
    assert _with_harmonics(job.sweep, job.plan) is job.sweep


def test_a_population_says_how_long_it_takes_and_on_how_many_coordinates(tmp_path, monkeypatch):
    """More disks take longer; a large disk names its coordinates, and its cases leave this process free for Ctrl-C."""
    ss.forced_response(ss.rigs.three_mass_wedge(), ss.hertz(215.0, 220.0), 1.0)  # compiles, where that is still to be done
    job = read(study(tmp_path, "mistuned_population"))
    assert run_time(job).startswith("Computing 20 mistuned disks takes ")
    assert not stays_long(job)
    many = read(study(tmp_path / "many", "mistuned_population", ("count = 20", "count = 20000")))
    assert estimated_seconds(many) > 100.0 * estimated_seconds(job)
    monkeypatch.setattr("stickslip.analyses.mistuning.work.LARGE", 100)
    large = read(study(tmp_path / "large", "mistuned_population", ("count = 20", "count = 1")))
    assert stays_long(large)
    assert large.plan.works[""].coordinates <= 24 * large.sweep.problem.structure.size


@each(
    ("seconds", "words"),
    [
        (3.0, "seconds"),
        (60.0, "about a minute"),
        (100.0, "about 2 minutes"),
        (1100.0, "about 20 minutes"),
        (1300.0, "about 20 minutes"),
        (5300.0, "about 90 minutes"),
        (6000.0, "about 2 hours"),
        (1e5, "about 30 hours"),
        (4e6, "about 50 days"),
    ],
)
def test_estimates_that_differ_little_read_alike(seconds, words):
    assert _in_words(seconds) == words
