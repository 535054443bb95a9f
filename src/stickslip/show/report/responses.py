"""Presentations of forced responses, with bounds or samples if present, and of controlled responses: their figures, sentences and
tables.

Report sections on response variability: bounds over the start states, and percentiles of sampled ones, each as a figure and a
table.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np

from stickslip.analyses.isolated import APART
from stickslip.analyses.nodal_diameters import has_disk
from stickslip.analyses.static_load import by_surface
from stickslip.analyses.stress import has_fatigue, has_gauges, has_stress
from stickslip.analyses.truncation import ALL_NODES, ALLOWED, finer_sentences, truncation_warning
from stickslip.analyses.variability.bounds import detached, has_bounds
from stickslip.analyses.variability.samples import has_percentiles
from stickslip.analyses.variability.samples import percentiles as percentiles_of
from stickslip.results import quantities, view
from stickslip.results.schema import CurveKind, Row, in_system, kind_words, kinds_in, shown_table, system_of
from stickslip.show.plots.chart import Chart
from stickslip.show.plots.contacts import contact_states, dissipation, hysteresis_loops, loss_factor
from stickslip.show.plots.disk import damper_ring, disk_mode, mean_normal_load, nodal_diameter_diagram
from stickslip.show.plots.paper import Figures
from stickslip.show.plots.response_curves import (
    controlled_response,
    haigh_diagram,
    peaks_over_force,
    resonances,
    response_curves,
    stress_curves,
)
from stickslip.show.plots.time_response import bound_cycles, contact_forces, force_ratios, loops
from stickslip.show.plots.variability import loss_factors, response_bounds, response_cloud, response_percentiles
from stickslip.show.report import stress
from stickslip.show.report.answer import bounds_failures, bounds_warnings, error_words, further_curves_sentence, reached_sentences
from stickslip.show.report.markup import Charts, framed, hertz, number, presents, section
from stickslip.solve.balance.fourier import of_attribute
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE
from stickslip.support.checks import Array, counted, in_percent
from stickslip.support.late import Figure, pd, xr
from stickslip.support.outcome import Outcome

FIGURES: dict[str, Callable[[Any], Chart | Figure]] = {
    "response": response_curves,
    "response_linear_scale": partial(response_curves, log=False),
    "response_per_force": partial(response_curves, per_force=True),
    "response_acceleration": partial(response_curves, quantity="acceleration"),
    "peaks": peaks_over_force,
    "loops": hysteresis_loops,
    "states": contact_states,
    "dissipation": dissipation,
    "loss_factor": loss_factor,
}
"""Name of the file: function that draws it."""


def figures_of(dataset: xr.Dataset) -> Figures:
    """The figures that a result has."""
    figures = dict(FIGURES)
    if has_bounds(dataset):
        figures |= {
            "bounds": lambda whole: response_bounds(detached(whole)),
            "bounds_loss_factor": lambda whole: loss_factors(detached(whole)),
            "bounds_contact_forces": lambda whole: contact_forces(detached(whole)),
        }
        # The ratio of friction to normal force needs a normal force that is known.
        if bound_cycles(detached(dataset)).contacts:
            figures["bounds_force_ratios"] = lambda whole: force_ratios(detached(whole))
        figures["bounds_loops"] = lambda whole: loops(detached(whole))
    if has_disk(dataset) and dataset.sizes["contact"]:
        figures |= {"dampers": damper_ring, "mean_normal_load": mean_normal_load}
    figures |= {"nodal_diameters": nodal_diameter_diagram} if "disk_frequency" in dataset.variables else {}
    figures |= {"disk_mode": disk_mode} if "disk_shape" in dataset.variables else {}
    figures |= {"stress": stress_curves} if has_stress(dataset) else {}
    figures |= {"haigh": haigh_diagram} if has_fatigue(dataset) else {}
    figures |= {"samples": response_cloud} if "start_variable" in dataset.variables else {}
    return figures | ({"percentiles": response_percentiles} if has_percentiles(dataset) else {})


NOTE = (
    '<p class="note">Friction forces of sticking contacts are not unique, so neither is the response. The bounds are the highest '
    "and the lowest response found over all start states of the contacts. The search finds local optima from many starts, so the "
    "true bounds can lie further apart.</p>"
)


def bounds(datasets: Mapping[str, xr.Dataset], charts: Charts) -> str:
    """Figure and table of every result that has bounds."""
    bounded = {label: detached(dataset) for label, dataset in datasets.items() if has_bounds(dataset)}
    parts = [
        charts.drawn(f"chart-bounds-{k}", response_bounds(dataset), "Bounds of the response")
        + ("" if k else NOTE)
        + _bounds_for_page(k, f"{label}: " if len(bounded) > 1 else "", dataset)
        for k, (label, dataset) in enumerate(bounded.items())
    ]
    return section("bounds", "Bounds", *parts)


def bounds_table(bounds: xr.Dataset) -> pd.DataFrame:
    """Lower and upper bound of each force level and frequency; by peaks, each bound has a frequency of its own."""
    levels, hertz_wanted = bounds["force_level"].values, bounds["frequency"].values
    case, at = (index.ravel() for index in np.indices((levels.size, hertz_wanted.size)))
    columns = {"force_level": levels[case]}
    columns |= {"frequency [Hz]": hertz_wanted[at]} if np.all(np.isfinite(hertz_wanted)) else {}
    for k, bound in enumerate(bounds["bound"].values):
        columns[f"{bound} [Hz]"] = bounds["resonance"].values[case, k, at]
        size = f"{bound} {view.measure_in(bounds).kind} [{bounds['amplitude'].attrs['units']}]"
        columns[size] = bounds["amplitude"].values[case, k, at]
        columns[f"{bound} loss_factor"] = bounds["loss_factor"].values[case, k, at]
        if "modal_error" in bounds:
            columns[f"{bound} error by the mesh"] = bounds["modal_error"].values[case, k, at]
    columns["start states without solution"] = bounds["unsolved_share"].values[case, at]
    return pd.DataFrame(columns)


def _bounds_for_page(k: int, begin: str, dataset: xr.Dataset) -> str:
    """Both bounds at each force level and frequency; of peaks, each bound has a frequency of its own."""
    frame, measure = bounds_table(dataset), view.measure_in(dataset)
    if "frequency [Hz]" in frame:
        frame = frame.drop(columns=[f"{bound} [Hz]" for bound in dataset["bound"].values])
    of = "amplitude" if measure == DISPLACEMENT_AMPLITUDE else measure.words
    caption = f"{begin}bounds of the {of}, by {str(dataset.attrs['objective']).replace('_', ' ')}"
    return framed(f"bounds-{k}", caption, shown_table(frame, dataset))


OF_PERCENTILES = (
    '<p class="note">Percentiles of the amplitude at each frequency, over the randomly drawn start states of the contacts that '
    "were solved.</p>"
)


def percentiles(datasets: Mapping[str, xr.Dataset], charts: Charts) -> str:
    """Figure and table of every result whose samples share their frequencies."""
    sampled = {label: dataset for label, dataset in datasets.items() if has_percentiles(dataset)}
    parts = []
    for place, (label, dataset) in enumerate(sampled.items()):
        parts.append(charts.drawn(f"chart-percentiles-{place}", response_percentiles(dataset), "Percentiles of the response"))
        parts.append("" if place else OF_PERCENTILES)
        frame = shown_table(percentiles_table(dataset), dataset)
        parts.append(framed(f"percentiles-{place}", f"{label}: percentiles of the amplitude", frame))
    return section("percentiles", "Percentiles", *parts)


def percentiles_table(dataset: xr.Dataset) -> pd.DataFrame:
    """The percentiles of `percentiles_of` at each force level and frequency, and how many start states they are of."""
    shares = percentiles_of(dataset)
    levels, frequencies = shares["force_level"].values, shares["frequency"].values
    case, at = (index.ravel() for index in np.indices((levels.size, frequencies.size)))
    columns = {"force_level": levels[case], "frequency [Hz]": frequencies[at], "solved": shares["solved"].values[case, at]}
    columns |= {f"{p:g} % [{shares.attrs['units']}]": shares.values[case, k, at] for k, p in enumerate(shares["percent"].values)}
    return pd.DataFrame(columns)


MOST_LINES = 12
"""Force levels listed in a summary."""


def sentences(dataset: xr.Dataset) -> list[str]:
    """The highest curve that no sweep meets, what "auto" took, and the highest peak of the first output at each force level, or
    the largest point without a peak."""
    if _bounds_alone(dataset):
        return bound_sentences(dataset)
    chosen = dataset.attrs.get("harmonics_chosen")
    lines = [*filter(None, [further_curves_sentence(dataset)]), *([f"{chosen}."] if chosen else []), *finer_sentences(dataset)]
    measure = view.measure_in(dataset)
    of = "" if measure == DISPLACEMENT_AMPLITUDE else f", {measure.words}"
    lines += [f"highest peaks of {dataset['output'].values[0]}{of}"]
    levels = view.levels_of(dataset)
    shown = view.chosen_levels(dataset, MOST_LINES)
    for cases in (levels[place] for place in shown):
        lines += cloud_lines(dataset, cases) if len(cases) > 1 else [level_line(dataset, cases[0])]
    lines += [f"  {len(shown)} of {len(levels)} {_curves(dataset)}; the report shows all"] if len(shown) < len(levels) else []
    lines += outside_lines(dataset)
    lines += [f"  {sentence}"] if (sentence := quantities.about_all(dataset)) else []
    lines += [*truncation_sentences(dataset), *message_sentences(dataset)]
    lines += bound_sentences(detached(dataset)) if has_bounds(dataset) else []
    lines += [*isolated_sentences(dataset), *reached_sentences(dataset)]
    lines += quantities.stability_sentences(dataset) if quantities.has_stability(dataset) else []
    lines += stress.stress_sentences(dataset) if has_stress(dataset) else []
    lines += stress.strain_sentences(dataset) if has_gauges(dataset) else []
    return [*lines, *(stress.fatigue_sentences(dataset) if has_fatigue(dataset) else [])]


def _curves(dataset: xr.Dataset) -> str:
    """What the cases are called: several curves may have one force level."""
    return "curves" if "curve_kind" in dataset else "force levels"


def _bounds_alone(dataset: xr.Dataset) -> bool:
    """Whether there are bounds without the curves of a study beside them, as Python gives them."""
    return "bound" in dataset.dims and "output" not in dataset.dims


def isolated_sentences(dataset: xr.Dataset) -> list[str]:
    """How many isolated curves were found, and from how many starts; or that contacts lift off and none were sought."""
    said = sorted(np.atleast_1d(dataset.attrs.get("isolated_search", [])).tolist(), key=lambda each: APART not in each)
    more = f" The results keep such a sentence for {counted(len(said) - 1, 'more force level')}." if len(said) > 1 else ""
    searched = [f"{said[0]}{more}"] if said else []
    of_sector = "excited_orders" in dataset.attrs  # which time integration does not take
    if CurveKind.ISOLATED in kinds_in(dataset) and "reached" not in dataset and not of_sector:
        searched.append("The table `[reached]` says which of these motions a machine shows from rest and in slow sweeps.")
    open_ = dataset["share_open"].values if "share_open" in dataset else np.zeros(0)
    if (
        not (said or view.is_listed(dataset) or view.is_cloud(dataset))
        and view.periods_of(dataset) == 1
        and np.any((open_ > 0.0) & (open_ < 1.0))
    ):
        searched.append("Detached curves were not sought although contacts lift off; the table `[isolated]` seeks them.")
    if "isolated_starts" not in dataset.attrs:
        return searched
    found, starts = (int(dataset.attrs[name]) for name in ("isolated_curves", "isolated_starts"))
    return [*searched, f"isolated curves: {found or 'none'} found from {counted(starts, 'start')}"]


def truncation_sentences(dataset: xr.Dataset) -> list[str]:
    """A warning where more harmonics matter at a highest peak, or this is unknown: the worst force level, how many there are."""
    if "truncation_error" not in dataset:
        return []
    errors = dataset["truncation_error"].values
    solved = np.isfinite(dataset["amplitude"].values).any(axis=(1, 2))
    worst = np.where(np.isnan(errors).all(axis=1), np.inf, np.nan_to_num(errors).max(axis=1, initial=0.0))
    worst[~solved] = 0.0
    case = int(np.argmax(worst))
    names = tuple(str(name) for name in dataset["output"].values)
    choice = str(dataset.attrs.get("harmonics_chosen", ""))
    warning = truncation_warning(of_attribute(dataset.attrs["harmonics"]), names, errors[case], choice)
    count, unknown = int(np.count_nonzero(worst > ALLOWED)), " or unknown" if np.isinf(worst).any() else ""
    more = f" ({count} of {len(errors)} {_curves(dataset)} above {100.0 * ALLOWED:g} %{unknown})" if count > 1 else ""
    return [f"warning, {_level(dataset, case)}: {warning}{more}"] if warning and worst[case] else []


def message_sentences(dataset: xr.Dataset) -> list[str]:
    """What else the message of a completed curve warns of: the first force level with it, of an unstable motion or one far from a
    true one before others, and how many there are.
    """
    found, harmonics, choice = [], of_attribute(dataset.attrs["harmonics"]), str(dataset.attrs.get("harmonics_chosen", ""))
    names = tuple(str(name) for name in dataset["output"].values)
    for case in np.flatnonzero(dataset["case_outcome"].values == Outcome.CONVERGED).tolist():
        _, _, more = str(dataset["case_message"].values[case]).partition(". ")
        errors = dataset["truncation_error"].values[case] if "truncation_error" in dataset else np.zeros(1)
        rest = " ".join(more.replace(truncation_warning(harmonics, names, errors, choice), "").split())
        found += [f"warning, {_level(dataset, case)}: {rest}"] if rest else []
    found.sort(key=lambda words: ("Unstable motion" not in words, "true motion differs" not in words))
    return [*found[:1], *([f"  and of {counted(len(found) - 1, 'more curve')}; the report has them"] if len(found) > 1 else [])]


def _level(dataset: xr.Dataset, case: int) -> str:
    """ "force 20 N", or "force × 20" where levels are factors."""
    level = view.force_text(dataset, case)
    return level if level.startswith("force") else f"force {level}"


def level_line(dataset: xr.Dataset, case: int) -> str:
    """The highest peak of one case."""
    kind, level = kind_words(dataset, case), _level(dataset, case)
    line = f"  {f'{level}, {kind}' if kind else f'{level:<14}'} {peak_words(dataset, case)}"
    if ALL_NODES.variable not in dataset:
        return line
    change = float(dataset[ALL_NODES.variable].values[case, 0])
    much = in_percent(change, "+") if np.isfinite(change) else "unknown"
    return f"{line}   with all nodes {much}"


def outside_lines(dataset: xr.Dataset) -> list[str]:
    """The highest peak of the first output outside the band, which does not count; none where no curve leaves it over a peak."""
    found = [(case, peak) for case in range(dataset.sizes["case"]) for peak in view.peaks_outside(dataset, case, 0)[:1]]
    if not found:
        return []
    case, peak = max(found, key=lambda pair: pair[1].amplitude)
    measure, (factor, units) = view.measure_in(dataset), _unit(dataset, "peak_amplitude")
    size = factor * peak.amplitude / measure.per(float(dataset["force_level"][case]))
    return [f"  outside the band, where it does not count: {hertz(peak.frequency)} Hz, {measure.kind} {number(size)} {units}"]


def cloud_lines(dataset: xr.Dataset, cases: list[int]) -> list[str]:
    """Of many start states at one force level those with the lowest, the median and the highest response."""
    chosen = view.representative_starts(dataset, cases)
    level, solved = _level(dataset, cases[0]), len(view.ranked(dataset, cases))
    lines = [f"  {level}, {counted(len(cases), 'start state')}, {solved} of them solved"]
    for word, case in zip(view.words_of(chosen), chosen, strict=True):
        start = f"start {int(dataset['start'][case]) + 1}"
        lines.append(f"    {word:<8} {start:<10} {peak_words(dataset, case)}")
    return lines


def bound_sentences(bounds: xr.Dataset) -> list[str]:
    """Where the bounds of each force level are furthest apart, and the highest one; of peaks both bounds."""
    measure, (factor, units) = view.measure_in(bounds), _unit(bounds, "amplitude")
    of = "" if measure == DISPLACEMENT_AMPLITUDE else f" of the {measure.words}"
    lines = [f"bounds{of} over the start states, by {str(bounds.attrs['objective']).replace('_', ' ')}"]
    for case in view.spread(bounds.sizes["case"], MOST_LINES):
        level = f"{_level(bounds, case):<14}"
        low, high = factor * bounds["amplitude"].values[case]
        if not np.any(np.isfinite(high - low)):
            lines.append(f"  {level} none found")
            continue
        k = int(np.nanargmax(high - low))
        frequency = float(bounds["frequency"].values[k])
        at = bounds["resonance"].values[case, :, k]
        peaks = f"{number(low[k])} {units} at {hertz(at[0])} Hz to {number(high[k])} {units} at {hertz(at[1])} Hz"
        lines.append(f"  {level} {widest_and_highest(bounds, case, k) if np.isfinite(frequency) else peaks}")
    return [*lines, *(f"  {sentence}" for sentence in bounds_warnings(bounds))]


def widest_and_highest(bounds: xr.Dataset, case: int, widest: int) -> str:
    """Both bounds where they are furthest apart, and the highest of all."""
    factor, units = _unit(bounds, "amplitude")
    frequencies, (low, high) = bounds["frequency"].values, factor * bounds["amplitude"].values[case]
    top = int(np.nanargmax(high))
    return (
        f"furthest apart at {hertz(frequencies[widest])} Hz: {number(low[widest])} to {number(high[widest])} {units}; "
        f"highest bound {number(high[top])} {units} at {hertz(frequencies[top])} Hz"
    )


def peak_words(dataset: xr.Dataset, case: int) -> str:
    """The highest peak of the first output of one curve, and its end where that is higher."""
    highest = view.highest_peak(dataset, case)
    if highest is None:
        return "no point was found"
    measure, (factor, units) = view.measure_in(dataset), _unit(dataset, "peak_amplitude")
    size = factor * highest.amplitude / measure.per(float(dataset["force_level"][case]))
    if not highest.local:
        what = "largest of the listed frequencies, at" if view.is_listed(dataset) else "no peak; largest at"
        return f"{what} {hertz(highest.frequency)} Hz: {measure.kind} {number(size)} {units}"
    error, loss = error_words(dataset, case, 0), number(highest.loss_factor)
    sentence = f"{hertz(highest.frequency):>9} Hz   {measure.kind} {number(size):>8} {units} (error {error})   loss factor {loss}"
    sentence += ", unstable" if quantities.peak_is_unstable(dataset, case, 0, highest.point) else ""
    unjudged = "" if quantities.none_is_judged(dataset) else quantities.peak_unjudged(dataset, case, 0)
    sentence += f", stability {unjudged}" if unjudged else ""
    sentence += ", curve incomplete" if int(dataset["case_outcome"].values[case]) != Outcome.CONVERGED else ""
    end = view.higher_end(dataset, case)
    if end is None:
        return sentence
    size = factor * end.amplitude / measure.per(float(dataset["force_level"][case]))
    return f"{sentence}; higher at an end of the curve, {hertz(end.frequency)} Hz: {number(size)} {units}"


def _unit(dataset: xr.Dataset, variable: str) -> tuple[float, str]:
    """The factor from SI to the unit that a variable is shown in, and its name; displacements are in µm or m by the largest."""
    sizes = dataset[variable if dataset[variable].size else "amplitude"].values
    unit = view.shown_unit(dataset[variable].attrs["units"], float(np.max(sizes[np.isfinite(sizes)], initial=0.0)), dataset)
    return 1.0 / unit.metres, unit.name


def failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for each case that did not reach the end of its band, and for each force level without bounds."""
    if _bounds_alone(dataset):
        return bounds_failures(dataset)
    messages, lost = dataset["case_message"].values, dataset["case_outcome"].values != Outcome.CONVERGED
    broken = [f"{_level(dataset, case)}: {messages[case]}".strip() for case in np.flatnonzero(lost).tolist()]
    return broken + (bounds_failures(detached(dataset)) if has_bounds(dataset) else [])


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Curves and peaks, as the quantity that peaks are of, and those of bounds, percentiles and stress where there are any."""
    return {"curves": quantities.quantity_table(dataset), "peaks": quantities.peak_table(dataset), **further_tables(dataset)}


def further_tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """What only some results hold."""
    frames = {"bounds": bounds_table(detached(dataset))} if has_bounds(dataset) else {}
    outside = quantities.outside_table(dataset)
    frames |= {} if outside.empty else {"peaks outside the band": outside}
    frames |= {"contacts at rest": pd.DataFrame(by_surface(dataset))} if "rest_load" in dataset else {}
    frames |= {"reached": quantities.reached_table(dataset)} if "reached" in dataset else {}
    frames |= {"percentiles": percentiles_table(dataset)} if has_percentiles(dataset) else {}
    frames |= {"stress": stress.stress_table(dataset)} if has_stress(dataset) else {}
    frames |= {"strain": stress.strain_table(dataset)} if has_gauges(dataset) else {}
    return frames | ({"fatigue": stress.fatigue_table(dataset)} if has_fatigue(dataset) else {})


presents(
    ("forced_response", "response_bounds", "response_samples"),
    "Forced response",
    sentences,
    figures_of,
    tables,
    failures=failures,
    responses=True,
)


HELD_ANSWER = "force and displacement at 90 degrees"
MOST_HELD = 12
"""Amplitudes with a sentence each."""


def _held_name(dataset: xr.Dataset, case: int) -> str:
    return view.size_text(float(dataset["held_amplitude"].values[case]), dataset["held_amplitude"].attrs["units"], dataset)


def held_sentences(dataset: xr.Dataset) -> list[str]:
    """What is held, and where force and displacement are at 90°, for each amplitude: the lowest force."""
    count, held = dataset.sizes["case"], f"{dataset.attrs['quantity']} of {dataset.attrs['output_held']} held"
    lines = [f"{held} at {counted(count, 'amplitude')}; at phase resonance the force is lowest, 90° from the displacement"]
    factor, unit = in_system("N", system_of(dataset))
    for case in range(min(count, MOST_HELD)):
        resonances_of_case = dataset["resonance_frequency"].values[case]
        if not (resonances_of_case.size and np.isfinite(resonances_of_case[0])):
            lines.append(f"  {_held_name(dataset, case)}: force and displacement are nowhere at 90° in the band")
            continue
        force, loss = (float(dataset[f"resonance_{name}"].values[case, 0]) for name in ("force_level", "loss_factor"))
        size = f"{factor * force:.4g} {unit}" if dataset["force_level"].attrs["units"] == "N" else f"force level {force:.4g}"
        at = f"{size} at {hertz(float(resonances_of_case[0]))} Hz"
        lines.append(Row(f"  {_held_name(dataset, case)}: phase resonance with {at}, loss factor {loss:.4g}"))
    if count > MOST_HELD:
        lines.append(f"{MOST_HELD} of {count} amplitudes; all stand in the report")
    return lines


def held_failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for each amplitude whose curve did not arrive or misses frequencies."""
    sentences = []
    for case in range(dataset.sizes["case"]):
        missing = int(np.count_nonzero(dataset["outcome"].values[case] > Outcome.CONVERGED))
        if int(dataset["case_outcome"].values[case]) != Outcome.CONVERGED:
            sentences.append(f"{_held_name(dataset, case)}: {dataset['case_message'].values[case]}")
        elif missing:
            sentences.append(f"{_held_name(dataset, case)}: {counted(missing, 'frequency', 'frequencies')} could not be solved")
    return sentences


