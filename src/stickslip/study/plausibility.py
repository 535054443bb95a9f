"""Warnings about a study that can be computed, but whose numbers together are hardly what was meant: slips of units and signs.

They look at what results, motions, forces and resonances in the band, whichever number was mistyped.
"""

import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.analyses.settings import ForcedResponseSettings
from stickslip.analyses.static_load import modes_at_rest
from stickslip.model.contact.point import Contact, SliderOffset
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.loads import Output, excited_harmonics
from stickslip.model.problem import Problem
from stickslip.model.problem.at_rest import dampers, normal_loads_at_rest, unbearable_loads
from stickslip.model.problem.warnings import LARGEST_FRICTION
from stickslip.model.structure.cyclic import NEXT
from stickslip.results.schema import in_system
from stickslip.study.surfaces import CHECK_FIT, CHECK_UNITS
from stickslip.support.checks import Array, InputError
from stickslip.support.units import Band, UnitSystem

LARGE = 0.1
"""Linear amplitude over the size of the structure from where on a theory of small motions is left."""

LARGE_WITHOUT_SIZE = 1e3
"""The same in m where no coordinates are known: models of a few masses are often stated without dimensions."""

IDLE = 0.3
"""Share of its slip limit that the most loaded contact carries at the stuck resonance of the largest force level, below which
friction never acts."""

UNREACHED = 1e-9
"""The same share below which the excitation does not reach the contacts at all, whatever the units."""

NEGLIGIBLE = 0.02
"""All slip limits together over the harmonic forces of the smallest level, below which friction changes nothing."""

WEAK = 0.1
"""The most that friction can dissipate in a free mode over what the smallest level feeds into it, 4 Σ μN |B q| / (π |fᵀ q|),
below which friction changes nothing: it lowers the peak by no more than this share."""

BESIDE = 1.0 + 1e-4
"""Times a natural frequency, where the undamped response has the shape of its mode."""

YIELDING = 0.01
"""Displacement μN/kt at which a contact slips over the size of the structure, above which its stiffness is in other units."""

APART = 0.05
"""Gap, or interference N0/kn, of a contact over the size of the structure, above which it is in other units."""

BEYOND = 100.0
"""Offset of a slider over what its contact can move and yield, far above which its unit is another: from one on, all offsets drag
the slider to its limit alike."""

SINKING = 0.3
"""Lowest stuck frequency over the lowest elastic one without contacts, below which a body is too heavy for its contacts."""

FASTEST = 5e6
"""Static force on a body over its mass, m/s²: ω² r of the fastest blades is below 1e6."""

SHOWN = 6
"""Natural frequencies that a sentence lists."""


@dataclass(frozen=True, eq=False)
class _Study:
    """A sweep with the ends of its band, Hz, normal loads and slip limits at rest, N, and the units of sentences."""

    sweep: ForcedResponseSettings
    system: UnitSystem | None

    @property
    def problem(self) -> Problem:
        return self.sweep.problem

    @cached_property
    def band(self) -> tuple[float, float]:
        given = self.sweep.band
        return (given.low, given.high) if isinstance(given, Band) else (float(np.min(given)), float(np.max(given)))

    @cached_property
    def loads(self) -> dict[str, float]:
        return normal_loads_at_rest(self.problem)

    @cached_property
    def limits(self) -> dict[str, float]:
        return slip_limits(self.problem, self.loads)

    @cached_property
    def met(self) -> dict[bool, Array]:
        """Natural frequencies that the excitation meets, Hz, by whether contacts are stuck."""
        return {stuck: self.problem.systems.met(stuck) for stuck in (False, True)}

    def inside(self, stuck: bool) -> list[float]:
        """The first of them in the band."""
        low, high = self.band
        return [float(f) for f in self.met[stuck] if low <= f <= high][:SHOWN]

    def text(self, value: float, unit: str) -> str:
        """A length or force in SI in the units of the study."""
        factor, own = in_system(unit, self.system)
        return f"{factor * value:.3g} {own}"


