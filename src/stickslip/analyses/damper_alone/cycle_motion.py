"""A steady damper cycle as it is drawn: the section of the damper, both platforms, contact points and loops, from its dataset."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.analyses.motion import (
    OVERLAP,
    BodyMotion,
    FaceMotion,
    LoopMotion,
    PeriodOfMotion,
    PointMotion,
    frames_of,
    point_states,
)
from stickslip.support.checks import Array, Index

if TYPE_CHECKING:
    import xarray as xr


def cycle_motion(dataset: xr.Dataset) -> PeriodOfMotion:
    """The motion of the last cycle."""
    loops = tuple(
        LoopMotion(
            str(name),
            dataset["tangential_motion"].values[:, k],
            dataset["friction_force"].values[:, k],
            point_states(dataset["state"].values[None, :, k]),
        )
        for k, name in enumerate(dataset["contact"].values)
    )
    title = str(dataset.attrs["title"])
    if not dataset.sizes.get("corner"):
        return PeriodOfMotion(title, loops)
    frames = frames_of(dataset.sizes["sample"])
    motion = _about_mean(dataset["damper_motion"].values)[frames]
    body = BodyMotion("damper", dataset["outline"].values, np.zeros(2), motion)
    points = tuple(_point(dataset, k, motion, frames) for k in range(len(loops)))
    return PeriodOfMotion(title, loops, (body,), tuple(_face(dataset, side, frames) for side in ("left", "right")), points)


def _about_mean(values: Array) -> Array:
    return np.asarray(values - values.mean(axis=0))


def _point(dataset: xr.Dataset, k: int, motion: Array, frames: Index) -> PointMotion:
    """A line of contact. Its friction and normal force act on the damper along t1 and n, since w = platform − damper."""
    place = dataset["place"].values[k]
    x, y = place
    moved = motion[:, :2] + motion[:, 2:] * np.array([-y, x])
    along = np.stack([dataset[name].values[k] for name in ("tangent", "normal")])
    forces = np.stack([dataset[name].values[frames, k] for name in ("friction_force", "normal_force")], axis=1)
    states = point_states(dataset["state"].values[None, frames, k])
    return PointMotion(str(dataset["contact"].values[k]), place, moved, states, forces @ along)


def _face(dataset: xr.Dataset, side: str, frames: Index) -> FaceMotion:
    """The face of one platform, which shifts without turning."""
    own = np.flatnonzero(dataset["side"].values == side)
    places = dataset["place"].values[own]
    tangent, into = dataset["tangent"].values[own[0]], -dataset["normal"].values[own[0]]
    reach = OVERLAP * float(np.ptp(dataset["outline"].values, axis=0).max())
    s = places @ tangent
    ends = (places @ into).mean() * into + np.array([s.min() - reach, s.max() + reach])[:, None] * tangent
    moved = _about_mean(dataset["platform_motion" if side == "left" else "right_motion"].values)[frames]
    return FaceMotion(ends, into, np.repeat(moved[:, None], 2, axis=1))
