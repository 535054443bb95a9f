"""Exactness of the elimination of stuck contacts, and the sizes it leaves."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stickslip.model.rigs import single_blade
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.newton import correct, fixed
from verify.row import CLOSED, Row, absolute, at_most

TITLE = "Only what slips is unknown"
ABOUT = (
    "The Newton system of the single blade (4.6 kg, 5 harmonics) at resonance: its size against 2H+1 per direction "
    "that slips or opens, found by marching every element in plain Python; its step and solution against the system "
    "of all 528 unknowns; the contact forces against marching."
)


def rows() -> Iterator[Row]:
    from balance.full_balance import full_newton_step, marched_forces, unknowns_by_theory

    rig = single_blade(4.6)
    balance = HarmonicBalance(rig, 5, 256)
    for level, frequency in ((1.0, 551.6), (20.0, 543.0), (80.0, 528.0), (100.0, 518.0)):
        omega = 2.0 * np.pi * frequency
        condition = fixed("omega", omega)
        solved = correct(balance, balance.stuck_point(omega, level), condition, iterations=60, halvings=12).evaluation
        w = solved.w[: balance.rows]
        name = f"{level:g} N, {frequency:g} Hz: "
        size = balance.factorise(solved, condition).size
        yield absolute(
            f"{name}unknowns (of {balance.rows * 11})", size, unknowns_by_theory(rig, w, 256), 0.0, "states by marching"
        )
        disturbed = balance.evaluate(solved.point.moved(1e-3 * solved.point.forces, "omega", 0.0))
        step, _ = balance.newton_step(disturbed, condition, balance.factorise(disturbed, condition))
        full = full_newton_step(balance, disturbed)
        yield at_most(f"{name}Newton step against the full system", np.abs(step - full).max() / np.abs(full).max(), 1e-10, CLOSED)
        point = disturbed.point
        for _ in range(12):
            point = point.moved(full_newton_step(balance, balance.evaluate(point)), "omega", 0.0)
        carried = balance.carried_forces(solved)
        scale = np.abs(carried).max()
        gap = np.abs(balance.carried_forces(balance.evaluate(point)) - carried).max() / scale
        yield at_most(f"{name}solution against the full system", gap, 1e-10, CLOSED)
        gap = np.abs(marched_forces(rig, w, 256) - carried).max() / scale
        yield at_most(f"{name}contact forces against marching", gap, 1e-8, "plain marching")
