"""Identification of a damper's contact parameters from measured cycles: global search, gradients, intervals.

1. A search of the whole range (differential evolution), then least squares on whole loops of all cases at once.
2. Intervals from refits to resampled cycles with drawn errors of cells and lasers, with the misfit itself turned about and
   with contacts between macroslip and microslip: the formal covariance is too small by 1.5 to 20 times.

Plausibility checks of measured cycles before a fit and of the result after it.

What an identification of a damper is given as: the result, its dataset and sentences, and parameters over the cycles.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from typing import Annotated, Any

import numpy as np

from stickslip.analyses.damper_alone.cycle import slip_work
from stickslip.analyses.settings import Seed, Setting, Settings, Whole, takes
from stickslip.laboratory.identification.damper.fit import (
    COARSE,
    EVALUATIONS,
    LINE_LAWS,
    TENFOLD,
    DamperFit,
    Refits,
    fitted,
    fitted_with_law,
    held_out,
    parameters,
    population,
    refits,
    usual_unknowns,
)
from stickslip.laboratory.identification.least_squares import CERTAINTY, CLOSE
from stickslip.laboratory.measurement.cycles import CycleSet, LoadRemoval, synthesis, whole_cycles, zeroed
from stickslip.laboratory.measurement.reconstruction import RigErrors, reconstruct
from stickslip.laboratory.measurement.records import Record
from stickslip.model.dampers.between_platforms import BetweenPlatforms
from stickslip.results.schema import Result, described, named, tabulated
from stickslip.runs.cases import Arrays
from stickslip.solve.platforms.cycle import CycleModel, steady_cycle
from stickslip.support.checks import Array, InputError, between, fault, nearest
from stickslip.support.late import xr

SAMPLES = 400
"""Samples of a cycle in the result."""

SLIPS = {"right_rolling": "rolling dr", "right_translation": "translation ds", "right_slip": "slip ds - dr"}
"""Motions at the right contact (`reconstruction.UNITS`), and what they are called."""

SLIP_DRAWS = 60
"""Draws of the errors of the rig for those of these motions."""

FAINT = 0.08
"""Varying part of a force, relative to the larger one of the case, below which its misfit is relative to that share."""

FEWEST = 2
"""Cycles of a group: their scatter shows which harmonics of the motion are noise."""


@dataclass(frozen=True, eq=False, repr=False)
class Identification(Result):
    """values {name: SI}, intervals {name: (low, high)} at 95 %, correlation of the logarithms (unknowns, unknowns); the law they
    belong to, and the error of every law on loops held out, in standard deviations; relative
    misfit of each case and channel in `dataset`, warnings.

    Intervals are NaN where the refits that they rest on failed; a warning then has the reason. `held_out` is empty where only one
    law was asked for, since no loop was held out. `dataset` has the lag of the forces and the zeros of the cells as well, with
    their standard deviations (`lag`, `lag_error`, `zero`, `zero_error`)."""

    values: dict[str, float]
    intervals: dict[str, tuple[float, float]]
    correlation: Array
    warnings: tuple[str, ...]
    fit: DamperFit
    replicates: Array
    dataset: "xr.Dataset"
    law: str = "macroslip"
    held_out: Mapping[str, float] = field(default_factory=dict)

    def over_cycles(self, points: int = 5) -> "xr.Dataset":
        """The parameters in so many consecutive parts of the records, {name: (point,)}, SI, fitted again from those of all
        cycles: how friction develops in a test. Their scatter is that of the cycles; errors of gains are common to all parts.
        """
        return over_cycles(self.fit, np.log([self.values[p.name] for p in self.fit.unknowns]), points)


def identification_dataset(
    fit: DamperFit, theta: Array, intervals: Mapping[str, tuple[float, float]], replicates: Array, errors: tuple[float, Array]
) -> "xr.Dataset":
    """The result as a dataset: everything that figures and report need. errors: standard deviations of the lag [s] and of the
    zeros (cases, forces) [N]."""
    computed = fit.predicted(theta)
    assert computed is not None
    table, chain = synthesis(SAMPLES, (fit.data.shape[2] - 1) // 2), fit.chain(computed)
    shown = fit.recorded(computed, chain)
    shift = fit.data[..., 0] - shown[..., 0]
    zero_errors = np.full_like(shift, np.nan)
    zero_errors[:, fit.forces] = errors[1]
    platform = [
        [case.cycle(f"platform_{a}", SAMPLES) if case.has(f"platform_{a}") else np.zeros(SAMPLES) for a in "xy"]
        for case in fit.cases
    ]
    variables = {
        "value": np.exp(theta),
        "interval": np.array([intervals[p.name] for p in fit.unknowns]),
        "replicates": np.exp(replicates),
        "measured": fit.data @ table.T,
        "fitted": shown @ table.T,
        "platform_motion": np.array(platform),
        "zero": shift,
        "zero_error": zero_errors,
        "lag": chain.lag,
        "lag_error": errors[0],
        "gain": chain.gains,
        "misfit": misfits(fit, shown),
    }
    coordinates = {
        "parameter": [p.name for p in fit.unknowns],
        "parameter_units": ["N/m" if p.part in ("kt", "kn") else "1" for p in fit.unknowns],
        "case": [case.name for case in fit.cases],
        "channel": list(fit.channels),
        "axis": ["x", "y"],
        "end": ["low", "high"],
    }
    about = {"title": "Contact parameters", "analysis": "identification", "law": fit.law}
    return tabulated("damper_identification", variables, coordinates, about | {"lag_fitted": int(bool(fit.errors.lag))})


def with_slip(dataset: "xr.Dataset", fit: DamperFit, rig: BetweenPlatforms, kn: float) -> "xr.Dataset":
    """The dataset with the motions at the right contact that the lasers measured, and their standard deviations; as it is where
    rotation and damper_y were not measured or several lines touch at the right. kn: of the right line, as identified [N/m]."""
    lag = float(dataset["lag"])
    cases = [case.without_lag(lag) for case in fit.cases]
    found = [reconstruct(case, rig, fit.errors, kn=kn, samples=SAMPLES, draws=SLIP_DRAWS) for case in cases]
    if not all(name in one for one in found for name in SLIPS):
        return dataset
    slip = {
        "right_motion": np.array([[one[name].values for name in SLIPS] for one in found]),
        "right_motion_error": np.array([[one[f"{name}_error"].values for name in SLIPS] for one in found]),
        "motion": list(SLIPS.values()),
    }
    return dataset.assign(described("damper_identification", slip))


def misfits(fit: DamperFit, shown: Array) -> Array:
    """(cases, channels): rms of measured less shown, relative to the rms of the varying part of the measured signal.

    That part counts as no less than what no model is held to, and than FAINT of the larger force of the case: a force that
    symmetry holds constant shows noise and crosstalk alone."""
    left, measured, held = (np.sqrt(np.sum(part[..., 1:] ** 2, axis=2)) for part in (fit.data - shown, fit.data, fit.spread))
    size = np.maximum(measured, held)
    size[:, fit.forces] = np.maximum(size[:, fit.forces], FAINT * measured[:, fit.forces].max(axis=1, keepdims=True))
    return np.asarray(left / size)


def chain_sentences(dataset: "xr.Dataset") -> list[str]:
    """The lag of the forces, where it was fitted, and the zeros of the cells that were left in the loops, with 95 % intervals."""
    lag, error = 1e3 * float(dataset["lag"]), 1e3 * float(dataset["lag_error"])
    seen, rows = 1e3 * float(dataset.attrs["lag_seen"]), []
    if dataset.attrs["lag_fitted"]:
        rows.append(f"lag    {_with_interval(lag, error, ' ms')}, the forces behind the motions where positive")
    elif np.isfinite(seen):
        rows.append(f"lag    not fitted; the apparent lag, {seen:.2f} ms, is too small to distinguish from gradual slip")
    for case in dataset["case"].values:
        one = dataset.sel(case=case)
        cells = [str(name) for name in one["channel"].values if str(name).startswith("force")]
        zeros = [(name, float(one["zero"].sel(channel=name)), float(one["zero_error"].sel(channel=name))) for name in cells]
        rows.append(f"zeros  {case}: " + ", ".join(f"{name} {_with_interval(value, e, ' N')}" for name, value, e in zeros))
    return rows


def _with_interval(value: float, error: float, unit: str) -> str:
    """A value with its 95 % interval, to the digits that its error leaves."""
    if not np.isfinite(error):
        return f"{value:.3g}{unit} (no interval)"
    digits = int(np.clip(1 - np.floor(np.log10(max(error, 1e-9))), 0, 6))
    low, high = value - CERTAINTY * error, value + CERTAINTY * error
    return f"{value:.{digits}f}{unit} ({low:.{digits}f} to {high:.{digits}f}{unit})"


def over_cycles(fit: DamperFit, theta: Array, points: int) -> "xr.Dataset":
    """Parameters (point, parameter) of a fit to consecutive groups of cycles, from those of all cycles, theta (logarithms).

    Group k holds the kth part of the cycles of every record. NaN where no steady cycle was found.
    """
    fewest = min(len(case.harmonics) for case in fit.cases)
    between("points", points, 2)
    if fewest < FEWEST * points:
        rule = f"must be at most {fewest // FEWEST}, for groups of at least {FEWEST} cycles"
        raise fault("points", rule, points, "Record more cycles, or ask for fewer points.")
    found, numbers = np.full((points, theta.size), np.nan), np.empty((points, 2))
    parts = [np.array_split(np.arange(len(case.harmonics)), points) for case in fit.cases]
    for k in range(points):
        cases = [replace(case, harmonics=case.harmonics[part[k]]) for case, part in zip(fit.cases, parts, strict=True)]
        own = fit.with_cases(cases, np.stack([[case.channel(name) for name in fit.channels] for case in cases])).steps(COARSE)
        numbers[k] = parts[0][k][0] + 1, parts[0][k][-1] + 1
        end = own.solved(theta, evaluations=EVALUATIONS).x
        if own.predicted(end) is not None:
            found[k] = np.exp(end)
    units = {"kt": "N/m", "kn": "N/m"}
    variables = {
        p.name: named("point", found[:, i], f"{p.name} of a group of cycles", units.get(p.part, "1"))
        for i, p in enumerate(fit.unknowns)
    }
    variables["cycles"] = named(("point", "end"), numbers, "first and last cycle of the group, of the first record")
    return xr.Dataset(variables, attrs={"title": "Parameters over the cycles"})


TURN = 2.0
"""Largest rotation, relative to the platform's motion over the mean distance of the contacts from the mass centre."""

