"""A lightly damped mass that meets an elastic stop: its peaks against the closed form of the undamped free motion.

The free motion is a cosine outside the stop, a cosine of the stiffer oscillator inside it. At a peak the force is in phase with
the velocity and gives what the damper takes: F X_1 = c ω Σ h² X_h². Light damping leaves the motion as it is, up to ζ².
"""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import stickslip as ss

KN, GAP, MASS, STIFFNESS = 3.0, 1.0, 1.0, 1.0


def free_motion(speed, harmonics):
    """ω, and X_h of harmonics 0 to H of the free motion that passes the gap at a speed; time zero is where it is deepest."""
    outer, inner = np.sqrt(STIFFNESS / MASS), np.sqrt((STIFFNESS + KN) / MASS)
    rest = KN * GAP / (STIFFNESS + KN)
    inside = np.arctan2(speed / inner, GAP - rest) / inner
    outside = (np.pi - np.arctan2(speed / outer, GAP)) / outer
    deep, far, half = np.hypot(GAP - rest, speed / inner), np.hypot(GAP, speed / outer), inside + outside
    omega = np.pi / half

    def position(time):
        return rest + deep * np.cos(inner * time) if time < inside else -far * np.cos(outer * (half - time))

    shares = [2.0 if h else 1.0 for h in range(harmonics + 1)]
    parts = [
        sum(
            quad(lambda t, h=h: position(t) * np.cos(h * omega * t), *ends, epsabs=1e-13)[0]
            for ends in ((0, inside), (inside, half))
        )
        for h in range(harmonics + 1)
    ]
    return omega, np.array(shares) * np.array(parts) / half


def peak(force, damping):
    """Frequency and amplitude of the first harmonic at the peak of a force level."""

    def balance(speed):
        omega, motion = free_motion(speed, 24)
        return damping * omega * np.sum(np.arange(25) ** 2 * motion**2) - force * motion[1]

    speed = brentq(balance, 0.05, 40.0, xtol=1e-10)
    omega, motion = free_motion(speed, 1)
    return omega, abs(motion[1])


@pytest.mark.parametrize("ratio", [1e-5, 1e-4, 1e-3])
@pytest.mark.parametrize("samples", [96, 512])
def test_the_only_peak_is_where_the_force_balances_the_damping(ratio, samples):
    structure = ss.Structure([[MASS]], [[STIFFNESS]], ("1.x",), C=[[2.0 * ratio]])
    stop = ss.Contact("stop", ss.Gap(KN, gap=GAP), normal=ss.between("1.x", "ground"))
    problem = ss.Problem(structure, (stop,), (ss.Force("1.x", 1.0),), ("1.x",))
    band, force = ss.radians_per_second(0.9, 1.9), 10.0 * ratio
    found = ss.forced_response(problem, band, force, harmonics=20, samples=samples)
    omega, amplitude = peak(force, 2.0 * ratio)
    assert int(found.dataset.case_outcome[0]) == ss.Outcome.CONVERGED
    peaks = found.peaks()
    heights, frequencies = (each.values[np.isfinite(each.values)] for each in (peaks.amplitude, peaks.frequency))
    assert heights == pytest.approx([amplitude], rel=1e-4)
    assert frequencies == pytest.approx([omega / (2.0 * np.pi)], rel=1e-4)