def check_static_loads(problem: Problem, notes: Sequence[str] = ()) -> None:
    """Refuse a problem with a body that cannot be at rest, whatever the stiffness of its contacts; notes: on the model."""
    known = [note.removeprefix("Warning: ").rstrip(".") for note in notes if CHECK_UNITS in note or CHECK_FIT in note]
    far = "".join(f" {note}." for note in known)
    unbearable = unbearable_loads(problem)
    if unbearable and not unbearable_loads(problem, -1.0):
        far = f" Loads of the opposite sign could be carried.{far}"
    for name in unbearable:
        raise InputError(
            f"The contacts cannot carry the static load on {name!r}: no combination of compressive normal forces and friction up "
            "to mu N balances it, so it cannot be at rest. Check the direction of the pull, mu, the normals, and the position of "
            f"the body and of the surfaces around it.{_neighbour(problem)}{far}"
        )


def plausibility_warnings(sweep: ForcedResponseSettings, system: UnitSystem | None = None, forced: bool = True) -> list[str]:
    """What is hardly meant: motions as large as the structure, a band without resonance, friction that can never act, contacts
    that nothing presses, stiffnesses and bodies of other units.

    system: the units of sentences, SI unless given; forced: whether force levels act in the analysis.
    """
    study = _Study(sweep, system)
    levels = (_amplitudes, _friction, _offsets) if forced else ()
    return [words for check in (_band, _harmonics, _at_rest, _wiring, _distances, _bodies, *levels) for words in check(study)]


def other_speed(sweep: ForcedResponseSettings, speed: float, engine_order: int) -> list[str]:
    """A model at a rotor speed (rev/min) at which the engine order excites elsewhere than in the band."""
    low, high = min(sweep.frequencies), max(sweep.frequencies)
    hertz, turns = engine_order * speed / 60.0, 60.0 / max(engine_order, 1)
    if not hertz or low <= hertz <= high:
        return []
    return [
        f"Warning: the model holds for {speed:.5g} rev/min, where engine order {engine_order} excites at {hertz:.5g} Hz, but the "
        f"band corresponds to {low * turns:.5g} to {high * turns:.5g} rev/min: stiffness, static loads and mean stress are "
        "those of another speed."
    ]


def _harmonics(study: _Study) -> list[str]:
    """A warning where several harmonics are excited and the peaks are those of one."""
    excited = excited_harmonics(study.problem.forces)
    if len(excited) < 2 or study.sweep.measured.kind != "amplitude":
        return []
    listed = ", ".join(map(str, sorted(excited)))
    return [
        f"Warning: the excitation has the harmonics {listed}, but peaks are those of the first harmonic of the motion, which a "
        'resonance of another one hardly shows. Write `measure = "max_abs"` in [sweep] for the largest motion in time.'
    ]


def _amplitudes(study: _Study) -> list[str]:
    """A warning where the largest force level moves the structure by a part of its size, even at the ends of the band and with
    all contacts stuck, all excited harmonics together.
    """
    problem, level = study.problem, max(study.sweep.levels)
    outputs, harmonics = problem.output_rows, _excited(problem)
    motions = [[_linear_motion(problem, level, hertz, h)[0] for h in harmonics] for hertz in study.band]
    moved = float(np.abs(np.array(motions) @ outputs.T).sum(axis=1).max())
    size = problem.structure.extent
    if moved <= (LARGE * size or LARGE_WITHOUT_SIZE):
        return []
    compared = f", {moved / size:.2g} times the size of the structure" if size else ""
    return [
        f"Warning: force level {level:g} moves the stuck structure by {study.text(moved, 'm')}{compared}. The theory assumes "
        "small motions: check the units of forces and stiffnesses."
    ]


def _band(study: _Study) -> list[str]:
    """A band that holds no natural frequency, free, stuck or of small vibrations at rest, at which a harmonic of the excitation
    meets the structure."""
    low, high = study.band
    met = np.concatenate(list(study.met.values()))
    if study.sweep.listed or np.any((met >= low) & (met <= high)):
        return []
    met = np.concatenate([met, *(small.frequencies / harmonic for harmonic, _, small in modes_at_rest(study.problem)[1])])
    if np.any((met >= low) & (met <= high)):
        return []
    nearest = sorted(f"{f:.5g}" for f in sorted(met[met > 0.0], key=lambda f: abs(np.log(f / np.sqrt(low * high))))[:2])
    where = f"; the nearest are at {' and '.join(nearest)} Hz" if nearest else ""
    return [f"Warning: no natural frequency lies between {low:.6g} and {high:.6g} Hz, where the response is computed{where}."]


