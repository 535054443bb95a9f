"""Nonlinear modes as independent cases, one curve each, and which modes and amplitudes the arguments of an analysis mean."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import Annotated, Any, Literal, get_args

import numpy as np

from stickslip.analyses.modes.characteristic import with_peaks
from stickslip.analyses.modes.dataset import decay_arrays, mode_arrays, modes_dataset
from stickslip.analyses.settings import Execution, OfProblem, OutputNumber, Samples, Setting, Settings, output_of
from stickslip.model.problem import Problem
from stickslip.model.rigs import single_mass
from stickslip.runs.work import Arrays, Report
from stickslip.solve.balance.fourier import fourier
from stickslip.solve.balance.mode_balance import ModalStructures, ModeBalance
from stickslip.solve.balance.orders import Harmonics, attribute, checked_harmonics, harmonics_for, highest, of_attribute
from stickslip.solve.curves.mode_curve import BEFORE_SLIP, BEYOND_SLIP, NODE, ModeCurve, slip_level, solve_mode
from stickslip.support.checks import Array, InputError, among, between, fault, of_kind, positive, unique, vector, whole
from stickslip.support.late import xr
from stickslip.support.machine import one_blas_thread
from stickslip.support.outcome import Outcome

Extended = Literal["first", "all"]

LOWEST = 1e-3
"""Where a curve begins whose largest amplitude alone is given, as a share of it."""

AMPLITUDES = (
    "[smallest, largest] amplitude of the first output, in the shape of the stuck mode; default: from half to 1000 times "
    "the amplitude at which the first contact slips"
)

NO_AUTO = 'A mode has no "auto": take the number that a forced response chooses, `response.dataset.attrs["harmonics"]`.'
HarmonicsOfModes = Annotated[int | Sequence[int], Setting(lambda name, value: checked_harmonics(value, NO_AUTO))]


def listed_modes(name: str, mode: Any) -> tuple[int, ...]:
    """Whole numbers, each once."""
    found = tuple(whole(name, number) for number in ([mode] if np.ndim(mode) == 0 else mode))
    if not found:
        raise InputError(f"{name} must hold at least one number, but is empty.")
    unique(name, found)
    return found


def ends_of(name: str, amplitude: Any) -> tuple[float, float]:
    """The ends of a curve."""
    if np.ndim(amplitude) == 0:
        return LOWEST * positive(name, amplitude), float(amplitude)
    ends: Array = vector(name, amplitude, 2)
    low, high = (positive(name, end) for end in ends.tolist())
    if not low < high:
        raise fault(name, "must be (low, high) with low below high", amplitude)
    return low, high


def first_or_all(name: str, extended: Any) -> str:
    """Which harmonics are extended."""
    return among(name, of_kind(name, extended, str), get_args(Extended))


@dataclass(frozen=True, eq=False)
class Modes(Settings):
    """Which modes, from 1 on, over which amplitudes of the output in m, and how finely; a case is a mode."""

    problem: OfProblem
    mode: Annotated[
        int | Sequence[int] | None,
        Setting(listed_modes, "number of a mode of the stuck structure, or a list; default: those in the band of [sweep]"),
    ] = None
    amplitude: Annotated[float | tuple[float, float] | None, Setting(ends_of, AMPLITUDES)] = None
    harmonics: HarmonicsOfModes = 5
    samples: Samples = 256
    _: KW_ONLY
    frequency: float | None = None
    output: OutputNumber = 0
    largest_at_output: bool = False
    extended: Annotated[Extended, Setting(first_or_all, "harmonics whose equation contains the negative damping of the mode")] = (
        "first"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        output_of(self.problem, self.output)
        object.__setattr__(self, "samples", self.problem.systems.enough_samples(self.samples))
        harmonics_for(self.problem, self.harmonics)
        fourier(highest(self.kept_harmonics), self.samples)
        _ = self.modes

    @property
    def kept_harmonics(self) -> Harmonics:
        return checked_harmonics(self.harmonics)

    @cached_property
    def modes(self) -> tuple[int, ...]:
        """The numbers of the modes."""
        by_output = of_kind("largest_at_output", self.largest_at_output, bool)
        if (self.mode is not None) + (self.frequency is not None) + by_output > 1:
            raise InputError("Of mode, frequency and largest_at_output one must be given at most, but there are several.")
        if self.frequency is None and not by_output:
            numbers = (1,) if self.mode is None else listed_modes("mode", self.mode)
            return tuple(between("mode", number, 1, self.problem.structure.size) for number in numbers)
        with one_blas_thread():
            structures = ModalStructures(self.problem, (1,), 1)
        squares, shapes = structures.squares[structures.key[1]], structures.shapes[structures.key[1]]
        if self.frequency is not None:
            wanted = 2.0 * np.pi * positive("frequency", self.frequency)
            with np.errstate(divide="ignore"):
                return (int(np.argmin(np.abs(1.0 / np.sqrt(squares) - wanted))) + 1,)
        return (int(np.argmax(np.abs(shapes[len(self.problem.B) + self.output]) ** 2)) + 1,)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Everything that a curve depends on."""
        others = self.identity("mode", "frequency", "largest_at_output")
        return tuple(f"{type(self).__name__}, mode {mode}, {others}" for mode in self.modes)

    @property
    def words(self) -> tuple[str, ...]:
        return tuple(f"mode {mode}" for mode in self.modes)

    @property
    def attributes(self) -> dict[str, Any]:
        """What results remember."""
        return {"harmonics": attribute(self.kept_harmonics), "samples": self.samples, "extended": self.extended}

    def refuse_amplitudes(self) -> None:
        """What would stop a curve where it begins."""
        with one_blas_thread():
            for case in range(len(self.modes)):
                self.levels(self.balance(case))

    def balance(self, case: int) -> ModeBalance:
        """The balance of a mode."""
        extended = 1 if self.extended == "first" else highest(self.kept_harmonics)
        return ModeBalance(self.problem, self.kept_harmonics, self.samples, self.modes[case] - 1, extended)

    def levels(self, balance: ModeBalance) -> tuple[float, float]:
        """The path parameter at both ends of the curve."""
        if self.amplitude is None:
            slip = slip_level(balance)
            return slip + float(np.log(BEFORE_SLIP)), slip + float(np.log(BEYOND_SLIP))
        shape = np.abs(balance.shape[balance.rows :])
        if shape[self.output] <= NODE * balance.largest_motion:
            what = f"Output {self.problem.output_names[self.output]!r}"
            raise fault(what, "must move in the mode, since amplitudes are given at it", float(shape[self.output]))
        low, high = (balance.level_of(end / float(shape[self.output])) for end in ends_of("amplitude", self.amplitude))
        return low, high


