"""Nonlinear modes: natural frequency and damping of a structure with friction over the amplitude of its vibration.

Limit cycles of self-excited vibration: amplitudes at which friction takes as much energy as gas forces feed.

The solved points of a nonlinear mode again, from its dataset.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.analyses.forced_response import ForcedResponse
from stickslip.analyses.modes.synthesis import ForcePattern, Synthesis
from stickslip.analyses.modes.work import (
    VARIABLES,
    Modes,
    NonlinearModesWork,
    attributes_of,
    labels,
    point_values,
    with_decays,
    with_solved,
)
from stickslip.analyses.response_dataset import ContactRows, of_parts, parts
from stickslip.analyses.settings import Execution, OfProblem, Setting, Settings, output_of, takes
from stickslip.analyses.solved_points import on_its_coordinates, with_shape_forces
from stickslip.model.contact.point import TractionRatio
from stickslip.model.problem import Problem
from stickslip.model.rigs import single_mass
from stickslip.results.schema import Result, named, stacked, variables_in
from stickslip.results.view import length_text
from stickslip.runs.cases import Arrays, Report, all_cases
from stickslip.solve.balance.balance import Point
from stickslip.solve.balance.fourier import of_attribute, real_harmonics
from stickslip.solve.balance.mode_balance import ModeBalance
from stickslip.solve.continuation.curve_points import CurvePoint, Tangent, moving_sizes, relative_metric
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.curves.mode_curve import ROUNDING, DampingCurve, ModeCurve, directed, is_stable, slope, solve_mode
from stickslip.support.checks import InputError, between, fault, of_kind, positive, unique, vector
from stickslip.support.late import pd, xr
from stickslip.support.machine import one_blas_thread
from stickslip.support.outcome import Outcome

TURNED = ("response", "contact_force", "contact_motion", "mode_shape", "shape_slope")
"""The variables with a phase; a slope is turned as its motion is, and remains that of the unturned one."""

_DAMPING = ("case", "aerodynamic_damping")
_ROOT = (*_DAMPING, "limit_cycle")
OF_MODE = (
    "modal_amplitude", "frequency", "energy", "viscous_work", "other_modes", "higher_harmonics", "residual", "amplitude",
    "max_abs", "dissipated", "share_stick", "share_slip", "share_open", "mode_shape",
)  # fmt: skip
"""Variables of limit cycles that are those of a nonlinear mode."""

ROOTS: dict[str, tuple[tuple[str, ...], str, str]] = {
    name: ((*_ROOT, *VARIABLES[name][0][2:]), *VARIABLES[name][1:]) for name in OF_MODE
} | {
    "damping_slope": (_ROOT, "1", "change of the damping ratio with the logarithm of the amplitude"),
    "stable": (_ROOT, "1", "1 where vibration of another amplitude nearby comes to the limit cycle, 0 where it leaves it"),
}
CURVE = variables_in("limit_cycle_curve")
OTHERS: dict[str, tuple[tuple[str, ...], str, str]] = {
    "limit_cycle_message": (_DAMPING, "1", "what the vibration does"),
    **{name: VARIABLES[name] for name in ("mode_number", "case_outcome", "case_message", "stuck_frequency", "stuck_damping")},
}

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
    force, motion = (rows.collected(of_parts(point[name].values)) for name in ("contact_force", "contact_motion"))
    # The followed coordinate φᴴMq of the first harmonic becomes real and positive.
    system = balance.problem.systems.at(1)
    whole = balance.structures.whole[balance.structures.key[1]][:, balance.followed]
    coordinate = complex(whole.conj() @ system.M @ of_parts(point["mode_shape"].values))
    turn = (coordinate.conjugate() / abs(coordinate)) ** np.arange(force.shape[1])
    forces = np.zeros((balance.rows + 1, balance.columns))
    forces[:-1] = real_harmonics((force - balance.stiffness[:, None] * motion) * turn)
    forces[-1, 1] = 2.0 * np.pi * float(point["frequency"]) / balance.linear_omega
    forces[-1, 2] = float(point["damping_ratio"])
    return Point(forces, balance.linear_omega, balance.level_of(float(point["modal_amplitude"])))


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
        arrays = self.arrays(balance, curve) | self.errors_on_mesh(balance, curve)
        return arrays | {"cpu_seconds": np.array(time.process_time() - started)}

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
        attrs = self.attributes | attributes_of(results)
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
    work = work.with_shapes(work.progress)
    return work.gathered(all_cases(work, work.checkpoint, work.workers, work.progress))


def limit_cycles_of(dataset: xr.Dataset, problem: Problem, aerodynamic_damping: ArrayLike = 0.0) -> LimitCycles:
    """Limit cycles of modes that are traced already: their points are solved again, and the roots between them."""
    numbers = tuple(int(number) for number in dataset["mode_number"].values)
    problem = on_its_coordinates(problem, dataset)
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


SAME_RESONANCE = 0.1
"""Relative distance in frequency within which a peak of a response is that of the mode."""


@dataclass(frozen=True, eq=False, repr=False)
class NonlinearModes(Result):
    """Curves of one or several modes: `dataset` with axes (case, point, ...), a case per mode, and the problem that made them."""

    dataset: xr.Dataset
    problem: Problem

    def __post_init__(self) -> None:
        object.__setattr__(self, "problem", on_its_coordinates(self.problem, self.dataset))
        number, known = self.problem.structure.size, self.dataset.sizes["dof"]
        if number != known:
            raise fault("The problem of the modes", f"must have their {known} coordinates", number)

    def peaks(self, force_levels: ArrayLike, case: int = 0, output: int = 0, forces: ForcePattern | None = None) -> pd.DataFrame:
        """Resonance peaks of all force levels from one mode: force_level, frequency [Hz], amplitude [m] of an output,
        modal_amplitude [m kg^0.5], damping_ratio, other_modes, phase [rad], solved_frequency and solved_amplitude; a row a peak,
        where a level has several the highest first. other_modes: their linear response relative to the motion of the mode, with
        which a peak may be wrong. solved_...: of the forced motion solved at the peak, NaN where that fails.

        forces: the harmonic forces whose pattern excites the mode, those of the problem unless given. Besides the mode the
        other modes of the stuck structure respond linearly. Raises `InputError` for a level beyond the amplitudes of the curve.
        """
        row = output_of(self.problem, output)
        table = self._synthesis(case, forces).peaks(vector("force_levels", force_levels), row)
        loaded = self.problem if forces is None else self.problem.with_forces(tuple(forces))
        return with_solved(table, self.dataset, loaded, case, row)

    def response(self, force_level: float, case: int = 0, output: int = 0, forces: ForcePattern | None = None) -> pd.DataFrame:
        """The forced response around the resonance of one force level from one mode: frequency [Hz], amplitude [m] and phase
        [rad] of an output, modal_amplitude [m kg^0.5], and `mode_alone`, the amplitude without the linear response of the other
        modes; in the order of travel, over the peak and through folds."""
        return self._synthesis(case, forces).response(positive("force_level", force_level), output_of(self.problem, output))

    def phase_resonance(self, case: int = 0, output: int = 0, forces: ForcePattern | None = None) -> pd.DataFrame:
        """Phase resonance, the force in quadrature with the motion, at every point of a curve: force_level, frequency [Hz],
        amplitude [m] of an output, damping_ratio."""
        return self._synthesis(case, forces).phase_resonance(output_of(self.problem, output))

    def against(self, response: ForcedResponse, case: int = 0) -> pd.DataFrame:
        """Peaks from a mode beside those of a forced response of the same problem: force_level, output, `swept` and `from_mode`
        [m], `difference`, relative to the swept one, and the frequencies of both [Hz]. Of the peaks of the response that nearest
        to the mode's counts; NaN where none is within 10 % of its frequency, as on a curve that was lost or in another band."""
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

    def with_decays(self) -> NonlinearModes:
        """A copy whose dataset also says how free decays along these modes fall: `swing` [m] (case, point, output), half the
        distance between the turning points, `decay_damping_ratio` (case, point, output), NaN where there is none, and
        `decay_message` (case,), where a decay is not one of the mode. `with_modes` of a decay asks for it. The modes are followed
        again, and the phases are those of their own coordinates."""
        if "decay_damping_ratio" in self.dataset:
            return self
        return replace(self, dataset=with_decays(self.dataset, self.problem))

    def limit_cycles(self, aerodynamic_damping: ArrayLike = 0.0) -> LimitCycles:
        """Limit cycles of these modes, amplitudes A with ζ(A) + aerodynamic_damping = 0; arguments as for `ss.limit_cycles`."""
        return limit_cycles_of(self.dataset, self.problem, aerodynamic_damping)

    def _synthesis(self, case: int, forces: ForcePattern | None) -> Synthesis:
        return Synthesis.of(self.dataset, self.problem, between("case", case, 0, self.dataset.sizes["case"] - 1), forces)


