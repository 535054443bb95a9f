"""Stress at nodes of a user's own mesh: against CalculiX, beam theory, the unreduced body, and waves of a sector."""

from dataclasses import replace

import numpy as np
import pytest
from readers.test_sector import COARSE, write
from scipy.sparse import linalg as sparse_linalg
from structure.calculix_elements import CALCULIX
from structure.cantilever import LENGTH, THICKNESS, cantilever, static_stress

import stickslip as ss
from stickslip.analyses.mistuning.work import blade_margins, population_dataset, smallest_blade_margin
from stickslip.analyses.stress import margins, own_recovery, smallest_margin
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.problem.at_rest import normal_loads_at_rest
from stickslip.model.readers.deck import OWN_AXES
from stickslip.model.readers.read import read_model
from stickslip.model.readers.sector import Faces, sector_of_model
from stickslip.model.readers.stress_places import MOST_PLACES, StrainGauge, rotation_stress_of_body, stress_rows_of
from stickslip.model.structure.centrifugal import RotationAxis
from stickslip.model.structure.cyclic_reduction import sector_of
from stickslip.model.structure.mesh_surface import HEXAHEDRON_OF_SKFEM
from stickslip.model.structure.solid import BRICK, BRICK_EDGES, STEEL, Material, box_mesh, solid
from stickslip.model.structure.stress import COMPONENTS, joined, nodal_stress, von_mises
from stickslip.show.report.stress import strain_table
from stickslip.study import job

NODES = BRICK[np.array([*((k, k) for k in range(8)), *BRICK_EDGES])].mean(axis=1)
MATERIAL = f"*MATERIAL, NAME=STEEL\n*ELASTIC\n{STEEL.young}, {STEEL.poisson}\n*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL\n"


@pytest.mark.parametrize("kind", CALCULIX)
def test_stress_at_nodes_is_that_of_calculix(kind):
    points, motion, expected = (np.array(each) for each in CALCULIX[kind])
    rows = nodal_stress(kind, 1e-3 * points, Material(200e9, 0.3))
    found = np.einsum("ncmx,mx->nc", rows, 1e-3 * motion)
    np.testing.assert_allclose(found, 1e6 * expected, atol=3e-5 * 1e6 * np.abs(expected).max())


def elements(mesh, points, kind="C3D20R"):
    """The cells of a hexahedral mesh as elements with their nodes among points (n, 3)."""
    weights = np.prod(np.where(BRICK[None], NODES[:, None], 1.0 - NODES[:, None]), axis=2)  # trilinear, of the corners
    lines = []
    for number, cell in enumerate(mesh.t.T, start=1):
        corners = mesh.p[:, cell[list(HEXAHEDRON_OF_SKFEM)]].T
        if np.linalg.det(corners[[1, 3, 4]] - corners[0]) < 0.0:
            corners = corners[[4, 5, 6, 7, 0, 1, 2, 3]]
        places = weights @ corners
        nodes = [str(1 + int(np.linalg.norm(points - place, axis=1).argmin())) for place in places]
        lines.append(f"{number}, {', '.join(nodes[:10])},\n{', '.join(nodes[10:])}\n")
    return f"*ELEMENT, TYPE={kind}, ELSET=ALL\n{''.join(lines)}{MATERIAL}"


@pytest.fixture(scope="module")
def beam(tmp_path_factory):
    """The files of CalculiX of the clamped box in SI, its mesh and its body."""
    mesh, body, _, _ = cantilever(20)
    folder = tmp_path_factory.mktemp("beam")
    sector = replace(COARSE.sector(), solid=body, left=np.array([0]), right=np.array([0]))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(type(COARSE), "contact_nodes", lambda self: {})
        patch.setattr(type(COARSE), "tip", lambda self: (0.0, LENGTH, 0.0))
        write(folder, sector)
    deck = folder / "disk.inp"
    deck.write_text(deck.read_text() + elements(mesh, body.points))
    return deck, mesh, body


MIDDLE = (0.5 * THICKNESS, 0.5 * LENGTH, 0.0)


def test_bending_stress_of_a_cantilever(beam):
    """σ_yy = −F (L − y) x/I of beam theory, and the same from the reduced model as from the whole one."""
    deck, _, body = beam
    where = {"middle": MIDDLE, "clamp": (0.5 * THICKNESS, 0.0, 0.0)}
    model = read_model(deck)
    rows = stress_rows_of(model, where)
    assert "have no rows and count as fixed" in rows.notes[0]
    load = np.zeros(model.size)
    load[model.rows[f"{body.node((0.0, LENGTH, 0.0)) + 1}.x"]] = 100.0
    whole = (rows.rows @ sparse_linalg.spsolve(model.K, load)).reshape(2, 6)
    assert whole[0, 1] == pytest.approx(static_stress(100.0, MIDDLE), rel=0.01)
    assert von_mises(whole[0]) == pytest.approx(abs(whole[0, 1]), rel=0.03)
    assert whole[1, 1] == pytest.approx(static_stress(100.0, where["clamp"]), rel=0.2), "a singular place, but not without stress"
    blade = ss.read_structure(deck, keep={"tip": "TIP"}, modes=4, stress=where)
    (recovery,) = blade.stresses
    assert recovery.places == ("middle", "clamp")
    pushed = np.zeros(blade.size)
    pushed[blade.index("tip.x")] = 100.0
    np.testing.assert_allclose(recovery.rows @ np.linalg.solve(blade.K, pushed), whole, atol=1e-7 * np.abs(whole).max())


