"""What the history of the static load changes: against two Jenkins oscillators, time integration, and curves of their own."""

from dataclasses import replace

import numpy as np
import pytest
from analyses.test_peak_shapes import BAND, LEVELS, MODES_TO, parts

import stickslip as ss
from stickslip.analyses.static_load import seated_balance
from stickslip.analyses.truncation import finer_sentences
from stickslip.model.contact.point import SliderOffset
from stickslip.model.problem.at_rest import at_rest, rest_variables, seated
from stickslip.model.problem.meshed import meshed_problem
from stickslip.model.structure.matrices import Structure
from stickslip.solve.balance.balance import HarmonicBalance

PULL, KT, KN, MU = 2.0, 4.0, 3.0, 0.5
SWEEP = ss.hertz(0.15, 0.3)


def beside_a_wall(coupled=0.0, pull=PULL, grip=10.0, start=None):
    """A mass that slides along x on a floor, on which `pull` presses it along −y, and sticks to a wall along y."""
    K = np.array([[1.0, coupled], [coupled, 0.5]])
    structure = ss.Structure(np.eye(2), K, ("1.x", "1.y"), C=0.02 * np.eye(2))
    start = start or SliderOffset()
    wall = ss.Contact("wall", ss.Macroslip(KT, 1.0, normal_load=grip), ({"1.y": 1.0},), None, start)
    floor = ss.Contact("floor", ss.Macroslip(1.0, MU, KN), ({"1.x": 1.0},), {"1.y": -1.0}, start)
    forces = (ss.Force("1.x", 1.0), ss.Force("1.y", 0.0, static=-pull))
    return ss.Problem(structure, (wall, floor), forces, ("1.x",))


def seated_problem(problem):
    """The same, each slider where the static load seats the contacts without friction."""
    places, starts = iter(seated(problem).motion), {}
    for contact in problem.contacts:
        moved = [next(places) for _ in contact.directions]
        starts[contact.name] = tuple(SliderOffset(float(u)) for u in moved[: len(contact.tangential)])
    return problem.with_contacts(lambda contact: contact.with_start(starts[contact.name]))


def height(response):
    return np.nanmax(response.dataset.peak_amplitude.values[:, :, 0], axis=1)


def test_the_wall_carries_its_share_of_the_pull_only_where_the_pull_drags_its_slider():
    """On the floor N is P kn/(k + kn + kt) or P kn/(k + kn), and x a Jenkins oscillator with the limit μN."""
    heights = []
    for held in (KT, 0.0):
        law = ss.Macroslip(1.0, MU, normal_load=PULL * KN / (0.5 + KN + held))
        slider = ss.Contact("floor", law, (ss.between("1.x", "ground"),))
        alone = ss.Structure([[1.0]], [[1.0]], ("1.x",), C=[[0.02]])
        heights.append(height(ss.forced_response(ss.Problem(alone, (slider,), (ss.Force("1.x", 1.0),), ("1.x",)), SWEEP, 0.2)))
    response = ss.forced_response(beside_a_wall(), SWEEP, 0.2)
    assert height(response) == pytest.approx(heights[0], rel=1e-5)
    (change,) = response.dataset.history_change.values[0]
    assert change == pytest.approx(heights[1][0] / heights[0][0] - 1.0, rel=1e-3)
    assert abs(change) > 0.05
    message = str(response.dataset.case_message.values[0])
    assert "The history of the static load changes 1.x at its highest peak: " in message
    assert f"{heights[0][0]:.4g} m at" in message
    assert f"{heights[1][0]:.4g} m at" in message
    assert f"{100.0 * change:+.1f} %" in message
    assert "These are not bounds of the response; compute bounds with `response_bounds`." in message


