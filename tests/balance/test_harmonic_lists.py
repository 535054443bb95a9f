"""A list of harmonics: that of 0..H is the number H, what a list leaves out is zero, and what it holds is balanced."""

import numpy as np
import pytest
from balance.full_balance import balance_residual
from scipy.optimize import fsolve
from structure.cantilever import cantilever_rig

import stickslip as ss
from stickslip.analyses.solved_points import SolvedPoints
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.study import job

WEDGE = ss.rigs.three_mass_wedge()
SYMMETRIC = {
    "one mass": (ss.rigs.single_mass(), ss.radians_per_second(0.5, 2.0), 0.5),
    "finite elements": (cantilever_rig(push=0.0), ss.hertz(410.0, 430.0), 5.0),
}
UNEVEN = {
    "wedge": (WEDGE, ss.hertz(200.0, 235.0), 1.0),
    "single blade": (ss.rigs.single_blade(), ss.hertz(525.0, 532.0), 80.0),
    "disk": (ss.rigs.lumped_blisk("W", engine_order=2, sectors=6), ss.hertz(140.0, 150.0), 40.0),
}


def wedge_of(pull):
    return ss.rigs.three_mass_wedge(pull=pull)


def solved(case, harmonics, **options):
    problem, band, level = case
    return ss.forced_response(problem, band, level, harmonics=harmonics, samples=96, **options)


def harmonic_sizes(found):
    """Largest |X_h| of each harmonic along the curve, relative to that of the first."""
    parts = found.dataset.response.values[0]
    sizes = np.nanmax(np.hypot(parts[..., 0], parts[..., 1]), axis=(0, 1))
    return sizes / sizes[1]


@pytest.mark.parametrize("case", [SYMMETRIC["one mass"], *UNEVEN.values()], ids=["one mass", *UNEVEN])
def test_a_list_of_all_is_the_number(case):
    number, listed = solved(case, 3).dataset, solved(case, [0, 1, 2, 3]).dataset
    assert listed.attrs["harmonics"] == 3
    assert number.drop_vars("cpu_seconds", errors="ignore").identical(
        listed.assign_attrs(cpu_seconds=number.attrs["cpu_seconds"])
    )


@pytest.mark.parametrize("name", SYMMETRIC)
def test_odd_harmonics_are_enough_where_all_is_symmetric(name):
    """Even harmonics and the mean vanish, so that neither list changes anything but the size of Newton's matrix."""
    every = solved(SYMMETRIC[name], 5)
    assert harmonic_sizes(every)[3] > 1e-5
    for listed in ([0, 1, 3, 5], [1, 3, 5]):
        found = solved(SYMMETRIC[name], listed)
        assert found.dataset.attrs["harmonics"] == ", ".join(map(str, listed))
        np.testing.assert_allclose(found.peaks().frequency, every.peaks().frequency, rtol=1e-7)
        np.testing.assert_allclose(found.peaks().amplitude, every.peaks().amplitude, rtol=1e-9)
        error = float(found.dataset.truncation_error[0, 0])
        assert error == pytest.approx(float(every.dataset.truncation_error[0, 0]), rel=1e-4, abs=1e-7)


@pytest.mark.parametrize("name", UNEVEN)
def test_what_a_list_leaves_out_is_zero_and_the_rest_is_balanced(name):
    found = solved(UNEVEN[name], [0, 1, 3])
    sizes = harmonic_sizes(found)
    assert sizes[2] == 0.0
    assert sizes[3] > 1e-6
    assert np.nanmax(np.abs(found.dataset.contact_force.values[0][..., 2, :])) == 0.0
    assert harmonic_sizes(solved(UNEVEN[name], 3))[2] > 1e-6
    assert float(found.dataset.energy_residual.max()) < 1e-6


