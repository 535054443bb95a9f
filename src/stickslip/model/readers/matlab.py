"""MATLAB files: version 4 to 7 (`matlab_5`) and 7.3, which is HDF5 (`matlab_73`).

M, K, C dense or sparse, `dofs`, `nodes`.
"""

import json
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.model.readers.matlab_5 import OBJECT_NAMES
from stickslip.model.readers.model import Content
from stickslip.model.readers.named_rows import from_tables
from stickslip.model.readers.process import arrays_of
from stickslip.support.checks import InputError, fault

HDF5 = b"\x89HDF\r\n\x1a\n"
OCTAVE = b"# Created by Octave"
NAMES = {
    "stickslip.model.readers.matlab_5": "MATLAB file",
    "stickslip.model.readers.matlab_73": "MATLAB 7.3 file",
}
"""What each module reads."""
USER_BLOCKS = (0, 512, 1024, 2048)
"""Bytes of the text that may stand before an HDF5 file."""


def read(path: Path) -> Content:
    """The numeric arrays of a MATLAB file, of whatever version; `dofs` and `nodes` may stand in its only struct that has them."""
    module = _version_module(path)
    tables = arrays_of(path, module)
    objects = [str(name) for name in tables.pop(OBJECT_NAMES, ())]
    square = [value for value in tables.values() if np.ndim(value) == 2 and value.shape[0] == value.shape[1]]
    if objects and len(square) < len("MK"):
        remedy = "Save M and K as arrays: M = ...; K = ...; save('model.mat', 'M', 'K')."
        raise fault("A MATLAB file", "must hold arrays; objects are not read", ", ".join(objects), remedy)
    for name in ("dofs", "nodes"):
        inner = [key for key in tables if key.endswith(f".{name}")]
        if name not in tables and len(inner) == 1:
            tables[name] = tables.pop(inner[0])
    return from_tables(NAMES[module], tables)


def arrays(path: Path) -> dict[str, Any]:
    """The arrays of all files that the file at `path` lists in JSON, by number of the file and name: "0:hyst".

    `process` calls it for several files at once: to start a process for each takes longer than to read it.
    """
    numbered: dict[str, Any] = {}
    for number, name in enumerate(json.loads(path.read_text(encoding="utf-8"))):
        try:
            own = import_module(_version_module(Path(name))).arrays(Path(name))
        except InputError as error:
            raise InputError(f"{Path(name).name}: {error}") from None
        except Exception as error:  # the libraries raise whatever a damaged file leads them to
            raise fault(Path(name).name, "must be a sound MATLAB file", str(error)[:200] or type(error).__name__) from None
        if (objects := own.pop(OBJECT_NAMES, ())) and not own:
            remedy = "Save its numbers as arrays: save('test.mat', 'f', 'H')."
            raise fault(Path(name).name, "must hold arrays; objects are not read", ", ".join(objects), remedy)
        numbered |= {f"{number}:{key}": value for key, value in own.items()}
    return numbered


def _version_module(path: Path) -> str:
    """The module whose `arrays` reads the version of a file."""
    with path.open("rb") as file:
        start = file.read(USER_BLOCKS[-1] + len(HDF5))
    if any(start[offset : offset + len(HDF5)] == HDF5 for offset in USER_BLOCKS):
        return "stickslip.model.readers.matlab_73"
    if start.startswith(OCTAVE):
        raise InputError("A MATLAB file must be binary, but this is a text file of Octave. Save it again: save -v7 model.mat M K")
    return "stickslip.model.readers.matlab_5"
