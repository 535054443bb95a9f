"""What of a study can vary, and the documents that sliders make of it."""

import tomllib

import pytest

from stickslip.show.explorer.solving import sliders_of, varied

RIG = {
    "study": {"analysis": "forced_response"},
    "structure": {"rig": "blade_and_wedge", "parameters": {"pull": 50.0}},
    "sweep": {"frequency": [300.0, 370.0], "force_levels": [1.0, 5.0, 20.0]},
}
MODEL = tomllib.loads("""
[structure]
matrices = { M = [[1.0]], K = [[1.0]] }
dofs = ["m.x"]
[damping]
modal = 0.01
[[contact]]
kt = 2.0
mu = 0.3
[[contact]]
name = "B"
kt = 2.0
mu = 0.5
[[force]]
direction = "m.x"
static = -3.0
[sweep]
frequency = [0.1, 0.2]
""")


def test_numbers_of_a_rig_vary_given_or_by_default():
    sliders = {slider.name: slider for slider in sliders_of(RIG)}
    assert sliders["pull"].value == 50.0
    assert sliders["mu"].value == 0.4
    assert (sliders["mu"].low, sliders["mu"].high) == (0.1, 1.6)
    assert sliders["force_level"].value == 5.0
    assert (sliders["platform_angle"].low, sliders["platform_angle"].high) == (5.0, 85.0)
    assert "force" not in sliders
    assert [slider.unit for slider in (sliders["pull"], sliders["kt"], sliders["mu"])] == ["N", "N/m", ""]


def test_contacts_that_are_alike_share_a_slider():
    names = {slider.name: slider.paths for slider in sliders_of(MODEL)}
    assert names["kt"] == (("contact", 0, "kt"), ("contact", 1, "kt"))
    assert {"contact 1 mu", "B mu", "damping", "static force m.x", "force_level"} < set(names)


def test_values_land_at_their_places_and_the_study_stays_as_it_is():
    sliders = sliders_of(MODEL)
    found = varied(MODEL, sliders, {"kt": 7.0, "B mu": 0.1, "static force m.x": -4.0, "force_level": 2.0})
    assert [table["kt"] for table in found["contact"]] == [7.0, 7.0]
    assert [table["mu"] for table in found["contact"]] == [0.3, 0.1]
    assert found["force"][0]["static"] == -4.0
    assert found["sweep"]["force_levels"] == [2.0]
    assert MODEL["contact"][0]["kt"] == 2.0


@pytest.mark.parametrize("document", [RIG, MODEL])
def test_every_value_lies_between_its_ends(document):
    assert all(slider.low <= slider.value <= slider.high for slider in sliders_of(document))