@dataclass(frozen=True, eq=False, kw_only=True)
class NonlinearModesWork(Modes, Execution):
    """Nonlinear modes as independent cases."""

    phase_at: int | None = None

    def prepare(self) -> None:
        """Compile the kernels, or load them from disk, with the smallest problem there is."""
        smallest = NonlinearModesWork(single_mass(), amplitude=(0.5, 0.6), harmonics=1, samples=8)
        smallest.dataset([smallest.solve(0, lambda share: None)])

    def solve(self, case: int, report: Report) -> Arrays:
        """The arrays of the curve of one mode."""
        started = time.process_time()
        balance = self.balance(case)
        arrays = mode_arrays(balance, solve_mode(balance, *self.levels(balance), report))
        return arrays | {"cpu_seconds": np.array(time.process_time() - started)}

    def dataset(self, results: Sequence[Arrays], levels: Sequence[float] = ()) -> xr.Dataset:
        """The curves of all cases as one dataset; levels: of the forces whose peaks it is to hold."""
        attrs = self.attributes | {"cpu_seconds": sum(float(result["cpu_seconds"]) for result in results)}
        return with_peaks(modes_dataset(self.problem, results, attrs), self.problem, levels)


def with_decays(dataset: xr.Dataset, problem: Problem) -> xr.Dataset:
    """The same modes with the variables of decays; they are followed again, since results do not hold the tangents of curves."""
    kept = of_attribute(dataset.attrs["harmonics"])
    extended = 1 if dataset.attrs["extended"] == "first" else highest(kept)
    results = []
    with one_blas_thread():
        for number, sizes in zip(dataset["mode_number"].values, dataset["modal_amplitude"].values, strict=True):
            balance = ModeBalance(problem, kept, int(dataset.attrs["samples"]), int(number) - 1, extended)
            known = sizes[np.isfinite(sizes)]
            curve = ModeCurve((), Outcome.NOT_CONVERGED, "")
            if known.size:
                curve = solve_mode(balance, balance.level_of(float(known[0])), balance.level_of(float(known[-1])))
            results.append(mode_arrays(balance, curve) | decay_arrays(balance, curve))
    return modes_dataset(problem, results, dict(dataset.attrs))
