"""One sector of a bladed disk in the files of several programs, as each numbers, orders, halves and holds its rows.

The sector is that of the template "bladed_disk" on a coarse mesh, in mm, t, s. Numbers of nodes have gaps and do not follow the
mesh. Nodes of the bore are held: most programs leave their rows out, Abaqus puts 1e36 on the diagonal of K.
"""

from dataclasses import dataclass

import numpy as np
from readers.nastran_files import dmig, op4_text
from scipy import sparse

from stickslip.model.structure.cyclic_reduction import craig_bampton
from stickslip.model.structure.solid import solid
from tools import template_files

HELD = 1e36
"""What Abaqus adds to the diagonal of K where a boundary condition holds a row."""
MODES = 40
"""Fixed-interface modes of a superelement."""
SCALAR = 9_000_001
"""Number of the first scalar point of a superelement of Nastran."""


@dataclass(frozen=True, eq=False)
class SectorFiles:
    """K, M: of all rows, sparse, N/mm and t; points: (nodes, 3), mm; ids: numbers of the nodes; held: rows that are fixed; sets:
    places of nodes by the name of a set; modes: rows behind those of the nodes, which are numbered `places`."""

    K: sparse.csc_array
    M: sparse.csc_array
    points: np.ndarray
    ids: np.ndarray
    held: np.ndarray
    sets: dict
    places: tuple

    def free(self, order=None):
        """K, M and the places (node, direction) of the rows that are not held, in an order of their own."""
        rows = np.flatnonzero(~self.held)
        rows = rows if order is None else rows[order(rows.size)]
        return self.K[rows][:, rows], self.M[rows][:, rows], [self.places[row] for row in rows]

    @property
    def ascending(self):
        """An order of the free rows by node and direction."""
        own = [place for place, held in zip(self.places, self.held, strict=True) if not held]
        return lambda size: np.array(sorted(range(size), key=own.__getitem__))

    def nodes(self):
        """Number and coordinates of each node."""
        return zip(self.ids.tolist(), self.points.tolist(), strict=True)

    def members(self, name):
        return self.ids[self.sets[name]].tolist()


def sector():
    """The sector of the template with the elements' rows at the bore."""
    body = solid(template_files.sector_mesh(cells=1))
    points = body.points / template_files.MM
    held = np.hypot(points[:, 0], points[:, 1]) < template_files.RADII["bore"] + 1e-6
    chosen = template_files.sector_sets()
    sets = {name: np.array([k for k, point in enumerate(points) if on(point)]) for name, on in chosen.items()}
    sets["TIP"] = np.array([int(np.linalg.norm(points - [template_files.RADII["tip"], 0.0, 0.0], axis=1).argmin())])
    ids = 1000 + 7 * np.random.default_rng(5).permutation(len(points))
    places = [(int(node), axis) for node in ids for axis in (1, 2, 3)]
    rows = body.numbers.ravel()
    K, M = (sparse.csc_array(1e-3 * matrix[rows][:, rows]) for matrix in (body.K, body.M))
    return SectorFiles(K, M, points, ids, np.repeat(held, 3), sets, tuple(places))


def superelement(whole):
    """Reduced to the nodes of all sets and modes, whose places are scalar points."""
    K, M, places = whole.free()
    kept = {node for name in whole.sets for node in whole.members(name)}
    names = {f"{node}.{axis}": row for row, (node, axis) in enumerate(places) if node in kept}
    reduced = craig_bampton(1e3 * M, 1e3 * K, names, MODES).structure
    points = tuple(places[row] for row in names.values())
    here = np.isin(whole.ids, list(kept))
    number = np.cumsum(here) - 1
    return SectorFiles(
        sparse.csc_array(1e-3 * reduced.K),
        sparse.csc_array(1e-3 * reduced.M),
        whole.points[here],
        whole.ids[here],
        np.zeros(len(reduced.dofs), dtype=bool),
        {name: number[nodes] for name, nodes in whole.sets.items()},
        (*points, *((SCALAR + k, 0) for k in range(MODES))),
    )


def lower(matrix):
    """Rows, columns and values of the lower triangle, column by column."""
    entries = sparse.tril(sparse.csc_array(matrix)).tocoo()
    return zip(*entries.coords, entries.data, strict=True)


