"""Contacts along the curve and at the peak: hysteresis loops, states, dissipated energy and the loss factor."""

from collections.abc import Callable

import numpy as np

from stickslip.results import view
from stickslip.results.view import representatives
from stickslip.show.plots.chart import Axis, Bars, Cells, Chart, Key, Layer, Line, Panel, closed, edges_between, from_zero
from stickslip.show.plots.look import CONTACTS, PAGE, Style, contact, state_colour
from stickslip.show.plots.response_curves import HERTZ, case_lines
from stickslip.support.checks import Array
from stickslip.support.late import xr
from stickslip.support.renderers import FIGURES

MANY_ROWS = 12
MOST_NAMES = 100
"""Directions of contacts in the figure of states; of more, those with the largest loops are drawn."""
MOST_COLUMNS, MOST_ROWS = 6, 8
"""Cases and contacts in the figure of loops, and cases in those of states and of dissipation: of more contacts those with the
largest loops are drawn, of more cases `representatives` chooses."""
STEPS = 20
"""Shares of the period are drawn in steps of 1/STEPS."""
STATES = [Key("stick", Style("stick")), Key("half, half", Style("half")), Key("slip", Style("slip")), Key("open", Style("open"))]
"""What the colours of states mean."""


@FIGURES.of("ForcedResponse", "loops")
def hysteresis_loops(dataset: "xr.Dataset") -> Chart:
    """Contact force in N against relative displacement in µm at the highest peak: a row per contact, a column per force level."""
    rows = view.contact_rows(dataset)
    shown = view.largest_loops(dataset, rows, MOST_ROWS)
    chosen = representatives(dataset, MOST_COLUMNS)
    lines, height = case_lines(chosen.dataset), min(1.6, (PAGE - 0.8) / max(len(shown), 1))
    panels = []
    for place, row in enumerate(shown):
        for case, line in enumerate(lines):
            title = ", ".join(filter(None, (view.level_text(chosen.dataset, case) if not place else "", row.label)))
            layers = [_loop(chosen.dataset, case, row, line["style"], line["label"])]
            panels.append(Panel(*loop_axes(dataset), layers, title, height))
    note = f"{len(shown)} of {len(rows)}, the largest" if len(shown) < len(rows) else ""
    note = "; ".join(filter(None, (note, chosen.words)))
    panels = panels or [Panel(*loop_axes(dataset), [])]
    return Chart("Loops at the highest peak", panels, columns=len(lines) if shown else 1, note=note, legend=False)


def loops_of(dataset: "xr.Dataset", most: int, step: int = 1) -> Callable[[view.ContactRow, bool], Chart]:
    """The loops of one contact at all force levels in one panel; step: of the samples drawn.

    What is returned draws them for a row; own: each centred and to its own size, to compare shapes.
    """
    chosen = representatives(dataset.isel(sample=slice(None, None, step)), most)
    lines, axes = case_lines(chosen.dataset), loop_axes(dataset)
    shapes = Axis("relative displacement over half its range"), Axis("contact force over half its range")

    def drawn(row: view.ContactRow, own: bool) -> Chart:
        layers = [_loop(chosen.dataset, case, row, line["style"], line["label"], own) for case, line in enumerate(lines)]
        panel = Panel(*(shapes if own else axes), layers, height=3.8)
        return Chart(f"Loops at the highest peak: {row.label}", [panel], note=chosen.words)

    return drawn


