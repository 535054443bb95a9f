"""What a check says of the model: implausible amplitudes, and bodies that friction alone holds."""

import pytest

from stickslip.study.reading import job
from stickslip.study.run_time import model_summary
from stickslip.study.templates import write_new


@pytest.mark.parametrize(
    ("kind", "words"), [("model", "times the size of the structure"), ("lumped", "moves the stuck structure by")]
)
@pytest.mark.parametrize("level", [1.0, 1e39])
def test_a_force_that_moves_the_structure_by_its_size_is_a_warning(tmp_path, kind, words, level):
    write_new(kind, tmp_path / "study.toml")
    text = (tmp_path / "study.toml").read_text()
    line = next(line for line in text.splitlines() if line.startswith("force_levels"))
    study = job(text.replace(line, f"force_levels = [{level}]"), tmp_path, "study")
    found = [sentence for sentence in study.notes if "moves the stuck structure" in sentence]
    assert len(found) == (level > 1.0)
    assert all(words in sentence and "check the units" in sentence for sentence in found)


def test_no_template_warns(tmp_path):
    for kind in ("forced_response", "blisk", "performance_curve"):
        write_new(kind, tmp_path / f"{kind}.toml")
        study = job((tmp_path / f"{kind}.toml").read_text(), tmp_path, "study")
        assert not any("Warning" in sentence for sentence in (*study.notes, *model_summary(study.sweep)))


@pytest.mark.parametrize(("kind", "held"), [("forced_response", True), ("lumped", False), ("blisk", False)])
def test_a_body_that_friction_alone_holds_is_named(tmp_path, kind, held):
    """The dampers of the single blade move along their axes against friction only."""
    write_new(kind, tmp_path / "study.toml")
    study = job((tmp_path / "study.toml").read_text(), tmp_path, "study")
    assert any("held by friction alone" in sentence for sentence in model_summary(study.sweep)) == held
