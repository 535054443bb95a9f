"""Conversion of a model to a `Structure`: complete if small, else by Craig–Bampton reduction to the places in use.

A reduction is kept on disk under a name that identifies its content, so that the same model is reduced once.
"""

import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

import stickslip
from stickslip.model.readers import numpy_archive
from stickslip.model.readers.model import Model, indefinite_mass
from stickslip.model.readers.numbers import within_memory
from stickslip.model.readers.stress_places import (
    Place,
    StressRows,
    centrifugal_loads,
    prestress_note,
    rotation_note,
    rotation_stress_of_body,
)
from stickslip.model.structure.centrifugal import CentrifugalLoads, RotationAxis
from stickslip.model.structure.cyclic_reduction import craig_bampton, mode_names
from stickslip.model.structure.matrices import Damping, Point, SparseStructure, Structure
from stickslip.model.structure.mesh_surface import MeshSurface, recovery_rows, selection
from stickslip.model.structure.modes import ModeCount, rigid_motions, without_resistance
from stickslip.model.structure.stress import StressRecovery
from stickslip.support.checks import Array, InputError, fault
from stickslip.support.files import only_own_files, write_arrays

Progress = Callable[[float, str], None]
"""Called with the share that is done and what is being done."""

WHOLE_SIZE = 3000
"""Rows up to which a model is taken whole."""
MODES = 30
"""Default number of fixed-interface modes."""


def quiet(share: float, text: str) -> None:
    """Progress that nobody watches."""


def whole(model: Model, damping: Damping | None = None, stress: StressRows | None = None) -> Structure:
    """The model as it stands, dense."""
    if model.size > WHOLE_SIZE:
        remedy = "Name the places of contacts, loads and outputs in `keep`: the rest is then reduced to modes."
        raise fault("A model taken whole", f"must have at most {WHOLE_SIZE} rows", model.size, remedy)
    C = None if model.C is None else model.C.toarray()
    nodes = {node: model.nodes[node] for node in model.located[0]}
    sets = {name: tuple(node for node in members if node in model.directions) for name, members in model.sets.items()}
    mesh = model.surface
    surfaces = () if mesh is None else (MeshSurface(*mesh[:2], selection(mesh.numbers, model.size), model.dofs),)
    stresses = () if stress is None else (stress.recovery(stress.rows.toarray(), model.dofs),)
    made = Structure(model.M.toarray(), model.K.toarray(), model.dofs, C, damping, nodes=nodes, sets=sets)
    rotating: dict[str, Any] = {name: part.toarray() for name, part in _rotating(model).items()}
    return replace(made, surfaces=surfaces, stresses=stresses, **rotating)


def _rotating(model: Model) -> dict[str, Any]:
    """What the rotation adds to a model, by name, as far as there is any."""
    return {name: part for name in ("softening", "coriolis") if (part := getattr(model, name)) is not None}


def unreduced(
    model: Model, places: tuple[Place, ...], damping: Damping | None = None, stress: StressRows | None = None
) -> SparseStructure:
    """The model with its sparse matrices, which contacts reduce: rows of places by their names there, all others by their own."""
    renamed = {row: name for place in places for name, row in place.dofs.items()}
    dofs = tuple(renamed.get(row, dof) for row, dof in enumerate(model.dofs))
    nodes = {}
    for dof, own in zip(dofs, model.dofs, strict=True):
        node = own.rpartition(".")[0]
        if node in model.nodes:
            nodes[dof.rpartition(".")[0]] = model.nodes[node]
    surface = model.surface
    surfaces: tuple[MeshSurface, ...] = ()
    stresses: tuple[StressRecovery, ...] = ()
    if surface is not None:
        moving = np.unique(surface.numbers[surface.numbers >= 0])
        numbers = np.where(surface.numbers >= 0, np.searchsorted(moving, surface.numbers), -1)
        names = tuple(dofs[row] for row in moving)
        surfaces = (MeshSurface(*surface[:2], selection(numbers, moving.size), names),)
    if stress is not None:
        around = np.unique(stress.rows.indices)
        stresses = (stress.recovery(stress.rows[:, around].toarray(), tuple(dofs[row] for row in around)),)
    made = SparseStructure(model.M, model.K, dofs, damping=damping, nodes=nodes, sets=kept_sets(model, places))
    return replace(
        made, mesh_points=model.located[1], surfaces=surfaces, stresses=stresses, kept=tuple(renamed[row] for row in renamed)
    )


