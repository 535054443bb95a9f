"""A study of blades with many contact nodes, of which no row is kept, against the same with kept rows and many modes."""

import numpy as np
import pytest
from study.test_surfaces_study import STUDY, folder  # noqa: F401
from typer.testing import CliRunner

import stickslip as ss
from stickslip.cli import app
from stickslip.model.contact.point import SliderOffset
from stickslip.results.files import open_results
from stickslip.solve.continuation.continuation import first_point, trace
from stickslip.study import read, run_time, structure
from stickslip.support import machine

SWEEP = STUDY.replace('"iwan"', '"macroslip"').replace(
    "frequency = [400.0, 700.0]", "frequency = [480.0, 620.0]\nforce_levels = [0.3, 1.0]\nharmonics = 3"
)
SWEEP += '[[mean_spring]]\ndirection = { "damper/centre.z" = 1.0 }\nk = 40.0\n'


@pytest.fixture
def from_mesh(monkeypatch):
    """The models of the test are small, with few contacts."""
    monkeypatch.setattr(structure, "WHOLE_SIZE", 300)
    monkeypatch.setattr(structure, "MANY_KEPT", 20)


def with_offsets(problem, values):
    """The problem with the sliders of all friction elements at given offsets, m."""
    offsets = iter(values.tolist())
    return problem.with_contacts(
        lambda each: each.with_start(tuple(SliderOffset(np.array([next(offsets)])) for _ in each.starts))
    )


def run(folder, name, text, *more):  # noqa: F811
    (folder / f"{name}.toml").write_text(text)
    return CliRunner().invoke(app, ["run", str(folder / f"{name}.toml"), "--out", str(folder / name), *more])


@pytest.mark.slow
def test_a_run_from_the_mesh(folder, from_mesh, monkeypatch):  # noqa: F811
    """Peaks, deformed shapes and report; a run that is resumed, and results that a problem read anew solves."""
    result = run(folder, "mesh", SWEEP, "--workers", "1")
    assert result.exit_code == 0, result.output
    assert "modes = 6 has no effect" in result.output
    assert "shapes of rigid motions, loads, outputs and the contact forces at the highest peaks" in result.output
    data = open_results(folder / "mesh" / "results.nc")
    anew = ss.ForcedResponse(data, ss.read_problem(folder / "mesh.toml"))
    shape = anew.deformed_shape(1).motion.displacement
    assert np.abs(data.modal_error.values).max() < 1e-3
    monkeypatch.undo()
    result = run(folder, "rows", SWEEP.replace("modes = 6", "modes = 60"), "--workers", "1")
    assert result.exit_code == 0, result.output
    rows = open_results(folder / "rows" / "results.nc")
    assert "shape_force" not in rows
    for name, within in (("peak_frequency", 2e-4), ("peak_amplitude", 1e-3)):
        assert data[name].values[:, 0] == pytest.approx(rows[name].values[:, 0], rel=within, nan_ok=True)
    kept = ss.ForcedResponse(rows, ss.read_problem(folder / "rows.toml")).deformed_shape(1).motion.displacement
    assert np.abs(shape - kept).max() < 1e-3 * np.abs(kept).max()


def test_a_check_from_the_mesh_says_what_one_with_rows_says(folder, from_mesh, monkeypatch):  # noqa: F811
    (folder / "check.toml").write_text(SWEEP)
    job = read(folder / "check.toml")
    assert job.sweep.problem.mesh is not None
    assert f"{job.sweep.problem.freedoms} degrees of freedom" in job.plan.summary
    monkeypatch.undo()
    (folder / "check.toml").write_text(SWEEP.replace("modes = 6", "modes = 60"))
    whole = read(folder / "check.toml")
    assert whole.sweep.problem.mesh is None
    for stuck in (True, False):
        assert job.sweep.problem.frequencies(stuck)[:8] == pytest.approx(whole.sweep.problem.frequencies(stuck)[:8], rel=1e-3)
    warned = [{note for note in each.notes if note.startswith("Warning")} for each in (job, whole)]
    assert warned[0] == warned[1]


