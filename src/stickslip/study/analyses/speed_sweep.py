"""Speed sweep in a study: the table [speed_sweep], engine orders over a range of rotor speeds."""

from collections.abc import Mapping
from dataclasses import replace
from math import pi
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field, Tag

from stickslip.analyses.speed.campbell import at_reference_speed
from stickslip.analyses.speed.speed_sweep import SpeedSweepSettings, SpeedSweepWork, samples_for
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.problem import Problem
from stickslip.model.problem.centrifugal_load import CentrifugalLoad
from stickslip.model.readers.read import read_content
from stickslip.model.structure.cyclic import CyclicStructure
from stickslip.study.analyses.forced_response import sweep_of
from stickslip.study.analysis import Asked, Kind, Works, summary_of
from stickslip.study.fields import STIFFNESS, Number, Positive, Table, by_form
from stickslip.support.checks import Array, InputError, counted, fault, positive, unique
from stickslip.support.units import Band

Order = Annotated[int, Field(ge=1, le=10_000)]


class SpeedSweepTable(Table):
    """Engine orders EO excite with ω = EO Ω; stiffness and static forces go with the square of the rotor speed Ω."""

    speed: Annotated[list[Positive], Field(min_length=2, max_length=2, description="[first, last] rotor speed, rev/min")]
    engine_orders: Annotated[list[Order], Field(min_length=1, description="EO, one curve each")]
    reference_speed: Positive
    """speed at which [structure] and the static forces hold, rev/min; static forces go with Ω²"""
    stiffness_at_rest: (
        Annotated[Annotated[str, Tag("<single>")] | Annotated[list[list[Number]], Tag("<list>")], by_form()] | None
    ) = None
    """K at speed 0, in the order of `dofs`, or a file .npz or .mat; default: K without spin softening that [rotation] adds"""


def checked(table: SpeedSweepTable) -> None:
    """What the model of the table cannot check."""
    if table.speed[0] == table.speed[1]:
        raise fault("speed", "must have two different ends", table.speed)
    unique("engine_orders", table.engine_orders)


def band_of(table: SpeedSweepTable) -> Band:
    """The frequencies of the excitation, Hz."""
    low, high = min(table.speed), max(table.speed)
    return Band(min(table.engine_orders) * low / 60.0, max(table.engine_orders) * high / 60.0)


def plan(asked: Asked) -> Works:
    """A curve for each engine order and force level."""
    sweep, table = sweep_of(asked), SpeedSweepTable.model_validate(asked.tables["speed_sweep"])
    positive("[speed_sweep]: reference_speed", table.reference_speed)
    at_rest = _stiffness_at_rest(table, sweep.problem, asked)
    problem = at_reference_speed(sweep.problem, 2.0 * pi * table.reference_speed / 60.0, at_rest)
    low, high = table.speed

    def work() -> SpeedSweepWork:
        return SpeedSweepWork.of(SpeedSweepSettings(problem, (low, high), table.engine_orders, **sweep.fineness))

    about = summary_of(replace(sweep, samples=samples_for(problem, table.engine_orders, sweep.samples)))
    summary = f"{about}; {counted(len(table.engine_orders), 'engine order')} from {low:g} to {high:g} rev/min"
    return Works(work, summary, content=problem.fingerprint, condition=f"at {table.reference_speed:g} rev/min")


def _stiffness_at_rest(table: SpeedSweepTable, problem: Problem, asked: Asked) -> Array | None:
    """K at rest in SI, (n, n); None where it is the same at all speeds."""
    given, structure = table.stiffness_at_rest, problem.structure
    if asked.disks:
        return _disk_at_rest(asked.disks)
    if isinstance(structure, CyclicStructure) and any(isinstance(force, CentrifugalLoad) for force in problem.forces):
        remedy = "Write speed and at_speeds in [structure.sector] in place of it, and the pull of dampers in [[body]]."
        raise fault("[rotation]", "must stay away from a speed sweep of a sector, whose K goes with the speed", "given", remedy)
    if given is None:
        follows = structure.softening
        return None if follows is None else structure.K + (2.0 * pi * table.reference_speed / 60.0) ** 2 * follows
    if isinstance(problem, TunedDisk):
        raise fault("[speed_sweep]: stiffness_at_rest", "must go with matrices", "a ready disk", "Use ss.speed_sweep in Python.")
    if asked.rig[0]:
        raise fault("[speed_sweep]: stiffness_at_rest", "must go with matrices", f"rig {asked.rig[0]!r}, which brings its own")
    K = _read(asked.folder / given) if isinstance(given, str) else np.array(given, dtype=float)
    size = structure.size
    if K.shape != (size, size):
        raise fault("[speed_sweep]: stiffness_at_rest", f"must have the shape of K, {(size, size)}", K.shape)
    rotations = [dof for dof in structure.dofs if dof.rpartition(".")[2].startswith("r")]
    if rotations and asked.units.system.length != "m":
        raise InputError(
            "[speed_sweep]: stiffness_at_rest must be of displacements alone where lengths are not in m, but the structure has "
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


def _read(path: Path) -> Array:
    matrices = read_content(path, {})[0].matrices
    found = matrices.get("K", next(iter(matrices.values())) if len(matrices) == 1 else None)
    if found is None:
        raise fault(
            "[speed_sweep]: stiffness_at_rest", "must be a file with a matrix K", f"{path.name} with {', '.join(matrices)}"
        )
    dense = found.toarray() if hasattr(found, "toarray") else found
    return np.asarray(dense, dtype=float)


TABLE = "speed_sweep"
KIND = Kind(
    plan,
    {TABLE: SpeedSweepTable},
    required=(TABLE,),
    checks={TABLE: checked},
    band=lambda tables: band_of(SpeedSweepTable.model_validate(tables[TABLE])) if TABLE in tables else None,
    without=("quantity", "measure"),
)
