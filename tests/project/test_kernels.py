"""Kernels are compiled once on a machine, and a warning says that it takes time."""

import os
import subprocess
import sys
from pathlib import Path

from stickslip import kernels

COMPILES = """
import numpy as np
from stickslip.solve.curve_points import moving_sizes
print(moving_sizes(np.ones((2, 3)), 1), moving_sizes(np.ones((3, 2)).T, 1))  # two layouts, compiled one after the other
"""


def test_the_first_process_says_that_it_compiles_and_the_next_one_has_no_need(tmp_path):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    first, second = (
        subprocess.run([sys.executable, "-c", COMPILES], env=environment, capture_output=True, text=True, check=True)
        for _ in range(2)
    )
    assert first.stdout == second.stdout
    assert first.stderr.count("stickslip compiles its kernels") == 1
    assert second.stderr == ""


def test_kernels_of_another_processor_stand_beside_those_of_this_one(tmp_path):
    """In one folder each processor has its own, and none takes those of the other: `make test-rounding` compiles for two."""
    own = {key: value for key, value in os.environ.items() if key != "NUMBA_CPU_NAME"} | {"NUMBA_CACHE_DIR": str(tmp_path)}
    other = own | {"NUMBA_CPU_NAME": "generic"}
    compiled = []
    for environment in (own, other, own, other):
        ended = subprocess.run([sys.executable, "-c", COMPILES], env=environment, capture_output=True, text=True, check=True)
        compiled.append("stickslip compiles its kernels" in ended.stderr)
    assert compiled == [True, True, False, False]


def test_a_change_of_any_kernel_compiles_anew():
    """The digest that names the cache covers every folder with kernels: numba does not notice a change in another file."""
    package = Path(kernels.__file__).parent
    folders = {path.parent.relative_to(package).as_posix() for path in package.rglob("*.py") if "\n@kernel" in path.read_text()}
    assert folders == set(kernels._FOLDERS)
