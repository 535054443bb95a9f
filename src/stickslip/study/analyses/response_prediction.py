"""Prediction from an identification in a study: the tables [response_identification] and [response_prediction]."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field

from stickslip.laboratory.identification.response.prediction import FEWEST_DRAWS, ResponsePredictionWork
from stickslip.laboratory.identification.response.prediction_result import level_of
from stickslip.laboratory.identification.response.result import ResponseIdentification
from stickslip.laboratory.measurement.measured_response import MeasuredResponse
from stickslip.results.files import open_results
from stickslip.results.schema import analysis_of, stamped
from stickslip.runs.cases import all_cases
from stickslip.runs.work import Arrays, Checkpoint, Progress, Work, Workers
from stickslip.study.analyses.response_identification import TABLE as IDENTIFICATION
from stickslip.study.analyses.response_identification import (
    ColumnName,
    ResponseIdentificationPlan,
    ResponseIdentificationTable,
    free_parameters,
    known_settings,
    measured_curves,
)
from stickslip.study.analysis import Asked, Kind, Plan
from stickslip.study.fields import Column, Number, Positive, Seed, Table
from stickslip.support.checks import MOST, counted, fault
from stickslip.support.units import Band

if TYPE_CHECKING:
    import xarray as xr


class ResponsePredictionTable(Table):
    """Responses that were not measured, from the identification of [response_identification], with 95 % intervals."""

    identification: Annotated[
        str | None,
        Field(description="results.nc of the identification, or its folder; without it, the identification is carried out first"),
    ] = None
    force: Annotated[list[Positive], Field(description="force levels, N")] = Field(default_factory=list)
    amplitude: Annotated[
        list[Positive], Field(description="held amplitudes of the measured quantity in place of forces, m, m/s or m/s2")
    ] = Field(default_factory=list)
    settings: Annotated[
        dict[str, Number], Field(description="{ name = value } of what differs from test to test, for the prediction")
    ] = Field(default_factory=dict)
    start_states: Annotated[
        Literal["identified", "virgin", "any"],
        Field(description="of the contacts: as in the identification, all virgin, or any, drawn anew for each draw"),
    ] = "identified"
    draws: Annotated[int, Field(ge=FEWEST_DRAWS, le=MOST, description="of the parameters, for the intervals")] = 40
    seed: Annotated[Seed, Field(description="of the draws")] = 0
    compare: Annotated[
        list[str],
        Field(description="files of measured curves to compare with; their levels are predicted too unless levels are given"),
    ] = Field(default_factory=list)
    compare_force: Annotated[
        list[Positive], Field(description="force of each of these curves, N, or one for all, where no column says it")
    ] = Field(default_factory=list)
    columns: Annotated[
        dict[ColumnName, Column],
        Field(description="of these files, if they differ from those of the identification, which are the default"),
    ] = Field(default_factory=dict)
    column_units: Annotated[dict[ColumnName, str], Field(description="units of these columns")] = Field(default_factory=dict)
    by: Annotated[
        Column | None, Field(description="column that distinguishes the curves of one of these files; that of the identification")
    ] = None


TABLE = "response_prediction"


def checked(table: ResponsePredictionTable) -> None:
    """One kind of levels, or tests that say them."""
    if bool(table.force) + bool(table.amplitude) != 1 and not (table.compare and not table.force and not table.amplitude):
        rule = "must be given, or amplitude, or files to compare with, and not both"
        raise fault("force", rule, table.force, "Such as force = [1.0, 5.0].")
    if not table.compare and (table.compare_force or table.columns or table.column_units or table.by is not None):
        raise fault("compare_force, columns, column_units and by", "must go with files to compare", "none")


@dataclass(frozen=True, eq=False)
class ResponsePredictionPlan(Plan):
    """An identification, carried out or read, and the prediction from it."""

    base: ResponseIdentificationPlan
    table: ResponsePredictionTable

    @classmethod
    def of(cls, asked: Asked) -> ResponsePredictionPlan:
        """The plan of a study."""
        table = ResponsePredictionTable.model_validate(asked.tables[TABLE])
        base = ResponseIdentificationPlan.of(asked)
        known_settings(f"[{TABLE}]", table.settings, base.table, asked.rig[0])
        return cls(base, table)

    @property
    def content(self) -> str:
        """Identifies the curves and the results that the study names, as far as they exist."""
        names = [self.table.identification] if self.table.identification else []
        files = [self.base.folder / name for name in (*names, *self.table.compare)]
        files = [file / "results.nc" if file.is_dir() else file for file in files]
        digest = sha256(b"".join(file.read_bytes() for file in files if file.is_file()))
        return digest.hexdigest() + ("" if names else self.base.content)

    @property
    def summary(self) -> str:
        levels = self.table.force or self.table.amplitude
        what = counted(len(levels), "level") if levels else "the levels of the compared curves"
        how = "from an identification" if self.table.identification else f"from {self.base.summary}"
        return f"{what}, {counted(self.table.draws, 'draw')}, {how}"

    @cached_property
    def tests(self) -> list[MeasuredResponse]:
        """The curves to compare with."""
        table, base = self.table, self.base.table
        if not table.compare:
            return []
        own: dict[str, Any] = {"files": table.compare, "force": table.compare_force, "settings": []}
        own |= {"columns": table.columns} if table.columns else {}
        own |= {"column_units": table.column_units} if table.column_units else {}
        own |= {"by": table.by} if table.by is not None else {}
        return measured_curves(base.model_copy(update=own), self.base.folder)

    @cached_property
    def identified(self) -> ResponseIdentification | None:
        """The identification whose results the study names."""
        if self.table.identification is None:
            return None
        return self._from(open_results(self.base.folder / self.table.identification))

    def _from(self, dataset: xr.Dataset) -> ResponseIdentification:
        """The identification of a dataset, with the problem of its study; another result is refused."""
        if analysis_of(dataset) != IDENTIFICATION:
            raise fault(f"[{TABLE}]: identification", f"must be the results of {IDENTIFICATION}", analysis_of(dataset))
        return ResponseIdentification(dataset, self.base.problem_of(*self.table.settings), ())

    def prediction(self, identified: ResponseIdentification) -> ResponsePredictionWork:
        """The work of the prediction."""
        table, held = self.table, str(identified.dataset.attrs["held"]) == "response"
        force, amplitude = list(table.force), list(table.amplitude)
        if not force and not amplitude:
            found = list(dict.fromkeys(level_of(test, held) for test in self.tests))
            force, amplitude = ([], found) if held else (found, [])
        where = self.base.sweep.frequencies
        band = Band(min(where), max(where))
        settings: dict[str, Any] = {name: getattr(table, name) for name in ("settings", "start_states", "draws", "seed")}
        return ResponsePredictionWork(identified, force, amplitude=amplitude, band=band, **settings)

    @cached_property
    def works(self) -> Mapping[str, Work]:
        identified = self.identified
        return {"": self.base.work if identified is None else self.prediction(identified)}

    def dataset(self, results: Mapping[str, Sequence[Arrays]]) -> xr.Dataset:
        """Of a prediction whose identification is read."""
        work = self.works[""]
        if not isinstance(work, ResponsePredictionWork):
            raise AssertionError("a prediction whose identification is carried out is searched")
        return self._compared(work, results[""])

    def searched(
        self, results: Mapping[str, Sequence[Arrays]], checkpoint: Checkpoint, workers: Workers, progress: Progress
    ) -> xr.Dataset:
        """The prediction, from the identification that was carried out or read."""
        if self.identified is not None:
            return self.dataset(results)
        work = self.prediction(self._from(stamped(self.base.dataset(results), IDENTIFICATION)))
        return self._compared(work, all_cases(work, checkpoint, workers, progress))

    def _compared(self, work: ResponsePredictionWork, results: Sequence[Arrays]) -> xr.Dataset:
        found = work.gathered(results)
        return (found.compare(self.tests) if self.tests else found).dataset


KINDS = {
    TABLE: Kind(
        ResponsePredictionPlan.of,
        {IDENTIFICATION: ResponseIdentificationTable, TABLE: ResponsePredictionTable},
        required=(IDENTIFICATION, TABLE),
        checks={IDENTIFICATION: free_parameters, TABLE: checked},
        without=("force_levels", "tolerance", "peak_tolerance", "quantity", "measure"),
    )
}
"""Files are read when the work begins."""