def test_the_balance_of_the_listed_harmonics_holds_with_forces_marched_in_plain_python():
    found = solved(UNEVEN["wedge"], [0, 1, 3, 4])
    points = found.dataset.sizes["point"]
    solved_points = SolvedPoints(found.dataset, WEDGE)
    residuals = [balance_residual(solved_points.balance, solved_points.point(0, k), (0, 1, 3, 4)) for k in range(0, points, 10)]
    assert max(residuals) < 1e-7
    assert balance_residual(solved_points.balance, solved_points.point(0, found.peak_point())) > 1e-3


def test_a_duffing_oscillator_under_a_static_load_as_solved_by_hand():
    """m ẍ + c ẋ + k x + k3 x³ = F0 + F cos ωt with harmonics 0, 1, 3 and x³ projected by a fast Fourier transform."""
    c, k3, static, force, omega, held = 0.05, 1.0, 0.3, 0.2, 1.2, (0, 1, 3)
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), C=np.array([[c]]))
    spring = ss.Contact("c", ss.CubicSpring(k3), (ss.between("1.x", "ground"),))
    problem = ss.Problem(structure, (spring,), (ss.Force("1.x", 1.0, static=static),), ("1.x",))
    found = ss.forced_response(problem, [omega / (2 * np.pi)], force, harmonics=held).dataset.response.values[0, 0, 0]
    X = found[:, 0] + 1j * found[:, 1]
    angles = 2.0 * np.pi * np.arange(64) / 64

    def gaps(values):
        motion = dict(zip(held, [values[0] + 0j, complex(*values[1:3]), complex(*values[3:])], strict=True))
        x = sum((value * np.exp(1j * h * angles)).real for h, value in motion.items())
        cube = np.fft.rfft(k3 * x**3) / 64 * np.where(np.arange(33) > 0, 2.0, 1.0)
        load = {0: static, 1: force, 3: 0.0}
        found = [(1.0 - (h * omega) ** 2 + 1j * h * omega * c) * motion[h] + cube[h] - load[h] for h in held]
        return [found[0].real, found[1].real, found[1].imag, found[2].real, found[2].imag]

    by_hand = fsolve(gaps, [X[0].real, X[1].real, X[1].imag, X[3].real, X[3].imag], xtol=1e-13)
    np.testing.assert_allclose([X[0].real, X[1].real, X[1].imag, X[3].real, X[3].imag], by_hand, rtol=1e-9)
    assert X[2] == 0.0
    with_second = ss.forced_response(problem, [omega / (2 * np.pi)], force, harmonics=3).dataset.response.values[0, 0, 0]
    assert abs(complex(*with_second[1]) - X[1]) > 1e-3 * abs(X[1])


def test_the_truncation_estimate_counts_what_lies_between():
    problem, _, level = UNEVEN["wedge"]
    found = solved(UNEVEN["wedge"], [0, 1, 3, 5])
    point, frequency = found.peak_point(), float(found.dataset.peak_frequency[0, 0, 0])
    many = ss.forced_response(problem, [frequency], level, harmonics=31).dataset
    first = complex(*found.dataset.response.values[0, point, 0, 1])
    change = abs(abs(complex(*many.response.values[0, 0, 0, 1])) - abs(first)) / abs(first)
    error = float(found.dataset.truncation_error[0, 0])
    assert error == pytest.approx(change, rel=0.35)
    assert error > 2.0 * float(solved(UNEVEN["wedge"], 5).dataset.truncation_error[0, 0])


def test_a_tuned_disk_and_the_whole_one_agree_on_a_list():
    """The mean and harmonics 1 and 3 of engine order 2 see diameters 0, 2 and 0 of six sectors; only harmonic 2 is left out."""
    disk, _, level = UNEVEN["disk"]
    tuned = ss.forced_response(disk, [143.0], level, harmonics=[0, 1, 3], samples=96).dataset
    whole = ss.forced_response(disk.full([1]), [143.0], level, harmonics=[0, 1, 3], samples=96).dataset
    np.testing.assert_allclose(whole.amplitude.values[0, 0, 0], tuned.amplitude.values[0, 0, 0], rtol=1e-6)