def loops_at(dataset: "xr.Dataset", rows: list[view.ContactRow], samples: int) -> Callable[[int, int], Chart]:
    """The loops at a point of a curve, from the harmonics that the result keeps: corners are rounded, the force may overshoot.

    What is returned draws them for a case and a point.
    """
    angle = 2.0 * np.pi * np.arange(samples + 1) / samples
    waves = np.exp(1j * np.outer(np.arange(dataset.sizes["harmonic"]), angle))
    motions, forces, hertz = (dataset[name].values for name in ("contact_motion", "contact_force", "frequency"))
    states = {state: dataset[f"share_{state}"].values for state in ("stick", "slip", "open")}
    metres, axes = view.length_unit(dataset).metres, loop_axes(dataset)
    levels = [view.level_text(dataset, case) for case in range(dataset.sizes["case"])]
    truncated = f"Hz (truncated to {dataset['harmonic'].values[-1]:g} harmonics)"

    def drawn(case: int, point: int) -> Chart:
        layers: list[Layer] = []
        for k, row in enumerate(rows):
            at = (case, point, row.contact, row.direction)
            motion, force = _series(motions[at], waves), _series(forces[at], waves)
            shares = {state: float(share[at]) for state, share in states.items()}
            states_text = ", ".join(f"{100.0 * share:.0f} % {state}" for state, share in shares.items() if share > 0.0)
            if np.all(np.isfinite(motion + force)):
                layers.append(Line(motion / metres, force, contact(k), f"{row.label}: {states_text}"))
        title = f"{levels[case]}, {hertz[case, point]:.7g} {truncated}"
        return Chart(title, [Panel(*axes, layers, height=3.4)])

    return drawn


def loop_axes(dataset: "xr.Dataset") -> tuple[Axis, Axis]:
    """Of a hysteresis loop."""
    return Axis("relative displacement", view.length_unit(dataset).name), Axis("contact force", "N")


@FIGURES.of("ForcedResponse", "states")
def contact_states(dataset: "xr.Dataset", most: int = MOST_ROWS) -> Chart:
    """Shares of the period in stick, slip and open as mixed colours: one panel a force level, one row a contact."""
    every = view.contact_rows(dataset)
    rows = every if len(every) <= MOST_NAMES else view.largest_loops(dataset, every, MOST_NAMES)
    panel = 0.25 + (0.16 if len(rows) <= MANY_ROWS else 0.1) * max(len(rows), 2)
    chosen = representatives(dataset, max(1, min(most, int((PAGE - 1.2) / (panel + 0.2)))))
    dataset = chosen.dataset
    folded = any(view.is_folded(dataset, case) for case in range(dataset.sizes["case"]))
    panels = [_states_of(dataset, case, rows, panel) for case in range(dataset.sizes["case"])]
    title = "Contact states, in shares of the period" + (", along the folded curve" if folded else "")
    note = f"the {len(rows)} of {len(every)} with the largest loops" if len(rows) < len(every) else ""
    return Chart(title, panels, note="; ".join(filter(None, (note, chosen.words))), shared_x=not folded)


def _series(parts: Array, waves: Array) -> Array:
    """x(t) = Re Σ X_h exp(ihωt) over a period of harmonics (H+1, 2) with real and imaginary part."""
    return np.asarray(((parts[:, 0] + 1j * parts[:, 1]) @ waves).real)


def _loop(dataset: "xr.Dataset", case: int, row: view.ContactRow, style: Style, label: str, own: bool = False) -> Line:
    """One closed loop at the highest peak."""
    motion = closed(dataset.loop_motion.values[case, row.contact, row.direction] / view.length_unit(dataset).metres)
    force = closed(dataset.loop_force.values[case, row.contact, row.direction])
    if not own:
        return Line(motion, force, style, label)
    hover = {f"relative displacement in {view.length_unit(dataset).name}": motion, "contact force in N": force}
    return Line(_to_own_size(motion), _to_own_size(force), style, label, hover)


def _to_own_size(values: Array) -> Array:
    low, high = np.min(values), np.max(values)
    return np.asarray((values - 0.5 * (low + high)) / (0.5 * (high - low) or 1.0))


