"""Deformed shapes against unreduced models under the same forces, against the response itself, and round a disk."""

import gzip
from pathlib import Path

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse import linalg as sparse_linalg

import stickslip as ss
from stickslip.analyses.mistuning.disk import Mistuning, mistuned_disk
from stickslip.analyses.solved_points import MOST_KEPT, SurfaceMotion, deformed_shape, has_shapes, kept_shapes, with_shapes
from stickslip.model.rigs.octopus_blisk import BliskSector, octopus_blisk
from stickslip.model.structure.cyclic_reduction import rotation
from stickslip.results.files import open_results, save
from stickslip.support.checks import InputError

DATA = Path(__file__).parents[1] / "data" / "calculix"
KEEP = {"left": (0, 60, -15), "right": (0, 60, 15), "tip": (4, 120, 15)}
ALPHA, BETA = 5.0, 2e-6
"""Rayleigh damping C = α M + β K, 1/s and s."""
COARSE = BliskSector(sectors=6, cells=(1, 1, 1))


@pytest.fixture(scope="module")
def deck(tmp_path_factory):
    """The run of CalculiX, unpacked."""
    folder = tmp_path_factory.mktemp("calculix")
    for name in ("blade.inp", "blade.dof"):
        (folder / name).write_bytes((DATA / name).read_bytes())
    for name in ("blade.sti", "blade.mas"):
        (folder / name).write_bytes(gzip.decompress((DATA / f"{name}.gz").read_bytes()))
    return folder / "blade.inp"


def rubbing(deck, modes, keep=KEEP):
    """The blade of 456 rows with a friction pad at each edge, shaken at a corner of its tip."""
    damping = ss.RayleighDamping(ALPHA, BETA)
    blade = ss.read_structure(deck, units="mm-t-s", keep=keep, modes=modes, damping=damping)
    pad = ss.Macroslip(kt=1e6, kn=1e6, mu=0.4, preload=20.0)
    contacts = [
        ss.Contact(side, pad, ({f"{side}.x": 1.0}, {f"{side}.y": 1.0}), {f"{side}.z": closing})
        for side, closing in (("left", -1.0), ("right", 1.0))
    ]
    return ss.Problem(blade, contacts, [ss.Force("tip.x", 1.0)], ["tip.x", "tip.y", "tip.z"], "Blade")


@pytest.mark.parametrize(("modes", "apart"), [(10, 4e-4), (40, 2e-5), (120, 2e-6)])
def test_the_shape_is_that_of_the_unreduced_model_under_the_same_forces(deck, modes, apart):
    """(K + iωC − ω²M) u = F − Bᵀλ with the contact forces of a slipping point, by a sparse solver, at all points."""
    problem, model = rubbing(deck, modes), ss.read_model(deck, units="mm-t-s")
    response = ss.forced_response(problem, [560.0], force=[40.0], harmonics=5)
    assert float(response.dataset.share_slip.sum()) > 0.1
    load = np.zeros(model.size, dtype=complex)
    rows = {f"{node}.{axis}": model.rows[f"{found}.{axis}"] for node, found in nodes_of(model, KEEP).items() for axis in "xyz"}
    load[rows["tip.x"]] = 40.0
    forces = response.dataset.contact_force.values[0, 0, :, :, 1] @ [1.0, 1.0j]
    for contact, force in zip(problem.contacts, forces, strict=True):
        for direction, along in zip(contact.directions, force, strict=True):
            for dof, coefficient in direction.items():
                load[rows[dof]] -= coefficient * along
    omega = 2.0 * np.pi * 560.0
    dynamic = model.K + 1j * omega * (ALPHA * model.M + BETA * model.K) - omega**2 * model.M
    u = sparse_linalg.spsolve(sparse.csc_array(dynamic), load)
    motion = response.deformed_shape(0, 0).motion
    numbers = model.surface.numbers
    expected = np.where(numbers >= 0, u[numbers], 0.0)
    assert np.abs(motion.displacement - expected).max() < apart * np.abs(expected).max()
    clamped = motion.points[:, 1] < 1e-9
    assert np.all(motion.displacement[clamped] == 0.0)
    assert np.all(np.abs(motion.displacement[~clamped]).max(axis=1) > 0.0)


