"""What kind of curve a case of a forced response is: of a sweep, a branch, or isolated."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

import numpy as np

from stickslip.support.late import xr


class CurveKind(IntEnum):
    """How a curve was found."""

    SWEEP = 0
    BRANCH = 1
    ISOLATED = 2


def with_kinds(dataset: xr.Dataset, kinds: list[CurveKind]) -> xr.Dataset:
    """A forced response that says of every case what kind of curve it is; as it is where all are of sweeps."""
    if not any(kinds):
        return dataset
    attributes: dict[str, Any] = {
        "units": "1",
        "long_name": "kind of the curve",
        "flag_values": np.array([int(kind) for kind in CurveKind], dtype=np.int8),
        "flag_meanings": " ".join(kind.name.lower() for kind in CurveKind),
    }
    return dataset.assign(curve_kind=("case", np.array(kinds, dtype=np.int8), attributes))


def kinds_in(dataset: xr.Dataset) -> list[CurveKind]:
    """The kind of every case."""
    if "curve_kind" not in dataset.variables:
        return [CurveKind.SWEEP] * dataset.sizes["case"]
    return [CurveKind(int(kind)) for kind in dataset["curve_kind"].values]


def kind_words(dataset: xr.Dataset, case: int) -> str:
    """ "branch" or "isolated"; "" for a sweep."""
    kind = kinds_in(dataset)[case]
    return "" if kind == CurveKind.SWEEP else kind.name.lower()
