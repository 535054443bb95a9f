"""Controlled response: the force that holds the amplitude of an output constant at each frequency, and phase resonance tests.

Laboratories measure jointed structures so: a resonance hardly folds then, and each curve belongs to one state of the contacts.
"""

import time
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Annotated, Any

import numpy as np

from stickslip.analyses.response_dataset import as_given, curve_arrays, labels_of, levels_are_newtons, stacked_curves
from stickslip.analyses.settings import (
    Execution,
    OfProblem,
    OneBalance,
    OutputNumber,
    OverBand,
    Sampled,
    Setting,
    ends_of,
    fineness_of,
    output_of,
    over_a_band,
    takes,
)
from stickslip.model.problem import Problem
from stickslip.model.rigs import single_mass
from stickslip.results.files import SavedResult
from stickslip.results.schema import SCHEMA, Result, described, named, stacked
from stickslip.runs.cases import Arrays, Report, all_cases
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance
from stickslip.solve.balance.energy import EnergyBalance
from stickslip.solve.balance.fourier import attribute, checked_harmonics, highest
from stickslip.solve.balance.measure import QUANTITIES, Quantity, quantity_named
from stickslip.solve.balance.system import Control
from stickslip.solve.curves.curve import controlled_curve, followed_resonances, force_phase, phase_resonances, turned_motion
from stickslip.support.checks import Array, fault, of_kind, positive, unique, vector
from stickslip.support.late import pd, xr
from stickslip.support.machine import one_blas_thread
from stickslip.support.outcome import Outcome
from stickslip.support.units import Band


@dataclass(frozen=True, eq=False, repr=False)
class ControlledResponse(SavedResult):
    """Curves at held amplitudes: `dataset`, axes (case, point, ...), a case for each amplitude `held_amplitude`, and the problem.

    force_level: the factor on every harmonic force that holds the amplitude, in N where `units` says so; phase: of the output's
    displacement against the force, in degrees; response, amplitude, contact states, dissipated energy and loss factor as of a
    forced response. resonance_frequency, resonance_force_level, resonance_loss_factor (case, resonance): where force and
    displacement of the output are at 90°, the lowest force first.
    """

    dataset: "xr.Dataset"
    problem: Problem

    def resonances(self) -> "pd.DataFrame":
        """Phase resonances: held amplitude, frequency [Hz], force level, loss factor, the lowest force of an amplitude first."""
        names = ["resonance_frequency", "resonance_force_level", "resonance_loss_factor"]
        table = self.dataset[names].to_dataframe().reset_index().dropna(subset=[names[0]])
        short = {name: name.removeprefix("resonance_") for name in names}
        return table.rename(columns=short)[["held_amplitude", *short.values()]].reset_index(drop=True)


@dataclass(frozen=True, eq=False, repr=False)
class PhaseResonance(Result):
    """`dataset`, axis `amplitude` [of the quantity]: frequency [Hz], force_level, loss_factor and outcome where force and
    displacement are at 90°; NaN where no solution was found."""

    dataset: "xr.Dataset"
    problem: Problem


def amplitudes_of(name: str, amplitude: Any) -> tuple[float, ...]:
    """Held amplitudes, checked: positive and different, at least one."""
    found = tuple(positive(name, value) for value in vector(name, amplitude).tolist())
    if not found:
        raise fault(name, "must hold at least one value", [])
    unique(name, found)
    return found


def _motion(name: str, value: Any) -> str:
    """The name of a quantity that is a motion."""
    quantity, per_force = quantity_named(of_kind(name, value, str))
    if per_force:
        raise fault(name, f"must be {', '.join(QUANTITIES)}", value, "What is held is a motion, not a motion per force.")
    return quantity.name


@dataclass(frozen=True, eq=False)
class HeldMotion(OneBalance, OverBand, Sampled):
    """What a laboratory holds: the amplitude of an output, over a band."""

    problem: OfProblem
    amplitude: Annotated[
        float | Sequence[float],
        Setting(amplitudes_of, "held amplitudes: length, length/time or length/time², in the units of the study"),
    ]
    _: KW_ONLY
    output: OutputNumber = 0
    quantity: Annotated[str, Setting(_motion, "quantity of the output that is held")] = "acceleration"

    def __post_init__(self) -> None:
        super().__post_init__()
        output_of(self.problem, self.output)
        fineness_of(self.harmonics, self.samples)
        if not any(force.amplitudes.get(1) for force in self.problem.forces):
            raise fault("The problem", "must have a force with a first harmonic, whose level is sought", "none")

    @property
    def amplitudes(self) -> tuple[float, ...]:
        return amplitudes_of("amplitude", self.amplitude)

    @property
    def held_quantity(self) -> Quantity:
        return QUANTITIES[self.quantity]

    def held(self, case: int) -> HarmonicBalance:
        """The balance that holds the amplitude of a case."""
        control = Control(self.balance.rows + self.output, self.held_quantity.order, self.amplitudes[case])
        return self.balance.holding(control)


