"""Normal loads of the contacts of a problem at rest, without vibration."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.contact.law import NormalElements
from stickslip.model.contact.point import Contact, MeanTraction, TractionRatio
from stickslip.support.checks import Array

if TYPE_CHECKING:
    from stickslip.model.problem.problem import Problem

ROUNDS = 60
"""How often the contacts that slip or are open under the static loads are looked for."""

SHORTEST = 1e-3
"""Least share of a step towards the equilibrium of the contacts' present states."""


class State(NamedTuple):
    """Of a contact at rest: by tangential direction, of each friction element 0 where it sticks, else the sign of its force; and
    which bends of its limit lie below it; which normal elements are closed.
    """

    slips: list[Array]
    passed: list[NDArray[np.bool_]]
    closed: NDArray[np.bool_]

    def same(self, other: State) -> bool:
        pairs = zip((*self.slips, *self.passed, self.closed), (*other.slips, *other.passed, other.closed), strict=True)
        return all(np.array_equal(one, two) for one, two in pairs)


def normal_loads_at_rest(problem: Problem) -> dict[str, float]:
    """Normal load of each contact with a normal direction, N, at K q + Bᵀ f(B q) = p; 0 of those that are open.

    f = S w + f₀ by the start states: T = kt (u − s) of slider offsets, ±μN where that is more, m μ N of traction ratios, T̄ of
    mean tractions; friction that forgets its start carries nothing at rest. Newton's method: the equilibrium of the states at a
    motion, of which a share is gone that reduces what is left over. Empty where such contacts do not hold the structure, or where
    the search does not end.
    """
    rest = _AtRest(problem)
    stuck = []
    for contact in problem.contacts:
        slips = [np.zeros(group.stiffness.size) for group in contact.elements.friction]
        normal = contact.elements.normal
        passed = [np.zeros(group.bend.shape, dtype=bool) for group in contact.elements.friction]
        stuck.append(State(slips, passed, np.ones(0 if normal is None else normal.stiffness.size, dtype=bool)))
    motion = rest.equilibrium(stuck)
    for _ in range(ROUNDS):
        if motion is None:
            return {}
        states = rest.states(motion)
        target = rest.equilibrium(states)
        if target is None or all(one.same(other) for one, other in zip(states, rest.states(target), strict=True)):
            motion = target
            break
        # On the way contacts may change their states, for which the step is too long: it must bring a tenth of what it promises.
        share, left = 1.0, rest.left_over(motion)
        while share > SHORTEST and rest.left_over(motion + share * (target - motion)) >= (1.0 - 0.1 * share) * left:
            share *= 0.5
        motion = motion + share * (target - motion)
    else:
        return {}
    if motion is None:
        return {}
    return {
        contact.name: float(normal.forces(w[-1]).sum())
        for contact, w in zip(problem.contacts, rest.moved(motion), strict=True)
        if (normal := contact.elements.normal) is not None
    }


class _AtRest:
    """The equilibrium of a problem under its static loads, contacts in given states."""

    def __init__(self, problem: Problem) -> None:
        system = problem.systems.at(0)
        self.contacts, self.load = problem.contacts, problem.static_load
        self.B, self.K = system.B, system.without_contacts(problem.contact_stiffness)
        ends = np.cumsum([len(contact.directions) for contact in self.contacts])
        self.rows = [slice(int(end) - len(c.directions), int(end)) for c, end in zip(self.contacts, ends, strict=True)]

    def moved(self, motion: NDArray[Any]) -> list[Array]:
        """The motion of each contact by its directions, m."""
        w = (self.B @ motion).real
        return [w[rows] for rows in self.rows]

    def states(self, motion: NDArray[Any]) -> list[State]:
        return [_state(contact, w) for contact, w in zip(self.contacts, self.moved(motion), strict=True)]

    def equilibrium(self, states: list[State]) -> NDArray[Any] | None:
        """The motion (n,) at which contacts of these states carry the loads; None where they do not hold the structure."""
        pressed, constant = np.zeros_like(self.B), np.zeros(self.B.shape[0])
        for contact, rows, state in zip(self.contacts, self.rows, states, strict=True):
            S, constant[rows] = _linear(contact, state)
            pressed[rows] = S @ self.B[rows]
        return _solved(self.K + self.B.conj().T @ pressed, self.load - self.B.conj().T @ constant)

    def left_over(self, motion: NDArray[Any]) -> float:
        """‖K q + Bᵀ f(B q) − p‖, N."""
        forces = np.zeros(self.B.shape[0])
        for contact, rows, w in zip(self.contacts, self.rows, self.moved(motion), strict=True):
            S, constant = _linear(contact, _state(contact, w))
            forces[rows] = S @ w + constant
        return float(np.linalg.norm(self.K @ motion + self.B.conj().T @ forces - self.load))


def _solved(stiffness: NDArray[Any], load: NDArray[Any]) -> NDArray[Any] | None:
    """The motion under a load; None where the stiffness is singular to rounding."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", linalg.LinAlgWarning)
        try:
            return np.asarray(linalg.solve(stiffness, load))
        except (linalg.LinAlgError, linalg.LinAlgWarning):
            return None


def _linear(contact: Contact, state: State) -> tuple[Array, Array]:
    """S and f₀ of a contact, by its directions."""
    size, normal = len(contact.directions), contact.elements.normal
    S, constant = np.zeros((size, size)), np.zeros(size)
    if normal is not None:
        S[-1, -1], constant[-1] = normal.stiffness[state.closed].sum(), normal.constant[state.closed].sum()
    for t, (start, group, signs) in enumerate(zip(contact.starts, contact.elements.friction, state.slips, strict=True)):
        if not contact.law.remembers_start:
            continue
        values = start.values(group.stiffness.size)
        if isinstance(start, MeanTraction):
            constant[t] += values.sum()
            continue
        ratios = values if isinstance(start, TractionRatio) else signs
        at_zero, at_one = (group.limits(_loads(normal, z, state.closed), state.passed[t]) for z in (0.0, 1.0))
        S[t, -1] += ratios @ (at_one - at_zero)
        constant[t] += ratios @ at_zero
        if not isinstance(start, TractionRatio):
            stuck = np.where(signs == 0.0, group.stiffness, 0.0)
            S[t, t] += stuck.sum()
            constant[t] -= stuck @ values
    return S, constant


def _loads(normal: NormalElements | None, z: float, closed: NDArray[np.bool_]) -> Array:
    """The force of each normal element at normal displacement z, linear in z, N."""
    return np.zeros(0) if normal is None else np.where(closed, normal.stiffness * z + normal.constant, 0.0)


def _state(contact: Contact, w: Array) -> State:
    """At a displacement of the contact, friction elements slip whose springs would carry more than the limit; normal ones that
    would pull are open.
    """
    normal = contact.elements.normal
    closed = np.zeros(0, dtype=bool) if normal is None else normal.forces(w[-1]) > 0.0
    slips, loads = [], _loads(normal, w[-1], closed)
    for t, (start, group) in enumerate(zip(contact.starts, contact.elements.friction, strict=True)):
        signs = np.zeros(group.stiffness.size)
        if contact.law.remembers_start and not isinstance(start, TractionRatio | MeanTraction):
            limits = np.maximum(group.limits(loads), 0.0)
            carried = group.stiffness * (w[t] - start.values(signs.size))
            signs = np.where(np.abs(carried) > limits, np.sign(carried), 0.0)
        slips.append(signs)
    return State(slips, [group.passed(loads) for group in contact.elements.friction], closed)
