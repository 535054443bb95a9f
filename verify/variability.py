"""Response variability: bounds of the single-blade rig, the published comparison, and what the search costs.

Half an hour. Besides the rows it writes results/variability.json and the tables of docs/variability_numbers.md.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.analyses.forced_response import forced_response
from stickslip.analyses.variability.bounds import response_bounds
from stickslip.analyses.variability.samples import response_history, response_samples, search_cloud
from stickslip.model.contact.protocol import OFFSET
from stickslip.model.problem import Problem
from stickslip.model.rigs import single_blade, three_mass_wedge
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE
from stickslip.solve.starts.extremes import AtFrequency, Effort, Extreme, extreme, leapt, size_of
from stickslip.solve.starts.states import StartSpace, UnsolvedError, explored_space
from stickslip.support.units import Band, hertz
from verify.counting import counted, residuals
from verify.rig_models import MASS, with_separators, with_stinger
from verify.row import Row, at_most, relative
from verify.variability_page import tables

TITLE = "Response variability"
ABOUT = (
    "Bounds over all admissible start states. Wedge: every start state of both contacts. Rig: the single blade, 80 start "
    "variables. The comparison with the published resonances is a table of its own."
)
ROOT = Path(__file__).parents[1]
LEVELS = (1.0, 5.0, 20.0, 50.0, 80.0, 100.0)
WORKERS = 2


def rows() -> Iterator[Row]:
    started = time.process_time()
    numbers: dict[str, Any] = {}
    yield from wedge_rows()
    yield from cost_rows(numbers)
    yield from six_slider_rows(numbers)
    numbers["peaks"] = {}
    for mass in ("4.6", "2.6", "6.6"):
        numbers["peaks"][mass] = peak_bounds(mass)
        yield from solved_again_rows(mass, numbers["peaks"][mass])
    numbers["ratios"] = ratio_bounds()
    numbers["history"] = history()
    numbers["variants"] = variants()
    yield from proxy_rows(numbers)
    numbers["cpu_seconds_here"] = time.process_time() - started
    (ROOT / "results").mkdir(exist_ok=True)
    (ROOT / "results" / "variability.json").write_text(json.dumps(numbers, indent=1) + "\n")
    (ROOT / "docs" / "variability_numbers.md").write_text(tables(numbers))


def one_seed() -> Iterator[Row]:
    """The wedge, whose start states can all be tried."""
    yield from wedge_rows()


def wedge_rows() -> Iterator[Row]:
    """The bounds at 222 Hz against the start states of an independent code, and against 2000 of its own."""
    low, high = response_bounds(three_mass_wedge(), [222.0]).dataset.amplitude.values.ravel()
    yield relative("Wedge, 222 Hz: lower bound, m", low, 3.494106e-5, 1e-6, "m = -1, two independent codes")
    yield relative("Wedge, 222 Hz: upper bound, m", high, 6.228618e-5, 1e-6, "m = +1, two independent codes")
    place = place_at(HarmonicBalance(three_mass_wedge(), 5, 256), 222.0, 1.0, "traction_ratio")
    cloud = [place.point(v).value for v in np.random.default_rng(1).uniform(-1.0, 1.0, (2000, 2))]
    outside = max(low / min(cloud), max(cloud) / high) - 1.0
    yield at_most("Wedge: 2000 start states outside the bounds, relative", max(outside, 0.0), 1e-9, "containment")
    yield relative("Wedge: lowest of 2000 start states over the lower bound", min(cloud) / low, 1.0, 1e-3, "touching")
    yield relative("Wedge: highest of 2000 start states over the upper bound", max(cloud) / high, 1.0, 1e-3, "touching")


def place_at(balance: HarmonicBalance, frequency: float, level: float, rule: Any = "slider_offset") -> AtFrequency:
    """The amplitude of the first output at a frequency in Hz."""
    omega = 2.0 * np.pi * frequency
    return AtFrequency(balance, explored_space(balance, [omega], level, rule), size_of(0, DISPLACEMENT_AMPLITUDE), omega, level)


class ForwardDifferences:
    """The same place with gradients by forward differences, as the published method has them."""

    def __init__(self, place: AtFrequency) -> None:
        self.place, self.space = place, place.space

    def value(self, variables: np.ndarray) -> tuple[Extreme, np.ndarray]:
        found = self.place.point(variables)
        step = 1e-6 * np.where(variables < 0.5, 1.0, -1.0)
        slopes = [(self.place.point(variables + step * unit).value - found.value) for unit in np.eye(variables.size)]
        return found, np.array(slopes) / step


def cost_rows(numbers: dict[str, Any]) -> Iterator[Row]:
    """Residual evaluations of one search on the rig at 20 N and 540 Hz, with exact gradients and with forward differences."""
    balance = HarmonicBalance(single_blade(4.6), 5, 256)
    counts = []
    for kind in (lambda place: place, ForwardDifferences):
        place = place_at(balance, 540.0, 20.0)
        place.point(np.zeros(place.space.size))
        with counted(residuals) as spent:
            extreme(kind(place), 1.0, [np.full(place.space.size, 0.1)], Effort(iterations=4, rounds=1))
        counts.append(spent())
    numbers["cost"] = {"exact": counts[0], "forward_differences": counts[1], "variables": int(place.space.size)}
    yield at_most("Rig: residual evaluations, exact gradients over forward differences", counts[0] / counts[1], 1 / 20, "counted")


def six_slider_rows(numbers: dict[str, Any]) -> Iterator[Row]:
    """Six free flat sliders at 20 N: the bounds against 20 000 draws, the best 50 of them polished."""
    balance = HarmonicBalance(single_blade(4.6), 5, 256)
    omega = 2.0 * np.pi * 540.0
    full = explored_space(balance, [omega], 20.0)
    names = [f"{c.name} {d}" for c in balance.problem.contacts for d in c.direction_names for _ in range(elements_of(c, d))]
    free = [names.index(f"{side} flat {i} t1") for side in ("left", "right") for i in (1, 3, 5)]
    group, scale = np.full(len(names), -1, dtype=np.int64), np.zeros(len(names))
    group[free], scale[free] = np.arange(6), full.scale[free]
    place = AtFrequency(
        balance, StartSpace(np.full_like(group, OFFSET), group, scale), size_of(0, DISPLACEMENT_AMPLITUDE), omega, 20.0
    )
    draws = np.random.default_rng(0).uniform(-1.0, 1.0, (20_000, 6))
    values = np.array([value_of(place, draw) for draw in draws])
    results: dict[str, float] = {}
    for name, sign in (("lower", -1.0), ("upper", 1.0)):
        order = np.argsort(np.where(np.isnan(values), np.inf, -sign * values))
        polished = [extreme(place, sign, [draws[k]]).value for k in order[:50]]
        cloud = sorted(search_cloud(6, 60), key=lambda v: -sign * value_of(place, v))
        found = leapt(place, sign, extreme(place, sign, [np.zeros(6), *cloud[:3]]), np.random.default_rng(0)).value
        best = max(polished, key=lambda v: sign * v)
        results |= {
            f"{name}_drawn": float(values[order[0]]),
            f"{name}_polished": best,
            f"{name}_bound": found,
        }
        results[f"{name}_local_optima"] = len(np.unique(np.round(np.array(polished) / best, 3)))
    numbers["six_sliders"] = results
    yield relative(
        "Rig, six sliders: lower bound over 20 000 draws, polished",
        results["lower_bound"] / results["lower_polished"],
        1.0,
        1e-2,
        "draws",
    )
    yield relative(
        "Rig, six sliders: upper bound over 20 000 draws, polished",
        results["upper_bound"] / results["upper_polished"],
        1.0,
        1e-2,
        "draws",
    )


def elements_of(contact: Any, direction: str) -> int:
    """Friction elements of a direction of a contact; none of its normal one."""
    if direction == "n":
        return 0
    return int(contact.elements.friction[list(contact.direction_names).index(direction)].stiffness.size)


def value_of(place: AtFrequency, variables: np.ndarray) -> float:
    try:
        return place.point(variables).value
    except UnsolvedError:
        return float("nan")


def peak_band(mass: str) -> Band:
    return hertz(470.0 if mass != "2.6" else 430.0, 600.0)


def peak_bounds(mass: str) -> dict[str, Any]:
    """Bounds of the resonance peak for every published force, and the cloud that the search began with."""
    rig, band = single_blade(float(mass)), peak_band(mass)
    found = response_bounds(rig, band, LEVELS, "peak", cloud=8, starts=2, workers=WORKERS).dataset
    print(f"  peaks at {mass} kg: {found.attrs['cpu_seconds']:.0f} s CPU", flush=True)
    return {
        "force": list(LEVELS),
        "search": "cloud 8, starts 2",
        "cpu_seconds": found.attrs["cpu_seconds"],
        **{name: found[name].values[:, :, 0].tolist() for name in ("amplitude", "resonance", "loss_factor")},
        "start_variable": found.start_variable.values[:, :, 0].tolist(),
        "virgin": found.sampled_amplitude.values[:, 0, 0].tolist(),
        "cloud": [
            found.sampled_amplitude.min("start").values[:, 0].tolist(),
            found.sampled_amplitude.max("start").values[:, 0].tolist(),
        ],
    }


def solved_again_rows(mass: str, bounds: dict[str, Any]) -> Iterator[Row]:
    """Whole curves from the start states of the bounds: their highest peaks are the bounds."""
    rig, away = single_blade(float(mass)), []
    for level, starts, amplitudes in zip(LEVELS, bounds["start_variable"], bounds["amplitude"], strict=True):
        peaks = response_samples(rig, peak_band(mass), level, np.array(starts), workers=WORKERS).peaks()
        solved = peaks.set_index("start")["amplitude"].reindex(range(2)).to_numpy()
        away += [solved[0] / amplitudes[0] - 1.0, solved[1] / amplitudes[1] - 1.0]
    known = np.abs(away)[np.isfinite(away)]
    bounds["solved_again"] = [len(known), len(away), float(known.max())]
    lost = len(away) - len(known)
    yield at_most(f"Rig, {mass} kg: peak bounds whose start state's whole curve is lost, of {len(away)}", lost, 1, "whole curves")
    text = f"Rig, {mass} kg: peak bounds beside the highest peak from their start states, relative difference"
    yield at_most(text, float(known.max()), 1e-4, "whole curves")


IN_PLANE = ("traction_ratio", "virgin")
"""The published variable in the plane of the dampers; along their axes, where only friction holds them, sliders rest at 0."""


def ratio_bounds() -> dict[str, Any]:
    """At 4.6 kg and 20 N: the peak for ratios that all contacts have in common, and its bounds over one ratio per contact."""
    rig, band, ratios = single_blade(4.6), hertz(420.0, 600.0), np.linspace(-0.5, 0.5, 11)
    drawn = response_samples(rig, band, 20.0, ratios[:, None], rule=IN_PLANE, share="all", workers=WORKERS).peaks()
    found: dict[str, Any] = {"common": drawn[["frequency", "amplitude"]].assign(ratio=ratios[drawn["start"]]).to_dict("list")}
    bounds = response_bounds(rig, band, 20.0, "peak", cloud=8, starts=2, rule=IN_PLANE, share="contact", workers=WORKERS).dataset
    found |= {name: bounds[name].values[0, :, 0].tolist() for name in ("amplitude", "resonance", "loss_factor")}
    found |= {"unsolved": int(bounds["unsolved"][0, 0]), "cloud": bounds.sizes["start"]}
    return found | {"cpu_seconds": bounds.attrs["cpu_seconds"]}


def history() -> dict[str, Any]:
    """From 1 to 100 N and back at 4.6 kg."""
    found = response_history(single_blade(4.6), hertz(490.0, 580.0), points=91)
    peaks = found.dataset
    return {
        "force": peaks.force_level.values.tolist(),
        "frequency": peaks.largest_frequency.values[:, 0].tolist(),
        "amplitude": peaks.largest_amplitude.values[:, 0].tolist(),
        "change": {str(level): found.change(level) for level in LEVELS[:-1]},
    }


VARIANTS: dict[str, Callable[[], Problem]] = {
    "rigid support, array on the cylinder, five flat points": partial(single_blade, MASS),
    "separators on load cells, 500 N/µm, 0.3 kg": with_separators,
    "load cells 150 N/µm": partial(with_separators, cell_stiffness=150e6),
    "load cells 1500 N/µm": partial(with_separators, cell_stiffness=1500e6),
    "separators 0.09 kg": partial(with_separators, mass=0.09),
    "separators 0.9 kg": partial(with_separators, mass=0.9),
    "Jenkins elements on both sides": partial(single_blade, MASS, cylinder_elements=1),
    "four flat points": partial(single_blade, MASS, flat_points=4),
    "nine flat points": partial(single_blade, MASS, flat_points=9),
    "fifteen flat points": partial(single_blade, MASS, flat_points=15),
    "stinger 30 N/µm, 0.2 kg": partial(with_stinger, 30e6),
    "stinger 10 N/µm, 0.2 kg": partial(with_stinger, 10e6),
    "stinger 3 N/µm, 0.2 kg": partial(with_stinger, 3e6),
    "stinger 10 N/µm, 3 kg": partial(with_stinger, 10e6, 3.0),
}
"""Models of the rig: what the paper leaves open, times 0.3 and 3, and what it compares or names."""


def variants() -> dict[str, Any]:
    """The virgin peak of every model of the rig."""
    levels, models = (1.0, 20.0, 80.0, 100.0), {}
    for name, made in VARIANTS.items():
        rig = made()
        found = forced_response(rig, hertz(490.0, 590.0), levels).dataset
        models[name] = {"stuck": float(rig.frequencies(stuck=True)[0])} | {
            key: found[f"peak_{key}"].values[:, 0, 0].tolist() for key in ("frequency", "amplitude")
        }
    return {"force": list(levels), "models": models}


def proxy_rows(numbers: dict[str, Any]) -> Iterator[Row]:
    """Amplitude and loss-factor bounds over the band at 20 and 80 N, both against the cloud of the amplitude search."""
    rig, frequencies = single_blade(4.6), np.linspace(500.0, 575.0, 7)
    for level in (20.0, 80.0):
        by = {
            objective: response_bounds(rig, frequencies, level, objective, cloud=40, starts=2, workers=WORKERS).dataset
            for objective in ("amplitude", "loss_factor")
        }
        cloud = by["amplitude"].sampled_amplitude.values[0]
        record: dict[str, Any] = {"frequency": frequencies.tolist(), "solves": by["amplitude"].solves.values[0].tolist()}
        record["cpu_seconds"] = {objective: d.attrs["cpu_seconds"] for objective, d in by.items()}
        for objective, d in by.items():
            low, high = d.amplitude.values[0]
            record[objective] = {"lower": low.tolist(), "upper": high.tolist(), "loss_factor": d.loss_factor.values[0].tolist()}
            record[objective] |= {
                "below": float(np.mean(cloud < low * (1 - 1e-9))),
                "above": float(np.mean(cloud > high * (1 + 1e-9))),
            }
            record[objective]["worst"] = [float(np.nanmin(cloud / low) - 1.0), float(np.nanmax(cloud / high) - 1.0)]
        numbers[f"proxy_{level:g}N"] = record
        inside = record["amplitude"]["below"] + record["amplitude"]["above"]
        yield at_most(f"Rig, {level:g} N: share of the cloud outside the amplitude bounds", inside, 0.0, "containment")
        fresh = fresh_draws(rig, frequencies, level, by["amplitude"].amplitude.values[0])
        numbers[f"fresh_{level:g}N"] = fresh
        yield at_most(
            f"Rig, {level:g} N: draws that the search did not see outside the bounds", fresh["outside"], 0.0, "containment"
        )


def fresh_draws(rig: Problem, frequencies: Sequence[float], level: float, bounds: np.ndarray) -> dict[str, float]:
    """Start states that no search has seen, half of them corners, against the bounds (2, frequency)."""
    balance, rng = HarmonicBalance(rig, 5, 256), np.random.default_rng(11)
    ratios = []
    for frequency, (low, high) in zip(frequencies, bounds.T, strict=True):
        place = place_at(balance, frequency, level)
        place.point(np.zeros(place.space.size))
        for k in range(30):
            size = place.space.size
            value = value_of(place, rng.uniform(-1.0, 1.0, size) if k % 2 else rng.choice([-1.0, 1.0], size))
            ratios.append(max(low / value, value / high))
    solved = np.array(ratios)[np.isfinite(ratios)]
    return {"solved": solved.size, "outside": float(np.sum(solved > 1.0 + 1e-9)), "closest": float(solved.max())}