REFUSED, POOR = 0.25, 0.06
"""Misfit of forces, relative to their varying part, from which a fit is refused, and from which it is called poor."""

STILL = 1e-6
"""Friction work of a line, relative to the largest, below which it counts as never sliding."""

LAG_PRIOR = 5e-3
"""Standard deviation [s] of a lag that is looked for where `errors` do not state one."""

STRAINED = 3.0
"""Gain error or zero found, in standard deviations stated for it, from which a scale, the geometry or the zero is doubted."""

SEEN = 3e-3
"""Angle of the first harmonic [rad] from which a lag of the forces is reported: 0.1 ms at 5 Hz."""

WIDE = 0.3
"""Standard deviation of a logarithm from which a parameter counts as unknown still."""


def checked_cases(loops: Sequence[CycleSet | Record], rig: BetweenPlatforms, errors: RigErrors) -> tuple[CycleSet, ...]:
    """The cases as cycles, refused where they cannot be those of this damper."""
    if not loops:
        raise fault("loops", "must be at least one", 0)
    cases = tuple(whole_cycles(one) if isinstance(one, Record) else one for one in loops)
    if len({case.name for case in cases}) < len(cases):
        raise fault("Names of the loops", "must differ", [case.name for case in cases])
    if len({case.harmonics.shape[2] for case in cases}) > 1:
        raise fault("All loops", "must be smoothed to the same number of harmonics", [c.harmonics.shape[2] for c in cases])
    for case in cases:
        for name in ("force_x", "force_y"):
            case.channel(name)
        pull = float(rig.pull[1]) if case.pull is None else case.pull
        _check_forces(case, pull, errors.with_zeros(case.zero_errors))
        _check_work(case)
        _check_rotation(case, rig)
    return cases


