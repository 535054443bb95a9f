"""What studies of predictions have in common: the identification that they read or carry out, and its problem."""

import json
import tomllib
from abc import abstractmethod
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field

from stickslip.laboratory.identification.response.prediction import FEWEST_DRAWS, settings_beside
from stickslip.laboratory.identification.response.result import ResponseIdentification
from stickslip.results.files import open_results
from stickslip.results.schema import analysis_of, stamped
from stickslip.runs.cases import Arrays, Checkpoint, Progress, Work, Workers, all_cases
from stickslip.study.analyses.response_identification import TABLE as IDENTIFICATION
from stickslip.study.analyses.response_identification import (
    ResponseIdentificationPlan,
    ResponseIdentificationTable,
    free_parameters,
    known_settings,
)
from stickslip.study.analysis import LEVELS_AND_PEAKS, Asked, Kind, Plan, content_of
from stickslip.study.fields import Number, Seed, Table, with_si
from stickslip.support.checks import MOST, InputError, counted, fault, listed
from stickslip.support.late import xr
from stickslip.support.units import Band

NOT_OF_THE_PROBLEM = ("sweep.frequency", "sweep.at")
"""Settings in which a prediction may differ from its identification."""
LISTED = 4
"""Differences that an error lists."""


class PredictionTable(Table):
    """From which identification, and from which draws of it."""

    identification: str | None = None
    """results.nc of the identification, or its folder; without it, the identification is carried out first"""
    settings: dict[str, Number] = Field(default_factory=dict)
    """{ name = value } for the prediction, of what differs from test to test"""
    start_states: Literal["identified", "virgin", "any"] = "identified"
    """start states of the contacts: as in the identification, all virgin, or any (random for each draw)"""
    draws: Annotated[int, Field(ge=FEWEST_DRAWS, le=MOST, description="draws of the parameters, for the intervals")] = 40
    seed: Annotated[Seed, Field(description="seed of the draws")] = 0
    compare: Annotated[list[str], Field(description="files of measurements to compare with")] = Field(default_factory=list)


