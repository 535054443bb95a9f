"""Presentations of performance curves, of their band over the start states, of sensitivity indices, and of a damper design."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from stickslip.analyses.performance.design import no_optimum
from stickslip.analyses.truncation import OWN_FORCES
from stickslip.results.schema import Row
from stickslip.results.view import measure_in, shown_unit, size_text
from stickslip.show.plots.paper import Figures
from stickslip.show.plots.performance_curve import design_space, dissipation, performance_band, performance_curves, region_of
from stickslip.show.plots.variability import tornado
from stickslip.show.report.markup import percent, presents
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE
from stickslip.support.checks import in_percent, listed
from stickslip.support.late import pd, xr
from stickslip.support.outcome import Outcome


def sentences(dataset: xr.Dataset) -> list[str]:
    """The optimum of every curve, its plateau, and what happened to peaks."""
    measure, units = measure_in(dataset), dataset["amplitude_per_force"].attrs["units"]
    resonance = "resonance" if measure.order == 0 else f"resonance, as {measure.quantity.name_per_force},"
    lines = []
    for case, mu in enumerate(dataset["friction"].values):
        keys = ("optimum_ratio", "optimum_amplitude_per_force", "optimum_frequency", "plateau_low", "plateau_high")
        best = {key: float(dataset[key].values[case]) for key in keys}
        name = "friction of the problem" if np.isnan(mu) else f"friction {mu:g}"
        if not np.isfinite(best["optimum_ratio"]):
            lines.append(f"{name}: no resonance was found")
            continue
        plateau = (best["plateau_low"], best["plateau_high"])
        ends = [f"{end:.4g}" if np.isfinite(end) else "where the values end" for end in plateau]
        lines.append(
            f"{name}: lowest {resonance} {size_text(best['optimum_amplitude_per_force'], units, dataset)} at "
            f"F_C/F_E = {best['optimum_ratio']:.4g} and {best['optimum_frequency']:.5g} Hz; "
            f"within 10 % of it from {ends[0]} to {ends[1]}"
        )
        if warning := str(dataset["optimum_warning"].values[case]):
            lines[-1] += f"; {warning}"
        further = (*_detached(dataset, case), *_happened(dataset, case), *_on_mesh(dataset, case))
        lines += [f"  {name}: {sentence}" for sentence in further]
    return lines


def _on_mesh(dataset: xr.Dataset, case: int) -> list[str]:
    """How much the shapes of the contacts that a finite-element model lacks change of peaks."""
    errors = dataset["modal_error"].values[case] if "modal_error" in dataset else np.full(1, np.nan)
    known = np.flatnonzero(np.isfinite(errors))
    if not known.size:
        return []
    where = ", ".join(f"{ratio:.4g}" for ratio in dataset["force_ratio"].values[known])
    change = in_percent(float(np.abs(errors[known]).max()))
    return [f"solved again {OWN_FORCES.words}, the peaks at F_C/F_E = {where} change by at most {change}"]


def _detached(dataset: xr.Dataset, case: int) -> list[str]:
    """Where higher peaks lie on isolas."""
    heights, ratios = dataset["detached_amplitude_per_force"].values[case], dataset["force_ratio"].values
    units = dataset["detached_amplitude_per_force"].attrs["units"]
    isolas = ratios[np.isfinite(heights)]
    if not isolas.size:
        return []
    where = f"{isolas[0]:.4g}" if isolas.size == 1 else f"{isolas[0]:.4g} to {isolas[-1]:.4g}"
    return [
        f"F_C/F_E {where}: higher peaks, up to {size_text(np.nanmax(heights), units, dataset)}, lie on an isola that "
        "sweeps miss; they are not counted and may be unstable (a time simulation shows)"
    ]


def _happened(dataset: xr.Dataset, case: int) -> list[str]:
    """What happened to peaks along a curve, in one sentence; the table lists each event."""
    kinds = dataset["event_kind"].values[case]
    if not np.any(kinds):
        return []
    words = {"born": "appear", "ended": "disappear", "merged": "merge", "swapped": "overtake each other"}
    counts = listed([f"{word} ({np.count_nonzero(kinds == kind)})" for kind, word in words.items() if np.any(kinds == kind)])
    low, high = np.nanmin(dataset["event_low"].values[case]), np.nanmax(dataset["event_high"].values[case])
    return [f"between F_C/F_E = {low:.4g} and {high:.4g} further resonance peaks {counts}; a table of the report lists them"]


def failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for each curve with points where no peak was found."""
    sentences = []
    for case, outcomes in enumerate(dataset["outcome"].values):
        missing = dataset["force_ratio"].values[outcomes != 1]
        if missing.size:
            where = f"{missing.size} values of F_C/F_E, the first {missing[0]:.4g}"
            sentences.append(f"curve {case + 1}: no peak was found at {where}")
    return sentences


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Every point of every curve, and what happened to peaks between them."""
    events = []
    for case, mu in enumerate(dataset["friction"].values.tolist()):
        numbers = (dataset[f"event_{key}"].values[case] for key in ("low", "high", "frequency"))
        for low, high, frequency, sentence in zip(*numbers, dataset["event"].values[case], strict=True):
            if sentence:
                events.append((mu, float(low), float(high), float(frequency), str(sentence).partition(": ")[2]))
    happened = pd.DataFrame(events, columns=["friction", "F_C/F_E from", "to", "at Hz", "what happened"])
    return {"performance curves": _points(dataset), **({"peaks along the curves": happened} if len(happened) else {})}


def _points(dataset: xr.Dataset) -> pd.DataFrame:
    """Every point of every curve."""
    units, (cases, count) = dataset["amplitude_per_force"].attrs["units"], dataset["region"].shape
    known = {
        "frequency": "frequency [Hz]",
        "amplitude_per_force": f"amplitude per force [{units}]",
        "inertance": "inertance [m/(s2 N)]",
        "normalised_amplitude": "relative to no contacts",
        "region": "contacts",
        "loss_factor": "loss factor",
        "detached_amplitude_per_force": f"on an isola [{units}]",
    }
    columns = {"friction": np.repeat(dataset["friction"].values, count)}
    columns |= {"F_C/F_E": np.tile(dataset["force_ratio"].values, cases)}
    columns |= {head: dataset[name].values.ravel() for name, head in known.items()}
    return pd.DataFrame(columns).assign(contacts=lambda table: [region_of(region) for region in table["contacts"]])


FIGURES: Figures = {
    "performance_curve": performance_curves,
    "performance_inertance": partial(performance_curves, quantity="inertance"),
    "dissipation": dissipation,
}
"""The curves as they were measured and as inertance at the same peaks, and which contact dissipates."""

presents("performance_curve", "Performance curves", sentences, FIGURES, tables, failures=failures)


def band_sentences(dataset: xr.Dataset) -> list[str]:
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


def band_failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for each value of F_C/F_E without a bound."""
    lines = []
    columns = (dataset[name].values for name in ("force_ratio", "outcome", "unsolved_share"))
    for ratio, outcomes, unsolved in zip(*columns, strict=True):
        bad = outcomes[outcomes != Outcome.CONVERGED]
        if bad.size:
            share = f" {percent(unsolved)} of the sampled start states have no solution." if unsolved else ""
            lines.append(f"F_C/F_E {ratio:.4g}: {Outcome(int(bad[0])).sentence}{share}")
    return lines


