"""The finite-element disk: cyclic constraints against a mesh of the whole disk, rigid motions, bad input. Six coarse sectors."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from meshed_waves import cyclic_frequencies
from scipy.sparse import linalg

from stickslip.model.rigs.octopus_blisk import BliskSector, octopus_blisk, reduced_sector
from stickslip.model.structure.centrifugal import spinning
from stickslip.model.structure.cyclic_reduction import cyclic_craig_bampton, rotation, sector_of
from stickslip.model.structure.modes import natural_modes
from stickslip.model.structure.solid import solid
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.continuation import first_point
from stickslip.support.checks import InputError

COARSE = BliskSector(sectors=6, cells=(1, 1, 1))


@cache
def sector():
    return COARSE.sector()


def disk(**changes):
    return octopus_blisk(sector=COARSE, engine_order=2, modes=8, **changes)


def whole_mesh():
    """All sectors turned into their places, nodes that coincide merged."""
    one = COARSE.mesh()
    points = np.hstack([rotation(6, j) @ one.p for j in range(6)])
    cells = np.hstack([one.t + j * one.p.shape[1] for j in range(6)])
    _, first, place = np.unique(np.round(points.T, 9), axis=0, return_index=True, return_inverse=True)
    return type(one)(points[:, first], place.ravel()[cells])


def test_cyclic_modes_are_the_modes_of_the_whole_disk():
    body = solid(whole_mesh(), COARSE.material).clamp(lambda p: np.hypot(p[:, 0], p[:, 1]) < COARSE.hub_radius * (1 + 1e-9))
    squares = linalg.eigsh(body.K, 12, body.M, sigma=0.0, return_eigenvectors=False)
    whole = np.sort(np.sqrt(squares)) / (2.0 * np.pi)
    waves = [np.repeat(cyclic_frequencies(sector(), n, 2), 1 if n in (0, 3) else 2) for n in range(4)]
    assert np.sort(np.concatenate(waves))[:12] == pytest.approx(whole, rel=1e-8)


@pytest.mark.nightly
def test_a_spinning_sector_is_the_spinning_disk():
    """Prestress of nodal diameter 0 in the sector, of the whole mesh in the disk; at 60 turns a second both stiffen alike."""
    mesh = whole_mesh()
    still = solid(mesh, COARSE.material).clamp(lambda p: np.hypot(p[:, 0], p[:, 1]) < COARSE.hub_radius * (1 + 1e-9))
    body = spinning(still, mesh, COARSE.material, 2.0 * np.pi * 60.0)
    squares = linalg.eigsh(body.K, 6, body.M, sigma=0.0, return_eigenvectors=False)
    fast = replace(COARSE, rotation=60.0).sector()
    waves = [np.repeat(cyclic_frequencies(fast, n, 2), 1 if n in (0, 3) else 2) for n in range(4)]
    found = np.sort(np.concatenate(waves))[:6]
    assert found == pytest.approx(np.sort(np.sqrt(squares)) / (2.0 * np.pi), rel=1e-8)
    assert found[0] > 1.02 * np.sort(np.concatenate([cyclic_frequencies(sector(), n, 1) for n in range(4)]))[0]


def test_the_reduction_converges():
    exact = cyclic_frequencies(sector(), 2, 3)
    errors = []
    for modes in (8, 40):
        reduced = reduced_sector(COARSE, modes).structure.at(2)
        errors.append(natural_modes(reduced.M, reduced.K).frequencies[:3] / exact - 1.0)
    assert np.all(errors[0] < 1e-3)
    assert np.all((errors[1] > -1e-10) & (errors[1] < 0.05 * errors[0]))


@pytest.mark.parametrize(("wave", "moves"), [((1.0, -1.0j, 0.0), False), ((1.0, 1.0j, 0.0), True)])
def test_a_rigid_translation_moves_no_damper(wave, moves):
    """All sectors along x − i y: nodal diameter 1 in axes that turn with the sectors; its mirror image is no translation."""
    problem = disk()
    motion = {f".{axis}": value for axis, value in zip("xyz", wave, strict=True)}
    q = np.array([0.0 if dof.startswith("mode") else motion.get(dof[-2:], 0.0) for dof in problem.structure.dofs])
    relative = np.abs(problem.systems.relative_rows(1) @ q).max()
    assert relative > 0.1 if moves else relative < 1e-12


def test_the_faces_of_a_sector_join_a_rigid_translation():
    """All sectors along x − i y: of nodal diameter 1 the right face follows the left one so that the whole disk moves alike."""
    whole = sector()
    motion = np.zeros(whole.solid.size, dtype=complex)
    free = whole.solid.numbers[whole.solid.numbers[:, 0] >= 0]
    motion[free] = [1.0, -1.0j, 0.0]
    off = np.setdiff1d(np.arange(motion.size), whole.dependent)
    np.testing.assert_allclose(whole.constraint(1) @ motion[off], motion, atol=1e-12)


def test_one_meshed_sector_equals_all():
    problem = disk()
    frequency = float(problem.frequencies(stuck=True)[0]) - 0.2
    found = []
    for case in (problem, problem.full(reported=[1])):
        balance = HarmonicBalance(case, 1, 24)
        correction = first_point(balance, 2.0 * np.pi * frequency, 2.0)
        assert correction.converged
        found.append(correction.evaluation.w[balance.rows])
    assert np.count_nonzero(correction.evaluation.unknown == 2) > 0
    assert found[1] == pytest.approx(found[0], rel=1e-8, abs=1e-9 * np.abs(found[0]).max())


def test_static_load_of_the_dampers():
    """Without vibration the two lines carry the pull alike: N cos α + T sin α = F_C/2 each."""
    problem = disk(pull=147.0)
    balance = HarmonicBalance(problem, 1, 24)
    mean = balance.carried_forces(first_point(balance, 600.0, 1e-9).evaluation)[:, 0].reshape(2, 5, 3).sum(axis=1)
    angle = np.radians(20.0)
    along = mean[:, 2] * np.cos(angle) + mean[:, 0] * np.sin(angle) * [1.0, -1.0]
    assert along == pytest.approx([73.5, 73.5], rel=2e-3)
    assert mean[0, 2] == pytest.approx(mean[1, 2], rel=1e-9)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (
            lambda: octopus_blisk(sector=COARSE, modes=8, engine_order=7),
            "engine_order must be a whole number and lie between 0 and",
        ),
        (lambda: octopus_blisk("guessed"), "contact must be a known set"),
        (lambda: octopus_blisk(normal_stiffness="Herz"), "normal_stiffness must be a known formula"),
        (lambda: BliskSector(stagger=40.0).body(), "must not be inverted"),
        (lambda: BliskSector(rotation=-1.0), "rotation must not be negative"),
        (lambda: replace(COARSE, rotation=1e5).sector(), "rotation must leave the body its stiffness"),
        (lambda: octopus_blisk(sector=COARSE, modes=8, kty=0.0), "kty must be positive"),
        (lambda: octopus_blisk(sector=COARSE, modes=8, engine_order=1.5), "must be a whole number"),
        (lambda: BliskSector(stagger=80.0), "stagger must lie between"),
        (lambda: BliskSector(damper_length=80e-3), "contact nodes on the platform"),
        (lambda: BliskSector(damper_radius=90e-3), "off the platform"),
        (lambda: BliskSector(shank_thickness=24.0), "pitch at the rim"),
    ],
)
def test_wrong_input(make, words):
    with pytest.raises(InputError, match=words):
        make()


def test_faces_that_do_not_match_are_refused():
    body, left, right = sector().solid, sector().left, sector().right

    with pytest.raises(InputError, match="same number on both"):
        sector_of(body, 6, left, right[1:])
    with pytest.raises(InputError, match="must match turned by 2π/7"):
        sector_of(body, 7, left, right)


def test_kept_nodes_off_the_faces():
    numbers = sector().solid.numbers[sector().left]
    row = int(numbers[numbers[:, 0] >= 0][0, 0])
    with pytest.raises(InputError, match="must not lie on the cyclic faces"):
        cyclic_craig_bampton(sector(), {"rim.x": row}, 4)
