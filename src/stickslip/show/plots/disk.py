"""Figures of bladed disks: mode shape, dampers, nodal diameters, damping of waves, mean normal loads; of
mistuned ones all blades with their envelope, distribution of the amplification, the most loaded blade and damper."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.results.view import level_text, representatives, shown_unit
from stickslip.show.plots.chart import Axis, Bars, Chart, Layer, Line, Panel, Rule, band
from stickslip.show.plots.look import CONTACTS, GREY, OPEN, SLIP, STICK, Style, contact, headed, house_style, state_colour
from stickslip.show.plots.response_curves import HERTZ, force_axis, size_label
from stickslip.support.checks import Array, InputError, fault
from stickslip.support.late import Axes, Figure, xr
from stickslip.support.renderers import FIGURES

EXAGGERATION = 0.06
"""Largest displacement in a picture, relative to the radius of the disk."""
RINGS = (
    "A piece is a damper, its arcs the contacts; colours mix shares of the period at the\n"
    "largest amplitude, the mean of the tangential directions"
)
"""What the figure of dampers shows."""
MOST_RINGS = 12
"""Force levels in the figure of dampers."""


def placed_sectors(dataset: xr.Dataset) -> tuple[Array, Array]:
    """Surface of all sectors in space at one instant: corners (faces, 4, 3) [m] and the size of their motion (faces,), 0 to 1."""
    points, quads, parts = (dataset[f"disk_{name}"].values for name in ("points", "quads", "shape"))
    shape: NDArray[np.complex128] = parts[..., 0] + 1j * parts[..., 1]
    sectors, order = int(dataset.attrs["sectors"]), _excited(dataset)[0]
    scale = EXAGGERATION * float(np.hypot(points[:, 0], points[:, 1]).max())
    corners, sizes = [], []
    for j in range(sectors):
        angle = 2.0 * np.pi * j / sectors
        turn = np.array([[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
        moved = (shape * np.exp(-1j * order * angle)).real
        corners.append(((points + scale * moved) @ turn.T)[quads])
        sizes.append(np.linalg.norm(moved, axis=1)[quads].mean(axis=1))
    return np.concatenate(corners), np.concatenate(sizes)


def disk_mode(dataset: xr.Dataset) -> Figure:
    """The disk in its first stuck mode at the first excited nodal diameter, at one instant, coloured by the motion."""
    from matplotlib import colormaps
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    from stickslip.show.plots.paper import NotebookFigure

    corners, sizes = placed_sectors(dataset)
    n = _folded(dataset)[0]
    with house_style():
        figure = NotebookFigure(figsize=(7.0, 6.2), layout="constrained")
        axes: Any = figure.add_subplot(projection="3d")
        colours = colormaps["viridis"](sizes)
        axes.add_collection3d(Poly3DCollection(corners, facecolors=colours, edgecolors=(0, 0, 0, 0.25), linewidths=0.15))
        reach = float(np.abs(corners[..., :2]).max())
        axes.set(xlim=(-reach, reach), ylim=(-reach, reach), zlim=(-0.45 * reach, 0.45 * reach))
        axes.set_box_aspect((1.0, 1.0, 0.45))
        axes.set_proj_type("ortho")
        axes.view_init(elev=50.0, azim=-60.0)
        axes.set_axis_off()
        axes.set_title(f"First stuck mode, nodal diameter {n}, motion exaggerated")
    return figure


def damper_ring(dataset: xr.Dataset) -> Figure:
    """Dampers around the disk at the largest amplitude, a ring for each force level; colours mix shares of stick, slip, open."""
    from matplotlib.patches import Wedge

    from stickslip.show.plots.paper import NotebookFigure

    chosen = representatives(dataset, MOST_RINGS)
    dataset, levels = chosen.dataset, chosen.dataset.sizes["case"]
    columns = min(levels, 4)
    with house_style():
        figure = NotebookFigure(figsize=(max(2.6 * columns + 0.4, 7.0), 2.9 * -(-levels // columns) + 0.4), layout="constrained")
        panels = figure.subplots(-(-levels // columns), columns, squeeze=False).ravel()
        for case, axes in enumerate(panels):
            axes.set_axis_off()
            if case < levels and dataset["amplitude"][case].notnull().any():
                _ring(axes, dataset, case)
                axes.set_title(level_text(dataset, case))
        handles = [Wedge((0.0, 0.0), 1.0, 0.0, 90.0, facecolor=c, edgecolor=GREY) for c in (STICK, SLIP, OPEN)]
        figure.legend(handles, ["stick", "slip", "open"], loc="outside lower center", ncols=3)
        headed(figure, "Dampers around the disk", f"{RINGS}\n{chosen.words}".strip())
    return figure


def _ring(axes: Axes, dataset: xr.Dataset, case: int) -> None:
    """Each damper a sector of the ring, its contacts one outside another, in the mixed colours of their states."""
    from matplotlib.patches import Wedge

    point = int(dataset["amplitude"].isel(case=case, output=0).argmax("point"))
    here = dataset.isel(case=case, point=point)
    shares = [here[f"share_{name}"].sel(direction=["t1", "t2"]).mean("direction").values for name in ("stick", "slip", "open")]
    sectors, of_contacts = int(dataset.attrs["sectors"]), np.stack(shares, axis=-1)
    # Contacts of a whole disk are numbered by sector; those of a tuned one stand for all sectors.
    whole = all(re.match(r"\d+ ", str(name)) for name in dataset["contact"].values) and len(of_contacts) % sectors == 0
    of_dampers = of_contacts.reshape(sectors, -1, 3) if whole else np.broadcast_to(of_contacts, (sectors, *of_contacts.shape))
    width = 0.45 / of_dampers.shape[1]
    for j, damper in enumerate(of_dampers):
        ends = np.degrees(2.0 * np.pi / sectors * np.array([j + 0.06, j + 0.94]))
        for c, states in enumerate(damper):
            shade, outer = state_colour(*states), 1.0 - c * width
            axes.add_patch(Wedge((0.0, 0.0), outer, *ends, width=0.96 * width, facecolor=shade, edgecolor=GREY, lw=0.2))
    axes.set(xlim=(-1.05, 1.05), ylim=(-1.05, 1.05), aspect="equal")


@FIGURES.of("NodalDiameters")
def nodal_diameter_diagram(dataset: xr.Dataset) -> Chart:
    """Natural frequencies over the nodal diameter, without contacts and with all of them stuck, and what is excited."""
    frequencies = dataset["disk_frequency"].values
    diameters = np.arange(frequencies.shape[1])
    layers: list[Layer] = []
    for state, (words, dash, marker) in enumerate((("without contacts", "dot", "circle"), ("contacts stuck", "solid", "square"))):
        style = contact(state, dash=dash, marker=marker, width=1.0, size=3.5)
        layers += [Line(diameters, frequencies[state, :, mode], style, words) for mode in range(frequencies.shape[2])]
    for order, n in zip(_excited(dataset), _folded(dataset), strict=True):
        layers.append(Rule(n, Style("grey", width=0.9), f"engine order {order}"))
    panel = Panel(Axis("nodal diameter"), Axis("natural frequency", "Hz", log=True), layers, height=3.7)
    return Chart("Nodal diameters", [panel])


def wave_damping(dataset: xr.Dataset) -> Chart:
    """The damping of travelling waves of the disk of a forced response: the first family of modes, contacts stuck."""
    names = {f"wave_{name}": name for name in ("damping_ratio", "aerodynamic_damping", "frequency", "frequency_shift")}
    waves = dataset[list(names)].rename({"wave": "nodal_diameter", **names})
    return over_nodal_diameter(waves.assign_attrs(title="Damping of travelling waves", mode=1, contacts="stuck"))


@FIGURES.of("DampingByNodalDiameter")
def over_nodal_diameter(dataset: xr.Dataset) -> Chart:
    """Aerodynamic damping ratio, the S curve, and dotted that with the damping of the structure, over the nodal diameter."""
    x = dataset["nodal_diameter"].values
    hover = {"frequency in Hz": dataset["frequency"].values, "frequency shift in %": 100.0 * dataset["frequency_shift"].values}
    aerodynamic = contact(0, marker="circle", size=4.0)
    whole = contact(1, dash="dot", marker="circle", size=3.0)
    layers: list[Layer] = [
        Line(x, 100.0 * dataset["aerodynamic_damping"].values, aerodynamic, "aerodynamic", hover),
        Line(x, 100.0 * dataset["damping_ratio"].values, whole, "with that of the structure", hover),
        Rule(0.0, Style("grey", width=0.9), along="y"),
    ]
    panel = Panel(Axis("nodal diameter"), Axis("damping ratio", "%"), layers)
    return Chart(str(dataset.attrs["title"]), [panel], note=f"mode {dataset.attrs['mode']}, contacts {dataset.attrs['contacts']}")


def mean_normal_load(dataset: xr.Dataset, reference: float | None = None) -> Chart:
    """Mean normal load of each contact line at the largest amplitude over the force level.

    reference: F_C/(2 cos α) [N]; that of the disk unless given.
    """
    reference = dataset.attrs.get("static_normal_load") if reference is None else reference
    names = [re.sub(r"\s+\d+$", "", str(name)) for name in dataset["contact"].values]
    lines = list(dict.fromkeys(names))[: len(CONTACTS)]
    levels = dataset["force_level"].values
    mean, first = (np.full((len(lines), levels.size), np.nan) for _ in range(2))
    for case in range(levels.size):
        if not dataset["amplitude"][case].notnull().any():
            continue
        point = int(dataset["amplitude"].isel(case=case, output=0).argmax("point"))
        force = dataset["contact_force"].isel(case=case, point=point).sel(direction="n").values
        for i, line in enumerate(lines):
            total = force[[name == line for name in names]].sum(axis=0)
            mean[i, case], first[i, case] = total[0, 0], np.hypot(*total[1])
    layers: list[Layer] = []
    for i, line in enumerate(lines):
        layers.append(band(levels, mean[i] - first[i], mean[i] + first[i], contact(i, opacity=0.12)))
        layers.append(Line(levels, mean[i], contact(i, marker="circle"), line, {"first harmonic in N": first[i]}))
    if reference is not None:
        layers.append(Rule(float(reference), Style("grey", "dash", 1.0), "F_C/(2 cos α)", "y"))
    force_level = replace(force_axis(dataset, levels), log=True)
    panel = Panel(force_level, Axis("mean normal load", "N"), layers, height=3.3)
    return Chart("Mean normal load under vibration (band: first harmonic)", [panel])


def _excited(dataset: xr.Dataset) -> tuple[int, ...]:
    """The excited engine orders; files that do not say have one."""
    return tuple(int(order) for order in np.atleast_1d(dataset.attrs.get("excited_orders", dataset.attrs["engine_order"])))


def _folded(dataset: xr.Dataset) -> list[int]:
    """The nodal diameters that they excite."""
    sectors = int(dataset.attrs["sectors"])
    return [min(order % sectors, -order % sectors) for order in _excited(dataset)]


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