def centrifugal(y):
    """σ_yy = ρ Ω² (R (L − y) + (L² − y²)/2) of a rod from 0 to L that turns with 6000 rev/min, its foot at R = 0.3 m."""
    return STEEL.density * (200.0 * np.pi) ** 2 * (0.3 * (LENGTH - y) + 0.5 * (LENGTH**2 - y**2))


def test_a_rotating_blade_has_the_stress_of_a_rod(beam):
    deck, _, _ = beam
    said = []
    where = {"middle": (0.0, 0.5 * LENGTH, 0.0)}
    options = {"keep": {"tip": "TIP"}, "modes": 4, "stress": where, "axis": ((0.0, -0.3, 0.0), (0.0, 0.0, 2.0))}
    blade = ss.read_structure(deck, speed=6000.0, progress=lambda share, text: said.append(text), **options)
    found = blade.stresses[0].rotation[0]
    assert found[1] == pytest.approx(centrifugal(0.5 * LENGTH), rel=0.01)
    assert np.abs(np.delete(found, 1)).max() < 0.02 * found[1]
    assert any("contains the stress due to rotation at 6000 rev/min" in text for text in said)
    rig = ss.Problem(blade.with_damping(ss.ModalDamping(0.01)), (), (ss.Force("tip.x", 1.0),), ("tip.x",))
    mean = ss.forced_response(rig, [10.0], harmonics=1).with_stress().dataset["stress_mean"].values[0, 0, 0]
    np.testing.assert_allclose(mean, found, rtol=1e-9)
    at_rest = ss.read_structure(deck, **options)
    assert at_rest.stresses[0].rotation is None
    # The same by the load, of which four modes show little, and what these lack.
    turning, load = ss.in_rotation(at_rest.with_damping(ss.ModalDamping(0.01)), 6000.0, options["axis"])
    rig = ss.Problem(turning, (), (ss.Force("tip.x", 1.0), load), ("tip.x",))
    loaded = ss.forced_response(rig, [10.0], harmonics=1).with_stress().dataset["stress_mean"].values[0, 0, 0]
    np.testing.assert_allclose(loaded, mean, atol=1e-7 * mean.max())
    assert turning.stresses[0].rotation[0, 1] > 0.3 * mean[1]
    with pytest.raises(ss.InputError, match="must be read without speed"):
        ss.in_rotation(blade, 6000.0)
    with pytest.raises(ss.InputError, match="must go with places of stress"):
        ss.read_structure(deck, keep={"tip": "TIP"}, modes=4, speed=6000.0)


def test_what_has_no_stress_due_to_rotation_is_refused(beam):
    model = read_model(beam[0])
    rows = stress_rows_of(model, {"middle": MIDDLE}).rows
    with pytest.raises(ss.InputError, match="must have rows along x, y and z"):
        rotation_stress_of_body(replace(model, notes=(f"nodes with {OWN_AXES}",)), rows, RotationAxis(), 100.0)
    with pytest.raises(ss.InputError, match="must have coordinates, but is 'none'"):
        rotation_stress_of_body(replace(model, nodes={}), rows, RotationAxis(), 100.0)
    with pytest.raises(ss.InputError, match="must be held by its supports"):
        rotation_stress_of_body(replace(model, K=0.0 * model.K + model.M * 0.0), rows, RotationAxis(), 100.0)


def test_constant_strain_gives_its_stress_at_every_node_of_a_set(beam):
    """The whole of a set, with names NAME/NODE, and where elements of one node are averaged."""
    deck, _, body = beam
    model = read_model(deck)
    inner = [k for k in range(len(body.points)) if body.points[k, 1] > 0.021][: MOST_PLACES - 1]
    model = replace(model, sets={"INNER": tuple(str(k + 1) for k in inner)})
    rows = stress_rows_of(model, {"all": "INNER"})
    assert next(iter(rows.nodes)) == f"all/{inner[0] + 1}"
    gradient = np.array([[1.0, 0.4, -0.2], [0.1, -0.7, 0.3], [0.5, 0.2, 0.9]]) * 1e-3
    motion = np.zeros(model.size)
    for dof, row in model.rows.items():
        node, _, axis = dof.rpartition(".")
        motion[row] = (gradient @ body.points[int(node) - 1])["xyz".index(axis)]
    lam, shear = STEEL.lame
    strain = 0.5 * (gradient + gradient.T)
    sigma = lam * np.trace(strain) * np.eye(3) + 2.0 * shear * strain
    expected = [sigma[0, 0], sigma[1, 1], sigma[2, 2], sigma[0, 1], sigma[1, 2], sigma[2, 0]]
    found = (rows.rows @ motion).reshape(-1, 6)
    np.testing.assert_allclose(found, np.tile(expected, (len(inner), 1)), rtol=1e-8)
    for along in np.vstack([np.eye(3), [[3.0, -1.0, 2.0], [0.0, 1.0, 1.0], [-2.0, 0.5, 0.0]]]):
        gauge = stress_rows_of(model, {"g": StrainGauge(inner[0] + 1, along)})
        measured = gauge.gauges["g"] @ (gauge.rows @ motion)
        assert measured == pytest.approx(along @ strain @ along / (along @ along), rel=1e-8)


