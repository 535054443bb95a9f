"""Every rig builds; its contacts join or ground bodies in balance; lumped rigs have their known frequencies."""

import subprocess
import sys

import numpy as np
import pytest

from stickslip.model import rigs
from stickslip.model.contact.point import SliderOffset, TractionRatio
from stickslip.model.problem import Problem
from stickslip.model.structure.cyclic import NEXT
from stickslip.model.structure.cyclic_reduction import rotation
from stickslip.support.checks import InputError

EVERY_RIG = sorted(rigs.RIGS)


def net_force(rig: Problem, direction) -> np.ndarray:
    """What a unit force along a contact direction adds up to over all translations x, y, z of named nodes.

    The axes of the following sector of a disk are turned by 2π/N.
    """
    total = np.zeros(3)
    for dof, coefficient in direction.items():
        axes = rotation(rig.sectors) if dof.startswith(NEXT) and dof.endswith((".x", ".y", ".z")) else np.eye(3)
        total += coefficient * sum(axes[:, k] for k, axis in enumerate("xyz") if dof.endswith(f".{axis}"))
    return total


@pytest.mark.parametrize("name", EVERY_RIG)
def test_every_rig_builds_and_is_held_when_stuck(name: str):
    rig = rigs.RIGS[name]()
    assert rig.title
    assert rig.contacts
    assert rig.frequencies(stuck=True)[0] > 0.0
    assert np.all(np.isfinite(rig.C))
    assert np.all(rig.frequencies(stuck=True) > rig.frequencies(stuck=False) * (1 - 1e-9) - 1e-3)


@pytest.mark.parametrize("name", EVERY_RIG)
def test_contact_forces_balance_between_bodies_and_are_unit_against_ground(name: str):
    """A common translation moves no contact between bodies; one to ground sees it along its unit direction."""
    rig = rigs.RIGS[name]()
    sizes = [np.linalg.norm(net_force(rig, d)) for contact in rig.contacts for d in contact.directions]
    for size in sizes:
        assert min(size, abs(size - 1.0)) < 1e-12


def test_importing_the_rigs_loads_no_finite_elements():
    code = "import sys, stickslip.model.rigs; sys.exit('skfem' in sys.modules or 'matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_single_mass_is_the_benchmark():
    rig = rigs.single_mass()
    assert (rig.structure.M, rig.structure.K, rig.C) == (1.0, 1.0, 0.02)
    assert rig.contact_stiffness == [1.0]
    assert rig.contacts[0].law.virgin_curve(5.0) == 1.0


def test_chain_is_the_benchmark():
    rig = rigs.chain()
    modes = np.arange(1, 21)
    np.testing.assert_allclose(rig.frequencies(stuck=False) * 2 * np.pi, 2 * np.sin((2 * modes - 1) * np.pi / 82), rtol=1e-9)
    np.testing.assert_allclose(rig.C, 0.01 * rig.structure.K)
    assert [c.name for c in rig.contacts] == [f"{i}-ground" for i in range(11, 21)]


def test_chain_with_varying_load_is_the_benchmark():
    rig = rigs.chain_varying_load()
    x, y = rig.structure.K[::2, ::2], rig.structure.K[1::2, 1::2]
    np.testing.assert_allclose(x, rigs.chain().structure.K)
    np.testing.assert_allclose(y, x + np.eye(20))
    assert not rig.structure.K[::2, 1::2].any()
    assert rig.load(1)[:, 0] == pytest.approx(
        np.where([d in {f"{i}.y" for i in range(11, 21)} for d in rig.structure.dofs], 2, 0)
    )
    assert sorted(f.direction for f in rig.forces) == sorted(["10.x", *(f"{i}.y" for i in range(11, 21))])


def test_chain_of_three_between_walls():
    rig = rigs.chain_of_three()
    np.testing.assert_allclose((2 * np.pi * rig.frequencies(stuck=False)) ** 2, [2 - 2**0.5, 2, 2 + 2**0.5], rtol=1e-12)
    np.testing.assert_allclose(rig.B, [[1, 0, 0], [1, -1, 0]])


def test_three_mass_wedge_has_its_published_frequencies():
    """Values of an independent script of this project for the published three-mass oscillator."""
    rig = rigs.three_mass_wedge(traction_ratio=0.5)
    stuck = [84.971051, 161.981025, 225.079079, 256.629635, 399.949839, 555.087429]
    np.testing.assert_allclose(rig.frequencies(stuck=True), stuck, rtol=1e-6 / 80)
    blades = [87.172752, 150.987636, 207.512658, 241.370422]
    np.testing.assert_allclose(rig.frequencies(stuck=False)[1:5], blades, rtol=1e-6 / 80)
    assert all(c.start == TractionRatio(0.5) for c in rig.contacts)
    assert rigs.three_mass_wedge(SliderOffset()).contacts[0].start == SliderOffset()


def test_three_mass_wedge_linear_preload():
    """Stuck static forces of the linear system, N1 28.5439, T1 36.2747, N2 45.6868, T2 −6.5824 N (independent script)."""
    rig = rigs.three_mass_wedge()
    motion = np.linalg.solve(rig.stuck_stiffness, rig.load(1)[:, 0])
    np.testing.assert_allclose(rig.contact_stiffness * (rig.B @ motion), [36.2747, 28.5439, -6.5824, 45.6868], atol=5e-5)


def test_masses_that_do_not_exist_are_refused():
    with pytest.raises(InputError, match="must lie between 1 and 5"):
        rigs.chain(5)