def deck(sector):
    """Nodes and sets as Abaqus and CalculiX read them."""
    lines = ["*NODE, NSET=NALL", *(f"{node}, {x:.12e}, {y:.12e}, {z:.12e}" for node, (x, y, z) in sector.nodes())]
    for name in sector.sets:
        members = sector.members(name)
        lines.append(f"*NSET, NSET={name}")
        lines += [", ".join(map(str, members[k : k + 8])) + "," for k in range(0, len(members), 8)]
    return "\n".join(lines) + "\n"


def table(sector, with_points=True):
    """A table of nodes with their sets, and with their coordinates."""
    of = {node: " ".join(name for name in sector.sets if node in sector.members(name)) for node in sector.ids.tolist()}
    if not with_points:
        return "node,set\n" + "".join(f"{node},{names}\n" for node, names in of.items() if names)
    return "node,x,y,z,set\n" + "".join(f"{node},{x!r},{y!r},{z!r},{of[node]}\n" for node, (x, y, z) in sector.nodes())


def archive(sector):
    """Nodes and components as CDWRITE writes them."""
    lines = ["/PREP7", "NBLOCK,6,SOLID", "(3i9,6e21.13e3)"]
    for node, point in sector.nodes():
        lines.append(f"{node:9d}{0:9d}{0:9d}" + "".join(f"{_exponent(f'{value:.13E}'):>21s}" for value in point))
    lines.append("N,R5.3,LOC,       -1,")
    for name in sector.sets:
        members = sector.members(name)
        lines += [f"CMBLOCK,{name},NODE,{len(members):8d}", "(8i10)"]
        lines += ["".join(f"{node:10d}" for node in members[k : k + 8]) for k in range(0, len(members), 8)]
    return "\n".join([*lines, "FINISH"]) + "\n"


def _exponent(text):
    """With three digits in the exponent."""
    return f"{text[:-2]}0{text[-2:]}"


def bulk(sector):
    """GRID entries in large fields, held nodes with SPC in their last field."""
    held = {node for (node, _), fixed in zip(sector.places, sector.held, strict=True) if fixed}
    lines = []
    for node, (x, y, z) in sector.nodes():
        lines.append(f"GRID*   {node:16d}{'':16s}{x:16.9E}{y:16.9E}")
        lines.append(f"*       {z:16.9E}{'':16s}{'123456' if node in held else '456':>16s}")
    return "\n".join(lines) + "\n"


def calculix(sector, folder):
    """One triangle with a line for each entry; held rows are missing."""
    K, M, places = sector.free(sector.ascending)
    pattern = sparse.tril(abs(K) + abs(M)).tocoo()
    for ending, matrix in (("sti", K), ("mas", M)):
        rows = np.column_stack([pattern.col + 1, pattern.row + 1, sparse.csr_array(matrix)[pattern.row, pattern.col]])
        np.savetxt(folder / f"wheel.{ending}", rows, fmt=("%d", "%d", "%.15e"))
    (folder / "wheel.dof").write_text("".join(f"{node}.{axis}\n" for node, axis in places))
    (folder / "wheel.inp").write_text(deck(sector))
    return 'model = "wheel.inp"'


def abaqus(sector, folder):
    """The lower triangle by nodes; all rows are there, and K holds those of boundary conditions."""
    for kind, matrix, step in (
        ("STIF", sector.K + HELD * sparse.diags_array(sector.held.astype(float)), 1),
        ("MASS", sector.M, 1),
    ):
        places = sector.places
        lines = [f"{places[i][0]},{places[i][1]}, {places[j][0]},{places[j][1]}, {value:22.15e}" for i, j, value in lower(matrix)]
        (folder / f"wheel_{kind}{step}.mtx").write_text("\n".join(lines) + "\n")
    (folder / "wheel.inp").write_text(deck(sector))
    return 'model = "wheel_STIF1.mtx"'


def abaqus_substructure(sector, folder):
    """*USER ELEMENT with its nodes in comments; every row of a node stands by itself, modes as nodes of their own."""
    K, M, places = sector.free()
    nodes = list(dict.fromkeys(node for node, _ in places))
    lines = [f"*USER ELEMENT, NODES={len(nodes)}, LINEAR", "** ELEMENT NODES"]
    lines += ["** " + ", ".join(map(str, nodes[k : k + 8])) for k in range(0, len(nodes), 8)]
    lines.append("1, 2, 3")
    first = next((k for k, node in enumerate(nodes, start=1) if node >= SCALAR), None)
    if first is not None:
        lines.append(f"{first}, 1")
    for kind, matrix in (("STIFFNESS", K), ("MASS", M)):
        lines.append(f"*MATRIX, TYPE={kind}")
        packed = matrix.toarray()[np.tril_indices(matrix.shape[0])]
        lines += [", ".join(f"{value:.16e}" for value in packed[k : k + 4]) for k in range(0, packed.size, 4)]
    (folder / "wheel.mtx").write_text("\n".join(lines) + "\n")
    (folder / "wheel.inp").write_text(deck(sector))
    return 'model = "wheel.mtx"'