def test_two_bodies_have_the_places_of_both(beam):
    deck = beam[0]
    blades = {
        name: ss.read_structure(deck, keep={"tip": "TIP"}, modes=4, stress={"middle": MIDDLE}) for name in ("left", "right")
    }
    pair = ss.assemble(blades)
    rig = ss.Problem(pair.with_damping(ss.ModalDamping(0.01)), (), (ss.Force("right/tip.x", 100.0),), ("right/tip.x",))
    stress = ss.forced_response(rig, [10.0]).stress(0, 0)
    assert stress["place"].values.tolist() == ["left/middle", "right/middle"]
    bending = stress["amplitude"].sel(component="yy")
    assert float(bending[1]) == pytest.approx(abs(static_stress(100.0, MIDDLE)), rel=0.01)
    assert float(bending[0]) < 1e-9 * float(bending[1])
    plain = ss.Problem(ss.read_structure(deck, keep={"tip": "TIP"}, modes=4), (), (ss.Force("tip.x", 1.0),), ("tip.x",))
    with pytest.raises(ss.InputError, match="Stress needs places"):
        ss.forced_response(plain, [10.0]).with_stress()


def test_a_strain_gauge_measures_the_bending_strain_and_its_limit(beam):
    """Along the beam σ/E, across it −ν σ/E, at each of both force levels; the limit grows with the margin."""
    along, across = StrainGauge(MIDDLE, (0.0, 2.0, 0.0)), StrainGauge(MIDDLE, (0.0, 0.0, 1.0))
    blade = ss.read_structure(beam[0], keep={"tip": "TIP"}, modes=4, stress={"along": along, "across": across, "middle": MIDDLE})
    pair = ss.assemble({"blade": blade}).with_damping(ss.ModalDamping(0.01))
    rig = ss.Problem(pair, (), (ss.Force("blade/tip.x", 100.0), ss.Force("blade/tip.x", static=400.0)), ("blade/tip.x",))
    response = ss.forced_response(rig, [10.0], [1.0, 2.0]).with_stress().with_fatigue(ss.FatigueLimit(400e6, 900e6))
    strain = response.dataset["strain_amplitude"]
    assert strain["gauge"].values.tolist() == ["blade/along", "blade/across"]
    expected = abs(static_stress(100.0, MIDDLE)) / STEEL.young
    np.testing.assert_allclose(strain.sel(gauge="blade/along").values[:, 0], [expected, 2.0 * expected], rtol=0.01)
    np.testing.assert_allclose(strain.sel(gauge="blade/across"), STEEL.poisson * strain.sel(gauge="blade/along"), rtol=0.03)
    table = strain_table(response.dataset)
    margin = min(found.size for found in margins(response.dataset) if found.case == 1)
    (row,) = table[(table.force_level == 2.0) & (table.gauge == "blade/along")].itertuples(index=False)
    assert row[4] == pytest.approx(margin * row[3], rel=1e-12)


@pytest.fixture(scope="module")
def disk_deck(tmp_path_factory):
    sector = COARSE.sector()
    deck = write(tmp_path_factory.mktemp("disk"), sector).with_suffix(".inp")
    deck.write_text(deck.read_text() + elements(COARSE.mesh(), sector.solid.points))
    return deck


@pytest.fixture(scope="module")
def small_disk(disk_deck):
    place = {"root": int(read_model(disk_deck).sets["RIGHT"][0])}
    disk = ss.read_sector(disk_deck, sectors=6, faces=("LOW", "HIGH"), keep={"tip": "TIP"}, modes=8, stress=place)
    damped = disk.with_damping(ss.ModalDamping(0.01))
    return TunedDisk(damped, (), (ss.Force("tip.x", 1.0),), ("tip.x",), engine_order=2)


