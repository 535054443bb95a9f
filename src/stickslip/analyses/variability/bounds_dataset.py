"""Bounds and nominal response in one dataset, for one results file and one report."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stickslip.results.shown_units import ATTRIBUTE

if TYPE_CHECKING:
    import xarray as xr

PREFIX = "bounds_"
_SHARED = {"case", "force_level"}


def attached(response: xr.Dataset, bounds: xr.Dataset) -> xr.Dataset:
    """The response with the bounds of the same force levels; names and dimensions of the bounds begin with bounds_."""
    names = {str(name) for name in (*bounds.variables, *bounds.dims)} - _SHARED
    renamed = bounds.rename({name: PREFIX + name for name in names}).drop_vars("force_level")
    attrs = {PREFIX + str(key): value for key, value in bounds.attrs.items()}
    return response.assign(renamed.variables).assign_attrs(attrs)


def has_bounds(dataset: xr.Dataset) -> bool:
    """Whether bounds are attached."""
    return PREFIX + "amplitude" in dataset.variables


def detached(dataset: xr.Dataset) -> xr.Dataset:
    """The bounds of a dataset, as `response_bounds` gives them."""
    names = [name for name in dataset.variables if str(name).startswith(PREFIX)]
    bounds = dataset[names]
    every = {str(name) for name in (*bounds.variables, *bounds.dims) if str(name).startswith(PREFIX)}
    bounds = bounds.rename({name: name.removeprefix(PREFIX) for name in every})
    bounds = bounds.assign_coords(force_level=("case", dataset["force_level"].values))
    bounds.attrs = {str(k).removeprefix(PREFIX): v for k, v in dataset.attrs.items() if str(k).startswith(PREFIX)}
    bounds.attrs |= {ATTRIBUTE: dataset.attrs[ATTRIBUTE]} if ATTRIBUTE in dataset.attrs else {}
    return bounds
