"""Studies of performance curves, their band, what matters, and damper design: read, planned, refused where wrong, reported."""

import numpy as np
import pytest
from typer.testing import CliRunner

import stickslip as ss
from stickslip.cli import app
from stickslip.results.files import open_results, save, stamped
from stickslip.show.report.markup import presentation_of
from stickslip.study import read
from stickslip.study.analyses.damper_design import RigDesign
from stickslip.study.templates import write_new
from stickslip.support import console
from stickslip.support.checks import InputError


def changed(tmp_path, kind: str, before: str, after: str):
    write_new(kind, tmp_path / "study.toml", overwrite=True)
    text = (tmp_path / "study.toml").read_text()
    assert before in text
    (tmp_path / "study.toml").write_text(text.replace(before, after))
    return tmp_path / "study.toml"


def test_plan_of_performance_curves(tmp_path):
    work = read(changed(tmp_path, "performance_curve", "points = 30", "points = 5")).plan.works[""]
    assert work.frictions == (0.2, 0.4)
    assert len(work.ratios) == 5
    assert work.ratios[-1] == pytest.approx(100.0)
    assert work.band == ss.hertz(280.0, 390.0)


def test_plan_of_a_design(tmp_path):
    work = read(changed(tmp_path, "damper_design", "designs = 8", "designs = 4")).plan.works[""]
    assert work.variables == ("damper_mass", "platform_angle")
    assert work.limits == ("no jamming", "no lift-off")
    problem = work.problem_of(friction=0.3, damper_mass=0.05, platform_angle=30.0)
    assert sum(force.static for force in problem.forces) == pytest.approx(150.0)
    assert {contact.law.mu for contact in problem.contacts} == {0.3}


def test_the_pull_of_a_design_follows_the_damper_mass_whatever_the_rig_calls_it():
    """The two dampers of the single blade are pulled by dead weights, given in kg."""
    stiffness = {"flat_kt": 25e6, "flat_kn": 65e6, "flat_mu": 0.6, "cylinder_kt": 45e6, "cylinder_kn": 260e6, "cylinder_mu": 0.4}
    small = {"modes": 10, "flat_points": 4, "cylinder_elements": 1}
    problem = RigDesign("single_blade", stiffness | small, acceleration=900.0)(friction=0.3, damper_mass=0.06)
    assert [abs(force.static) for force in problem.forces if force.static] == pytest.approx([54.0, 54.0])
    assert {contact.law.mu for contact in problem.contacts} == {0.3}


@pytest.mark.nightly
@pytest.mark.usefixtures("unsaved_figures")
def test_a_design_study_without_an_allowed_design_is_written_and_reported(tmp_path):
    """The command ends with the code of an incomplete result and keeps every design."""
    study = changed(tmp_path, "damper_design", "no_lift_off = true", "largest_force = 1e-6")
    for long, short in (("designs = 8", "designs = 4"), ("refinements = 8", "refinements = 2"), ("starts = 1", "starts = 0")):
        study.write_text(study.read_text().replace(long, short))
    found = CliRunner().invoke(app, ["run", str(study), "--out", str(tmp_path / "out")])
    assert found.exit_code == console.INCOMPLETE, found.output
    assert "must meet all constraints, but none does" in found.output
    assert open_results(tmp_path / "out" / "results.nc").sizes["design"] >= 4
    assert (tmp_path / "out" / "report.html").exists()


def test_plan_of_a_band(tmp_path):
    """F_C/F_E from 3 to 100 at a pull of 60 N and 1 N of excitation at level one."""
    work = read(changed(tmp_path, "performance_band", "points = 6", "points = 2")).plan.works[""]
    assert work.levels == pytest.approx((20.0, 0.6))
    assert (work.objective, work.share, work.band) == ("peak", "contact", ss.hertz(280.0, 390.0))


def test_plan_of_what_matters(tmp_path):
    """64 draws of five ranges are 7 × 64 problems; a corner of the ranges is the problem with its contacts changed."""
    plan = read(changed(tmp_path, "sensitivity_indices", "slider_offset = [-1e-4, 1e-4]", "slider_offset = [-1e-5, 2e-5]")).plan
    work = plan.works[""]
    assert work.points().shape == (64, 7, 5)
    assert "448 problems" in plan.summary
    nominal, corner = work.problem_of.problem, work.problem(np.array([0.75, 1.25, 1.4, 1.1, 2e-5]))
    for before, after in zip(nominal.contacts, corner.contacts, strict=True):
        assert after.law.kt == pytest.approx(0.75 * before.law.kt)
        assert after.law.kn == pytest.approx(1.25 * before.law.kn)
        assert after.law.mu == pytest.approx(1.4 * before.law.mu)
        assert after.starts == (ss.SliderOffset(2e-5),)
    assert sum(force.static for force in corner.forces) == pytest.approx(66.0)


