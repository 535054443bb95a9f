"""Fatigue margins of the blades of mistuned disks, each at its largest amplitude."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stickslip.analyses.fatigue import Equivalent, has_fatigue, with_fatigue
from stickslip.analyses.stress import SIZES
from stickslip.model.structure.fatigue import FatigueLimit
from stickslip.support.checks import InputError

if TYPE_CHECKING:
    import xarray as xr

TUNED = "tuned_"
KEPT = ("fatigue_amplitude", "fatigue_mean", "fatigue_limit")


class BladeMargin(NamedTuple):
    """The smallest margin of a population: sample and blade, from 1; the place and Hz; amplitude and mean of the stress there and
    the amplitude that the material stands, Pa; the smallest margin of the tuned disk."""

    sample: int
    blade: int
    place: str
    frequency: float
    alternating: float
    mean: float
    allowed: float
    tuned: float

    @property
    def size(self) -> float:
        """By how much the vibration may grow; infinite where nothing vibrates."""
        return self.allowed / self.alternating if self.alternating > 0.0 else np.inf


def with_blade_fatigue(
    dataset: xr.Dataset, limit: FatigueLimit, mean: Mapping[str, float] | None = None, equivalent: Equivalent = "sines"
) -> xr.Dataset:
    """A population with stress and its fatigue margins: `fatigue_amplitude`, `fatigue_mean` and `fatigue_limit` (sample, blade,
    place) as of `with_fatigue`, each blade at its largest amplitude, and those of the tuned disk, `tuned_fatigue_amplitude`, ...

    Where several modes are excited, stress may be larger at another frequency than that of the largest amplitude.
    """
    if "stress_mean" not in dataset:
        raise InputError(
            "A fatigue margin of mistuned disks needs the stress of their blades. Name places of stress with the model of the "
            "sector (stress = ...), and compute results of an older version again."
        )
    found = with_fatigue(dataset, limit, mean, equivalent)
    own_names = {TUNED + name: name for name in (*SIZES, "stress_mean")}
    tuned = with_fatigue(dataset[list(own_names)].rename(own_names), limit, mean, equivalent)
    return found.assign({TUNED + name: tuned[name] for name in KEPT})


def blade_margins(dataset: xr.Dataset, prefix: str = "") -> xr.DataArray:
    """The margin of each blade at each place, (sample, blade, place), or of the tuned disk (place,); NaN where it failed."""
    allowed, alternating = dataset[f"{prefix}fatigue_limit"], dataset[f"{prefix}fatigue_amplitude"]
    with np.errstate(divide="ignore", invalid="ignore"):
        return (allowed / alternating).where(alternating != 0.0, np.inf).where(np.isfinite(alternating))


def smallest_blade_margin(dataset: xr.Dataset) -> BladeMargin | None:
    """The smallest margin of all blades, samples and places; None without a fatigue limit or where every sample failed."""
    if not has_fatigue(dataset):
        return None
    sizes = blade_margins(dataset)
    if not sizes.notnull().any():
        return None
    sample, blade, place = np.unravel_index(int(np.nanargmin(sizes.values)), sizes.shape)
    here = dataset.isel(sample=int(sample), blade=int(blade), place=int(place))
    alternating, mean, allowed = (float(here[name]) for name in KEPT)
    where = int(sample) + 1, int(here["blade"]), str(here["place"].values), float(here["blade_peak_frequency"])
    return BladeMargin(*where, alternating, mean, allowed, float(blade_margins(dataset, TUNED).min()))