@dataclass(frozen=True, eq=False)
class HeldAtResonance(HeldMotion):
    """The same in a phase resonance test, which needs a band and goes from amplitude to amplitude."""

    band: Annotated[Band, Setting(over_a_band)]
    amplitude: Annotated[Sequence[float], Setting(amplitudes_of)]


@dataclass(frozen=True, eq=False, kw_only=True)
class ControlledResponseWork(HeldMotion, Execution):
    """A controlled response as independent cases, one amplitude each."""

    @property
    def names(self) -> tuple[str, ...]:
        """Everything that a curve depends on."""
        others = self.identity("amplitude")
        return tuple(f"controlled response, amplitude {amplitude!r}, {others}" for amplitude in self.amplitudes)

    @property
    def words(self) -> tuple[str, ...]:
        return tuple(f"{self.quantity} {amplitude:g} {self.held_quantity.units}" for amplitude in self.amplitudes)

    def prepare(self) -> None:
        """Compile the kernels, or load them from disk, with the smallest problem there is."""
        controlled_response(single_mass(), [0.1], 0.1, quantity="displacement", harmonics=1, samples=8)

    def solve(self, case: int, report: Report) -> Arrays:
        """The arrays of the curve of one amplitude."""
        started = time.process_time()
        with one_blas_thread():
            balance = self.held(case)
            curve = controlled_curve(balance, [2.0 * np.pi * f for f in self.frequencies], self.listed, report)
            whole = curve_arrays(balance, curve)
            arrays = {name: whole[name] for name in (*ALONG, "case_outcome", "case_message")}
            at = np.flatnonzero(whole["outcome"] == Outcome.CONVERGED)
            arrays["force_level"], arrays["phase"] = (np.full(whole["outcome"].shape, np.nan) for _ in range(2))
            row = balance.rows + self.output
            for k, point in zip(at, curve.points, strict=True):
                arrays["force_level"][k] = point.point.level
                phase = force_phase(self.problem, point.point.omega)
                motion = turned_motion(balance, point.evaluation, row, phase or 0.0)
                arrays["phase"][k] = np.degrees(np.angle(motion))
            phase = force_phase(self.problem, 2.0 * np.pi * self.frequencies[0])
            found = [] if phase is None or self.listed else phase_resonances(balance, curve.points, phase)
            found = [each for each in found if curve.holds(each.evaluation.point.omega)]
            arrays |= resonance_arrays(balance, [each.evaluation for each in found])
        arrays["frequency"] = as_given(arrays["frequency"], self.frequencies)
        return arrays | {"cpu_seconds": np.array(time.process_time() - started)}

    def gathered(self, curves: Sequence[Arrays]) -> ControlledResponse:
        """The response of the curves of all amplitudes."""
        names = self.problem.output_names
        kept = [variable for variable in SCHEMA if variable.name in curves[0]]
        data = {v.name: named(v.dims, stacked_curves(v, [c[v.name] for c in curves]), v.long_name, v.units) for v in kept}
        level = _level_units(self)

        def together(name: str) -> Array:
            return stacked([curve[name] for curve in curves])

        names_found = ("force_level", "phase", *(f"resonance_{name}" for name in RESONANCE))
        data |= described("controlled_response", {name: together(name) for name in names_found}, level)
        held = f"held amplitude of the {self.quantity} of {names[self.output]}"
        along = {"harmonic": np.arange(highest(checked_harmonics(self.harmonics)) + 1), "part": ["re", "im"]}
        coords = {"held_amplitude": named("case", list(self.amplitudes), held, self.held_quantity.units)}
        coords |= described("controlled_response", labels_of(self.problem) | along)
        seconds = sum(float(curve["cpu_seconds"]) for curve in curves)
        return ControlledResponse(xr.Dataset(data, coords, _attributes(self) | {"cpu_seconds": seconds}), self.problem)


@takes(ControlledResponseWork)
def controlled_response(work: ControlledResponseWork) -> ControlledResponse:
    """Force level p(ω) at which an output vibrates with a given amplitude, ω^k |X_1| = A, by harmonic balance.

    X_1 is the first harmonic of the displacement of the output. p multiplies every harmonic force, whose phases do not change.
    k = 0, 1, 2 for quantity "displacement", "velocity", "acceleration"; amplitude: A, one or several, in m, m/s or m/s². band:
    a `Band` in Hz, followed from start to stop through folds, which remain where contacts lift off or modes interact; or a list
    of frequencies in Hz, at which the response is solved exactly.
    output: number of the output. harmonics, samples, workers, checkpoint, progress: as for `forced_response`.

    Returns a `ControlledResponse`. The forced response at a force level and frequency from it has the amplitude A, unless the
    start state has a phase (`TractionRatio` under a varying normal load has one, the same in both).
    """
    return work.gathered(all_cases(work, work.checkpoint, work.workers, work.progress))


