"""Answers of the explorer: those of `forced_response`, never out of order, with the sentences of `run` where a study is wrong."""

import threading

import numpy as np
import pytest

import stickslip as ss
from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.show.explorer.page import python_of
from stickslip.show.explorer.solving import OutdatedError, Solver, detail_figures
from stickslip.study.reading import job
from stickslip.study.templates import KINDS, write_new
from stickslip.support.checks import InputError

STUDY = """
[study]
analysis = "forced_response"
[structure]
rig = "blade_and_wedge"
[sweep]
frequency = [300.0, 370.0]
force_levels = [5.0]
harmonics = 5
samples = 64
"""


REFUSED = dict.fromkeys(
    ("contact_law", "damper_cycle", "damper_design", "damper_evolution", "identification", "steady_cycles"),
    "be of a problem, with a [sweep]",
) | dict.fromkeys(("campbell", "run_up", "speed_sweep"), "have a band, [sweep] frequency")
"""Templates that have no response over a band, and what the explorer says that they must."""


@pytest.fixture
def solver(tmp_path):
    path = tmp_path / "wedge.toml"
    path.write_text(STUDY)
    return Solver.of(path)


def test_a_fine_answer_is_that_of_forced_response(solver):
    answer = solver.answer({"pull": 80.0, "force_level": 4.0})
    expected = ss.forced_response(ss.rigs.blade_and_wedge(pull=80.0), ss.Band(300.0, 370.0), 4.0, 5, 64)
    for name in ("peak_frequency", "peak_amplitude"):
        found, known = (float(dataset[name][0, 0, 0]) for dataset in (answer.response.dataset, expected.dataset))
        assert found == pytest.approx(known, rel=1e-9)


def test_a_coarse_answer_has_few_harmonics_and_comes_near(solver):
    """Here the fifth harmonic moves the peak by 0.8 %."""
    coarse, fine = (solver.answer({}, output).response.dataset for output in (solver.outputs[0], None))
    assert int(coarse.attrs["harmonics"]) == 3
    assert float(coarse["peak_frequency"][0, 0, 0]) == pytest.approx(float(fine["peak_frequency"][0, 0, 0]), rel=2e-2)


def test_requests_that_a_newer_one_overtook_are_dropped(solver):
    """Five requests wait while the first one is solved: only the newest is answered; another tab is not concerned."""
    answered, dropped = [], []

    def request(version):
        solver.ask("one", version)
        try:
            solver.answer({"pull": 60.0 + version}, solver.outputs[0], "one", version)
            answered.append(version)
        except OutdatedError:
            dropped.append(version)

    threads = [threading.Thread(target=request, args=(version,)) for version in range(1, 6)]
    with solver.solving:
        for thread in threads:
            thread.start()
        while solver.newest.get("one") != 5:
            pass
    for thread in threads:
        thread.join()
    assert (answered, sorted(dropped)) == ([5], [1, 2, 3, 4])
    solver.ask("two", 1)
    assert solver.answer({}, solver.outputs[0], "two", 1).response.dataset.sizes["case"] == 1


def test_a_curve_under_way_ends_when_it_is_overtaken(solver, monkeypatch):
    """The progress report of the curve raises; nothing of it is kept."""
    asked = []

    def overtaken(tab, version):
        asked.append(version)
        if len(asked) > 2:
            raise OutdatedError

    monkeypatch.setattr(solver, "_refuse_outdated", overtaken)
    with pytest.raises(OutdatedError):
        solver.answer({"pull": 61.0}, None, "tab", 1)
    assert not solver.known


def test_an_older_number_does_not_become_the_newest(solver):
    solver.ask("one", 7)
    solver.ask("one", 3)
    assert solver.newest["one"] == 7


def test_a_wrong_value_gives_the_sentence_of_the_study(solver, tmp_path):
    with pytest.raises(InputError) as expected:
        job(STUDY.replace('"blade_and_wedge"', '"blade_and_wedge"\nparameters = { mu = -1.0 }'), tmp_path, "wedge")
    with pytest.raises(InputError) as found:
        solver.answer({"mu": -1.0})
    assert str(found.value) == str(expected.value)
    assert "mu" in str(found.value)


