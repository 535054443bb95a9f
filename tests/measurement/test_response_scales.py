"""What measured responses say of their units: those that were assumed, and tests a thousand times apart."""

import numpy as np

import stickslip as ss
from stickslip.laboratory.measurement.measured_response import assumed_units, joined

FREQUENCY = np.linspace(60.0, 100.0, 21)


def response_of(name, natural=80.0, damping=0.02, factor=1.0, frequency=FREQUENCY):
    """Acceleration per newton of one mass."""
    size = frequency**2 / np.abs(natural**2 - frequency**2 + 2j * damping * natural * frequency)
    return ss.MeasuredResponse(frequency, factor * size, 1.0, name=name)


def test_assumed_units_are_listed_once_for_files_alike(tmp_path):
    for name, titles in (
        ("a", "f,a [g],force"),
        ("b", "f,a [g],force"),
        ("c", "f [Hz],a,force [N]"),
        ("d", "f [Hz],a [g],force [N]"),
    ):
        (tmp_path / f"{name}.csv").write_text(titles + "\n80,1,1\n81,2,1\n82,1,1\n")
    tests = [ss.read_measured_response(tmp_path / f"{name}.csv") for name in "abcd"]
    assert assumed_units(tests) == [
        "No unit is stated of frequency and force in a, b: Hz and N are assumed.",
        "No unit is stated of acceleration in c: m/s2 is assumed.",
    ]
    found = ss.identify_response(
        lambda kt: ss.rigs.single_mass(kt=kt), {"kt": (0.5, 0.1, 3.0)}, tests[2:3], tries=0, evaluations=1
    )
    assert "No unit is stated of acceleration in c: m/s2 is assumed." in str(found)


def test_sentences_that_differ_in_the_name_alone_are_one():
    notes = [(f"g_{k}", f"The quantity of g_{k}.csv is not stated: acceleration is assumed.") for k in (1, 2)]
    notes += [
        ("g_1", "The force of g_1 is held."),
        ("g_12", "The force of g_12 is held."),
        ("1", "1 row of 1 left out."),
        ("a", "Same."),
    ]
    assert joined([*notes, ("b", "Same.")]) == [
        "The quantity of g_1.csv, g_2.csv is not stated: acceleration is assumed.",
        "The force of g_1, g_12 is held.",
        "1 row of 1 left out.",
        "Same.",
    ]
