"""Contact forces of a damper of the blade rig from the two load cells of its separator.

The separator splits the force of the damper's cylinder into one part along each arm, outwards and up; its cells read them. The
flat side carries what is left of the pull: quasi-static, for the inertia of a 50 g damper is small against the forces.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stickslip.checks import Array, fault, finite, positive


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
    names = ("cylinder_tangential", "cylinder_normal", "flat_tangential", "flat_normal")
    spread = {name: np.std([one[i] for one in drawn], axis=0) for i, name in enumerate(names)}
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