def test_stress_in_all_sectors_under_a_load_on_one_is_that_of_the_unreduced_waves(disk_deck, small_disk):
    """u_j = Σ_n K_n⁻¹ p exp(−i n 2π j/N)/N of the unreduced sector, of a static load on sector 1."""
    full = small_disk.full()
    recovery = own_recovery(full)
    load = np.zeros(full.structure.size)
    load[full.structure.index("1/tip.x")] = 1.0
    found = recovery.rows @ np.linalg.solve(full.structure.K, load)
    model = read_model(disk_deck)
    read = sector_of_model(model, Faces(6, "LOW", "HIGH"))
    place = {"root": int(model.sets["RIGHT"][0])}
    rows = stress_rows_of(model, place).rows[:, np.flatnonzero(read.rows >= 0)]
    own = np.zeros(read.sector.solid.size)
    own[read.rows[model.rows[f"{model.sets['TIP'][0]}.x"]]] = 1.0
    waves = []
    for n in range(6):
        T = read.sector.constraint(n)
        waves.append(rows @ (T @ sparse_linalg.spsolve((T.conj().T @ read.sector.solid.K @ T).tocsc(), T.conj().T @ own)))
    expected = np.fft.fft(waves, axis=0).real / 6.0
    assert recovery.places == tuple(f"{j}/root" for j in range(1, 7))
    np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())
    np.testing.assert_allclose(own_recovery(full).rows[2:4], joined(full.stresses).of_whole_disk([3, 4]).rows, atol=0.0)


def test_stress_of_mistuned_blades_is_that_of_their_disk(small_disk):
    """Of each blade at its own largest amplitude, against the stress along the response of the whole disk."""
    lowest = float(small_disk.frequencies(stuck=True)[0])
    at = [0.99 * lowest, lowest, 1.01 * lowest]
    tuned = ss.mistuned_response(small_disk, at, ss.Mistuning(), harmonics=1, samples=96)
    stress = tuned.dataset["stress_von_mises"].values[0, :, 0]
    np.testing.assert_allclose(stress, float(tuned.dataset["tuned_stress_von_mises"][0]), rtol=1e-9)
    mistuning = ss.Mistuning(blade=[0.02, -0.01, 0.0, 0.01, -0.02, 0.015])
    population = ss.mistuned_response(small_disk, at, mistuning, harmonics=1, samples=96)
    found = population.dataset
    response = ss.forced_response(ss.mistuned_disk(small_disk, mistuning), at, harmonics=1, samples=96).with_stress().dataset
    points = response["amplitude"].values[0].argmax(axis=0)
    for name in ("stress_von_mises", "stress_alternating"):
        expected = [response[name].sel(place=f"{j + 1}/root").values[0, point] for j, point in enumerate(points)]
        np.testing.assert_allclose(found[name].values[0, :, 0], expected, rtol=1e-9)
    assert np.ptp(found["stress_von_mises"].values) > 0.005 * found["stress_von_mises"].values.max()
    largest, ratio = 1e-6 * float(found["stress_von_mises"].max()), 1e-6 * float(found["tuned_stress_von_mises"].max())
    assert f"largest von Mises stress {largest:.4g} MPa" in str(population).replace("\xa0", " ")
    assert f"of the tuned disk {ratio:.4g} MPa" in str(population).replace("\xa0", " ")


@pytest.mark.parametrize("equivalent", ["sines", "von_mises", "principal"])
def test_margins_of_mistuned_blades_are_those_of_their_disk(small_disk, equivalent):
    """Against the margin along the response of the whole disk, at the largest amplitude of each blade."""
    lowest = float(small_disk.frequencies(stuck=True)[0])
    at = [0.99 * lowest, lowest, 1.01 * lowest]
    mistuning = ss.Mistuning(blade=[0.02, -0.01, 0.0, 0.01, -0.02, 0.015])
    limit = ss.FatigueLimit(fatigue_strength=4e8, ultimate_strength=9e8)
    population = ss.mistuned_response(small_disk, at, mistuning, harmonics=1, samples=96)
    found = population.with_fatigue(limit, {"root": 2e8}, equivalent)
    disk = ss.forced_response(ss.mistuned_disk(small_disk, mistuning), at, harmonics=1, samples=96).with_stress()
    every = {f"{j}/root": 2e8 for j in range(1, 7)}
    response = disk.with_fatigue(limit, every, equivalent).dataset
    points = response["amplitude"].values[0].argmax(axis=0)
    for name in ("fatigue_amplitude", "fatigue_mean", "fatigue_limit"):
        expected = [response[name].sel(place=f"{j + 1}/root").values[0, point] for j, point in enumerate(points)]
        np.testing.assert_allclose(found.dataset[name].values[0, :, 0], expected, rtol=1e-8)
    margins = blade_margins(found.dataset).values[0, :, 0]
    worst = smallest_blade_margin(found.dataset)
    assert (worst.sample, worst.blade, worst.place) == (1, int(margins.argmin()) + 1, "root")
    assert worst.size == pytest.approx(margins.min(), rel=1e-12)
    if equivalent == "sines":
        tuned = ss.forced_response(small_disk, at, harmonics=1, samples=96).with_stress().with_fatigue(limit, {"root": 2e8})
        highest = tuned.dataset.isel(point=[int(tuned.dataset["amplitude"].values.argmax())])
        assert worst.tuned == pytest.approx(smallest_margin(highest).size, rel=1e-8)
        said = f"smallest fatigue margin {worst.size:.4g} (Goodman): blade {worst.blade}, root, at {worst.frequency:.5g} Hz"
        assert said in str(found).replace("\xa0", " ")
    assert smallest_blade_margin(population.dataset) is None


