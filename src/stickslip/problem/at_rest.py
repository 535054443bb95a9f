"""Normal loads of the contacts of a problem at rest, without vibration."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.checks import Array
from stickslip.contact.law import FrictionElements, NormalElements
from stickslip.contact.point import Contact
from stickslip.contact.start import MeanTraction, Start, TractionRatio
from stickslip.problem.problem import Problem

ROUNDS = 30
"""How often the contacts that slip under the static loads are looked for."""

Slips = list[list[Array]]
"""By contact and tangential direction: of each friction element 0 where it sticks at rest, else the sign of its force."""


def normal_loads_at_rest(problem: Problem) -> dict[str, float]:
    """Normal load of each contact with a normal direction, N, if all are closed: K q + Bᵀ f(B q) = p.

    f = S w + f₀ by the start states: T = kt (u − s) of slider offsets, ±μN where that is more, m μ N of traction ratios, T̄ of
    mean tractions; friction that forgets its start carries nothing at rest. Empty where such contacts do not hold the structure,
    or where the search for those that slip does not end.
    """
    _, _, stuck, B, _ = problem.systems.at(0)
    ends = np.cumsum([len(contact.directions) for contact in problem.contacts])
    places = [slice(int(end) - len(c.directions), int(end)) for c, end in zip(problem.contacts, ends, strict=True)]
    slips: Slips = [[np.zeros(group.stiffness.size) for group in contact.elements.friction] for contact in problem.contacts]
    w = np.zeros(B.shape[0])
    for _ in range(ROUNDS):
        S, constant = np.zeros((w.size, w.size)), np.zeros(w.size)
        for contact, rows, signs in zip(problem.contacts, places, slips, strict=True):
            S[rows, rows], constant[rows] = _linear(contact, signs)
        stiffness = stuck + B.conj().T @ ((S - np.diag(problem.contact_stiffness)) @ B)
        motion = _solved(stiffness, problem.static_load - B.conj().T @ constant)
        if motion is None:
            return {}
        w = (B @ motion).real
        found = [_slipping(contact, w[rows], signs) for contact, rows, signs in zip(problem.contacts, places, slips, strict=True)]
        if all(np.array_equal(a, b) for one, other in zip(found, slips, strict=True) for a, b in zip(one, other, strict=True)):
            break
        slips = found
    else:
        return {}
    normals = {
        contact.name: (contact.elements.normal, w[rows][-1]) for contact, rows in zip(problem.contacts, places, strict=True)
    }
    return {name: float(normal.forces(z).sum()) for name, (normal, z) in normals.items() if normal is not None}


def _solved(stiffness: NDArray[Any], load: NDArray[Any]) -> NDArray[Any] | None:
    """The motion under a load; None where the stiffness is singular to rounding."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", linalg.LinAlgWarning)
        try:
            return np.asarray(linalg.solve(stiffness, load))
        except (linalg.LinAlgError, linalg.LinAlgWarning):
            return None


def _linear(contact: Contact, slips: list[Array]) -> tuple[Array, Array]:
    """S and f₀ of a closed contact, by its directions."""
    size, normal = len(contact.directions), contact.elements.normal
    S, constant = np.zeros((size, size)), np.zeros(size)
    if normal is not None:
        S[-1, -1], constant[-1] = normal.stiffness.sum(), normal.constant.sum()
    for t, (start, group, signs) in enumerate(zip(contact.starts, contact.elements.friction, slips, strict=True)):
        if not contact.law.remembers_start:
            continue
        values = start.values(group.stiffness.size)
        if isinstance(start, MeanTraction):
            constant[t] += values.sum()
            continue
        ratios = values if isinstance(start, TractionRatio) else signs
        S[t, -1] += ratios @ (_limits(group, normal, 1.0) - _limits(group, normal, 0.0))
        constant[t] += ratios @ _limits(group, normal, 0.0)
        if not isinstance(start, TractionRatio):
            stuck = np.where(signs == 0.0, group.stiffness, 0.0)
            S[t, t] += stuck.sum()
            constant[t] -= stuck @ values
    return S, constant


def _limits(group: FrictionElements, normal: NormalElements | None, z: float) -> Array:
    """The limit of each friction element of a closed contact at normal displacement z, linear in z, N."""
    return group.limits(np.zeros(0) if normal is None else normal.stiffness * z + normal.constant)


def _slipping(contact: Contact, w: Array, slips: list[Array]) -> list[Array]:
    """The elements that slip at a displacement of the contact: their springs would carry more than the limit."""
    normal = contact.elements.normal
    return [
        _signs(start, group, w[t], _limits(group, normal, w[-1])) if contact.law.remembers_start else signs
        for t, (start, group, signs) in enumerate(zip(contact.starts, contact.elements.friction, slips, strict=True))
    ]


def _signs(start: Start, group: FrictionElements, u: float, limits: Array) -> Array:
    if isinstance(start, TractionRatio | MeanTraction):
        return np.zeros(limits.size)
    carried = group.stiffness * (u - start.values(limits.size))
    return np.where(np.abs(carried) > np.maximum(limits, 0.0), np.sign(carried), 0.0)
