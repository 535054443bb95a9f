"""Presentation of limit cycles."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from stickslip.results.view import length_text
from stickslip.show.plots.files import Figures
from stickslip.show.plots.nonlinear_modes import frequency_over_damping, over_damping
from stickslip.show.report.markup import hertz, number
from stickslip.show.report.presentation import Presentation, presents
from stickslip.support.outcome import Outcome

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def sentences(dataset: xr.Dataset) -> list[str]:
    """The largest negative damping that each mode holds, and what vibration does at every aerodynamic damping."""
    lines, output = [], str(dataset["output"].values[0])
    for case in range(dataset.sizes["case"]):
        mode = dataset.isel(case=case)
        name, most = f"mode {int(mode['mode_number'])}", float(mode["held_damping"])
        if not np.isfinite(most):
            lines.append(f"{name}: no motion was found")
            continue
        size = length_text(float(mode["held_amplitude"][0]), dataset)
        where = f"{size} of {output} and {hertz(float(mode['held_frequency']))} Hz"
        edge = "" if float(mode["held_inside"]) else ", an end of the computed amplitudes"
        if most > 0.0:
            lines.append(f"{name}: holds an aerodynamic damping of down to {number(-100.0 * most, 3)} %, at {where}{edge}")
        else:
            lines.append(f"{name}: vibration grows at all amplitudes, least at {where}{edge}")
        for ratio in dataset["aerodynamic_damping"].values:
            what = str(mode["limit_cycle_message"].sel(aerodynamic_damping=ratio).item())
            lines.append(f"  {name}, aerodynamic damping {number(100.0 * float(ratio), 3)} %: {what}")
    return lines


def failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for each mode whose curve ended early."""
    outcomes = dataset["case_outcome"].values
    return [
        f"mode {int(dataset['mode_number'].values[case])}: {dataset['case_message'].values[case]}"
        for case in np.flatnonzero(outcomes != Outcome.CONVERGED)
    ]


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Every limit cycle, and the curve on which they lie."""
    import pandas as pd

    cycles, curves = [], []
    for case, d, k in np.argwhere(np.isfinite(dataset["frequency"].values)):
        one = dataset.isel(case=case, aerodynamic_damping=d, limit_cycle=k)
        row: dict[str, object] = {"mode": int(one["mode_number"]), "aerodynamic damping ratio": float(one["aerodynamic_damping"])}
        row |= {"stable": "yes" if float(one["stable"]) else "no", "frequency [Hz]": float(one["frequency"])}
        row |= {f"{name} [m]": float(one["amplitude"][o]) for o, name in enumerate(dataset["output"].values)}
        row["energy [J]"] = float(one["energy"])
        row["dissipated in contacts [J]"] = float(np.nansum(one["dissipated"].values))
        cycles.append(row)
    for case in range(dataset.sizes["case"]):
        one = dataset.isel(case=case)
        there = np.isfinite(one["curve_damping"].values)
        columns = {"mode": np.full(int(there.sum()), int(one["mode_number"]))}
        columns["aerodynamic damping ratio"] = -one["curve_damping"].values[there]
        columns["dζ/d ln A"] = one["curve_slope"].values[there]
        columns["frequency [Hz]"] = one["curve_frequency"].values[there]
        for output, name in enumerate(dataset["output"].values):
            columns[f"{name} [m]"] = one["curve_amplitude"].values[there, output]
        columns["energy [J]"] = one["curve_energy"].values[there]
        curves.append(pd.DataFrame(columns))
    curve = pd.concat(curves, ignore_index=True)
    return {"limit cycles": pd.DataFrame(cycles), "limit cycles by aerodynamic damping": curve}


def figures(dataset: xr.Dataset) -> Figures:
    """Amplitude and frequency over the aerodynamic damping."""
    return {"limit_cycles": over_damping, "limit_cycle_frequency": frequency_over_damping}


PRESENTATION = presents("limit_cycles", Presentation("Limit cycles", sentences, failures, figures, tables))
