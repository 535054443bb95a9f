"""Figures of identifications and predictions: measured and fitted loops and responses, posterior, and what was predicted with its
intervals.

Figures of contact laws: measured loops and fit, parameters over the cycles, errors of the laws; stiffness over the load.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from stickslip.laboratory.identification.response.prediction_result import held_share
from stickslip.results.view import shown_unit, spread
from stickslip.show.plots.chart import Area, Axis, Bars, Chart, Layer, Line, Panel, Rule, band, closed, from_zero, spans
from stickslip.show.plots.look import CONTACTS, MOST_PANELS, Style, contact, entries, level
from stickslip.show.plots.response_curves import HERTZ
from stickslip.show.plots.time_response import HEIGHT
from stickslip.support.checks import Array
from stickslip.support.late import xr
from stickslip.support.renderers import FIGURES

CHANNELS = {
    "force_x": ("horizontal force", "N", 1.0),
    "force_y": ("vertical force", "N", 1.0),
    "rotation": ("rotation", "mrad", 1e3),
    "damper_y": ("vertical motion of the damper", "µm", 1e6),
}
"""Each channel in words, its unit in figures, and the factor to it."""
MEASURED, FITTED = contact(0, width=2.6), contact(1, width=1.3)


@FIGURES.of("Identification")
def loops_and_fit(dataset: xr.Dataset) -> Chart:
    """Each channel of each case against the platform's larger motion: measured dark, fitted orange."""
    all_cases, channels = dataset["case"].values, [str(channel) for channel in dataset["channel"].values]
    cases, panels = all_cases[spread(len(all_cases), MOST_PANELS)], []
    for case in cases:
        moves = dataset.sel(case=case)["platform_motion"].values
        motion = closed(1e6 * moves[int(np.argmax(np.ptp(moves, axis=1)))])
        for channel in channels:
            loop = dataset.sel(case=case, channel=channel)
            quantity, unit, factor = CHANNELS[channel]
            measured = closed(factor * loop["measured"].values)
            fitted = closed(factor * (loop["fitted"].values + float(loop["zero"])))
            layers = [Line(motion, measured, MEASURED, "measured"), Line(motion, fitted, FITTED, "fitted")]
            panels.append(Panel(Axis("motion of the platform", "µm"), Axis(quantity, unit), layers, str(case), 2.3))
    note = f"{len(cases)} of {len(all_cases)} cases" if len(cases) < len(all_cases) else ""
    return Chart("Measured and fitted loops", panels, columns=len(channels), note=note)


@FIGURES.of("Identification", "residuals")
def residuals(dataset: xr.Dataset) -> Chart:
    """Measured less fitted over the cycle, every case, without the mean."""
    channels, all_cases = [str(channel) for channel in dataset["channel"].values], dataset["case"].values
    cases = all_cases[spread(len(all_cases), len(CONTACTS))]
    phase, panels = np.arange(dataset.sizes["sample"]) / dataset.sizes["sample"], []
    for channel in channels:
        quantity, unit, factor = CHANNELS[channel]
        layers = []
        for k, case in enumerate(cases):
            loop = dataset.sel(case=case, channel=channel)
            left = factor * (loop["measured"].values - loop["fitted"].values)
            layers.append(Line(phase, left - left.mean(), contact(k, width=1.2), str(case)))
        panels.append(Panel(Axis("share of the cycle"), Axis(quantity, unit), layers, height=1.7))
    note = f"{len(cases)} of {len(all_cases)} cases" if len(cases) < len(all_cases) else ""
    return Chart("Residuals: measured less fitted", panels, note=note, shared_x=True)


@FIGURES.of("Identification", "posterior")
def posterior(dataset: xr.Dataset) -> Chart:
    """Refits of every pair of unknowns, with the identified values and 95 % intervals."""
    names = [str(name) for name in dataset["parameter"].values]
    empty = Panel(Axis(""), Axis(""), [], height=1.6)
    panels = [_pair(dataset, across, up) if j <= i else empty for i, up in enumerate(names) for j, across in enumerate(names)]
    return Chart("Refits of every pair of unknowns", panels, columns=len(names))


