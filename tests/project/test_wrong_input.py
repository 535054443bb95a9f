"""Arguments of a wrong kind are refused with what, rule and value, never by an error of the libraries below."""

from typing import Any

import numpy as np
import pytest
from each import each

import stickslip as ss

GROUND = ss.between("2.x", "ground")
SLIDER = ss.Macroslip(1.0, 0.5, normal_load=1.0)


def structure(**changes: Any) -> ss.Structure:
    sound = {"M": np.eye(2), "K": [[2.0, -1.0], [-1.0, 1.5]], "dofs": ("1.x", "2.x"), "C": 0.02 * np.eye(2)}
    return ss.Structure(**(sound | changes))


def contact(**changes: Any) -> ss.Contact:
    return ss.Contact(**({"name": "slider", "law": SLIDER, "tangential": (GROUND,)} | changes))


def problem(**changes: Any) -> ss.Problem:
    sound = {"structure": structure(), "contacts": (contact(),), "forces": (ss.Force("1.x", 1.0),), "outputs": ("2.x",)}
    return ss.Problem(**(sound | changes))


def respond(**changes: Any) -> ss.ForcedResponse:
    return ss.forced_response(**({"problem": problem(), "band": [0.1], "harmonics": 1, "samples": 16} | changes))


def analyses(of: Any) -> dict[str, Any]:
    return {
        "forced_response": lambda: ss.forced_response(of, [0.1]),
        "controlled_response": lambda: ss.controlled_response(of, [0.1], 1.0),
        "response_bounds": lambda: ss.response_bounds(of, [0.1]),
        "response_samples": lambda: ss.response_samples(of, [0.1]),
        "response_history": lambda: ss.response_history(of, [0.1], [1.0]),
        "performance_curve": lambda: ss.performance_curve(of, [1.0, 2.0]),
        "time_response": lambda: ss.time_response(of, 0.1),
    }


NUMBERS = "must hold numbers"
HUGE = 10**5000
"""Beyond floating point, and beyond what Python writes as text."""
WRONG = [
    (lambda: structure(M="x"), f"M {NUMBERS}, but is 'x'"),
    (lambda: structure(M=[[1, 2], [3]]), f"M {NUMBERS}"),
    (lambda: structure(M=1j * np.eye(2)), "M must be real, but is 'complex, as 1j'"),
    (lambda: structure(K=[[2.0, 1j], [-1j, 2.0]]), "K must be real"),
    (lambda: structure(C="x"), f"C {NUMBERS}"),
    (lambda: structure(dofs=("1", "2")), "A name in dofs must be NODE.DIRECTION, but is '1'. Write 1.x, say."),
    (lambda: structure(dofs=("1.", "2.x")), "must be NODE.DIRECTION, but is '1.'"),
    (lambda: structure(dofs=(1, 2)), "A name in dofs must be"),
    (lambda: ss.Force("1.x", "a"), "Force.amplitude must be a number, or {harmonic: number}, but is 'a'"),
    (lambda: ss.Force("1.x", {1.5: 1.0}), "Harmonic of Force.amplitude must be a whole number, but is 1.5"),
    (lambda: ss.Force(3, 1.0), "Force.direction must be"),
    (lambda: contact(law=3), "Contact 'slider', law must be a Law, but is 3"),
    (lambda: contact(start=3), "Contact 'slider', start must be a SliderOffset, TractionRatio or MeanTraction, but is 3"),
    (lambda: contact(tangential="2.x"), "Contact 'slider', tangential must be a tuple or list"),
    (lambda: contact(tangential=("2.x",)), "a direction must be coefficients, as `between` gives them, but is '2.x'"),
    (lambda: problem(structure=3), "structure must be a Structure, but is 3"),
    (lambda: problem(contacts=(1,)), "A contact must be a Contact, but is 1"),
    (lambda: problem(forces=(1,)), "A force must be a Force, but is 1"),
    (lambda: problem(outputs=(1,)), "An output must be"),
    (lambda: respond(force="a"), f"force {NUMBERS}, but is 'a'"),
    (lambda: respond(harmonics="x"), "harmonics must be a whole number, but is 'x'. Or write \"auto\"."),
    (lambda: respond(harmonics="many"), 'Or write "auto".'),
    (lambda: respond(harmonics=float("nan")), "harmonics must be a whole number"),
    (lambda: respond(samples="x"), "samples must be a whole number"),
    (lambda: respond(workers="x"), "workers must be a whole number"),
    (lambda: respond(band=0.1), "band must be a Band, as of ss.hertz(480, 600), or a list of frequencies in Hz, but is 0.1"),
    (lambda: respond(band="0.1"), "band must be a Band"),
    (lambda: respond(band=(0.1, 0.2)), "must not be a pair in round brackets, which could mean a band or two points"),
    (lambda: ss.hertz("x", 1.0), "start must be a number, but is 'x'"),
    (lambda: ss.radians_per_second(1.0, "x"), "stop must be"),
    (lambda: ss.hertz(1.0, HUGE), "stop must not be larger than 1e+40 in size, but is a huge integer. Check its unit."),
    (lambda: structure(M=[[HUGE, 0], [0, 1]]), "M must not be larger than 1e+40 in size"),
    (lambda: ss.Force("1.x", HUGE), "Force.amplitude must not be larger than 1e+40 in size, but is a huge integer"),
    (lambda: ss.Force("1.x", complex("nan")), "Force.amplitude must be finite"),
    (lambda: respond(harmonics=HUGE), "harmonics must be at most 1000, but is a huge integer"),
    (lambda: respond(samples=HUGE), "samples must be at most"),
]


@each(("call", "said"), WRONG, ids=[said[:40] for _, said in WRONG])
def test_arguments_of_a_wrong_kind(call, said):
    with pytest.raises(ss.InputError) as raised:
        call()
    assert said in str(raised.value)


@each("name", analyses(None))
def test_no_problem_at_all(name):
    with pytest.raises(ss.InputError, match="problem must be a Problem, but is None"):
        analyses(None)[name]()


def test_real_numbers_of_a_complex_type_are_taken():
    assert structure(M=np.eye(2) + 0j).M.dtype == float


def test_two_frequencies_in_a_list_are_two_points():
    assert respond(band=[0.1, 0.2]).dataset.frequency.values.tolist() == [[0.1, 0.2]]
