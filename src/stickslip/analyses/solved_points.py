"""Solver states of a forced response, restored from its dataset, and what is computed from them.

Forced response at user-chosen frequencies: interpolated between solved points and checked, or solved.

Peaks of a quantity other than the computed one, searched and solved between the points of a forced response.

The deformed shape of a solved point: one harmonic of the displacement on the outer surface of the meshed bodies, and what a
dataset keeps of it, so that a report shows it without the problem.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.response_dataset import ContactRows, of_parts, parts, point_values
from stickslip.model.disks.tuned import FullDisk, TunedDisk
from stickslip.model.loads import excited_harmonics
from stickslip.model.problem import Problem
from stickslip.model.problem.meshed import with_all_forces
from stickslip.model.problem.systems import on_few_coordinates
from stickslip.model.structure.cyclic_reduction import rotation
from stickslip.model.structure.mesh_surface import SectorSurface, thinned, triangulated
from stickslip.results.schema import COORDINATES, SCHEMA, named, stamped, system_of
from stickslip.results.view import band_of, highest_peak, level_text, periods_of, spread
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.balance.energy import EnergyBalance
from stickslip.solve.balance.fourier import complex_harmonics, of_attribute, real_harmonics
from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.interpolation import SAME, Interpolation, Value
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.peaks.search import PeakSearch
from stickslip.support.checks import SMALLEST, Array, Index, InputError, between, fault, numbers, positive, whole
from stickslip.support.late import pd, xr
from stickslip.support.machine import one_blas_thread
from stickslip.support.outcome import Outcome
from stickslip.support.units import UnitSystem

SHAPE_FORCE = "shape_force"
"""The variable with the contact forces whose shapes are coordinates, of a finite-element model."""

KEPT = ("outcome", "frequency", "force_level", "response", "contact_force", "contact_motion")
"""The variables of a dataset that a point is made of, and is known again by."""

ROUNDINGS = 8.0
"""How many roundings the stored forces of a point may have gone through."""

MISMATCH = 1e-6
"""How far a kept point may miss the balance and its own motion. Those of a finite-element blade miss them by 1e-14; by 6e-11
where another processor reduced it; by 1e-4 where a friction coefficient differs by a thousandth."""

AMPLIFIED = 1e-5
"""How far Newton's method may take the motion of a kept point, where a resonance of little damping amplifies rounding."""

REMEDY = (
    "The results are of another problem: give the one that made them (of a study, dataset.attrs['study']; of a sample, with its "
    "start state), or run this one."
)


def with_shape_forces(dataset: xr.Dataset, problem: Problem) -> xr.Dataset:
    """Results with the contact forces whose shapes are coordinates, of a problem on a mesh."""
    if problem.mesh is None:
        return dataset
    forces, axes = ContactRows(problem).spread(problem.mesh.forces), ("contact", "direction", "contact_shape")
    words = "contact forces whose shapes on the mesh are coordinates"
    return dataset.assign({SHAPE_FORCE: named(axes, forces, words, "N")})


def on_its_coordinates(problem: Problem, dataset: xr.Dataset) -> Problem:
    """A problem on the coordinates on which a result was solved: those of a mesh have the shapes of its contact forces."""
    if problem.mesh is None or SHAPE_FORCE not in dataset:
        return problem
    return with_all_forces(problem, ContactRows(problem).collected(dataset[SHAPE_FORCE].to_numpy()))


