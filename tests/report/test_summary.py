"""What `print` and notebooks show of a result, and what xarray draws of its dataset."""

import base64
import pkgutil
import re
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from matplotlib import use

import stickslip as ss
from stickslip import analyses, laboratory
from stickslip.results.quantities import NOT_JUDGED
from stickslip.results.schema import Result
from stickslip.show.report.answer import comparison, failures_of, peaks_at_a_glance, warnings_of
from stickslip.show.report.markup import presentation_of
from stickslip.show.report.nonlinear_modes import PRESENTATION
from stickslip.show.report.page import _sentence, common_title
from stickslip.support.checks import rounded


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
    assert len(lines) <= 8  # the last says where detached curves were sought
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
    history = ss.response_history(ss.rigs.three_mass_wedge(), [222.0], [1.0, 2.0, 1.0], harmonics=1, samples=64)
    assert "largest_amplitude (run, output)" in str(history)
    assert "<img" in history._repr_html_()


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
    for room in (analyses, laboratory):
        for module in pkgutil.walk_packages(room.__path__, f"{room.__name__}."):
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


def test_a_result_prints_what_failed(response):
    """Curves that did not reach the end of their band, of which the complete ones say nothing."""
    assert "failed" not in str(response)
    message = "The curve closed on itself. It got to 214 Hz."
    held = ss.controlled_response(ss.rigs.three_mass_wedge(), ss.hertz(210, 230), [1e-6], harmonics=1, samples=64)
    for result, name in ((response, "force × 0.5"), (held, "1e-06 m/s²")):
        assert "failed" not in str(result)
        dataset = result.dataset.copy()
        dataset["case_outcome"] = dataset["case_outcome"].copy(data=[2, *dataset["case_outcome"].values[1:]])
        messages = np.array([message, *dataset["case_message"].values[1:]], dtype=object)
        dataset["case_message"] = dataset["case_message"].copy(data=messages)
        assert f"failed: {name}: {message}" in str(replace(result, dataset=dataset))
        assert message in replace(result, dataset=dataset)._repr_html_()


def test_a_curve_that_is_higher_at_its_end_than_at_its_peak_says_so():
    """A hardening mass with an absorber: one resonance inside the band, and a higher one beyond it."""
    m, k, c = 0.06, 0.055, 0.008
    K, C = (np.array([[one, -two], [-two, two]]) for one, two in ((1.0 + k, k), (0.001 + c, c)))
    structure = ss.Structure(np.diag([1.0, m]), K, ("1.x", "2.x"), C=C)
    spring = ss.Contact("spring", ss.CubicSpring(1.2), (ss.between("1.x", "ground"),))
    problem = ss.Problem(structure, (spring,), (ss.Force("1.x", 1.0),), ("1.x",))
    found = ss.forced_response(problem, ss.radians_per_second(0.7, 2.0), [0.05, 0.1], harmonics=3, samples=64, isolated=False)
    dataset = found.dataset
    peak, end = float(dataset.peak_amplitude[1, 0, 0]), float(dataset.amplitude[1, :, 0].max())
    assert end > 2.0 * peak
    line = next(line for line in str(found).splitlines() if line.startswith("  force 0.1"))
    assert line.endswith(f"higher at an end of the curve, {float(dataset.frequency[1].max()):.5g} Hz: {end:.4g} m")
    assert "higher at" not in next(line for line in str(found).splitlines() if line.startswith("  force 0.05"))
    (warning,) = (one for one in warnings_of(dataset) if "larger at an end of its curve" in one)
    assert warning.startswith("0.1 N: 1.x")
    low, high = comparison({"a": dataset, "b": dataset.assign(peak_amplitude=2.0 * dataset["peak_amplitude"])}).split("At ")
    assert "a at 0.05\xa0N" in low
    assert high.startswith("0.1\xa0N the order of the peaks is open"), "a higher peak may lie beyond the end"


def test_a_curve_that_broke_off_is_not_compared_with_those_that_did_not():
    """An undamped mass whose slider cannot bound its resonance above a force of 4 μN/π: its curve ends on the flank of the peak,
    which was called the lowest response, 98 % below the linear peak."""
    slider = ss.Contact("slider", ss.Macroslip(kt=0.5, mu=0.5, normal_load=1.0), (ss.between("1.x", "ground"),))
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",))
    problem = ss.Problem(structure, (slider,), (ss.Force("1.x", 1.0),), ("1.x",))
    found = ss.forced_response(problem, ss.radians_per_second(0.5, 2.0), [0.3, 0.5, 1.0], harmonics=1).dataset
    assert found.case_outcome.values.tolist() == [1, 1, 2]
    assert np.isfinite(found.peak_amplitude.values[:2]).any(axis=(1, 2)).all()
    assert not np.isfinite(found.peak_amplitude.values[2]).any(), "a curve has no peak where it is lost"
    table = peaks_at_a_glance("a", found)
    assert table.count("the curve broke off") == table.count("cannot be judged") == 1
    (failure,) = [words for words in failures_of(found) if "did not reach the end of the band" in words]
    assert failure.startswith("1 N: ")
    lower = found.assign(peak_amplitude=0.5 * found["peak_amplitude"], amplitude=0.5 * found["amplitude"])
    assert "At 1\xa0N the order of the peaks is open" in comparison({"a": found, "b": lower})