def _check_forces(case: CycleSet, pull: float, errors: RigErrors) -> None:
    """Zeroed cells of a damper under its pull press both ways, and by no more than a few times the pull."""
    zeros = {axis: errors.zero_of(f"force_{axis}") for axis in "xy"}
    if max(zeros.values()) > 0.2 * pull:
        return
    x, y = float(case.channel("force_x")[0]), float(case.channel("force_y")[0])
    remedy = "Are signs, units and zeros of the cells right?"
    if y <= -3.0 * zeros["y"] or x <= -3.0 * zeros["x"]:
        raise fault(f"Mean force_x, force_y of {case.name}", "must press the right platform", (round(x, 3), round(y, 3)), remedy)
    if not 0.02 * pull <= y <= 3.0 * pull or x > 20.0 * pull:
        raise fault(
            f"Mean forces of {case.name}", f"must be of the size of the pull, {pull:g} N", (round(x, 4), round(y, 4)), remedy
        )


def _check_work(case: CycleSet) -> None:
    """A damper takes energy out: the loop ∮(H dh + V dw) runs one way, against the package's sense of the axes."""
    done, scale = 0.0, 0.0
    for axis in "xy":
        if case.has(f"platform_{axis}"):
            u, f = case.cycle(f"platform_{axis}"), case.cycle(f"force_{axis}")
            done += float(np.sum(f * (np.roll(u, -1) - np.roll(u, 1)))) / 2.0
            scale += float(np.ptp(u) * np.ptp(f))
    if done < -0.01 * scale:
        rule = "must be taken out of the platforms, a positive area"
        raise fault(f"The energy of {case.name}", rule, float(f"{done:.3g}"), "Is a sign reversed, or time?")


