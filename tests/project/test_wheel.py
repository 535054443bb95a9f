"""A wheel brings compiled kernels: the first answer on a new machine compiles nothing."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from stickslip import forced_response
from stickslip.model.rigs import single_mass
from stickslip.support.kernels import cache

ROOT = Path(__file__).parents[2]

FIRST = """
import time
began = time.process_time()
import stickslip
from stickslip.support.compilation import NOTICE
response = stickslip.forced_response(stickslip.model.rigs.single_mass(), [0.16], 1.0, harmonics=3, samples=64)
print(stickslip.__file__, float(response.dataset.amplitude.values[0, 0, 0]), NOTICE.compiled, time.process_time() - began)
"""


@pytest.mark.slow
def test_a_wheel_answers_at_once_on_an_empty_machine(tmp_path):
    """Kernels for a common processor, taken where no others are; on another processor, as its name tells numba, all compile."""
    if not cache._takes_packed():
        pytest.skip("this processor is older than the common one, or tests stand for an older one")
    command = [sys.executable, "-m", "tools.wheel", str(tmp_path), "forced response"]
    built = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()[-1]
    assert Path(built).stat().st_size < 12e6
    with zipfile.ZipFile(built) as wheel:
        wheel.extractall(tmp_path / "installed")
    environment = {name: value for name, value in os.environ.items() if not name.startswith("NUMBA_")}
    environment |= {"PYTHONPATH": str(tmp_path / "installed"), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    ran = subprocess.run([sys.executable, "-P", "-c", FIRST], env=environment, capture_output=True, text=True, check=True)
    place, amplitude, compiled, seconds = ran.stdout.split()
    assert Path(place).is_relative_to(tmp_path)
    own = forced_response(single_mass(), [0.16], 1.0, harmonics=3, samples=64).dataset.amplitude.values[0, 0, 0]
    assert float(amplitude) == pytest.approx(own, rel=1e-9)
    assert int(compiled) == 0
    assert float(seconds) < 5.0
