"""Nonlinear modes: natural frequency and damping of a structure with friction over the amplitude of its vibration."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from stickslip.analyses.arguments import output_of
from stickslip.analyses.forced_response import ForcedResponse
from stickslip.analyses.modes.characteristic import with_peaks
from stickslip.analyses.modes.dataset import mode_arrays, modes_dataset, with_phase_at
from stickslip.analyses.modes.solved_peaks import with_solved
from stickslip.analyses.modes.synthesis import ForcePattern, Synthesis
from stickslip.analyses.work_parts import StateOfFields
from stickslip.checks import Array, InputError, among, between, fault, of_kind, positive, unique, vector
from stickslip.contact.start import TractionRatio
from stickslip.curves.mode_curve import BEFORE_SLIP, BEYOND_SLIP, NODE, slip_level, solve_mode
from stickslip.harmonic.fourier import fourier
from stickslip.harmonic.mode_balance import ModalStructures, ModeBalance
from stickslip.harmonic.orders import Harmonics, attribute, fineness, harmonics_for, highest
from stickslip.problem import Problem
from stickslip.results.result import Result
from stickslip.rigs import single_mass
from stickslip.runs.cases import all_cases
from stickslip.runs.work import Arrays, Checkpoint, Progress, Report, Workers

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from stickslip.analyses.modes.limit_cycles import LimitCycles

Extended = Literal["first", "all"]

SAME_RESONANCE = 0.1
"""Relative distance in frequency within which a peak of a response is that of the mode."""

LOWEST = 1e-3
"""Where a curve begins whose largest amplitude alone is given, as a share of it."""


@dataclass(frozen=True, eq=False, repr=False)
class NonlinearModes(
    Result,
    figure="nonlinear_modes:over_amplitude",
    energy="nonlinear_modes:over_energy",
    peaks="nonlinear_modes:peaks_over_force",
    shape="nonlinear_modes:shape",
    states="nonlinear_modes:contact_states",
):
    """Curves of one or several modes: `dataset` with axes (case, point, ...), a case per mode, and the problem that made them."""

    dataset: xr.Dataset
    problem: Problem

    def peaks(self, force_levels: ArrayLike, case: int = 0, output: int = 0, forces: ForcePattern | None = None) -> pd.DataFrame:
        """Resonance peaks of all force levels from one mode: force_level, frequency [Hz], amplitude [m] of an output,
        modal_amplitude, damping_ratio, other_modes, phase [rad], solved_frequency and solved_amplitude; a row a peak, where a
        level has several the highest first. other_modes: their linear response relative to the motion of the mode, with which a
        peak may be wrong. solved_...: of the forced motion solved at the peak, NaN where that fails.

        forces: the harmonic forces whose pattern excites the mode, those of the problem unless given. Besides the mode the
        other modes of the stuck structure respond linearly. Raises `InputError` for a level beyond the amplitudes of the curve.
        """
        row = output_of(self.problem, output)
        table = self._synthesis(case, forces).peaks(vector("force_levels", force_levels), row)
        loaded = self.problem if forces is None else self.problem.with_forces(tuple(forces))
        return with_solved(table, self.dataset, loaded, case, row)

    def response(self, force_level: float, case: int = 0, output: int = 0, forces: ForcePattern | None = None) -> pd.DataFrame:
        """The forced response around the resonance of one force level from one mode: frequency [Hz], amplitude [m] and phase
        [rad] of an output, modal_amplitude, and `mode_alone`, the amplitude without the linear response of the other modes; in
        the order of travel, over the peak and through folds."""
        return self._synthesis(case, forces).response(positive("force_level", force_level), output_of(self.problem, output))

    def phase_resonance(self, case: int = 0, output: int = 0, forces: ForcePattern | None = None) -> pd.DataFrame:
        """Phase resonance, the force in quadrature with the motion, at every point of a curve: force_level, frequency [Hz],
        amplitude [m] of an output, damping_ratio."""
        return self._synthesis(case, forces).phase_resonance(output_of(self.problem, output))

    def against(self, response: ForcedResponse, case: int = 0) -> pd.DataFrame:
        """Peaks from a mode beside those of a forced response of the same problem: force_level, output, `swept` and `from_mode`
        [m], `difference`, relative to the swept one, and the frequencies of both [Hz]. Of the peaks of the response that nearest
        to the mode's counts; NaN where none is within 10 % of its frequency, as on a curve that was lost or in another band."""
        import pandas as pd

        peaks = of_kind("response", response, ForcedResponse).peaks("displacement", "amplitude")
        rows = []
        for level in response.dataset["force_level"].values.tolist():
            for number, name in enumerate(self.problem.output_names):
                mode = self.peaks([level], case, number)
                own = peaks[(peaks["force_level"] == level) & (peaks["output"] == name)]
                away = (own["frequency"] / float(mode["frequency"][0]) - 1.0).abs()
                near = own.loc[away.idxmin()] if away.min() < SAME_RESONANCE else {"amplitude": np.nan, "frequency": np.nan}
                ends = float(near["amplitude"]), float(mode["amplitude"][0])
                rows.append((level, name, *ends, ends[1] / ends[0] - 1.0, float(near["frequency"]), float(mode["frequency"][0])))
        columns = ["force_level", "output", "swept", "from_mode", "difference", "swept_frequency", "mode_frequency"]
        return pd.DataFrame(rows, columns=columns)

    def limit_cycles(self, aerodynamic_damping: ArrayLike = 0.0) -> LimitCycles:
        """Limit cycles of these modes, amplitudes A with ζ(A) + aerodynamic_damping = 0; arguments as for `ss.limit_cycles`."""
        found: LimitCycles = import_module("stickslip.analyses.modes.limit_cycles").limit_cycles_of(self, aerodynamic_damping)
        return found

    def _synthesis(self, case: int, forces: ForcePattern | None) -> Synthesis:
        return Synthesis.of(self.dataset, self.problem, between("case", case, 0, self.dataset.sizes["case"] - 1), forces)


