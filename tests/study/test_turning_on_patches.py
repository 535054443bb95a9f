"""How much more easily a body turns on patches than on nodes: two patches of two nodes each by hand."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.model.contact.point import mean
from stickslip.study.surfaces import turning_notes, turning_share

BODY = ss.RigidBody(1.0, np.eye(3), (0.0, 0.0, 0.0))


def contact(name, points):
    """A patch of nodes on the ground, pressed along z and rubbing along x and y; a node is a patch of one."""
    law = ss.Macroslip(kt=2.0 * len(points), mu=0.3, kn=3.0 * len(points))
    motion = mean([BODY.at(point, "wedge") for point in points], [1.0 / len(points)] * len(points))
    t1, t2, n = (motion(axis) for axis in np.eye(3).tolist())
    return ss.Contact(name, law, (t1, t2), n)


class Patch:
    """Two contacts that know the nodes behind them."""

    def __init__(self, name, points):
        whole = contact(name, points)
        self.directions, self.elements, self.nodes = whole.directions, whole.elements, tuple(map(str, points))
        self.at_nodes = [contact(f"{name} {k}", [point]) for k, point in enumerate(points)]


def test_two_patches_of_two_nodes_keep_the_square_of_the_lever():
    """Nodes at x = ±a and ±b, patches at ±(a + b)/2: about y they keep ((a + b)/2)² ÷ (a² + b²)/2 of the stiffness."""
    a, b = 1.0, 3.0
    rows = [(x, y, 0.0) for y in (-1.0, 1.0) for x in (a, b, -a, -b)]
    pairs = [rows[k : k + 2] for k in range(0, len(rows), 2)]
    patches = [Patch(f"patch {k}", pair) for k, pair in enumerate(pairs)]
    expected = (0.5 * (a + b)) ** 2 / (0.5 * (a**2 + b**2))
    assert turning_share(patches, "wedge") == pytest.approx(expected, rel=1e-9)
    (note,) = turning_notes(patches, ["wedge"])
    assert note.startswith("Warning: The contact points hold wedge in the softest direction with 80 %")
    assert turning_notes([each for patch in patches for each in patch.at_nodes], ["wedge"]) == []
