"""Few coordinates of a sparse structure that contacts hold: no row of its mesh is kept.

With all contacts stuck the structure has the stiffness K' = K + BᵀK_cB, positive definite even where contacts alone hold a part.
Its one factor gives everything else. The lowest modes P, K'P = M P Ω², by block Lanczos, are complete by Sylvester's count. What
the modes above add is the residual flexibility G = K'⁻¹ − P Ω⁻² Pᵀ. The coordinates are

    x = P Ω⁻¹ η + V z,  VᵀK'V = 1,  PᵀM V = 0,

V holds the rigid motions of all parts, without which nothing of what contacts let go could be known; the modes without contacts,
since stiff contacts prevent what these deform; the static shapes G f of loads and outputs; and the shapes G Bᵀ λ of given contact
forces λ. On them the structure is projected (Ritz).

Sources: R. H. MacNeal, Comput. Struct. 1 (1971) 581-601, for residual flexibility; shapes of solved forces, kept by their energy:
proper orthogonal decomposition, L. Sirovich, Q. Appl. Math. 45 (1987) 561-571.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy import linalg, sparse
from scipy.sparse.csgraph import connected_components

from stickslip.model.structure.cyclic_reduction import mode_names
from stickslip.model.structure.factor import Pencil, Singular
from stickslip.model.structure.matrices import Report, Sparse, SparseStructure, Structure
from stickslip.model.structure.mesh_surface import MeshSurface
from stickslip.model.structure.modes import BLOCK, completed, eigenpairs_above, rigid_motions, with_unit_mass, without_resistance
from stickslip.model.structure.stress import StressRecovery
from stickslip.support.checks import Array, Index, InputError, counted

DEPENDENT = 1e-5
"""Length of a unit shape off the others below which it is a combination of them: far above the rounding of a solution, and far
below what `LOOSE` motions of a problem may store."""

NEGLIGIBLE = 1e-6
"""Share of an energy below which a shape is left out: that of the modes above in the work of a load, that of a shape of contact
forces off all others in the work of these forces. Outputs change by the square root of the product of two such shares."""

BEYOND = 1.0123
"""Of the frequency up to which modes without contacts are sought: a band may end at a computed mode or a simple multiple of it,
at which K − σM has no factor."""


class Coordinates(NamedTuple):
    """shapes (n, m), with shapesᵀK'shapes = 1; squares (m,): 1/ω² of each; modes: how many of them, the first, are modes."""

    shapes: Array
    squares: Array
    modes: int

    @property
    def beyond(self) -> Array:
        """V, the shapes beyond the modes, (n, m − modes)."""
        return self.shapes[:, self.modes :]


