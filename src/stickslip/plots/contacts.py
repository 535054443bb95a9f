"""Hysteresis loops at the peak, and contact states along the curve."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from stickslip.checks import Array
from stickslip.plots.case_lines import case_lines
from stickslip.plots.look import GREY, OPEN, PAGE, SLIP, STICK, headed, house_style, plain, state_colour
from stickslip.results.representative import representatives, spread
from stickslip.results.view import (
    ContactRow,
    along_curve,
    contact_rows,
    frequencies,
    is_folded,
    largest_loops,
    length_unit,
    level_text,
)

if TYPE_CHECKING:
    import xarray as xr

MANY_ROWS = 12
MOST_NAMES = 100
MOST_CONTACTS = 8
"""Contacts in the figure of loops; of more, those with the largest loops are drawn."""
MOST_COLUMNS = 6
MOST_STATES = 8
"""Cases in the figures of loops and of states; of more, `results_representative.representatives` chooses."""


def hysteresis_loops(dataset: xr.Dataset) -> Figure:
    """Contact force in N against relative displacement in µm at the highest peak: a row per contact, a column per force level."""
    rows = contact_rows(dataset)
    shown = largest_loops(dataset, rows, MOST_CONTACTS)
    chosen = representatives(dataset, MOST_COLUMNS)
    cases, lines = chosen.dataset.sizes["case"], case_lines(chosen.dataset)
    with house_style():
        size = (max(6.0, 1.75 * cases + 0.8), min(1.6 * max(len(shown), 1) + 0.9, PAGE))
        figure = Figure(figsize=size, layout="constrained")
        panels = figure.subplots(max(len(shown), 1), cases, squeeze=False)
        for case, line in enumerate(lines):
            panels[0, case].set_title(level_text(chosen.dataset, case).replace(", ", ",\n"), fontsize=9)
            for axes, row in zip(panels[:, case], shown, strict=False):
                _loop(axes, chosen.dataset, case, row, line["color"])
        for axes, row in zip(panels[:, 0], shown, strict=False):
            axes.set_ylabel(plain(row.label), fontsize=8.5)
        note = f" ({len(shown)} of {len(rows)}, the largest)" if len(shown) < len(rows) else ""
        headed(figure, f"Loops at the highest peak{note}", chosen.words)
        figure.supxlabel(f"relative displacement in {length_unit(dataset).name}", fontsize=9.5)
        figure.supylabel("contact force in N", fontsize=9.5)
    return figure


def contact_states(dataset: xr.Dataset) -> Figure:
    """Shares of the period in stick, slip and open as mixed colours: one panel a force level, one row a contact."""
    rows = contact_rows(dataset)
    panel = 0.42 + (0.16 if len(rows) <= MANY_ROWS else 0.1) * max(len(rows), 2)
    chosen = representatives(dataset, max(1, min(MOST_STATES, int((PAGE - 1.2) / panel))))
    dataset, cases = chosen.dataset, chosen.dataset.sizes["case"]
    with house_style():
        figure = Figure(figsize=(7.6, min(1.2 + cases * panel, PAGE)), layout="constrained")
        for case, axes in enumerate(figure.subplots(cases, 1, squeeze=False).ravel()):
            _states_of(axes, dataset, case, rows)
        folded = any(is_folded(dataset, case) for case in range(cases))
        figure.supxlabel("frequency in Hz" + (", along the curve" if folded else ""), fontsize=9.5)
        legend = figure.legend(handles=_state_handles(), loc="outside right upper", title="share of period")
        legend.get_title().set_fontsize(8.5)
        headed(figure, "Contact states along the curve", chosen.words)
    return figure


def mesh_edges(centres: Array) -> Array:
    """Cell edges halfway between the points, (n + 1,)."""
    if centres.size < 2:
        return np.array([centres[0] - 0.5, centres[0] + 0.5]) if centres.size else np.zeros(1)
    middle = 0.5 * (centres[1:] + centres[:-1])
    return np.concatenate([[1.5 * centres[0] - 0.5 * centres[1]], middle, [1.5 * centres[-1] - 0.5 * centres[-2]]])


def _loop(axes: Axes, dataset: xr.Dataset, case: int, row: ContactRow, colour: str) -> None:
    """One closed loop on its own scale."""
    motion = dataset.loop_motion.values[case, row.contact, row.direction] / length_unit(dataset).metres
    force = dataset.loop_force.values[case, row.contact, row.direction]
    axes.plot(np.append(motion, motion[:1]), np.append(force, force[:1]), color=colour, linewidth=1.3)
    axes.locator_params(nbins=4)
    axes.margins(0.12)
    axes.tick_params(labelsize=7)


def _state_handles() -> list[Patch]:
    half = tuple(state_colour(0.5, 0.5, 0.0))
    words = ((STICK, "stick"), (half, "half, half"), (SLIP, "slip"), (OPEN, "open"))
    return [Patch(facecolor=colour, edgecolor=GREY, label=word) for colour, word in words]


def _states_of(axes: Axes, dataset: xr.Dataset, case: int, rows: list[ContactRow]) -> None:
    hertz = frequencies(dataset, case)
    axes.grid(visible=False)
    axes.set_title(level_text(dataset, case), fontsize=8.5, fontweight="normal")
    named = spread(len(rows), MOST_NAMES)
    axes.set_yticks(named, [plain(rows[row].label) for row in named], fontsize=8 if len(rows) <= MANY_ROWS else 5)
    if not hertz.size or not rows:
        axes.text(0.5, 0.5, "no points", transform=axes.transAxes, ha="center", va="center", color=GREY)
        return
    colours = np.stack([_row_colours(dataset, case, row) for row in rows])
    centres = np.arange(hertz.size, dtype=float) if is_folded(dataset, case) else hertz
    axes.pcolormesh(mesh_edges(centres), np.arange(len(rows) + 1) - 0.5, colours, rasterized=True)
    axes.invert_yaxis()
    if is_folded(dataset, case):
        ticks = np.unique(np.linspace(0, hertz.size - 1, 7).round().astype(int))
        axes.set_xticks(ticks, [f"{hertz[tick]:.4g}" for tick in ticks])


def _row_colours(dataset: xr.Dataset, case: int, row: ContactRow) -> Array:
    """Mixed colours of one contact along the curve, (point, 4); transparent where the point did not converge."""
    stick, slip, open_ = (
        along_curve(dataset, f"share_{state}", case)[:, row.contact, row.direction] for state in ("stick", "slip", "open")
    )
    colours = np.nan_to_num(state_colour(stick, slip, open_))
    return np.column_stack([np.clip(colours, 0.0, 1.0), np.isfinite(stick + slip + open_).astype(float)])
