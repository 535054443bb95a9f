"""A witness of `make robustness`: every resonance of lightly damped structures is found, beside exact and solved peaks."""

from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from robustness import problems
from robustness.resonances import HARMONICS, RATIOS, SAMPLES, STUCK, Tally, linear_peaks, random_case, solved_peaks
from stickslip.model.contact.protocol import HELD, SLIPPING
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.resonances import REMEMBERED, Resonances
from stickslip.solve.continuation import steps
from stickslip.solve.curves.curve import _hills, solve_curve
from stickslip.solve.peaks.search import PeakSearch

CASES = [
    *(("chain", seed) for seed in range(2)),
    *(pytest.param("chain", seed, marks=pytest.mark.nightly) for seed in range(2, 6)),
    ("beam", 0),
    pytest.param("beam", 1, marks=pytest.mark.nightly),
]


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize(("kind", "seed"), CASES)
def test_every_peak_of_a_stuck_structure_is_found(kind, seed, ratio):
    case, tally = random_case(kind, ratio, seed), Tally()
    tally.add(case, STUCK * case.level, linear_peaks(case), exact=True)
    assert tally.wrong == []


def test_a_shoulder_that_only_just_dips_between_the_points_of_a_curve_is_a_peak():
    """0.2747 m beside a trough of 0.2740 m and a higher peak; no point of the curve lies in the trough."""
    case, tally = random_case("chain", 1e-2, 91), Tally()
    tally.add(case, STUCK * case.level, linear_peaks(case), exact=True)
    assert tally.peaks == 8
    assert tally.wrong == []


def test_a_resonance_adds_the_motion_of_its_mode():
    """One mass, stuck: F/(c ω) at ω = √2, the motion of the output at resonance; contacts as without force."""
    problem = ss.rigs.single_mass(damping=0.03, kt=1.0, limit=1e6)
    resonances = Resonances(problem, 1)
    k = int(np.argmin(np.abs(resonances.omega - np.sqrt(2.0))))
    added = resonances.motion(k, 2.0, np.zeros((1, 2)), np.zeros((1, 2)))
    np.testing.assert_allclose(added, 2.0 / (0.03 * np.sqrt(2.0)), rtol=1e-12)


def test_resonances_of_a_third_harmonic_of_a_complex_force():
    """One mass, free at ω = 1 and stuck at √2, half-width c/2m = 0.015, all over h. A contact force of the phase of the force
    takes its motion away, and its opposite doubles it."""
    problem = ss.rigs.single_mass(damping=0.03, kt=1.0, limit=1e6)
    load = 0.3 - 0.4j
    resonances = Resonances(replace(problem, forces=(ss.Force("1.x", {1: 1.0, 3: load}),)), [1, 3])
    np.testing.assert_allclose(resonances.omega, [1.0 / 3.0, np.sqrt(2.0) / 3.0, 1.0, np.sqrt(2.0)], rtol=1e-12)
    np.testing.assert_allclose(resonances.width, [0.005, 0.005, 0.015, 0.015], rtol=1e-12)
    for k, size in ((0, 1.0), (1, np.sqrt(2.0))):
        for share in (0.0, 1.0, -1.0):
            held = 2.0 * share * np.array([[load.real, -load.imag]])
            forces, carried = (np.zeros((1, 2)), held) if k == 0 else (held, np.zeros((1, 2)))
            motion = (1.0 - share) * 2.0 * abs(load) / (0.03 * size)
            np.testing.assert_allclose(resonances.motion(k, 2.0, forces, carried), motion, rtol=1e-12, atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "seed", "ratio"),
    [
        pytest.param("chain", 62, 1e-2, marks=pytest.mark.nightly),
        ("chain", 0, 1e-4),
        pytest.param("beam", 1, 1e-3, marks=pytest.mark.nightly),
        pytest.param("partly stuck chain", 1, 1e-4, marks=pytest.mark.nightly),
    ],
)
def test_every_peak_with_slip_is_found(kind, seed, ratio):
    case, tally = random_case(kind, ratio, seed), Tally()
    reference = solved_peaks(case)
    tally.add(case, case.level, reference, exact=False)
    assert reference
    assert tally.wrong == []


