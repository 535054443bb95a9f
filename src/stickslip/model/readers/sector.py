"""A sector of a bladed disk from another program, as a cyclic structure.

The model is one sector with both faces free: the ties of a cyclic analysis must not act in its matrices. The high face is the low
one turned by 2π/N about the axis. Its nodes are paired by their coordinates; where they do not match, why, or interpolation.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy import sparse

import stickslip
from stickslip.model.readers import stress_places
from stickslip.model.readers.deck import OWN_AXES
from stickslip.model.readers.model import ROTATIONS, Model
from stickslip.model.readers.read import Paths, read_model
from stickslip.model.readers.reduction import (
    MODES,
    Progress,
    cache_folder,
    from_cache,
    kept_nodes,
    kept_sets,
    loads_of,
    quiet,
    to_cache,
)
from stickslip.model.structure.centrifugal import Z_AXIS, AxisLike, CentrifugalLoads, RotationAxis
from stickslip.model.structure.cyclic import MOST_SECTORS, CyclicStructure, HeldDiameters, cyclic
from stickslip.model.structure.cyclic_reduction import (
    MATCH,
    Sector,
    hermitian,
    lowest_frequencies,
    mode_names,
    partners,
    reduced_waves,
    sector_of,
    shared_modes,
    shared_waves,
    spacing,
)
from stickslip.model.structure.matrices import Damping, Sparse
from stickslip.model.structure.modes import ModeCount, natural_modes
from stickslip.model.structure.solid import Solid
from stickslip.support.checks import Array, Index, InputError, between, counted, fault, first_of, nearest, not_negative
from stickslip.support.units import UnitSystem, unit_system

SAME_MASS = 1e-6
"""Difference of two mass matrices, relative to their largest entry, that is rounding of printed numbers."""
OTHER_SUPPORT = 100.0
"""Ratio of two entries on the diagonals of K beyond which a support has changed and not the speed."""
LOWEST, SHARED = 3, 0.01
"""Natural frequencies that are compared, and their relative error beyond which models at two speeds are warned of: margins to a
speed are judged to some per cent."""
AT_SPEEDS, SAME_SUPPORTS = "The models of a sector at several speeds", "Fix the same nodes at every speed."
WAVE = ("M", "K", "stress", "count", "loads")
"""What is kept of the reduction of a nodal diameter."""
COUPLING = 1e-6
"""Mass between different directions, relative to the largest, that is more than rounding."""


@dataclass(frozen=True)
class Faces:
    """How a sector meets its neighbours: the number of sectors of the disk, the sets of nodes of the low face and of the high
    one, which is the low one turned by 2π/N about the axis, and whether their meshes differ (interpolated).
    """

    sectors: int
    low: str
    high: str
    axis: RotationAxis = Z_AXIS
    interpolated: bool = False


@dataclass(frozen=True, eq=False)
class ReadSector:
    """A sector with its paired faces; rows: of each row of the model the row in it, −1 where a partner on the other face fixes
    it; notes: sentences on what was found."""

    sector: Sector
    rows: Index
    notes: tuple[str, ...]


def read_sector(
    path: Paths,
    *,
    sectors: int,
    faces: tuple[str, str],
    keep: stress_places.Keep,
    axis: AxisLike = "z",
    modes: int = MODES,
    interpolated: bool = False,
    units: str | UnitSystem = "SI",
    damping: Damping | None = None,
    names: str | Path | None = None,
    speed: float | None = None,
    stress: Mapping[str, stress_places.Where | stress_places.StrainGauge] | None = None,
    nodal_diameters: Sequence[int] | None = None,
    progress: Progress = quiet,
) -> CyclicStructure:
    """Read the finite-element model of one sector and return the disk of `sectors` equal sectors, reduced for every nodal
    diameter, in SI.

    faces: the two sets of nodes at which a sector meets its neighbours, (low, high): high is low turned by 2π/N counter-clockwise
    about the axis. keep: the nodes to retain, as in `read_structure`, none of them on the faces. axis: of rotation, "x", "y" or
    "z" through the origin, or (point, direction) in the units of the model. modes: number of fixed-interface modes of each nodal
    diameter, in addition to the retained nodes. interpolated: for faces with different meshes; the displacements of the finer
    face are interpolated between the nodes of the other. stress: places {name: node, set, coordinates or `StrainGauge`} whose
    stress is recovered from the elements of the deck, none of them on the faces. speed: rotor speed of K in rev/min; the mean
    stress then contains the stress due to rotation. nodal_diameters: those to reduce, default all; engine order EO excites only
    the multiples of its greatest common divisor with N. These are enough for a `TunedDisk` under EO, but not for its `full()`,
    mistuning and gas forces. progress is called with what is being done and what was found.

    A pair of nodes on the faces is fixed if either node is fixed. Matrices with a constraint between the faces are refused: in
    CalculiX write them without *CYCLIC SYMMETRY MODEL, or with CYCMPC=INACTIVE.
    """
    system = unit_system(units)
    model = read_model(path, units=system, names=names)
    joint = Faces(sectors, *faces, RotationAxis.of(axis).scaled(system.metres), interpolated)
    recovered = None if stress is None else stress_places.stress_rows_of(model, stress, system.metres)
    places = stress_places.places_of(model, keep, system.metres)
    speeds = [] if speed is None else [not_negative("speed", speed)]
    chosen = HeldDiameters.of(between("sectors", sectors, 2, MOST_SECTORS), nodal_diameters)
    disks, notes = disks_of([model], joint, places, modes, damping, progress, speeds, recovered, chosen)
    for note in notes:
        progress(1.0, note)
    return disks[0]


def read_sector_at_speeds(
    paths: Mapping[float, Paths],
    *,
    sectors: int,
    faces: tuple[str, str],
    keep: stress_places.Keep,
    axis: AxisLike = "z",
    modes: int = MODES,
    interpolated: bool = False,
    units: str | UnitSystem = "SI",
    damping: Damping | None = None,
    names: str | Path | None = None,
    stress: Mapping[str, stress_places.Where | stress_places.StrainGauge] | None = None,
    progress: Progress = quiet,
) -> dict[float, CyclicStructure]:
    """Read the models of one sector at several rotor speeds, {speed in rev/min: path}, and return {speed: disk}, all of them
    in the same coordinates. In a Campbell diagram K(Ω) lies between them, and turns with the blades. That of `ss.speed_sweep`
    goes straight with Ω², so that its two models should be near to the speeds of the sweep.

    The mass matrix must be the same at all speeds, and every K must contain what its program adds at that speed: stress
    stiffening and, as in CalculiX, spin softening. All are reduced with the shapes of the slowest and the fastest K together:
    modes is the number of fixed-interface modes of each, and of the static shapes in which they differ, so that there are up to
    three times as many modal coordinates. Other arguments: as for `read_sector`.
    """
    speeds = sorted(not_negative("paths, a speed", speed) for speed in paths)
    if len(speeds) < 2:
        raise fault("paths", "must be models at two speeds at least, {speed in rev/min: path}", dict(paths))
    system = unit_system(units)
    joint = Faces(sectors, *faces, RotationAxis.of(axis).scaled(system.metres), interpolated)
    models = held_alike([read_model(paths[speed], units=system, names=names) for speed in speeds], joint)
    recovered = None if stress is None else stress_places.stress_rows_of(models[0], stress, system.metres)
    places = stress_places.places_of(models[0], keep, system.metres)
    disks, notes = disks_of(models, joint, places, modes, damping, progress, speeds, recovered)
    for note in notes:
        progress(1.0, note)
    return dict(zip(speeds, disks, strict=True))


def held_alike(models: Sequence[Model], faces: Faces) -> list[Model]:
    """The models of one sector at several speeds without the rows on one face that a model alone has and whose partner it holds.

    CalculiX refuses supports on the dependent face of a cyclic step, which a model without such a step has. A pair of nodes is
    held where one of them is.
    """
    common = set.intersection(*(set(model.dofs) for model in models))
    found = []
    for model in models:
        extra = {name for name in model.dofs if name not in common}
        nodes = sorted({name.rpartition(".")[0] for name in extra})
        if nodes and _held_by_partners(model, nodes, faces):
            rows = [row for row, name in enumerate(model.dofs) if name not in extra]
            held = f"{counted(len(nodes), 'node')} on one face held, as at the other speeds"
            notes = (*model.notes, f"{model.file}: {held}: {first_of(nodes)}")
            M, K = (sparse.csc_array(matrix[rows][:, rows]) for matrix in (model.M, model.K))
            model = replace(model, M=M, K=K, dofs=tuple(model.dofs[row] for row in rows), notes=notes)
        found.append(model)
    return found


def _held_by_partners(model: Model, nodes: Sequence[str], faces: Faces) -> bool:
    """Whether nodes lie on one face, and those nearest to them on the other one, turned, are held."""
    for own, other, steps in ((faces.low, faces.high, 1), (faces.high, faces.low, -1)):
        across = [*model.sets.get(other, ())]
        if across and {*nodes} <= {*model.sets.get(own, ())} and {*nodes, *across} <= {*model.nodes}:
            points = np.array([model.nodes[node] for node in (*nodes, *across)])
            numbers = np.arange(len(points))
            _, near = partners(points, numbers[: len(nodes)], numbers[len(nodes) :], faces.axis, faces.sectors, steps)
            return all(across[k] not in model.directions for k in near)
    return False


def disks_of(
    models: Sequence[Model],
    faces: Faces,
    places: Sequence[stress_places.Place],
    modes: int | None = None,
    damping: Damping | None = None,
    progress: Progress = quiet,
    speeds: Sequence[float] = (),
    stress: stress_places.StressRows | None = None,
    diameters: HeldDiameters | None = None,
) -> tuple[list[CyclicStructure], tuple[str, ...]]:
    """The disks of the models of one sector, at `speeds` in rev/min where they are known, and notes on what was found; with all
    nodal diameters unless some are chosen."""
    if any(model.C is not None for model in models):
        raise InputError("The model of a sector must not contain C. Use a damping rule, or pass the matrices to `with_damping`.")
    model = models[0]
    read = sector_of_model(model, faces)
    # Stress at a node is the mean over its elements, some of which belong to the neighbour on a face.
    on_faces = {node for face in (faces.low, faces.high) for node in model.sets[face]}
    named = [name for name, node in (stress.nodes if stress else {}).items() if node in on_faces]
    if named:
        raise fault("A place of stress", "must not lie on a face of the sector", named[0], "Choose a node beside it.")
    stiffnesses = [read.sector.solid.K, *(_stiffness(model, each, read) for each in models[1:])]
    kept = {name: int(read.rows[row]) for place in places for name, row in place.dofs.items()}
    held = sorted(name for name, row in kept.items() if row < 0)
    if held:
        raise fault("Kept degrees of freedom", "must not be fixed by their partner on the other face", held)
    number = MODES if modes is None else modes
    speed = speeds[0] if speeds and stress is not None else 0.0
    if speed:
        stress_places.refuse_own_axes(model)
    diameters = diameters or HeldDiameters.of(faces.sectors)
    arrays = _reduced(models, read, stiffnesses, faces, kept, number, stress, speeds, diameters, progress)
    dofs = (*kept, *mode_names(number if len(models) == 1 else shared_modes(kept, number)))
    whole = {name: row for place in places for name, row in place.dofs.items()}
    nodes, sets = kept_nodes(model, whole), kept_sets(model, tuple(places))
    mean = arrays["rotation"] if arrays["rotation"].size else None
    recoveries = () if stress is None else (stress.recovery(arrays["stress"], dofs, diameters, mean),)
    surface = model.surface
    disks = [
        replace(
            cyclic(faces.sectors, dofs, arrays["M"], waves, None, None, faces.axis, diameters.held),
            nodes=nodes,
            sets=sets,
            mesh_points=model.located[1] if surface is None else surface.points,
            mesh_triangles=np.zeros((0, 3), dtype=np.int64) if surface is None else surface.triangles,
            damping=damping,
            turns=len(models) > 1,
            stresses=recoveries,
            centrifugal=CentrifugalLoads(arrays["loads"], len(dofs)) if arrays["loads"].size else None,
        )
        for waves in arrays["K"]
    ]
    notes = [*map(str, places), *(stress.notes if stress else ())]
    if stress is not None and mean is not None:
        notes.append(stress_places.rotation_note(stress, mean, speed))
    notes += read.notes
    counts = [ModeCount.of(numbers) for numbers in arrays["counts"]]
    notes += _count_notes(dict(zip(diameters.held, counts, strict=True)), number)
    if faces.interpolated:
        error = 100.0 * float(arrays["error"])
        notes.append(f"The lowest frequencies change by up to {error:.1g} % if the other face follows instead")
    notes += _shared_notes(arrays["shared"], models, diameters.held[0])
    speed_of: Sequence[float | None] = speeds or [None] * len(models)
    notes += filter(
        None, (stress_places.prestress_note(each, faces.axis, own) for each, own in zip(models, speed_of, strict=True))
    )
    return disks, tuple(notes)


def _reduced(
    models: Sequence[Model],
    read: ReadSector,
    stiffnesses: Sequence[Sparse],
    faces: Faces,
    kept: Mapping[str, int],
    modes: int,
    stress: stress_places.StressRows | None,
    speeds: Sequence[float],
    diameters: HeldDiameters,
    progress: Progress,
) -> dict[str, NDArray[Any]]:
    """The reduction on the shapes of the slowest and the fastest model: M of the nodal diameters (held, m, m), K of each model
    (models, held, m, m), stress (held, rows, m) and that due to rotation (rows,), error of the interpolation.

    Every nodal diameter has a file of its own in the cache, so that another engine order finds those that it shares.
    """
    speed = speeds[0] if speeds and stress is not None else 0.0
    ends = [0] if len(models) == 1 else [int(np.argmin(speeds)), int(np.argmax(speeds))]
    face_nodes = [(node, models[0].nodes[node]) for face in (faces.low, faces.high) for node in models[0].sets[face]]
    reduction = [model.fingerprint for model in models], faces, face_nodes, list(kept.values()), modes
    key = repr((stickslip.__version__, *reduction, ends, stress and stress.bytes, speed))
    files = {part: cache_folder() / f"{sha256(f'{key} {part}'.encode()).hexdigest()[:32]}.npz" for part in ("", *diameters.held)}
    sector = read.sector
    free = np.flatnonzero(read.rows >= 0)
    rows = None if stress is None else stress.rows[:, free]
    centrifugal = loads_of(models[0])
    acting = None if centrifugal is None else centrifugal.table[:, free].T
    waves = {n: found for n in diameters.held if (found := from_cache(files[n], WAVE)) is not None}
    wanted = [n for n in diameters.held if n not in waves]
    if not wanted:
        progress(1.0, f"reduction found in {files[0]}")
    both = [replace(sector, solid=replace(sector.solid, K=stiffnesses[k])) for k in ends]
    if len(both) == 1:
        reduced = reduced_waves(sector, kept, modes, wanted, progress, acting)
    else:
        reduced = shared_waves(both, kept, modes, wanted, progress, acting)
    for n, wave in zip(wanted, reduced, strict=True):
        T = wave.transformation
        lacking = np.zeros((0, 9)) if rows is None else rows @ wave.beyond
        # All sectors have the same load: it is one of nodal diameter 0.
        own = None if centrifugal is None or n else centrifugal.on_rows(free).projected(T.real, lacking.real)
        waves[n] = {
            "M": wave.M,
            "K": np.array([wave.K] if len(stiffnesses) == 1 else [hermitian(T.conj().T @ (K @ T)) for K in stiffnesses]),
            "stress": np.zeros((0, len(wave.M))) if rows is None else rows @ T,
            "count": wave.counted.numbers,
            "loads": np.zeros(0) if own is None else own.table,
        }
        to_cache(files[n], waves[n])
    rest = from_cache(files[""], ("error", "rotation", "shared"))
    if rest is None:
        rest = {
            "error": np.array(interpolation_error(sector) if faces.interpolated else 0.0),
            "rotation": np.zeros(0)
            if rows is None or not speed
            else stress_places.rotation_stress(sector, rows, faces.axis, speed),
            "shared": _raised(sector, stiffnesses, kept, modes, diameters.held[0], waves[diameters.held[0]]),
        }
        to_cache(files[""], rest)
    M, K, recovery = (np.array([waves[n][part] for n in diameters.held], dtype=complex) for part in ("M", "K", "stress"))
    counts = np.array([waves[n]["count"] for n in diameters.held])
    return {"M": M, "K": K.swapaxes(0, 1), "stress": recovery, "counts": counts, "loads": waves[0]["loads"], **rest}


def _raised(sector: Sector, stiffnesses: Sequence[Sparse], kept: Mapping[str, int], modes: int, n: int, wave: Any) -> Array:
    """By how much the lowest natural frequencies of each model are higher in the shapes that all speeds share than in its own,
    relatively, at a nodal diameter; empty for one model.
    """
    raised = []
    for k, K in enumerate(stiffnesses if len(stiffnesses) > 1 else ()):
        own = next(reduced_waves(replace(sector, solid=replace(sector.solid, K=K)), kept, modes, [n]))
        apart, shared = (natural_modes(*pair).frequencies for pair in ((own.M, own.K), (wave["M"], wave["K"][k])))
        lowest = np.flatnonzero(apart > 0.0)[:LOWEST]
        raised.append(float(np.max(shared[lowest] / apart[lowest] - 1.0)))
    return np.array(raised)


def _shared_notes(raised: Array, models: Sequence[Model], n: int) -> Iterator[str]:
    """What the shapes that all speeds share change at the speeds of the models."""
    if not raised.size:
        return
    most = int(np.argmax(raised))
    where = f"the {LOWEST} lowest frequencies at nodal diameter {n} are up to {100.0 * max(raised[most], 0.0):.2g} % higher"
    said = f"In the reduction basis that all speeds share, {where} than in that of {models[most].file} alone"
    yield said if raised[most] <= SHARED else f"Warning: {said}: take more modes"


def _count_notes(counts: Mapping[int, ModeCount], modes: int) -> Iterator[str]:
    """How many modes there are of those that each nodal diameter keeps, and where the last of them has equals beyond."""
    what = "Modes of the sector with what is kept held, at each nodal diameter"
    whole = [count.hertz for count in counts.values() if count.there == count.found == modes]
    if len(whole) == len(counts):
        ends = list(dict.fromkeys(f"{hertz:.5g}" for hertz in (min(whole), max(whole))))
        yield f"{what}: {modes} of {modes} below {' to '.join(ends)} Hz" if np.isfinite(max(whole)) else f"{what}: all {modes}"
    for n, count in counts.items():
        if count.there is None:
            yield f"Warning: at nodal diameter {n}, modes of the sector with what is kept held: {count}"
        elif count.found > modes:
            yield (
                f"Warning: at nodal diameter {n} the last of {modes} modes has equals, with which there are {count.found} below "
                f"{count.hertz:.5g} Hz: keep all of them, or none"
            )


def _stiffness(model: Model, other: Model, read: ReadSector) -> Sparse:
    """K of the same sector at another speed, in the rows of the sector."""
    if set(other.dofs) != set(model.dofs):
        pairs = ((model, other), (other, model))
        more = [f"{first_of(sorted(set(a.dofs) - set(b.dofs)))} in {a.file} alone" for a, b in pairs if set(a.dofs) - set(b.dofs)]
        raise fault(AT_SPEEDS, "must have the same rows", "; ".join(more), SAME_SUPPORTS)
    _refuse_other_supports(model, other)
    order = np.array([other.rows[name] for name in model.dofs])[np.flatnonzero(read.rows >= 0)]
    M = other.M[order][:, order]
    gap = np.abs((M - read.sector.solid.M).data).max(initial=0.0)
    if gap > SAME_MASS * np.abs(M.data).max():
        raise fault(AT_SPEEDS, "must have the same M", f"a difference of {gap:.3g} kg")
    return sparse.csc_array(other.K[order][:, order])


def _refuse_other_supports(model: Model, other: Model) -> None:
    """Stiffness against a support, or a row that is taken out, stands on the diagonal of K, far beyond what a speed changes."""
    own, theirs = model.K.diagonal(), other.K.diagonal()[[other.rows[name] for name in model.dofs]]
    small, large = np.sort(np.abs([own, theirs]), axis=0)
    differs = (large > OTHER_SUPPORT * small) & (large > np.median(np.abs(own)) / OTHER_SUPPORT)
    if np.any(differs):
        row = int(np.flatnonzero(differs)[0])
        names = first_of([model.dofs[k] for k in np.flatnonzero(differs).tolist()])
        sizes = " and ".join(f"{value:.3g} N/m in {each.file}" for value, each in ((own[row], model), (theirs[row], other)))
        raise fault(AT_SPEEDS, "must be held at the same nodes", f"{names} with {sizes} on the diagonal of K", SAME_SUPPORTS)


def sector_of_model(model: Model, faces: Faces) -> ReadSector:
    """The sector of a model with its faces paired."""
    between("sectors", faces.sectors, 2, MOST_SECTORS)
    names, points = tuple(model.nodes), np.array([model.nodes[node] for node in model.nodes]).reshape(-1, 3)
    numbers = np.array([[model.rows.get(f"{node}.{direction}", -1) for direction in "xyz"] for node in names]).reshape(-1, 3)
    low, high = (_side(model, names, face) for face in (faces.low, faces.high))
    _refuse_local_axes(model, numbers, np.concatenate([low, high]))
    _refuse_rotations(model, [names[node] for node in np.concatenate([low, high])])
    pairs = paired(Solid(model.M, model.K, points, numbers), faces, low, high)
    free = numbers[np.concatenate([pairs.left, pairs.right])] >= 0
    partly = np.concatenate([pairs.left, pairs.right])[free.any(axis=1) != free.all(axis=1)]
    if partly.size:
        raise fault(
            "Nodes on the faces of a sector",
            "must be free or fixed in all three directions",
            f"{first_of([names[node] for node in partly])} fixed in one or two",
            "Fix these nodes in all three directions, or support other nodes instead.",
        )
    left, right = np.split(free[:, 0], [pairs.left.size])
    if not (np.any(left) and np.any(right)) or (not faces.interpolated and not np.any(left & right)):
        raise InputError(
            f"The sector must be written with both faces free, but no pair of nodes of {faces.low} and {faces.high} has rows on "
            "both: the matrices contain a cyclic constraint, or both faces are fixed. In CalculiX omit *CYCLIC SYMMETRY MODEL, "
            "or write CYCMPC=INACTIVE."
        )
    one_sided = np.zeros(0, dtype=np.int64)
    if not faces.interpolated:  # a node whose partner is fixed is fixed too
        one_sided = np.concatenate([numbers[pairs.left[left & ~right]], numbers[pairs.right[right & ~left]]]).ravel()
    kept = np.setdiff1d(np.arange(model.size), one_sided)
    rows = np.full(model.size + 1, -1, dtype=np.int64)  # the last entry is what −1, of fixed directions, leads to
    rows[kept] = np.arange(kept.size)
    reduced = Solid(model.M[kept][:, kept], model.K[kept][:, kept], points, rows[numbers])
    return ReadSector(replace(pairs, solid=reduced), rows[:-1], tuple(_notes(pairs, faces, left, right)))


def _notes(pairs: Sector, faces: Faces, left: NDArray[np.bool_], right: NDArray[np.bool_]) -> Iterator[str]:
    """How the nodes of the faces were paired, or which follow the others; left, right: whether a node of either is free."""
    apart = f"at most {1e3 * pairs.apart:.2g} mm apart"
    if faces.interpolated:
        leading, following = (faces.high, faces.low) if pairs.mirrored else (faces.low, faces.high)
        yield (
            f"The {counted(pairs.right.size, 'node')} of {following} follow the {counted(pairs.left.size, 'node')} of {leading} "
            f"by interpolation, {apart} from their surface"
        )
        return
    yield f"{faces.low} and {faces.high}: {counted(left.size, 'pair')} of nodes, {apart}, 1 of {faces.sectors} sectors"
    one_sided = int(np.sum(left != right))
    if one_sided:
        yield f"{counted(one_sided, 'pair of nodes is', 'pairs of nodes are')} fixed because one node is"


def _side(model: Model, names: Sequence[str], face: str) -> Index:
    """The numbers of the nodes of a face."""
    if face not in model.sets:
        known = nearest(face, model.sets) if model.sets else "It has no sets: name a deck or a table with them (names = ...)."
        raise fault("A face of the sector", "must be a set of nodes of the model", face, known)
    members = set(model.sets[face])
    missing = sorted(members - set(names))
    if missing:
        raise fault(f"The nodes of {face}", "must have coordinates", f"{first_of(missing)} without")
    return np.flatnonzero([node in members for node in names])


def _refuse_rotations(model: Model, nodes: Sequence[str]) -> None:
    """Rotations of shells and beams on the faces would stay apart: the faces are joined in their displacements."""
    turning = [name for node in nodes for name in (f"{node}.{about}" for about in ROTATIONS) if name in model.rows]
    if turning:
        raise fault(
            "Nodes on the faces of a sector",
            "must have displacements alone",
            f"{first_of(turning)} with rotations",
            "Mesh the sector with solid elements, and leave the rotations that these do not have out of the matrices.",
        )


def _refuse_local_axes(model: Model, numbers: Index, nodes: Index) -> None:
    """Rows of face nodes along axes of their own do not join. The mass of solids then couples different directions of two nodes,
    which it does not along the axes of the model; only where the reader has noted such axes at all.
    """
    if not any(OWN_AXES in note for note in model.notes):
        return
    direction = np.array(["xyz".find(name.rpartition(".")[2]) for name in model.dofs])
    own = numbers[nodes].ravel()
    mass = sparse.coo_array(model.M[own[own >= 0]])
    ours, others = direction[own[own >= 0]][mass.coords[0]], direction[mass.coords[1]]
    coupling = np.abs(mass.data[(others >= 0) & (ours != others)]).max(initial=0.0)
    if coupling > COUPLING * np.abs(mass.data).max(initial=0.0):
        raise fault(
            "Nodes on the faces of a sector",
            "must have rows along x, y and z of the model",
            "axes of their own",
            "Write the matrices without the local axes of these nodes (*TRANSFORM, CD, NROTAT).",
        )


ON_AXIS = 1e-6
"""Distance from the axis, relative to that of the farthest node of a face, at which a node is its own neighbour."""
COMPARED = 4
"""Frequencies of a nodal diameter by which an interpolation is judged."""
NEIGHBOURS = 12
"""Nodes between which a displacement is interpolated: twice the six coefficients of a quadratic polynomial."""
OFF = 0.25
"""How far a node may lie off the surface of the other face, relative to the distance of the nodes there."""


def paired(solid: Solid, faces: Faces, low: Index, high: Index) -> Sector:
    """The sector with the nodes of its faces paired, or interpolated."""
    for name, nodes in ((faces.low, low), (faces.high, high)):
        away = faces.axis.distances(solid.points[nodes])
        if not nodes.size or away.min() <= ON_AXIS * away.max():
            what = "on the axis" if nodes.size else "empty"
            raise fault(f"The face {name}", "must have nodes, all of them off the axis", what, "Cut a hole at the axis.")
    common = np.intersect1d(low, high)
    if common.size:
        what, remedy = f"The faces {faces.low} and {faces.high}", "Leave these nodes out of one of the sets."
        remedy = "low and high are one set." if faces.low == faces.high else remedy
        raise fault(what, "must have no node in common", counted(common.size, "node"), remedy)
    if faces.interpolated:
        return _interpolated(solid, faces, low, high)
    if low.size != high.size:
        raise InputError(
            f"The faces of the sector must have the same number of nodes, but {faces.low} has {low.size} and {faces.high} "
            f'{high.size}. Mesh both faces alike, or write faces = "interpolated" (in Python: interpolated=True).'
        )
    try:
        return sector_of(solid, faces.sectors, low, high, faces.axis)
    except InputError as error:
        raise _reason(solid.points, faces, low, high) or error from None


def _reason(points: Array, faces: Faces, low: Index, high: Index) -> InputError | None:
    """Why the faces do not match: exchanged, or of another number of sectors."""
    limit = MATCH * spacing(points[high])

    def match(sectors: int, steps: int) -> bool:
        return bool(partners(points, low, high, faces.axis, sectors, steps)[0].max() <= limit)

    what = f"The face {faces.high} must be {faces.low} turned by 360°/{faces.sectors} about the axis"
    if match(faces.sectors, -1):
        return InputError(
            f"{what}, but is turned by −360°/{faces.sectors}. Exchange low and high, or reverse the direction of the axis."
        )
    middles = [np.exp(1j * faces.axis.angles(points[side])) * faces.axis.distances(points[side]) for side in (low, high)]
    angle = float(np.angle(middles[1].sum() / middles[0].sum()))
    fits = round(2.0 * np.pi / abs(angle)) if angle else 0
    if fits >= 2 and match(fits, 1 if angle > 0.0 else -1):
        exchanged = "" if angle > 0.0 else ", with low and high exchanged"
        return InputError(f"{what}, but they match for sectors = {fits}{exchanged}. Check sectors and the axis.")
    distances = partners(points, low, high, faces.axis, faces.sectors)[0]
    lonely = int(np.sum(distances > limit))
    return InputError(
        f"{what}, to {1e3 * limit:.2g} mm, but {counted(lonely, 'node')} of {low.size} have no partner, the farthest "
        f"{1e3 * distances.max():.3g} mm away. The middles of the faces are {np.degrees(angle):.4g}° apart. Check the axis, mesh "
        'both faces alike, or write faces = "interpolated" (in Python: interpolated=True).'
    )


def interpolation_error(sector: Sector) -> float:
    """The largest relative change of the four lowest frequencies of nodal diameters 0 and N/2 if the other face follows.

    The right face, with more nodes, follows more closely; so this is an upper estimate of the error of the interpolation.
    """
    weights, _ = _weights(
        sector.axis.turned(sector.solid.points[sector.right], sector.sectors, 1 if sector.mirrored else -1),
        sector.solid.points[sector.left],
    )
    other = replace(sector, left=sector.right, right=sector.left, weights=weights, mirrored=not sector.mirrored)
    waves = (0, sector.sectors // 2)
    own, exchanged = (np.array([lowest_frequencies(each, n, COMPARED) for n in waves]) for each in (sector, other))
    return float(np.abs(exchanged / own - 1.0).max())


def _interpolated(solid: Solid, faces: Faces, low: Index, high: Index) -> Sector:
    """The face with more nodes follows the other, whose nodes carry a quadratic polynomial around each of its nodes."""
    mirrored = low.size > high.size
    left, right = (high, low) if mirrored else (low, high)
    turned = faces.axis.turned(solid.points[left], faces.sectors, -1 if mirrored else 1)
    weights, apart = _weights(turned, solid.points[right])
    distance = float(np.median(np.asarray(scipy.spatial.KDTree(turned).query(turned, k=2)[0])[:, 1]))
    away = float(np.max(scipy.spatial.KDTree(turned).query(solid.points[right])[0]))
    # A point between nodes is nearer to one of them than the widest distance of a node from the third of its neighbours.
    widest = float(np.max(np.asarray(scipy.spatial.KDTree(turned).query(turned, k=min(4, len(turned)))[0])[:, -1]))
    if apart > OFF * distance or away > widest:
        raise fault(
            f"The face {faces.high}",
            f"must lie on {faces.low} turned by 360°/{faces.sectors} about the axis",
            f"up to {1e3 * max(apart, away):.3g} mm away, where its nodes are {1e3 * distance:.3g} mm apart",
            "Check N, the axis, and which face is low.",
        )
    return Sector(solid, faces.sectors, left, right, faces.axis, weights, mirrored, apart)


def _weights(nodes: Array, points: Array) -> tuple[sparse.csr_array, float]:
    """Weights (points, nodes) of a displacement at points from those at nodes, and the largest distance [m] of a point from the
    surface through the nodes.

    Moving least squares: a quadratic polynomial in the tangent plane of the nearest nodes, weighted by exp(−(d/s)²), d the
    distance and s that of the middle one. Linear fields, and with them rigid motions, are exact. (Lancaster and Salkauskas 1981.)
    """
    number = min(NEIGHBOURS, len(nodes))
    distances, nearest = scipy.spatial.KDTree(nodes).query(points, k=number)
    distances, nearest = np.reshape(distances, (-1, number)), np.reshape(nearest, (-1, number))
    shares, apart = np.zeros((len(points), number)), 0.0
    for k, (point, away, around) in enumerate(zip(points, distances, nearest, strict=True)):
        scale = float(away[number // 2]) or 1.0
        if away[0] <= MATCH * scale:
            shares[k, 0] = 1.0
            continue
        centre = nodes[around].mean(axis=0)
        axes = np.linalg.svd(nodes[around] - centre)[2]
        x, y, height = ((nodes[around] - point) @ axes.T / scale).T
        weight = np.exp(-0.5 * (away / scale) ** 2)
        polynomial = np.column_stack([np.ones(number), x, y, x * x, x * y, y * y])
        inverse = np.linalg.pinv(weight[:, None] * polynomial, rcond=1e-8)
        shares[k] = inverse[0] * weight
        apart = max(apart, abs(float(shares[k] @ height)) * scale)
    rows = np.repeat(np.arange(len(points)), number)
    return sparse.csr_array((shares.ravel(), (rows, nearest.ravel())), shape=(len(points), len(nodes))), apart
