"""A tuned disk after running in: its sliders start where slip has moved them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.response_settings import ForcedResponseSettings
from stickslip.model.contact.point import Contact
from stickslip.model.contact.start import SliderOffset
from stickslip.model.disks.tuned import TunedDisk
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.cycle import contact_cycle
from stickslip.solve.curves.curve import solve_curve
from stickslip.support.checks import Array, InputError, of_kind
from stickslip.support.units import Band


def run_in(
    disk: TunedDisk, band: Band | Sequence[float], force: float, harmonics: int | Sequence[int] = 5, samples: int = 256
) -> TunedDisk:
    """A copy whose contacts start from the mean slider positions s̄ = ū − T̄/kt at the highest point of the response to `force`.

    Whatever slips there has forgotten where it began. A contact that starts at s̄ and sticks carries the mean traction of one
    that slips; a virgin one (s = 0) carries another, which the first slip wears off in many small steps, each contact at a
    place of its own. band, force (one level), harmonics, samples: as of `forced_response`. Raises `InputError` where the
    response is not found.
    """
    of_kind("disk", disk, TunedDisk)
    work = ForcedResponseWork.of(ForcedResponseSettings(disk, band, force, harmonics, samples))
    return run_in_by(work, disk)


def run_in_by(work: ForcedResponseWork, disk: TunedDisk) -> TunedDisk:
    """As `run_in`, by the response of a work with one force level."""
    balance = HarmonicBalance(disk, work.harmonics, work.samples)
    omegas = [2.0 * np.pi * frequency for frequency in work.settings.frequencies]
    curve = solve_curve(balance, omegas, work.levels[0], work.settings.listed)
    if not curve.points:
        raise InputError(f"The tuned disk must have a response to be run in by, but none was found. {curve.message}")
    row = balance.rows
    highest = max((point.evaluation for point in curve.points), key=lambda found: float(np.hypot(*found.w[row, 1:3])))
    sliders = contact_cycle(balance.table, balance.tables, highest.w, highest.point.omega).mean_slider
    return replace(disk, contacts=tuple(_started(disk.contacts, sliders)))


def _started(contacts: Sequence[Contact], sliders: Array) -> Iterator[Contact]:
    """The contacts with slider offsets (elements,) of all their friction elements, one after the other."""
    first = 0
    for contact in contacts:
        starts = []
        for friction in contact.elements.friction:
            last = first + friction.stiffness.size
            starts.append(SliderOffset(tuple(sliders[first:last].tolist())))
            first = last
        yield contact.with_start(tuple(starts)) if starts else contact