@pytest.mark.parametrize(
    ("kind", "before", "after", "words"),
    [
        ("performance_band", "[3.0, 100.0]", "[100.0, 3.0]", "low below high"),
        ("performance_band", "frequency = [280.0, 390.0]", "at = [300.0]", "must have a band"),
        ("performance_band", 'share = "contact"', 'share = "side"', "share"),
        ("sensitivity_indices", "draws = 64", "draws = 48", "draws must be a power of two"),
        ("sensitivity_indices", "mu = [0.7, 1.4]", "mu = [1.4, 0.7]", "low below high"),
        ("sensitivity_indices", "mu = [0.7, 1.4]", "muu = [0.7, 1.4]", "Did you mean 'mu'"),
        ("sensitivity_indices", "force_levels = [1.0]", "force_levels = [1.0, 2.0]", "force_levels must be one"),
        ("performance_curve", "[3.0, 100.0]", "[100.0, 3.0]", "low below high"),
        ("performance_curve", "frequency = [280.0, 390.0]", "at = [300.0]", "must have a band"),
        ("performance_curve", 'vary = "force"', 'vary = "mass"', "vary"),
        (
            "performance_curve",
            "friction = [0.2, 0.4]",
            "friction = [0.2, 0.2]",
            "friction must be unique, but 0.2 is given more than once",
        ),
        ("performance_curve", "friction = [0.2, 0.4]", "friction = [0.0]", "friction"),
        (
            "performance_curve",
            "harmonics = 5",
            "force_levels = [1, 2]",
            "force_levels must be left out, since it has no effect on this analysis",
        ),
        ("performance_band", "harmonics = 3", "force_levels = [2]", "force_levels must be left out"),
        ("damper_design", "kt = 8e5", "damper_mass = 0.1", "must not be among the parameters, which stay, but is 0.1"),
        (
            "damper_design",
            "platform_angle = [15.0, 60.0]",
            "platform_angle = [15.0, 120.0]",
            "between 0 and 90 degrees, but is 120",
        ),
        ("damper_design", "force = [5.0, 20.0]", "force = [5.0, 5.0]", "levels must be 1 where both ends of force are the same"),
        ("damper_design", "levels = 2", "levels = 1", "levels must be 1 where both ends"),
        ("damper_design", 'rig = "blade_and_wedge"', 'rig = "blade_and_wedg"', "Did you mean 'blade_and_wedge'"),
        ("damper_design", "damper_mass = [0.02, 0.1]", "damper_mas = [0.02, 0.1]", "Did you mean 'damper_mass'"),
        ("damper_design", "[15.0, 60.0]", "[60.0, 15.0]", "low below high"),
        (
            "damper_design",
            "known = [{ damper_mass = 0.06,",
            "known = [{ damper_mass = 0.6,",
            r"known\[0\], damper_mass must be 0.02 to 0.1, but is 0.6",
        ),
        ("damper_design", "known = [{ damper_mass = 0.06, ", "known = [{ ", r"known\[0\] must give damper_mass, platform_angle"),
        (
            "damper_design",
            "{ damper_mass = [0.02, 0.1], ",
            "{ ",
            "acceleration must go with damper_mass and a rig whose dampers are pulled",
        ),
        (
            "damper_design",
            'no_jamming = "platform_angle"',
            'no_jamming = "damper_mass"',
            "name an angle among the variables",
        ),
        ("damper_design", "kt = 8e5", "mu = 0.3", "mu of the rig must be left to friction, which every contact gets, but is 0.3"),
        (
            "damper_design",
            "damper_mass = [0.02, 0.1], ",
            "damper_mass = [0.02, 0.1], mu = [0.2, 0.4], ",
            "must be left to friction",
        ),
        (
            "damper_design",
            "kt = 8e5",
            "pull = 9.0",
            "must be left to acceleration, from which it follows, but is 9.0",
        ),
    ],
)
def test_faults_of_studies_are_said(tmp_path, kind, before, after, words):
    with pytest.raises(InputError, match=words):
        read(changed(tmp_path, kind, before, after))


