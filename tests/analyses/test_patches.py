"""Contacts of patches of a finite-element surface: stuck frequencies, and the error of peaks against a trace with all nodes.

A clamped beam of steel, 100 x 20 x 10 mm, lies with the outer third of its underside on the ground: 21 nodes, 63 rows.
"""

from itertools import pairwise

import numpy as np
import pytest

import stickslip as ss
from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.settings import ForcedResponseSettings
from stickslip.analyses.truncation import ALL_NODES
from stickslip.model.structure.matrices import Structure
from stickslip.model.structure.solid import box_mesh, solid
from stickslip.show.report.responses import sentences

BAND = ss.hertz(1110.0, 1180.0)
LAW = ss.Macroslip(kt=4e6, mu=0.3, kn=6e6, preload=40.0)


@pytest.fixture(scope="module")
def beam():
    body = solid(box_mesh(np.linspace(0.0, 0.1, 7), np.linspace(0.0, 0.02, 3), np.linspace(0.0, 0.01, 2)))
    free = np.flatnonzero(body.points[:, 0] > 1e-9)
    rows = body.numbers[free].ravel()
    M, K = (matrix.toarray()[np.ix_(rows, rows)] for matrix in (body.M, body.K))
    nodes = {str(k): tuple(map(float, body.points[k])) for k in free}
    underside = tuple(name for name, (x, _, z) in nodes.items() if z < 1e-9 and x > 0.066)
    dofs = tuple(f"{name}.{axis}" for name in nodes for axis in "xyz")
    return Structure(M, K, dofs, damping=ss.ModalDamping(0.004), nodes=nodes, sets={"pad": underside})


def on_the_ground(beam, points=None):
    pad = ss.NodeSurface.of(beam, "pad", (0.0, 0.0, -1.0))
    contacts = ss.surface_contacts("pad", LAW, pad, tangent=(1.0, 0.0, 0.0), balanced=True, points=points)
    tip = next(name for name, (x, y, z) in beam.nodes.items() if x > 0.0999 and abs(y - 0.01) < 1e-6 and z > 0.009)
    return ss.Problem(beam, contacts, (ss.Force(f"{tip}.z", 1.0),), (f"{tip}.z", f"{tip}.x"))


def test_stuck_frequencies_rise_with_the_points_to_those_of_all_nodes(beam):
    """The square of a mean is at most the mean of squares: patches are softer than their nodes, and parts of a patch stiffer."""
    squares = [on_the_ground(beam, points).frequencies(stuck=True)[:6] for points in (1, 2, 4, 8, 16, None)]
    assert len(squares[-1]) == 6
    for fewer, more in pairwise(squares):
        assert np.all(fewer <= more * (1.0 + 1e-12))
    errors = [1.0 - found / squares[-1] for found in squares[:-1]]
    assert errors[0].max() > 0.02
    assert errors[-1].max() < 0.1 * errors[0].max()


@pytest.fixture(scope="module")
def all_nodes(beam):
    return ss.forced_response(on_the_ground(beam), BAND, [100.0], harmonics=1, samples=64).dataset


@pytest.mark.parametrize("few_coordinates", [False, True])
def test_the_error_of_patches_is_that_of_their_peaks_against_all_nodes(beam, all_nodes, few_coordinates, monkeypatch):
    """Both traced, while the pad slips and lifts. On few coordinates, all modes count too."""
    if few_coordinates:
        monkeypatch.setattr("stickslip.model.problem.systems.MANY_ROWS", 60)
    data = ss.forced_response(on_the_ground(beam, 1), BAND, [100.0], harmonics=1, samples=64).dataset
    assert ("coordinates" in data.attrs) == few_coordinates
    assert data.sizes["contact"] == 1
    whole = [float(found["contact_area"].sum()) for found in (data, all_nodes)]
    assert whole == pytest.approx([ss.NodeSurface.of(beam, "pad", (0.0, 0.0, -1.0)).area] * 2, rel=1e-12)
    change = all_nodes["peak_amplitude"].values[:, 0] / data["peak_amplitude"].values[:, 0] - 1.0
    np.testing.assert_allclose(data["patch_error"], change, rtol=0.02)
    assert np.abs(change).max() > 0.01
    assert "modal_error" not in data
    (line,) = [line for line in sentences(data) if line.startswith("  force 100")]
    assert line.endswith(f"with all nodes {100.0 * change[0, 0]:+.2g} %")
    assert any("Solved again with a contact at each node of the patches" in line for line in sentences(data))
    said = " ".join(map(str, data["case_message"].values))
    assert "when it is solved with a contact at each node of the patches" in said


def test_problems_without_patches_have_no_such_error(all_nodes):
    assert "patch_error" not in all_nodes


def test_the_work_keeps_the_problem_with_all_nodes(beam):
    patched, alone = (on_the_ground(beam, points) for points in (3, None))
    work = ForcedResponseWork.of(ForcedResponseSettings(patched, BAND, [1.0], 3, 64))
    assert work.finer_problem is ALL_NODES
    assert len(work.finer.B) == len(alone.B)
    order = [[contact.name for contact in problem.contacts] for problem in (work.finer, alone)]
    rows = np.argsort(order[0])[np.argsort(np.argsort(order[1]))]
    stiffness = [problem.B.T @ (problem.contact_stiffness[:, None] * problem.B) for problem in (work.finer, alone)]
    np.testing.assert_allclose(*stiffness, rtol=1e-9, atol=1e-9 * np.abs(stiffness[1]).max())
    assert [order[0][k] for k in rows] == order[1]
    assert ForcedResponseWork.of(ForcedResponseSettings(alone, BAND, [1.0], 3, 64)).finer is None


def test_peaks_that_are_not_found_with_all_nodes_are_said():
    assert not ALL_NODES.warning(("a",), np.array([0.009]))
    assert "a changes at its highest peak by -1.1 %" in ALL_NODES.warning(("a",), np.array([-0.011]))
    assert "could not be solved with a contact at each node" in ALL_NODES.warning(("a",), np.array([np.nan]))
