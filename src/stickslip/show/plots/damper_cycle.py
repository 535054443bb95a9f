"""A damper cycle in six panels: platform hysteresis, contact forces, force ratios, motion and its parts, the plane of friction
forces with its limit lines, and the timeline of stick, slip and open."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from stickslip.results.view import spread
from stickslip.show.plots.chart import Axis, Bars, Cells, Chart, Key, Layer, Line, Panel, Rule
from stickslip.show.plots.chart import closed as with_first
from stickslip.show.plots.look import Dash, Style, colour, contact, level_lines, rgb
from stickslip.support.checks import Array, counted
from stickslip.support.late import xr
from stickslip.support.renderers import FIGURES
from stickslip.support.units import um

CYCLE = Axis("share of the cycle", limits=(0.0, 1.0))
PARTS: dict[str, tuple[str, Dash]] = {
    "slip_motion": ("slip", "solid"),
    "elastic_motion": ("elastic", "dot"),
    "rolling": ("rolling", "dash"),
}
"""Parts of the motion along a platform, in words, with their dashes."""
LINES = (2, 3, 6, 7)
"""Colours of the contacts in their order: those that stick and slip do not have."""
HEIGHT = 2.7


@FIGURES.of("DamperCycle")
def damper_cycle(dataset: xr.Dataset) -> Chart:
    """Everything that one cycle of a damper between two platforms shows."""
    energy, rotation = float(dataset.loop_energy) * 1e6, float(dataset.rotation) * 1e3
    title = f"{dataset.attrs['title']}: {energy:.4g} µJ a cycle, rotation {rotation:.3g} mrad, {dataset.attrs['outcome']}"
    panels = [draw(dataset) for draw in (_hysteresis, _forces, _ratios, _motion, _plane, _timeline)]
    return Chart(title.replace("_", " "), panels, columns=2)


def _hysteresis(dataset: xr.Dataset) -> Panel:
    """Force between the platforms against their relative motion, in both directions."""
    layers = []
    for axis, name in enumerate(("horizontal", "vertical")):
        motion, force = (dataset[key].values[:, axis] for key in ("platform_motion", "force_on_right"))
        if np.ptp(motion) > 0.0:
            drawn, style = closed(force), Style("ink", ("solid", "dash")[axis])
            layers.append(Line(closed(motion) / um, drawn, style, hover=_called(name, drawn)))
    axes = Axis("relative motion", "µm"), Axis("force on the right platform", "N")
    return Panel(*axes, layers, "Platform to platform; dashed: vertical", HEIGHT)


def _forces(dataset: xr.Dataset) -> Panel:
    """Vector diagram: the ends of the force at each contact through the cycle, T over N, in its friction cone."""
    layers: list[Layer] = []
    for k, name, mu in _contacts(dataset):
        normal, top = dataset.normal_force.values[:, k], float(dataset.normal_force.values[:, k].max())
        layers.append(Line(closed(dataset.friction_force.values[:, k]), closed(normal), _line(k), name))
        if np.isfinite(mu):
            layers.append(Line([-mu * top, 0.0, mu * top], [top, 0.0, top], _line(k, dash="dot", width=0.8), name, listed=False))
        else:  # of a coefficient that depends on the load the limits themselves, in the order of the load
            order = np.argsort(normal)
            limit, load = dataset.slip_limit.values[order, k], normal[order]
            both, loads = np.append(-limit[::-1], limit), np.append(load[::-1], load)
            layers.append(Line(both, loads, _line(k, dash="dot", width=0.8), name, listed=False))
    axes = Axis("friction force T", "N"), Axis("normal force N", "N")
    return Panel(*axes, layers, "Contact forces; dotted: friction cones", HEIGHT)


def _ratios(dataset: xr.Dataset) -> Panel:
    """T/N of each contact within its limits ±μ."""
    layers: list[Layer] = []
    for k, name, mu in _contacts(dataset):
        layers.append(Line(dataset.phase.values, dataset.force_ratio.values[:, k], _line(k), name))
        layers += [Rule(sign * mu, _line(k, dash="dot", width=0.8), along="y") for sign in (-1.0, 1.0) if np.isfinite(mu)]
    return Panel(CYCLE, Axis("force ratio T/N"), layers, "Force ratios; dotted: ±μ", HEIGHT)


def _motion(dataset: xr.Dataset) -> Panel:
    """The parts of the motion of each contact along its platform, about their means."""
    layers: list[Layer] = []
    for k, name, _ in _contacts(dataset):
        for part, (words, dash) in PARTS.items():
            values = dataset[part].values[:, k]
            line = _line(k, dash=dash, width=1.2)
            layers.append(
                Line(dataset.phase.values, (values - values.mean()) / um, line, name, {"": [words] * values.size}, listed=False)
            )
    return Panel(CYCLE, Axis("motion about its mean", "µm"), layers, "Motion: slip; dotted: elastic, dashed: rolling", HEIGHT)


def _plane(dataset: xr.Dataset) -> Panel:
    """Yang and Menq: friction forces of the two sides over the pull, with the lines on which a side slips as a whole."""
    pull, sides = float(dataset.attrs["pull"]), dataset.side.values
    left, right = (dataset.friction_force.values[:, sides == side].sum(axis=1) / pull for side in ("left", "right"))
    limits = [dataset.slip_limit.values[:, sides == side].sum(axis=1) / pull for side in ("left", "right")]
    drawn = [(left, right, "both sides", Style("ink"))]
    for sign in (-1.0, 1.0):
        drawn.append((sign * limits[0], right, "left side slips", Style("grey", width=0.9)))
        drawn.append((left, sign * limits[1], "right side slips", Style("grey", "dash", 0.9)))
    layers = [Line(closed(x), closed(y), style, hover=_called(words, closed(y))) for x, y, words, style in drawn]
    axes = Axis("friction force on the left over pull"), Axis("friction force on the right over pull")
    return Panel(*axes, layers, "Friction; grey: left side slips, dashed: right", HEIGHT)


def _timeline(dataset: xr.Dataset) -> Panel:
    """When each contact sticks, slips and is open."""
    phase, names = dataset.phase.values, [str(name) for name in dataset.contact.values]
    colour_of = {0: "stick", 1: "slip", -1: "slip", 2: "open"}  # slip has the sign of its direction
    states = [[colour_of[int(state)] for state in dataset.state.values[:, row]] for row in range(len(names))]
    colours = np.array([[rgb(colour(state)) for state in along] for along in states])
    texts = [
        [f"{name}, {share:.3f} of the cycle: {state}" for share, state in zip(phase, along, strict=True)]
        for name, along in zip(names, states, strict=True)
    ]
    axis = Axis("", names={float(row): name for row, name in enumerate(names)}, upside_down=True)
    keys = [Key(state, Style(state)) for state in ("stick", "slip", "open")]
    return Panel(CYCLE, axis, [Cells(np.append(phase, 1.0), colours, texts), *keys], "States", HEIGHT)


def _called(words: str, values: Array) -> dict[str, list[str]]:
    """The name of a line that no legend lists, for each of its points."""
    return {"": [words] * values.size}


def _line(place: int, **more: Any) -> Style:
    """The style of the lines of a contact."""
    return contact(LINES[place % len(LINES)], **more)


def _contacts(dataset: xr.Dataset) -> Iterator[tuple[int, str, float]]:
    """Place, name and friction coefficient of each contact."""
    friction = np.atleast_1d(dataset.attrs["friction"])
    return ((k, str(name), float(friction[k])) for k, name in enumerate(dataset.contact.values))


def closed(values: Array) -> Array:
    """With the first value at the end, unless that is a leap: a cycle that does not repeat is drawn as it is, open."""
    leap, usual = abs(values[0] - values[-1]), np.max(np.abs(np.diff(values)), initial=0.0)
    return np.append(values, np.nan) if leap > 2.0 * usual else with_first(values)


MOST_NAMES = 16
"""Cycles named below the bars; of more, evenly spread ones."""
CYCLES_HEIGHT = 3.0


@FIGURES.of("SteadyCycles")
@FIGURES.of("DamperEvolution")
def damper_cycles(dataset: xr.Dataset) -> Chart:
    """Loops in the direction that moves most, dark to light in the order of the cycles; then energy and rotation of each."""
    axis = int(np.argmax(np.ptp(dataset.platform_motion.values[0], axis=0)))
    motion, force = dataset.platform_motion.values[..., axis], dataset.force_on_right.values[..., axis]
    # The number of each cycle stands below its bars too.
    names = [f"{number}: {name}" for number, name in zip(dataset.cycle.values, cycle_names(dataset), strict=True)]
    loops = [
        Line(closed(x) / um, closed(f), **look) for x, f, look in zip(motion, force, level_lines(names, width=1.3), strict=True)
    ]
    direction = ("horizontal", "vertical")[axis]
    axes = Axis(f"{direction} motion", "µm"), Axis(f"{direction} force", "N")
    energy = _bars(dataset, 1e6 * dataset.loop_energy.values, Axis("energy of a cycle", "µJ"))
    rotation = _bars(dataset, 1e3 * dataset.rotation.values, Axis("rotation, peak to peak", "mrad"))
    panels = [Panel(*axes, loops, "Platform to platform", CYCLES_HEIGHT), energy, rotation]
    return Chart(str(dataset.attrs["title"]), panels, columns=3)


def cycle_names(dataset: xr.Dataset) -> list[str]:
    """What distinguishes the cycles: how many starts lead to each, or its friction."""
    if "starts" in dataset:
        return [counted(int(count), "start") for count in dataset.starts.values]
    return [f"µ = {', '.join(f'{mu:g}' for mu in dict.fromkeys(row))}" for row in dataset.friction.values]


def _bars(dataset: xr.Dataset, values: Array, axis: Axis) -> Panel:
    numbers = dataset.cycle.values
    across = Axis("cycle", names={float(place): str(numbers[place]) for place in spread(numbers.size, MOST_NAMES)})
    return Panel(across, axis, [Bars(np.arange(numbers.size), values, Style("stick"))], height=CYCLES_HEIGHT)
