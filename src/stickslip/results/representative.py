"""Representative cases for figures, report and console: evenly spread force levels; of start states lowest, median and highest.

A figure has room for a few panels; a sentence beside it says how the cases shown were chosen.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from stickslip.results.view import highest_peak
from stickslip.support.checks import listed
from stickslip.support.late import xr

REPRESENTATIVE = ("lowest", "median", "highest")
"""Start states of one force level that stand for all, by their highest peaks."""


@dataclass(frozen=True, eq=False)
class Representatives:
    """The cases to show, also as a dataset of their own, and a sentence about the others; empty where there are none."""

    dataset: xr.Dataset
    cases: list[int]
    words: str


def spread(count: int, most: int) -> list[int]:
    """At most `most` places of `count`, evenly spread from the first to the last; a single one is the last."""
    return sorted({round(place) for place in np.linspace(count - 1, 0, min(count, most)).tolist()})


def is_cloud(dataset: xr.Dataset) -> bool:
    """Whether the cases are start states, several to a force level."""
    return "start" in dataset.coords


def levels_of(dataset: xr.Dataset) -> list[list[int]]:
    """The cases of each force level of a cloud; otherwise every case is a level of its own."""
    if not is_cloud(dataset):
        return [[case] for case in range(dataset.sizes["case"])]
    values = dataset["force_level"].values.tolist()
    return [[case for case, value in enumerate(values) if value == level] for level in dict.fromkeys(values)]


def ranked(dataset: xr.Dataset, cases: list[int], output: int = 0) -> list[int]:
    """Those of the cases that have a solution, by their highest peak, lowest first."""
    peaks = {case: highest_peak(dataset, case, output) for case in cases}
    sizes = {case: peak.amplitude for case, peak in peaks.items() if peak is not None}
    return sorted(sizes, key=lambda case: sizes[case])


def representative_starts(dataset: xr.Dataset, cases: list[int], most: int = len(REPRESENTATIVE)) -> list[int]:
    """Of start states of one level those of lowest, median and highest peak, in this order."""
    order = ranked(dataset, cases) or cases[:1]
    return [order[place] for place in spread(len(order), min(most, len(REPRESENTATIVE)))]


def words_of(chosen: list[int]) -> list[str]:
    """What each of the cases that `representative_starts` gives is."""
    return [REPRESENTATIVE[place] for place in spread(len(REPRESENTATIVE), len(chosen))]


def representatives(dataset: xr.Dataset, most: int) -> Representatives:
    """At most `most` cases: all; else levels evenly spread, and of a cloud three start states of each."""
    groups = levels_of(dataset)
    if dataset.sizes["case"] <= most:
        return Representatives(dataset, list(range(dataset.sizes["case"])), "")
    cloud = is_cloud(dataset)
    levels = spread(len(groups), max(1, most // len(REPRESENTATIVE)) if cloud else most)
    chosen = partial(representative_starts, dataset, most=most) if cloud else list
    kept = [case for level in levels for case in chosen(groups[level])]
    fewer = f"{len(levels)} of {len(groups)} force levels" if len(levels) < len(groups) else ""
    return Representatives(dataset.isel(case=kept), kept, "; ".join(filter(None, (cloud_words(dataset, most), fewer))))


def cloud_words(dataset: xr.Dataset, most: int = len(REPRESENTATIVE)) -> str:
    """What `representative_starts` takes, in words; empty without start states."""
    if not is_cloud(dataset):
        return ""
    names = words_of(list(range(min(most, len(REPRESENTATIVE)))))
    starts = max(len(cases) for cases in levels_of(dataset))
    return f"of {starts} start states those with the {listed(names)} response"