def test_performance_curves_are_reported_after_a_round_trip_to_disk(tmp_path):
    curve = ss.performance_curve(ss.rigs.single_mass(kt=0.5), [0.8, 1.5, 4.0, 90.0], friction=[0.5, 1.0], harmonics=1, samples=64)
    path = save(stamped(curve.dataset, "performance_curve"), tmp_path / "results.nc")
    report = presentation_of(dataset := open_results(path))
    assert "friction 0.5: lowest resonance" in report.sentences(dataset)[0]
    assert report.failures(dataset) == []
    assert len(report.tables(dataset)["performance curves"]) == 8
    assert {name: len(draw(dataset).plot().axes) for name, draw in report.figures(dataset).items()} == {
        "performance_curve": 3,
        "performance_inertance": 3,
        "dissipation": 2,
    }


def test_a_band_is_reported_after_a_round_trip_to_disk(tmp_path):
    rig, settings = ss.rigs.three_mass_wedge(ss.SliderOffset()), {"cloud": 2, "starts": 0, "harmonics": 1, "samples": 64}
    band = ss.performance_band(rig, [4.0, 8.0], band=ss.hertz(200.0, 235.0), **settings)
    path = save(stamped(band.dataset, "performance_band"), tmp_path / "results.nc")
    report = presentation_of(dataset := open_results(path))
    assert "band widest at F_C/F_E = " in report.sentences(dataset)[0]
    assert report.failures(dataset) == []
    assert report.tables(dataset)["band of the performance curve"]["F_C/F_E"].tolist() == [4.0, 8.0]
    assert len(report.figures(dataset)["performance_band"](dataset).panels) == 2
    failed = dataset.assign(outcome=dataset["outcome"] * 0 + 2)
    assert len(report.failures(failed)) == 2


def test_sensitivity_indices_are_reported_after_a_round_trip_to_disk(tmp_path):
    def rig(*, kt: float, limit: float) -> ss.Problem:
        return ss.rigs.single_mass(damping=0.01, kt=kt, limit=limit)

    ranges = {"kt": (0.4, 0.6), "limit": (1.5, 1.6)}
    found = ss.sensitivity_indices(rig, ranges, ss.radians_per_second(0.8, 1.4), draws=16, harmonics=1, samples=64)
    path = save(stamped(found.dataset, "sensitivity_indices"), tmp_path / "results.nc")
    report = presentation_of(dataset := open_results(path))
    assert "total indices: kt" in report.sentences(dataset)[0]
    assert report.tables(dataset)["parameters"]["parameter"].tolist() == ["kt", "limit"]
    assert report.figures(dataset)["tornado"](dataset).plot().axes


def test_a_design_is_reported_after_a_round_trip_to_disk(tmp_path):
    def mass(*, friction: float, load: float) -> ss.Problem:
        return ss.rigs.single_mass(damping=0.01, kt=0.5, limit=load * friction)

    effort = {"levels": 1, "starts": 0, "designs": 4, "refinements": 2, "harmonics": 1, "samples": 64}
    limits = {"load": lambda trial: 1.0 - trial.variables["load"] / 6.0}
    design = ss.damper_design(mass, {"load": (1.0, 8.0)}, (1.0, 1.0), 0.4, constraints=limits, **effort)
    path = save(stamped(design.dataset, "damper_design"), tmp_path / "results.nc")
    report = presentation_of(dataset := open_results(path))
    assert "worst-case resonance of the best design" in report.sentences(dataset)[0]
    assert len(report.tables(dataset)["designs"]) == dataset.sizes["design"]
    assert report.figures(dataset)["design_space"](dataset).plot().axes


@pytest.mark.slow
def test_figures_of_curves_without_any_peak_are_drawn(tmp_path):
    """Nothing but NaN where sweeps were lost everywhere: no figure or report may break on it."""
    curve = ss.performance_curve(ss.rigs.single_mass(kt=0.5), [0.8, 1.5, 4.0], friction=[0.5], harmonics=1, samples=64).dataset
    names = [name for name in curve.data_vars if curve[name].dims[:1] == ("case",) and curve[name].dtype == float]
    lost = curve.assign({name: curve[name] * np.nan for name in names})
    report = presentation_of(lost := stamped(lost, "performance_curve"))
    assert report.sentences(lost)[0] == "friction 0.5: no resonance was found"
    for name, draw in report.figures(lost).items():
        draw(lost).plot().savefig(tmp_path / f"{name}.png")
    band = ss.performance_band(ss.rigs.single_mass(kt=0.5), [0.8, 1.5], cloud=0, starts=0, harmonics=1, samples=64).dataset
    lost = band.assign({name: band[name] * np.nan for name in band.data_vars if band[name].dtype == float})
    report = presentation_of(lost := stamped(lost, "performance_band"))
    assert report.sentences(lost)
    report.figures(lost)["performance_band"](lost).plot().savefig(tmp_path / "band.png")
