"""Left forces, their place, slip and friction from what a rig measures, against the contact forces of a computed cycle."""

import numpy as np
import pytest

from stickslip.analyses.damper_alone.cycle import damper_cycle
from stickslip.laboratory.measurement.cycles import whole_cycles
from stickslip.laboratory.measurement.reconstruction import damper_motion, reconstruct, reconstructed
from stickslip.laboratory.measurement.records import Record, read_record
from stickslip.model.dampers.between_platforms import in_phase, out_of_phase
from stickslip.model.dampers.laboratory import laboratory_damper
from stickslip.support.checks import InputError
from verify.synthetic_records import synthetic_record, true_cycle, write_record

FRICTION = (0.18, 0.199, 0.45)
RIG = laboratory_damper(37.0, 80.0, FRICTION)
MOTION = out_of_phase(30e-6)


@pytest.fixture(scope="module")
def cycle():
    return damper_cycle(RIG, MOTION, steps=400).dataset


def test_the_left_force_and_its_place(cycle):
    forces = {"force_x": cycle.force_on_right.values[:, 0], "force_y": cycle.force_on_right.values[:, 1]}
    found = reconstructed(RIG, forces, 80.0)
    normal = cycle.normal_force.values
    np.testing.assert_allclose(found["right_normal"], normal[:, 2], atol=1e-6)
    np.testing.assert_allclose(found["left_normal"], normal[:, 0] + normal[:, 1], atol=1e-6)
    np.testing.assert_allclose(np.abs(found["right_ratio"]), np.abs(cycle.force_ratio.values[:, 2]), atol=1e-7)
    # Not 0.45: the right side rolls from here on (independent derivation of this project). A plateau is a bound of friction.
    assert np.quantile(np.abs(found["right_ratio"]), 0.96) == pytest.approx(0.406928, rel=1e-4)


def test_the_errors_come_from_the_rig():
    cycles = whole_cycles(synthetic_record(true_cycle(RIG, MOTION, 800), cycles=6, seed=2))
    data = reconstruct(cycles, RIG, draws=60)
    assert data.right_normal.units == "N"
    assert 0.5 < float(data.left_normal_error.mean()) < 2.0
    truth = damper_cycle(RIG, MOTION, steps=500).dataset.normal_force.values[:, 2]
    assert np.mean(np.abs(data.right_normal.values - truth) < 3.0 * data.right_normal_error.values) > 0.95


def test_rotation_from_two_lasers(cycle):
    y, turn = cycle.damper_motion.values[:, 1], cycle.damper_motion.values[:, 2]
    count = 4 * y.size
    time = np.arange(count) / y.size
    record = {"laser_1": np.tile(y - 5e-3 * turn, 4), "laser_2": np.tile(y + 9e-3 * turn, 4)}
    record["platform_x"] = np.tile(MOTION.samples(y.size)[:, 0], 4)
    found = damper_motion(whole_cycles(Record(time, record), 1.0), 14e-3, 5e-3)
    np.testing.assert_allclose(found.cycle("rotation", y.size), turn, atol=0.02 * np.ptp(turn))
    np.testing.assert_allclose(found.cycle("damper_y", y.size), y, atol=0.02 * np.ptp(y))


