"""Sections of the page, each a function from datasets to HTML. Tables carry exact SI numbers in data-value."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from stickslip.analyses.static_load import by_surface
from stickslip.analyses.truncation import finer_sentences
from stickslip.analyses.variability.bounds import detached, has_bounds
from stickslip.results import quantities, view
from stickslip.results.schema import in_system, system_of
from stickslip.results.view import spread
from stickslip.show.plots.chart import Chart
from stickslip.show.plots.contacts import contact_states, dissipation, loops_at, loops_of, loss_factor
from stickslip.show.plots.response_curves import compared_peaks, response_curves
from stickslip.show.report import answer
from stickslip.show.report.markup import Charts, Choice, Opening, cell, framed, hertz, number, section, table, text
from stickslip.show.report.stress import fatigue_headline
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE, QUANTITIES, Measure
from stickslip.support.checks import Array, counted
from stickslip.support.late import pd, xr

Datasets = Mapping[str, "xr.Dataset"]
Ranked = Callable[["xr.Dataset", int, int], Iterator[tuple[int, Array]]]
"""Rank and numbers of the peaks of a case and output."""

ENERGY_RESIDUAL_LIMIT, SLIP_WORK_LIMIT = 1e-8, 1e-3
"""What a trustworthy point stays below: consistency of the solution, and the physics of slip at enough samples."""
CYCLE_NOTE = (
    "Loops at the saved point nearest to the click, drawn from the saved harmonics: corners are rounded, and the force may "
    "overshoot. The section on hysteresis loops shows the exact loops at the highest peak."
)
MOST_SHOWN = 12
"""Cases whose loops and states are drawn, and that the overview lists."""
MOST_LOOPS = 100
"""Directions of contacts whose loops a report holds; of more, those with the largest."""
LOOPS_OF_A_POINT = 8
"""Contact rows, those with the largest loops, whose loops are drawn at a point that is clicked."""
NUMBERS_OF_LOOPS, SAMPLES_OF_MANY = 120_000, 64
"""Numbers of the loops at the peaks that a page takes as they are; the samples of each loop where there would be more."""
OPENED, SAMPLES_OF_A_LOOP = 150, 64
"""Points of all curves together whose loops the page holds, about a megabyte, and the samples of each loop."""
LIMITS = {"energy_residual": ENERGY_RESIDUAL_LIMIT, "slip_work_error": SLIP_WORK_LIMIT, "residual": np.inf}


def overview(datasets: Datasets, charts: Charts) -> str:
    """The answer in a few sentences, the highest peaks at a glance, and what it took to compute them; of results that can be
    compared one table, with those of each folded."""
    compared, answered, parts, warnings = answer.comparison(datasets), "", [], {}
    for label, dataset in datasets.items():
        answers = [
            fatigue_headline(dataset),
            answer.bounds_headline(detached(dataset)) if has_bounds(dataset) else "",
            answer.further_curves_sentence(dataset),
            " ".join(answer.reached_sentences(dataset)),
        ]
        begin = f"{label}: " if compared else ""
        own = "".join(f'<p class="headline">{text(begin + sentence)}</p>' for sentence in answers if sentence)
        answered, warnings[label] = answered + own, answer.least_certain_first(dataset)
        cases = range(dataset.sizes["case"])
        count, good = sum(view.points(dataset, c).size for c in cases), sum(view.converged_points(dataset, c).size for c in cases)
        whole = f"All {count} points converged" if good == count else f"{good} of {count} points converged"
        solved = f"{whole}; {float(dataset.attrs['cpu_seconds']):.3g} s of processor time."
        chosen, small = str(dataset.attrs.get("harmonics_chosen", "")), str(dataset.attrs.get("static_history", ""))
        how = [f"Chosen by “auto”: {chosen}."] if chosen else []
        how += [sentence for sentence in finer_sentences(dataset) if sentence != small]
        note = f"<details><summary>{text(solved)}</summary>{text(' '.join(how))}</details>" if how else text(solved)
        parts += [f"<h3>{text(label)}</h3>"] if len(datasets) > 1 else []
        parts += [answer.highest_peaks(label, dataset)] if compared else [own, answer.peaks_at_a_glance(label, dataset)]
        parts += [f'<div class="note">{note}</div>']
    if compared:
        known = Counter(verdict for data in datasets.values() for verdict, of in quantities.verdicts(data).items() for _ in of)
        stability = ", ".join(f"{count} {verdict}" for verdict, count in known.items())
        head = f"Each result, against linear responses; its peaks: {stability}"
        each = f"<details><summary>{text(head)}</summary>{''.join(parts)}</details>"
        parts = [compared, answered, answer.warnings_at_a_glance(warnings), each]
    return section("overview", "Overview", *parts)


def curves(datasets: Datasets, charts: Charts) -> str:
    """The response curves with their choices."""
    html = ""
    for label, dataset in datasets.items():
        first = view.measure_in(dataset).quantity.name
        choices = [
            Choice("Output", _outputs(dataset)),
            Choice("Scale", ("logarithmic", "linear")),
            Choice("Show", list(dict.fromkeys((first, *QUANTITIES)))),
            Choice("Amplitude", ("absolute", "per force")),
        ]

        def draw(output: str, scale: str, quantity: str, size: str, dataset: "xr.Dataset" = dataset) -> Chart:
            return response_curves(dataset, output, scale == "logarithmic", size == "per force", quantity)

        html += charts.place("chart-curves", draw, choices, label, _loops_of_points(dataset))
    known = any(view.has_linear_curves(dataset) for dataset in datasets.values())
    linear = "Thin dotted: without contacts; thin dashed: with stuck contacts. " if known else ""
    note = (
        f'<p class="note">{linear}Dots mark the highest peaks of the quantity shown; crosses at the bottom mark frequencies that '
        "did not converge. Click a point to see its loops.</p>"
    )
    return section("curves", "Response curves", html, note)


def _outputs(*datasets: "xr.Dataset") -> list[str]:
    return list(dict.fromkeys(str(name) for dataset in datasets for name in dataset.output.values))


def _loops_of_points(dataset: "xr.Dataset") -> Opening | None:
    """Loops at points spread over the curves, the peaks among them, as many as `OPENED` allows over all force levels."""
    rows = view.contact_rows(dataset)
    if not rows:
        return None
    drawn = loops_at(dataset, view.largest_loops(dataset, rows, LOOPS_OF_A_POINT), SAMPLES_OF_A_LOOP)
    loops: list[Chart] = []
    points_of = {}
    for case in range(dataset.sizes["case"]):
        kept, peak = view.converged_points(dataset, case), view.highest_peak(dataset, case)
        some = kept[spread(kept.size, max(OPENED // dataset.sizes["case"], 1))] if kept.size else kept
        some = np.unique(np.append(some, peak.point)) if peak is not None else some
        places: list[int | None] = [None] * view.points(dataset, case).size
        for point in some:
            places[int(np.searchsorted(view.points(dataset, case), point))] = len(loops)
            loops.append(drawn(case, int(point)))
        points_of[view.level_text(dataset, case)] = places
    return Opening(loops, points_of, CYCLE_NOTE)


def peaks(datasets: Datasets, charts: Charts) -> str:
    """The highest peak over the force level, and all peaks in tables, one for each quantity that they are of."""
    alike: dict[Measure, dict[str, xr.Dataset]] = {}
    for label, dataset in datasets.items():
        alike.setdefault(replace(view.measure_in(dataset), per_force=False), {})[label] = dataset
    parts = [_peaks_of(measure, f"-{k + 1}" if k else "", some, datasets) for k, (measure, some) in enumerate(alike.items())]
    trend = ""
    if any(dataset.sizes["case"] > 1 for dataset in datasets.values()):
        trend = charts.place("chart-trend", partial(compared_peaks, datasets), [Choice("Output", _outputs(*datasets.values()))])
    return section("peaks-section", "Peaks", trend, *parts)


def _peaks_of(measure: Measure, place: str, datasets: Datasets, every: Datasets) -> str:
    """The peaks of one quantity, and where it is largest in time."""
    unit = view.peak_unit(*datasets.values())
    rows = [row for label, dataset in datasets.items() for row in _peak_rows(label, dataset, len(every) > 1, unit, _ranked)]
    word = {"amplitude": "Amplitude", "rms": "Rms", "max_abs": "Largest"}[measure.kind]
    heads = ["Force level", "Output", "Peak", "Frequency in Hz", f"{word} in {unit.name}"]
    newtons = all(view.levels_in_newtons(dataset) for dataset in datasets.values())
    heads.append(f"{word} per force" if newtons else f"{word} per unit force level")
    heads += [f"Largest in {unit.name}"] if measure.kind != "max_abs" else []
    heads = [*_result_head(every), *heads, "Loss factor"]
    of = "first harmonic" if measure == DISPLACEMENT_AMPLITUDE else measure.words
    caption = f"Peaks: local maxima of the {of} along the curve, highest first."
    mean = "the mean and " if measure.order == 0 else ""
    largest = f"largest is max |{('x', 'ẋ', 'ẍ')[measure.order]}(t)| in time, with {mean}all harmonics."
    first = f"{word} is {measure.symbol}{', the first harmonic alone' if measure.kind == 'amplitude' else ''}; {largest} "
    first += "It may be smaller than the amplitude: a third harmonic can flatten the crests."
    said = largest.capitalize() if measure.kind == "max_abs" else first
    note = f'<p class="note">{said} {_loss_factor(datasets)}</p>'
    beyond = [row for label, dataset in datasets.items() for row in _peak_rows(label, dataset, len(every) > 1, unit, _outside)]
    outside = table(f"outside{place}", answer.OUTSIDE, heads, beyond, stacked=True) if beyond else ""
    shown = table(f"peaks{place}", caption, heads, rows, stacked=True)
    return shown + note + outside + _largest(measure, place, datasets, every)


def _loss_factor(datasets: Datasets) -> str:
    """What the loss factor is, and what a damping ratio makes of it."""
    meaning = (
        "The loss factor is the energy dissipated per cycle over 2π times the largest elastic energy: 2ζ for a damping ratio ζ"
    )
    disk = ", but 4ζ in a wave that travels around a disk, whose elastic energy is constant"
    return meaning + (disk if any(map(answer.engine_order, datasets.values())) else "") + "."


def _largest(measure: Measure, place: str, datasets: Datasets, every: Datasets) -> str:
    """Where the quantity over the whole period, with mean and all harmonics, is largest; peaks of this say so themselves."""
    rows, unit = [], view.peak_unit(*datasets.values())
    for label, dataset in datasets.items() if measure.kind != "max_abs" else ():
        for case, output in np.argwhere(np.isfinite(dataset.highest_max_abs.values)):
            size, frequency = (float(dataset[f"highest_max_abs{end}"].values[case, output]) for end in ("", "_frequency"))
            size *= view.measure_in(dataset).per(float(dataset.force_level[case]))
            cells = (cell(label) if len(every) > 1 else "") + cell(
                view.level_text(dataset, case), float(dataset.force_level[case])
            )
            cells += cell(str(dataset.output.values[output])) + cell(number(size / unit.metres), size)
            rows.append(f"<tr>{cells}{cell(hertz(frequency), frequency)}</tr>")
    heads = [*_result_head(every), "Force level", "Output", f"Largest in {unit.name}", "at Hz"]
    mean = "the mean and " if measure.order == 0 else ""
    caption = f"Largest {measure.quantity.name} in time along the curve, with {mean}all harmonics, at a peak of its own."
    return table(f"largest{place}", caption, heads, rows, stacked=True) if rows else ""


def loops(datasets: Datasets, charts: Charts) -> str:
    """Hysteresis loops at the peak."""
    html = ""
    for label, dataset in datasets.items():
        every = view.contact_rows(dataset)
        rows = {row.label: row for row in (every if len(every) <= MOST_LOOPS else view.largest_loops(dataset, every, MOST_LOOPS))}
        if rows:
            if len(rows) < len(every):
                html += (
                    f'<p class="note">The list has the {len(rows)} of {len(every)} contact directions with the largest loops.</p>'
                )
            first = view.largest_loops(dataset, [*rows.values()], 1)[0].label
            many = 2 * MOST_SHOWN * len(rows) * dataset.sizes["sample"] > NUMBERS_OF_LOOPS
            step = max(1, dataset.sizes["sample"] // SAMPLES_OF_MANY) if many else 1
            sizes = f"in {in_system('N', system_of(dataset))[1]} and {view.length_unit(dataset).name}", "each to its own size"
            choices = Choice("Contact", list(dict.fromkeys([first, *rows]))), Choice("Loops", sizes)
            draw = loops_of(dataset, MOST_SHOWN, step)
            html += charts.place("chart-loops", partial(_loops, draw, rows, sizes[1]), choices, label)
    note = (
        '<p class="note">One period at the highest peak of the first output. '
        "Double-click a level in the legend to see it alone.</p>"
    )
    return section("loops", "Hysteresis loops", html, note)


def _loops(
    draw: Callable[[view.ContactRow, bool], Chart], rows: Mapping[str, view.ContactRow], own: str, contact: str, size: str
) -> Chart:
    """The loops of the contact that the reader chose, each to its own size or not."""
    return draw(rows[contact], size == own)


def states(datasets: Datasets, charts: Charts) -> str:
    """Contact states along the curves, and a table of those at rest."""
    note = '<p class="note">Colours mix by the shares of the period. Gaps mark points that did not converge.</p>'
    html = "".join(
        charts.drawn("chart-states", contact_states(dataset, MOST_SHOWN), "", label) for label, dataset in datasets.items()
    )
    for place, (label, dataset) in enumerate(datasets.items()):
        if "rest_load" in dataset:
            html += framed(f"rest-{place}", f"{label}: contacts at rest", pd.DataFrame(by_surface(dataset, system_of(dataset))))
    return section("states", "Contact states", note, html)


def energies(datasets: Datasets, charts: Charts) -> str:
    """Where the energy goes, and the numbers that say whether to trust it."""
    rows = [row for label, dataset in datasets.items() for row in _energy_rows(label, dataset, len(datasets) > 1)]
    heads = ["Force level", "Dissipated at the peak", "Largest energy residual", "Largest slip work error", "Largest residual"]
    heads = [*_result_head(datasets), *heads]
    caption = (
        "Energy dissipated in contacts per period of the excitation at the highest peak, and accuracy over all converged points "
        f"inside the band: the energy balance of the solution (below {ENERGY_RESIDUAL_LIMIT:g}) and slip work against contact "
        f"work (below {SLIP_WORK_LIMIT:g}). What more harmonics and samples would change is estimated of this energy and of the "
        "height of the highest peaks; loss factors, contact forces and stresses have no estimate of their error."
    )
    html = ""
    for label, dataset in datasets.items():
        html += charts.drawn("chart-energy", dissipation(dataset), "", label)
    for label, dataset in datasets.items():
        html += charts.drawn("chart-loss", loss_factor(dataset), "", label)
    note = f'<p class="note">{_loss_factor(datasets)}</p>'
    return section("energy", "Energy", html, note, table("energies", caption, heads, rows))


def failures(datasets: Datasets, charts: Charts) -> str:
    """What failed and why, grouped by cause."""
    parts = []
    for label, dataset in datasets.items():
        count = sum(view.points(dataset, case).size for case in range(dataset.sizes["case"]))
        head = f"<h3>{text(label)}</h3>" if len(datasets) > 1 else ""
        causes = "".join(f"<li>{text(sentence)}</li>" for sentence in answer.failures_of(dataset))
        fine = f"<p>Every point converged: {counted(count, 'point')} on {counted(dataset.sizes['case'], 'curve')}.</p>"
        parts.append(head + (f'<ul class="failed">{causes}</ul>' if causes else fine))
    return section("failures", "What failed, and why", *parts)


def study(datasets: Datasets, charts: Charts) -> str:
    """The text of the study file."""
    parts = []
    for label, dataset in datasets.items():
        content = str(dataset.attrs["study"])
        if content.strip():
            parts.append(f"<details><summary>{text(label)}</summary><pre>{text(content)}</pre></details>")
        else:
            parts.append(f"<p>{text(label)}: computed from Python, without a study file.</p>")
    return section("study", "Study", *parts)


def versions(datasets: Datasets, charts: Charts) -> str:
    """What computed it, and how."""
    names = sorted({str(name) for dataset in datasets.values() for name in dataset.attrs} - {"study", "title"})
    rows = []
    for name in names:
        values = "".join(cell(str(dataset.attrs.get(name, ""))) for dataset in datasets.values())
        rows.append(f'<tr><th scope="row">{text(name)}</th>{values}</tr>')
    return section("versions", "Versions and settings", table("attributes", "Saved with the results", ["", *datasets], rows))


def _result_head(datasets: Datasets) -> list[str]:
    return ["Result"] if len(datasets) > 1 else []


def _peak_rows(label: str, dataset: "xr.Dataset", several: bool, unit: view.Length, ranked: Ranked) -> Iterator[str]:
    """The peaks of every curve and output, highest first, absolute and per force."""
    measure, (factor, per_force) = view.measure_in(dataset), view.per_force_unit(dataset)
    none = "largest of the listed frequencies" if view.is_listed(dataset) else "no peak inside the band; the largest point"
    for case in range(dataset.sizes["case"]):
        for output, name in enumerate(dataset.output.values):
            for rank, values in ranked(dataset, case, output):
                force = float(dataset.force_level[case])
                frequency, amplitude, largest_in_time, loss = (float(value) for value in values)
                normalised = amplitude / abs(force) if force else float("nan")
                cells = (cell(label) if several else "") + cell(view.level_text(dataset, case), force)
                cells += f"{cell(str(name))}<td>{text(rank or none)}</td>"
                cells += cell(hertz(frequency), frequency) + cell(number(amplitude / unit.metres), amplitude)
                cells += cell(f"{number(normalised / unit.metres * factor)} {unit.name}{per_force}", normalised)
                if measure.kind != "max_abs":
                    cells += cell(number(largest_in_time / unit.metres), largest_in_time)
                yield f'<tr data-case="{case}" data-rank="{rank}">{cells}{cell(number(loss), loss)}</tr>'


def _ranked(dataset: "xr.Dataset", case: int, output: int) -> Iterator[tuple[int, Array]]:
    """Rank and (frequency, size, largest, loss factor) of each peak, not per force; rank 0 for a curve without local maximum."""
    names = ("peak_frequency", "peak_amplitude", "peak_max_abs", "peak_loss_factor")
    table_of_peaks = np.array([dataset[name].values[case, :, output] for name in names]).T
    table_of_peaks[:, 1:3] *= view.measure_in(dataset).per(float(dataset.force_level[case]))
    solved = table_of_peaks[np.isfinite(table_of_peaks[:, 1])] if table_of_peaks.size else table_of_peaks
    yield from enumerate(solved, start=1)
    highest = view.highest_peak(dataset, case, output)
    if not len(solved) and highest is not None:
        yield 0, np.array([highest.frequency, highest.amplitude, highest.max_abs, highest.loss_factor])


def _outside(dataset: "xr.Dataset", case: int, output: int) -> Iterator[tuple[int, Array]]:
    """The same of the peaks outside the band."""
    for rank, peak in enumerate(view.peaks_outside(dataset, case, output), start=1):
        yield rank, np.array([peak.frequency, peak.amplitude, peak.max_abs, peak.loss_factor])


def _energy_rows(label: str, dataset: "xr.Dataset", several: bool) -> Iterator[str]:
    """What the contacts dissipate at the highest peak of each curve, and the worst measures of accuracy along it."""
    for case in range(dataset.sizes["case"]):
        peak, kept = view.highest_peak(dataset, case), view.in_band(dataset, case, view.converged_points(dataset, case))
        cells = (cell(label) if several else "") + cell(view.level_text(dataset, case), float(dataset.force_level[case]))
        if peak is None:
            yield f'<tr>{cells}<td colspan="4">no point converged</td></tr>'
            continue
        total = float(np.sum(dataset.dissipated.values[case, peak.point]))
        cells += cell(view.energy_text(total, dataset), total)
        for name, limit in LIMITS.items():
            values = np.abs(dataset[name].values[case, kept])
            worst = float(np.nanmax(values)) if np.any(np.isfinite(values)) else float("nan")
            cells += cell(f"{worst:.1e}" if np.isfinite(worst) else "–", worst, f"above {limit:g}" if worst > limit else "")
        yield f"<tr>{cells}</tr>"
