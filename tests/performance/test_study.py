"""Studies of performance curves and of damper design: read, planned, refused where wrong."""

import pytest

import stickslip as ss
from stickslip.checks import InputError
from stickslip.report.presentation import presentation_of
from stickslip.results import open_results, save, stamped
from stickslip.study import read
from stickslip.study.templates import write_new


def changed(tmp_path, kind: str, before: str, after: str):
    write_new(kind, tmp_path / "study.toml", overwrite=True)
    text = (tmp_path / "study.toml").read_text()
    assert before in text
    (tmp_path / "study.toml").write_text(text.replace(before, after))
    return tmp_path / "study.toml"


def test_plan_of_performance_curves(tmp_path):
    work = read(changed(tmp_path, "performance", "points = 30", "points = 5")).plan.works[""]
    assert work.frictions == (0.2, 0.4)
    assert len(work.ratios) == 5
    assert work.ratios[-1] == pytest.approx(100.0)
    assert work.band == (280.0, 390.0)


def test_plan_of_a_design(tmp_path):
    work = read(changed(tmp_path, "design", "designs = 8", "designs = 4")).plan.works[""]
    assert work.variables == ("damper_mass", "platform_angle")
    assert work.limits == ("no jamming", "no lift-off")
    problem = work.problem_of(friction=0.3, damper_mass=0.05, platform_angle=30.0)
    assert sum(force.static for force in problem.forces) == pytest.approx(150.0)
    assert {contact.law.mu for contact in problem.contacts} == {0.3}


@pytest.mark.parametrize(
    ("kind", "before", "after", "words"),
    [
        ("performance", "[3.0, 100.0]", "[100.0, 3.0]", "low below high"),
        ("performance", "frequency = [280.0, 390.0]", "at = [300.0]", "must have a band"),
        ("performance", 'vary = "force"', 'vary = "mass"', "vary"),
        ("design", 'rig = "blade_and_wedge"', 'rig = "blade_and_wedg"', "Did you mean 'blade_and_wedge'"),
        ("design", "damper_mass = [0.02, 0.1]", "damper_mas = [0.02, 0.1]", "Did you mean 'damper_mass'"),
        ("design", "[15.0, 60.0]", "[60.0, 15.0]", "low below high"),
        ("design", 'no_jamming = "platform_angle"', 'no_jamming = "kt"', "must name a variable"),
    ],
)
def test_faults_of_studies_are_said(tmp_path, kind, before, after, words):
    with pytest.raises(InputError, match=words):
        read(changed(tmp_path, kind, before, after))


def test_performance_curves_are_told_after_a_round_trip_to_disk(tmp_path):
    curve = ss.performance_curve(ss.rigs.single_mass(kt=0.5), [0.8, 1.5, 4.0, 90.0], friction=[0.5, 1.0], harmonics=1, samples=64)
    path = save(stamped(curve.dataset, "performance_curve"), tmp_path / "results.nc")
    told = presentation_of(dataset := open_results(path))
    assert "friction 0.5: lowest resonance" in told.sentences(dataset)[0]
    assert told.failures(dataset) == []
    assert len(told.tables(dataset)["performance curves"]) == 8
    assert {name: len(draw(dataset).axes) for name, draw in told.figures(dataset).items()} == {
        "performance_curve": 3,
        "performance_inertance": 3,
        "dissipation": 1,
    }


def test_a_design_is_told_after_a_round_trip_to_disk(tmp_path):
    def mass(*, friction: float, load: float) -> ss.Problem:
        return ss.rigs.single_mass(damping=0.01, kt=0.5, limit=load * friction)

    effort = {"levels": 1, "starts": 0, "designs": 4, "refinements": 2, "harmonics": 1, "samples": 64}
    limits = {"load": lambda trial: 1.0 - trial.variables["load"] / 6.0}
    design = ss.design_damper(mass, {"load": (1.0, 8.0)}, (1.0, 1.0), 0.4, constraints=limits, **effort)
    path = save(stamped(design.dataset, "damper_design"), tmp_path / "results.nc")
    told = presentation_of(dataset := open_results(path))
    assert "worst resonance of the best design" in told.sentences(dataset)[0]
    assert len(told.tables(dataset)["designs"]) == dataset.sizes["design"]
    assert told.figures(dataset)["design_space"](dataset).axes
