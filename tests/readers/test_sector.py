"""A sector of a bladed disk in the files of CalculiX as a cyclic structure, against the meshed disk itself."""

import re
from dataclasses import replace

import numpy as np
import pytest
from meshed_waves import cyclic_frequencies
from scipy import linalg, sparse

import stickslip as ss
from stickslip.analyses.speed.models import Turning
from stickslip.model.readers.read import read_model
from stickslip.model.readers.sector import Faces, _weights, sector_of_model
from stickslip.model.readers.stress_places import prestress_note, spin_softening
from stickslip.model.rigs.octopus_blisk import BliskSector
from stickslip.model.structure.centrifugal import RotationAxis
from stickslip.model.structure.cyclic_reduction import (
    hermitian,
    lowest_frequencies,
    reduced_waves,
    rotation,
    shared_modes,
    shared_waves,
)

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


@pytest.mark.slow
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


@pytest.mark.slow
def test_the_surface_of_the_following_sector_is_turned_with_its_axes(tmp_path, meshed):
    disk = ss.read_sector(write(tmp_path, meshed), sectors=6, faces=("LOW", "HIGH"), keep=KEEP)
    own = ss.NodeSurface.of(disk, "L", towards=(-1.0, 0.0, 0.0), line=True)
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
        (Faces(6, "TIP", "LOW", RotationAxis((*COARSE.tip()[:2], 0.0))), "off the axis"),
        (Faces(6, "LOW", "LOW"), "must have no node in common"),
        (Faces(7, "LOW", "HIGH", interpolated=True), "must lie on LOW turned by 360°/7"),
        (Faces(6, "HIGH", "LOW", interpolated=True), "which face is low"),
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


def test_rotations_on_the_faces_are_refused(tmp_path, meshed):
    """They would not be joined."""
    model = read_model(write(tmp_path, meshed))
    node = str(meshed.right[np.flatnonzero(meshed.solid.numbers[meshed.right, 0] >= 0)[0]] + 1)
    dofs = (*model.dofs, f"{node}.rx")
    M, K = (sparse.block_diag([matrix, sparse.eye_array(1)], format="csc") for matrix in (model.M, model.K))
    said = f"must have displacements alone, but is '{node}.rx with rotations'. Mesh the sector with solid elements"
    with pytest.raises(ss.InputError, match=re.escape(said)):
        sector_of_model(replace(model, M=M, K=K, dofs=dofs), Faces(6, "LOW", "HIGH"))


def test_matrices_with_the_cyclic_tie_are_refused(tmp_path, meshed):
    """The tie has taken the rows of one face to the other."""
    path = write(tmp_path, meshed, without=meshed.right)
    with pytest.raises(ss.InputError, match="CYCMPC=INACTIVE"):
        ss.read_sector(path, sectors=6, faces=("LOW", "HIGH"), keep={"tip": "TIP"})


@pytest.mark.slow
def test_one_sector_is_the_whole_wheel(meshed):
    """Six sectors in their places, the nodes of their faces merged: all frequencies of the wheel are those of the waves."""
    sectors, size = meshed.sectors, meshed.solid.size
    turns = [rotation(sectors, j) for j in range(sectors)]
    place = np.full((sectors, *meshed.solid.numbers.shape), -1)
    count = 0
    for j in range(sectors):
        for node, row in enumerate(meshed.solid.numbers[:, 0]):
            if row >= 0 and node not in set(meshed.right.tolist()):
                place[j, node] = count + np.arange(3)
                count += 3
    for j in range(sectors):
        place[j, meshed.right] = place[(j + 1) % sectors, meshed.left]
    gathered = []
    for j, turn in enumerate(turns):
        rows, columns, values = [], [], []
        for node, numbers in enumerate(meshed.solid.numbers):
            if numbers[0] >= 0:  # own axes from those of the wheel: u = Rᵀ U
                rows += np.repeat(numbers, 3).tolist()
                columns += np.tile(place[j, node], 3).tolist()
                values += turn.T.ravel().tolist()
        gathered.append(sparse.csr_array((values, (rows, columns)), shape=(size, count)))
    K, M = (sum(T.T @ A @ T for T in gathered) for A in (meshed.solid.K, meshed.solid.M))
    squares = sparse.linalg.eigsh(sparse.csc_array(K), 18, sparse.csc_array(M), sigma=0.0, return_eigenvectors=False)
    waves = [np.repeat(lowest_frequencies(meshed, n, 6), 1 if n in (0, 3) else 2) for n in range(4)]
    assert np.sort(np.concatenate(waves))[:18] == pytest.approx(np.sort(np.sqrt(squares)) / (2.0 * np.pi), rel=1e-6)


