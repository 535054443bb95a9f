"""Animations: pages without links, films that can be read back, a factor that is said."""

import re
import shutil
import sys

import numpy as np
import pytest
from PIL import Image

import stickslip as ss
from stickslip.support.checks import InputError


@pytest.fixture(scope="module")
def animation():
    problem = ss.rigs.blade_and_wedge()
    return ss.forced_response(problem, [320.0], 20.0, harmonics=3, samples=24).animate(0, 0)


def test_magnification_is_a_round_number_that_is_said(animation):
    factor = animation.magnification
    assert f"{factor:g}"[0] in "125"
    assert f"magnified {factor:g} times" in animation.note
    largest = max(np.abs(body.motion[:, :2]).max() for body in animation.motion.bodies)
    extent = np.ptp(animation.motion.bodies[0].corners, axis=0).max()
    assert factor * largest < 0.2 * extent


def test_frames_move_what_a_period_moves(animation):
    """The dots lie on their loops, and the first frame is what is drawn without playing."""
    figure = animation.to_plotly()
    assert len(figure.frames) == animation.frames == 24
    number, dot = [k for k, trace in enumerate(figure.data) if trace.xaxis == "x2"][:2]
    loop = figure.data[number]
    for k, frame in enumerate(figure.frames):
        moved = frame.data[list(frame.traces).index(dot)]
        assert (moved.x[0], moved.y[0]) == (loop.x[k], loop.y[k])


def test_on_a_narrow_screen_no_line_of_the_title_is_longer_than_it(animation):
    lines = animation.to_plotly(narrow=True).layout.title.text.split("<br>")
    assert max(len(re.sub("<[^>]+>", "", line)) for line in lines if line.startswith("<b>")) <= 42
    words = " ".join(re.sub("<[^>]+>", "", line) for line in lines)
    assert words == f"{animation.title} {animation.note}"


def test_the_page_needs_nothing_else(animation):
    page = animation.to_html()
    assert not re.findall(r"<(?:script|link|img)[^>]+(?:src|href)=", page)
    assert animation._repr_html_().startswith("<iframe")


@pytest.mark.slow
def test_a_film_has_all_frames_and_other_names_are_refused(tmp_path):
    animation = ss.forced_response(ss.rigs.blade_and_wedge(), [320.0], 20.0, harmonics=1, samples=8).animate(0, 0)
    with Image.open(animation.save(tmp_path / "x.gif")) as film:
        assert film.n_frames == animation.frames == 8
    with pytest.raises(InputError, match=r"must end in \.gif"):
        animation.save(tmp_path / "x.avi")


@pytest.mark.parametrize("fps", [0, -5, float("nan"), float("inf"), 1001, "20", True])
def test_wrong_speeds_of_a_film_are_refused(animation, tmp_path, fps):
    with pytest.raises(InputError, match="fps must"):
        animation.save(tmp_path / "x.gif", fps)
    assert not list(tmp_path.iterdir())


@pytest.mark.nightly
def test_a_film_makes_its_folder_and_says_where_it_cannot_be_written(animation, tmp_path):
    assert animation.save(tmp_path / "new" / "x.gif", 0.01).stat().st_size
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"The film .*x\.gif could not be written"):
        animation.save(tmp_path / "file" / "x.gif")
    (tmp_path / "y.html").mkdir()
    with pytest.raises(InputError, match=r"The page .*y\.html could not be written"):
        animation.save(tmp_path / "y.html")


def test_a_problem_without_sections_shows_loops_and_one_without_contacts_is_refused():
    response = ss.forced_response(ss.rigs.single_mass(), [0.2], harmonics=3, samples=32)
    animation = response.animate(0, 0)
    assert animation.panels == ("loops",)
    assert len(animation.description()["frames"]) == 32
    free = ss.Problem(ss.Structure([[1.0]], [[1.0]], ("m.x",), C=[[0.1]]), (), (ss.Force("m.x", 1.0),), ("m.x",))
    with pytest.raises(InputError, match="must have contacts"):
        ss.forced_response(free, [0.2]).animate(0, 0)


@pytest.mark.nightly
def test_ffmpeg_writes_a_film(animation, tmp_path):
    film = animation.save(tmp_path / "x.mp4").read_bytes()
    assert film[4:8] == b"ftyp"


def test_without_ffmpeg_a_film_is_refused_with_the_remedy(animation, tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(InputError, match=r"stickslip\[film\]"):
        animation.save(tmp_path / "x.mp4")
    assert not list(tmp_path.iterdir())


def test_a_program_in_the_working_folder_is_not_run(animation, tmp_path, monkeypatch):
    """On Windows a search for ffmpeg begins there, and finds it by a path without a root."""
    (tmp_path / "ffmpeg.bat").write_text("echo ran > marks")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(shutil, "which", lambda name: "./ffmpeg.bat")
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(InputError, match=r"stickslip\[film\]"):
        animation.save("x.mp4")


def test_blades_of_a_mistuned_wheel_have_amplitudes_and_colours_of_their_own():
    """The amplitudes are half the travel of each blade's own output; blades of one colour are within an eighth of the largest."""
    deviation = [0.02, -0.03, 0.01, 0.0, 0.025, -0.015]
    disk = ss.mistuned_disk(ss.rigs.lumped_blisk("W", engine_order=2, sectors=6), ss.Mistuning(blade=deviation))
    response = ss.forced_response(disk, [149.0], 0.4, harmonics=3, samples=48)
    animation = response.animate(0, 0)
    wheel = animation.motion.wheel
    first = response.dataset["amplitude"][0, 0].to_numpy()
    assert len(wheel.amplitude) == len(first) == 6
    np.testing.assert_allclose(wheel.amplitude, first, rtol=2e-2)  # a third harmonic and the samples between
    assert np.ptp(first) > 0.2 * first.max()
    steps = {f"level {min(int(8 * a / wheel.amplitude.max()), 7)}/8" for a in wheel.amplitude}
    drawn = {part.colour for part in animation.parts if part.panel == "wheel" and part.colour.startswith("level")}
    assert drawn == steps
    assert len(drawn) > 1
