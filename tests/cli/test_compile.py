"""The command `compile` leaves no kernel for later."""

import os
import signal
import subprocess
import sys
import time

import pytest

from stickslip.support import console

LEFT = """
import importlib, pkgutil, stickslip
from numba.core.dispatcher import Dispatcher
from stickslip.cli.compile_kernels import compile_all
from stickslip.support.kernels.cache import FOLDER
from stickslip.support.kernels.decorators import _SEPARATE

compile_all()
names = [each.name for each in pkgutil.walk_packages(stickslip.__path__, "stickslip.") if "__main__" not in each.name]
found = {each for name in names for each in vars(importlib.import_module(name)).values() if isinstance(each, Dispatcher)}
chosen = [each for each in found if "no_cpython_wrapper" not in each.targetoptions]
called = [each for each in chosen if each.targetoptions.get("inline") != "always"]
# Of kernels that others call alone, a process with a full cache reads none: what lies in the cache is compiled.
kept = {path.name.partition("-")[0] for path in FOLDER.glob("*.kernel")}
chosen = [each.dispatcher for made in _SEPARATE.values() for each in made]
called += [each for each in chosen if each.__module__.startswith("stickslip.")]
left = {".".join([*each.__module__.split(".")[-2:], each.__name__]) for each in called if not each.signatures}
print(len(called), *(name.rpartition(".")[2] for name in left - kept))
"""

ONLY_TESTS_CALL = {"_pulled", "add_product_sums", "add_run", "start_intercept"}


@pytest.mark.slow
def test_every_kernel_that_python_calls_is_compiled():
    ended = subprocess.run([sys.executable, "-c", LEFT], capture_output=True, text=True, check=True)
    count, *left = ended.stdout.splitlines()[-1].split()
    assert int(count) > 30
    assert set(left) <= ONLY_TESTS_CALL


@pytest.mark.slow
def test_termination_while_kernels_compile_ends_at_once(tmp_path):
    """Batch systems and containers wait for ten to thirty seconds before they kill."""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-m", "stickslip", "compile"]
    process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    time.sleep(6.0)
    process.send_signal(signal.SIGTERM)
    began = time.monotonic()
    _, errors = process.communicate(timeout=60)
    assert time.monotonic() - began < 9.0
    assert process.returncode == console.TERMINATED, errors
    assert errors.strip().endswith("Interrupted. All files written so far are complete.")
