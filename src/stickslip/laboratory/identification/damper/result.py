"""What an identification of a damper is given as: the result, its dataset and sentences, and parameters over the cycles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from stickslip.laboratory.identification.damper.fit import COARSE, EVALUATIONS, DamperFit
from stickslip.laboratory.identification.least_squares import CERTAINTY
from stickslip.laboratory.measurement.cycles import synthesis
from stickslip.laboratory.measurement.reconstruction import reconstruct
from stickslip.model.dampers.between_platforms import BetweenPlatforms
from stickslip.results.schema import Result, described, named, tabulated
from stickslip.support.checks import Array, between, fault
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
    dataset: xr.Dataset
    law: str = "macroslip"
    held_out: Mapping[str, float] = field(default_factory=dict)

    def over_cycles(self, points: int = 5) -> xr.Dataset:
        """The parameters in so many consecutive parts of the records, {name: (point,)}, SI, fitted again from those of all
        cycles: how friction develops in a test. Their scatter is that of the cycles; errors of gains are common to all parts.
        """
        return over_cycles(self.fit, np.log([self.values[p.name] for p in self.fit.unknowns]), points)


def identification_dataset(
    fit: DamperFit, theta: Array, intervals: Mapping[str, tuple[float, float]], replicates: Array, errors: tuple[float, Array]
) -> xr.Dataset:
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


def with_slip(dataset: xr.Dataset, fit: DamperFit, rig: BetweenPlatforms, kn: float) -> xr.Dataset:
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


def chain_sentences(dataset: xr.Dataset) -> list[str]:
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


def over_cycles(fit: DamperFit, theta: Array, points: int) -> xr.Dataset:
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
