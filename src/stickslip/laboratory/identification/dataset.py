"""Labelled dataset of an identification: parameters with intervals, replicates, measured and fitted loops."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from stickslip.laboratory.identification.damper_fit import DamperFit
from stickslip.laboratory.measurement.cycles import synthesis
from stickslip.laboratory.measurement.reconstruction import reconstruct
from stickslip.model.dampers.between_platforms import BetweenPlatforms
from stickslip.support.checks import Array

if TYPE_CHECKING:
    import xarray as xr

SAMPLES = 400
"""Samples of a cycle in the result."""

SLIPS = {"right_rolling": "rolling dr", "right_translation": "translation ds", "right_slip": "slip ds - dr"}
"""Motions at the right contact (`reconstruction.UNITS`), and what they are called."""

SLIP_DRAWS = 60
"""Draws of the errors of the rig for those of these motions."""

CERTAINTY = 1.96
"""Standard deviations of a 95 % interval."""


def identification_dataset(
    fit: DamperFit,
    theta: Array,
    intervals: Mapping[str, tuple[float, float]],
    replicates: Array,
    chain_errors: tuple[float, Array],
    warnings: tuple[str, ...],
) -> xr.Dataset:
    """The result as a dataset: everything that figures and report need. chain_errors: standard deviations of the lag [s] and of
    the zeros (cases, forces) [N]."""
    import xarray as xr

    computed = fit.predicted(theta)
    assert computed is not None
    table, chain = synthesis(SAMPLES, (fit.data.shape[2] - 1) // 2), fit.chain(computed)
    shown = fit.recorded(computed, chain)
    shift = fit.data[..., 0] - shown[..., 0]
    zero_errors = np.full_like(shift, np.nan)
    zero_errors[:, fit.forces] = chain_errors[1]
    platform = [
        [case.cycle(f"platform_{a}", SAMPLES) if case.has(f"platform_{a}") else np.zeros(SAMPLES) for a in "xy"]
        for case in fit.cases
    ]
    units = ["1" if p.part in ("mu", "gaps") else "N/m" for p in fit.unknowns]
    bounds = np.array([intervals[p.name] for p in fit.unknowns])
    loop = ("case", "channel", "sample")
    variables = {
        "value": ("parameter", np.exp(theta), {"units": "parameter_units", "long_name": "identified value"}),
        "interval": (("parameter", "end"), bounds, {"units": "parameter_units", "long_name": "95 % interval"}),
        "replicates": (
            ("replicate", "parameter"),
            np.exp(replicates),
            {"units": "parameter_units", "long_name": "values of refits"},
        ),
        "measured": (loop, fit.data @ table.T, {"units": "N, rad, m", "long_name": "measured cycle"}),
        "fitted": (loop, shown @ table.T, {"units": "N, rad, m", "long_name": "computed cycle, with the gains found"}),
        "platform_motion": (
            ("case", "axis", "sample"),
            np.array(platform),
            {"units": "m", "long_name": "motion of the left platform"},
        ),
        "zero": (("case", "channel"), shift, {"units": "N, rad, m", "long_name": "measured less fitted mean"}),
        "zero_error": (("case", "channel"), zero_errors, {"units": "N", "long_name": "standard deviation of the zero of a cell"}),
        "lag": ((), chain.lag, {"units": "s", "long_name": "lag of the forces behind the motions"}),
        "lag_error": ((), chain_errors[0], {"units": "s", "long_name": "standard deviation of the lag"}),
        "gain": (("channel",), chain.gains, {"units": "1", "long_name": "gain error of the channel"}),
        "misfit": (
            ("case", "channel"),
            misfits(fit, computed),
            {"units": "1", "long_name": "misfit, relative"},
        ),
    }
    coordinates = {
        "parameter": ("parameter", [p.name for p in fit.unknowns], "unknown"),
        "parameter_units": ("parameter", units, "units of the unknown"),
        "case": ("case", [case.name for case in fit.cases], "measured loop"),
        "channel": ("channel", list(fit.channels), "signal"),
        "axis": ("axis", ["x", "y"], "direction of the platform"),
        "end": ("end", ["low", "high"], "end of the interval"),
    }
    labels = {name: (dim, names, {"units": "1", "long_name": words}) for name, (dim, names, words) in coordinates.items()}
    attributes = {
        "title": "Contact parameters",
        "analysis": "identification",
        "law": fit.law,
        "lag_fitted": int(bool(fit.errors.lag)),
        "warnings": "\n".join(warnings),
    }
    return xr.Dataset(variables, labels, attributes)


def with_slip(dataset: xr.Dataset, fit: DamperFit, rig: BetweenPlatforms, kn: float) -> xr.Dataset:
    """The dataset with the motions at the right contact that the lasers measured, and their standard deviations; as it is where
    rotation and damper_y were not measured or several lines touch at the right. kn: of the right line, as identified [N/m]."""
    lag = float(dataset["lag"])
    cases = [case.without_lag(lag) for case in fit.cases]
    found = [reconstruct(case, rig, fit.errors, kn=kn, samples=SAMPLES, draws=SLIP_DRAWS) for case in cases]
    if not all(name in one for one in found for name in SLIPS):
        return dataset
    place, units = ("case", "motion", "sample"), {"units": "m"}
    motion = [[one[name].values for name in SLIPS] for one in found]
    error = [[one[f"{name}_error"].values for name in SLIPS] for one in found]
    return dataset.assign(
        right_motion=(place, np.array(motion), units | {"long_name": "measured motion at the right contact, less its mean"}),
        right_motion_error=(place, np.array(error), units | {"long_name": "standard deviation of that motion"}),
    ).assign_coords(motion=("motion", list(SLIPS.values()), {"units": "1", "long_name": "which motion"}))


def misfits(fit: DamperFit, computed: Array) -> Array:
    """(cases, channels): rms of measured less computed, relative to the rms of the varying part of the measured signal."""
    left = fit.data - fit.recorded(computed, fit.chain(computed))
    return np.asarray(np.sqrt(np.sum(left[..., 1:] ** 2, axis=2) / np.sum(fit.data[..., 1:] ** 2, axis=2)))


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


def with_laws(dataset: xr.Dataset, errors: Mapping[str, float]) -> xr.Dataset:
    """The dataset with the errors of several laws on loops held out."""
    words = {"units": "1", "long_name": "error on loops held out, in standard deviations"}
    names = {"units": "1", "long_name": "law of the lines of contact"}
    return dataset.assign(held_out=("law", list(errors.values()), words)).assign_coords(law=("law", list(errors), names))