def _at_rest(study: _Study) -> list[str]:
    """Rubbing contacts without a gap none of which is pressed at rest: a pull or the normals point the other way."""
    closed = [contact for contact in study.problem.contacts if contact.law.rubs and _closes(contact)]
    if not closed or any(study.loads.get(contact.name, 0.0) > 0.0 for contact in closed):
        return []
    none = "no state of rest was found in which contacts carry the static loads"
    what = "no contact is pressed on at rest" if study.loads else none
    where = "Check the directions of pulls and normals, the preloads, and the positions of bodies."
    if any(contact.nodes for contact in closed):
        where += " Two contact points on a surface do not prevent a body from rotating: use `points` of three or more."
    return [f"Warning: {what}. {where}{_neighbour(study.problem)}"]


def _wiring(study: _Study) -> list[str]:
    """Forces and outputs on a damper instead of a blade, a side of it that stands off at rest, preloads below zero.

    A damper is a body of one node that a pull presses on the contacts that alone hold it, beside bodies that are held.
    """
    problem = study.problem
    preloads = {contact.name: float(np.min(getattr(contact.law, "preload", 0.0))) for contact in problem.contacts}
    found = [
        f"Warning: {name} has a preload of {study.text(preload, 'N')}, which separates its sides as a gap does. State a "
        "gap, or change the sign."
        for name, preload in preloads.items()
        if preload < 0.0
    ]
    structure, pulled = problem.structure, dampers(problem)
    on_damper = frozenset[str]().union(*pulled.values())

    def moving(direction: Mapping[str, float]) -> set[str]:
        own = (dof.removeprefix(NEXT) for dof, coefficient in direction.items() if coefficient)
        return {structure.dofs[structure.index(dof)] for dof in own}

    if not pulled or not (on_damper < {*structure.dofs}):
        return found
    names = " and ".join(pulled)
    if set().union(*(moving(force.coefficients) for force in problem.forces if any(force.amplitudes.values()))) <= on_damper:
        found.append(
            f"Warning: the excitation acts only on {names}, which only contacts restrain. Check the directions of the forces."
        )
    if all(moving(Output.of(output).direction) <= on_damper for output in problem.outputs):
        found.append(f"Warning: all outputs are on {names}, which only contacts restrain. Add an output on a blade.")
    twice = [
        contact.name
        for contact in problem.contacts
        if preloads[contact.name] > 0.0 and any(moving(direction) & on_damper for direction in contact.directions)
    ]
    if twice:
        found.append(
            f"Warning: {', '.join(twice[:SHOWN])} {'has' if len(twice) == 1 else 'have'} a preload, and a pull acts on {names}: "
            "the contact carries both. Remove one of them."
        )
    return found + _standing_off(study)


def _standing_off(study: _Study) -> list[str]:
    """Bodies that do not touch at rest although no gap is between them, while others press on each other."""
    sides: dict[frozenset[str], list[str]] = {}
    for contact in study.problem.contacts:
        if _closes(contact) and contact.normal is not None:
            nodes = {dof.removeprefix(NEXT).rpartition(".")[0] for dof, factor in contact.normal.items() if factor}
            bodies = frozenset(node.rpartition("/")[0] or node for node in nodes)
            sides.setdefault(bodies, []).append(contact.name)
    off = [names for names in sides.values() if not any(study.loads.get(name, 0.0) > 0.0 for name in names)]
    if not off or len(off) == len(sides):
        return []
    names = ", ".join(name for own in off for name in own[:SHOWN])
    return [
        f"Warning: {names} carries no load at rest, although it has no gap. Check the normals, the direction of the pull, and "
        "what the contacts join."
    ]


def _neighbour(problem: Problem) -> str:
    """What to write in the contacts of a damper between two sectors, where no contact joins two."""
    moved = (dof for contact in problem.contacts for direction in contact.directions for dof in direction)
    if not isinstance(problem, TunedDisk) or any(dof.startswith(NEXT) for dof in moved):
        return ""
    return " No contact joins two sectors: a damper between neighbours must touch next/SET."


def _closes(contact: Contact) -> bool:
    """Whether a contact has a normal direction, and no gap."""
    normal = contact.elements.normal
    return normal is not None and bool(np.any(normal.constant >= 0.0))


