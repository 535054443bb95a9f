"""Forced response at user-chosen frequencies: interpolated between solved points and checked, or solved."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.response_dataset import point_values
from stickslip.analyses.solved_points import SolvedPoints
from stickslip.model.problem import Problem
from stickslip.results.schema import COORDINATES, SCHEMA, stamped
from stickslip.solve.continuation.interpolation import SAME, Interpolation, Value
from stickslip.support.checks import Array, InputError, fault, numbers, positive
from stickslip.support.late import xr
from stickslip.support.machine import one_blas_thread
from stickslip.support.outcome import Outcome

KEPT = ("outcome", "residual", "response", "amplitude", "rms", "max_abs", "contact_motion", "contact_force")
"""The variables of the schema that are given at each frequency."""

OWN = {
    "solved": "1 where the balance was solved at this frequency, 0 where forces are interpolated",
    "error": "estimated error of the outputs relative to their amplitudes; 0 where solved",
}


def response_at(dataset: xr.Dataset, problem: Problem, frequencies: Any, tolerance: float) -> xr.Dataset:
    """What `ForcedResponse.at` says."""
    wanted = _within_the_band(dataset, frequencies)
    if not positive("tolerance", tolerance) < 0.1:
        raise fault("tolerance", "must lie between 0 and 0.1", tolerance)
    points = SolvedPoints(dataset, problem)
    with one_blas_thread():
        curves: list[list[list[Value]]] = []
        omegas = 2.0 * np.pi * wanted / points.balance.periods
        for case in range(dataset.sizes["case"]):
            solved = points.converged(case)
            curves.append(Interpolation(points.balance, solved, tolerance).values(omegas) if solved else [[] for _ in wanted])
    return _dataset(dataset, points, wanted, curves, tolerance)


def _within_the_band(dataset: xr.Dataset, frequencies: Any) -> Array:
    """Frequencies in Hz, checked; those that a curve has by rounding are its own. Where curves broke off, some have no values."""
    wanted = np.array([positive("A frequency", value) for value in np.atleast_1d(numbers("frequencies", frequencies))])
    if not wanted.size:
        raise InputError("frequencies must hold at least one value, but is empty.")
    known = dataset["frequency"].values
    if np.any(dataset["case_outcome"].values != Outcome.CONVERGED):
        known = np.append(known, dataset["linear_frequency"].values)  # from end to end of the band that was asked for
    low, high = np.nanmin(known), np.nanmax(known)
    for value in wanted.tolist():
        if not low * (1.0 - SAME) <= value <= high * (1.0 + SAME):
            what = f"must lie in the band of the response, from {low:g} to {high:g} Hz"
            raise fault("A frequency", what, value, "Solve a wider band.")
    return wanted


def _dataset(
    dataset: xr.Dataset, points: SolvedPoints, wanted: Array, curves: Sequence[list[list[Value]]], tolerance: float
) -> xr.Dataset:
    branches = max((len(values) for curve in curves for values in curve), default=0)
    shape = (len(curves), max(branches, 1), len(wanted))
    found: dict[str, NDArray[Any]] = {name: np.full((*shape, *dataset[name].shape[2:]), np.nan) for name in KEPT}
    found |= {
        "outcome": np.zeros(shape, dtype=np.int8),
        "solved": np.zeros(shape, dtype=np.int8),
        "error": np.full(shape, np.nan),
    }
    for case, i in product(range(len(curves)), range(len(wanted))):
        if not curves[case][i]:
            ended = Outcome(int(dataset["case_outcome"][case]))
            found["outcome"][case, 0, i] = Outcome.EMPTY if ended == Outcome.CONVERGED else ended
        for branch, value in enumerate(curves[case][i]):
            place = case, branch, i
            found["solved"][place] = value.solved
            if value.evaluation is None:
                found["outcome"][place] = Outcome.NOT_CONVERGED
                continue
            found["outcome"][place] = Outcome.CONVERGED
            found["residual"][place], found["error"][place] = value.evaluation.error, value.error
            for name, values in point_values(points.balance, points.rows, [value.evaluation]).items():
                found[name][place] = values[0]
    variables = {v.name: (_dims(v.dims), found[v.name], dataset[v.name].attrs) for v in SCHEMA if v.name in found}
    variables |= {
        name: (_dims(("case", "point")), found[name], {"units": "1", "long_name": words}) for name, words in OWN.items()
    }
    coords: dict[str, Any] = {v.name: dataset[v.name] for v in COORDINATES}
    coords["frequency"] = ("frequency", wanted, dataset["frequency"].attrs)
    attrs = {name: dataset.attrs[name] for name in ("title", "study", "harmonics", "samples", "periods") if name in dataset.attrs}
    return stamped(xr.Dataset(variables, coords, attrs | {"tolerance": tolerance}), "response_at")


def _dims(dims: Sequence[str]) -> tuple[str, ...]:
    """Those of a point's variable, with the times a curve passes a frequency in place of points."""
    return ("case", "branch", "frequency", *dims[2:])
