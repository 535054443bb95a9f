"""Solid elements: patch test, rigid motions, mass, cantilever frequencies, refusal of inverted cells."""

import numpy as np
import pytest
import skfem
from scipy import linalg

from stickslip.model.structure.cyclic_reduction import craig_bampton
from stickslip.model.structure.solid import STEEL, Material, Solid, box_mesh, solid
from stickslip.support.checks import InputError

SIDES = (0.05, 0.03, 0.02)


def distorted_mesh(seed: int = 3):
    """A box of 3 × 2 × 2 cells with its inner nodes moved; the faces stay plane."""
    mesh = box_mesh(*(np.linspace(0.0, side, n) for side, n in zip(SIDES, (4, 3, 3), strict=True)))
    points = mesh.p.copy()
    inner = np.all((points > 1e-9) & (points < np.array(SIDES)[:, None] - 1e-9), axis=0)
    points[:, inner] += 2e-3 * np.random.default_rng(seed).uniform(-1.0, 1.0, (3, inner.sum()))
    return type(mesh)(points, mesh.t)


def rigid_motions(body: Solid) -> np.ndarray:
    """Three translations and three rotations, (3 nodes, 6)."""
    translations = np.tile(np.eye(3), (len(body.points), 1))
    rotations = [np.cross(axis, body.points).ravel() for axis in np.eye(3)]
    return np.column_stack([translations, *rotations])


def test_patch_of_linear_displacement_is_exact():
    body = solid(distorted_mesh())
    gradient = np.array([[1.0, 0.4, -0.2], [0.1, -0.7, 0.3], [0.5, 0.2, 0.9]]) * 1e-3
    exact = (body.points @ gradient.T).ravel()
    on_surface = np.any((body.points < 1e-9) | (body.points > np.array(SIDES) - 1e-9), axis=1)
    fixed, free = body.numbers[on_surface].ravel(), body.numbers[~on_surface].ravel()
    assert free.size == 39, "2 inner vertices and 11 inner edges"
    K = body.K.toarray()
    found = linalg.solve(K[np.ix_(free, free)], -K[np.ix_(free, fixed)] @ exact[fixed])
    np.testing.assert_allclose(found, exact[free], atol=1e-12 * np.abs(exact).max())
    lam, shear = STEEL.lame
    strain = 0.5 * (gradient + gradient.T)
    energy = 0.5 * np.prod(SIDES) * (lam * np.trace(strain) ** 2 + 2.0 * shear * np.sum(strain**2))
    assert 0.5 * exact @ K @ exact == pytest.approx(energy, rel=1e-12)


def test_free_block_has_six_rigid_motions_and_its_mass():
    body = solid(distorted_mesh())
    rigid = rigid_motions(body)
    scale = np.abs(body.K.toarray()).max()
    assert np.abs(body.K @ rigid).max() < 1e-12 * scale
    squares = linalg.eigvalsh(body.K.toarray(), body.M.toarray())
    assert np.all(np.abs(squares[:6]) < 1e-9 * squares[6])
    mass = rigid.T @ (body.M @ rigid)
    total = STEEL.density * np.prod(SIDES)
    np.testing.assert_allclose(mass[:3, :3], total * np.eye(3), atol=1e-12 * total)
    about_corner = total / 3.0 * (sum(s**2 for s in SIDES) - np.array(SIDES) ** 2)
    np.testing.assert_allclose(np.diag(mass)[3:], about_corner, rtol=1e-10)


def lowest_frequency(cells: int, poisson: float = 0.0) -> float:
    """First bending frequency of a steel bar 10 × 200 × 14 mm clamped at y = 0, Hz."""
    mesh = box_mesh(np.linspace(-5e-3, 5e-3, 2), np.linspace(0.0, 0.2, cells + 1), np.linspace(-7e-3, 7e-3, 3))
    body = solid(mesh, Material(poisson=poisson)).clamp(lambda points: points[:, 1] < 1e-9)
    return float(craig_bampton(body.M, body.K, {}, 2).frequencies[0])


def test_cantilever_converges_to_beam_theory():
    """Euler-Bernoulli, lowered by rotary inertia and shear (Timoshenko) by about 0.3 % at this slenderness."""
    inertia, area, length = 14e-3 * 10e-3**3 / 12, 14e-3 * 10e-3, 0.2
    beam = 1.875104069**2 / (2 * np.pi) * np.sqrt(210e9 * inertia / (7850.0 * area * length**4))
    found = np.array([lowest_frequency(cells) for cells in (1, 2, 4, 8, 16)])
    steps = -np.diff(found)
    assert np.all(steps > 0.0), "Ritz: refinement lowers the frequency"
    assert np.all(steps[1:] < 0.5 * steps[:-1])
    assert found[-1] == pytest.approx(beam, rel=5e-3)
    assert found[-1] < beam


def test_clamped_body_names_nodes_by_place():
    mesh = box_mesh([0.0, 0.01], [0.0, 0.01, 0.02], [0.0, 0.01])
    body = solid(mesh).clamp(lambda points: points[:, 1] < 1e-9)
    rows = body.named({"tip": (0.01, 0.02, 0.0), "edge": (0.005, 0.02, 0.0)})
    assert list(rows) == ["tip.x", "tip.y", "tip.z", "edge.x", "edge.y", "edge.z"]
    assert rows["tip.y"] == rows["tip.x"] + 1
    np.testing.assert_allclose(body.points[body.node((0.005, 0.02, 0.0))], (0.005, 0.02, 0.0))
    assert np.all(linalg.eigvalsh(body.K.toarray()) > 0.0)
    with pytest.raises(InputError, match="must lie within"):
        body.node((0.012, 0.02, 0.0))
    with pytest.raises(InputError, match=r"must not be clamped.*root\.x"):
        body.named({"root": (0.0, 0.0, 0.0)})
    with pytest.raises(InputError, match="must hold nodes of the mesh"):
        body.clamp(lambda points: points[:, 1] > 1.0)
    with pytest.raises(InputError, match=r"must have the shape \(\d+,\), one for each node, but is \(3,\)"):
        body.clamp(lambda points: points[2] < 0.0)


@pytest.mark.parametrize("far", [0.012, 0.03])
def test_inverted_cells_are_refused_by_number(far: float):
    """An inner node pushed through the neighbouring face."""
    mesh = box_mesh([0.0, 0.01, 0.02], [0.0, 0.01, 0.02], [0.0, 0.01, 0.02])
    points = mesh.p.copy()
    points[0, np.all(np.isclose(points, 0.01), axis=0)] += far
    with pytest.raises(InputError, match=r"must not be inverted.*Move their nodes"):
        solid(skfem.MeshHex(points, mesh.t))


@pytest.mark.parametrize("wrong", [{"young": -1.0}, {"poisson": 0.5}, {"density": float("nan")}])
def test_impossible_materials_are_refused(wrong: dict[str, float]):
    with pytest.raises(InputError, match=next(iter(wrong))):
        Material(**wrong)
