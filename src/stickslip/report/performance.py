"""How performance curves are told."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from stickslip.plots.files import Figures
from stickslip.plots.performance_curve import dissipation, performance_curves
from stickslip.report.presentation import Presentation

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

REGIONS = ("stick", "microslip", "slip", "lift-off")


def sentences(dataset: xr.Dataset) -> list[str]:
    """The optimum of every curve, its plateau, and what happened to peaks."""
    lines = []
    for case, mu in enumerate(dataset["friction"].values):
        one = {name: float(dataset[name].values[case]) for name in _OPTIMUM}
        name = "friction of the problem" if np.isnan(mu) else f"friction {mu:g}"
        if not np.isfinite(one["optimum_ratio"]):
            lines.append(f"{name}: no resonance was found")
            continue
        ends = [f"{one[key]:.4g}" if np.isfinite(one[key]) else "beyond the range" for key in ("plateau_low", "plateau_high")]
        lines.append(
            f"{name}: lowest resonance {one['optimum_amplitude_per_force']:.4g} m/N at F_C/F_E = {one['optimum_ratio']:.4g} and "
            f"{one['optimum_frequency']:.5g} Hz; within 10 % of it from {ends[0]} to {ends[1]}"
        )
        lines += [f"  {name}: {words}" for words in _detached(dataset, case)]
        lines += [f"  {name}: {words}" for words in dataset["event"].values[case] if words]
    return lines


_OPTIMUM = ("optimum_ratio", "optimum_amplitude_per_force", "optimum_frequency", "plateau_low", "plateau_high")


def _detached(dataset: xr.Dataset, case: int) -> list[str]:
    """Where higher peaks lie apart from the curve."""
    heights, ratios = dataset["detached_amplitude_per_force"].values[case], dataset["force_ratio"].values
    apart = ratios[np.isfinite(heights)]
    if not apart.size:
        return []
    where = f"{apart[0]:.4g}" if apart.size == 1 else f"{apart[0]:.4g} to {apart[-1]:.4g}"
    return [
        f"F_C/F_E {where}: higher peaks, up to {np.nanmax(heights):.4g} m/N, lie on a curve apart, which no sweep meets; "
        "they do not count, and may be unstable (a time simulation tells)"
    ]


def failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for each curve with points where no peak was found."""
    found = []
    for case, outcomes in enumerate(dataset["outcome"].values):
        missing = dataset["force_ratio"].values[outcomes != 1]
        if missing.size:
            found.append(f"curve {case + 1}: no peak was found at {missing.size} values of F_C/F_E, the first {missing[0]:.4g}")
    return found


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Every point of every curve."""
    import pandas as pd

    rows = []
    for case, mu in enumerate(dataset["friction"].values):
        for k, ratio in enumerate(dataset["force_ratio"].values):
            at = dataset.isel(case=case, point=k)
            region = float(at["region"])
            rows.append(
                {
                    "friction": float(mu),
                    "F_C/F_E": float(ratio),
                    "frequency [Hz]": float(at["frequency"]),
                    "amplitude per force [m/N]": float(at["amplitude_per_force"]),
                    "inertance [m/(s2 N)]": float(at["inertance"]),
                    "relative to no contacts": float(at["normalised_amplitude"]),
                    "contacts": REGIONS[int(region)] if np.isfinite(region) else "",
                    "loss factor": float(at["loss_factor"]),
                    "apart from the curve [m/N]": float(at["detached_amplitude_per_force"]),
                }
            )
    return {"performance curves": pd.DataFrame(rows)}


def figures(dataset: xr.Dataset) -> Figures:
    """The curves as amplitude and as inertance, and which contact dissipates."""
    return {
        "performance_curve": performance_curves,
        "performance_inertance": lambda data: performance_curves(data, "inertance"),
        "dissipation": dissipation,
    }


PRESENTATION = Presentation("Performance curves", sentences, failures, figures, tables)