@pytest.mark.parametrize("friction", [FRICTION, (0.14, 0.13, 0.25)])
@pytest.mark.parametrize("move", [out_of_phase, in_phase])
def test_rolling_and_translation_at_the_right(friction, move):
    """Slip ds - dr is what the contact of a computed cycle moves, its normal deformation known; the axis of the cylinder,
    7 mm from the mass centre, goes by ds, and dr is radius times rotation. With friction 0.45 it rolls, else it slides."""
    rig = laboratory_damper(37.0, 80.0, friction)
    data = damper_cycle(rig, move(30e-6), steps=400).dataset
    x, y, turn = data.damper_motion.values.T
    signals = {"force_x": data.force_on_right.values[:, 0], "force_y": data.force_on_right.values[:, 1]}
    signals |= {"rotation": turn, "damper_y": y}
    found = reconstructed(rig, signals, 80.0, 84e6)
    own = -data.tangential_motion.values[:, 2]  # of the damper relative to the platform
    np.testing.assert_allclose(found["right_slip"], own - own.mean(), atol=1e-13)
    angle = np.radians(37.0)
    tangent, axis = np.array([-np.cos(angle), np.sin(angle)]), 7e-3 * np.array([np.sin(angle), np.cos(angle)])
    moved = tangent[0] * (x - axis[1] * turn) + tangent[1] * (y + axis[0] * turn)
    np.testing.assert_allclose(found["right_translation"], moved - moved.mean(), atol=1e-13)
    np.testing.assert_allclose(np.ptp(found["right_rolling"]), 5e-3 * np.ptp(turn), rtol=1e-12)
    share = np.ptp(found["right_slip"]) / np.ptp(found["right_translation"])
    assert share < 0.2 if friction is FRICTION else share > 0.99
    rough = reconstructed(rig, signals, 80.0)
    assert 0.1e-6 < np.max(np.abs(rough["right_slip"] - found["right_slip"])) < 0.5e-6


def test_motion_at_the_right_has_errors_and_needs_the_lasers():
    record = synthetic_record(true_cycle(RIG, MOTION, 800), cycles=6, seed=2)
    data = reconstruct(whole_cycles(record), RIG, draws=60)
    assert 0.02 < float(data.right_translation_error.max() / abs(data.right_translation).max()) < 0.15
    cells = {name: values for name, values in record.signals.items() if name not in ("rotation", "damper_y")}
    assert "right_slip" not in reconstruct(whole_cycles(Record(record.time, cells)), RIG, draws=2)
    with pytest.raises(InputError, match="kn"):
        reconstruct(whole_cycles(record), RIG, draws=2, kn=-1.0)


def cells_record(cycles=6, rate=500.0, samples=200):
    """Readings of both dampers from chosen forces on their cylinders, resolved by hand: the platform rises at 40 degrees; a force
    N across and T up along the other one, falling outwards, presses the separator with N n - T t."""
    phase = np.arange(cycles * samples) / samples
    angle, c, s = 2.0 * np.pi * phase, np.cos(np.radians(40.0)), np.sin(np.radians(40.0))
    signals, truth = {}, {}
    for side, shift in (("left", 0.0), ("right", 1.0)):
        normal, friction = 30.0 + 6.0 * np.sin(angle + shift), 8.0 * np.tanh(3.0 * np.cos(angle + shift))
        signals[f"{side}_outward"] = s * normal + c * friction
        signals[f"{side}_upward"] = c * normal - s * friction
        truth[side] = normal[:samples], friction[:samples]
    return Record(phase / rate, signals, "cells"), truth


def test_forces_of_the_dampers_of_the_blade_rig_are_those_of_the_page(tmp_path):
    """The formulas of docs/identification.md: at the cylinder what was put in, at the flat what balances that and the pull."""
    record, truth = cells_record()
    read = read_record(write_record(record, tmp_path / "cells.csv"))
    cycles, pull = whole_cycles(read), 45.0
    assert cycles.frequency == pytest.approx(500.0, rel=1e-3)
    cycles = whole_cycles(read, 500.0)
    c, s = np.cos(np.radians(40.0)), np.sin(np.radians(40.0))
    for side, (normal, friction) in truth.items():
        x, y = (cycles.cycle(f"{side}_{cell}", 200) for cell in ("outward", "upward"))
        np.testing.assert_allclose(s * x + c * y, normal, atol=1e-3)
        np.testing.assert_allclose(c * x - s * y, friction, atol=1e-3)
        flat_friction, flat_load = c * x + s * (y - pull), s * x - c * (y - pull)
        np.testing.assert_allclose(-x + s * flat_load + c * flat_friction, 0.0, atol=1e-9)
        np.testing.assert_allclose(-y - c * flat_load + s * flat_friction + pull, 0.0, atol=1e-9)


def test_clipped_readings_of_a_cell_are_refused():
    record, _ = cells_record()
    with pytest.raises(InputError, match="must not be clipped"):
        Record(record.time, dict(record.signals) | {"left_upward": np.minimum(record.signals["left_upward"], 22.0)})