def marched(problem, hertz, force, cycles=(40, 80, 80), steps=160):
    """|X₁| of the first coordinate in both histories, integrated from rest: the static load comes, then slowly the force.

    Explicit steps of Newton's equation; each slider follows where its spring would carry more than μN.
    """
    (M, K, C), B = (getattr(problem.structure, name) for name in "MKC"), problem.B
    inverse, omega = np.linalg.inv(M), 2.0 * np.pi * hertz
    dt, static = 1.0 / (hertz * steps), problem.static_load
    q, v, sliders = np.zeros((2, 2)), np.zeros((2, 2)), np.zeros((2, 2))
    ends, x1 = steps * np.cumsum(cycles), np.zeros(2, dtype=complex)
    for step in range(ends[-1]):
        rest = min(2.0 * step / ends[0], 1.0)
        grown = float(np.clip((step - ends[0]) / (ends[1] - ends[0]), 0.0, 1.0))
        w = q @ B.T
        u, N = w[:, :2], np.maximum(KN * w[:, 2], 0.0)
        limit = np.stack([np.full(2, 10.0), MU * N], axis=1)
        stiff = np.array([KT, 1.0])
        T = np.clip(stiff * (u - sliders), -limit, limit)
        sliders = u - T / stiff
        if step < ends[0]:  # the second one is seated without friction, and its sliders begin afterwards
            T[1], sliders[1] = 0.0, u[1]
        f = np.column_stack([T, N])
        damping = C + (1.0 * np.eye(2) if step < ends[0] else 0.0)
        p = rest * static + np.array([force * grown * np.cos(omega * dt * (step - ends[0])), 0.0])
        v = v + dt * (p - q @ K - v @ damping - f @ B) @ inverse
        q = q + dt * v
        if step >= ends[-1] - steps:
            x1 += 2.0 / steps * q[:, 0] * np.exp(-1j * omega * dt * step)
    return np.abs(x1)


def test_both_histories_are_those_of_time_integration_from_rest():
    problem, hertz, force = beside_a_wall(coupled=0.15), 0.2174, 0.2
    expected = [
        float(ss.forced_response(each, [hertz], force).dataset.amplitude.values[0, 0, 0])
        for each in (problem, seated_problem(problem))
    ]
    assert expected[1] > 1.5 * expected[0]
    assert marched(problem, hertz, force) == pytest.approx(expected, rel=2e-3)


def test_a_peak_is_that_of_the_whole_curve_of_the_other_history():
    problem = beside_a_wall(coupled=0.15)
    forces = [0.05, 0.2]
    response, other = (ss.forced_response(each, SWEEP, forces) for each in (problem, seated_problem(problem)))
    change = response.dataset.history_change.values[:, 0]
    assert change == pytest.approx(height(other) / height(response) - 1.0, abs=2e-4)
    assert change.min() > 0.5
    assert np.isnan(other.dataset.history_change.values).all()  # its start states are given


def test_where_the_history_does_not_matter_it_is_said_why():
    """No load, a load that moves no slider, sliders that all slip, frequencies without peaks, friction that alone holds."""

    def found(problem, band=SWEEP, force=0.2):
        data = ss.forced_response(problem, band, force).dataset
        return data.history_change.values[0, 0], data.attrs["static_history"]

    unloaded = found(beside_a_wall(pull=0.0))
    assert np.isnan(unloaded[0])
    assert unloaded[1] == ""
    structure = ss.Structure(np.eye(2), np.eye(2), ("1.x", "1.y"), C=0.02 * np.eye(2))
    forces = (ss.Force("1.x", 1.0), ss.Force("1.y", 0.0, static=-PULL))
    along, normal = {"1.x": 0.8, "1.y": 0.6}, {"1.x": 0.6, "1.y": -0.8}
    pressed = (ss.Force("1.x", 1.0, static=0.6 * PULL), ss.Force("1.y", 0.0, static=-0.8 * PULL))
    across = found(ss.Problem(structure, (ss.Contact("floor", ss.Macroslip(1.0, MU, KN), (along,), normal),), pressed, ("1.x",)))
    assert np.isnan(across[0])
    assert across[1] == "The history of the static load does not matter: the load moves no slider."
    assert np.isnan(found(beside_a_wall(), [0.2])[0])
    sliding = beside_a_wall(grip=0.5)  # under a load of its own
    assert rest_variables(sliding, at_rest(sliding))["rest_state"].tolist() == [2, 1]
    assert found(beside_a_wall(grip=0.0))[0] == pytest.approx(0.0, abs=1e-6)
    loose = ss.Structure(np.diag([1.0, 1.0]), np.diag([1.5, 0.0]), ("1.x", "1.y"), C=0.02 * np.eye(2))
    held = ss.Contact("wall", ss.Macroslip(KT, 1.0, normal_load=10.0), ({"1.y": 1.0, "1.x": 0.5},))
    change, why = found(ss.Problem(loose, (held,), forces, ("1.x",)))
    assert np.isnan(change)
    assert why.startswith("The effect of the history of the static load is not known: no equilibrium without friction")


