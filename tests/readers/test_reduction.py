"""Places by id, set and coordinates; the reduction, its cache, what it reports; the description of a model."""

import numpy as np
import pytest
from scipy import linalg

import stickslip as ss
from stickslip.model.readers.model import describe
from stickslip.model.structure.modes import lowest_modes
from stickslip.model.structure.solid import box_mesh, solid
from stickslip.support.checks import Faults, InputError


@pytest.fixture(scope="module")
def beam():
    """A free steel beam of 20-node hexahedra, 10 x 10 x 60 mm."""
    return solid(box_mesh(np.linspace(0, 0.01, 2), np.linspace(0, 0.01, 2), np.linspace(0, 0.06, 9)))


def saved(beam, path, clamped, scale=1.0):
    """The beam as a .npz file with names and coordinates, clamped at z = 0 or free."""
    body = beam.clamp(lambda points: points[:, 2] < 1e-9) if clamped else beam
    order = [(body.numbers[node, axis], f"{node}.{'xyz'[axis]}") for node in range(len(body.points)) for axis in range(3)]
    dofs = [name for row, name in sorted(order) if row >= 0]
    nodes = np.column_stack([np.arange(len(body.points)), body.points * scale])
    np.savez(path, M=body.M.toarray(), K=body.K.toarray(), dofs=dofs, nodes=nodes)
    return path


@pytest.fixture(scope="module")
def clamped(beam, tmp_path_factory):
    return saved(beam, tmp_path_factory.mktemp("beam") / "clamped.npz", True)


def test_frequencies_of_the_reduced_model(clamped):
    """The lowest modes of the whole model, by a dense solver, against those of 12 kept rows and 30 modes."""
    model = ss.read_model(clamped)
    keep = {"tip": (0.01, 0.01, 0.06), "near": (0.0005, 0.0, 0.0302)}
    messages = []
    structure = ss.read_structure(clamped, keep=keep, modes=30, progress=lambda share, text: messages.append(text))
    assert structure.dofs[:6] == ("tip.x", "tip.y", "tip.z", "near.x", "near.y", "near.z")
    whole = linalg.eigvalsh(model.K.toarray(), model.M.toarray(), subset_by_index=(0, 4))
    reduced = linalg.eigvalsh(structure.K, structure.M)[:5]
    np.testing.assert_allclose(np.sqrt(reduced), np.sqrt(whole), rtol=2e-4)
    said = " ".join(messages)
    assert "near: node" in said
    assert "0.539 mm from the point asked for" in said  # √(0.5² + 0.2²)
    assert "the basis takes" in said


def test_the_same_model_is_reduced_once(clamped, cache):
    keep, messages = {"tip": (0.01, 0.01, 0.06)}, []
    first = ss.read_structure(clamped, keep=keep, modes=5)
    again = ss.read_structure(clamped, keep=keep, modes=5, progress=lambda share, text: messages.append(text))
    assert any("found in" in text for text in messages)
    np.testing.assert_array_equal(first.K, again.K)
    (kept,) = cache.glob("*.npz")
    kept.write_bytes(b"damaged")
    np.testing.assert_array_equal(ss.read_structure(clamped, keep=keep, modes=5).K, first.K)
    ss.read_structure(clamped, keep=keep, modes=6)
    assert len(list(cache.glob("*.npz"))) == 2


def test_damping_is_projected(chain, tmp_path):
    structure = ss.read_structure(chain.save(tmp_path, "npz"), keep=["2", "5.x"], modes=4)
    assert structure.dofs == ("2.x", "5.x", "mode/1.q", "mode/2.q", "mode/3.q", "mode/4.q")
    np.testing.assert_allclose(structure.C, 1e-5 * structure.K, atol=1e-9)


def test_a_named_set(clamped):
    model = ss.read_model(clamped)
    tip = [node for node, point in model.nodes.items() if point[2] > 0.0599 and node in model.directions]
    lines = ["node,direction,set"] + [
        f"{n},{d},{'TIP' if n in tip else ''}" for n, _, d in (x.rpartition(".") for x in model.dofs)
    ]
    names = clamped.with_name("names.csv")
    names.write_text("\n".join(lines))
    structure = ss.read_structure(clamped, names=names, keep={"pad": "TIP"}, modes=2)
    assert structure.dofs[0] == f"pad/{model.dofs[model.rows[f'{structure.dofs[0][4:]}']]}"
    assert structure.size == 3 * len(tip) + 2


@pytest.mark.parametrize(
    ("keep", "said"),
    [
        ({"a": "TPI"}, "keep, a: Node or set 'TPI' does not exist"),
        ({"a": (0.0, 0.0, 0.2)}, "must lie within"),
        (["93", "93"], "must name each degree of freedom once"),
        ({"a": (0.0, 0.0)}, "must have 3 entries"),
        ({"a": (0.0, 0.0, np.nan)}, "must be finite"),
    ],
)
def test_places_that_are_not_there(clamped, keep, said):
    with pytest.raises(Faults, match=said):
        ss.read_structure(clamped, keep=keep)


def test_modes_without_places(clamped):
    with pytest.raises(InputError, match="modes must go with keep"):
        ss.read_structure(clamped, modes=3)


