"""Grid points of Nastran in rectangular, cylindrical and spherical systems, against places worked out by hand."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.models.nastran_grid import read_grid


def deck(folder, text):
    path = folder / "blade.bdf"
    path.write_text(text)
    return read_grid(path)


def test_cylindrical_and_spherical_coordinates(tmp_path):
    """Axis along z, θ from the x axis: (2, 90°, 3) is (0, 2, 3); (2, 90°, 90°) of the sphere is (0, 2, 0)."""
    found = deck(
        tmp_path,
        "CORD2C,5,,0.,0.,0.,0.,0.,1.,\n,1.,0.,0.\nCORD2S,6,0,0.,0.,0.,0.,0.,1.,\n,1.,0.,0.\n"
        "GRID,1,5,2.,90.,3.\nGRID,2,6,2.,90.,90.\nGRID,3,6,2.,0.,17.\nGRID,4,,.1,.2,.3\n",
    )
    assert found.nodes["1"] == pytest.approx((0.0, 2.0, 3.0), abs=1e-14)
    assert found.nodes["2"] == pytest.approx((0.0, 2.0, 0.0), abs=1e-14)
    assert found.nodes["3"] == pytest.approx((0.0, 0.0, 2.0), abs=1e-14)
    assert found.nodes["4"] == (0.1, 0.2, 0.3)
    assert found.notes == ()


def test_systems_in_systems_whatever_their_order(tmp_path):
    """System 8 has its origin at r = 1, θ = 90° of system 7 and axes turned with it by its own points; 9 lies at grid points."""
    found = deck(
        tmp_path,
        "CORD1R,9,11,12,13\n"
        "CORD2R,8,7,1.,90.,0.,1.,90.,1.,\n,2.,90.,0.\n"
        "CORD2C,7,0,10.,0.,0.,10.,0.,1.,\n,11.,0.,0.\n"
        "GRID,1,8,1.,0.,0.\nGRID,2,8,0.,1.,0.\nGRID,3,9,0.,0.,2.\n"
        "GRID,11,8,0.,0.,0.\nGRID,12,8,1.,0.,0.\nGRID,13,8,0.,0.,1.\n",
    )
    assert found.nodes["1"] == pytest.approx((10.0, 2.0, 0.0), abs=1e-13)
    assert found.nodes["2"] == pytest.approx((9.0, 1.0, 0.0), abs=1e-13)
    assert found.nodes["3"] == pytest.approx((10.0, 3.0, 0.0), abs=1e-13)


def test_defaults_of_all_grid_points(tmp_path):
    """GRDSET fills what a GRID entry leaves blank; a 0 is the basic system."""
    found = deck(
        tmp_path, "CORD2R,4,,0.,0.,5.,0.,0.,6.,\n,1.,0.,5.\nGRDSET,,4,,,,4\nGRID,1,,1.,2.,3.\nGRID,80000000001,0,1.,2.,3.,0\n"
    )
    assert found.nodes["1"] == pytest.approx((1.0, 2.0, 8.0))
    assert found.nodes["80000000001"] == (1.0, 2.0, 3.0)
    assert found.notes == ("1 grid points of blade.bdf move in coordinate systems of their own: x, y, z are those directions.",)


@pytest.mark.parametrize(
    "systems", ["", "CORD2R,7,8,0.,0.,0.,0.,0.,1.,\n,1.,0.,0.\nCORD2R,8,7,0.,0.,0.,0.,0.,1.,\n,1.,0.,0.\n", "CORD1R,7,1,2,3\n"]
)
def test_grid_points_in_systems_that_are_not_known(tmp_path, systems):
    found = deck(tmp_path, systems + "GRID,1,7,1.,1.,1.\nGRID,2,,1.,0.,1.\n")
    assert list(found.nodes) == ["2"]
    assert found.notes == ("1 grid points of blade.bdf are left out: their coordinate systems are not in the file.",)


def test_points_in_line_are_no_system(tmp_path):
    with pytest.raises(ss.InputError, match=r"Coordinate system 7 must be given by three points that are not in line"):
        deck(tmp_path, "CORD2R,7,,0.,0.,0.,0.,0.,1.,\n,0.,0.,2.\nGRID,1,7,1.,1.,1.\n")


def test_many_systems_in_a_row_end(tmp_path):
    """Each refers to the one after it: those beyond the hundredth are left out, in bounded time."""
    chain = "".join(f"CORD2R,{k},{k + 1},0.,0.,1.,0.,0.,2.,\n,1.,0.,1.\n" for k in range(1, 300))
    last = "CORD2R,300,0,0.,0.,1.,0.,0.,2.,\n,1.,0.,1.\n"
    found = deck(tmp_path, chain + last + "GRID,1,1,0.,0.,0.\nGRID,2,260,0.,0.,0.\n")
    assert found.nodes.keys() == {"2"}
    np.testing.assert_allclose(found.nodes["2"], (0.0, 0.0, 41.0))