def test_of_many_failures_the_first_are_printed(response):
    dataset = response.dataset.isel(case=[0] * 9).copy()
    dataset["case_outcome"] = dataset["case_outcome"].copy(data=np.full(9, 2))
    lines = str(replace(response, dataset=dataset)).splitlines()
    assert sum(line.startswith("failed: force") for line in lines) == 5
    assert lines[-1] == "failed: 4 more; the report has them"


def _loop(amplitude):
    turn = 2.0 * np.pi * np.arange(200) / 200
    u = amplitude * np.cos(turn)
    return u, ss.hysteresis_loop(ss.Macroslip(kt=1e6, mu=0.5, normal_load=5.0), u).force


def test_a_structure_that_stuck_contacts_do_not_stiffen_is_compared_with_itself_once():
    structure = ss.Structure(np.diag([1.0, 1.0]), np.array([[2.0, -1.0], [-1.0, 2.0]]), ("1.x", "2.x"), C=0.05 * np.eye(2))
    spring = ss.Contact("spring", ss.CubicSpring(0.5), (ss.between("1.x", "ground"),))
    problem = ss.Problem(structure, (spring,), (ss.Force("1.x", 1.0),), ("1.x",))
    found = ss.forced_response(problem, ss.radians_per_second(0.5, 2.5), 0.05, harmonics=1, samples=64).dataset
    table = peaks_at_a_glance("a", found)
    assert "Against no contacts" in table
    assert "stuck" not in table


def test_modes_print_the_peaks_of_their_force_levels_first():
    modes = ss.nonlinear_modes(ss.rigs.single_mass(), amplitude=(0.9, 3.0), harmonics=1, samples=64).dataset
    levels = np.array([0.1, 0.2])
    about = {"level_frequency": [0.2, 0.19], "level_amplitude": [1.5, np.nan]}
    data = modes.assign({name: (("case", "force_level"), [values]) for name, values in about.items()})
    data = data.assign_coords(force_level=levels)
    lines = PRESENTATION.sentences(data)
    assert sum(line.startswith("  force ") for line in lines) == 1
    assert "force 0.1: " in lines[1]
    assert "1.5 m, 0.2 Hz" in lines[1]
    assert list(PRESENTATION.tables(data)) == ["peaks of force levels", "nonlinear modes"]


def test_a_symbol_at_the_start_of_a_sentence_stays_as_it_is():
    said = ("kt = 3 N/m", "mu ≥ 0.3: no contact slips", "mu_R: its contact never slides", "worst-case resonance")
    assert [_sentence(line) for line in said] == [
        "kt = 3 N/m.",
        "mu ≥ 0.3: no contact slips.",
        "mu_R: its contact never slides.",
        "Worst-case resonance.",
    ]


def test_rounded_numbers_have_no_exponents_that_nobody_writes():
    pairs = [(123.4, 2, "120"), (10730.5, 4, "10730"), (5.0, 2, "5"), (0.0012345, 3, "0.00123"), (-999.7, 3, "-1000")]
    assert [rounded(value, digits) for value, digits, _ in pairs] == [shown for *_, shown in pairs]


def test_that_no_stability_was_judged_is_said_once(response):
    """On the console and in the headline, where it would stand on every line; undecided peaks are named one by one."""
    data = response.dataset.copy(deep=True)
    for flag, once, on_lines in ((0, 1, 0), (3, 0, 2)):
        data["highest_stability"].values[:] = flag
        lines = presentation_of(data).sentences(data)
        assert sum(NOT_JUDGED in line for line in lines) == once
        assert sum(", stability undecided" in line for line in lines) == on_lines
        assert (NOT_JUDGED in peaks_at_a_glance("a", data)) == bool(once)


@pytest.mark.parametrize(
    ("titles", "title"),
    [
        (["One blade"], "One blade"),
        (["One blade, 2.6 kg", "One blade, 4.6 kg"], "One blade: 2.6 kg, 4.6 kg"),
        (["One blade", "A disk"], "One blade · A disk"),
        (["One blade", "One blade with a wedge"], "One blade · One blade with a wedge"),
    ],
)
def test_a_report_of_several_results_has_one_title(titles, title):
    assert common_title(titles) == title
