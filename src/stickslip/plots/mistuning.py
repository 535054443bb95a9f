"""Figures of mistuned disks: all blades with their envelope, distribution of the amplification, the most loaded blade and
damper.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.checks import Array, InputError, fault
from stickslip.plots.look import CONTACTS, FAILED, GREY, STICK, house_style, plain
from stickslip.results.view import measure_in, shown_unit

if TYPE_CHECKING:
    import xarray as xr

FITTED_FROM = 20
"""Samples from which a distribution is fitted."""


def _symbol(dataset: xr.Dataset) -> str:
    """What amplitudes are of."""
    measure = measure_in(dataset)
    return measure.symbol + ("/F" if measure.per_force else "")


def all_blades(dataset: xr.Dataset, sample: int | None = None) -> Figure:
    """The amplitude of every blade over the frequency, their envelope and the tuned disk.

    sample: counted from 0; the one with the highest amplification unless given.
    """
    if sample is None:
        ratio = dataset["amplification"].values
        sample = 0 if np.isnan(ratio).all() else int(np.nanargmax(ratio))
    if not 0 <= sample < dataset.sizes["sample"]:
        raise fault("sample", f"must lie between 0 and {dataset.sizes['sample'] - 1}", sample)
    one = dataset.isel(sample=sample)
    frequency, unit = one["frequency"].values, shown_unit(one["envelope"].attrs["units"], float(one["envelope"].max()))
    with house_style():
        figure = Figure(figsize=(7.6, 4.4), layout="constrained")
        axes = figure.add_subplot()
        for label, curve in zip(("each blade",) + (None,) * frequency.size, one["amplitude"].values.T, strict=False):
            axes.plot(frequency, curve / unit.metres, color=CONTACTS[4], lw=0.6, alpha=0.7, label=label)
        axes.plot(frequency, one["envelope"].values / unit.metres, color="black", label="envelope of all blades")
        axes.plot(dataset["tuned_frequency"], dataset["tuned_amplitude"] / unit.metres, "--", color=FAILED, label="tuned disk")
        worst = int(one["worst_blade"])
        if worst:
            top = one.isel(blade=worst - 1)
            height = float(top["blade_peak"]) / unit.metres
            axes.plot(float(top["blade_peak_frequency"]), height, "o", ms=5, color="black", label=f"highest: blade {worst}")
        axes.set(
            xlabel="frequency in Hz",
            ylabel=f"{_symbol(dataset)} in {unit.name}",
            title=plain(f"{dataset.attrs['title']}, sample {sample + 1}"),
        )
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0)
    return figure


def amplification(dataset: xr.Dataset) -> Figure:
    """Histogram of the amplification with the generalised extreme-value distribution fitted to it.

    A maximum over many blades tends to that distribution, whose three constants are fitted by maximum likelihood.
    """
    ratio = _solved(dataset)
    with house_style():
        figure = Figure(figsize=(7.6, 4.0), layout="constrained")
        axes = figure.add_subplot()
        axes.hist(ratio, bins=max(5, int(2 * ratio.size ** (1 / 3))), density=True, color=STICK, alpha=0.45, label="samples")
        if ratio.size >= FITTED_FROM and np.ptp(ratio) > 0.0:
            _fit(axes, ratio)
        for percent, style in ((50, ":"), (95, "--")):
            value = float(np.percentile(ratio, percent))
            axes.axvline(value, color=GREY, lw=1.0, ls=style, label=f"{percent} %: {value:.3f}")
        axes.set(xlabel="amplification, highest blade over tuned disk", ylabel="density", title=plain(dataset.attrs["title"]))
        axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.0)
    return figure


def _fit(axes: Axes, ratio: Array) -> None:
    from scipy.stats import genextreme

    constants = genextreme.fit(ratio)
    x = np.linspace(ratio.min() - 0.1 * np.ptp(ratio), ratio.max() + 0.1 * np.ptp(ratio), 200)
    axes.plot(x, genextreme.pdf(x, *constants), color="black", label=f"extreme-value fit, shape {-constants[0]:+.2f}")


def worst_blade(dataset: xr.Dataset) -> Figure:
    """How often each blade is the worst, and how far each goes: median and range of its own largest amplitude."""
    peaks = dataset["blade_peak"].values / float(dataset["tuned_peak"])
    worst = dataset["worst_blade"].values
    return _each_sector(dataset, worst, peaks, 1.0, ("blade", "samples where worst", f"largest {_symbol(dataset)} over tuned"))


def busiest_damper(dataset: xr.Dataset) -> Figure:
    """How often each damper takes out the most energy where a blade is highest, and how much each takes: median and range."""
    work, tuned = 1e6 * dataset["damper_work"].values, 1e6 * float(dataset["tuned_damper_work"])
    busiest = dataset["busiest_damper"].values
    words = ("damper after blade", "samples where busiest", "friction work in µJ a period")
    return _each_sector(dataset, busiest, work, tuned, words)


def _each_sector(dataset: xr.Dataset, first: Array, values: Array, tuned: float, words: tuple[str, str, str]) -> Figure:
    """Bars: samples in which each sector is the first; below median and range of the values (sample, sector)."""
    _solved(dataset)
    sectors, solved = dataset["blade"].values, values[dataset["worst_blade"].values > 0]
    with house_style():
        figure = Figure(figsize=(7.6, 5.0), layout="constrained")
        upper, lower = figure.subplots(2, 1, sharex=True)
        upper.bar(sectors, [int(np.count_nonzero(first == sector)) for sector in sectors], color=STICK)
        upper.set(ylabel=words[1], title=plain(dataset.attrs["title"]))
        middle = np.median(solved, axis=0)
        reach = np.array([middle - solved.min(axis=0), solved.max(axis=0) - middle])
        lower.errorbar(
            sectors, middle, reach, fmt="o", ms=4, color="black", ecolor=GREY, elinewidth=1.2, label="median and range"
        )
        lower.axhline(tuned, color=FAILED, lw=1.0, ls="--", label="tuned disk")
        lower.set(xlabel=words[0], ylabel=words[2])
        lower.legend(loc="best")
    return figure


def _solved(dataset: xr.Dataset) -> Array:
    ratio = dataset["amplification"].values
    ratio = ratio[np.isfinite(ratio)]
    if not ratio.size:
        raise InputError("The samples must hold one that was solved, but all failed.")
    return np.asarray(ratio)
