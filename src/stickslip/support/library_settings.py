"""Keeps libraries from taking settings out of the working folder, which may be that of somebody's model.

numba reads `.numba_config.yaml` there, whose entries replace files and switch off compilation, and matplotlib `matplotlibrc`,
which names programs and modules to run. Neither has an option against it. The package imports this module before any of them.
"""

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from threading import RLock
from types import ModuleType
from typing import Any

_NUMBA = "numba.core.config"
FILES = {_NUMBA: ".numba_config.yaml", "matplotlib": "matplotlibrc"}
"""The module that reads settings when it is imported, and their file in the working folder."""

_IMPORTING = RLock()


class _Finder(MetaPathFinder):
    """Finds these modules where they are, and has them executed without sight of their files."""

    def find_spec(self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        if fullname not in FILES:
            return None
        spec = PathFinder.find_spec(fullname, path, target)
        if spec is not None and spec.loader is not None:
            execute = partial(_executed, spec.loader.exec_module)
            spec.loader.exec_module = execute  # type: ignore[method-assign]
        return spec


def _executed(execute: Any, module: ModuleType) -> None:
    with _unseen(FILES[module.__name__]):
        execute(module)
    if module.__name__ == _NUMBA:
        _read_no_more(module)


@contextmanager
def _unseen(file: str) -> Iterator[None]:
    """Both libraries ask whether the file is there before they read it."""
    with _IMPORTING:
        exists = os.path.exists
        os.path.exists = lambda path: path != file and exists(path)
        try:
            yield
        finally:
            os.path.exists = exists


def _read_no_more(config: Any) -> None:
    """numba would look for the file again whenever it compiles."""
    config._config_fname = os.fspath(Path(config.__file__).with_name(FILES[_NUMBA]))


def ignore_working_folder() -> None:
    """From now on; of a numba that a script has imported before, what it read from there is dropped."""
    if not any(isinstance(finder, _Finder) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Finder())
    config = sys.modules.get(_NUMBA)
    if config is not None:
        _read_no_more(config)
        config.reload_config()


def import_nothing_from_working_folder() -> None:
    """An empty entry of PYTHONPATH, as a colon at its end, stands for the working folder: neither this process nor those that it
    starts import from there."""
    entries = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    named = [entry for entry in entries if entry]
    if named == entries or not os.environ.get("PYTHONPATH"):
        return
    os.environ["PYTHONPATH"] = os.pathsep.join(named)
    here = os.getcwd()
    if here not in map(os.path.abspath, named):
        sys.path[:] = [entry for entry in sys.path if entry not in ("", here)]