def test_a_face_is_interpolated_between_the_nodes_of_the_other():
    """Quadratic fields on a curved face are exact to its curvature, and nodes that coincide take the displacement as it is."""
    u, v = (each.ravel() for each in np.meshgrid(np.linspace(0.0, 1.0, 6), np.linspace(0.0, 2.0, 9)))
    nodes = np.column_stack([u, v, 0.0 * u])
    points = np.vstack([nodes[7], np.random.default_rng(1).uniform((0.0, 0.0), (1.0, 2.0), (30, 2)) @ np.eye(2, 3)])
    weights, apart = _weights(nodes, points)
    for field in (
        lambda p: 1.0 + 0.0 * p[:, 0],
        lambda p: p[:, 0] - 3.0 * p[:, 1],
        lambda p: p[:, 0] * p[:, 1] - 2.0 * p[:, 1] ** 2,
    ):
        np.testing.assert_allclose(weights @ field(nodes), field(points), atol=1e-9)
    assert weights[[0]].toarray().max() == 1.0
    assert apart < 1e-9
    _, off = _weights(nodes, points + np.array([0.0, 0.0, 0.03]))
    assert off == pytest.approx(0.03)


@pytest.mark.slow
def test_an_interpolated_sector_has_the_frequencies_of_the_paired_one(tmp_path, meshed):
    """One node of the low face given away: its partner is interpolated, which changes frequencies little, as the note says."""
    path = write(tmp_path, meshed)
    text = (tmp_path / "disk.inp").read_text()
    middle = meshed.left[
        np.argmin(np.linalg.norm(meshed.solid.points[meshed.left] - meshed.solid.points[meshed.left].mean(axis=0), axis=1))
    ]
    low, rest = text.split("*NSET, NSET=HIGH")
    (tmp_path / "disk.inp").write_text(low.replace(f"\n{middle + 1},\n", "\n") + "*NSET, NSET=HIGH" + rest)
    notes = []
    options = {"sectors": 6, "faces": ("LOW", "HIGH"), "keep": KEEP, "progress": lambda share, text: notes.append(text)}
    disk = ss.read_sector(path, interpolated=True, **options)
    said = re.search(r"change by up to (\S+) %", "\n".join(notes))
    for n in range(4):
        exact = cyclic_frequencies(meshed, n, 3)
        assert frequencies(disk, n) == pytest.approx(exact, rel=0.05)
    assert 0.0 < float(said[1]) < 5.0


@pytest.mark.parametrize("square", [0.0, 1.0])
def test_the_speed_of_a_stiffness_is_known_by_its_spin_softening(tmp_path, meshed, square):
    """Elastic stiffness, and stress stiffness whose forces on each node cancel, do not resist a translation; −Ω² M does."""
    rate = 500.0
    across = np.ones(meshed.solid.size)
    across[meshed.solid.numbers[:, 2]] = 0.0
    softening = sparse.diags_array(across) @ meshed.solid.M
    softened = replace(meshed, solid=replace(meshed.solid, K=meshed.solid.K - square * rate**2 * softening))
    model = read_model(write(tmp_path, softened))
    assert spin_softening(model, RotationAxis()) == pytest.approx(square * rate, rel=1e-6)
    assert prestress_note(model, RotationAxis(), None).startswith("K contains") == bool(square)
    if square:
        with pytest.raises(ss.InputError, match=re.escape("Write 4774.65")):
            prestress_note(model, RotationAxis(), 500.0)


def turned(sector, angle):
    """The sector with the K that it has turned about the axis at every node: the same frequencies, and other soft motions."""
    turn = sparse.lil_array(sparse.eye_array(sector.solid.size))
    for x, y, _ in sector.solid.numbers[sector.solid.numbers[:, 0] >= 0]:
        turn[np.ix_([x, y], [x, y])] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return replace(sector, solid=replace(sector.solid, K=sparse.csc_array(turn @ sector.solid.K @ turn.T)))


