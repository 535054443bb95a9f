"""Craig-Bampton: exact static response with any number of modes, exact with all of them, upper bounds of frequencies."""

import numpy as np
import pytest
from scipy import linalg, sparse

from stickslip.model.structure.cyclic_reduction import craig_bampton
from stickslip.model.structure.solid import box_mesh, solid
from stickslip.support.checks import InputError

LENGTH = 0.12


def clamped_bar(cells: int = 6):
    mesh = box_mesh([-5e-3, 5e-3], np.linspace(0.0, LENGTH, cells + 1), [-8e-3, 0.0, 8e-3])
    body = solid(mesh).clamp(lambda points: points[:, 1] < 1e-9)
    return body, body.named({"tip": (5e-3, LENGTH, 0.0), "side": (-5e-3, LENGTH / 2, 8e-3)})


def frequencies(structure) -> np.ndarray:
    return np.sqrt(linalg.eigvalsh(structure.K, structure.M)) / (2 * np.pi)


@pytest.mark.parametrize("modes", [0, 1, 7, None])
def test_static_response_is_exact_with_any_number_of_modes(modes: int | None):
    body, kept = clamped_bar(3)
    reduction = craig_bampton(body.M, body.K, kept, modes)
    load = np.random.default_rng(0).standard_normal(len(kept))
    full = np.zeros(body.size)
    full[list(kept.values())] = load
    exact = linalg.solve(body.K.toarray(), full)
    reduced = linalg.solve(reduction.structure.K, np.append(load, np.zeros(reduction.structure.size - len(kept))))
    np.testing.assert_allclose(reduction.transformation @ reduced, exact, rtol=0, atol=1e-10 * np.abs(exact).max())
    np.testing.assert_allclose(reduced[: len(kept)], exact[list(kept.values())], rtol=1e-8)


def test_all_modes_reproduce_every_frequency():
    body, kept = clamped_bar(3)
    reduction = craig_bampton(body.M, body.K, kept)
    assert reduction.structure.size == body.size
    exact = np.sqrt(linalg.eigvalsh(body.K.toarray(), body.M.toarray())) / (2 * np.pi)
    np.testing.assert_allclose(frequencies(reduction.structure), exact, rtol=1e-8)


def test_frequencies_of_the_modes_are_those_of_the_body_held_where_it_is_kept():
    """In Hz, lowest first."""
    body, kept = clamped_bar(3)
    inside = np.setdiff1d(np.arange(body.size), list(kept.values()))
    K, M = (matrix.toarray()[np.ix_(inside, inside)] for matrix in (body.K, body.M))
    exact = np.sqrt(linalg.eigh(K, M, eigvals_only=True)[:7]) / (2 * np.pi)
    np.testing.assert_allclose(craig_bampton(body.M, body.K, kept, 7).frequencies, exact, rtol=1e-8)


def test_all_modes_reproduce_the_dynamic_response():
    body, kept = clamped_bar(2)
    reduction = craig_bampton(body.M, body.K, kept)
    omega = 2 * np.pi * 3000.0
    load = np.zeros(body.size)
    load[kept["tip.x"]] = 1.0
    exact = linalg.solve(body.K.toarray() - omega**2 * body.M.toarray(), load)
    structure = reduction.structure
    found = reduction.transformation @ linalg.solve(structure.K - omega**2 * structure.M, structure.row({"tip.x": 1.0}))
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-8 * np.abs(exact).max())


def test_frequencies_fall_to_the_exact_ones_with_more_modes():
    body, kept = clamped_bar(8)
    exact = np.sqrt(linalg.eigh(body.K.toarray(), body.M.toarray(), eigvals_only=True, subset_by_index=[0, 3])) / (2 * np.pi)
    errors = np.array([frequencies(craig_bampton(body.M, body.K, kept, n).structure)[:4] / exact - 1 for n in (2, 8, 32)])
    assert np.all(np.diff(errors, axis=0) < 0.0)
    assert np.all(errors > -1e-10)
    assert errors[-1].max() < 1e-5


def test_sparse_and_dense_routes_agree():
    """More than 400 interior unknowns: shift-invert Lanczos; the same by the dense solver with every mode wanted."""
    body, kept = clamped_bar(8)
    assert body.size - len(kept) > 400
    some = craig_bampton(body.M, body.K, kept, 12)
    every = craig_bampton(body.M, body.K, kept)
    np.testing.assert_allclose(some.frequencies, every.frequencies[:12], rtol=1e-8)
    again = craig_bampton(body.M, body.K, kept, 12)
    np.testing.assert_array_equal(again.transformation, some.transformation)


def test_names_kept_first_then_modes():
    body, kept = clamped_bar(2)
    structure = craig_bampton(body.M, body.K, kept, 2).structure
    assert structure.dofs == (*kept, "mode/1.q", "mode/2.q")
    np.testing.assert_allclose(structure.M[-2:, -2:], np.eye(2), atol=1e-9)


def test_massless_interior_motions_follow_statically():
    """Three masses in a row, the middle one without mass: exact with the one mode that is left."""
    K = 2.0 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1)
    reduction = craig_bampton(np.diag([1.0, 0.0, 1.0]), K, {"1.x": 0})
    assert reduction.structure.size == 2
    condensed = np.array([[1.5, -0.5], [-0.5, 1.5]])
    np.testing.assert_allclose(2 * np.pi * frequencies(reduction.structure), np.sqrt(linalg.eigvalsh(condensed)), rtol=1e-12)


def test_unheld_interior_and_bad_rows_are_refused():
    K = np.array([[1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    with pytest.raises(InputError, match=r"must be positive definite.*Keep more"):
        craig_bampton(np.eye(3), sparse.csc_array(K), {"1.x": 0}, 1)
    with pytest.raises(InputError, match="must be different"):
        craig_bampton(np.eye(2), np.eye(2), {"1.x": 0, "2.x": 0})
    with pytest.raises(InputError, match="must lie between 0 and 1"):
        craig_bampton(np.eye(2), np.eye(2), {"1.x": 2})
    with pytest.raises(InputError, match="modes must lie between 0 and 1"):
        craig_bampton(np.eye(2), np.eye(2), {"1.x": 0}, 5)


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.array([[2.0, 1.0], [0.0, 2.0]]), "K must be symmetric"),
        (np.array([[2.0, np.nan], [np.nan, 2.0]]), "K\\[0, 1\\] must be finite"),
        (np.ones((2, 3)), "K must be a square matrix"),
        (np.eye(3), r"M must have the shape of K, \(3, 3\)"),
        (np.diag([1.0, -1.0]), "must be positive definite"),
    ],
)
def test_faulty_matrices_are_refused(matrix, message):
    with pytest.raises(InputError, match=message):
        craig_bampton(np.eye(2), matrix, {"1.x": 0}, 1)


def test_units_of_the_degrees_of_freedom_do_not_matter():
    """Rotations in other units: rows of K differ by 1e16, the reduction is the same."""
    K = 2.0 * np.eye(4) - np.eye(4, k=1) - np.eye(4, k=-1)
    units = np.diag([1.0, 1e-8, 1.0, 1e3])
    plain = craig_bampton(np.eye(4), K, {"1.x": 0}).structure
    scaled = craig_bampton(units @ units, units @ K @ units, {"1.x": 0}).structure
    np.testing.assert_allclose(frequencies(scaled), frequencies(plain), rtol=1e-9)
