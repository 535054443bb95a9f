"""Export to MATLAB: `save_mat` writes a dataset as a .mat file (version 5).

Variables keep their names and the order of their axes; real and imaginary parts become complex numbers, texts cell arrays. The
structs `units`, `meaning` and `axes` say of each variable what it is, `about` holds title, study and versions. Numbers
are in the units of the study.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scipy import io

from stickslip.results.quantities import as_quantity
from stickslip.results.shown_units import shown_dataset
from stickslip.results.view import measure_in
from stickslip.support.checks import fault
from stickslip.support.files import replacing

if TYPE_CHECKING:
    import xarray as xr

LARGEST = 2**31 - 1
"""Bytes of the largest variable of a .mat file of version 5."""
LONGEST_NAME = 63
"""Characters of a variable's name in MATLAB."""


def save_mat(dataset: xr.Dataset, path: str | Path, quantity: str | None = None, per_force: bool = False) -> Path:
    """Write one result as a .mat file, whole or not at all; returns the path.

    quantity: displacement, velocity or acceleration, of which `response`, `amplitude` and `rms` are then, that of the result's
    peaks unless given; per_force divides by the force level, as the names receptance, mobility and inertance do.
    """
    return save_all_mat({"": dataset}, path, quantity, per_force)


def save_all_mat(
    datasets: Mapping[str, xr.Dataset], path: str | Path, quantity: str | None = None, per_force: bool = False
) -> Path:
    """Several results in one file, each a struct with the name of the result; one without a name stands by itself."""
    tables = {_name(name): _table(shown_dataset(_converted(dataset, quantity, per_force))) for name, dataset in datasets.items()}
    content = tables[""] if set(tables) == {""} else tables
    with replacing(path) as temporary:
        io.savemat(str(temporary), content, appendmat=False, long_field_names=True, do_compression=True, oned_as="column")
    return Path(path)


def _converted(dataset: xr.Dataset, quantity: str | None, per_force: bool) -> xr.Dataset:
    """The dataset with its responses as another quantity."""
    if "response" not in dataset:
        return dataset
    quantity = quantity or measure_in(dataset).name
    if quantity == "displacement" and not per_force:
        return dataset
    found = as_quantity(dataset, quantity, per_force)
    return dataset.assign({name: found[name] for name in ("response", "amplitude", "rms")})


def _table(dataset: xr.Dataset) -> dict[str, Any]:
    """Variables by name, and the structs that describe them."""
    variables = {_name(str(name)): variable for name, variable in dataset.variables.items() if name != "part"}
    described = {
        "units": {name: str(variable.attrs.get("units", "1")) for name, variable in variables.items()},
        "meaning": {name: str(variable.attrs.get("long_name", "")) for name, variable in variables.items()},
        "axes": {name: ", ".join(str(dim) for dim in variable.dims if dim != "part") for name, variable in variables.items()},
        "about": {_name(str(name)): value for name, value in dataset.attrs.items()},
    }
    return {name: _array(name, variable) for name, variable in variables.items()} | described


def _array(name: str, variable: xr.Variable) -> Any:
    """Numbers as they are, parts as complex numbers, texts as objects (cells)."""
    if variable.nbytes > LARGEST:
        raise fault(f"The variable {name}", "must have less than 2 GiB in a .mat file", f"{variable.nbytes / 2**30:.1f} GiB")
    if "part" in variable.dims:
        return variable.isel(part=0).values + 1j * variable.isel(part=1).values
    return variable.values.astype(object) if variable.dtype.kind in "UOT" else variable.values


def _name(name: str) -> str:
    """A name that MATLAB allows: letters, digits and _, a letter first."""
    plain = re.sub(r"\W", "_", name, flags=re.ASCII)[: LONGEST_NAME - 1]
    return plain if not plain or plain[0].isalpha() else f"r{plain}"
