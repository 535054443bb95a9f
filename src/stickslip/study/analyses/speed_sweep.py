"""Speed sweep in a study: the table [speed_sweep], engine orders over a range of rotor speeds."""

from collections.abc import Mapping
from dataclasses import replace
from math import pi
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.analyses.speed.models import at_reference_speed, waves_at
from stickslip.analyses.speed.speed_sweep import SpeedSweepSettings, SpeedSweepWork, samples_for
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.problem import Problem
from stickslip.model.problem.speed import CentrifugalLoad
from stickslip.model.readers.read import read_content
from stickslip.model.readers.sector import LOWEST, SHARED
from stickslip.model.structure.cyclic import CyclicStructure
from stickslip.model.structure.modes import natural_modes
from stickslip.study.analyses.forced_response import sweep_of
from stickslip.study.analysis import Asked, Kind, Works, summary_of
from stickslip.study.fields import STIFFNESS, Table
from stickslip.study.tables import OverSpeedTable
from stickslip.support.checks import Array, InputError, counted, fault
from stickslip.support.units import Band


class SpeedSweepTable(OverSpeedTable):
    """Engine orders EO excite with ω = EO Ω; stiffness and static forces go with the square of the rotor speed Ω."""

    key = "speed_sweep"


def band_of(orders: list[int], low: float, high: float) -> Band:
    """The frequencies of the excitation between two speeds, Hz."""
    return Band(min(orders) * low / 60.0, max(orders) * high / 60.0)


def plan(asked: Asked) -> Works:
    """A curve for each engine order and force level."""
    sweep, table = sweep_of(asked), SpeedSweepTable.model_validate(asked.tables["speed_sweep"])
    problem, reference = problem_over_speed(asked, table)
    low, high = table.speed

    def work() -> SpeedSweepWork:
        return SpeedSweepWork.of(SpeedSweepSettings(problem, (low, high), table.engine_orders, **sweep.fineness))

    about = summary_of(replace(sweep, samples=samples_for(problem, table.engine_orders, sweep.samples)))
    summary = f"{about}; {counted(len(table.engine_orders), 'engine order')} from {low:g} to {high:g} rev/min"
    return Works(work, summary, content=problem.fingerprint, condition=f"at {reference:g} rev/min")


def reference_of(asked: Asked, table: OverSpeedTable) -> float | None:
    """Speed in rev/min at which structure and static forces hold: as given, or that of the rotation or the sector; None where
    nothing says it."""
    given = (table.reference_speed, asked.document.get("rotation", {}).get("speed"), next(iter(asked.disks), None))
    return next((float(speed) for speed in given if speed), None)


def problem_over_speed(asked: Asked, table: OverSpeedTable) -> tuple[Problem, float]:
    """The problem of a study with what goes with its rotor speed, and the speed in rev/min at which its structure is given."""
    problem, reference = sweep_of(asked).problem, reference_of(asked, table)
    if reference is None:
        remedy = "Write the speed in rev/min at which [structure] and the static forces hold."
        raise InputError(f"[{table.key}]: reference_speed must be given, but is missing. {remedy}")
    at_rest = stiffness_at_rest(asked, table, problem, reference)
    try:
        return at_reference_speed(problem, 2.0 * pi * reference / 60.0, at_rest), reference
    except InputError as error:
        raise InputError(f"[{table.key}]: at rest: {error}") from None


