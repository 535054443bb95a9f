"""Prediction of responses from an identification in a study: the tables [response_identification] and [response_prediction]."""

from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

from pydantic import Field

from stickslip.laboratory.identification.response.prediction import ResponsePredictionWork, one_kind_of_level
from stickslip.laboratory.identification.response.prediction_result import level_for, level_of, points_in_band
from stickslip.laboratory.identification.response.result import ResponseIdentification
from stickslip.laboratory.measurement.measured_response import MeasuredResponse
from stickslip.study.analyses.response_identification import (
    ColumnName,
    measured_curves,
)
from stickslip.study.fields import Column, Positive
from stickslip.study.prediction import PredictionPlan, PredictionTable
from stickslip.support.checks import InputError, counted, fault, unique


class ResponsePredictionTable(PredictionTable):
    """Responses that were not measured, from the identification of [response_identification], with 95 % intervals."""

    force: Annotated[list[Positive], Field(description="force levels, N")] = Field(default_factory=list)
    amplitude: list[Positive] = Field(default_factory=list)
    """held amplitudes of the measured quantity in place of forces, m, m/s or m/s2"""
    compare: list[str] = Field(default_factory=list)
    """files of measured curves to compare with; their levels are predicted too unless levels are given"""
    compare_force: list[Positive] = Field(default_factory=list)
    """force of each of these curves, N, or one for all, if no column states it"""
    columns: dict[ColumnName, Column] = Field(default_factory=dict)
    """columns of these files; default: those of the identification"""
    column_units: Annotated[dict[ColumnName, str], Field(description="units of these columns")] = Field(default_factory=dict)
    by: Column | None = None
    """column that distinguishes the curves of one of these files; default: that of the identification"""

    def check(self) -> None:
        """One kind of levels, or tests that say them."""
        if self.force or self.amplitude or not self.compare:
            one_kind_of_level(self.force, self.amplitude, files=True)
        unique("force", self.force)
        unique("amplitude", self.amplitude)
        if not self.compare and (self.compare_force or self.columns or self.column_units or self.by is not None):
            raise fault("compare_force, columns, column_units and by", "must go with files to compare", "none")


TABLE = "response_prediction"


@dataclass(frozen=True, eq=False)
class ResponsePredictionPlan(PredictionPlan):
    """An identification, carried out or read, and the prediction of responses from it."""

    table: ResponsePredictionTable
    name, form = TABLE, ResponsePredictionTable

    @property
    def what(self) -> str:
        levels = self.table.force or self.table.amplitude
        return counted(len(levels), "level") if levels else "the levels of the compared curves"

    @cached_property
    def measured(self) -> list[MeasuredResponse]:
        """The curves to compare with."""
        table, base = self.table, self.base.table
        if not table.compare:
            return []
        own: dict[str, Any] = {"files": table.compare, "force": table.compare_force, "settings": []}
        own |= {"columns": table.columns} if table.columns else {}
        own |= {"column_units": table.column_units} if table.column_units else {}
        own |= {"by": table.by} if table.by is not None else {}
        table_of_tests = base.model_copy(update=own)
        try:
            return measured_curves(table_of_tests, self.base.folder)
        except InputError:
            # Curves of another quantity than the stated one lack its column: what is wrong is the quantity.
            with suppress(InputError):
                return measured_curves(table_of_tests.model_copy(update={"quantity": None}), self.base.folder)
            raise

    def levels(self, held: bool) -> tuple[list[float], list[float]]:
        """Forces and held amplitudes, of which one is empty; without either those of the curves to compare with. held: whether
        the response was held in the identification."""
        if self.table.force or self.table.amplitude:
            return list(self.table.force), list(self.table.amplitude)
        found = list(dict.fromkeys(level_of(test, held) for test in self.measured))
        return ([], found) if held else (found, [])

    def check(self, held: bool, quantity: str) -> None:
        """Refuse curves to compare with that are of another quantity, or at no predicted level, or beside the band."""
        force, amplitude = self.levels(held)
        for test in self.measured:
            level_for(test, amplitude or force, bool(amplitude), quantity)
            points_in_band(test, self.band.low, self.band.high)

    def prediction(self, identified: ResponseIdentification) -> ResponsePredictionWork:
        """The work of the prediction."""
        force, amplitude = self.levels(str(identified.dataset.attrs["held"]) == "response")
        return ResponsePredictionWork(identified, force, amplitude=amplitude, band=self.band, **self.about_draws)


KIND = ResponsePredictionPlan.kind()