@takes(NonlinearModesWork)
def nonlinear_modes(work: NonlinearModesWork) -> NonlinearModes:
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
    work.refuse_amplitudes()
    turned = None if work.phase_at is None else output_of(work.problem, work.phase_at, "phase_at")
    # A traction ratio holds at an instant of the period, so that the phase of a motion matters.
    ratios = any(start.code == TractionRatio.code for contact in work.problem.contacts for start in contact.starts)
    if turned is not None and ratios:
        remedy = "Leave phase_at out, or start from slider offsets."
        raise fault("phase_at", "must not be given with traction ratios, which hold at an instant of the period", turned, remedy)
    work = work.with_shapes(work.progress)
    dataset = work.dataset(all_cases(work, work.checkpoint, work.workers, work.progress))
    return NonlinearModes(dataset if turned is None else with_phase_at(dataset, turned), work.problem)


def with_phase_at(dataset: xr.Dataset, output: int) -> xr.Dataset:
    """The dataset with every motion moved in time so that the first harmonic of an output is real and positive."""
    first = dataset["response"].values[:, :, output, 1]
    angle = -np.angle(of_parts(first))
    turned = {}
    for name in TURNED:
        variable = dataset[name]
        values = of_parts(variable.values)
        orders = dataset["harmonic"].values if "harmonic" in variable.dims else np.ones(1)
        turn = np.exp(1j * angle.reshape(*angle.shape, *[1] * (values.ndim - 2)) * orders)
        turned[name] = variable.copy(data=parts(values * turn))
    return dataset.assign(turned)