def test_newton_has_no_unknowns_for_what_is_left_out():
    every, listed = HarmonicBalance(WEDGE, 5, 96), HarmonicBalance(WEDGE, [0, 1, 5], 96)
    assert (every.columns, listed.columns, listed.kept.tolist()) == (11, 11, [0, 1, 2, 9, 10])
    full, less = (solved(UNEVEN["wedge"], h).dataset for h in (5, [0, 1, 5]))
    assert (int(full.active_rows.max()), int(less.active_rows.max())) == (11 + 1, 5 + 1)


@pytest.mark.slow
def test_results_go_on_with_their_list(tmp_path):
    found = solved(UNEVEN["wedge"], (0, 1, 3))
    kept = ss.ForcedResponse(ss.open_results(found.save(tmp_path / "listed.nc")), WEDGE)
    assert kept.dataset.attrs["harmonics"] == "0, 1, 3"
    frequency = float(kept.dataset.peak_frequency[0, 0, 0])
    between = kept.at([frequency])
    assert float(between.error.max()) < 1e-3
    assert float(between.amplitude[0, 0, 0, 0]) == pytest.approx(float(kept.dataset.peak_amplitude[0, 0, 0]), rel=1e-6)
    check = kept.verify_in_time(0, kept.peak_point())
    assert "harmonics 0, 1, 3" in str(check)
    moved = kept.sensitivity(0, kept.peak_point() // 2, {"pull": ss.Parameter(120.0, wedge_of)})
    step = 1e-3
    ends = [ss.forced_response(wedge_of(120.0 + d), [moved.frequency], harmonics=(0, 1, 3), samples=96) for d in (-step, step)]
    low, high = (complex(*end.dataset.response.values[0, 0, 0, 1]) for end in ends)
    assert moved.by_parameter["pull"][0, 1] == pytest.approx((high - low) / (2.0 * step), rel=1e-4)


WRONG = {
    "must hold 1, the harmonic of the frequency itself, but is [0, 2]": [0, 2],
    "must be a list in ascending order, each harmonic once, but is [0, 3, 1]": [0, 3, 1],
    "must be a list in ascending order, each harmonic once, but is [0, 1, 1]": [0, 1, 1],
    "harmonics[2] must be at least 0, but is -2": [0, 1, -2],
    "harmonics[2] must be a whole number, but is 2.5": [0, 1, 2.5],
    "harmonics[2] must be at most 1000, but is 2000": [0, 1, 2000],
    "must hold 0, the mean, since there are static loads": np.array([1, 3]),
}


@pytest.mark.parametrize("said", WRONG)
def test_a_list_that_cannot_be_is_refused(said):
    with pytest.raises(ss.InputError) as raised:
        ss.forced_response(WEDGE, [222.0], harmonics=WRONG[said])
    assert said in str(raised.value)


def test_the_mean_is_left_out_only_where_it_is_zero():
    structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), damping=ss.ModalDamping(0.01))

    def problem(law, start=None, harmonic=1):
        normal = ss.between("1.x", "ground") if law.has_normal else None
        tangential = () if law.has_normal else (ss.between("1.x", "ground"),)
        contact = ss.Contact("c", law, tangential, normal, start or ss.SliderOffset())
        return ss.Problem(structure, (contact,), (ss.Force("1.x", {1: 0.1, harmonic: 0.1}),), ("1.x",))

    slider, one = ss.Macroslip(0.5, 0.5, normal_load=0.1), [0.2]
    assert ss.forced_response(problem(slider), one, harmonics=[1, 3]).dataset.response.values[0, 0, 0, 0, 0] == 0.0
    for other, said in (
        (problem(slider, ss.SliderOffset(0.01)), "contact c starts off the middle"),
        (problem(slider, ss.TractionRatio(0.0)), "contact c starts off the middle"),
        (problem(ss.Gap(0.5, gap=0.1)), "the normal load of contact c varies"),
    ):
        with pytest.raises(ss.InputError, match=f"must hold 0, the mean, since {said}"):
            ss.forced_response(other, one, harmonics=[1, 3])
    with pytest.raises(ss.InputError, match="must hold the load's harmonic 2"):
        ss.forced_response(problem(slider, harmonic=2), one, harmonics=[0, 1, 3])
    with pytest.raises(ss.InputError, match="must hold 0, the mean, since start states shift it"):
        ss.response_samples(problem(slider), one, starts=2, harmonics=[1, 3])
    with pytest.raises(ss.InputError, match="must hold 0, the mean, since start states shift it"):
        ss.response_history(problem(slider), one, [1.0, 2.0], harmonics=[1, 3])


