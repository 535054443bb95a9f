"""Arguments that several analyses of response variability have in common: every wrong value is refused in words, at once."""

from typing import Any

import numpy as np
import pytest
from each import each
from scipy import stats

import stickslip as ss

WEDGE = ss.rigs.three_mass_wedge()
NAN, INF = float("nan"), float("inf")
BAND = ss.hertz(200.0, 235.0)


def samples(**wrong: Any) -> Any:
    return ss.response_samples(**({"problem": WEDGE, "band": [222.0], "starts": 2, "harmonics": 1, "samples": 16} | wrong))


def bounds(**wrong: Any) -> Any:
    return ss.response_bounds(
        **({"problem": WEDGE, "band": BAND, "cloud": 2, "starts": 1, "harmonics": 1, "samples": 16} | wrong)
    )


def history(**wrong: Any) -> Any:
    return ss.response_history(**({"problem": WEDGE, "band": BAND, "force": [1.0], "harmonics": 1, "samples": 16} | wrong))


CASES, DRAWN = {samples, bounds}, {samples, bounds}
ALL = {samples, bounds, history}
TEXT, LIST, NONE = "x", [], None
NO_COUNT = (TEXT, NONE, NAN, INF, 2.5, LIST, [3], True, 1j)
NO_NUMBER = (TEXT, NAN, INF, -1.0, 0.0)

WRONG: list[tuple[str, set[Any], tuple[Any, ...]]] = [
    ("problem", ALL, (NONE, 3, TEXT)),
    ("band", ALL, (NONE, 220.0, "band", LIST, [NAN], [-5.0], [0.0], ["a"], [[1.0, 2.0]], [1j])),
    ("force", ALL, (*NO_NUMBER, NONE, LIST, [1.0, NAN], [1.0, -1.0], [[1.0], [1.0, 2.0]])),
    ("harmonics", ALL, (*NO_COUNT, "auto", 0, -1, 10**12)),
    ("samples", ALL, (*NO_COUNT, 3, -1, 10**10)),
    ("progress", ALL, (3, TEXT)),
    ("checkpoint", CASES, (3, TEXT)),
    ("workers", CASES, (0, -1, TEXT, 1.5, True, NONE)),
    ("seed", DRAWN, (TEXT, NONE, -1, 0.5, 2**63, 10**23, True, LIST)),
    ("rule", DRAWN, (TEXT, LIST, NONE, 3, ["slider_offset"])),
    ("share", DRAWN, (TEXT, LIST, NONE, 3)),
    ("output", {bounds}, (*NO_COUNT, "2.y", -1, 9)),
    ("quantity", {samples, bounds}, ("speed", 2, None, ["velocity"])),
    ("measure", {samples, bounds}, ("peak", 2, None, ["rms"])),
    ("points", {bounds, history}, (*NO_COUNT, 0, -1, 10**12)),
    ("cloud", {bounds}, (*NO_COUNT, -1, 10**13)),
    ("objective", {bounds}, (TEXT, LIST, NONE, 3)),
    ("starts", {bounds}, (*NO_COUNT, -1, 10**12)),
    ("starts", {samples}, (TEXT, "20", NONE, NAN, 1.5, True, 1j, 0, -3, 10**12, LIST, [3], [[0.0, 1.0], [1.0]], [["a", "b"]])),
    ("starts", {samples}, ([[0.0, 2.0]], [[NAN, 0.0]], np.zeros((3, 5)), np.zeros(2), np.zeros((0, 2)), 0.2j * np.ones((2, 2)))),
    ("method", {samples}, ("sobol", LIST, NONE, ["latin"])),
    ("distribution", {samples}, ("beta", 3, stats.beta(-2.0, 2.0), stats.norm(50.0, 1.0))),
]
CALLS = [
    (analysis, name, value)
    for name, takers, values in WRONG
    for analysis in sorted(takers, key=lambda taker: taker.__name__)
    for value in values
]


@each(("analysis", "name", "value"), CALLS)
def test_a_wrong_argument_is_refused(analysis, name, value):
    """By its name, with a rule and the value: never by an error of the libraries below."""
    with pytest.raises(ss.InputError, match=r"must (not )?.*, but (is|are) ") as raised:
        analysis(**{name: value})
    words = {"band": ("band", "frequenc"), "force": ("force",)}.get(name, (name,))
    assert any(word in str(raised.value) for word in words)


SAID = [
    (lambda: samples(starts=[[1.5, 0.0]]), r"starts\[0, 0\] must lie in \[-1, 1\], but is 1.5"),
    (lambda: samples(starts=[[0.0, 0.0], [0.0, NAN]]), r"starts\[1, 1\] must lie in \[-1, 1\], but is nan"),
    (lambda: samples(starts=np.zeros((3, 5))), r"starts must have shape \(samples, 2\), .* but is \(3, 5\)"),
    (lambda: samples(distribution=stats.norm(50.0, 1.0)), "must have weight between -1 and 1, but is 'one from -inf to inf with"),
    (lambda: samples(seed=2**63), "seed must be at most 9223372036854775807, but is 9223372036854775808"),
    (lambda: samples(harmonics="auto"), "harmonics must be a whole number, but is 'auto'"),
    (lambda: samples(force=[1.0, 1.0]), "Force levels must be unique, but 1.0 is given more than once"),
    (lambda: bounds(points=10**12), "points must be at most 100000, but is 1000000000000"),
    (lambda: ss.logspace(1, 10, 2.5), "points must be a whole number, but is 2.5"),
    (lambda: ss.logspace(1, 10, "x"), "points must be a whole number, but is 'x'"),
    (lambda: ss.rigs.blade_and_wedge(platform_angle="a"), "platform_angle must be a number, but is 'a'"),
    (lambda: ss.rigs.blade_and_wedge(platform_angle="40"), "platform_angle must be a number, but is '40'"),
    (lambda: ss.forced_response(WEDGE, BAND, force=True), "must hold numbers, but is True"),
    (lambda: ss.hertz(70.0), "frequencies in Hz are given as a list"),
    (lambda: ss.forced_response(WEDGE, BAND, harmonics={1, 3}), "harmonics must be a whole number or a list in ascending order"),
    (lambda: ss.forced_response(WEDGE, BAND, quantity="speed"), "accelerance, but is 'speed'.$"),
]


@each(("call", "said"), SAID, ids=[said[:50] for _, said in SAID])
def test_the_bad_value_is_shown_with_its_place(call, said):
    with pytest.raises(ss.InputError, match=said):
        call()


def test_the_largest_seed_is_taken():
    assert samples(seed=2**63 - 1).dataset.attrs["seed"] == 2**63 - 1