@pytest.mark.parametrize("engine_order", [pytest.param(1, marks=pytest.mark.slow), pytest.param(2, marks=pytest.mark.slow), 5])
def test_stress_of_a_travelling_wave_is_that_of_the_unreduced_sector(disk_deck, engine_order):
    """Static force of each engine order: K_n u = p of the whole sector, also where the wave runs against the numbering."""
    faces = Faces(6, "LOW", "HIGH")
    place = {"root": int(read_model(disk_deck).sets["RIGHT"][0])}
    disk = ss.read_sector(disk_deck, sectors=6, faces=("LOW", "HIGH"), keep={"tip": "TIP"}, modes=8, stress=place)
    rig = TunedDisk(disk, (), (ss.Force("tip.x", 1.0),), ("tip.x",), engine_order=engine_order)
    found = ss.forced_response(rig, [1e-3]).stress(0, 0)["stress"].values[0, :, 1]
    model = read_model(disk_deck)
    read = sector_of_model(model, faces)
    n = min(engine_order, 6 - engine_order)
    T = read.sector.constraint(n)
    load = np.zeros(read.sector.solid.size)
    load[read.rows[model.rows[f"{model.sets['TIP'][0]}.x"]]] = 1.0
    K = (T.conj().T @ read.sector.solid.K @ T).tocsc()
    motion = T @ sparse_linalg.spsolve(K, T.conj().T @ load)
    rows = stress_rows_of(model, place).rows[:, np.flatnonzero(read.rows >= 0)]
    expected = rows @ (motion if n == engine_order else motion.conj())
    np.testing.assert_allclose(found[:, 0] + 1j * found[:, 1], expected, atol=1e-6 * np.abs(expected).max())
    assert np.abs(expected.imag).max() > 1e-3 * np.abs(expected).max()


@pytest.mark.slow
def test_stress_of_a_disk_without_contacts_is_that_of_its_resonance(disk_deck):
    """A contact that always slips at a small limit changes little; the disk without any, solved at its own resonance."""
    place = {"root": int(read_model(disk_deck).sets["RIGHT"][0])}
    disk = ss.read_sector(disk_deck, sectors=6, faces=("LOW", "HIGH"), keep={"tip": "TIP"}, modes=8, stress=place)
    disk = disk.with_damping(ss.ModalDamping(0.01))
    force = (ss.Force("tip.x", 1.0),)
    rubbing = ss.Contact("c", ss.Macroslip(kt=1e5, mu=0.5, normal_load=2.0), ({"tip.x": 1.0},))
    with_contact, free = (TunedDisk(disk, contacts, force, ("tip.x",), engine_order=2) for contacts in ((rubbing,), ()))
    own = float(free.frequencies(stuck=False)[0])
    response = ss.forced_response(with_contact, ss.hertz(0.9 * own, 1.1 * own), [1.0], harmonics=1).with_stress()
    assert float(response.dataset["frequency_without_contacts"][0]) == pytest.approx(own, rel=1e-9)
    solved = ss.forced_response(free, [own], [1.0], harmonics=1).with_stress().dataset["stress_alternating"].values[0, 0]
    np.testing.assert_allclose(response.dataset["stress_without_contacts"], solved, rtol=1e-4)


@pytest.fixture(scope="module")
def ring(tmp_path_factory):
    """The files of a sector of 30° of a thin ring about z, which is held along and about z at the middle of its inner side."""
    radii, heights = 0.1 + 0.001 * np.array([-0.5, 0.5]), 0.3 + 0.001 * np.array([-0.5, 0.5])
    mesh = box_mesh(np.linspace(-1.0, 1.0, 9) * np.pi / 12.0, radii, heights)
    angle, radius, height = mesh.p
    mesh = type(mesh)(np.array([radius * np.cos(angle), radius * np.sin(angle), height]), mesh.t)
    free = solid(mesh)
    middle = np.argmin(np.abs(free.points - [radii[0], 0.0, heights[0]]).sum(axis=1))
    numbers = free.numbers.copy()
    held = numbers[middle, 1:]
    kept = np.setdiff1d(np.arange(free.size), held)
    numbers = np.where(np.isin(numbers, held), -1, np.searchsorted(kept, numbers))
    body = replace(free, M=free.M[kept][:, kept], K=free.K[kept][:, kept], numbers=numbers)
    azimuth = np.arctan2(body.points[:, 1], body.points[:, 0])
    low, high = (np.flatnonzero(np.abs(azimuth - side * np.pi / 12.0) < 1e-9) for side in (-1, 1))
    folder = tmp_path_factory.mktemp("ring")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(type(COARSE), "contact_nodes", lambda self: {})
        patch.setattr(type(COARSE), "tip", lambda self: (radii[1], 0.0, heights[1]))
        write(folder, sector_of(body, 12, low, high))
    deck = folder / "disk.inp"
    deck.write_text(deck.read_text() + elements(mesh, body.points))
    return deck, int(np.argmin(np.abs(body.points - [radii[0], 0.0, heights[1]]).sum(axis=1))) + 1


