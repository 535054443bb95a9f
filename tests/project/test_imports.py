"""Imports go one way, and importing the package or asking for help costs next to nothing."""

import ast
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

import stickslip

ROOT = Path(stickslip.__file__).parent

# From the bottom up. A module imports from its own component and from the rows above its own; never sideways or downwards.
LAYERS = (
    ("checks", "machine", "outcome", "interrupts", "notebook_bar", "renamed"),
    ("compilation", "files"),
    ("kernels",),
    ("units",),
    ("structure", "contact", "loads"),
    ("dampers", "models", "interfaces"),
    ("problem",),
    ("disks",),
    ("harmonic", "rigs"),
    ("time",),
    ("platforms", "solve", "stability"),
    ("peaks",),
    ("curves", "starts"),
    ("measurement",),
    ("results", "runs"),
    ("analyses",),
    ("plots", "study"),
    ("report",),
    ("console",),
    ("explorer",),
    ("cli",),
)
SAYS_WHERE_TO_BEGIN = (
    *(
        "contact",
        "structure",
        "dampers",
        "interfaces",
        "problem",
        "disks",
        "harmonic",
        "time",
        "platforms",
        "solve",
        "stability",
        "peaks",
        "curves",
        "starts",
    ),
    *("measurement", "models", "results", "runs", "analyses"),
)
RANK = {component: rank for rank, row in enumerate(LAYERS) for component in row}
LOCAL_IMPORTS_ALLOWED = {"cli", "report", "plots", "rigs", "explorer"}
LOADED_LATE = {
    "rich",
    "IPython",
    "dash",
    "flask",
    "werkzeug",
    "scipy.stats",
    "importlib",
    "resource",
    "skfem",
    "xarray",
    "pandas",
    "h5netcdf",
    "h5py",
    "matplotlib",
    "plotly",
}

MODULES = sorted(path for path in ROOT.rglob("*.py") if path not in (ROOT / "__init__.py", ROOT / "__main__.py"))


def component_of(path: Path) -> str:
    return path.relative_to(ROOT).parts[0].removesuffix(".py")


def imported_components(tree: ast.AST) -> set[str]:
    """Components of stickslip that a module imports, wherever the import stands."""
    found: set[str] = set()
    for node in ast.walk(tree):
        match node:
            case ast.Import(names=names):
                found |= {name.name.split(".")[1] for name in names if name.name.startswith("stickslip.")}
            case ast.ImportFrom(module="stickslip", level=0, names=names):
                found |= {name.name for name in names if name.name in RANK}
            case ast.ImportFrom(module=str(module), level=0) if module.startswith("stickslip."):
                found.add(module.split(".")[1])
            case _:
                pass
    return found


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(ROOT)))
def test_imports_go_one_way(path):
    own = component_of(path)
    assert own in RANK, f"give {own!r} its place in LAYERS"
    for other in imported_components(ast.parse(path.read_text())):
        allowed = other == own or RANK[other] < RANK[own]
        assert allowed, f"{own} may not import {other}"


@pytest.mark.parametrize("room", sorted({path.parent for path in MODULES} - {ROOT}), ids=lambda room: str(room.relative_to(ROOT)))
def test_every_folder_says_what_lives_in_it_and_where_to_begin(room):
    """All but the outermost folders say what they may import and with which file to begin, too."""
    words = ast.get_docstring(ast.parse((room / "__init__.py").read_text())) or ""
    assert words, f"{room.name} says nothing"
    if room.relative_to(ROOT).as_posix() in SAYS_WHERE_TO_BEGIN:
        assert "Imports" in words
        assert "Begin with" in words
        for file in re.findall(r"`(\w+\.py)`", words):
            assert (room / file).is_file(), file


def packages(node: ast.Import | ast.ImportFrom) -> set[str]:
    """The packages that an import statement names; of stickslip and scipy, the component too."""
    names = [name.name for name in node.names]
    if isinstance(node, ast.ImportFrom):
        names = [f"scipy.{name}" for name in names] if node.module == "scipy" else [node.module or ""]
    return {".".join(name.split(".")[:2]) if name.startswith(("stickslip.", "scipy.")) else name.split(".")[0] for name in names}


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(ROOT)))
def test_no_import_is_relative_or_hides_in_a_function(path):
    """Only heavy packages are loaded late, and only the edge loads parts of stickslip late."""
    tree = ast.parse(path.read_text())
    assert not [node.lineno for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.level]
    if component_of(path) in LOCAL_IMPORTS_ALLOWED:
        return
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    imports = [inner for f in functions for inner in ast.walk(f) if isinstance(inner, ast.Import | ast.ImportFrom)]
    assert [node.lineno for node in imports if not packages(node) <= LOADED_LATE] == []


def test_only_the_explorer_imports_dash():
    found = {
        component_of(path)
        for path in MODULES
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Import | ast.ImportFrom) and packages(node) & {"dash", "flask", "werkzeug"}
    }
    assert found == {"explorer"}


HEAVY = [
    "matplotlib",
    "dash",
    "plotly",
    "xarray",
    "pandas",
    "skfem",
    "numba",
    "scipy.optimize",
    "scipy.sparse",
    "pydantic",
    "h5netcdf",
]

PROBE = """
import json, sys, time
{code}
print("\\n" + json.dumps([time.process_time(), sorted(set(sys.modules) & set({heavy}))]))
"""

HELP = """
from stickslip.cli import main
try:
    main(["--help"])
except SystemExit as end:
    assert not end.code
"""


@pytest.mark.parametrize("code", ["import stickslip", HELP], ids=["import", "help"])
def test_import_and_help_are_light(code):
    probe = PROBE.format(code=code, heavy=HEAVY)
    result = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    cpu_seconds, loaded = json.loads(result.stdout.strip().splitlines()[-1])
    assert loaded == []
    assert cpu_seconds < 1.0


SWEEP = """
import stickslip as ss

ss.forced_response(ss.rigs.single_mass(), ss.hertz(0.05, 0.3), harmonics=3)
"""


def test_a_sweep_loads_no_part_of_scipy_that_it_does_not_use():
    """`scipy.optimize` and `scipy.spatial` take 0.15 s; below the analyses they are loaded at their first use."""
    probe = PROBE.format(code=SWEEP, heavy=["scipy.optimize", "scipy.spatial", "numba"])
    result = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    assert json.loads(result.stdout.strip().splitlines()[-1])[1] == ["numba"]


@pytest.mark.parametrize("name", stickslip.__all__)
def test_every_public_name_exists(name):
    assert getattr(stickslip, name) is not None


def test_a_wrong_name_is_refused():
    with pytest.raises(AttributeError, match="no attribute 'forced_responce'"):
        stickslip.forced_responce  # noqa: B018
