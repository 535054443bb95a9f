"""MATLAB files: version 5 to 7 (`matlab_5`) and 7.3, which is HDF5 (`matlab_73`). M, K, C dense or sparse, `dofs`, `nodes`."""

from __future__ import annotations

from pathlib import Path

from stickslip.models.content import Content
from stickslip.models.named_rows import from_tables
from stickslip.models.process import arrays_of

HDF5 = b"\x89HDF\r\n\x1a\n"
USER_BLOCKS = (0, 512, 1024, 2048)
"""Bytes of the text that may stand before an HDF5 file."""


def read(path: Path) -> Content:
    """The numeric arrays of a MATLAB file, of whatever version."""
    return from_tables("MATLAB 7.3 file" if _is_hdf5(path) else "MATLAB file", arrays_of(path, version_module(path)))


def version_module(path: Path) -> str:
    """The module whose `arrays` reads the version of a file."""
    return "stickslip.models.matlab_73" if _is_hdf5(path) else "stickslip.models.matlab_5"


def _is_hdf5(path: Path) -> bool:
    with path.open("rb") as file:
        start = file.read(USER_BLOCKS[-1] + len(HDF5))
    return any(start[place : place + len(HDF5)] == HDF5 for place in USER_BLOCKS)
