"""Build a wheel that carries compiled kernels: python -m tools.wheel [FOLDER [CASE ...]], `make wheel`.

The kernels are those for a common processor (`COMMON` of `support/kernels/cache.py`), of this system, this version of Python and
of numba; elsewhere they are not taken, and kernels compile at their first use. CASE: only the kernels of these cases of
`stickslip compile`.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from stickslip.support.kernels.cache import COMMON
from tools.wheel_hook import FOLDER

ROOT = Path(__file__).parents[1]

COMPILE = """
import sys
from stickslip.cli.compile_kernels import compile_all, small_cases
cases = small_cases()
[cases[name]() for name in sys.argv[1:]] if sys.argv[1:] else compile_all()
"""


def build(folder: Path, cases: list[str]) -> Path:
    """The wheel, in the folder."""
    with tempfile.TemporaryDirectory() as kept:
        common = {"NUMBA_CPU_NAME": COMMON, "NUMBA_CPU_FEATURES": "", "NUMBA_CACHE_DIR": kept}
        subprocess.run([sys.executable, "-c", COMPILE, *cases], env=os.environ | common, cwd=ROOT, check=True)
        command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder.absolute())]
        subprocess.run(command, env=os.environ | {FOLDER: str(Path(kept, "stickslip"))}, cwd=ROOT, check=True)
    return max(folder.glob("stickslip-*.whl"), key=lambda path: path.stat().st_mtime)


if __name__ == "__main__":
    sys.stdout.write(f"{build(Path(sys.argv[1] if len(sys.argv) > 1 else 'dist'), sys.argv[2:])}\n")