def test_memory_of_a_run_is_said_and_refused_where_the_machine_has_less(folder, from_mesh, monkeypatch):  # noqa: F811
    """Of a point count the arrays that a solved one keeps, and those of results; a second process takes the model again."""
    (folder / "check.toml").write_text(SWEEP)
    job, taken = read(folder / "check.toml"), 3 << 30
    balance = job.plan.works[""].balance
    point = next(trace(balance, first_point(balance, 3200.0, 0.3), "omega", 3300.0))
    state, metric = point.evaluation.state, point.metric
    rows, columns = state.residual.shape
    arrays = {id(a): a.nbytes for a in (*state[:-1], *point.tangent[:2], metric.weight) if a.shape[1:] == (columns,)}
    assert sum(arrays.values()) == pytest.approx(run_time.KEPT * 8 * rows * columns, rel=0.05)
    assert state.own.size + state.by_omega.size == 0
    monkeypatch.setattr(machine, "taken", lambda: taken)
    monkeypatch.setattr(machine, "memory", lambda: 5 << 30)
    whole = taken + run_time.POINTS * (run_time.KEPT + run_time.RESULTING * 2) * 8 * rows * columns
    assert run_time.run_memory(job) == f"It takes about {whole / 2**30:.2g} GiB of memory in 1 process."
    with pytest.raises(ss.InputError, match=r"contact rows .* in 2 processes must fit into 5 GiB, but is '6 GiB'.* --workers"):
        run_time.run_memory(job, 8)


@pytest.mark.parametrize(
    "change",
    [
        ("\n[damping]\nmodal = 0.002", '\n[damping]\nmodal = 0.002\non = "free"'),
        ('analysis = "forced_response"', 'analysis = "controlled_response"'),
        ('surface = "left/PLATR"', 'points = 3\nsurface = "left/PLATR"'),
    ],
)
def test_rows_are_kept_where_they_are_needed(folder, from_mesh, change):  # noqa: F811
    text = SWEEP.replace(*change)
    if "controlled" in change[1]:
        text = text.replace("force_levels = [0.3, 1.0]\n", "") + "[controlled_response]\namplitude = [0.01]\n"
    if "points" in change[1]:
        text = text.replace('surface = "right/PLATL"', 'points = 3\nsurface = "right/PLATL"')
    (folder / "other.toml").write_text(text)
    assert read(folder / "other.toml").sweep.problem.mesh is None


@pytest.mark.slow
def test_a_performance_curve_from_the_mesh(folder, from_mesh, monkeypatch):  # noqa: F811
    """Against the same with kept rows and ten times the modes: peaks within the error that is said, and no row kept."""
    text = SWEEP.replace('analysis = "forced_response"', 'analysis = "performance_curve"').replace(
        "force_levels = [0.3, 1.0]\n", ""
    )
    text += "[performance_curve]\nforce_ratio = [80.0, 300.0]\npoints = 3\npull = 60.0\nfriction = [0.3, 0.5]\n"
    result = run(folder, "curve", text, "--workers", "1")
    assert result.exit_code == 0, result.output
    data = open_results(folder / "curve" / "results.nc")
    checked = np.isfinite(data.modal_error.values)
    assert checked[:, [0, -1]].all()
    assert np.nanmax(np.abs(data.modal_error.values)) < 1e-3
    assert (
        "solved again on the mesh with all shapes of its contact forces and their inertia, the peaks at F_C/F_E = 80"
        in result.output
    )
    monkeypatch.undo()
    result = run(folder, "curve_rows", text.replace("modes = 6", "modes = 60"), "--workers", "1")
    assert result.exit_code == 0, result.output
    rows = open_results(folder / "curve_rows" / "results.nc")
    assert "modal_error" not in rows
    for name, within in (("frequency", 2e-4), ("amplitude_per_force", 1e-3), ("optimum_amplitude_per_force", 1e-3)):
        assert data[name].values == pytest.approx(rows[name].values, rel=within)


