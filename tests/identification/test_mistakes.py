"""Mistakes in measured responses are named: each is put into curves whose truth is known."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import xarray as xr
from identification.test_identify_response import FREE, measured, one_mass
from measurement import universal_writer

import stickslip as ss
from stickslip.laboratory.identification.response.mistakes import named_gain, notes_on_mistakes
from stickslip.laboratory.identification.response.result import SUSPICION, summary

SETTINGS = {"tries": 1, "evaluations": 25, "samples": 64, "harmonics": 3}


@cache
def sound():
    return [measured(force, 3, frequencies=np.linspace(0.14, 0.24, 15)) for force in (0.3, 1.0, 2.0)]


def scaled(amplitude=1.0, force=1.0):
    return lambda test: replace(test, amplitude=amplitude * np.asarray(test.amplitude), force=force * np.asarray(test.force))


def turned(of):
    return lambda test: replace(test, phase=of(np.asarray(test.phase)))


MISTAKES = {
    "force in kN": (
        scaled(force=1e-3),
        "times those of the model that fits else, as where the force is in kN but taken for N",
    ),
    "displacement in mm": (scaled(1e3), "or the response in mm or mm/s2 but taken for m or m/s2. State the unit"),
    "force in N for kN": (scaled(force=1e3), "as where the force is in N but taken for kN"),
    "acceleration in g": (scaled(1.0 / 9.80665), "as where an acceleration in g is given as in m/s2"),
    "a gain of no known mistake": (scaled(3.3), "0.3, 1, 2: the amplitudes fit with a gain of 3.2"),
    "RMS response": (scaled(np.sqrt(0.5)), "0.3, 1, 2: the measured responses per force are 0.70"),
    "RMS force": (scaled(force=np.sqrt(0.5)), "as if the force were an RMS value and the response an amplitude"),
    "peak to peak": (scaled(2.0), "as where the response is a peak-to-peak value"),
    "sign": (turned(lambda phase: -phase), "the displacement leads the force, as with exp(-iωt)"),
    "acceleration": (
        turned(lambda phase: phase + np.pi),
        "are 180° from those of the displacement: they belong to the acc",
    ),
    "lag of the acceleration": (turned(lambda phase: np.pi - phase), "those of the acceleration with opposite sign"),
    "velocity": (turned(lambda phase: phase + 0.5 * np.pi), "90° ahead of those of the displacement"),
    "sine": (turned(lambda phase: phase - 0.5 * np.pi), "90° behind those of the displacement"),
    "radians as degrees": (turned(np.radians), "seem to be radians that are given as degrees"),
    "swapped parts": (turned(lambda phase: 0.5 * np.pi - phase), "are those of swapped real and imaginary parts"),
    "swapped columns": (
        lambda test: replace(test, amplitude=test.force, force=test.amplitude),
        "0.3, 1, 2: the columns of force and response seem to be swapped",
    ),
}
NAMED_ON_EVERY_CHANGE = {"force in kN"}
"""One of amplitudes; `test_one_wrong_test_is_named_alone` has one of phases."""

HINTS = ("model that fits else", "the amplitudes fit with a gain", "the measured phases", "seem to be swapped")


def hints(found):
    return [note for note in found.notes if any(words in note for words in HINTS)]


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [name if name in NAMED_ON_EVERY_CHANGE else pytest.param(name, marks=pytest.mark.nightly) for name in MISTAKES]
)
def test_a_mistake_is_named(name):
    change, words = MISTAKES[name]
    found = ss.identify_response(one_mass, FREE, [change(test) for test in sound()], **SETTINGS)
    said = hints(found)
    assert any(words in note for note in said), found.notes
    assert len(said) == 1
    first, *rest = [note for note in found.notes if "is assumed" not in note]
    assert first in said  # the cause, and none of its consequences
    assert rest == [SUSPICION]
    assert summary(found.dataset)[:2] == [first, SUSPICION]  # before the values, which mean nothing


@pytest.mark.slow
def test_a_sound_fit_and_a_wrong_model_are_no_mistakes():
    """Right curves; and a model without friction, which misses them by more than a tenth."""
    assert hints(ss.identify_response(one_mass, FREE, sound(), **SETTINGS)) == []
    stuck = ss.identify_response(
        lambda kt, damping: one_mass(kt, 100.0, damping), {k: FREE[k] for k in ("kt", "damping")}, sound(), **SETTINGS
    )
    assert float(stuck.dataset["misfit"].max()) > 0.1
    assert hints(stuck) == []
    assert any("Check quantity, units, mass and stiffness of the model, contact law" in note for note in stuck.notes)


@pytest.mark.slow
def test_one_wrong_test_is_named_alone():
    tests = [sound()[0], MISTAKES["sign"][0](sound()[1]), sound()[2]]
    (said,) = hints(ss.identify_response(one_mass, FREE, tests, **SETTINGS))
    assert said.startswith("1: the measured phases have the opposite sign")


def test_a_suspected_mistake_is_printed_before_the_values():
    data = xr.Dataset(
        {key: ("parameter", [1.0]) for key in ("value", "low", "high")} | {"least": ("parameter", [np.nan])},
        {"parameter": ["kt"], "own": ("own", []), "test": ["a"]},
        {"notes": f"The mistake.\n{SUSPICION}\nAnother note."},
    ).assign({key: ("test", [0.3]) for key in ("misfit", "held_out")})
    first, second, third, *_, last = summary(data)
    assert (first, second, last) == ("The mistake.", SUSPICION, "Another note.")
    assert third.startswith("kt = 1")


def test_one_curve_that_fits_with_exchanged_columns_is_chance():
    """As one of eight curves of a measured beam does, which a wrong model misses."""
    solution = {
        "plain_gain": np.ones(3),
        "plain_misfit": np.full(3, 0.3),
        "plain_phase": np.concatenate([np.asarray(test.phase) for test in sound()]),
    }
    for exchanged, count in (([0.05, 0.3, 0.3], 0), ([0.05, 0.05, 0.05], 1)):
        said = notes_on_mistakes(sound(), np.full(3, 0.3), solution | {"swapped_misfit": np.array(exchanged)})
        assert len([note for note in said if "swapped" in note]) == count


@pytest.mark.parametrize(("wrong", "label"), [(1.0 / 9.80665, "m/s^2"), (1000.0, "m/s^2"), (0.001, "mm/s^2")])
@pytest.mark.parametrize("ending", ["unv", "csv"])
def test_the_unit_that_is_advised_mends_a_response_per_force(tmp_path, wrong, label, ending):
    """Accelerances in g and in mm/s2 that are labelled m/s2, and some in m/s2 that are labelled mm/s2."""
    f, true = np.linspace(10.0, 20.0, 11), np.linspace(1.0, 3.0, 11) * np.exp(1j)
    shown = true * wrong * (1000.0 if label == "mm/s^2" else 1.0)
    path = tmp_path / f"a.{ending}"
    if ending == "unv":
        path.write_bytes(universal_writer.function(f, shown, ordinate=(12, label), denominator=(13, "N"), double=True))
    else:
        rows = [f"{a:.9g},{b.real:.12g},{b.imag:.12g}" for a, b in zip(f, shown, strict=True)]
        path.write_text("\n".join([f"frequency [Hz],Re(H) [({label})/N],Im(H) [({label})/N]", *rows]))
    gains = ss.read_measured_response(path, force=4.0).amplitude / (4.0 * np.abs(true))
    np.testing.assert_allclose(gains, wrong, rtol=1e-6)
    words, _ = named_gain(float(np.median(gains)))
    assert "title" not in words
    (unit,) = re.findall(r"'amplitude': '(.*?)'\}", words)
    after = ss.read_measured_response(path, force=4.0, units={"amplitude": unit})
    np.testing.assert_allclose(after.amplitude, 4.0 * np.abs(true), rtol=1e-6)
    with pytest.raises(ss.InputError, match="must be per force"):
        ss.read_measured_response(path, force=4.0, units={"amplitude": unit.removesuffix("/N").strip("()")})


def test_phases_of_the_opposite_sign_may_be_those_of_a_turned_sensor():
    """So says the sentence, since a sensor against the axis of the model is as common as the phase of an acceleration."""
    phases = np.concatenate([np.asarray(test.phase) for test in sound()])
    turned_tests = [MISTAKES["acceleration"][0](test) for test in sound()]
    solution = {"plain_gain": np.ones(3), "plain_misfit": np.full(3, 0.01), "plain_phase": phases}
    (said,) = notes_on_mistakes(turned_tests, np.full(3, 1.0), solution | {"swapped_misfit": np.full(3, np.inf)})
    assert "a sensor or the force has the opposite direction" in said
