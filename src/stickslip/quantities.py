"""Responses as engineers ask for them: displacement, velocity, acceleration; per force: receptance, mobility, inertance.

In a stored result these are X_h (i h ω)^k, so nothing is computed again. Figures, the report and CSV tables read them here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.checks import Array, fault, nearest

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


@dataclass(frozen=True)
class Quantity:
    """The k-th time derivative of the displacement; `units` and `name_per_force`: of it and of it per newton."""

    name: str
    order: int
    units: str
    name_per_force: str
    units_per_force: str


QUANTITIES = {
    quantity.name: quantity
    for quantity in (
        Quantity("displacement", 0, "m", "receptance", "m/N"),
        Quantity("velocity", 1, "m/s", "mobility", "m/(s N)"),
        Quantity("acceleration", 2, "m/s2", "inertance", "m/(s2 N)"),
    )
}


PER_FORCE = {quantity.name_per_force: quantity for quantity in QUANTITIES.values()} | {
    "compliance": QUANTITIES["displacement"],
    "accelerance": QUANTITIES["acceleration"],
}
"""By the names of what they are per force."""


def quantity_named(name: str, per_force: bool = False) -> tuple[Quantity, bool]:
    """The quantity of a name and whether it is wanted per force: by the name of its own (mobility) it is."""
    if name in PER_FORCE:
        return PER_FORCE[name], True
    if name not in QUANTITIES:
        rule = f"must be {', '.join(QUANTITIES)}, or per force {', '.join(PER_FORCE)}"
        raise fault("quantity", rule, name, nearest(name, [*QUANTITIES, *PER_FORCE]))
    return QUANTITIES[name], per_force


def angular_factor(frequency: Array, quantity: Quantity) -> Array:
    """(2πf)^k: from |X_1| of the displacement to that of the quantity; frequency in Hz."""
    return np.asarray((2.0 * np.pi * np.asarray(frequency)) ** quantity.order)


def as_quantity(dataset: xr.Dataset, name: str, per_force: bool = False) -> xr.Dataset:
    """The response of a result as another quantity: `response` (case, point, output, harmonic, part), `amplitude` and `rms`.

    name: displacement, velocity or acceleration; per_force divides by the force level. Or the name of what that makes, receptance
    (compliance), mobility, inertance (accelerance).
    """
    import xarray as xr

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
        "amplitude": sizes.isel(harmonic=1, drop=True),
        "rms": (mean + 0.5 * (sizes.isel(harmonic=slice(1, None)) ** 2).sum("harmonic")) ** 0.5,
    }
    words = quantity.name_per_force if per_force else quantity.name
    found = xr.Dataset(parts, attrs=dataset.attrs).assign_coords(part=dataset["part"])
    for variable in found.data_vars.values():
        variable.attrs = {"units": units, "long_name": words}
    converged = dataset["outcome"] == 1
    return found.where(converged).assign(frequency=dataset["frequency"], outcome=dataset["outcome"])


def quantity_table(dataset: xr.Dataset, name: str = "displacement", per_force: bool = False) -> pd.DataFrame:
    """Every converged point of every curve as a row; amplitudes are of the first harmonic, units stand in the column names.

    Samples have a column `start` that tells their start states apart.
    """
    import pandas as pd

    converted = as_quantity(dataset, name, per_force)
    units = converted["amplitude"].attrs["units"]
    first = converted["response"].isel(harmonic=1)
    phase = np.degrees(np.arctan2(first.isel(part=1).values, first.isel(part=0).values))
    rows = []
    for case, level in enumerate(dataset["force_level"].values):
        for k in np.flatnonzero(dataset["outcome"].values[case] == 1):
            for output, label in enumerate(dataset["output"].values):
                rows.append(
                    {
                        "force_level": float(level),
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


def peak_table(dataset: xr.Dataset, name: str = "displacement", per_force: bool = False) -> pd.DataFrame:
    """Every peak of the displacement's first harmonic as a row, its amplitude as another quantity at that frequency."""
    quantity, per_force = quantity_named(name, per_force)
    names = ["peak_frequency", "peak_amplitude", "peak_loss_factor"]
    table = dataset[names].to_dataframe().reset_index().dropna(subset=["peak_frequency"])
    scale = angular_factor(table["peak_frequency"].to_numpy(), quantity)
    if per_force:
        scale = scale / table["force_level"].to_numpy()
    units = _units(dataset, quantity, per_force)
    table[f"amplitude [{units}]"] = table["peak_amplitude"] * scale
    table = table.rename(columns={"peak_frequency": "frequency [Hz]", "peak_loss_factor": "loss_factor"})
    which = ["force_level", *(["start"] if "start" in dataset.coords else []), "output", "peak"]
    columns = [*which, "frequency [Hz]", f"amplitude [{units}]", "loss_factor"]
    return table[columns].sort_values(which, ignore_index=True)


def _units(dataset: xr.Dataset, quantity: Quantity, per_force: bool) -> str:
    if not per_force:
        return quantity.units
    newtons = str(dataset["force_level"].attrs.get("units", "1")) == "N"
    return quantity.units_per_force if newtons else f"{quantity.units} per unit level"
