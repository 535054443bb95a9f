"""Limit cycles of self-excited vibration: amplitudes at which friction takes as much energy as gas forces feed.

The solved points of a nonlinear mode again, from its dataset.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.analyses.modes.dataset import curve_arrays, limit_cycles_dataset, root_arrays
from stickslip.analyses.modes.work import Modes
from stickslip.analyses.response_dataset import ContactRows
from stickslip.analyses.settings import Execution, OfProblem, Setting, Settings, takes
from stickslip.model.problem import Problem
from stickslip.model.rigs import single_mass
from stickslip.results.result import Result
from stickslip.runs.cases import all_cases
from stickslip.runs.work import Arrays, Report
from stickslip.solve.balance.balance import Point
from stickslip.solve.balance.fourier import real_harmonics
from stickslip.solve.balance.mode_balance import ModeBalance
from stickslip.solve.balance.orders import of_attribute
from stickslip.solve.continuation.curve_points import CurvePoint, Tangent, moving_sizes, relative_metric
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.curves.mode_curve import DampingCurve, ModeCurve, directed, solve_mode
from stickslip.support.checks import InputError, fault, unique, vector
from stickslip.support.late import xr
from stickslip.support.machine import one_blas_thread
from stickslip.support.outcome import Outcome

STEP = 0.1
"""Scale of ln a in arc length."""


def restored(balance: ModeBalance, mode: xr.Dataset) -> Iterator[CurvePoint]:
    """The points of one mode with their tangents, `mode` without the axis `case`.

    Refused where they do not solve the equations of the problem.
    """
    before: CurvePoint | None = None
    for k in range(int(np.count_nonzero(np.isfinite(mode["frequency"].values)))):
        start = _start(balance, mode.isel(point=k))
        found = correct(balance, start, fixed("level", start.level), iterations=20, halvings=8)
        if not found.converged:
            raise InputError("The nonlinear mode must be that of its problem, but its points do not solve the equations.")
        w = found.evaluation.w
        metric = relative_metric(w, balance.rows, moving_sizes(w, balance.rows), STEP)
        tangent = Tangent(np.zeros_like(found.evaluation.point.forces), np.zeros_like(w), 1.0)
        point = CurvePoint(found.evaluation, tangent, metric, found.iterations, 0, 0.0)
        before = directed(balance, before or point, point)
        yield before


def _start(balance: ModeBalance, point: xr.Dataset) -> Point:
    """λ, ω and ζ of a point; the phase is turned back to that of the followed stuck mode."""
    rows = ContactRows(balance.problem)
    force, motion = (rows.collected(_complex(point[name].values)) for name in ("contact_force", "contact_motion"))
    # The followed coordinate φᴴMq of the first harmonic becomes real and positive.
    system = balance.problem.systems.at(1)
    whole = balance.structures.whole[balance.structures.key[1]][:, balance.followed]
    coordinate = complex(whole.conj() @ system.M @ _complex(point["mode_shape"].values))
    turn = (coordinate.conjugate() / abs(coordinate)) ** np.arange(force.shape[1])
    forces = np.zeros((balance.rows + 1, balance.columns))
    forces[:-1] = real_harmonics((force - balance.stiffness[:, None] * motion) * turn)
    forces[-1, 1] = 2.0 * np.pi * float(point["frequency"]) / balance.linear_omega
    forces[-1, 2] = float(point["damping_ratio"])
    return Point(forces, balance.linear_omega, balance.level_of(float(point["modal_amplitude"])))


def _complex(values: NDArray[np.float64]) -> NDArray[np.complex128]:
    return np.asarray(values[..., 0] + 1j * values[..., 1])


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


def checked_ratios(name: str, given: Any) -> tuple[float, ...]:
    """Aerodynamic damping ratios, each between −1 and 1 and given once."""
    found = tuple(vector(name, np.atleast_1d(np.asarray(given, dtype=object))).tolist())
    if not found:
        raise fault(name, "must hold at least one damping ratio", "none")
    for ratio in found:
        if not abs(ratio) < MOST_RATIO:
            remedy = "It is a ratio to critical damping: −0.5 % is -0.005."
            raise fault(name, "must lie between -1 and 1", ratio, remedy)
    unique(name, found)
    return found


@dataclass(frozen=True, eq=False)
class Fed(Settings):
    """What feeds a vibration."""

    problem: OfProblem
    aerodynamic_damping: Annotated[
        ArrayLike,
        Setting(checked_ratios, "damping ratio of the aerodynamic forces, negative if they feed the vibration, or a list"),
    ] = 0.0

    @property
    def ratios(self) -> tuple[float, ...]:
        return checked_ratios("aerodynamic_damping", self.aerodynamic_damping)


@dataclass(frozen=True, eq=False, kw_only=True)
class LimitCyclesWork(Modes, Fed, Execution):
    """Limit cycles of each mode as independent cases."""

    def prepare(self) -> None:
        """Compile the kernels, or load them from disk, with the smallest problem there is."""
        limit_cycles(single_mass(), -0.05, amplitude=(0.9, 3.0), harmonics=1, samples=8)

    def solve(self, case: int, report: Report) -> Arrays:
        """The arrays of one mode."""
        started = time.process_time()
        balance = self.balance(case)
        curve = solve_mode(balance, *self.levels(balance), report)
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
            **root_arrays(damping, self.ratios),
        }

    def gathered(self, results: Sequence[Arrays]) -> LimitCycles:
        """The limit cycles of all cases."""
        attrs = self.attributes | {"cpu_seconds": sum(float(result["cpu_seconds"]) for result in results)}
        return LimitCycles(limit_cycles_dataset(self.problem, results, self.ratios, attrs), self.problem)


@takes(LimitCyclesWork)
def limit_cycles(work: LimitCyclesWork) -> LimitCycles:
    """Limit cycles of a mode that aerodynamic forces excite and friction limits: ζ(A) + aerodynamic_damping = 0 at amplitude A.

    ζ(A) is the damping ratio of the nonlinear mode (`nonlinear_modes`), of friction and all viscous damping of the problem,
    `AerodynamicDamping` included. aerodynamic_damping: further damping ratios of the mode, one or several, negative if the gas
    feeds the vibration; the force is 2ζωM q̇ of the first harmonic (extended="all": of all). Each root is solved by the equations
    of the mode. A limit cycle is stable if dζ/dA > 0: slightly larger or smaller vibrations return to it. The harmonic forces of
    the problem do not act.

    Other arguments as for `nonlinear_modes`. The largest damping ratio over A (`held_damping`) is the largest negative damping
    that friction can balance; the stable and the unstable limit cycle meet there.

    Source: ζ(A) = 0 of the extended periodic motion, M. Krack, Computers and Structures 154 (2015).
    """
    work.refuse_amplitudes()
    return work.gathered(all_cases(work, work.checkpoint, work.workers, work.progress))


def limit_cycles_of(dataset: xr.Dataset, problem: Problem, aerodynamic_damping: ArrayLike = 0.0) -> LimitCycles:
    """Limit cycles of modes that are traced already: their points are solved again, and the roots between them."""
    numbers = tuple(int(number) for number in dataset["mode_number"].values)
    H, Nt, extended = (dataset.attrs[name] for name in ("harmonics", "samples", "extended"))
    work = LimitCyclesWork(problem, aerodynamic_damping, numbers, None, of_attribute(H), int(Nt), extended=extended)
    results = []
    with one_blas_thread():
        for case in range(len(numbers)):
            started, balance = time.process_time(), work.balance(case)
            one = dataset.isel(case=case)
            curve = ModeCurve(
                tuple(restored(balance, one)), Outcome(int(one["case_outcome"])), str(one["case_message"].values.item())
            )
            results.append(work.arrays(balance, curve) | {"cpu_seconds": np.array(time.process_time() - started)})
    return work.gathered(results)