def nodes_of(model, keep):
    """The node of the model at each place, in mm."""
    names, points = model.located
    return {name: names[int(np.linalg.norm(points - 1e-3 * np.array(at), axis=1).argmin())] for name, at in keep.items()}


@pytest.mark.slow
def test_kept_nodes_move_as_the_response_says_and_a_whole_model_as_its_reduction(deck):
    response = ss.forced_response(rubbing(deck, 30), ss.Band(440.0, 640.0), force=[0.5, 5.0], harmonics=3)
    for case in (0, 1):
        motion, point = response.deformed_shape(case).motion, response.peak_point(case)
        tip = int(np.linalg.norm(motion.points - [4e-3, 0.12, 15e-3], axis=1).argmin())
        own = response.dataset.response.values[case, point, :, 1] @ [1.0, 1.0j]
        np.testing.assert_allclose(motion.displacement[tip], own, rtol=1e-8, atol=1e-9 * np.abs(own).max())
    whole = ss.read_structure(deck, units="mm-t-s")
    nodes = nodes_of(ss.read_model(deck, units="mm-t-s"), KEEP)
    problem = ss.Problem(whole, (), [ss.Force(f"{nodes['tip']}.x", 1.0)], [f"{nodes['tip']}.x"], "Blade")
    one = ss.forced_response(problem, [100.0]).deformed_shape(0, 0).motion
    few = ss.Problem(rubbing(deck, 120).structure.with_damping(None), (), [ss.Force("tip.x", 1.0)], ["tip.x"], "Blade")
    other = ss.forced_response(few, [100.0]).deformed_shape(0, 0).motion
    assert np.array_equal(one.points, other.points)
    assert np.abs(one.displacement - other.displacement).max() < 1e-5 * np.abs(one.displacement).max()


def test_a_reduction_that_was_kept_has_the_same_shape(deck, monkeypatch, tmp_path):
    monkeypatch.setenv("STICKSLIP_CACHE", str(tmp_path))
    first, again = (ss.read_structure(deck, units="mm-t-s", keep=KEEP, modes=5).surfaces[0] for _ in range(2))
    assert len(list(tmp_path.iterdir())) == 1
    assert np.array_equal(first.recovery, again.recovery)
    assert first.recovery.dtype == np.float32
    assert again.dofs[-1] == "mode/5.q"


def test_the_amplitude_is_the_largest_displacement_of_the_period():
    rng = np.random.default_rng(2)
    u = rng.normal(size=(50, 3)) + 1j * rng.normal(size=(50, 3))
    motion = SurfaceMotion("", np.zeros((50, 3)), np.zeros((0, 3), dtype=int), u)
    turns = np.exp(2j * np.pi * np.arange(20_000) / 20_000)
    largest = [np.linalg.norm((each * turns[:, None]).real, axis=1).max() for each in u]
    np.testing.assert_allclose(motion.amplitude, largest, rtol=1e-6)


@pytest.fixture(scope="module")
def disk():
    """Six coarse sectors under engine order 4, whose wave is the one of two nodal diameters that runs the other way."""
    return octopus_blisk(sector=COARSE, engine_order=4, modes=8)


