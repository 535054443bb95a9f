"""A finite-element model in SI: sparse M, K, C with names of rows, coordinates and node sets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from typing import Any, NamedTuple

import numpy as np

from stickslip.model.readers.content import NEEDED, Content, chosen
from stickslip.model.readers.conversion import matrices_in_si
from stickslip.model.readers.limits import rows_with_entries
from stickslip.model.readers.solids import Solids
from stickslip.model.structure.matrices import Point, check_names, freedoms
from stickslip.model.structure.mesh_surface import Cells, outer_faces, thinned, triangulated
from stickslip.model.structure.sparse import Sparse, square_sparse, symmetric_sparse
from stickslip.support.checks import SMALLEST, Array, Faults, Index, InputError, counted, fault, finite, first_of
from stickslip.support.units import UnitSystem

CHECKS = {"M": symmetric_sparse, "K": symmetric_sparse, "C": square_sparse}
LETTERS = ("M", "K", "C")
NEARLY = 1e-6
"""Of a product of masses: what rounding in a file may add."""
SHOWN = 5
"""Names that a note lists."""


class Surface(NamedTuple):
    """points: (p, 3), m; triangles: (t, 3), places among them; numbers: (p, 3), the rows of their displacements, −1 without."""

    points: Array
    triangles: Index
    numbers: Index


@dataclass(frozen=True, eq=False, repr=False)
class Model:
    """M q̈ + C q̇ + K q = p, sparse, SI.

    M, K: (n, n), symmetric; C: (n, n) or None; dofs: n names NODE.DIRECTION; nodes: coordinates of nodes, m, where known;
    sets: nodes by the name of a set; cells: corner nodes of elements by kind, where known; format, file: what it was read from;
    notes: what the reader left out or took for granted; solids: elements with their materials, where stress can be recovered.
    """

    M: Sparse
    K: Sparse
    dofs: tuple[str, ...]
    C: Sparse | None = None
    nodes: Mapping[str, Point] = field(default_factory=dict)
    sets: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    format: str = ""
    file: str = ""
    notes: tuple[str, ...] = ()
    cells: Cells = field(default_factory=dict)
    solids: Solids | None = None

    def __repr__(self) -> str:
        return f"Model {self.file!r}: {freedoms(self.dofs)}, {counted(len(self.nodes), 'node')} with coordinates"

    @property
    def size(self) -> int:
        return len(self.dofs)

    @cached_property
    def rows(self) -> dict[str, int]:
        """The row of each degree of freedom."""
        return {name: row for row, name in enumerate(self.dofs)}

    @cached_property
    def directions(self) -> dict[str, tuple[str, ...]]:
        """The directions that each node has, in the order of the rows."""
        found: dict[str, list[str]] = {}
        for name in self.dofs:
            node, _, direction = name.rpartition(".")
            found.setdefault(node, []).append(direction)
        return {node: tuple(directions) for node, directions in found.items()}

    @cached_property
    def located(self) -> tuple[tuple[str, ...], Array]:
        """The nodes that have rows and coordinates, and these, (nodes, 3), m."""
        names = tuple(node for node in self.directions if node in self.nodes)
        return names, np.array([self.nodes[node] for node in names]).reshape(len(names), 3)

    @cached_property
    def surface(self) -> Surface | None:
        """The outer surface of the mesh, thinned out where it is fine; None without elements, and where these are not those of
        the matrices: nodes without rows count as fixed, which most nodes of a mesh are not.
        """
        faces = outer_faces(self.cells)
        used = np.unique(faces)
        names = [str(node) for node in used.tolist()]
        if not names or not all(name in self.nodes for name in names):
            return None
        moving = sum(name in self.directions for name in names)
        if moving <= len(names) / 2:
            return None
        points = np.array([self.nodes[name] for name in names])
        kept, triangles = thinned(points, triangulated(np.searchsorted(used, faces)))
        numbers = np.array([[self.rows.get(f"{names[k]}.{axis}", -1) for axis in "xyz"] for k in kept.tolist()])
        return Surface(points[kept], triangles, numbers)

    @cached_property
    def fingerprint(self) -> str:
        """Hexadecimal digits that identify matrices and names."""
        digest = sha256("\n".join(self.dofs).encode())
        for matrix in (self.M, self.K, self.C):
            for part in () if matrix is None else (matrix.data, matrix.indices.astype(np.int64), matrix.indptr.astype(np.int64)):
                digest.update(np.ascontiguousarray(part).tobytes())
        return digest.hexdigest()


def model_of(
    content: Content, units: UnitSystem, variables: Mapping[Any, str], dofs: Sequence[str], file: str, own_damping: bool = True
) -> Model:
    """The model of a content, converted to SI; all faults of the matrices at once. own_damping: whether its C counts."""
    names = tuple(dofs) or content.dofs
    found = chosen(content, variables, file)
    if "C" in found and _is_placeholder(found["C"], found["K"]):
        del found["C"]
    matrices = _checked({key: matrix for key, matrix in found.items() if key != "C" or own_damping}, file, names)
    size = _common_size(matrices, names)
    if not size:
        raise fault("A model", "must have rows", "empty")
    heaviest = float(np.max(np.abs(matrices["M"].data), initial=0.0))
    if heaviest < SMALLEST:
        raise fault(f"{file}: M" if file else "M", "must have mass", f"{heaviest:g} at most", "Check its unit, and the export.")
    _refuse_negative_mass(f"{file}: M" if file else "M", matrices["M"])
    unused = _unused(content, found, names, size)
    names = names or tuple(f"{row}.q" for row in range(1, size + 1))
    structural = (f"{name}, structural damping of the file, is not used." for name in _structural(content))
    held_by_nothing = _no_stiffness(matrices["K"], names) if file else ()
    notes = (*content.notes, *structural, *unused, *held_by_nothing)
    converted = matrices_in_si(matrices, names, units)
    nodes = {node: _in_metres(node, point, units.metres) for node, point in content.nodes.items()}
    pascals = units.newtons / units.metres**2
    solids = None if content.solids is None else replace(content.solids, pascals=pascals)
    matrices_of = (converted["M"], converted["K"], names, converted.get("C"))
    return Model(*matrices_of, nodes, content.sets, content.format, file, notes, content.cells, solids)


def _refuse_negative_mass(what: str, mass: Sparse) -> None:
    """Refuse an entry larger than those on the diagonal allow: a mass is positive semidefinite, so m_ij² <= m_ii m_jj."""
    rows, columns = mass.nonzero()
    diagonal = mass.diagonal()
    too_large = mass[rows, columns] ** 2 > (1.0 + NEARLY) * diagonal[rows] * diagonal[columns]
    if np.any(too_large):
        row, column = (int(places[too_large][0]) for places in (rows, columns))
        shown = [float(mass[place]) for place in ((row, row), (row, column), (column, column))]
        raise fault(
            f"{what}[{row}, {column}]",
            "must not exceed what the diagonal of its row and column allows",
            shown,
            "Check the file for damage.",
        )


def _no_stiffness(stiffness: Sparse, names: Sequence[str]) -> tuple[str, ...]:
    """A note on rows without stiffness of their own."""
    rows = np.flatnonzero(stiffness.diagonal() == 0.0)
    few = [names[row] for row in rows[:SHOWN].tolist()]
    said = (
        f"K has no entry on the diagonal of {counted(rows.size, 'row')}: {', '.join(few)}{', ...' if rows.size > SHOWN else ''}."
    )
    return (said,) if 0 < rows.size < len(names) else ()


def _unused(content: Content, found: Mapping[str, Any], names: Sequence[str], size: int) -> tuple[str, ...]:
    """A note on arrays as long as the model that could be its damping or its names, where it has none of these."""
    if "C" in found and names:
        return ()
    taken = {id(matrix) for matrix in (*found.values(), *(content.matrices[name] for name in _structural(content)))}
    unused = [name for name, array in content.matrices.items() if id(array) not in taken and np.shape(array)[:1] == (size,)]
    return (f"Arrays as long as the model that are not used: {first_of(unused, SHOWN)}.",) if unused else ()


def _is_placeholder(damping: Any, stiffness: Any) -> bool:
    """Whether the damping is the null matrix of one row that Nastran's EXTSEOUT writes where there is none."""
    return np.shape(damping) == (1, 1) != np.shape(stiffness) and not abs(damping).sum()


