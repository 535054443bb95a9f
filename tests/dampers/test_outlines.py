"""The outlines by which dampers are drawn: their area and centroid are those of the body, and contacts stand on them."""

import numpy as np
import pytest

from stickslip.model.dampers import SHAPES


def area_and_centroid(corners):
    """Of a polygon (k, 2), by triangles from its first corner."""
    a, b = corners[1:-1] - corners[0], corners[2:] - corners[0]
    areas = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    return areas.sum(), corners[0] + (areas[:, None] * (a + b) / 3.0).sum(axis=0) / areas.sum()


def distance(corners, place):
    """Of a point from the edges of a polygon."""
    ends = np.roll(corners, -1, axis=0) - corners
    share = np.clip(np.sum((place - corners) * ends, axis=1) / np.sum(ends**2, axis=1), 0.0, 1.0)
    return np.linalg.norm(corners + share[:, None] * ends - place, axis=1).min()


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("shape", SHAPES.values())
def test_an_outline_holds_the_contacts_on_its_edge(shape, side):
    """To the 0.2 % of the radius by which a polygon lies inside its arcs; flats that cross a cylinder lie inside."""
    damper = shape(left_angle=40.0, right_angle=48.0).damper(centre=(0.02, 0.08, 0.0), side=side, pull=10.0)
    corners = np.asarray(damper.body.outline)[:, :2] + [0.02, 0.08]
    area, _ = area_and_centroid(corners)
    assert area > 0.0
    crossed = shape.__name__ == "CrossedCurvedFlat"
    for surface in damper.surfaces:
        for place in np.asarray(surface.points)[:, :2]:
            assert distance(corners, place) < (4e-3 if crossed else 3e-5)


@pytest.mark.parametrize("shape", [shape for shape in SHAPES.values() if hasattr(shape(), "density")])
def test_area_and_centroid_of_an_outline_are_those_of_the_body(shape):
    dimensions = shape(left_angle=40.0, right_angle=48.0)
    body = dimensions.body()
    area, centroid = area_and_centroid(np.asarray(body.outline)[:, :2])
    assert area == pytest.approx(body.mass / (dimensions.density * dimensions.depth), rel=4e-3)
    np.testing.assert_allclose(centroid, 0.0, atol=3e-5)
