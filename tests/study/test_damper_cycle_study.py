"""A damper cycle from a study file: the same numbers as from Python, a report with its figure, faults said in words."""

from pathlib import Path

import numpy as np
import pytest

from stickslip.analyses.damper_alone.cycle import damper_cycle, steady_cycles
from stickslip.cli import main
from stickslip.laboratory.identification.damper.fit import LINE_LAWS
from stickslip.model.dampers import Cylinder, in_phase, out_of_phase
from stickslip.model.dampers.between_platforms import LAWS, BetweenPlatforms
from stickslip.model.rigs import laboratory_damper
from stickslip.results.files import open_results
from stickslip.show.report.damper_cycle import sentences, tables
from stickslip.solve.platforms.relaxation import elements_of, relaxed_cycle
from stickslip.study import read, templates
from stickslip.support.checks import InputError

KINDS = ("damper_cycle", "steady_cycles", "damper_evolution")
TEMPLATES = [(Path(templates.__file__).parent / f"{kind}.toml").read_text() for kind in KINDS]
TEMPLATE, STARTS_TEMPLATE, EVOLUTION_TEMPLATE = TEMPLATES


def test_the_template_runs_to_a_report(tmp_path, capsys):
    study, out = tmp_path / "study.toml", tmp_path / "out"
    study.write_text(TEMPLATE.replace("steps = 1000 ", "steps = 200 "))
    with pytest.raises(SystemExit) as end:
        main(["run", str(study), "--out", str(out), "--figures"])
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


@pytest.mark.parametrize("law", LINE_LAWS)
def test_a_cycle_takes_what_an_identification_finds(tmp_path, law):
    """The study of an identified law has the cycle that the identification fitted, computed by its relaxation; ten elements
    of iwan there, twenty here."""
    study, gaps = tmp_path / "study.toml", {"microslip": 0.4}.get(law, 0.0)
    keys = f'mu = [0.40, 0.22, 0.32]\nlaw = "{law}"\ngaps = {gaps}'
    study.write_text(TEMPLATE.replace("mu = [0.40, 0.22, 0.32]", keys))
    rig = read(study).plan.works[""].rig
    found = damper_cycle(rig, in_phase(30e-6), steps=500)
    frame = elements_of(laboratory_damper(45.0, 50.0, (0.40, 0.22, 0.32)))
    values = {"kt": frame.kt, "kn": frame.kn, "mu": frame.mu, "gaps": np.full(3, gaps)}
    relaxed = relaxed_cycle(LINE_LAWS[law][0](frame, values, 50.0 / 3.0), 50.0, in_phase(30e-6).samples(500))
    shown = found.dataset.force_on_right.values
    np.testing.assert_allclose(shown, relaxed[:, :2], atol=0.15 if law == "iwan" else 1e-3)
    plain = damper_cycle(laboratory_damper(45.0, 50.0, (0.40, 0.22, 0.32)), in_phase(30e-6), steps=500).dataset.force_on_right
    assert (law == "macroslip") == (np.max(np.abs(shown - plain.values)) < 0.3)


def test_an_identification_names_its_laws_in_its_own_table(tmp_path):
    study = tmp_path / "study.toml"
    text = (Path(templates.__file__).parent / "identification.toml").read_text().replace("$loops", '["x.csv"]')
    study.write_text(text.replace("mu = 0.3", 'mu = 0.3\nlaw = "iwan"'))
    with pytest.raises(InputError, match=r"\[damper\] law must be macroslip in an identification.*\[identification\] law"):
        read(study)


def test_a_cycle_takes_the_law_of_dahl(tmp_path):
    """It dissipates more than sliders of the same stiffness, which first stick: at a reversal it yields at once."""
    study = tmp_path / "study.toml"
    study.write_text(TEMPLATE.replace("mu = [0.40, 0.22, 0.32]", 'mu = [0.40, 0.22, 0.32]\nlaw = "dahl"'))
    motion = in_phase(10e-6)
    found, plain = (
        damper_cycle(rig, motion, steps=500).dataset
        for rig in (read(study).plan.works[""].rig, laboratory_damper(45.0, 50.0, (0.40, 0.22, 0.32)))
    )
    assert np.all(np.abs(found.friction_force) <= np.array([0.40, 0.22, 0.32]) * found.normal_force + 1e-9)
    assert float(found.energy_error) < 1e-2
    assert float(found.loop_energy) > float(plain.loop_energy)