@pytest.mark.nightly
def test_sectors_of_a_disk_are_those_of_the_full_disk_one_after_another(disk):
    """Stuck for all its contacts: every tip of the wheel moves as the full disk, each sector of its own, says."""
    free = ss.forced_response(disk, [150.0], force=1e-3, harmonics=1, samples=64)
    motion = free.deformed_shape(0, 0).motion
    assert "6 sectors, nodal diameter 2" in motion.note
    full = disk.full()
    tips = [f"{j}/tip.{axis}" for j in range(1, 7) for axis in "xyz"]
    full = ss.forced_response(type(full)(**{**vars_of(full), "outputs": tuple(tips)}), [150.0], 1e-3, 1, 64)
    found = (full.dataset.response.values[0, 0, :, 1] @ [1.0, 1.0j]).reshape(6, 3)
    for j in range(6):
        turn = rotation(6, j)
        tip = int(np.linalg.norm(motion.points - turn @ COARSE.tip(), axis=1).argmin())
        assert np.linalg.norm(motion.points[tip] - turn @ COARSE.tip()) < 1e-9
        np.testing.assert_allclose(motion.displacement[tip], turn @ found[j], atol=2e-6 * np.abs(found).max())


def vars_of(problem):
    """The fields of a problem that its constructor takes."""
    return {name: getattr(problem, name) for name in problem.__dataclass_fields__}


@pytest.mark.slow
@pytest.mark.parametrize("engine_order", [1, 4])
def test_the_shape_of_a_sector_is_that_of_its_unreduced_elements(engine_order):
    """Dᴴ (K − ω²M) D q = Dᴴ (F − Bᴴλ) with the cyclic constraint D and the forces of its dampers, by a sparse solver."""
    disk = octopus_blisk(sector=COARSE, engine_order=engine_order, modes=30, damping=0.0)
    response = ss.forced_response(disk, [90.0], 1.0, harmonics=1, samples=64)
    sector = COARSE.sector()
    rows = sector.solid.named({**COARSE.contact_nodes(), "tip": COARSE.tip()})
    load = np.zeros(sector.solid.size, dtype=complex)
    load[rows["tip.y"]] = 1.0
    following = np.exp(-2j * np.pi * engine_order / 6)
    forces = response.dataset.contact_force.values[0, 0, :, :, 1] @ [1.0, 1.0j]
    for contact, force in zip(disk.contacts, forces, strict=True):
        for direction, along in zip(contact.directions, force, strict=True):
            for dof, coefficient in direction.items():
                if not dof.startswith("damper/"):
                    phase = following.conj() if dof.startswith("next/") else 1.0
                    load[rows[dof.removeprefix("next/")]] -= phase * coefficient * along
    D = sector.constraint(engine_order)
    M, K = sector.matrices(engine_order)
    omega = 2.0 * np.pi * 90.0
    u = D @ sparse_linalg.spsolve(sparse.csc_array(K - omega**2 * M), D.conj().T @ load)
    motion, size = response.deformed_shape(0, 0).motion, len(disk.surface.points)
    numbers = sector.solid.numbers[[sector.solid.node(point) for point in motion.points[:size]]]
    expected = np.where(numbers >= 0, u[numbers], 0.0)
    assert np.abs(expected.imag).max() > 1e-4 * np.abs(expected.real).max()
    assert np.abs(motion.displacement[:size] - expected).max() < 1e-4 * np.abs(expected).max()


@pytest.mark.nightly
@pytest.mark.parametrize("engine_order", [1, 4])
def test_a_full_disk_without_mistuning_has_the_shape_of_the_tuned_one(engine_order):
    """All sectors solved together move as the wave that one sector gives."""
    disk = octopus_blisk(sector=COARSE, engine_order=engine_order, modes=8)
    one = ss.forced_response(disk, [90.0], 1.0, harmonics=1, samples=64)
    wave, whole = one.deformed_shape(0, 0).motion, ss.forced_response(disk.full(), [90.0], 1.0, harmonics=1, samples=64)
    motion = whole.deformed_shape(0, 0).motion
    assert motion.note == "6 sectors, each with its own motion"
    np.testing.assert_allclose(motion.points, wave.points, atol=1e-12)
    assert np.array_equal(motion.triangles, wave.triangles)
    assert np.abs(motion.displacement - wave.displacement).max() < 1e-9 * wave.amplitude.max()


