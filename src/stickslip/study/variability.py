"""Response variability in a study: the tables [bounds] and [samples], the work they ask for, and the dataset that comes of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field
from scipy import stats

from stickslip.analyses.bounds_dataset import attached
from stickslip.analyses.bounds_work import BoundsWork
from stickslip.analyses.cases import Arrays, Work
from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.response_samples import SamplesWork
from stickslip.analyses.start_draws import draw
from stickslip.study.fields import Positive, Table, Words
from stickslip.units import Band

if TYPE_CHECKING:
    import xarray as xr

Shape = Annotated[list[Positive], Field(min_length=2, max_length=2), Words("pair of numbers")]


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

    count: Annotated[int, Field(ge=1, description="start states; the first is virgin unless `beta` is given")] = 20
    method: Annotated[Literal["latin", "random", "corners"], Field(description="how they are drawn")] = "latin"
    beta: Annotated[
        Shape | None, Field(description="[a, b]: every variable follows a beta law on [-1, 1]; uniform unless given")
    ] = None


def samples_work(base: ForcedResponseWork, table: SamplesTable) -> SamplesWork:
    """The curves from drawn start states, where and as finely as the forced response would be."""
    settings = (base.problem, base.frequencies, base.exactly, base.levels, table.rule, table.share, base.harmonics, base.samples)
    size = SamplesWork(*settings, np.empty((0, 0))).space_at(base.levels[0]).size
    law = None if table.beta is None else stats.beta(*table.beta)
    return SamplesWork(*settings, draw(size, table.count, table.method, table.seed, law))


def bounds_work(base: ForcedResponseWork, table: BoundsTable) -> BoundsWork:
    """The bounds over the band, or at the frequencies, of a forced response."""
    band = Band(*base.frequencies) if not base.exactly else None
    frequencies = base.frequencies if band is None else tuple(np.linspace(band.low, band.high, table.points).tolist())
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
