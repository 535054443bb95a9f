"""Derivatives of a response by every kind of parameter, against central differences of solved responses."""

from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

import stickslip as ss

STEP = 1e-5
"""Relative; the differences are exact to about 1e-9."""
WEDGE = {"kt": 8e5, "kn": 1.2e6, "mu": 0.4, "pull": 60.0, "damper_mass": 0.02, "platform_angle": 35.0}
MASSES = {"kt": 0.8, "kn": 1.5, "mu": 0.4, "preload": 1.0, "gap": 0.05, "offset": 0.2, "m": 1.0, "k": 2.0, "force": 1.0}


def masses(
    kt: float, kn: float, mu: float, preload: float, gap: float, offset: float, m: float, k: float, force: float
) -> ss.Problem:
    """Two masses in a plane: one rubs under a varying load, one sticks from a start state away from zero, one strikes a stop."""
    K = np.diag([k, 2.0, 1.5]) + 0.3 * (np.ones((3, 3)) - np.eye(3))
    structure = ss.Structure(np.diag([m, 1.0, 0.8]), K, ("1.x", "1.y", "2.x"), C=0.05 * np.eye(3))
    contacts = (
        ss.Contact("rubs", ss.Macroslip(kt, mu, kn, preload), (ss.between("1.x", "ground"),), ss.between("1.y", "ground")),
        ss.Contact(
            "sticks",
            ss.Macroslip(kt, 5.0, kn, 3.0),
            (ss.between("2.x", "1.x"),),
            ss.between("1.y", "ground"),
            ss.SliderOffset(offset),
        ),
        ss.Contact("stop", ss.Gap(1.0, gap), normal=ss.between("2.x", "ground")),
    )
    return ss.Problem(structure, contacts, (ss.Force("1.x", force, static=0.1), ss.Force("1.y", 0.3j)), ("1.x", "2.x"))


CASES = {"wedge": (ss.rigs.blade_and_wedge, WEDGE, 30.0), "masses": (masses, MASSES, 1.0)}


def frequency_of(name: str) -> float:
    maker, values, _ = CASES[name]
    return 0.98 * float(maker(**values).frequencies(stuck=True)[0])


def response(problem: ss.Problem, frequency: float, force: float) -> ss.ForcedResponse:
    return ss.forced_response(problem, [frequency], force, harmonics=5, samples=128)


def motion(of: ss.ForcedResponse) -> np.ndarray:
    parts = of.dataset.response.values[0, 0]
    return parts[..., 0] + 1j * parts[..., 1]


def changed(maker: Callable[..., ss.Problem], values: dict[str, float], name: str, value: float) -> ss.Problem:
    return maker(**(values | {name: value}))


@pytest.fixture(scope="module", params=CASES)
def solved(request):
    maker, values, force = CASES[request.param]
    frequency = frequency_of(request.param)
    parameters = {name: ss.Parameter(value, partial(changed, maker, values, name)) for name, value in values.items()}
    return parameters, frequency, force, ss.sensitivity(maker(**values), frequency, parameters, force, harmonics=5, samples=128)


def test_every_parameter_against_differences(solved):
    parameters, frequency, force, found = solved
    for name, parameter in parameters.items():
        step = STEP * parameter.value
        ends = [motion(response(parameter.problem(parameter.value + side * step), frequency, force)) for side in (1.0, -1.0)]
        expected = (ends[0] - ends[1]) / (2.0 * step)
        scale = np.abs(expected).max()
        assert scale * parameter.value > 1e-5 * np.abs(found.response).max(), f"{name} acts"
        np.testing.assert_allclose(found.by_parameter[name], expected, atol=1e-6 * scale, err_msg=name)
        first = np.real(np.conj(found.response[:, 1]) * expected[:, 1]) / np.abs(found.response[:, 1])
        np.testing.assert_allclose(found.amplitude_slopes()[name], first, atol=1e-6 * scale)


def test_the_points_rub_stick_and_strike():
    maker, values, force = CASES["masses"]
    states = response(maker(**values), frequency_of("masses"), force).dataset.isel(case=0, point=0)
    assert 0.05 < float(states.share_slip[0, 0]) < 0.95
    assert float(states.share_stick[1, 0]) == 1.0
    assert 0.05 < float(states.share_open[2, 2]) < 0.95
    maker, values, force = CASES["wedge"]
    assert float(response(maker(**values), frequency_of("wedge"), force).dataset.share_slip.max()) > 0.05


def test_start_states_against_differences():
    """The contact that sticks has a slope by its start value, that of the offset; those that slip have none."""
    maker, values, force = CASES["masses"]
    parameter = ss.Parameter(values["offset"], partial(changed, maker, values, "offset"))
    found = ss.sensitivity(maker(**values), frequency_of("masses"), {"offset": parameter}, force, harmonics=5, samples=128)
    assert found.elements.tolist() == [1]
    np.testing.assert_allclose(found.by_start[0], found.by_parameter["offset"], rtol=1e-6, atol=1e-9)


def test_wrong_use_is_refused():
    with pytest.raises(ss.InputError, match="problem must be a Problem"):
        ss.sensitivity(None, 1.0, {})
    with pytest.raises(ss.InputError, match="frequency must be positive"):
        ss.sensitivity(masses(**MASSES), -1.0, {})


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        (
            {"mu": ss.Parameter(0.5, lambda mu: ss.rigs.blade_and_wedge(mu=mu))},
            "'mu' must make the problem itself",
        ),
        ({"mu": 0.4}, "'mu' must be a Parameter, but is 0.4"),
        ([], "parameters must be a Mapping"),
    ],
)
def test_parameters_of_something_else_are_refused(parameters, said):
    with pytest.raises(ss.InputError, match=said):
        ss.sensitivity(ss.rigs.blade_and_wedge(mu=0.4), 330.0, parameters, force=30.0)
