"""Readers of other packages in a process of their own: their compiled code can end a process on a damaged file.

`python -m stickslip.model.readers.process MODULE SOURCE TARGET` calls `arrays(path)` of a reader's module on the file SOURCE and
writes what it returns to the NumPy archive TARGET. Its folder may be that of the model: `-P` keeps it off the import path.
"""

import os
import subprocess
import sys
import tempfile
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from stickslip.model.readers import numpy_archive
from stickslip.model.readers.numbers import compressed_columns, memory
from stickslip.support.checks import InputError, fault

WRONG = 2
"""Exit code of the process that reads, when the file is at fault."""
SECONDS, BYTES_PER_SECOND = 60.0, 1e6
PARTS = ("data", "indices", "indptr", "shape")
OWN_MEMORY = 1 << 30
"""Address space of the process before it reads, bytes."""


def arrays_of(path: Path, reader: str) -> dict[str, Any]:
    """Arrays and sparse matrices by name, as `arrays(path)` of the module `reader` returns them."""
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "arrays.npz"
        command = [sys.executable, "-P", "-m", __name__, reader, os.fspath(path.absolute()), os.fspath(target)]
        limit = SECONDS + path.stat().st_size / BYTES_PER_SECOND
        threads = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
        try:
            ended = subprocess.run(
                command, capture_output=True, text=True, errors="replace", timeout=limit, check=False, env=threads
            )
        except subprocess.TimeoutExpired:
            remedy = "The file is damaged, or the machine is busy: try again when it is not."
            raise fault("Reading", f"must end within {limit:.0f} s", "still going on", remedy) from None
        if ended.returncode == WRONG:
            raise InputError(ended.stderr.strip()[:500])
        if not target.is_file():
            raise fault("The file", "must be sound", f"damaged (its reader ended with {ended.returncode})")
        members = numpy_archive.arrays(target)
    # Sparse matrices out of their parts NAME/data, NAME/indices, ..., which are not believed; everything else as it is.
    arrays = {name: value for name, value in members.items() if "/" not in name}
    for name in {name.partition("/")[0] for name in members if "/" in name}:
        data, indices, starts, shape = (members[f"{name}/{part}"] for part in PARTS)
        arrays[name] = compressed_columns(name, data, indices, starts, (int(shape[0]), int(shape[1])))
        if not arrays[name].has_canonical_format:
            raise fault(name, "must hold each entry once, and those of a column by rising rows", "otherwise")
    return arrays


def _limit_memory() -> None:
    """Let an allocation beyond half of the machine's memory fail, where the system can."""
    try:
        import resource
    except ImportError:
        return
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    limit = memory() + OWN_MEMORY
    with suppress(ValueError, OSError):  # a system may know the limit and not take it
        resource.setrlimit(resource.RLIMIT_AS, (limit if hard == resource.RLIM_INFINITY else min(limit, hard), hard))


def main(reader: str, source: str, target: str) -> int:
    """Read `source` and write its arrays to `target`; returns the exit code."""
    _limit_memory()
    try:
        members: dict[str, Any] = {}
        for name, value in import_module(reader).arrays(Path(source)).items():
            if sparse.issparse(value):
                matrix = sparse.csc_array(value)  # type: ignore[call-overload]
                members |= {f"{name}/{part}": np.asarray(getattr(matrix, part)) for part in PARTS}
            else:
                members[name] = np.array(value, dtype=np.str_) if isinstance(value, list) else value
        np.savez(target, **members)
    except InputError as error:
        sys.stderr.write(str(error))
        return WRONG
    except MemoryError:
        sys.stderr.write(f"The file must fit into {memory() / 2**30:.1f} GiB, half of the memory, but is larger.")
        return WRONG
    except Exception as error:  # the libraries raise whatever a damaged file leads them to
        sys.stderr.write(f"The file is damaged ({str(error)[:200] or type(error).__name__}).")
        return WRONG
    return 0


if __name__ == "__main__":
    code = main(*sys.argv[1:])
    sys.stderr.flush()
    os._exit(code)  # without the clean-up in which a library may fail
