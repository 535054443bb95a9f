"""Copies of a problem with scaled friction or preload, and the forces in F_C/F_E.

Search band for resonances, from the free to the stuck one, and the message if it holds none.
"""

from collections.abc import Mapping
from dataclasses import fields, replace
from typing import Any

import numpy as np

from stickslip.analyses.settings import Ends
from stickslip.model.contact.law import Law
from stickslip.model.contact.point import Contact
from stickslip.model.loads import BaseMotion
from stickslip.model.problem import Problem
from stickslip.model.problem.speed import CentrifugalLoad
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.linear_response import linear_peak
from stickslip.support.checks import InputError, fault, not_negative, positive
from stickslip.support.units import Band

PRELOADS = ("normal_load", "preload")
"""Fields of contact laws that hold a load in newtons."""


def with_friction(problem: Problem, mu: float) -> Problem:
    """A copy with one friction coefficient at every contact that rubs."""
    not_negative("friction", mu)
    if not any(_has(contact.law, "mu") for contact in problem.contacts):
        raise fault("friction", "must meet a contact law with a coefficient mu", "none has one")
    return problem.with_contacts(lambda contact: _changed(contact, mu=mu))


def with_preload_factor(problem: Problem, factor: float) -> Problem:
    """A copy with every static force and every preload of a contact law times a factor; gaps and stiffness stay."""
    positive("preload factor", factor)
    forces, speed = [replace(force, static=factor * force.static) for force in problem.forces], problem.speed
    if speed is not None:
        speed = replace(speed, loads=tuple(replace(load, static=factor * load.static) for load in speed.loads))

    def loaded(contact: Contact) -> Contact:
        values = {key: getattr(contact.law, key) for key in PRELOADS if _has(contact.law, key)}
        return _changed(contact, **{key: _times(factor, value) for key, value in values.items()})

    return replace(problem, forces=tuple(forces), speed=speed).with_contacts(loaded)


def with_factors(contact: Contact, factors: Mapping[str, float]) -> Contact:
    """A copy with fields of its law times factors; fields that the law does not have are passed over."""
    law = contact.law
    return _changed(contact, **{key: _times(factor, getattr(law, key)) for key, factor in factors.items() if _has(law, key)})


def centrifugal_pull(problem: Problem) -> float:
    """F_C, N: the largest static force, or without any the largest preload of a contact law."""
    static = [
        float(np.linalg.norm(force.resultant))
        if isinstance(force, CentrifugalLoad)
        else abs(force.static) * _length(force.coefficients)
        for force in problem.forces
    ]
    if max(static, default=0.0) > 0.0:
        return max(static)
    loads = [
        np.sum(getattr(contact.law, key) or 0.0) for contact in problem.contacts for key in PRELOADS if _has(contact.law, key)
    ]
    largest = float(max(loads, default=0.0))
    if largest <= 0.0:
        raise fault("The problem", "must have a static force or a preload, F_C", "neither", "Give `pull`.")
    return largest


def excitation(problem: Problem) -> float:
    """F_E at force level one, N: the largest amplitude of a harmonic force."""
    if any(isinstance(force, BaseMotion) or force.power for force in problem.forces if any(force.amplitudes.values())):
        remedy = "Follow the peak in another parameter, `follow_peaks`."
        raise fault("F_E", "must be a force of one amplitude", "a moving base, or goes by a power of the frequency", remedy)
    sizes = [abs(a) * _length(force.coefficients) for force in problem.forces for a in force.amplitudes.values()]
    return float(max(sizes))


def _has(law: Law, key: str) -> bool:
    return any(field.name == key for field in fields(law))  # type: ignore[arg-type]


def _changed(contact: Contact, **values: Any) -> Contact:
    known = {key: value for key, value in values.items() if _has(contact.law, key)}
    return contact.with_law(replace(contact.law, **known)) if known else contact  # type: ignore[type-var]


def _times(factor: float, value: Any) -> Any:
    if value is None:
        return None
    return factor * value if np.ndim(value) == 0 else tuple(factor * np.asarray(value, dtype=float))


def _length(direction: Mapping[str, float]) -> float:
    """The size of a force along a direction: of its resultant, or of one side of a force that balances itself."""
    nodes: dict[str, dict[str, float]] = {}
    whole: dict[str, float] = {}
    for dof, share in direction.items():
        node, _, axis = dof.rpartition(".")
        nodes.setdefault(node, {})[axis] = share
        whole[axis] = whole.get(axis, 0.0) + share
    sides = sum(float(np.linalg.norm(list(each.values()))) for each in nodes.values())
    return max(float(np.linalg.norm(list(whole.values()))), 0.5 * sides)


OUTSIDE = (0.9, 1.1)
"""How far the band reaches beyond the free and the stuck resonance."""


def resonance_band(balance: HarmonicBalance, output: int) -> Band:
    """A band that holds the free and the stuck resonance of an output."""
    peaks = [linear_peak(balance, output, stuck).frequency for stuck in (False, True)]
    return Band(OUTSIDE[0] * min(peaks), OUTSIDE[1] * max(peaks))


def no_resonance(balance: HarmonicBalance, output: int, band: Ends, where: str = "") -> InputError:
    """The fault of a band in Hz that holds no resonance of an output; where: " at 5 N", say."""
    free, stuck = (linear_peak(balance, output, stuck).frequency for stuck in (False, True))
    remedy = f"The highest resonance without contacts is at {free:.5g} Hz, that with contacts stuck at {stuck:.5g} Hz."
    return fault("The band of frequencies", f"must hold a resonance{where}", f"{band[0]:g} to {band[1]:g} Hz", remedy)