def test_laws_of_identifications_are_laws_of_studies():
    assert set(LINE_LAWS) < set(LAWS)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("mu = [0.40, 0.22, 0.32]", "mu = [0.4, 0.2]", "mu must have 3 entries"),
        ("foot_distance = 14e-3", "foot_spacing = 14e-3", "Known: left_distance, right_distance, foot_distance"),
        ("vertical = 30e-6", "vertical = 0.0", "A platform motion must move.*Give a horizontal or a vertical"),
        ("pull = 50.0", "pull = -50.0", "pull"),
        ('shape = "three_point"', 'shape = "four_point"', "shape"),
        ("# frequency = 5.0", "frequency = 5.0", "method"),
        ("pull = 50.0", 'pull = 50.0\nlaw = "iwann"', "macroslip.*iwan"),
        ("pull = 50.0", 'pull = 50.0\nlaw = "microslip"', "gaps must be above 0 with the law microslip"),
        ("pull = 50.0", "pull = 50.0\ngaps = 0.3", "gaps must be above 0 with the law microslip, and 0 with others"),
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
    assert plan.works[""].rig.laws[0].kn == pytest.approx(84e6)
    assert float(plan.works[""].rig.right.stiffness[1, 1]) == pytest.approx(30e6)
    assert plan.works[""].motion.harmonics[1, 2] == pytest.approx(30e-6)


def test_the_frequency_of_the_motion_in_radians_per_second(tmp_path):
    text = TEMPLATE.replace("[study]", 'units = { frequency = "rad/s" }\n\n[study]').replace("# method", "method")
    (tmp_path / "study.toml").write_text(text.replace("# frequency = 5.0", "frequency = 31.4"))
    (work,) = read(tmp_path / "study.toml").plan.works.values()
    assert work.frequency == pytest.approx(31.4 / (2.0 * np.pi), rel=1e-15)


def finished(study, out, *options):
    with pytest.raises(SystemExit) as end:
        main(["run", str(study), "--out", str(out), *options])
    assert not end.value.code
    return open_results(out / "results.nc")


@pytest.mark.slow
def test_every_steady_cycle_from_a_study(tmp_path, capsys):
    text = STARTS_TEMPLATE.replace("count = 20 ", "count = 6 ").replace("steps = 500 ", "steps = 100 ")
    (tmp_path / "study.toml").write_text(text)
    found = finished(tmp_path / "study.toml", tmp_path / "out", "--workers", "1", "--figures")
    python = steady_cycles(laboratory_damper(45.0, 50.0, (0.40, 0.22, 0.32)), out_of_phase(0.3e-6), starts=6, steps=100)
    np.testing.assert_allclose(found.loop_energy, [cycle.energy for cycle in python.cycles], rtol=1e-9)
    assert tuple(found.starts.values) == python.counts
    assert "steady cycles from 6 initial states" in capsys.readouterr().out
    assert (tmp_path / "out" / "figures" / "damper_cycles.png").stat().st_size > 10_000


@pytest.mark.usefixtures("unsaved_figures")
def test_an_evolution_from_a_study(tmp_path):
    (tmp_path / "study.toml").write_text(EVOLUTION_TEMPLATE.replace("steps = 500 ", "steps = 100 "))
    found = finished(tmp_path / "study.toml", tmp_path / "out")
    np.testing.assert_allclose(found.friction[:, 0], [0.3, 0.5, 0.7, 0.9, 1.1, 1.2])
    assert list(found.outcome.values) == 4 * ["not_steady"] + 2 * ["jammed"]
    assert float(found.loop_energy[3]) > 5.0 * float(found.loop_energy[-1])  # beyond the cone the damper wedges: a small loop
    (tmp_path / "wrong.toml").write_text(EVOLUTION_TEMPLATE.replace("[0.3, 0.5,", "[[0.3, 0.2], 0.5,"))
    with pytest.raises(InputError, match="friction must have 3 entries"):
        read(tmp_path / "wrong.toml")


