"""Code that lies beside a model or a study is not run, whatever it is named, by no process of a command or of a script."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from importlib import metadata
from pathlib import Path
from urllib.request import urlopen

import pytest
from readers.conftest import Chain

from stickslip.runs import dask_cluster
from stickslip.runs.cases import _safe_paths

COMMAND = Path(sys.executable).with_name("stickslip")
NAMES = {
    *sys.stdlib_module_names,
    *(name for name in metadata.packages_distributions() if name.isidentifier()),
    *("stickslip", "sitecustomize", "usercustomize", "lazy_loader", "mkl_rt", "chain", "study"),
}
STUDY = """
[study]
analysis = "forced_response"
[structure]
model = "chain.mat"
keep = ["1"]
modes = 2
[[contact]]
law = "macroslip"
between = ["1.x", "ground"]
kt = 1e5
mu = 0.3
normal_load = 10.0
[[force]]
direction = "1.x"
amplitude = 1.0
[sweep]
frequency = [50.0, 60.0]
force_levels = [0.1, 0.2]
harmonics = 1
samples = 16
outputs = ["1.x"]
"""
SCRIPT = """
import stickslip as ss
import beside

if __name__ == "__main__":
    answer = ss.forced_response(ss.rigs.single_mass(), beside.BAND, [0.5, 1.0], harmonics=1, samples=16, workers=2)
    print(answer.dataset.sizes["case"], ss.read_model("chain.mat").size)
