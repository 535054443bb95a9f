"""A disk that holds the matrices of some nodal diameters: the response of one sector is that of the disk with all of them."""

import numpy as np
import pytest
from each import each

import stickslip as ss
from stickslip.model.rigs.lumped import lumped_blisk
from stickslip.model.structure.cyclic import HeldDiameters
from stickslip.support.checks import InputError


@each(
    ("sectors", "order", "held"),
    [
        (12, 3, (0, 3, 6)),
        (12, 9, (0, 3, 6)),
        (12, 0, (0, 6)),
        (12, 12, (0, 6)),
        (12, 8, (0, 4, 6)),
        (24, 10, (0, 2, 4, 6, 8, 10, 12)),
        (15, 5, (0, 5, 7)),
        (13, 4, tuple(range(7))),
        (2, 1, (0, 1)),
    ],
)
def test_an_engine_order_excites_the_waves_of_its_harmonics(sectors, order, held):
    """h EO mod N over many harmonics, folded at N/2, and N//2 for comparison."""
    waves = {h * order % sectors for h in range(200)}
    assert set(held) == {min(n, sectors - n) for n in waves} | {sectors // 2}
    assert HeldDiameters.excited(sectors, order).held == held


def some_of(disk, held):
    """The disk with the matrices of some nodal diameters alone."""
    parts = [None if waves is None else waves[list(held)] for waves in (disk.masses, disk.stiffnesses, disk.dampings)]
    return ss.cyclic(disk.sectors, disk.dofs, *parts, damping=disk.damping, axis=disk.axis, nodal_diameters=held)


def test_the_response_of_one_sector_needs_no_others():
    whole = lumped_blisk(sectors=12, engine_order=4)
    some = whole.with_structure(some_of(whole.disk, (0, 4, 6)))
    found, expected = (ss.forced_response(problem, [140.0, 148.0, 150.0], force=3.0, harmonics=3) for problem in (some, whole))
    np.testing.assert_array_equal(found.dataset["amplitude"], expected.dataset["amplitude"])
    assert some.fingerprint != whole.fingerprint
    known = found.dataset["disk_frequency"].notnull().any(["disk_state", "disk_mode"])
    assert known["nodal_diameter"].values[known.values].tolist() == [0, 4, 6]


def test_what_needs_the_others_is_refused():
    whole = lumped_blisk(sectors=12, engine_order=4)
    some = whole.with_structure(some_of(whole.disk, (0, 4, 6)))
    gas = ss.Aerodynamics(influence={0: 2400j}, frequency=152.7)
    for asked in (
        some.full,
        lambda: ss.nodal_diameters(some),
        lambda: some.with_aerodynamics(gas).wave_stiffnesses,
        lambda: some.with_engine_order(3).frequencies(stuck=False),
    ):
        with pytest.raises(InputError, match=r"must hold .*nodal diameters? .*, but is '0, 4, 6'"):
            asked()


def test_the_matrices_of_a_travelling_wave_stay_complex():
    """Also where the highest that is held, 4 of 12, is not N/2."""
    sector = ss.Structure(np.eye(2), 10.0 * np.eye(2), ("a.x", "b.x"))
    whole = ss.sector_chain(sector, 12, [[-1.0, -2.0], [0.5, -1.0]])
    assert np.abs(whole.at(4).K.imag).max() > 1.0
    np.testing.assert_array_equal(some_of(whole, (0, 4)).at(-4).K, whole.at(8).K)