def nastran_dmig(sector, folder):
    """A symmetric DMIG of the a-set in large fields with the grid points; sets stand in a table."""
    K, M, places = sector.free(sector.ascending)
    text = dmig({"KAAX": K.toarray(), "MAAX": M.toarray()}, "large", places=places)
    (folder / "wheel.pch").write_text(text + bulk(sector))
    (folder / "sets.csv").write_text(table(sector, with_points=False))
    return 'model = "wheel.pch"\nnames = "sets.csv"'


def nastran_op4(sector, folder):
    """OUTPUT4 has no names of rows: the table has a line for each row."""
    K, M, places = sector.free(sector.ascending)
    (folder / "wheel.op4").write_text(op4_text({"KAA": K.toarray(), "MAA": M.toarray()}, "strings"))
    point = dict(sector.nodes())
    of = {node: " ".join(name for name in sector.sets if node in sector.members(name)) for node in point}
    lines = ["node,direction,x,y,z,set"]
    for node, axis in places:
        where = ",".join(map(repr, point.get(node, ()))) or ",,"
        lines.append(f"{node},{axis},{where},{of.get(node, '')}")
    (folder / "rows.csv").write_text("\n".join(lines) + "\n")
    return 'model = "wheel.op4"\nnames = "rows.csv"'


def ansys_hbmat(sector, folder):
    """HBMAT: one matrix a file in the order of the solver, the lower triangle, and the mapping of its rows."""
    K, M, places = sector.free(lambda size: np.random.default_rng(11).permutation(size))
    for letter, matrix in (("K", K), ("M", M)):
        stored = sparse.csc_array(sparse.tril(sparse.csc_array(matrix)))
        stored.sort_indices()
        parts = [
            ["".join(form.format(value) for value in values[k : k + n].tolist()) for k in range(0, len(values), n)]
            for values, form, n in (
                (stored.indptr + 1, "{:14d}", 5),
                (stored.indices + 1, "{:14d}", 5),
                (stored.data, "{:25.15E}", 3),
            )
        ]
        counts = [sum(map(len, parts)), *map(len, parts), 0]
        head = [
            f"{'HBMAT of a sector':72s}{'STIFF' if letter == 'K' else 'MASS':8s}",
            "".join(f"{count:14d}" for count in counts),
            f"{'RSA':14s}" + "".join(f"{count:14d}" for count in (*stored.shape, stored.nnz, 0)),
            f"{'(5I14)':16s}{'(5I14)':16s}{'(3E25.15)':20s}",
        ]
        (folder / f"wheel_{letter}.matrix").write_text("\n".join([*head, *(line for part in parts for line in part)]) + "\n")
        rows = [f"{row:14d}{node:14d}     U{'XYZ'[axis - 1]}" for row, (node, axis) in enumerate(places, start=1)]
        (folder / f"wheel_{letter}.mapping").write_text("\n".join(["    Matrix Eqn          Node    DOF", *rows]) + "\n")
    (folder / "wheel.cdb").write_text(archive(sector))
    return 'model = "wheel_K.matrix"\nnames = "wheel.cdb"'


def numpy(sector, folder):
    """An archive with names of rows, and a table of nodes."""
    K, M, places = sector.free()
    dofs = [f"{node}.{'xyz'[axis - 1] if axis else 'q0'}" for node, axis in places]
    np.savez(folder / "wheel.npz", K=K.toarray(), M=M.toarray(), dofs=dofs)
    (folder / "wheel.csv").write_text(table(sector))
    return 'model = "wheel.npz"\nnames = "wheel.csv"'


WHOLE = (calculix, abaqus, nastran_dmig, nastran_op4, ansys_hbmat, numpy)
REDUCED = (abaqus_substructure, nastran_dmig, nastran_op4, numpy)
