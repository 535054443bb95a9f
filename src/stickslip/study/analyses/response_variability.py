"""Response variability in a study: the tables [response_bounds] and [response_samples]."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field, Tag

from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.variability.bounds_dataset import attached
from stickslip.analyses.variability.bounds_work import BoundsWork, refuse_discs
from stickslip.analyses.variability.samples import SamplesWork
from stickslip.analyses.variability.start_draws import Law, draw, named_law
from stickslip.checks import MOST, InputError, fault
from stickslip.runs.work import Arrays, Work
from stickslip.starts.space import rule_words
from stickslip.study.analyses.forced_response import sweep_of
from stickslip.study.analysis import Asked, Kind, Plan, Sweep
from stickslip.study.fields import Number, Seed, Table, Words, by_form

if TYPE_CHECKING:
    import xarray as xr


RuleName = Literal["slider_offset", "traction_ratio", "mean_traction", "virgin"]
RuleOrRules = Annotated[
    Annotated[RuleName, Tag("<single>")] | Annotated[list[RuleName], Field(min_length=2, max_length=2), Tag("<list>")],
    by_form(),
    Words('`"slider_offset"`, `"traction_ratio"`, `"mean_traction"`, `"virgin"`, or a list of two'),
]


class StartsTable(Table):
    """What the variables of the start states are."""

    rule: Annotated[
        RuleOrRules,
        Field(description='what a start variable sets; a list: in t1 and in t2, where "virgin" leaves the sliders at 0'),
    ] = "slider_offset"
    share: Annotated[
        Literal["element", "direction", "contact", "all"], Field(description="which friction elements have one in common")
    ] = "element"
    seed: Annotated[Seed, Field(description="of the random draws")] = 0


class BoundsTable(StartsTable):
    """Highest and lowest response over the start states of the contacts, beside the response itself."""

    objective: Annotated[
        Literal["amplitude", "loss_factor", "peak"], Field(description="what is bounded: at each frequency, or at the resonance")
    ] = "amplitude"
    points: Annotated[int, Field(ge=2, le=MOST, description="frequencies over the band")] = 25
    cloud: Annotated[int, Field(ge=0, le=MOST, description="start states sampled at each frequency")] = 60
    starts: Annotated[int, Field(ge=0, le=MOST, description="how many of them begin a search")] = 3


class SamplesTable(StartsTable):
    """Responses from many start states instead of one."""

    count: Annotated[int, Field(ge=1, le=MOST, description="start states; the first is virgin unless `law` is given")] = 20
    method: Annotated[Literal["latin", "random", "corners"], Field(description="how they are drawn")] = "latin"
    law: Annotated[
        str | None, Field(description="continuous distribution of scipy.stats that every variable follows; uniform unless given")
    ] = None
    parameters: Annotated[dict[str, Number], Field(description="of the law, by their names there: {a = 0.5, b = 0.5}")] = Field(
        default_factory=dict
    )
    points: Annotated[
        int | None, Field(ge=2, le=MOST, description="solve exactly at so many frequencies of the band, which percentiles need")
    ] = None


def law_of(table: SamplesTable) -> Law | None:
    """The law of the start variables, None for the uniform one."""
    if table.law is None and table.parameters:
        raise fault("parameters", "must go with a law", table.parameters)
    if table.law is not None and table.method == "corners":
        raise fault("method", "must be latin or random with a law", table.method, "Corners follow no law.")
    return None if table.law is None else named_law(table.law, table.parameters)


def samples_work(base: ForcedResponseWork, table: SamplesTable) -> SamplesWork:
    """The curves from sampled start states, where and as finely as the forced response would be."""
    work = SamplesWork(
        base.problem,
        frequencies=spread(base.frequencies, table.points) if table.points else base.frequencies,
        exactly=base.exactly or bool(table.points),
        levels=base.levels,
        rule=table.rule,
        share=table.share,
        harmonics=base.harmonics,
        samples=base.samples,
        measure=base.measure,
    )
    return work.of(draw(work.size, table.count, table.method, table.seed, law_of(table)))


def spread(ends: Sequence[float], points: int) -> tuple[float, ...]:
    """Frequencies in equal steps over a band, upwards."""
    return tuple(np.linspace(min(ends), max(ends), points).tolist())


def bounds_work(base: ForcedResponseWork, table: BoundsTable) -> BoundsWork:
    """The bounds over the band, or at the frequencies, of a forced response."""
    return BoundsWork(
        base.problem,
        frequencies=base.frequencies if base.exactly else spread(base.frequencies, table.points),
        levels=base.levels,
        objective=table.objective,
        output=0,
        cloud=table.cloud,
        starts=table.starts,
        rule=table.rule,
        share=table.share,
        seed=table.seed,
        harmonics=base.harmonics,
        samples=base.samples,
        measure=base.measure,
    )


@dataclass(frozen=True, eq=False)
class BoundsPlan(Plan):
    """The forced response and its bounds."""

    sweep: Sweep
    table: BoundsTable

    @classmethod
    def of(cls, asked: Asked) -> BoundsPlan:
        """The plan of a study; every key of its table has a default."""
        table, sweep = asked.tables.get("response_bounds", BoundsTable()), sweep_of(asked)
        refuse_discs(sweep.problem)
        return cls(sweep, BoundsTable.model_validate(table))

    @property
    def summary(self) -> str:
        return self.sweep.summary

    @cached_property
    def base(self) -> ForcedResponseWork:
        return self.sweep.forced_response()

    @cached_property
    def bounds(self) -> BoundsWork:
        return bounds_work(self.base, self.table)

    @property
    def works(self) -> Mapping[str, Work]:
        return {"": self.base, "bounds": self.bounds}

    def dataset(self, results: Mapping[str, Sequence[Arrays]]) -> xr.Dataset:
        return attached(self.base.gathered(results[""]).dataset, self.bounds.gathered(results["bounds"]))


@dataclass(frozen=True, eq=False)
class SamplesPlan(Plan):
    """Curves from sampled start states."""

    sweep: Sweep
    table: SamplesTable

    @classmethod
    def of(cls, asked: Asked) -> SamplesPlan:
        """The plan of a study; every key of its table has a default."""
        table = SamplesTable.model_validate(asked.tables.get("response_samples", SamplesTable()))
        sweep = sweep_of(asked)
        if table.points and isinstance(sweep.frequencies, tuple):
            raise InputError(
                "[response_samples]: points must go with a band, but [sweep] at lists the frequencies. Leave one out."
            )
        return cls(sweep, table)

    @property
    def summary(self) -> str:
        return self.sweep.summary

    @cached_property
    def base(self) -> ForcedResponseWork:
        return self.sweep.forced_response()

    @cached_property
    def works(self) -> Mapping[str, SamplesWork]:
        return {"samples": samples_work(self.base, self.table)}

    def dataset(self, results: Mapping[str, Sequence[Arrays]]) -> xr.Dataset:
        work = self.works["samples"]
        attributes = {"rule": rule_words(work.rule), "share": work.share, "harmonics_chosen": self.base.choice}
        return work.gathered(results["samples"], attributes).dataset


KINDS = {
    "response_bounds": Kind(BoundsPlan.of, {"response_bounds": BoundsTable}),
    "response_samples": Kind(SamplesPlan.of, {"response_samples": SamplesTable}, checks={"response_samples": law_of}),
}