def test_a_ring_in_rotation_has_the_hoop_stress_of_its_speed(ring):
    """σ = ρ Ω² r² of a thin ring, which the vibration leaves in the mean; a speed that is not given adds nothing."""
    deck, node = ring
    options = {"sectors": 12, "faces": ("LOW", "HIGH"), "keep": {"tip": "TIP"}, "modes": 4, "stress": {"inner": node}}
    said = []
    disk = ss.read_sector(deck, speed=3000.0, progress=lambda share, text: said.append(text), **options)
    hoop = STEEL.density * (100.0 * np.pi * 0.1) ** 2
    found = disk.stresses[0].rotation[0]
    assert found[1] == pytest.approx(hoop, rel=0.015)
    assert np.abs(np.delete(found, 1)).max() < 0.02 * hoop
    assert any(text.startswith("The mean stress contains the stress due to rotation at 3000 rev/min, von Mises") for text in said)
    rig = TunedDisk(disk.with_damping(ss.ModalDamping(0.01)), (), (ss.Force("tip.x", 1.0),), ("tip.x",), engine_order=3)
    mean = ss.forced_response(rig, [100.0], harmonics=1).with_stress().dataset["stress_mean"].values[0, 0, 0]
    np.testing.assert_allclose(mean, found, rtol=1e-9)
    at_rest = ss.read_sector(deck, **options)
    assert at_rest.stresses[0].rotation is None
    # The same by the load, of which few modes show a part, and what these lack.
    turning, load = ss.in_rotation(at_rest.with_damping(ss.ModalDamping(0.01)), 3000.0, "z")
    assert load.name == "centrifugal load of a sector"
    rig_parts = (ss.Force("tip.x", 1.0), load), ("tip.x",)
    rig = TunedDisk(turning, (), *rig_parts, engine_order=3)
    loaded = ss.forced_response(rig, [100.0], harmonics=1).with_stress().dataset["stress_mean"].values[0, 0, 0]
    np.testing.assert_allclose(loaded, found, atol=1e-7 * hoop)
    grown = np.linalg.solve(turning.K, load.static * turning.row(load.direction))[turning.index("tip.x")]
    assert grown == pytest.approx(hoop * 0.1 / STEEL.young, rel=0.02)
    # Pressed against the ground by it, the sector has the loads of the disk with all its sectors.
    law = ss.Macroslip(kt=1e6, kn=2e6, mu=0.3)
    pressed = TunedDisk(turning, (ss.Contact("c", law, ({"tip.y": 1.0},), {"tip.x": 1.0}),), *rig_parts, engine_order=3)
    (own,) = normal_loads_at_rest(pressed).values()
    assert own > 0.0
    assert list(normal_loads_at_rest(pressed.full()).values()) == pytest.approx(12 * [own], rel=1e-9)


def test_a_sector_rotates_about_the_axis_of_its_disk(ring):
    """Lines that differ by less than the digits of coordinates are one; those of a chain of masses have no places."""
    deck, _ = ring
    disk = ss.read_sector(deck, sectors=12, faces=("LOW", "HIGH"), keep={"tip": "TIP"}, modes=4)
    size = float(np.linalg.norm(next(iter(disk.nodes.values()))))
    along = ss.in_rotation(disk, 3000.0, ((0.0, 0.0, 7.0), (0.0, 0.0, -2.0)))[1]
    assert along.static == pytest.approx(ss.in_rotation(disk, 3000.0, ((5e-7 * size, 0.0, 0.0), (0.0, 0.0, 1.0)))[1].static)
    for axis in ("x", ((2e-6 * size, 0.0, 0.0), (0.0, 0.0, 1.0)), ((0.0, 0.0, 0.0), (2e-6, 0.0, 1.0))):
        with pytest.raises(ss.InputError, match="must be that of the disk"):
            ss.in_rotation(disk, 3000.0, axis)
    with pytest.raises(ss.InputError, match="must know the coordinates of all its nodes"):
        ss.in_rotation(ss.rigs.lumped_blisk().structure, 3000.0)


def test_a_place_on_a_face_of_a_sector_is_refused(disk_deck):
    node = int(read_model(disk_deck).sets["LOW"][0])
    with pytest.raises(ss.InputError, match="must not lie on a face of the sector, but is 'side'"):
        ss.read_sector(disk_deck, sectors=6, faces=("LOW", "HIGH"), keep={"tip": "TIP"}, modes=5, stress={"side": node})


