"""A sector of a bladed disk in the files of CalculiX as a cyclic structure, against the meshed disk itself."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy import linalg, sparse

import stickslip as ss
from stickslip.models.read import read_model
from stickslip.models.sector import Faces, sector_of_model
from stickslip.rigs.blisk_sector import BliskSector
from stickslip.structure.cyclic_reduction import cyclic_frequencies, rotation
from stickslip.structure.rotation_axis import RotationAxis

COARSE = BliskSector(sectors=6, cells=(1, 1, 1))


@pytest.fixture(scope="module")
def meshed():
    return COARSE.sector()


def write(folder, sector, order=(0, 1, 2), without=()):
    """The sector as disk.sti, .mas, .dof and .inp in SI; order: the axes that become x, y and z; without: nodes without rows."""
    body, edge = sector.solid, COARSE.contact_nodes()
    numbers = body.numbers.copy()
    numbers[list(without)] = -1
    rows = [(node + 1, axis + 1, numbers[node, order[axis]]) for node in range(len(numbers)) for axis in range(3)]
    rows = [(node, axis, row) for node, axis, row in rows if row >= 0]
    kept = np.array([row for *_, row in rows])
    K, M = (matrix[kept][:, kept] for matrix in (body.K, body.M))
    places = sparse.triu(K).tocoo()
    for ending, matrix in ((".sti", K), (".mas", M)):
        table = np.column_stack([places.row + 1, places.col + 1, matrix[places.row, places.col]])
        np.savetxt(folder / f"disk{ending}", table, fmt=("%d", "%d", "%.15e"))
    (folder / "disk.dof").write_text("".join(f"{node}.{axis}\n" for node, axis, _ in rows))
    text = "*NODE\n" + "".join(f"{k + 1}, {p[0]:.12e}, {p[1]:.12e}, {p[2]:.12e}\n" for k, p in enumerate(body.points[:, order]))
    sets = {"LOW": sector.left, "HIGH": sector.right, "TIP": [body.node(COARSE.tip())]}
    for side in ("right", "left"):
        sets[side.upper()] = [body.node(point) for name, point in edge.items() if name.startswith(side)]
    text += "".join(f"*NSET, NSET={name}\n" + "".join(f"{node + 1},\n" for node in nodes) for name, nodes in sets.items())
    (folder / "disk.inp").write_text(text)
    return folder / "disk.sti"


KEEP = {"tip": "TIP", "R": "RIGHT", "L": "LEFT"}


def frequencies(disk, nodal_diameter, number=3):
    waves = disk.at(nodal_diameter)
    return np.sqrt(linalg.eigh(waves.K, waves.M, eigvals_only=True)[:number]) / (2.0 * np.pi)


@pytest.mark.parametrize(("axis", "order"), [("z", (0, 1, 2)), ("x", (2, 0, 1))])
def test_frequencies_are_those_of_the_meshed_disk(tmp_path, meshed, axis, order):
    """About any axis."""
    disk = ss.read_sector(write(tmp_path, meshed, order), sectors=6, faces=("LOW", "HIGH"), keep=KEEP, axis=axis)
    assert disk.sectors == 6
    for n in range(4):
        assert frequencies(disk, n) == pytest.approx(cyclic_frequencies(meshed, n, 3), rel=1e-4)
    assert set(disk.sets) == set(KEEP)
    assert len(disk.sets["R"]) == 5


def test_a_pair_is_held_where_either_of_its_nodes_is(tmp_path, meshed):
    pairs = np.flatnonzero(meshed.solid.numbers[meshed.left, 0] >= 0)
    both = [*meshed.left[pairs[:2]], *meshed.right[pairs[:2]]]
    (tmp_path / "both").mkdir()
    disks = [
        ss.read_sector(write(folder, meshed, without=held), sectors=6, faces=("LOW", "HIGH"), keep={"tip": "TIP"})
        for folder, held in ((tmp_path, both[2:]), (tmp_path / "both", both))
    ]
    assert frequencies(disks[0], 1) == pytest.approx(frequencies(disks[1], 1), rel=1e-9)
    assert frequencies(disks[0], 1)[0] > 1.0001 * cyclic_frequencies(meshed, 1, 1)[0]


def test_the_surface_of_the_following_sector_is_turned_with_its_axes(tmp_path, meshed):
    disk = ss.read_sector(write(tmp_path, meshed), sectors=6, faces=("LOW", "HIGH"), keep=KEEP)
    own = ss.NodeSurface.of(disk, "L", towards=(-1.0, 0.0, 0.0))
    following, turn = own.following(disk), rotation(6)
    assert following.nodes == tuple(f"next/{name}" for name in own.nodes)
    np.testing.assert_allclose(following.points, own.points @ turn.T, atol=1e-15)
    np.testing.assert_allclose(following.normals, own.normals @ turn.T, atol=1e-15)
    local, direction = np.array([0.3, -0.5, 0.7]), np.array([0.2, 0.9, -0.4])
    seen = following.motion(1)(direction)
    moved = sum(seen[f"next/{own.nodes[1]}.{axis}"] * value for axis, value in zip("xyz", local, strict=True))
    assert moved == pytest.approx(direction @ turn @ local)


def test_what_is_no_sector_is_refused(tmp_path, meshed):
    path = write(tmp_path, meshed)
    model = read_model(path)
    for faces, words in (
        (Faces(7, "LOW", "HIGH"), "but they match for sectors = 6."),
        (Faces(7, "HIGH", "LOW"), "but they match for sectors = 6, with low and high exchanged."),
        (Faces(6, "HIGH", "LOW"), "is turned by −360°/6. Exchange low and high, or reverse the direction of the axis."),
        (Faces(6, "LOW", "HIGH", RotationAxis((0.01, 0.0, 0.0))), "have no partner"),
        (Faces(6, "LOW", "UP"), "must be a set of nodes of the model"),
        (Faces(6, "LOW", "TIP"), 'write faces = "interpolated"'),
        (Faces(6, "TIP", "TIP", RotationAxis((*COARSE.tip()[:2], 0.0))), "off the axis"),
        (Faces(1, "LOW", "HIGH"), "sectors must be at least 2"),
    ):
        with pytest.raises(ss.InputError, match=re.escape(words)):
            sector_of_model(model, faces)
    with pytest.raises(ss.InputError, match='must be "x", "y", "z"'):
        ss.read_sector(path, sectors=6, faces=("LOW", "HIGH"), keep=KEEP, axis="r")
    with pytest.raises(ss.InputError, match="must not lie on the cyclic faces"):
        ss.read_sector(path, sectors=6, faces=("LOW", "HIGH"), keep={"face": "LOW"})
    node = str(meshed.right[np.flatnonzero(meshed.solid.numbers[meshed.right, 0] >= 0)[0]] + 1)
    kept = [row for row, name in enumerate(model.dofs) if name != f"{node}.z"]
    dofs = tuple(model.dofs[row] for row in kept)
    half = replace(model, M=model.M[kept][:, kept], K=model.K[kept][:, kept], dofs=dofs)
    with pytest.raises(ss.InputError, match="must be free or fixed in all three directions"):
        sector_of_model(half, Faces(6, "LOW", "HIGH"))


def test_matrices_with_the_cyclic_tie_are_refused(tmp_path, meshed):
    """The tie has taken the rows of one face to the other."""
    path = write(tmp_path, meshed, without=meshed.right)
    with pytest.raises(ss.InputError, match="CYCMPC=INACTIVE"):
        ss.read_sector(path, sectors=6, faces=("LOW", "HIGH"), keep={"tip": "TIP"})
