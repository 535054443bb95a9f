"""Responses from many start states in a study: the table [response_samples]."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache, partial
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.variability.samples import Law, SamplesWork, named_law
from stickslip.runs.cases import Arrays
from stickslip.study.analyses.forced_response import sweep_of
from stickslip.study.analysis import Asked, Kind, Works, summary_of, taken_over
from stickslip.study.contacts import RuleOrRules
from stickslip.study.fields import Number, Table, in_si, table_of
from stickslip.support.checks import MOST, InputError, fault
from stickslip.support.late import xr
from stickslip.support.units import Band

LawName = Annotated[
    str | None, Field(description="continuous distribution of scipy.stats that every variable follows; default: uniform")
]
LawParameters = Annotated[
    dict[str, Number], Field(description="parameters of `law`, by their names in scipy.stats: {a = 0.5, b = 0.5}")
]
Points = Annotated[
    int | None, Field(ge=2, le=MOST, description="number of frequencies in the band to solve exactly, as percentiles require")
]


class DrawnTable(Table):
    """Start states that are drawn."""

    def check(self) -> None:
        """A law and its parameters, and a method that follows it."""
        law_of(self)


SamplesTable = table_of(
    SamplesWork,
    "Responses from many start states instead of one.",
    DrawnTable,
    checked=True,
    count=Annotated[int, Field(ge=1, le=MOST)],
    rule=RuleOrRules,
    law=(LawName, None),
    parameters=(LawParameters, Field(default_factory=dict)),
    points=(Points, None),
)


def law_of(table: Any) -> Law | None:
    """The law of the start variables, None for the uniform one."""
    if table.law is None and table.parameters:
        raise fault("parameters", "must go with a law", table.parameters)
    if table.law is not None and table.method == "corners":
        raise fault("method", "must be latin or random with a law", table.method, "Corners follow no law.")
    return None if table.law is None else named_law(table.law, table.parameters)


def plan(asked: Asked) -> Works:
    """Curves from sampled start states; every key of the table has a default."""
    table, sweep = asked.tables.get("response_samples", SamplesTable()), sweep_of(asked)
    given = in_si(table, asked.units)
    if given["points"] and sweep.listed:
        raise InputError("[response_samples]: points needs a band, but [sweep] at lists the frequencies. Leave one out.")
    settings = {name: given[name] for name in ("method", "rule", "share", "seed")}
    settings |= {"starts": given["count"], "distribution": law_of(table)}
    base = cache(partial(ForcedResponseWork.of, replace(sweep, isolated=False)))

    def work(base: ForcedResponseWork) -> SamplesWork:
        where = sweep.band
        if given["points"] and isinstance(where, Band):
            where = np.linspace(where.low, where.high, given["points"]).tolist()
        return SamplesWork(**taken_over(base), band=where, force=base.levels, **settings)

    def gathered(work: SamplesWork, arrays: Sequence[Arrays]) -> "xr.Dataset":
        return work.gathered(arrays).dataset.assign_attrs(harmonics_chosen=base().choice)

    return Works(lambda: work(base()), summary_of(sweep), gathered, on_mesh=lambda progress: work(base().with_shapes(progress)))


KIND = Kind(plan, {"response_samples": SamplesTable}, optional=("response_samples",), without=("peak_tolerance",), from_mesh=True)