@dataclass(frozen=True, eq=False)
class StuckMesh:
    """A sparse structure with stuck contacts. B (rows, n), sparse, stiffness (rows,): contact rows and K_c; directions (k, n),
    sparse: of loads and outputs; modes_to, free_to: frequency up to which modes are kept, Hz, stuck and without contacts."""

    structure: SparseStructure
    B: Any
    stiffness: Array
    directions: Any
    modes_to: float
    free_to: float
    report: Report = lambda text: None

    def __getstate__(self) -> dict[str, Any]:
        """The factor does not travel to other processes; nor does what reports."""
        state = {key: value for key, value in self.__dict__.items() if key != "pencil"}
        return state | {"report": quiet}

    @cached_property
    def stuck(self) -> Sparse:
        """K', (n, n)."""
        return sparse.csc_array(self.structure.K + self.B.T @ (sparse.diags_array(self.stiffness) @ self.B))

    @cached_property
    def pencil(self) -> Pencil:
        """The factor of K'."""
        return self._held(Pencil(self.stuck, self.structure.M, self.report))

    def _held(self, pencil: Pencil) -> Pencil:
        """The factor without a shift, of a structure that is held."""
        try:
            pencil.at(0.0)
        except Singular:
            raise self._not_held() from None
        if pencil.negative or pencil.weak:
            raise self._not_held()
        return pencil

    def _not_held(self) -> InputError:
        """Names the motion of a part that resists least."""
        energies, turned = linalg.eigh(self.rigid.T @ (self.stuck @ self.rigid))
        led = ""
        if energies.size:
            led = f" A motion led by {self.structure.dofs[int(np.argmax(np.abs(self.rigid @ turned[:, 0])))]!r} is held least."
        return InputError(
            "The structure with all contacts stuck must have a positive definite stiffness, but a motion is held by nothing or "
            f"of negative stiffness.{led} Add a support or a contact with stiffness, or check the signs in K."
        )

    @cached_property
    def rigid(self) -> Array:
        """The rigid motions of all parts without their contacts, (n, motions)."""
        return rigid_motions(self.structure.K, self.structure.dofs, self.structure.nodes)

    @cached_property
    def free_modes(self) -> Array:
        """The elastic modes without contacts, φᵀMφ = 1, (n, modes); none where K − σM has no good factor.

        The factor at that frequency has as many negative pivots as there are modes, and (σM − K)⁻¹ finds them, as many equal ones
        as there may be. It is made before that of K', for memory.
        """
        M, shift = self.structure.M, (2.0 * np.pi * BEYOND * self.free_to) ** 2
        try:
            pencil = Pencil(self.structure.K, M, self.report).at(shift)
        except Singular:
            return np.zeros((self.structure.size, 0))
        rigid = with_unit_mass(M, self.rigid)
        number = pencil.negative - rigid.shape[1]
        if number <= 0 or pencil.weak:
            return np.zeros((self.structure.size, 0))
        self.report(f"{counted(number, 'elastic mode')} without contacts up to {self.free_to:.5g} Hz")
        pairs = eigenpairs_above(lambda loads: -pencil.solve(loads), M, number, known=rigid, block=max(BLOCK, number))
        return pairs.shapes[:, :number]

    @cached_property
    def bodies(self) -> list[tuple[str, Index, Array]]:
        """Name, rows and rigid motions (n, motions) of each body that contacts alone hold; stiffness or a node joins its rows."""
        nodes = [dof.rpartition(".")[0] for dof in self.structure.dofs]
        first = {node: row for row, node in reversed(list(enumerate(nodes)))}
        size = self.structure.size
        same_node = sparse.csr_array((np.ones(size), (np.arange(size), [first[node] for node in nodes])), shape=(size, size))
        _, labels = connected_components(sparse.csr_array(abs(self.structure.K) + same_node), directed=False)
        owners = labels[np.argmax(np.abs(self.rigid), axis=0)] if self.rigid.shape[1] else np.zeros(0, dtype=int)
        found = []
        for owner in dict.fromkeys(owners.tolist()):
            rows = np.flatnonzero(labels == owner)
            name = nodes[rows[0]]
            found.append((name.partition("/")[0] or name, rows, self.rigid[:, owners == owner]))
        return found

    @cached_property
    def modes(self) -> tuple[Array, Array]:
        """ω² and mass-normalised shapes (n, m) of all modes up to the frequency."""
        highest = (2.0 * np.pi * self.modes_to) ** 2
        pencil = Pencil(self.stuck, self.structure.M, self.report)
        number = pencil.at(highest).negative
        self.__dict__["pencil"] = self._held(pencil)
        self.report(f"{number} modes up to {self.modes_to:.5g} Hz; the factor takes {pencil.megabytes:.0f} MiB")
        if not number:
            return np.zeros(0), np.zeros((self.structure.size, 0))
        pairs = eigenpairs_above(pencil.solve, self.structure.M, number)
        if int(np.sum(pairs.squares <= highest)) < number:  # more equal ones than a block holds
            found = completed(pencil, pairs, number)
            pencil.at(0.0)
            return found.squares, found.shapes
        return pairs.squares[:number], pairs.shapes[:, :number]

    @cached_property
    def forces_of_modes(self) -> Array:
        """What the stuck contacts carry in each mode, of unit energy, (rows, modes): the first they let go of."""
        squares, shapes = self.modes
        return np.asarray(self.stiffness[:, None] * (self.B @ (shapes / np.sqrt(squares))))

    def flexible(self, loads: Array) -> Array:
        """G loads, (n, k): what the modes above add to the static motion."""
        squares, shapes = self.modes
        return np.asarray(self.pencil.solve(loads) - shapes @ ((shapes.T @ loads) / squares[:, None]))

    @cached_property
    def first_shapes(self) -> Array:
        """V without contact forces: rigid motions and modes without contacts off the modes, and the static shapes of loads and
        outputs, (n, k)."""
        loads, moved = self.directions.toarray().T, np.hstack([self.rigid, self.free_modes])
        squares, modes = self.modes
        beyond = moved - modes @ (modes.T @ (self.structure.M @ moved))
        static = self.flexible(loads)
        works = [np.einsum("ij,ij->j", first, second) for first, second in ((beyond, self.stuck @ beyond), (loads, static))]
        wholes = (
            np.einsum("ij,ij->j", moved, self.stuck @ moved),
            works[1] + np.sum((modes.T @ loads) ** 2 / squares[:, None], axis=0),
        )
        kept = [work > NEGLIGIBLE * whole for work, whole in zip(works, wholes, strict=True)]
        kept[0][: self.rigid.shape[1]] = True
        return self._orthonormal(np.hstack([beyond[:, kept[0]], static[:, kept[1]]]))

    def _orthonormal(self, shapes: Array, have: Array | None = None) -> Array:
        """Shapes that span the same off those one has, XᵀK'X = 1; those that are combinations of others are left out.

        have: (n, k), haveᵀK'have = 1.
        """
        pushed = np.asarray(self.stuck @ shapes)
        lengths = np.sqrt(np.einsum("ij,ij->j", shapes, pushed))
        shapes, pushed = (each[:, lengths > 0.0] / lengths[lengths > 0.0] for each in (shapes, pushed))
        for again in (True, False):  # the second time removes what rounding left of the first
            energies = shapes.T @ pushed
            if have is not None:
                along = have.T @ pushed
                shapes, energies = shapes - have @ along, energies - along.T @ along
            energies, turned = linalg.eigh(energies)
            kept = energies > DEPENDENT**2
            shapes = shapes @ (turned[:, kept] / np.sqrt(energies[kept]))
            pushed = np.asarray(self.stuck @ shapes) if again else pushed
        return np.asarray(shapes)

    def new_forces(self, have: Array, forces: Array, share: float = NEGLIGIBLE) -> Array:
        """Combinations (rows, k) of contact forces (rows, j) whose shapes are not among those one has, (n, m), haveᵀK'have = 1.

        The work of the forces on what is left of their shapes off the others must be more than a share of their largest.
        """
        forces = forces[:, np.any(forces != 0.0, axis=0)]
        if not forces.shape[1]:
            return forces
        shapes = self.flexible(np.asarray(self.B.T @ forces))
        pushed = np.asarray(self.stuck @ shapes)
        whole = float(np.max(np.einsum("ij,ij->j", shapes, pushed)))
        shapes = shapes - have @ (have.T @ pushed)
        pushed = np.asarray(self.stuck @ shapes)
        along = have.T @ pushed
        energies, turned = linalg.eigh(shapes.T @ pushed - along.T @ along)
        kept = energies > share * whole
        return np.asarray(forces @ (turned[:, kept] / np.sqrt(energies[kept])))

    def _shapes_of(self, forces: Array, have: Array) -> Array:
        """The shapes of contact forces (rows, k) beside those one has."""
        if not forces.shape[1]:
            return have
        return np.hstack([have, self._orthonormal(self.flexible(np.asarray(self.B.T @ forces)), have)])

    def coordinates(self, forces: Array) -> Coordinates:
        """The coordinates with the shapes of contact forces (rows, k)."""
        return self._natural(self._shapes_of(forces, self.first_shapes))

    def finer(self, coordinates: Coordinates, forces: Array) -> Coordinates:
        """The coordinates with all shapes of contact forces (rows, k), and with G M V, what the inertia of V deforms.

        At a frequency ω far below the modes left out, the motion is the series (G + ω² G M G + ...) p, of which V has the first
        term and G M V the second.
        """
        beyond = self._shapes_of(forces[:, np.any(forces != 0.0, axis=0)], coordinates.beyond)
        more = self._orthonormal(self.flexible(self.structure.M @ beyond), beyond)
        return self._natural(np.hstack([beyond, more]))

    def _natural(self, beyond: Array) -> Coordinates:
        """Modes, and combinations of V (n, k) with a frequency each."""
        squares, modes = self.modes
        beyond = beyond - modes @ ((self.structure.M @ modes).T @ beyond)  # what rounding left of them, grown with short shapes
        values, turned = linalg.eigh(_projected(self.structure.M, beyond), _projected(self.stuck, beyond))
        shapes = np.empty((len(beyond), squares.size + values.size))
        shapes[:, : squares.size] = modes / np.sqrt(squares)
        np.matmul(beyond, turned[:, ::-1], out=shapes[:, squares.size :])
        return Coordinates(shapes, np.concatenate([1.0 / squares, values[::-1]]), squares.size)

    def structure_on(self, coordinates: Coordinates, named: tuple[str, ...]) -> Structure:
        """The structure on few coordinates, with the motion of the `named` degrees of freedom."""
        shapes, whole = coordinates.shapes, self.structure
        K = _projected(whole.K, shapes)
        if self.rigid.shape[1]:  # those that K leaves free stay so: rounding would hold them
            K = without_resistance(K, shapes.T @ (self.stuck @ self.rigid))
        names = mode_names(shapes.shape[1])
        spread = [row @ shapes for row in whole.directions.values()]
        recovered = np.vstack([shapes[[whole.index(dof) for dof in named]], *spread, np.eye(len(names))])
        known = {dof.rpartition(".")[0] for dof in named}
        nodes = {name: point for name, point in whole.nodes.items() if name in known}
        few = Structure(
            np.diag(np.maximum(coordinates.squares, 0.0)),
            0.5 * (K + K.T),
            (*named, *whole.directions, *names),
            damping=whole.damping,
            nodes=nodes,
            sets=whole.sets,
            mesh_points=whole.mesh_points,
            outlines=whole.outlines,
            shapes=recovered,
        )
        surfaces = tuple(self._surface(each, shapes, names) for each in whole.surfaces)
        return replace(few, surfaces=surfaces, stresses=tuple(self._stress(each, shapes, names) for each in whole.stresses))

    def _surface(self, surface: MeshSurface, shapes: Array, names: tuple[str, ...]) -> MeshSurface:
        moved = surface.recovery @ shapes[[self.structure.index(dof) for dof in surface.dofs]]
        return replace(surface, recovery=np.asarray(moved, dtype=np.float32), dofs=names)

    def _stress(self, recovery: StressRecovery, shapes: Array, names: tuple[str, ...]) -> StressRecovery:
        return replace(recovery, rows=recovery.rows @ shapes[[self.structure.index(dof) for dof in recovery.dofs]], dofs=names)


def _projected(matrix: Sparse, shapes: Array) -> Array:
    """XᵀAX, a few columns at a time: of a large mesh, products with all of them take as much memory as its factor."""
    columns = [slice(first, first + BLOCK) for first in range(0, max(shapes.shape[1], 1), BLOCK)]
    return np.hstack([shapes.T @ (matrix @ shapes[:, each]) for each in columns])


def quiet(text: str) -> None:
    """A report that nobody reads."""
