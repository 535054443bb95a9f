"""Limit cycles of self-excited vibration: amplitudes at which friction takes as much energy as gas forces feed."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from threadpoolctl import threadpool_limits

from stickslip.analyses.modes.limit_cycle_dataset import curve_arrays, limit_cycles_dataset, root_arrays
from stickslip.analyses.modes.restored import restored
from stickslip.analyses.modes.work import Extended, NonlinearModesWork, ends_of, numbers_of
from stickslip.analyses.work_parts import StateOfFields
from stickslip.checks import fault, unique, vector
from stickslip.curves.damping_roots import DampingCurve
from stickslip.curves.mode_curve import ModeCurve, solve_mode
from stickslip.harmonic.mode_balance import ModeBalance
from stickslip.harmonic.orders import attribute, of_attribute
from stickslip.outcome import Outcome
from stickslip.problem import Problem
from stickslip.results.result import Result
from stickslip.rigs import single_mass
from stickslip.runs.cases import all_cases
from stickslip.runs.work import Arrays, Checkpoint, Progress, Report, Workers

if TYPE_CHECKING:
    import xarray as xr

MOST_RATIO = 1.0
"""Of aerodynamic damping: beyond critical damping there is no vibration."""


@dataclass(frozen=True, eq=False, repr=False)
class LimitCycles(Result):
    """Limit cycles of one or several modes for values of the aerodynamic damping, and the curve on which they lie.

    dataset: axes (case, aerodynamic_damping, limit_cycle), a case per mode, limit cycles in the order of the traced curve;
    (case, point) for the curve, `curve_...`; `held_damping` and `held_...`: the largest damping ratio over the amplitude.
    """

    dataset: xr.Dataset
    problem: Problem


def limit_cycles(
    problem: Problem,
    aerodynamic_damping: ArrayLike = 0.0,
    mode: int | Sequence[int] | None = None,
    amplitude: float | tuple[float, float] | None = None,
    harmonics: int | Sequence[int] = 5,
    samples: int = 256,
    *,
    frequency: float | None = None,
    output: int = 0,
    largest_at_output: bool = False,
    extended: Extended = "first",
    workers: Workers = 1,
    checkpoint: Checkpoint | None = None,
    progress: Progress = lambda fraction, text: None,
) -> LimitCycles:
    """Limit cycles of a mode that gas forces excite and friction holds: amplitudes A with ζ(A) + aerodynamic_damping = 0.

    ζ(A) is the damping ratio of the nonlinear mode (`nonlinear_modes`), of friction and all viscous damping of the problem,
    `AerodynamicDamping` included. aerodynamic_damping: further damping ratios of the mode, one or several, negative where gas
    feeds the vibration; the force is 2ζωM q̇ of the first harmonic (extended="all": of all). Each root is solved by the equations
    of the mode. Stable where dζ/dA > 0: vibration that is a little larger or smaller comes to it; else it leaves. The harmonic
    forces of the problem do not act.

    Other arguments as for `nonlinear_modes`. The largest damping ratio over A (`held_damping`) is the largest negative damping
    that the structure holds at all; stable and unstable limit cycle meet there.

    Source: ζ(A) = 0 of the extended periodic motion, M. Krack, Computers and Structures 154 (2015).
    """
    ratios = checked_ratios(aerodynamic_damping)
    with threadpool_limits(1, user_api="blas"):
        modes = NonlinearModesWork.of(
            problem,
            modes=numbers_of(problem, mode, frequency, output, largest_at_output),
            ends=ends_of(amplitude),
            output=output,
            harmonics=harmonics,
            samples=samples,
            extended=extended,
        )
    work = LimitCyclesWork(modes, ratios)
    return work.gathered(all_cases(work, checkpoint, workers, progress))


def limit_cycles_of(dataset: xr.Dataset, problem: Problem, aerodynamic_damping: ArrayLike = 0.0) -> LimitCycles:
    """Limit cycles of modes that are traced already: their points are solved again, and the roots between them."""
    ratios = checked_ratios(aerodynamic_damping)
    numbers = tuple(int(number) for number in dataset["mode_number"].values)
    H, Nt, extended = (dataset.attrs[name] for name in ("harmonics", "samples", "extended"))
    traced = NonlinearModesWork(
        problem, modes=numbers, ends=None, output=0, harmonics=of_attribute(H), samples=int(Nt), extended=extended
    )
    work = LimitCyclesWork(traced, ratios)
    results = []
    with threadpool_limits(1, user_api="blas"):
        for case in range(len(numbers)):
            started, balance = time.process_time(), work.modes.balance(case)
            one = dataset.isel(case=case)
            curve = ModeCurve(
                tuple(restored(balance, one)), Outcome(int(one["case_outcome"])), str(one["case_message"].values.item())
            )
            results.append(work.arrays(balance, curve) | {"cpu_seconds": np.array(time.process_time() - started)})
    return work.gathered(results)


def checked_ratios(given: ArrayLike) -> tuple[float, ...]:
    """Aerodynamic damping ratios, each between −1 and 1 and given once."""
    found = tuple(vector("aerodynamic_damping", np.atleast_1d(np.asarray(given, dtype=object))).tolist())
    if not found:
        raise fault("aerodynamic_damping", "must hold at least one damping ratio", "none")
    for ratio in found:
        if not abs(ratio) < MOST_RATIO:
            remedy = "It is a ratio to critical damping: −0.5 % is -0.005."
            raise fault("aerodynamic_damping", "must lie between -1 and 1", ratio, remedy)
    unique("aerodynamic_damping", found)
    return found


@dataclass(frozen=True, eq=False)
class LimitCyclesWork(StateOfFields):
    """Limit cycles of each mode as independent cases."""

    modes: NonlinearModesWork
    aerodynamic_damping: tuple[float, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Everything that a case depends on."""
        return tuple(f"limit cycles at {self.aerodynamic_damping!r} of {name}" for name in self.modes.names)

    @property
    def words(self) -> tuple[str, ...]:
        return self.modes.words

    def prepare(self) -> None:
        """Compile the kernels, or load them from disk, with the smallest problem there is."""
        limit_cycles(single_mass(), -0.05, amplitude=(0.9, 3.0), harmonics=1, samples=8)

    def solve(self, case: int, report: Report) -> Arrays:
        """The arrays of one mode."""
        started = time.process_time()
        balance = self.modes.balance(case)
        curve = solve_mode(balance, *self.modes.levels(balance), report)
        return self.arrays(balance, curve) | {"cpu_seconds": np.array(time.process_time() - started)}

    def arrays(self, balance: ModeBalance, curve: ModeCurve) -> dict[str, NDArray[Any]]:
        """Limit cycles, curve and largest damping of a traced mode, by name."""
        damping = DampingCurve.of(balance, curve.points)
        return {
            "mode_number": np.array(float(balance.followed + 1)),
            "case_outcome": np.array(float(curve.outcome)),
            "case_message": np.array(curve.message),
            "stuck_frequency": np.array(balance.linear_omega / (2.0 * np.pi)),
            "stuck_damping": np.array(balance.linear_damping),
            **curve_arrays(damping),
            **root_arrays(damping, self.aerodynamic_damping),
        }

    def gathered(self, results: Sequence[Arrays]) -> LimitCycles:
        """The limit cycles of all cases."""
        modes = self.modes
        attrs: dict[str, Any] = {"harmonics": attribute(modes.harmonics), "samples": modes.samples, "extended": modes.extended}
        attrs["cpu_seconds"] = sum(float(result["cpu_seconds"]) for result in results)
        return LimitCycles(limit_cycles_dataset(modes.problem, results, self.aerodynamic_damping, attrs), modes.problem)
