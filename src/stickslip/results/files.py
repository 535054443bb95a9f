"""Results files in NetCDF-4: `save` writes them atomically, `open_results` reads and checks them.

No pickle: strings, numbers and attributes only, so any NetCDF or HDF5 reader opens the file.

Export to MATLAB: `save_mat` writes a dataset as a .mat file (version 5).

Variables keep their names and the order of their axes; real and imaginary parts become complex numbers, texts cell arrays. The
structs `units`, `meaning` and `axes` say of each variable what it is, `about` holds title, study and versions. Numbers
are in the units of the study.
"""

from __future__ import annotations

import io
import re
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import io as scipy_io

from stickslip.model.readers.matlab import refuse_other_files, refuse_too_much
from stickslip.results.quantities import as_quantity
from stickslip.results.schema import (
    FILE_FORMAT,
    SCHEMA,
    Result,
    analysis_named,
    check_results,
    labelled,
    shown_dataset,
    stamped,
    with_frequency,
)
from stickslip.results.view import measure_in
from stickslip.support.checks import Faults, InputError, fault, similar_file
from stickslip.support.files import replacing
from stickslip.support.interrupts import held_back
from stickslip.support.late import h5py, xr

__all__ = ["SCHEMA", "labelled", "open_results", "save", "stamped"]

_HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_LENGTH_ALONE = b"This is a netCDF dimension but not a netCDF variable."
"""How NetCDF marks what gives an axis its length and holds nothing."""
CHECKSUM = "crc32"
"""Attribute of each variable, and of the file for its own attributes."""

_COMPRESS_FROM = 1024
"""Entries from which compressing a variable is worth its header."""


def save(dataset: xr.Dataset, path: str | Path) -> Path:
    """Write `dataset` as NetCDF-4, whole or not at all; returns the path. Large variables are compressed and checksummed.

    A file of that name is replaced, as NumPy and xarray do; the commands refuse it without `--overwrite`.
    """
    check_results(dataset)
    content = _netcdf(dataset)
    with replacing(path) as temporary:
        temporary.write_bytes(content)
    return Path(path)


class SavedResult(Result):
    """A result whose dataset can be written to a file, as that of the analysis after which its class is named."""

    dataset: xr.Dataset

    def save(self, path: str | Path) -> Path:
        """Write the dataset as NetCDF, as the command does."""
        return save(stamped(self.dataset, analysis_named(type(self).__name__)), path)


def _netcdf(dataset: xr.Dataset) -> bytes:
    """The file in memory: on a full disk HDF5 would not only fail, but take the process with it."""
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    plain = _with_checksums(dataset)
    for name, encoding in _encoding(dataset).items():
        plain[name].encoding = encoding
    buffer = io.BytesIO()
    with held_back(), h5netcdf.File(buffer, "w") as file:  # which Ctrl-C would leave half made
        plain.dump_to_store(H5NetCDFStore(file))
    return buffer.getvalue()


def _with_checksums(dataset: xr.Dataset) -> xr.Dataset:
    """A copy whose variables, and the dataset for its attributes, carry the checksum of their content."""
    marked = dataset.copy()
    marked.attrs = {**dataset.attrs, CHECKSUM: _checksum(dataset.attrs)}
    for name, variable in marked.variables.items():
        marked[name].attrs = {**variable.attrs, CHECKSUM: _checksum(variable.attrs, variable.values)}
    return marked


def _checksum(attributes: Mapping[Any, Any], values: NDArray[Any] | None = None) -> str:
    """CRC-32 of attributes and values, eight hexadecimal digits, as they are read from the file again."""
    words = {str(key): np.ravel(value).tolist() for key, value in attributes.items() if key != CHECKSUM}
    found = zlib.crc32(repr(sorted(words.items())).encode())
    if values is not None:
        if values.dtype.kind == "f":
            values = np.where(np.isnan(values), np.nan, values)  # of which there are many bit patterns
        text = values.dtype.kind in "OTUS"
        content = repr(values.tolist()).encode() if text else np.ascontiguousarray(values).tobytes()
        found = zlib.crc32(content, zlib.crc32(repr(values.shape).encode(), found))
    return f"{found:08x}"


def _verified(dataset: xr.Dataset, path: Path) -> xr.Dataset:
    """The dataset without its checksums; refused where one does not agree. Files of earlier versions have none."""
    parts: dict[str, tuple[dict[Any, Any], NDArray[Any] | None]] = {"the attributes": (dataset.attrs, None)}
    parts |= {f"the variable {name!r}": (variable.attrs, variable.values) for name, variable in dataset.variables.items()}
    wrong = [what for what, (attrs, values) in parts.items() if CHECKSUM in attrs and attrs[CHECKSUM] != _checksum(attrs, values)]
    if wrong:
        raise InputError(
            f"The results file {str(path)!r} must be as it was written, but {wrong[0]}"
            f"{f' and {len(wrong) - 1} more' if len(wrong) > 1 else ''} changed since. Copy it again, or run the study again."
        )
    for attrs, _ in parts.values():
        attrs.pop(CHECKSUM, None)
    return dataset