def test_the_saved_study_and_the_python_code_give_what_is_seen(solver, tmp_path):
    values = {"pull": 75.0, "mu": 0.35, "force_level": 6.0}
    shown = solver.answer(values).response.dataset
    saved = job(solver.study(values), tmp_path, "saved").sweep
    again = ForcedResponseWork.of(saved).solve(0, lambda fraction: None)
    names = {}
    exec(python_of(solver, values).replace("print(response.peaks())", ""), names)
    for peaks in (again["peak_frequency"], names["response"].dataset["peak_frequency"].values[0]):
        np.testing.assert_allclose(peaks[0, 0], shown["peak_frequency"].values[0, 0, 0], rtol=1e-9)


def test_code_for_a_study_without_a_rig_reads_the_saved_study(tmp_path, monkeypatch):
    path = tmp_path / "mass.toml"
    path.write_text("""
[study]
analysis = "forced_response"
[structure]
matrices = { M = [[1.0]], K = [[1.0]] }
dofs = ["m.x"]
[damping]
modal = 0.01
[[contact]]
law = "macroslip"
between = ["m.x", "ground"]
kt = 1.0
mu = 0.5
normal_load = 1.0
[[force]]
direction = "m.x"
amplitude = 1.0
[sweep]
frequency = [0.1, 0.3]
outputs = ["m.x"]
samples = 64
""")
    solver, values = Solver.of(path), {"kt": 0.8}
    monkeypatch.chdir(tmp_path)
    (tmp_path / "explored.toml").write_text(solver.study(values))
    names = {}
    exec(python_of(solver, values).replace("print(response.peaks())", ""), names)
    shown = solver.answer(values).response.dataset
    np.testing.assert_allclose(names["response"].dataset["peak_frequency"], shown["peak_frequency"], rtol=1e-9)


OPENED_ON_EVERY_CHANGE = {"forced_response", "nonlinear_modes", "blisk"}
"""A problem of a rig, modes, and a disk."""


@pytest.mark.parametrize(
    "kind",
    [
        kind if kind in OPENED_ON_EVERY_CHANGE else pytest.param(kind, marks=pytest.mark.nightly)
        for kind in sorted(set(KINDS) - REFUSED.keys())
    ],
)
def test_every_template_of_a_problem_opens_and_shows_its_peak_in_detail(kind, tmp_path):
    """Curve, point in detail, saved study and code, of the problem as the template states it."""
    write_new(kind, tmp_path / "study.toml")
    solver = Solver.of(tmp_path / "study.toml")
    answer = solver.answer({}, solver.outputs[0])
    assert answer.sentences == ()
    point = int(np.nanargmax(answer.response.dataset["amplitude"].values[0, :, 0]))
    assert len(detail_figures(answer, point, solver.outputs[0], False, False)) >= 1
    own, saved = (job(text, tmp_path, "study").sweep.problem for text in (solver.text, solver.study({})))
    assert saved.fingerprint == own.fingerprint
    compile(python_of(solver, {}), "code", "exec")


@pytest.mark.parametrize("kind", sorted(REFUSED))
def test_templates_without_a_response_over_a_band_are_refused_in_a_sentence(kind, tmp_path):
    write_new(kind, tmp_path / "study.toml")
    with pytest.raises(InputError) as found:
        Solver.of(tmp_path / "study.toml")
    assert str(found.value) == (
        f"The study of the explorer must {REFUSED[kind]}, but is {kind!r}. "
        "Explore a forced response: `stickslip new forced_response` writes one."
    )