def nonlinear_modes(
    problem: Problem,
    mode: int | Sequence[int] | None = None,
    amplitude: float | tuple[float, float] | None = None,
    harmonics: int | Sequence[int] = 5,
    samples: int = 256,
    *,
    frequency: float | None = None,
    output: int = 0,
    largest_at_output: bool = False,
    extended: Extended = "first",
    phase_at: int | None = None,
    workers: Workers = 1,
    checkpoint: Checkpoint | None = None,
    progress: Progress = lambda fraction, text: None,
) -> NonlinearModes:
    """Natural frequency ω and damping ratio ζ of a mode over its amplitude, from stuck contacts to full slip.

    The periodic motions of M q̈ + (C − 2ζωM) q̇ + K q + Bᵀ f(Bq) = static loads: where the damping of friction and dashpots takes
    as much from the motion as −2ζωM gives, the motion neither grows nor decays. ω is the frequency and ζ the damping ratio with
    which the structure vibrates freely at that amplitude, positive where the motion decays by exp(−ζωt).

    mode: number of the stuck mode to follow, 1 the lowest, or several; or by frequency: the stuck mode nearest to it, Hz; or
    largest_at_output: the stuck mode with the largest share in the static compliance of the output. The first unless given.
    amplitude: largest amplitude, or (lowest, largest), as the amplitude [m] that `output` has in the stuck mode's shape; unless
    given from half to 1000 times the amplitude at which the first contact slips. harmonics, samples: as for `forced_response`.
    extended: "first" puts −2ζωM into the equation of the first harmonic alone, "all" into those of all harmonics. The two differ
    where damping is high: with "all" the negative damping acts on the other modes too, which higher harmonics then excite.
    phase_at: number of the output whose first harmonic is real and positive, at all amplitudes; unless given it is the
    coordinate of the followed stuck mode. Start states are those of the contacts; a traction ratio counts from the
    instant of the largest modal coordinate.
    workers, checkpoint, progress: as for `forced_response`, a case a mode.

    Source: M. Krack, Nonlinear modal analysis of nonconservative systems: extension of the periodic motion concept, Computers
    and Structures 154 (2015).
    """
    with threadpool_limits(1, user_api="blas"):
        work = NonlinearModesWork.of(
            problem, numbers_of(problem, mode, frequency, output, largest_at_output), ends_of(amplitude),
            output_of(problem, output), harmonics, samples, extended,
        )  # fmt: skip
    turned = None if phase_at is None else output_of(problem, phase_at, "phase_at")
    _refuse_no_phase(problem, turned)
    found = work.gathered(all_cases(work, checkpoint, workers, progress))
    return found if turned is None else NonlinearModes(with_phase_at(found.dataset, turned), problem)


@dataclass(frozen=True, eq=False)
class NonlinearModesWork(StateOfFields):
    """Modes as independent cases; modes from 1 on; ends: amplitudes of the output in m, or None."""

    problem: Problem
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
        work = cls(problem, modes, ends, output, H, Nt, extended)  # type: ignore[arg-type]
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
        nonlinear_modes(single_mass(), amplitude=(0.5, 0.6), harmonics=1, samples=8)

    def solve(self, case: int, report: Report) -> Arrays:
        """The arrays of the curve of one mode."""
        started = time.process_time()
        balance = self.balance(case)
        arrays = mode_arrays(balance, solve_mode(balance, *self.levels(balance), report))
        return arrays | {"cpu_seconds": np.array(time.process_time() - started)}

    def gathered(self, results: Sequence[Arrays], levels: Sequence[float] = ()) -> NonlinearModes:
        """The modes of the curves of all cases; levels: of the forces whose peaks the dataset is to hold."""
        attrs: dict[str, Any] = {"harmonics": attribute(self.harmonics), "samples": self.samples, "extended": self.extended}
        attrs["cpu_seconds"] = sum(float(result["cpu_seconds"]) for result in results)
        dataset = modes_dataset(self.problem, results, attrs)
        return NonlinearModes(with_peaks(dataset, self.problem, levels), self.problem)


def _refuse_no_phase(problem: Problem, output: int | None) -> None:
    """A traction ratio holds at an instant of the period, so that the phase of a motion matters."""
    ratios = any(start.code == TractionRatio.code for contact in problem.contacts for start in contact.starts)
    if output is not None and ratios:
        remedy = "Leave phase_at out, or start from slider offsets."
        raise fault("phase_at", "must not be given with traction ratios, which hold at an instant of the period", output, remedy)


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