def _pair(dataset: xr.Dataset, across: str, up: str) -> Panel:
    """Refits of two unknowns, or their distribution where they are the same."""
    x = _scaled(dataset, across, dataset["replicates"].sel(parameter=across).values)
    low, high = _scaled(dataset, across, dataset["interval"].sel(parameter=across).values)
    if across == up:
        counts, edges = np.histogram(x, bins=10)
        layers: list[Layer] = [
            Bars(0.5 * (edges[1:] + edges[:-1]), counts, Style("grey"), "refits", width=float(edges[1] - edges[0]))
        ]
        ends, axis = (0.0, float(counts.max())), Axis("number of refits")
    else:
        y = _scaled(dataset, up, dataset["replicates"].sel(parameter=up).values)
        best_x, best_y = ([float(_scaled(dataset, name, dataset["value"].sel(parameter=name).values))] for name in (across, up))
        layers = [Line(x, y, Style("grey", "none", marker="circle", size=2.5), "refits")]
        layers.append(Line(best_x, best_y, contact(1, dash="none", marker="circle", size=5.0), "identified"))
        ends, axis = (float(np.nanmin(y)), float(np.nanmax(y))), _axis(dataset, up)
    if np.isfinite(low):
        corners = [low, high, high, low], [ends[0], ends[0], ends[1], ends[1]]
        layers.insert(0, Area(*corners, contact(0, opacity=0.14), "95 % interval"))
    return Panel(_axis(dataset, across), axis, layers, height=1.6)


def _scaled(dataset: xr.Dataset, name: str, values: Array) -> Array:
    return np.asarray(values * (1.0 if str(dataset["parameter_units"].sel(parameter=name).values) == "1" else 1e-6))


def _axis(dataset: xr.Dataset, name: str) -> Axis:
    """kt, kn, or μ with the contact lines that it is of."""
    symbol, _, lines = name.replace("mu", "μ", 1).partition("_")
    return Axis(
        f"{symbol} of {lines}" if lines else symbol,
        "" if str(dataset["parameter_units"].sel(parameter=name).values) == "1" else "N/µm",
    )


@FIGURES.of("ResponseIdentification")
def measured_and_computed(dataset: xr.Dataset) -> Chart:
    """Response per force of every test over frequency, measured (dots) and computed (lines); the phase where it is known."""
    count, names = dataset.sizes["test"], [str(name) for name in dataset["test"].values]
    quantity = str(dataset["quantity"].values[0])
    units = {"displacement": "m/N", "velocity": "m/(s N)", "acceleration": "m/(s2 N)"}[quantity]
    unit = shown_unit(units, float(np.nanmax(dataset["measured"].values)))
    listed = entries(names)
    top: list[Layer] = []
    bottom: list[Layer] = []
    for t, name in enumerate(names):
        test, shown = dataset.isel(test=t), name in listed
        style, dots = level(t, count), level(t, count, dash="none", marker="circle", size=2.5)
        f = test["frequency"].values
        for key, look, own in (("measured", dots, False), ("computed", style, shown)):
            top.append(Line(f, test[key].values / unit.metres, look, name, listed=own))
            if np.isfinite(test["measured_phase"].values).any():
                bottom.append(Line(f, test[f"{key}_phase"].values, look, name, listed=own))
    size = Axis(
        f"{quantity} per force", unit.name, log=spans(dataset["measured"].values[np.isfinite(dataset["measured"].values)], 8.0)
    )
    panels = [Panel(HERTZ, size, top, height=3.2)]
    panels += [Panel(HERTZ, Axis("phase", "°"), bottom, height=1.9)] if bottom else []
    return Chart("Measured (dots) and computed (lines) responses", panels, shared_x=True)