def two_masses():
    """ζ = 1e-4, so that the second peak is as narrow as 4e-4 rad/s."""
    structure = ss.Structure(np.eye(2), np.array([[2.0, -1.0], [-1.0, 2.0]]), ("1.x", "2.x"), damping=ss.ModalDamping(1e-4))
    slider = ss.Contact("slider", ss.Macroslip(kt=0.5, mu=0.5, normal_load=1.0), (ss.between("1.x", "ground"),))
    return ss.Problem(structure, (slider,), (ss.Force("1.x", 1.0),), ("1.x",))


@pytest.mark.parametrize("band", [(0.5, 2.5), (2.5, 0.5), (0.9, 2.2)])
def test_a_narrow_second_peak_is_not_passed_over(band):
    """Stuck contact: |X| = |[K + BᵀK_cB + iωC − ω²M]⁻¹| exactly, 9.468e-4 at 1.8113 rad/s for unit force."""
    response = ss.forced_response(two_masses(), ss.radians_per_second(*band), force=1e-6)
    peaks = response.peaks()
    highest = peaks.loc[(peaks.frequency * 2.0 * np.pi - 1.8113).abs() < 1e-3]
    np.testing.assert_allclose(highest.amplitude, 9.468e-4, rtol=1e-4)
    frequencies = response.dataset.frequency.values[0]
    travelled = np.diff(frequencies[np.isfinite(frequencies)])
    assert np.all(travelled * (band[1] - band[0]) > 0.0)
    assert np.isfinite(response.at([1.8113 / (2.0 * np.pi)]).amplitude.values).sum() == 1


def cantilever(ratio, outputs, elements=12, length=0.3, bending=210e9 * 1.6667e-9, mass=1.56):
    """A steel cantilever of Euler-Bernoulli elements, EI [N m²] and mass [kg/m], with a slider at its fourth node."""
    h = length / elements
    k = (
        bending
        / h**3
        * np.array([[12, 6 * h, -12, 6 * h], [0, 4 * h**2, -6 * h, 2 * h**2], [0, 0, 12, -6 * h], [0, 0, 0, 4 * h**2]])
    )
    m = (
        mass
        * h
        / 420
        * np.array([[156, 22 * h, 54, -13 * h], [0, 4 * h**2, 13 * h, -3 * h**2], [0, 0, 156, -22 * h], [0, 0, 0, 4 * h**2]])
    )
    K, M = np.zeros((2, 2 * elements + 2, 2 * elements + 2))
    for e in range(elements):
        part = slice(2 * e, 2 * e + 4)
        K[part, part] += np.triu(k) + np.triu(k, 1).T
        M[part, part] += np.triu(m) + np.triu(m, 1).T
    names = tuple(f"{node}.{direction}" for node in range(1, elements + 1) for direction in ("y", "rz"))
    structure = ss.Structure(M[2:, 2:], K[2:, 2:], names, damping=ss.ModalDamping(ratio))
    slider = ss.Contact("slider", ss.Macroslip(kt=1e6, mu=0.5, normal_load=100.0), (ss.between("4.y", "ground"),))
    return ss.Problem(structure, (slider,), (ss.Force("12.y", 1.0),), outputs)


@pytest.mark.parametrize(("ratio", "end"), [(2e-5, 9000.0), (1e-2, 90_000.0)])
def test_a_linear_curve_has_no_peak_twice_and_never_turns_back(ratio, end):
    """Points solved inside a step across a narrow resonance must not be those of its other side."""
    problem = cantilever(ratio, ("12.y", "6.y"))
    response = ss.forced_response(problem, ss.hertz(50.0, end), force=1e-9, harmonics=1, samples=32)
    frequencies = response.dataset.frequency.values[0]
    assert np.all(np.diff(frequencies[np.isfinite(frequencies)]) > 0.0)
    peaks = response.peaks()
    C, force = problem.C, problem.structure.row({"12.y": 1.0})
    for name in problem.output_names:
        for peak in peaks[peaks.output == name].itertuples():
            beside = 2.0 * np.pi * peak.frequency * (1.0 + ratio * np.array([-0.1, 0.0, 0.1]))
            stiffness = [problem.stuck_stiffness + 1j * w * C - w * w * problem.structure.M for w in beside]
            sizes = [abs(problem.structure.row({name: 1.0}) @ np.linalg.solve(matrix, force)) for matrix in stiffness]
            assert sizes[1] > (1.0 - 1e-6) * max(sizes[0], sizes[2])
            assert peak.amplitude == pytest.approx(1e-9 * sizes[1], rel=1e-5)