@pytest.mark.nightly
def test_the_shape_of_a_mistuned_disk_is_that_of_its_unreduced_sectors():
    """Dampers of different kt, mu and pull, one missing: Dᴴ (K − ω²M) D q = Dᴴ p of every wave, by a sparse solver, with the
    forces p of the contacts on each sector; then the sum of the waves."""
    sectors, omega = COARSE.sectors, 2.0 * np.pi * 90.0
    disk = octopus_blisk(sector=COARSE, engine_order=1, modes=30, damping=0.0)
    scatter = 0.1 * np.array([1.0, -0.5, 0.3, 0.0, -1.0, 0.7])
    mistuned = mistuned_disk(disk, Mistuning(kt=scatter, mu=-scatter, pull=scatter[::-1], missing=(5,)))
    response = ss.forced_response(mistuned, [90.0], 1.0, harmonics=1, samples=64)
    motion, size = response.deformed_shape(0, 0).motion, len(disk.surface.points)
    sector = COARSE.sector()
    rows = sector.solid.named({**COARSE.contact_nodes(), "tip": COARSE.tip()})
    load = np.zeros((sectors, sector.solid.size), dtype=complex)
    load[:, rows["tip.y"]] = np.exp(-2j * np.pi * np.arange(sectors) / sectors)
    forces = response.dataset.contact_force.values[0, 0, :, :, 1] @ [1.0, 1.0j]
    for contact, force in zip(mistuned.contacts, forces, strict=True):
        for direction, along in zip(contact.directions, force, strict=True):
            for dof, coefficient in direction.items():
                where, _, name = dof.partition("/")
                if not name.startswith("damper/"):
                    load[int(where) - 1, rows[name]] -= coefficient * along
    expected = np.zeros((sectors, size, 3), dtype=complex)
    numbers = sector.solid.numbers[[sector.solid.node(point) for point in motion.points[:size]]]
    for n in range(sectors):
        turns = np.exp(2j * np.pi * n * np.arange(sectors) / sectors)
        D, (M, K) = sector.constraint(n), sector.matrices(n)
        u = D @ sparse_linalg.spsolve(sparse.csc_array(K - omega**2 * M), D.conj().T @ (turns @ load) / sectors)
        expected += turns.conj()[:, None, None] * np.where(numbers >= 0, u[numbers], 0.0)
    largest = np.abs(expected).max(axis=(1, 2))
    assert largest.max() > 1.05 * largest.min()
    for j in range(sectors):
        found = motion.displacement[j * size : (j + 1) * size] @ rotation(sectors, j)
        assert np.abs(found - expected[j]).max() < 1e-4 * largest.max()


@pytest.mark.nightly
def test_tips_of_mistuned_blades_move_as_their_response_says(disk, monkeypatch):
    """Also where fewer points are drawn."""
    full = mistuned_disk(disk, Mistuning(blade=[0.01, -0.02, 0.0, 0.015, -0.005, 0.02]))
    tips = [f"{j}/tip.{axis}" for j in range(1, 7) for axis in "xyz"]
    full = type(full)(**{**vars_of(full), "outputs": tuple(tips)})
    response = ss.forced_response(full, [150.0], 1e-3, harmonics=1, samples=64)
    found = (response.dataset.response.values[0, 0, :, 1] @ [1.0, 1.0j]).reshape(6, 3)
    assert np.ptp(np.abs(found[:, 1])) > 0.01 * np.abs(found[:, 1]).max()
    monkeypatch.setattr("stickslip.analyses.solved_points.MOST_OF_A_WHEEL", 6 * 40)
    few = deformed_shape(response.dataset, full, 0, 0)
    assert len(few.points) <= 6 * 40 < 6 * len(disk.surface.points)
    for motion in (response.deformed_shape(0, 0).motion, few):
        for j in range(6):
            turn = rotation(6, j)
            apart = np.linalg.norm(motion.points - turn @ COARSE.tip(), axis=1)
            if apart.min() < 1e-9:
                tip = int(apart.argmin())
                np.testing.assert_allclose(motion.displacement[tip], turn @ found[j], atol=2e-6 * np.abs(found).max())
            else:
                assert motion is few


