"""Periods of motion as they are drawn: they obey the equations of motion of the dampers that they show."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.analyses.motion import LIFTED, PARTLY, SLIPPING, STUCK, kept_motion, point_states, response_motion
from stickslip.model.contact.protocol import OPEN, SLIP_DOWN, SLIP_UP, STICK

PULL, MASS = 60.0, 0.02


@pytest.fixture(scope="module")
def response():
    problem = ss.rigs.blade_and_wedge(pull=PULL, damper_mass=MASS)
    return ss.forced_response(problem, ss.Band(300.0, 360.0), 20.0, harmonics=7, samples=96)


@pytest.fixture(scope="module")
def motion(response):
    return response.animate().motion


def accelerations(motion, omega):
    """Second derivative of periodic samples (frames, 2), by their Fourier series."""
    spectrum = np.fft.rfft(motion, axis=0)
    orders = np.arange(len(spectrum))
    return np.fft.irfft(-((orders * omega) ** 2)[:, None] * spectrum, len(motion), axis=0)


def test_forces_in_the_picture_accelerate_the_damper(response, motion):
    """Newton's law of the wedge, harmonic by harmonic up to those that are kept: m ü = pull + Σ forces of the arrows."""
    (body,) = motion.bodies
    omega = 2.0 * np.pi * float(response.dataset["frequency"][0, response.peak_point()])
    forces = sum((point.force for point in motion.points), np.array([0.0, PULL]))
    spectrum = np.fft.rfft(forces - MASS * accelerations(body.motion[:, :2], omega), axis=0) / len(forces)
    # 48 frames of 96 samples alias the friction force's harmonics from 41 on into the kept ones.
    assert np.abs(spectrum[:8]).max() < 1e-2 * PULL


def test_the_face_of_the_blade_moves_with_the_blade_and_the_other_one_rests(response, motion):
    blade, fixed = motion.faces
    point = response.peak_point()
    parts = response.dataset["response"].values[0, point, 0]
    angle = 2.0 * np.pi * np.arange(len(blade.motion)) / len(blade.motion)
    x = sum((complex(*parts[h]) * np.exp(1j * h * angle)).real for h in range(1, 8))
    np.testing.assert_allclose(blade.motion[:, 0], np.stack([x, np.zeros_like(x)], axis=1), atol=1e-9 * np.abs(x).max())
    np.testing.assert_allclose(fixed.motion, 0.0, atol=1e-9 * np.abs(x).max())


def test_relative_motion_in_the_picture_is_that_of_the_loops(motion):
    """Platform and damper part along the face by the displacement of the loop, but for its mean."""
    for face, point, loop in zip(motion.faces, motion.points, motion.loops, strict=True):
        tangent = np.array([face.into[1], -face.into[0]])
        apart = (point.motion - face.motion.mean(axis=1)) @ tangent
        relative = loop.displacement[::2] - loop.displacement.mean()
        assert min(np.abs(apart - s * relative).max() for s in (1, -1)) < 1e-9 * np.ptp(relative)


def test_a_turning_damper_balances_its_moments_too():
    """Quasi-static cycle of the three-point damper: Σ F + pull = 0 and Σ r × F = 0 in every frame."""
    motion = ss.damper_cycle(ss.rigs.laboratory_damper(pull=80.0), ss.dampers.in_phase(20e-6), steps=200).animate().motion
    total = sum((point.force for point in motion.points), np.array([0.0, 80.0]))
    moment = sum(p.place[0] * p.force[:, 1] - p.place[1] * p.force[:, 0] for p in motion.points)
    np.testing.assert_allclose(total, 0.0, atol=1e-6 * 80.0)
    np.testing.assert_allclose(moment, 0.0, atol=1e-6 * 80.0 * 0.01)
    lifted = [point.name for point in motion.points if np.any(point.state == LIFTED)]
    assert all(np.abs(point.force[point.state == LIFTED]).max() < 1e-9 for point in motion.points if point.name in lifted)


def test_states_at_one_place_are_summed_up():
    rows = np.array([[STICK, STICK, SLIP_UP, OPEN, OPEN], [STICK, SLIP_DOWN, SLIP_DOWN, SLIP_UP, OPEN]])
    assert point_states(rows).tolist() == [STUCK, PARTLY, SLIPPING, SLIPPING, LIFTED]


def test_kept_motion_is_that_of_the_peak(response):
    """What the report reads from results is what `animate` computes."""
    dataset = response.with_motion().dataset
    kept, fresh = kept_motion(dataset, 0), response_motion(response.dataset, response.problem, 0, response.peak_point())
    for name in ("bodies", "faces", "points"):
        for one, other in zip(getattr(kept, name), getattr(fresh, name), strict=True):
            np.testing.assert_allclose(one.motion, other.motion, rtol=1e-9, atol=1e-15)
    assert [loop.label for loop in kept.loops] == [loop.label for loop in fresh.loops]


def test_blades_of_a_tuned_disk_follow_each_other():
    """Sector j moves as the first one did j EO/N of a period before, and as blade j of the full disk."""
    disk = ss.rigs.lumped_blisk(sectors=8)
    band = [0.99 * disk.frequencies(True)[0]]
    settings = {"harmonics": 3, "samples": 96}
    tuned = ss.forced_response(disk, band, 1.0, **settings).animate(0, 0).motion.wheel
    full = ss.forced_response(disk.full(), band, 1.0, **settings).animate(0, 0).motion.wheel
    scale = np.abs(tuned.displacement).max()
    np.testing.assert_allclose(full.displacement, tuned.displacement, atol=1e-5 * scale)
    assert np.ptp(tuned.amplitude) < 1e-9 * scale
