"""Old names of tables, analyses and templates are still read, with a note that gives the new name; so are old results."""

import pytest
import xarray as xr
from typer.testing import CliRunner

from stickslip.cli import app
from stickslip.results.files import open_results, save
from stickslip.results.schema import RENAMED_ANALYSES, RENAMED_VARIABLES, stamped
from stickslip.show.report.markup import presentation_of
from stickslip.study.analysis import KINDS, owners
from stickslip.study.faults import ANALYSES, TABLES, TEMPLATES, with_new_names
from stickslip.study.reading import read
from stickslip.study.templates import KINDS as FILES
from stickslip.study.templates import write_new


@pytest.mark.parametrize(("old", "new"), TABLES.items())
def test_a_study_with_an_old_table_asks_for_the_same(tmp_path, old, new):
    path = write_new(new, tmp_path / "study.toml")[0]
    today = read(path)
    assert f"\n[{new}]" in path.read_text()
    analyses = [name for name, now in ANALYSES.items() if now == today.analysis]
    text = path.read_text().replace(f"\n[{new}]", f"\n[{old}]")
    for name in analyses:
        text = text.replace(f'analysis = "{today.analysis}"', f'analysis = "{name}"')
    path.write_text(text)
    before = read(path)
    assert before.analysis == today.analysis
    assert before.plan.summary == today.plan.summary
    assert [list(work.names) for work in before.plan.works.values()] == [list(work.names) for work in today.plan.works.values()]
    notes = [note for note in before.notes if note not in today.notes]
    assert notes[0] == f"The table [{old}] is now called [{new}]; the old name will stop working."
    assert len(notes) == 1 + len(analyses)


def test_an_old_table_beside_the_new_one_stays_a_fault():
    document = {"study": {"analysis": "damper_design"}, "design": {"seed": 1}, "damper_design": {"seed": 2}}
    assert with_new_names(document) == (document, [])
    assert not owners("design")


def test_new_names_are_known():
    assert set(TABLES.values()) <= {key for kind in KINDS.values() for key in kind.tables}
    assert set(ANALYSES.values()) <= set(KINDS)
    assert set(TEMPLATES.values()) <= set(FILES)
    assert not set(TEMPLATES) & set(FILES)
    assert {name for name in FILES if name not in KINDS} == {
        "lumped",
        "model",
        "blisk",
        "bladed_disk",
        "two_blades",
        "flutter",
        "jointed_beams",
        "beams_with_a_gap",
        "blade_root",
        "ring_damper",
        "shrouded_blades",
        "strip_damper",
    }


def test_new_takes_an_old_name_of_a_template_with_a_warning(tmp_path):
    result = CliRunner().invoke(app, ["new", "damper-cycle", str(tmp_path / "study.toml")])
    assert result.exit_code == 0
    assert "`damper-cycle` is now called `damper_cycle`" in result.output
    assert read(tmp_path / "study.toml").analysis == "damper_cycle"


@pytest.mark.parametrize(("old", "new"), RENAMED_ANALYSES.items())
def test_results_of_an_analysis_under_its_old_name_are_reported(old, new):
    assert new in KINDS
    assert presentation_of(xr.Dataset(attrs={"analysis": old})) is presentation_of(xr.Dataset(attrs={"analysis": new}))


@pytest.mark.parametrize(("old", "new"), RENAMED_VARIABLES.items())
def test_a_variable_of_old_results_is_read_under_its_new_name(tmp_path, old, new):
    meaning = {"units": "1", "long_name": "an old variable"}
    dataset = stamped(xr.Dataset({old: ("case", ["", "a warning"], meaning)}), "performance_curve")
    found = open_results(save(dataset, tmp_path / "results.nc"))
    assert old not in found
    assert found[new].values.tolist() == ["", "a warning"]
    assert found[new].attrs == meaning
