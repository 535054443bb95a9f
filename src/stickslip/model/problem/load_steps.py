"""What steps of the static load leave behind: sliders remember what has been before.

A turbine has run faster than now, a damper has been pulled harder, a root has been loaded and let go. At each load p of such a
history the contacts are in equilibrium,

    K q + Bᵀ f(B q) = p,   T = kt (w − s) within ±μN,

with sliders s where the load before has left them, from s = 0 before the first one; then they stand at s = w − T/kt. Between the
loads of two steps all static forces change together, in as many parts as the sliders need.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from stickslip.model.contact.point import Contact, SliderOffset, Start, contact_table
from stickslip.model.problem.at_rest import Rest, at_rest
from stickslip.model.problem.meshed import with_forces
from stickslip.model.problem.speed import refuse_speed
from stickslip.support.checks import Array, InputError, fault, finite, nearest, several

if TYPE_CHECKING:
    from stickslip.model.problem.problem import Problem

LoadStep = float | Mapping[str, float]
"""A factor of all static forces, or of those named, {name: factor}, the others being as they are."""

SETTLED = 1e-3
"""Share of the motion of contacts within which sliders are where smaller parts of a step leave them; and the shortest part."""


def after_load_steps(problem: Problem, steps: Sequence[LoadStep]) -> Problem:
    """The problem with its sliders where a history of the static load has left them; its own static load comes last.

    steps: the loads in turn, each a factor of all static forces or {name of a force: factor}. `[1.44]` is an earlier run at 1.2
    times the speed. Contacts without memory, or with a traction ratio or a mean traction as their start state, do not change.
    Raises `InputError` if a load has no state of rest, and for friction discs, whose directions slip together.
    """
    moved, _ = load_history(problem, steps)
    return moved


def load_history(problem: Problem, steps: Sequence[LoadStep]) -> tuple[Problem, list[Rest]]:
    """As `after_load_steps`, with the contacts at rest under the load of each step and under that of the problem."""
    refuse_speed(problem, "Load steps")
    steps = several("steps", steps)
    discs = [contact.name for contact in problem.contacts if contact.law.couples_directions]
    if discs:
        rule = "must have one direction for each slider, if there are load steps"
        raise fault(f"The friction of {discs[0]}", rule, "a friction disc", "Use `macroslip`.")
    static = [force for force in problem.forces if force.static]
    if not static:
        raise InputError("Load steps need a static load, but there is none: state a pull, a rotation or a force.")
    if not steps:
        raise fault("steps", "must contain a load", "none")
    if not any(_slides(contact, start) for contact in problem.contacts for start in contact.starts):
        raise InputError("Load steps need contacts whose friction starts from a slider offset, but there are none.")
    names = [force.name for force in problem.forces]
    now, moved, rests = np.zeros(len(names)), problem, list[Rest]()
    halvings = int(np.ceil(np.log2(1.0 / SETTLED)))
    for number, step in enumerate((*steps, 1.0), start=1):
        after = _factors(f"Step {number}", step, names, [force.name for force in static])
        way = _Way(problem, now, after, f"step {number}" if number <= len(steps) else "the problem, after all steps")
        moved, rest = way.along(moved, rests[-1] if rests else None, 0.0, 1.0, halvings)
        rests.append(rest)
        now = after
    carried = np.abs(contact_table(problem.contacts).stiffness * rests[-1].sliders).max(initial=0.0)
    if np.finfo(float).eps * carried > SETTLED * np.abs(rests[-1].forces).max():
        rule = "must not move sliders so far that rounding hides their friction"
        raise fault("steps", rule, f"sliders {np.abs(rests[-1].sliders).max():.1e} m away")
    return with_sliders(problem, rests[-1].sliders), rests


def _factors(what: str, step: LoadStep, names: Sequence[str], static: Sequence[str]) -> Array:
    """The factor of each force of a problem."""
    if not isinstance(step, Mapping):
        return np.full(len(names), finite(what, step))
    for name, factor in step.items():
        finite(f"{what}: {name}", factor)
        if not name or name not in static:
            raise fault(what, "must name static forces", name, nearest(name, [each for each in static if each]))
    return np.array([step.get(name, 1.0) for name in names])


AtRest = tuple["Problem", Rest]
"""A problem with its sliders where a load leaves them, and its contacts at rest under that."""


class _Way:
    """The way of a problem from one static load to another, by the factors of its forces at both."""

    def __init__(self, problem: Problem, before: Array, after: Array, where: str) -> None:
        self.forces, self.before, self.after, self.where = problem.forces, before, after, where
        table = contact_table(problem.contacts)
        self.row = np.repeat(np.arange(table.rows), np.diff(table.friction_first))

    def at(self, problem: Problem, share: float) -> AtRest:
        """The problem under the load at a share of the way, its sliders where that moves them, on the coordinates it needs."""
        factors = (1.0 - share) * self.before + share * self.after
        pairs = zip(self.forces, factors, strict=True)
        loaded = problem.with_forces([replace(force, static=float(factor * force.static)) for force, factor in pairs])
        rest = at_rest(loaded)
        while rest is not None and loaded.mesh is not None:
            more = with_forces(loaded, (rest.forces - loaded.contact_stiffness * rest.motion)[:, None])
            if more.structure.size == loaded.structure.size:
                break
            loaded, rest = more, at_rest(more)
        if rest is None:
            raise InputError(
                f"No state of rest was found under the static load of {self.where}. At each step, the load must press parts that "
                "only contacts restrain on these contacts."
            )
        return with_sliders(loaded, rest.sliders), rest

    def along(
        self,
        problem: Problem,
        begin: Rest | None,
        low: float,
        high: float,
        halvings: int,
        end: tuple[Problem, Rest] | None = None,
    ) -> tuple[Problem, Rest]:
        """The problem and its contacts at rest at the end of a part of the way; end: the same in one piece, where that is known.

        The part is halved where both halves leave a slider elsewhere than the whole, where one does not go straight through its
        middle, since friction then begins or ends to slip, and where one may have moved before its contact closed. Of the
        beginning, which may not hold all parts yet, nothing is known but what its halves say.
        """
        whole, middle = end or self.at(problem, high), 0.5 * (low + high)
        if halvings == 0:
            return whole
        half = self.at(problem, middle)
        finer = self.at(half[0], high)
        rest = finer[1]
        uncertain = [rest.sliders - whole[1].sliders]
        if begin is not None:
            closes = (begin.limits == 0.0) & (rest.limits > 0.0)
            uncertain += [half[1].sliders - 0.5 * (begin.sliders + rest.sliders), closes * (rest.motion - begin.motion)[self.row]]
        if np.abs(uncertain).max(initial=0.0) <= SETTLED * np.abs(rest.motion[self.row]).max(initial=0.0):
            return finer
        problem, rest = self.along(problem, begin, low, middle, halvings - 1, half)
        return self.along(problem, rest, middle, high, halvings - 1)


def with_sliders(problem: Problem, sliders: Array) -> Problem:
    """The problem with its sliders at these places, (friction elements,) m."""
    left = iter(sliders.tolist())

    def moved(contact: Contact) -> Contact:
        places = [[next(left) for _ in range(group.stiffness.size)] for group in contact.elements.friction]
        pairs = zip(contact.starts, places, strict=True)
        starts = tuple(SliderOffset(own) if _slides(contact, start) else start for start, own in pairs)
        return contact.with_start(starts) if starts else contact

    return problem.with_contacts(moved)


def _slides(contact: Contact, start: Start) -> bool:
    """Whether a direction of a contact begins from the place of a slider."""
    return contact.law.remembers_start and isinstance(start, SliderOffset)
