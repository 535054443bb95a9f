"""What `nonlinear_modes` and its results refuse, which mode they choose, and what they say of a curve."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.analyses.modes.work import NonlinearModesWork, with_peaks
from stickslip.show.report.nonlinear_modes import failures
from stickslip.support.outcome import Outcome

RIG = ss.rigs.three_mass_wedge()


def small(**arguments) -> ss.NonlinearModes:
    return ss.nonlinear_modes(RIG, amplitude=(1e-7, 1e-6), harmonics=1, samples=32, **arguments)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"mode": 0}, "mode must be at least 1"),
        ({"mode": 7}, "mode must be at most 6"),
        ({"mode": [2, 2]}, "mode"),
        ({"mode": []}, "mode must hold at least one number"),
        ({"mode": 1, "frequency": 160.0}, "one must be given at most"),
        ({"frequency": -1.0}, "frequency must be positive"),
        ({"extended": "both"}, "extended"),
        ({"amplitude": (1e-3, 1e-4)}, "low below high"),
        ({"amplitude": -1.0}, "amplitude must be positive"),
        ({"output": 9}, "output must be 0 to 3"),
        ({"harmonics": 0}, "harmonics"),
        ({"samples": 4, "harmonics": 3}, "samples"),
        ({"samples": 10**10}, "samples must be at most"),
        ({"largest_at_output": 1}, "largest_at_output"),
    ],
)
def test_wrong_arguments_are_refused(arguments, words):
    with pytest.raises(ss.InputError, match=words):
        ss.nonlinear_modes(RIG, **arguments)


def test_a_mode_is_chosen_by_its_number_its_frequency_or_its_output():
    frequencies = RIG.frequencies(stuck=True)
    several = small(mode=[3, 1]).dataset
    np.testing.assert_allclose(several["stuck_frequency"], frequencies[[2, 0]], rtol=1e-12)
    assert int(small(frequency=230.0).dataset["mode_number"].item()) == 3
    shares = [np.abs(small(mode=k).dataset["amplitude"].values[0, 0, 1]) for k in (1, 2, 3)]
    assert len(shares) == 3
    chosen = int(small(output=2, largest_at_output=True).dataset["mode_number"].item())
    K, row = RIG.stuck_stiffness, RIG.output_rows[2]
    w, shapes = np.linalg.eig(np.linalg.solve(RIG.structure.M, K))
    order = np.argsort(w.real)
    shapes = shapes[:, order].real
    compliance = (row @ shapes) ** 2 / np.einsum("im,ij,jm->m", shapes, K, shapes)
    assert chosen == int(np.argmax(compliance)) + 1


def test_an_amplitude_must_be_given_where_nothing_says_where_slip_begins():
    dahl = ss.rigs.single_mass().with_contacts(lambda contact: contact.with_law(ss.Dahl(1.0, 1.0, normal_load=1.0)))
    with pytest.raises(
        ss.InputError, match="amplitude must be given, since the contacts are nonlinear, slip or are open however small it is"
    ):
        ss.nonlinear_modes(dahl, harmonics=1, samples=32)
    spring = ss.rigs.single_mass().with_contacts(lambda contact: contact.with_law(ss.Macroslip(1.0, 1.0, normal_load=1e39)))
    with pytest.raises(ss.InputError, match="no contact slips at any amplitude"):
        ss.nonlinear_modes(spring, harmonics=1, samples=32)


def test_an_output_at_a_node_of_the_mode_has_no_amplitude():
    K = np.array([[2.0, -1.0], [-1.0, 2.0]])
    structure = ss.Structure(np.eye(2), K, ("1.x", "2.x"))
    contacts = (ss.Contact("one", ss.Macroslip(0.5, 1.0, normal_load=1.0), ({"1.x": 1.0, "2.x": 1.0},)),)
    mean = ss.Output("difference", {"1.x": 1.0, "2.x": -1.0})
    problem = ss.Problem(structure, contacts, (ss.Force("1.x", 1.0),), (mean,))
    with pytest.raises(ss.InputError, match="Output 'difference' must move in the mode"):
        ss.nonlinear_modes(problem, 1, (1e-3, 1.0), harmonics=1, samples=32)
    with pytest.raises(ss.InputError, match="no contact moves in this mode"):
        ss.nonlinear_modes(problem, 2, harmonics=1, samples=32)


def test_force_levels_beyond_the_curve_and_forces_without_work_are_refused():
    modes = ss.nonlinear_modes(ss.rigs.single_mass(), amplitude=(0.5, 2.0), harmonics=1, samples=64)
    with pytest.raises(ss.InputError, match=r"at most .*, that of the largest amplitude of the mode"):
        modes.peaks([5.0])
    with pytest.raises(ss.InputError, match="case"):
        modes.peaks([0.1], case=1)
    with pytest.raises(ss.InputError, match="must move the mode by one of its amplitudes"):
        modes.response(1e-9)
    K = np.array([[2.0, -1.0], [-1.0, 2.0]])
    sliders = tuple(ss.Contact(f"{k}", ss.Macroslip(0.5, 1.0, normal_load=1.0), ({f"{k}.x": 1.0},)) for k in (1, 2))
    pair = ss.Problem(ss.Structure(np.eye(2), K, ("1.x", "2.x")), sliders, (ss.Force({"1.x": 1.0, "2.x": -1.0}, 1.0),), ("1.x",))
    together = ss.nonlinear_modes(pair, 1, harmonics=1, samples=64)
    with pytest.raises(ss.InputError, match="must excite the mode"):
        together.peaks([0.1])
    assert "must excite the mode" in together.dataset["synthesis_message"].item()
    assert np.isnan(together.dataset["peak_force_level"]).all()
    with pytest.raises(ss.InputError, match="forces"):
        together.peaks([1.0], forces=3)
    with pytest.raises(ss.InputError, match="response"):
        together.against(3)
    other = together.peaks([1.0], forces=[ss.Force("1.x", 2.0)])
    assert other["amplitude"].to_numpy() == pytest.approx(together.peaks([2.0], forces=[ss.Force("1.x", 1.0)])["amplitude"])


def test_a_curve_that_is_lost_keeps_its_points_and_says_so(monkeypatch):
    monkeypatch.setattr("stickslip.solve.curves.mode_curve.POINTS", 5)
    lost = ss.nonlinear_modes(ss.rigs.single_mass(), harmonics=1, samples=64).dataset
    assert lost["case_outcome"].item() == Outcome.NOT_CONVERGED
    assert "ended before the largest amplitude: The curve was not finished within 5 points" in lost["case_message"].item()
    assert np.isfinite(lost["frequency"]).sum() >= 6


def test_an_internal_resonance_is_reported():
    """Chain of 20: harmonic 3 of mode 1 meets mode 4."""
    found = ss.nonlinear_modes(ss.rigs.chain(), amplitude=(2.0, 20.0), harmonics=3, samples=64).dataset
    assert "harmonic 3 excites mode 4 of the stuck structure" in found["case_message"].item()
    assert found["higher_harmonics"].max() > 0.05


def test_cases_are_solved_one_by_one():
    modes = small(mode=[1, 2])
    assert modes.dataset["frequency"].attrs["units"] == "Hz"
    work = NonlinearModesWork(RIG, (1, 2), (1e-7, 1e-6), harmonics=1, samples=32)
    assert len(set(work.names)) == 2
    again = work.dataset([work.solve(case, lambda done: None) for case in (0, 1)])
    np.testing.assert_array_equal(again["frequency"], modes.dataset["frequency"])


@pytest.mark.parametrize("figure", ["", "energy", "peaks", "shape", "states"])
def test_figures_are_drawn(figure):
    assert small(mode=[1, 2]).plot(figure).axes


def test_a_force_level_beyond_the_mode_is_refused_for_curves_as_for_peaks():
    modes = ss.nonlinear_modes(ss.rigs.single_mass(), amplitude=(0.1, 5.0), harmonics=1)
    for ask in (lambda: modes.peaks([50.0]), lambda: modes.response(50.0)):
        with pytest.raises(ss.InputError, match="that of the largest amplitude of the mode"):
            ask()


def test_a_force_that_no_amplitude_needs_is_named():
    """Without viscous damping the friction of one slider holds at most a force of 4μN/π: no larger amplitude will do."""
    problem = ss.rigs.single_mass(damping=0.0)
    modes = ss.nonlinear_modes(problem, harmonics=1, samples=64)
    with pytest.raises(ss.InputError, match="the most that the mode needs at any of its amplitudes") as refused:
        modes.peaks([1.5])
    assert "contacts hold no more" in str(refused.value)
    assert "larger amplitude" not in str(refused.value)
    assert "contacts hold no more" in failures(with_peaks(modes.dataset, problem, [1.0, 1.5]))[0]
    with pytest.raises(ss.InputError, match="Compute the mode up to a larger amplitude"):
        ss.nonlinear_modes(problem, amplitude=(0.5, 3.0), harmonics=1, samples=64).peaks([1.2])
    with pytest.raises(ss.InputError, match="Compute the mode up to a larger amplitude"):
        ss.nonlinear_modes(ss.rigs.single_mass(damping=0.02), harmonics=1, samples=64).peaks([100.0])


@pytest.mark.nightly
def test_a_mode_of_a_body_that_friction_alone_holds_says_so():
    """Four free masses in a row, the first rubs: the mean position is not determined where it slips."""
    K = 1000.0 * np.array([[1.0, -1, 0, 0], [-1, 2, -1, 0], [0, -1, 2, -1], [0, 0, -1, 1]])
    structure = ss.Structure(np.eye(4), K, tuple(f"{k}.x" for k in range(1, 5)), C=1e-4 * K)
    slider = ss.Contact("slider", ss.Macroslip(kt=50.0, mu=0.3, normal_load=5.0), (ss.between("1.x", "ground"),))
    problem = ss.Problem(structure, (slider,), (ss.Force("1.x", 1.0),), ("1.x",))
    modes = ss.nonlinear_modes(problem, 1, harmonics=3, samples=64)
    assert "held by friction alone" in str(modes.dataset["case_message"].values[0])
    with pytest.raises(ss.InputError, match="leave harmonic 0 out"):
        modes.peaks([100.0])
    free = ss.nonlinear_modes(problem, 1, harmonics=[1, 3], samples=64)
    assert int(free.dataset["case_outcome"].values[0]) == ss.Outcome.CONVERGED
