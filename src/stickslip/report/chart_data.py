"""Data for the charts of report.js, in plain lists of rounded numbers in display units.

Exact values stand in the tables of the page and in results.nc.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.checks import Array
from stickslip.harmonic.measure import QUANTITIES, Measure, Quantity
from stickslip.outcome import Outcome
from stickslip.plots.case_lines import case_lines
from stickslip.plots.look import CONTACTS, FAILED, GREY, entries, level_colours, state_colour
from stickslip.results.representative import levels_of, representatives
from stickslip.results.view import (
    ContactRow,
    Length,
    along_curve,
    contact_rows,
    converged_points,
    dissipated,
    failed_points,
    frequencies,
    highest_maximum,
    highest_peak,
    is_folded,
    largest_loops,
    length_unit,
    level_text,
    levels_in_newtons,
    measure_in,
    points,
    quantity_unit,
    shares_at_peak,
)

if TYPE_CHECKING:
    import xarray as xr

STEPS = 20
"""Shares of the period are drawn in steps of 1/STEPS: one colour for every mixture of stick, slip and open."""
LOOP_SAMPLES = 128
"""Samples that a loop keeps where all samples of all loops would be more than `NUMBERS_OF_CYCLES`."""
MOST_SHOWN = 12
"""Cases whose loops, states and shares are drawn."""
LOOPS_OF_A_POINT = 8
"""Contact rows, those with the largest loops, whose loops are drawn at a point that is clicked."""
NUMBERS_OF_CYCLES = 120_000
"""Numbers that a result may put into the page for the loops of its points, about a megabyte."""


def chart_data(datasets: Mapping[str, xr.Dataset]) -> dict[str, Any]:
    """Everything that the page draws."""
    most = max(dataset.sizes["case"] for dataset in datasets.values())
    count, unit = len(datasets), length_unit(*datasets.values())
    return {
        "length": unit.name,
        "results": [_result(label, dataset, unit.metres, unit.name) for label, dataset in datasets.items()],
        "mixtures": mixtures(),
        "colours": {
            scheme: {
                "levels": {n: level_colours(n, scheme == "dark") for n in range(1, most + 1)},
                "results": level_colours(count, scheme == "dark"),
            }
            for scheme in ("light", "dark")
        }
        | {"contacts": list(CONTACTS), "failed": FAILED, "grey": GREY},
    }


def mixtures() -> list[dict[str, Any]]:
    """Every mixture of states in steps: [stick, slip, open] in percent, and its colour; `mixture_index` points into it."""
    shares = [(STEPS - slip - open_, slip, open_) for slip in range(STEPS + 1) for open_ in range(STEPS + 1 - slip)]
    colours = np.rint(255 * np.clip([state_colour(*(np.array(share) / STEPS)) for share in shares], 0.0, 1.0)).astype(int)
    return [
        {"shares": [round(100 * part / STEPS) for part in share], "colour": f"rgb({r},{g},{b})"}
        for share, (r, g, b) in zip(shares, colours.tolist(), strict=True)
    ]


def mixture_index(slip: Array, open_: Array) -> list[int | None]:
    """Index into `mixtures` for shares of slip and open, (n,); None where they are not numbers."""
    first = np.concatenate([[0], np.cumsum(np.arange(STEPS + 1, 0, -1))])
    known = np.isfinite(slip) & np.isfinite(open_)
    opened = np.rint(STEPS * np.clip(np.nan_to_num(open_), 0.0, 1.0)).astype(int)
    slipped = np.minimum(np.rint(STEPS * np.clip(np.nan_to_num(slip), 0.0, 1.0)).astype(int), STEPS - opened)
    return [int(i) if k else None for i, k in zip(first[slipped] + opened, known, strict=True)]


def rounded(values: ArrayLike, digits: int = 5) -> list[float | None]:
    """A vector with so many digits; None for what is not a number."""
    return [float(f"{value:.{digits}g}") if np.isfinite(value) else None for value in np.asarray(values, dtype=float).tolist()]


def _result(label: str, dataset: xr.Dataset, metres: float, length: str) -> dict[str, Any]:
    names, shares, totals = shares_at_peak(dataset, len(CONTACTS))
    rows = contact_rows(dataset)
    shown = largest_loops(dataset, rows, LOOPS_OF_A_POINT) if rows else []
    measure, peaks = measure_in(dataset), quantity_unit(Length(metres, length), measure_in(dataset).quantity)
    return {
        "label": label,
        "peakSymbol": measure.symbol,
        "peakUnit": peaks.name,
        "cycleRows": [rows.index(row) for row in shown],
        "harmonics": dataset.sizes["harmonic"] - 1,
        "newtons": levels_in_newtons(dataset),
        "outputs": [str(name) for name in dataset.output.values],
        "contacts": [row.label for row in rows],
        "largestLoop": rows.index(largest_loops(dataset, rows, 1)[0]) if rows else 0,
        "linearFrequency": rounded(dataset.linear_frequency.values, 7),
        "energyNames": names,
        "representatives": representatives(dataset, MOST_SHOWN).cases,
        "cases": [
            _case(dataset, case, metres, peaks.metres)
            | line
            | _shares(shares[case], totals[case])
            | _cycles(dataset, case, shown, metres)
            for case, line in enumerate(_lines(dataset))
        ],
    }


def _case(dataset: xr.Dataset, case: int, metres: float, peak_unit: float) -> dict[str, Any]:
    outputs = range(dataset.sizes["output"])
    amplitude = along_curve(dataset, "amplitude", case) / metres
    return {
        "level": level_text(dataset, case),
        "force": float(dataset.force_level[case]),
        "point": points(dataset, case).tolist(),
        "frequency": rounded(frequencies(dataset, case), 8),
        "folded": is_folded(dataset, case),
        "amplitude": [rounded(amplitude[:, output]) for output in outputs],
        "peak": [_peak(dataset, case, output, peak_unit) for output in outputs],
        "dots": [[_dot(dataset, case, output, quantity, metres) for quantity in QUANTITIES.values()] for output in outputs],
        "failed": rounded(dataset.frequency.values[case, failed_points(dataset, case)], 8),
        "causes": [outcome_words(int(code)) for code in dataset.outcome.values[case, failed_points(dataset, case)]],
        "free": [rounded(dataset.free_amplitude.values[case, :, output] / metres) for output in outputs],
        "stuck": [rounded(dataset.stuck_amplitude.values[case, :, output] / metres) for output in outputs],
        "lossFactor": rounded(along_curve(dataset, "loss_factor", case)),
        "dissipated": rounded(dissipated(dataset, case).sum(axis=1)),
        **_contacts(dataset, case, metres),
    }


def _lines(dataset: xr.Dataset) -> list[dict[str, Any]]:
    """Of each case: its colour, whether it is the first of its level, its label, whether a legend has that, and its width."""
    groups, lines = levels_of(dataset), case_lines(dataset)
    shown = entries([line["label"] for line in lines])
    found: dict[int, dict[str, Any]] = {}
    for place, cases in enumerate(groups):
        for case in cases:
            label = lines[case]["label"]
            entry = label in shown and label not in [other["label"] for other in found.values()]
            style = {"label": label, "entry": entry, "thin": "alpha" in lines[case]}
            found[case] = {"colour": place, "levels": len(groups), "first": case == cases[0], **style}
    return [found[case] for case in range(len(lines))]


def outcome_words(code: int) -> str:
    """What came of a point, in words."""
    known = {int(outcome): outcome.name.lower().replace("_", " ") for outcome in Outcome}
    return known.get(code, f"outcome {code}")


def _cycles(dataset: xr.Dataset, case: int, shown: list[ContactRow], metres: float) -> dict[str, Any]:
    """Harmonics of motion and force of the rows shown at points spread over the curve: [a0, a1, b1, ...] of u, then of T.

    As many points as NUMBERS_OF_CYCLES allows over all force levels.
    """
    kept = converged_points(dataset, case)
    numbers = max(4 * len(shown) * dataset.sizes["harmonic"] * dataset.sizes["case"], 1)
    step = max(1, -(-kept.size // max(NUMBERS_OF_CYCLES // numbers, 1)))
    at = kept[::step]
    peak = highest_peak(dataset, case)
    at = np.unique(np.append(at, peak.point)) if peak is not None else at
    series = []
    for point in at:
        for row in shown:
            parts = [
                dataset[name].values[case, point, row.contact, row.direction] for name in ("contact_motion", "contact_force")
            ]
            series.append([rounded(_storage(parts[0]) / metres, 4), rounded(_storage(parts[1]), 4)])
    count = max(len(shown), 1)
    positions = np.searchsorted(points(dataset, case), at).tolist()
    return {"cycleAt": positions, "cycles": [series[i : i + count] for i in range(0, len(series), count)]}


def _storage(parts: Array) -> Array:
    """a0, a1, b1, a2, b2, ... of harmonics (H+1, 2) with real and imaginary part, X_h = a_h − i b_h."""
    values = np.column_stack([parts[:, 0], -parts[:, 1]]).ravel()
    return np.delete(values, 1)


def _shares(shares: Array, total: float) -> dict[str, Any]:
    return {"shares": rounded(shares), "total": rounded([total])[0]}


def _peak(dataset: xr.Dataset, case: int, output: int, unit: float) -> dict[str, Any] | None:
    """The highest peak, as the peaks of the result are measured."""
    peak = highest_peak(dataset, case, output)
    if peak is None:
        return None
    frequency, amplitude = rounded([peak.frequency, peak.amplitude / unit], 8)
    return {"frequency": frequency, "amplitude": amplitude}


def _dot(dataset: xr.Dataset, case: int, output: int, quantity: Quantity, metres: float) -> dict[str, Any] | None:
    """Where the first harmonic of a quantity is highest: frequency, and the displacement there, of which the page makes it."""
    highest = highest_maximum(dataset, case, output, Measure(quantity))
    if highest is None:
        return None
    displacement = highest[1] / float(Measure(quantity).of_harmonic(np.array(1.0), np.array(2.0 * np.pi * highest[0])))
    frequency, amplitude = rounded([highest[0], displacement / metres], 8)
    return {"frequency": frequency, "amplitude": amplitude}


def _contacts(dataset: xr.Dataset, case: int, metres: float) -> dict[str, Any]:
    """States along the curve and the loop at the peak, one entry a contact row."""
    slip, open_ = (along_curve(dataset, f"share_{state}", case) for state in ("slip", "open"))
    rows = contact_rows(dataset)
    samples = dataset.sizes["sample"]
    many = 2 * MOST_SHOWN * len(rows) * samples > NUMBERS_OF_CYCLES
    step = max(1, samples // LOOP_SAMPLES) if many else 1
    motion, force = dataset.loop_motion.values[case, :, :, ::step] / metres, dataset.loop_force.values[case, :, :, ::step]
    return {
        "states": [mixture_index(slip[:, r.contact, r.direction], open_[:, r.contact, r.direction]) for r in rows],
        "loops": [[rounded(motion[r.contact, r.direction]), rounded(force[r.contact, r.direction])] for r in rows],
        "loopFrequency": rounded([dataset.loop_frequency.values[case]], 7)[0],
    }