class SolvedPoints:
    """The converged points of a dataset; `balance`: the one that solved them.

    Whether they belong to `problem` is checked with the points themselves: the stored motion must solve its balance.
    """

    def __init__(self, dataset: xr.Dataset, problem: Problem) -> None:
        for what, own in (("contact", [contact.name for contact in problem.contacts]), ("output", list(problem.output_names))):
            kept = [str(name) for name in dataset[what].to_numpy()]
            if kept != own:
                raise fault(f"The {what}s of the problem", f"must be those of the results, {kept}", own, REMEDY)
        self.rows = ContactRows(problem)
        problem = on_its_coordinates(problem, dataset)
        if "modes_to" in dataset.attrs:
            problem = on_few_coordinates(problem, 0.0, float(dataset.attrs["modes_to"]))
        self.problem = problem
        self.kept = {name: dataset[name].to_numpy() for name in KEPT}
        harmonics, samples = of_attribute(dataset.attrs["harmonics"]), int(dataset.attrs["samples"])
        self.balance = HarmonicBalance(problem, harmonics, samples, periods_of(dataset))

    def evaluation(self, case: int, point: int) -> Evaluation:
        """A point of the balance; refused where it is the solution of another problem."""
        place = self._place(case, point)
        motion = self._rows(self.kept["contact_motion"][place])
        # λ, what contacts carry beyond the springs of the stuck ones.
        forces = self._rows(self.kept["contact_force"][place]) - self.balance.stiffness[:, None] * motion
        omega, level = self.omega(self.kept["frequency"][place]), float(self.kept["force_level"][place[0]])
        found = self.balance.evaluate(Point(forces, omega, level))
        known = np.concatenate([motion, _real(self.kept["response"][place])])
        missed = max(found.error, relative_distance(found.w, known), relative_distance(found.w[:, 1:], known[:, 1:]))
        if not missed <= MISMATCH and not missed <= self._rounding(found, motion) and not self._returns(found, known):
            what = f"The share by which point {place[1]} of case {place[0]} misses the balance of the problem"
            raise fault(what, f"must be at most {MISMATCH:g}", float(f"{missed:.3g}"), REMEDY)
        return found

    def _rounding(self, found: Evaluation, motion: Array) -> float:
        """What rounding of the stored forces and motions may change of a motion: much near a resonance of very little damping."""
        spread = ROUNDINGS * np.finfo(float).eps
        forces = found.point.forces + spread * (np.abs(found.point.forces) + np.abs(self.balance.stiffness[:, None] * motion))
        return relative_distance(self.balance.evaluate(replace(found.point, forces=forces)).w, found.w)

    def _returns(self, found: Evaluation, known: Array) -> bool:
        """Whether Newton's method solves the balance beside a kept point."""
        solved = correct(self.balance, found.point, fixed("omega", found.point.omega))
        w = solved.evaluation.w
        return solved.converged and max(relative_distance(w, known), relative_distance(w[:, 1:], known[:, 1:])) <= AMPLIFIED

    def at_one_speed(self, case: int, point: int) -> tuple[HarmonicBalance, Evaluation]:
        """A point with the balance of the rotor speed it is at, or with that of all where the problem has no `speed`."""
        balance, found = self.balance, self.evaluation(case, point)
        if balance.problem.speed is None:
            return balance, found
        one = balance.problem.at_frequency(found.point.omega)
        alone = HarmonicBalance(one, balance.harmonics, balance.tables.E.shape[0])
        return alone, alone.evaluate(found.point)

    def omega(self, frequency: Any) -> float:
        """ω of the balance, rad/s, at a frequency of the excitation, Hz."""
        return 2.0 * np.pi * float(frequency) / self.balance.periods

    def point(self, case: int, point: int) -> Point:
        """λ with frequency and force level."""
        return self.evaluation(case, point).point

    def converged(self, case: int) -> list[Point]:
        """All converged points of a case, in the order of travel."""
        return [self.point(case, int(k)) for k in np.flatnonzero(self.kept["outcome"][case] == Outcome.CONVERGED)]

    def contact_motion(self, case: int, point: int) -> Array:
        """Relative displacement of every contact row, (rows, 2H+1), m."""
        return self.evaluation(case, point).w[: self.balance.rows]

    def whole_motion(self, case: int, point: int) -> Array:
        """Displacement of every degree of freedom, (n, 2H+1), m."""
        solved = self.point(case, point)
        y = self.balance.linear.whole_motion(solved.forces, solved.omega, solved.level)
        return self.balance.problem.structure.motion(y)

    def _place(self, case: int, point: int) -> tuple[int, int]:
        """The two numbers, checked."""
        outcomes = self.kept["outcome"]
        for name, number, size in zip(("case", "point"), (case, point), outcomes.shape, strict=True):
            if not 0 <= whole(name, number) < size:
                raise fault(name, f"must be a whole number from 0 to {size - 1}", number)
        outcome = Outcome(int(outcomes[case, point]))
        if outcome != Outcome.CONVERGED:
            raise fault(f"Point {point} of case {case}", "must have converged", outcome.sentence)
        return int(case), int(point)

    def _rows(self, parts: Array) -> Array:
        """Real storage (rows, 2H+1) from (contact, direction, harmonic, part)."""
        return _real(self.rows.collected(parts))


