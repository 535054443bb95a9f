"""Nonlinear modes in a study: [nonlinear_modes]."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field

from stickslip.analyses.modes.work import NonlinearModesWork, numbers_of
from stickslip.checks import InputError, counted, fault
from stickslip.harmonic.orders import in_words
from stickslip.problem import Problem
from stickslip.runs.work import Arrays, Work
from stickslip.study.analyses.forced_response import sweep_of
from stickslip.study.analysis import Asked, Kind, Plan, Sweep
from stickslip.study.fields import Table
from stickslip.study.further_curves import Amplitudes, ModeNumbers, ordered
from stickslip.study.units import with_si
from stickslip.units import Band

if TYPE_CHECKING:
    import xarray as xr


class ModesTable(Table):
    """Natural frequency and damping over the amplitude; the force levels of [sweep] are those whose peaks are made from it."""

    mode: Annotated[
        ModeNumbers | None,
        Field(description="number of a mode of the stuck structure, or a list; unless given those in the band of [sweep]"),
    ] = None
    amplitude: Amplitudes = None
    extended: Annotated[
        Literal["first", "all"], Field(description="harmonics whose equation holds the negative damping of the mode")
    ] = "first"


def checked(table: ModesTable) -> None:
    """What the model of the table cannot check."""
    ordered(table.amplitude, table.mode)


@dataclass(frozen=True, eq=False)
class ModesPlan(Plan):
    """The nonlinear modes of a problem."""

    sweep: Sweep
    table: ModesTable

    @classmethod
    def of(cls, asked: Asked) -> ModesPlan:
        """The plan of a study."""
        return cls.of_table(asked, ModesTable.model_validate(asked.tables.get("nonlinear_modes", {})))

    @classmethod
    def of_table(cls, asked: Asked, table: ModesTable) -> ModesPlan:
        """The modes that a table asks for."""
        sweep = sweep_of(asked)
        if sweep.harmonics == "auto":
            raise fault("harmonics", "must be a number or a list for nonlinear modes", "auto")
        plan = cls(sweep, with_si(table, asked.units))
        _ = plan.work
        return plan

    @property
    def summary(self) -> str:
        problem = self.sweep.problem
        size = counted(problem.structure.size, "degree of freedom", "degrees of freedom")
        modes = ", ".join(map(str, self.work.modes))
        named = f"nonlinear mode{'s' if len(self.work.modes) > 1 else ''} {modes}"
        how = f"{in_words(self.work.harmonics)}, {self.work.samples} samples"
        return f"{size}, {counted(len(problem.contacts), 'contact')}; {named}, {how}"

    @cached_property
    def work(self) -> NonlinearModesWork:
        sweep, table = self.sweep, self.table
        ends = None if table.amplitude is None else (table.amplitude[0], table.amplitude[1])
        assert sweep.harmonics != "auto"
        harmonics = sweep.harmonics if isinstance(sweep.harmonics, int) else list(sweep.harmonics)
        return NonlinearModesWork.of(
            sweep.problem,
            modes=self._modes(),
            ends=ends,
            output=0,
            harmonics=harmonics,
            samples=sweep.samples,
            extended=table.extended,
        )

    def _modes(self) -> tuple[int, ...]:
        """The modes asked for, or those of the stuck structure in the band."""
        if self.table.mode is not None:
            return numbers_of(self.sweep.problem, self.table.mode, None, 0, False)
        return modes_between(self.sweep.problem, *_ends(self.sweep))

    @property
    def works(self) -> Mapping[str, Work]:
        return {"": self.work}

    def dataset(self, results: Mapping[str, Sequence[Arrays]]) -> xr.Dataset:
        return self.work.dataset(results[""], self.sweep.force_levels)


def _ends(sweep: Sweep) -> tuple[float, float]:
    where = sweep.frequencies
    return (where.low, where.high) if isinstance(where, Band) else (min(where), max(where))


def modes_between(problem: Problem, low: float, high: float) -> tuple[int, ...]:
    """Numbers of the modes of the stuck structure within a band in Hz, at least one."""
    frequencies = problem.frequencies(stuck=True)
    inside = np.flatnonzero((frequencies >= low) & (frequencies <= high))
    if not inside.size:
        near = ", ".join(f"{value:.5g}" for value in frequencies[:6])
        raise InputError(
            f"[sweep]: the band must hold a natural frequency of the stuck structure, but {low:g} to {high:g} Hz holds none of "
            f"{near}{', ...' if frequencies.size > 6 else ''} Hz. Widen it, or give the number of a mode."
        )
    return tuple(int(k) + 1 for k in inside)


KINDS = {"nonlinear_modes": Kind(ModesPlan.of, {"nonlinear_modes": ModesTable}, checks={"nonlinear_modes": checked})}
