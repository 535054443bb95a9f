"""Controlled response in a study: the table [controlled_response], amplitudes that the force holds over the band of [sweep]."""

from typing import Annotated, Any, Literal

from pydantic import Field

from stickslip.analyses.controlled_response import ControlledResponseWork, HeldMotion
from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.study.analyses.forced_response import sweep_of
from stickslip.study.analysis import LEVELS_AND_PEAKS, Asked, Kind, Works, summary_of
from stickslip.study.fields import ACCELERATION, LENGTH, VELOCITY, Dimension, Positive, in_si, scaled, table_of
from stickslip.support.checks import counted, fault

Held = Literal["displacement", "velocity", "acceleration"]
DIMENSIONS: dict[Held, Dimension] = {"displacement": LENGTH, "velocity": VELOCITY, "acceleration": ACCELERATION}


TABLE = "controlled_response"
ControlledResponseTable = table_of(
    HeldMotion,
    "The force that holds the first harmonic of an output at given amplitudes, over the frequencies of [sweep].",
    checked=True,
    amplitude=Annotated[list[Positive], Field(min_length=1)],
    quantity=Held,
    output=(Annotated[str | None, Field(description="name of the output that is held; default: the first")], None),
)


def plan(asked: Asked) -> Works:
    """A curve for each held amplitude."""
    sweep, values = sweep_of(asked), in_si(asked.tables[TABLE], asked.units)
    if sweep.harmonics == "auto":
        raise fault("[sweep]: harmonics", "must be a number or a list for a controlled response", "auto")
    names = list(sweep.problem.output_names)
    if values["output"] not in (None, *names):
        raise fault(f"[{TABLE}]: output", f"must be one of {', '.join(names)}", values["output"])
    values["output"] = 0 if values["output"] is None else names.index(values["output"])
    values["amplitude"] = scaled(values["amplitude"], asked.units.factor(DIMENSIONS[values["quantity"]]))
    base = ForcedResponseWork.of(sweep)
    fineness: dict[str, Any] = {"harmonics": base.harmonics, "samples": base.samples}
    work = ControlledResponseWork(sweep.problem, sweep.band, **values, **fineness)
    held = counted(len(work.amplitudes), "held amplitude")
    return Works(work, f"{summary_of(sweep, with_levels=False)}; {held} of the {work.quantity} of {names[work.output]}")


KIND = Kind(plan, {TABLE: ControlledResponseTable}, repeats=True, without=LEVELS_AND_PEAKS)
