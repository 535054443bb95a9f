"""Synthetic measurements: a damper's cycle by Newton's method in fine steps, then the errors of a rig.

For trying an identification before trusting it: the identification computes its cycles by another scheme
(`platforms.relaxation`), and the truth may follow another law than the one that is fitted.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from stickslip.laboratory.measurement.reconstruction import RigErrors, distorted
from stickslip.laboratory.measurement.records import Record
from stickslip.model.contact.microslip import MicroslipArray
from stickslip.model.dampers.between_platforms import BetweenPlatforms
from stickslip.model.dampers.platform_motion import PlatformMotion
from stickslip.solve.platforms.cycle import CycleModel, CycleOutcome, steady_cycle
from stickslip.support.checks import Array, fault, positive

STEPS = 2000
"""Steps of a cycle of the truth."""

NO_ERRORS = RigErrors(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, lag=0.0)


def true_cycle(rig: BetweenPlatforms, motion: PlatformMotion, steps: int = STEPS) -> dict[str, Array]:
    """The signals of one steady cycle without errors, {channel: (steps,)}, SI. Any law of the damper."""
    model, platform = CycleModel.of(rig), motion.samples(steps)
    march = steady_cycle(model, platform)
    if march.outcome != CycleOutcome.STEADY:
        raise fault("The damper's cycle", "must become steady", march.outcome.name.lower(), "Take more steps or another motion.")
    forces, moved = -march.record.force @ model.right, march.record.motion
    values = (platform[:, 0], platform[:, 1], forces[:, 0], forces[:, 1], moved[:, 2], moved[:, 1])
    return dict(zip(("platform_x", "platform_y", "force_x", "force_y", "rotation", "damper_y"), values, strict=True))


def synthetic_record(
    truth: dict[str, Array],
    errors: RigErrors | None = None,
    *,
    seed: int = 0,
    systematic: dict[str, tuple[float, float, float]] | None = None,
    cycles: int = 20,
    samples: int = 400,
    frequency: float = 5.0,
    laser_distance: float = 14e-3,
    lag: float = 0.0,
    name: str = "synthetic",
) -> Record:
    """A record of so many cycles from one true cycle (`true_cycle`), with the errors of the rig.

    systematic: errors drawn before (`RigErrors.draw`), to give several records the same gains of their cells; zeros are drawn
    anew for each record. laser_distance [m]: between the two lasers that see the rotation. lag [s]: by which all forces are
    recorded later than all motions.
    """
    errors = RigErrors() if errors is None else errors
    generator = np.random.default_rng(seed)
    fresh = errors.draw(generator)
    drawn = fresh if systematic is None else {key: (*systematic[key][:2], fresh[key][2]) for key in fresh}
    count = int(positive("cycles", cycles)) * samples
    phase = (np.arange(count) / samples) % 1.0
    signals: dict[str, Array] = {}
    for key, values in truth.items():
        shown = distorted(values, drawn[key]) if key in drawn else values
        place = (phase - lag * frequency) % 1.0 if key.startswith("force") else phase
        repeated = np.interp(place, np.arange(values.size + 1) / values.size, np.append(shown, shown[0]))
        noise = errors.laser_noise * (np.sqrt(2.0) / laser_distance if key == "rotation" else 1.0)
        if key.startswith("force"):
            noise = errors.force_noise
        signals[key] = repeated + noise * generator.standard_normal(count)
    return Record(np.arange(count) / (samples * positive("frequency", frequency)), signals, name)


def with_microslip(rig: BetweenPlatforms, spread: float = 0.5, elements: int = 5) -> BetweenPlatforms:
    """The same damper with microslip arrays of the same total kt, kn, mu in place of macroslip laws.

    The gaps reach `spread` × 2 v with v = N/kn and N the pull shared over the lines of contact: below 1 all elements stay
    closed at that load.
    """
    laws, pull = [], float(rig.pull[1])
    for law in rig.laws:
        kt, kn, mu = (getattr(law, key, None) for key in ("kt", "kn", "mu"))
        if kt is None or kn is None or mu is None:
            raise fault("Every law", "must be a macroslip law", type(law).__name__)
        laws.append(MicroslipArray.from_totals(kt, kn, mu, 2.0 * spread * pull / (len(rig.laws) * kn), elements))
    return BetweenPlatforms(rig.damper, tuple(laws), rig.right, f"{rig.title}, microslip")


def loop_of(
    law_weights: ArrayLike, kt: float, mu: float, normal: float, amplitude: float, samples: int = 400
) -> tuple[Array, Array]:
    """Displacement and force (samples,) of a steady loop of one contact by marching: elements of equal kt share whose limits
    are `law_weights` (mean 1) times mu × normal / count, under u = amplitude sin."""
    weights = np.asarray(law_weights, dtype=float)
    u = amplitude * np.sin(2.0 * np.pi * np.arange(samples) / samples)
    limit, stiffness = mu * normal * weights / weights.size, kt / weights.size
    tension, force = np.zeros(weights.size), np.zeros(samples)
    last = 0.0
    for _ in range(2):
        for n in range(samples):
            tension = np.clip(tension + stiffness * (u[n] - last), -limit, limit)
            last, force[n] = u[n], tension.sum()
    return u, force
