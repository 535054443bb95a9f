"""Presentation of a damper design."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stickslip.analyses.performance.design import no_optimum
from stickslip.results.view import measure_in, size_text
from stickslip.show.plots.paper import Figures
from stickslip.show.plots.performance_curve import design_space
from stickslip.show.report.markup import Presentation, percent, presents
from stickslip.support.late import pd, xr

MORE = 0.1
"""Share by which the worst case over all start states must exceed that of the sampled ones to be reported."""

FALLS, SIDES = -0.01, ("less", "more")
"""The search counts as not converged where 1 % of a variable lowers the worst-case peak by more than 0.01 %."""


def sentences(dataset: xr.Dataset) -> list[str]:
    """The best design, how flat it is, and its caveats."""
    refused, total = int(np.count_nonzero(dataset["allowed"].values == 0)), dataset.sizes["design"]
    counts = f"{total} designs, {refused} of them {'breaks' if refused == 1 else 'break'} a constraint"
    if no_optimum(dataset):
        return [counts]
    names = [str(name) for name in dataset["variable"].values]
    best, optimum = dataset.isel(design=int(dataset["optimum_design"])), float(dataset["optimum_peak"])
    measure = measure_in(dataset)
    of = "" if measure.quantity.order == 0 and measure.kind == "amplitude" else f", {measure.words}"
    lines = [f"worst-case resonance of the best design{of}: {_peak(best)}{_against_known(dataset)}"]
    if optimum > (1.0 + MORE) * float(best["sampled_peak"]):
        more = percent(optimum / float(best["sampled_peak"]) - 1.0)
        lines.append(f"  that is {more} more than for the sampled start states, for which alone the constraints were checked")
    lines += [_variable(dataset, k, name) for k, name in enumerate(names)]
    lines += [f"  known design {_compared(dataset, k)}" for k in range(int(dataset.attrs.get("known", 0)))]
    lines += _caveats(dataset, best, names)
    partly = int(np.count_nonzero((dataset["allowed"].values == 1) & (dataset["failed"].values > 0)))
    lines.append(counts)
    return [*lines, f"{partly} met the constraints only where a peak was solved and come last"] if partly else lines


def _size(dataset: xr.Dataset, name: str) -> str:
    """A peak with its unit, "12.3 µm" or "12.3 µm per unit level"."""
    return size_text(float(dataset[name]), dataset[name].attrs["units"], dataset)


def _peak(design: xr.Dataset) -> str:
    """The worst-case peak of a design over all start states and from those sampled, each named as what it is."""
    if not int(design["searches"]):
        return _size(design, "worst_peak")
    return f"{_size(design, 'searched_peak')} over all start states ({_size(design, 'sampled_peak')} over the sampled ones)"


def _variable(dataset: xr.Dataset, k: int, name: str) -> str:
    """The best value of a variable, its range, and what 1 % of it does to either side."""
    value, low, high = (float(dataset[key].values[k]) for key in ("optimum", "near_low", "near_high"))
    ends = [float(dataset[key].values[k]) for key in ("low", "high")]
    span = f"alone {low:.4g} to {high:.4g} stays within 5 %"
    if np.allclose([low, high], ends, rtol=0.0, atol=1e-9 * (ends[1] - ends[0])):
        span = f"its whole range, {low:.4g} to {high:.4g}, stays within 5 %"
    slopes = zip(SIDES, dataset["sensitivity"].values[k], strict=True)
    changes = [f"1 % {side}: {slope:+.2g} %" if np.isfinite(slope) else f"{side}: not allowed" for side, slope in slopes]
    return f"  {name} = {value:.4g}; {span}; {', '.join(changes)} (over 2 % of its range)"


def _caveats(dataset: xr.Dataset, best: xr.Dataset, names: list[str]) -> list[str]:
    """Where the best design is not the end of the search, and what slopes and ranges do not hold."""
    slopes = zip(names, dataset["sensitivity"].values, strict=True)
    ways = [f"{side} {name}" for name, pair in slopes for side, slope in zip(SIDES, pair, strict=True) if slope < FALLS]
    caveats = []
    if ways:
        caveats.append(
            f"the search has not converged: {' or '.join(ways)} lowers the worst-case resonance; more designs or generations "
            "would continue it"
        )
    if float(dataset["optimum_peak"]) > (1.0 + 1e-3) * float(best["worst_peak"]):
        caveats.append(
            f"ranges and changes are those of {_size(best, 'worst_peak')}, the worst case that the search saw for that design"
        )
    return caveats


def _compared(dataset: xr.Dataset, design: int) -> str:
    """A known design beside the best one, over all start states if they were searched."""
    known, name = dataset.isel(design=design), ", ".join(_variables(dataset, design))
    if not float(known["allowed"]):
        return f"{name}: breaks a constraint"
    if design == int(dataset["optimum_design"]):
        return f"{name}: {_peak(known)}; it is the best"
    lower = percent(1.0 - float(dataset["optimum_peak"]) / _known_peak(known))
    return f"{name}: {_peak(known)}; the best is {lower} lower"


def _against_known(dataset: xr.Dataset) -> str:
    """By how much the best design lies below the known ones that are allowed; empty where one of these is the best."""
    allowed = [k for k in range(int(dataset.attrs.get("known", 0))) if float(dataset["allowed"].values[k])]
    peaks = [_known_peak(dataset.isel(design=k)) for k in allowed]
    if not peaks or int(dataset["optimum_design"]) in allowed:
        return ""
    which = "known design" if len(peaks) == 1 else "best known design"
    return f", {percent(1.0 - float(dataset['optimum_peak']) / min(peaks))} lower than the {which}"


def _known_peak(design: xr.Dataset) -> float:
    """The worst-case peak of a known design, over all start states if they were searched."""
    return float(design["searched_peak" if int(design["searches"]) else "worst_peak"])


def failures(dataset: xr.Dataset) -> list[str]:
    """That no design is allowed; each design with conditions that gave no peak, and which they are."""
    message = no_optimum(dataset)
    sentences = [message] if message else []
    for k in np.flatnonzero(dataset["failed"].values).tolist():
        cases = np.stack([dataset[f"failed_{key}"].values[k] for key in ("force", "friction", "start")], axis=-1)
        conditions = [
            f"force level {force:.4g} with friction {mu:.4g} from {f'sampled start {start:.0f}' if start else 'virgin contacts'}"
            for force, mu, start in cases[np.isfinite(cases[:, 0])]
        ]
        design = ", ".join(_variables(dataset, k))
        sentences.append(f"design {design}: no peak solved at {', '.join(conditions)}; its worst case may be higher")
    return sentences


def _variables(dataset: xr.Dataset, design: int) -> list[str]:
    values = dataset["value"].values[design]
    return [f"{name} = {value:.4g}" for name, value in zip(dataset["variable"].values, values, strict=True)]


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """The best design beside the known ones, variable by variable; every design, the best ones first."""
    best = {} if no_optimum(dataset) else {"best design": _best_design(dataset)}
    table = pd.DataFrame({str(name): dataset["value"].values[:, k] for k, name in enumerate(dataset["variable"].values)})
    units = dataset["worst_peak"].attrs["units"]
    table[f"worst-case peak [{units}]"] = dataset["worst_peak"].values
    table[f"from virgin contacts and sampled starts [{units}]"] = dataset["sampled_peak"].values
    table[f"over all start states, where searched [{units}]"] = dataset["searched_peak"].values
    table["at Hz"] = dataset["worst_frequency"].values
    table["at force level"] = dataset["worst_force"].values
    table["at friction"] = dataset["worst_friction"].values
    met = np.where(dataset["failed"].values > 0, "met where a peak was solved", "met")
    table["constraints"] = np.where(dataset["allowed"].values == 1, met, "broken")
    table["conditions without a peak"] = dataset["failed"].values.astype(int)
    return best | {"designs": table.iloc[np.lexsort((dataset["worst_peak"].values, -dataset["allowed"].values))]}


def _best_design(dataset: xr.Dataset) -> pd.DataFrame:
    """Each variable of the best design: its value and the known ones, the range of it alone in which the worst-case peak rises by
    at most 5 %, and what 1 % less and more of it do to this peak; a change that breaks a constraint has no number.
    """
    columns = {"variable": [str(name) for name in dataset["variable"].values], "best": dataset["optimum"].values}
    count = int(dataset.attrs.get("known", 0))
    columns |= {f"known {k + 1}" if count > 1 else "known": dataset["value"].values[k] for k in range(count)}
    columns |= {"peak within 5 % from": dataset["near_low"].values, "to": dataset["near_high"].values}
    columns |= {f"peak change with 1 % {side} [%]": dataset["sensitivity"].values[:, k] for k, side in enumerate(SIDES)}
    return pd.DataFrame(columns)


def figures(dataset: xr.Dataset) -> Figures:
    """The design space."""
    return {"design_space": design_space}


PRESENTATION = presents(
    "damper_design", Presentation("Design of a damper", sentences, failures, figures, tables, answer="best design")
)
