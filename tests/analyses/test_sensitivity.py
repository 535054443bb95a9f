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


def disc_on_a_line(across: float) -> ss.Problem:
    """One mass in a plane on a friction disc, driven along x, and across it by `across`."""
    structure = ss.Structure(np.eye(2), np.diag([1.0, 1.3]), ("1.x", "1.y"), C=0.05 * np.eye(2))
    directions = (ss.between("1.x", "ground"), ss.between("1.y", "ground"))
    disc = ss.Contact("disc", ss.FrictionDisc(1.0, 0.5, normal_load=1.0), directions)
    forces = (ss.Force("1.x", 1.0), ss.Force("1.y", across))
    return ss.Problem(structure, (disc,), forces, ("1.x", "1.y"))


@pytest.mark.parametrize(("omega", "level"), [(1.0, 0.7), (1.25, 0.3)])
def test_a_force_across_the_line_of_a_friction_disc_against_differences(omega, level):
    """At across = 0 the disc rubs exactly along x; what the force across does there is the limit of solved motions beside."""
    frequency, step = omega / (2.0 * np.pi), 1e-4
    parameter = ss.Parameter(0.0, disc_on_a_line)
    found = ss.sensitivity(disc_on_a_line(0.0), frequency, {"across": parameter}, level, harmonics=5, samples=128)
    ends = [response(disc_on_a_line(side * step), frequency, level) for side in (1.0, -1.0)]
    assert 0.05 < float(ends[0].dataset.share_slip.max()) < 0.95
    expected = (motion(ends[0]) - motion(ends[1])) / (2.0 * step)
    scale = np.abs(expected[1]).max()
    assert scale > 0.1
    np.testing.assert_allclose(found.by_parameter["across"], expected, atol=1e-6 * scale)


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


DUFFING = {"k": 1.0, "m": 1.0, "c": 0.05, "k3": 1.0, "force": 0.2}


def duffing(k: float, m: float, c: float, k3: float, force: float) -> ss.Problem:
    spring = ss.Contact("spring", ss.CubicSpring(k3), (ss.between("1.x", "ground"),))
    structure = ss.Structure(np.array([[m]]), np.array([[k]]), ("1.x",), C=np.array([[c]]))
    return ss.Problem(structure, (spring,), (ss.Force("1.x", force),), ("1.x",))


def of_duffing() -> dict[str, ss.Parameter]:
    return {name: ss.Parameter(value, partial(changed, duffing, DUFFING, name)) for name, value in DUFFING.items()}


@pytest.mark.nightly
def test_every_point_of_an_overhanging_curve_has_its_derivatives():
    """g = ((k + 3/4 k3 a² − m ω²)² + (c ω)²) a² − F² = 0 of one harmonic: da/dθ = −(∂g/∂θ)/(∂g/∂a) on all three branches."""
    made = ss.forced_response(duffing(**DUFFING), ss.radians_per_second(0.6, 2.6), harmonics=1)
    data = made.dataset.isel(case=0, output=0)
    omegas = 2.0 * np.pi * data.frequency.values
    falls = np.diff(omegas) < 0.0
    assert falls.any(), "the curve overhangs"
    k, m, c, k3, F = DUFFING.values()
    for point in range(data.sizes["point"]):
        a, omega = float(data.amplitude[point]), omegas[point]
        s = k + 0.75 * k3 * a**2 - m * omega**2
        by_a = 2.0 * s * 1.5 * k3 * a**3 + 2.0 * a * (s**2 + (c * omega) ** 2)
        scale = 2.0 * a * (s**2 + (c * omega) ** 2) + abs(3.0 * s * k3 * a**3)
        by = {"k": 2.0 * s * a**2, "m": -2.0 * s * omega**2 * a**2, "k3": 1.5 * s * a**4}
        by |= {"c": 2.0 * c * omega**2 * a**2, "force": -2.0 * F}
        found = made.sensitivity(0, point, of_duffing())
        assert found.frequency == pytest.approx(float(data.frequency[point]), rel=1e-14)
        assert abs(found.response[0, 1]) == pytest.approx(a, rel=1e-9)
        if abs(by_a) > 1e-4 * scale:
            for name, slope in found.amplitude_slopes().items():
                assert slope[0] == pytest.approx(-by[name] / by_a, rel=1e-6, abs=1e-9), (name, point)


