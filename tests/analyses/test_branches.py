"""Branches of symmetric structures and period doublings: beside time integration by SciPy, and on rings of equal sectors."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stickslip as ss
from stickslip.analyses import further_curves
from stickslip.results.view import level_text

TURN = 2.0 * np.pi


def two_masses(coupling=0.05, damping=0.02, level=0.03):
    """Equal masses on cubic springs, pushed against each other: x1 = −x2 by symmetry."""
    K = np.array([[1.0 + coupling, -coupling], [-coupling, 1.0 + coupling]])
    structure = ss.Structure(np.eye(2), K, ("1.x", "2.x"), C=damping * np.eye(2))
    springs = [ss.Contact(f"spring {n}", ss.CubicSpring(1.0), (ss.between(f"{n}.x", "ground"),)) for n in (1, 2)]
    return ss.Problem(structure, springs, (ss.Force({"1.x": 1.0, "2.x": -1.0}, level),), ("1.x", "2.x"))


def two_masses_rates(omega, coupling=0.05, damping=0.02, level=0.03):
    """ẏ of the same, (x1, x2, v1, v2)."""

    def rates(t, y):
        x, v = y[:2], y[2:]
        force = level * np.cos(omega * t) * np.array([1.0, -1.0])
        return np.concatenate([v, force - damping * v - x - coupling * (x - x[::-1]) - x**3])

    return rates


def state(dataset, case, point):
    """ω [rad/s], and displacements and velocities of the outputs at t = 0."""
    omega = TURN * float(dataset.frequency[case, point])
    parts = dataset.response.values[case, point]
    X, h = parts[..., 0] + 1j * parts[..., 1], dataset.harmonic.values
    return omega, np.concatenate([X.real.sum(axis=1), (1j * h * omega * X).real.sum(axis=1)])


@pytest.fixture(scope="module")
def swept():
    return ss.forced_response(two_masses(), ss.radians_per_second(0.7, 1.6), harmonics=5, samples=64)


@pytest.fixture(scope="module")
def branch(swept):
    return swept.branch().with_stability()


def test_a_branch_point_is_where_the_monodromy_matrix_has_an_eigenvalue_of_one(swept):
    """Differences of SciPy's integrations over a period."""
    table = swept.branch_points()
    assert len(table) == 2
    found = ss.forced_response(two_masses(), [table["frequency"].min()], harmonics=9, samples=64)
    omega, start = state(found.dataset, 0, 0)
    rates, columns = two_masses_rates(omega), []
    for change in 1e-5 * np.eye(4):
        ends = [
            solve_ivp(rates, (0.0, TURN / omega), start + side * change, rtol=1e-11, atol=1e-13).y[:, -1] for side in (1.0, -1.0)
        ]
        columns.append((ends[0] - ends[1]) / 2e-5)
    assert np.min(np.abs(np.linalg.eigvals(np.array(columns).T) - 1.0)) < 2e-3


def test_the_branch_begins_at_the_branch_point_and_loses_the_symmetry(swept, branch):
    hertz = swept.branch_points()["frequency"].min()
    motion = branch.dataset.response.values[0, ..., 1, 0] + 1j * branch.dataset.response.values[0, ..., 1, 1]
    good = branch.dataset.outcome.values[0] == 1
    lost = np.abs(motion[good].sum(axis=1)) / np.abs(motion[good]).max(axis=1)
    frequencies = branch.dataset.frequency.values[0, good]
    assert abs(frequencies[0] / hertz - 1.0) < 1e-3
    assert lost[0] < 0.05
    assert lost.max() > 0.8
    assert str(branch.dataset.case_message.values[0]).endswith("which closes on itself.")
    assert level_text(branch.dataset, 0).endswith(", branch")


def test_the_other_half_of_the_branch_is_the_mirror_image(branch):
    """The masses change places and signs: both reach the same largest amplitude."""
    peaks = branch.peaks()
    tops = peaks[peaks["peak"] == 0].set_index("output")["amplitude"]
    np.testing.assert_allclose(tops["1.x"], tops["2.x"], rtol=1e-4)


def test_a_stable_motion_of_the_branch_is_there_in_time(branch):
    """Integrated by SciPy over 40 periods from its own state; the symmetric motion is far away."""
    dataset = branch.dataset
    stable = np.flatnonzero(dataset.stability.values[0] == 1)
    amplitudes = dataset.amplitude.values[0, stable]
    point = int(stable[np.argmax(np.abs(amplitudes[:, 0] - amplitudes[:, 1]))])
    omega, start = state(dataset, 0, point)
    end = solve_ivp(two_masses_rates(omega), (0.0, 40.0 * TURN / omega), start, rtol=1e-10, atol=1e-12).y[:, -1]
    np.testing.assert_allclose(end, start, atol=2e-3 * np.abs(start).max())
    first = np.abs(amplitudes[stable == point][0])
    assert first.max() > 3.0 * first.min()