def open_results(path: str | Path) -> xr.Dataset:
    """Read a results file, or the results.nc of a folder, whole into memory and check it against the schema; the file is closed
    on return."""
    path = Path(path)
    path = path / "results.nc" if (path / "results.nc").is_file() else path
    _refuse_foreign(path)
    try:
        _refuse_what_is_not_in_it(path)
        with held_back(), xr.open_dataset(path, engine="h5netcdf", decode_times=False) as opened:
            _check_format(opened, path)
            dataset = _plain(_verified(opened.load(), path))
    except InputError:
        raise
    except (OSError, RuntimeError, ValueError, KeyError, AttributeError, TypeError, zlib.error) as error:
        raise InputError(
            f"The results file {str(path)!r} must be readable to its end, but is truncated or damaged. "
            "Copy it again, or run the study again."
        ) from error
    try:
        check_results(dataset)
    except Faults as faults:
        raise Faults([f"{path}: {line}" for line in faults.faults]) from None
    return dataset


def _refuse_foreign(path: Path) -> None:
    try:
        with path.open("rb") as file:
            start = file.read(len(_HDF5_SIGNATURE))
    except FileNotFoundError:
        remedy = similar_file(path) or "`stickslip run STUDY --out DIR` writes one."
        raise fault("The results file", "must exist", str(path), remedy) from None
    except IsADirectoryError:
        raise fault("The results file", "must be readable", str(path), "It is a folder: give the results.nc in it.") from None
    except OSError as error:
        raise fault("The results file", "must be readable", str(path), f"({error.strerror})") from None
    if start != _HDF5_SIGNATURE:
        what = "empty" if not start else "not NetCDF-4"
        raise fault("A results file", f"must be NetCDF-4 as written by stickslip ({what})", str(path))


def _refuse_what_is_not_in_it(path: Path) -> None:
    try:
        with h5py.File(path) as file:
            refuse_other_files(file)
            for name, item in file.items():
                if isinstance(item, h5py.Dataset) and not bytes(item.attrs.get("NAME", b"")).startswith(_LENGTH_ALONE):
                    refuse_too_much(name, item)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _check_format(dataset: xr.Dataset, path: Path) -> None:
    """Refuse a file of another program, or of another file format of this one."""
    if "file_format" not in dataset.attrs:
        raise fault("A results file", "must carry the attribute file_format", str(path), "Another program wrote this file.")
    found = dataset.attrs["file_format"]
    if np.ndim(found) or found != FILE_FORMAT:
        newer = np.ndim(found) == 0 and isinstance(found, (int, float, np.number)) and found > FILE_FORMAT
        remedy = "It was written by a newer stickslip: update this one." if newer else "Run the study again with this version."
        raise fault(f"file_format of {str(path)!r}", f"must be {FILE_FORMAT}", _scalar(found), remedy)


def _encoding(dataset: xr.Dataset) -> dict[str, dict[str, Any]]:
    """Shuffle, deflate and checksum where there is something to gain; strings and small arrays stay plain."""
    packed = {"zlib": True, "complevel": 4, "shuffle": True, "fletcher32": True}
    return {
        str(name): packed if variable.dtype.kind in "fi" and variable.size >= _COMPRESS_FROM else {}
        for name, variable in dataset.variables.items()
    }


def _plain(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset as an analysis makes it: strings of fixed width, Python numbers as attributes, no encoding of the file."""
    for name, variable in list(dataset.variables.items()):
        if variable.dtype.kind in "OT":
            dataset[name] = (variable.dims, variable.values.astype(np.str_), variable.attrs)
    dataset.attrs = {key: _scalar(value) for key, value in dataset.attrs.items()}
    return with_frequency(dataset.drop_encoding())


def _scalar(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


LARGEST = 2**31 - 1
"""Bytes of the largest variable of a .mat file of version 5."""
LONGEST_NAME = 63
"""Characters of a variable's name in MATLAB."""


def save_mat(
    dataset: xr.Dataset | Mapping[str, xr.Dataset], path: str | Path, quantity: str | None = None, per_force: bool = False
) -> Path:
    """Write one result as a .mat file, whole or not at all, or several by name, each a struct in it; returns the path.

    quantity: displacement, velocity or acceleration, of which `response`, `amplitude` and `rms` are then, that of the result's
    peaks unless given; per_force divides by the force level, as the names receptance, mobility and inertance do.
    """
    datasets = {"": dataset} if isinstance(dataset, xr.Dataset) else dataset
    tables = {_name(name): _table(shown_dataset(_converted(each, quantity, per_force))) for name, each in datasets.items()}
    content = tables[""] if set(tables) == {""} else tables
    with replacing(path) as temporary:
        scipy_io.savemat(str(temporary), content, appendmat=False, long_field_names=True, do_compression=True, oned_as="column")
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
