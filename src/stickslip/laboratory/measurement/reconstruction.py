"""Quantities that a damper rig does not measure: left contact forces, their points of action, slip and T/N, with errors.

Inertia is neglected (0.001 to 0.01 N at 5 Hz), so that the forces of both platforms and the pull balance and meet in a point.
Rolling moves the place of the right contact by radius × rotation, micrometres against millimetres, which moments do not feel.
Source of the motion at the right contact, "pure rolling" dr and "pure translation" ds: Gola and Gastaldi, ASME GT2014-25240.

Measurement errors of a damper rig, for reconstruction and fits.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

import numpy as np

from stickslip.laboratory.measurement.cycles import CALIBRATION, CycleSet, synthesis
from stickslip.model.dampers.between_platforms import BetweenPlatforms
from stickslip.results.schema import named
from stickslip.support.checks import Array, not_negative, positive
from stickslip.support.late import xr

SIGNALS = ("force_x", "force_y", "rotation", "damper_y")
"""The channels that a damper answers with."""


@dataclass(frozen=True)
class RigErrors:
    """Standard deviations. Of each cell: gain, shape (linearity, greatest deviation) [N], zero after load removal [N], noise of
    a sample [N]; of lasers: noise of a sample [m]; of rotation and damper motion: gain (from distances on photographs); of
    the lag of all forces behind all motions [s]; of the calibration factor at load removal (3 to 5 %), which gives the error of
    a zero that is found so.

    Defaults follow Gola and Gastaldi (ASME GT2014-25240): cell 1 %, linearity 2 % (1 N, here a bound of two deviations),
    calibration at load removal 0.7 to 0.9 N, laser 0.08 µm, rotation and contact motion 5 %. The noise of a force sample is
    this project's. `lag` None: looked for, and fitted where it is more than gradual slip looks like; 0: forces and motions are
    synchronous; else always fitted. `zero_x`, `zero_y`: of the cells of
    force_x and force_y, where they differ from `zero`; for a cell whose zero is not known give as much as it may be off.
    """

    cell_gain: float = 0.01
    linearity: float = 0.5
    zero: float = 0.8
    force_noise: float = 0.05
    laser_noise: float = 0.08e-6
    motion_gain: float = 0.05
    zero_x: float | None = None
    zero_y: float | None = None
    lag: float | None = None
    calibration: float = CALIBRATION

    def __post_init__(self) -> None:
        for field in fields(self):
            if getattr(self, field.name) is not None:
                not_negative(field.name, getattr(self, field.name))

    def zero_of(self, channel: str) -> float:
        """Standard deviation of the zero of a cell, N."""
        own = {"force_x": self.zero_x, "force_y": self.zero_y}[channel]
        return self.zero if own is None else own

    def with_zeros(self, zeros: Mapping[str, float]) -> "RigErrors":
        """A copy with the standard deviations [N] of the zeros of some cells, by channel, as load removal gives them."""
        return replace(self, **{f"zero_{channel[-1]}": error for channel, error in zeros.items()})

    def gain(self, channel: str) -> float:
        """Standard deviation of the gain of a channel."""
        return self.cell_gain if channel.startswith("force") else self.motion_gain

    def draw(self, generator: np.random.Generator) -> dict[str, tuple[float, float, float]]:
        """One draw of the systematic errors: {channel: (gain error, linearity [N], zero [N])}."""
        drawn = {}
        for channel in SIGNALS:
            gain, shape, zero = generator.normal(size=3)
            drawn[channel] = gain * self.motion_gain, 0.0, 0.0
            if channel.startswith("force"):
                drawn[channel] = gain * self.cell_gain, shape * self.linearity, zero * self.zero_of(channel)
        return drawn


def distorted(values: Array, systematic: tuple[float, float, float]) -> Array:
    """What a channel shows instead of `values` (n,): (1 + gain) values + linearity × bow + zero, the bow being 0 at both ends
    of the range and 1 in its middle."""
    gain, linearity, zero = systematic
    middle, half = 0.5 * (values.max() + values.min()), max(0.5 * float(np.ptp(values)), 1e-300)
    return np.asarray((1.0 + gain) * values + linearity * (1.0 - ((values - middle) / half) ** 2) + zero)


UNITS = {
    "left_tangential": ("N", "tangential force on the damper at the left, up the platform"),
    "left_normal": ("N", "normal force on the damper at the left, positive pressing"),
    "right_tangential": ("N", "tangential force on the damper at the right, along t1"),
    "right_normal": ("N", "normal force on the damper at the right, positive pressing"),
    "left_ratio": ("1", "T/N at the left"),
    "right_ratio": ("1", "T/N at the right"),
    "left_place": ("m", "point of application at the left, from the middle of the feet towards the upper one"),
    "right_rolling": ("m", "rolling of the right cylinder, dr: how far its axis goes along t1 without slip, less its mean"),
    "right_translation": ("m", "translation of the right cylinder, ds: motion of its axis along t1, less its mean"),
    "right_slip": ("m", "motion of the damper's surface at the right contact along t1, ds - dr, less its mean"),
}


def damper_motion(cycles: CycleSet, distance: float, offset: float = 0.0) -> CycleSet:
    """Rotation and damper_y from two lasers along the pull: β = (laser_2 − laser_1)/distance, y at the mass centre.

    distance [m] from laser 1 to laser 2 along x; offset [m] of the mass centre from laser 1.
    """
    positive("distance", abs(distance))
    first, second = (cycles.harmonics[:, cycles.index(name)] for name in ("laser_1", "laser_2"))
    rotation = (second - first) / distance
    return cycles.with_channels({"rotation": rotation, "damper_y": first + offset * rotation})


@dataclass(frozen=True, eq=False)
class Geometry:
    """Of a damper between platforms: at the left the tangent from the first foot to the last, the normal into the damper and the
    middle of the feet; at the right tangent, normal and arm, NaN with several lines, since forces do not determine where theirs
    acts."""

    left_tangent: Array
    left_normal: Array
    middle: Array
    right_tangent: Array
    right_normal: Array
    right_arm: Array
    right_radius: float

    @classmethod
    def of(cls, rig: BetweenPlatforms) -> "Geometry":
        left, right = [p for p in rig.points if p.side == "left"], [p for p in rig.points if p.side == "right"]
        arms = np.array([p.arm for p in left])
        feet = arms[-1] - arms[0]
        tangent = feet / np.hypot(*feet) if len(left) > 1 else -np.array(left[0].tangent)
        one = right[0]
        arm = one.arm if len(right) == 1 else (np.nan, np.nan)
        values = (tangent, left[0].normal, arms.mean(axis=0), one.tangent, one.normal, arm)
        t, n, middle, right_t, right_n, place = (np.asarray(value, dtype=float) for value in values)
        return cls(t, n, middle, right_t, right_n, place, one.radius)


def reconstructed(rig: BetweenPlatforms, signals: dict[str, Array], pull: float, kn: float | None = None) -> dict[str, Array]:
    """The quantities of `UNITS` (n,) from force_x, force_y and, for the motion at the right, rotation and damper_y.

    The right platform pushes the damper by −(H, V), the left one by (H, V − F_C): forces balance. The left force acts where
    moments about the mass centre balance. Ratios and place are NaN where nothing presses, the place also where several lines
    at the right leave it open.
    """
    g = Geometry.of(rig)
    right = -np.stack([signals["force_x"], signals["force_y"]], axis=1)
    left = -right - np.array([0.0, pull])
    values = {
        "left_tangential": left @ g.left_tangent,
        "left_normal": left @ g.left_normal,
        "right_tangential": right @ g.right_tangent,
        "right_normal": right @ g.right_normal,
    }
    moment = g.right_arm[0] * right[:, 1] - g.right_arm[1] * right[:, 0] + g.middle[0] * left[:, 1] - g.middle[1] * left[:, 0]
    turning = g.left_tangent[0] * left[:, 1] - g.left_tangent[1] * left[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        pressed_left, pressed_right = values["left_normal"] > 0.0, values["right_normal"] > 0.0
        values["left_ratio"] = np.where(pressed_left, values["left_tangential"] / values["left_normal"], np.nan)
        values["right_ratio"] = np.where(pressed_right, values["right_tangential"] / values["right_normal"], np.nan)
        values["left_place"] = np.where(pressed_left, -moment / turning, np.nan)
    if "rotation" in signals and "damper_y" in signals and np.all(np.isfinite(g.right_arm)):
        approach = np.zeros_like(turning) if kn is None else values["right_normal"] / positive("kn", kn)
        values |= right_motion(g, signals["rotation"], signals["damper_y"], approach)
    return values


def right_motion(g: "Geometry", rotation: Array, damper_y: Array, approach: Array | float = 0.0) -> dict[str, Array]:
    """Rolling dr, translation ds and slip ds − dr of the cylinder on the right platform (n,) [m], each less its mean.

    n points into the damper. The axis O of the cylinder, at the contact plus radius × n, rises by w = y + β Ox. It moves by ds
    along t1 and by the `approach` of the contact (n,) against n, so that ds = (w + approach ny)/ty. It would roll by
    dr = ±radius × β without slip. The approach, N/kn, is below a micrometre and neglected by the source.
    """
    normal, tangent = g.right_normal, g.right_tangent
    axis = g.right_arm + g.right_radius * normal
    turned = float(normal[0] * tangent[1] - normal[1] * tangent[0])
    rolling = turned * g.right_radius * rotation
    translation = (damper_y + axis[0] * rotation + approach * normal[1]) / tangent[1]
    found = {"right_rolling": rolling, "right_translation": translation, "right_slip": translation - rolling}
    return {name: values - values.mean() for name, values in found.items()}


def reconstruct(
    cycles: CycleSet,
    rig: BetweenPlatforms,
    errors: "RigErrors | None" = None,
    *,
    pull: float | None = None,
    kn: float | None = None,
    samples: int = 500,
    draws: int = 200,
    seed: int = 0,
) -> "xr.Dataset":
    """The mean cycle of the quantities of `UNITS`, each with the standard deviation NAME_error from `draws` samples of the
    rig's systematic errors and of the cycles. Dimension `sample`, (samples,). Motion at the right needs rotation and damper_y
    and a single line of contact there; kn [N/m] of that line, where known, takes its normal deformation into account."""
    generator = np.random.default_rng(seed)
    errors = (RigErrors() if errors is None else errors).with_zeros(cycles.zero_errors)
    force = cycles.pull if pull is None else pull
    load = float(rig.pull[1]) if force is None else force
    table = synthesis(samples, (cycles.harmonics.shape[2] - 1) // 2)
    best = reconstructed(rig, _signals(cycles, table, None), load, kn)
    drawn = [
        reconstructed(rig, _signals(cycles.resampled(generator), table, errors.draw(generator)), load, kn) for _ in range(draws)
    ]
    variables = {}
    for name, values in best.items():
        units, words = UNITS[name]
        variables[name] = named("sample", values, words, units)
        spread = np.std([one[name] for one in drawn], axis=0)
        variables[f"{name}_error"] = named("sample", spread, f"standard deviation: {words}", units)
    return xr.Dataset(variables, attrs={"title": cycles.name, "warnings": list(cycles.warnings), "pull": load})


def _signals(cycles: CycleSet, table: Array, drawn: dict[str, tuple[float, float, float]] | None) -> dict[str, Array]:
    """Channels over the mean cycle, distorted by a draw of systematic errors."""
    found = {name: table @ values for name, values in zip(cycles.channels, cycles.mean, strict=True)}
    if drawn is None:
        return found
    return {name: distorted(values, drawn[name]) if name in SIGNALS else values for name, values in found.items()}