def table(path, count=300, periods=1, header="time [ms],platform_x [um],platform_y [um]"):
    """So many periods of an ellipse at 5 Hz, with a third harmonic."""
    phase = np.arange(count) / count * periods
    angle = 2.0 * np.pi * phase
    rows = np.stack([200.0 * phase, 20.0 * np.sin(angle), 8.0 * np.cos(angle) + 0.5 * np.sin(3.0 * angle)], axis=1)
    np.savetxt(path, rows, delimiter=",", header=header, comments="", fmt="%.9g")


def measured_study(folder, more=""):
    text = TEMPLATE.replace("vertical = 30e-6 ", f'file = "cycle.csv"\n{more}\n# ')
    (folder / "study.toml").write_text(text.replace("steps = 1000 ", "steps = 300 "))
    return folder / "study.toml"


@pytest.mark.parametrize(("periods", "more"), [(1, ""), (4, "frequency = 5.0")])
def test_a_measured_motion_drives_the_damper(tmp_path, periods, more):
    table(tmp_path / "cycle.csv", 300 * periods, periods)
    motion = read(measured_study(tmp_path, more)).plan.works[""].motion
    angle = 2.0 * np.pi * np.arange(150) / 150
    expected = 1e-6 * np.stack([20.0 * np.sin(angle), 8.0 * np.cos(angle) + 0.5 * np.sin(3.0 * angle)], axis=1)
    np.testing.assert_allclose(motion.samples(150), expected, atol=1e-11)


@pytest.mark.usefixtures("unsaved_figures")
def test_a_changed_table_is_computed_anew(tmp_path):
    table(tmp_path / "cycle.csv")
    first = finished(measured_study(tmp_path), tmp_path / "out")
    table(tmp_path / "cycle.csv", header="time [ms],platform_y [um],platform_x [um]")
    with pytest.raises(SystemExit) as end:
        main(["run", str(tmp_path / "study.toml"), "--out", str(tmp_path / "out"), "--resume"])
    assert end.value.code == 2
    other = finished(tmp_path / "study.toml", tmp_path / "out", "--overwrite")
    assert float(other.loop_energy) != pytest.approx(float(first.loop_energy), rel=1e-3)


@pytest.mark.parametrize(
    ("change", "more", "message"),
    [
        (lambda path: table(path, 900, 3), "", "must be one period of the motion, but is '3 periods or so'"),
        (lambda path: table(path, 40), "", "must have more than 62 rows for 30 harmonics"),
        (lambda path: table(path, header="time [ms],a [um],b [um]"), "", "must hold platform_x or platform_y"),
        (lambda path: table(path, header="time [ms],platform_x,platform_y"), "", "must be stated"),
        (lambda path: path.write_text("time [s],platform_x [um]\n0.0,nan\n" * 20), "", "cycle.csv"),
        (lambda path: None, "", "must be a file"),
        (table, "horizontal = 1e-6", "must stand alone"),
    ],
)
def test_faults_of_a_measured_motion_are_said(tmp_path, change, more, message):
    change(tmp_path / "cycle.csv")
    with pytest.raises(InputError, match=message):
        read(measured_study(tmp_path, more))


def test_harmonics_of_no_file_are_refused(tmp_path):
    (tmp_path / "study.toml").write_text(TEMPLATE.replace("vertical = 30e-6 ", "harmonics = 9\nvertical = 30e-6 "))
    with pytest.raises(InputError, match="harmonics needs it"):
        read(tmp_path / "study.toml")


def test_a_cycle_without_dissipation_is_printed_as_one():
    """A cylinder whose contacts stick: rounding gave -2.5e-10 µJ and 5e-16 mrad."""
    rig = BetweenPlatforms.macroslip(Cylinder().damper(pull=60.0), 1e7, 1e7, 0.3)
    found = damper_cycle(rig, out_of_phase(1e-6), steps=200).dataset
    assert sentences(found)[0] == "0 µJ a cycle, rotation 0 mrad peak to peak"
    assert list(tables(found)["contacts"]["energy [µJ]"]) == [0.0, 0.0]
    slipping = damper_cycle(rig, out_of_phase(30e-6), steps=200).dataset
    assert sentences(slipping)[0].startswith(f"{1e6 * float(slipping.loop_energy):.4g} µJ a cycle")
