"""Response variability in a study: the tables [bounds] and [samples], the work they ask for, and the dataset that comes of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field

from stickslip.analyses.bounds_dataset import attached
from stickslip.analyses.bounds_work import BoundsWork
from stickslip.analyses.cases import Arrays, Work
from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.response_samples import SamplesWork
from stickslip.analyses.start_draws import Law, draw, named_law
from stickslip.checks import fault
from stickslip.study.fields import Number, Table

if TYPE_CHECKING:
    import xarray as xr


class StartsTable(Table):
    """What the variables of the start states are."""

    rule: Annotated[
        Literal["slider_offset", "traction_ratio", "mean_traction"], Field(description="what a start variable sets")
    ] = "slider_offset"
    share: Annotated[
        Literal["element", "direction", "contact", "all"], Field(description="which friction elements have one in common")
    ] = "element"
    seed: Annotated[int, Field(ge=0, description="of the random draws")] = 0


class BoundsTable(StartsTable):
    """Highest and lowest response over the start states of the contacts, beside the response itself."""

    objective: Annotated[
        Literal["amplitude", "loss_factor", "peak"], Field(description="what is bounded: at each frequency, or at the resonance")
    ] = "amplitude"
    points: Annotated[int, Field(ge=2, description="frequencies over the band")] = 25
    cloud: Annotated[int, Field(ge=0, description="start states sampled at each frequency")] = 60
    starts: Annotated[int, Field(ge=0, description="how many of them begin a search")] = 3


class SamplesTable(StartsTable):
    """Responses from many start states instead of one."""

    count: Annotated[int, Field(ge=1, description="start states; the first is virgin unless `law` is given")] = 20
    method: Annotated[Literal["latin", "random", "corners"], Field(description="how they are drawn")] = "latin"
    law: Annotated[
        str | None, Field(description="continuous distribution of scipy.stats that every variable follows; uniform unless given")
    ] = None
    parameters: Annotated[dict[str, Number], Field(description="of the law, by their names there: {a = 0.5, b = 0.5}")] = Field(
        default_factory=dict
    )
    points: Annotated[
        int | None, Field(ge=2, description="solve exactly at so many frequencies of the band, which percentiles need")
    ] = None


def law_of(table: SamplesTable) -> Law | None:
    """The law of the start variables, None for the uniform one."""
    if table.law is None and table.parameters:
        raise fault("parameters", "must go with a law", table.parameters)
    return None if table.law is None else named_law(table.law, table.parameters)


def samples_work(base: ForcedResponseWork, table: SamplesTable) -> SamplesWork:
    """The curves from drawn start states, where and as finely as the forced response would be."""
    where = (spread(base.frequencies, table.points), True) if table.points else (base.frequencies, base.exactly)
    settings = (base.problem, *where, base.levels, table.rule, table.share, base.harmonics, base.samples)
    size = SamplesWork(*settings, np.empty((0, 0))).space_at(base.levels[0]).size
    return SamplesWork(*settings, draw(size, table.count, table.method, table.seed, law_of(table)))


def spread(ends: Sequence[float], points: int) -> tuple[float, ...]:
    """Frequencies in equal steps over a band, upwards."""
    return tuple(np.linspace(min(ends), max(ends), points).tolist())


def bounds_work(base: ForcedResponseWork, table: BoundsTable) -> BoundsWork:
    """The bounds over the band, or at the frequencies, of a forced response."""
    frequencies = base.frequencies if base.exactly else spread(base.frequencies, table.points)
    search = (table.cloud, table.starts, table.rule, table.share, table.seed)
    return BoundsWork(base.problem, frequencies, base.levels, table.objective, 0, *search, base.harmonics, base.samples)


def works_of(base: ForcedResponseWork, table: BoundsTable | SamplesTable | None) -> dict[str, Work]:
    """The works of one job by kind; "" is the forced response itself."""
    if isinstance(table, SamplesTable):
        return {"samples": samples_work(base, table)}
    works: dict[str, Work] = {"": base}
    return works if table is None else works | {"bounds": bounds_work(base, table)}


def dataset_of(works: Mapping[str, Work], results: Mapping[str, Sequence[Arrays]]) -> xr.Dataset:
    """The dataset of the results of all works of a job."""
    if isinstance(samples := works.get("samples"), SamplesWork):
        attrs = {"rule": samples.rule, "share": samples.share}
        return samples.gathered(results["samples"], attrs).dataset
    response, bounds = works[""], works.get("bounds")
    if not isinstance(response, ForcedResponseWork):
        raise TypeError(type(response).__name__)
    dataset = response.gathered(results[""]).dataset
    return attached(dataset, bounds.gathered(results["bounds"])) if isinstance(bounds, BoundsWork) else dataset
