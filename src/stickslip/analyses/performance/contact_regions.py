"""Contact states over a steady period as performance curves name them: stick, microslip, slip, lift-off."""

from __future__ import annotations

import numpy as np

from stickslip.model.contact.law import SLIDERS
from stickslip.model.contact.period import OPEN, STICK, friction_period
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance
from stickslip.solve.balance.cycle import ContactCycle, friction_limits
from stickslip.support.checks import Index

REGIONS = ("stick", "microslip", "slip", "lift-off")
STUCK, MICROSLIP, SLIP, LIFT_OFF = range(4)


def contact_regions(balance: HarmonicBalance, evaluation: Evaluation, cycle: ContactCycle) -> Index:
    """The region of each contact, (contacts,): it opens, or all, some or none of its closed elements slip.

    Elements count in the tangential direction in which the contact moves most. Index into `REGIONS`.
    """
    slips = _slipping_elements(balance, evaluation, cycle)
    travel = np.ptp(cycle.displacement, axis=1)
    found, row = [], 0
    for contact in balance.problem.contacts:
        tangential = range(row, row + len(contact.tangential))
        normal = row + len(contact.tangential) if contact.normal is not None else None
        row += len(contact.directions)
        if normal is not None and bool(np.any(cycle.state[normal] == OPEN)):
            found.append(LIFT_OFF)
        elif not tangential:
            found.append(STUCK)
        else:
            shares = slips[max(tangential, key=lambda r: travel[r])]
            found.append(STUCK if not any(shares) else SLIP if all(shares) else MICROSLIP)
    return np.array(found, dtype=np.int64)


def whole_region(regions: Index, friction: Index) -> int:
    """The region of all contacts together: lift-off of any; slip of all with friction; stick of all; else microslip."""
    rubbing = regions[friction]
    if np.any(regions == LIFT_OFF):
        return LIFT_OFF
    if rubbing.size == 0 or np.all(rubbing == STUCK):
        return STUCK
    return SLIP if np.all(rubbing == SLIP) else MICROSLIP


def _slipping_elements(balance: HarmonicBalance, evaluation: Evaluation, cycle: ContactCycle) -> dict[int, list[bool]]:
    """For each tangential row, whether each of its elements slips; elements open all the time are left out."""
    table, tables, w = evaluation.table, balance.tables, evaluation.w
    samples = tables.E.shape[0]
    y, event = np.empty(samples), np.empty(samples, dtype=np.int64)
    found: dict[int, list[bool]] = {row: [] for row in range(balance.rows)}
    for e, row, u, limit, landing in friction_limits(table, tables, w):
        if table.kind[np.searchsorted(table.first_row, row, side="right") - 1] != SLIDERS:
            found[row] = [bool(np.any((cycle.state[row] != STICK) & (cycle.state[row] != OPEN)))]
            continue
        kt, kind, value = table.stiffness[e], int(table.start_kind[e]), table.start_value[e]
        friction_period(kind, value, kt, kt * u, limit, landing, kt * w[row, 0], y, event)
        if not np.all(event == OPEN):
            found[row].append(bool(np.any((event != STICK) & (event != OPEN))))
    return found
