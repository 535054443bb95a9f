"""Stress recovery: exact for constant strain, beam theory away from the clamp, and the unreduced body."""

import numpy as np
import pytest
from scipy.sparse import linalg as sparse_linalg
from structure.cantilever import PLACES, cantilever, cantilever_rig, cantilever_stress, resonant_stress, static_stress

import stickslip as ss
from stickslip.analyses.solved_points import SolvedPoints
from stickslip.model.dampers.cylinder import FlatCylinder
from stickslip.model.rigs.single_blade import PlatformBlade, pads, placed_dampers
from stickslip.model.structure.solid import STEEL, box_mesh, solid
from stickslip.model.structure.stress import stress_recovery, stress_rows, von_mises
from stickslip.support.checks import InputError


def test_constant_strain_gives_its_stress_anywhere():
    mesh = box_mesh(*(np.linspace(0.0, side, 3) for side in (0.05, 0.03, 0.02)))
    points = mesh.p.copy()
    inner = np.all((points > 1e-9) & (points < np.array([[0.05], [0.03], [0.02]]) - 1e-9), axis=0)
    points[:, inner] += 2e-3
    mesh = type(mesh)(points, mesh.t)
    body = solid(mesh)
    gradient = np.array([[1.0, 0.4, -0.2], [0.1, -0.7, 0.3], [0.5, 0.2, 0.9]]) * 1e-3
    motion = (body.points @ gradient.T).ravel()
    lam, shear = STEEL.lame
    strain = 0.5 * (gradient + gradient.T)
    sigma = lam * np.trace(strain) * np.eye(3) + 2.0 * shear * strain
    expected = [sigma[0, 0], sigma[1, 1], sigma[2, 2], sigma[0, 1], sigma[1, 2], sigma[2, 0]]
    for place in ([0.011, 0.013, 0.007], [0.05, 0.03, 0.02], [0.025, 0.0, 0.01]):
        np.testing.assert_allclose(stress_rows(mesh, body, np.array(place)) @ motion, expected, rtol=1e-10)
    with pytest.raises(ss.InputError, match="must lie in the body"):
        stress_rows(mesh, body, np.array([0.06, 0.01, 0.01]))


def test_equivalent_stress_of_uniaxial_stress_shear_and_pressure():
    """|σ|, √3 |τ|, 0; of any state √(3/2) times the size of its deviator, in each entry of an array."""
    for k in range(3):
        assert von_mises(7.0 * np.eye(6)[k]) == pytest.approx(7.0, rel=1e-14)
        assert von_mises(-7.0 * np.eye(6)[3 + k]) == pytest.approx(7.0 * np.sqrt(3.0), rel=1e-14)
    assert von_mises([5.0, 5.0, 5.0, 0.0, 0.0, 0.0]) == 0.0
    states = np.random.default_rng(0).standard_normal((4, 5, 6))
    x, y, z, xy, yz, zx = np.moveaxis(states, -1, 0)
    tensor = np.moveaxis(np.array([[x, xy, zx], [xy, y, yz], [zx, yz, z]]), (0, 1), (-2, -1))
    deviator = tensor - (x + y + z)[..., None, None] / 3.0 * np.eye(3)
    np.testing.assert_allclose(von_mises(states), np.sqrt(1.5 * np.sum(deviator**2, axis=(-2, -1))), rtol=1e-13)


def test_bending_stress_of_a_cantilever():
    """σ_yy = F (L − y) x/I of beam theory, away from clamp and load."""
    mesh, body, _, reduction = cantilever()
    recovery = stress_recovery(mesh, body, reduction, PLACES)
    load = np.zeros(reduction.structure.size)
    load[0] = 100.0
    found = recovery.rows @ np.linalg.solve(reduction.structure.K, load)
    for place, sigma in zip(PLACES.values(), found, strict=True):
        beam = static_stress(100.0, place)
        assert sigma[1] == pytest.approx(beam, rel=0.02)
        assert np.abs(np.delete(sigma, 1)).max() < 0.05 * abs(beam)
        assert von_mises(sigma) == pytest.approx(abs(beam), rel=0.03)


def test_recovered_stress_equals_that_of_the_unreduced_body():
    """Static: exact. Vibrating between the first two bending modes, with eighty modes: to 1e-3 (fifteen: 5e-3)."""
    mesh, body, kept, reduction = cantilever()
    recovery = stress_recovery(mesh, body, reduction, PLACES)
    structure = reduction.structure
    for omega, tolerance in ((0.0, 1e-9), (2.0 * np.pi * 1500.0, 1e-3)):
        load, full = np.zeros(structure.size), np.zeros(body.size)
        load[0] = full[kept["tip.x"]] = 100.0
        reduced = recovery.rows @ np.linalg.solve(structure.K - omega**2 * structure.M, load)
        motion = sparse_linalg.spsolve((body.K - omega**2 * body.M).tocsc(), full)
        expected = np.array([stress_rows(mesh, body, np.array(place)) @ motion for place in PLACES.values()])
        np.testing.assert_allclose(reduced, expected, atol=tolerance * np.abs(expected).max())


