"""A damper between two platforms, from points on them, against shapes that were placed by hand and turned at random."""

import numpy as np
import pytest

from stickslip.model.dampers import SHAPES, Wedge
from stickslip.model.dampers.damper import outward
from stickslip.model.dampers.seat import Seat
from stickslip.support.checks import InputError

WEDGE = Wedge(width=24e-3, height=7e-3, depth=31e-3, left_angle=35.0, right_angle=50.0)


def turned(seed):
    """Axes of a body, rows, and its mass centre, in a model that lies anyhow."""
    draw = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(draw.standard_normal((3, 3)))
    turn[2] *= np.sign(np.linalg.det(turn))
    return turn, 0.3 * draw.standard_normal(3)


def faces(wedge, turn, centre, scatter=0.0):
    """Points on both faces of a wedge, in the model."""
    base, draw = wedge.section(), np.random.default_rng(1)
    corners = wedge.corners() - base.centroid
    rows = []
    for low, high, angle, side in ((0, 3, wedge.left_angle, -1), (1, 2, wedge.right_angle, 1)):
        along = corners[low] + np.linspace(0.0, 1.0, 7)[:, None] * (corners[high] - corners[low])
        points = np.array([(*place, z) for place in along for z in wedge.depth * np.linspace(-0.5, 0.5, 9)])
        points[:, :2] += scatter * draw.uniform(-1.0, 1.0, (len(points), 1)) * outward(angle, side)
        rows.append(centre + points @ turn)
    return rows


@pytest.mark.parametrize("seed", range(5))
def test_a_wedge_is_found_again(seed):
    """Slopes, base, height, depth, axes and mass centre; with nodes a little off the planes, nearly."""
    turn, centre = turned(seed)
    for scatter, within in ((0.0, 1e-9), (1e-6, 1e-3)):
        seat = Seat.between(*faces(WEDGE, turn, centre, scatter), 3.0 * turn[1] + turn[2])  # not quite across the depth
        given = seat.dimensions(Wedge, {})
        for name, value in given.items():
            assert value == pytest.approx(getattr(WEDGE, name), rel=within), name
        assert set(given) == {"width", "height", "depth", "left_angle", "right_angle"}
        assert seat.axes == pytest.approx(turn, abs=within)
        assert seat.centre(Wedge(**given)) == pytest.approx(centre, abs=10.0 * within * WEDGE.width)


def test_a_smaller_wedge_lies_nearer_to_the_ridge_and_a_narrower_one_is_as_low():
    turn, centre = turned(7)
    wedge = Wedge(width=20e-3, height=5e-3, depth=30e-3, left_angle=40.0, right_angle=30.0)
    seat = Seat.between(*faces(wedge, turn, centre), turn[1])
    assert "width" not in seat.dimensions(Wedge, {"width": 10e-3})
    small = Wedge(width=12e-3, height=2e-3, depth=10e-3, left_angle=40.0, right_angle=30.0)
    edges = turn @ (seat.centre(small) - centre) + np.pad(small.corners() - small.section().centroid, ((0, 0), (0, 1)))
    whole = wedge.corners() - wedge.section().centroid
    slants = np.tan(np.radians((40.0, 30.0)))
    assert (edges[0, 1] - whole[0, 1]) / (edges[0, 0] - whole[0, 0]) == pytest.approx(slants[0])
    assert (edges[1, 1] - whole[1, 1]) / (whole[1, 0] - edges[1, 0]) == pytest.approx(slants[1])
    assert edges[0, 1] > whole[0, 1] + 1e-3
    # With its width alone it ends where the platforms end: 20 mm less 16 mm over both cotangents is lost of 5 mm.
    assert seat.narrower(16e-3) == pytest.approx(5e-3 - 4e-3 / np.sum(1.0 / slants))
    low = Wedge(**seat.dimensions(Wedge, {"width"}) | {"width": 16e-3, "height": seat.narrower(16e-3)})
    top = turn @ (seat.centre(low) - centre) + np.pad(low.corners() - low.section().centroid, ((0, 0), (0, 1)))
    assert top[2, 1] == pytest.approx(whole[2, 1])


def test_shallow_and_steep_platforms_have_their_slopes():
    """Of 5 and 40 degrees, lower edges level: the line between the middles lies above the shallow one."""
    turn, centre = turned(4)
    wedge = Wedge(width=60e-3, height=3e-3, depth=30e-3, left_angle=5.0, right_angle=40.0)
    left, right = faces(wedge, turn, centre)
    assert Seat.between(left, right, turn[1]).slopes == pytest.approx((5.0, 40.0))
    assert Seat.between(right, left, turn[1]).slopes == pytest.approx((40.0, 5.0))


@pytest.mark.parametrize("kind", [kind for kind in SHAPES if kind != "crossed_curved_flat"])
def test_every_shape_touches_both_platforms(kind):
    """But the one whose lines lie beyond platforms of this size."""
    turn, centre = turned(3)
    wide = Wedge(width=60e-3, height=25e-3, depth=31e-3, left_angle=35.0, right_angle=50.0)
    platforms = faces(wide, turn, centre)
    seat = Seat.between(*platforms, turn[1])
    given = seat.dimensions(SHAPES[kind], {})
    assert kind == "wedge" or "height" not in given
    shape = SHAPES[kind](**given)
    place = seat.centre(shape)
    for touch, angle, points in zip((shape.left(), shape.right()), (35.0, 50.0), platforms, strict=True):
        assert touch.angle == pytest.approx(angle)
        normal = np.linalg.svd(points - points.mean(axis=0))[2][2]
        off = (place + np.asarray(touch.points) @ seat.axes - points.mean(axis=0)) @ normal
        assert np.abs(off).min() < 1e-12


def test_platforms_that_hold_no_damper_are_refused():
    turn, centre = turned(2)
    left, right = faces(WEDGE, turn, centre)
    with pytest.raises(InputError, match="inclined platforms"):
        Seat.between(left, left + 0.03 * turn[0], turn[1])
    with pytest.raises(InputError, match="lie opposite each other"):
        Seat.between(left, right + 0.05 * turn[2], turn[1])
    with pytest.raises(InputError, match=r"must lie in \[0, 90\) degrees"):
        Seat.between(left, right, -turn[1])
    with pytest.raises(InputError, match="must point to the ridge"):
        Seat.between(left, right, turn[2] + 0.01 * turn[1])
    with pytest.raises(InputError, match="at least three nodes"):
        Seat.between(left[:2], right, turn[1])
    with pytest.raises(InputError, match="a line of nodes"):
        Seat.between(left[:9], right, turn[1])
    bulge = 1e-3 * np.cos(np.linspace(-1.5, 1.5, len(left)))[:, None] * turn[1]
    with pytest.raises(InputError, match="must be flat"):
        Seat.between(left + bulge, right, turn[1])


def test_a_damper_that_falls_through_or_juts_out_is_refused():
    turn, centre = turned(2)
    seat = Seat.between(*faces(WEDGE, turn, centre), turn[1])
    for radius in (0.5e-3, 40e-3):
        with pytest.raises(InputError, match="mm beyond its ends"):
            seat.centre(SHAPES["cylinder"](radius=radius, left_angle=35.0, right_angle=50.0))
