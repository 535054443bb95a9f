"""One mistuned wheel on the forces of its contacts, sector by sector, against the whole disk on all degrees of freedom."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import linalg

import stickslip as ss
from stickslip.analyses.mistuning.disk import blade_dofs, deviating_contacts
from stickslip.analyses.mistuning.work import PopulationWork
from stickslip.solve.balance.balance import HarmonicBalance, PathCondition, Point
from stickslip.solve.balance.energy import contact_cycle
from stickslip.solve.continuation.curve_points import LostCurveError
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.wheels.balance import WheelBalance, WheelResonances
from stickslip.solve.wheels.curve import _open
from stickslip.solve.wheels.tuned import Shapes, TunedWheel

SECTORS, MASSES, H, SAMPLES, LEVEL = 6, 16, 3, 60, 1.5
BLADE = ["tip", *(f"{k}.x" for k in range(9, MASSES))]
"""All above the sixth mass, where the dampers are, but what couples the neighbours."""


def chain_disk():
    """A blade of 16 masses a sector, its eighth coupled to the neighbours; dampers with two motions rub at three masses and the
    next sector's, pressed by a pull and by the vibration."""
    k, m = 4e6, 0.02
    K = 2.0 * k * np.eye(MASSES) - k * (np.eye(MASSES, k=1) + np.eye(MASSES, k=-1))
    K[-1, -1] = k
    ring = np.zeros_like(K)
    ring[7, 7] = 2e5
    sector = ss.Structure(m * np.eye(MASSES), K + 2.0 * ring, [f"{k}.x" for k in range(1, MASSES)] + ["tip.x"])
    damper = ss.Structure(np.diag([0.01, 0.012]), np.zeros((2, 2)), ["damper.x", "damper.y"])
    disk = ss.with_bodies(ss.sector_chain(sector, SECTORS, -ring), {"body": damper})
    law = ss.Macroslip(kt=3e5, kn=4e5, mu=0.3)
    contacts = []
    for n, place in enumerate((4, 5, 6)):
        for name, side, sign in (("own", "", 1.0), ("following", "next/", -1.0)):
            tangential = ({"body/damper.x": 1.0, f"{side}{place}.x": -1.0},)
            normal = {"body/damper.y": 1.0, f"{side}{place}.x": sign * 0.3}
            contacts.append(ss.Contact(f"{name} {n}", law, tangential, normal))
    forces = [ss.Force("tip.x", 1.0), ss.Force("body/damper.y", 0.0, static=40.0), ss.Force("12.x", 0.0, static=2.0)]
    held = (ss.Spring({"body/damper.x": 1.0}, 1e4),)
    damped = disk.with_damping(ss.ModalDamping(2e-3))
    return ss.TunedDisk(damped, contacts, forces, ["tip.x"], mean_springs=held, engine_order=1)


DISK = chain_disk()
FIRST = float(DISK.frequencies(stuck=True)[0])
BAND = tuple(2.0 * np.pi * FIRST * np.array([0.97, 1.02]))
DEVIATIONS = ss.Mistuning(
    blade=[0.01, -0.02, 0.005, 0.0, -0.01, 0.015], mu=[0.1, 0.0, -0.1, 0.2, 0.0, 0.0], pull=[0.0, 0.1, -0.1, 0.0, 0.05, 0.0]
).of(SECTORS)

SPRINGS = ss.Mistuning(
    blade=DEVIATIONS.blade, kt=[0.1, -0.2, 0.15, 0.0, 0.05, -0.1], kn=[-0.1, 0.1, 0.0, 0.2, -0.15, 0.05], pull=DEVIATIONS.pull
).of(SECTORS)
"""Contacts with other springs than those of the tuned disk, too."""


@cache
def tuned():
    """The wheel with eight of eighteen families in its Ritz basis."""
    return TunedWheel(DISK, blade_dofs(DISK, BLADE), H, BAND, 3.0 * H * BAND[1] / (2.0 * np.pi))


def wheel_balance(least=0.0, given=DEVIATIONS):
    wheel = tuned()
    shapes = Shapes(wheel, wheel.shapes(least) if least else np.eye(wheel.stiffness.size))
    contacts = deviating_contacts(DISK.contacts * SECTORS, given)
    return WheelBalance(wheel, shapes, SAMPLES, contacts, given.deviation("blade"), 1.0 + given.deviation("pull"))