def held_tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Phase resonances, and every point of every curve."""
    units, level = dataset["held_amplitude"].attrs["units"], dataset["force_level"].attrs["units"]
    force, held = f"force level [{level}]", f"{dataset.attrs['quantity']} [{units}]"

    def listed(there: Array, names: Mapping[str, str]) -> pd.DataFrame:
        """A row for each case and place that is there, of variables by the heads of their columns."""
        amplitude = dataset["held_amplitude"].values[np.nonzero(there)[0]]
        return pd.DataFrame({held: amplitude, **{head: dataset[name].values[there] for head, name in names.items()}})

    resonance = {"frequency [Hz]": "resonance_frequency", force: "resonance_force_level", "loss factor": "resonance_loss_factor"}
    curve = {"frequency [Hz]": "frequency", force: "force_level", "phase [degree]": "phase", "loss factor": "loss_factor"}
    at_90 = listed(np.isfinite(dataset["resonance_frequency"].values), resonance)
    return {HELD_ANSWER: at_90, "controlled response": listed(dataset["outcome"].values == Outcome.CONVERGED, curve)}


def held_figures(dataset: xr.Dataset) -> Figures:
    """The curves, and the phase resonances of several amplitudes."""
    found: Figures = {"controlled_response": controlled_response}
    known = int(np.isfinite(dataset["resonance_frequency"].values).any(axis=1).sum())
    return {**found, "phase_resonances": resonances} if known > 1 else found


presents(
    "controlled_response",
    "Controlled response",
    held_sentences,
    held_figures,
    held_tables,
    failures=held_failures,
    answer=HELD_ANSWER,
)
