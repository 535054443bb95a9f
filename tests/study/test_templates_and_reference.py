"""Templates are sound studies, and the documentation of the study file is current."""

import re
from pathlib import Path

import numpy as np
import pytest

from stickslip.cli import main
from stickslip.model.contact.point import TractionRatio
from stickslip.model.rigs import three_mass_wedge
from stickslip.study import read, templates
from stickslip.study.templates import KINDS, write_new
from stickslip.support.checks import InputError
from tools import template_files
from tools.reference import SECTIONS, kind_of, limits, reference

TEMPLATES = Path(templates.__file__).parent
DOCS = Path(__file__).parents[2] / "docs"


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in ("forced_response", "damper_cycle")])
def test_templates_are_sound(tmp_path, kind):
    written = write_new(kind, tmp_path / "study.toml")
    assert all(path.is_file() for path in written)
    comments = [line for line in (tmp_path / "study.toml").read_text().splitlines() if re.search(r"[\]\"] {9,}#", line)]
    assert not [line for line in comments if line.index("#") > 45]  # pushed to the right by what was inserted
    study = read(tmp_path / "study.toml")
    assert study.plan.summary
    assert study.sweep is None or study.sweep.problem.contacts


QUICK = (*template_files.MODELS, template_files.loops, template_files.stepped_sines, template_files.contact_record)


@pytest.mark.parametrize("write", QUICK, ids=lambda write: write.__name__)
def test_files_beside_templates_are_what_their_tool_writes(tmp_path, write):
    """To the last digits, which depend on the machine; the decay takes too long for a quick test."""
    for kind in template_files.FOLDER.iterdir():
        (tmp_path / kind.name).mkdir()
    write(tmp_path)
    written = [file for file in tmp_path.rglob("study*") if file.is_file()]
    assert written
    for file in written:
        kept = template_files.FOLDER / file.relative_to(tmp_path)
        if file.suffix == ".npz":
            with np.load(file) as fresh, np.load(kept) as known:
                assert fresh.files == known.files
                for name in known.files:
                    if known[name].dtype.kind == "f":
                        np.testing.assert_allclose(fresh[name], known[name], atol=1e-10 * np.abs(known[name]).max())
                    else:
                        assert np.array_equal(fresh[name], known[name])
        elif "node" in kept.read_text()[:10]:
            assert file.read_text() == kept.read_text()
        else:
            assert file.read_text().partition("\n")[0] == kept.read_text().partition("\n")[0]
            fresh, known = (np.loadtxt(each, delimiter=",", skiprows=1) for each in (file, kept))
            np.testing.assert_allclose((fresh - known) / np.abs(known).max(axis=0), 0.0, atol=1e-5)


def test_new_without_a_kind_lists_every_kind_with_its_purpose(capsys):
    with pytest.raises(SystemExit) as end:
        main(["new"])
    assert not end.value.code
    lines = capsys.readouterr().out.splitlines()
    assert {file.stem for file in TEMPLATES.glob("*.toml")} == set(KINDS) == {line.split()[0] for line in lines if line[0] != " "}
    assert any(line.startswith("lumped ") and line.endswith("as three masses in a plane") for line in lines)


def test_new_lists_what_it_wrote(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit):
        main(["new", "response_identification", "a.toml"])
    assert capsys.readouterr().out.startswith("Wrote a.toml, a_0.5_N.csv, a_6_N.csv and a_15_N.csv. Next: ")


def test_the_template_of_the_rig_is_sound(tmp_path):
    write_new("forced_response", tmp_path / "study.toml")
    study = read(tmp_path / "study.toml")
    assert study.sweep.levels == (1.0, 5.0, 20.0, 50.0, 80.0, 100.0)
    assert len(study.sweep.problem.contacts) == 16


def test_a_rig_takes_a_start_rule(tmp_path):
    write_new("forced_response", tmp_path / "study.toml")
    text = (tmp_path / "study.toml").read_text()
    (tmp_path / "study.toml").write_text(text.replace("[sweep]", "start = { traction_ratio = 0.5 }\n[sweep]"))
    contacts = read(tmp_path / "study.toml").sweep.problem.contacts
    assert all(start == TractionRatio(0.5) for contact in contacts for start in contact.starts)
    (tmp_path / "study.toml").write_text(text.replace("[sweep]", "start = { traction_rato = 0.5 }\n[sweep]"))
    with pytest.raises(InputError, match="Did you mean 'traction_ratio'"):
        read(tmp_path / "study.toml")


