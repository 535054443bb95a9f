"""Contacts of a problem at rest, without vibration: their normal loads, and whether they can carry the static load at all.

Bodies that nothing but contacts holds are at rest where their load p and the forces of the contacts add up to nothing in every
motion φ that no stiffness resists, φᵀ Σ B_cᵀ f_c = φᵀ p, with normal forces N_e ≥ 0 and friction |T| ≤ Σ (μ Σ N_e + L0) in each
direction: one linear program in the N_e and T of all contacts, whatever their stiffness. Without a solution of it there is no
state of rest, and no steady vibration either. Of a limit that bends with the load stand the lines that bound it.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray
from scipy import linalg, sparse
from scipy.sparse.csgraph import connected_components

from stickslip.model.contact.point import Contact, OnSurface, SliderOffset, contact_table, remembering
from stickslip.model.contact.protocol import MEAN, OFFSET, RATIO
from stickslip.support.checks import Array

if TYPE_CHECKING:
    from stickslip.model.problem.problem import Mesh, Problem
    from stickslip.model.problem.systems import LinearSystem


ROUNDS = 60
"""How often the contacts that slip or are open under the static loads are looked for."""

SHORTEST = 1e-3
"""Least share of a step towards the equilibrium of the contacts' present states."""

SEATING, SEATED = 1e-6, 1e-9
"""Share of kt that seats contacts, of which sliders follow, and the share of the contact forces at which it carries nothing more:
places do not depend on the first."""


class State(NamedTuple):
    """Of contacts at rest: of each friction element 0 where it sticks, else the sign of its force; which bends of the limits lie
    below them; which normal elements are closed.
    """

    slips: Array
    passed: NDArray[np.bool_]
    closed: NDArray[np.bool_]

    def same(self, other: State) -> bool:
        return all(np.array_equal(one, two) for one, two in zip(self, other, strict=True))


class Rest(NamedTuple):
    """Contacts at rest: their motion w and forces f by their rows, (rows,), m and N, their state; and of each friction element
    where its slider then stands, s = w − T/kt, m, and the most that it carries there, N, (elements,)."""

    motion: Array
    forces: Array
    state: State
    sliders: Array
    limits: Array


def at_rest(problem: Problem) -> Rest | None:
    """The contacts at K q + Bᵀ f(B q) = p, sliders there before the static load p, which drags them.

    f = S w + f₀ by the start states: T = kt (u − s) of slider offsets, ±μN where that is more, m μ N of traction ratios, T̄ of
    mean tractions; friction that forgets its start carries nothing at rest. Newton's method: the equilibrium of the states at a
    motion, of which a share is gone that reduces what is left over. Where contacts of these states do not hold the structure, it
    goes on as stuck ones would. None where these do not hold it either, or where the search does not end.
    """
    rest = _AtRest(problem)
    motion = rest.found()
    return None if motion is None else rest.rest(motion)


def seated(problem: Problem) -> Rest | None:
    """The contacts where the static load seats them without friction: K q + Bᵀ f(B q) = p with T = 0 where sliders begin.

    What friction alone restrains stays as near to where it was as it can, Σ kt u² least: the limit of ever less friction. Springs
    of a small share of kt seat the contacts, again and again from where they are, until they carry nothing. Contacts with a start
    state of their own, other than a slider at rest, keep it. None where nothing but friction balances the load.
    """
    rest, before = _AtRest(problem, seating=True), np.inf
    while (motion := rest.found()) is not None:
        found = rest.rest(motion)
        carried = float(np.linalg.norm(found.forces[rest.free]))
        if carried <= SEATED * float(np.linalg.norm(found.forces)):
            return found._replace(forces=np.where(rest.free, 0.0, found.forces))
        if carried > 0.5 * before:
            return None
        rest.sliders, before = found.motion, carried
    return None


def normal_loads_at_rest(problem: Problem) -> dict[str, float]:
    """Normal load of each contact with a normal direction `at_rest`, N; 0 of those that are open. Empty where there is none."""
    rest = at_rest(problem)
    if rest is None:
        return {}
    rows = zip(problem.contacts, _rows(problem.contacts), strict=True)
    return {contact.name: float(rest.forces[own][-1]) for contact, own in rows if contact.normal is not None}