def _check_rotation(case: CycleSet, rig: BetweenPlatforms) -> None:
    """Rotation cannot exceed a few times the platform's motion over the size of the damper."""
    if not case.has("rotation"):
        return
    motion = max(float(np.ptp(case.cycle(f"platform_{a}"))) for a in "xy" if case.has(f"platform_{a}"))
    size = float(np.mean([np.hypot(*point.arm) for point in rig.points]))
    found = float(np.ptp(case.cycle("rotation")))
    if found > TURN * motion / size:
        rule = f"must be below {TURN * motion / size:.3g} rad for this motion"
        raise fault(f"rotation of {case.name}", rule, float(f"{found:.3g}"), "Is its unit right?")


def never_sliding(fit: DamperFit, theta: Array, rig: BetweenPlatforms) -> tuple[str, ...]:
    """Which friction coefficients belong to lines that stick throughout every steady cycle."""
    if fit.law != "macroslip":
        return ()
    values, work = fit.values(theta), np.zeros(len(fit.lines))
    for pull, drive in zip(fit.pulls, fit.drives, strict=True):
        mu = values["mu"] * values[TENFOLD] ** np.log10(pull / (fit.at * len(fit.lines)))
        model = CycleModel.of(rig.with_pull(pull)).with_parameters(values["kt"], values["kn"], mu)
        work += np.abs(slip_work(model, steady_cycle(model, drive)))
    still = work <= STILL * work.max()
    return tuple(
        f"{p.name}: its contact never slides in the steady cycles. The value follows from slip while the centrifugal "
        "load was applied to sliders that are assumed to be virgin; the loops themselves only show a lower bound."
        for p in fit.unknowns
        if p.part == "mu" and all(still[p.lines(fit.lines)])
    )


