"""Synthetic measurements of a damper rig: a damper's cycle by Newton's method in fine steps, then the errors of a rig.

For trying an identification before trusting it: the identification computes its cycles by another scheme
(`platforms.relaxation`), and the truth may follow another law than the one that is fitted.
"""

from pathlib import Path

import numpy as np

from stickslip.laboratory.measurement.reconstruction import RigErrors, distorted
from stickslip.laboratory.measurement.records import QUANTITIES, Record
from stickslip.model.dampers.between_platforms import BetweenPlatforms, PlatformMotion
from stickslip.solve.platforms.cycle import CycleModel, CycleOutcome, steady_cycle
from stickslip.support.checks import Array, fault
from stickslip.support.files import write_text

STEPS = 2000
"""Steps of a cycle of the truth."""


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
    count = cycles * samples
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
    return Record(np.arange(count) / (samples * frequency), signals, name)


def write_record(record: Record, path: str | Path) -> Path:
    """Write a record as the table that `read_record` reads, in s, um, N and rad."""
    shown = {"time [s]": record.time}
    for name, values in record.signals.items():
        metres = QUANTITIES[name] == "m"
        shown[f"{name} [{'um' if metres else QUANTITIES[name]}]"] = values * (1e6 if metres else 1.0)
    rows = [",".join(f"{value:.8g}" for value in row) for row in np.stack(list(shown.values()), axis=1)]
    return write_text(path, "\n".join([",".join(shown), *rows]) + "\n")
