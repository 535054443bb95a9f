"""Assembly of bodies and springs: names, blocks, damping, and what is refused."""

import numpy as np
import pytest

from stickslip.model.structure.assembly import Spring, assemble
from stickslip.model.structure.matrices import ModalDamping, Structure
from stickslip.support.checks import InputError


def one_mass(mass: float, stiffness: float = 0.0, damping: float | None = None) -> Structure:
    C = None if damping is None else np.array([[damping]])
    return Structure(np.array([[mass]]), np.array([[stiffness]]), ("1.x",), C=C)


def test_two_bodies_and_a_spring():
    joined = Spring({"a/1.x": 1.0, "b/1.x": -1.0}, 7.0)
    whole = assemble({"a": one_mass(2.0, 5.0), "b": one_mass(3.0)}, [joined, Spring({"b/1.x": 1.0}, 1.0)])
    assert whole.dofs == ("a/1.x", "b/1.x")
    np.testing.assert_allclose(whole.M, np.diag([2.0, 3.0]))
    np.testing.assert_allclose(whole.K, [[12.0, -7.0], [-7.0, 8.0]])
    assert whole.C is None


@pytest.mark.parametrize(
    ("damping", "spring_damping", "expected"),
    [(0.4, 0.0, [[0.4, 0.0], [0.0, 0.0]]), (None, 0.3, [[0.3, -0.3], [-0.3, 0.3]]), (0.4, 0.3, [[0.7, -0.3], [-0.3, 0.3]])],
)
def test_damping_comes_from_bodies_and_springs(damping, spring_damping, expected):
    spring = Spring({"a/1.x": 1.0, "b/1.x": -1.0}, 7.0, spring_damping)
    whole = assemble({"a": one_mass(2.0, 5.0, damping), "b": one_mass(3.0)}, [spring])
    np.testing.assert_allclose(whole.C, expected)


def test_rules_are_set_on_the_whole():
    ruled = one_mass(1.0, 1.0).with_damping(ModalDamping(0.01))
    with pytest.raises(InputError, match=r"must not bring a damping rule.*with_damping"):
        assemble({"a": ruled})
    assert assemble({"a": one_mass(1.0)}).with_damping(ModalDamping(0.01)).damping == ModalDamping(0.01)


@pytest.mark.parametrize(
    ("direction", "stiffness", "message"),
    [
        ({"a/1.x": 1.0}, -1.0, "must not be negative"),
        ({}, 1.0, "must have a coefficient"),
        ({"a/1.x": float("inf")}, 1.0, "finite"),
    ],
)
def test_bad_springs_are_refused(direction, stiffness, message):
    with pytest.raises(InputError, match=message):
        Spring(direction, stiffness)


def test_unknown_degree_of_freedom_is_named():
    with pytest.raises(InputError, match=r"'a/2.x' does not exist. Did you mean 'a/1.x'"):
        assemble({"a": one_mass(1.0)}, [Spring({"a/2.x": 1.0}, 1.0)])
    with pytest.raises(InputError, match="must hold at least one structure"):
        assemble({})


def test_damping_that_feeds_energy_in_is_refused():
    with pytest.raises(InputError, match="must not feed energy in"):
        Structure(np.eye(2), np.eye(2), ("1.x", "2.x"), C=-0.02 * np.eye(2))
    gyroscopic = np.array([[0.02, 1.0], [-1.0, 0.02]])
    assert Structure(np.eye(2), np.eye(2), ("1.x", "2.x"), C=gyroscopic).C is not None


def test_a_set_of_one_node_may_be_called_by_its_name():
    """left/tip.x is left/tip/1430.x where tip has no other node; a name that exists keeps its meaning."""
    dofs = ("left/tip/1430.x", "left/tip/1430.y", "left/pad/1.x", "left/pad/2.x", "left/root/7.x", "left/root.x")
    whole = Structure(np.eye(6), np.eye(6), dofs)
    assert [whole.index(dof) for dof in ("left/tip.x", "left/tip.y", "left/tip/1430.x", "left/root.x")] == [0, 1, 0, 5]
    with pytest.raises(InputError, match=r"'left/pad\.x' does not exist"):
        whole.index("left/pad.x")


def test_a_misspelt_name_is_compared_with_those_of_its_structure():
    """right/tpi.x is as near to left/tip.x, which is of the other blade."""
    whole = Structure(np.eye(3), np.eye(3), ("left/tpj.x", "left/tip.x", "right/tip.x"))
    with pytest.raises(InputError, match=r"Did you mean 'right/tip\.x'"):
        whole.index("right/tpj.x")
    with pytest.raises(InputError, match=r"Did you mean 'left/tip\.x'"):
        whole.index("lft/tip.x")