@FIGURES.of("ResponseIdentification", "misfits")
def misfits(dataset: xr.Dataset) -> Chart:
    """Misfit of each test, and what the others predict of it where tests were left out."""
    names = {float(t): str(name) for t, name in enumerate(dataset["test"].values)}
    places = np.arange(len(names), dtype=float)
    shown = [("misfit", "fitted", 0)]
    if np.isfinite(dataset["held_out"].values).any():
        shown.append(("held_out", "predicted by the other tests", 1))
    width = 0.8 / len(shown)
    across: dict[str, Any] = {"width": 0.9 * width, "horizontal": True}
    layers: list[Layer] = [
        Bars(places + (k - 0.5 * (len(shown) - 1)) * width, 100.0 * dataset[key].values, contact(k), label, **across)
        for key, label, k in shown
    ]
    axes = Axis("misfit relative to the largest response", "%"), Axis("", names=names, upside_down=True)
    return Chart("Misfit of each test", [Panel(*axes, layers, height=0.8 + 0.3 * len(names))])


@FIGURES.of("ResponseIdentification", "intervals")
def intervals(dataset: xr.Dataset) -> Chart:
    """95 % intervals of the parameters, relative to their values."""
    names = {float(k): str(name) for k, name in enumerate(dataset["parameter"].values)}
    value = np.abs(dataset["value"].values)
    low, high = (
        100.0 * (dataset[key].values - dataset["value"].values) / np.where(value > 0.0, value, 1.0) for key in ("low", "high")
    )
    places = np.arange(len(names), dtype=float)
    bars = Bars(places, high - low, Style("contact 0"), "95 % interval", base=low, horizontal=True)
    axes = Axis("distance from the value", "%"), Axis("", names=names, upside_down=True)
    return Chart("Intervals of the parameters", [Panel(*axes, [bars], height=0.6 + 0.3 * len(names))])


def _largest(values: Array) -> float:
    """The largest number of an array, 0 of none."""
    return float(values[np.isfinite(values)].max(initial=0.0))


@FIGURES.of("ResponsePrediction")
def predicted(dataset: xr.Dataset) -> Chart:
    """Of each level the median of the draws (lines) and the 95 % band (areas) over frequency, and measured points (dots)."""
    levels, count = dataset["level"], dataset.sizes["level"]
    names = [f"{value:.4g} {levels.attrs['units']}" for value in levels.values]
    listed, values = entries(names), dataset["amplitude"].values
    unit = shown_unit(dataset["amplitude"].attrs["units"], _largest(values))
    layers: list[Layer] = []
    for k, name in enumerate(names):
        one = dataset.isel(level=k)
        f, low, high = (one[key].values for key in ("frequency", "amplitude_low", "amplitude_high"))
        label = f"{held_share(dataset):.0f} % interval" if count == 1 else ""
        layers.append(band(f, low / unit.metres, high / unit.metres, level(k, count, opacity=0.25), label))
        layers.append(Line(f, one["amplitude"].values / unit.metres, level(k, count), name, listed=name in listed))
    for t in range(dataset.sizes.get("measured", 0)):
        one = dataset.isel(measured=t)
        dots = level(int(one["predicted_level"]), count, dash="none", marker="circle", size=2.5)
        f, size = one["measured_frequency"].values, one["measured_amplitude"].values / unit.metres
        layers.append(Line(f, size, dots, hover={"": [str(one["measured"].values)] * f.size}))
    quantity = f"{dataset.attrs['quantity']}{' per force' if dataset.attrs['held'] == 'response' else ''}"
    axis = Axis(quantity, unit.name, log=spans(values[np.isfinite(values)], 8.0))
    dotted = ", measured points (dots)" if "measured" in dataset.sizes else ""
    return Chart(
        f"Predicted responses (lines) with {held_share(dataset):.0f} % bands (areas){dotted}",
        [Panel(HERTZ, axis, layers, height=3.6)],
    )


