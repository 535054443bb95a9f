"""One model in every format: a chain of masses with names, coordinates and a set."""

from functools import partial

import numpy as np
import pytest
from models import nastran_files
from scipy import io, sparse


class Chain:
    """Six masses along x. Its numbers have few digits, which every format holds."""

    def __init__(self):
        generator = np.random.default_rng(3)
        self.M = np.diag(generator.uniform(0.1, 0.2, 6).round(6))
        stiffness = generator.uniform(1e5, 2e5, 7).round()
        self.K = np.diag(stiffness[:-1] + stiffness[1:]) - np.diag(stiffness[1:-1], 1) - np.diag(stiffness[1:-1], -1)
        self.C = 1e-5 * self.K
        self.dofs = tuple(f"{node}.x" for node in range(1, 7))

    def save(self, folder, kind):
        """Write the model in a format; returns the path to read."""
        return getattr(self, f"_{kind}")(folder)

    def _npz(self, folder):
        np.savez(folder / "chain.npz", M=self.M, K=self.K, C=self.C, dofs=self.dofs)
        return folder / "chain.npz"

    def _mat(self, folder):
        names = np.array(self.dofs, dtype=object)
        io.savemat(folder / "chain.mat", {"M": self.M, "K": sparse.csc_array(self.K), "C": self.C, "dofs": names})
        return folder / "chain.mat"

    def _mat_compressed(self, folder):
        rows = {"M": self.M, "K": self.K, "C": self.C, "dofs": list(self.dofs)}
        io.savemat(folder / "chain.mat", rows, do_compression=True)
        return folder / "chain.mat"

    def _mat4(self, folder):
        io.savemat(
            folder / "chain.mat", {"M": self.M, "K": sparse.csc_array(self.K), "C": self.C, "dofs": list(self.dofs)}, format="4"
        )
        return folder / "chain.mat"

    def _octave_text(self, folder):
        """As `save -text` of Octave writes a matrix, a sparse one and a cell array of names."""

        def rows(matrix):
            return "\n".join(" " + " ".join(f"{value:.17g}" for value in row) for row in matrix)

        K = sparse.coo_array(self.K)
        entries = "\n".join(f"{i + 1} {j + 1} {value:.17g}" for i, j, value in zip(*K.coords, K.data.tolist(), strict=True))
        cells = "".join(f"# name: <cell-element>\n# type: string\n# elements: 1\n# length: 3\n{name}\n\n\n" for name in self.dofs)
        (folder / "chain.mat").write_text(
            "# Created by Octave 8.4.0, Mon Jan 01 00:00:00 2024 UTC <someone@somewhere>\n"
            f"# name: M\n# type: matrix\n# rows: 6\n# columns: 6\n{rows(self.M)}\n\n\n"
            f"# name: K\n# type: sparse matrix\n# nnz: {K.nnz}\n# rows: 6\n# columns: 6\n{entries}\n\n\n"
            f"# name: C\n# type: matrix\n# rows: 6\n# columns: 6\n{rows(self.C)}\n\n\n"
            f"# name: dofs\n# type: cell\n# rows: 6\n# columns: 1\n{cells}\n"
        )
        return folder / "chain.mat"

    def _mat73(self, folder):
        """As MATLAB writes it: columns first, a user block, cell arrays as references, sparse as data, ir, jc."""
        h5py = pytest.importorskip("h5py")
        path = folder / "chain73.mat"
        with h5py.File(path, "w", userblock_size=512) as file:
            file["M"], file["C"] = self.M.T, self.C.T
            K = sparse.csc_array(self.K)
            group = file.create_group("K")
            group["data"], group["ir"], group["jc"] = K.data, K.indices.astype(np.uint64), K.indptr.astype(np.uint64)
            group.attrs["MATLAB_sparse"] = np.uint64(6)
            cells = [file.create_dataset(f"#refs#/{k}", data=np.frombuffer(name.encode(), np.uint8)[:, None].astype(np.uint16))
                     for k, name in enumerate(self.dofs)]  # fmt: skip
            file["dofs"] = np.array([[cell.ref for cell in cells]], dtype=h5py.ref_dtype).T
        with path.open("r+b") as file:
            file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")
        return path

    def _matrix_market(self, folder):
        for name in "MKC":
            io.mmwrite(folder / f"chain_{name}.mtx", sparse.coo_array(getattr(self, name)), symmetry="symmetric", precision=17)
        return folder / "chain_K.mtx"

    def _matrix_market_dense(self, folder):
        for name in "MKC":
            io.mmwrite(folder / f"chain_{name}.mtx", getattr(self, name), precision=17)
        return folder / "chain_M.mtx"

    def _harwell_boeing(self, folder):
        for name in "MKC":
            io.hb_write(folder / f"{name.lower()}.rb", sparse.csc_array(getattr(self, name)))
        return folder / "k.rb"

    def _harwell_boeing_symmetric(self, folder):
        """The lower triangle, column by column; SciPy writes unsymmetric files alone."""
        for name in "MKC":
            lower = sparse.csc_array(np.tril(getattr(self, name)))
            numbers = [*(lower.indptr + 1), *(lower.indices + 1)]
            counts = "".join(f"{count:14d}" for count in (7 + 2 * lower.nnz, 7, lower.nnz, lower.nnz, 0))
            sizes = "".join(f"{count:14d}" for count in (6, 6, lower.nnz, 0))
            head = f"{'chain':72s}{name:8s}\n{counts}\nRSA           {sizes[:14]}{sizes[14:]}\n"
            layout = f"{'(1I14)':16s}{'(1I14)':16s}{'(1E26.17)':20s}{'':20s}\n"
            lines = [*(f"{number:14d}" for number in numbers), *(f"{value:26.17E}" for value in lower.data)]
            (folder / f"{name.lower()}.rsa").write_text(head + layout + "\n".join(lines) + "\n")
        return folder / "k.rsa"

    def _scipy(self, folder):
        for name in "MKC":
            sparse.save_npz(folder / f"chain_{name}.npz", sparse.csr_array(getattr(self, name)))
        return folder / "chain_K.npz"

    def _abaqus(self, folder):
        """FORMAT=MATRIX INPUT: node, direction, node, direction, value of one triangle."""
        for name, kind in (("M", "MASS"), ("K", "STIF"), ("C", "DMPV")):
            matrix = getattr(self, name)
            lines = [f"{i + 1},1, {j + 1},1, {matrix[i, j]:.17e}" for i in range(6) for j in range(i + 1) if matrix[i, j]]
            (folder / f"job_{kind}1.mtx").write_text("** a comment\n" + "\n".join(lines) + "\n")
        return folder / "job_STIF1.mtx"

    def _abaqus_coordinate(self, folder):
        for name, kind in (("M", "MASS"), ("K", "STIF"), ("C", "DMPV")):
            rows = sparse.coo_array(getattr(self, name))
            lines = [f"{i + 1}  {j + 1}  {value:.17e}" for i, j, value in zip(*rows.coords, rows.data, strict=True)]
            (folder / f"job_{kind}2.mtx").write_text("\n".join(lines) + "\n")
        return folder / "job_STIF2.mtx"

    def _abaqus_substructure(self, folder):
        """*USER ELEMENT with its nodes in comments, and the columns up to the diagonal, four entries a line."""
        lines = [
            "*USER ELEMENT, NODES=6, LINEAR",
            "** ELEMENT NODES",
            "** 1, 2, 3, 4,",
            "** 5, 6,",
            "1,",
            "*MATRIX, TYPE=STIFFNESS",
        ]
        for matrix, kind in ((self.K, None), (self.M, "MASS"), (self.C, "DAMPING")):
            lines += [f"*MATRIX, TYPE={kind}"] if kind else []
            packed = matrix[np.tril_indices(6)]
            lines += [", ".join(f"{value:.17e}" for value in packed[k : k + 4]) + "," for k in range(0, packed.size, 4)]
        (folder / "substructure.mtx").write_text("\n".join(lines) + "\n")
        return folder / "substructure.mtx"

    def _nastran(self, folder, name, content):
        path = folder / name
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    @property
    def _named(self):
        return {"KAA": self.K, "MAA": self.M, "BAA": self.C}


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
    _save = lambda self, folder, style=_style: self._nastran(folder, "chain.pch", nastran_files.dmig(self._named, style))  # noqa: E731
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
