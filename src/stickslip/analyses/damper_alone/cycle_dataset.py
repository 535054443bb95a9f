"""Labelled dataset of a steady damper cycle: forces, motion, states, energies and harmonics."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from stickslip.analyses.time_response import harmonics_of
from stickslip.model.contact.law import Friction, LoadDependentFriction
from stickslip.model.contact.protocol import OPEN, SLIP_DOWN, SLIP_UP, STICK
from stickslip.model.dampers.between_platforms import BetweenPlatforms
from stickslip.results.schema import named
from stickslip.solve.platforms.cycle import CycleModel, Marching, SteadyCycle
from stickslip.solve.platforms.march import Record
from stickslip.support.checks import Array, Index
from stickslip.support.late import xr

HARMONICS = 15
"""Harmonics of the platform forces that are kept."""


Variables = dict[str, tuple[tuple[str, ...], Any, str, str]]
"""Dimensions, values, units and meaning by name."""

EACH, PLACE = ("sample", "contact"), ("sample", "axis")


def cycle_dataset(rig: BetweenPlatforms, model: CycleModel, march: SteadyCycle, marching: Marching, sentence: str) -> xr.Dataset:
    """Everything about the last cycle."""
    variables = _platforms(rig, model, march) | _contact_forces(model, march) | _contact_motions(rig, model, march)
    variables |= _states(model, march) | _energies(model, march) | _section(rig)
    return xr.Dataset(
        {name: named(dims, values, words, units) for name, (dims, values, units, words) in variables.items()},
        coords={
            "contact": named("contact", [point.name for point in rig.points], "line of contact"),
            "side": named("contact", [point.side for point in rig.points], "platform it is on"),
            "axis": named("axis", ["x", "y"], "x to the right, y along the pull"),
            "damper": named("damper", ["x", "y", "rotation"], "motion of the damper"),
            "kind": named("kind", ["stick", "slip", "open"], "state of a contact"),
            "platform": named("platform", ["left", "right"], "platform"),
            "part": named("part", ["re", "im"], "real and imaginary part"),
        },
        attrs={
            "title": rig.title or rig.damper.name,
            "pull": float(np.hypot(*np.asarray(rig.damper.pull)[:2])),
            "method": repr(marching.method) if marching.method else "quasi-static",
            "frequency": marching.frequency,
            "friction": [_constant(getattr(law, "mu", np.nan)) for law in rig.laws],
            "cycles": march.cycles,
            "outcome": march.outcome.name.lower(),
            "message": sentence,
        },
    )


def _constant(mu: Friction) -> float:
    """A coefficient, NaN of one that depends on the load."""
    return np.nan if isinstance(mu, LoadDependentFriction) else float(mu)


def _section(rig: BetweenPlatforms) -> Variables:
    """Where the damper is touched, and its outline, from its mass centre: for drawings."""
    outline = np.reshape(rig.damper.body.outline, (-1, 3))[:, :2]
    place = ("contact", "axis")
    return {
        "outline": (("corner", "axis"), outline, "m", "corners of the section of the damper"),
        "place": (place, [point.arm for point in rig.points], "m", "place of the contact on the damper"),
        "tangent": (place, [point.tangent for point in rig.points], "1", "direction t1"),
        "normal": (place, [point.normal for point in rig.points], "1", "direction n, from the platform into the damper"),
    }


def _platforms(rig: BetweenPlatforms, model: CycleModel, march: SteadyCycle) -> Variables:
    """Motion of platforms and damper, and the forces on the platforms, with their harmonics."""
    steps, motion = march.drive.shape[0], march.record.motion
    right = motion[:, 3:5] if rig.right else np.zeros((steps, 2))
    on_left, on_right = forces_on_platforms(model, march)
    spectrum = harmonics_of(np.stack([on_left.T, on_right.T]), min(HARMONICS, steps // 4))
    parts = np.stack([spectrum.real, spectrum.imag], axis=-1)
    words = "equivalent harmonic forces of the damper on the platforms"
    return {
        "phase": (("sample",), np.arange(steps) / steps, "1", "share of the cycle that has passed"),
        "platform_motion": (PLACE, platform_motion(model, march), "m", "motion of the left platform"),
        "right_motion": (PLACE, right, "m", "motion of the right platform"),
        "force_on_left": (PLACE, on_left, "N", "force of the damper on the left platform"),
        "force_on_right": (PLACE, on_right, "N", "force of the damper on the right platform"),
        "force_harmonics": (("platform", "axis", "harmonic", "part"), parts, "N", words),
        "damper_motion": (("sample", "damper"), motion[:, :3], "m, m, rad", "motion of the damper's mass centre"),
        "rotation": ((), float(np.ptp(motion[:, 2])), "rad", "rotation of the damper, peak to peak"),
    }


def _contact_forces(model: CycleModel, march: SteadyCycle) -> Variables:
    tangential, normal_rows = _rows(model)
    friction, normal = march.record.force[:, tangential], march.record.force[:, normal_rows]
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.where(normal > 0.0, friction / normal, np.nan)
    # The slip limit of a contact is the sum of those of its elements.
    table = model.table
    first, last = table.friction_first[table.first_row[:-1]], table.friction_first[table.first_row[1:]]
    return {
        "friction_force": (EACH, friction, "N", "friction force along t1"),
        "normal_force": (EACH, normal, "N", "normal force"),
        "force_ratio": (EACH, ratio, "1", "friction over normal force"),
        "slip_limit": (
            EACH,
            np.stack([march.record.limit[:, a:b].sum(axis=1) for a, b in zip(first, last, strict=True)], axis=1),
            "N",
            "friction force at which all of the contact slips",
        ),
    }


def _contact_motions(rig: BetweenPlatforms, model: CycleModel, march: SteadyCycle) -> Variables:
    """Motion at every contact, parted into elastic and slip, and the rolling."""
    tangential, normal_rows = _rows(model)
    u, z = march.record.w[:, tangential], march.record.w[:, normal_rows]
    elastic = _sprung(march.record.force[:, tangential], model.stiffness[tangential])
    rolling = march.record.motion[:, 2:3] * np.array([point.radius for point in rig.points])
    words = "tangential motion of the damper at the contact, relative to the platform"
    return {
        "tangential_motion": (EACH, u, "m", words),
        "approach": (EACH, z, "m", "normal motion, positive closing"),
        "elastic_motion": (EACH, elastic, "m", "part of the tangential motion that the contact springs hold"),
        "slip_motion": (EACH, u - elastic, "m", "part of the tangential motion that the sliders have gone"),
        "rolling": (EACH, rolling, "m", "motion of the rounding's axis by rolling"),
    }


def _states(model: CycleModel, march: SteadyCycle) -> Variables:
    states = contact_states(model, march)
    words = "0 stick, 1 slip with positive friction, -1 with negative, 2 open"
    kinds = (states == STICK, np.abs(states) == 1, states == OPEN)
    return {
        "state": (EACH, states, "1", words),
        "share": (
            ("contact", "kind"),
            np.stack([kind.mean(axis=0) for kind in kinds], axis=1),
            "1",
            "share of the cycle in each state",
        ),
        "iterations": (("sample",), march.record.iterations, "1", "Newton iterations of the step, -1 where it failed"),
    }


def _energies(model: CycleModel, march: SteadyCycle) -> Variables:
    """Loop energy ∫ F dx on the platforms: friction work and, where the cycle does not close, what is stored in the end."""
    path, work = march.path(model), slip_work(model, march)
    motion = platform_motion(model, march)
    force = path.force @ model.left
    # by trapezes
    loop = float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(np.append(motion, motion[:1], axis=0), axis=0)))
    stored = float(np.diff(stored_energy(model, path)[[0, -1]])[0])
    error, words = abs(loop - work.sum() - stored), "loop energy less friction work and stored energy, relative"
    return {
        "friction_work": (("contact",), work, "J", "friction work of a cycle"),
        "loop_energy": ((), loop, "J", "energy that the damper takes from the platforms in a cycle"),
        "stored_energy": ((), stored, "J", "energy that contacts, rig and pull hold after the cycle less that before it"),
        "energy_error": ((), error / abs(loop) if loop else error, "1", words),
    }


def _rows(model: CycleModel) -> tuple[Index, Index]:
    """Tangential and normal rows, one of each a contact."""
    normal = model.table.normal_row
    return np.setdiff1d(np.arange(model.B.shape[0]), normal), normal


def platform_motion(model: CycleModel, march: SteadyCycle) -> Array:
    """x and y of the left platform, (steps, 2) [m]."""
    return np.asarray(march.drive @ np.linalg.pinv(model.left.T))


def forces_on_platforms(model: CycleModel, march: SteadyCycle) -> tuple[Array, Array]:
    """x and y of the damper's force on the left and on the right platform, (steps, 2) each [N]."""
    return -march.record.force @ model.left, -march.record.force @ model.right