"""


class Folder:
    """A working folder that holds a module of every name, each of which leaves a mark when it is run."""

    def __init__(self, place):
        self.place, self.marks = place, place / "marks"
        place.mkdir()
        for name in NAMES:
            (place / f"{name}.py").write_text(f"open({str(self.marks)!r}, 'a').write(__name__ + '\\n')\n")
        (place / ".numba_config.yaml").write_text(f"chrome_trace: {self.marks}\n")  # numba would write a list of its work there
        (place / "matplotlibrc").write_text("backend: module://study\nfigure.facecolor: red\nanimation.ffmpeg_path: ./study.py\n")

    def run(self, *command, **environment):
        """What a command prints that is run here; nothing has been run from here."""
        ended = subprocess.run(
            [*map(str, command)], cwd=self.place, env=plain(**environment), capture_output=True, text=True, check=False
        )
        self.assert_unmarked()
        assert ended.returncode == 0, ended.stderr
        return ended.stdout

    def assert_unmarked(self):
        assert not self.marks.exists(), self.marks.read_text()[:200]


def plain(**more):
    """The environment without anything that says where modules are."""
    return {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "PYTHONSAFEPATH")} | more


@pytest.fixture
def folder(tmp_path):
    return Folder(tmp_path / "models")


def test_the_marks_are_left_by_what_is_run(folder):
    """As any Python process does that is started by `python -c`; from 3.13 on it imports linecache before it begins."""
    subprocess.run([sys.executable, "-c", "import numpy"], cwd=folder.place, env=plain(), capture_output=True, check=False)
    assert {"numpy", "linecache"} & set(folder.marks.read_text().split())


@pytest.mark.parametrize("kind", ["mat", "mat73"])
def test_reading_a_model_in_a_process(folder, kind):
    path = Chain().save(folder.place, kind)
    assert "6" in folder.run(COMMAND, "info", path.name)


@pytest.mark.slow
def test_a_study_on_a_model(folder):
    Chain().save(folder.place, "mat")
    (folder.place / "own.toml").write_text(STUDY)
    folder.run(COMMAND, "check", "own.toml")
    folder.run(COMMAND, "run", "own.toml", "--out", "out", "--workers", "2")
    folder.run(COMMAND, "run", "own.toml", "--out", "out", "--workers", "2", "--resume")
    folder.run(COMMAND, "export", "out", "--out", "curves.csv")


@pytest.mark.slow
@pytest.mark.skipif(not dask_cluster.installed(), reason='needs distributed: pip install "stickslip[dask]"')
def test_a_cluster_whose_processes_take_safe_paths(folder):
    """Dask starts its processes itself: PYTHONSAFEPATH, as the page on clusters says, keeps them and their nannies safe."""
    Chain().save(folder.place, "mat")
    (folder.place / "own.toml").write_text(STUDY)
    dask, safe = Path(sys.executable).with_name("dask"), plain(PYTHONSAFEPATH="1")
    quiet = {"cwd": folder.place, "env": safe, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    local = ("--host", "127.0.0.1", "--no-dashboard")
    processes = [subprocess.Popen([dask, "scheduler", "--port", "0", "--scheduler-file", "dask.json", *local], **quiet)]
    try:
        file = folder.place / "dask.json"
        ends = time.monotonic() + 120.0
        while not file.exists() or not file.read_text():
            assert time.monotonic() < ends
            time.sleep(0.1)
        address = json.loads(file.read_text())["address"]
        processes.append(subprocess.Popen([dask, "worker", address, "--nthreads", "1", *local], **quiet))
        folder.run(COMMAND, "run", "own.toml", "--out", "out", "--scheduler", address)
    finally:
        for process in reversed(processes):
            process.send_signal(signal.SIGINT)
            process.wait(timeout=60)
    folder.assert_unmarked()


@pytest.mark.slow
def test_the_explorer(folder):
    pytest.importorskip("dash")
    Chain().save(folder.place, "mat")
    (folder.place / "own.toml").write_text(STUDY)
    command = [COMMAND, "explore", "own.toml", "--no-browser"]
    process = subprocess.Popen(command, cwd=folder.place, env=plain(PYTHONUNBUFFERED="1"), stdout=subprocess.PIPE, text=True)
    try:
        address = process.stdout.readline().split()[-1]
        assert urlopen(address, timeout=60).status == 200
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=180)  # a kernel may be compiling
    folder.assert_unmarked()


@pytest.mark.slow
def test_a_script_in_another_folder(folder, tmp_path):
    """Its own folder stays importable, in its processes too."""
    scripts = tmp_path / "scripts"
    scripts.mkdir()
    (scripts / "work.py").write_text(SCRIPT)
    (scripts / "beside.py").write_text("BAND = [0.1, 0.3]\n")
    Chain().save(folder.place, "mat")
    assert folder.run(sys.executable, scripts / "work.py").split() == ["2", "6"]


SETTINGS = """
import stickslip, numba, matplotlib
from numba.core import config
numba.njit(lambda x: x)(1.0)
print(repr(config.CHROME_TRACE), *(matplotlib.rcParams[key] for key in ("figure.facecolor", "animation.ffmpeg_path")))
"""
NUMBA_FIRST = (
    "import numba.core.config as config; before = config.DISABLE_JIT; import stickslip; print(before, config.DISABLE_JIT)"
)


def test_libraries_take_no_settings_from_the_working_folder(folder):
    assert folder.run(sys.executable, "-P", "-c", SETTINGS) == "'' white ffmpeg\n"


def test_what_numba_read_for_a_script_before_is_dropped(tmp_path):
    pytest.importorskip("yaml")
    (tmp_path / ".numba_config.yaml").write_text("disable_jit: 1\n")
    command = [sys.executable, "-P", "-c", NUMBA_FIRST]
    assert subprocess.run(command, cwd=tmp_path, env=plain(), capture_output=True, text=True, check=True).stdout == "1 0\n"


@pytest.mark.slow
def test_figures_are_drawn_as_in_any_other_folder(folder, tmp_path):
    arguments = ("contact-stiffness", "--length", 27.6, "--radius", 5, "--load", 80, "--out")
    folder.run(COMMAND, *arguments, "here.svg")
    subprocess.run([COMMAND, *map(str, arguments), "there.svg"], cwd=tmp_path, env=plain(), capture_output=True, check=True)
    assert (folder.place / "here.svg").read_bytes() == (tmp_path / "there.svg").read_bytes()


@pytest.mark.parametrize("path", [":", "{elsewhere}:", ":{elsewhere}"])
def test_an_empty_entry_of_the_path_of_python_does_not_mean_the_working_folder(folder, tmp_path, path):
    """The interpreter itself imports `sitecustomize`, what that takes, and what a `.pth` file of an installed package names, as
    that of setuptools, before any code of the package."""
    for name in (*sys.stdlib_module_names, "sitecustomize", "usercustomize", "_distutils_hack", "lazy_loader", "stickslip"):
        (folder.place / f"{name}.py").unlink(missing_ok=True)
    file = Chain().save(folder.place, "mat")
    assert "6" in folder.run(COMMAND, "info", file.name, PYTHONPATH=path.format(elsewhere=tmp_path))


@pytest.mark.parametrize("before", [None, "", "yes"])
def test_the_environment_is_as_it_was_once_processes_have_started(monkeypatch, before):
    if before is None:
        monkeypatch.delenv("PYTHONSAFEPATH", raising=False)
    else:
        monkeypatch.setenv("PYTHONSAFEPATH", before)
    with suppress(KeyboardInterrupt), _safe_paths():
        assert os.environ["PYTHONSAFEPATH"] == "1"
        raise KeyboardInterrupt
    assert os.environ.get("PYTHONSAFEPATH") == before


def test_as_a_module_of_python(folder):
    """`python -m` puts the working folder on the path of its own process; it is not there once the command begins."""
    for name in NAMES - {"numpy", "scipy", "h5py", "xarray", "multiprocessing", "socket", "subprocess"}:
        (folder.place / f"{name}.py").unlink()
    path = Chain().save(folder.place, "mat73")
    assert "6" in folder.run(sys.executable, "-m", "stickslip", "info", path.name)