def _distances(study: _Study) -> list[str]:
    """Contacts that would yield, or stand off, by a part of the structure before they slip or close."""
    problem, limits, size = study.problem, study.limits, study.problem.structure.extent
    if not size:
        return []
    found = []
    yielding = {
        contact.name: limits[contact.name] / stiffness
        for contact in problem.contacts
        if contact.name in limits
        if (stiffness := max(float(group.stiffness.sum()) for group in contact.elements.friction))
    }
    name, most = max(yielding.items(), key=lambda item: item[1], default=("", 0.0))
    if most > YIELDING * size:
        found.append(
            f"Warning: {name} slips only where its spring has yielded by {study.text(most, 'm')}, the slip limit over kt, "
            f"{most / size:.2g} times the size of the structure. Check the units of kt and of the normal load."
        )
    standing = {contact.name: _standing(contact) for contact in problem.contacts}
    name, most = max(standing.items(), key=lambda item: item[1], default=("", 0.0))
    if most > APART * size:
        found.append(
            f"Warning: the gap of {name}, or its preload over kn, is {study.text(most, 'm')}, {most / size:.2g} times the "
            "size of the structure. Check the units of gap, preload and kn."
        )
    return found


def _offsets(study: _Study) -> list[str]:
    """Sliders that rest much further away than the contact moves, at the largest level and with contacts stuck or without them,
    and yields before it slips.
    """
    problem, level = study.problem, max(study.sweep.levels)
    given = {
        contact.name: [
            float(np.abs(start.values(group.stiffness.size)).max()) if isinstance(start, SliderOffset) else 0.0
            for start, group in zip(contact.starts, contact.elements.friction, strict=True)
        ]
        for contact in problem.contacts
        if contact.law.remembers_start
    }
    if not any(map(any, given.values())):
        return []
    moved = np.zeros(len(problem.contact_stiffness))
    for stuck in (True, False):
        for hertz in (*study.inside(stuck), *study.band):
            motions = {h: _linear_motion(problem, level, hertz, h, stuck, damped=True)[0] for h in _excited(problem)}
            moved = np.maximum(moved, sum(np.abs(problem.systems.at(h).B @ motion) for h, motion in motions.items()))
    far = []
    for contact, first in _first_rows(problem):
        for row, offset in enumerate(given.get(contact.name, ()), start=first):
            stiffness = float(contact.elements.friction[row - first].stiffness.sum())
            reach = float(moved[row]) + study.limits.get(contact.name, 0.0) / stiffness
            far.append((offset / max(reach, np.finfo(float).tiny), contact.name, offset, reach))
    times, name, offset, reach = max(far)
    if times <= BEYOND:
        return []
    return [
        f"Warning: the slider of {name} rests {study.text(offset, 'm')} away, {times:.2g} times as far as the contact moves "
        f"and yields, {study.text(reach, 'm')}: it is dragged to its limit in any case. Check the unit of slider_offset."
    ]


def _standing(contact: Contact) -> float:
    """The largest gap or interference of a contact, m."""
    normal = contact.elements.normal
    if normal is None:
        return 0.0
    distances = np.divide(normal.constant, normal.stiffness, out=np.zeros_like(normal.constant), where=normal.stiffness > 0.0)
    return float(np.abs(distances).max(initial=0.0))


def _bodies(study: _Study) -> list[str]:
    """Bodies so heavy that they sink into their contacts, and static forces that no rotor makes of their mass."""
    problem = study.problem
    if not problem.structure.outlines:
        return []
    found = []
    free, stuck = (problem.frequencies(stuck=stuck) for stuck in (False, True))
    elastic, held = free[free > 0.0], stuck[stuck > 0.0]
    if elastic.size and held.size and held[0] < SINKING * elastic[0]:
        found.append(
            f"Warning: the lowest mode with all contacts stuck, at {held[0]:.4g} Hz, lies far below the lowest elastic one "
            f"without contacts, at {elastic[0]:.5g} Hz: a body is heavy for its contacts. Check its mass, its dimensions, kt and "
            "kn."
        )
    structure = problem.structure if problem.mesh is None else problem.mesh.stuck.structure
    rows, masses = {dof: row for row, dof in enumerate(structure.dofs)}, structure.M.diagonal().real
    for node in problem.structure.outlines:
        at = [f"{node}.{axis}" for axis in "xyz" if f"{node}.{axis}" in rows]
        mass = max((float(masses[rows[dof]]) for dof in at), default=0.0)
        acting = [sum(force.static * force.coefficients.get(dof, 0.0) for force in problem.forces) for dof in at]
        force = float(np.linalg.norm(acting))
        if mass and force > FASTEST * mass:
            found.append(
                f"Warning: the static force on {node.rpartition('/')[0] or node} over its mass is {force / mass:.2g} m/s², "
                f"more than {FASTEST:g} m/s². Check the units of the pull, the density and the dimensions."
            )
    return found


