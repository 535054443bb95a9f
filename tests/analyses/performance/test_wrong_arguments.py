"""Every analysis of peaks refuses wrong arguments in a sentence: analyses and wrong values are listed, all are tried."""

import inspect
import math

import pytest
from each import each

import stickslip as ss

BAND = ss.radians_per_second(0.8, 1.4)


def mass(**values):
    return ss.rigs.single_mass(damping=0.01, kt=0.5, limit=values.get("limit", 1.0))


def design(*, friction, limit=1.0):
    return mass(limit=limit * friction)


SOUND = {
    ss.performance_curve: {"problem": mass(), "force_ratio": [1.0, 2.0]},
    ss.performance_band: {"problem": mass(), "force_ratio": [1.0, 2.0]},
    ss.sensitivity_indices: {"problem_of": mass, "parameters": {"limit": (1.0, 2.0)}, "band": BAND, "draws": 2},
    ss.follow_peaks: {"problem_of": lambda limit: mass(limit=limit), "values": [1.0, 2.0], "band": BAND},
    ss.damper_design: {"problem_of": design, "variables": {"limit": (1.0, 2.0)}, "force": (1.0, 2.0), "friction": 0.4},
}
NOT_WHOLE = ["s", None, 1.5, -1]
WRONG = {
    "problem": [None, 3],
    "problem_of": [None, mass(), lambda *values, **named: None, lambda *values, **named: 1 / 0, lambda other, more: mass()],
    "band": ["q", [280, 390], 3.0],
    "output": ["a", 7, 0.5],
    "quantity": ["speed", 2, None],
    "measure": ["peak", 2, None],
    "force_ratio": [[], "a", [1.0, 1.0], [[1.0, 2.0]], [0.0], [math.nan], None],
    "pull": ["a", -1.0, math.nan],
    "check_every": [0, *NOT_WHOLE],
    "harmonics": [0, *NOT_WHOLE],
    "samples": [0, *NOT_WHOLE],
    "cloud": NOT_WHOLE,
    "starts": NOT_WHOLE,
    "seed": NOT_WHOLE,
    "draws": [3, 2**50, *NOT_WHOLE],
    "designs": [3, *NOT_WHOLE],
    "levels": [1, *NOT_WHOLE],
    "generations": NOT_WHOLE,
    "refinements": NOT_WHOLE,
    "rule": ["x", 3],
    "share": ["x", 3],
    "vary": ["mass", None],
    "objective": ["x", 3],
    "friction_factor": [0.5, "a"],
    "values": [[], [1.0, 1.0], "a", [math.nan]],
    "parameters": [{}, 3, {"limit": (2.0, 1.0)}, {"limit": (1.0, 2.0, 3.0)}, {"limit": "ab"}, {"limi": (1.0, 2.0), "x": 3}],
    "variables": [{}, 3, {"limit": (2.0, 1.0)}, {"limit": (1.0, 2.0, 3.0)}, {"limit": "ab"}, {"other": (1.0, 2.0)}],
    "constraints": [3, {"a": 3}],
    "known": [3, "ab", [3], [{}], [{"limit": math.nan}], [{"limit": "a"}], [{"limit": 1e9}], {"limit": 1.0}],
    "workers": [0, "a"],
}
OWN = {
    (ss.performance_curve, "friction"): [[], "a", -0.1, 0.0, [0.2, 0.2], math.nan],
    (ss.damper_design, "friction"): ["a", 0.0, math.nan],
    (ss.damper_design, "force"): [5, (2.0, 1.0), (0.0, 1.0), (1.0, 2.0, 3.0), "ab", (5.0, 5.0)],
    (ss.sensitivity_indices, "force"): ["a", 0.0, math.nan],
    (ss.follow_peaks, "force"): ["a", 0.0, lambda value: "a"],
}
CASES = [
    (analysis, name, value)
    for analysis in SOUND
    for name in inspect.signature(analysis).parameters
    for value in OWN.get((analysis, name), WRONG.get(name, []))
    if not (analysis is ss.performance_band and name == "band" and value is None)
]


@each(("analysis", "name", "value"), CASES, ids=lambda given: getattr(given, "__name__", str(given))[:30])
def test_a_wrong_argument_is_refused_in_a_sentence(analysis, name, value):
    with pytest.raises(ss.InputError) as raised:
        analysis(**({"harmonics": 1, "samples": 16} | SOUND[analysis] | {name: value}))
    assert "must" in str(raised.value)


@each("analysis", SOUND, ids=lambda analysis: analysis.__name__)
def test_every_argument_has_wrong_values(analysis):
    """A new argument is to be listed above."""
    free = {"checkpoint", "progress", "search"}
    tried = {name for one, name, _ in CASES if one is analysis}
    assert set(inspect.signature(analysis).parameters) - tried - free == set()


@pytest.mark.parametrize(
    "call",
    [
        lambda band: ss.performance_curve(mass(), [1.0, 2.0], band=band, harmonics=1, samples=16),
        lambda band: ss.performance_band(mass(), [1.0], band=band, cloud=0, harmonics=1, samples=16),
        lambda band: ss.sensitivity_indices(mass, {"limit": (1.0, 2.0)}, band, draws=2, harmonics=1, samples=16),
    ],
)
def test_a_band_without_a_resonance_is_refused(call):
    with pytest.raises(ss.InputError, match=r"must hold a resonance.* but is '0.5 to 0.6 Hz'.*without contacts"):
        call(ss.hertz(0.5, 0.6))
