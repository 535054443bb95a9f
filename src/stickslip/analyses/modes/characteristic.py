"""Peaks of all force levels from a mode, as columns of its dataset.

Forced motions solved at the peaks that a nonlinear mode synthesises: what the synthesis misses is known, not estimated.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stickslip.analyses.isolated import ModeMotions
from stickslip.analyses.modes.synthesis import Synthesis
from stickslip.model.problem import Problem
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, PathCondition
from stickslip.solve.balance.orders import of_attribute
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.support.checks import Array, InputError, rounded
from stickslip.support.late import pd, xr
from stickslip.support.units import um

ITERATIONS, HALVINGS = 30, 8

LEAST_RATIO, FINEST, MOST_STEPS = 1e-5, 1e-5, 40
"""Of a climb: the damping ratio that its first step has at least, its last step relative to the frequency, and steps at most."""

FARTHEST = 0.2
"""Relative distance in frequency beyond which a solution is that of another peak."""


def with_solved(table: pd.DataFrame, modes: xr.Dataset, problem: Problem, case: int, output: int) -> pd.DataFrame:
    """Peaks of `Synthesis.peaks` with solved_frequency [Hz] and solved_amplitude [m] of the first harmonic of the output; NaN
    where Newton's method does not arrive.

    The harmonic balance of the forced motion is solved from the motion of the mode, with the phase of the synthesis and the
    frequency as an unknown, and then beside it, upwards, until no frequency at either side has a larger amplitude.
    """
    balance = HarmonicBalance(problem, of_attribute(modes.attrs["harmonics"]), int(modes.attrs["samples"]))
    motions = ModeMotions.of(balance, modes, case)
    columns = ["force_level", "frequency", "modal_amplitude", "phase", "damping_ratio"]
    solved = [_solved(balance, motions, output, *row) for row in table[columns].to_numpy()]
    frequencies, amplitudes = np.array(solved).reshape(-1, 2).T
    return table.assign(solved_frequency=frequencies, solved_amplitude=amplitudes)


def _solved(
    balance: HarmonicBalance,
    motions: ModeMotions,
    output: int,
    level: float,
    hertz: float,
    amplitude: float,
    phase: float,
    ratio: float,
) -> tuple[float, float]:
    """Frequency [Hz] and amplitude [m] of one peak."""
    omega = 2.0 * np.pi * hertz
    place = float(np.interp(amplitude, motions.amplitude, np.arange(motions.amplitude.size)))
    start = motions.start(balance, place, float(motions.phase[int(place)]), level).point
    near = correct(balance, start, fixed("omega", omega), ITERATIONS, HALVINGS)
    for begin in (*((near.evaluation.point,) if near.converged else ()), start):
        solution = correct(balance, begin, _phase_of(balance, phase, output), ITERATIONS, HALVINGS)
        found = solution.evaluation.point.omega
        if solution.converged and abs(found / omega - 1.0) < FARTHEST:
            return _climbed(balance, solution.evaluation, output, abs(ratio))
    return np.nan, np.nan


def _climbed(balance: HarmonicBalance, begin: Evaluation, output: int, ratio: float) -> tuple[float, float]:
    """The peak above a point: steps in frequency from the half-power width on, shortened where neither side is higher, there from
    the top of the parabola through all three."""

    def size(evaluation: Evaluation) -> float:
        return float(np.hypot(*evaluation.w[balance.rows + output, balance.first]))

    def beside(change: float) -> Evaluation | None:
        solution = correct(balance, best.point, fixed("omega", best.point.omega + change))
        return solution.evaluation if solution.converged else None

    best, step = begin, max(ratio, LEAST_RATIO) * begin.point.omega
    sides: dict[float, Evaluation | None] = {}
    for _ in range(MOST_STEPS):
        if step < FINEST * best.point.omega:
            break
        sides |= {way: beside(way * step) for way in (-1.0, 1.0) if way not in sides}
        solved = {way: each for way, each in sides.items() if each is not None}
        higher = max(solved, key=lambda way: size(solved[way]), default=0.0)
        if solved and size(solved[higher]) > size(best):
            sides, best = {-higher: best}, solved[higher]
            continue
        if len(solved) == 2:
            low, middle, high = size(solved[-1.0]), size(best), size(solved[1.0])
            bend = 2.0 * middle - low - high
            top = beside(0.5 * step * (high - low) / bend) if bend > 0.0 else None
            best = best if top is None else max(best, top, key=size)
        sides, step = {}, (0.2 if len(solved) == 2 else 0.5) * step
    return best.point.omega / (2.0 * np.pi), size(best)


def _phase_of(balance: HarmonicBalance, phase: float, output: int) -> PathCondition:
    """The first harmonic x of an output, a real and a imaginary part a − ib, has a phase: Im(x exp(−i phase)) = 0, relative to
    the motion of a micrometre.
    """
    weight = np.zeros((balance.rows + len(balance.problem.outputs), balance.columns))
    weight[balance.rows + output, balance.first] = -np.sin(phase) / um, -np.cos(phase) / um
    return PathCondition("omega", weight, 0.0, 0.0)


CONSIDERABLE = 0.05
"""Linear response of the other modes relative to the mode's motion above which peaks of force levels come with a warning. Below,
peaks of chains, blade and three masses are at most 1.3 % off. From 0.05 to 0.2 they are up to 9 % off, of two weakly coupled
masses 34 %; from 0.2 to 0.4 up to 38 %, although those of the blade and of mode 1 of the chain of 20 masses stay within 3 %."""

OFF = 0.01
"""Relative difference of a solved peak from the synthesised one above which it is said."""

_POINT, _LEVEL = ("case", "point"), ("case", "force_level")
POINTS = {
    "peak_force_level": (_POINT, "1", "force level whose resonance peak has this amplitude"),
    "peak_frequency": (_POINT, "Hz", "frequency of that peak"),
    "peak_amplitude": ((*_POINT, "output"), "m", "amplitude of the first harmonic at that peak, with the other modes"),
    "peak_other_modes": (_POINT, "1", "linear response of the other stuck modes at that peak, relative to the mode's motion"),
    "quadrature_force_level": (_POINT, "1", "force level in phase resonance"),
}
LEVELS = {
    "level_frequency": (_LEVEL, "Hz", "frequency of the highest peak of a force level"),
    "level_amplitude": (_LEVEL, "m", "amplitude of the first output at the highest peak of a force level"),
    "level_solved_frequency": (_LEVEL, "Hz", "frequency of that peak, solved as a forced motion"),
    "level_solved_amplitude": (_LEVEL, "m", "amplitude of the first output at that peak, solved as a forced motion"),
}


def with_peaks(dataset: xr.Dataset, problem: Problem, levels: Sequence[float] = ()) -> xr.Dataset:
    """The dataset with the peaks that belong to its points, and those of force levels; NaN where the forces of the problem do not
    excite a mode, or a level is beyond its amplitudes. `synthesis_message` says why."""
    sizes = {**dataset.sizes, "force_level": len(levels)}
    names = POINTS | (LEVELS if levels else {})
    data = {name: np.full([sizes[dim] for dim in dims], np.nan) for name, (dims, _, _) in names.items()}
    messages, warnings = [], []
    for case in range(sizes["case"]):
        try:
            synthesis = Synthesis.of(dataset, problem, case, None)
        except InputError as reason:
            messages.append(str(reason))
            warnings.append("")
            continue
        messages.append("")
        mode, omega = synthesis.mode, synthesis.mode.easiest()
        own_levels, count = mode.level_of_peak(), mode.omega.size
        data["peak_force_level"][case, :count], data["peak_frequency"][case, :count] = own_levels, omega / (2.0 * np.pi)
        data["quadrature_force_level"][case, :count] = mode.quadrature
        data["peak_other_modes"][case, :count] = synthesis.other_modes(mode, omega, own_levels)
        for output in range(sizes["output"]):
            data["peak_amplitude"][case, :count, output] = np.abs(synthesis.moved(mode, omega, own_levels, output))
        said = [_others_move(data["peak_force_level"][case], data["peak_other_modes"][case])]
        if levels:
            _fill_levels(data, case, synthesis, levels, dataset, problem)
            said.append(_misses(np.array(levels), *(data[name][case] for name in ("level_amplitude", "level_solved_amplitude"))))
        warnings.append(" ".join(filter(None, said)))
    described = {name: (dims, data[name], {"units": units, "long_name": words}) for name, (dims, units, words) in names.items()}
    why = {"units": "1", "long_name": "why there are no peaks of force levels"}
    found = dataset.assign(described).assign(synthesis_message=("case", np.array(messages, dtype=np.str_), why))
    close = {"units": "1", "long_name": "why peaks of force levels may be wrong"}
    found = found.assign(synthesis_warning=("case", np.array(warnings, dtype=np.str_), close))
    if not levels:
        return found
    return found.assign_coords(force_level=("force_level", list(levels), {"units": "1", "long_name": "force level"}))


def _others_move(levels: Array, shares: Array) -> str:
    """A warning where the other modes move so much that it matters that they respond linearly, as if contacts stuck; else ""."""
    large = np.flatnonzero(shares > CONSIDERABLE)
    if not large.size:
        return ""
    ends, most = (levels[large].min(), levels[large].max()), int(np.nanargmax(shares))
    return (
        f"Other modes: at the peaks of force levels {ends[0]:.3g} to {ends[1]:.3g} they respond with more than "
        f"{100.0 * CONSIDERABLE:g} % of the motion of this one, with up to {rounded(100.0 * shares[most], 2)} % at "
        f"{levels[most]:.3g}, "
        "in the synthesis as if all contacts stuck. Peaks there may be wrong by about as much: compare forced responses."
    )


def _misses(levels: Array, synthesised: Array, solved: Array) -> str:
    """A warning where forced motions have other peaks than the synthesis, or none was found; else ""."""
    unsolved = np.isfinite(synthesised) & np.isnan(solved)
    words = []
    if np.isfinite(solved).any():
        off = np.abs(solved / synthesised - 1.0)
        worst = int(np.nanargmax(off))
        if off[worst] > OFF:
            words.append(
                f"Peaks that are solved as forced motions differ from the synthesised ones by up to {100.0 * off[worst]:.2g} % "
                f"(force level {levels[worst]:g}). Use the solved peaks."
            )
    if unsolved.any():
        listed = ", ".join(f"{level:g}" for level in levels[unsolved])
        words.append(
            f"No forced motion was found at the peaks of force levels {listed}, so the error of the synthesis is unknown there."
        )
    return " ".join(words)


def _fill_levels(
    data: dict[str, np.ndarray],
    case: int,
    synthesis: Synthesis,
    levels: Sequence[float],
    dataset: xr.Dataset,
    problem: Problem,
) -> None:
    """The highest peak of each force level that the mode reaches."""
    reached = [level for level in levels if level <= synthesis.mode.level_of_peak().max()]
    if not reached:
        return
    table = with_solved(synthesis.peaks(np.array(reached), 0).drop_duplicates("force_level"), dataset, problem, case, 0)
    places = [list(levels).index(level) for level in table["force_level"]]
    for name in ("frequency", "amplitude", "solved_frequency", "solved_amplitude"):
        data[f"level_{name}"][case, places] = table[name]
