"""Arrays of the curves of a result, from which one with more curves is made."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.results.schema import SCHEMA
from stickslip.runs.work import Arrays
from stickslip.support.late import xr

KEPT = (
    "truncation_error", "sampling_error", "work_error", "modal_error", "patch_error", "point_truncation_error",
    "highest_stability", "end_stability",
)  # fmt: skip
"""What a curve has beside the variables of the schema."""


def arrays_of(dataset: xr.Dataset, case: int, longer: int = 1) -> dict[str, NDArray[Any]]:
    """What `curve_arrays` gives of a curve, from its dataset; longer: by how many times the expansion is."""
    found: dict[str, NDArray[Any]] = {}
    for variable in SCHEMA:
        if variable.dims[0] == "case" and "linear_point" not in variable.dims:
            values = dataset[variable.name].transpose(*variable.dims).values[case]
            found[variable.name] = _longer(values, variable.dims[1:], longer) if longer > 1 else np.asarray(values)
    for name in KEPT:
        if name in dataset:
            found[name] = dataset[name].values[case]
    return found


APART = "isolated {} "
"""What stands before the names of the arrays of a curve that lies apart from the swept one, with its number."""


def beside(curves: Sequence[Arrays]) -> dict[str, NDArray[Any]]:
    """The arrays of curves apart from a swept one, under names that stand beside its own."""
    return {APART.format(k) + name: values for k, each in enumerate(curves) for name, values in each.items()}


def apart_of(arrays: Arrays) -> list[Arrays]:
    """The arrays of the curves that `beside` put there."""
    found: list[Arrays] = []
    while own := {name: values for name, values in arrays.items() if name.startswith(APART.format(len(found)))}:
        begin = len(APART.format(len(found)))
        found.append({name[begin:]: values for name, values in own.items()})
    return found


def _longer(values: NDArray[Any], dims: tuple[str, ...], longer: int) -> NDArray[Any]:
    """Over several times the period: harmonics with zeros between them, samples repeated."""
    if "harmonic" in dims:
        axis = dims.index("harmonic")
        shape = list(values.shape)
        shape[axis] = longer * (shape[axis] - 1) + 1
        spread = np.where(np.isnan(np.take(values, [0], axis)), np.nan, np.zeros(shape))
        place: list[Any] = [slice(None)] * values.ndim
        place[axis] = slice(None, None, longer)
        spread[tuple(place)] = values
        return spread
    return np.tile(values, [longer if dim == "sample" else 1 for dim in dims]) if "sample" in dims else np.asarray(values)
