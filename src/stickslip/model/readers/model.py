"""A finite-element model in SI: sparse M, K, C with names of rows, coordinates and node sets.

Raw content of a model file, as every reader returns it: matrices, names, coordinates, sets.

Description of a model for `stickslip info`: size, mass, extent, first modes, rigid motions and warnings.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

from stickslip.model.readers.deck import ALONG, NodeAxes, along_model
from stickslip.model.readers.input_cards import Solids
from stickslip.model.readers.numbers import rows_with_entries
from stickslip.model.structure.factor import Factor, Singular
from stickslip.model.structure.matrices import Point, Sparse, check_names, freedoms, square_sparse, symmetric_sparse
from stickslip.model.structure.mesh_surface import Cells, outer_faces, thinned, triangulated
from stickslip.model.structure.modes import DENSE_SIZE, LowestModes, lowest_modes, rigid_motions
from stickslip.support.checks import SMALLEST, Array, Faults, Index, InputError, counted, fault, finite, first_of, nearest
from stickslip.support.units import UnitSystem

SYNONYMS = {
    "M": ("M", "MAA", "MAAX", "MGG", "MXX", "MHH", "MASS"),
    "K": ("K", "KAA", "KAAX", "KGG", "KXX", "KHH", "STIFFNESS"),
    "C": ("C", "BAA", "BAAX", "BGG", "BXX", "BHH", "DAMPING", "VISCOUS"),
}
"""Names under which programs write mass, stiffness and damping; the first that a file has counts."""
NEEDED = ("M", "K")

DIRECTIONS = {1: "x", 2: "y", 3: "z", 4: "rx", 5: "ry", 6: "rz"}
"""Names of the directions that programs number."""


@dataclass(frozen=True, eq=False)
class Content:
    """Matrices by their names in the file (dense or sparse), and what the file says about their rows.

    dofs: the name NODE.DIRECTION of each row, or none; nodes: coordinates, in the file's unit of length; sets: nodes by the name
    of a set; cells: corner nodes of the elements by kind, where known; notes: what the reader left out or took for granted;
    solids: elements with their materials, where stress can be recovered; turned: nodes along whose own axes rows are.
    """

    format: str
    matrices: Mapping[str, Any]
    dofs: tuple[str, ...] = ()
    nodes: Mapping[str, Point] = field(default_factory=dict)
    sets: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    cells: Cells = field(default_factory=dict)
    solids: Solids | None = None
    turned: NodeAxes = field(default_factory=NodeAxes)


def chosen(content: Content, variables: Mapping[Any, str], file: str, needed: Sequence[str] = NEEDED) -> dict[str, Any]:
    """The matrices M, K and, if there is one, C; `variables` names them, {"K": "KELAST"}, where usual names do not do."""
    unknown = [key for key in variables if key not in SYNONYMS]
    if unknown:
        raise fault("variables", "must name M, K or C", unknown[0])
    for letter, name in variables.items():
        if not isinstance(name, str):
            raise fault(f"variables, {letter}", "must be a name", name)
    matrices: dict[str, Any] = {}
    faults = []
    for letter, usual in SYNONYMS.items():
        names = (variables[letter],) if letter in variables else usual
        present = next((name for name in names if name in content.matrices), None)
        if present is not None:
            matrices[letter] = content.matrices[present]
        elif letter in needed or letter in variables:
            faults.append(f"{file}: matrix {names[0]} must be in the file, but is missing. {nearest(names[0], content.matrices)}")
    if faults:
        raise Faults(faults)
    return matrices


def located(pairs: Iterable[tuple[str, Point]]) -> dict[str, Point]:
    """Coordinates by node; one that stands twice must stand in one place."""
    nodes: dict[str, Point] = {}
    for node, point in pairs:
        located_once(nodes, node, point)
    return nodes


def located_once(nodes: dict[str, Point], node: str, point: Point) -> bool:
    """Add the coordinates of a node; whether they were there already."""
    known = node in nodes
    if nodes.setdefault(node, point) != point:
        raise fault(f"The coordinates of node {node}", "must be given once", [nodes[node], point], "Delete the wrong ones.")
    return known


def given_twice(count: int, file: str) -> tuple[str, ...]:
    """A note on nodes that a deck defines again at the same place; none without such nodes."""
    what = counted(count, "node is", "nodes are")
    return (f"{what} defined more than once in {file}, each time at the same place.",) if count else ()


def dof(node: object, direction: int) -> str:
    """NODE.DIRECTION of a numbered direction: 1 to 3 along x, y, z, 4 to 6 about them, others q0, q7, ... (scalar, modal)."""
    return f"{node}.{DIRECTIONS.get(direction, f'q{direction}')}"


CHECKS = {"M": symmetric_sparse, "K": symmetric_sparse, "C": square_sparse}
LETTERS = ("M", "K", "C")
NEARLY = 1e-6
"""Of a product of masses: what rounding in a file may add."""
ROTATIONS = ("rx", "ry", "rz")


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
    notes: what the reader left out or took for granted; solids: elements with their materials, where stress can be recovered;
    turned: whether rows along axes that nodes have of their own were turned; softening: what Ω² times was taken from K, kg;
    coriolis: what Coriolis forces add to C, N s/m.
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
    turned: bool = False
    softening: Sparse | None = None
    coriolis: Sparse | None = None

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
        of_nodes: dict[str, list[str]] = {}
        for name in self.dofs:
            node, _, direction = name.rpartition(".")
            of_nodes.setdefault(node, []).append(direction)
        return {node: tuple(directions) for node, directions in of_nodes.items()}

    @cached_property
    def located(self) -> tuple[tuple[str, ...], Array]:
        """The nodes that have rows and coordinates, and these, (nodes, 3), m."""
        names = tuple(node for node in self.directions if node in self.nodes)
        return names, np.array([self.nodes[node] for node in names]).reshape(len(names), 3)

    @cached_property
    def faces(self) -> Index:
        """The outer faces of the elements, (f, 4); a triangle repeats its last corner."""
        return outer_faces(self.cells)

    def covers(self, members: Iterable[str]) -> bool | None:
        """Whether nodes cover an area by the mesh, whose nodes between corners do not count: True where each belongs to a face
        with all corners among them, False where none does but each is joined to another by a side; None where it does not say.
        """
        numbers = np.array([int(name) for name in members if name.isdecimal()], dtype=np.int64)
        inside = np.isin(self.faces, numbers)
        corners = np.unique(self.faces[inside])
        covered = np.unique(self.faces[inside.all(axis=1)])
        if corners.size and covered.size == corners.size:
            return True
        following = np.roll(self.faces, -1, axis=1)
        along = inside & np.roll(inside, -1, axis=1) & (self.faces != following)
        joined = np.union1d(self.faces[along], following[along])
        return False if corners.size and not covered.size and joined.size == corners.size else None

    @cached_property
    def surface(self) -> Surface | None:
        """The outer surface of the mesh, thinned out where it is fine; None without elements, and where these are not those of
        the matrices: nodes without rows count as fixed, which most nodes of a mesh are not.
        """
        faces = self.faces
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
    named = chosen(content, variables, file)
    # Nastran's EXTSEOUT writes the null matrix of one row where there is no damping.
    if "C" in named and np.shape(named["C"]) == (1, 1) != np.shape(named["K"]) and not abs(named["C"]).sum():
        del named["C"]
    matrices = _checked({key: matrix for key, matrix in named.items() if key != "C" or own_damping}, file, names)
    size = matrices["M"].shape[0]
    if not size:
        raise fault("A model", "must have rows", "empty")
    heaviest = float(np.max(np.abs(matrices["M"].data), initial=0.0))
    if heaviest < SMALLEST:
        raise fault(f"{file}: M" if file else "M", "must have mass", f"{heaviest:g} at most", "Check its unit, and the export.")
    _refuse_negative_mass(f"{file}: M" if file else "M", matrices["M"])
    notes = [*content.notes, *_unused(content, named, names, size)]
    names = names or tuple(f"{row}.q" for row in range(1, size + 1))
    bare = np.flatnonzero(matrices["K"].diagonal() == 0.0)
    if file and 0 < bare.size < size:
        notes.append(f"K has no entry on the diagonal of {counted(bare.size, 'row')}: {first_of([names[row] for row in bare])}.")
    turned = along_model(matrices, names, content.turned)
    names, notes = turned.dofs, [*notes, *turned.notes]
    converted = matrices_in_si(turned.matrices, names, units)
    nodes: dict[str, Point] = {}
    for node, point in content.nodes.items():
        x, y, z = (units.metres * finite(f"The coordinates of node {node}", coordinate) for coordinate in point)
        nodes[node] = x, y, z
    pascals = units.newtons / units.metres**2
    solids = None if content.solids is None else replace(content.solids, pascals=pascals)
    # Shapes and stress of nodes whose rows have axes of their own would be wrong.
    cells, solids = ({}, None) if turned.left else (content.cells, solids)
    matrices_of = (converted["M"], converted["K"], names, converted.get("C"))
    made = Model(*matrices_of, nodes, content.sets, content.format, file, tuple(notes), cells, solids)
    return replace(made, turned=turned.any)


def levers(dofs: Sequence[str], units: UnitSystem) -> Array:
    """The factor of each degree of freedom: 1 for displacements, one length unit for rotations NODE.rx, ry, rz (in rad), (n,)."""
    return np.array([units.metres if dof.rpartition(".")[2] in ROTATIONS else 1.0 for dof in dofs])


def matrices_in_si(matrices: Mapping[str, Sparse], dofs: Sequence[str], units: UnitSystem) -> dict[str, Sparse]:
    """The matrices in SI. Rows of rotations carry a length more than those of displacements."""
    force_per_length = units.newtons / units.metres
    factors = {"M": units.kilograms, "K": force_per_length, "C": force_per_length * units.seconds}
    lever = sparse.diags_array(levers(dofs, units))
    return {name: sparse.csc_array(factors[name] * (lever @ matrix @ lever)) for name, matrix in matrices.items()}


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


def _unused(content: Content, named: Mapping[str, Any], names: Sequence[str], size: int) -> Iterator[str]:
    """Notes on structural damping (K4AA, K4XX, ... of Nastran), and on arrays as long as the model that could be its damping or
    its names, where it has none of these."""
    structural = [name for name, matrix in content.matrices.items() if name.upper().startswith("K4") and abs(matrix).sum()]
    yield from (f"{name}, structural damping of the file, is not used." for name in structural)
    if "C" in named and names:
        return
    taken = {id(matrix) for matrix in (*named.values(), *(content.matrices[name] for name in structural))}
    unused = [name for name, array in content.matrices.items() if id(array) not in taken and np.shape(array)[:1] == (size,)]
    if unused:
        yield f"Arrays as long as the model that are not used: {first_of(unused)}."


def _checked(matrices: Mapping[str, Any], file: str, names: Sequence[str]) -> dict[str, Sparse]:
    """Real square matrices, M and K symmetric, all of one size, that of the names if there are any."""
    checked, faults = {}, []
    entries = max(int(getattr(matrix, "nnz", np.size(matrix))) for matrix in matrices.values())
    try:
        check_names(tuple(names))
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
    size = checked["M"].shape[0]
    for letter, matrix in checked.items():
        if names and matrix.shape[0] != len(names):
            rule = f"must have {counted(matrix.shape[0], 'entry', 'entries')}"
            raise fault(f"dofs, the names of the rows of {letter},", rule, len(names))
        if matrix.shape[0] != size:
            raise fault(letter, f"must have the shape of M, {(size, size)}", matrix.shape)
    return checked


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


LIGHTEST, DENSEST = 20.0, 25e3
"""kg/m³ of the box round a body: a slender part in a wide box, osmium."""
SLOWEST, FASTEST = 0.05, 3e4
"""m/s, first elastic frequency times the length of the body: a thin whip, faster than sound in diamond."""
SMALLEST_FREQUENCY, LARGEST_FREQUENCY = 1e-3, 1e7
"""Hz; a node of a fine mesh alone may have a thousand times the largest."""


@dataclass(frozen=True, eq=False)
class Description:
    """mass: along x, y, z of unit translations, kg (nan without such directions); box: lengths along x, y, z, m, or none;
    modes: the lowest; odd: sentences on what to look at."""

    model: Model
    mass: Array
    box: Array | None
    modes: LowestModes | None
    odd: tuple[str, ...]

    def __str__(self) -> str:
        return "\n".join(lines(self))


def describe(model: Model, number: int = 10) -> Description:
    """Mass, extent and the lowest `number` modes of a model, and what is odd about it."""
    mass, box = translation_mass(model), extent(model)
    odd = list(model.notes)
    if box is not None and box.max() == 0.0:
        odd.append(f"All {len(model.nodes)} nodes lie at one point: coordinates are missing in the file, or cut off.")
    odd += [*_density(mass, box), *_spectrum(model), *_rows(model), *_viscous(model)]
    if indefinite_mass(model.M):
        odd.insert(0, "M has negative eigenvalues: check the sign and the export of the mass.")
        return Description(model, mass, box, None, tuple(odd))
    # Nodes without coordinates may be what seems to hold the body: the energy of the modes then decides what is rigid.
    rigid = rigid_motions(model.K, model.dofs, model.nodes)
    by_coordinates = rigid.shape[1] or all(node in model.nodes for node in model.directions)
    if model.turned:  # a deck gives axes to six digits: what K resists by less may be free
        by_coordinates = rigid.shape[1] == rigid_motions(model.K, model.dofs, model.nodes, ALONG).shape[1]
    modes = lowest_modes(model.M, model.K, number, rigid if by_coordinates else None)
    odd += _odd_modes(box, modes)
    return Description(model, mass, box, modes, tuple(odd))


def translation_mass(model: Model) -> Array:
    """rᵀMr of unit translations along x, y, z, kg, (3,); nodes that the file leaves out, as fixed ones, do not count.

    Nodes with negative numbers are internal ones of Abaqus, and those without a place beside others that have one the
    incompatible modes of CalculiX: they move relative to the others.
    """
    masses = []
    internal = {node for node in model.directions if node.startswith("-") or (model.nodes and node not in model.nodes)}
    for axis in "xyz":
        pairs = (name.rpartition(".") for name in model.dofs)
        r = np.array([float(direction == axis and node not in internal) for node, _, direction in pairs])
        masses.append(float(r @ (model.M @ r)) if r.any() else np.nan)
    return np.array(masses)


def extent(model: Model) -> Array | None:
    """The lengths of the box round all nodes along x, y, z, m, (3,)."""
    if len(model.nodes) < 2:
        return None
    return np.asarray(np.ptp(np.array(list(model.nodes.values())), axis=0))


def indefinite_mass(M: Sparse) -> bool:
    """Whether M has a negative eigenvalue."""
    scale = float(np.abs(M.diagonal()).max(initial=0.0))
    if np.any(M.diagonal() < -1e-12 * scale):
        return True
    if M.shape[0] <= DENSE_SIZE:
        return float(np.linalg.eigvalsh(M.toarray())[0]) < -1e-9 * scale * M.shape[0]
    heavy = np.flatnonzero(M.diagonal() > 1e-12 * scale)
    raised = M[heavy][:, heavy] + sparse.diags_array(1e-9 * M.diagonal()[heavy])  # so that rounding of zeros does not count
    try:
        return Factor(sparse.csc_array(raised)).negative > 0
    except Singular:
        return False


def implausible(model: Model) -> tuple[str, ...]:
    """What reading a model warns of: a density or a stiffness that no body has."""
    return tuple(_density(translation_mass(model), extent(model))) + tuple(_spectrum(model))


def _odd_modes(box: Array | None, modes: LowestModes | None) -> Iterator[str]:
    """A stiffness that has no modes, or negative ones, or one that no body of this extent has."""
    if modes is None:
        yield "K could not be factorised: rows without stiffness, or an export cut short."
        return
    if modes.negative:
        yield f"K has {counted(modes.negative, 'motion')} of negative stiffness: check its sign, or a prestress beyond buckling."
    elastic = modes.frequencies[modes.rigid :]
    if box is not None and box.max() > 0.0 and elastic.size and not SLOWEST <= elastic[0] * box.max() <= FASTEST:
        yield f"The first elastic mode at {elastic[0]:.4g} Hz of a body of {box.max():.4g} m is implausible: check the units."


def _rows(model: Model) -> Iterator[str]:
    """Rows without entries or mass, and nodes without coordinates where others have them."""
    stiff, heavy = (matrix.diagonal() != 0.0 for matrix in (model.K, model.M))
    if not np.all(stiff | heavy):
        yield f"{_some(model, ~(stiff | heavy))} neither mass nor stiffness: left out of the export, or fixed?"
    if np.any(stiff & ~heavy):
        yield f"{_some(model, stiff & ~heavy)} no mass: they follow the others, and give no mode."
    placed = (node for node, axes in model.directions.items() if not node.startswith("-") and not axes[0].startswith("q"))
    missing = [node for node in placed if node not in model.nodes]
    if model.nodes and missing:
        yield (
            f"{counted(len(missing), 'node')} without coordinates, {missing[0]} first: inner rows of elements, as the three "
            "of each C3D8I, or nodes that the file of coordinates lacks. Places are not looked for there."
        )


def _some(model: Model, chosen: Array) -> str:
    rows = np.flatnonzero(chosen)
    return f"{counted(rows.size, 'row')}, {model.dofs[rows[0]]} first, with"


def _viscous(model: Model) -> Iterator[str]:
    """A viscous damper takes energy out, and between two motions it acts both ways alike."""
    if model.C is None:
        return
    skew = model.C - model.C.T
    if skew.nnz and np.abs(skew.data).max() > 1e-8 * np.abs(model.C.data).max():
        yield "C is not symmetric: gyroscopic or circulatory terms, or an export cut short."
    if indefinite_mass(sparse.csc_array(0.5 * (model.C + model.C.T))):
        yield "C feeds energy in (its symmetric part has negative eigenvalues): check its sign."


def _density(mass: Array, box: Array | None) -> Iterator[str]:
    heaviest = float(np.nanmax(mass)) if not np.all(np.isnan(mass)) else 0.0
    if box is None or box.min() <= 0.0 or heaviest <= 0.0:
        return
    density = heaviest / float(np.prod(box))
    if not LIGHTEST <= density <= DENSEST:
        yield (
            f"{heaviest:.4g} kg in a box of {' x '.join(f'{length:.4g}' for length in box)} m is {density:.3g} kg/m³: "
            "implausible, check the units of the file."
        )


def _spectrum(model: Model) -> Iterator[str]:
    """√(K_ii/M_ii) bounds the frequencies of single nodes: far outside of what bodies have, the units are wrong."""
    mass, stiffness = model.M.diagonal(), model.K.diagonal()
    both = (mass > SMALLEST) & (stiffness > 0.0)
    if not both.any():
        return
    highest = float(np.sqrt(np.max(stiffness[both] / mass[both]))) / (2.0 * np.pi)
    if not SMALLEST_FREQUENCY <= highest <= 1e3 * LARGEST_FREQUENCY:
        yield f"The stiffest node has {highest:.3g} Hz on its own: the stiffness is implausible, check the units of the file."


def lines(description: Description) -> Iterator[str]:
    """The description as text."""
    model = description.model
    yield f"format            {model.format}"
    damping = "" if model.C is None else f", C {model.C.nnz}"
    yield f"rows              {model.size} (M {model.M.nnz}, K {model.K.nnz}{damping} entries)"
    yield f"nodes             {len(model.directions)}, {len(model.located[0])} with coordinates; rows {', '.join(model.dofs[:4])}"
    for name, nodes in model.sets.items():
        yield f"set               {name}: {counted(len(nodes), 'node')}"
    if description.box is not None:
        yield f"box               {' x '.join(f'{length:.6g}' for length in description.box)} m"
    if not np.all(np.isnan(description.mass)):
        masses = {axis: value for axis, value in zip("xyz", description.mass, strict=True) if not np.isnan(value)}
        label = f"mass along {' '.join(masses)}"
        yield f"{label:18s}{', '.join(f'{value:.6g}' for value in masses.values())} kg (without fixed nodes)"
    # M and K are made exactly symmetric as they are read.
    symmetric_damping = model.C is not None and not np.any((model.C - model.C.T).data)
    yield f"symmetric         {'M, K and C' if symmetric_damping else 'M and K'}"
    if description.modes is not None:
        definite = "positive semidefinite (rigid motions)" if description.modes.rigid else "positive definite"
        if description.modes.negative:
            definite = f"{counted(description.modes.negative, 'motion')} of negative stiffness"
        yield f"rigid motions     {description.modes.rigid}"
        yield f"K                 {definite}"
        yield f"first modes       {', '.join(f'{value:.7g}' for value in description.modes.frequencies)} Hz"
        yield f"modes             {description.modes.count}"
    for sentence in description.odd:
        yield f"note              {sentence}"