def band_tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Both ends of the band at every point."""
    units = dataset["amplitude_per_force"].attrs["units"]
    columns = {"F_C/F_E": dataset["force_ratio"].values, f"virgin [{units}]": dataset["virgin_amplitude_per_force"].values}
    for bound, name in enumerate(("lowest", "highest")):
        columns[f"{name} [{units}]"] = dataset["amplitude_per_force"].values[:, bound]
        columns[f"{name}, at Hz"] = dataset["frequency"].values[:, bound]
        columns[f"{name}, loss factor"] = dataset["loss_factor"].values[:, bound]
    columns["solutions"] = dataset["solves"].values
    return {"band of the performance curve": pd.DataFrame(columns)}


presents(
    "performance_band",
    "Band of the performance curve",
    band_sentences,
    {"performance_band": performance_band},
    band_tables,
    failures=band_failures,
)


def index_sentences(dataset: xr.Dataset) -> list[str]:
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


def index_tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Indices, ends and slopes of every parameter."""
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


presents("sensitivity_indices", "Which parameter matters", index_sentences, {"tornado": tornado}, index_tables)


MORE = 0.1
"""Share by which the worst case over all start states must exceed that of the sampled ones to be reported."""

FALLS, SIDES = -0.01, ("less", "more")
"""The search counts as not converged where 1 % of a variable lowers the worst-case peak by more than 0.01 %."""


def design_sentences(dataset: xr.Dataset) -> list[str]:
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
    lines += [Row(_variable(dataset, k, name)) for k, name in enumerate(names)]
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


def design_failures(dataset: xr.Dataset) -> list[str]:
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


def design_tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
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


presents(
    "damper_design",
    "Design of a damper",
    design_sentences,
    {"design_space": design_space},
    design_tables,
    failures=design_failures,
    answer="best design",
)