def _states_of(dataset: "xr.Dataset", case: int, rows: list[view.ContactRow], height: float) -> Panel:
    """The panel of one force level: a row of cells for each contact, NaN where a point did not converge."""
    hertz, title = view.frequencies(dataset, case), view.level_text(dataset, case)
    if not hertz.size or not rows:
        return Panel(HERTZ, Axis("", limits=(0.0, 1.0)), [*STATES], f"{title}: no points", height)
    states = [view.along_curve(dataset, f"share_{state}", case) for state in ("stick", "slip", "open")]
    shares = np.stack([np.stack([share[:, row.contact, row.direction] for share in states], axis=-1) for row in rows])
    folded, descending = view.is_folded(dataset, case), hertz[0] > hertz[-1]
    if descending and not folded:
        hertz, shares = hertz[::-1], shares[:, ::-1]
    names = {float(k): row.label for k, row in enumerate(rows)}
    texts = [
        [f"{row.label}, {f:.2f} Hz: {_state_text(share)}" for f, share in zip(hertz, along, strict=True)]
        for row, along in zip(rows, shares, strict=True)
    ]
    x = HERTZ
    if folded:
        ticks = np.unique(np.linspace(0, hertz.size - 1, 7).round().astype(int))
        x = Axis("frequency along the curve", "Hz", names={float(tick): f"{hertz[tick]:.4g}" for tick in ticks})
    edges = edges_between(np.arange(hertz.size, dtype=float) if folded else hertz)
    rounded = np.round(STEPS * shares) / STEPS
    cells = Cells(edges, state_colour(*np.moveaxis(rounded, -1, 0)), texts)
    return Panel(x, Axis("", names=names, upside_down=True), [cells, *STATES], title, height)


def _state_text(shares: Array) -> str:
    """ "60 % stick, 40 % slip"."""
    states = zip(shares, ("stick", "slip", "open"), strict=True)
    return ", ".join(f"{100.0 * share:.0f} % {state}" for share, state in states if share > 0.005) or "not converged"


@FIGURES.of("ForcedResponse", "dissipation")
def dissipation(dataset: "xr.Dataset") -> Chart:
    """Energy of all contacts per period against frequency, and the share of each contact at the highest peak."""
    energies = [np.sum(view.dissipated(dataset, case), axis=1) for case in range(dataset.sizes["case"])]
    joules, unit = view.energy_unit(float(np.max(np.nan_to_num(np.concatenate(energies)), initial=0.0)))
    lines = [
        Line(view.frequencies(dataset, case), np.where(energy > 0.0, energy / joules, np.nan), **line)
        for case, (energy, line) in enumerate(zip(energies, case_lines(dataset), strict=True))
    ]
    axis = Axis("energy per period", unit, log=bool(np.nansum(dataset.dissipated.values) > 0.0))

    chosen = representatives(dataset, MOST_ROWS)
    names, energy, total = view.shares_at_peak(chosen.dataset, len(CONTACTS))
    percent = np.nan_to_num(100.0 * energy / np.where(total > 0.0, total, np.nan)[:, None])
    rows, before = np.arange(total.size), np.cumsum(percent, axis=1) - percent
    bars = []
    for k, name in enumerate(names):
        style, hover = contact(-1 if name.endswith(" others") else k), {"energy per period in J": energy[:, k]}
        bars.append(Bars(rows, percent[:, k], style, name, base=before[:, k], horizontal=True, hover=hover))
    sizes = [view.energy_text(value, chosen.dataset) if np.isfinite(value) else "not converged" for value in total]
    cases = {float(case): f"{view.level_text(chosen.dataset, case)}, {size}" for case, size in enumerate(sizes)}
    axes = Axis("share of the contacts", "%", limits=(0.0, 100.0)), Axis("", names=cases, upside_down=True)

    panels = [Panel(HERTZ, axis, lines, "All contacts", 3.4), Panel(*axes, bars, "At the highest peak", 3.4)]
    note = f"shares: {chosen.words}" if chosen.words else ""
    return Chart("Energy dissipated in contacts", panels, columns=2, note=note)


@FIGURES.of("ForcedResponse", "loss_factor")
def loss_factor(dataset: "xr.Dataset") -> Chart:
    """Loss factor against frequency, one curve a force level."""
    lines = [
        Line(view.frequencies(dataset, case), view.along_curve(dataset, "loss_factor", case), **line)
        for case, line in enumerate(case_lines(dataset))
    ]
    return Chart("Loss factor", [Panel(HERTZ, from_zero(Axis("loss factor")), lines, height=3.4)])
