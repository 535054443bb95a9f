"""Figures of mistuned disks: all blades with their envelope, distribution of the amplification, the most loaded blade and
damper.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.results.view import shown_unit
from stickslip.show.plots.chart import Axis, Bars, Chart, Layer, Line, Panel, Rule
from stickslip.show.plots.look import Style
from stickslip.show.plots.response_curves import HERTZ, size_label
from stickslip.support.checks import Array, InputError, fault
from stickslip.support.renderers import FIGURES

if TYPE_CHECKING:
    import xarray as xr

FITTED_FROM = 20
"""Samples from which a distribution is fitted."""
TUNED = Style("failed", "dash", 1.4)
"""The tuned disk, to which samples are compared."""


@FIGURES.of("MistunedPopulation")
def all_blades(dataset: xr.Dataset, sample: int | None = None) -> Chart:
    """The amplitude of every blade over the frequency, their envelope and the tuned disk.

    sample: counted from 0; the one with the highest amplification unless given.
    """
    if sample is None:
        ratio = dataset["amplification"].values
        sample = 0 if np.isnan(ratio).all() else int(np.nanargmax(ratio))
    if not 0 <= sample < dataset.sizes["sample"]:
        raise fault("sample", f"must lie between 0 and {dataset.sizes['sample'] - 1}", sample)
    shown = dataset.isel(sample=sample)
    hertz, envelope = shown["frequency"].values, shown["envelope"]
    unit = shown_unit(envelope.attrs["units"], float(envelope.max()))
    layers: list[Layer] = [
        Line(
            hertz, curve / unit.metres, Style("contact 4", width=0.6, opacity=0.7), "each blade", {"blade": [blade] * hertz.size}
        )
        for blade, curve in zip(shown["blade"].values.tolist(), shown["amplitude"].values.T, strict=True)
    ]
    layers.append(Line(hertz, envelope.values / unit.metres, Style("ink"), "envelope of all blades"))
    layers.append(Line(dataset["tuned_frequency"].values, dataset["tuned_amplitude"].values / unit.metres, TUNED, "tuned disk"))
    if worst := int(shown["worst_blade"]):
        top = shown.isel(blade=worst - 1)
        dot = Style("ink", "none", marker="circle", size=5.0)
        place = [float(top["blade_peak_frequency"])], [float(top["blade_peak"]) / unit.metres]
        layers.append(Line(*place, dot, f"highest: blade {worst}"))
    panel = Panel(HERTZ, Axis(size_label(dataset), unit.name), layers, height=3.7)
    return Chart(f"{dataset.attrs['title']}, sample {sample + 1}", [panel])


@FIGURES.of("MistunedPopulation", "amplification")
def amplification(dataset: xr.Dataset) -> Chart:
    """Histogram of the amplification with the generalised extreme-value distribution fitted to it.

    A maximum over many blades tends to that distribution, whose three constants are fitted by maximum likelihood.
    """
    ratio = _solved(dataset)
    density, edges = np.histogram(ratio, bins=max(5, int(2 * ratio.size ** (1 / 3))), density=True)
    middle, width = 0.5 * (edges[1:] + edges[:-1]), float(edges[1] - edges[0])
    layers: list[Layer] = [Bars(middle, density, Style("stick", opacity=0.5), "samples", width=width)]
    if ratio.size >= FITTED_FROM and np.ptp(ratio) > 0.0:
        from scipy.stats import genextreme

        constants = genextreme.fit(ratio)
        x = np.linspace(ratio.min() - 0.1 * np.ptp(ratio), ratio.max() + 0.1 * np.ptp(ratio), 200)
        label = f"extreme-value fit, shape {-constants[0]:+.2f}"  # SciPy's sign of the shape is the opposite of the usual one
        layers.append(Line(x, genextreme.pdf(x, *constants), Style("ink"), label))
    for percent, style in ((50, Style("grey", "dot", 1.1)), (95, Style("grey", "dash", 1.1))):
        value = float(np.percentile(ratio, percent))
        layers.append(Rule(value, style, f"{percent} %: {value:.3f}"))
    axes = Axis("amplification, highest blade over tuned disk"), Axis("probability density")
    return Chart(f"Amplification: {dataset.attrs['title']}", [Panel(*axes, layers, height=3.3)])


@FIGURES.of("MistunedPopulation", "worst_blade")
def worst_blade(dataset: xr.Dataset) -> Chart:
    """How often each blade is the worst, and how far each goes: median and range of its own largest amplitude."""
    peaks = dataset["blade_peak"].values / float(dataset["tuned_peak"])
    axes = Axis("blade"), Axis("samples in which it is the worst"), Axis(f"largest {size_label(dataset)} over tuned")
    return _each_sector(dataset, dataset["worst_blade"].values, peaks, 1.0, axes, "Worst blades")


def busiest_damper(dataset: xr.Dataset) -> Chart:
    """How often each damper takes out the most energy where a blade is highest, and how much each takes: median and range."""
    work, tuned = 1e6 * dataset["damper_work"].values, 1e6 * float(dataset["tuned_damper_work"])
    axes = Axis("damper after blade"), Axis("samples in which it is the busiest"), Axis("friction work per period", "µJ")
    return _each_sector(dataset, dataset["busiest_damper"].values, work, tuned, axes, "Busiest dampers")


def _each_sector(
    dataset: xr.Dataset, first: Array, values: Array, tuned: float, axes: tuple[Axis, Axis, Axis], title: str
) -> Chart:
    """Bars: samples in which each sector is the first; below median and range of the values (sample, sector)."""
    _solved(dataset)
    sectors, solved = dataset["blade"].values, values[dataset["worst_blade"].values > 0]
    counts = [int(np.count_nonzero(first == sector)) for sector in sectors]
    low, middle, high = solved.min(axis=0), np.median(solved, axis=0), solved.max(axis=0)
    gap = np.full(sectors.size, np.nan)
    ranges = Line(np.repeat(sectors, 3), np.stack([low, high, gap], axis=1).ravel(), Style("grey", width=1.3), "range")
    hover = {"lowest": low, "highest": high}
    medians = Line(sectors, middle, Style("ink", "none", marker="circle"), "median", hover)
    lower: list[Layer] = [ranges, medians, Rule(tuned, TUNED, "tuned disk", "y")]
    panels = [Panel(axes[0], axes[1], [Bars(sectors, counts, Style("stick"))]), Panel(axes[0], axes[2], lower)]
    return Chart(f"{title}: {dataset.attrs['title']}", panels, shared_x=True)


def _solved(dataset: xr.Dataset) -> Array:
    ratio = dataset["amplification"].values
    ratio = ratio[np.isfinite(ratio)]
    if not ratio.size:
        raise InputError("The samples must hold one that was solved, but all failed.")
    return np.asarray(ratio)
