"""The steady loop of any contact law under prescribed motion and normal load, without a structure.

Stiffness of a line contact against load, by several formulas; a source of `kn` without measurements.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stickslip.model.contact.law import Law
from stickslip.model.contact.point import Contact, SliderOffset, Start, contact_table
from stickslip.model.contact.stiffness import NORMAL_STIFFNESS, LineContact
from stickslip.results.schema import Result, tabulated
from stickslip.solve.balance.energy import forces_of_motion
from stickslip.support.checks import Array, fault, numbers, of_kind, positive, vector
from stickslip.support.late import xr

FEWEST_SAMPLES = 8


@dataclass(frozen=True, eq=False)
class HysteresisLoop:
    """One period of a contact: displacement [m] and friction force [N], (n,) or (2, n), and normal load [N], (n,)."""

    displacement: Array
    force: Array
    normal: Array

    @property
    def energy(self) -> float:
        """Energy dissipated in the period, ∮ T·du by the polygon through the samples [J]."""
        u, force = np.atleast_2d(self.displacement), np.atleast_2d(self.force)
        return float(0.5 * np.sum(force * (np.roll(u, -1, axis=1) - np.roll(u, 1, axis=1))))


def hysteresis_loop(
    law: Law,
    displacement: ArrayLike,
    normal_load: ArrayLike | None = None,
    *,
    normal_displacement: ArrayLike | None = None,
    frequency: float = 1.0,
    start: Start | None = None,
) -> HysteresisLoop:
    """The steady friction force of a contact law under one period of motion.

    displacement: u(t) at equal times of one period [m], (n,), or (2, n) for both tangential directions. normal_load: N(t) [N],
    a number or (n,), of a law with a varying normal load: the normal displacement z is found for which N(z) is it. Or
    normal_displacement: z(t) itself [m], (n,). A law with a constant normal load takes neither. frequency: of the period [Hz],
    which matters to laws with velocity alone (`TanhCoulomb`). start: the start state, where the steady force depends on it.

    The force is that of the harmonic balance at the same samples, without any truncation: sliders march exactly from sample to
    sample, T_n = clamp(T_(n−1) + kt (u_n − u_(n−1)), ±μN_n), until the period repeats.
    Raises `InputError` for other shapes, for fewer than 8 samples and for a load where the law has its own.

    >>> import numpy as np
    >>> u = 2.0 * np.sin(2.0 * np.pi * np.arange(400) / 400.0)
    >>> loop = hysteresis_loop(Macroslip(kt=1.0, mu=0.5, normal_load=2.0), u)
    >>> round(loop.energy, 2)  # 4 μN (X − μN/kt)
    4.0
    """
    if not isinstance(law, Law):
        raise fault("law", "must be a Law", law)
    given = numbers("displacement", displacement)
    u = np.atleast_2d(given)
    if u.ndim != 2 or len(u) > 2 or u.shape[1] < FEWEST_SAMPLES or not np.all(np.isfinite(u)):
        rule = f"must be finite and of shape (n,) or (2, n), n from {FEWEST_SAMPLES} on"
        raise fault("displacement", rule, given.shape)
    directions = ({"contact.t1": 1.0}, {"contact.t2": 1.0})[: len(u)]
    normal = {"contact.n": 1.0} if law.has_normal else None
    contact = Contact("contact", law, directions, normal, SliderOffset() if start is None else start)
    rows = u if normal is None else np.vstack([u, _normal_motion(contact, normal_load, normal_displacement, u.shape[1])])
    if normal is None and (normal_load is not None or normal_displacement is not None):
        remedy = "Leave normal_load away, or give the law kn in place of its normal_load."
        raise fault("normal_load", "must stay away where the law has a constant one", type(law).__name__, remedy)
    force = forces_of_motion(contact_table((contact,)), rows, 2.0 * np.pi * positive("frequency", frequency))
    load = force[-1] if normal is not None else np.full(u.shape[1], float(np.sum(getattr(law, "normal_load", np.nan))))
    friction = force[: len(u)]
    return HysteresisLoop(given, friction[0] if given.ndim == 1 else friction, load)


def _normal_motion(contact: Contact, load: ArrayLike | None, motion: ArrayLike | None, samples: int) -> Array:
    """z (n,) [m] of a law with a varying normal load."""
    if (load is None) == (motion is None):
        raise fault(
            "normal_load and normal_displacement",
            "must be given one without the other for a law with a varying normal load",
            "both" if load is not None else "none",
        )
    name = "normal_load" if motion is None else "normal_displacement"
    given = load if motion is None else motion
    assert given is not None
    values = numbers(name, given)
    if values.shape not in ((), (samples,)) or not np.all(np.isfinite(values)):
        raise fault(name, f"must be finite, a number or of shape ({samples},)", values.shape)
    series = np.broadcast_to(values, (samples,))
    if motion is not None:
        return np.asarray(series)
    if np.any(series < 0.0):
        raise fault("normal_load", "must not be negative", float(series.min()))
    elements = contact.elements.normal
    assert elements is not None
    # Σ max(k z + c, 0) = N(z) is piecewise linear and rises, so it is inverted between its corners.
    corners = np.sort(-elements.constant / elements.stiffness)
    there = np.array([float(np.sum(elements.forces(z))) for z in corners])
    beyond = corners[-1] + max(float(series.max()) - there[-1], 0.0) / float(np.sum(elements.stiffness))
    found: Array = np.interp(series, np.append(there, max(float(series.max()), there[-1])), np.append(corners, beyond))
    return found


@dataclass(frozen=True, eq=False, repr=False)
class ContactStiffness(Result):
    """`dataset`: normal_stiffness (formula, load), tangential_across, tangential_along (load) [N/m], half_width (load) [m]."""

    dataset: "xr.Dataset"
    contact: LineContact


def contact_stiffness(contact: LineContact, loads: ArrayLike, at: float | None = None) -> ContactStiffness:
    """Normal stiffness after Harris, Brändlein and Allara, initial tangential stiffness and half width, at normal loads [N].

    at: the load of interest, marked in the figure: N̄ = F_C/(2 cos α) of a damper (`static_normal_load`).
    """
    of_kind("contact", contact, LineContact)
    N = np.array([positive("load", load) for load in vector("loads", loads)])
    across, along = contact.tangential_stiffness(N)
    normal = np.array([formula(contact, N) for formula in NORMAL_STIFFNESS.values()])
    widths = contact.half_width(N)
    found = {"normal_stiffness": normal, "tangential_across": across, "tangential_along": along, "half_width": widths}
    coords = {"formula": list(NORMAL_STIFFNESS), "load": N}
    attrs = {"length": contact.length, "radius": contact.radius, "load_of_interest": np.nan if at is None else positive("at", at)}
    return ContactStiffness(tabulated("contact_stiffness", found, coords, attrs), contact)
