"""What a slow free decay shows of a nonlinear mode: its frequency, and a damping ratio larger than that of the mode."""

from __future__ import annotations

import numpy as np

from stickslip.support.checks import Array


def decay_damping(frequency: Array, damping_ratio: Array, energy: Array, amplitude: Array) -> Array:
    """Damping ratio with which the amplitude of an output falls in a slow decay along a nonlinear mode, (points,) each, from its
    frequency [Hz], damping ratio, mechanical energy [J] and the amplitude of that output [m]; NaN where there is no curve.

    The mode loses W = 2πζP a cycle, P = ω²s², s² = q̂ᵀMq̂. The energy E that a decay has left at its turning points is less than
    P/2 where contacts have slipped: friction keeps back what it does not return. By Masing's rule a contact of amplitude x and
    force f on its first loading stores xf − ∫f dx, so that dE = q̂ᵀK dq̂ + x df, and with (K − ω²M)q̂ + f = 0

        dE = dP − ω² q̂ᵀM dq̂ = P (1 + 2 d ln ω/d ln s) d ln s.

    Over a cycle of 2π/ω, ds/dt = −ζωs/(1 + 2 d ln ω/d ln s), and an output falls by d ln A/d ln s of that:

        ζ_decay = ζ (d ln A/d ln s)/(1 + 2 d ln ω/d ln s).

    Friction softens, so that a decay is more damped than its mode. Forces count with their first harmonic, which is close for
    microslip; for a single slider the difference between decay and mode comes out about half too large.
    """
    found = np.array(damping_ratio, dtype=float)
    known = np.isfinite(frequency) & np.isfinite(energy) & (energy > 0.0) & np.isfinite(amplitude) & (amplitude > 0.0)
    if np.count_nonzero(known) < 2:
        return found
    omega = np.log(frequency[known])
    size = 0.5 * np.log(energy[known]) - omega
    along, falling, turning = (np.gradient(values) for values in (size, np.log(amplitude[known]), omega))
    # At a fold of the curve nothing changes with s, and the mode itself is all that is known.
    slope = 1.0 + 2.0 * np.divide(turning, along, out=np.zeros_like(along), where=along != 0.0)
    share = np.divide(falling, along, out=np.ones_like(along), where=along != 0.0)
    found[known] *= np.where(slope > 0.0, share / np.where(slope > 0.0, slope, 1.0), 1.0)
    return found
