"""A mode is a forced motion: with the force 2iζω²M Q₁ in quadrature at ω, the balance of forced responses has the same solution.

That balance keeps no mode apart and knows neither ζ nor a; it is tested against closed forms and time integration elsewhere.
"""

from dataclasses import replace

import numpy as np
import pytest
from balance.problems import everything, structure

import stickslip as ss
from stickslip.model.contact.law import Law
from stickslip.solve.balance.balance import HarmonicBalance, Point
from stickslip.solve.balance.fourier import complex_harmonics
from stickslip.solve.balance.mode_balance import ModeBalance
from stickslip.solve.curves.mode_curve import solve_mode
from stickslip.support.outcome import Outcome

ALONG, ACROSS, NORMAL = ({f"{mass}.x": 1.0, "2.y": 0.3} for mass in (1, 2, 3))
UNCOUPLED = np.diag([0.02, 0.05, 0.01, 0.03, 0.04, 0.02])
"""Damping of the masses that couples the stuck modes."""


def with_law(law: Law, C: np.ndarray | None = None) -> ss.Problem:
    """Three masses on two contacts of a law, the second across the first where a law couples its directions."""
    directions = (ALONG, ACROSS) if law.couples_directions else (ALONG,)
    tangential = directions if getattr(law, "kt", None) is not None or not law.has_normal else ()
    contacts = (ss.Contact("one", law, tangential, NORMAL if law.has_normal else None),)
    return ss.Problem(structure(C), contacts, (ss.Force("1.x", 1.0),), ("1.x", "2.y"), "One law")


def mistuned() -> ss.Problem:
    """Three sectors with springs between blades of their own: modes that are close, and complex once contacts slip."""
    disk = ss.rigs.lumped_blisk(sectors=3, engine_order=1).full()
    tips = [k for k, dof in enumerate(disk.structure.dofs) if "tip" in dof]
    K = disk.structure.K.copy()
    K[tips, tips] *= 1.0 + np.array([0.02, -0.01, 0.015])
    return disk.with_structure(replace(disk.structure, K=K))


def stuck(preload: float = 1.0) -> dict[str, ss.Problem]:
    return {
        "every kind of contact": everything(),
        "damping that couples modes": everything(C=UNCOUPLED),
        "slider of constant load": with_law(ss.Macroslip(0.8, 0.5, normal_load=preload), UNCOUPLED),
        "friction disc": with_law(ss.FrictionDisc(0.8, 0.5, 1.0, preload)),
        "Dahl": with_law(ss.Dahl(0.8, 0.5, normal_load=preload), UNCOUPLED),
        "tanh Coulomb": with_law(ss.TanhCoulomb(0.5, 0.3, normal_load=preload)),
        "cubic spring": with_law(ss.CubicSpring(0.3)),
        "held by friction alone": ss.rigs.blade_and_wedge(),
        "disk": ss.rigs.lumped_blisk(),
        "rolling disk": ss.rigs.lumped_blisk("R"),
        "mistuned disk": mistuned(),
    }


PROBLEMS = stuck()
LARGEST = {"disk": 2e-4, "mistuned disk": 2e-4, "rolling disk": 2e-4, "held by friction alone": 3e-4}


def as_forced(problem: ss.Problem, balance: ModeBalance, evaluation, samples: int) -> tuple[HarmonicBalance, Point]:
    """The balance under the force that the mode stands for, and the point of the mode in it."""
    omega, zeta = balance.omega_of(evaluation.point), balance.damping_of(evaluation.point)
    moved = complex_harmonics(balance.whole_motion(evaluation))[:, 1]
    load = 2.0j * zeta * omega**2 * (problem.systems.at(1).M @ moved)
    forces = [
        ss.Force(dof, complex(value)) for dof, value in zip(problem.structure.dofs, load, strict=True) if abs(value) > 1e-300
    ]
    static = [replace(force, amplitude=0.0) for force in problem.forces]
    forced = HarmonicBalance(problem.with_forces([*static, *forces]), balance.harmonics, samples)
    return forced, Point(np.ascontiguousarray(evaluation.point.forces[: balance.rows]), omega, 1.0)


@pytest.mark.parametrize("name", PROBLEMS)
def test_the_mode_solves_the_balance_of_forced_responses(name):
    problem = PROBLEMS[name]
    samples = 96
    balance = ModeBalance(problem, 3, samples, 0)
    shape = float(np.max(np.abs(balance.shape[balance.rows :])))
    largest = LARGEST.get(name, 5.0)
    curve = solve_mode(balance, balance.level_of(0.02 * largest / shape), balance.level_of(largest / shape))
    assert curve.outcome == Outcome.CONVERGED, curve.message
    for point in curve.points[:: max(len(curve.points) // 6, 1)]:
        forced, place = as_forced(problem, balance, point.evaluation, samples)
        found = forced.evaluate(place)
        scale = np.abs(point.evaluation.w).max()
        assert np.abs(found.w - point.evaluation.w).max() < 1e-8 * scale
        assert found.error < 1e-8


def test_peaks_of_a_tuned_disk_are_those_of_sweeps():
    """Travelling waves of nodal diameter 2 in one sector: 24 blades with wedges, 0.1 to 4 N, H 3."""
    disk = ss.rigs.lumped_blisk()
    levels = [0.1, 0.4, 1.0, 4.0]
    modes = ss.nonlinear_modes(disk, amplitude=(1e-6, 3e-4), harmonics=3, samples=96)
    swept = ss.forced_response(disk, ss.hertz(140.0, 150.0), levels, harmonics=3, samples=96).peaks()
    np.testing.assert_allclose(modes.peaks(levels)["amplitude"], swept[swept["peak"] == 0]["amplitude"], rtol=1e-2)


def test_one_of_a_pair_of_modes_is_refused():
    disk = ss.rigs.lumped_blisk(sectors=6).full()
    assert disk.frequencies(stuck=True)[2] == pytest.approx(disk.frequencies(stuck=True)[3], rel=1e-9)
    with pytest.raises(ss.InputError, match=r"a frequency of its own.*one of a pair.*TunedDisk"):
        ss.nonlinear_modes(disk, 3, harmonics=1, samples=48)
