"""The deformed shape of a solved point: one harmonic of the displacement on the outer surface of the meshed bodies, and what a
dataset keeps of it, so that a report shows it without the problem.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.solved_points import SolvedPoints
from stickslip.model.disks.tuned import FullDisk, TunedDisk
from stickslip.model.loads import excited_harmonics
from stickslip.model.problem import Problem
from stickslip.model.structure.cyclic_reduction import rotation
from stickslip.model.structure.mesh_surface import SectorSurface, thinned, triangulated
from stickslip.results.representative import spread
from stickslip.results.shown_units import system_of
from stickslip.results.view import highest_peak, level_text, periods_of
from stickslip.solve.balance.fourier import complex_harmonics
from stickslip.support.checks import Array, Index, InputError, between, fault
from stickslip.support.late import xr
from stickslip.support.units import UnitSystem

MOST_KEPT = 4
"""Cases whose shapes a result keeps."""
MOST_OF_A_WHEEL = 12_000
"""Points of the surface of a whole disk. Of a tuned one with more, a sector is shown; of a full one fewer points are drawn."""
REMEDY = (
    "Ready rigs with finite elements have one (single_blade, octopus_blisk), and models read with the elements of their deck "
    "(CalculiX, Abaqus, Nastran, Ansys) whose nodes are those of the matrices and move along x, y, z."
)


@dataclass(frozen=True, eq=False)
class SurfaceMotion:
    """u(t) = Re displacement exp(i h ω t): points (p, 3) at rest [m], triangles (t, 3), places among the points, displacement
    (p, 3) complex [m]. system: the units to show.
    """

    title: str
    points: Array
    triangles: Index
    displacement: NDArray[np.complex128]
    note: str = field(default="", kw_only=True)
    system: UnitSystem | None = field(default=None, kw_only=True)

    @cached_property
    def amplitude(self) -> Array:
        """The largest displacement of each point in the period, (p,) [m]: its path is an ellipse with the longer half axis a,
        a² = ½ (|u|² + |u·u|).
        """
        u = self.displacement
        return np.asarray(np.sqrt(0.5 * (np.sum(np.abs(u) ** 2, axis=1) + np.abs(np.sum(u**2, axis=1)))))


def has_surface(problem: Problem) -> bool:
    """Whether a problem has a surface to draw."""
    return bool(problem.structure.surfaces) or (isinstance(problem, TunedDisk | FullDisk) and problem.surface is not None)


def deformed_shape(dataset: xr.Dataset, problem: Problem, case: int, point: int, harmonic: int | None = None) -> SurfaceMotion:
    """The surfaces of all meshed bodies at a solved point; of a tuned disk all sectors, or the first alone where they are large.

    harmonic: of the excitation, that in which the first output moves most unless given.

    Sector j (0, 1, ...) of a tuned disk is that of the first one, turned, and late by j EO/N periods of the excitation; of a full
    disk each sector has its own motion.
    """
    if not has_surface(problem):
        raise InputError(f"A deformed shape needs a problem with the surface of a mesh, but this one has none. {REMEDY}")
    points, periods = SolvedPoints(dataset, problem), periods_of(dataset)
    harmonics = complex_harmonics(points.whole_motion(case, point))
    if harmonic is None:
        first = points.kept["response"][case, point, 0, periods::periods]
        harmonic = 1 + int(np.argmax(np.linalg.norm(first, axis=-1)))
    q = harmonics[:, periods * between("harmonic", harmonic, 1, (harmonics.shape[1] - 1) // periods)]
    hertz = float(dataset["frequency"].values[case, point])
    title = f"{problem.heading}, {level_text(dataset, case)}, {hertz:.6g} Hz"
    title += f", harmonic {harmonic}" if harmonic > 1 or excited_harmonics(problem.forces) != {1} else ""
    if isinstance(problem, TunedDisk) and problem.surface is not None:
        return replace(_of_a_tuned_disk(problem, problem.surface, q, harmonic, title), system=system_of(dataset))
    if isinstance(problem, FullDisk) and problem.surface is not None:
        return replace(_of_a_full_disk(problem, problem.surface, q, title), system=system_of(dataset))
    rows = {dof: row for row, dof in enumerate(problem.structure.dofs)}
    surfaces = problem.structure.surfaces
    first = np.cumsum([0, *(len(surface.points) for surface in surfaces)])
    return SurfaceMotion(
        title,
        np.concatenate([surface.points for surface in surfaces]),
        np.concatenate([surface.triangles + start for surface, start in zip(surfaces, first[:-1], strict=True)]),
        np.concatenate([surface.motion(q[[rows[dof] for dof in surface.dofs]]) for surface in surfaces]),
        system=system_of(dataset),
    )


def _of_a_tuned_disk(
    disk: TunedDisk, surface: SectorSurface, q: NDArray[np.complex128], harmonic: int, title: str
) -> SurfaceMotion:
    sectors, order = disk.sectors, harmonic * disk.engine_order
    n, shape, triangles = order % sectors, surface.wave(q, order, sectors), triangulated(surface.quads)
    wave = f"nodal diameter {min(n, sectors - n)}"
    if len(surface.points) * sectors > MOST_OF_A_WHEEL:
        return SurfaceMotion(title, surface.points, triangles, shape, note=f"one of {sectors} sectors, {wave}")
    late = np.exp(-2j * np.pi * order * np.arange(sectors) / sectors)
    return _wheel(title, surface.points, triangles, late[:, None, None] * shape, f"{sectors} sectors, {wave}")


def _of_a_full_disk(disk: FullDisk, surface: SectorSurface, q: NDArray[np.complex128], title: str) -> SurfaceMotion:
    """Of each sector its own motion. A sector whose damper is missing has its other degrees of freedom, which stand first."""
    size, names = surface.motions[0].shape[2], disk.structure.dofs
    rows = [[k for k, dof in enumerate(names) if dof.startswith(f"{j}/")][:size] for j in range(1, disk.sectors + 1)]
    if len({tuple(names[k].partition("/")[2] for k in row) for row in rows}) > 1 or len(rows[0]) < size:
        raise fault("The degrees of freedom of a full disk", "must be those of TunedDisk.full() to have a shape", names[:3])
    shapes = surface.shapes(q[np.array(rows)])
    kept, triangles = thinned(surface.points, triangulated(surface.quads), MOST_OF_A_WHEEL // disk.sectors)
    return _wheel(title, surface.points[kept], triangles, shapes[:, kept], f"{disk.sectors} sectors, each with its own motion")


def _wheel(title: str, points: Array, triangles: Index, shapes: NDArray[np.complex128], note: str) -> SurfaceMotion:
    """All sectors together; points (p, 3) [m] of the first one, shapes (N, p, 3) [m] each in the axes of its sector."""
    turns = np.array([rotation(len(shapes), j) for j in range(len(shapes))])
    return SurfaceMotion(
        title,
        (points @ turns.swapaxes(1, 2)).reshape(-1, 3),
        np.concatenate([triangles + j * len(points) for j in range(len(shapes))]),
        (shapes @ turns.swapaxes(1, 2)).reshape(-1, 3),
        note=note,
    )


def with_shapes(dataset: xr.Dataset, problem: Problem) -> xr.Dataset:
    """A response with the deformed shapes at the highest peaks of up to four cases; as it is where nothing has a surface.

    Gains, in single precision, shape_point (shape_node, space) [m] and shape_displacement (shape, shape_node, space, part) [m],
    shape_triangle, and shape_case, the case that each shape is of; attributes shape_titles and shape_note.
    """
    if not has_surface(problem):
        return dataset
    peaks = {case: peak for case in range(dataset.sizes["case"]) if (peak := highest_peak(dataset, case)) is not None}
    if not peaks:
        return dataset
    cases = [list(peaks)[k] for k in spread(len(peaks), MOST_KEPT)]
    found = [deformed_shape(dataset, problem, case, peaks[case].point) for case in cases]
    parts = np.array([np.stack([each.displacement.real, each.displacement.imag], axis=-1) for each in found])
    single, node = np.float32, ("shape_node", "space")
    words = "harmonic of the displacement in which the first output moves most, at the highest peak"
    notes = list(dict.fromkeys(each.note for each in found))
    return dataset.assign(
        shape_point=(node, found[0].points.astype(single), {"units": "m", "long_name": "surface at rest"}),
        shape_triangle=(("shape_face", "corner_of_face"), found[0].triangles.astype(np.int32), {"units": "1"}),
        shape_displacement=(("shape", *node, "part"), parts.astype(single), {"units": "m", "long_name": words}),
        shape_case=(("shape",), np.array(cases), {"units": "1", "long_name": "case that the shape is of"}),
    ).assign_attrs(
        shape_titles=[each.title for each in found],
        shape_note=notes[0] if len(notes) == 1 else [each.note for each in found],
    )


def has_shapes(dataset: xr.Dataset) -> bool:
    """Whether a result keeps deformed shapes."""
    return "shape_displacement" in dataset


def kept_shapes(dataset: xr.Dataset) -> dict[str, SurfaceMotion]:
    """The shapes that a result keeps, by their force level."""
    points, triangles, parts = (dataset[f"shape_{name}"].values for name in ("point", "triangle", "displacement"))
    titles = np.atleast_1d(dataset.attrs["shape_titles"])
    notes = np.broadcast_to(np.atleast_1d(dataset.attrs["shape_note"]), titles.shape)
    return {
        level_text(dataset, int(case)): SurfaceMotion(
            str(title), points, triangles, u[..., 0] + 1j * u[..., 1], note=str(note), system=system_of(dataset)
        )
        for case, title, note, u in zip(dataset["shape_case"].values, titles, notes, parts, strict=True)
    }