def reduced(
    model: Model,
    places: tuple[Place, ...],
    modes: int | None,
    damping: Damping | None = None,
    progress: Progress = quiet,
    stress: StressRows | None = None,
) -> tuple[Structure, str]:
    """The model by its places and `modes` fixed-interface modes (30, or all of a smaller model) with those equal to the last, and
    how many there are; C is projected too."""
    kept = {name: row for place in places for name, row in place.dofs.items()}
    inside = model.size - len(kept)
    if modes is not None and modes not in range(inside + 1):
        raise fault("modes", f"must be a whole number from 0 to {inside}, the rows that are not kept", modes)
    number = min(MODES, inside) if modes is None else int(modes)
    surface, located = model.surface, model.located[1]
    drawn = b"" if surface is None else surface.numbers.tobytes()
    rotating = _rotating(model)
    turning = [part.data.tobytes() for part in rotating.values()]
    reduction = sorted(kept.values()), list(kept.values()), number, drawn, located.tobytes(), stress and stress.bytes, turning
    key = repr((stickslip.__version__, model.fingerprint, *reduction))
    file = cache_folder() / f"{sha256(key.encode()).hexdigest()[:32]}.npz"
    matrices = from_cache(file, ("M", "K", "C", "recovery", "stress", "count", "loads", *rotating))
    if matrices is None:
        matrices = _reduce(model, kept, number, progress, stress)
        to_cache(file, matrices)
    else:
        progress(1.0, f"reduction found in {file}")
    C = matrices["C"] if matrices["C"].size else None
    dofs = (*kept, *mode_names(matrices["M"].shape[0] - len(kept)))
    nodes, sets = kept_nodes(model, kept), kept_sets(model, places)
    surfaces = () if surface is None else (MeshSurface(*surface[:2], matrices["recovery"], dofs),)
    stresses = () if stress is None else (stress.recovery(matrices["stress"], dofs),)
    made = Structure(matrices["M"], matrices["K"], dofs, C, damping, nodes=nodes, sets=sets, mesh_points=located)
    loads = CentrifugalLoads(matrices["loads"], made.size) if matrices["loads"].size else None
    follows: dict[str, Any] = {name: matrices[name] for name in rotating}
    made = replace(made, surfaces=surfaces, stresses=stresses, centrifugal=loads, **follows)
    return made, _count_note(ModeCount.of(matrices["count"]), number)


def _count_note(count: ModeCount, asked: int) -> str:
    more = f" ({asked} were asked for, and the others equal the last of these)" if count.found > asked else ""
    return f"{'Warning: modes' if count.there is None else 'Modes'} of the body with what is kept held: {count}{more}"


def kept_nodes(model: Model, kept: dict[str, int]) -> dict[str, Point]:
    """Coordinates of the kept nodes by their names in the reduced model."""
    names = {name.rpartition(".")[0]: model.dofs[row].rpartition(".")[0] for name, row in kept.items()}
    return {name: model.nodes[node] for name, node in names.items() if node in model.nodes}


def kept_sets(model: Model, places: tuple[Place, ...]) -> dict[str, tuple[str, ...]]:
    """The nodes of each place by their names in the reduced model."""
    rows = {model.dofs[row].rpartition(".")[0]: name.rpartition(".")[0] for place in places for name, row in place.dofs.items()}
    return {place.name: tuple(dict.fromkeys(rows[node] for node in place.nodes if node in rows)) for place in places}


