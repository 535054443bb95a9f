"""Presentation of the band of a performance curve over the start states."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from stickslip.results.view import size_text
from stickslip.show.plots.files import Figures
from stickslip.show.plots.performance_curve import performance_band
from stickslip.show.report.markup import percent
from stickslip.show.report.presentation import Presentation, presents
from stickslip.support.outcome import Outcome

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def sentences(dataset: xr.Dataset) -> list[str]:
    """Where the band is widest, and which F_C/F_E has the lowest of the highest peaks."""
    low, high = dataset["amplitude_per_force"].values.T
    ratios, units = dataset["force_ratio"].values, dataset["amplitude_per_force"].attrs["units"]
    if not np.isfinite(low).any():
        return ["no bound of the resonance was found"]
    widest, safest = int(np.nanargmax(high / low)), int(np.nanargmin(high))
    ends = f"{size_text(low[widest], units, dataset)} to {size_text(high[widest], units, dataset)}"
    unsolved = dataset["unsolved_share"].values
    most = int(np.argmax(unsolved))
    fewer = f"{percent(unsolved[most])} of the sampled start states have no solution at F_C/F_E = {ratios[most]:.4g}"
    return [
        f"band widest at F_C/F_E = {ratios[widest]:.4g}: the peak is {ends}, the highest "
        f"{percent(high[widest] / low[widest] - 1.0)} above the lowest, depending on where the contacts start",
        f"lowest of the highest peaks: {size_text(high[safest], units, dataset)} at F_C/F_E = {ratios[safest]:.4g}",
        *([fewer] if unsolved[most] else []),
    ]


def failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for each value of F_C/F_E without a bound."""
    sentences = []
    columns = (dataset[name].values for name in ("force_ratio", "outcome", "unsolved_share"))
    for ratio, outcomes, unsolved in zip(*columns, strict=True):
        bad = outcomes[outcomes != Outcome.CONVERGED]
        if bad.size:
            share = f" {percent(unsolved)} of the sampled start states have no solution." if unsolved else ""
            sentences.append(f"F_C/F_E {ratio:.4g}: {Outcome(int(bad[0])).sentence}{share}")
    return sentences


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Both ends of the band at every point."""
    import pandas as pd

    units = dataset["amplitude_per_force"].attrs["units"]
    columns = {"F_C/F_E": dataset["force_ratio"].values, f"virgin [{units}]": dataset["virgin_amplitude_per_force"].values}
    for bound, name in enumerate(("lowest", "highest")):
        columns[f"{name} [{units}]"] = dataset["amplitude_per_force"].values[:, bound]
        columns[f"{name}, at Hz"] = dataset["frequency"].values[:, bound]
        columns[f"{name}, loss factor"] = dataset["loss_factor"].values[:, bound]
    columns["solutions"] = dataset["solves"].values
    return {"band of the performance curve": pd.DataFrame(columns)}


def figures(dataset: xr.Dataset) -> Figures:
    """The band of amplitude and frequency."""
    return {"performance_band": performance_band}


PRESENTATION = presents("performance_band", Presentation("Band of the performance curve", sentences, failures, figures, tables))