def whole_balance(given=DEVIATIONS):
    return HarmonicBalance(ss.mistuned_disk(DISK, given, BLADE), H, SAMPLES)


def some_forces(balance, size=0.5):
    """Forces of all harmonics, of about a size in the units of the shapes."""
    return size * np.random.default_rng(5).standard_normal((balance.rows, balance.columns)) / np.arange(1, balance.columns + 1)


@cache
def slipping(given=DEVIATIONS):
    """A balance on all rows and a solved point of it near the resonance, in which contacts slip and open."""
    balance = wheel_balance(given=given)
    omega = 0.995 * 2.0 * np.pi * FIRST
    forces = np.zeros((balance.rows, balance.columns))
    for level in (0.1, 0.2, 0.3, 0.5, 0.7):
        found = correct(balance, Point(forces, omega, level), fixed("omega", omega), iterations=40, halvings=8)
        assert found.converged
        forces = found.evaluation.point.forces
    return balance, found.evaluation


def test_it_moves_as_the_whole_disk_does():
    """Contacts and blades under loads, pulls and arbitrary contact forces of all harmonics: with eight families of eighteen, what
    the others add and how the blades' deviations meet them is known to 1e-4; without them it would be wrong by a tenth."""
    balance, whole = wheel_balance(), whole_balance()
    forces, scale = some_forces(balance), np.sqrt(np.tile(DISK.contact_stiffness, SECTORS))[:, None]
    for share in (0.972, 1.0, 1.018):
        omega = share * 2.0 * np.pi * FIRST
        found = balance.motion(Point(forces, omega, LEVEL))
        expected = whole.linear.motion(forces * scale, omega, LEVEL)
        expected[: balance.rows] *= scale
        for h in range(balance.columns):
            assert np.linalg.norm(found[:, h] - expected[:, h]) < 2e-4 * np.linalg.norm(expected[:, h]), (share, h)


@pytest.mark.parametrize("given", [DEVIATIONS, SPRINGS])
def test_derivatives_are_those_of_differences(given):
    """Of the motion by ω, and of the residual by the contact forces while contacts slip and open."""
    balance, evaluation = slipping(given)
    point, step = evaluation.point, 1e-4
    ends = [balance.motion(Point(point.forces, point.omega + s, point.level)) for s in (-step, step)]
    np.testing.assert_allclose(balance.slope(point), (ends[1] - ends[0]) / (2.0 * step), atol=1e-7 * np.abs(ends[0]).max())
    at, beside = balance.at(point.omega), [balance.at(point.omega + s) for s in (-step, step)]
    for name, slope in (("by_forces", at.forces_slope), ("by_load", at.load_slope)):
        change = (getattr(beside[1], name) - getattr(beside[0], name)) / (2.0 * step)
        np.testing.assert_allclose(slope, change, atol=1e-6 * np.abs(change).max())
    assert (evaluation.unknown > 0).mean() > 0.3
    change = 1e-6 * some_forces(balance)
    ends = [balance.evaluate(Point(point.forces + s * change, point.omega, point.level)).residual for s in (-1.0, 1.0)]
    moved = balance.change(change, point.omega)[: balance.rows]
    pushed = balance.derivative(evaluation).astype(float) @ moved.reshape(SECTORS, -1, 1)
    expected = change - pushed.reshape(change.shape)
    assert np.linalg.norm(0.5 * (ends[1] - ends[0]) - expected) < 1e-5 * np.linalg.norm(expected)


def test_newton_systems_are_solved_with_the_path_condition():
    """J δμ − ∂λ̂/∂z ∂z/∂ω δω = v and the condition, to the tolerance; the preconditioner alone comes near."""
    balance, evaluation = slipping()
    rng = np.random.default_rng(2)
    condition = PathCondition("omega", rng.standard_normal(evaluation.w.shape), 0.3, 0.0)
    factors, v = balance.factorise(evaluation, condition), some_forces(balance, 1e-3)
    slope = balance.slope(evaluation.point)
    for found, allowed in ((factors.solve(v, 0.2, 1e-6), 1e-5), (factors.estimate(v, 0.2), 0.05)):
        moved = balance.change(found.forces, evaluation.point.omega) + found.omega * slope
        np.testing.assert_allclose(found.motion, moved, rtol=1e-9, atol=1e-12 * np.abs(moved).max())
        pushed = balance.derivative(evaluation).astype(float) @ moved[: balance.rows].reshape(SECTORS, -1, 1)
        missed = found.forces - pushed.reshape(v.shape) - v
        assert np.linalg.norm(missed) < allowed * np.linalg.norm(found.forces)
        assert condition.rate(found.motion, found.omega) == pytest.approx(0.2, rel=1e-9)
    assert 0 < factors.products < 12