def _structural(content: Content) -> list[str]:
    """Matrices of structural damping as Nastran calls them: K4AA, K4XX, ..."""
    return [name for name, matrix in content.matrices.items() if name.upper().startswith("K4") and abs(matrix).sum()]


def _in_metres(node: str, point: Point, metres: float) -> Point:
    x, y, z = (metres * finite(f"The coordinates of node {node}", coordinate) for coordinate in point)
    return x, y, z


def _checked(matrices: Mapping[str, Any], file: str, names: Sequence[str]) -> dict[str, Sparse]:
    checked, faults = {}, []
    entries = max(_entries(matrix) for matrix in matrices.values())
    try:
        check_names(names)
    except InputError as error:
        faults.append(str(error))
    for letter, matrix in matrices.items():
        try:
            rows_with_entries(letter, max(np.shape(matrix), default=0), entries)
            checked[letter] = CHECKS[letter](letter, _real(letter, matrix))
        except InputError as error:
            faults.append(f"{file}: {error}" if file else str(error))
    if faults:
        raise Faults(faults)
    return checked


def _entries(matrix: Any) -> int:
    """How many entries a matrix stores."""
    return int(getattr(matrix, "nnz", np.size(matrix)))


def _real(letter: str, matrix: Any) -> Any:
    """The matrix in floating point; a complex one only where nothing is imaginary."""
    kind = getattr(matrix, "dtype", np.asarray(matrix).dtype if np.ndim(matrix) else None)
    if kind is None or kind.kind not in "fiubc":
        raise fault(letter, "must hold real numbers", str(kind), "Convert it to numbers.")
    if kind.kind == "c":
        imaginary = matrix.imag
        if abs(imaginary).max():
            raise fault(letter, "must hold real numbers", str(kind), "Hysteretic damping in K? Give it as viscous C.")
        matrix = matrix.real
    return matrix.astype(float)


def _common_size(matrices: Mapping[str, Sparse], names: Sequence[str]) -> int:
    size = matrices[NEEDED[0]].shape[0]
    for letter, matrix in matrices.items():
        if names and matrix.shape[0] != len(names):
            raise fault(
                f"dofs, the names of the rows of {letter},",
                f"must have {counted(matrix.shape[0], 'entry', 'entries')}",
                len(names),
            )
        if matrix.shape[0] != size:
            raise fault(letter, f"must have the shape of M, {(size, size)}", matrix.shape)
    return int(size)