def open_stiffness(problem: Problem, rest: Rest) -> Array:
    """The share of K_c that is open at rest, N/m, (rows,): of normal elements, and of friction elements that these alone load.
    What touches without load is not."""
    elements = _Elements(problem.contacts)
    table, pressed = elements.table, elements.pressed(rest.motion)
    constant = table.normal_constant
    closed = pressed >= -LOOSE * (np.abs(pressed - constant) + np.abs(constant))
    return elements.by_row(table.stiffness * ~elements.loaded(closed), table.normal_stiffness * ~closed)


def rest_variables(problem: Problem, rest: Rest) -> dict[str, Any]:
    """The contacts of a problem at rest, one by one: the variables of the table `contacts_at_rest` by name."""
    contacts, elements = problem.contacts, _Elements(problem.contacts)
    table, count, parts = (
        elements.table,
        len(problem.contacts),
        [each.surface or OnSurface(each.name) for each in problem.contacts],
    )
    of_row, normal = np.repeat(np.arange(count), np.diff(table.first_row)), table.normal_row
    tangential, varies = np.ones(table.rows, dtype=bool), normal >= 0
    tangential[normal[varies]] = False
    constant = [np.nan if (load := getattr(contact.law, "normal_load", None)) is None else np.sum(load) for contact in contacts]
    load = np.where(varies, rest.forces[normal], constant)
    slid, apart = np.zeros(table.rows), np.where(varies, np.inf, 0.0)
    np.maximum.at(slid, elements.row, np.abs(rest.sliders) * elements.slides)
    of_normal = np.repeat(np.arange(count), np.diff(table.normal_first))
    np.minimum.at(apart, of_normal, -elements.pressed(rest.motion) / table.normal_stiffness)
    at_limit = elements.by_row((rest.state.slips != 0.0) & elements.loaded(rest.state.closed), 0.0)
    friction, slip, slips = (np.bincount(of_row, each, count) for each in ((rest.forces * tangential) ** 2, slid**2, at_limit))
    return {
        "rest_load": load,
        "rest_friction": np.sqrt(friction),
        "rest_gap": np.maximum(apart, 0.0),
        "rest_slip": np.sqrt(slip),
        "rest_state": np.where(slips > 0.0, 2, np.where(varies & (load == 0.0), 0, 1)),
        "contact_surface": np.array([part.name for part in parts]),
        "contact_node_place": np.concatenate([part.places for part in parts]),
        "contact_of_node": np.repeat(np.arange(count), [len(part.places) for part in parts]),
    }


def _rows(contacts: Sequence[Contact]) -> list[slice]:
    """The rows of each contact."""
    ends = np.cumsum([len(contact.directions) for contact in contacts])
    return [slice(int(end) - len(c.directions), int(end)) for c, end in zip(contacts, ends, strict=True)]


def begins(contact: Contact) -> list[bool]:
    """Of each direction of a contact, whether sliders begin there, at rest: the history of its static load then matters."""
    sliding = contact.law.rubs and contact.law.remembers_start
    virgin = [isinstance(start, SliderOffset) and not np.any(start.value) for start in contact.starts]
    return [*(sliding and each for each in virgin), *[False] * (contact.normal is not None)]


