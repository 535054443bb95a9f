"""MATLAB files: version 4 to 7 (`matlab_5`), 7.3, which is HDF5 (`matlab_73`), and text of Octave (`octave_text`).

M, K, C dense or sparse, `dofs`, `nodes`.
"""

from __future__ import annotations

from pathlib import Path

from stickslip.model.readers.content import Content
from stickslip.model.readers.named_rows import from_tables
from stickslip.model.readers.process import arrays_of

HDF5 = b"\x89HDF\r\n\x1a\n"
OCTAVE = b"# Created by Octave"
NAMES = {
    "stickslip.model.readers.matlab_5": "MATLAB file",
    "stickslip.model.readers.matlab_73": "MATLAB 7.3 file",
    "stickslip.model.readers.octave_text": "text file of Octave",
}
"""What each module reads."""
USER_BLOCKS = (0, 512, 1024, 2048)
"""Bytes of the text that may stand before an HDF5 file."""


def read(path: Path) -> Content:
    """The numeric arrays of a MATLAB file, of whatever version; `dofs` and `nodes` may stand in its only struct that has them."""
    module = version_module(path)
    arrays = arrays_of(path, module)
    for name in ("dofs", "nodes"):
        inner = [key for key in arrays if key.endswith(f".{name}")]
        if name not in arrays and len(inner) == 1:
            arrays[name] = arrays.pop(inner[0])
    return from_tables(NAMES[module], arrays)


def version_module(path: Path) -> str:
    """The module whose `arrays` reads the version of a file."""
    with path.open("rb") as file:
        start = file.read(USER_BLOCKS[-1] + len(HDF5))
    if any(start[place : place + len(HDF5)] == HDF5 for place in USER_BLOCKS):
        return "stickslip.model.readers.matlab_73"
    return "stickslip.model.readers.octave_text" if start.startswith(OCTAVE) else "stickslip.model.readers.matlab_5"