@takes(HeldAtResonance)
def phase_resonance(held: HeldAtResonance) -> PhaseResonance:
    """Frequency f(A) and force level p(A) at which the displacement of an output and the force are 90° out of phase.

    Both are given over the amplitude A: they solve Re(X_1 e^{−iφ}) = 0 and ω^k |X_1| = A; all forces must have the same phase φ.
    The curve begins at the lowest amplitude with the mode of the stuck structure inside the band that takes the least force, and
    continues from amplitude to amplitude. A phase resonance test with a phase-locked loop measures the same. Arguments as for
    `controlled_response`.

    Source: S. Peter and R. I. Leine, Mechanical Systems and Signal Processing 96 (2017) 139-158.
    """
    with one_blas_thread():
        low, high = (2.0 * np.pi * end for end in ends_of(held.band))
        # It begins with the stuck mode inside the band that takes the least force to move the output.
        natural = 2.0 * np.pi * held.problem.frequencies(stuck=True)
        inside = natural[(natural >= low) & (natural <= high)]
        if not inside.size:
            ends = [low / (2.0 * np.pi), high / (2.0 * np.pi)]
            raise fault("band", "must hold a natural frequency of the stuck structure", ends, "Widen the band.")
        row, balance = held.balance.rows + held.output, held.balance
        sizes = [float(np.hypot(*balance.evaluate(balance.stuck_point(float(omega), 1.0)).w[row, 1:3])) for omega in inside]
        begin = float(inside[int(np.argmax(sizes))])
        phase = force_phase(held.problem, begin)
        if phase is None:
            raise fault(
                "The harmonic forces", "must have one phase in their first harmonic for a phase resonance", "several or none"
            )
        amplitudes = np.sort(np.array(held.amplitudes))
        found = followed_resonances(held.held(0), amplitudes, begin, phase, (low, high))
        return PhaseResonance(_resonance_dataset(held, amplitudes, found), held.problem)


ALONG = tuple(variable.name for variable in SCHEMA if variable.dims[:2] == ("case", "point"))
"""The variables along a curve that a controlled response shares with a forced one."""

RESONANCE = ("frequency", "force_level", "loss_factor")
"""What is found where force and displacement are at 90°."""


def resonance_arrays(balance: HarmonicBalance, found: Sequence[Evaluation]) -> dict[str, Array]:
    """The variables of `RESONANCE` of solved points."""
    energy = EnergyBalance(balance)
    loss = [energy.loss_factor(each) for each in found]
    values = [each.point.omega / (2.0 * np.pi) for each in found], [each.point.level for each in found], loss
    return {f"resonance_{name}": np.array(value, dtype=float) for name, value in zip(RESONANCE, values, strict=True)}


def _attributes(work: HeldMotion) -> dict[str, Any]:
    attrs: dict[str, Any] = {"title": work.problem.heading, "output_held": work.problem.output_names[work.output]}
    return attrs | {"quantity": work.quantity, "harmonics": attribute(work.harmonics), "samples": work.samples}


def _level_units(work: HeldMotion) -> str:
    return "N" if levels_are_newtons(work.problem) else "1"


def _resonance_dataset(work: HeldMotion, amplitudes: Array, found: Sequence[Any]) -> "xr.Dataset":
    good = np.array([each.converged for each in found])
    arrays = resonance_arrays(work.held(0), [each.evaluation for each in found if each.converged])
    values = {"outcome": np.where(good, int(Outcome.CONVERGED), int(Outcome.NOT_CONVERGED))}
    for name in RESONANCE:
        values[name] = np.full(amplitudes.size, np.nan)
        values[name][good] = arrays[f"resonance_{name}"]
    data = described("phase_resonance", values, _level_units(work))
    of = f"{work.quantity} of {work.problem.output_names[work.output]}"
    coords = {"amplitude": named("amplitude", amplitudes, f"amplitude of the {of}", work.held_quantity.units)}
    missing = ", ".join(f"{amplitude:.4g}" for amplitude in amplitudes[~good])
    message = f"No phase resonance was found at {missing} {work.held_quantity.units}." if missing else ""
    return xr.Dataset(data, coords, _attributes(work) | {"message": message})
