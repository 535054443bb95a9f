"""The folder of compiled kernels among the temporary ones is used only where it is the user's alone: what lies there is run."""

import os
import stat
import subprocess
import sys
import tempfile
import warnings
from contextlib import nullcontext
from pathlib import Path

import pytest

from stickslip.support.kernels import cache
from stickslip.support.kernels.cache import _folder, _temporary_folder, is_closed_to_others

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


OPEN = [(part, mode) for part in ("kernels", "stickslip", "cache", "above") for mode in (0o777, 0o757, 0o1777)]


@pytest.mark.parametrize("variable", ["NUMBA_CACHE_DIR", "XDG_CACHE_HOME"])
def test_a_folder_that_others_can_write_to_is_not_used_wherever_it_comes_from(own, monkeypatch, variable):
    """Nor one that others can exchange, because they can write to a folder above it; the sticky bit of that forbids it."""
    (own.parent / "package").write_text("")
    monkeypatch.setattr(cache, "_PACKAGE", own.parent / "package")
    for name in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv(variable, str(own.parent / "above" / "cache"))
    parts = {"above": own.parent / "above", "cache": own.parent / "above" / "cache"}
    parts["stickslip"] = parts["cache"] / "stickslip"
    parts["kernels"] = parts["stickslip"] if variable == "NUMBA_CACHE_DIR" else parts["stickslip"] / "kernels"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert _folder() == parts["kernels"]
    for part, mode in OPEN:
        before = stat.S_IMODE(parts[part].stat().st_mode)
        parts[part].chmod(mode)
        last = parts[part] == parts["kernels"]
        used = mode & stat.S_ISVTX and not last
        told = variable == "NUMBA_CACHE_DIR" and not used
        with pytest.warns(RuntimeWarning, match="only you can write to") if told else nullcontext():
            assert _folder() == (parts["kernels"] if used else own / "kernels"), (part, mode)
        parts[part].chmod(before)
    if os.geteuid() == 0:
        os.chown(parts["kernels"], 12345, -1)
        assert not is_closed_to_others(parts["kernels"])


def test_a_kernel_that_others_could_write_is_not_read(tmp_path):
    (tmp_path / "a.kernel").write_bytes(b"code")
    assert cache._read(tmp_path / "a.kernel") == b"code"
    (tmp_path / "a.kernel").chmod(0o666)
    assert cache._read(tmp_path / "a.kernel") == b""
    if os.geteuid() == 0:
        (tmp_path / "a.kernel").chmod(0o644)
        os.chown(tmp_path / "a.kernel", 12345, -1)
        assert cache._read(tmp_path / "a.kernel") == b""


def test_the_private_group_of_the_user_is_the_user(tmp_path):
    """Linux gives each user a group of the same name, and its members write to the folders of some systems."""
    tmp_path.chmod(0o775)
    grp, pwd = pytest.importorskip("grp"), pytest.importorskip("pwd")
    alone = grp.getgrgid(os.getegid()).gr_name == pwd.getpwuid(os.geteuid()).pw_name and not grp.getgrgid(os.getegid()).gr_mem
    assert cache._others_write(tmp_path.stat()) is not alone
    if os.geteuid() == 0:
        os.chown(tmp_path, -1, 12345)
        assert cache._others_write(tmp_path.stat())


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
