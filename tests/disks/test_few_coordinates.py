"""A whole disk on few coordinates of each nodal diameter against itself on all degrees of freedom."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.analyses.mistuning import work
from stickslip.analyses.mistuning.disk import blade_dofs
from stickslip.model.disks.tuned import REACH, few_waves

SECTORS, MASSES, H = 5, 24, 3


def chain_disk():
    """A blade of 24 masses a sector, its middle coupled to the neighbours; a damper rubs on the sixth mass and the next one's."""
    k, m = 4e6, 0.02
    K = 2.0 * k * np.eye(MASSES) - k * (np.eye(MASSES, k=1) + np.eye(MASSES, k=-1))
    K[-1, -1] = k
    ring = np.zeros_like(K)
    ring[11, 11] = 2e5
    sector = ss.Structure(m * np.eye(MASSES), K + 2.0 * ring, [f"{k}.x" for k in range(1, MASSES)] + ["tip.x"])
    disk = ss.with_bodies(
        ss.sector_chain(sector, SECTORS, -ring), {"damper": ss.Structure(np.array([[0.01]]), np.zeros((1, 1)), ["mass.x"])}
    ).with_damping(ss.ModalDamping(2e-3))
    law = ss.Macroslip(kt=3e5, mu=0.3, normal_load=100.0)
    contacts = [
        ss.Contact(name, law, ({"damper/mass.x": 1.0, dof: -1.0},)) for name, dof in (("own", "6.x"), ("following", "next/6.x"))
    ]
    held = (ss.Spring({"damper/mass.x": 1.0}, 1e4),)
    return ss.TunedDisk(disk, contacts, [ss.Force("tip.x", 1.0)], ["tip.x"], mean_springs=held, engine_order=1)


DISK = chain_disk()
FIRST = float(DISK.frequencies(stuck=True)[0])
SCATTER = ss.Scatter(blade=0.02, kt=0.1)


def population(**changed):
    given = {"harmonics": H, "samples": 60, "seed": 3, "blade": ["tip", "23", "22"], "peak_tolerance": 1e-7} | changed
    return ss.mistuned_population(DISK, [0.97 * FIRST, FIRST, 1.02 * FIRST], 1, SCATTER, force=1.5, **given).dataset


@pytest.mark.parametrize("mistuning", [None, ss.Mistuning(missing=[2])])
def test_a_mistuned_disk_on_few_coordinates_moves_as_on_all(mistuning, monkeypatch):
    """Slipping dampers, also with one missing: amplitudes to 1e-6, friction work to 1e-5."""
    whole = population(mistuning=mistuning)
    monkeypatch.setattr(work, "LARGE", 0)
    few = population(mistuning=mistuning)
    assert float(whole.damper_work.max()) > 1e-6
    np.testing.assert_allclose(few.amplitude, whole.amplitude, rtol=1e-6)
    np.testing.assert_allclose(few.damper_work, whole.damper_work, rtol=1e-5, atol=1e-12)
    assert not np.array_equal(few.amplitude, whole.amplitude)


def test_few_coordinates_hold_what_moves():
    """Fewer than four fifths, of one number at all nodal diameters, real at nodal diameter 0; the damper moves by itself."""
    blade = blade_dofs(DISK, ["tip", "23", "22"])
    shapes = few_waves(DISK, REACH * H * 1.02 * FIRST, blade, 0.08)
    size = DISK.structure.size
    assert shapes.shape[:2] == (SECTORS // 2 + 1, size)
    assert shapes.shape[2] < 0.8 * size
    assert not shapes[0].imag.any()
    assert np.array_equal(shapes[1][-1], np.eye(shapes.shape[2])[-1])
    few, whole = DISK.full(shapes=shapes), DISK.full()
    np.testing.assert_allclose(few.frequencies(stuck=True)[:8], whole.frequencies(stuck=True)[:8], rtol=1e-7)
    assert few.structure.dofs == whole.structure.dofs
    assert few.structure.motion(np.eye(few.structure.size)).shape == (whole.structure.size, few.structure.size)
