"""Steps of the static load in a study."""

import numpy as np
import pytest
from study.test_many_contacts_study import SWEEP, from_mesh  # noqa: F401
from study.test_rotation_study import PULL, ROTATION
from study.test_surfaces_study import folder  # noqa: F401
from typer.testing import CliRunner

import stickslip as ss
from stickslip.cli import app
from stickslip.study import job, read
from stickslip.study.templates import write_new

STEPS = "\n[[load_step]]\nfactor = 2.5\n\n[[load_step]]\nfactor = 0.5\n"


def places(problem):
    return np.concatenate([start.values(1) for contact in problem.contacts for start in contact.starts])


def test_sliders_of_a_study_are_those_of_python_and_are_said(folder):  # noqa: F811
    (folder / "steps.toml").write_text(SWEEP + STEPS)
    result = CliRunner().invoke(app, ["check", str(folder / "steps.toml")])
    assert result.exit_code == 0, result.output
    (head,) = [
        place for place, line in enumerate(result.output.splitlines()) if line.startswith("Contacts at rest after each step")
    ]
    rows = [line.split() for line in result.output.splitlines()[head + 1 : head + 6]]
    assert rows[0][:4] == ["load", "surface", "contacts", "open"]
    assert [row[:3] for row in rows[1:]] == [["step", step, name] for step in "12" for name in ("L", "contact")]
    before, after = (job(text, folder, "steps").sweep.problem for text in (SWEEP, SWEEP + STEPS))
    found = places(after)
    assert np.any(found)
    np.testing.assert_array_equal(found, places(ss.after_load_steps(before, [2.5, 0.5])))


def test_sliders_of_a_mesh_are_those_of_kept_rows(folder, from_mesh, monkeypatch):  # noqa: F811
    (folder / "mesh_steps.toml").write_text(SWEEP + STEPS)
    mesh = read(folder / "mesh_steps.toml").sweep.problem
    assert mesh.mesh is not None
    monkeypatch.undo()
    (folder / "mesh_steps.toml").write_text(SWEEP.replace("modes = 6", "modes = 60") + STEPS)
    rows = read(folder / "mesh_steps.toml").sweep.problem
    assert rows.mesh is None
    np.testing.assert_allclose(places(mesh), places(rows), atol=3e-3 * np.abs(places(rows)).max())


def test_a_step_states_what_the_tables_state(folder):  # noqa: F811
    """Preloads of whole surfaces, shared by area, the pull on a body and a named force, in the units of the file."""
    text = (
        SWEEP.replace("mu = 0.4", "mu = 0.4\npreload = 5.0")
        + '[[force]]\nname = "push"\ndirection = "left/tip.y"\nstatic = 2.0\n'
    )
    step = """[[load_step]]
factor = 1.5
preload = { L = 12.0, "contact 2" = 8.0 }
gap = { L = 1e-4 }
pull = { damper = [3.0, 80.0, 0.0] }
static = { push = 7.0 }
"""
    before, after = (job(each, folder, "stated").sweep.problem for each in (text, text + step))
    pull = [force.name for force in before.forces if force.static and force.name.startswith("pull")]
    assert pull == ["pull on damper along y"]
    across = ss.Force("damper/centre.x", name="across")
    python = ss.LoadStep(1.5, {"push": 7.0, pull[0]: 80.0, "across": 3.0}, {"L": 12.0, "contact 2": 8.0}, {"L": 1e-7})
    expected = ss.after_load_steps(before.with_forces([*before.forces, across]), [python])
    np.testing.assert_allclose(places(after), places(expected), atol=1e-12)
    assert np.abs(places(after) - places(ss.after_load_steps(before, [1.5]))).max() > 1e-7
    assert after.forces == before.forces
    assert [contact.law for contact in after.contacts] == [contact.law for contact in before.contacts]


@pytest.mark.slow
def test_a_pull_before_changes_a_peak_where_contacts_stick_in_part(tmp_path):
    """Two blades and a wedge under 1 N: three times the pull before, +3 % and −1.2 Hz; 1.44 times, nothing."""
    write_new("two_blades", tmp_path / "study.toml")
    problem = job((tmp_path / "study.toml").read_text(), tmp_path, "study").sweep.problem

    def peak(problem):
        return ss.forced_response(problem, ss.hertz(395, 405), 1.0, harmonics=5, samples=128).peaks().iloc[0]

    never, little, much = peak(problem), *(peak(ss.after_load_steps(problem, [factor])) for factor in (1.44, 3.0))
    assert little.amplitude == pytest.approx(never.amplitude, rel=1e-6)
    assert much.amplitude / never.amplitude - 1.0 == pytest.approx(0.03, abs=0.005)
    assert much.frequency - never.frequency == pytest.approx(-1.2, abs=0.1)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[[load_step]]\nspeed = 3000.0", "speed = 3000 needs [rotation]"),
        ("[[load_step]]\nfactor = 1.2\nspeed = 3000.0", "factor and speed must not be given together"),
        ("[[load_step]]\nfactor = 0.0", "No state of rest was found under the static load of step 1"),
        ("[load_step]\nfactor = 1.2", "must be written with double brackets"),
        ("[[load_step]]\npreload = { M = 3.0 }", "preload must name contacts, but is 'M'"),
        ("[[load_step]]\nnormal_load = { L = -3.0 }", "normal_load"),
        ("[[load_step]]\nnormal_load = { L = 3.0 }", "the Macroslip of L has no normal_load here. A step may state its preload"),
        ("[[load_step]]\ngap = { L = nan }", "gap"),
        ("[[load_step]]\npreload = 3.0", "preload must be a table, but is 3.0"),
        ("[[load_step]]\npull = { dampr = [0.0, 1.0, 0.0] }", "'dampr/centre.x' does not exist"),
        ("[[load_step]]\npull = { damper = 3.0 }", "pull, damper must be a list, but is 3.0"),
        ("[[load_step]]\nstatic = { push = 3.0 }", "static must name single forces, but is 'push'"),
        ("[[load_step]]\npull = { damper = [0.0, -10.0, 0.0] }", "No state of rest was found under the static load of step 1"),
    ],
)
def test_steps_that_are_none_are_refused(folder, text, said):  # noqa: F811
    (folder / "wrong.toml").write_text(f"{SWEEP}\n{text}\n")
    result = CliRunner().invoke(app, ["check", str(folder / "wrong.toml")])
    assert result.exit_code != 0
    assert said in " ".join(result.output.split())


def test_an_analysis_that_does_not_begin_there_refuses_them(folder):  # noqa: F811
    text = SWEEP.replace('analysis = "forced_response"', 'analysis = "response_samples"') + STEPS
    (folder / "samples.toml").write_text(text + "\n[response_samples]\ncount = 3\n")
    result = CliRunner().invoke(app, ["check", str(folder / "samples.toml")])
    assert "Load steps need analysis = forced_response or stepped_sine" in " ".join(result.output.split())


def test_the_speed_before_counts_by_its_square(folder):  # noqa: F811
    """A run at 1.2 times the speed loads as 1.44 times the load of the rotation does, at the feet of blades and on the damper."""
    turning = SWEEP.replace(PULL, "") + ROTATION
    by_speed, by_factor = (
        places(job(turning + f"[[load_step]]\n{step}\n", folder, "turning").sweep.problem)
        for step in ("speed = 3600.0", "factor = 1.44")
    )
    assert np.any(by_speed)
    np.testing.assert_allclose(by_speed, by_factor, atol=1e-12 * np.abs(by_factor).max())
