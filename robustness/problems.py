"""Seeded random problems for the robustness run: small structures, every law, built so that a steady solution exists.

Six classes: constant normal load; varying normal load without lift-off; with lift-off; start states away from zero; barely
pressed contacts, of 0.1 to 30 times the median stiffness of the structure, from virgin and from other start states.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.model.contact.cubic import Gap
from stickslip.model.contact.law import Law
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.microslip import MicroslipArray
from stickslip.model.contact.point import Contact, SliderOffset
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.structure.matrices import ModalDamping, Structure
from stickslip.support.units import Band

CLASSES = ("constant load", "varying load", "lift-off", "start state", "barely pressed", "barely pressed, start state")
BARELY = CLASSES[4:]


@dataclass(frozen=True, eq=False)
class Case:
    """A problem with its band and force level."""

    name: str
    problem: Problem
    band: Band
    level: float


def random_case(kind: str, seed: int) -> Case:
    """Case number `seed` of a class: 1 to 6 degrees of freedom, 1 to 4 contacts."""
    rng = np.random.default_rng([CLASSES.index(kind), seed])
    size = int(rng.integers(1 if kind == "constant load" else 2, 7))
    structure = _structure(rng, size)
    unit = float(np.median(np.diag(structure.K))) if kind in BARELY else 1.0
    contacts = tuple(_contact(rng, kind, size, k, unit) for k in range(int(rng.integers(1, 5))))
    forced = int(rng.integers(size))
    phase = np.exp(2j * np.pi * rng.random())
    forces = (Force(structure.dofs[forced], phase), *_preloads(rng, kind, structure.dofs))
    problem = Problem(structure, contacts, forces, (structure.dofs[int(rng.integers(size))],), f"{kind} {seed}")
    frequencies = problem.frequencies(stuck=True)
    band = Band(0.4 * float(problem.frequencies(stuck=False)[0] + 0.2 * frequencies[0]), 1.3 * float(frequencies[-1]))
    return Case(f"{kind} {seed}", problem, band, float(10.0 ** rng.uniform(-1.3, 1.0)))


def _structure(rng: np.random.Generator, size: int) -> Structure:
    """A chain with random springs, some to ground, and modal damping between 0.3 and 5 %."""
    springs = rng.uniform(0.3, 3.0, size + 1) * np.array([1.0] * size + [rng.integers(2)])
    K = np.diag(springs[:-1] + springs[1:]) - np.diag(springs[1:-1], 1) - np.diag(springs[1:-1], -1)
    M = np.diag(rng.uniform(0.5, 2.0, size))
    ratio = float(10.0 ** rng.uniform(-2.5, -1.3))
    dofs = tuple(f"{i + 1}.x" for i in range(size))
    return Structure(M, K, dofs, damping=ModalDamping(ratio, on=("free", "stuck")[int(rng.integers(2))]))


def _direction(rng: np.random.Generator, size: int) -> dict[str, float]:
    """One degree of freedom against ground, against another one, or an inclined combination."""
    chosen = rng.permutation(size)[: min(size, 3)] + 1
    match int(rng.integers(3)) if size > 1 else 0:
        case 0:
            return {f"{chosen[0]}.x": 1.0}
        case 1:
            return {f"{chosen[0]}.x": 1.0, f"{chosen[1]}.x": -1.0}
        case _:
            return {f"{i}.x": float(c) for i, c in zip(chosen, rng.normal(size=chosen.size), strict=True)}


def _contact(rng: np.random.Generator, kind: str, size: int, number: int, unit: float) -> Contact:
    law = _barely_pressed(rng, unit) if kind in BARELY else _law(rng, kind)
    tangential: Sequence[dict[str, float]] = () if isinstance(law, Gap) else (_direction(rng, size),)
    start = SliderOffset(float(rng.normal(scale=2.0))) if kind.endswith("start state") else SliderOffset()
    return Contact(f"contact {number + 1}", law, tuple(tangential), _direction(rng, size) if law.has_normal else None, start)


def _law(rng: np.random.Generator, kind: str) -> Law:
    kt, mu = float(rng.uniform(0.1, 3.0)), float(rng.uniform(0.1, 0.8))
    if kind == "constant load" or (kind == "start state" and rng.integers(2)):
        if rng.integers(3) == 0:
            share = rng.dirichlet(np.ones(4))
            return MicroslipArray(tuple(kt * share), mu, normal_load=tuple(rng.uniform(0.05, 1.0, 4)))
        return Macroslip(kt=kt, mu=mu, normal_load=float(rng.uniform(0.2, 3.0)))
    kn = float(rng.uniform(0.1, 3.0))
    preload = float(rng.uniform(10.0, 30.0) if kind == "varying load" else rng.uniform(0.0, 2.0))
    match int(rng.integers(4)):
        case 0:
            array = MicroslipArray.from_totals(kt, kn, mu, largest_gap=float(rng.uniform(0.0, 1.0)))
            return MicroslipArray(array.kt, mu, array.kn, array.gaps, preload / 5.0)
        case 1 if kind == "lift-off":
            return Gap(kn, gap=float(rng.normal()))
        case _:
            return Macroslip(kt=kt, mu=mu, kn=kn, preload=preload)


def _barely_pressed(rng: np.random.Generator, unit: float) -> Law:
    """Contacts on the edge of lift-off: with no preload at all, or little; as soft or stiff as `unit` times 0.1 to 30."""
    kt, kn = (float(value) for value in unit * 10.0 ** rng.uniform(-1.0, np.log10(30.0), 2))
    mu, preload = float(rng.uniform(0.1, 0.8)), float(rng.choice([0.0, 10.0 ** rng.uniform(-3.0, -0.5)]))
    match int(rng.integers(4)):
        case 0:
            array = MicroslipArray.from_totals(kt, kn, mu, largest_gap=float(rng.uniform(0.0, 1.0)))
            return MicroslipArray(array.kt, mu, array.kn, array.gaps, preload / 5.0)
        case 1:
            return Gap(kn, gap=float(0.1 * rng.normal()))
        case _:
            return Macroslip(kt=kt, mu=mu, kn=kn, preload=preload)


def _preloads(rng: np.random.Generator, kind: str, dofs: tuple[str, ...]) -> tuple[Force, ...]:
    """A static load that presses or pulls, in the classes with a varying normal load."""
    if kind == "constant load":
        return ()
    return (Force(dofs[int(rng.integers(len(dofs)))], static=float(rng.normal())),)