def random_frame(seed, preload, varying=True):
    """Three masses, dense M⁻¹K, two contacts with gaps that open: tops full of corners that samples make."""
    rng = np.random.default_rng(seed)
    factor = rng.normal(size=(3, 3))
    K, M, names = factor @ factor.T + 0.3 * np.eye(3), np.diag(rng.uniform(0.5, 2.0, 3)), ("1.x", "2.x", "3.x")

    def direction():
        return {name: float(value) for name, value in zip(names, rng.normal(size=3), strict=True)}

    contacts = []
    for j in range(2):
        tangential, normal = direction(), direction()
        load = rng.uniform(0.5, 1.5) * preload
        kt = rng.uniform(0.3, 3.0)
        if varying:
            law = ss.Macroslip(kt=kt, mu=0.5, kn=rng.uniform(0.3, 3.0), preload=load)
            contacts.append(ss.Contact(f"c{j}", law, (tangential,), normal, balanced=True))
        else:
            contacts.append(ss.Contact(f"c{j}", ss.Macroslip(kt=kt, mu=0.5, normal_load=load), (tangential,)))
    force = direction()
    structure = ss.Structure(M, K, names, damping=ss.ModalDamping(0.01))
    problem = ss.Problem(structure, tuple(contacts), (ss.Force(force, 1.0),), names)
    return problem, [0.5 * problem.frequencies(stuck=False)[0], 1.2 * problem.frequencies(stuck=True)[-1]]


@pytest.mark.parametrize(
    ("seed", "preload", "varying", "level", "output", "samples"),
    [(3, 2.0, True, 3.0, 1, 256), (2, 2.0, True, 0.3, 0, 128), (7, 1.0, False, 3.0, 0, 256)],
)
def test_peaks_do_not_depend_on_the_direction_of_the_sweep(seed, preload, varying, level, output, samples):
    """The highest peak, and those that dip by two parts in a thousand; none is below a point of its curve."""
    problem, ends = random_frame(seed, preload, varying)
    found = []
    for band in (ends, ends[::-1]):
        response = ss.forced_response(problem, ss.hertz(*band), force=level, harmonics=5, samples=samples)
        peaks = response.peaks()
        found.append(peaks[peaks.output == problem.output_names[output]])
        assert found[-1].amplitude.max() >= np.nanmax(response.dataset.amplitude.values[0, :, output]) * (1.0 - 1e-6)
    assert found[0].amplitude.max() == pytest.approx(found[1].amplitude.max(), rel=1e-7)
    if not varying:
        np.testing.assert_allclose(np.sort(found[0].amplitude), np.sort(found[1].amplitude), rtol=1e-5)


def test_peaks_among_points_that_go_back_behind_a_corner_are_searched():
    problem, ends = random_frame(4, 2.0)
    response = ss.forced_response(problem, ss.hertz(*ends), force=3.0, harmonics=5, samples=128)
    assert len(response.peaks()) > 10


@pytest.mark.nightly
def test_the_witness_fails_without_a_look_for_resonances(monkeypatch):
    monkeypatch.setattr(steps, "hidden_resonance", lambda *of: None)
    tally = Tally()
    for seed in range(6):
        case = random_case("chain", 1e-4, seed)
        tally.add(case, STUCK * case.level, linear_peaks(case), exact=True)
    assert tally.missing + tally.low > 0


def test_an_output_that_does_not_move_leaves_the_curve_alone():
    """A symmetric chain driven antisymmetrically: its middle is a node, and has no peaks, since it moves by rounding alone."""
    K = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]])
    structure = ss.Structure(np.eye(3), K, ("1.x", "2.x", "3.x"), damping=ss.ModalDamping(1e-2))
    law = ss.Macroslip(kt=0.5, mu=0.5, normal_load=1.0)
    sliders = tuple(ss.Contact(f"slider {i}", law, (ss.between(f"{i}.x", "ground"),)) for i in (1, 3))
    forces = (ss.Force("1.x", 1.0), ss.Force("3.x", -1.0))
    band = ss.radians_per_second(0.5, 2.5)
    alone = ss.forced_response(ss.Problem(structure, sliders, forces, ("2.x",)), band)
    both = ss.forced_response(ss.Problem(structure, sliders, forces, ("2.x", "1.x")), band)
    assert alone.dataset.case_outcome.values[0] == both.dataset.case_outcome.values[0] == ss.Outcome.CONVERGED
    assert alone.peaks().empty
    assert set(both.peaks().output) == {"1.x"}


