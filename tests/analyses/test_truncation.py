"""The estimate of what more harmonics would change at a highest peak, against solutions with more of them, and its warning."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.analyses import truncation
from stickslip.analyses.truncation import truncation_warning
from stickslip.report.failures import warnings_of
from stickslip.report.responses import sentences

CASES = {
    "one mass": (ss.rigs.single_mass(), ss.radians_per_second(0.5, 2.0), 1.3, (1, 3, 5)),
    "wedge": (ss.rigs.three_mass_wedge(), ss.hertz(200.0, 235.0), 1.0, (3, 5)),
}


def first(dataset, point):
    return complex(*dataset.response.values[0, point, 0, 1])


@pytest.mark.parametrize(("name", "harmonics"), [(name, H) for name, case in CASES.items() for H in case[3]])
def test_the_estimate_is_the_change_with_many_harmonics(name, harmonics):
    problem, band, level, _ = CASES[name]
    found = ss.forced_response(problem, band, level, harmonics=harmonics)
    point, frequency = found.peak_point(), float(found.dataset.peak_frequency[0, 0, 0])
    many = ss.forced_response(problem, [frequency], level, harmonics=31).dataset
    change = abs(first(many, 0) - first(found.dataset, point)) / abs(first(found.dataset, point))
    assert float(found.dataset.truncation_error[0, 0]) == pytest.approx(change, rel=0.35)


def test_a_linear_structure_leaves_nothing_out_and_an_output_at_rest_has_no_error():
    structure = ss.Structure(np.eye(2), 2.0 * np.eye(2), ("1.x", "2.x"), damping=ss.ModalDamping(0.01))
    linear = ss.Problem(structure, (), (ss.Force("1.x", 1.0),), ("1.x", "2.x"))
    found = ss.forced_response(linear, ss.hertz(0.1, 0.4))
    np.testing.assert_allclose(found.dataset.truncation_error, 0.0, atol=1e-12)
    assert str(found.dataset.case_message.values[0]) == "The curve reached the end of the band."


def test_too_few_harmonics_are_a_warning():
    problem, band, _, _ = CASES["one mass"]
    found = ss.forced_response(problem, band, [1.0, 1.3, 100.0], harmonics=1).dataset
    errors = found.truncation_error.values[:, 0]
    assert np.all(errors[:2] > 0.01)
    assert errors[2] < 0.004
    words = f"More than 1 harmonic would change 1.x at its highest peak by about {100 * errors[0]:.1f} %: take more"
    assert words in str(found.case_message.values[0])
    assert "harmonic" not in str(found.case_message.values[2])
    assert any(words in sentence for sentence in warnings_of(found))
    (line,) = [line for line in sentences(found) if "More than" in line]
    assert line.startswith("warning, force 1: ")
    assert line.endswith("(2 of 3 force levels above 0.4 %)")
    enough = ss.forced_response(problem, band, 1.3, harmonics=5).dataset
    assert not [line for line in sentences(enough) if "More than" in line]
    assert warnings_of(enough) == []


def test_every_output_has_its_own_and_lists_count_at_their_largest_point():
    found = ss.forced_response(ss.rigs.three_mass_wedge(), [215.0, 217.0, 222.0], harmonics=2).dataset
    outputs = ss.rigs.three_mass_wedge().output_names
    assert found.truncation_error.shape == (1, len(outputs))
    assert np.all(found.truncation_error.values > 1e-4)
    assert len(set(found.truncation_error.values.ravel().tolist())) == len(outputs)


def test_results_without_the_estimate_have_no_warning():
    found = ss.forced_response(ss.rigs.single_mass(), [0.16], harmonics=1).dataset
    assert not [line for line in sentences(found.drop_vars("truncation_error")) if "More than" in line]
    assert truncation_warning(3, ("1.x",), np.array([np.nan])) == ""
    assert truncation_warning(3, ("1.x", "2.x"), np.array([np.nan, 0.02])).startswith("More than 3 harmonics would change 2.x")


def test_an_estimate_that_would_cost_a_curve_is_left_out(monkeypatch):
    """Fewer harmonics are looked at where many contacts slip, none where even two more are too many."""
    full = ss.forced_response(ss.rigs.single_mass(), [0.17], harmonics=1).dataset
    monkeypatch.setattr(truncation, "MOST_UNKNOWNS", 9)
    fewer = ss.forced_response(ss.rigs.single_mass(), [0.17], harmonics=1).dataset
    monkeypatch.setattr(truncation, "MOST_UNKNOWNS", 5)
    none = ss.forced_response(ss.rigs.single_mass(), [0.17], harmonics=1).dataset
    assert float(fewer.truncation_error[0, 0]) == pytest.approx(float(full.truncation_error[0, 0]), rel=0.3)
    assert float(fewer.truncation_error[0, 0]) != float(full.truncation_error[0, 0])
    assert np.isnan(float(none.truncation_error[0, 0]))
    assert str(none.case_message.values[0]) == "The frequency was solved."