def _friction(study: _Study) -> list[str]:
    """Contacts that stay stuck even at the resonance of the largest force level, or slip limits that are nothing beside the
    forces: pulls, preloads and forces do not fit.
    """
    problem, limits, levels = study.problem, study.limits, study.sweep.levels
    if not limits:
        rubbing = [contact for contact in problem.contacts if contact.law.rubs and contact.elements.friction]
        if rubbing and not any(_limit(contact, 1.0) for contact in rubbing):
            return ["Warning: no contact has friction, since mu and slip forces are zero: contacts dissipate nothing."]
        return []
    largest, smallest = max(levels), min(levels)
    force, total = smallest * _excitation(problem), sum(limits.values())
    if total < NEGLIGIBLE * force or _largest_effect(study, smallest) < WEAK:
        return [
            f"Warning: all contacts together slip at {study.text(total, 'N')}, but the smallest excitation is "
            f"{study.text(force, 'N')}, so friction has almost no effect. Check the units of pulls, preloads and forces, and "
            "the force levels."
        ]
    inside = study.inside(stuck=True)
    name, share = _most_loaded(study, largest, [*inside, *study.band])
    if share >= IDLE or share < UNREACHED:
        return [] if inside else _flank(study)
    return [
        f"Warning: no contact slips at force level {largest:g}: the most loaded contact, {name}, carries {100.0 * share:.2g} % "
        f"of its slip limit ({study.text(limits[name], 'N')}) in the stuck response. Check the units of pulls, preloads and "
        "forces."
    ]


def _flank(study: _Study) -> list[str]:
    """A band that holds resonances without contacts only, at whose smallest force level no contact slips: no peak is in it."""
    smallest, free, (low, high) = min(study.sweep.levels), study.inside(stuck=False), study.band
    if not free or study.sweep.listed:
        return []
    stuck = study.met[True]
    _, share = _most_loaded(study, smallest, [*free, low, high])
    if share >= 1.0 or share < UNREACHED or not stuck.size:
        return []
    nearest = float(stuck[np.argmin(np.abs(np.log(np.maximum(stuck, 1e-300) / np.sqrt(low * high))))])
    return [
        f"Warning: at force level {smallest:g} no contact slips between {low:.6g} and {high:.6g} Hz, and the nearest natural "
        f"frequency with all contacts stuck, {nearest:.5g} Hz, is outside of this band: the response has no peak in it. Widen "
        "the band, or check the units of kt and kn."
    ]


def _largest_effect(study: _Study, level: float) -> float:
    """4 Σ μN |B q| / (π |fᵀ q|) of the free mode q in the band in which friction can do most; infinite where there is none.

    Beside its resonance the response without contacts has the shape of the mode, and its size cancels. Of several excited
    harmonics the one in resonance is that whose force does most work.
    """
    problem, limits, largest = study.problem, study.limits, 0.0
    for hertz in study.inside(stuck=False):
        found = {h: _linear_motion(problem, level, BESIDE * hertz, h, stuck=False) for h in _excited(problem)}
        harmonic = max(found, key=lambda h: float(abs(found[h][1] @ found[h][0])))
        moved, load = found[harmonic]
        along, taken = np.abs(problem.systems.at(harmonic).B @ moved), 0.0
        for contact, first in _first_rows(problem):
            if contact.name in limits:
                taken += 4.0 * limits[contact.name] * float(np.linalg.norm(along[first : first + len(contact.elements.friction)]))
        fed = np.pi * abs(load @ moved)
        largest = max(largest, taken / float(fed) if fed else float(np.inf))
    return largest or float(np.inf)


def _first_rows(problem: Problem) -> Iterator[tuple[Contact, int]]:
    """Every contact with its first row among all contact rows."""
    starts = np.cumsum([0, *(len(contact.directions) for contact in problem.contacts)])
    return ((contact, int(start)) for contact, start in zip(problem.contacts, starts[:-1], strict=True))


