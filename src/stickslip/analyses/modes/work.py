"""Nonlinear modes as independent cases, one curve each, and which modes and amplitudes the arguments of an analysis mean."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from stickslip.analyses.arguments import output_of
from stickslip.analyses.modes.characteristic import with_peaks
from stickslip.analyses.modes.dataset import mode_arrays, modes_dataset
from stickslip.analyses.work_parts import StateOfFields
from stickslip.checks import Array, InputError, among, between, fault, of_kind, positive, unique, vector
from stickslip.curves.mode_curve import BEFORE_SLIP, BEYOND_SLIP, NODE, slip_level, solve_mode
from stickslip.harmonic.fourier import fourier
from stickslip.harmonic.mode_balance import ModalStructures, ModeBalance
from stickslip.harmonic.orders import Harmonics, attribute, fineness, harmonics_for, highest
from stickslip.problem import Problem
from stickslip.rigs import single_mass
from stickslip.runs.work import Arrays, Report

if TYPE_CHECKING:
    import xarray as xr

Extended = Literal["first", "all"]

LOWEST = 1e-3
"""Where a curve begins whose largest amplitude alone is given, as a share of it."""


@dataclass(frozen=True, eq=False)
class NonlinearModesWork(StateOfFields):
    """Modes as independent cases; modes from 1 on; ends: amplitudes of the output in m, or None."""

    problem: Problem
    _: KW_ONLY
    modes: tuple[int, ...]
    ends: tuple[float, float] | None
    output: int
    harmonics: Harmonics
    samples: int
    extended: Extended

    @classmethod
    def of(
        cls,
        problem: Problem,
        *,
        modes: tuple[int, ...],
        ends: tuple[float, float] | None,
        output: int,
        harmonics: int | Sequence[int],
        samples: int,
        extended: str,
    ) -> NonlinearModesWork:
        """The work of checked modes and ends and of unchecked other arguments."""
        among("extended", of_kind("extended", extended, str), ("first", "all"))
        remedy = 'A mode has no "auto": take the number that a forced response chooses, `response.dataset.attrs["harmonics"]`.'
        H, (_, Nt) = harmonics_for(problem, harmonics, remedy), fineness(harmonics, samples)
        Nt += -Nt % problem.systems.sample_multiple
        fourier(highest(H), Nt)
        work = cls(
            problem,
            modes=modes,
            ends=ends,
            output=output,
            harmonics=H,
            samples=Nt,
            extended=extended,  # type: ignore[arg-type]
        )
        for case in range(len(modes)):
            work.levels(work.balance(case))
        return work

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Everything that a curve depends on."""
        where = (
            "from stuck to slip" if self.ends is None else f"from {self.ends[0]!r} to {self.ends[1]!r} m at output {self.output}"
        )
        how = f"{self.harmonics} harmonics, {self.samples} samples, {self.extended} extended, problem {self.problem.fingerprint}"
        return tuple(f"nonlinear mode {mode}, {where}, {how}" for mode in self.modes)

    @property
    def words(self) -> tuple[str, ...]:
        return tuple(f"mode {mode}" for mode in self.modes)

    def balance(self, case: int) -> ModeBalance:
        """The balance of a mode."""
        extended = 1 if self.extended == "first" else highest(self.harmonics)
        return ModeBalance(self.problem, self.harmonics, self.samples, self.modes[case] - 1, extended)

    def levels(self, balance: ModeBalance) -> tuple[float, float]:
        """The path parameter at both ends of the curve."""
        if self.ends is None:
            slip = slip_level(balance)
            return slip + float(np.log(BEFORE_SLIP)), slip + float(np.log(BEYOND_SLIP))
        shape = np.abs(balance.shape[balance.rows :])
        if shape[self.output] <= NODE * balance.largest_motion:
            what = f"Output {self.problem.output_names[self.output]!r}"
            raise fault(what, "must move in the mode, since amplitudes are given at it", float(shape[self.output]))
        low, high = (balance.level_of(end / float(shape[self.output])) for end in self.ends)
        return low, high

    def prepare(self) -> None:
        """Compile the kernels, or load them from disk, with the smallest problem there is."""
        smallest = NonlinearModesWork.of(
            single_mass(), modes=(1,), ends=(0.5, 0.6), output=0, harmonics=1, samples=8, extended="first"
        )
        smallest.dataset([smallest.solve(0, lambda share: None)])

    def solve(self, case: int, report: Report) -> Arrays:
        """The arrays of the curve of one mode."""
        started = time.process_time()
        balance = self.balance(case)
        arrays = mode_arrays(balance, solve_mode(balance, *self.levels(balance), report))
        return arrays | {"cpu_seconds": np.array(time.process_time() - started)}

    def dataset(self, results: Sequence[Arrays], levels: Sequence[float] = ()) -> xr.Dataset:
        """The curves of all cases as one dataset; levels: of the forces whose peaks it is to hold."""
        attrs: dict[str, Any] = {"harmonics": attribute(self.harmonics), "samples": self.samples, "extended": self.extended}
        attrs["cpu_seconds"] = sum(float(result["cpu_seconds"]) for result in results)
        return with_peaks(modes_dataset(self.problem, results, attrs), self.problem, levels)


def numbers_of(problem: Problem, mode: Any, frequency: float | None, at: int, largest_at_output: bool) -> tuple[int, ...]:
    """The numbers of the modes to follow, from 1 on."""
    output = output_of(problem, at) if of_kind("largest_at_output", largest_at_output, bool) else None
    if sum(given is not None for given in (mode, frequency, output)) > 1:
        raise InputError("Of mode, frequency and largest_at_output one must be given at most, but there are several.")
    if frequency is None and output is None:
        numbers = [1] if mode is None else [mode] if np.ndim(mode) == 0 else list(mode)
        if not numbers:
            raise InputError("mode must hold at least one number, but is empty.")
        found = tuple(between("mode", number, 1, problem.structure.size) for number in numbers)
        unique("mode", found)
        return found
    structures = ModalStructures(problem, (1,), 1)
    squares, shapes = structures.squares[structures.key[1]], structures.shapes[structures.key[1]]
    if frequency is not None:
        wanted = 2.0 * np.pi * positive("frequency", frequency)
        with np.errstate(divide="ignore"):
            return (int(np.argmin(np.abs(1.0 / np.sqrt(squares) - wanted))) + 1,)
    rows = len(problem.B)
    return (int(np.argmax(np.abs(shapes[rows + int(output or 0)]) ** 2)) + 1,)


def ends_of(amplitude: Any) -> tuple[float, float] | None:
    if amplitude is None:
        return None
    if np.ndim(amplitude) == 0:
        return LOWEST * positive("amplitude", amplitude), float(amplitude)
    ends: Array = vector("amplitude", amplitude, 2)
    low, high = (positive("amplitude", end) for end in ends.tolist())
    if not low < high:
        raise fault("amplitude", "must be (low, high) with low below high", amplitude)
    return low, high