def stiffness_at_rest(asked: Asked, table: OverSpeedTable, problem: Problem, reference: float) -> Array | None:
    """K at rest in SI, (n, n); None where it is the same at all speeds."""
    given, structure, key = table.stiffness_at_rest, problem.structure, f"[{table.key}]: stiffness_at_rest"
    if asked.disks:
        return _disk_at_rest(asked.disks)
    if isinstance(structure, CyclicStructure) and any(isinstance(force, CentrifugalLoad) for force in problem.forces):
        remedy = "Write at_speeds in [structure.sector], with the model of the sector at rest or at another speed."
        raise fault("[rotation]", "must have K at two speeds for a sector over the speed", "at one speed only", remedy)
    if given is None:
        follows = structure.softening
        return None if follows is None else structure.K + (2.0 * pi * reference / 60.0) ** 2 * follows
    if isinstance(problem, TunedDisk):
        raise fault(key, "must go with matrices", "a ready disk", "Use ss.speed_sweep in Python.")
    if asked.rig[0]:
        raise fault(key, "must go with matrices", f"rig {asked.rig[0]!r}, which brings its own")
    K = _read(asked.folder / given, key) if isinstance(given, str) else np.array(given, dtype=float)
    size = structure.size
    if K.shape != (size, size):
        raise fault(key, f"must have the shape of K, {(size, size)}", K.shape)
    rotations = [dof for dof in structure.dofs if dof.rpartition(".")[2].startswith("r")]
    if rotations and asked.units.system.length != "m":
        raise InputError(
            f"{key} must be of displacements alone where lengths are not in m, but the structure has "
            f"the rotation {rotations[0]!r}. Write the study in m, or use ss.speed_sweep in Python."
        )
    return np.asarray(K * asked.units.factor(STIFFNESS))


def _disk_at_rest(disks: Mapping[float, CyclicStructure]) -> Array | None:
    """K(Ω) = K_r + (Ω² − Ω_r²) K₁ of every nodal diameter at rest, K_r that at the reference speed, K₁ by least squares."""
    own, *others = disks
    K = {speed: np.asarray(disk.stiffnesses) for speed, disk in disks.items()}
    if not others:
        return None
    steps = np.array([speed**2 - own**2 for speed in others])
    changes = np.array([K[speed] - K[own] for speed in others])
    rate = np.tensordot(steps, changes, axes=1) / (steps @ steps)
    return np.asarray(K[own] - own**2 * rate)


def straight_notes(asked: Asked) -> list[str]:
    """What K of a sector that goes straight with Ω² adds to frequencies within a sweep: K of the models turns with the blades."""
    table: Any = asked.tables.get(TABLE, asked.tables.get("run_up"))
    at_rest = None if table is None or not asked.disks else _disk_at_rest(asked.disks)
    if at_rest is None:
        return []
    own, disk = next(iter(asked.disks.items()))
    assert disk.masses is not None
    assert disk.stiffnesses is not None
    raised = {}
    for speed in np.clip(np.linspace(table.speed[0], table.speed[1], 3), min(asked.disks), max(asked.disks)).tolist():
        straight = at_rest[0] + (speed / own) ** 2 * (disk.stiffnesses[0] - at_rest[0])
        high, right = (natural_modes(disk.masses[0], K).frequencies for K in (straight, waves_at(asked.disks, speed)[0]))
        lowest = np.flatnonzero(right > 0.0)[:LOWEST]
        raised[speed] = float(np.max(high[lowest] / right[lowest] - 1.0))
    most = max(raised, key=raised.__getitem__)
    if raised[most] <= SHARED:
        return []
    return [
        f"Warning: K goes straight with the square of the speed, and blades turn under the load: at {most:.5g} rev/min the "
        f"{LOWEST} lowest frequencies at nodal diameter 0 are up to {100.0 * raised[most]:.2g} % too high. Give models nearer to "
        "the speeds of the sweep, or ask for a Campbell diagram, whose K turns"
    ]


def _read(path: Path, key: str) -> Array:
    matrices = read_content(path, {})[0].matrices
    found = matrices.get("K", next(iter(matrices.values())) if len(matrices) == 1 else None)
    if found is None:
        raise fault(key, "must be a file with a matrix K", f"{path.name} with {', '.join(matrices)}")
    dense = found.toarray() if hasattr(found, "toarray") else found
    return np.asarray(dense, dtype=float)


TABLE = SpeedSweepTable.key


def band(tables: Mapping[str, Table]) -> Band | None:
    """The band of a study whose only table of its own is over the speed; None where that is missing or faulty."""
    table = next(iter(tables.values()), None)
    return band_of(table.engine_orders, min(table.speed), max(table.speed)) if isinstance(table, OverSpeedTable) else None


KIND = Kind(plan, {TABLE: SpeedSweepTable}, band=band, without=("quantity", "measure"))
