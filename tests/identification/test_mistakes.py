"""Mistakes in measured responses are named: each is put into curves whose truth is known."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import xarray as xr
from identification.test_identify_response import FREE, measured, one_mass

import stickslip as ss
from stickslip.laboratory.identification.response.diagnosis import SUSPICION
from stickslip.laboratory.identification.response.mistakes import notes_on_mistakes
from stickslip.laboratory.identification.response.result import summary

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
        "times those of the model that fits else, as where the force is in kN although its title says N",
    ),
    "displacement in mm": (scaled(1e3), "or a response in mm as in m. State the unit"),
    "force in N for kN": (scaled(force=1e3), "as where the force is in N although its title says kN"),
    "acceleration in g": (scaled(1.0 / 9.80665), "as where an acceleration in g is given as in m/s2"),
    "a gain of no known mistake": (scaled(3.3), "0.3, 1, 2: the amplitudes fit with a gain of 3.2"),
    "RMS response": (scaled(np.sqrt(0.5)), "0.3, 1, 2: the measured responses per force are 0.70"),
    "RMS force": (scaled(force=np.sqrt(0.5)), "as where the force is an RMS value and the response an amplitude"),
    "peak to peak": (scaled(2.0), "as where the response is a peak-to-peak value"),
    "sign": (turned(lambda phase: -phase), "the displacement leads the force, as where motions go by exp(-iωt)"),
    "acceleration": (turned(lambda phase: phase + np.pi), "are 180° from those of the displacement: they are the acceleration's"),
    "lag of the acceleration": (turned(lambda phase: np.pi - phase), "those of the acceleration with the opposite sign"),
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
