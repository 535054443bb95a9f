"""Normal loads at rest against harmonic balance under a force of nearly nothing, for every kind of start state."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import optimize

import stickslip as ss
from stickslip.analyses.static_load import opened
from stickslip.model.problem.at_rest import normal_loads_at_rest
from stickslip.study import job
from stickslip.study.run_time import model_summary
from stickslip.study.templates import write_new

WEDGE = ss.rigs.three_mass_wedge()


@pytest.mark.parametrize(
    "rig", [WEDGE, ss.rigs.blade_and_wedge(), ss.rigs.lumped_blisk()], ids=["three masses", "blade and wedge", "disk"]
)
@pytest.mark.parametrize("start", [ss.SliderOffset(), ss.SliderOffset(2e-6), ss.TractionRatio(0.4), ss.MeanTraction(3.0)])
def test_loads_at_rest_are_those_of_a_vibration_of_nearly_nothing(rig, start):
    problem = rig.with_start(start)
    response = ss.forced_response(problem, [100.0], force=1e-9, harmonics=1, samples=66).dataset
    mean = response.contact_force.isel(case=0, point=0).sel(direction="n", harmonic=0, part="re")
    loads = normal_loads_at_rest(problem)
    np.testing.assert_allclose([loads[str(name)] for name in mean.contact.values], mean.values, rtol=1e-5)


def test_contacts_of_constant_load_have_none_and_open_ones_zero():
    assert normal_loads_at_rest(ss.rigs.single_mass()) == {}
    structure = ss.Structure(np.eye(1), [[1.0]], ("1.y",))
    stop = ss.Contact("stop", ss.Gap(kn=5.0, gap=0.1), (), ss.between("1.y", "ground"))
    problem = ss.Problem(structure, (stop,), (ss.Force("1.y", 1.0),), ("1.y",))
    assert normal_loads_at_rest(problem) == {"stop": 0.0}
    pressed = replace(problem, forces=(ss.Force("1.y", 1.0, static=1.3),))
    assert normal_loads_at_rest(pressed) == pytest.approx({"stop": 5.0 * (1.3 + 0.5) / 6.0 - 0.5})


def test_what_friction_without_stiffness_alone_holds_has_no_loads():
    """A mass pressed on the ground whose tangential traction is given: at rest it may lie anywhere along the contact."""
    structure = ss.Structure(np.eye(2), np.zeros((2, 2)), ("1.x", "1.y"))
    forces = (ss.Force("1.x", 1.0), ss.Force("1.y", 0.0, static=2.0))
    for start, expected in ((ss.SliderOffset(), {"pad": pytest.approx(2.0)}), (ss.MeanTraction(0.1), {})):
        law = ss.Macroslip(kt=1.0, mu=0.3, kn=1.0)
        pad = ss.Contact("pad", law, (ss.between("1.x", "ground"),), ss.between("1.y", "ground"), start)
        assert normal_loads_at_rest(ss.Problem(structure, (pad,), forces, ("1.x",))) == expected


def test_a_check_names_frequencies_and_loads(tmp_path):
    path, _ = write_new("lumped", tmp_path / "wedge.toml", False)
    frequencies, head, titles, loads, _ = model_summary(job(path.read_text(), tmp_path, "wedge").sweep)
    assert "all contacts stuck: 84.971, 161.98, 225.08" in frequencies
    assert head.startswith("Contacts at rest; ")
    assert titles.split()[:3] == ["surface", "contacts", "open"]
    assert loads.split()[:6] == ["blade", "1", "1", "0", "0", "31.39"]
    above = path.read_text().replace("frequency = [145.0, 235.0]", "frequency = [1450.0, 2350.0]")
    nowhere = job(above, tmp_path, "wedge").notes[0]
    assert nowhere.startswith("Warning: no natural frequency lies between 1450 and 2350 Hz, where the response is computed")


def test_contacts_open_at_rest_are_those_of_the_least_potential_energy():
    """A chain pulled off some stops and pressed on others; SciPy minimises ½ qᵀKq − pᵀq + Σ kn max(q − gap, 0)²/2."""
    rng, size = np.random.default_rng(4), 6
    K = 3.0 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1)
    dofs = tuple(f"{k}.y" for k in range(size))
    for _ in range(10):
        p, gaps, kn = 4.0 * rng.normal(size=size), rng.uniform(-0.5, 0.5, size), 20.0
        stops = tuple(
            ss.Contact(dof, ss.Gap(kn=kn, gap=float(gap)), (), ss.between(dof, "ground"))
            for dof, gap in zip(dofs, gaps, strict=True)
        )
        forces = tuple(ss.Force(dof, 0.0, static=float(each)) for dof, each in zip(dofs, p, strict=True))
        problem = ss.Problem(ss.Structure(np.eye(size), K, dofs), stops, (ss.Force("0.y", 1.0), *forces), ("0.y",))

        def energy(q, p=p, gaps=gaps, kn=kn):
            N = np.maximum(kn * (q - gaps), 0.0)
            return 0.5 * q @ K @ q - p @ q + 0.5 * N @ N / kn, K @ q - p + N

        q = optimize.minimize(energy, 0.0 * p, jac=True, method="L-BFGS-B", options={"ftol": 1e-15, "gtol": 1e-10}).x
        expected = np.maximum(kn * (q - gaps), 0.0)
        assert 0 < np.count_nonzero(expected) < size
        np.testing.assert_allclose(list(normal_loads_at_rest(problem).values()), expected, atol=1e-5)


def test_modal_damping_across_an_open_gap_is_warned_of():
    """Two masses apart: modes with the gap closed damp their relative motion, as C shows; those without do not."""
    structure = ss.Structure(np.eye(2), np.diag([1.0, 1.0]), ("1.y", "2.y"))
    stop = ss.Contact("stop", ss.Gap(kn=10.0, gap=0.1), (), ss.between("1.y", "2.y"))

    def problem(on, static=0.0):
        damped = structure.with_damping(ss.ModalDamping(0.01, on=on))
        return ss.Problem(damped, (stop,), (ss.Force("1.y", 1.0, static=static),), ("1.y",))

    assert problem("stuck").C[0, 1] < -0.02
    (warning,) = problem("stuck").warnings
    assert "Contacts with a gap, open at rest (stop), are closed in the modes" in warning
    assert not problem("free").warnings
    assert not problem("free").C[0, 1]
    assert not problem("stuck", static=1.0).warnings


def test_a_band_with_the_frequency_of_small_vibrations_at_rest_holds_one(tmp_path):
    """One of two contacts is open: √(k + kn)/2π = 31.83 Hz lies between 15.9 Hz, free, and 162 Hz, both stuck."""
    study = """
    [study]
    title = "open at rest"
    analysis = "forced_response"
    [structure]
    matrices = { M = [[1.0, 0.0], [0.0, 1.0]], K = [[1e4, 0.0], [0.0, 9e6]], C = [[2.0, 0.0], [0.0, 2.0]] }
    dofs = ["a.y", "a.x"]
    [[contact]]
    name = "closed"
    law = "macroslip"
    tangential = ["a.x", "ground"]
    normal = ["a.y", "ground"]
    kt = 3e4
    kn = 3e4
    mu = 0.3
    preload = 50.0
    [[contact]]
    name = "open"
    law = "macroslip"
    tangential = ["a.x", "ground"]
    normal = ["a.y", "ground"]
    kt = 1e6
    kn = 1e6
    mu = 0.3
    gap = 0.01
    [[force]]
    direction = "a.y"
    amplitude = 0.05
    [sweep]
    frequency = [25.0, 40.0]
    outputs = ["a.y"]
    """
    made = job(study, tmp_path, "study")
    assert not any("no natural frequency" in note for note in made.notes)
    sentence = opened(made.sweep.problem, 25.0, 40.0)
    assert "small vibrations have the natural frequency 31.831 Hz instead of 162.31 Hz" in sentence
    far = job(study.replace("[25.0, 40.0]", "[50.0, 100.0]"), tmp_path, "study")
    assert any("no natural frequency lies between 50 and 100 Hz" in note and "31.831" in note for note in far.notes)