def slip_limits(problem: Problem, loads: Mapping[str, float]) -> dict[str, float]:
    """μN of each contact at rest from its normal load, N, of those that carry load and rub with a coefficient that a measurement
    may have."""
    limits = {contact.name: _limit(contact, loads.get(contact.name)) for contact in problem.contacts if _rubs(contact)}
    return {name: limit for name, limit in limits.items() if limit > 0.0}


def _rubs(contact: Contact) -> bool:
    groups = contact.elements.friction
    return bool(groups) and max(float(group.friction.max(initial=0.0)) for group in groups) < LARGEST_FRICTION


def _limit(contact: Contact, load: float | None) -> float:
    """The largest slip limit of the directions of a contact; of a normal load shared by its elements as their stiffnesses."""
    normal = contact.elements.normal
    if normal is None:
        forces = np.zeros(0)
    elif load is None:
        return 0.0
    else:
        forces = load * normal.stiffness / normal.stiffness.sum()
    return max(float(group.limits(forces).sum()) for group in contact.elements.friction)


def _excitation(problem: Problem) -> float:
    """The harmonic forces of level one together, N, at a natural frequency where they go with it."""
    load = problem.load(max(_excited(problem)), 1.0, problem.first_omega_at_rest)[:, 1:]
    rows = [k for k, dof in enumerate(problem.structure.dofs) if not dof.rpartition(".")[2].startswith("r")]
    parts = load.reshape(load.shape[0], -1, 2)
    sizes = np.hypot(parts[..., 0], parts[..., 1]).sum(axis=1)
    return float(sizes[rows].sum() if problem.structure.shapes is None else sizes.sum())


def _most_loaded(study: _Study, level: float, hertz: Sequence[float]) -> tuple[str, float]:
    """The contact that comes nearest to slipping with all contacts stuck, and what it carries over its slip limit while its
    normal load is least in the period, T/(μ (N0 − N1)); infinite where it lifts off, and at undamped resonances. T and N1 are
    sums over the harmonics that are excited, at most reached at once.
    """
    problem, limits = study.problem, study.limits
    found = dict.fromkeys(limits, 0.0)
    for f in hertz:
        moved = sum(np.abs(problem.systems.at(h).B @ _linear_motion(problem, level, f, h)[0]) for h in _excited(problem))
        forces = problem.contact_stiffness * moved
        for contact, first in _first_rows(problem):
            if contact.name in found:
                normal = first + len(contact.elements.friction)
                carried = float(np.linalg.norm(forces[first:normal])) / limits[contact.name]
                swing = 0.0 if contact.elements.normal is None else float(forces[normal]) / study.loads[contact.name]
                share = carried / (1.0 - swing) if swing < 1.0 else np.inf
                found[contact.name] = max(found[contact.name], share)
    return max(found.items(), key=lambda item: item[1])


def _excited(problem: Problem) -> list[int]:
    """Those that are excited; the first where none is."""
    return sorted(excited_harmonics(problem.forces)) or [1]


def _linear_motion(
    problem: Problem, level: float, hertz: float, harmonic: int = 1, stuck: bool = True, damped: bool | None = None
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """A harmonic with all contacts stuck, or without contacts, complex amplitudes (n,), m, 0 where it is not finite; and the
    force, (n,), N. damped: unless given, where contacts stick."""
    system, omega = problem.systems.at(harmonic), 2.0 * np.pi * hertz
    load = problem.load(max(harmonic, *_excited(problem)), level, omega)[:, 2 * harmonic - 1 : 2 * harmonic + 1]
    K, share = system.K if stuck else problem.systems.free_stiffness(harmonic), float(stuck if damped is None else damped)
    w = harmonic * omega
    dynamic: NDArray[np.complex128] = K - w**2 * system.M + 1j * w * share * system.C
    force: NDArray[np.complex128] = load[:, 0] - 1j * load[:, 1]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", linalg.LinAlgWarning)
            moved = np.asarray(linalg.solve(dynamic, force))
    except (linalg.LinAlgError, linalg.LinAlgWarning):
        moved = np.asarray(np.linalg.lstsq(dynamic, force, rcond=None)[0])
    return np.asarray(np.nan_to_num(moved, posinf=0.0, neginf=0.0)), force
