"""One model in every format: a chain of masses with names, coordinates and a set."""

import numpy as np
import pytest
from scipy import io, sparse


class Chain:
    """Six masses along x; node k at (0.01 k, 0, 0) m."""

    def __init__(self):
        generator = np.random.default_rng(3)
        self.M = np.diag(generator.uniform(0.1, 0.2, 6))
        stiffness = generator.uniform(1e5, 2e5, 7)
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

    def _scipy(self, folder):
        for name in "MKC":
            sparse.save_npz(folder / f"chain_{name}.npz", sparse.csr_array(getattr(self, name)))
        return folder / "chain_K.npz"


KINDS = [name[1:] for name in vars(Chain) if name.startswith("_") and not name.startswith("__")]


@pytest.fixture
def chain():
    return Chain()


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """Reductions are kept in a folder of the test."""
    monkeypatch.setenv("STICKSLIP_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"
