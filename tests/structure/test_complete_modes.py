"""Modes are complete where more of them are equal than a block has vectors: closed forms and dense solutions, either solver."""

import numpy as np
import pytest
from each import each
from scipy import linalg, sparse

import stickslip as ss
from stickslip.model.structure import factor, pardiso
from stickslip.model.structure.factor import Pencil
from stickslip.model.structure.modes import BLOCK, held_modes, lowest_modes

needs_mkl = pytest.mark.skipif(not pardiso.usable(), reason="no wheel of MKL for this machine")


@pytest.fixture(params=["SuperLU", pytest.param("MKL PARDISO", marks=needs_mkl)])
def solver(request, monkeypatch):
    """One of the solvers, for matrices of any size."""
    monkeypatch.setattr(factor, "LARGE", 1 if request.param == "MKL PARDISO" else 10**9)
    return request.param


def chain(size, held=True):
    """Springs of 1 N/m between unit masses, the last free and the first held or free."""
    K = 2.0 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1)
    K[-1, -1] = 1.0
    K[0, 0] = 2.0 if held else 1.0
    return K


def copies(K, M, factors):
    """Equal bodies beside each other, the stiffness of each times a factor."""
    return sparse.csc_array(np.kron(np.diag(factors), K)), sparse.csc_array(np.kron(np.eye(len(factors)), M))


def agrees(found, K, M, number, every=None):
    """That the modes are the lowest of all, by a dense solution unless they are given: as many as lie below the bound, at least
    `number`, with the equals of the last."""
    if every is None:
        thetas = linalg.eigh(M.toarray(), K.toarray(), eigvals_only=True)[::-1]
        every = 1.0 / thetas[thetas > 1e-13 * thetas[0]]
    size = found.squares.size
    assert found.count.there == found.count.found == size == np.sum(every < found.count.bound) >= min(number, every.size)
    assert size == every.size or every[size] > every[size - 1] * (1.0 + 1e-10)
    np.testing.assert_allclose(found.squares, every[:size], rtol=1e-10)
    np.testing.assert_allclose(found.shapes.conj().T @ (M @ found.shapes), np.eye(size), atol=1e-10)
    residual = K @ found.shapes - (M @ found.shapes) * found.squares
    assert np.abs(residual).max() < 1e-8 * np.abs(K.data).max() * np.abs(found.shapes).max()


@each("bodies", [2, BLOCK + 1, 24, 60])
@each("spread", [0.0, 1e-12, 1e-9, 1e-6])
def test_equal_bodies_have_equal_modes(solver, bodies, spread):
    """Wanted: one of each body, half a family more, and fewer than there are equal ones."""
    draw = 1.0 + spread * np.random.default_rng(bodies).random(bodies)
    size = 410 // bodies + 1
    K, M = copies(chain(size), np.eye(size), draw)
    every = np.sort(np.outer(4.0 * np.sin(np.pi * np.arange(1, 2 * size, 2) / (4 * size + 2)) ** 2, draw), axis=None)
    for number in (bodies, bodies + bodies // 2, 1):
        agrees(held_modes(Pencil(K, M).at(0.0), number), K, M, number, every)


def test_rows_without_mass_of_equal_bodies(solver):
    K, M = copies(chain(30), np.diag(np.where(np.arange(30) % 3, 1.0, 0.0)), np.ones(25))
    agrees(held_modes(Pencil(K, M).at(0.0), 30), K, M, 30)
    K, M = copies(chain(30), np.diag(np.where(np.arange(30) == 29, 1.0, 0.0)), np.ones(25))
    agrees(held_modes(Pencil(K, M).at(0.0), 40), K, M, 40)  # 25 are all that there are


@each("factors", [(1e18, 1e3), (1e-9, 1e6), (1.0, 1e-15)])
def test_units_do_not_matter(factors):
    K, M = copies(factors[0] * chain(22), factors[1] * np.eye(22), np.ones(20))
    agrees(held_modes(Pencil(K, M).at(0.0), 30), K, M, 30)


def test_hermitian_matrices_count_once(solver):
    """A ring of 400 masses closed with a phase, as a sector at a nodal diameter, three times: ω² = 2 − 2 cos((2πk + φ)/n) + k."""
    size, phase, ground = 160, 0.7, 1e-3
    K = (2.0 + ground) * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1) + 0j
    K[0, -1], K[-1, 0] = -np.exp(1j * phase), -np.exp(-1j * phase)
    K, M = copies(K, np.eye(size), np.ones(12))
    found = held_modes(Pencil(K, M).at(0.0), 30)
    exact = np.sort(2.0 - 2.0 * np.cos((2.0 * np.pi * np.arange(size) + phase) / size)) + ground
    assert found.count.there == found.squares.size == 36
    np.testing.assert_allclose(found.squares, np.repeat(exact[:3], 12), rtol=1e-11)


