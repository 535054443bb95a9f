"""How the design of a damper is told."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from stickslip.analyses.performance.design import no_optimum
from stickslip.plots.design import design_space
from stickslip.plots.files import Figures
from stickslip.report.numbers import percent
from stickslip.report.presentation import Presentation
from stickslip.results_view import length_text

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def sentences(dataset: xr.Dataset) -> list[str]:
    """The best design, how flat it is, and what matters."""
    refused, total = int(np.count_nonzero(dataset["allowed"].values == 0)), dataset.sizes["design"]
    counts = f"{total} designs, {refused} of them {'breaks' if refused == 1 else 'break'} a constraint"
    if no_optimum(dataset):
        return [counts]
    names = [str(name) for name in dataset["variable"].values]
    lines = [f"worst resonance of the best design: {_size(dataset, 'optimum_peak')}"]
    for k, name in enumerate(names):
        low, high, slope = (float(dataset[key].values[k]) for key in ("near_low", "near_high", "sensitivity"))
        change = f"1 % more of it changes the worst resonance by {slope:+.2g} %" if np.isfinite(slope) else "others are refused"
        lines.append(
            f"  {name} = {float(dataset['optimum'].values[k]):.4g}; designs within 5 % have {low:.4g} to {high:.4g}; {change}"
        )
    lines += [f"  known design {_compared(dataset, k)}" for k in range(int(dataset.attrs.get("known", 0)))]
    searched = float(dataset["searched_peak"])
    if np.isfinite(searched):
        more = searched / float(dataset["optimum_peak"]) - 1.0
        found = f"{_size(dataset, 'searched_peak')} there, {percent(more)} more" if more > 1e-6 else "nothing higher there"
        lines.append(f"over all start states a search finds {found}")
    partly = int(np.count_nonzero((dataset["allowed"].values == 1) & (dataset["failed"].values > 0)))
    lines.append(counts)
    return [*lines, f"{partly} met the constraints only where a peak was solved and come last"] if partly else lines


def _size(dataset: xr.Dataset, name: str) -> str:
    """A peak with its unit, "12.3 µm" or "12.3 µm per unit level"."""
    return f"{length_text(float(dataset[name]))}{dataset[name].attrs['units'].removeprefix('m')}"


def _compared(dataset: xr.Dataset, design: int) -> str:
    """A known design beside the best one."""
    one, words = dataset.isel(design=design), ", ".join(_variables(dataset, design))
    if not float(one["allowed"]):
        return f"{words}: breaks a constraint"
    less = 1.0 - float(dataset["optimum_peak"]) / float(one["worst_peak"])
    return f"{words}: {_size(one, 'worst_peak')}; the best is {percent(less)} lower"


def failures(dataset: xr.Dataset) -> list[str]:
    """That no design is allowed; each design with conditions that gave no peak, and which they are."""
    message = no_optimum(dataset)
    return ([message] if message else []) + [
        f"design {', '.join(_variables(dataset, k))}: no peak solved at {_conditions(dataset, k)}; its worst may be higher"
        for k in np.flatnonzero(dataset["failed"].values).tolist()
    ]


def _variables(dataset: xr.Dataset, design: int) -> list[str]:
    values = dataset["value"].values[design]
    return [f"{name} = {value:.4g}" for name, value in zip(dataset["variable"].values, values, strict=True)]


def _conditions(dataset: xr.Dataset, design: int) -> str:
    """The conditions of a design without a peak, in words."""
    cases = np.stack([dataset[f"failed_{key}"].values[design] for key in ("force", "friction", "start")], axis=-1)
    return ", ".join(
        f"force level {force:.4g} with friction {mu:.4g} from {'virgin contacts' if start == 0 else f'drawn start {start:.0f}'}"
        for force, mu, start in cases[np.isfinite(cases[:, 0])]
    )


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Every design, the best ones first."""
    import pandas as pd

    table = pd.DataFrame({str(name): dataset["value"].values[:, k] for k, name in enumerate(dataset["variable"].values)})
    table[f"worst peak [{dataset['worst_peak'].attrs['units']}]"] = dataset["worst_peak"].values
    table["at Hz"] = dataset["worst_frequency"].values
    table["at force level"] = dataset["worst_force"].values
    table["at friction"] = dataset["worst_friction"].values
    told = np.where(dataset["failed"].values > 0, "met where a peak was solved", "met")
    table["constraints"] = np.where(dataset["allowed"].values == 1, told, "broken")
    table["conditions without a peak"] = dataset["failed"].values.astype(int)
    return {"designs": table.iloc[np.lexsort((dataset["worst_peak"].values, -dataset["allowed"].values))]}


def figures(dataset: xr.Dataset) -> Figures:
    """The design space."""
    return {"design_space": design_space}


PRESENTATION = Presentation("Design of a damper", sentences, failures, figures, tables)
