"""Matrices of a study: read from .npz or .mat by the names M, K, C, converted to SI. No pickle, nothing that runs code."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy import io, sparse

from stickslip.checks import Array, Faults, InputError, fault, nearest
from stickslip.study.names import levers
from stickslip.study.units import Units

NAMES = ("M", "K", "C")
DAMAGED = (OSError, EOFError, ValueError, TypeError, KeyError, IndexError, zlib.error, zipfile.BadZipFile, io.matlab.MatReadError)
"""What NumPy and SciPy raise for files that are truncated or hold something else."""


def read_matrices(path: Path) -> dict[str, Array]:
    """M, K and, if the file has it, C, as real dense arrays in the units of the file."""
    if path.suffix.lower() not in READERS:
        raise fault("matrices", f"must be a file ending in {' or '.join(READERS)}", path.name)
    if not path.is_file():
        raise fault("matrices", "must name a file that exists", str(path), "The path counts from the study file's folder.")
    try:
        found = READERS[path.suffix.lower()](path)
    except InputError:
        raise
    except DAMAGED as error:
        raise fault("matrices", "must be a readable file", path.name, f"It is damaged, or no such file ({error}).") from None
    return picked(found, path.name)


def picked(found: Mapping[str, Any], file: str) -> dict[str, Array]:
    """M, K and C of what a file holds; all faults at once."""
    faults = [
        f"{file}: matrix {name} must be in the file, but is missing. {nearest(name, found)}"
        for name in ("M", "K")
        if name not in found
    ]
    matrices: dict[str, Array] = {}
    for name in (name for name in NAMES if name in found):
        try:
            matrices[name] = real(name, found[name])
        except InputError as error:
            faults.append(f"{file}: {error}")
    if faults:
        raise Faults(faults)
    return matrices


def real(name: str, value: Any) -> Array:
    """`value` as a real dense array."""
    array = np.asarray(value.toarray() if sparse.issparse(value) else value)  # type: ignore[attr-defined]
    if array.dtype.kind == "c" and not np.any(array.imag):
        array = array.real
    if array.dtype.kind not in "fiub":
        raise fault(name, "must hold real numbers", str(array.dtype), "Hysteretic damping in K? Give it as viscous C.")
    return np.asarray(array, dtype=float)


def _npz(path: Path) -> dict[str, Any]:
    with path.open("rb") as file:
        archive = np.load(file, allow_pickle=False)
        if not isinstance(archive, np.lib.npyio.NpzFile):
            raise fault("matrices", "must be a .npz archive", path.name, "Write it with numpy.savez(file, M=M, K=K).")
        return {name: archive[name] if name in NAMES else None for name in archive.files}


def _mat(path: Path) -> dict[str, Any]:
    try:
        content = io.loadmat(path)
    except NotImplementedError:
        raise fault(
            "matrices", "must be a MATLAB file up to version 7", path.name, "Save it with save(file, ..., '-v7')."
        ) from None
    return {name: value for name, value in content.items() if not name.startswith("__")}


READERS: dict[str, Callable[[Path], dict[str, Any]]] = {".npz": _npz, ".mat": _mat}


def matrices_in_si(matrices: Mapping[str, Array], dofs: Sequence[str], units: Units) -> dict[str, Array]:
    """The matrices in SI. Rows of rotations (rx, ry, rz, in rad) carry a length more than those of displacements."""
    force_per_length = units.newtons / units.metres
    factors = {"M": units.kilograms, "K": force_per_length, "C": force_per_length * units.seconds}
    lever = levers(dofs, units)
    return {name: factors[name] * lever[:, None] * matrix * lever for name, matrix in matrices.items()}
