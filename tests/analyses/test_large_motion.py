"""A motion that is large beside the structure is said with its size; what has no coordinates has no size."""

from dataclasses import replace

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
