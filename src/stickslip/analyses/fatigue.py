"""Fatigue margin along response curves: the stress amplitude that a material stands over that of the vibration."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Literal, NamedTuple

import numpy as np

from stickslip.analyses.stress import has_stress
from stickslip.model.structure.fatigue import FatigueLimit
from stickslip.model.structure.stress import von_mises
from stickslip.results.view import inside_band
from stickslip.support.checks import Array, InputError, among, fault, finite, nearest
from stickslip.support.late import xr

NORMAL = ("xx", "yy", "zz")

DRAWN = 61
"""Points of the line of the limit that a figure is drawn from."""


Equivalent = Literal["sines", "von_mises", "principal"]
EQUIVALENTS = {
    "sines": "The amplitude is the largest von Mises stress of the vibration, and the mean is the sum of the mean normal "
    "stresses (Sines)",
    "von_mises": "The amplitude is the largest von Mises stress of the vibration, and the mean is the von Mises stress of the "
    "mean stresses, negative in compression",
    "principal": "Amplitude and mean are those of the normal stress on the plane where its amplitude is largest",
}
"""Of each equivalent stress in tension, how it is made."""


def with_fatigue(
    dataset: xr.Dataset, limit: FatigueLimit, mean: Mapping[str, float] | None = None, equivalent: Equivalent = "sines"
) -> xr.Dataset:
    """A response with stress (`with_stress`), or blades of mistuned disks with theirs, and the fatigue margin.

    equivalent: the stress in tension that replaces a stress of several components.

    "sines": amplitude σ_a, the largest von Mises stress of the vibration over the period (`stress_alternating`); mean σ_m, the
    sum of the mean normal stresses. Source: G. Sines (1959), see `FatigueLimit`.
    "von_mises": the same σ_a; σ_m, the von Mises stress of the mean stresses with the sign of their sum of normal stresses.
    Source: R. G. Budynas and J. K. Nisbett, Shigley's Mechanical Engineering Design, chapter 6 (combinations of loading modes).
    "principal": σ_a and σ_m of the normal stress on the plane where its amplitude is largest
    (`stress_principal`, `stress_principal_mean`), for brittle materials. Source: see `critical_plane`.

    In tension all three equal the stress itself. `fatigue_amplitude` (case, point, place): σ_a [Pa]; `fatigue_mean`: σ_m;
    `fatigue_limit`: the amplitude that the material withstands at this mean. The margin `fatigue_limit` / `fatigue_amplitude` is
    the factor by which the vibration may grow at the same mean stress.
    mean: stress that the response does not contain, such as that due to rotation, in Pa by place or by the name of a set of
    places; it is added to σ_m.
    """
    among("equivalent", equivalent, EQUIVALENTS)
    if not has_stress(dataset):
        raise InputError("A fatigue margin needs stress along the curves: take it of `response.with_stress()`.")
    places = [str(place) for place in dataset["place"].values]
    added = np.zeros(len(places))
    for name, size in (mean or {}).items():
        here = [k for k, place in enumerate(places) if place == name or place.startswith(f"{name}/")]
        if not here:
            raise fault("mean", "must name places of stress", name, nearest(name, places))
        added[here] = finite(f"mean of {name}", size)
    amplitude, sizes = _in_tension(dataset, equivalent)
    sizes = sizes + added
    allowed = np.where(np.isfinite(sizes), limit.amplitude(np.nan_to_num(sizes)), np.nan)
    dims = dataset["stress_alternating"].dims
    drawn = np.linspace(min(0.0, float(np.nanmin(sizes, initial=0.0))), limit.largest_mean, DRAWN)
    return dataset.assign(
        fatigue_amplitude=(dims, amplitude, {"units": "Pa", "long_name": "equivalent stress amplitude"}),
        fatigue_mean=(dims, sizes, {"units": "Pa", "long_name": "equivalent mean stress"}),
        fatigue_limit=(
            dims,
            allowed,
            {"units": "Pa", "long_name": "stress amplitude that the material stands"},
        ),
        haigh_mean=xr.DataArray(drawn, dims="haigh", attrs={"units": "Pa", "long_name": "mean stress of the Haigh diagram"}),
        haigh_limit=xr.DataArray(
            limit.amplitude(drawn), dims="haigh", attrs={"units": "Pa", "long_name": "stress amplitude of the Haigh diagram"}
        ),
    ).assign_attrs(fatigue_criterion=limit.words, fatigue_equivalent=equivalent)


def _in_tension(dataset: xr.Dataset, equivalent: Equivalent) -> tuple[Array, Array]:
    """Amplitude and mean of the equivalent stress, at each place, Pa."""
    if equivalent == "principal":
        if "stress_principal" not in dataset:
            raise InputError("The response of an older version has no principal stresses. Compute its stress again.")
        return dataset["stress_principal"].values, dataset["stress_principal_mean"].values
    tension = dataset["stress_mean"].sel(component=list(NORMAL)).values.sum(axis=-1)
    if equivalent == "von_mises":
        tension = np.where(tension < 0.0, -1.0, 1.0) * von_mises(dataset["stress_mean"].values)
    return dataset["stress_alternating"].values, tension


def has_fatigue(dataset: xr.Dataset) -> bool:
    """Whether a result holds fatigue margins."""
    return "fatigue_limit" in dataset.variables


class Margin(NamedTuple):
    """The smallest margin of one curve at one place: where, Hz; amplitude and mean of the stress, the amplitude that the material
    stands, and the amplitude at the resonance without contacts at the same force level, NaN where there is none, Pa."""

    case: int
    place: str
    point: int
    frequency: float
    alternating: float
    mean: float
    allowed: float
    without_contacts: float

    @property
    def size(self) -> float:
        """By how much the vibration may grow; infinite where nothing vibrates."""
        return self.allowed / self.alternating if self.alternating > 0.0 else np.inf

    @property
    def size_without_contacts(self) -> float:
        """The margin at the resonance without contacts, at the same mean stress; NaN where there is none."""
        return self.allowed / self.without_contacts if self.without_contacts > 0.0 else np.nan


def margins(dataset: xr.Dataset) -> Iterator[Margin]:
    """Of every curve and place where a point was solved, the smallest along the curve inside the band."""
    alternating = inside_band(dataset, "fatigue_amplitude" if "fatigue_amplitude" in dataset else "stress_alternating")
    allowed = dataset["fatigue_limit"].values
    none = np.full(dataset.sizes["place"], np.nan)  # in results of before
    by_plane = dataset.attrs.get("fatigue_equivalent") == "principal"
    free_stress = dataset.get("principal_without_contacts" if by_plane else "stress_without_contacts", none)
    free = np.outer(dataset["force_level"].values, free_stress)
    with np.errstate(divide="ignore", invalid="ignore"):
        size = np.where(alternating > 0.0, allowed / alternating, np.where(np.isfinite(alternating), np.inf, np.nan))
    for case in range(size.shape[0]):
        for k, place in enumerate(dataset["place"].values):
            if np.isfinite(alternating[case, :, k]).any():
                point = int(np.nanargmin(size[case, :, k]))
                found = alternating[case, point, k], dataset["fatigue_mean"].values[case, point, k], allowed[case, point, k]
                frequency = float(dataset["frequency"].values[case, point])
                yield Margin(case, str(place), point, frequency, *map(float, (*found, free[case, k])))


def smallest_margin(dataset: xr.Dataset) -> Margin | None:
    """The smallest of all curves and places; None without a point."""
    return min(margins(dataset), key=lambda margin: margin.size, default=None)


def smallest_margins(dataset: xr.Dataset) -> dict[int, Margin]:
    """The smallest of each curve, by its case; a curve without a point has none."""
    smallest: dict[int, Margin] = {}
    for margin in margins(dataset):
        smallest[margin.case] = min(smallest.get(margin.case, margin), margin, key=lambda each: each.size)
    return smallest
