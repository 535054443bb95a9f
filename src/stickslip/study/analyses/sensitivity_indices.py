"""Sensitivity indices in a study: the table [sensitivity_indices], ranges of factors on the contacts and of a start state."""

from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import Field

from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.performance.sensitivity_indices import MOST_DRAWS, DrawsWork, gathered
from stickslip.analyses.performance.work import with_factors, with_preload_factor
from stickslip.model.contact.point import Contact, SliderOffset
from stickslip.model.problem import Problem
from stickslip.study.analyses.performance_curve import sweep_over_a_band
from stickslip.study.analysis import Asked, Kind, Works, summary_of, taken_over
from stickslip.study.fields import LENGTH, Table, in_si, table_of
from stickslip.study.tables import Ends, Two
from stickslip.support.checks import InputError, fault
from stickslip.support.units import Band

FACTORS = ("kt", "kn", "mu", "preload")


class RangesTable(Table):
    """Ranges of what is uncertain."""

    kt: Annotated[Ends | None, Field(description="[low, high] of a factor on the tangential stiffness of every contact")] = None
    kn: Annotated[Ends | None, Field(description="[low, high] of a factor on the normal stiffness")] = None
    mu: Annotated[Ends | None, Field(description="[low, high] of a factor on the friction coefficient")] = None
    preload: Annotated[Ends | None, Field(description="[low, high] of a factor on every static force and preload")] = None
    slider_offset: Annotated[Two | None, LENGTH, Field(description="start state of every contact; instead of its own")] = None

    def check(self) -> None:
        """Ranges in order, and a power of two of draws."""
        ranges(self)


UncertainTable = table_of(
    DrawsWork,
    "Ranges of what is uncertain, each drawn evenly: which of them spreads the resonance in the band of [sweep]?",
    RangesTable,
    draws=Annotated[int, Field(ge=2, le=MOST_DRAWS)],
)


@dataclass(frozen=True, eq=False)
class Varied:
    """A problem whose contacts have their parameters times factors, and start from an offset."""

    problem: Problem

    def __call__(self, **values: float) -> Problem:
        factors = {name: values[name] for name in FACTORS[:3] if name in values}

        def changed(contact: Contact) -> Contact:
            return with_factors(contact, factors)

        problem = self.problem.with_contacts(changed)
        if "preload" in values:
            problem = with_preload_factor(problem, values["preload"])
        return problem.with_start(SliderOffset(values["slider_offset"])) if "slider_offset" in values else problem


def ranges(table: Any) -> dict[str, list[float]]:
    """What is uncertain, by name; at least one, each in order."""
    found = {name: ends for name in (*FACTORS, "slider_offset") if (ends := getattr(table, name)) is not None}
    if not found:
        raise fault("sensitivity_indices", f"must give a range of one of {', '.join(FACTORS)}, slider_offset", "none")
    for name, (low, high) in found.items():
        if low >= high:
            raise fault(name, "must be [low, high] with low below high", [low, high])
    if table.draws & (table.draws - 1):
        raise fault("draws", "must be a power of two", table.draws)
    return found


def plan(asked: Asked) -> Works:
    """Peaks at drawn values, and the indices that follow."""
    sweep, table = sweep_over_a_band(asked), asked.tables["sensitivity_indices"]
    if len(sweep.levels) != 1:
        raise InputError("[sweep]: force_levels must be one for sensitivity indices, but are several. Write a study for each.")
    values = in_si(table, asked.units)
    box = {name: (values[name][0], values[name][1]) for name in ranges(table)}
    for name in FACTORS[:3]:
        if name in box and not any(hasattr(contact.law, name) for contact in sweep.problem.contacts):
            raise fault(f"[sensitivity_indices]: {name}", "must meet a contact law that has it", "none does")

    def work() -> DrawsWork:
        base = ForcedResponseWork.of(sweep)
        shared = taken_over(base)
        make, band = Varied(shared.pop("problem")), Band(min(sweep.frequencies), max(sweep.frequencies))
        return DrawsWork(make, box, band, base.levels[0], draws=values["draws"], seed=values["seed"], **shared)

    return Works(work, f"{summary_of(sweep)}; {values['draws'] * (len(box) + 2)} problems for {', '.join(box)}", gathered)


TABLE = "sensitivity_indices"
KIND = Kind(plan, {TABLE: UncertainTable}, without=("peak_tolerance",))
