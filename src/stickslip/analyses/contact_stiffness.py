"""Stiffness of a line contact against load, by several formulas; a source of `kn` without measurements."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.model.contact.stiffness import NORMAL_STIFFNESS, LineContact
from stickslip.results.result import Result
from stickslip.support.checks import of_kind, positive, vector
from stickslip.support.late import xr


@dataclass(frozen=True, eq=False, repr=False)
class ContactStiffness(Result):
    """`dataset`: normal_stiffness (formula, load), tangential_across, tangential_along (load) [N/m], half_width (load) [m]."""

    dataset: xr.Dataset
    contact: LineContact


def contact_stiffness(contact: LineContact, loads: ArrayLike, at: float | None = None) -> ContactStiffness:
    """Normal stiffness after Harris, Brändlein and Allara, initial tangential stiffness and half width, at normal loads [N].

    at: the load of interest, marked in the figure: N̄ = F_C/(2 cos α) of a damper (`static_normal_load`).
    """
    of_kind("contact", contact, LineContact)
    N = np.array([positive("load", load) for load in vector("loads", loads)])
    across, along = contact.tangential_stiffness(N)
    normal = np.array([formula(contact, N) for formula in NORMAL_STIFFNESS.values()])
    variables: dict[str, Any] = {
        "normal_stiffness": (("formula", "load"), normal, {"units": "N/m", "long_name": "normal contact stiffness"}),
        "tangential_across": ("load", across, {"units": "N/m", "long_name": "initial tangential stiffness across the line"}),
        "tangential_along": ("load", along, {"units": "N/m", "long_name": "initial tangential stiffness along the line"}),
        "half_width": ("load", contact.half_width(N), {"units": "m", "long_name": "half width of the contact"}),
    }
    coords: dict[str, Any] = {
        "formula": list(NORMAL_STIFFNESS),
        "load": ("load", N, {"units": "N", "long_name": "normal load"}),
    }
    attrs = {"length": contact.length, "radius": contact.radius, "load_of_interest": np.nan if at is None else positive("at", at)}
    return ContactStiffness(xr.Dataset(variables, coords, attrs), contact)