def test_a_low_hump_beside_a_high_peak_is_a_peak():
    """Chain 4 with ζ = 1e-2: a peak of the first output rises by 0.4 % out of the flank of a higher one."""
    case = random_case("chain", 1e-2, 4)
    balance = HarmonicBalance(case.problem, HARMONICS, SAMPLES)
    curve = solve_curve(balance, case.band, case.level, exactly=False)
    search = PeakSearch(balance, curve.points)
    assert any(abs(point.point.omega - 0.1704) < 2e-3 for point in search.peaks(0).points)


@pytest.mark.parametrize(("kind", "seed"), [("constant load", 31), ("varying load", 30), ("lift-off", 34)])
def test_every_maximum_among_the_points_of_a_curve_is_a_peak(kind, seed):
    """At number 30 of the varying load the curve turns at a sharp corner, where its highest point is."""
    case = problems.random_case(kind, seed)
    response = ss.forced_response(case.problem, case.band, case.level, harmonics=5, samples=256)
    amplitudes = response.dataset.amplitude.values[0, :, 0]
    amplitudes = amplitudes[np.isfinite(amplitudes)]
    peaks = response.dataset.peak_amplitude.values[0, :, 0]
    hills = _hills(amplitudes, 1e-2)
    assert hills
    for low, high in hills:
        top = amplitudes[low : high + 1].max()
        assert np.nanmin(np.abs(peaks / top - 1.0)) < 1e-3


def one_sticks_the_other_slips():
    """Three masses, ζ of 1e-4: a strong slider always sticks, a weak one slips; so the resonances are those of neither limit."""
    K = 2.0 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1)
    K[-1, -1] = 1.0
    structure = ss.Structure(np.eye(3), K, ("1.x", "2.x", "3.x"), C=2e-4 * np.eye(3))
    sliders = tuple(
        ss.Contact(f"on {dof}", ss.Macroslip(kt=kt, mu=0.5, normal_load=2.0 * limit), (ss.between(dof, "ground"),))
        for dof, kt, limit in (("1.x", 2.0, 1e6), ("2.x", 1.0, 1e-2))
    )
    return ss.Problem(structure, sliders, (ss.Force("3.x", 1.0),), ("3.x",))


@pytest.mark.parametrize("band", [(0.05, 0.5), (0.5, 0.05)])
def test_resonances_with_some_contacts_stuck_are_found(band):
    """Beside solutions at listed frequencies around the resonances of the structure with the strong slider alone stuck."""
    problem = one_sticks_the_other_slips()
    peaks = ss.forced_response(problem, ss.hertz(*band), force=1.0).peaks()
    stuck_alone = problem.structure.K + 2.0 * np.diag([1.0, 0.0, 0.0])
    for natural in np.sqrt(np.linalg.eigvalsh(stuck_alone)) / (2.0 * np.pi):
        listed = (natural + 3e-3 * natural * np.linspace(-1.0, 1.0, 301)).tolist()
        exact = float(ss.forced_response(problem, listed, force=1.0).dataset.amplitude.max())
        near = peaks[(peaks.frequency / natural - 1.0).abs() < 3e-3]
        assert near.amplitude.max() >= (1.0 - 1e-3) * exact


def test_resonances_of_few_states_of_contacts_are_kept():
    """Of 62 states of six contact rows the last few; one that is met again has the resonances it had."""
    problem = problems.random_case("varying load", 0).problem
    rows = len(problem.contact_stiffness)
    resonances = Resonances(problem, 1)
    states = [np.array([SLIPPING if number >> bit & 1 else HELD for bit in range(rows)]) for number in range(1, 2**rows - 1)]
    found = [resonances.where_stuck(state) for state in states]
    assert len(found) > 2 * REMEMBERED
    assert len(resonances._stuck) <= REMEMBERED + 2
    again = resonances.where_stuck(states[0])
    assert again is not found[0]
    np.testing.assert_array_equal(again.omega, found[0].omega)


