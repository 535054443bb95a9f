"""What works of several analyses share: what travels to other processes, and the balance that their cases solve."""

from __future__ import annotations

from dataclasses import fields
from functools import cached_property
from typing import Any

from stickslip.model.problem import Problem
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.measure import Measure, measure_of
from stickslip.support.machine import one_blas_thread

EXECUTION = ("workers", "checkpoint", "progress")
"""Arguments that say how cases are computed: they do not travel, and no result depends on them."""


class StateOfFields:
    """A dataclass of which the fields alone travel to a process, not what was built from them."""

    def __getstate__(self) -> dict[str, Any]:
        names = [field.name for field in fields(self)]  # type: ignore[arg-type]
        return {name: getattr(self, name) for name in names if name not in EXECUTION}


class Measured:
    """A work of which `quantity` and `measure` say what amplitudes are of."""

    quantity: str
    measure: str

    @property
    def measured(self) -> Measure:
        return measure_of(self.quantity, self.measure)


class OneBalance(StateOfFields):
    """A work whose cases share one balance."""

    problem: Problem
    harmonics: Any
    samples: int

    @property
    def periods(self) -> int:
        """Of the excitation, over which a motion is expanded."""
        return 1

    @cached_property
    def balance(self) -> HarmonicBalance:
        with one_blas_thread():
            return HarmonicBalance(self.problem, self.harmonics, self.samples, self.periods)