def test_newton_systems_near_a_fold_are_solved_to_the_residual():
    """Along the weakest direction of J the change is much larger than v; what is missed stays a share of v."""
    balance, evaluation = slipping()
    omega, n = evaluation.point.omega, evaluation.residual.size
    D = linalg.block_diag(*balance.derivative(evaluation).astype(float))
    J = np.eye(n) + D @ balance.receptance(omega).reshape(n, n)
    U, sizes, _ = linalg.svd(J)
    v = U[:, -1].reshape(evaluation.residual.shape)
    assert sizes[-1] < 0.2
    found = balance.factorise(evaluation, fixed("omega", omega)).solve(v, 0.0, 0.05)
    assert np.linalg.norm(J @ found.forces.ravel() - v.ravel()) < 0.051


def test_a_point_is_a_point_of_the_whole_disk():
    """From the wheel's solution on all rows the whole disk's Newton method hardly moves; on few shapes blades stay near."""
    balance, evaluation = slipping()
    whole, point = whole_balance(), evaluation.point
    scale = np.sqrt(np.tile(DISK.contact_stiffness, SECTORS))[:, None]
    found = correct(whole, Point(point.forces * scale, point.omega, point.level), fixed("omega", point.omega), iterations=8)
    assert found.converged
    expected = np.hypot(*found.evaluation.w[whole.rows :, 1:3].T)
    np.testing.assert_allclose(np.hypot(*evaluation.w[balance.rows :, 1:3].T), expected, rtol=2e-4)
    few = wheel_balance(1e-3)
    assert few.rows < balance.rows
    forces = few.shapes.U.T @ point.forces.reshape(SECTORS, -1, few.columns)
    start = Point(forces.reshape(few.rows, -1), point.omega, point.level)
    found = correct(few, start, fixed("omega", point.omega), iterations=20, halvings=8)
    assert found.converged
    np.testing.assert_allclose(np.hypot(*found.evaluation.w[few.rows :, 1:3].T), expected, rtol=1e-2)


def test_a_point_with_springs_of_its_own_is_a_point_of_the_whole_disk():
    """Contact stiffness deviates: the whole disk's λ is counted from its own springs, λ − ΔK w."""
    balance, evaluation = slipping(SPRINGS)
    whole, point, rows = whole_balance(SPRINGS), evaluation.point, balance.rows
    stiffness = np.sqrt(np.tile(DISK.contact_stiffness, SECTORS))[:, None]
    forces = point.forces * stiffness - balance.stiffer[:, None] * evaluation.w[:rows] / stiffness
    found = correct(whole, Point(forces, point.omega, point.level), fixed("omega", point.omega), iterations=8)
    assert found.converged
    expected = np.hypot(*found.evaluation.w[rows:, 1:3].T)
    np.testing.assert_allclose(np.hypot(*evaluation.w[rows:, 1:3].T), expected, rtol=3e-4)


@pytest.mark.parametrize(("given", "allowed"), [(DEVIATIONS, 1e-6), (SPRINGS, 1e-4)])
def test_resonances_are_those_of_the_whole_stuck_disk(given, allowed):
    balance, whole = wheel_balance(given=given), whole_balance(given)
    ours, theirs = WheelResonances(balance), whole.linear.resonances
    low, high = 0.8 * BAND[0], 1.3 * BAND[1]
    first = [omega for omega, h, k in zip(theirs.omega, theirs.harmonic, theirs._number, strict=True) if h == 1 and k % 2 == 0]
    expected = [omega for omega in first if low < omega < high]
    found = [omega for omega, h in zip(ours.omega, ours.harmonic, strict=True) if h == 1 and low < omega < high]
    np.testing.assert_allclose(found, expected, rtol=allowed)
    assert len(found) == SECTORS


