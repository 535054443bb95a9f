"""Warnings about a study that can be computed, but whose numbers together are hardly what was meant: slips of units and signs.

They look at what results, motions, forces and resonances in the band, whichever number was mistyped.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.contact.point import Contact
from stickslip.problem import Problem
from stickslip.problem.at_rest import normal_loads_at_rest
from stickslip.problem.warnings import LARGEST_FRICTION
from stickslip.study.analysis import Sweep
from stickslip.units import Band

LARGE = 0.1
"""Linear amplitude over the size of the structure from where on a theory of small motions is left."""

LARGE_WITHOUT_SIZE = 1e3
"""The same in m where no coordinates are known: models of a few masses are often stated without dimensions."""

IDLE = 0.1
"""Share of its slip limit that the most loaded contact carries at the stuck resonance of the largest force level, below which
friction never acts."""

UNREACHED = 1e-9
"""The same share below which the excitation does not reach the contacts at all, whatever the units."""

NEGLIGIBLE = 0.02
"""All slip limits together over the harmonic forces of the smallest level, below which friction changes nothing."""

SHOWN = 6
"""Natural frequencies that a sentence lists."""


def plausibility_warnings(sweep: Sweep) -> list[str]:
    """What is hardly meant: motions as large as the structure, a band without resonance, friction that can never act."""
    given = sweep.frequencies
    low, high = (given.low, given.high) if isinstance(given, Band) else (float(np.min(given)), float(np.max(given)))
    return [*_amplitudes(sweep, low, high), *_band(sweep, low, high), *_friction(sweep, low, high)]


def _amplitudes(sweep: Sweep, low: float, high: float) -> list[str]:
    """A warning where the largest force level moves the structure by a part of its size, even at the ends of the band and with
    all contacts stuck.
    """
    problem, level = sweep.problem, max(sweep.force_levels)
    moved = max(float(np.max(np.abs(problem.output_rows @ _stuck_motion(problem, level, hertz)))) for hertz in (low, high))
    places = np.concatenate([problem.structure.mesh_points, np.reshape(list(problem.structure.nodes.values()), (-1, 3))])
    size = float(np.ptp(places, axis=0).max()) if len(places) else 0.0
    if moved <= (LARGE * size or LARGE_WITHOUT_SIZE):
        return []
    compared = f", {moved / size:.2g} times the size of the structure" if size else ""
    return [
        f"Warning: force level {level:g} moves the stuck structure by {moved:.3g} m{compared}. The theory assumes small motions: "
        "check the units of forces and stiffnesses."
    ]


def _band(sweep: Sweep, low: float, high: float) -> list[str]:
    """A band that holds no natural frequency, free or stuck, at which a harmonic of the excitation meets the structure."""
    met = np.concatenate([sweep.problem.systems.met(stuck) for stuck in (False, True)])
    if not isinstance(sweep.frequencies, Band) or np.any((met >= low) & (met <= high)):
        return []
    nearest = sorted(f"{f:.5g}" for f in sorted(met[met > 0.0], key=lambda f: abs(np.log(f / np.sqrt(low * high))))[:2])
    where = f"; the nearest are at {' and '.join(nearest)} Hz" if nearest else ""
    return [f"Warning: no natural frequency lies between {low:.6g} and {high:.6g} Hz, where the response is computed{where}."]


def _friction(sweep: Sweep, low: float, high: float) -> list[str]:
    """Contacts that stay stuck even at the resonance of the largest force level, or slip limits that are nothing beside the
    forces: pulls, preloads and forces do not fit.
    """
    problem = sweep.problem
    limits = slip_limits(problem)
    if not limits:
        return []
    largest, smallest = max(sweep.force_levels), min(sweep.force_levels)
    force, total = smallest * _excitation(problem), sum(limits.values())
    if total < NEGLIGIBLE * force:
        return [
            f"Warning: all contacts together slip at {total:.3g} N, but the smallest excitation is {force:.3g} N, so "
            "friction has almost no effect. Check the units of pulls, preloads and forces, and the force levels."
        ]
    inside = [float(f) for f in problem.systems.met(True) if low <= f <= high]
    name, share = _most_loaded(problem, largest, [*inside[:SHOWN], low, high], limits)
    if share >= IDLE or share < UNREACHED:
        return []
    return [
        f"Warning: no contact slips at force level {largest:g}: the most loaded contact, {name}, carries {100.0 * share:.2g} % "
        f"of its slip limit ({limits[name]:.3g} N) in the stuck response. Check the units of pulls, preloads and forces."
    ]


def slip_limits(problem: Problem) -> dict[str, float]:
    """μN of each contact at rest, N, of those that carry load and rub with a coefficient that a measurement may have."""
    loads: Mapping[str, float] = normal_loads_at_rest(problem)
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
    orders = max((harmonic for force in problem.forces for harmonic in force.amplitudes), default=1)
    load = problem.load(orders, 1.0, problem.first_omega_at_rest)[:, 1:]
    rows = [k for k, dof in enumerate(problem.structure.dofs) if not dof.rpartition(".")[2].startswith("r")]
    parts = load.reshape(load.shape[0], -1, 2)
    sizes = np.hypot(parts[..., 0], parts[..., 1]).sum(axis=1)
    return float(sizes[rows].sum() if problem.structure.shapes is None else sizes.sum())


def _most_loaded(problem: Problem, level: float, hertz: list[float], limits: Mapping[str, float]) -> tuple[str, float]:
    """The contact that carries most of its slip limit with all contacts stuck, and that share; infinite at undamped ones."""
    starts = np.cumsum([0, *(len(contact.directions) for contact in problem.contacts)])
    rows = {contact.name: int(start) for contact, start in zip(problem.contacts, starts[:-1], strict=True)}
    found = dict.fromkeys(limits, 0.0)
    for f in hertz:
        forces = np.abs(problem.contact_stiffness * (problem.systems.at(1).B @ _stuck_motion(problem, level, f)))
        for contact in problem.contacts:
            if contact.name in found:
                first = rows[contact.name]
                carried = float(np.linalg.norm(forces[first : first + len(contact.elements.friction)]))
                found[contact.name] = max(found[contact.name], carried / limits[contact.name])
    return max(found.items(), key=lambda item: item[1])


def _stuck_motion(problem: Problem, level: float, hertz: float) -> NDArray[np.complex128]:
    """First harmonic with all contacts stuck, complex amplitudes (n,), m; 0 where it is not finite."""
    omega = 2.0 * np.pi * hertz
    system = problem.systems.at(1)
    orders = max((harmonic for force in problem.forces for harmonic in force.amplitudes), default=1)
    load = problem.load(orders, level, omega)
    dynamic: NDArray[np.complex128] = system.K - omega**2 * system.M + 1j * omega * system.C
    force: NDArray[np.complex128] = load[:, 1] - 1j * load[:, 2]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", linalg.LinAlgWarning)
            moved = np.asarray(linalg.solve(dynamic, force))
    except (linalg.LinAlgError, linalg.LinAlgWarning):
        moved = np.asarray(np.linalg.lstsq(dynamic, force, rcond=None)[0])
    return np.asarray(np.nan_to_num(moved, posinf=0.0, neginf=0.0))