def curve_arrays(damping: DampingCurve) -> dict[str, NDArray[Any]]:
    """The variables of the curve of one mode."""
    balance, rows = damping.balance, ContactRows(damping.balance.problem)
    values = [point_values(balance, rows, point.evaluation)[0] for point in damping.points]
    outputs = len(balance.problem.outputs)
    found = {
        f"curve_{name}": np.array([value[key] for value in values], dtype=float)
        for name, key in (("damping", "damping_ratio"), ("frequency", "frequency"), ("energy", "energy"))
    }
    found["curve_slope"] = np.array([damping.slope(k) for k in range(len(values))])
    found["curve_stable"] = np.array([float(is_stable(point)) for point in damping.points])
    neutral = np.abs(found["curve_slope"]) <= ROUNDING * np.max(np.abs(found["curve_damping"]), initial=0.0)
    found["curve_stable"][neutral] = np.nan
    found["curve_amplitude"] = np.array([value["amplitude"] for value in values], dtype=float).reshape(len(values), outputs)
    if not values:
        nothing = {name: np.array(np.nan) for name in ("held_damping", "held_frequency", "held_inside")}
        return found | nothing | {"held_amplitude": np.full(outputs, np.nan)}
    most = damping.largest
    held = {f"held_{name}": found[f"curve_{name}"][most] for name in ("damping", "frequency", "amplitude")}
    return found | held | {"held_inside": np.array(float(0 < most < len(values) - 1))}


def root_arrays(damping: DampingCurve, ratios: Sequence[float]) -> dict[str, NDArray[Any]]:
    """The variables of the limit cycles of one mode, (aerodynamic_damping, limit_cycle, ...)."""
    balance, problem = damping.balance, damping.balance.problem
    rows, sizes = ContactRows(problem), {"output": len(problem.outputs), "contact": len(problem.contacts), "direction": 3}
    sizes |= {"dof": problem.structure.size, "part": 2}
    by_name: dict[str, list[NDArray[Any]]] = {name: [] for name in ROOTS}
    messages = []
    for ratio in ratios:
        values = []
        for root in damping.roots(-ratio):
            value = point_values(balance, rows, root.evaluation)[0]
            values.append(value | {"damping_slope": slope(root), "stable": float(is_stable(root))})
        for name in ROOTS:
            empty = np.empty((0, *(sizes[dim] for dim in ROOTS[name][0][3:])))
            by_name[name].append(np.array([value[name] for value in values], dtype=float) if values else empty)
        messages.append(_words(damping, ratio, values))
    return {name: stacked(pieces) for name, pieces in by_name.items()} | {"limit_cycle_message": np.array(messages)}


def _words(damping: DampingCurve, ratio: float, values: Sequence[dict[str, Any]]) -> str:
    """What vibration does at an aerodynamic damping ratio, in words."""
    if not damping.points:
        return "No motion of the mode was found."
    first, last = damping.ratios[0] + ratio, damping.ratios[-1] + ratio
    name = damping.balance.problem.output_names[0]
    if not values:
        if first < 0.0:
            return f"Vibration grows at all amplitudes; {-100.0 * (max(damping.ratios) + ratio):.3g} % of damping is missing."
        return "Vibration decays at all amplitudes, or stays as small as it is."
    words = ["Vibration grows from rest." if first < 0.0 else "Small vibration decays or stays as it is."]
    for value in values:
        kind = "Stable" if value["stable"] else "Unstable"
        words.append(f"{kind} limit cycle: {length_text(value['amplitude'][0])} of {name} at {value['frequency']:.5g} Hz.")
    if last < 0.0:
        words.append("Beyond the largest it grows without bound.")
    return " ".join(words)


def limit_cycles_dataset(
    problem: Problem, results: Sequence[Arrays], ratios: Sequence[float], attrs: dict[str, Any]
) -> xr.Dataset:
    """The limit cycles of all modes as one labelled dataset."""
    data = {
        name: named(dims, stacked([result[name] for result in results]), words, units)
        for name, (dims, units, words) in (ROOTS | CURVE | OTHERS).items()
    }
    ratio = named("aerodynamic_damping", list(ratios), "aerodynamic damping ratio, added to that of the mode")
    coords = labels(problem) | {"aerodynamic_damping": ratio}
    return with_shape_forces(xr.Dataset(data, coords, {"title": problem.heading, "study": "", **attrs}), problem)
