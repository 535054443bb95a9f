"""Stepped sine in a study: the table [stepped_sine], over the frequencies of [sweep], and the harmonic balance beside it."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.stepped_sine import SteppedSineWork, beside_balance
from stickslip.runs.cases import Arrays
from stickslip.study.analyses.forced_response import sweep_of
from stickslip.study.analysis import Asked, Kind, Works
from stickslip.study.fields import table_of, values_of
from stickslip.support.checks import counted, fault
from stickslip.support.late import xr

TABLE = "stepped_sine"

COUNT = 41
"""Frequencies of a band unless a study says how many."""

STEADY = "steady"
"""The work of the harmonic balance, by its name among those of the plan."""

SteppedSineTable = table_of(
    SteppedSineWork,
    "A test whose excitation dwells at one frequency after the other, from rest, integrated in time.",
    checked=True,
    count=(
        Annotated[
            int | None,
            Field(ge=2, le=100_000, description=f"number of frequencies, equally spaced over the band; default: {COUNT}"),
        ],
        None,
    ),
    back=(
        Annotated[bool, Field(description="whether the test returns from the last frequency through all others to the first")],
        False,
    ),
    balance=(
        Annotated[bool, Field(description="whether the harmonic balance is solved at the same frequencies, for comparison")],
        True,
    ),
)


def plan(asked: Asked) -> Works:
    """The dwells, and the steady response beside them."""
    table, sweep = asked.tables[TABLE], sweep_of(asked)
    count, back, balance = (getattr(table, key) for key in ("count", "back", "balance"))
    if sweep.listed and count is not None:
        raise fault(f"[{TABLE}]: count", "needs a band, but [sweep] lists its frequencies (`at`)", count)
    f = sweep.frequencies
    forth = list(f) if sweep.listed else np.linspace(f[0], f[-1], COUNT if count is None else count).tolist()
    order = forth + forth[-2::-1] if back else forth
    work = SteppedSineWork(sweep.problem, order, **values_of(SteppedSineWork, table))
    summary = f"stepped sine in time, {counted(work.dwell, 'period')} at each of {len(work.frequencies)} frequencies"
    if not balance:
        return Works(work, summary)
    steady = ForcedResponseWork.of(replace(sweep, band=order, force=work.force))
    return Works({"": work, STEADY: steady}, f"{summary}, compared with the harmonic balance", _beside)


def _beside(works: Mapping[str, Any], arrays: Mapping[str, Sequence[Arrays]]) -> "xr.Dataset":
    dwells, steady = (works[name].gathered(arrays[name]).dataset for name in ("", STEADY))
    return beside_balance(dwells, steady)


KIND = Kind(plan, {TABLE: SteppedSineTable}, repeats=True, without=("force_levels", "peak_tolerance", "quantity", "measure"))
