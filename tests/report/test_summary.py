"""What `print` and notebooks show of a result, and what xarray draws of its dataset."""

import base64
import pkgutil
import re
from importlib import import_module

import numpy as np
import pytest
from matplotlib import use

import stickslip as ss
from stickslip import analyses
from stickslip.results.result import Result


@pytest.fixture(scope="module")
def response():
    return ss.forced_response(ss.rigs.three_mass_wedge(), ss.hertz(210, 230), [0.5, 1.0], harmonics=1, samples=64)


def highest(response):
    """Frequency of the highest peak of the first output, as it is printed."""
    peaks = response.peaks()
    return f"{peaks[peaks.output == response.dataset.output.values[0]].frequency.iloc[0]:g} Hz"


def test_a_result_prints_its_answer_in_a_few_lines(response):
    lines = str(response).splitlines()
    assert lines[0] == f"Forced response: {response.problem.title}"
    assert len(lines) < 8
    assert highest(response) in str(response)
    assert repr(response) == str(response)


def test_a_notebook_shows_answer_and_figure(response):
    page = response._repr_html_()
    assert highest(response) in page
    picture = base64.b64decode(re.search(r"data:image/png;base64,([^\"]+)", page).group(1))
    assert picture.startswith(b"\x89PNG")


def test_titles_cannot_leave_the_page_of_a_notebook():
    problem = ss.rigs.three_mass_wedge()
    hostile = ss.Problem(problem.structure, problem.contacts, problem.forces, problem.outputs, "<script>alert(1)</script>")
    page = ss.forced_response(hostile, [222.0], harmonics=1, samples=64)._repr_html_()
    assert "&lt;script&gt;" in page
    assert "<script>" not in page


def test_a_result_without_report_names_what_it_holds():
    freedom = ss.friction_freedom(ss.rigs.three_mass_wedge(), [222.0], harmonics=1, samples=64)
    assert "slope (point, element)" in str(freedom)
    assert "<img" in freedom._repr_html_()


def test_a_figure_is_a_picture_in_a_notebook(response):
    assert response.plot()._repr_png_().startswith(b"\x89PNG")


def test_xarray_draws_the_curves_over_frequency(response, tmp_path):
    use("agg")
    for dataset in (response.dataset, ss.open_results(response.save(tmp_path / "results.nc"))):
        lines = dataset.amplitude.isel(output=0).plot.line(x="frequency", hue="case")
        for case, line in enumerate(lines):
            np.testing.assert_array_equal(line.get_xdata(), dataset.frequency[case])
            np.testing.assert_array_equal(line.get_ydata(), dataset.amplitude[case, :, 0])


def test_every_result_prints_its_answer():
    """A dataclass writes a `__repr__` of its own unless it is asked not to."""
    for module in pkgutil.walk_packages(analyses.__path__, f"{analyses.__name__}."):
        for value in vars(import_module(module.name)).values():
            if isinstance(value, type) and issubclass(value, Result):
                assert value.__repr__ is Result.__repr__, value.__name__


def test_results_of_python_print_the_sentences_of_their_report():
    """Datasets made in Python name no analysis; the class does."""
    law = ss.contact_law([ss.ContactLoop(*_loop(amplitude), 5.0) for amplitude in (2e-5, 4e-5)], laws=["jenkins"])
    samples = ss.response_samples(ss.rigs.three_mass_wedge(), [222.0], starts=2, harmonics=1, samples=64)
    curve = ss.performance_curve(ss.rigs.blade_and_wedge(), [10.0, 20.0], friction=0.4, harmonics=1, samples=64)
    cycle = ss.damper_cycle(ss.rigs.laboratory_damper(), ss.dampers.in_phase(2e-5), steps=200)
    for result, words in ((law, "jenkins"), (samples, "peak"), (curve, "lowest"), (cycle, "a cycle")):
        lines = repr(result).splitlines()
        assert not lines[1].startswith("dataset:"), lines
        assert words in repr(result).lower()


def _loop(amplitude):
    turn = 2.0 * np.pi * np.arange(200) / 200
    u = amplitude * np.cos(turn)
    return u, ss.hysteresis_loop(ss.Macroslip(kt=1e6, mu=0.5, normal_load=5.0), u).force
