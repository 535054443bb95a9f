"""The picture of a deformed shape: its factor, its frames, its size in a page, and steps of moving pictures."""

import base64
import gzip
import json
import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

import stickslip as ss
from stickslip.analyses.solved_points import MOST_OF_A_WHEEL, SurfaceMotion
from stickslip.show.plots.deformed_shape import FRAMES, DeformedShape, save_vtu
from stickslip.show.report import write
from stickslip.show.report.markup import Charts
from stickslip.support.units import UnitSystem


@pytest.fixture(scope="module")
def response():
    return ss.forced_response(ss.rigs.single_blade(modes=20), [528.7], [20.0, 80.0], harmonics=1, samples=64)


@pytest.fixture(scope="module")
def shape(response):
    return response.deformed_shape(1, 0)


def test_the_factor_is_a_round_number_that_is_said(shape):
    factor = shape.magnification
    assert f"{factor:g}"[0] in "125"
    assert f"magnified {factor:g} times" in shape.note
    extent = np.ptp(shape.motion.points, axis=0).max()
    assert 0.03 < factor * shape.motion.amplitude.max() / extent <= 0.1
    assert f"largest {shape.motion.amplitude.max() * 1e6:.4g} µm" in shape.note


def test_frames_are_the_motion_of_one_period_from_the_largest_deflection_on(shape):
    """Those of plotly are x + m Re(u exp(iφ)), whatever the phase at which they begin; the first is the largest."""
    figure, motion = shape.to_plotly(), shape.motion
    assert len(figure.frames) == FRAMES
    drawn = np.array([np.stack([frame.data[0][axis] for axis in "xyz"], axis=1) for frame in figure.frames])
    moved = (drawn - motion.points) / shape.magnification
    np.testing.assert_allclose(moved[FRAMES // 2], -moved[0], atol=1e-5 * motion.amplitude.max())
    first = 2.0 / FRAMES * np.einsum("f,fpk->pk", np.exp(-2j * np.pi * np.arange(FRAMES) / FRAMES), moved)
    turn = np.vdot(motion.displacement, first) / np.vdot(motion.displacement, motion.displacement)
    assert abs(turn) == pytest.approx(1.0, abs=1e-5)
    np.testing.assert_allclose(first, turn * motion.displacement, atol=2e-5 * motion.amplitude.max())
    sizes = np.linalg.norm(moved, axis=(1, 2))
    assert sizes[0] == pytest.approx(sizes.max(), rel=1e-5)
    assert sizes.min() < 0.5 * sizes.max()
    np.testing.assert_allclose(np.stack([figure.data[0][axis] for axis in "xyz"], axis=1), drawn[0])
    np.testing.assert_allclose(figure.data[0].intensity, 1e6 * motion.amplitude, rtol=1e-6)
    for frame in (0, 7):
        np.testing.assert_allclose(shape.moved(frame), drawn[frame], atol=1e-6)
    with pytest.raises(ss.InputError, match="frame"):
        shape.moved(FRAMES)


def test_a_file_of_vtk_has_the_points_triangles_and_motion(response, tmp_path):
    shapes = {f"force {level:g}": response.deformed_shape(case, 0).motion for case, level in enumerate((20.0, 80.0))}
    first = replace(shapes["force 20"], system=UnitSystem("mm", "N", "t", "s"))
    path = save_vtu({"a <b>": first, **shapes}, tmp_path / "shape.vtu")
    tree = ElementTree.parse(path)
    arrays = {array.get("Name"): np.array(array.text.split(), dtype=float) for array in tree.iter("DataArray")}
    counts = {array.get("Name"): array.get("NumberOfComponents") for array in tree.iter("DataArray")}
    assert [counts[name] for name in ("points", "connectivity", "offsets", "types")] == ["3", "1", "1", "1"]
    piece = tree.find("UnstructuredGrid/Piece")
    assert (int(piece.get("NumberOfPoints")), int(piece.get("NumberOfCells"))) == (len(first.points), len(first.triangles))
    np.testing.assert_allclose(arrays["points"], 1e3 * first.points.ravel(), atol=1e-4)
    np.testing.assert_array_equal(arrays["connectivity"], first.triangles.ravel())
    np.testing.assert_array_equal(arrays["offsets"], 3.0 * np.arange(1, len(first.triangles) + 1))
    real, imaginary = (arrays[f"a <b>, {part} part [mm]"] for part in ("real", "imaginary"))
    np.testing.assert_allclose(real + 1j * imaginary, 1e3 * first.displacement.ravel(), rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(arrays["force 80, amplitude [mm]"], 1e3 * shapes["force 80"].amplitude, rtol=1e-6)
    with pytest.raises(ss.InputError, match="these results have none"):
        save_vtu({}, tmp_path / "none.vtu")


def test_a_shape_that_stands_still_is_drawn_at_rest():
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    still = DeformedShape(SurfaceMotion("still", corners, np.array([[0, 1, 2]]), np.zeros((3, 3), dtype=complex)))
    assert still.magnification == 1.0
    np.testing.assert_array_equal(still.moved(5), corners)
    still.to_plotly()
    still.plot()


def test_the_page_needs_nothing_else_and_has_steps(shape):
    page = shape.to_html()
    assert not re.findall(r"<(?:script|link|img)[^>]+(?:src|href)=", page)
    assert "stepper(div)" in page
    assert "one frame forward" in page
    assert shape._repr_html_().startswith("<iframe")


def test_the_picture_shows_the_amplitude(shape):
    figure = shape.plot()
    assert "amplitude in µm" in figure.axes[1].get_ylabel()
    assert shape.title.split(",")[0] in figure.get_suptitle()


@pytest.mark.nightly
def test_a_film_shows_every_frame_of_the_surface_and_a_page_can_be_saved(shape, tmp_path):
    """Frames of the film differ as the surface moves, half a period later it stands on the other side."""
    with Image.open(shape.save(tmp_path / "shape.gif", fps=10)) as film:
        assert film.n_frames == shape.frames == FRAMES
        pictures = []
        for frame in range(FRAMES):
            film.seek(frame)
            pictures.append(np.asarray(film.convert("L"), dtype=float))
    apart = [np.abs(picture - pictures[0]).mean() for picture in pictures]
    assert int(np.argmax(apart)) in range(FRAMES // 2 - 2, FRAMES // 2 + 3)
    assert apart[1] > 0.0
    assert "stepper(div)" in shape.save(tmp_path / "shape.html").read_text()
    with pytest.raises(ss.InputError, match=r"must end in \.gif, \.webp, \.mp4, \.html"):
        shape.save(tmp_path / "shape.avi")


def test_reports_hold_the_shapes(response, tmp_path):
    page = write({"blade": response.with_motion().dataset}, tmp_path / "report.html").read_text()
    data = json.loads(gzip.decompress(base64.b64decode(re.search(r'id="data">(.*?)</script>', page).group(1))))
    (place,) = data["places"]["chart-shape"]
    assert place["choices"] == [{"name": "Force level", "options": ["20 N", "80 N"]}]
    assert "largest" in place["charts"][1]["note"]
    assert "Drag it to turn it" in page


def test_the_largest_shapes_take_less_than_three_megabytes_of_a_report():
    """A disk of the most points that are drawn whole, at as many force levels as a result keeps."""
    rng = np.random.default_rng(1)
    points = rng.normal(size=(MOST_OF_A_WHEEL, 3))
    triangles = rng.integers(0, len(points), (2 * len(points), 3))
    shapes = [
        DeformedShape(SurfaceMotion(f"{k} N", points, triangles, rng.normal(size=(len(points), 3)) * (1.0 + 2.0j * k)))
        for k in range(4)
    ]
    charts = Charts(["a"])
    for k, shape in enumerate(shapes):
        charts.place(f"chart-{k}", lambda shape=shape: shape)
    assert len(json.dumps(charts.data())) < 3e6
