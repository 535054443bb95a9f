"""Performance curves in a study, and their band over the start states: [performance_curve] and [performance_band]."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import Field

from stickslip.analyses.performance.band import band_dataset, force_levels
from stickslip.analyses.performance.curve import gathered
from stickslip.analyses.performance.work import PerformanceWork
from stickslip.analyses.variability.bounds_work import BoundsWork, refuse_discs
from stickslip.checks import MOST, InputError, counted, fault
from stickslip.runs.work import Arrays, Work
from stickslip.study.analyses.forced_response import sweep_of
from stickslip.study.analyses.response_variability import StartsTable
from stickslip.study.analysis import Asked, Kind, Plan, Sweep
from stickslip.study.fields import Positive, Table
from stickslip.study.settings_table import check_of, table_of
from stickslip.study.tables import Ends
from stickslip.study.units import FORCE, Units, in_si, with_si

if TYPE_CHECKING:
    import xarray as xr


Points = Annotated[int, Field(ge=2, le=MOST, description="values of F_C/F_E, in equal ratios")]
PerformanceTable = table_of(
    PerformanceWork,
    "The resonance against F_C/F_E, for one or several friction coefficients; sought in the band of [sweep].",
    friction=Annotated[list[Positive] | None, Field(min_length=1)],
    pull=Annotated[Positive | None, FORCE],
    points=(Points, 40),
    force_ratio=Ends,
)


class BandTable(StartsTable):
    """The lowest and the highest resonance over all start states of the contacts, against F_C/F_E."""

    force_ratio: Annotated[Ends, Field(description="[low, high] of F_C/F_E")]
    points: Annotated[int, Field(ge=2, le=MOST, description="values of F_C/F_E, in equal ratios")] = 6
    pull: Annotated[Positive | None, FORCE, Field(description="F_C of the problem; its largest static force unless given")] = None
    share: Annotated[
        Literal["element", "direction", "contact", "all"], Field(description="which friction elements have one in common")
    ] = "contact"
    cloud: Annotated[int, Field(ge=0, le=MOST, description="start states sampled at each value")] = 20
    starts: Annotated[int, Field(ge=0, le=MOST, description="how many of them begin a search")] = 2


def ordered(table: Any) -> None:
    """What the model of the table cannot check."""
    low, high = table.force_ratio
    if low >= high:
        raise fault("force_ratio", "must be [low, high] with low below high", table.force_ratio)


def checked(table: Any) -> None:
    """The same of a performance curve."""
    ordered(table)
    check_of(PerformanceWork)(table)


@dataclass(frozen=True, eq=False)
class PerformancePlan(Plan):
    """A performance curve for each friction coefficient."""

    sweep: Sweep
    settings: Mapping[str, Any]

    @classmethod
    def of(cls, asked: Asked) -> PerformancePlan:
        """The plan of a study."""
        return cls(sweep_at_ratios(asked), at_ratios(asked.tables["performance_curve"], asked.units))

    @property
    def summary(self) -> str:
        curves = counted(len(self.settings["friction"] or [0]), "performance curve")
        low, *_, high = ratios = self.settings["force_ratio"]
        return f"{self.sweep.summary}; {curves} of {counted(len(ratios), 'point')}, F_C/F_E {low:g} to {high:g}"

    @cached_property
    def work(self) -> PerformanceWork:
        own = {"problem": self.sweep.problem, "band": self.sweep.frequencies}
        return PerformanceWork(**self.sweep.settings | own, **self.settings)

    @property
    def works(self) -> Mapping[str, Work]:
        return {"": self.work}

    def dataset(self, results: Mapping[str, Sequence[Arrays]]) -> xr.Dataset:
        return gathered(self.work, results[""]).dataset


@dataclass(frozen=True, eq=False)
class BandPlan(Plan):
    """The band of a performance curve over the start states."""

    sweep: Sweep
    table: BandTable

    @classmethod
    def of(cls, asked: Asked) -> BandPlan:
        """The plan of a study."""
        sweep = sweep_at_ratios(asked)
        refuse_discs(sweep.problem)
        return cls(sweep, with_si(BandTable.model_validate(asked.tables["performance_band"]), asked.units))

    @property
    def summary(self) -> str:
        low, high = self.table.force_ratio
        return f"{self.sweep.summary}; band of the performance curve at {self.table.points} F_C/F_E, {low:g} to {high:g}"

    @cached_property
    def work(self) -> BoundsWork:
        table, base = self.table, self.sweep.forced_response()
        band = (min(base.frequencies), max(base.frequencies))
        levels = force_levels(base.problem, ratios_of(table), table.pull)
        return BoundsWork(
            base.problem,
            frequencies=band,
            levels=levels,
            objective="peak",
            output=0,
            cloud=table.cloud,
            starts=table.starts,
            rule=table.rule,
            share=table.share,
            seed=table.seed,
            harmonics=base.harmonics,
            samples=base.samples,
            measure=replace(base.measure, per_force=False),
        )

    @property
    def works(self) -> Mapping[str, Work]:
        return {"": self.work}

    def dataset(self, results: Mapping[str, Sequence[Arrays]]) -> xr.Dataset:
        return band_dataset(self.work, ratios_of(self.table), results[""])


def sweep_over_a_band(asked: Asked) -> Sweep:
    """The sweep, whose band says where resonances are sought."""
    sweep = sweep_of(asked)
    if isinstance(sweep.frequencies, tuple):
        raise InputError("[sweep]: a performance curve must have a band, frequency = [start, stop], but has a list.")
    return sweep


def sweep_at_ratios(asked: Asked) -> Sweep:
    """The sweep over a band of an analysis whose F_C/F_E says how large the excitation is."""
    sweep = sweep_over_a_band(asked)
    if sweep.force_levels != (1.0,):
        given = ", ".join(f"{level:g}" for level in sweep.force_levels)
        raise InputError(f"[sweep]: force_levels must be left out, since force_ratio says the forces, but is [{given}].")
    return sweep


def at_ratios(table: Table, units: Units) -> dict[str, Any]:
    """The settings of a table, with F_C/F_E in equal ratios between its ends."""
    settings = in_si(table, units)
    low, high = settings["force_ratio"]
    settings["force_ratio"] = np.geomspace(low, high, settings.pop("points")).tolist()
    return settings


def ratios_of(table: BandTable) -> tuple[float, ...]:
    """The values of F_C/F_E."""
    return tuple(np.geomspace(table.force_ratio[0], table.force_ratio[1], table.points).tolist())


KINDS = {
    "performance_curve": Kind(
        PerformancePlan.of,
        {"performance_curve": PerformanceTable},
        required=("performance_curve",),
        checks={"performance_curve": checked},
    ),
    "performance_band": Kind(
        BandPlan.of,
        {"performance_band": BandTable},
        required=("performance_band",),
        checks={"performance_band": ordered},
    ),
}
