"""A damper between prescribed platforms by harmonic balance: beside quasi-static steps and time integration a third method."""

from dataclasses import dataclass

import numpy as np

from stickslip.model.dampers.between_platforms import DAMPER, LEFT, RIGHT, BetweenPlatforms, PlatformMotion
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.structure.matrices import Structure
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.balance.energy import cycle_work
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.support.checks import Array
from stickslip.support.machine import one_blas_thread

FIRST, FINEST = 0.02, 1e-4
"""Share of the motion by which it grows at first, from stuck contacts, and the smallest that is tried where Newton fails."""

GROWTH = 1.5
"""By what a step follows one that succeeded; it is halved after a failure."""


@dataclass(frozen=True, eq=False)
class HarmonicCycle:
    """force_on_right (2, 2H+1): x and y in real harmonics, N; contact forces and motion (rows, 2H+1); energy of a cycle, J."""

    force_on_right: Array
    contact_force: Array
    contact_motion: Array
    energy: float


def harmonic_cycle(
    rig: BetweenPlatforms, motion: PlatformMotion, frequency: float, harmonics: int = 15, samples: int = 512
) -> HarmonicCycle:
    """The steady cycle with virgin sliders, inertia included, at a frequency [Hz].

    The motion grows from stuck contacts on, each time from the solution before, by steps that fit.
    """
    omega = 2.0 * np.pi * frequency
    with one_blas_thread():
        balance = HarmonicBalance(platform_problem(rig, motion), harmonics, samples)
        found = _grown(balance, omega)
        force, moved = balance.carried_forces(found), found.w[: balance.rows]
    return HarmonicCycle(-rig.rows(RIGHT).T @ force, force, moved, float(np.sum(cycle_work(force, moved))))


def _grown(balance: HarmonicBalance, omega: float) -> Evaluation:
    """The solution at the whole motion."""
    point, reached, step = balance.stuck_point(omega, FIRST), 0.0, FIRST
    while True:
        goal = min(reached + step, 1.0)
        found = correct(balance, Point(point.forces, omega, goal), fixed("level", goal), 40, halvings=8, patience=4)
        if not found.converged:
            step *= 0.5
        elif goal == 1.0:
            return found.evaluation
        else:
            point, reached, step = found.evaluation.point, goal, GROWTH * step
        assert step >= FINEST, f"no solution beyond {reached:.0%} of the motion"


def platform_problem(rig: BetweenPlatforms, motion: PlatformMotion, ratio: float = 1e5) -> Problem:
    """The left platform is held by springs `ratio` times as stiff as its contacts, whose far ends move as prescribed.

    The platform follows to about 1/ratio. A rigid right platform is held the same way. Outputs: the damper's x and y, and the
    forces are those of the contacts. Force level 1 is the motion as given.
    """
    table = rig.table
    spring = ratio * float(table.stiffness.sum() + table.normal_stiffness.sum())
    dofs = (*DAMPER, *LEFT, *RIGHT)
    M, C, K = (np.zeros((len(dofs), len(dofs))) for _ in range(3))
    M[:3, :3], K[3:5, 3:5], K[5:, 5:] = rig.matrices[0][:3, :3], spring * np.eye(2), spring * np.eye(2)
    if rig.right is not None:
        M[5:, 5:], C[5:, 5:], K[5:, 5:] = (matrix[3:, 3:] for matrix in rig.matrices)
    values = spring * np.asarray(motion.harmonics)
    moved = [
        Force(dof, {h: row[2 * h - 1] - 1j * row[2 * h] for h in range(1, (row.size + 1) // 2)}, float(row[0]), "platform motion")
        for dof, row in zip(LEFT, values, strict=True)
    ]
    pull = [Force(dof, static=float(f), name="pull") for dof, f in zip(DAMPER, rig.pull, strict=False) if f]
    body = rig.damper.body
    corners, place = np.reshape(body.outline, (-1, 3)), tuple(np.asarray(body.centre).tolist())
    outlines = {"damper": np.asarray(body.centre) + corners} if corners.size else {}
    structure = Structure(M, K, dofs, C=C, nodes={"damper": place}, outlines=outlines)
    return Problem(structure, rig.contacts, (*moved, *pull), ("damper.x", "damper.y"), rig.title)
