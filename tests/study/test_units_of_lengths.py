"""Every length of a study file is in the units of the file: the same table in mm-t-s and in SI makes the same body."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.study.analyses.damper_cycle import DamperTable
from stickslip.study.analyses.identification import IdentificationTable
from stickslip.study.build import body
from stickslip.study.fields import SYSTEMS, in_si
from stickslip.study.tables import BodyTable

MM = {"width": 24, "height": 6.0, "depth": 30.0, "density": 7.8e-9, "left_angle": 35.0, "lines": 2}
SI = {"width": 0.024, "height": 0.006, "depth": 0.03, "density": 7800.0, "left_angle": 35.0, "lines": 2}
AXES = ("x", "y", "z", "rx", "ry", "rz")


def wedge(units, dimensions):
    table = BodyTable.model_validate({"name": "damper", "shape": "wedge", "dimensions": dimensions})
    return body(table, SYSTEMS[units])[0]


def test_dimensions_of_a_body_are_in_the_units_of_the_file():
    """ρ times the trapezium times the depth, by hand; a wedge of 24 m had 3.6 million tonnes."""
    found, other = wedge("mm-t-s", MM), wedge("SI", SI)
    top = 0.024 - 0.006 / np.tan(np.radians(35.0)) - 0.006
    assert found.mass == pytest.approx(7800.0 * 0.03 * 0.006 * (0.024 + top) / 2, rel=1e-12)
    np.testing.assert_allclose(found.inertia, other.inertia, rtol=1e-12)
    np.testing.assert_allclose(found.outline, other.outline, rtol=1e-12)


def test_defaults_of_a_shape_do_not_depend_on_the_units():
    assert wedge("mm-t-s", {}).mass == wedge("SI", {}).mass


def test_masses_of_a_shape_are_in_those_of_the_file():
    """Tonnes: a laboratory damper of 20 g and its feet, 14 mm apart."""
    given = {"mass": 2e-5, "foot_distance": 14.0, "sides": [10.0, 12.0, 30.0]}
    values = {"shape": "crossed_curved_flat", "dimensions": given, "pull": 50.0, "kt": 2e4, "kn": 3e4, "mu": 0.3}
    rig = DamperTable.model_validate(values).rig(SYSTEMS["mm-t-s"])
    assert rig.damper.body.mass == pytest.approx(0.02)
    assert rig.damper.body.inertia[2, 2] == pytest.approx(0.02 * (0.010**2 + 0.012**2) / 12)


def test_lengths_of_an_identification():
    table = IdentificationTable.model_validate({"loops": ["a.csv"], "laser_distance": 12.0, "laser_offset": 3.0, "pulls": [4.0]})
    si = in_si(table, SYSTEMS["mm-t-s"])
    assert (si["laser_distance"], si["laser_offset"], si["pulls"]) == (pytest.approx(0.012), pytest.approx(0.003), [4.0])


@pytest.mark.parametrize(("side", "said"), [(24.0, "24 m wide"), (2.4e-5, "2.4e-05 m wide"), (0.024, "")])
def test_a_body_that_does_not_fit_its_model_is_warned_of(side, said):
    """Beside a blade of 0.12 m."""
    corners = side * np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.2, 0.0]])
    body = ss.RigidBody(0.02, np.diag([1e-6, 1e-6, 1e-6]), (0.0, 0.05, 0.0), outline=corners)
    blade = ss.Structure(np.eye(1), np.eye(1) * 1e6, ("tip.x",), nodes={"tip": (0.0, 0.12, 0.0), "root": (0.0, 0.0, 0.0)})
    whole = ss.assemble({"blade": blade, "damper": body.structure()}, [ss.Spring({f"damper/centre.{a}": 1.0}, 1e5) for a in AXES])
    contact = ss.Contact("c", ss.Macroslip(kt=1e5, mu=0.3, normal_load=5.0), ({"blade/tip.x": 1.0, "damper/centre.x": -1.0},))
    problem = ss.Problem(whole.with_damping(ss.ModalDamping(0.01)), (contact,), (ss.Force("blade/tip.x", 1.0),), ("blade/tip.x",))
    sizes = [sentence for sentence in problem.warnings if "do not fit" in sentence]
    assert (said in sizes[0] if sizes else False) == bool(said)
    assert len(sizes) == bool(said)
