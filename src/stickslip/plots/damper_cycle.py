"""A damper cycle in six panels: platform hysteresis, contact forces, force ratios, motion and its parts, the plane of friction
forces with its limit lines, and the timeline of stick, slip and open."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from stickslip.plots.look import CONTACTS, GREY, OPEN, SLIP, STICK, house_style, plain
from stickslip.units import um

if TYPE_CHECKING:
    import xarray as xr

COLOURS = {0: STICK, 1: SLIP, -1: SLIP, 2: OPEN}


def damper_cycle(dataset: xr.Dataset) -> Figure:
    """Everything that one cycle of a damper between two platforms shows."""
    with house_style():
        figure = Figure(figsize=(10.5, 9.0), layout="constrained")
        panels = figure.subplots(3, 2).ravel()
        for panel, draw in zip(panels, (_hysteresis, _forces, _ratios, _motion, _plane, _timeline), strict=True):
            draw(panel, dataset)
        energy, rotation = float(dataset.loop_energy) * 1e6, float(dataset.rotation) * 1e3
        words = f"{dataset.attrs['title']}: {energy:.4g} µJ a cycle, rotation {rotation:.3g} mrad, {dataset.attrs['outcome']}"
        figure.suptitle(plain(words), x=0.01, ha="left", fontweight="bold", fontsize=10.5)
    return figure


def _hysteresis(axes: Any, dataset: xr.Dataset) -> None:
    for axis, (name, colour) in enumerate(zip(("horizontal", "vertical"), CONTACTS, strict=False)):
        motion, force = (dataset[key].values[:, axis] for key in ("platform_motion", "force_on_right"))
        if np.ptp(motion) > 0.0:
            axes.plot(closed(motion) / um, closed(force), color=colour, label=name)
    axes.set(title="Platform to platform", xlabel="relative motion in µm", ylabel="force on the right platform in N")
    axes.legend()


def _forces(axes: Any, dataset: xr.Dataset) -> None:
    """Vector diagram: the ends of the force at each contact through the cycle, T over N, in its friction cone."""
    for contact, name, colour, mu in _contacts(dataset):
        normal = dataset.normal_force.values[:, contact]
        axes.plot(closed(dataset.friction_force.values[:, contact]), closed(normal), color=colour, label=name)
        if np.isfinite(mu):
            top = normal.max()
            axes.plot([-mu * top, 0.0, mu * top], [top, 0.0, top], color=colour, linewidth=0.8, linestyle=":")
    axes.set(title="Contact forces and friction cones", xlabel="T in N", ylabel="N in N")
    axes.legend()


def _ratios(axes: Any, dataset: xr.Dataset) -> None:
    for contact, name, colour, mu in _contacts(dataset):
        axes.plot(dataset.phase, dataset.force_ratio.values[:, contact], color=colour, label=name)
        for sign in (-1.0, 1.0):
            axes.axhline(sign * mu, color=colour, linewidth=0.7, linestyle=":")
    axes.set(title="Force ratios T/N; dotted: ±μ", xlabel="share of the cycle", ylabel="T/N")


def _motion(axes: Any, dataset: xr.Dataset) -> None:
    for contact, _, colour, _ in _contacts(dataset):
        for part, style in (("elastic_motion", ":"), ("slip_motion", "-"), ("rolling", "--")):
            values = dataset[part].values[:, contact]
            axes.plot(dataset.phase, (values - values.mean()) / um, style, color=colour, linewidth=1.2)
    for words, style in (("elastic", ":"), ("slip", "-"), ("rolling", "--")):
        axes.plot([], [], style, color=GREY, label=words)
    axes.set(title="Motion along the platforms, about its mean", xlabel="share of the cycle", ylabel="µm")
    axes.legend()


def _plane(axes: Any, dataset: xr.Dataset) -> None:
    """Yang and Menq: friction forces of the two sides over the pull, with the lines on which a side slips as a whole."""
    pull, sides = float(dataset.attrs["pull"]), dataset.side.values
    left, right = (dataset.friction_force.values[:, sides == side].sum(axis=1) / pull for side in ("left", "right"))
    limits = [dataset.slip_limit.values[:, sides == side].sum(axis=1) / pull for side in ("left", "right")]
    axes.plot(closed(left), closed(right), color=CONTACTS[0])
    for sign in (-1.0, 1.0):
        axes.plot(closed(sign * limits[0]), closed(right), color=GREY, linewidth=0.9)
        axes.plot(closed(left), closed(sign * limits[1]), color=GREY, linewidth=0.9, linestyle="--")
    axes.set(title="Friction of both sides; grey: where a side slips", xlabel="T left / pull", ylabel="T right / pull")


def _timeline(axes: Any, dataset: xr.Dataset) -> None:
    phase, names = dataset.phase.values, [str(name) for name in dataset.contact.values]
    for row in range(len(names)):
        states = dataset.state.values[:, row]
        cuts = np.concatenate([[0], np.flatnonzero(np.diff(states)) + 1, [states.size]])
        for a, b in pairwise(cuts):
            end = phase[b] if b < phase.size else 1.0
            axes.barh(
                row, end - phase[a], left=phase[a], color=COLOURS[int(states[a])], edgecolor=GREY, linewidth=0.4, height=0.7
            )
    axes.set_yticks(range(len(names)), [plain(name) for name in names])
    axes.grid(visible=False)
    for words, colour in (("stick", STICK), ("slip", SLIP), ("open", OPEN)):
        axes.barh(0, 0.0, color=colour, edgecolor=GREY, linewidth=0.4, label=words)
    axes.legend(ncols=3, loc="upper right", bbox_to_anchor=(1.0, 1.14))
    axes.set(title="States", xlabel="share of the cycle", xlim=(0.0, 1.0))
    axes.invert_yaxis()


def _contacts(dataset: xr.Dataset) -> list[tuple[int, str, str, float]]:
    friction = np.atleast_1d(dataset.attrs["friction"])
    names = [plain(str(name)) for name in dataset.contact.values]
    return [(i, name, CONTACTS[i % len(CONTACTS)], float(friction[i])) for i, name in enumerate(names)]


def closed(values: np.ndarray) -> np.ndarray:
    """With the first value at the end, unless that is a leap: a cycle that does not repeat is drawn as it is, open."""
    leap, usual = abs(values[0] - values[-1]), np.max(np.abs(np.diff(values)), initial=0.0)
    return np.append(values, np.nan if leap > 2.0 * usual else values[0])
