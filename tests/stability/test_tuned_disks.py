"""Stability of tuned disks: all sectors disturbed, against SciPy's variational equation and against the full disk in time."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stickslip as ss
from stickslip.model import rigs
from stickslip.model.structure.cyclic import sector_chain

SECTORS, ENGINE_ORDER, COUPLING, DAMPING = 5, 2, 0.1, 0.02


def ring(contact, coupling=COUPLING, engine_order=ENGINE_ORDER):
    """Five masses in a ring, each on a spring of 1 N/m and on a contact, with weak springs between neighbours."""
    blade = ss.Structure(np.eye(1), np.array([[1.0 + 2.0 * coupling]]), ("b.x",), C=DAMPING * np.eye(1))
    disk = sector_chain(blade, SECTORS, [[-coupling]])
    return ss.TunedDisk(disk, (contact,), (ss.Force("b.x", 0.15),), ("b.x",), "Ring", engine_order=engine_order)


def cubic_ring():
    return ring(ss.Contact("spring", ss.CubicSpring(0.3), (ss.between("b.x", "ground"),)))


def sliding_ring():
    """Jenkins sliders between neighbours."""
    return ring(ss.Contact("slider", ss.Macroslip(0.3, 0.5, normal_load=0.3), (ss.between("b.x", "next/b.x"),)), 0.02, 1)


def multipliers_of_the_ring(omega, start):
    """Of the five masses, by their variational equation."""
    size, turns = SECTORS, 2.0 * np.pi * ENGINE_ORDER * np.arange(SECTORS) / SECTORS
    K = (1.0 + 2.0 * COUPLING) * np.eye(size) - COUPLING * (np.roll(np.eye(size), 1, 0) + np.roll(np.eye(size), -1, 0))

    def rate(t, x):
        q, v, dq, dv = x[:size], x[size : 2 * size], *x[2 * size :].reshape(2, size, 2 * size)
        force = 0.15 * np.cos(omega * t - turns) - DAMPING * v - K @ q - 0.3 * q**3
        tangent = -DAMPING * dv - (K + np.diag(0.9 * q**2)) @ dq
        return np.concatenate([v, force, dv.ravel(), tangent.ravel()])

    begin = np.concatenate([start, np.eye(2 * size).ravel()])
    end = solve_ivp(rate, (0.0, 2.0 * np.pi / omega), begin, method="DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
    return end[: 2 * size], np.linalg.eigvals(end[2 * size :].reshape(2 * size, 2 * size))


def test_a_travelling_wave_is_disturbed_in_all_sectors():
    """The wave repeats itself under SciPy's integration; other sectors make it unstable long before its curve turns."""
    problem = cubic_ring()
    response = ss.forced_response(problem, ss.Band(0.13, 0.24), harmonics=7).with_stability()
    dataset = response.dataset
    frequency, size = dataset.frequency.values[0], np.hypot(*dataset.multiplier.values[0].T)
    rising = np.arange(int(np.argmax(dataset.amplitude.values[0, :, 0])))
    assert np.all(np.diff(frequency[rising]) > 0.0)
    for point in rising[[3, rising.size // 2, rising.size - 3]]:
        omega = 2.0 * np.pi * frequency[point]
        X = dataset.response.values[0, point, 0] @ [1.0, 1.0j]
        order = np.arange(X.size)
        phases = np.exp(-2j * np.pi * ENGINE_ORDER / SECTORS * np.outer(np.arange(SECTORS), order))
        start = np.concatenate([(phases * X).sum(1).real, (1j * omega * order * phases * X).sum(1).real])
        end, exact = multipliers_of_the_ring(omega, start)
        np.testing.assert_allclose(end, start, atol=1e-4 * np.abs(start).max())
        assert size[point] == pytest.approx(np.abs(exact).max(), abs=1e-3)
    assert np.any(dataset.stability.values[0, rising] == 2)
    assert dataset.stability_change.values[0, 0] == 4


@pytest.mark.slow
def test_sliders_between_sectors_in_a_tuned_disk_and_in_the_full_one():
    """The largest multiplier of the sector's response, of that of the full disk, and of the full disk marched in time."""
    problem = sliding_ring()
    frequencies = [0.17, 0.18]
    tuned = ss.forced_response(problem, frequencies, harmonics=9, samples=500).with_stability()
    whole = ss.forced_response(problem.full(), frequencies, harmonics=9, samples=500).with_stability()
    sizes = [np.hypot(*response.dataset.multiplier.values[0].T) for response in (tuned, whole)]
    assert sizes[0] == pytest.approx(sizes[1], abs=1e-6)
    assert tuned.dataset.stuck_sliders.values.tolist() == whole.dataset.stuck_sliders.values.tolist() == [[0, 0]]
    check = whole.verify_in_time(0, 1, steps_per_period=2000, periods=3)
    assert abs(check.multiplier) == pytest.approx(sizes[0][1], abs=1e-3)


def test_a_disk_whose_dampers_stick_says_how_many_sliders_never_slip():
    """With C of the blades alone the dampers on their springs are undamped: multipliers of size 1 to rounding, undecided."""
    undamped = rigs.lumped_blisk(force=1e-3, sectors=6)
    for problem, verdict in ((undamped.with_damping(ss.ModalDamping(0.01)), 1), (undamped, 3)):
        response = ss.forced_response(problem, [float(problem.frequencies(stuck=True)[0])], harmonics=1, samples=24)
        dataset = response.with_stability().dataset
        assert dataset.stability.values.tolist() == [[verdict]]
        assert dataset.stuck_sliders.values.tolist() == [[12]]