@pytest.mark.parametrize(
    ("old", "new", "stress", "said"),
    [
        ("", "", {"a": "NOSET"}, "stress, a: Node or set 'NOSET' does not exist"),
        ("", "", {"a": 99999}, "Node or set '99999' does not exist"),
        ("", "", {"a": (0.0, 3.0, 0.0)}, "must lie within"),
        ("", "", {}, "must be from 1 to 200, but is 0"),
        ("", "", {"a": StrainGauge("TIP", (0, 0, 0))}, "stress, a: "),
        ("", "", {"a": StrainGauge(MIDDLE, (0.0, 0.0, 0.0))}, "stress, a: direction must not be zero"),
        ("", "", {"a": StrainGauge(MIDDLE, (0.0, 1.0))}, "stress, a: direction must"),
        ("TYPE=C3D20R", "TYPE=C3D20", {"a": MIDDLE}, "must be one of C3D4, C3D8, C3D10, C3D20R, but is 'C3D20'"),
        ("TYPE=C3D20R", "TYPE=C3D8", {"a": MIDDLE}, "A C3D8 at a place of stress must have 8 nodes, but"),
        ("*SOLID SECTION, ELSET=ALL", "*SOLID SECTION, ELSET=OTHER", {"a": MIDDLE}, "must have a *SOLID SECTION with a material"),
        ("*ELASTIC\n", "*ELASTIC, TYPE=ORTHO\n", {"a": MIDDLE}, "the same in all directions, but is 'another TYPE'"),
        ("*ELASTIC\n", "*ELASTIC\n1e11, 0.3, 20\n", {"a": MIDDLE}, "in one line of *ELASTIC"),
        (f", {STEEL.poisson}\n", ", 0.6\n", {"a": MIDDLE}, "The material STEEL: Material.poisson must lie between -1 and 0.5"),
        ("*MATERIAL", "*ELCOPY\n*MATERIAL", {"a": MIDDLE}, "must come with the elements of its deck"),
    ],
)
def test_what_cannot_be_recovered_is_refused(beam, tmp_path, old, new, stress, said):
    for file in beam[0].parent.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    text = (tmp_path / "disk.inp").read_text()
    assert old in text
    (tmp_path / "disk.inp").write_text(text.replace(old, new, 1) if old else text)
    with pytest.raises(ss.InputError) as raised:
        ss.read_structure(tmp_path / "disk.inp", keep={"tip": "TIP"}, modes=4, stress=stress)
    assert said in str(raised.value)


STUDY = """
units = "SI"
[study]
analysis = "forced_response"
[structure]
model = "disk.inp"
keep = { tip = "TIP" }
modes = 4
stress = { middle = [0.01, 0.1, 0.0] }
[damping]
modal = 0.01
[[force]]
direction = "tip.x"
amplitude = 100.0
[sweep]
at = [10.0]
force_levels = [1.0]
harmonics = 1
outputs = ["tip.x"]
"""


def test_a_study_names_places_of_stress(beam):
    plan = job(STUDY, beam[0].parent, "beam").plan
    assert plan.recovery.places == ("middle",)
    assert plan.recovery.rows.shape == (1, len(COMPONENTS), 7)
    gauge = STUDY.replace("[0.01, 0.1, 0.0] }", "{ at = [0.01, 0.1, 0.0], direction = [0.0, 1.0, 0.0] } }")
    (measured,) = job(gauge, beam[0].parent, "beam").plan.recovery.gauges.values()
    np.testing.assert_allclose(measured * STEEL.young, [-STEEL.poisson, 1.0, -STEEL.poisson, 0.0, 0.0, 0.0], atol=1e-12)
    with pytest.raises(ss.InputError, match="direction"):
        job(gauge.replace(", direction = [0.0, 1.0, 0.0]", ""), beam[0].parent, "beam")
    with pytest.raises(ss.InputError, match="stress must go with a model"):
        job(STUDY.replace('model = "disk.inp"\nkeep = { tip = "TIP" }\nmodes = 4', 'rig = "single_mass"'), beam[0].parent, "beam")
    with pytest.raises(ss.InputError, match="stress needs analysis = forced_response or mistuned_population, but the analysis"):
        job(STUDY.replace('"forced_response"', '"nonlinear_modes"'), beam[0].parent, "beam")


def test_a_study_of_a_rotating_blade(beam):
    """About an axis below its foot; a sector has its own speed."""
    speed = "modes = 4\nspeed = 6000.0\naxis = { point = [0.0, -0.3, 0.0] }"
    made = job(STUDY.replace("modes = 4", speed), beam[0].parent, "beam")
    assert made.plan.recovery.rotation[0, 1] == pytest.approx(centrifugal(0.5 * LENGTH), rel=0.01)
    # [rotation] makes the same of the load, with the spin softening of K, whatever few modes the blade has.
    turning = STUDY.replace("[damping]", "[rotation]\nspeed = 6000.0\naxis = { point = [0.0, -0.3, 0.0] }\n[damping]")
    problem = job(turning, beam[0].parent, "beam").sweep.problem
    mean = ss.forced_response(problem, [10.0], harmonics=1).with_stress().dataset["stress_mean"].values[0, 0, 0]
    assert mean[1] == pytest.approx(centrifugal(0.5 * LENGTH), rel=0.01)
    assert np.abs(np.delete(mean, 1)).max() < 0.02 * mean[1]
    with pytest.raises(ss.InputError, match="axis must be given with a speed"):
        job(STUDY.replace("modes = 4", speed.replace("speed = 6000.0\n", "")), beam[0].parent, "beam")