def test_the_lumped_template_is_the_wedge_of_the_rigs(tmp_path):
    """Text and matrices of the template against the Python rig."""
    write_new("lumped", tmp_path / "study.toml")
    ours, rig = read(tmp_path / "study.toml").sweep.problem, three_mass_wedge()
    for key in ("stuck_stiffness", "C", "contact_stiffness"):
        np.testing.assert_allclose(getattr(ours, key), getattr(rig, key), rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(ours.load(1), rig.load(1))
    assert [contact.start for contact in ours.contacts] == [(rig.contacts[0].start,)] * 2


def test_nothing_is_overwritten_unless_asked(tmp_path):
    write_new("lumped", tmp_path / "a.toml")
    with pytest.raises(InputError, match="must not exist yet"):
        write_new("lumped", tmp_path / "a.toml")
    assert write_new("lumped", tmp_path / "a.toml", overwrite=True)


def test_the_reference_in_the_documentation_is_current():
    assert (DOCS / "study_reference.md").read_text() == reference(), "run `make reference`"


def test_every_key_has_a_meaning():
    assert [line for line in reference().splitlines() if line.startswith("| `") and line.endswith("|  |")] == []


RIG, MATRICES = re.findall(r"```toml\n(\[study\]\n.*?)```", (DOCS / "study.md").read_text(), re.S)
"""The complete studies of the page on study files."""


@pytest.mark.parametrize("text", [pytest.param(RIG, marks=pytest.mark.slow), MATRICES], ids=["rig", "matrices"])
def test_the_studies_in_the_documentation_are_sound(text, tmp_path):
    (tmp_path / "study.toml").write_text(text)
    study = read(tmp_path / "study.toml")
    assert study.plan.summary
    assert study.sweep.problem.contacts


def test_the_template_of_a_model_is_a_blade(tmp_path):
    """The first bending of its 8 x 120 x 30 mm blade lies between that of a slender beam and of a wide plate (1 - ν²)."""
    write_new("model", tmp_path / "study.toml")
    study = read(tmp_path / "study.toml")
    slender = 1.8751**2 / (2 * np.pi) * np.sqrt(210e9 * 0.008**2 / 12 / 7850) / 0.12**2
    assert study.sweep.problem.frequencies(stuck=False)[0] == pytest.approx(1.024 * slender, rel=0.024)
    assert [note.partition(":")[0] for note in study.notes] == [
        "left",
        "right",
        "tip",
        "Modes of the body with what is kept held",
    ]
    assert not any("away" in note or "from the point" in note for note in study.notes)


def test_every_whole_number_has_an_upper_bound():
    """So that `check` refuses a slip of the pen that `run` would compute at for ever, and the reference says so."""
    fields = {
        (model.__name__, name): field
        for models in SECTIONS.values()
        for model in models
        for name, field in model.model_fields.items()
    }
    counts = {place: limits(field) for place, field in fields.items() if kind_of(field) == "whole number"}
    assert len(counts) > 30
    assert [place for place, bound in counts.items() if "≤" not in bound] == []


@pytest.mark.parametrize(
    ("kind", "change", "said"),
    [
        ("performance_curve", ("points = 30", "points = 10000000000000"), "points must be at most 100000, but is 10000000000000"),
        (
            "sensitivity_indices",
            ("draws = 64", "draws = 1125899906842624"),
            "must be at most 1048576, but is 1125899906842624",
        ),
        ("response_bounds", ("seed = 0", f"seed = {10**23}"), f"seed must be at most {2**63 - 1}, but is {10**23}"),
    ],
)
def test_huge_counts_are_refused_at_reading(tmp_path, kind, change, said):
    write_new(kind, tmp_path / "study.toml")
    text = (tmp_path / "study.toml").read_text()
    assert change[0] in text
    (tmp_path / "study.toml").write_text(text.replace(*change))
    with pytest.raises(InputError, match=said):
        read(tmp_path / "study.toml")