def relative_distance(found: Array, known: Array) -> float:
    """How far two motions are apart, relative to the known one."""
    return float(np.linalg.norm(found - known)) / max(float(np.linalg.norm(known)), SMALLEST)


def _real(parts: Array) -> Array:
    """Real storage (..., 2H+1) of (..., harmonic, part)."""
    return real_harmonics(of_parts(parts))


GIVEN = ("outcome", "residual", "response", "amplitude", "rms", "max_abs", "contact_motion", "contact_force")
"""The variables of the schema that are given at each frequency."""

OWN = {
    "solved": "1 where the balance was solved at this frequency, 0 where forces are interpolated",
    "error": "estimated error of the outputs relative to their amplitudes; 0 where solved",
}


def response_at(dataset: xr.Dataset, problem: Problem, frequencies: Any, tolerance: float) -> xr.Dataset:
    """What `ForcedResponse.at` says."""
    wanted = _within_the_band(dataset, frequencies)
    if not positive("tolerance", tolerance) < 0.1:
        raise fault("tolerance", "must lie between 0 and 0.1", tolerance)
    points = SolvedPoints(dataset, problem)
    with one_blas_thread():
        curves: list[list[list[Value]]] = []
        omegas = 2.0 * np.pi * wanted / points.balance.periods
        for case in range(dataset.sizes["case"]):
            solved = points.converged(case)
            curves.append(Interpolation(points.balance, solved, tolerance).values(omegas) if solved else [[] for _ in wanted])
    return _dataset(dataset, points, wanted, curves, tolerance)


def _within_the_band(dataset: xr.Dataset, frequencies: Any) -> Array:
    """Frequencies in Hz, checked; those that a curve has by rounding are its own. Where curves broke off, some have no values."""
    wanted = np.array([positive("A frequency", value) for value in np.atleast_1d(numbers("frequencies", frequencies))])
    if not wanted.size:
        raise InputError("frequencies must hold at least one value, but is empty.")
    known = dataset["frequency"].values
    if np.any(dataset["case_outcome"].values != Outcome.CONVERGED):
        known = np.append(known, dataset["linear_frequency"].values)  # from end to end of the band that was asked for
    low, high = np.nanmin(known), np.nanmax(known)
    for value in wanted.tolist():
        if not low * (1.0 - SAME) <= value <= high * (1.0 + SAME):
            what = f"must lie in the band of the response, from {low:g} to {high:g} Hz"
            raise fault("A frequency", what, value, "Solve a wider band.")
    return wanted


def _dataset(
    dataset: xr.Dataset, points: SolvedPoints, wanted: Array, curves: Sequence[list[list[Value]]], tolerance: float
) -> xr.Dataset:
    branches = max((len(values) for curve in curves for values in curve), default=0)
    shape = (len(curves), max(branches, 1), len(wanted))
    found: dict[str, NDArray[Any]] = {name: np.full((*shape, *dataset[name].shape[2:]), np.nan) for name in GIVEN}
    found |= {
        "outcome": np.zeros(shape, dtype=np.int8),
        "solved": np.zeros(shape, dtype=np.int8),
        "error": np.full(shape, np.nan),
    }
    for case, i in product(range(len(curves)), range(len(wanted))):
        if not curves[case][i]:
            ended = Outcome(int(dataset["case_outcome"][case]))
            found["outcome"][case, 0, i] = Outcome.EMPTY if ended == Outcome.CONVERGED else ended
        for branch, value in enumerate(curves[case][i]):
            place = case, branch, i
            found["solved"][place] = value.solved
            if value.evaluation is None:
                found["outcome"][place] = Outcome.NOT_CONVERGED
                continue
            found["outcome"][place] = Outcome.CONVERGED
            found["residual"][place], found["error"][place] = value.evaluation.error, value.error
            for name, values in point_values(points.balance, points.rows, [value.evaluation]).items():
                found[name][place] = values[0]
    variables = {v.name: (_dims(v.dims), found[v.name], dataset[v.name].attrs) for v in SCHEMA if v.name in found}
    variables |= {name: named(_dims(("case", "point")), found[name], words) for name, words in OWN.items()}
    coords: dict[str, Any] = {v.name: dataset[v.name] for v in COORDINATES}
    coords["frequency"] = ("frequency", wanted, dataset["frequency"].attrs)
    attrs = {name: dataset.attrs[name] for name in ("title", "study", "harmonics", "samples", "periods") if name in dataset.attrs}
    return stamped(xr.Dataset(variables, coords, attrs | {"tolerance": tolerance}), "response_at")