@each("located", [True, False])
def test_free_bodies_have_a_rigid_motion_each(solver, located):
    bodies, size = 20, 22
    K, M = copies(chain(size, held=False), np.eye(size), np.ones(bodies))
    rigid = np.kron(np.eye(bodies), np.full((size, 1), size**-0.5)) if located else None
    found = lowest_modes(M, K, 2 * bodies + 5, rigid)
    every = 4.0 * np.sin(np.pi * np.arange(size) / (2.0 * size)) ** 2
    assert (found.rigid, found.negative, found.squares.size) == (bodies, 0, 3 * bodies)
    np.testing.assert_allclose(found.squares, np.repeat(every[:3], bodies), atol=1e-9)
    assert str(found.count) == f"60 of 60 below {np.sqrt(found.count.bound) / (2.0 * np.pi):.5g} Hz"
    assert every[2] < found.count.bound < every[3]


def test_the_list_of_a_model_is_complete(tmp_path):
    """18 equal masses on springs in a chain of their own: two of them were lost."""
    K, M = copies(chain(25), np.eye(25), np.ones(18))
    found = lowest_modes(M, K, 18, np.zeros((K.shape[0], 0)))
    np.testing.assert_allclose(found.squares, 4.0 * np.sin(np.pi / 102.0) ** 2, rtol=1e-10)
    assert found.count.there == 18
    small = lowest_modes(sparse.csc_array(np.eye(2)), sparse.csc_array(np.diag([1.0, 4.0])), 1)
    assert str(small.count) == f"1 of 1 below {np.sqrt(2.5) / (2.0 * np.pi):.5g} Hz"
    assert str(lowest_modes(sparse.csc_array(np.eye(2)), sparse.csc_array(np.diag([1.0, 4.0])), 5).count) == "2 of 2"


def test_one_more_factor_counts_and_a_restart_takes_as_many_vectors_as_are_missing(monkeypatch):
    """Different bodies: the factor of the count alone. 60 equal ones: begun again once, and counted twice."""
    shifts = []

    def at(self, shift, own=Pencil.at):
        shifts.append(shift)
        return own(self, shift)

    monkeypatch.setattr(Pencil, "at", at)
    for factors, times in ((1.0 + 0.01 * np.arange(60), 2), (np.ones(60), 4)):
        shifts.clear()
        held_modes(Pencil(*copies(chain(10), np.eye(10), factors)).at(0.0), 60)
        assert len(shifts) == times


def test_a_factor_that_errs_is_not_believed(monkeypatch):
    """The count is made elsewhere in the gap; where no factor is good, the list says that it is not counted."""
    K, M = copies(chain(50), np.eye(50), np.ones(9))
    places = []

    def at(self, shift, own=Pencil.at):
        places.append(shift)
        own(self, shift * (1.0 if len(places) != 2 else 3.0))  # another matrix than was asked for
        return self

    monkeypatch.setattr(Pencil, "at", at)
    agrees(held_modes(Pencil(K, M).at(0.0), 9), K, M, 9)
    assert 0.0 < places[2] < places[1]

    monkeypatch.setattr(Pencil, "at", lambda self, shift, own=at: own(self, 3.0 * shift))
    found = held_modes(Pencil(K, M).at(0.0), 9).count
    assert found.there is None
    assert "not counted" in str(found)


def test_equal_blades_in_one_model_are_reduced_alike(tmp_path, monkeypatch):
    """24 equal clamped blades, kept tips: the frequencies of one blade reduced alone, 22.350 and 74.820 Hz with a mode a blade.

    The reduction says how many modes there are; 30, which would cut the second family, become 48.
    """
    monkeypatch.setenv("STICKSLIP_CACHE", str(tmp_path / "cache"))
    blades, nodes = 24, 20
    K, M = np.kron(chain(nodes), np.diag([9e8, 1e6, 4e8])), 0.3 * np.eye(3 * nodes)
    dofs = [f"{node + 1}.{axis}" for node in range(blades * nodes) for axis in "xyz"]
    np.savez(tmp_path / "blades.npz", M=np.kron(np.eye(blades), M), K=np.kron(np.eye(blades), K), dofs=dofs)
    keep = {f"tip{blade + 1}": nodes * (blade + 1) for blade in range(blades)}
    said = []
    for modes, families, kept in ((24, (22.3500752, 74.81968397), 24), (30, (22.28007091, 67.33304328), 48)):
        made = ss.read_structure(tmp_path / "blades.npz", keep=keep, modes=modes, progress=lambda share, text: said.append(text))
        found = np.sqrt(linalg.eigvalsh(made.K, made.M)) / (2.0 * np.pi)
        np.testing.assert_allclose(found[:48], np.repeat(families, blades), rtol=1e-8)
        assert made.size == 3 * blades + kept
    notes = [text for text in said if text.startswith("Modes of the body with what is kept held: ")]
    assert len(notes) == 2
    assert "24 of 24 below " in notes[0]
    assert "48 of 48 below " in notes[1]
    assert notes[1].endswith("(30 were asked for, and the others equal the last of these)")
