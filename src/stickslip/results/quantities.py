"""Derived quantities of a response: velocity, acceleration, and per force receptance, mobility, inertance.

In a stored result these are X_h (i h ω)^k, so nothing is computed again. Figures, the report and CSV tables read them here.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from stickslip.results.curve_kind import kinds_in
from stickslip.results.stability import has_stability
from stickslip.results.stability import words as words_of_flags
from stickslip.results.view import levels_in_newtons, measure_in, nearest_point, periods_of, sizes
from stickslip.solve.balance.measure import Measure, Quantity, quantity_named
from stickslip.support.late import pd, xr

ERRORS = ("truncation_error", "sampling_error", "work_error", "modal_error", "patch_error")
"""Estimates of errors at the highest peak of an output, (case, output), of those that a result holds."""


def as_quantity(dataset: xr.Dataset, name: str, per_force: bool = False) -> xr.Dataset:
    """The response of a result as another quantity: `response` (case, point, output, harmonic, part), `amplitude` and `rms`.

    name: displacement, velocity or acceleration; per_force divides by the force level. Or the name of what that makes, receptance
    (compliance), mobility, inertance (accelerance).
    """
    quantity, per_force = quantity_named(name, per_force)
    rate = 2.0 * np.pi * dataset["frequency"] * dataset["harmonic"]
    complex_response = dataset["response"].isel(part=0) + 1j * dataset["response"].isel(part=1)
    values = complex_response * (1j * rate) ** quantity.order
    if per_force:
        values = values / dataset["force_level"]
    units = _units(dataset, quantity, per_force)
    sizes = abs(values)
    mean = sizes.isel(harmonic=0, drop=True) ** 2
    parts: dict[str, Any] = {
        "response": xr.concat([values.real, values.imag], dim="part").transpose(*dataset["response"].dims),
        "amplitude": sizes.isel(harmonic=periods_of(dataset), drop=True),
        "rms": (mean + 0.5 * (sizes.isel(harmonic=slice(1, None)) ** 2).sum("harmonic")) ** 0.5,
    }
    words = quantity.name_per_force if per_force else quantity.name
    found = xr.Dataset(parts, attrs=dataset.attrs).assign_coords(part=dataset["part"])
    for variable in found.data_vars.values():
        variable.attrs = {"units": units, "long_name": words}
    converged = dataset["outcome"] == 1
    return found.where(converged).assign(frequency=dataset["frequency"], outcome=dataset["outcome"])


def quantity_table(dataset: xr.Dataset, name: str | None = None, per_force: bool = False) -> pd.DataFrame:
    """Every converged point of every curve as a row; amplitudes are of the first harmonic, units stand in the column names.

    name: the quantity; that of the result's peaks unless given. Samples have a column `start` with their start states
    apart.
    """
    converted = as_quantity(dataset, name or measure_in(dataset).name, per_force)
    units = converted["amplitude"].attrs["units"]
    first = converted["response"].isel(harmonic=periods_of(dataset))
    phase = np.degrees(np.arctan2(first.isel(part=1).values, first.isel(part=0).values))
    rows = []
    for case, level in enumerate(dataset["force_level"].values):
        for k in np.flatnonzero(dataset["outcome"].values[case] == 1):
            for output, label in enumerate(dataset["output"].values):
                rows.append(
                    {
                        "force_level": float(level),
                        **({"curve": kinds_in(dataset)[case].name.lower()} if "curve_kind" in dataset else {}),
                        **({"start": int(dataset["start"].values[case])} if "start" in dataset.coords else {}),
                        "output": str(label),
                        "point": int(k),
                        "frequency [Hz]": float(dataset["frequency"].values[case, k]),
                        f"amplitude [{units}]": float(converted["amplitude"].values[case, k, output]),
                        "phase [deg]": float(phase[case, k, output]),
                        f"rms [{units}]": float(converted["rms"].values[case, k, output]),
                        "loss_factor": float(dataset["loss_factor"].values[case, k]),
                        "residual": float(dataset["residual"].values[case, k]),
                    }
                )
    return pd.DataFrame(rows)


def peak_table(dataset: xr.Dataset, name: str | None = None, per_force: bool = False) -> pd.DataFrame:
    """Every peak as a row: frequency, its size, loss factor, and at the highest peak of each curve the estimates of its errors:
    relative changes of the size with more harmonics, with more samples, on all coordinates of the structure and with a contact at
    each node of a patch, and of the work of the contacts. name: the quantity; that of the result's peaks unless given.

    Peaks of another quantity are elsewhere: they are not in the result. The column of the size then says whose peaks these are,
    "acceleration at the displacement peak [m/s2]"; for the others ask the analysis for that quantity,
    or `ForcedResponse.peaks("acceleration")`, which has the problem to solve them.
    """
    own = measure_in(dataset)
    quantity, per_force = quantity_named(name or own.name, per_force)
    table = dataset[["peak_frequency", "peak_amplitude", "peak_loss_factor", *_stability(dataset)]].to_dataframe().reset_index()
    table = table.dropna(subset=["peak_frequency"])
    if own.per_force:
        table["peak_amplitude"] = table["peak_amplitude"] * table["force_level"]
    if quantity != own.quantity:
        wanted = Measure(quantity, own.kind)
        outputs = [str(label) for label in dataset["output"].values]
        places = [
            (int(row.case), outputs.index(str(row.output)), row.peak_frequency, row.peak_amplitude) for row in table.itertuples()
        ]
        table["peak_amplitude"] = [
            float(sizes(dataset, place[0], place[1], wanted, np.array([nearest_point(dataset, *place)]))[0]) for place in places
        ]
    if per_force:
        table["peak_amplitude"] = table["peak_amplitude"] / table["force_level"]
    words = quantity.name_per_force if per_force else quantity.name
    what = own.kind if quantity == own.quantity else f"{words} at the {own.quantity.name} peak"
    size = f"{what} [{_units(dataset, quantity, per_force)}]"
    names = {"peak_frequency": "frequency [Hz]", "peak_amplitude": size, "peak_loss_factor": "loss_factor"}
    if "curve_kind" in dataset:
        table["curve"] = words_of_flags(dataset["curve_kind"], dataset["curve_kind"].to_numpy()[table["case"]])
    if has_stability(dataset):
        names["stability"] = "stability"
        table["stability"] = words_of_flags(dataset["peak_stability"], table["peak_stability"].to_numpy())
    for key in (each for each in ERRORS if each in dataset):
        columns = {str(label): k for k, label in enumerate(dataset["output"].values)}
        at = table["case"].to_numpy(dtype=int), table["output"].astype(str).map(columns).to_numpy(dtype=int)
        table[key] = np.where(table["peak"] == 0, dataset[key].values[at], np.nan)
        names[key] = key
    table = table.rename(columns=names)
    curve = ["curve"] if "curve_kind" in dataset else []
    which = ["force_level", *curve, *(["start"] if "start" in dataset.coords else []), "output", "peak"]
    return table[[*which, *names.values()]].sort_values(which, ignore_index=True)


def _stability(dataset: xr.Dataset) -> list[str]:
    """The variable of the peaks' stability, where a result has it."""
    return ["peak_stability"] if has_stability(dataset) else []


def other_peaks(dataset: xr.Dataset, name: str | None) -> str:
    """A sentence where the peaks of a result are not of the quantity that is asked for; else ""."""
    own = measure_in(dataset)
    asked = name or own.name
    quantity = quantity_named(asked)[0]
    if quantity == own.quantity or not dataset["peak_frequency"].notnull().any():
        return ""
    return (
        f"The peaks are those of the {own.quantity.name}, with the {asked} there, which is highest elsewhere: "
        f'for its own peaks run the study with quantity = "{asked}" in [sweep].'
    )


def _units(dataset: xr.Dataset, quantity: Quantity, per_force: bool) -> str:
    return Measure(quantity, per_force=per_force).reported_units(levels_in_newtons(dataset))
