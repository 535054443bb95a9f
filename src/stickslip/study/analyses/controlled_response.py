"""Controlled response in a study: the table [controlled_response], amplitudes that the force holds over the band of [sweep]."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from stickslip.analyses.controlled_response import ControlledResponseWork
from stickslip.checks import counted, fault, unique
from stickslip.runs.work import Arrays, Work
from stickslip.study.analyses.forced_response import sweep_of
from stickslip.study.analysis import Asked, Kind, Plan, Sweep
from stickslip.study.fields import Positive, Table
from stickslip.study.units import ACCELERATION, LENGTH, VELOCITY, Dimension, scaled
from stickslip.units import Band

if TYPE_CHECKING:
    import xarray as xr

Held = Literal["displacement", "velocity", "acceleration"]
DIMENSIONS: dict[Held, Dimension] = {"displacement": LENGTH, "velocity": VELOCITY, "acceleration": ACCELERATION}


class ControlledResponseTable(Table):
    """The force that holds the first harmonic of an output at given amplitudes, over the frequencies of [sweep]."""

    amplitude: Annotated[
        list[Positive],
        Field(min_length=1, description="held amplitudes: length, length/time or length/time², in the units of the study"),
    ]
    quantity: Annotated[Held, Field(description="what of the output is held")] = "acceleration"
    output: Annotated[str | None, Field(description="name of the output that is held; the first unless given")] = None


def different(table: ControlledResponseTable) -> None:
    """What the model of the table cannot check."""
    unique("amplitude", table.amplitude)


@dataclass(frozen=True, eq=False)
class ControlledResponsePlan(Plan):
    """A curve for each held amplitude."""

    sweep: Sweep
    table: ControlledResponseTable
    output: int

    @classmethod
    def of(cls, asked: Asked) -> ControlledResponsePlan:
        """The plan of a study."""
        sweep, table = sweep_of(asked), ControlledResponseTable.model_validate(asked.tables["controlled_response"])
        if sweep.harmonics == "auto":
            raise fault("[sweep]: harmonics", "must be a number or a list for a controlled response", "auto")
        names = list(sweep.problem.output_names)
        if table.output is not None and table.output not in names:
            raise fault("[controlled_response]: output", f"must be one of {', '.join(names)}", table.output)
        table = table.model_copy(update={"amplitude": scaled(table.amplitude, asked.units.factor(DIMENSIONS[table.quantity]))})
        return cls(sweep, table, 0 if table.output is None else names.index(table.output))

    @property
    def summary(self) -> str:
        held = counted(len(self.table.amplitude), "held amplitude")
        name = self.sweep.problem.output_names[self.output]
        return f"{self.sweep.summary}; {held} of the {self.table.quantity} of {name}"

    @cached_property
    def work(self) -> ControlledResponseWork:
        sweep, table = self.sweep, self.table
        where = sweep.frequencies if isinstance(sweep.frequencies, Band) else list(sweep.frequencies)
        base = sweep.forced_response()
        return ControlledResponseWork.of(
            sweep.problem,
            band=where,
            amplitude=table.amplitude,
            output=self.output,
            quantity=table.quantity,
            harmonics=base.harmonics,
            samples=base.samples,
        )

    @property
    def works(self) -> Mapping[str, Work]:
        return {"": self.work}

    def dataset(self, results: Mapping[str, Sequence[Arrays]]) -> xr.Dataset:
        return self.work.gathered(results[""]).dataset


TABLE = "controlled_response"
KINDS = {
    TABLE: Kind(
        ControlledResponsePlan.of,
        {TABLE: ControlledResponseTable},
        required=(TABLE,),
        checks={TABLE: different},
        repeats=True,
        forced=False,
    )
}