def strained_gains(fit: DamperFit, computed: Array) -> tuple[str, ...]:
    """Which channels fit only with a gain error that the stated errors hardly allow: parameters are then wrong all the same."""
    stated = {name: fit.errors.gain(name) for name in fit.channels}
    return tuple(
        f"{name} fits only with a gain error of {gain:+.0%}, against {stated[name]:.0%} stated. The parameters are wrong if "
        "a scale of the record, a dimension or angle of the damper, or its pull is wrong: check them."
        for name, gain in zip(fit.channels, fit.chain(computed).gains, strict=True)
        if stated[name] > 0.0 and abs(gain) > STRAINED * stated[name]
    )


def strained_zeros(fit: DamperFit, computed: Array) -> tuple[str, ...]:
    """Which cells fit only with a zero that its stated error hardly allows."""
    zeros, warnings = fit.zeros(computed, fit.chain(computed)), []
    for case, of_case in zip(fit.cases, zeros, strict=True):
        for c, zero in zip(fit.forces, of_case, strict=True):
            name = fit.channels[c]
            stated = fit.errors.with_zeros(case.zero_errors).zero_of(name)
            if stated > 0.0 and abs(zero) > STRAINED * stated:
                warnings.append(
                    f"{case.name}: {name} fits only with a zero of {zero:+.3g} N, against {stated:.2g} N stated. If the zeros "
                    f"of the cells are not known, give a load removal, or state their error in `errors` (zero_{name[-1]})."
                )
    return tuple(warnings)


def lag_remarks(fit: DamperFit, theta: Array, error: float) -> tuple[str, ...]:
    """A lag of the forces that matters: corrected where it was fitted, stated where `errors.lag` of 0 excludes it."""
    computed = fit.predicted(theta)
    assert computed is not None
    fitted = bool(fit.errors.lag)
    lag = (fit if fitted else fit.with_lag(LAG_PRIOR)).chain(computed).lag
    angle = 2.0 * np.pi * lag * max(case.frequency for case in fit.cases)
    if abs(angle) < SEEN or (fitted and abs(lag) < CERTAINTY * error):
        return ()
    delay = f"{abs(1e3 * lag):.2g} ms {'behind' if lag > 0.0 else 'before'} the motions"
    if not fitted:
        return (
            f"The forces seem to come {delay}, which `errors` exclude (lag = 0): contact stiffness is then wrong. Give the "
            "standard deviation of `lag` to fit it.",
        )
    alike = "viscous damping in parallel, or a filter of the motions," if lag < 0.0 else "a filter of the forces"
    return (
        f"The forces come {delay}. The fit corrects it as a lag, but {alike} looks the same: a record at another frequency "
        "shows whether the time is the same there.",
    )


def friction_over_load(fit: DamperFit, theta: Array, scatter: Array) -> tuple[str, ...]:
    """What the unknown `tenfold` says: the power of the load that the coefficients follow, or that the loops do not show one."""
    names = [p.name for p in fit.unknowns]
    if TENFOLD not in names:
        return ()
    k = names.index(TENFOLD)
    exponent, error = theta[k] / np.log(10.0), CERTAINTY * scatter[k] / np.log(10.0)
    if not abs(exponent) > error:  # NaN too
        if len({*fit.pulls}) == 1:
            return (f"All loops have one pull, which hardly shows {TENFOLD}: measure at another pull, too, or leave it out.",)
        return (
            f"The loops do not show that friction depends on the load: {TENFOLD} = 1 lies within its interval. Remove {TENFOLD} "
            "from unknown, or measure at pulls that differ more.",
        )
    return (
        f"The friction coefficients are those at a normal load of {fit.at:.4g} N on a line, and follow the power {exponent:.3f} "
        f"of the load (95 % interval {exponent - error:.3f} to {exponent + error:.3f}). In a study write mu = {{ value = ..., at "
        f"= {fit.at:.4g}, exponent = {exponent:.3f} }}.",
    )


