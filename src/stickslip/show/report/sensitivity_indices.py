"""Presentation of sensitivity indices."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from stickslip.results.view import measure_in, shown_unit
from stickslip.show.plots.files import Figures
from stickslip.show.plots.variability import tornado
from stickslip.show.report.presentation import Presentation, presents
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def sentences(dataset: xr.Dataset) -> list[str]:
    """Middle and spread of the resonance, and its parameters from the strongest to the weakest."""
    names = [str(name) for name in dataset["parameter"].values]
    lines = []
    measure, units = measure_in(dataset), dataset["middle"].attrs["units"].removesuffix(" and Hz")
    unit_of_size = shown_unit(units, float(dataset["middle"].values[0]), dataset)
    what = "amplitude" if measure == DISPLACEMENT_AMPLITUDE else measure.words
    for q, (quantity, size, unit) in enumerate(((what, unit_of_size.metres, unit_of_size.name), ("frequency", 1.0, "Hz"))):
        middle, spread = (float(dataset[key].values[q]) / size for key in ("middle", "spread"))
        total, interval = dataset["total"].values[:, q], dataset["total_interval"].values[:, q]
        ranked = ", ".join(
            f"{names[k]} {float(total[k]):.2f} ({interval[k, 0]:.2f} to {interval[k, 1]:.2f})" for k in np.argsort(-total)
        )
        lines.append(f"peak {quantity} {middle:.5g} {unit} ± {spread:.2g} {unit}; total indices: {ranked}, with 95 % intervals")
    return lines


def failures(dataset: xr.Dataset) -> list[str]:
    """None: a problem without a peak ends the run."""
    return []


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Indices, ends and slopes of every parameter."""
    import pandas as pd

    columns = {name: dataset[name].values for name in ("parameter", "low", "high")}
    for q, quantity in enumerate(("amplitude", "frequency")):
        words_of = {"first_order": "alone", "total": "total", "low_end": "at the low end", "high_end": "at the high end"}
        for key, words in words_of.items():
            units = dataset["middle"].attrs["units"].split(" and ")[q]
            shown = f" [{units}]" if key.endswith("_end") else ""
            columns[f"{quantity}, {words}{shown}"] = dataset[key].values[:, q]
            if key in ("first_order", "total"):
                for bound, end in enumerate(("from", "to")):
                    columns[f"{quantity}, {words}, 95 % {end}"] = dataset[f"{key}_interval"].values[:, q, bound]
    columns["slope of ln amplitude over the range"] = dataset["slope"].values
    return {"parameters": pd.DataFrame(columns)}


def figures(dataset: xr.Dataset) -> Figures:
    """The tornado plot."""
    return {"tornado": tornado}


PRESENTATION = presents("sensitivity_indices", Presentation("Which parameter matters", sentences, failures, figures, tables))