@pytest.mark.parametrize(("angle", "n"), [(0.03, 0), (0.03, 2), (0.0, 2)])
def test_a_sector_at_two_speeds_has_its_own_frequencies_at_both_and_between(meshed, angle, n):
    """Against the whole mesh; static displacements are exact with the load that shapes lack, of the slow one."""
    numbers = meshed.solid.numbers
    kept = {f"{node}.{axis}": numbers[node, k] for node in (meshed.solid.node(COARSE.tip()),) for k, axis in enumerate("xyz")}
    load = meshed.solid.M @ np.ones((meshed.solid.size, 1))
    ends = [turned(meshed, each) for each in (0.0, angle)]
    (wave,) = shared_waves(ends, kept, 20, [n], loads=load)
    T, size = wave.transformation, shared_modes(kept, 20)
    assert (size, wave.M.shape) == (43, (46, 46))
    K = [hermitian(T.conj().T @ (end.solid.K @ T)) for end in ends]
    turning = Turning.between(wave.M, *K)
    own = lowest_frequencies(meshed, n, 3)
    # The straight line makes the lowest one 47 % too high.
    for each, within in ((K[0], 1e-4), (K[1], 1e-4), (turning.at(0.5), 0.03)):
        assert np.sqrt(linalg.eigh(each, wave.M, eigvals_only=True)[:3]) / (2.0 * np.pi) == pytest.approx(own, rel=within)
    np.testing.assert_allclose(T[list(kept.values())], np.eye(3, 46), atol=1e-12)
    np.testing.assert_allclose(wave.M[3:, 3:], np.eye(43), atol=1e-9)
    joined = meshed.constraint(n)
    exact = joined @ sparse.linalg.spsolve(meshed.matrices(n)[1].tocsc(), (joined.conj().T @ load)[:, 0])
    (slow,) = reduced_waves(ends[0], kept, 20, [n], loads=load)
    for each in (wave, slow):
        found = each.transformation @ np.linalg.solve(each.K, each.transformation.conj().T @ load[:, 0]) + each.beyond[:, 0]
        np.testing.assert_allclose(found, exact, atol=1e-9 * np.abs(exact).max())
    (alone,) = reduced_waves(ends[1], kept, 20, [n])
    np.testing.assert_allclose(
        np.linalg.inv(K[1])[:3, :3], np.linalg.inv(alone.K)[:3, :3], rtol=1e-3, atol=1e-6 / np.abs(alone.K).max()
    )


@pytest.mark.slow
def test_models_at_two_speeds_are_one_disk(tmp_path, meshed):
    """Each has its own frequencies, in one set of coordinates, though both have the same shapes."""
    paths = {}
    for speed, factor in ((0.0, 1.0), (3000.0, 1.03)):
        folder = tmp_path / f"{speed:g}"
        folder.mkdir()
        paths[speed] = write(folder, replace(meshed, solid=replace(meshed.solid, K=meshed.solid.K * factor)))
    disks = ss.read_sector_at_speeds(paths, sectors=6, faces=("LOW", "HIGH"), keep=KEEP)
    for speed, factor in ((0.0, 1.0), (3000.0, 1.03)):
        for n in (0, 2):
            assert frequencies(disks[speed], n) == pytest.approx(cyclic_frequencies(meshed, n, 3) * factor**0.5, rel=1e-4)


def test_complex_matrices_of_one_nodal_diameter_are_refused(tmp_path, meshed):
    """CalculiX writes the real and the imaginary part as 2n rows, and n names."""
    path = write(tmp_path, meshed)
    size = meshed.solid.size
    for ending in (".sti", ".mas"):
        with (tmp_path / f"disk{ending}").open("a") as file:
            file.write(f"{2 * size} {2 * size} 1.0\n")
    with pytest.raises(ss.InputError, match="CYCMPC=INACTIVE"):
        ss.read_sector(path, sectors=6, faces=("LOW", "HIGH"), keep=KEEP)


def test_face_nodes_with_axes_of_their_own_are_refused(tmp_path, meshed):
    """As Nastran's CD turns their rows: the mass then couples x, y and z of neighbours."""
    model = read_model(write(tmp_path, meshed))
    turn = sparse.lil_array(sparse.eye_array(model.size))
    for node in meshed.left + 1:
        rows = [model.rows.get(f"{node}.{axis}", -1) for axis in "xyz"]
        if rows[0] >= 0:
            turn[np.ix_(rows, rows)] = rotation(5) @ np.roll(np.eye(3), 1, axis=0)
    M, K = (sparse.csc_array(turn @ A @ turn.T) for A in (model.M, model.K))
    turned = replace(model, M=M, K=K, notes=("disk.bdf has 25 nodes with axes of their own",))
    with pytest.raises(ss.InputError, match="must have rows along x, y and z of the model"):
        sector_of_model(turned, Faces(6, "LOW", "HIGH"))
    along = replace(turned, M=model.M, K=model.K)
    assert sector_of_model(along, Faces(6, "LOW", "HIGH")).notes
