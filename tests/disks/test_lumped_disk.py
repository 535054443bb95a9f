"""The lumped disk: one sector against all sectors, and against numbers of an independent script of this project."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip.analyses.forced_response import forced_response
from stickslip.analyses.nodal_diameters import nodal_diameters
from stickslip.analyses.time_response import time_response
from stickslip.model.contact.point import MeanTraction, TractionRatio
from stickslip.model.rigs import lumped_blisk, octopus_blisk
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.continuation import first_point
from stickslip.support.checks import InputError


def solved(disk, frequency, force, harmonics=3, samples=96):
    """The balance and the solution at one frequency."""
    balance = HarmonicBalance(disk, harmonics, samples)
    correction = first_point(balance, 2.0 * np.pi * frequency, force)
    assert correction.converged
    return balance, correction.evaluation


def harmonics_of(balance, evaluation, output=0):
    row = evaluation.w[balance.rows + output]
    return np.concatenate([row[:1], row[1::2] - 1j * row[2::2]])


def test_frequencies():
    wedge, roller = lumped_blisk("W"), lumped_blisk("R")
    assert wedge.frequencies(stuck=False)[2:] == pytest.approx([131.92083361, 258.14530402, 496.62061886], abs=1e-8)
    assert wedge.frequencies(stuck=True)[:3] == pytest.approx([148.6080699, 377.91876149, 508.63701605], abs=1e-7)
    assert roller.frequencies(stuck=True)[0] == pytest.approx(145.517857, abs=1e-6)
    assert wedge.modes(22, stuck=True).frequencies == pytest.approx(wedge.frequencies(stuck=True), rel=1e-9)


def test_static_loads():
    balance, evaluation = solved(lumped_blisk("W"), 148.0, 1e-6)
    mean = balance.carried_forces(evaluation)[:, 0]
    assert mean == pytest.approx([2.73115896, 101.21353788, -2.73115896, 101.21353788], abs=2e-7)


@pytest.mark.parametrize(
    ("case", "force", "frequency", "mobility"),
    [("W", 0.1, 148.60807, 0.589501), ("W", 0.4, 148.5656, 0.209084), ("R", 0.1, 145.517857, 0.5893424)],
)
def test_mobility(case, force, frequency, mobility):
    balance, evaluation = solved(lumped_blisk(case), frequency, force, harmonics=5, samples=384)
    found = abs(harmonics_of(balance, evaluation)[1]) * 2.0 * np.pi * frequency / force
    assert found == pytest.approx(mobility, rel=2e-6)


def test_shakedown_of_the_rolling_damper():
    """At 0.2 N a cylinder slips once and then sticks at a higher normal load: the response is the stuck one."""
    small, large = (solved(lumped_blisk("R"), 145.517857, force) for force in (0.02, 0.2))
    assert abs(harmonics_of(*large)[1]) == pytest.approx(10.0 * abs(harmonics_of(*small)[1]), rel=1e-7)
    mean = [float(balance.carried_forces(evaluation)[1, 0]) for balance, evaluation in (small, large)]
    assert mean[1] > 1.01 * mean[0]


@pytest.mark.parametrize(("case", "frequency", "force", "bound"), [("W", 148.5, 0.4, 1e-10), ("R", 145.4, 1.6, 1e-9)])
def test_one_sector_equals_all(case, frequency, force, bound):
    disk = lumped_blisk(case)
    one = harmonics_of(*solved(disk, frequency, force))
    whole = solved(disk.full(reported=[1, 6]), frequency, force)
    first, sixth = (harmonics_of(*whole, output) for output in (0, 1))
    delay = np.exp(-2j * np.pi * np.arange(4) * 2 * 5 / 24)
    size = np.abs(one[1:]).max()
    assert np.abs(first - one).max() < bound * size
    assert np.abs(sixth - one * delay).max() < bound * size


@pytest.mark.parametrize(("sectors", "engine_order"), [(6, 0), (6, 3), (6, 5), (7, 2), (7, 7)])
def test_every_kind_of_nodal_diameter(sectors, engine_order):
    """In phase, half way round, beyond half way, odd numbers of sectors: always the full disk."""
    disk = lumped_blisk("W", sectors=sectors, engine_order=engine_order)
    frequency = float(disk.frequencies(stuck=True)[0]) - 0.1
    samples = 96 - 96 % disk.systems.sample_multiple
    one = harmonics_of(*solved(disk, frequency, 2.0, samples=samples))
    whole = harmonics_of(*solved(disk.full(reported=[1]), frequency, 2.0, samples=samples))
    assert np.abs(whole - one).max() < 1e-10 * np.abs(one[1:]).max()


def test_energy_of_a_sector_and_of_the_disk():
    disk = lumped_blisk("W", sectors=6, engine_order=2)
    frequency = float(disk.frequencies(stuck=True)[0])
    kept = ("loss_factor", "energy_residual")
    one, whole = (forced_response(d, [frequency - 1.0, frequency], 1.6, 3).dataset for d in (disk, disk.full([1])))
    assert float(one.samples) % 3 == 0
    assert one.loss_factor.values == pytest.approx(whole.loss_factor.values, rel=1e-9)
    assert float(one.loss_factor[0, -1]) > 0.02
    assert all(float(dataset[kept[1]].max()) < 1e-9 for dataset in (one, whole))


def test_start_states_travel_with_the_disk():
    disk = lumped_blisk("W", sectors=6, engine_order=2, start=MeanTraction(3.0))
    frequency = float(disk.frequencies(stuck=True)[0]) - 0.1
    one = harmonics_of(*solved(disk, frequency, 0.5))
    assert harmonics_of(*solved(disk.full([1]), frequency, 0.5)) == pytest.approx(one, rel=1e-9)
    with pytest.raises(InputError, match="traction ratio"):
        lumped_blisk(sectors=6, start=TractionRatio(0.5)).full()


def test_disks_that_differ_beyond_nodal_diameter_0_are_distinguished():
    disk = lumped_blisk(sectors=6)
    ring = np.zeros_like(disk.disk.stiffnesses)
    ring[1:, 0, 0] = 1e6
    stiffer = replace(disk, structure=replace(disk.structure, stiffnesses=disk.disk.stiffnesses + ring))
    names = {other.fingerprint for other in (disk, lumped_blisk(sectors=6), stiffer, disk.with_engine_order(3))}
    assert len(names) == 3


def test_time_integration_asks_for_the_full_disk():
    with pytest.raises(InputError, match="full disk"):
        time_response(lumped_blisk(), 148.0)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (
            lambda: lumped_blisk(engine_order=25),
            "engine_order must be a whole number and lie between 0 and the number of sectors, 24",
        ),
        (lambda: lumped_blisk("X"), "case must be"),
        (lambda: lumped_blisk(sectors=1), "sectors must be at least 2"),
        (lambda: lumped_blisk(sectors=2.5), "sectors must be a whole number"),
        (lambda: lumped_blisk(sectors=100_000), "sectors must be at most 1000"),
        (lambda: lumped_blisk(engine_order="2"), "engine_order must be a whole number"),
        (lambda: lumped_blisk(engine_order=True), "engine_order must be a whole number"),
        (lambda: lumped_blisk(platform_angle=90.0), "platform_angle must lie in"),
        (lambda: lumped_blisk().full(reported=3), "reported must be a tuple or list"),
        (lambda: lumped_blisk().full(reported=["a"]), "reported must be a whole number"),
        (lambda: lumped_blisk().full(reported=[25]), "reported must hold sectors from 1 to 24"),
        (lambda: nodal_diameters(None), "disk must be a TunedDisk"),
        (lambda: octopus_blisk(sector=3), "sector must be a BliskSector"),
        (lambda: octopus_blisk("analytic", ktx=1e7), "must be left out beside the published set 'analytic'"),
    ],
)
def test_wrong_input(make, words):
    with pytest.raises(InputError, match=words):
        make()