def _dims(dims: Sequence[str]) -> tuple[str, ...]:
    """Those of a point's variable, with the times a curve passes a frequency in place of points."""
    return ("case", "branch", "frequency", *dims[2:])


def refuse_unexcited(problem: Problem, measure: Measure) -> None:
    """Refuse peaks of the first harmonic where the load excites others."""
    excited = excited_harmonics(problem.forces)
    if excited and measure.kind == "amplitude" and 1 not in excited:
        raise InputError(
            "The peaks of a band must be of what the load excites, but they are of the amplitude of the first harmonic, and "
            f'the load excites {", ".join(f"harmonic {h}" for h in sorted(excited))}. Take measure="max_abs" or "rms".'
        )


def peaks_of_another(dataset: xr.Dataset, problem: Problem, measure: Measure) -> pd.DataFrame:
    """The peaks of a measure along every curve inside its band, as the table of `ForcedResponse.peaks`."""
    points = SolvedPoints(dataset, problem)
    balance = points.balance
    measure = measure.over(balance.periods)
    largest = measure.with_kind("max_abs")
    rows: list[dict[str, Any]] = []
    band = band_of(dataset)
    with one_blas_thread():
        energy = EnergyBalance(balance)
        for case, level in enumerate(dataset["force_level"].values.tolist()):
            solved = points.converged(case)
            search = PeakSearch(balance, Interpolation(balance, solved, 1e-3).curve() if solved else [])
            for output, name in enumerate(problem.output_names):
                found: list[dict[str, Any]] = []
                for point in search.peaks(output, measure).points:
                    evaluation, omega = point.evaluation, point.point.omega
                    if not band[0] <= balance.hertz(omega) <= band[1]:
                        continue
                    row = evaluation.w[balance.rows + output]
                    sizes = {str(one.kind): one.size(row, omega) / one.per(level) for one in (measure, largest)}
                    found.append({"frequency": balance.hertz(omega), **sizes, "loss_factor": energy.loss_factor(evaluation)})
                found.sort(key=lambda peak: -peak[measure.kind])
                rows += [{"force_level": level, "output": name, "peak": k} | peak for k, peak in enumerate(found)]
    sizes_of = list(dict.fromkeys([str(measure.kind), "max_abs"]))
    table = pd.DataFrame(rows, columns=["force_level", "output", "peak", "frequency", *sizes_of, "loss_factor"])
    return table.sort_values(["force_level", "output", "peak"], ignore_index=True)


MOST_KEPT = 4
"""Cases whose shapes a result keeps."""
MOST_OF_A_WHEEL = 12_000
"""Points of the surface of a whole disk. Of a tuned one with more, a sector is shown; of a full one fewer points are drawn."""
NO_SURFACE = (
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
        raise InputError(f"A deformed shape needs a problem with the surface of a mesh, but this one has none. {NO_SURFACE}")
    problem, periods = on_its_coordinates(problem, dataset), periods_of(dataset)
    points = SolvedPoints(dataset, problem)
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
    shapes = np.array([parts(each.displacement) for each in found])
    single, node = np.float32, ("shape_node", "space")
    words = "harmonic of the displacement in which the first output moves most, at the highest peak"
    notes = list(dict.fromkeys(each.note for each in found))
    return dataset.assign(
        shape_point=named(node, found[0].points.astype(single), "surface at rest", "m"),
        shape_triangle=(("shape_face", "corner_of_face"), found[0].triangles.astype(np.int32), {"units": "1"}),
        shape_displacement=named(("shape", *node, "part"), shapes.astype(single), words, "m"),
        shape_case=named(("shape",), np.array(cases), "case that the shape is of"),
    ).assign_attrs(
        shape_titles=[each.title for each in found], shape_note=notes[0] if len(notes) == 1 else [each.note for each in found]
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
            str(title), points, triangles, of_parts(u), note=str(note), system=system_of(dataset)
        )
        for case, title, note, u in zip(dataset["shape_case"].values, titles, notes, parts, strict=True)
    }
