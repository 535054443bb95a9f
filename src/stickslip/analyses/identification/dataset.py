"""An identification with labels: parameters with intervals, replicates, and loops measured and fitted."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from stickslip.analyses.identification.damper_fit import DamperFit
from stickslip.analyses.identification.result_checks import misfits
from stickslip.checks import Array
from stickslip.measurement.cycles import synthesis

if TYPE_CHECKING:
    import xarray as xr

SAMPLES = 400


def identification_dataset(
    fit: DamperFit, theta: Array, intervals: Mapping[str, tuple[float, float]], replicates: Array, warnings: tuple[str, ...]
) -> xr.Dataset:
    """The result as a dataset: everything that figures and report need."""
    import xarray as xr

    computed = fit.predicted(theta)
    assert computed is not None
    table, gains = synthesis(SAMPLES, (fit.data.shape[2] - 1) // 2), fit.gains(computed)
    shown = (1.0 + gains[:, None]) * computed
    shift = fit.data[..., 0] - shown[..., 0]
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
        "gain": (("channel",), gains, {"units": "1", "long_name": "gain error of the channel"}),
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
    said = {"title": "Contact parameters", "analysis": "identification", "law": fit.law, "warnings": "\n".join(warnings)}
    return xr.Dataset(variables, labels, said)


def with_laws(dataset: xr.Dataset, errors: Mapping[str, float]) -> xr.Dataset:
    """The dataset with the errors of several laws on loops held out."""
    words = {"units": "1", "long_name": "error on loops held out, in standard deviations"}
    names = {"units": "1", "long_name": "law of the lines of contact"}
    return dataset.assign(held_out=("law", list(errors.values()), words)).assign_coords(law=("law", list(errors), names))
