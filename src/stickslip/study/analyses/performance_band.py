"""The band of a performance curve over the start states in a study: the table [performance_band]."""

from functools import cache
from typing import Annotated

from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.performance.curve import BandSettings, band_dataset
from stickslip.analyses.variability.bounds import refuse_discs
from stickslip.study.analyses.performance_curve import Points, RatiosTable, at_ratios, sweep_over_a_band
from stickslip.study.analysis import Asked, Kind, Works, summary_of, taken_over
from stickslip.study.contacts import RuleOrRules
from stickslip.study.fields import FORCE, Positive, table_of
from stickslip.study.tables import Ends

BandTable = table_of(
    BandSettings,
    "The lowest and the highest resonance over all start states of the contacts, against F_C/F_E.",
    RatiosTable,
    force_ratio=Ends,
    pull=Annotated[Positive | None, FORCE],
    rule=RuleOrRules,
    points=(Points, 6),
)


def plan(asked: Asked) -> Works:
    """The band of a performance curve over the start states."""
    sweep = sweep_over_a_band(asked)
    refuse_discs(sweep.problem)
    given = at_ratios(asked.tables["performance_band"], asked.units) | {"band": sweep.band}

    @cache
    def settings() -> BandSettings:
        return BandSettings(**taken_over(ForcedResponseWork.of(sweep)), **given)

    low, *_, high = ratios = given["force_ratio"]
    summary = f"{summary_of(sweep)}; band of the performance curve at {len(ratios)} F_C/F_E, {low:g} to {high:g}"
    return Works(lambda: settings().bounds, summary, lambda _, arrays: band_dataset(settings(), arrays))


KIND = Kind(plan, {"performance_band": BandTable}, without=("force_levels", "peak_tolerance"))