def test_a_disk_is_explored_and_its_first_curve_is_that_of_forced_response(tmp_path):
    path = tmp_path / "disk.toml"
    path.write_text("""
[study]
analysis = "forced_response"
[structure]
rig = "lumped_blisk"
parameters = { case = "W", engine_order = 2, sectors = 6 }
[sweep]
frequency = [120.0, 180.0]
force_levels = [0.4]
harmonics = 3
samples = 64
""")
    solver = Solver.of(path)
    assert "force_level" in [slider.name for slider in solver.sliders]
    assert len(solver.sliders) > 1
    disk = ss.rigs.lumped_blisk("W", engine_order=2, sectors=6)
    expected = ss.forced_response(disk, ss.Band(120.0, 180.0), 0.4, 3, 64).dataset
    shown = solver.answer({}).response.dataset
    assert int(np.isfinite(expected["peak_frequency"]).sum()) > 0
    for name in ("peak_frequency", "peak_amplitude"):
        np.testing.assert_allclose(shown[name], expected[name], rtol=1e-9)


@pytest.fixture(scope="module")
def two_blades(tmp_path_factory):
    """The `lumped` template: its band, 145 to 235 Hz, leaves out the lowest mode, at 85 Hz."""
    path = tmp_path_factory.mktemp("lumped") / "study.toml"
    write_new("lumped", path)
    return Solver.of(path)


@pytest.mark.parametrize("output", ["2.y", "1.y"])
def test_the_performance_curve_keeps_to_band_and_output_of_the_study(two_blades, output):
    """At the ratio of the study the highest peak is that of its coarse response, of the same output. The frequency of a
    performance curve is the middle of the band within 0.1 % of the peak, so that it may lie a little beside it."""
    ratio = 120.0 / 20.0
    curve, said = two_blades.performance({"force_level": 1.0}, [ratio, 1.1 * ratio], output)
    response = two_blades.answer({"force_level": 1.0}, output).response.dataset
    assert 145.0 < float(curve.dataset["frequency"][0, 0]) < 235.0
    assert float(curve.dataset["frequency"][0, 0]) == pytest.approx(float(response["peak_frequency"][0, 0, 0]), rel=1e-3)
    per_force = float(response["peak_amplitude"][0, 0, 0]) / 20.0
    assert float(curve.dataset["amplitude_per_force"][0, 0]) == pytest.approx(per_force, rel=1e-3)
    assert said.startswith(f"Coarse settings for {output}: 3 harmonics, 64 samples")


@pytest.mark.parametrize("view", ["coarse", "performance"])
def test_views_take_quantity_and_measure_of_the_study(tmp_path, view):
    path = tmp_path / "study.toml"
    path.write_text(STUDY.replace("samples = 64", 'samples = 64\nquantity = "acceleration"\nmeasure = "rms"'))
    solver = Solver.of(path)
    if view == "coarse":
        attrs = solver.answer({}, solver.outputs[0]).response.dataset.attrs
    else:
        attrs = solver.performance({}, [20.0, 22.0], solver.outputs[0])[0].dataset.attrs
    assert (attrs["quantity"], attrs["measure"]) == ("acceleration", "rms")


def test_coarse_views_take_harmonics_of_a_list(tmp_path):
    """A list stays one, without what is left out of it."""
    path = tmp_path / "study.toml"
    path.write_text(STUDY.replace("harmonics = 5", "harmonics = [0, 1, 3, 5]"))
    solver = Solver.of(path)
    assert solver.answer({}, solver.outputs[0]).response.dataset.attrs["harmonics"] == "0, 1, 3"


def test_tables_that_no_view_computes_are_named(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(STUDY + "[stability]\n")
    answer = Solver.of(path).answer({})
    assert any(sentence.startswith("The explorer leaves out [stability];") for sentence in answer.sentences)


def test_the_code_has_the_tolerances_of_the_study(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(STUDY.replace("samples = 64", 'samples = 64\noutputs = ["C.y"]\npeak_tolerance = 1e-5\ntolerance = 0.01'))
    (tmp_path / "other").mkdir()
    outputs = Solver.of(path).outputs if False else None
    assert outputs is None
