"""The two codes under test as processes, pyHarm's environment, and the machine in words."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import venv
from pathlib import Path

from channel import Side

HERE = Path(__file__).parent
BUILD = HERE.parent / "build" / "bench"
PYHARM = BUILD / "pyharm"
ONE_THREAD = {
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "NUMBA_NUM_THREADS": "1",
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1",
}


def stickslip_side(cache: str | None = None, threads: int = 1) -> Side:
    """stickslip in the environment that runs the benchmark; its kernels are cached where it keeps them, or in a folder given."""
    several = {name: str(threads) for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")}
    environment = ONE_THREAD | several | ({"NUMBA_CACHE_DIR": str(BUILD / cache)} if cache else {})
    return Side("stickslip", [sys.executable, str(HERE / "stickslip_side.py")], environment, str(HERE))


def pyharm_side(cache: str = "numba-pyharm") -> Side:
    """pyHarm in its own environment, in double precision; its settings file stays in the build folder."""
    home = BUILD / "pyharm-home"
    home.mkdir(parents=True, exist_ok=True)
    environment = ONE_THREAD | {"NUMBA_CACHE_DIR": str(BUILD / cache), "HOME": str(home), "JAX_ENABLE_X64": "1"}
    return Side("pyHarm", [str(python_of(PYHARM)), str(HERE / "pyharm_side.py")], environment, str(home))


def python_of(folder: Path) -> Path:
    return folder / ("Scripts" if os.name == "nt" else "bin") / "python"


def install_pyharm() -> None:
    """Make pyHarm's environment once, from the package index."""
    stamp = PYHARM / ".installed"
    requirements = HERE / "requirements-pyharm.txt"
    if stamp.exists() and stamp.read_text() == requirements.read_text():
        return
    print("installing pyHarm into an environment of its own ...", flush=True)
    venv.create(PYHARM, with_pip=True, clear=True)
    command = [str(python_of(PYHARM)), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r", str(requirements)]
    subprocess.run(command, check=True, stderr=subprocess.DEVNULL)
    stamp.write_text(requirements.read_text())


def machine() -> dict[str, object]:
    """Processor, cores and system; nothing that names the machine."""
    return {"processor": _processor(), "cores": os.cpu_count(), "system": platform.system(), "architecture": platform.machine()}


def _processor() -> str:
    listing = Path("/proc/cpuinfo")
    if listing.exists():
        for line in listing.read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or "unknown"