def test_the_upper_branch_against_curves_of_changed_springs():
    """At 1.5 rad/s, reached from below; solved afresh at that frequency, the point is one of the lower branch."""

    def traced(k3: float) -> ss.ForcedResponse:
        frequencies = np.array([0.9, 1.2, 1.5]) / (2.0 * np.pi)
        return ss.forced_response(duffing(**(DUFFING | {"k3": k3})), frequencies, harmonics=5)

    upper, step = traced(1.0), 1e-5
    slope = upper.sensitivity(0, 2, of_duffing()).amplitude_slopes()["k3"][0]
    high, low = (float(traced(1.0 + side * step).dataset.amplitude[0, 2, 0]) for side in (1.0, -1.0))
    assert slope == pytest.approx((high - low) / (2.0 * step), rel=1e-6)
    afresh = ss.sensitivity(duffing(**DUFFING), 1.5 / (2.0 * np.pi), of_duffing(), samples=256)
    assert abs(afresh.response[0, 1]) < 0.5 * float(upper.dataset.amplitude[0, 2, 0])
    assert afresh.amplitude_slopes()["k3"][0] * slope < 0.0


@pytest.fixture(scope="module")
def slipping_peak():
    maker, values, _ = CASES["wedge"]
    parameters = {name: ss.Parameter(values[name], partial(changed, maker, values, name)) for name in ("mu", "kt", "pull")}
    made = ss.forced_response(maker(**values), ss.Band(330.0, 360.0), 5.0, samples=2048)
    assert 0.05 < float(made.dataset.share_slip[0, made.peak_point()].max()) < 0.95
    return made, parameters


def test_the_slope_at_a_peak_is_that_of_its_height(slipping_peak):
    """Central differences of peaks, each at a frequency of its own. Peaks sit on kinks of the sampled curve, so that the slopes
    agree to the fineness of the samples: 3 % with 256, 0.2 % with 2048.
    """
    made, parameters = slipping_peak
    slopes = made.sensitivity(0, made.peak_point(), parameters).amplitude_slopes()
    for name, parameter in parameters.items():
        step = 1e-4 * parameter.value
        high, low = (
            ss.forced_response(parameter.problem(parameter.value + side * step), ss.Band(330.0, 360.0), 5.0, samples=2048)
            for side in (1.0, -1.0)
        )
        height = float(high.dataset.peak_amplitude[0, 0, 0] - low.dataset.peak_amplitude[0, 0, 0])
        assert slopes[name][0] == pytest.approx(height / (2.0 * step), rel=2e-3), name


def test_a_point_beside_a_slipping_peak_against_differences(slipping_peak):
    made, parameters = slipping_peak
    point = made.peak_point() + 1
    frequency = float(made.dataset.frequency[0, point])
    slopes = made.sensitivity(0, point, parameters).amplitude_slopes()
    for name, parameter in parameters.items():
        step = 1e-6 * parameter.value
        high, low = (
            ss.forced_response(parameter.problem(parameter.value + side * step), [frequency], 5.0, samples=2048).dataset
            for side in (1.0, -1.0)
        )
        expected = float(high.amplitude[0, 0, 0] - low.amplitude[0, 0, 0]) / (2.0 * step)
        assert slopes[name][0] == pytest.approx(expected, rel=1e-5), name


def test_a_rig_that_takes_only_some_values_is_distinguished_from_a_wrong_value():
    """The value refused is not one that the user gave."""
    made = ss.forced_response(masses(**MASSES), [frequency_of("masses")])

    def only_given(mu: float) -> ss.Problem:
        if mu not in (0.3, 0.4):
            raise ss.InputError(f"mu must be 0.3 or 0.4, but is {mu!r}.")
        return masses(**(MASSES | {"mu": mu}))

    with pytest.raises(ss.InputError, match=r"'mu' must make a problem of values beside 0.4 too.*differences.*mu must be 0.3 or"):
        made.sensitivity(0, 0, {"mu": ss.Parameter(0.4, only_given)})
    with pytest.raises(ss.InputError, match="'mu' must make the problem itself"):
        made.sensitivity(0, 0, {"mu": ss.Parameter(0.3, only_given)})