@FIGURES.of("ResponsePrediction", "peaks")
def predicted_peaks(dataset: xr.Dataset) -> Chart:
    """Peak response and peak frequency over the levels with their 95 % intervals."""
    levels = dataset["level"]
    at = Axis(str(levels.attrs["long_name"]), str(levels.attrs["units"]), log=levels.size > 1)
    unit = shown_unit(dataset["peak_amplitude"].attrs["units"], _largest(dataset["peak_amplitude"].values))
    panels: list[Panel] = []
    share = f"{held_share(dataset):.0f} % interval"
    order = np.argsort(levels.values)
    for key, axis, factor in (
        ("peak_amplitude", Axis(f"peak {dataset.attrs['quantity']}", unit.name), unit.metres),
        ("peak_frequency", Axis("peak frequency", "Hz"), 1.0),
    ):
        low, middle, high = (dataset[f"{key}{end}"].values[order] / factor for end in ("_low", "", "_high"))
        x = levels.values[order]
        points = level(0, 1, dash="none", marker="circle", size=4.0)
        whiskers = np.column_stack([low, high, np.full(x.size, np.nan)]).ravel()
        bars = Line(np.repeat(x, 3), whiskers, level(0, 1), share, listed=not panels)
        panels.append(Panel(at, axis, [bars, Line(x, middle, points, "median", listed=not panels)], height=2.2))
    return Chart(f"Predicted peaks with {share}s", panels, shared_x=True)


@FIGURES.of("DecayPrediction")
def predicted_decay(dataset: xr.Dataset) -> Chart:
    """The median of the draws (line) and the 95 % band (area) of frequency and damping ratio over the amplitude, and the
    windows of measured decays (dots)."""
    size = dataset["amplitude"].values
    unit, share = shown_unit("m", float(size.max()), dataset), f"{held_share(dataset):.0f} % interval"
    count = dataset.sizes.get("decay", 0)

    def along(key: str, factor: float) -> list[Layer]:
        low, middle, high = (factor * dataset[f"{key}{end}"].values for end in ("_low", "", "_high"))
        x = size / unit.metres
        layers: list[Layer] = [band(x, low, high, level(0, count + 1, opacity=0.25), share)]
        layers.append(Line(x, middle, level(0, count + 1), "predicted"))
        for t in range(count):
            one = dataset.isel(decay=t)
            dots = level(t + 1, count + 1, dash="none", marker="circle", size=2.5)
            at, values = one["measured_amplitude"].values / unit.metres, factor * one[f"measured_{key}"].values
            layers.append(Line(at[np.isfinite(at)], values[np.isfinite(at)], dots, str(one["decay"].values)))
        return layers

    across = Axis("amplitude", unit.name, log=True)
    panels = [
        Panel(across, Axis("frequency", "Hz"), along("frequency", 1.0), "Frequency", HEIGHT),
        Panel(across, Axis("damping ratio", "%"), along("damping_ratio", 100.0), "Damping", HEIGHT),
    ]
    return Chart(str(dataset.attrs["title"]), panels, columns=2)


MOST_LOOPS = 6
"""Loops in one figure."""

MANY_DECADES = 50.0
"""Ratio of cycle numbers from which their axis is logarithmic."""


@FIGURES.of("ContactLaw")
def law_loops_and_fit(dataset: xr.Dataset) -> Chart:
    """Measured loops, dark, and those of the chosen law, orange."""
    names = dataset["loop"].values
    shown = names[spread(len(names), MOST_LOOPS)]
    axes, panels = (Axis("displacement", "µm"), Axis("friction force", "N")), []
    for name in shown:
        loop = dataset.sel(loop=name)
        u = 1e6 * loop["displacement"].values
        there = np.isfinite(u)
        layers = [
            Line(closed(u[there]), closed(loop[variable].values[there]), style, label)
            for variable, label, style in (
                ("force_measured", "measured", contact(0, width=2.4)),
                ("force_fitted", str(dataset.attrs["best"]), contact(1, width=1.2)),
            )
        ]
        panels.append(Panel(*axes, layers, str(name), 2.5))
    note = f"{len(shown)} of {len(names)}" if len(shown) < len(names) else ""
    return Chart("Measured and fitted loops", panels, columns=min(len(shown), 3), note=note)


