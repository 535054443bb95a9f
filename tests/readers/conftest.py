"""One model in every format: a chain of masses with names, coordinates and a set."""

from functools import partial

import numpy as np
import pytest
from readers import nastran_files
from scipy import io, sparse

ABAQUS = {"M": "MASS", "K": "STIF", "C": "DMPV"}
DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")


class Chain:
    """Six masses along x. Its numbers have few digits, which every format holds."""

    def __init__(self):
        generator = np.random.default_rng(3)
        self.M = np.diag(generator.uniform(0.1, 0.2, 6).round(6))
        stiffness = generator.uniform(1e5, 2e5, 7).round()
        self.K = np.diag(stiffness[:-1] + stiffness[1:]) - np.diag(stiffness[1:-1], 1) - np.diag(stiffness[1:-1], -1)
        self.C = 1e-5 * self.K
        self.dofs = tuple(f"{node}.x" for node in range(1, 7))

    @property
    def letters(self):
        """The matrices that there are."""
        return [name for name in "MKC" if getattr(self, name) is not None]

    @property
    def places(self):
        """Node and number of the direction of each row."""
        numbers = {axis: number for number, axis in enumerate(DIRECTIONS, start=1)}
        return [
            (int(node), numbers[axis] if axis in numbers else int(axis[1:]))
            for node, axis in (name.split(".") for name in self.dofs)
        ]

    def save(self, folder, kind):
        """Write the model in a format; returns the path to read."""
        return getattr(self, f"_{kind}")(folder)

    def _npz(self, folder):
        np.savez(folder / "chain.npz", **{name: getattr(self, name) for name in self.letters}, dofs=self.dofs)
        return folder / "chain.npz"

    def _mat(self, folder):
        names = np.array(self.dofs, dtype=object)
        rows = {"M": self.M, "K": sparse.csc_array(self.K), "C": self.C, "dofs": names}
        io.savemat(folder / "chain.mat", {name: value for name, value in rows.items() if value is not None})
        return folder / "chain.mat"

    def _mat_compressed(self, folder):
        rows = {name: getattr(self, name) for name in self.letters}
        io.savemat(folder / "chain.mat", {**rows, "dofs": list(self.dofs)}, do_compression=True)
        return folder / "chain.mat"

    def _mat4(self, folder):
        io.savemat(
            folder / "chain.mat", {"M": self.M, "K": sparse.csc_array(self.K), "C": self.C, "dofs": list(self.dofs)}, format="4"
        )
        return folder / "chain.mat"

    def _mat73(self, folder):
        """As MATLAB writes it: columns first, a user block, cell arrays as references, sparse as data, ir, jc."""
        h5py = pytest.importorskip("h5py")
        path = folder / "chain73.mat"
        with h5py.File(path, "w", userblock_size=512) as file:
            for name in self.letters:
                if name != "K":
                    file[name] = getattr(self, name).T
            K = sparse.csc_array(self.K)
            group = file.create_group("K")
            group["data"], group["ir"], group["jc"] = K.data, K.indices.astype(np.uint64), K.indptr.astype(np.uint64)
            group.attrs["MATLAB_sparse"] = np.uint64(len(self.K))
            cells = [file.create_dataset(f"#refs#/{k}", data=np.frombuffer(name.encode(), np.uint8)[:, None].astype(np.uint16))
                     for k, name in enumerate(self.dofs)]  # fmt: skip
            file["dofs"] = np.array([[cell.ref for cell in cells]], dtype=h5py.ref_dtype).T
        with path.open("r+b") as file:
            file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")
        return path

    def _matrix_market(self, folder):
        for name in self.letters:
            matrix = getattr(self, name)
            symmetry = "symmetric" if np.array_equal(matrix, matrix.T) else "general"
            io.mmwrite(folder / f"chain_{name}.mtx", sparse.coo_array(matrix), symmetry=symmetry, precision=17)
        return folder / "chain_K.mtx"

    def _matrix_market_dense(self, folder):
        for name in self.letters:
            io.mmwrite(folder / f"chain_{name}.mtx", getattr(self, name), precision=17)
        return folder / "chain_M.mtx"

    def _harwell_boeing(self, folder):
        for name in self.letters:
            io.hb_write(folder / f"{name.lower()}.rb", sparse.csc_array(getattr(self, name)))
        return folder / "k.rb"

    def _rutherford_boeing(self, folder):
        """The symmetric type, whose fields need no blanks between them; SciPy writes the other one."""
        for name in self.letters:
            matrix = getattr(self, name)
            symmetric = np.array_equal(matrix, matrix.T)
            stored = sparse.csc_array(np.tril(matrix) if symmetric else matrix)
            fields = ((stored.indptr + 1, "%4d", 20), (stored.indices + 1, "%4d", 20), (stored.data, "%23.16E", 3))
            parts = [
                ["".join(form % x for x in values[k : k + n].tolist()) for k in range(0, len(values), n)]
                for values, form, n in fields
            ]
            counts = [sum(map(len, parts)), *map(len, parts)]
            head = [
                f"{'a chain of masses':72s}{name:8s}",
                "".join(f"{count:14d}" for count in counts),
                f"{'RSA' if symmetric else 'RUA':14s}" + "".join(f"{count:14d}" for count in (*stored.shape, stored.nnz, 0)),
                f"{'(20I4)':16s}{'(20I4)':16s}{'(1P,3D23.16)':20s}",
            ]
            (folder / f"chain_{name}.rsa").write_text(
                "\n".join([*head, *(line for part in parts for line in part)]).replace("E+", "D+") + "\n"
            )
        return folder / "chain_K.rsa"

    def _scipy(self, folder):
        for name in self.letters:
            sparse.save_npz(folder / f"chain_{name}.npz", sparse.csr_array(getattr(self, name)))
        return folder / "chain_K.npz"

    def _abaqus(self, folder):
        """FORMAT=MATRIX INPUT: node, direction, node, direction, value of one triangle."""
        for name in self.letters:
            matrix, kind = getattr(self, name), ABAQUS[name]
            triangle = np.tril(matrix) if np.array_equal(matrix, matrix.T) else matrix
            ids = [f"{node},{direction}" for node, direction in self.places]
            lines = [f"{ids[i]}, {ids[j]}, {matrix[i, j]:.17e}" for i, j in np.argwhere(triangle).tolist()]
            (folder / f"job_{kind}1.mtx").write_text("** a comment\n" + "\n".join(lines) + "\n")
        return folder / "job_STIF1.mtx"

    def _abaqus_coordinate(self, folder):
        for name in self.letters:
            rows, kind = sparse.coo_array(getattr(self, name)), ABAQUS[name]
            lines = [f"{i + 1}  {j + 1}  {value:.17e}" for i, j, value in zip(*rows.coords, rows.data, strict=True)]
            (folder / f"job_{kind}2.mtx").write_text("\n".join(lines) + "\n")
        return folder / "job_STIF2.mtx"

    def _abaqus_substructure(self, folder):
        """*USER ELEMENT with its nodes in comments, and the columns up to the diagonal, four entries a line."""
        nodes = [node for node, _ in self.places]
        lines = [f"*USER ELEMENT, NODES={len(nodes)}, LINEAR", "** ELEMENT NODES"]
        lines += ["** " + ", ".join(map(str, nodes[k : k + 4])) + "," for k in range(0, len(nodes), 4)]
        lines.append(f"{self.places[0][1]},")
        for matrix, kind in ((self.K, "STIFFNESS"), (self.M, "MASS"), (self.C, "DAMPING")):
            if matrix is None:
                continue
            lines.append(f"*MATRIX, TYPE={kind}")
            packed = matrix[np.tril_indices(len(matrix))] if np.array_equal(matrix, matrix.T) else matrix.T.ravel()
            lines += [", ".join(f"{value:.17e}" for value in packed[k : k + 4]) + "," for k in range(0, packed.size, 4)]
        (folder / "substructure.mtx").write_text("\n".join(lines) + "\n")
        return folder / "substructure.mtx"

    def _nastran(self, folder, name, content):
        path = folder / name
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    @property
    def _named(self):
        named = {"KAA": self.K, "MAA": self.M, "BAA": self.C}
        return {name: matrix for name, matrix in named.items() if matrix is not None}


for _style in nastran_files.STYLES:
    for _name, _write in {
        "text": nastran_files.op4_text,
        "text_wide": partial(nastran_files.op4_text, width=16),
        "binary": nastran_files.op4_binary,
        "binary_big_endian": partial(nastran_files.op4_binary, order=">"),
        "binary_64": partial(nastran_files.op4_binary, word=8),
    }.items():
        _save = lambda self, folder, write=_write, style=_style: self._nastran(folder, "chain.op4", write(self._named, style))  # noqa: E731
        setattr(Chain, f"_op4_{_name}_{_style}", _save)
for _style in ("large", "free"):
    _write = partial(nastran_files.dmig, style=_style)
    _save = lambda self, folder, write=_write: self._nastran(folder, "chain.pch", write(self._named, places=self.places))  # noqa: E731
    setattr(Chain, f"_dmig_{_style}", _save)

KINDS = [name[1:] for name in vars(Chain) if name.startswith("_") and not name.startswith(("__", "_nam", "_nas"))]


@pytest.fixture
def chain():
    return Chain()


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """Reductions are kept in a folder of the test."""
    monkeypatch.setenv("STICKSLIP_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"