STUDY = """
[study]
analysis = "{analysis}"
[structure]
rig = "three_mass_wedge"
[sweep]
frequency = [200.0, 235.0]
harmonics = {harmonics}
samples = 64
"""


def test_a_study_file_takes_a_list(tmp_path):
    found = job(STUDY.format(analysis="forced_response", harmonics="[0, 1, 3]"), tmp_path, "listed")
    assert "harmonics 0, 1, 3" in found.plan.summary
    (work,) = found.plan.works.values()
    by_file = work.gathered([work.solve(0, lambda fraction: None)]).dataset
    by_hand = ss.forced_response(WEDGE, ss.hertz(200.0, 235.0), harmonics=[0, 1, 3], samples=64).dataset
    np.testing.assert_array_equal(by_file.amplitude, by_hand.amplitude)
    assert by_file.attrs["harmonics"] == "0, 1, 3"


@pytest.mark.parametrize(
    ("harmonics", "said"),
    [
        ("[1, 3]", "must hold 0, the mean, since there are static loads"),
        ("[0, 2]", "must hold 1, the harmonic of the frequency itself"),
        ("[0, 1, 20]", "samples must be at least 4 x harmonics + 2 = 82"),
        ("[]", "harmonics"),
        ("[0, 1, -3]", "harmonics"),
        ("[0, 1.5]", "harmonics"),
        ("0", "harmonics"),
    ],
)
def test_a_wrong_list_is_a_fault_of_the_file(harmonics, said, tmp_path):
    with pytest.raises(ss.InputError) as raised:
        job(STUDY.format(analysis="forced_response", harmonics=harmonics), tmp_path, "wrong")
    assert said in str(raised.value)


def test_other_analyses_take_a_list():
    bounds = ss.response_bounds(WEDGE, [222.0], cloud=2, starts=1, harmonics=[0, 1, 3], samples=64).dataset
    assert bounds.attrs["harmonics"] == "0, 1, 3"
    history = ss.response_history(WEDGE, [220.0, 222.0], [1.0], harmonics=[0, 1, 3], samples=64).dataset
    alone = ss.forced_response(WEDGE, [220.0], harmonics=[0, 1, 3], samples=64).dataset
    assert history.attrs["harmonics"] == "0, 1, 3"
    np.testing.assert_allclose(history.amplitude.values[0, 0], alone.amplitude.values[0, 0], rtol=1e-6)
    assert float(bounds.amplitude.min()) <= float(history.amplitude.values[0, 1, 0]) <= float(bounds.amplitude.max()) * (1 + 1e-9)
    drawn = ss.response_samples(WEDGE, [222.0], starts=2, harmonics=[0, 1, 3], samples=64).dataset
    assert drawn.attrs["harmonics"] == "0, 1, 3"
    ends = ss.hertz(200.0, 235.0)
    listed, every = (ss.performance_curve(WEDGE, [2.0], band=ends, harmonics=h, samples=64).dataset for h in ([0, 1, 3], 3))
    assert listed.attrs["harmonics"] == "0, 1, 3"
    assert 0.0 < abs(float(listed.amplitude[0, 0] / every.amplitude[0, 0]) - 1.0) < 0.05
