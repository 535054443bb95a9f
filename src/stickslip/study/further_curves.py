"""Further curves in a study: the tables [isolated] and [branches] of a forced response."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field, Tag

from stickslip.analyses.forced_response import ForcedResponse, ForcedResponseWork
from stickslip.analyses.modes.nonlinear_modes import NonlinearModes, nonlinear_modes
from stickslip.analyses.modes.work import AMPLITUDES, NonlinearModesWork
from stickslip.analyses.response_settings import ForcedResponseSettings
from stickslip.model.problem.many_periods import MOST_PERIODS
from stickslip.study.analysis import Asked
from stickslip.study.fields import LENGTH, Table, by_form, with_si
from stickslip.study.tables import Ends
from stickslip.support.checks import MOST, fault, unique

ModeNumber = Annotated[int, Field(ge=1, le=MOST)]
ModeNumbers = Annotated[
    Annotated[ModeNumber, Tag("<single>")] | Annotated[list[ModeNumber], Field(min_length=1), Tag("<list>")], by_form()
]
Amplitudes = Annotated[Ends | None, LENGTH, Field(description=AMPLITUDES)]
"""Ends of the curve of a nonlinear mode."""
Periods = Annotated[int, Field(ge=1, le=MOST_PERIODS)]


def ordered(amplitude: tuple[float, ...] | list[float] | None, mode: int | list[int] | None) -> None:
    """What the models of tables with modes cannot check."""
    if amplitude is not None and amplitude[0] >= amplitude[1]:
        raise fault("amplitude", "must be [smallest, largest] with the smallest first", amplitude)
    if isinstance(mode, list):
        unique("mode", mode)


class IsolatedTable(Table):
    """Isolas, closed curves that the sweeps do not meet, from nonlinear modes and along the force level."""

    mode: Annotated[
        ModeNumbers | None, Field(description="number of a mode of the stuck structure, or a list; default: none")
    ] = None
    amplitude: Amplitudes = None
    periods: Annotated[
        Periods,
        Field(
            description="periods of the excitation after which motions may repeat themselves; with several they are subharmonic"
        ),
    ] = 1

    @property
    def ends(self) -> tuple[float, float] | None:
        """The amplitudes as a pair."""
        return None if self.amplitude is None else (self.amplitude[0], self.amplitude[1])


class BranchesTable(Table):
    """Branches at all branch points of the curves."""

    periods: Annotated[
        Periods, Field(description="of a curve, after which motions may repeat themselves; 2 for period doublings")
    ] = 1


@dataclass(frozen=True, eq=False)
class FurtherCurves:
    """What a study asks for beyond its sweeps."""

    isolated: IsolatedTable | None
    branches: BranchesTable | None

    @classmethod
    def of(cls, asked: Asked) -> FurtherCurves:
        """The tables of a study; refused for listed frequencies, which no curve joins."""
        isolated, branches = asked.tables.get("isolated"), asked.tables.get("branches")
        for name, table in (("isolated", isolated), ("branches", branches)):
            if table is not None and asked.sweep is not None and asked.sweep.listed:
                raise fault(f"[{name}]", "must go with a band, [sweep] frequency", "listed frequencies, [sweep] at")
        found = cls(
            with_si(isolated, asked.units) if isinstance(isolated, IsolatedTable) else None,
            branches if isinstance(branches, BranchesTable) else None,
        )
        if found.isolated is not None and found.isolated.mode is not None and asked.sweep is not None:
            found._refuse_modes(found.isolated, asked.sweep)
        return found

    def _refuse_modes(self, table: IsolatedTable, sweep: ForcedResponseSettings) -> None:
        """What would stop the modes when all sweeps are done: a number beyond the structure's, contacts at a node, amplitudes."""
        loaded = max((h for force in sweep.problem.forces for h in force.factors), default=1)
        harmonics = max(loaded, 1) if sweep.harmonics == "auto" else sweep.harmonics
        NonlinearModesWork(sweep.problem, table.mode, table.ends, harmonics, sweep.samples).refuse_amplitudes()

    @property
    def periods(self) -> int:
        """Over how many periods of the excitation the sweeps are to be expanded."""
        return 1 if self.isolated is None else self.isolated.periods

    def added(self, response: ForcedResponse, work: ForcedResponseWork) -> ForcedResponse:
        """The response with the curves that are asked for."""
        if self.isolated is not None:
            modes = self._modes(self.isolated, work)
            response = response.with_isolated(*modes) if modes else response
        return response if self.branches is None else response.with_branches(self.branches.periods)

    def _modes(self, table: IsolatedTable, work: ForcedResponseWork) -> list[NonlinearModes]:
        if table.mode is None:
            return []
        harmonics = work.harmonics if isinstance(work.harmonics, int) else list(work.harmonics)
        return [nonlinear_modes(work.problem, table.mode, table.ends, harmonics, work.samples)]
