"""The worked examples of jointed beams and of beams with a gap, against their whole meshes with springs put in by hand."""

import csv

import numpy as np
import pytest
from scipy import linalg

from stickslip.study import read
from stickslip.study.templates import write_new


def whole(study, name):
    """M, K and names of rows of one beam in mm, t, s, and its nodes by set."""
    place = study.with_name(f"{study.stem}_{name}")
    with np.load(place.with_suffix(".npz")) as file:
        M, K, dofs = file["M"], file["K"], list(file["dofs"])
    with open(place.with_suffix(".csv"), newline="") as file:
        rows = list(csv.DictReader(file))
    return M, K, dofs, rows


def pairs(one, other, key):
    """Nodes of two tables in one set that stand at one x and y, by (x, y)."""
    places = [{(row["x"], row["y"]): row["node"] for row in rows if key in row["set"].split()} for rows in (one, other)]
    assert set(places[0]) == set(places[1])
    return {place: (node, places[1][place]) for place, node in places[0].items()}


@pytest.mark.slow
def test_the_stuck_joint_is_that_of_the_whole_meshes_with_springs(tmp_path):
    """3 x 5 nodes 10 and 5 mm apart: quarters at corners, halves at edges of what a node in the middle has."""
    write_new("jointed_beams", tmp_path / "joint.toml")
    problem = read(tmp_path / "joint.toml").sweep.problem
    (Ma, Ka, upper, upper_nodes), (Mb, Kb, lower, lower_nodes) = (
        whole(tmp_path / "joint.toml", name) for name in ("upper", "lower")
    )
    M, K = linalg.block_diag(Ma, Mb), linalg.block_diag(Ka, Kb)
    for (x, y), (a, b) in pairs(upper_nodes, lower_nodes, "JOINT").items():
        share = (0.5 if float(x) in (20.0, 40.0) else 1.0) * (0.5 if float(y) in (0.0, 20.0) else 1.0) / 8.0
        for axis in "xyz":
            i, j = upper.index(f"{a}.{axis}"), len(upper) + lower.index(f"{b}.{axis}")
            K[np.ix_([i, j], [i, j])] += 15e3 * share * np.array([[1.0, -1.0], [-1.0, 1.0]])
    expected = np.sqrt(linalg.eigh(K, M, eigvals_only=True, subset_by_index=[0, 3])) / (2.0 * np.pi)
    np.testing.assert_allclose(problem.frequencies(stuck=True)[:4], expected, rtol=2e-3)
    assert len(problem.contacts) == 15
    assert len(problem.structure.dofs) == 105
    assert sum(np.sum(contact.law.preload) for contact in problem.contacts) == pytest.approx(400.0)  # 1 N/mm² on 20 x 20 mm


def test_each_beam_with_a_gap_has_the_frequency_of_the_guide(tmp_path):
    """110.67 Hz is published; thickness and material are not, and the thickness was chosen for it."""
    write_new("beams_with_a_gap", tmp_path / "gap.toml")
    problem = read(tmp_path / "gap.toml").sweep.problem
    np.testing.assert_allclose(problem.frequencies(stuck=False)[:2], 110.67, atol=0.02)
    np.testing.assert_allclose([contact.law.gap for contact in problem.contacts], 1e-5, rtol=1e-6)
    spread = problem.forces[0].coefficients
    assert sum(spread.values()) == pytest.approx(1.0)
    assert {dof[:14] for dof in spread} == {"lower/OUTSIDE/"}
    assert not problem.warnings
