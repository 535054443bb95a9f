"""Harmonics of a balance: 0..H by the number H, or a list such as 0, 1, 3, 5.

Storage is always that of 0..H, H the highest, so that row h of an array is harmonic h whatever the list; motion and forces of a
harmonic that the list leaves out are zero, and no unknowns of Newton's method.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence, Set
from typing import Any

import numpy as np

from stickslip.model.contact.point import TractionRatio
from stickslip.model.problem import Problem
from stickslip.support.checks import Index, between, counted, fault, whole

Harmonics = int | tuple[int, ...]
"""H for 0..H, or an ascending list that holds 1 and is not all of 0..H."""

MOST_HARMONICS, MOST_SAMPLES = 1000, 1_000_000


def checked_harmonics(value: Any, remedy: str = "") -> Harmonics:
    """The argument `harmonics` of an analysis: a number H from 1 on, or whole numbers from 0 on, ascending, among them 1."""
    if isinstance(value, Set):
        raise fault("harmonics", "must be a whole number or a list in ascending order", value, "Write a list: [0, 1, 3].")
    if isinstance(value, str) or not isinstance(value, Iterable) or np.ndim(value) == 0:  # type: ignore[arg-type]
        return between("harmonics", whole("harmonics", value, remedy), 1, MOST_HARMONICS)
    listed = tuple(between(f"harmonics[{k}]", h, 0, MOST_HARMONICS) for k, h in enumerate(value))
    if list(listed) != sorted(set(listed)):
        raise fault("harmonics", "must be a list in ascending order, each harmonic once", list(listed))
    if 1 not in listed:
        raise fault("harmonics", "must hold 1, the harmonic of the frequency itself", list(listed), "Put 1 into the list.")
    return listed[-1] if listed == tuple(range(listed[-1] + 1)) else listed


def fineness(harmonics: Any, samples: Any) -> tuple[Harmonics, int]:
    """Harmonics and Nt, checked; that they suit each other, `fourier` says."""
    return checked_harmonics(harmonics), between("samples", samples, 1, MOST_SAMPLES)


def harmonics_for(problem: Problem, value: Any, remedy: str = "") -> Harmonics:
    """`checked_harmonics`, refused where the problem has loads in harmonics that the list leaves out."""
    harmonics = checked_harmonics(value, remedy)
    held = orders(harmonics)
    loaded = sorted({harmonic for force in problem.forces for harmonic in force.factors})
    for harmonic in loaded:
        if harmonic not in held:
            rule = f"must {'reach' if harmonic > held[-1] else 'hold'} the load's harmonic {harmonic}"
            raise fault("harmonics", rule, harmonics if isinstance(harmonics, int) else list(harmonics))
    if held[0] != 0:
        reason = _why_the_mean_matters(problem)
        if reason:
            raise fault("harmonics", f"must hold 0, the mean, since {reason}", list(held), "Put 0 into the list.")
    return harmonics


def _why_the_mean_matters(problem: Problem) -> str:
    """What of a problem has a mean in general; empty where all of it is odd and may vibrate about zero."""
    if np.any(problem.static_powers):
        return "there are static loads"
    for contact in problem.contacts:
        if contact.normal is not None:
            return f"the normal load of contact {contact.name} varies"
        if any(start.code == TractionRatio.code or np.any(np.asarray(start.value)) for start in contact.starts):
            return f"contact {contact.name} starts off the middle"
    return ""


def orders(harmonics: Harmonics) -> tuple[int, ...]:
    """The harmonics in ascending order."""
    return tuple(range(harmonics + 1)) if isinstance(harmonics, int) else harmonics


def highest(harmonics: Harmonics) -> int:
    """H, by which arrays are sized."""
    return harmonics if isinstance(harmonics, int) else harmonics[-1]


def in_fractions(harmonics: Harmonics, periods: int) -> Harmonics:
    """Harmonics of the excitation as those of a motion expanded over several of its periods, 0, 1/p, ..., H as 0, 1, ..., p H."""
    if periods == 1:
        return harmonics
    if not isinstance(harmonics, int):
        remedy = "Which fractions a list leaves out, it does not say."
        raise fault("harmonics", "must be a number H where motions last several periods", list(harmonics), remedy)
    return between("harmonics times periods", periods * harmonics, 1, MOST_HARMONICS)


def columns_of(held: tuple[int, ...]) -> Index:
    """Where these harmonics stand in real storage a0, a1, b1, ..., ascending."""
    return np.array([column for h in held for column in ((2 * h - 1, 2 * h) if h else (0,))], dtype=np.int64)


def in_words(harmonics: Harmonics) -> str:
    """ "5 harmonics", or "harmonics 0, 1, 3, 5"."""
    return counted(harmonics, "harmonic") if isinstance(harmonics, int) else f"harmonics {attribute(harmonics)}"


def attribute(harmonics: int | Sequence[int]) -> int | str:
    """What a results file keeps: H, or the list in words."""
    return harmonics if isinstance(harmonics, int) else ", ".join(map(str, harmonics))


def of_attribute(value: Any) -> Harmonics:
    """The harmonics of a results file."""
    return checked_harmonics([int(h) for h in value.split(",")] if isinstance(value, str) else value)
