"""The folder of compiled kernels among the temporary ones is used only where it is the user's alone: what lies there is run."""

import os
import stat
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from stickslip.support.kernels.cache import _folder, _temporary_folder

pytestmark = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="folders have no such owners on Windows")


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """A folder of temporary files that all users share."""
    tmp_path.chmod(0o1777)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


@pytest.fixture
def own(temporary):
    """The name that every process of the user tries."""
    return temporary / f"stickslip-{os.geteuid()}"


def assert_passing(folder, own):
    assert folder.parent == own.parent
    assert folder != own
    assert stat.S_IMODE(folder.lstat().st_mode) == 0o700


def test_it_is_made_for_the_user_alone_and_found_again(own):
    assert _temporary_folder() == _temporary_folder() == own
    assert stat.S_IMODE(own.stat().st_mode) == 0o700


@pytest.mark.parametrize("mode", [0o770, 0o707, 0o777, 0o720, 0o702, 0o755])
def test_a_folder_open_to_others_is_refused(own, mode):
    own.mkdir()
    own.chmod(mode)
    assert_passing(_temporary_folder(), own)


def test_a_folder_of_another_user_is_refused(own):
    if os.geteuid():
        pytest.skip("only root can give a folder away")
    own.mkdir(mode=0o700)
    os.chown(own, 12345, -1)
    assert_passing(_temporary_folder(), own)


@pytest.mark.parametrize("target", ["elsewhere", "nowhere"])
def test_a_link_is_refused(own, target):
    (own.parent / "elsewhere").mkdir(mode=0o700)
    own.symlink_to(own.parent / target)
    assert_passing(_temporary_folder(), own)


def test_a_file_of_that_name_is_refused(own):
    own.write_text("")
    assert_passing(_temporary_folder(), own)


def test_a_place_where_others_can_exchange_it_is_refused(own):
    """Without the sticky bit whoever can write into a folder can move what is in it."""
    own.parent.chmod(0o777)
    assert_passing(_temporary_folder(), own)


def test_a_folder_of_one_process_ends_with_it(own):
    own.write_text("")
    script = "from stickslip.support.kernels.cache import _temporary_folder; print(_temporary_folder())"
    command, environment = [sys.executable, "-P", "-c", script], os.environ | {"TMPDIR": str(own.parent)}
    printed = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
    assert Path(printed.strip()).parent == own.parent
    assert not Path(printed.strip()).exists()


def test_kernels_of_a_user_without_a_home_go_there(own, monkeypatch):
    """Neither beside the package nor, as a relative path, into the working folder."""
    (own.parent / "package").write_text("")
    monkeypatch.setattr("stickslip.support.kernels.cache._PACKAGE", own.parent / "package")
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    (own.parent / "model").mkdir()
    monkeypatch.chdir(own.parent / "model")
    assert _folder() == own / "kernels"
    assert not Path("relative").exists()


def test_the_working_folder_is_not_used(own, monkeypatch):
    """Where nothing else can be written, temporary files go there, and what was unpacked there belongs to the user."""
    monkeypatch.chdir(own.parent)
    own.mkdir(mode=0o700)
    assert_passing(_temporary_folder(), own)


CHANGE_OF_FOLDER = """
import os, sys, numba
from stickslip.support.kernels.cache import FOLDER
os.chdir(sys.argv[1])
numba.njit(lambda x: x)(1.0)
import numpy as np
from stickslip.solve.continuation.curve_points import moving_sizes
moving_sizes(np.ones((2, 3)), 1)
print(any(FOLDER.glob("continuation.curve_points.moving_sizes-*")), os.listdir())
"""


def test_kernels_are_not_led_elsewhere_by_a_file_of_the_working_folder(tmp_path):
    """numba takes its settings from such a file whenever it compiles."""
    pytest.importorskip("yaml")
    (tmp_path / ".numba_config.yaml").write_text("cache_dir: elsewhere\n")
    command = [sys.executable, "-P", "-c", CHANGE_OF_FOLDER, str(tmp_path)]
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    printed = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
    assert printed == "True ['.numba_config.yaml']\n"
