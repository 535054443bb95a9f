"""A damper cycle from a study file: the same numbers as from Python, a report with its figure, faults said in words."""

import pytest

from stickslip.analyses.damper_cycle import damper_cycle
from stickslip.checks import InputError
from stickslip.cli import main
from stickslip.dampers import in_phase
from stickslip.results import open_results
from stickslip.rigs import laboratory_damper
from stickslip.study import read
from stickslip.study.damper_cycle import TEMPLATE


def test_the_template_runs_to_a_report(tmp_path, capsys):
    study, out = tmp_path / "study.toml", tmp_path / "out"
    study.write_text(TEMPLATE.replace("steps = 1000 ", "steps = 200 "))
    with pytest.raises(SystemExit) as end:
        main(["run", str(study), "--out", str(out)])
    assert not end.value.code
    found = open_results(out / "results.nc")
    python = damper_cycle(laboratory_damper(45.0, 50.0, (0.40, 0.22, 0.32)), in_phase(30e-6), steps=200)
    assert float(found.loop_energy) == pytest.approx(python.energy, rel=1e-9)
    assert "L2: stick" in capsys.readouterr().out
    report = (out / "report.html").read_text()
    assert "Damper cycle" in report
    assert (out / "figures" / "damper_cycle.png").stat().st_size > 10_000
    with pytest.raises(SystemExit) as end:
        main(["export", str(out / "results.nc"), "--out", str(out / "table.csv")])
    assert not end.value.code


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("mu = [0.40, 0.22, 0.32]", "mu = [0.4, 0.2]", "mu must have 3 entries"),
        ("foot_distance = 14e-3", "foot_spacing = 14e-3", "foot_spacing"),
        ("vertical = 30e-6", "vertical = 0.0", "A platform motion must move"),
        ("pull = 50.0", "pull = -50.0", "pull"),
        ('shape = "three_point"', 'shape = "four_point"', "shape"),
        ("# frequency = 5.0", "frequency = 5.0", "method"),
    ],
)
def test_faults_are_said(tmp_path, old, new, message):
    study = tmp_path / "study.toml"
    study.write_text(TEMPLATE.replace(old, new))
    with pytest.raises(InputError, match=message):
        read(study)


def test_units_and_an_elastic_rig(tmp_path):
    text = TEMPLATE.replace("[study]", 'units = { length = "um" }\n\n[study]').replace("vertical = 30e-6", "vertical = 30.0")
    text = text.replace("kt = 56e6", "kt = 56.0").replace("kn = 84e6", "kn = 84.0\nplatform_stiffness = 30.0")
    (tmp_path / "study.toml").write_text(text)
    plan = read(tmp_path / "study.toml").plan
    assert plan.rig.laws[0].kn == pytest.approx(84e6)
    assert float(plan.rig.right.stiffness[1, 1]) == pytest.approx(30e6)
    assert plan.motion.harmonics[1, 2] == pytest.approx(30e-6)