def test_the_tuned_wave_is_a_solution_of_the_tuned_wheel():
    wheel, omega = tuned(), 0.99 * 2.0 * np.pi * FIRST
    sector = HarmonicBalance(DISK, H, SAMPLES)
    one = correct(sector, sector.stuck_point(omega, 0.3), fixed("omega", omega), iterations=40, halvings=12)
    assert one.converged
    U, none = np.eye(wheel.stiffness.size), np.zeros(SECTORS)
    balance = WheelBalance(wheel, Shapes(wheel, U), SAMPLES, DISK.contacts * SECTORS, none, 1.0 + none)
    found = balance.evaluate(Point(wheel.wave(one.evaluation.point.forces, U), omega, 0.3))
    assert found.error < 1e-6
    expected = np.hypot(*one.evaluation.w[-1, 1:3])
    np.testing.assert_allclose(np.hypot(*found.w[balance.rows :, 1:3].T), expected, rtol=1e-6)


ASKED = {"harmonics": H, "samples": SAMPLES, "blade": BLADE}


def work_of(disk=DISK, scatter=None, **given):
    return PopulationWork(disk, ss.hertz(0.97 * FIRST, 1.02 * FIRST), 1, scatter or ss.Scatter(blade=0.01), **ASKED | given)


def test_which_disks_are_solved_sector_by_sector():
    """Those with fewer shapes than contact rows, one damping ratio, every damper, and the tuned contact stiffness in the mean."""
    assert work_of().by_sector
    assert work_of(scatter=ss.Scatter(kt=0.1, mu=0.1, pull=0.1), mistuning=ss.Mistuning(kn=0.1)).by_sector
    assert work_of(mistuning=ss.Mistuning(kt=[0.5, -0.5, 0.0, 0.5, -0.5, 0.0])).by_sector
    lumped = ss.rigs.lumped_blisk("W", sectors=6)
    assert not PopulationWork(lumped, ss.hertz(140.0, 156.0), 1, ss.Scatter(blade=0.01)).by_sector
    for other in (
        work_of(scatter=ss.Scatter(missing=0.1)),
        work_of(mistuning=ss.Mistuning(missing=[2])),
        work_of(mistuning=ss.Mistuning(kt=-0.3)),
        work_of(mistuning=ss.Mistuning(kn=0.3)),
        work_of(harmonics=[0, 1, 3]),
        work_of(disk=DISK.with_structure(DISK.structure.with_damping(ss.ModalDamping([2e-3, 1e-3])))),
        work_of(disk=DISK.with_structure(DISK.structure.with_damping(ss.RayleighDamping(1.0, 1e-6)))),
        PopulationWork(DISK, [FIRST, 1.01 * FIRST], 1, ss.Scatter(blade=0.01), **ASKED),
    ):
        assert not other.by_sector


def test_finite_element_disks_are_run_in_unless_said_otherwise():
    assert work_of(force=LEVEL).started is not DISK
    assert work_of(force=LEVEL, run_in=False).started is not work_of(force=LEVEL).started
    lumped = ss.rigs.lumped_blisk("W", sectors=6)
    work = PopulationWork(lumped, ss.hertz(140.0, 156.0), 1, ss.Scatter(blade=0.01), harmonics=1, samples=24)
    assert work.started is work.tuned


