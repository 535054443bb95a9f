"""Several MATLAB files of any version in one process: starting one for each file takes longer than reading it."""

from __future__ import annotations

import json
from importlib import import_module
from pathlib import Path
from typing import Any

from stickslip.model.readers.matlab import version_module
from stickslip.support.checks import InputError, fault


def arrays(path: Path) -> dict[str, Any]:
    """The arrays of all files that the file at `path` lists in JSON, by number of the file and name: "0:hyst"."""
    found: dict[str, Any] = {}
    for number, name in enumerate(json.loads(path.read_text(encoding="utf-8"))):
        try:
            own = import_module(version_module(Path(name))).arrays(Path(name))
        except InputError as error:
            raise InputError(f"{Path(name).name}: {error}") from None
        except Exception as error:  # the libraries raise whatever a damaged file leads them to
            raise fault(Path(name).name, "must be a sound MATLAB file", str(error)[:200] or type(error).__name__) from None
        found |= {f"{number}:{key}": value for key, value in own.items()}
    return found
