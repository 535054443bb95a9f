"""Contact forces of the blade rig's dampers from the two load cells behind each.

The separator splits the force of the damper's cylinder into one part along each arm, outwards and up; its cells read them. The
flat side carries what is left of the pull: quasi-static, for the inertia of a 50 g damper is small against the forces.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.laboratory.measurement.cycles import HARMONICS, whole_cycles
from stickslip.laboratory.measurement.records import BLADE_CELLS, Record
from stickslip.support.checks import Array, fault, finite, positive, vector

if TYPE_CHECKING:
    import xarray as xr

MEANINGS = {
    "cylinder_tangential": "friction force on the damper at the cylinder, up along its platform",
    "cylinder_normal": "normal force at the cylinder, positive pressing",
    "flat_tangential": "friction force on the damper at the flat, up along the blade's platform",
    "flat_normal": "normal force at the flat, positive pressing",
}


@dataclass(frozen=True, eq=False)
class BladeDamperForces:
    """Forces on a damper (n,) [N], T along its platform (up), N pressing: at the cylinder (separator) and at the flat (blade);
    the same with the error of each, (n,) standard deviations from the errors of the cells."""

    cylinder_tangential: Array
    cylinder_normal: Array
    flat_tangential: Array
    flat_normal: Array
    errors: dict[str, Array]

    def ratio(self, side: str) -> Array:
        """T/N at "cylinder" or "flat", NaN where nothing presses."""
        tangential, normal = getattr(self, f"{side}_tangential"), getattr(self, f"{side}_normal")
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(normal > 0.0, tangential / normal, np.nan)


def blade_damper_forces(
    outward: ArrayLike,
    upward: ArrayLike,
    pull: float,
    platform_angle: float = 45.0,
    inertia: tuple[ArrayLike, ArrayLike] | None = None,
    cell_gain: float = 0.01,
    zero: float = 0.8,
    draws: int = 200,
    seed: int = 0,
) -> BladeDamperForces:
    """From the cells' readings (n,) [N]: force of the damper on the separator, outwards (away from the blade) and up.

    The separator pushes the damper by −(outward, upward); the blade by what balances that, the pull up, and m(ẍ, ÿ) where
    `inertia` gives it (n,) each. Errors: gain of each cell and zero after load removal, by sampling.
    """
    x, y = np.asarray(outward, dtype=float), np.asarray(upward, dtype=float)
    if x.shape != y.shape or x.ndim != 1 or not (np.all(np.isfinite(x)) and np.all(np.isfinite(y))):
        raise fault("Readings of the two cells", "must be finite, of one length", (x.shape, y.shape))
    if np.mean(y) < 0.0 or np.mean(x) < 0.0:
        raise fault("The mean readings", "must press the cells", (float(x.mean()), float(y.mean())), "Reversed sign or no zero?")
    positive("pull", pull)
    if y.mean() > 2.0 * pull or x.mean() > 10.0 * pull:
        raise fault("The mean readings", "must be of the size of the pull", (float(x.mean()), float(y.mean())), "Right unit?")
    angle = np.radians(finite("platform_angle", platform_angle))
    moving = (0.0, 0.0) if inertia is None else (np.asarray(inertia[0], float), np.asarray(inertia[1], float))
    best = _split(x, y, pull, float(angle), moving)
    generator = np.random.default_rng(seed)
    drawn = []
    for _ in range(draws):
        gain, shift = cell_gain * generator.normal(size=2), zero * generator.normal(size=2)
        drawn.append(_split((1 + gain[0]) * x + shift[0], (1 + gain[1]) * y + shift[1], pull, float(angle), moving))
    spread = {name: np.std([one[i] for one in drawn], axis=0) for i, name in enumerate(MEANINGS)}
    return BladeDamperForces(best[0], best[1], best[2], best[3], spread)


def _split(x: Array, y: Array, pull: float, angle: float, moving: tuple[Array | float, Array | float]) -> tuple[Array, ...]:
    """T and N at the cylinder and at the flat, for the damper at the side whose outward is +x; the roof rises to the ridge on
    either side: outer platform normal (sin, cos) presses down and inwards."""
    c, s = np.cos(angle), np.sin(angle)
    force_x, force_y = -x, -y
    blade_x, blade_y = moving[0] - force_x, moving[1] - force_y - pull
    return (
        np.asarray(-c * force_x + s * force_y),
        np.asarray(-s * force_x - c * force_y),
        np.asarray(c * blade_x + s * blade_y),
        np.asarray(s * blade_x - c * blade_y),
    )


def blade_rig_forces(
    record: Record,
    pull: ArrayLike,
    platform_angle: float = 45.0,
    *,
    frequency: float | None = None,
    harmonics: int = HARMONICS,
    samples: int = 400,
    **errors: Any,
) -> xr.Dataset:
    """Contact forces of both dampers over the mean cycle of a record of their four cells, (damper, sample), each with its
    standard deviation NAME_error, and T/N at cylinder and flat.

    record: with left_outward, left_upward, right_outward, right_upward (`read_record`), outwards away from the blade, zeros
    removed; pull: on each damper [N], a number or (left, right); frequency [Hz]: found in the largest signal unless given;
    errors: cell_gain, zero, draws, seed as of `blade_damper_forces`. Cycles with gaps are left out and drift is stated, as
    warnings in the attributes.
    """
    import xarray as xr

    record.needs(*BLADE_CELLS)
    cycles, pulls = whole_cycles(record, frequency, harmonics), vector("pull", pull, 2)
    found = []
    for side, force in zip(("left", "right"), pulls, strict=True):
        outward, upward = (cycles.cycle(f"{side}_{cell}", samples) for cell in ("outward", "upward"))
        found.append(blade_damper_forces(outward, upward, float(force), platform_angle, **errors))
    variables: dict[str, tuple[tuple[str, str], Any, dict[str, str]]] = {}
    for name, words in MEANINGS.items():
        values, spread = np.stack([getattr(one, name) for one in found]), np.stack([one.errors[name] for one in found])
        variables[name] = (("damper", "sample"), values, {"units": "N", "long_name": words})
        variables[f"{name}_error"] = (("damper", "sample"), spread, {"units": "N", "long_name": f"standard deviation: {words}"})
    for side in ("cylinder", "flat"):
        ratio = np.stack([one.ratio(side) for one in found])
        variables[f"{side}_ratio"] = (("damper", "sample"), ratio, {"units": "1", "long_name": f"T/N at the {side}"})
    attributes = {"title": record.name, "frequency": cycles.frequency, "pull": pulls.tolist(), "warnings": list(cycles.warnings)}
    return xr.Dataset(variables, {"damper": ["left", "right"]}, attributes)
