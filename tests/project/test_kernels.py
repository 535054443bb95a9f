"""Kernels are compiled once on a machine, and nobody waits for that without being told."""

import os
import subprocess
import sys

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
