"""What users install: the wheel, in an environment without this repository."""

import os
import re
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest

import stickslip as ss

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "src" / "stickslip"


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    folder = tmp_path_factory.mktemp("dist")
    subprocess.run([sys.executable, "-m", "hatchling", "build", "-d", str(folder)], cwd=ROOT, check=True, capture_output=True)
    return {path.suffix: path for path in folder.iterdir()}


def output(command):
    return subprocess.run(list(map(str, command)), check=True, capture_output=True, text=True).stdout


def test_the_wheel_holds_the_package_and_its_licence(built):
    with zipfile.ZipFile(built[".whl"]) as archive:
        names = set(archive.namelist())
    sources = [path for path in PACKAGE.rglob("*") if path.is_file() and "__pycache__" not in path.parts]
    assert {path.relative_to(ROOT / "src").as_posix() for path in sources} <= names
    others = {name for name in names if not name.startswith("stickslip/")}
    assert all(name.startswith(f"stickslip-{ss.__version__}.dist-info/") for name in others), others
    assert any(name.endswith("licenses/LICENSE") for name in others)


def test_the_source_archive_holds_what_its_tests_need(built):
    with tarfile.open(built[".gz"]) as archive:
        names = {name.split("/")[1] for name in archive.getnames()}
    assert {"src", "tests", "docs", "examples", "verify", "tools", "Makefile", "CONTRIBUTING.md", "CITATION.cff"} <= names
    assert not any(name.endswith(".whl") for name in names)


def test_the_citation_names_this_version():
    citation = (ROOT / "CITATION.cff").read_text()
    assert re.search(r"^version: (.+)$", citation, re.MULTILINE).group(1) == ss.__version__
    assert f"## [{ss.__version__}]" in (ROOT / "CHANGELOG.md").read_text()


def test_the_conda_recipe_needs_what_the_package_needs():
    """The same versions of the same packages, which have another name there in one case; METIS is left to the user."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    own = {need.replace("matplotlib>", "matplotlib-base>") for need in project["project"]["dependencies"] if ";" not in need}
    recipe = (ROOT / "recipe" / "meta.yaml").read_text()
    run = recipe.partition("  run:\n")[2].partition("\n\n")[0]
    needs = {line.strip(" -").replace(" ", "") for line in run.splitlines()}
    assert needs == own | {f"python{project['project']['requires-python']}"}
    assert f'version = "{ss.__version__}"' in recipe


def test_the_release_tries_each_wheel_that_it_publishes():
    """Of every Python that the package names, on Linux, macOS and Windows, before anything is published."""
    release = (ROOT / ".github" / "workflows" / "release.yml").read_text()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    for version in re.findall(r"Python :: (3\.\d+)", " ".join(project["classifiers"])):
        assert f'"{version}"' in release
    assert "needs: [source, kernels]" in release.partition("publish:")[2]


@pytest.mark.slow
def test_the_demo_runs_from_the_wheel(built, tmp_path):
    """Dependencies are those of this environment. The folder of the package takes no kernels, as that of an administrator does
    not: they go into the user's folder of caches."""
    venv.create(tmp_path / "own", with_pip=True)
    python = tmp_path / "own" / "bin" / "python"
    output([python, "-m", "pip", "install", "--no-deps", "--no-index", "--no-compile", built[".whl"]])
    site = Path(output([python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"]).strip())
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib"))
    pycache = site / "stickslip" / "__pycache__"
    pycache.write_text("not a folder")
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("NUMBA", "PYTHON", "STICKSLIP"))}
    kept |= {"XDG_CACHE_HOME": str(tmp_path / "cache"), "OPENBLAS_NUM_THREADS": "1"}
    command = [python.with_name("stickslip"), "demo", "--fast", "--out", "demo", "--workers", "1"]
    found = subprocess.run(command, cwd=tmp_path, env=kept, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stderr
    assert "force 80" in found.stdout
    assert (tmp_path / "demo" / "report.html").is_file()
    assert list((tmp_path / "cache" / "stickslip").glob("kernels/*.kernel"))