def slip_work(model: CycleModel, march: SteadyCycle) -> Array:
    """Friction work of each contact over the cycle, Σ T δ(slip) over its elements and Σ T δu of what no spring carries, both
    trapezoidal, (contacts,) [J]."""
    path, table, rows = march.path(model), model.table, _rows(model)[0]
    traction = _tractions(model, path)
    slid = _sprung(-np.diff(path.intercept, axis=0), table.stiffness)
    work = np.sum(0.5 * (traction[1:] + traction[:-1]) * slid, axis=0)
    elements = _elements(model)
    direct = path.force[:, rows] - np.stack([traction[:, own].sum(axis=1) for own in elements], axis=1)
    further = np.sum(0.5 * (direct[1:] + direct[:-1]) * np.diff(path.w[:, rows], axis=0), axis=0)
    return np.asarray(further + np.array([work[own].sum() for own in elements]))


def stored_energy(model: CycleModel, path: Record) -> Array:
    """½ Σ T²/kt + ½ Σ N²/kn over the elements, ½ qᵀKq of the platform's rig, less the work of the pull, (samples,) [J]."""
    table, size = model.table, np.ones(model.load.size)
    size[2] = model.length
    motion = path.motion * size
    press = np.repeat(path.w[:, table.normal_row], np.diff(table.normal_first), axis=1)
    normal = np.maximum(table.normal_stiffness * press + table.normal_constant, 0.0)
    elastic = _sprung(_tractions(model, path) ** 2, table.stiffness).sum(axis=1)
    elastic = elastic + (normal**2 / table.normal_stiffness).sum(axis=1)
    return np.asarray(0.5 * (elastic + np.sum(motion @ model.matrices[2] * motion, axis=1)) - motion @ model.load)


