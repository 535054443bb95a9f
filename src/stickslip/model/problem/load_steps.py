"""What steps of the static load leave behind: sliders remember what has been before.

A turbine has run faster than now, a damper has been pulled harder, a root has been loaded and let go. At each load p of such a
history the contacts are in equilibrium,

    K q + Bᵀ f(B q) = p,   T = kt (w − s) within ±μN,

with sliders s where the load before has left them, from s = 0 before the first one; then they stand at s = w − T/kt. Between the
loads of two steps all static forces, preloads and gaps change together, in as many parts as the sliders need. Preloads and gaps
of the first step are there from the beginning.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from stickslip.model.contact.point import Contact, OnSurface, SliderOffset, Start, contact_table
from stickslip.model.loads import Force
from stickslip.model.problem.at_rest import Rest, at_rest
from stickslip.model.problem.meshed import resting
from stickslip.model.problem.speed import refuse_speed
from stickslip.support.checks import Array, InputError, fault, finite, listed, nearest, several
from stickslip.support.machine import one_blas_thread

if TYPE_CHECKING:
    from stickslip.model.problem.problem import Problem


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


AtRest = tuple["Problem", Rest]
"""A problem with its sliders where a load leaves them, and its contacts at rest under that."""


def load_history(problem: Problem, steps: Sequence[float | LoadStep]) -> tuple[Problem, list[AtRest]]:
    """As `after_load_steps`, with the problem and its contacts at rest under the load of each step and under its own."""
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
    ends = [_End.of(problem, step, f"Step {number}") for number, step in enumerate(loads, start=1)]
    ends.append(_End.of(problem, LoadStep(), "The problem"))
    unloaded = ends[0]._replace(static=np.zeros(len(problem.forces)))
    moved, begin, found = problem.with_damping(None), None, list[AtRest]()  # the matrix of a damping rule is dear
    with suppress(InputError):  # parts that only a load presses on their contacts have no state of rest before it
        start = _Way(problem, unloaded, unloaded, "").at(moved, 0.0)
        if np.any(start[1].forces):  # what presses without a load may let sliders slip already
            moved, begin = start
    halvings = int(np.ceil(np.log2(1.0 / SETTLED)))
    for number, (before, after) in enumerate(pairwise([unloaded, *ends]), start=1):
        way = _Way(problem, before, after, f"step {number}" if number <= len(loads) else "the problem, after all steps")
        moved, begin = way.along(moved, begin, 0.0, 1.0, halvings)
        found.append((moved, begin))
    _, rest = found[-1]
    carried = np.abs(contact_table(problem.contacts).stiffness * rest.sliders).max(initial=0.0)
    if np.finfo(float).eps * carried > SETTLED * np.abs(rest.forces).max():
        rule = "must not move sliders so far that rounding hides their friction"
        raise fault("steps", rule, f"sliders {np.abs(rest.sliders).max():.1e} m away")
    return with_sliders(problem, rest.sliders), found


class _End(NamedTuple):
    """What acts at an end of a way: the static part of each force [N], and the law of each contact."""

    static: Array
    laws: list[Any]

    @classmethod
    def of(cls, problem: Problem, step: LoadStep, what: str) -> _End:
        """What acts at a step of a problem, which is called `what`."""
        names = [force.name for force in problem.forces]
        for name, value in step.static.items():
            finite(f"{what}: static of {name}", value)
            if not name or names.count(name) != 1:
                raise fault(f"{what}: static", "must name single forces", name, nearest(name, [each for each in names if each]))
        factor = finite(f"{what}: factor", step.factor)
        static = [step.static.get(each.name, factor * each.static) for each in problem.forces]
        return cls(np.array(static), _laws(problem.contacts, step, what))

    def towards(self, other: _End, share: float) -> _End:
        """What acts at a share of the way to another end."""
        laws = [_between(one, two, share) for one, two in zip(self.laws, other.laws, strict=True)]
        return _End((1.0 - share) * self.static + share * other.static, laws)


def _laws(contacts: Sequence[Contact], step: LoadStep, what: str) -> list[Any]:
    """The law of each contact at a step."""
    laws: list[Any] = [contact.law for contact in contacts]
    parts: dict[str, list[tuple[int, OnSurface]]] = {}
    for number, contact in enumerate(contacts):
        if contact.surface is not None:
            parts.setdefault(contact.surface.name, []).append((number, contact.surface))
    parts |= {contact.name: [(number, OnSurface(contact.name))] for number, contact in enumerate(contacts)}
    for key, name, value in ((each, *item) for each in OF_CONTACTS for item in getattr(step, each).items()):
        finite(f"{what}: {key} of {name}", value)
        if name not in parts:
            raise fault(f"{what}: {key}", "must name contacts", name, nearest(name, parts))
        for number, part in parts[name]:
            law = laws[number]
            own = [each for each in OF_CONTACTS if _given(law, each) is not None]
            if key not in own:
                remedy = f"A step may state its {listed(own)}." if own else "Remove it."
                raise fault(f"{what}: {key} of {name}", "must be a number of its law", type(law).__name__, remedy)
            size = np.size(getattr(law, "kt", 0.0))
            new = value + part.further if key == "gap" else part.share * value / size
            laws[number] = replace(law, **{key: new if size == 1 else (new,) * size})
    return laws


def _given(law: Any, key: str) -> Any:
    """What a law says of the normal load, with or without a spring; None where it does not."""
    return getattr(law, key, None) if law.has_normal == (key != "normal_load") else None


def _between(one: Any, other: Any, share: float) -> Any:
    """A law at a share of the way to another one, which differs in the normal load alone."""
    if one is other:
        return one
    ends = {key: (_given(one, key), _given(other, key)) for key in OF_CONTACTS}
    mixed = {k: (1.0 - share) * np.asarray(a) + share * np.asarray(b) for k, (a, b) in ends.items() if a is not None}
    return replace(one, **{key: tuple(value.tolist()) if value.ndim else float(value) for key, value in mixed.items()})


class _Way:
    """The way of a problem from one static load to another, by what acts at both."""

    def __init__(self, problem: Problem, before: _End, after: _End, where: str) -> None:
        self.problem, self.before, self.after, self.where = problem, before, after, where
        table = contact_table(problem.contacts)
        self.row = np.repeat(np.arange(table.rows), np.diff(table.friction_first))

    def at(self, problem: Problem, share: float) -> AtRest:
        """The problem under the load at a share of the way, its sliders where that moves them, on the coordinates it needs."""
        static, laws = self.before.towards(self.after, share)
        forces = [replace(force, static=size) for force, size in zip(self.problem.forces, static.tolist(), strict=True)]
        contacts = [contact.with_law(law) for contact, law in zip(problem.contacts, laws, strict=True)]
        for contact, own in zip(contacts, self.problem.contacts, strict=True):
            if contact.balanced and contact.normal is not None and contact.law is not own.law:  # whose counter-force stays
                normals = [each.elements.normal for each in (own, contact)]
                then, now = (0.0 if each is None else float(each.forces(0.0).sum()) for each in normals)
                forces.append(Force(contact.normal, static=then - now))
        loaded, rest = resting(replace(problem, forces=tuple(forces), contacts=tuple(contacts)), at_rest)
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
        end: AtRest | None = None,
    ) -> AtRest:
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
