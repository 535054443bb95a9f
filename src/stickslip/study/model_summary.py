"""What a check says of the model of a study: natural frequencies, what holds it, and the loads of its contacts at rest."""

from __future__ import annotations

from stickslip.analyses.response_settings import ForcedResponseSettings
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.problem import Problem
from stickslip.model.problem.at_rest import normal_loads_at_rest
from stickslip.model.problem.loose_motions import soft_springs
from stickslip.results.shown_units import in_system
from stickslip.solve.curves.curve import HELD_BY_FRICTION, held_by_friction_alone
from stickslip.support.checks import Array, counted, first_of
from stickslip.support.units import UnitSystem

SHOWN = 6
"""How many frequencies, and how many contacts, a sentence lists."""


def model_summary(sweep: ForcedResponseSettings, condition: str = "", system: UnitSystem | None = None) -> list[str]:
    """Natural frequencies without contacts and with all stuck, whether friction alone holds a body, and normal loads at rest.
    condition: when all that holds, "at 6000 rev/min".
    """
    free, stuck = (sweep.problem.frequencies(stuck=stuck) for stuck in (False, True))
    when = f" {condition}" if condition else ""
    listed = f"without contacts: {_listed(free)}; all contacts stuck: {_listed(stuck)}"
    lines = [f"Natural frequencies in Hz{when}, {listed}."]
    lines += _waves(sweep.problem)
    if held_by_friction_alone(sweep.problem):
        lines.append(f"{HELD_BY_FRICTION} {_proposed(sweep.problem, system)}")
    return lines + _loads(sweep.problem, when, system)


def _waves(problem: Problem) -> list[str]:
    """Natural frequencies of a disk at the nodal diameters that are excited, and at 0 and N/2, which an analysis of the sector
    alone gives too."""
    if not isinstance(problem, TunedDisk):
        return []
    waves = [order % problem.sectors for order in problem.excited_orders or (problem.engine_order,)]
    diameters = dict.fromkeys((0, *(min(wave, problem.sectors - wave) for wave in waves[:SHOWN]), problem.sectors // 2))
    return [f"At nodal diameter {n}, without contacts: {_listed(problem.modes(n, stuck=False).frequencies)}." for n in diameters]


def _proposed(problem: Problem, system: UnitSystem | None) -> str:
    """Soft springs for the mean of each loose motion, as a study holds them, in its units."""
    tables, (factor, unit) = [], in_system("N/m", system)
    for spring in soft_springs(problem):
        largest = max(spring.direction.values(), key=abs)  # a motion has no sign; the table shows its largest part as 1
        parts = {dof: round(c / largest, 3) for dof, c in spring.direction.items()}
        direction = ", ".join(f'"{dof}" = {c:g}' for dof, c in parts.items() if c)
        tables.append(f"direction = {{ {direction} }}, k of about {factor * spring.stiffness * largest**2:.1g} {unit}")
    return f"A soft spring on the mean holds it and leaves the vibration as it is, [[mean_spring]]: {'; '.join(tables)}."


def _listed(frequencies: Array) -> str:
    """The lowest frequencies, and how many rigid motions there are below."""
    moving = frequencies[frequencies > 0.0]
    rigid = [counted(frequencies.size - moving.size, "rigid motion")] if moving.size < frequencies.size else []
    return first_of([*rigid, *(f"{f:.5g}" for f in moving)], SHOWN)


def _loads(problem: Problem, when: str, system: UnitSystem | None) -> list[str]:
    """Normal loads at rest of contacts where they vary; those that are open by name."""
    loads = normal_loads_at_rest(problem)
    if not loads:
        if not any(contact.normal is not None for contact in problem.contacts):
            return []
        held = " and that friction can hold them" if any(contact.law.rubs for contact in problem.contacts) else ""
        unknown = f"No static equilibrium was found{when}, so normal loads at rest are unknown."
        return [f"{unknown} Check that the static loads close the contacts{held}."]
    open_ = [name for name, load in loads.items() if load == 0.0]
    factor, unit = in_system("N", system)
    closed = [f"{name} {factor * load:.4g}" for name, load in loads.items() if load > 0.0]
    return [
        *([f"Normal loads at rest in {unit}{when}: {first_of(closed, SHOWN)}."] if closed else []),
        *([f"Open at rest{when}: {first_of(open_, SHOWN)}."] if open_ else []),
    ]