def test_a_large_disk_is_shown_as_one_sector(disk, monkeypatch):
    monkeypatch.setattr("stickslip.analyses.solved_points.MOST_OF_A_WHEEL", 100)
    response = ss.forced_response(disk, [150.0], 1e-3, harmonics=1, samples=64)
    motion = deformed_shape(response.dataset, disk, 0, 0)
    assert motion.note == "one of 6 sectors, nodal diameter 2"
    assert np.array_equal(motion.points, disk.surface.points)


@pytest.mark.slow
def test_results_keep_the_shapes_of_some_cases_and_give_them_back(deck, tmp_path):
    problem = rubbing(deck, 10)
    response = ss.forced_response(problem, ss.Band(440.0, 640.0), force=np.linspace(1.0, 20.0, 7), harmonics=1)
    kept = with_shapes(response.dataset, problem)
    save(kept, tmp_path / "results.nc")
    shapes = kept_shapes(open_results(tmp_path / "results.nc"))
    assert len(shapes) == MOST_KEPT
    assert next(iter(shapes)) == "1 N"
    own = response.deformed_shape(0).motion
    np.testing.assert_allclose(shapes["1 N"].displacement, own.displacement, rtol=1e-6, atol=1e-15)
    np.testing.assert_allclose(shapes["1 N"].points, own.points, atol=1e-8)
    assert shapes["1 N"].title == own.title
    assert np.array_equal(shapes["1 N"].triangles, own.triangles)
    assert not has_shapes(response.dataset)
    assert has_shapes(response.with_motion().dataset)


def test_problems_without_a_mesh_and_harmonics_that_are_not_there_are_refused(deck):
    lumped = ss.forced_response(ss.rigs.single_mass(), [0.2], harmonics=3, samples=32)
    with pytest.raises(InputError, match="needs a problem with the surface of a mesh, but this one has none"):
        lumped.deformed_shape(0, 0)
    assert not has_shapes(lumped.with_motion().dataset)
    meshed = ss.forced_response(rubbing(deck, 5), [560.0], force=40.0, harmonics=3)
    with pytest.raises(InputError, match="harmonic must"):
        meshed.deformed_shape(0, 0, harmonic=4)
    with pytest.raises(InputError, match="point must"):
        meshed.deformed_shape(0, 1)
    third = meshed.deformed_shape(0, 0, harmonic=3)
    assert "harmonic 3" in third.title
    assert third.motion.amplitude.max() < meshed.deformed_shape(0, 0).motion.amplitude.max()


def test_under_several_engine_orders_the_shape_is_that_of_the_harmonic_that_moves_most():
    disk = octopus_blisk(sector=COARSE, engine_order=2, modes=8)
    both = disk.with_engine_orders({2: 1.0, 3: 0.5})
    speeds = [float(disk.modes(order).frequencies[0]) / order for order in (2, 3)]
    response = ss.forced_response(both, speeds, 1e-3, harmonics=3, samples=96, measure="max_abs")
    for point, order in enumerate((2, 3)):
        motion = response.deformed_shape(0, point).motion
        assert motion.title.endswith(f"harmonic {order}")
        assert f"nodal diameter {order}" in motion.note
        assert np.array_equal(motion.displacement, response.deformed_shape(0, point, harmonic=order).motion.displacement)
    assert response.deformed_shape(0, 0, harmonic=1).motion.title.endswith("harmonic 1")
    for level, order in ((1e-3, 2), (1e-2, 3)):
        other = ss.forced_response(both, [speeds[order - 2]], level, harmonics=3, samples=96, measure="max_abs")
        (kept,) = kept_shapes(with_shapes(other.dataset, both)).values()
        assert f"nodal diameter {order}" in kept.note
