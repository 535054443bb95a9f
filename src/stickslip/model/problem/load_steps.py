"""What steps of the static load leave behind: sliders remember what has been before.

A turbine has run faster than now, a damper has been pulled harder, a root has been loaded and let go. At each load p of such a
history the contacts are in equilibrium,

    K q + Bᵀ f(B q) = p,   T = kt (w − s) within ±μN,

with sliders s where the load before has left them, from s = 0 before the first one; then they stand at s = w − T/kt. Between the
loads of two steps all static forces, preloads and gaps change together, in as many parts as the sliders need. Preloads and gaps
of the first step are there from the beginning.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from stickslip.model.contact.point import Contact, OnSurface, SliderOffset, Start, contact_table
from stickslip.model.loads import Force
from stickslip.model.problem.at_rest import Rest, at_rest, rest_variables
from stickslip.model.problem.meshed import resting
from stickslip.model.problem.problem import Problem
from stickslip.model.problem.speed import refuse_speed
from stickslip.support.checks import Array, InputError, fault, finite, listed, nearest, several
from stickslip.support.machine import one_blas_thread


@dataclass(frozen=True)
class LoadStep:
    """A load before that of a problem: `factor` of all static forces, and what is another one at this step. static: {name of a
    force: N}; preload, normal_load [N], gap [m]: {name of a contact or of a contact surface: value}, as in its law, of a whole
    surface, a negative gap being an interference.
    """

    factor: float = 1.0
    static: Mapping[str, float] = field(default_factory=dict)
    preload: Mapping[str, float] = field(default_factory=dict)
    gap: Mapping[str, float] = field(default_factory=dict)
    normal_load: Mapping[str, float] = field(default_factory=dict)


OF_CONTACTS = ("preload", "gap", "normal_load")
"""What a step may change in contacts."""

SETTLED = 1e-3
"""Share of the motion of contacts within which sliders are where smaller parts of a step leave them; and the shortest part."""


def after_load_steps(problem: Problem, steps: Sequence[float | LoadStep]) -> Problem:
    """The problem with its sliders where a history of the static load has left them; its own static load comes last.

    steps: the loads in turn, each a `LoadStep` or the factor of one alone: `[1.44]` is an earlier run at 1.2 times the speed, and
    `[ss.LoadStep(0.0, preload={"shroud": 50.0})]` an assembly with another preload. Contacts without memory, or with a traction
    ratio or a mean traction as their start state, do not change. Raises `InputError` if a load has no state of rest, and for
    friction discs, whose directions slip together.
    """
    with one_blas_thread():
        moved, _ = load_history(problem, steps)
    return moved


def load_history(problem: Problem, steps: Sequence[float | LoadStep]) -> tuple[Problem, list[tuple[Problem, Rest]]]:
    """As `after_load_steps`, with the problem, without damping, and its contacts at rest under each load, its own last."""
    refuse_speed(problem, "Load steps")
    loads = [step if isinstance(step, LoadStep) else LoadStep(step) for step in several("steps", steps)]
    discs = [contact.name for contact in problem.contacts if contact.law.couples_directions]
    if discs:
        rule = "must have one direction for each slider, if there are load steps"
        raise fault(f"The friction of {discs[0]}", rule, "a friction disc", "Use `macroslip`.")
    if not (any(force.static for force in problem.forces) or any(replace(step, factor=1.0) != LoadStep() for step in loads)):
        raise InputError("Load steps need a static load, but there is none: state a pull, a rotation or a force.")
    if not loads:
        raise fault("steps", "must contain a load", "none")
    if not any(_slides(contact, start) for contact in problem.contacts for start in contact.starts):
        raise InputError("Load steps need contacts whose friction starts from a slider offset, but there are none.")
    ends = [_end(problem, step, f"Step {number}") for number, step in enumerate((*loads, LoadStep()), start=1)]
    own = {place: getattr(problem.contacts[place[0]].law, place[1]) for end in ends for place in end.numbers}
    ends = [end._replace(numbers=own | end.numbers) for end in ends]
    unloaded = ends[0]._replace(static=0.0 * ends[0].static)
    start: tuple[Problem, Rest | None] = problem.with_damping(None), None  # the matrix of a damping rule is dear
    with suppress(InputError):  # parts that only a load presses on their contacts have no state of rest before it
        start = _Way(problem, unloaded, unloaded, "").at(start[0], 0.0)
    halvings, found = int(np.ceil(np.log2(1.0 / SETTLED))), list[Any]()
    for number, (before, after) in enumerate(pairwise([unloaded, *ends]), start=1):
        way = _Way(problem, before, after, f"step {number}" if number <= len(loads) else "the problem, after all steps")
        found.append(way.along(found[-1] if found else start, 0.0, 1.0, halvings))
    _, rest = found[-1]
    carried = np.abs(contact_table(problem.contacts).stiffness * rest.sliders).max(initial=0.0)
    acting = np.abs(rest.forces).max() or np.abs(problem.static_load).max()
    if np.finfo(float).eps * carried > SETTLED * acting:
        rule = "must not move sliders so far that rounding hides their friction"
        raise fault("steps", rule, f"sliders {np.abs(rest.sliders).max():.1e} m away")
    return with_sliders(problem, rest.sliders), found


class _End(NamedTuple):
    """What acts at an end of a way: the static part of each force [N], and numbers of laws by the contact and their key."""

    static: Array
    numbers: dict[tuple[int, str], Any]


def _end(problem: Problem, step: LoadStep, what: str) -> _End:
    """What acts at a step of a problem, which is called `what`, as far as it is not that of the problem."""
    names, factor = [force.name for force in problem.forces], finite(f"{what}: factor", step.factor)
    for name, value in step.static.items():
        finite(f"{what}: static of {name}", value)
        if not name or names.count(name) != 1:
            raise fault(f"{what}: static", "must name single forces", name, nearest(name, [each for each in names if each]))
    static = [step.static.get(force.name, factor * force.static) for force in problem.forces]
    parts: dict[str, list[tuple[int, OnSurface]]] = {}
    for number, contact in enumerate(problem.contacts):
        for part in filter(None, (contact.surface, OnSurface(contact.name))):
            parts.setdefault(part.name, []).append((number, part))
    numbers: dict[tuple[int, str], Any] = {}
    for key, name, value in ((each, *item) for each in OF_CONTACTS for item in getattr(step, each).items()):
        finite(f"{what}: {key} of {name}", value)
        if name not in parts:
            raise fault(f"{what}: {key}", "must name contacts", name, nearest(name, parts))
        for number, part in parts[name]:
            law: Any = problem.contacts[number].law
            known = [each for each in (("preload", "gap") if law.has_normal else ("normal_load",)) if hasattr(law, each)]
            if key not in known:
                remedy = f"A step may state its {listed(known)}." if known else "Remove it."
                raise InputError(f"{what}: the {type(law).__name__} of {name} has no {key} here. {remedy}")
            size = np.size(getattr(law, "kt", 0.0))  # of an array its elements, which share a total
            numbers[number, key] = value + part.further if key == "gap" else np.full(size, part.share * value / size).squeeze()
    return _End(np.array(static), numbers)


class _Way:
    """The way of a problem from one static load to another, by what acts at both."""

    def __init__(self, problem: Problem, before: _End, after: _End, where: str) -> None:
        self.problem, self.before, self.after, self.where = problem, before, after, where
        table = contact_table(problem.contacts)
        self.row = np.repeat(np.arange(table.rows), np.diff(table.friction_first))
        self.contact = np.searchsorted(table.first_row, self.row, side="right") - 1

    def at(self, problem: Problem, share: float) -> tuple[Problem, Rest]:
        """The problem under the load at a share of the way, its sliders where that moves them, on the coordinates it needs."""
        static = (1.0 - share) * self.before.static + share * self.after.static
        forces = [replace(force, static=size) for force, size in zip(self.problem.forces, static.tolist(), strict=True)]
        contacts = list(problem.contacts)
        for (number, key), value in self.before.numbers.items():
            mixed = ((1.0 - share) * np.asarray(value) + share * np.asarray(self.after.numbers[number, key])).tolist()
            law: Any = contacts[number].law
            contacts[number] = contacts[number].with_law(replace(law, **{key: tuple(mixed) if np.ndim(mixed) else mixed}))
        for number in {place[0] for place in self.before.numbers}:
            now, own = contacts[number], self.problem.contacts[number]
            if now.balanced and now.normal is not None and now.elements.normal and own.elements.normal:
                more = own.elements.normal.forces(0.0).sum() - now.elements.normal.forces(0.0).sum()
                forces.append(Force(now.normal, static=float(more)))  # the counter-force stays that of the problem
        loaded, rest = resting(replace(problem, forces=tuple(forces), contacts=tuple(contacts)), at_rest)
        if rest is None:
            raise InputError(
                f"No state of rest was found under the static load of {self.where}. At each step, the load must press parts that "
                "only contacts restrain on these contacts. Very stiff contacts may hide one."
            )
        return with_sliders(loaded, rest.sliders), rest

    def along(
        self, start: tuple[Problem, Rest | None], low: float, high: float, halvings: int, end: tuple[Problem, Rest] | None = None
    ) -> tuple[Problem, Rest]:
        """The problem and its contacts at rest at the end of a part of the way; end: the same in one piece, where that is known.

        The part is halved where both halves leave a slider elsewhere than the whole, where one does not go straight through its
        middle, since friction then begins or ends to slip, and where one may have moved before its contact closed. Of a start
        without a state of rest, which may not hold all parts yet, nothing is known but what its halves say.
        """
        problem, begin = start
        whole, middle = end or self.at(problem, high), 0.5 * (low + high)
        if halvings == 0:
            return whole
        try:
            half = self.at(problem, middle)
        except InputError:
            if begin is not None:
                raise
            return whole  # what presses without a load has kept the parts apart so far
        finer = self.at(half[0], high)
        rest = finer[1]
        uncertain, moved = [rest.sliders - whole[1].sliders], np.abs(rest.motion[self.row]).max(initial=0.0)
        if begin is not None:
            apart = rest_variables(problem, begin)["rest_gap"][self.contact] > SETTLED * moved
            closes = apart & (begin.limits == 0.0) & (rest.limits > 0.0)
            uncertain += [half[1].sliders - 0.5 * (begin.sliders + rest.sliders), closes * (rest.motion - begin.motion)[self.row]]
        if np.abs(uncertain).max(initial=0.0) <= SETTLED * moved:
            return finer
        return self.along(self.along(start, low, middle, halvings - 1, half), middle, high, halvings - 1)


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
