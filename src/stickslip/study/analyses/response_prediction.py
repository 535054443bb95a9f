"""Prediction from an identification in a study: the tables [response_identification] and [response_prediction]."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field

from stickslip.laboratory.identification.response.prediction import (
    FEWEST_DRAWS,
    ResponsePredictionWork,
    one_kind_of_level,
    settings_beside,
)
from stickslip.laboratory.identification.response.prediction_result import level_for, level_of, points_in_band
from stickslip.laboratory.identification.response.result import ResponseIdentification
from stickslip.laboratory.measurement.measured_response import MeasuredResponse, listed
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
from stickslip.study.renamed import with_new_names
from stickslip.support.checks import MOST, InputError, counted, fault, unique
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
NOT_OF_THE_PROBLEM = ("sweep.frequency", "sweep.at")
"""Settings in which a prediction may differ from its identification."""
LISTED = 4
"""Differences that an error lists."""


def checked(table: ResponsePredictionTable) -> None:
    """One kind of levels, or tests that say them."""
    if table.force or table.amplitude or not table.compare:
        one_kind_of_level(table.force, table.amplitude, files=True)
    unique("force", table.force)
    unique("amplitude", table.amplitude)
    if not table.compare and (table.compare_force or table.columns or table.column_units or table.by is not None):
        raise fault("compare_force, columns, column_units and by", "must go with files to compare", "none")


@dataclass(frozen=True, eq=False)
class ResponsePredictionPlan(Plan):
    """An identification, carried out or read, and the prediction from it."""

    base: ResponseIdentificationPlan
    table: ResponsePredictionTable
    document: Mapping[str, Any]

    @classmethod
    def of(cls, asked: Asked) -> ResponsePredictionPlan:
        """The plan of a study."""
        table = ResponsePredictionTable.model_validate(asked.tables[TABLE])
        base = ResponseIdentificationPlan.of(asked)
        known_settings(f"[{TABLE}]", table.settings, base.table, asked.rig[0])
        return cls(base, table, asked.document)

    @property
    def reads(self) -> tuple[Path, ...]:
        """The results of the identification."""
        if self.table.identification is None:
            return ()
        place = self.base.folder / self.table.identification
        return (place / "results.nc" if place.is_dir() else place,)

    @property
    def content(self) -> str:
        """Identifies the curves and the results that the study names, as far as they exist."""
        files = (*self.reads, *(self.base.folder / name for name in self.table.compare))
        digest = sha256(b"".join(file.read_bytes() for file in files if file.is_file()))
        return digest.hexdigest() + ("" if self.reads else self.base.content)

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
        table_of_tests = base.model_copy(update=own)
        try:
            return measured_curves(table_of_tests, self.base.folder)
        except InputError:
            # Curves of another quantity than the stated one lack its column: what is wrong is the quantity.
            with suppress(InputError):
                return measured_curves(table_of_tests.model_copy(update={"quantity": None}), self.base.folder)
            raise

    @cached_property
    def identified(self) -> ResponseIdentification | None:
        """The identification whose results the study names."""
        if self.table.identification is None:
            return None
        return self._from(open_results(self.base.folder / self.table.identification))

    def _from(self, dataset: xr.Dataset) -> ResponseIdentification:
        """The identification of a dataset, with the problem of its study; another result or problem is refused."""
        what = f"[{TABLE}]: identification"
        if analysis_of(dataset) != IDENTIFICATION:
            raise fault(what, f"must be the results of {IDENTIFICATION}", analysis_of(dataset))
        free, identified = list(free_parameters(self.base.table)), list(json.loads(str(dataset.attrs.get("free", "{}"))))
        if sorted(free) != sorted(identified):
            raise fault(f"[{IDENTIFICATION}]", f"must leave free what was identified, {', '.join(identified)}", ", ".join(free))
        own = {*free, *self.table.settings, *(name for one in self.base.table.settings for name in one)}
        text = str(dataset.attrs.get("study", ""))
        if text and (found := differences(self.document, with_new_names(tomllib.loads(text))[0], own)):
            raise InputError(
                f"{what} must be of the problem of this study, but {listed(found)}. Make both the same, give what differs in the "
                "prediction in `settings`, or leave `identification` out: the study then identifies the parameters itself."
            )
        return ResponseIdentification(dataset, self.base.problem_of(*self.table.settings), ())

    def levels(self, held: bool) -> tuple[list[float], list[float]]:
        """Forces and held amplitudes, of which one is empty; without either those of the curves to compare with. held: whether
        the response was held in the identification."""
        if self.table.force or self.table.amplitude:
            return list(self.table.force), list(self.table.amplitude)
        found = list(dict.fromkeys(level_of(test, held) for test in self.tests))
        return ([], found) if held else (found, [])

    def check_tests(self, held: bool, quantity: str) -> None:
        """Refuse curves to compare with that are of another quantity, or at no predicted level, or beside the band."""
        force, amplitude = self.levels(held)
        where = self.base.sweep.frequencies
        for test in self.tests:
            level_for(test, amplitude or force, bool(amplitude), quantity)
            points_in_band(test, min(where), max(where))

    def prediction(self, identified: ResponseIdentification) -> ResponsePredictionWork:
        """The work of the prediction."""
        table, data = self.table, identified.dataset
        force, amplitude = self.levels(str(data.attrs["held"]) == "response")
        where = self.base.sweep.frequencies
        band = Band(min(where), max(where))
        settings: dict[str, Any] = {name: getattr(table, name) for name in ("settings", "start_states", "draws", "seed")}
        return ResponsePredictionWork(identified, force, amplitude=amplitude, band=band, **settings)

    @cached_property
    def works(self) -> Mapping[str, Work]:
        """What of the prediction is wrong is said before the identification is carried out."""
        identified = self.identified
        if identified is not None:
            data = identified.dataset
            self.check_tests(str(data.attrs["held"]) == "response", str(data["quantity"].values[0]))
            return {"": self.prediction(identified)}
        work = self.base.work
        settings_beside(self.base.table.settings, self.table.settings)
        self.check_tests(self.base.table.held == "response", work.tests[0].quantity)
        return {"": work}

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


def differences(here: Mapping[str, Any], there: Mapping[str, Any], aside: Collection[str]) -> list[str]:
    """What two studies differ in, of the problem and of how finely it is computed; aside: arguments of the rig that do not count.

    Names of files may lie in different folders.
    """
    stated, identified = (
        {key: value for key, value in _settings_in(each) if key not in NOT_OF_THE_PROBLEM} for each in (here, there)
    )
    found = []
    for key in dict.fromkeys((*stated, *identified)):
        one, other = stated.get(key), identified.get(key)
        same = one == other or (isinstance(one, str) and isinstance(other, str) and Path(one).name == Path(other).name)
        if not same and key not in {f"structure.parameters.{name}" for name in aside}:
            shown = ["not given" if each is None else repr(each) for each in (one, other)]
            found.append(f"{key} is {shown[0]} here and {shown[1]} in the identification")
    return found if len(found) <= LISTED else [*found[:LISTED], counted(len(found) - LISTED, "further difference")]


def _settings_in(document: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """The settings of a study by their keys, but for those of its analysis."""
    if isinstance(document, Mapping):
        for name, value in document.items():
            if key or name not in ("study", IDENTIFICATION, TABLE):
                yield from _settings_in(value, f"{key}.{name}" if key else name)
    elif isinstance(document, list) and any(isinstance(each, Mapping) for each in document):
        for number, each in enumerate(document, start=1):
            yield from _settings_in(each, f"{key} {number}")
    else:
        yield key, document


KIND = Kind(
    ResponsePredictionPlan.of,
    {IDENTIFICATION: ResponseIdentificationTable, TABLE: ResponsePredictionTable},
    required=(IDENTIFICATION, TABLE),
    checks={IDENTIFICATION: free_parameters, TABLE: checked},
    without=("force_levels", "tolerance", "peak_tolerance", "quantity", "measure"),
)
"""Files are read when the work begins."""