def test_description_of_a_free_body(beam, tmp_path):
    found = describe(ss.read_model(saved(beam, tmp_path / "free.npz", False)))
    mass = 7850 * 0.01 * 0.01 * 0.06
    np.testing.assert_allclose(found.mass, mass, rtol=1e-12)
    np.testing.assert_allclose(found.box, [0.01, 0.01, 0.06])
    assert found.modes.rigid == 6
    assert found.odd == ()
    text = str(found)
    for words in ("rigid motions     6", "positive semidefinite", "324 rows", "box               0.01 x 0.01 x 0.06 m"):
        assert words.split()[-1] in text


def test_shift_and_invert_finds_what_a_dense_solver_finds():
    """A longer free beam, above the size that is solved densely."""
    body = solid(box_mesh(np.linspace(0, 0.01, 3), np.linspace(0, 0.01, 3), np.linspace(0, 0.06, 7)))
    found = lowest_modes(body.M, body.K, 12)
    assert found.squares.size == 12
    assert (found.rigid, found.negative) == (6, 0)
    whole = linalg.eigvalsh(body.K.toarray(), body.M.toarray(), subset_by_index=(6, 11))
    np.testing.assert_allclose(found.squares[6:], whole, rtol=1e-8)
    weakened = body.K - 1.5 * whole[0] * body.M
    assert lowest_modes(body.M, weakened, 12).negative == int(np.sum(whole < 1.5 * whole[0])) + 6


def test_wrong_units_warn(beam, tmp_path):
    with pytest.warns(UserWarning, match=r"is 7.65e-06 kg/m³: implausible, check the units"):
        ss.read_model(saved(beam, tmp_path / "mm.npz", True, scale=1e3).with_name("mm.npz"), units="SI")


def test_negative_mass_is_odd(chain, tmp_path):
    chain.M[2, 2] = -0.1
    said = str(describe(ss.read_model(chain.save(tmp_path, "npz"))))
    assert "M has negative eigenvalues" in said
    assert "could not be factorised" not in said


def test_negative_stiffness_is_odd(chain, tmp_path):
    chain.K[0, 0] = -1e5
    assert "K has 1 motion of negative stiffness" in str(describe(ss.read_model(chain.save(tmp_path, "npz"))))


def described(tmp_path, **arrays):
    np.savez(tmp_path / "odd.npz", **arrays)
    return str(describe(ss.read_model(tmp_path / "odd.npz")))


def test_a_model_along_one_axis(chain, tmp_path):
    (mass,) = [line for line in str(describe(ss.read_model(chain.save(tmp_path, "npz")))).splitlines() if "mass along" in line]
    assert mass == f"mass along x      {chain.M.sum():.6g} kg (without fixed nodes)"


def test_rows_that_are_odd(chain, tmp_path):
    M, K = (np.pad(matrix, (0, 2)) for matrix in (chain.M, chain.K))
    K[6, 6] = 1e5
    dofs = (*chain.dofs, "7.rx", "8.q")
    said = described(tmp_path, M=M, K=K, dofs=dofs, nodes=[[1, 0, 0, 0], [2, 1, 0, 0]])
    assert "1 row, 8.q first, with neither mass nor stiffness" in said
    assert "1 row, 7.rx first, with no mass" in said
    assert "5 nodes without coordinates, 3 first: inner rows of elements" in said


def test_a_damping_that_is_odd(chain, tmp_path):
    sound = described(tmp_path, M=chain.M, K=chain.K, C=chain.C)
    assert "symmetric         M, K and C" in sound
    assert "note  " not in sound
    gyroscopic = chain.C + np.eye(6, k=1) - np.eye(6, k=-1)
    said = described(tmp_path, M=chain.M, K=chain.K, C=gyroscopic)
    assert "C is not symmetric" in said
    assert "feeds energy" not in said
    assert "C feeds energy in" in described(tmp_path, M=chain.M, K=chain.K, C=-chain.C)


def test_internal_nodes_of_abaqus_carry_no_mass_of_their_own(tmp_path):
    """A bar of two nodes and an internal one that moves relative to them: 2 kg, whatever the internal row holds."""
    K = "1,1, 1,1, 2e6\n2,1, 1,1, -1e6\n2,1, 2,1, 2e6\n-1,1, -1,1, 1e6\n"
    M = "1,1, 1,1, 0.7\n2,1, 1,1, 0.3\n2,1, 2,1, 0.7\n-1,1, -1,1, 0.4\n1,1, -1,1, 0.2\n"
    for kind, lines in (("STIF", K), ("MASS", M)):
        (tmp_path / f"bar_{kind}1.mtx").write_text(lines)
    model = ss.read_model(tmp_path / "bar_STIF1.mtx")
    assert model.dofs == ("-1.x", "1.x", "2.x")
    assert describe(model).mass[0] == pytest.approx(2.0)


def test_a_negative_mass_inside_is_refused(tmp_path):
    """The modes would drop it without a word."""
    K = 2e6 * np.eye(12) - 1e6 * (np.eye(12, k=1) + np.eye(12, k=-1))
    np.savez(tmp_path / "m.npz", M=np.diag([1.0, 1, 1, -1, *np.ones(8)]), K=K, dofs=[f"{n}.x" for n in range(1, 13)])
    with pytest.raises(InputError, match="M must have no negative eigenvalue"):
        ss.read_structure(tmp_path / "m.npz", keep=["1"], modes=3)