def test_a_study_of_mistuned_disks_has_the_stress_of_each_blade(ring):
    deck, node = ring
    sector = '[structure.sector]\nsectors = 12\nlow = "LOW"\nhigh = "HIGH"\n[excitation]\nengine_order = 3\n[damping]'
    text = STUDY.replace("[damping]", sector).replace("middle = [0.01, 0.1, 0.0]", f"inner = {node}")
    text = text.replace('"forced_response"', '"mistuned_population"') + "[mistuned_population]\nblade_scatter = 0.01\n"
    plan = job(text, deck.parent, "ring").plan
    assert plan.works[""].places == ("inner",)
    assert plan.gathered is population_dataset
    fatigue = "[fatigue]\nfatigue_strength = 4e8\nultimate_strength = 9e8\n"
    assert job(text + fatigue, deck.parent, "ring").plan.gathered is not population_dataset
    without = text.replace(f"stress = {{ inner = {node} }}\n", "")
    assert without != text
    with pytest.raises(ss.InputError, match=r"\[fatigue\] must go with places of stress"):
        job(without + fatigue, deck.parent, "ring")


def test_a_study_of_a_sector_at_speed_does_not_count_the_rotation_twice(ring):
    deck, node = ring
    sector = (
        '[structure.sector]\nsectors = 12\nlow = "LOW"\nhigh = "HIGH"\nspeed = 3000.0\n[excitation]\nengine_order = 3\n[damping]'
    )
    text = STUDY.replace("[damping]", sector).replace("middle = [0.01, 0.1, 0.0]", f"inner = {node}")
    made = job(text, deck.parent, "ring")
    assert any("contains the stress due to rotation at 3000 rev/min" in note for note in made.notes)
    assert made.plan.recovery.rotation[0, 1] == pytest.approx(STEEL.density * (100.0 * np.pi * 0.1) ** 2, rel=0.015)
    limit = "[fatigue]\nfatigue_strength = 4e8\nultimate_strength = 9e8\n"
    job(text + limit, deck.parent, "ring")
    table = "[rotation]\nspeed = 3000.0\n[damping]"
    turning = job(text.replace("speed = 3000.0\n", "").replace("[damping]", table), deck.parent, "ring")
    assert any("centrifugal load of a sector" in note for note in turning.notes)
    (softened,) = [note for note in turning.notes if "spin softening of 3000 rev/min" in note]
    assert "it is added, −Ω² M (1 − d dᵀ)" in softened
    loaded = turning.sweep.problem.forces[-1]
    assert loaded.static > 0.0
    with pytest.raises(ss.InputError, match=r"speed of \[structure.sector\] must be left out with \[rotation\]"):
        job(text.replace("[damping]", table), deck.parent, "ring")
    with pytest.raises(ss.InputError, match=r"speed must be given in \[structure.sector\] for a sector"):
        job(text.replace("modes = 4", "modes = 4\nspeed = 3000.0"), deck.parent, "ring")
    with pytest.raises(ss.InputError, match=r"\[fatigue\]: mean must not be given together with the speed"):
        job(f"{text}{limit}mean = {{ inner = 1e8 }}\n", deck.parent, "ring")


def test_a_margin_of_a_disk_without_the_stress_of_its_rotation_is_warned_of(ring):
    """Of a sector whose speed nobody says; a speed, also of zero, the stress itself or static forces on the blade say it."""
    deck, node = ring
    sector = '[structure.sector]\nsectors = 12\nlow = "LOW"\nhigh = "HIGH"\n{}[excitation]\nengine_order = 3\n[damping]'
    text = STUDY.replace("[damping]", sector).replace("middle = [0.01, 0.1, 0.0]", f"inner = {node}")
    text += "[fatigue]\nfatigue_strength = 4e8\nultimate_strength = 9e8\n"

    def warned(text):
        return [note for note in job(text, deck.parent, "ring").notes if "[fatigue]" in note]

    still = text.replace("{}", "")
    (note,) = warned(still)
    assert note.startswith("Warning: [fatigue]: the mean stress at inner has nothing of the rotation of the disk")
    population = still.replace('"forced_response"', '"mistuned_population"') + "[mistuned_population]\nblade_scatter = 0.01\n"
    assert len(warned(population)) == 1
    for stated in (
        text.replace("{}", "speed = 3000.0\n"),
        text.replace("{}", "speed = 0.0\n"),
        still + "mean = { inner = 1e8 }\n",
        still.replace("[damping]", "[rotation]\nspeed = 3000.0\n[damping]"),
        still.replace("[sweep]", '[[force]]\ndirection = "tip.y"\nstatic = 10.0\n[sweep]'),
        still.partition("[fatigue]")[0],
    ):
        assert warned(stated) == []
    assert len(warned(still + "mean = { inner = 0.0 }\n")) == 0