def contact_states(model: CycleModel, march: SteadyCycle) -> Index:
    """What each contact does at each sample, (steps, contacts): open where no element carries load, slip where one slides; at
    sample 0 in the step that ends the cycle."""
    path, table = march.path(model), model.table
    force, slid = path.force[1:], -np.diff(path.intercept, axis=0)
    found = np.full((slid.shape[0], table.normal_row.size), STICK)
    for c, (normal, elements) in enumerate(zip(table.normal_row, _elements(model), strict=True)):
        moved = np.any((slid[:, elements] != 0.0) | (table.stiffness[elements] == 0.0), axis=1)
        row = next(row for row in range(table.first_row[c], table.first_row[c + 1]) if row != normal)
        found[moved, c] = np.where(force[moved, row] >= 0.0, SLIP_UP, SLIP_DOWN)
        found[force[:, normal] <= 0.0, c] = OPEN
    return np.roll(found, 1, axis=0)


def _sprung(values: Array, stiffness: Array) -> Array:
    """values/kt, and 0 without a spring, (samples, elements)."""
    return np.divide(values, stiffness, out=np.zeros_like(values), where=stiffness > 0.0)


def _tractions(model: CycleModel, path: Record) -> Array:
    """Force of the spring of each friction element, 0 without one, (samples, elements) [N]."""
    table = model.table
    stretched = table.stiffness * np.repeat(path.w, np.diff(table.friction_first), axis=1)
    return np.where(table.stiffness > 0.0, path.intercept + stretched, 0.0)


def _elements(model: CycleModel) -> list[slice]:
    """The friction elements of each contact."""
    table = model.table
    return [slice(table.friction_first[a], table.friction_first[b]) for a, b in pairwise(table.first_row)]
