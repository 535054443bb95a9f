"""Bladed disks: the lumped disk sector by sector, contact stiffness from geometry, the finite-element disk beside the paper."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stickslip.contact.stiffness import NORMAL_STIFFNESS, LineContact
from stickslip.disk import TunedDisk
from stickslip.harmonic.balance import Evaluation, HarmonicBalance
from stickslip.problem import Problem
from stickslip.rigs import lumped_blisk, octopus_blisk
from stickslip.solve.continuation import first_point
from verify.row import INDEPENDENT, Row, absolute, at_most, relative

TITLE = "Bladed disks"
ABOUT = (
    "24 sectors, engine order 2. The lumped disk against an independent script and against all of its sectors; the meshed "
    "disk beside *On the choice of contact parameters for the forced response calculation of a bladed disk with underplatform "
    "dampers*, whose geometry is not published: the stuck 144.9 Hz and the damping were fitted, the rest is predicted."
)
PAPER = "published"


def rows() -> Iterator[Row]:
    yield from stiffness()
    yield from lumped()
    yield from one_against_all()
    yield from meshed()


def stiffness() -> Iterator[Row]:
    """A cylinder of 27.6 mm and 5 mm at F_C/(2 cos 45°)."""
    for (name, formula), value in zip(NORMAL_STIFFNESS.items(), (6.544e8, 6.345e8, 6.063e8), strict=True):
        yield relative(f"k_n at 103.9 N, {name}, N/m", formula(LineContact(27.6e-3, 5e-3), 103.9), value, 1e-4, INDEPENDENT)


def lumped() -> Iterator[Row]:
    wedge, roller = lumped_blisk("W"), lumped_blisk("R")
    for mode, frequency in enumerate((148.6080699, 377.91876149, 508.63701605)):
        yield absolute(
            f"Case W, stuck frequency {mode + 1}, Hz", wedge.frequencies(stuck=True)[mode], frequency, 1e-7, INDEPENDENT
        )
    for mode, frequency in enumerate((131.92083361, 258.14530402, 496.62061886)):
        yield absolute(f"Free frequency {mode + 1}, Hz", wedge.frequencies(stuck=False)[2 + mode], frequency, 1e-8, INDEPENDENT)
    yield absolute("Case R, stuck frequency, Hz", roller.frequencies(stuck=True)[0], 145.517857, 1e-6, INDEPENDENT)
    balance, evaluation = solved(wedge, 148.0, 1e-6)
    static = balance.carried_forces(evaluation)[:, 0]
    yield absolute("Case W, static normal load, N", static[1], 101.21353788, 1e-6, INDEPENDENT)
    yield absolute("Case W, static tangential load, N", static[0], 2.73115896, 1e-6, INDEPENDENT)
    for case, force, frequency, value in (
        ("W", 0.1, 148.60807, 0.589501),
        ("W", 0.4, 148.5656, 0.209084),
        ("R", 0.1, 145.517857, 0.5893424),
        ("R", 0.2, 145.517857, 0.5893424),
    ):
        found = mobility(lumped_blisk(case), frequency, force)
        yield relative(f"Case {case}, mobility at {force:g} N, m/s/N", found, value, 1e-5, INDEPENDENT)


def one_against_all() -> Iterator[Row]:
    for case, frequency, bound in (("W", 148.5, 1e-10), ("R", 145.4, 1e-9)):
        disk = lumped_blisk(case)
        whole = disk.full(reported=[1])
        for harmonics in (3, 5):
            for force in (0.4, 1.6):
                one, every = (output(d, frequency, force, harmonics) for d in (disk, whole))
                error = np.abs(one - every).max() / np.abs(one[1:]).max()
                name = f"Case {case}, one sector against 24, H = {harmonics}, {force:g} N"
                yield at_most(name, error, bound, "all sectors solved together")


def meshed() -> Iterator[Row]:
    stuck = {factor: octopus_blisk(kty=factor * 1.7e7).frequencies(stuck=True)[0] for factor in (0.1, 1.0, 10.0)}
    for factor, published, tolerance in ((0.1, 143.8, 1.5e-2), (1.0, 144.9, 1e-3), (10.0, 150.3, 1.5e-2)):
        yield relative(f"Finite elements, stuck, k_ty = {factor:g} k_tx, Hz", stuck[factor], published, tolerance, PAPER)
    soft, stiff = (across_the_section(octopus_blisk(kty=factor * 1.7e7)) for factor in (0.1, 10.0))
    yield at_most("Mobility across the section, k_ty = 10 k_tx over 0.1 k_tx (published: it falls)", stiff / soft, 1.0, PAPER)
    analytic = octopus_blisk("analytic").frequencies(stuck=True)[0]
    yield at_most("Measured over analytic stuck frequency (published: below 1/1.5)", stuck[1.0] / analytic, 1.0 / 1.5, PAPER)
    formulas = [octopus_blisk(normal_stiffness=name).frequencies(stuck=True)[0] for name in NORMAL_STIFFNESS]
    yield at_most("Spread over three formulas of k_n, relative (published: below 1.5 %)", np.ptp(formulas) / 144.9, 1.5e-2, PAPER)
    disk = octopus_blisk()
    yield relative("Mobility of the stuck peak, m/s/N (fitted)", mobility(disk, stuck[1.0], 1e-6, 1), 0.531, 5e-3, PAPER)
    q = [
        {"x": 1.0, "y": -1.0j}.get(dof[-1], 0.0) if "mode" not in dof and ".r" not in dof else 0.0 for dof in disk.structure.dofs
    ]
    moved = float(np.abs(disk.relative_rows(1) @ np.array(q)).max())
    yield at_most("Relative motion at the dampers under a rigid translation, relative", moved, 1e-12, "closed form")


def solved(problem: Problem, frequency: float, force: float, harmonics: int = 5) -> tuple[HarmonicBalance, Evaluation]:
    """The balance and the solution at one frequency, 384 samples."""
    balance = HarmonicBalance(problem, harmonics, 384)
    return balance, first_point(balance, 2.0 * np.pi * frequency, force).evaluation


def output(problem: Problem, frequency: float, force: float, harmonics: int) -> np.ndarray:
    """Harmonics of the first output, in real storage."""
    balance, evaluation = solved(problem, frequency, force, harmonics)
    return np.asarray(evaluation.w[balance.rows])


def mobility(problem: TunedDisk, frequency: float, force: float, harmonics: int = 5) -> float:
    """|X_1| ω/F of the first output."""
    row = output(problem, frequency, force, harmonics)
    return float(np.hypot(row[1], row[2]) * 2.0 * np.pi * frequency / force)


def across_the_section(disk: TunedDisk) -> float:
    """|φ·e|²/(2ζω φᴴMφ) of the first stuck mode at the tip, m/s/N with ζ = 1: e the direction of its motion there."""
    modes, names = disk.modes(disk.engine_order), disk.structure.dofs
    shape, M = modes.shapes[:, 0], disk.matrices(disk.engine_order).M
    tip = shape[[names.index(f"tip.{axis}") for axis in "xyz"]]
    square = np.linalg.svd(np.stack([tip.real, tip.imag]), compute_uv=False)[0] ** 2
    return float(square / (4.0 * np.pi * modes.frequencies[0] * (shape.conj() @ M @ shape).real))