def remarks(fit: DamperFit, theta: Array, scatter: Array) -> tuple[str, ...]:
    """What must be known of the result; a fit that explains the loops badly is refused."""
    computed = fit.predicted(theta)
    assert computed is not None
    found, bare = misfits(fit, fit.recorded(computed, fit.chain(computed))), misfits(fit, computed)  # a gain may turn a sign
    warnings = [*strained_gains(fit, computed), *strained_zeros(fit, computed)]
    table = synthesis(200, (fit.data.shape[2] - 1) // 2)
    for k, case in enumerate(fit.cases):
        for c, channel in enumerate(fit.channels):
            a, b = table @ fit.data[k, c], table @ computed[k, c]
            alike = float(np.corrcoef(a, b)[0, 1])
            if alike < -0.5 and bare[k, c] > REFUSED:
                raise InputError(
                    f"{channel} of {case.name} runs against the model (correlation {alike:.2f}). Is its sign reversed?"
                )
            if channel.startswith("force") and found[k, c] > REFUSED:
                raise InputError(
                    f"The best contact parameters miss {channel} of {case.name} by {found[k, c]:.0%} of its varying part. "
                    "Check geometry, pull, signs and units; no parameters are given."
                )
            if found[k, c] > (POOR if channel.startswith("force") else 0.3):
                warnings.append(f"{case.name}: {channel} is missed by {found[k, c]:.0%} of its varying part.")
    low, high = fit.bounds
    for p, t, s, a, b in zip(fit.unknowns, theta, scatter, low, high, strict=True):
        if min(t - a, b - t) < 1e-3:
            warnings.append(f"{p.name} lies at the end of its range ({np.exp(t):.4g}): the loops do not limit it.")
        elif s > WIDE and not (p.name == TENFOLD and len({*fit.pulls}) == 1):
            warnings.append(f"These loops hardly depend on {p.name}: its interval is wide.")
    warnings += friction_over_load(fit, theta, scatter)
    if "rotation" not in fit.channels:
        warnings.append("No rotation was measured: other parameters may fit equally well.")
    return tuple(warnings)


GRADUAL = 6e-3
"""Angle of the first harmonic [rad] by which forces lag or lead where contacts slip more gradually than the law that is fitted
(0.2 ms at 5 Hz; up to half of it was measured): a lag is fitted from there on."""


def _laws(name: str, law: Any) -> tuple[str, ...]:
    laws = (law,) if isinstance(law, str) else tuple(law)
    for each in laws:
        if each not in LINE_LAWS:
            raise fault("law", "must be a known one", each, nearest(each, LINE_LAWS))
    if not laws or len(set(laws)) < len(laws):
        raise fault("law", "must be at least one, each once", list(laws))
    return laws


@dataclass(frozen=True, eq=False)
class IdentificationWork(Settings):
    """An identification as work of one case, which studies keep and resume."""

    loops: Sequence[CycleSet | Record] | CycleSet | Record
    damper: BetweenPlatforms
    unknown: Sequence[str] = ()
    _: KW_ONLY
    law: Annotated[str | Sequence[str], Setting(_laws)] = "macroslip"
    errors: RigErrors | None = None
    bounds: Mapping[str, tuple[float, float]] | None = None
    steps: int = 500
    resamples: Annotated[int, Setting(Whole(8))] = 24
    population: int = 6
    generations: int = 15
    seed: Seed = 0
    progress: Callable[[float], object] | None = None
    load_removal: LoadRemoval | Sequence[LoadRemoval] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "unknown", tuple(self.unknown or usual_unknowns(self.damper)))
        if len(self.law) > 1 and len(self.cases) < 2:
            raise fault("loops", "must be at least two, to hold one out and choose a law", len(self.cases), "Name one law.")
        _ = self.fit

    @property
    def rig_errors(self) -> RigErrors:
        """Those given, or the usual ones."""
        return RigErrors() if self.errors is None else self.errors

    @cached_property
    def cases(self) -> tuple[CycleSet, ...]:
        """The loops as checked cycles, with the zeros of their cells where load removals give them."""
        loops = [self.loops] if isinstance(self.loops, CycleSet | Record) else list(self.loops)
        if self.load_removal is not None:
            loops = [*zeroed(loops, self.load_removal, self.rig_errors.calibration)]
        return checked_cases(loops, self.damper, self.rig_errors)

    @property
    def names(self) -> Sequence[str]:
        zeros = str([sorted(case.zero_errors.items()) for case in self.cases])
        digest = sha256(b"".join(case.harmonics.tobytes() for case in self.cases) + zeros.encode()).hexdigest()[:12]
        return (f"identification {digest}, {self.identity('loops', 'damper', 'load_removal')}",)

    @property
    def words(self) -> Sequence[str]:
        return (f"{len(self.unknown)} parameters",)

    def prepare(self) -> None:
        """Compile the cycle."""
        self.fit.steps(COARSE).predicted(np.mean(self.fit.bounds, axis=0))

    @cached_property
    def fit(self) -> DamperFit:
        """Loops and model."""
        unknowns = parameters(self.unknown, self.damper, self.bounds or {})
        return DamperFit.of(self.cases, self.damper, unknowns, self.rig_errors, self.steps)

    def solve(self, case: int, report: Callable[[float], object]) -> Arrays:
        """Logarithms of the unknowns of the law that is chosen, and of their refits; errors of all laws on loops held out."""
        fit, seen = self.fit, np.nan
        best, others = self._searched(fit, lambda share: report(0.4 * share))
        if self.rig_errors.lag is None:
            largest, late = GRADUAL / (2.0 * np.pi * max(case.frequency for case in self.cases)), fit.with_lag(LAG_PRIOR)
            coarse = late.steps(COARSE)
            seen = coarse.lag_at(coarse.solved(best, evaluations=EVALUATIONS).x)
            if abs(seen) > largest:
                there = self._searched(late, lambda share: report(0.4 + 0.1 * share))
                seen = late.lag_at(there[0])
                # A lag that another minimum seemed to show is none, but has led to a better one.
                fit, (best, others) = (late, there) if abs(seen) > largest else (fit, fitted(fit, np.array([best, there[0]])))
        fits = {law: fit.with_law(law) for law in LINE_LAWS if law in self.law}
        thetas = {law: fitted_with_law(fit, best) for law, fit in fits.items()}
        errors = {law: held_out(fit, thetas[law]) for law, fit in fits.items()} if len(fits) > 1 else {}
        law = next(law for law in fits if not errors or errors[law] <= CLOSE * min(errors.values()))
        report(0.6)
        places = others if law == "macroslip" else thetas[law][None]
        again = refits(fits[law], thetas[law], places, self.resamples, self.seed, lambda share: report(0.6 + 0.4 * share))
        number, counts = np.array(list(LINE_LAWS).index(law)), np.array([again.lost, again.cycles, again.missing])
        held = np.array(list(errors.values()))
        again_too = {"replicates": again.values, "lags": again.lags, "zeros": again.zeros, "counts": counts}
        lag = np.array([fit.errors.lag or 0.0, seen])
        return {"theta": thetas[law], **again_too, "law": number, "held_out": held, "lag_prior": lag}

    def _searched(self, fit: DamperFit, report: Callable[[float], object]) -> tuple[Array, Array]:
        """The best of the whole range, and other minima that are about as good."""
        return fitted(fit, population(fit.steps(COARSE), self.population, self.generations, self.seed, report))

    def identification(self, arrays: Arrays) -> Identification:
        """The result from the arrays of `solve`."""
        theta, replicates = np.asarray(arrays["theta"]), np.asarray(arrays["replicates"])
        law = list(LINE_LAWS)[int(arrays["law"])]
        prior, seen = map(float, arrays["lag_prior"])
        fit = self.fit.with_lag(prior).with_law(law)
        lost, cycles, missing = map(int, arrays["counts"])
        again = Refits(replicates, lost, cycles, missing, np.asarray(arrays["lags"]), np.asarray(arrays["zeros"]))
        scatter, lag_error, zero_errors = again.errors(theta)
        names = [p.name for p in fit.unknowns]
        values = dict(zip(names, map(float, np.exp(theta)), strict=True))
        ends = np.exp(np.stack([theta - CERTAINTY * scatter, theta + CERTAINTY * scatter], axis=1))
        intervals = {name: (float(low), float(high)) for name, (low, high) in zip(names, ends, strict=True)}
        of_cases = (sentence for case in self.cases for sentence in case.warnings)
        counted = (sentence for sentence in (again.refusal, again.remark) if sentence)
        late = lag_remarks(fit, theta, lag_error) if prior or self.rig_errors.lag is not None else ()
        warnings = (*counted, *of_cases, *late, *remarks(fit, theta, scatter), *never_sliding(fit, theta, self.damper))
        with np.errstate(invalid="ignore", divide="ignore"):
            enough = len(replicates) > 1
            correlation = np.atleast_2d(np.corrcoef(replicates.T)) if enough else np.full((theta.size, theta.size), np.nan)
        dataset = identification_dataset(fit, theta, intervals, replicates, (lag_error, zero_errors))
        dataset.attrs |= {"warnings": "\n".join(warnings), "lag_seen": seen}
        dataset = with_slip(dataset, fit, self.damper, float(fit.values(theta)["kn"][-1]))
        several = [one for one in LINE_LAWS if one in self.law] if len(self.law) > 1 else []
        errors = dict(zip(several, map(float, arrays["held_out"]), strict=True))
        if errors:
            known = {"held_out": list(errors.values()), "law": several}
            dataset = dataset.assign(described("damper_identification", known))
        return Identification(values, intervals, correlation, warnings, fit, replicates, dataset, law, errors)


