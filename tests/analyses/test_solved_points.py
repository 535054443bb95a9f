"""Results and problem belong together: the points of results solve the balance of their own problem alone."""

from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss

BAND, FORCE = ss.Band(330.0, 360.0), 5.0
RIG = ss.rigs.blade_and_wedge()
SIZES = {"kt": 8e5, "kn": 1.2e6, "mu": 0.4, "pull": 60.0, "damper_mass": 0.02, "platform_angle": 35.0}


@pytest.fixture(scope="module")
def response():
    return ss.forced_response(RIG, BAND, FORCE)


def stiffer(share: float) -> ss.Problem:
    return RIG.with_structure(replace(RIG.structure, K=RIG.structure.K * (1.0 + share)))


@pytest.mark.parametrize("name", SIZES)
def test_a_parameter_changed_by_a_thousandth_is_another_problem(response, name):
    other = ss.ForcedResponse(response.dataset, ss.rigs.blade_and_wedge(**{name: 1.001 * SIZES[name]}))
    point = response.peak_point()
    for asked in (other.verify_in_time, other.cycle, lambda *at: other.sensitivity(*at, {})):
        with pytest.raises(ss.InputError, match=f"point {point} of case 0 misses .* results are of another problem"):
            asked(0, point)
    with pytest.raises(ss.InputError, match="results are of another problem"):
        other.at([340.0])


@pytest.mark.parametrize(
    "other",
    [stiffer(1e-3), RIG.with_forces([replace(force, static=force.static + 1.0) for force in RIG.forces])],
    ids=["structure", "static load"],
)
def test_structure_and_load_are_the_problem_too(response, other):
    with pytest.raises(ss.InputError, match="results are of another problem"):
        ss.ForcedResponse(response.dataset, other).cycle(0, response.peak_point())


def test_another_mass_shows_where_all_contacts_stick():
    """λ of stuck contacts is no function of the motion: the motion itself must be the one kept, however small beside its mean."""
    made = ss.forced_response(RIG, [300.0], 1e-3)
    assert float(made.dataset.share_stick.min()) == 1.0
    heavier = RIG.with_structure(replace(RIG.structure, M=1.001 * RIG.structure.M))
    with pytest.raises(ss.InputError, match="results are of another problem"):
        ss.ForcedResponse(made.dataset, heavier).cycle(0, 0)


def test_other_outputs_and_contacts_are_named(response):
    named = replace(RIG, outputs=(ss.Output("elsewhere", {RIG.structure.dofs[0]: 1.0}),))
    with pytest.raises(ss.InputError, match=r"outputs of the problem must be those of the results, .*elsewhere"):
        ss.ForcedResponse(response.dataset, named).at([340.0])
    fewer = replace(RIG, contacts=RIG.contacts[1:])
    with pytest.raises(ss.InputError, match="contacts of the problem must be those of the results"):
        ss.ForcedResponse(response.dataset, fewer).at([340.0])


def test_samples_of_other_start_states_are_not_solutions_of_the_problem():
    samples = ss.response_samples(RIG, [340.0], 1.0, starts=3)
    of_samples = ss.ForcedResponse(samples.dataset, RIG)
    assert of_samples.cycle(0, 0)
    with pytest.raises(ss.InputError, match="results are of another problem"):
        of_samples.cycle(1, 0)


def test_a_problem_that_another_machine_rounds_otherwise_is_the_same(response):
    ours, theirs = response.dataset, stiffer(1e-11)
    assert theirs.fingerprint != RIG.fingerprint
    again = ss.ForcedResponse(ours, theirs)
    for k in range(ours.sizes["point"]):
        np.testing.assert_allclose(again.cycle(0, k).force, response.cycle(0, k).force, rtol=1e-6, atol=1e-6)


@pytest.mark.slow
def test_points_of_a_hardly_damped_structure_are_known_again():
    """At ζ = 1e-6 the roundings of the stored forces alone change the motion by 1e-6 and more."""
    rng = np.random.default_rng(3)
    factor = rng.normal(size=(4, 4))
    names = ("1.x", "2.x", "3.x", "4.x")
    structure = ss.Structure(
        np.diag(rng.uniform(0.5, 2.0, 4)), factor @ factor.T + 0.3 * np.eye(4), names, damping=ss.ModalDamping(1e-6)
    )
    slider = ss.Contact(
        "slider",
        ss.Macroslip(kt=1.0, mu=0.5, normal_load=0.5),
        ({name: float(x) for name, x in zip(names, rng.normal(size=4), strict=True)},),
    )
    problem = ss.Problem(structure, (slider,), (ss.Force("1.x", 1.0),), names)
    ends = 0.5 * problem.frequencies(stuck=False)[0], 1.2 * problem.frequencies(stuck=True)[-1]
    response = ss.forced_response(problem, ss.hertz(*ends), force=1.0, harmonics=5, samples=128)
    found = response.peaks("velocity")
    assert len(found) >= 4
    with pytest.raises(ss.InputError, match="The results are of another problem"):
        ss.ForcedResponse(response.dataset, problem.with_structure(structure.with_damping(ss.ModalDamping(2e-6)))).peaks(
            "velocity"
        )


def test_peaks_of_another_quantity_are_not_searched_between_listed_frequencies():
    response = ss.forced_response(ss.rigs.single_mass(), [0.1, 0.15, 0.2], 0.5, 3, 64)
    with pytest.raises(ss.InputError, match="need a response over a band"):
        response.peaks("velocity")
