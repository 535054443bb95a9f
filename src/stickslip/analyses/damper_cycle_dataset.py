"""A damper cycle with labels: forces, motion and its parts, states, energies and harmonics of one steady cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.analyses.time_response import harmonics_of
from stickslip.checks import Array, Index
from stickslip.contact.period import OPEN, SLIP_DOWN, SLIP_UP, STICK
from stickslip.dampers.between_platforms import BetweenPlatforms
from stickslip.solve.platform_cycle import CycleModel, Marching, SteadyCycle

if TYPE_CHECKING:
    import xarray as xr

HARMONICS = 15
"""Harmonics of the platform forces that are kept."""


def cycle_dataset(rig: BetweenPlatforms, model: CycleModel, march: SteadyCycle, marching: Marching, sentence: str) -> xr.Dataset:
    """Everything about the last cycle."""
    import xarray as xr

    record, steps = march.record, march.drive.shape[0]
    platform = march.drive @ np.linalg.pinv(model.left.T)
    tangential = np.setdiff1d(np.arange(record.w.shape[1]), model.table.normal_row)
    u, z = record.w[:, tangential], record.w[:, model.table.normal_row]
    friction, normal = record.force[:, tangential], record.force[:, model.table.normal_row]
    on_left, on_right = -record.force @ model.left, -record.force @ model.right
    work, loop = slip_work(model, march), float(-_loop(on_left, platform).sum())
    states = contact_states(model, march)
    radius = np.array([point.radius for point in rig.points])
    elastic = friction / model.stiffness[tangential]
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.where(normal > 0.0, friction / normal, np.nan)
    each, place = ("sample", "contact"), ("sample", "axis")
    spectrum = harmonics_of(np.stack([on_left.T, on_right.T]), min(HARMONICS, steps // 4))
    variables: dict[str, tuple[tuple[str, ...], Any, str, str]] = {
        "phase": (("sample",), np.arange(steps) / steps, "1", "share of the cycle that has passed"),
        "platform_motion": (place, platform, "m", "motion of the left platform"),
        "right_motion": (
            place,
            record.motion[:, 3:5] if rig.right else np.zeros((steps, 2)),
            "m",
            "motion of the right platform",
        ),
        "force_on_left": (place, on_left, "N", "force of the damper on the left platform"),
        "force_on_right": (place, on_right, "N", "force of the damper on the right platform"),
        "damper_motion": (("sample", "damper"), record.motion[:, :3], "m, m, rad", "motion of the damper's mass centre"),
        "friction_force": (each, friction, "N", "friction force along t1"),
        "normal_force": (each, normal, "N", "normal force"),
        "force_ratio": (each, ratio, "1", "friction over normal force"),
        "tangential_motion": (each, u, "m", "tangential motion of the damper at the contact, relative to the platform"),
        "approach": (each, z, "m", "normal motion, positive closing"),
        "elastic_motion": (each, elastic, "m", "part of the tangential motion that the contact springs hold"),
        "slip_motion": (each, u - elastic, "m", "part of the tangential motion that the sliders have gone"),
        "rolling": (each, record.motion[:, 2:3] * radius, "m", "motion of the rounding's axis by rolling"),
        "slip_limit": (each, _limits(model, march), "N", "friction force at which all of the contact slips"),
        "state": (each, states, "1", "0 stick, 1 slip with positive friction, -1 with negative, 2 open"),
        "share": (("contact", "kind"), _shares(states), "1", "share of the cycle in each state"),
        "friction_work": (("contact",), work, "J", "friction work of a cycle"),
        "loop_energy": ((), loop, "J", "energy that the damper takes from the platforms in a cycle"),
        "energy_error": ((), _relative(loop - work.sum(), loop), "1", "loop energy less friction work, relative"),
        "rotation": ((), float(np.ptp(record.motion[:, 2])), "rad", "rotation of the damper, peak to peak"),
        "force_harmonics": (
            ("platform", "axis", "harmonic", "part"),
            np.stack([spectrum.real, spectrum.imag], axis=-1),
            "N",
            "equivalent harmonic forces of the damper on the platforms",
        ),
        "iterations": (("sample",), record.iterations, "1", "Newton iterations of the step, -1 where it failed"),
    }
    coordinates: dict[str, tuple[str, list[str], str]] = {
        "contact": ("contact", [point.name for point in rig.points], "line of contact"),
        "side": ("contact", [point.side for point in rig.points], "platform it is on"),
        "axis": ("axis", ["x", "y"], "x to the right, y along the pull"),
        "damper": ("damper", ["x", "y", "rotation"], "motion of the damper"),
        "kind": ("kind", ["stick", "slip", "open"], "state of a contact"),
        "platform": ("platform", ["left", "right"], "platform"),
        "part": ("part", ["re", "im"], "real and imaginary part"),
    }
    return xr.Dataset(
        {name: (dims, values, {"units": units, "long_name": words}) for name, (dims, values, units, words) in variables.items()},
        coords={name: (dim, values, {"units": "1", "long_name": words}) for name, (dim, values, words) in coordinates.items()},
        attrs={
            "title": rig.title or rig.damper.name,
            "pull": float(np.hypot(*np.asarray(rig.damper.pull)[:2])),
            "method": repr(marching.method) if marching.method else "quasi-static",
            "frequency": marching.frequency,
            "friction": [float(getattr(law, "mu", np.nan)) for law in rig.laws],
            "cycles": march.cycles,
            "outcome": march.outcome.name.lower(),
            "message": sentence,
        },
    )


def slip_work(model: CycleModel, march: SteadyCycle) -> Array:
    """Friction work of each contact over the cycle, Σ T δ(slip) over its elements, trapezoidal, (contacts,) [J]."""
    table, record = model.table, march.record
    found = np.zeros(table.normal_row.size)
    for c, normal in enumerate(table.normal_row):
        for row in range(table.first_row[c], table.first_row[c + 1]):
            for e in range(table.friction_first[row], table.friction_first[row + 1]) if row != normal else ():
                y = record.intercept[:, e]
                traction = y + table.stiffness[e] * record.w[:, row]
                slid = (np.roll(y, 1) - y) / table.stiffness[e]
                found[c] += float(np.sum(0.5 * (traction + np.roll(traction, 1)) * slid))
    return found


def contact_states(model: CycleModel, march: SteadyCycle) -> Index:
    """What each contact does at each sample, (steps, contacts): open where no element carries load, slip where one slides."""
    table, record = model.table, march.record
    found = np.full((record.w.shape[0], table.normal_row.size), STICK)
    slid = np.roll(record.intercept, 1, axis=0) - record.intercept
    for c, normal in enumerate(table.normal_row):
        rows = [row for row in range(table.first_row[c], table.first_row[c + 1]) if row != normal]
        elements = np.concatenate([np.arange(table.friction_first[r], table.friction_first[r + 1]) for r in rows])
        moved = np.any(slid[:, elements] != 0.0, axis=1)
        sense = np.sign(record.force[:, rows[0]])
        found[moved, c] = np.where(sense[moved] >= 0.0, SLIP_UP, SLIP_DOWN)
        found[record.force[:, normal] <= 0.0, c] = OPEN
    return found


def _limits(model: CycleModel, march: SteadyCycle) -> Array:
    """Sum of the slip limits of each contact's elements, (steps, contacts)."""
    table = model.table
    first, last = table.friction_first[table.first_row[:-1]], table.friction_first[table.first_row[1:]]
    return np.stack([march.record.limit[:, a:b].sum(axis=1) for a, b in zip(first, last, strict=True)], axis=1)


def _shares(states: Index) -> Array:
    kinds = (states == STICK, np.abs(states) == 1, states == OPEN)
    return np.stack([kind.mean(axis=0) for kind in kinds], axis=1)


def _loop(force: Array, motion: Array) -> Array:
    """∮ F dx of each column, trapezoidal."""
    return np.asarray(np.sum(0.5 * (force + np.roll(force, 1, axis=0)) * (motion - np.roll(motion, 1, axis=0)), axis=0))


def _relative(difference: float, size: float) -> float:
    return abs(difference) / abs(size) if size else abs(difference)
