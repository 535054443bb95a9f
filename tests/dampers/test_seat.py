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


def test_what_is_given_is_kept_and_between_equal_slopes_out_is_in_the_middle():
    turn, centre = turned(7)
    wedge = Wedge(width=20e-3, height=5e-3, depth=30e-3, left_angle=40.0, right_angle=40.0)
    seat = Seat.between(*faces(wedge, turn, centre))
    assert seat.axes == pytest.approx(turn, abs=1e-9)
    given = seat.dimensions(Wedge, {"width": 10e-3})
    assert "width" not in given
    small = Wedge(**{**given, "width": 12e-3, "height": 4e-3, "depth": 10e-3})
    moved = turn @ (seat.centre(small) - centre)
    assert moved[[0, 2]] == pytest.approx(0.0, abs=1e-12)
    assert moved[1] > 1e-3  # a smaller wedge lies nearer to the ridge


@pytest.mark.parametrize("kind", SHAPES)
def test_every_shape_touches_both_platforms(kind):
    turn, centre = turned(3)
    platforms = faces(WEDGE, turn, centre)
    seat = Seat.between(*platforms, turn[1])
    given = seat.dimensions(SHAPES[kind], {})
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
        Seat.between(left, left + 0.03 * turn[0])
    with pytest.raises(InputError, match="lie opposite each other"):
        Seat.between(left, right + 0.05 * turn[2])
    with pytest.raises(InputError, match=r"must lie in \[0, 90\) degrees"):
        Seat.between(left, right, -turn[1])