class _Elements:
    """The springs and sliders of contacts, side by side."""

    def __init__(self, contacts: Sequence[Contact]) -> None:
        self.table = table = contact_table(contacts)
        self.row = np.repeat(np.arange(table.rows), np.diff(table.friction_first))
        self.normal_row = np.repeat(table.normal_row, np.diff(table.normal_first))
        self.of_bend = np.repeat(np.arange(self.row.size), np.diff(table.bend_first))
        ends = np.cumsum(table.load_last - table.load_first)
        loads = np.repeat(table.load_last - ends, table.load_last - table.load_first) + np.arange(ends[-1] if ends.size else 0)
        sizes = self.row.size, self.normal_row.size
        self.loads: Any = sparse.csr_array((np.ones(loads.size), loads, np.append(0, ends)), shape=sizes)
        """Which normal elements load a friction element."""
        remembers = remembering(contacts)
        self.slides, self.ratio, self.mean = (remembers & (table.start_kind == kind) for kind in (OFFSET, RATIO, MEAN))

    def pressed(self, w: Array) -> Array:
        """The force of each normal element at a motion w (rows,) if it could pull, N."""
        return np.asarray(self.table.normal_stiffness * w[self.normal_row] + self.table.normal_constant)

    def loaded(self, closed: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """The friction elements that have a limit at all: a normal element closed that loads them, or one of their own."""
        return np.asarray((self.loads @ closed > 0.0) | (self.table.constant_limit > 0.0))

    def line(self, loads: Array) -> Array:
        """μ Σ N + L0 of each friction element for forces of the normal ones, N."""
        return np.asarray(self.table.friction * (self.loads @ loads) + self.table.constant_limit)

    def over_bends(self, values: Array) -> Array:
        """Sums over the bends of each friction element."""
        return np.asarray(np.bincount(self.of_bend, values, self.row.size), dtype=float)

    def by_row(self, friction: ArrayLike, normal: ArrayLike) -> Array:
        """Sums over the elements of each row."""
        own, springs = (np.broadcast_to(each, row.shape) for each, row in ((friction, self.row), (normal, self.normal_row)))
        sums = np.bincount(self.row, own, self.table.rows) + np.bincount(self.normal_row, springs, self.table.rows)
        return np.asarray(sums, dtype=float)

    def state(self, w: Array) -> State:
        """At a motion of the contacts, friction elements slip whose springs would carry more than the limit; normal ones that
        would pull are open."""
        pressed = self.pressed(w)
        limits, passed = self.limits(pressed)
        carried = self.carried(w)
        slips = np.where(self.slides & (np.abs(carried) > limits), np.sign(carried), 0.0)
        return State(slips, passed, pressed > 0.0)

    def limits(self, pressed: Array) -> tuple[Array, NDArray[np.bool_]]:
        """The most that each friction element carries, N, and which bends lie below it."""
        line = self.line(np.maximum(pressed, 0.0))
        beyond = np.maximum(line[self.of_bend] - self.table.bend, 0.0)
        return np.maximum(line + self.over_bends(self.table.change * beyond), 0.0), beyond > 0.0

    def carried(self, w: Array) -> Array:
        """The force of the spring of each friction element at a motion w (rows,) if its slider stays, N."""
        return np.asarray(self.table.stiffness * (w[self.row] - self.table.start_value))

    def sliders(self, w: Array, limits: Array) -> Array:
        """Where the slider of each friction element stands at a motion w (rows,), m; the start of one without memory."""
        carried = self.carried(w)
        beyond = carried - np.clip(carried, -limits, limits)
        stiffness = np.where(self.slides, self.table.stiffness, np.inf)
        return np.asarray(self.table.start_value + beyond / stiffness)

    def linear(self, state: State) -> tuple[Array, Array, Array]:
        """The forces of contacts in a state, f = s w + s' z + f₀ with z of the own contact: s, s', f₀ (rows,)."""
        table, closed = self.table, state.closed
        line, change = self.line(table.normal_constant * closed), np.where(state.passed, table.change, 0.0)
        limits = line + self.over_bends(change * (line[self.of_bend] - table.bend))
        steep = table.friction * (self.loads @ (table.normal_stiffness * closed)) * (1.0 + self.over_bends(change))
        ratios = np.where(self.ratio, table.start_value, state.slips)
        stuck = np.where(self.slides & (state.slips == 0.0), table.stiffness, 0.0)
        given = ratios * limits - stuck * table.start_value + np.where(self.mean, table.start_value, 0.0)
        own = self.by_row(stuck, table.normal_stiffness * closed)
        return own, self.by_row(ratios * steep, 0.0), self.by_row(given, table.normal_constant * closed)


class _AtRest:
    """The equilibrium of a problem under its static loads, contacts in given states.

    seating: with springs `seat` [N/m] along the directions that are `free` of friction, (rows,), off `sliders` [m].
    """

    def __init__(self, problem: Problem, seating: bool = False) -> None:
        system = problem.systems.at(0)
        self.elements, self.load = _Elements(problem.contacts), problem.static_load
        self.B, self.K = system.B, system.without_contacts(problem.contact_stiffness)
        self.free = np.array([seating and each for contact in problem.contacts for each in begins(contact)], dtype=bool)
        self.seat, self.sliders = SEATING * problem.contact_stiffness, np.zeros(self.free.size)

    def found(self) -> NDArray[Any] | None:
        """The motion (n,) at rest, from stuck contacts, else from open ones, to which the way of very stiff ones is too steep."""
        table = self.elements.table
        no_slips, no_bends = np.zeros(table.stiffness.size), np.zeros(table.bend.size, dtype=bool)
        closed = np.ones(table.normal_stiffness.size, dtype=bool)
        stuck, opened = (State(no_slips, no_bends, each) for each in (closed, ~closed))
        motion = self._from(stuck, stuck)
        return self._from(opened, stuck) if motion is None and closed.size else motion

    def _from(self, first: State, stuck: State) -> NDArray[Any] | None:
        """The same from the equilibrium of a first state of the contacts."""
        motion = self.equilibrium(first)
        for _ in range(ROUNDS):
            if motion is None:
                return None
            state = self.state(motion)
            target = self.equilibrium(state)
            if target is None:
                motion = self.beyond(motion, stuck)
                continue
            if state.same(self.state(target)) or self.balanced(target):
                return target
            # On the way contacts may change their states, for which the step is too long: it must bring a tenth of its promise.
            share, left = 1.0, self.left_over(motion)
            while share > SHORTEST and self.left_over(motion + share * (target - motion)) >= (1.0 - 0.1 * share) * left:
                share *= 0.5
            motion = motion + share * (target - motion)
        return None

    def rest(self, motion: NDArray[Any]) -> Rest:
        """The contacts at a motion (n,)."""
        w, state = (self.B @ motion).real, self.state(motion)
        own, by_normal, constant = self.linear(state)
        forces = own * w + by_normal * w[self.elements.table.loading_row] + constant
        limits, _ = self.elements.limits(self.elements.pressed(w))
        return Rest(w, forces, state, self.elements.sliders(w, limits), limits)

    def state(self, motion: NDArray[Any]) -> State:
        return self.elements.state((self.B @ motion).real)

    def linear(self, state: State) -> tuple[Array, Array, Array]:
        """s, s' and f₀ of contacts in a state, (rows,)."""
        own, by_normal, constant = self.elements.linear(state)
        own, by_normal = np.where(self.free, self.seat, own), np.where(self.free, 0.0, by_normal)
        return own, by_normal, np.where(self.free, -self.seat * self.sliders, constant)

    def equilibrium(self, state: State) -> NDArray[Any] | None:
        """The motion (n,) at which contacts in a state carry the loads; None where they do not hold the structure."""
        own, by_normal, constant = self.linear(state)
        return _solved(self.stiffness(own, by_normal), self.load - self.B.conj().T @ constant)

    def beyond(self, motion: NDArray[Any], stuck: State) -> NDArray[Any] | None:
        """A motion nearer to equilibrium than one at which the states of contacts do not hold the structure.

        On the step of stuck contacts what is unbalanced works against it, ever less, and after a change of states with it: the
        length is that from which on it does, between two powers of two. None where it never does.
        """
        step = _solved(self.stiffness(*self.linear(stuck)[:2]), -self.unbalanced(motion))
        for _ in range(ROUNDS):
            if step is None or np.vdot(step, self.unbalanced(motion + step)).real >= 0.0:
                return None if step is None else motion + step
            step = 2.0 * step
        return None

    def stiffness(self, own: Array, by_normal: Array) -> NDArray[Any]:
        """K + Bᵀ S B (n, n), of s and s' of the contacts."""
        pressed = own[:, None] * self.B + by_normal[:, None] * self.B[self.elements.table.loading_row]
        return np.asarray(self.K + self.B.conj().T @ pressed)

    def unbalanced(self, motion: NDArray[Any]) -> NDArray[Any]:
        """K q + Bᵀ f(B q) − p (n,), N."""
        return np.asarray(self.K @ motion + self.B.conj().T @ self.rest(motion).forces - self.load)

    def left_over(self, motion: NDArray[Any]) -> float:
        """Its norm, N."""
        return float(np.linalg.norm(self.unbalanced(motion)))

    def balanced(self, motion: NDArray[Any]) -> bool:
        """Whether nothing but rounding is left over, n ε of what cancels in it: an element at its limit may count as stuck or
        slipping. Springs with sliders far away carry little, as the difference of much."""
        own, by_normal, constant = self.linear(self.state(motion))
        way, across = np.abs(motion), np.abs(self.B)
        w = across @ way
        forces = np.abs(own) * w + np.abs(by_normal) * w[self.elements.table.loading_row] + np.abs(constant)
        terms = np.abs(self.K) @ way, across.T @ forces, self.load
        scale = self.load.size * np.finfo(float).eps * sum(float(np.linalg.norm(each)) for each in terms)
        return bool(self.left_over(motion) <= scale)


def _solved(stiffness: NDArray[Any], load: NDArray[Any]) -> NDArray[Any] | None:
    """The motion under a load; None where the stiffness is singular to rounding."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", linalg.LinAlgWarning)
        try:
            return np.asarray(linalg.solve(stiffness, load))
        except (linalg.LinAlgError, linalg.LinAlgWarning):
            return None


LOOSE = 1e-12
"""Stiffness of a body in a motion over that with stuck contacts, below which it is rounding and contacts alone hold the body."""

LARGEST = 300
"""Degrees of freedom of a body from which on it is taken for a held finite-element model."""

MISSING = 1e-4
"""Share of the load that contacts must leave over to be said not to carry it."""


class _Forces(NamedTuple):
    """The forces x of a contact, of which `rows` of B say how they act: `within` x ≤ `limits`, each x from `least` on."""

    rows: Array
    within: Array
    limits: Array
    least: list[float | None]


class _Loose(NamedTuple):
    """A body and the motions (n, k) of the structure that no stiffness resists, each moving the contacts by 1 at most."""

    name: str
    motions: Array
    dofs: frozenset[str]


def unbearable_loads(problem: Problem, sign: float = 1.0) -> list[str]:
    """The names of loose bodies whose static load times `sign` contacts cannot carry; all of them where they cannot together."""
    system = problem.systems.at(0)
    if np.any(np.imag(system.B)):
        return []
    bodies, rows = _loose_bodies(problem, system), _rows(problem.contacts)
    forces = [_forces(contact, system.B.real[own]) for contact, own in zip(problem.contacts, rows, strict=True)]
    load = sign * problem.static_load.real
    unbearable = [body.name for body in bodies if not _carried(forces, [body], load)]
    if unbearable or len(bodies) < 2 or _carried(forces, bodies, load):
        return unbearable
    return [" and ".join(body.name for body in bodies)]


def dampers(problem: Problem) -> dict[str, frozenset[str]]:
    """The bodies of one node that nothing but contacts holds and a static load presses on them, by name, with their degrees of
    freedom; none where directions of contacts are complex."""
    system, load = problem.systems.at(0), problem.static_load.real
    if np.any(np.imag(system.B)):
        return {}
    pulled = [body for body in _loose_bodies(problem, system) if np.any(load @ body.motions)]
    return {body.name: body.dofs for body in pulled if len({dof.rpartition(".")[0] for dof in body.dofs}) == 1}


def _loose_bodies(problem: Problem, system: LinearSystem) -> list[_Loose]:
    """The bodies, degrees of freedom that stiffness or a node joins, with motions that move contacts and meet no stiffness."""
    if problem.mesh is not None:
        return _bodies_of_mesh(problem.mesh, problem, system.B.real)
    held, size = system.without_contacts(problem.contact_stiffness).real, np.sqrt(np.diag(system.K.real))
    size[size == 0.0] = 1.0
    held = np.where(np.abs(held) > LOOSE * np.outer(size, size), held, 0.0)
    nodes = np.array([dof.rpartition(".")[0] for dof in problem.structure.dofs])
    _, bodies = connected_components(sparse.csr_array((held != 0.0) | (nodes[:, None] == nodes)), directed=False)
    loose = []
    for body in np.flatnonzero(np.bincount(bodies) < LARGEST):
        dofs = np.flatnonzero(bodies == body)
        stiffness, shapes = linalg.eigh(held[np.ix_(dofs, dofs)] / np.outer(size[dofs], size[dofs]))
        motions = np.zeros((len(held), int(np.sum(stiffness < LOOSE))))
        motions[dofs] = shapes[:, stiffness < LOOSE] / size[dofs, None]
        moved = np.abs(system.B.real @ motions).max(axis=0, initial=0.0)
        touching = moved > 0.0
        if np.any(touching):
            name = str(nodes[dofs[0]])
            moving = np.any(motions[:, touching] != 0.0, axis=1)
            names = frozenset(problem.structure.dofs[row] for row in np.flatnonzero(moving))
            loose.append(_Loose(name.rpartition("/")[0] or name, motions[:, touching] / moved[touching], names))
    return loose


def _bodies_of_mesh(mesh: Mesh, problem: Problem, B: Array) -> list[_Loose]:
    """The same of bodies of a mesh, whose rigid motions the coordinates hold."""
    loose = []
    for name, rows, rigid in mesh.stuck.bodies:
        motions = mesh.coordinates.shapes.T @ (mesh.stuck.stuck @ rigid)
        moved = np.abs(B @ motions).max(axis=0, initial=0.0)
        touching = moved > LOOSE * moved.max(initial=0.0)
        if np.any(touching):
            dofs = frozenset(mesh.stuck.structure.dofs[row] for row in rows)
            loose.append(_Loose(name, motions[:, touching] / moved[touching], dofs))
    return loose


def _forces(contact: Contact, rows: Array) -> _Forces:
    """N_e and one T a tangential direction of a contact with these rows of B; springs without friction may have any force."""
    normal = contact.elements.normal
    elements = 0 if normal is None else normal.stiffness.size
    acts = np.concatenate([np.repeat(rows[-1:], elements, axis=0), rows[: len(contact.tangential)]])
    within, limits = np.zeros((0, len(acts))), []
    for t, group in enumerate(contact.elements.friction if contact.law.rubs else ()):
        direction = np.eye(len(acts))[elements + t]
        for slope, beside in group.bounds():
            constant = (slope * group.line(np.zeros(elements)) + beside).sum()
            line = np.zeros(len(acts))
            line[:elements] = [constant - (slope * group.line(unit) + beside).sum() for unit in np.eye(elements)]
            within = np.vstack([within, line + direction, line - direction])
            limits += [constant, constant]
    return _Forces(acts, within, np.array(limits), [0.0] * elements + [None] * len(contact.tangential))


def _carried(forces: list[_Forces], bodies: list[_Loose], load: Array) -> bool:
    """Whether contacts leave over no more than a small share of the load of bodies."""
    motions = np.hstack([body.motions for body in bodies])
    wanted, whole = motions.T @ load, np.abs(motions).T @ np.abs(load)
    size = whole.max(initial=0.0)
    if size <= LOOSE * np.abs(motions).max() * np.abs(load).max():  # rounding of a load across the motions
        return True
    forces = [force for force in forces if np.any(force.rows @ motions)]
    limits, over = np.concatenate([force.limits for force in forces]), np.eye(wanted.size)
    unknowns = np.cumsum([0, *(len(force.rows) for force in forces)])
    rows = np.cumsum([0, *(len(force.limits) for force in forces)])
    places = np.vstack([np.argwhere(f.within) + np.array([a, b]) for f, a, b in zip(forces, rows, unknowns, strict=False)])
    entries = np.concatenate([force.within[force.within != 0.0] for force in forces])
    shape = limits.size, unknowns[-1] + 2 * wanted.size
    within: Any = sparse.csr_array((entries, places.T), shape=shape)
    program = scipy.optimize.linprog(
        np.concatenate([np.zeros(unknowns[-1]), np.ones(2 * wanted.size)]),
        A_ub=within,
        b_ub=limits / size,
        A_eq=np.hstack([np.vstack([force.rows for force in forces]).dot(motions).T, over, -over]),
        b_eq=wanted / size,
        bounds=[*((least, None) for force in forces for least in force.least), *[(0.0, None)] * (2 * wanted.size)],
    )
    return (program.fun or 0.0) <= MISSING
