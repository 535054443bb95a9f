"""Damping that feeds a mode is warned of, however it came in: gas forces along a direction, or of the waves of a disk.

References: c/(2ω) of one mass by hand; `damping_by_nodal_diameter`, which solves the quadratic eigenvalue problem of each wave.
"""

import numpy as np
import pytest

import stickslip as ss
from stickslip.model.problem.warnings import negative_damping


def mass(gas: float, ratio: float = 0.002) -> ss.Problem:
    structure = ss.Structure(np.eye(1), np.eye(1), ("q.x",), damping=ss.ModalDamping(ratio))
    contact = ss.Contact("slider", ss.Macroslip(kt=0.5, mu=0.5, normal_load=0.3), ({"q.x": 1.0},))
    gas_force = ss.AerodynamicDamping({"q.x": 1.0}, gas)
    return ss.Problem(structure, (contact,), (ss.Force("q.x", 0.005),), ("q.x",), dashpots=(gas_force,))


def test_the_ratio_of_a_fed_mass_is_said():
    ratio = 0.002 - 0.03 / (2 * np.sqrt(1.5))
    (said,) = mass(-0.03).warnings
    assert f"0.19492 Hz has the damping ratio {ratio:.3g}." in said


@pytest.mark.parametrize("gas", [0.03, -0.004])
def test_damping_that_stays_positive_is_none(gas):
    """2 ζ ω = 0.0049 of the structure exceeds what the gas feeds."""
    assert negative_damping(mass(gas)) == ""


def test_of_a_disk_the_least_damped_wave_is_named():
    disk = ss.rigs.lumped_blisk("W", engine_order=1, sectors=6)
    gas = ss.Aerodynamics(influence={0: 4e3 + 900j, 1: -1.5e3 - 3e4j, -1: -400 + 900j}, frequency=149.0, direction="tip.t")
    least = ss.damping_by_nodal_diameter(disk.with_aerodynamics(gas)).table().iloc[0]
    said = negative_damping(disk.with_aerodynamics(gas))
    assert least["damping_ratio"] < 0.0
    assert f"of nodal diameter {int(least['nodal_diameter'])} " in said
    number = float(said.partition("damping ratio ")[2].split()[0].rstrip("."))
    assert number == pytest.approx(least["damping_ratio"], rel=0.02)
    assert negative_damping(disk) == ""


def test_a_response_of_such_a_disk_says_so():
    disk = ss.rigs.lumped_blisk("W", engine_order=1, sectors=6)
    gas = ss.Aerodynamics(influence={0: 4e3 + 900j, 1: -1.5e3 - 3e4j, -1: -400 + 900j}, frequency=149.0, direction="tip.t")
    found = ss.forced_response(disk.with_aerodynamics(gas), [140.0], harmonics=1, samples=48)
    assert "Negative damping" in str(found.dataset["case_message"].values[0])


def test_a_disk_damped_by_a_rule_alone_asks_for_no_other_nodal_diameter(monkeypatch):
    """The modes of every nodal diameter took two thirds of a check of a finite-element disk."""
    disk = ss.rigs.lumped_blisk("W", engine_order=2, sectors=6)
    disk = disk.with_structure(disk.disk.with_damping(ss.ModalDamping(1e-3)))
    asked = []
    matrices = type(disk.systems).matrices
    monkeypatch.setattr(type(disk.systems), "matrices", lambda own, n: asked.append(n % 6) or matrices(own, n))
    assert not [each for each in disk.warnings if "Negative damping" in each]
    assert set(asked) <= {2}
