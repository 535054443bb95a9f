"""A motion that is large beside the structure is said with its size; what has no coordinates has no size."""

from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss

BAND = ss.radians_per_second(0.5, 2.0)


@pytest.mark.parametrize(("side", "said"), [(1e3, False), (10.0, True), (0.0, False)])
def test_a_motion_of_a_part_of_the_size_is_said(side, said):
    """At force level 2 the mass of the benchmark moves by metres."""
    rig = ss.rigs.single_mass()
    nodes = {"1": (0.0, 0.0, 0.0), "2": (side, 0.0, 0.0)} if side else {}
    placed = replace(rig, structure=replace(rig.structure, nodes=nodes))
    found = ss.forced_response(placed, BAND, 2.0, harmonics=1).dataset
    moved = float(found["max_abs"].max())
    assert 1.0 < moved < 100.0
    sentence = f"1.x moves by up to {moved:.3g} m, {moved / max(side, 1.0):.2g} times the size of the structure"
    assert (sentence in str(found["case_message"].values[0])) == said
    velocity = ss.forced_response(placed, BAND, 2.0, harmonics=1, quantity="velocity").dataset
    assert "times the size" not in str(velocity["case_message"].values[0])


def test_a_gap_that_rounding_would_hide_the_force_behind_is_refused():
    """A gap of 1e15 m as "never closes": the peak was 11.8 m, which is 43.5 m, and three detached curves."""
    structure = ss.Structure(M=np.eye(1), K=np.eye(1), C=0.023 * np.eye(1), dofs=("a.x",))

    def peak(gap):
        stop = ss.Contact("stop", ss.Gap(kn=2.0, gap=gap), normal={"a.x": 1.0})
        problem = ss.Problem(structure, contacts=(stop,), forces=(ss.Force("a.x", 1.0),), outputs=("a.x",))
        return float(ss.forced_response(problem, ss.Band(0.08, 0.5)).peaks().amplitude[0])

    assert peak(1e9) == pytest.approx(1.0 / (0.023 * np.sqrt(1.0 - 0.25 * 0.023**2)), rel=1e-6)
    with pytest.raises(ss.InputError, match="gap of stop must not be so large"):
        peak(1e15)


def test_start_states_too_refuse_a_gap_that_hides_the_force():
    structure = ss.Structure(M=np.eye(1), K=np.eye(1), C=0.023 * np.eye(1), dofs=("a.x",))
    contacts = (
        ss.Contact("slider", ss.Macroslip(kt=0.1, mu=0.3, normal_load=1.0), tangential=({"a.x": 1.0},)),
        ss.Contact("stop", ss.Gap(kn=2.0, gap=1e15), normal={"a.x": 1.0}),
    )
    problem = ss.Problem(structure, contacts=contacts, forces=(ss.Force("a.x", 1.0),), outputs=("a.x",))
    with pytest.raises(ss.InputError, match="gap of stop must not be so large"):
        ss.response_samples(problem, ss.Band(0.08, 0.5), 1.0, starts=1)
