"""Prediction of a free decay from an identification in a study: the tables [response_identification] and [decay_prediction]."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from stickslip.laboratory.identification.response.decay_prediction import DecayPredictionWork, windows_between
from stickslip.laboratory.identification.response.result import ResponseIdentification
from stickslip.laboratory.measurement.decay import MeasuredDecay, read_decay
from stickslip.results.files import open_results
from stickslip.results.schema import analysis_of
from stickslip.study.fields import LENGTH
from stickslip.study.prediction import PredictionPlan, PredictionTable
from stickslip.study.tables import Ends
from stickslip.support.checks import MOST, between, counted, existing, fault


class DecayPredictionTable(PredictionTable):
    """A free decay that was not measured, from the identification of [response_identification], with 95 % intervals."""

    amplitude: Annotated[Ends | None, LENGTH] = None
    """[smallest, largest] amplitude of the displacement; default: those of the decays to compare with"""
    mode: Annotated[int | None, Field(ge=1, le=MOST)] = None
    """stuck mode that decays, 1 the lowest; default: that of the first compared decay, or that of the peaks"""
    compare: list[str] = Field(default_factory=list)
    """measured decays to compare with: results of `stickslip decay`, or recorded signals"""

    def check(self) -> None:
        """Amplitudes, or decays that say them."""
        if self.amplitude is None and not self.compare:
            raise fault("amplitude", "must be given, or decays to compare with", "none")
        if self.amplitude is not None and not self.amplitude[0] < self.amplitude[1]:
            raise fault("amplitude", "must be [smallest, largest], the smaller first", list(self.amplitude))


TABLE = "decay_prediction"


@dataclass(frozen=True, eq=False)
class DecayPredictionPlan(PredictionPlan):
    """An identification, carried out or read, and the prediction of a decay from it."""

    table: DecayPredictionTable
    name, form = TABLE, DecayPredictionTable

    @property
    def what(self) -> str:
        beside = f" beside {counted(len(self.table.compare), 'measured one')}" if self.table.compare else ""
        return f"free decay{beside}"

    @cached_property
    def measured(self) -> list[MeasuredDecay]:
        """The decays to compare with."""
        return [_decay(self.base.folder / file) for file in self.table.compare]

    @property
    def ends(self) -> tuple[float, float]:
        """The smallest and the largest amplitude, m."""
        if self.table.amplitude is not None:
            return self.table.amplitude[0], self.table.amplitude[1]
        sizes = [one.dataset["amplitude"].values for one in self.measured]
        return min(float(one.min()) for one in sizes), max(float(one.max()) for one in sizes)

    def check(self, held: bool, quantity: str) -> None:
        """Refuse a mode that the structure does not have, decays that cannot be read, and those at other amplitudes."""
        if self.table.mode is not None:
            between("mode", self.table.mode, 1, self.base.sweep.problem.structure.size)
        for decay in self.measured:
            windows_between(decay.dataset, *self.ends)

    def prediction(self, identified: ResponseIdentification) -> DecayPredictionWork:
        """The work of the prediction."""
        frequency = None
        if self.table.mode is None and self.measured:
            first = self.measured[0].dataset
            frequency = float(first["frequency"].values[int(np.argmin(first["amplitude"].values))])
        mode: dict[str, Any] = {"mode": self.table.mode, "frequency": frequency}
        return DecayPredictionWork(identified, self.ends, **mode, band=self.band, **self.about_draws)


def _decay(path: Path) -> MeasuredDecay:
    """A measured decay, from results of `stickslip decay` or from a recorded signal."""
    if not path.is_dir() and path.suffix != ".nc":
        existing(f"[{TABLE}]: compare", [path])
        return read_decay(path, name=path.stem)
    dataset = open_results(path)
    if analysis_of(dataset) != "measured_decay":
        rule = "must be results of `stickslip decay`, or recorded signals"
        raise fault(f"[{TABLE}]: compare", rule, f"{path.name}, results of {analysis_of(dataset)}")
    return MeasuredDecay(dataset)


KIND = DecayPredictionPlan.kind()