@pytest.mark.parametrize(
    ("scatter", "mistuning"),
    [
        (ss.Scatter(blade=0.01), None),
        (ss.Scatter(), SPRINGS),
        (ss.Scatter(), ss.Mistuning(kt=[-0.2, 0.0, 0.0, 0.0, 0.0, -0.1], kn=-0.1)),
    ],
)
def test_peaks_of_blades_are_those_of_the_whole_disk(scatter, mistuning, monkeypatch):
    """Each blade's highest amplitude over the band, and the friction work of the dampers at the highest of all; with few shapes
    for the path, the highest blade is finer. Blade frequencies or springs of contacts deviate."""
    asked = {"force": 0.3, "harmonics": 1, "samples": 24, "run_in": True, "mistuning": mistuning}
    shares = 0.97, 1.02
    work, whole = (PopulationWork(DISK, ss.hertz(*(s * FIRST for s in shares)), 1, scatter, **ASKED | asked) for _ in "ab")
    monkeypatch.setitem(vars(whole), "by_sector", False)
    found, expected = (each.solve(1, lambda share: None) for each in (work, whole))
    assert str(found["message"]) == "Converged."
    assert found["peak"].max() == pytest.approx(expected["peak"].max(), rel=5e-4)
    np.testing.assert_allclose(found["peak"], expected["peak"], rtol=1e-2)
    np.testing.assert_allclose(found["peak_frequency"], expected["peak_frequency"], rtol=1e-3)
    assert found["damper_work"].sum() == pytest.approx(expected["damper_work"].sum(), rel=1e-2)
    assert found["frequency"][[0, -1]] == pytest.approx([s * FIRST for s in shares])
    assert found["amplitude"].shape == (found["frequency"].size, SECTORS)
    assert found["frequency"].size < 1.5 * expected["frequency"].size

    def lost(*_):
        raise LostCurveError("It ended.")

    monkeypatch.setattr(work.wheels, "curve", lost)
    again = work.solve(1, lambda share: None)
    np.testing.assert_allclose(again["peak"], expected["peak"], rtol=1e-6)
    assert str(again["message"]).startswith("Solved as a whole")
    monkeypatch.setattr(type(work), "large", True)
    again = work.solve(1, lambda share: None)
    assert np.isnan(again["peak"]).all()
    assert str(again["message"]).startswith("It ended. Take a lower force")


def test_a_disk_without_deviations_is_the_tuned_disk():
    """Every blade as the one of the tuned disk, bit by bit, whatever the wheel's own solver can follow."""
    work = work_of(scatter=ss.Scatter(blade=0.0), force=0.3, harmonics=1, samples=24)
    tuned, disk = (work.solve(case, lambda share: None) for case in (0, 1))
    assert work.by_sector
    for name in ("peak", "peak_frequency", "damper_work"):
        assert disk[name].tolist() == SECTORS * tuned[name].tolist(), name
    assert disk["amplitude"].shape == (tuned["frequency"].size, SECTORS)
    assert disk["stress"].shape[0] == SECTORS


def test_the_receptance_and_its_determinant_are_those_of_the_wheel():
    """All columns of R as the motion of single forces; the sign of the determinant is that of J with the path condition."""
    balance, evaluation = slipping()
    omega, forces = evaluation.point.omega, some_forces(balance)
    R = balance.receptance(omega)
    moved = balance.change(forces, omega)[: balance.rows]
    np.testing.assert_allclose(np.tensordot(R, -forces, 2), moved, atol=1e-6 * np.abs(moved).max())
    D, n = linalg.block_diag(*balance.derivative(evaluation)), forces.size
    J = np.eye(n) + D @ R.reshape(n, n)
    by_omega = balance.slope(evaluation.point)[: balance.rows].ravel()
    balance.oriented = True
    try:
        signs = []
        for sign in (-1.0, 1.0):
            weight = sign * np.random.default_rng(1).standard_normal(evaluation.w.shape)
            condition = PathCondition("omega", weight, 0.0, 0.0)
            row, slope = np.zeros(n), 0.0
            row = -weight.ravel()[:n] @ R.reshape(n, n)
            outputs = [balance.change(unit.reshape(forces.shape), omega)[balance.rows :] for unit in np.eye(n)]
            row = row + np.array([np.vdot(weight[balance.rows :], each) for each in outputs])
            slope = np.vdot(weight, balance.slope(evaluation.point))
            v = -(D @ by_omega) - evaluation.state.by_omega.ravel()
            whole = np.block([[J, v[:, None]], [row[None], np.array([[slope]])]])
            assert balance.factorise(evaluation, condition).orientation == np.linalg.slogdet(whole)[0]
            signs.append(np.linalg.slogdet(whole)[0])
        assert signs[0] == -signs[1]
    finally:
        balance.oriented = False


def test_lost_curves_say_how_many_contacts_lift_off():
    """At a higher level than that of a solved point some contacts open and others do not."""
    balance, solved = slipping()
    evaluation = balance.evaluate(replace(solved.point, level=2.0 * solved.point.level))
    words = _open(balance, SimpleNamespace(point=evaluation.point, evaluation=evaluation))
    gaps = balance.contacts_of(evaluation.w)
    table = balance.table
    force = contact_cycle(table, balance.tables, gaps, evaluation.point.omega).force[table.normal_row]
    opened = int((force.min(axis=1) == 0.0).sum())
    assert 0 < opened < len(force)
    assert f"{opened} of {len(force)} contacts lift off." in words
