"""The tests with the rounding of other processors: `make test-rounding` all of them, `make ci` a part.

The last bits of a result depend on the processor: OpenBLAS, NumPy and the C library choose code by it, and numba compiles for it.
Each of them can be made to choose as an older processor would. What must not depend on rounding is tested so on any machine.
"""

from __future__ import annotations

import os
import platform
import signal
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__

ROOT = Path(__file__).parents[1]

NUMERICAL = (
    *("balance", "physics", "laws", "time_domain", "structure", "analyses", "disks", "robustness"),
    *("dampers", "measurement", "rigs", "stability", "interfaces", "identification"),
)
PART = ("balance", "physics", "structure", "analyses/performance/test_following.py")
"""Where rounding decided in the past; a few minutes for two processors."""

BEYOND_AVX2 = [name for name in __cpu_dispatch__ if __cpu_features__[name] and ("AVX512" in name or name == "X86_V4")]
BEYOND_SSE = [name for name in __cpu_dispatch__ if __cpu_features__[name]]
NO_FMA = {
    "NPY_DISABLE_CPU_FEATURES": " ".join(BEYOND_SSE),
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F,-AVX512VL,-AVX512BW,-AVX512DQ",
}
PROCESSORS = {
    "SkylakeX": {},
    "Haswell": {"NPY_DISABLE_CPU_FEATURES": " ".join(BEYOND_AVX2)},
    "Sandybridge": NO_FMA,
    "Nehalem": NO_FMA,
    "Prescott": NO_FMA | {"NUMBA_CPU_NAME": "generic"},
}
"""The kernels that OpenBLAS has in the packages of NumPy and SciPy, newest first, and what else changes with them.

Haswell are those of AMD's Zen too.
"""

LOADED = """
import numpy, scipy.linalg, threadpoolctl
matrix = numpy.cos(numpy.arange(10_000.0)).reshape(100, 100)
scipy.linalg.eigh(matrix @ matrix.T)
print(sorted({library["architecture"] for library in threadpoolctl.threadpool_info() if library["internal_api"] == "openblas"}))
"""


def environment(name: str) -> dict[str, str]:
    """The environment in which a process rounds as that processor does."""
    return {**os.environ, "OPENBLAS_CORETYPE": name, **PROCESSORS[name]}


def kernels(environment: dict[str, str]) -> str | None:
    """The kernels that OpenBLAS takes in an environment, as it names them; None where this processor lacks their instructions.

    OpenBLAS takes the kernels it is told to without asking the processor: they end in an illegal instruction.
    """
    ran = subprocess.run([sys.executable, "-c", LOADED], env=environment, capture_output=True, text=True, check=False)
    if ran.returncode == -signal.SIGILL:
        return None
    ran.check_returncode()
    return ran.stdout


def other_processors() -> list[str]:
    """Those whose rounding this machine can have and does not have by itself, newest first."""
    if platform.machine() not in ("x86_64", "AMD64"):
        return []
    own = kernels({key: value for key, value in os.environ.items() if key != "OPENBLAS_CORETYPE"})
    return [name for name in PROCESSORS if kernels(environment(name)) not in (own, None)]


def passes(name: str, tests: Iterable[str], options: list[str]) -> bool:
    """Run tests with the rounding of a processor; whether they pass."""
    sys.stdout.write(f"\nWith the rounding of {name}: OPENBLAS_CORETYPE={name}")
    sys.stdout.write("".join(f" {key}='{value}'" for key, value in PROCESSORS[name].items()) + "\n")
    sys.stdout.flush()
    command = [sys.executable, "-m", "pytest", *options, *(f"tests/{each}" for each in tests)]
    return subprocess.run(command, cwd=ROOT, env=environment(name), check=False).returncode == 0


def shows(name: str) -> bool:
    """Whether the demonstration ends well with the rounding of a processor."""
    command = [sys.executable, "-m", "stickslip", "demo", "--overwrite", "--out", f"build/rounding/{name}"]
    return subprocess.run(command, cwd=ROOT, env=environment(name), check=False).returncode == 0


def main(which: str, options: list[str]) -> int:
    others = other_processors()
    if not others:
        sys.stdout.write("No other processor's rounding can be had on this machine: that needs x86-64 and OpenBLAS.\n")
        return 0
    ends = {others[0], others[-1]}
    if which == "part":
        failed = [name for name in others if name in ends and not passes(name, PART, options)]
    else:
        failed = [name for name in others if not (shows(name) and passes(name, [""] if name in ends else NUMERICAL, options))]
    sys.stdout.write(f"\nRounding of {', '.join(others)} at hand; failed with that of: {', '.join(failed) or 'none'}.\n")
    return bool(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