@FIGURES.of("ContactLaw", "cycles")
def over_cycles(dataset: xr.Dataset) -> Chart:
    """kt, μ and energy against the cycle number, with bands of one standard deviation."""
    number = dataset["cycle_number"].values
    wide = number.min() > 0 and number.max() > MANY_DECADES * max(number.min(), 1) and len(number) < number.max() // 2
    cycle = Axis("cycle", log=bool(wide))
    stiffness = _with_band(number, 1e-6 * dataset["cycle_kt"].values, 1e-6 * dataset["cycle_kt_error"].values)
    known = "least_mu" not in dataset.attrs
    friction = _with_band(number, dataset["cycle_mu"].values, dataset["cycle_mu_error"].values) if known else []
    plateau = Style("grey", "none", marker="circle", size=2.5)
    friction.append(Line(number, dataset["plateau"].values, plateau, "plateau of the force over the load"))
    energy = [
        Line(number, 1e3 * dataset[name].values, contact(k, width=1.0, marker="circle", size=2.5), words)
        for k, (name, words) in enumerate((("energy_measured", "measured"), ("energy_fitted", "fitted energy")))
    ]
    panels = [
        Panel(cycle, Axis("tangential stiffness kt", "N/µm"), stiffness, height=2.0),
        Panel(cycle, Axis("friction coefficient μ"), friction, height=2.0),
        Panel(cycle, Axis("energy per cycle", "mJ"), energy, height=2.0),
    ]
    return Chart("Parameters over the cycles", panels, shared_x=True)


@FIGURES.of("ContactLaw", "laws")
def held_out(dataset: xr.Dataset) -> Chart:
    """Misfit of every law, and its error on loops held out."""
    laws = [str(law) for law in dataset["law"].values]
    places = np.arange(len(laws), dtype=float)
    layers = [
        Bars(places + shift, 100.0 * dataset[name].values, Style(shade), words, width=0.38)
        for shift, name, words, shade in ((-0.2, "misfit", "fit", "pale"), (0.2, "held_out", "loops held out", "contact 0"))
    ]
    across = Axis("contact law", names={float(place): law for place, law in enumerate(laws)})
    panel = Panel(across, Axis("error, relative to the rms force", "%"), layers, height=2.4)
    return Chart(f"Law of the contact: {dataset.attrs['best']}", [panel])


def _with_band(number: Array, value: Array, error: Array) -> list[Layer]:
    line = Line(number, value, contact(0, width=1.0, marker="circle", size=2.5), "fitted", {"standard deviation": error})
    return [band(number, value - error, value + error, contact(0, opacity=0.2), "one standard deviation"), line]


@FIGURES.of("ContactStiffness")
def stiffness_over_load(dataset: xr.Dataset) -> Chart:
    """Normal stiffness by every formula, the initial tangential ones dotted (across) and dashed (along), the load of interest."""
    load, at = dataset["load"].values, float(dataset.attrs["load_of_interest"])
    layers: list[Layer] = [
        Line(load, dataset["normal_stiffness"].sel(formula=formula).values / 1e6, contact(k), f"normal, {formula}")
        for k, formula in enumerate(dataset["formula"].values)
    ]
    across, along = (dataset[f"tangential_{direction}"].values / 1e6 for direction in ("across", "along"))
    layers.append(Line(load, across, Style("ink", "dot"), "tangential, across the line (initial)"))
    layers.append(Line(load, along, Style("grey", "dash"), "tangential, along the line (initial)"))
    layers += [Rule(at, Style("grey", width=0.9), f"{at:.4g} N")] if np.isfinite(at) else []
    panel = Panel(from_zero(Axis("normal load", "N")), Axis("stiffness", "N/µm"), layers, height=3.5)
    return Chart("Stiffness of the line contact", [panel])
