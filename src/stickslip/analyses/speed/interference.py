"""Interference diagram (SAFE, ZZENF) of a bladed disk: which modes the engine orders excite at one rotor speed, and how near."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.analyses.nodal_diameters import nodal_diameters
from stickslip.analyses.speed.models import Models, problem_at
from stickslip.model.disks.tuned import TunedDisk
from stickslip.results.result import Result
from stickslip.support.checks import between, fault, of_kind, positive, several, unique

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

WAVES = ("standing", "backward", "forward")
"""How the wave that a pattern at rest excites travels in the disk: neither way (0 and N/2), against the rotation, or with it."""


@dataclass(frozen=True, eq=False, repr=False)
class InterferenceDiagram(Result):
    """`dataset`: disk_frequency (state, nodal_diameter, mode) [Hz]; of each engine order excited_diameter, wave and
    excitation_frequency EO Ω [Hz]; mode of the nearest frequency at that diameter and its margin f/(EO Ω) − 1, both
    (state, engine_order)."""

    dataset: xr.Dataset

    def table(self) -> pd.DataFrame:
        """Nearest modes and margins, a row for each engine order and state."""
        names = ["excited_diameter", "wave", "excitation_frequency", "nearest_mode", "margin"]
        return self.dataset[names].to_dataframe().reset_index()


def interference_diagram(
    disk: TunedDisk | Models, speed: float, engine_orders: Sequence[int] | None = None, modes: int = 6
) -> InterferenceDiagram:
    """Natural frequencies over the nodal diameter, and where the engine orders meet them at a rotor speed.

    Of N sectors, engine order EO excites nodal diameter EO mod N, or N less that where it is above N/2, with frequency EO Ω. A
    mode is in resonance where the line of frequency over diameter, folded at 0 and N/2, passes through it. The pattern stands
    still in space; its wave travels backward in the disk, forward where the diameter is folded.
    disk: a tuned disk, or its models by speed as `campbell` takes them. speed: rev/min. engine_orders: 1 to N unless given.
    modes: of each nodal diameter; rigid motions of free dampers are left out. Coriolis terms are neglected.
    """
    positive("speed", speed)
    problem = disk if isinstance(disk, TunedDisk) else problem_at(disk)(speed)
    of_kind("disk", problem, TunedDisk)
    assert isinstance(problem, TunedDisk)
    given = range(1, problem.sectors + 1) if engine_orders is None else several("engine_orders", engine_orders)
    orders = np.array([between("engine_orders", order, 1) for order in given])
    unique("engine_orders", orders.tolist())
    if not orders.size:
        raise fault("engine_orders", "must hold at least one", "none")
    found, sectors = nodal_diameters(problem, modes).dataset, problem.sectors
    diameters = np.minimum(orders % sectors, -orders % sectors)
    excitation = orders * speed / 60.0
    # Where a diameter has fewer modes than others, NaN stands in their place.
    off = found["disk_frequency"].values[:, diameters] / excitation[:, None] - 1.0
    nearest = np.argmin(np.where(np.isfinite(off), np.abs(off), np.inf), axis=2)
    margins = np.take_along_axis(off, nearest[..., None], axis=2)[..., 0]
    own, both = "engine_order", ("state", "engine_order")
    folded = orders % sectors
    kinds = np.where(2 * folded < sectors, 1, 2)
    kinds[(folded == 0) | (2 * folded == sectors)] = 0
    data: dict[str, Any] = {
        "excited_diameter": (own, diameters, {"units": "1", "long_name": "nodal diameter that an engine order excites"}),
        "wave": (own, np.asarray(WAVES)[kinds], {"units": "1", "long_name": "how the excited wave travels"}),
        "excitation_frequency": (own, excitation, {"units": "Hz", "long_name": "frequency of the excitation"}),
        "nearest_mode": (both, nearest + 1, {"units": "1", "long_name": "mode of that nodal diameter nearest in frequency"}),
        "margin": (both, margins, {"units": "1", "long_name": "its frequency over that of the excitation, less 1"}),
    }
    return InterferenceDiagram(found.assign(data).assign_coords(engine_order=orders).assign_attrs(speed=float(speed)))