def test_other_analyses_need_the_shapes_of_a_forced_response(folder, from_mesh):  # noqa: F811
    (folder / "mesh.toml").write_text(SWEEP)
    problem = ss.read_problem(folder / "mesh.toml")
    with pytest.raises(ss.InputError, match=r"shapes of its contact forces, .* Give `forced_response\(...\).problem`"):
        ss.response_samples(problem, [550.0], 1.0)
    with pytest.raises(ss.InputError, match="must have a row for each direction of its contacts"):
        ss.controlled_response(problem, ss.hertz(500.0, 600.0), 1e-5)


@pytest.mark.slow
def test_start_states_from_the_mesh(folder, from_mesh, monkeypatch):  # noqa: F811
    """The same start states with kept rows: the coordinates are those of peaks of sliders that start where they are assembled."""
    text = SWEEP.replace('analysis = "forced_response"', 'analysis = "response_samples"').replace("[0.3, 1.0]", "[1.0]")
    text = text.replace("frequency = [480.0, 620.0]", "at = [540.0]") + '[response_samples]\ncount = 4\nshare = "contact"\n'
    result = run(folder, "samples", text, "--workers", "1")
    assert result.exit_code == 0, result.output
    assert "Solved again on the mesh with all shapes of its contact forces and their inertia" in result.output
    data = open_results(folder / "samples" / "results.nc")
    assert data.modal_error.sizes == {"case": 4, "output": 2}
    assert 0.0 < np.abs(data.modal_error.values).max() < 4e-3
    monkeypatch.undo()
    (folder / "rows.toml").write_text(text.replace("modes = 6", "modes = 60"))
    rows = ss.read_problem(folder / "rows.toml")
    assert rows.mesh is None
    starts = data.start_variable.values
    again = ss.response_samples(rows, [540.0], 1.0, starts=starts, share="contact", harmonics=3).dataset.amplitude.values
    assert np.ptp(again[..., 0]) > 0.01 * again[..., 0].max()
    corrected = data.amplitude.values * (1.0 + data.modal_error.values[:, None, :])
    assert corrected == pytest.approx(again, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("objective", "where", "within"), [("amplitude", "at = [540.0]", 1e-4), ("peak", "frequency = [480.0, 560.0]", 1e-3)]
)
def test_bounds_from_the_mesh(folder, from_mesh, monkeypatch, objective, where, within):  # noqa: F811
    """The start state of each bound gives with kept rows and ten times the modes what is said of it; with a finer goal the search
    goes on with the shapes of the contact forces at the bounds, whose error was 3.5e-4 at 540 Hz."""
    monkeypatch.setattr("stickslip.analyses.variability.bounds.SETTLED", within)
    text = SWEEP.replace('analysis = "forced_response"', 'analysis = "response_bounds"').replace("[0.3, 1.0]", "[1.0]")
    text += f'[response_bounds]\nobjective = "{objective}"\ncloud = 4\nstarts = 1\n'
    text = text.replace("frequency = [480.0, 620.0]", where)
    result = run(folder, objective, text, "--workers", "1")
    assert result.exit_code == 0, result.output
    data = open_results(folder / objective / "results.nc")
    bounds, errors = data.bounds_amplitude.values[0, :, 0], np.abs(data.bounds_modal_error.values[0, :, 0])
    assert errors.max() < within
    assert (bounds[0] < 0.5 * bounds[1]) == (objective == "amplitude")
    monkeypatch.undo()
    (folder / "rows.toml").write_text(text.replace("modes = 6", "modes = 60"))
    rows = ss.read_problem(folder / "rows.toml")
    assert rows.mesh is None
    for bound, values, frequency in zip(
        bounds, data.bounds_start_value.values[0, :, 0], data.bounds_resonance.values[0, :, 0], strict=True
    ):
        found = ss.forced_response(with_offsets(rows, values), [frequency], 1.0, harmonics=3, samples=256)
        assert found.dataset.amplitude.values.ravel()[0] == pytest.approx(bound, rel=within + 5e-4)