@pytest.mark.parametrize(("weak", "said"), [(2e-3, False), (8e-3, True), (0.5, True)])
def test_small_vibrations_of_contacts_that_are_open_at_rest(weak, said):
    """A pull lifts one of two pads off; the other one, which it drags to its friction limit, sticks.

    Across, the natural frequency falls from above that along to below it."""
    structure = ss.Structure(np.eye(2), np.diag([1.0, 0.6]), ("1.x", "1.y"), C=1e-3 * np.eye(2))
    law = ss.Macroslip(kt=1.0, mu=0.3, kn=1.0)
    lifted = ss.Contact("lifted", replace(law, kt=weak), ({"1.x": 1.0},), {"1.y": 1.0})
    pressed = ss.Contact("pressed", law, ({"1.x": 1.0},), {"1.y": -1.0})
    problem = ss.Problem(
        structure, (lifted, pressed), (ss.Force("1.x", 1.0, static=1.0), ss.Force("1.y", 0.0, static=-1.0)), ("1.x",)
    )
    assert rest_variables(problem, at_rest(problem))["rest_state"].tolist() == [0, 2]
    response = ss.forced_response(problem, ss.hertz(0.2, 0.255), 1e-6)
    (found,) = response.dataset.peak_frequency.values[0, 0]
    stuck = np.sqrt(2.0 + weak) / (2.0 * np.pi)
    assert found == pytest.approx(np.sqrt(2.0) / (2.0 * np.pi), rel=1e-5)
    sentence = f"(lifted): small vibrations have the natural frequency {found:.5g} Hz instead of {stuck:.5g} Hz with"
    assert (sentence in response.dataset.attrs["static_history"]) == said
    assert any(sentence in line for line in finer_sentences(response.dataset)) == said


def pressed_beam():
    """A beam on its pad with a preload that bends it, a force along the pad and one across it, and all rows of the same."""
    structure, contacts, (force,), outputs = parts()
    contacts = tuple(ss.Contact(c.name, c.law, c.tangential, c.normal) for c in contacts)
    forces = (force, ss.Force(force.direction.replace(".y", ".z"), 0.0, static=-30.0))
    dense = Structure(structure.M, structure.K, structure.dofs, damping=structure.damping, nodes=structure.nodes)
    return (structure, contacts, forces, outputs), ss.Problem(dense, contacts, forces, outputs)


def test_a_mesh_of_few_modes_has_the_shape_of_its_seated_contacts():
    meshed, whole = pressed_beam()
    _, _, places = seated_balance(HarmonicBalance(meshed_problem(*meshed, modes_to=3e3), 1, 16), 1.0)
    along = np.array([name != "n" for contact in whole.contacts for name in contact.direction_names])
    right = seated(whole).motion[along]
    assert np.abs(places - right).max() < 2e-4 * np.abs(right).max()


@pytest.mark.slow
def test_a_mesh_without_kept_rows_says_the_same_as_all_rows():
    """Some contacts slip at the peak."""
    (meshed, whole), how = pressed_beam(), {"harmonics": 3, "samples": 128}
    response, other = (ss.forced_response(each, BAND, LEVELS[1:2], **how) for each in (whole, seated_problem(whole)))
    change = response.dataset.history_change.values[:, 0]
    assert change == pytest.approx(height(other) / height(response) - 1.0, abs=1e-4)
    assert np.abs(change).min() > 0.01
    few = ss.forced_response(meshed_problem(*meshed, modes_to=MODES_TO), BAND, LEVELS[1:2], **how)
    assert few.dataset.history_change.values[:, 0] == pytest.approx(change, rel=1e-3)
