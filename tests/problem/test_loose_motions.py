"""Which motions friction alone restrains, and that a soft spring on their mean changes nothing else."""

from dataclasses import replace

import numpy as np
import pytest
from problem.loose_wedge import KT, wedge_between

import stickslip as ss
from stickslip.analyses.truncation import coordinates_note, held_mean_warning
from stickslip.model.problem.systems import SOFT, lasting_stiffness, loose_motions, soft_springs
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE
from stickslip.solve.curves.curve import solve_curve


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_the_axial_position_of_a_wedge_is_loose_in_any_unit(scale):
    motions = loose_motions(wedge_between(scale=scale))
    np.testing.assert_allclose(np.abs(motions), [[0.0] * 8 + [1.0]], atol=1e-9)
    (spring,) = soft_springs(wedge_between(scale=scale))
    assert spring.direction == {"body.z": pytest.approx(spring.direction["body.z"])}
    assert spring.stiffness == pytest.approx(SOFT * 2.0 * KT * scale)


def test_a_soft_blade_is_not_loose():
    """One part in a million of the stiffness of the contacts is a stiffness."""
    assert len(loose_motions(wedge_between(stiffness=(1e-3, 1e-3, 1e-3)))) == 1


def test_held_bodies_have_no_loose_motion():
    held = wedge_between()
    held = replace(held, mean_springs=(ss.Spring({"body.z": 1.0}, 1.0),))
    assert not len(loose_motions(held))
    assert not soft_springs(held)
    assert not len(loose_motions(ss.rigs.single_mass()))


def test_the_vibration_does_not_depend_on_the_spring():
    """Both contacts slip along z at 5 N: their mean is free, the amplitudes are the same whatever holds it."""
    amplitudes = []
    for times in (0.1, 1.0, 10.0):
        problem = wedge_between()
        springs = tuple(replace(spring, stiffness=times * spring.stiffness) for spring in soft_springs(problem))
        response = ss.forced_response(replace(problem, mean_springs=springs), [4.2, 4.6], 6.0, harmonics=3, samples=128)
        assert (response.dataset["outcome"] == 1).all()
        amplitudes.append(response.dataset["amplitude"].to_numpy())
    assert response.dataset["share_slip"].max() > 0.1
    np.testing.assert_allclose(amplitudes[0], amplitudes[2], rtol=1e-4)
    np.testing.assert_allclose(amplitudes[1], amplitudes[2], rtol=1e-4)


def test_peaks_are_checked_not_to_depend_on_the_spring(monkeypatch):
    problem = wedge_between()
    held = replace(problem, mean_springs=soft_springs(problem))
    balance = HarmonicBalance(held, 3, 128)
    curve = solve_curve(balance, [2.0 * np.pi * 4.2], 6.0, exactly=True)
    assert held_mean_warning(balance, 0, curve, DISPLACEMENT_AMPLITUDE) == ""
    assert held_mean_warning(balance, 1, curve, DISPLACEMENT_AMPLITUDE) == ""
    note = coordinates_note(replace(held, modes_to=100.0), problem)
    assert "holds the mean position along body.z, which friction alone restrains" in note
    monkeypatch.setattr("stickslip.analyses.truncation.INDEPENDENT", -1.0)
    assert "left.x depends on the springs that hold mean positions" in held_mean_warning(
        balance, 1, curve, DISPLACEMENT_AMPLITUDE
    )


def test_soft_mean_springs_last_along_what_they_hold_alone():
    """Along the loose motion as stiff as given; what moves otherwise, as stuck contacts have it, feels nothing."""
    problem = wedge_between()
    (spring,) = soft_springs(problem)
    held = replace(problem, mean_springs=(spring,))
    K, loose = lasting_stiffness(held), loose_motions(problem)[0]
    moved = float(problem.structure.rows([spring.direction])[0] @ loose)
    assert loose @ K @ loose == pytest.approx(spring.stiffness * moved**2)
    other = np.linspace(1.0, 2.0, loose.size)
    other -= loose * (loose @ problem.stuck_stiffness @ other) / (loose @ problem.stuck_stiffness @ loose)
    np.testing.assert_allclose(K @ other, 0.0, atol=1e-9 * np.abs(K).max())
    assert lasting_stiffness(problem).shape == K.shape
    assert not lasting_stiffness(problem).any()


def test_mean_springs_that_the_vibration_would_feel_do_not_last():
    """Stiff ones, and those that hold what the structure holds too, in place of the loose motion or beside it."""
    problem = wedge_between()
    (spring,) = soft_springs(problem)
    for times, allowed in ((9.0, True), (11.0, False)):
        held = replace(problem, mean_springs=(replace(spring, stiffness=times * spring.stiffness),))
        assert (lasting_stiffness(held) is not None) == allowed
    other = replace(spring, direction={problem.structure.dofs[0]: 1.0})
    for springs in ((other,), (spring, other)):
        assert lasting_stiffness(replace(problem, mean_springs=springs)) is None


def test_a_wedge_on_a_soft_mean_spring_moves_in_time_as_in_the_harmonic_balance():
    problem = wedge_between()
    held = replace(problem, mean_springs=soft_springs(problem))
    response = ss.forced_response(held, [4.2], 1.0, harmonics=5, samples=512)
    check = response.verify_in_time(0, 0, steps_per_period=500, tolerance=1e-4)
    assert check.periodic
    assert check.agrees(5e-3)
