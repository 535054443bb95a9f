"""Bounds of the response over all start states in a study: the table [response_bounds]."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache, partial
from typing import Any

from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.variability.bounds import BoundsWork, attached, refuse_discs
from stickslip.runs.cases import Arrays, Work
from stickslip.study.analyses.forced_response import sweep_of
from stickslip.study.analysis import Asked, Kind, Works, summary_of, taken_over
from stickslip.study.contacts import RuleOrRules
from stickslip.study.fields import in_si, table_of
from stickslip.support.late import xr

BoundsTable = table_of(
    BoundsWork,
    "Highest and lowest response over the start states of the contacts, and the response itself.",
    checked=True,
    rule=RuleOrRules,
)


def plan(asked: Asked) -> Works:
    """The forced response and its bounds; every key of the table has a default."""
    sweep, settings = sweep_of(asked), in_si(asked.tables.get("response_bounds", BoundsTable()), asked.units)
    refuse_discs(sweep.problem)

    def works(base: ForcedResponseWork) -> dict[str, Work]:
        return {"": base, "bounds": BoundsWork(**taken_over(base), band=sweep.band, force=base.levels, **settings)}

    def gathered(works: Mapping[str, Any], arrays: Mapping[str, Sequence[Arrays]]) -> "xr.Dataset":
        return attached(works[""].gathered(arrays[""]).dataset, works["bounds"].gathered(arrays["bounds"]))

    base = cache(partial(ForcedResponseWork.of, replace(sweep, isolated=False)))
    return Works(lambda: works(base()), summary_of(sweep), gathered, on_mesh=lambda progress: works(base().with_shapes(progress)))


KIND = Kind(plan, {"response_bounds": BoundsTable}, optional=("response_bounds",), from_mesh=True)