@pytest.mark.nightly
def test_time_integration_of_this_program_agrees_on_a_branch(branch):
    stable = np.flatnonzero(branch.dataset.stability.values[0] == 1)
    assert branch.verify_in_time(0, int(stable[len(stable) // 4]), steps_per_period=1000).agrees(5e-4)


def test_curves_of_sweep_and_branch_in_one_result(swept, branch):
    joined = swept.with_curves(branch)
    assert [str(kind) for kind in joined.peaks()["curve"].unique()] == ["sweep", "branch"]
    np.testing.assert_array_equal(joined.dataset.amplitude[0, :20], swept.dataset.amplitude[0, :20])
    assert joined.plot() is not None


def ring(sectors, engine_order):
    """Equal masses on cubic springs in a ring, joined by linear ones."""
    sector = ss.Structure(np.eye(1), np.array([[1.1]]), ("b.x",), C=0.02 * np.eye(1))
    springs = (ss.Contact("spring", ss.CubicSpring(1.0), (ss.between("b.x", "ground"),)),)
    cyclic = ss.sector_chain(sector, sectors, np.array([[-0.05]]))
    return ss.TunedDisk(cyclic, springs, (ss.Force("b.x", 0.03),), ("b.x",), "ring", engine_order=engine_order)


def test_a_disk_loses_its_symmetry_in_two_directions_at_once():
    """All sectors alike: disturbances of nodal diameter 1 come in pairs, and the determinant keeps its sign."""
    swept = ss.forced_response(ring(3, 0).full(), ss.radians_per_second(0.9, 1.5), harmonics=3, samples=32)
    table = swept.branch_points()
    assert table["directions"].tolist() == [2, 2]
    # The stability found by the period map changes there.
    changes = swept.with_stability().dataset.stability_change_frequency.values[0]
    assert all(np.min(np.abs(changes / hertz - 1.0)) < 5e-3 for hertz in table["frequency"])
    branch = swept.branch()
    # One of three sectors vibrates for all: one curve for each kind of it, turned or not.
    for case in range(branch.dataset.sizes["case"]):
        amplitude = branch.dataset.amplitude.values[case]
        largest = np.sort(amplitude[np.nanargmax(amplitude.max(axis=1))])
        assert largest[2] > 5.0 * largest[1]
        np.testing.assert_allclose(largest[0], largest[1], rtol=1e-3)


def duffing(damping, force, static=0.0, stiffness=1.0):
    structure = ss.Structure(np.eye(1), stiffness * np.eye(1), ("1.x",), C=np.array([[damping]]))
    spring = ss.Contact("spring", ss.CubicSpring(1.0), (ss.between("1.x", "ground"),))
    return ss.Problem(structure, (spring,), (ss.Force("1.x", force, static),), ("1.x",))


def duffing_after(periods, omega, start, damping, force, static=0.0):
    """State after a number of periods of the excitation, by SciPy."""

    def rates(t, y):
        return [y[1], static + force * np.cos(omega * t) - damping * y[1] - y[0] - y[0] ** 3]

    return solve_ivp(rates, (0.0, periods * TURN / omega), start, rtol=1e-11, atol=1e-13).y[:, -1]


@pytest.fixture(scope="module")
def one_sided():
    """A cubic spring under a static force, which makes it uneven: its motion doubles its period."""
    return ss.forced_response(duffing(0.15, 3.0, 3.0), ss.radians_per_second(3.5, 6.0), harmonics=8, samples=128)


def test_the_period_doubles_where_a_multiplier_is_minus_one(one_sided):
    table = one_sided.branch_points(periods=2)
    assert len(table) == 2
    for hertz in table["frequency"]:
        found = ss.forced_response(duffing(0.15, 3.0, 3.0), [hertz], harmonics=16, samples=128).dataset
        omega, start = state(found, 0, 0)
        columns = [
            (duffing_after(1, omega, start + dy, 0.15, 3.0, 3.0) - duffing_after(1, omega, start - dy, 0.15, 3.0, 3.0)) / 2e-5
            for dy in 1e-5 * np.eye(2)
        ]
        assert np.min(np.abs(np.linalg.eigvals(np.array(columns).T) + 1.0)) < 2e-3
    assert one_sided.branch_points().empty


@pytest.mark.slow
def test_a_motion_of_twice_the_period_is_there_in_time(one_sided):
    doubled = one_sided.branch(periods=2).with_stability()
    dataset = doubled.dataset
    assert dataset.harmonic.values[:4].tolist() == [0.0, 0.5, 1.0, 1.5]
    stable = np.flatnonzero(dataset.stability.values[0] == 1)
    half = np.hypot(*dataset.response.values[0, :, 0, 1].T)
    point = int(stable[np.argmax(half[stable])])
    omega, start = state(dataset, 0, point)
    size = np.abs(start).max()
    after = [duffing_after(periods, omega, start, 0.15, 3.0, 3.0) for periods in (1, 40)]
    assert np.abs(after[0] - start).max() > 0.1 * size
    np.testing.assert_allclose(after[1], start, atol=2e-3 * size)
    check = doubled.verify_in_time(0, point, steps_per_period=1000)
    assert check.agrees(1e-3)
    np.testing.assert_allclose(check.harmonic_amplitude, dataset.amplitude.values[0, point])


def test_a_branch_of_twice_the_period_ends_where_its_motions_come_again(one_sided):
    """It leads from one period doubling to the other; behind that its motions are the same, one period later."""
    dataset = one_sided.branch(periods=2).dataset
    assert "which joins the curve again." in str(dataset.case_message.values[0])
    table, hertz = one_sided.branch_points(periods=2)["frequency"], dataset.frequency.values[0]
    assert [hertz[0], hertz[-1]] == pytest.approx(sorted(table, key=lambda at: abs(at - hertz[0])), rel=2e-2)
    half = dataset.response.values[0, :, 0, 1] @ [1.0, 1.0j]
    turned = np.real(half[1:] * np.conj(half[:-1]))
    assert np.all(turned[:-1] > 0.0)
    assert turned[-1] < 0.0


def periodic(omega, start, stiffness):
    """Displacement over two periods of the excitation, periodic, by Newton's method with SciPy."""
    times = np.linspace(0.0, 2.0 * TURN / omega, 257)

    def marched(y):
        def rates(t, y):
            return [y[1], 3.0 + 3.0 * np.cos(omega * t) - 0.15 * y[1] - stiffness * y[0] - y[0] ** 3]

        return solve_ivp(rates, (0.0, times[-1]), y, t_eval=times, rtol=1e-11, atol=1e-13).y

    for _ in range(6):
        missed = marched(start)[:, -1] - start
        slope = np.array([marched(start + dy)[:, -1] - marched(start - dy)[:, -1] for dy in 1e-5 * np.eye(2)]).T / 2e-5
        start = start - np.linalg.solve(slope - np.eye(2), missed)
    return marched(start)[0, :-1]


@pytest.mark.slow
def test_sensitivity_of_a_motion_of_twice_the_period(one_sided):
    """The amplitude is that at the frequency of the excitation, the second of the harmonics."""
    doubled = one_sided.branch(periods=2)
    point = doubled.dataset.sizes["point"] // 2
    stiffness = ss.Parameter(1.0, lambda k: duffing(0.15, 3.0, 3.0, k))
    found = doubled.sensitivity(0, point, {"k": stiffness})
    omega, start = state(doubled.dataset, 0, point)
    np.testing.assert_allclose(TURN * found.frequency, omega)
    low, high = (np.abs(np.fft.rfft(periodic(omega, start, k))[2]) / 128 for k in (0.999, 1.001))
    np.testing.assert_allclose(found.amplitude_slopes()["k"], (high - low) / 2e-3, rtol=2e-2)


def test_sweep_and_doubled_motions_in_one_result(one_sided):
    joined = one_sided.with_curves(one_sided.branch(periods=2))
    assert joined.dataset.attrs["periods"] == 2
    np.testing.assert_array_equal(joined.dataset.amplitude[0, :10], one_sided.dataset.amplitude[0, :10])
    np.testing.assert_allclose(joined.cycle(0, 3).displacement[:, :128], one_sided.cycle(0, 3).displacement, rtol=1e-10)


def test_a_curve_without_branch_points_says_so():
    response = ss.forced_response(ss.rigs.single_mass(), ss.radians_per_second(0.5, 2.0))
    assert response.branch_points().empty
    with pytest.raises(ss.InputError, match="no branch point"):
        response.branch()
    listed = ss.forced_response(ss.rigs.single_mass(), [0.1])
    with pytest.raises(ss.InputError, match="over a band"):
        listed.branch()
    with pytest.raises(ss.InputError, match="case"):
        response.branch(case=3)
    with pytest.raises(ss.InputError, match="problem"):
        response.with_curves(ss.forced_response(ss.rigs.single_mass(kt=2.0), ss.radians_per_second(0.5, 2.0)))


@pytest.mark.parametrize("samples", [64, 512])
def test_a_period_doubling_is_found_where_a_contact_opens_ever_later(samples):
    """Two masses at a stop: a multiplier passes -1 where the end of the opening moves over many samples at once."""
    K = np.array([[3.0, -1.0], [-1.0, 1.0]])
    structure = ss.Structure(np.diag([1.0, 0.5]), K, ("1.x", "2.x"), C=0.004 * K)
    stop = ss.Contact("stop", ss.Gap(10.0, gap=1.0), normal=ss.between("2.x", "ground"))
    problem = ss.Problem(structure, (stop,), (ss.Force("2.x", 0.05),), ("2.x",))
    response = ss.forced_response(problem, ss.radians_per_second(0.985, 1.0), harmonics=9, samples=samples)
    dataset = response.with_stability().dataset
    assert dataset.stability_change.values[0, 0] == 3
    change = float(dataset.stability_change_frequency[0, 0])
    assert response.branch_points(periods=2)["frequency"].tolist() == pytest.approx([change], rel=1e-4)
    assert response.branch(periods=2)


def test_a_curve_says_where_its_jacobian_jumps_between_samples(monkeypatch):
    """Friction that changes between stick and slip at samples; at which of them rounding decides, so the places are given."""
    alone = ss.forced_response(ss.rigs.single_mass(), ss.radians_per_second(0.5, 0.6), harmonics=3, samples=64)
    with pytest.raises(ss.InputError, match="no branch point: friction under constant loads"):
        alone.branch()
    structure = ss.Structure(np.eye(2), np.diag([1.0, 4.0]), ("1.x", "1.y"), C=0.1 * np.eye(2))
    pressed = ss.Contact("c", ss.Macroslip(1.0, 0.5, 1.0, 1.0), ({"1.x": 1.0},), {"1.y": 1.0})
    problem = ss.Problem(structure, (pressed,), (ss.Force("1.x", 1.0),), ("1.x",))
    response = ss.forced_response(problem, ss.radians_per_second(0.5, 2.0), harmonics=3, samples=64)
    with pytest.raises(ss.InputError, match="regular all along it"):
        response.branch()
    monkeypatch.setattr(further_curves, "determinant_jumps", lambda balance, points: [1.0, 1.5])
    with pytest.raises(ss.InputError, match=r"jumps over singularity near 0\.159155, 0\.238732 Hz.* 64 a period"):
        response.branch()


def test_motions_over_several_periods_of_sectors_are_refused():
    with pytest.raises(ss.InputError, match=r"disk\.full"):
        ss.forced_response(ring(3, 0), ss.radians_per_second(0.9, 1.5), harmonics=3, samples=33, periods=2)
    with pytest.raises(ss.InputError, match="periods"):
        ss.forced_response(duffing(0.1, 1.0), ss.radians_per_second(0.9, 1.5), periods=0)
    with pytest.raises(ss.InputError, match="harmonics"):
        ss.forced_response(duffing(0.1, 1.0), ss.radians_per_second(0.9, 1.5), [1, 2.0], [1, 3], periods=2)


def test_a_sweep_over_two_periods_is_that_over_one():
    one, two = (
        ss.forced_response(ss.rigs.single_mass(), ss.radians_per_second(0.5, 2.0), harmonics=3, samples=64, periods=periods)
        for periods in (1, 2)
    )
    columns = ["frequency", "amplitude", "max_abs", "loss_factor"]
    np.testing.assert_allclose(two.peaks()[columns], one.peaks()[columns], rtol=1e-6)
    for quantity, measure in (("acceleration", "amplitude"), ("velocity", "rms"), ("acceleration", "max_abs")):
        a, b = (each.peaks(quantity, measure)[["frequency", measure]] for each in (one, two))
        np.testing.assert_allclose(b, a, rtol=1e-5)
    a, b = (each.at([0.17, 0.2]) for each in (one, two))
    np.testing.assert_allclose(b.amplitude, a.amplitude, rtol=2e-3)
    np.testing.assert_allclose(
        two.as_quantity("velocity").amplitude.max(), one.as_quantity("velocity").amplitude.max(), rtol=1e-6
    )