def test_narrow_peaks_of_a_wide_band_are_found():
    """A band from 0.03 to 300 times a resonance with ζ = 2.4e-7; its half-width is 5e-9 of the band."""
    K = np.array([[1.0, -0.1], [-0.1, 4.0]])
    structure = ss.Structure(np.eye(2), K, ("1.x", "2.x"), C=2e-6 * np.eye(2))
    slider = ss.Contact("slider", ss.Macroslip(kt=0.5, mu=0.5, normal_load=1.0), (ss.between("2.x", "ground"),))
    problem = ss.Problem(structure, (slider,), (ss.Force("1.x", 1.0),), ("2.x",))
    peaks = ss.forced_response(problem, ss.hertz(0.01, 100.0), force=1e-9).peaks()
    natural = np.sqrt(np.linalg.eigvalsh(problem.stuck_stiffness))
    np.testing.assert_allclose(np.sort(peaks.frequency), natural / (2.0 * np.pi), rtol=1e-6)
    for omega in natural:
        exact = 1e-9 * abs(np.linalg.solve(problem.stuck_stiffness + 2e-6j * omega * np.eye(2) - omega**2 * np.eye(2), [1, 0])[1])
        assert np.min(np.abs(peaks.amplitude / exact - 1.0)) < 1e-3


def test_the_points_of_a_linear_curve_never_turn_back():
    """Those that are added between the steps of a wide band too: planes across a step meet the curve far away as well."""
    K = np.diag([1.0, 4.0, 9.0]) - 0.01 * (np.ones((3, 3)) - np.eye(3))
    structure = ss.Structure(np.eye(3), K, ("1.x", "2.x", "3.x"), C=2e-5 * np.eye(3))
    slider = ss.Contact("slider", ss.Macroslip(kt=1.0, mu=0.5, normal_load=1.0), (ss.between("2.x", "ground"),))
    problem = ss.Problem(structure, (slider,), (ss.Force("1.x", 1.0),), ("1.x",))
    frequencies = ss.forced_response(problem, ss.hertz(100.0, 0.01), force=1e-9).dataset.frequency.values[0]
    assert np.all(np.diff(frequencies[np.isfinite(frequencies)]) < 0.0)


@pytest.mark.parametrize("band", [(100.0, 220.0), (220.0, 100.0)], ids=["up", "down"])
def test_a_smooth_lightly_damped_peak_is_proven_from_both_sides(band):
    """A plane across a step meets both sides of the narrow resonance: places of the far side were taken for unsolved ones."""
    structure = ss.Structure(M=[[1.0]], K=[[1e6]], C=[[0.2]], dofs=("1.x",))
    contact = ss.Contact("slider", ss.TanhCoulomb(mu=0.5, normal_load=20.0, v0=0.1), (ss.between("1.x", "ground"),))
    problem = ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0),), ("1.x",))
    found = ss.forced_response(problem, ss.hertz(*band), force=13.0, harmonics=9, samples=1024)
    assert "could not be solved" not in str(found.dataset.case_message.values[0])
    assert found.peaks().amplitude[0] == pytest.approx(1.4612360591e-3, rel=1e-8)


@pytest.mark.parametrize("level", [0.11498147770792445, 0.12324407300134943])
def test_no_peak_is_listed_twice(level):
    """A top rippled by 64 samples: the peak at the end of one searched part is not found again at the start of the next."""
    K = [[2.7249028, -0.0032880464, -0.1003097976], [-0.0032880464, 2.8675034653, 0.0057648203]]
    K = np.array([*K, [-0.1003097976, 0.0057648203, 3.063404862]])
    damping = ss.ModalDamping(1e-5, on="free")
    structure = ss.Structure(np.diag([0.76737815, 1.92877094, 1.9101865]), K, ("1.x", "1.y", "1.z"), damping=damping)
    law = ss.TanhCoulomb(mu=0.18914, v0=0.65856, normal_load=2.64736)
    contact = ss.Contact("c", law, (ss.between("1.x", "ground"), ss.between("1.z", "ground")))
    force = ss.Force({"1.x": -0.91749, "1.y": -0.56891, "1.z": -0.53759}, -0.08789 - 0.96738j)
    problem = ss.Problem(structure, (contact,), (force,), ("1.x",))
    found = ss.forced_response(problem, ss.hertz(0.39007633, 0.09702653), force=level, harmonics=1, samples=64).peaks()
    assert found.frequency.is_unique