@takes(IdentificationWork)
def identify(work: IdentificationWork) -> Identification:
    """Contact parameters of a damper from measured cycles of one or several cases.

    loops: records or cycles (`whole_cycles`) with platform motion, force_x, force_y and, if measured, rotation and damper_y,
    which select the right one of several minima. damper: geometry, pull, and values of the known parameters.
    unknown: kt, kn or mu of all lines, or of those whose names begin with what follows: mu_L1, mu_R, kt_L; by default those of
    `usual_unknowns`. With "tenfold" among them, all friction coefficients follow a power e of the normal load N of their line, μ
    (N/N0)^e with tenfold = 10^e; mu is that at N0, the geometric mean of the pulls divided by the number of lines.
    law: of all lines, "macroslip", "iwan" or "microslip"; of several, the simplest one whose error in predicting each case from
    the others is within 10 % of the smallest, which needs two cases. errors: of the rig, as priors of gains, zeros and lag and
    for the intervals. load_removal: readings from which the zeros of the cells follow (`read_load_removal`), one for all loops or
    one each; the records then hold raw readings. bounds: {name: (low, high)} SI. steps: of a computed cycle in the final fit.
    resamples: refits for the intervals; population (times unknowns), generations: of the search. progress(share): callback.
    """
    return work.identification(work.solve(0, work.progress or (lambda share: None)))