@dataclass(frozen=True, eq=False)
class PredictionPlan(Plan):
    """An identification, carried out or read, and a prediction from it; `name` and `form`: the table of the prediction."""

    base: ResponseIdentificationPlan
    table: Any
    document: Mapping[str, Any]

    name: ClassVar[str]
    form: ClassVar[type[PredictionTable]]

    @classmethod
    def of(cls, asked: Asked) -> Self:
        """The plan of a study; the settings of the identification are those of the prediction."""
        base = ResponseIdentificationPlan.of(asked)
        table: Any = with_si(asked.tables[cls.name], asked.units)
        known_settings(f"[{cls.name}]", table.settings, base.table, asked.rig[0])
        return cls(base, table, asked.document)

    @classmethod
    def kind(cls) -> Kind:
        """The analysis, whose files are read when the work begins."""
        return Kind(cls.of, {IDENTIFICATION: ResponseIdentificationTable, cls.name: cls.form}, without=LEVELS_AND_PEAKS)

    @property
    def reads(self) -> tuple[Path, ...]:
        """The results of the identification."""
        if self.table.identification is None:
            return ()
        return (results_at(self.base.folder / self.table.identification),)

    @property
    def content(self) -> str:
        """Identifies the curves and the results that the study names, as far as they exist."""
        files = (*self.reads, *(results_at(self.base.folder / name) for name in self.table.compare))
        return content_of(files) + ("" if self.reads else self.base.content)

    @property
    @abstractmethod
    def what(self) -> str:
        """What is predicted, in words."""

    @property
    def summary(self) -> str:
        how = "from an identification" if self.table.identification else f"from {self.base.summary}"
        return f"{self.what}, {counted(self.table.draws, 'draw')}, {how}"

    @property
    def band(self) -> Band:
        """The band of the study."""
        where = self.base.sweep.frequencies
        return Band(min(where), max(where))

    @property
    def about_draws(self) -> dict[str, Any]:
        """The settings that all predictions have."""
        return {name: getattr(self.table, name) for name in ("settings", "start_states", "draws", "seed")}

    @cached_property
    def identified(self) -> ResponseIdentification | None:
        """The identification whose results the study names."""
        if self.table.identification is None:
            return None
        return self._from(open_results(self.base.folder / self.table.identification))

    def _from(self, dataset: "xr.Dataset") -> ResponseIdentification:
        """The identification of a dataset, with the problem of its study; another result or problem is refused."""
        what = f"[{self.name}]: identification"
        if analysis_of(dataset) != IDENTIFICATION:
            raise fault(what, f"must be the results of {IDENTIFICATION}", analysis_of(dataset))
        free, identified = list(free_parameters(self.base.table)), list(json.loads(str(dataset.attrs.get("free", "{}"))))
        if sorted(free) != sorted(identified):
            raise fault(
                f"[{IDENTIFICATION}]", f"must have the identified parameters free, {', '.join(identified)}", ", ".join(free)
            )
        own = {*free, *self.table.settings, *(name for one in self.base.table.settings for name in one)}
        text = str(dataset.attrs.get("study", ""))
        if text and (found := differences(self.document, tomllib.loads(text), (own, self.name))):
            raise InputError(
                f"{what} was made with another problem: {listed(found)}. Use the same problem, give intended differences in "
                "`settings`, or remove `identification`: the study then identifies the parameters itself."
            )
        return ResponseIdentification(dataset, self.base.problem_of(*self.table.settings), ())

    @abstractmethod
    def check(self, held: bool, quantity: str) -> None:
        """Refuse what is wrong with the prediction and with what it is compared with. held: whether the response was held in the
        identification; quantity: that was measured."""

    @abstractmethod
    def prediction(self, identified: ResponseIdentification) -> Any:
        """The work of the prediction."""

    @property
    @abstractmethod
    def measured(self) -> Sequence[Any]:
        """What the prediction is compared with."""

    def compared(self, work: Any, results: Sequence[Arrays]) -> "xr.Dataset":
        """The prediction beside what it is compared with."""
        found = work.gathered(results)
        dataset: xr.Dataset = (found.compare(self.measured) if self.measured else found).dataset
        return dataset

    @cached_property
    def works(self) -> Mapping[str, Work]:
        """What of the prediction is wrong is said before the identification is carried out."""
        identified = self.identified
        if identified is not None:
            data = identified.dataset
            self.check(str(data.attrs["held"]) == "response", str(data["quantity"].values[0]))
            return {"": self.prediction(identified)}
        work = self.base.work
        settings_beside(self.base.table.settings, self.table.settings)
        self.check(self.base.table.held == "response", work.tests[0].quantity)
        return {"": work}

    def dataset(self, results: Mapping[str, Sequence[Arrays]]) -> "xr.Dataset":
        """Of a prediction whose identification is read."""
        if self.identified is None:
            raise AssertionError("a prediction whose identification is carried out is searched")
        return self.compared(self.works[""], results[""])

    def searched(
        self, results: Mapping[str, Sequence[Arrays]], checkpoint: Checkpoint, workers: Workers, progress: Progress
    ) -> "xr.Dataset":
        """The prediction, from the identification that was carried out or read."""
        if self.identified is not None:
            return self.dataset(results)
        work = self.prediction(self._from(stamped(self.base.dataset(results), IDENTIFICATION)))
        return self.compared(work, all_cases(work, checkpoint, workers, progress))


def results_at(place: Path) -> Path:
    """The file of results at a place: the file itself, or results.nc of a folder."""
    return place / "results.nc" if place.is_dir() else place


def differences(here: Mapping[str, Any], there: Mapping[str, Any], aside: tuple[Collection[str], str]) -> list[str]:
    """What two studies differ in, of the problem and of how finely it is computed; aside: arguments of the rig that do not count,
    and the table of the prediction.

    Names of files may lie in different folders.
    """
    arguments, table = aside
    stated, identified = (
        {key: value for key, value in _settings_in(each, table) if key not in NOT_OF_THE_PROBLEM} for each in (here, there)
    )
    found = []
    for key in dict.fromkeys((*stated, *identified)):
        one, other = stated.get(key), identified.get(key)
        same = one == other or (isinstance(one, str) and isinstance(other, str) and Path(one).name == Path(other).name)
        if not same and key not in {f"structure.parameters.{name}" for name in arguments}:
            shown = ["not given" if each is None else repr(each) for each in (one, other)]
            found.append(f"{key} is {shown[0]} here and {shown[1]} in the identification")
    return found if len(found) <= LISTED else [*found[:LISTED], counted(len(found) - LISTED, "further difference")]


def _settings_in(document: Any, table: str, key: str = "") -> Iterator[tuple[str, Any]]:
    """The settings of a study by their keys, but for those of its analysis."""
    if isinstance(document, Mapping):
        for name, value in document.items():
            if key or name not in ("study", IDENTIFICATION, table):
                yield from _settings_in(value, table, f"{key}.{name}" if key else name)
    elif isinstance(document, list) and any(isinstance(each, Mapping) for each in document):
        for number, each in enumerate(document, start=1):
            yield from _settings_in(each, table, f"{key} {number}")
    else:
        yield key, document