def _reduce(model: Model, kept: dict[str, int], modes: int, progress: Progress, stress: StressRows | None) -> dict[str, Array]:
    """What the cache keeps of a reduction: M, K and C, and the rows that recover the outer surface and the stress."""
    basis = 8 * model.size * (len(kept) + modes)
    within_memory("The basis of the reduction", 3 * basis)
    if indefinite_mass(model.M):
        raise fault("M", "must have no negative eigenvalue", "indefinite", "Check the sign and the export of the mass.")
    sizes = f"{model.size} rows to {len(kept)} kept and {modes} modes; the basis takes {basis / 2**20:.0f} MiB"
    progress(0.0, f"reducing {sizes}")
    loads = loads_of(model)
    reduction = craig_bampton(model.M, model.K, kept, modes, progress, None if loads is None else loads.table[:, : loads.size].T)
    T = reduction.transformation
    C = np.zeros((0, 0)) if model.C is None else np.asarray(T.T @ (model.C @ T))
    numbers = np.zeros((0, 3), dtype=int) if model.surface is None else model.surface.numbers
    K = reduction.structure.K
    # The reduced K must leave the same rigid motions free; rounding would hold them. Fixed-interface modes do not move in them.
    rigid = rigid_motions(model.K, model.dofs, model.nodes)
    if rigid.shape[1]:
        motions = np.zeros((K.shape[0], rigid.shape[1]))
        motions[: len(kept)] = rigid[list(kept.values())]
        K = without_resistance(K, motions)
    stresses = np.zeros((0, T.shape[1])) if stress is None else np.asarray(stress.rows @ T)
    rest = {"recovery": recovery_rows(T, numbers), "stress": stresses, "count": reduction.count.numbers}
    lacking = np.zeros((0, 9)) if stress is None else np.asarray(stress.rows @ reduction.beyond)
    rest |= {name: np.asarray(T.T @ (part @ T)) for name, part in _rotating(model).items()}
    rest["loads"] = np.zeros(0) if loads is None else loads.projected(T, lacking).table
    return {"M": reduction.structure.M, "K": K, "C": C} | rest


def loads_of(model: Model) -> CentrifugalLoads | None:
    """The centrifugal loads of a model where its rows have all that they need."""
    try:
        return centrifugal_loads(model)
    except InputError:
        return None


def cache_folder() -> Path:
    """Where reductions are kept: STICKSLIP_CACHE, or `stickslip` in the user's folder of caches."""
    chosen = os.environ.get("STICKSLIP_CACHE")
    return Path(chosen) if chosen else Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "stickslip" / "models"


def from_cache(file: Path, names: Sequence[str]) -> dict[str, Any] | None:
    """The arrays that an earlier reduction left; a damaged file counts as none."""
    try:
        arrays = numpy_archive.arrays(file)
        return {name: arrays[name] for name in names}
    except Exception:  # whatever a damaged file raises: the reduction is simply done again
        return None


def to_cache(file: Path, matrices: dict[str, Any]) -> None:
    """Keep a reduction; without a folder to write to, nothing is kept."""
    with suppress(OSError), only_own_files(False):
        write_arrays(file, matrices)


def structure_of(
    model: Model,
    places: tuple[Place, ...] | None,
    modes: int | None,
    damping: Damping | None,
    progress: Progress = quiet,
    stress: StressRows | None = None,
    rotation: tuple[float, RotationAxis] | None = None,
    many_contacts: bool = False,
) -> tuple[Structure, tuple[str, ...]]:
    """The model whole, or by its places, and what was found; with the stress where it is asked for, and the part of it due to
    rotation at a speed in rev/min about an axis. many_contacts: with sparse matrices, for contacts to reduce."""
    if damping is not None and model.C is not None:
        where = f"{model.file} has" if model.file else "the structure has"
        remedy = "Leave [damping] out (in Python: damping), or write own_damping = false, so that C counts for nothing."
        raise InputError(f"Damping must be given once, but {where} a matrix C beside the damping rule. {remedy}")
    if places is None and modes is not None:
        raise InputError("modes must go with keep or a contact surface, the places that are not reduced, but stands alone.")
    notes: tuple[str, ...] = ()
    made: Structure
    if many_contacts:
        made = unreduced(model, places or (), damping, stress)
        notes = () if modes is None else (f"modes = {modes} has no effect: the frequencies of the band and its harmonics decide",)
    elif places is None:
        made = whole(model, damping, stress)
    else:
        made, counted = reduced(model, places, modes, damping, progress, stress)
        notes = (counted,)
    made = made if made.centrifugal else replace(made, centrifugal=loads_of(model))
    if rotation is None:
        return made, notes
    if stress is None:
        raise InputError("The speed of a model must go with places of stress, whose mean it changes, but there are none.")
    speed, axis = rotation
    mean = rotation_stress_of_body(model, stress.rows, axis, speed)
    notes += tuple(filter(None, (rotation_note(stress, mean, speed), prestress_note(model, axis, speed))))
    (recovery,) = made.stresses
    return replace(made, stresses=(replace(recovery, rotation=mean.reshape(len(recovery.places), -1)),)), notes
