"""A problem on few coordinates of finite-element models whose contacts are many: no contact row is kept."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from stickslip.model.contact.point import Contact, stuck_stiffness
from stickslip.model.loads import Force, Output
from stickslip.model.problem.at_rest import Rest
from stickslip.model.problem.problem import Mesh, Problem
from stickslip.model.problem.speed import CentrifugalLoad
from stickslip.model.problem.systems import REACH
from stickslip.model.structure.matrices import Report, SparseStructure
from stickslip.model.structure.stuck_mesh import NEGLIGIBLE, StuckMesh, quiet
from stickslip.support.checks import Array, counted


def meshed_problem(
    structure: SparseStructure,
    contacts: Sequence[Contact],
    forces: Sequence[Force],
    outputs: Sequence[str | Output],
    title: str = "",
    *,
    modes_to: float,
    report: Report = quiet,
    **more: Any,
) -> Problem:
    """The problem of a sparse structure on the modes up to a frequency [Hz], rigid motions, modes without contacts up to
    the highest frequency that is balanced, and shapes of loads and outputs.

    more: as of a `Problem`. What the contacts deform beyond that is not known yet: `with_forces` adds it.
    """
    directions = [direction for contact in contacts for direction in contact.directions]
    # Of a load on the whole structure only the motion along it is known, not that of each of its degrees of freedom.
    spread = {f"rotation/{k}.load": force for k, force in enumerate(forces) if isinstance(force, CentrifugalLoad)}
    along = [force.coefficients for force in spread.values()]

    def counted_report(text: str) -> None:
        report(f"{counted(len(contacts), 'contact')}: {text}")

    structure = replace(structure, directions=dict(zip(spread, structure.rows(along).toarray(), strict=True)))
    loads = [force.coefficients for force in forces if not isinstance(force, CentrifugalLoad)]
    loads += [contact.normal for contact in contacts if contact.balanced and contact.normal is not None]
    loads += [Output.of(output).direction for output in outputs]
    others = [each.direction for name in ("mean_springs", "dashpots") for each in more.get(name, ())]
    named = _named(structure, [*directions, *loads, *others])
    rows = structure.rows(directions)
    reach = modes_to, modes_to / REACH  # stuck, and without contacts
    stuck = StuckMesh(structure, rows, stuck_stiffness(contacts), structure.rows([*loads, *along]), *reach, counted_report)
    known = stuck.new_forces(stuck.first_shapes, stuck.forces_of_modes)
    mesh = Mesh(stuck, named, known, stuck.coordinates(known))
    few = stuck.structure_on(mesh.coordinates, named)
    acting = [force for force in forces if not isinstance(force, CentrifugalLoad)]
    acting += [replace(force, direction=name) for name, force in spread.items()]
    return Problem(few, tuple(contacts), tuple(acting), tuple(outputs), title, modes_to=modes_to, mesh=mesh, **more)


def _named(structure: SparseStructure, directions: Iterable[Mapping[str, float]]) -> tuple[str, ...]:
    """The degrees of freedom that are kept or named by directions, in the order of the structure."""
    rows = {structure.index(dof) for direction in directions for dof in direction}
    rows |= {structure.index(dof) for dof in structure.kept}
    return tuple(structure.dofs[row] for row in sorted(rows))


def with_forces(problem: Problem, forces: Array, share: float = NEGLIGIBLE) -> Problem:
    """A problem of a mesh with the shapes of contact forces (rows, k) [N] of its solutions too, as far as it lacks them; share:
    of the work of the forces on their shapes, which what it may lack keeps below."""
    mesh = problem.mesh
    if mesh is None:
        raise ValueError("a problem without a mesh has all its shapes")
    known = np.hstack([mesh.forces, mesh.stuck.new_forces(mesh.coordinates.beyond, forces, share)])
    return with_all_forces(problem, known)


def promised(problem: Problem) -> Problem:
    """The problem for settings that are checked before the shapes of the contact forces of its solutions are found."""
    return problem if problem.mesh is None else replace(problem, mesh=replace(problem.mesh, solved=True))


def resting(problem: Problem, found: Callable[[Problem], Rest | None]) -> tuple[Problem, Rest | None]:
    """A problem, of a mesh with the shapes of its contact forces at rest too, and its contacts as they are `found` at rest."""
    rest = found(problem)
    while rest is not None and problem.mesh is not None:
        more = with_forces(problem, (rest.forces - problem.contact_stiffness * rest.motion)[:, None])
        if more.structure.size == problem.structure.size:
            break
        problem, rest = more, found(more)
    return problem, rest


def finer(problem: Problem, forces: Array) -> Problem:
    """A problem of a mesh that shows what it lacks where contacts carry `forces` (rows, k): with all of their shapes and what
    the inertia of its own deforms."""
    mesh = problem.mesh
    if mesh is None:
        raise ValueError("a problem without a mesh has all its shapes")
    return _on(problem, replace(mesh, coordinates=mesh.stuck.finer(mesh.coordinates, forces)))


def with_all_forces(problem: Problem, forces: Array) -> Problem:
    """A problem of a mesh with the shapes of these contact forces (rows, k), in the order in which they were found."""
    mesh = problem.mesh
    if mesh is None or np.array_equal(mesh.forces, forces):
        return problem
    return _on(problem, replace(mesh, forces=forces, coordinates=mesh.stuck.coordinates(forces), solved=True))


def _on(problem: Problem, mesh: Mesh) -> Problem:
    """The problem on other coordinates of its mesh."""
    few = mesh.stuck.structure_on(mesh.coordinates, mesh.named)
    return replace(problem, structure=replace(few, damping=problem.structure.damping), mesh=mesh)
