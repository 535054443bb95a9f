"""Warnings about a problem that can be computed, but is hardly what was meant, or may defeat Newton's method.

Each function returns a sentence, empty where there is nothing to warn of.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stickslip.model.contact.law import LoadDependentFriction, largest_friction
from stickslip.model.contact.point import Contact, Direction, SliderOffset
from stickslip.model.problem.at_rest import normal_loads_at_rest
from stickslip.model.structure.matrices import ModalDamping
from stickslip.model.structure.modes import Modes, natural_modes
from stickslip.support.checks import Array, first_of, is_definite

if TYPE_CHECKING:
    from stickslip.model.problem import Problem

STIFFEST, STIFFEST_VARYING = 1e4, 1e2
"""Times what a contact of constant, of varying normal load joins, from where on random problems are lost (docs/choose.md)."""

LARGEST_FRICTION = 2.0
"""μ from where on random problems that lift off are lost (docs/choose.md); no measured one is as large."""

LARGEST_RATIO = 0.1
"""A damping ratio beyond it is more likely a percentage, or damping of other units: bladed structures have 1e-4 to 1e-2."""

SOFTEST_NORMAL, STIFFEST_NORMAL = 1.0 / 1.2, 1e3
"""kn over kt of a contact: of elastic bodies (2 − ν)/(2 − 2ν), 1 to 1.5 (R. D. Mindlin, J. Appl. Mech. 16, 1949, 259-268), of
thin layers and strips up to a hundred. Measured ones scatter: a fifth below 1 is let pass."""

LEFT = 0.5
"""Share of a preload that is left at rest, below which what contacts join is softer than they are."""

LEAST_RATIO = 1e-9
"""A damping ratio below which rounding may decide its sign."""

ROUNDING = 1e-9
"""Share of C below which a negative eigenvalue is rounding."""

ROUNDED = 0.01
"""How far cosines may be off that were typed with two digits."""

LEAST_SIZE, MOST_SIZE = 2e-3, 3.0
"""Of a body, relative to the model: from a pin of half a millimetre under a blade of 0.25 m to three times all blades."""


AXES, ROTATIONS = ("x", "y", "z"), ("rx", "ry", "rz")


def warnings_of(problem: Problem) -> tuple[str, ...]:
    """All warnings about a problem."""
    sentences = (
        _stiffness(problem),
        _friction(problem),
        _friction_over_load(problem),
        _normal_stiffness(problem),
        _preloads(problem),
        _starts(problem),
        _damping(problem),
        negative_damping(problem),
        _damped_gaps(problem),
        _sizes(problem),
        *_directions(problem),
    )
    return tuple(filter(None, sentences))


def _stiffness(problem: Problem) -> str:
    """Contacts too stiff to slip or lift off without trouble; of a mesh the flexibility under each one is not computed."""
    if problem.mesh is not None:
        return ""
    owners = [contact for contact in problem.contacts for _ in contact.directions]
    limits = np.array([STIFFEST if contact.normal is None else STIFFEST_VARYING for contact in owners])
    stiff = np.flatnonzero(np.isfinite(problem.stiffness_ratios) & (problem.stiffness_ratios > limits))
    if not stiff.size:
        return ""
    largest, lowest = f"{problem.stiffness_ratios[stiff].max():.2g}", f"{limits[stiff].min():g}"
    return (
        f"Very stiff contacts ({_named([owners[row].name for row in stiff])}): up to {largest} times what they join. Where "
        f"they slip or lift off, the curve may stop. Lower kt and kn to {lowest} times that stiffness: a stuck "
        f"contact is then rigid to within one part in {lowest}."
    )


def _friction(problem: Problem) -> str:
    """Contacts with a friction coefficient that no measurement has."""
    largest = {}
    for contact in problem.contacts:
        of_elements = [float(group.friction.max(initial=0.0)) for group in contact.elements.friction]
        largest[contact.name] = max([largest_friction(getattr(contact.law, "mu", 0.0)), *of_elements])
    large = [contact for contact in problem.contacts if largest[contact.name] >= LARGEST_FRICTION]
    if not large:
        return ""
    lost = any(contact.normal is not None for contact in large)
    return (
        f"Large friction coefficients ({_named([contact.name for contact in large])}): up to mu = {max(largest.values()):.3g}. "
        + ("Where such contacts lift off, the curve may stop. " if lost else "")
        + "Measured coefficients are hardly ever above 1."
    )


def _friction_over_load(problem: Problem) -> str:
    """Contacts whose normal load at rest lies beyond the loads of their coefficient of friction."""
    given = {c.name: mu for c in problem.contacts if isinstance(mu := getattr(c.law, "mu", 0.0), LoadDependentFriction)}
    if not given:
        return ""
    constant = {c.name: np.sum(load) for c in problem.contacts if (load := getattr(c.law, "normal_load", None)) is not None}
    loads = normal_loads_at_rest(problem) | constant
    beyond = [name for name, mu in given.items() if name in loads and not mu.over[0] <= loads[name] <= mu.over[-1]]
    if not beyond:
        return ""
    mu, load = given[beyond[0]], float(loads[beyond[0]])
    return (
        f"Normal loads at rest beyond those for which mu is given ({_named(beyond)}): {load:.4g} N at {beyond[0]}, whose mu is "
        f"given from {mu.over[0]:.4g} to {mu.over[-1]:.4g} N. Beyond them mu is constant, there "
        f"{float(mu.coefficient(load)):.4g}."
    )


def _sizes(problem: Problem) -> str:
    """Rigid bodies with a section that is far larger or smaller than what they touch: their dimensions are in other units."""
    structure = problem.structure
    others = [point for name, point in structure.nodes.items() if name not in structure.outlines]
    model = np.concatenate([structure.mesh_points, np.reshape(others, (-1, 3))])
    if len(model) < 2 or not (size := _extent(model)):
        return ""
    strange = {
        name.rpartition("/")[0] or name: own
        for name, corners in structure.outlines.items()
        if len(corners) and not LEAST_SIZE * size <= (own := _extent(np.asarray(corners))) <= MOST_SIZE * size
    }
    if not strange:
        return ""
    name, own = next(iter(strange.items()))
    return (
        f"Sizes that do not fit ({_named(list(strange))}): the section of {name} is {own:.3g} m wide, but all nodes of the "
        f"model lie within {size:.3g} m. Check the units of its dimensions."
    )


def _extent(points: Array) -> float:
    """The longest side of the box round points (k, 3), m."""
    return float(np.ptp(points, axis=0).max(initial=0.0))


def _starts(problem: Problem) -> str:
    """Contacts with a start state that their law does not have."""
    given = [
        contact
        for contact in problem.contacts
        if contact.has_no_start and any(start != SliderOffset() for start in contact.starts)
    ]
    if not given:
        return ""
    laws = " and ".join(sorted({type(contact.law).__name__ for contact in given}))
    return f"Start states without effect ({_named([contact.name for contact in given])}): a contact of {laws} has none."


def _normal_stiffness(problem: Problem) -> str:
    """Contacts whose stiffnesses along and across the surface differ as no body makes them."""
    ratios = {}
    for contact in problem.contacts:
        normal, sizes = contact.elements.normal, [_motion_of(direction) ** 2 for direction in contact.directions]
        along = [size * float(group.stiffness.sum()) for size, group in zip(sizes, contact.elements.friction, strict=False)]
        if normal is not None and max(along, default=0.0) > 0.0 and sizes[-1]:
            ratios[contact.name] = sizes[-1] * float(normal.stiffness.sum()) / max(along)
    odd = {name: ratio for name, ratio in ratios.items() if not SOFTEST_NORMAL <= ratio <= STIFFEST_NORMAL}
    if not odd:
        return ""
    worst = max(odd.values(), key=lambda ratio: abs(np.log(max(ratio, 1e-300))))
    return (
        f"Unusual ratio of normal to tangential stiffness ({_named(list(odd))}): kn is {worst:.2g} times kt. Between elastic "
        "bodies it is 1 to 1.5 times kt. Check whether the two are exchanged, and the units of both."
    )


def _preloads(problem: Problem) -> str:
    """Preloads, as interferences, of which what the contacts join takes more than they do: stiffer contacts than what they join.

    Contacts of one surface share theirs, and static loads, which may unload contacts, do not count.
    """
    groups: dict[str, dict[str, float]] = {}
    for contact in problem.contacts:
        normal, group = contact.elements.normal, contact.surface.name if contact.surface else contact.name
        if normal is not None and not contact.balanced:
            groups.setdefault(group, {})[contact.name] = float(normal.forces(0.0).sum())
    if not any(any(stated.values()) for stated in groups.values()):
        return ""
    shaking = [replace(force, static=0.0) for force in problem.forces if any(force.amplitudes.values())]
    loads = normal_loads_at_rest(problem.with_forces(shaking))
    for group, stated in sorted(groups.items()) if loads else ():
        whole, left = sum(stated.values()), sum(loads[name] for name in stated)
        if left < LEFT * whole:
            kept = f"{left:.3g} N are" if round(left / whole, 3) else "nothing is"
            return (
                f"The preload of {group}, {whole:.4g} N, is an interference, of which {kept} left at rest without "
                "other loads, since what the contacts join yields more than they do. If it is the normal load at rest, write "
                "balanced = true; else raise it until the load at rest is right."
            )
    return ""


def _motion_of(direction: Direction) -> float:
    """The largest coefficient of a direction, a vector (x, y, z) at each node, without rotations."""
    squares: dict[str, float] = {}
    for dof, coefficient in direction.items():
        node, _, axis = dof.rpartition(".")
        squares[node] = squares.get(node, 0.0) + (axis not in ROTATIONS) * coefficient**2
    return float(np.sqrt(max(squares.values())))


def _damping(problem: Problem) -> str:
    """A damping ratio that was a percentage, or a C in other units: what results in the lowest stuck mode counts."""
    rule = problem.structure.damping
    largest = float(np.max(rule.ratio)) if isinstance(rule, ModalDamping) else 0.0
    if largest > LARGEST_RATIO:
        return f"A large damping ratio: {largest:g}, {100.0 * largest:g} % of critical damping. One per cent is 0.01."
    system = problem.systems.at(1)
    if (isinstance(rule, ModalDamping) and not problem.dashpots) or not np.any(system.C):
        return ""
    modes = natural_modes(system.M, system.K)
    elastic = np.flatnonzero(modes.squares > 0.0)[:1]
    ratio = float(_ratios(system.C, modes)[elastic].max(initial=0.0))
    if ratio <= LARGEST_RATIO:
        return ""
    return (
        f"Large damping: the lowest mode with all contacts stuck, at {float(modes.frequencies[elastic[0]]):.5g} Hz, has the "
        f"damping ratio {ratio:.3g}, {100.0 * ratio:.3g} % of critical damping. Check the units of C, or whether the "
        "Rayleigh factors are exchanged (C = a M + b K, a in 1/s, b in s)."
    )


def negative_damping(problem: Problem) -> str:
    """A mode of the stuck structure that gas forces or dashpots feed, ζ = φᴴCφ/(2ω) < 0 with φᴴMφ = 1: it grows until friction or
    nothing holds it. The least damped one is named.
    """
    if problem.systems.passive:
        return ""
    fed = []
    for name, system in problem.systems.vibrating():
        rounding = ROUNDING * float(np.abs(system.C).sum(axis=1).max(initial=0.0))
        if not is_definite(0.5 * (system.C + system.C.conj().T), rounding):
            modes = natural_modes(system.M, system.K)
            ratios = _ratios(system.C, modes)
            fed.append((float(ratios.min()), name, float(modes.frequencies[int(np.argmin(ratios))])))
    ratio, name, frequency = min(fed, default=(0.0, "", 0.0))
    if ratio >= 0.0:
        return ""
    return (
        f"Negative damping: with all contacts stuck, the mode at {frequency:.5g} Hz{name} has the damping ratio {ratio:.3g}. "
        "Small vibrations of this mode grow by themselves, whatever the excitation, and the computed response may be unstable. "
        "`limit_cycles` computes the amplitudes at which friction stops the growth, and beyond which nothing does. If this is "
        "not intended, check the sign."
    )


def _ratios(C: NDArray[Any], modes: Modes) -> Array:
    """Damping ratios of elastic modes, 0 where rounding may decide their sign."""
    losses = np.sum(modes.shapes.conj() * (C @ modes.shapes), axis=0).real
    omega = np.sqrt(np.maximum(modes.squares, 0.0))
    ratios = np.divide(losses, 2.0 * omega, out=np.zeros_like(omega), where=omega > 0.0)
    return np.asarray(np.where(np.abs(ratios) > LEAST_RATIO, ratios, 0.0))


def _damped_gaps(problem: Problem) -> str:
    """Modal damping of modes in which contacts are closed that are open at rest: it joins their sides like dashpots."""
    rule = problem.structure.damping
    if not isinstance(rule, ModalDamping) or rule.on != "stuck" or not any(map(_has_gap, problem.contacts)):
        return ""
    loads = normal_loads_at_rest(problem)
    open_ = [contact.name for contact in problem.contacts if _has_gap(contact) and not loads.get(contact.name, 1.0)]
    if not open_:
        return ""
    return (
        f"Contacts with a gap, open at rest ({_named(open_)}), are closed in the modes to which the damping ratio belongs: it "
        'damps the motion of their sides against each other although they do not touch. Give ModalDamping on = "free".'
    )


def _has_gap(contact: Contact) -> bool:
    """Whether the contact is open while nothing is displaced."""
    normal = contact.elements.normal
    return normal is not None and bool(np.all(normal.constant < 0.0))


def _directions(problem: Problem) -> Iterator[str]:
    """Directions of contacts that are no unit vectors, do not cancel, or are not perpendicular to each other."""
    faults: dict[str, list[str]] = {}
    for contact in problem.contacts:
        for name, direction in zip(contact.direction_names, contact.directions, strict=True):
            fault = _fault_of(direction, problem.systems.one_frame)
            if fault:
                faults.setdefault(fault, []).append(f"{contact.name}, {name}")
        for one, other in combinations(range(len(contact.directions)), 2):
            if not _perpendicular(contact.directions[one], contact.directions[other]):
                names = " and ".join(contact.direction_names[k] for k in (one, other))
                faults.setdefault("The directions must be perpendicular to each other", []).append(f"{contact.name}, {names}")
    for fault, places in faults.items():
        yield f"Directions of contacts ({_named(places)}): {fault}."


def _fault_of(direction: Direction, one_frame: bool) -> str:
    """What is wrong with the translations of a direction, or nothing; one_frame: whether all are along the same axes.

    v_k, the coefficients of node k along x, y and z, are +e on one side of the contact and −e on the other, |e| = 1; a side may
    be several nodes whose coefficients add up to that, or the ground.
    """
    nodes, whole = _translations(direction)
    if not nodes:
        return ""
    vectors = np.array(list(nodes.values()))
    axis = vectors[np.argmax(np.linalg.norm(vectors, axis=1))]
    along = vectors @ (axis / np.linalg.norm(axis))
    sides = sorted((float(along[along > 0.0].sum()), float(-along[along < 0.0].sum())))
    if not (whole and one_frame):
        alone = len(nodes) == 1 and abs(sides[1] - 1.0) > ROUNDED
        return f"The coefficients must be those of a unit vector, but have length {sides[1]:.3g}" if alone else ""
    apart = float(np.linalg.norm(vectors.sum(axis=0)))
    to_ground = abs(apart - 1.0) <= ROUNDED and sides[0] <= ROUNDED
    if to_ground or (apart <= ROUNDED and abs(sides[1] - 1.0) <= ROUNDED):
        return ""
    if apart <= ROUNDED * sides[1]:
        return f"The coefficients must be those of a unit vector, but have length {sides[1]:.3g}"
    return (
        "Where both sides move alike by 1, the relative displacement must be 0, or 1 against the ground, but is "
        f"{apart:.3g}. Check signs and sizes of the coefficients"
    )


def _translations(direction: Mapping[str, float]) -> tuple[dict[str, Array], bool]:
    """The coefficients (3,) along x, y and z by node; whether all others are rotations (else modal coordinates, say)."""
    nodes: dict[str, Array] = {}
    whole = True
    for dof, coefficient in direction.items():
        node, _, axis = dof.rpartition(".")
        if axis in AXES and coefficient:
            nodes.setdefault(node, np.zeros(3))[AXES.index(axis)] = coefficient
        whole = whole and axis in (*AXES, *ROTATIONS)
    return nodes, whole


def _perpendicular(one: Direction, other: Direction) -> bool:
    """Whether two directions are so at every node that both have."""
    a, b = _translations(one)[0], _translations(other)[0]
    return all(
        abs(a[node] @ b[node]) <= ROUNDED * np.linalg.norm(a[node]) * np.linalg.norm(b[node]) for node in a.keys() & b.keys()
    )


def _named(names: Sequence[str]) -> str:
    """The first names of a list, each once."""
    return first_of(list(dict.fromkeys(names)))