@pytest.mark.parametrize("name", ["c", "force", "static"])
def test_another_damping_or_load_than_the_problem_has_is_refused(name):
    """A value whose problem has the same stiffness and contacts, and other slopes."""

    def made(c: float = 0.05, force: float = 1.0, static: float = 0.1) -> ss.Problem:
        structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), C=c * np.eye(1))
        slider = ss.Contact("slider", ss.Macroslip(kt=1.0, mu=1.0, normal_load=1.0), (ss.between("1.x", "ground"),))
        return ss.Problem(structure, (slider,), (ss.Force("1.x", force, static),), ("1.x",))

    with pytest.raises(ss.InputError, match="must make the problem itself of its value"):
        ss.sensitivity(made(), 0.2, {name: ss.Parameter(0.3, lambda value: made(**{name: value}))})


@pytest.mark.parametrize("name", MASSES)
@pytest.mark.parametrize("value", [0.0, 1e-12, -1e-15])
def test_a_parameter_near_zero_that_adds_to_something(name, value):
    """θ added to each argument: a relative step of θ is lost in rounding; the slope is that of the argument."""
    added = ss.Parameter(value, lambda theta: changed(masses, MASSES, name, MASSES[name] + theta))
    own = ss.Parameter(MASSES[name], partial(changed, masses, MASSES, name))
    where = (frequency_of("masses"), {"added": added, "own": own}, 1.0)
    found = ss.sensitivity(masses(**MASSES), *where, harmonics=5, samples=128).by_parameter
    scale = np.abs(found["own"]).max()
    np.testing.assert_allclose(found["added"], found["own"], atol=1e-5 * scale, err_msg=name)


@pytest.mark.parametrize("value", [1e-14, -1e-25])
def test_a_stiffness_near_zero_by_itself(value):
    """The slope by a vanishing cubic stiffness is that by a small one: ∂X/∂k3 of a linear mass."""
    slopes = [
        ss.sensitivity(duffing(**(DUFFING | {"k3": k3})), 0.1, {"k3": ss.Parameter(k3, partial(changed, duffing, DUFFING, "k3"))})
        for k3 in (value, 1e-7)
    ]
    vanishing, small = (slope.by_parameter["k3"] for slope in slopes)
    np.testing.assert_allclose(vanishing, small, atol=1e-5 * np.abs(small).max())


@pytest.mark.parametrize("gap", [0.0, 1e-15])
def test_a_gap_near_zero(gap):
    """A stop that touches at rest, against differences of solved responses."""

    def touching(gap):
        structure = ss.Structure([[1.0]], [[1.0]], ("1.x",), C=[[0.1]])
        stop = ss.Contact("stop", ss.Gap(1.0, gap), normal=ss.between("1.x", "ground"))
        return ss.Problem(structure, (stop,), (ss.Force("1.x", 1e-5),), ("1.x",))

    found = ss.sensitivity(touching(gap), 0.17, {"gap": ss.Parameter(gap, touching)}).by_parameter["gap"]
    ends = [motion(ss.forced_response(touching(end), [0.17], harmonics=5, samples=256)) for end in (1e-9, -1e-9)]
    expected = (ends[0] - ends[1]) / 2e-9
    np.testing.assert_allclose(found, expected, atol=1e-3 * np.abs(expected).max())


def test_a_parameter_that_stands_for_itself_keeps_its_relative_step():
    """A light damper mass is not near zero: what is beside it must stay close to it."""
    asked: list[float] = []

    def light(mass):
        asked.append(mass)
        structure = ss.Structure(np.diag([1.0, mass]), [[2e6, -1e6], [-1e6, 1e6]], ("1.x", "2.x"), C=1.0 * np.eye(2))
        return ss.Problem(structure, (), (ss.Force("1.x", 1.0),), ("1.x",))

    ss.sensitivity(light(1e-3), 150.0, {"mass": ss.Parameter(1e-3, light)})
    assert max(abs(mass / 1e-3 - 1.0) for mass in asked) < 2e-3