def test_stress_along_a_curve_of_a_rubbing_cantilever():
    """Far below resonance the vibrating and the mean stress are those of a beam under its tip forces, at resonance that of its
    first bending mode, σ_yy = −E x w''(y); and each point is that of `stress`."""
    rig, recovery = cantilever_rig(), cantilever_stress(PLACES)
    resonance = float(rig.frequencies(stuck=False)[0])
    response = ss.forced_response(rig, [10.0, resonance], force=50.0, harmonics=5)
    with pytest.raises(InputError, match=r"Draw `response.with_stress\(recovery\)`"):
        response.plot("stress")
    data = response.with_stress(recovery).dataset
    carried = response.dataset.contact_force.values[0, 0, 0, 0]
    bending = data.sel(component="yy")
    for k, place in enumerate(PLACES.values()):
        tip = 50.0 - (carried[1, 0] + 1j * carried[1, 1])
        assert float(bending.stress_amplitude[0, 0, k]) == pytest.approx(abs(static_stress(abs(tip), place)), rel=0.02)
        assert float(bending.stress_mean[0, 0, k]) == pytest.approx(static_stress(100.0 - carried[0, 0], place), rel=0.02)
        beam = abs(resonant_stress(float(data.amplitude[0, 1, 0]), place))
        assert float(bending.stress_amplitude[0, 1, k]) == pytest.approx(beam, rel=0.02)
        assert float(data.stress_von_mises[0, 1, k]) == pytest.approx(
            beam + abs(float(bending.stress_mean[0, 1, k])), rel=0.04
        ), "bending alone, at the worst instant"
    one = response.stress(0, 1, recovery)
    np.testing.assert_allclose(data.stress_von_mises[0, 1], one.von_mises, rtol=1e-12)
    np.testing.assert_allclose(data.stress_amplitude[0, 1], one.amplitude, rtol=1e-12)
    np.testing.assert_allclose(data.stress_mean[0, 1], one.stress[:, :, 0, 0], rtol=1e-12)


def test_mean_stress_of_the_single_blade_equals_a_static_solution_of_its_elements():
    """Under the mean contact forces of a rubbing point, the unreduced finite elements carry the recovered mean stress."""
    rig = ss.rigs.single_blade()
    response = ss.forced_response(rig, [530.0], force=20.0, harmonics=1)
    places = {"root": (0.012, 20e-3, 0.0), "under the platform": (-0.012, 60e-3, 0.01)}
    recovery = ss.rigs.single_blade_stress(places)
    found = response.stress(0, 0, recovery)
    blade = PlatformBlade()
    body = blade.clamped()
    kept = body.named({name: at for damper in placed_dampers(blade, FlatCylinder(), 1.0) for name, at in pads(damper)})
    forces = np.nan_to_num(response.dataset.contact_force.values[0, 0, :, :, 0, 0])
    rows = np.array([forces[c, ("t1", "t2", "n").index(n)] for c, k in enumerate(rig.contacts) for n in k.direction_names])
    carried, full = -rig.B.T @ rows, np.zeros(body.size)
    for name, row in kept.items():
        full[row] = carried[rig.structure.index(f"blade/{name}")]
    motion = sparse_linalg.spsolve(body.K.tocsc(), full)
    expected = np.array([stress_rows(blade.mesh(), body, np.array(place)) @ motion for place in places.values()])
    mean = found["stress"].isel(harmonic=0, part=0).values
    np.testing.assert_allclose(mean, expected, atol=1e-8 * np.abs(expected).max())
    # The vibration: a blade bending at 530 Hz by its tip amplitude has, in a first bending mode, about this stress at 20 mm.
    tip, inertia_free = float(response.dataset.amplitude[0, 0, 0]), 210e9 * 0.012 * 3.516 / blade.length**2
    assert 0.5 < float(found["amplitude"].sel(place="root", component="yy")) / (inertia_free * tip) < 1.0
    assert float(found["von_mises"].max()) == pytest.approx(float(found["largest"].sel(component="yy").max()), rel=0.1)
    q = SolvedPoints(response.dataset, rig).whole_motion(0, 0)
    assert np.hypot(*q[rig.structure.index("blade/tip.x"), 1:]) == pytest.approx(tip, rel=1e-9)
