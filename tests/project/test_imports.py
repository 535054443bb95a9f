"""Imports go one way, and importing the package or asking for help costs next to nothing."""

import ast
import functools
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
    ("support/checks", "support/machine", "support/outcome", "support/interrupts", "support/late"),
    ("support/library_settings",),
    ("support/compilation", "support/files", "support/renderers", "support/units"),
    ("support/console", "support/kernels"),
    ("model/structure", "model/contact", "model/loads"),
    ("model/dampers", "model/readers", "model/interfaces"),
    ("model/problem",),
    ("model/disks",),
    ("solve/balance", "model/rigs"),
    ("solve/time",),
    ("solve/platforms", "solve/continuation", "solve/stability"),
    ("solve/peaks",),
    ("solve/curves", "solve/starts", "solve/wheels"),
    ("results", "runs"),
    ("analyses",),
    ("laboratory/measurement",),
    ("laboratory/identification",),
    ("study",),
    ("show/plots",),
    ("show/report",),
    ("show/explorer",),
    ("cli", "dampers", "rigs", "units"),
)
RANK = {component: rank for rank, row in enumerate(LAYERS) for component in row}
ROOMS = ("support", "model", "solve", "laboratory", "show")
"""Folders of components. Each stands above all of those before it."""

ONLY_A_DOCSTRING = {*ROOMS, "support/kernels", "study", "show/plots", "show/report", "show/explorer", "cli", "model/rigs"}
SAYS_WHERE_TO_BEGIN = {component for component in RANK if (ROOT / component).is_dir()} - ONLY_A_DOCSTRING
LOCAL_IMPORTS_ALLOWED = {"cli", "show/report", "show/plots", "model/rigs", "show/explorer"}
LOADED_LATE = {
    "rich",
    "IPython",
    "dash",
    "flask",
    "werkzeug",
    "scipy.stats",
    "importlib",
    "resource",
    "grp",
    "pwd",
    "h5netcdf",
    "xarray",
    "matplotlib",
    "plotly",
}

MODULE_IN_TEXT = re.compile(r"stickslip\.[.\w]+$")
"""A text that is the name of a module, or how an f-string that makes one begins."""

IMPORTS_BY_NAME = {
    "support/late.py": "a library, by the name that it gives",
    "model/readers/process.py": "the reader that another process is told to use",
    "show/plots/catalogue.py": "every module of its own folder",
    "support/renderers.py": "what the package, which stands above all, names",
    "show/report/markup.py": "every module of its own folder",
    "study/analysis.py": "every module of its own folder",
}
"""Modules that import by a name that is computed, and which one that is."""

MODULES = sorted(path for path in ROOT.rglob("*.py") if path not in (ROOT / "__init__.py", ROOT / "__main__.py"))


@functools.cache
def trees() -> dict[Path, ast.Module]:
    """The parsed modules."""
    return {path: ast.parse(path.read_text()) for path in MODULES}


@functools.cache
def nodes(tree: ast.AST) -> list[ast.AST]:
    """All nodes of a module, walked once."""
    return list(ast.walk(tree))


def component_of(path: Path) -> str:
    return component_named(".".join(("stickslip", *path.relative_to(ROOT).with_suffix("").parts)))


def component_named(module: str) -> str:
    """The component that a module, or a name of it, belongs to; a room for what stands in its `__init__.py`."""
    _, room, *rest = [*module.split("."), ""]
    return f"{room}/{rest[0]}" if room in ROOMS and rest[0] not in ("", "__init__") else room


def imported_components(tree: ast.AST) -> set[str]:
    """Components of stickslip that a module imports, wherever the import stands, or names in a text, by which it can import."""
    found: set[str] = set()
    for node in nodes(tree):
        match node:
            case ast.Import(names=names):
                found |= {name.name for name in names}
            case ast.ImportFrom(module=str(module), level=0, names=names):
                found |= {f"{module}.{name.name}" for name in names}
            case ast.Constant(value=str(text)) if MODULE_IN_TEXT.match(text):
                found.add(text)
            case _:
                pass
    return {component_named(name) for name in found if name.startswith("stickslip.")} & set(RANK)


def test_imports_go_one_way():
    without_place = {component_of(path) for path in MODULES} - set(RANK) - set(ROOMS)
    assert without_place == set(), "give these their place in LAYERS"
    wrong = [
        f"{path.relative_to(ROOT)} may not import {other}"
        for path, tree in trees().items()
        for other in imported_components(tree) - {component_of(path)}
        if RANK[other] >= RANK.get(component_of(path), -1)
    ]
    assert wrong == []


def called(call: ast.Call) -> str:
    """The last name of what is called."""
    return call.func.attr if isinstance(call.func, ast.Attribute) else call.func.id if isinstance(call.func, ast.Name) else ""


def imports_by_name(tree: ast.AST) -> list[ast.Call]:
    """Calls of `import_module` with a name that is not a text, nor a constant of the module."""
    constants = {
        target.id
        for node in nodes(tree)
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant)
        for target in node.targets
        if isinstance(target, ast.Name)
    }
    calls = [node for node in nodes(tree) if isinstance(node, ast.Call) and called(node).endswith("import_module")]
    names = {id(call): {n.id for n in ast.walk(call.args[0]) if isinstance(n, ast.Name)} for call in calls}
    return [call for call in calls if names[id(call)] - constants]


def test_what_is_imported_by_a_computed_name_is_known():
    found = {path.relative_to(ROOT).as_posix() for path, tree in trees().items() if imports_by_name(tree)}
    assert found == set(IMPORTS_BY_NAME)


def unsaid(room: Path) -> list[str]:
    """What the words of a folder lack: all but the outermost say what they may import and with which file to begin, too."""
    words = ast.get_docstring(ast.parse((room / "__init__.py").read_text())) or ""
    if room.relative_to(ROOT).as_posix() not in SAYS_WHERE_TO_BEGIN:
        return [] if words else ["a docstring"]
    files = [file for file in re.findall(r"`(\w+\.py)`", words) if not (room / file).is_file()]
    return [word for word in ("Imports", "Begin with") if word not in words] + files


def test_every_folder_says_what_lives_in_it_and_where_to_begin():
    rooms = sorted({path.parent for path in MODULES} - {ROOT})
    assert len(rooms) > len(SAYS_WHERE_TO_BEGIN)
    lacking = {room.relative_to(ROOT).as_posix(): unsaid(room) for room in rooms}
    assert {room: what for room, what in lacking.items() if what} == {}


def packages(node: ast.Import | ast.ImportFrom) -> set[str]:
    """The packages that an import statement names; of stickslip and scipy, the component too."""
    names = [name.name for name in node.names]
    if isinstance(node, ast.ImportFrom):
        names = [f"scipy.{name}" for name in names] if node.module == "scipy" else [node.module or ""]
    return {".".join(name.split(".")[:2]) if name.startswith(("stickslip.", "scipy.")) else name.split(".")[0] for name in names}


def hidden_imports(tree: ast.AST) -> list[ast.Import | ast.ImportFrom]:
    """Imports inside functions of what is not loaded late."""
    functions = [node for node in nodes(tree) if isinstance(node, ast.FunctionDef)]
    imports = [inner for f in functions for inner in ast.walk(f) if isinstance(inner, ast.Import | ast.ImportFrom)]
    return [node for node in imports if not packages(node) <= LOADED_LATE]


def test_no_import_is_relative_or_hides_in_a_function():
    """Only heavy packages are loaded late, and only the edge loads parts of stickslip late."""
    wrong = []
    for path, tree in trees().items():
        relative = [node for node in nodes(tree) if isinstance(node, ast.ImportFrom) and node.level]
        hidden = [] if component_of(path) in LOCAL_IMPORTS_ALLOWED else hidden_imports(tree)
        wrong += [f"{path.relative_to(ROOT)}:{node.lineno}: {ast.unparse(node)}" for node in relative + hidden]
    assert wrong == []


def test_libraries_that_take_long_are_imported_by_one_file():
    """`support/late.py` loads them at their first use; parts of them, by `from`, stand where they are used."""
    found = {
        path.relative_to(ROOT).as_posix()
        for path, tree in trees().items()
        for node in nodes(tree)
        if isinstance(node, ast.Import) and packages(node) & {"h5py", "pandas", "skfem", "xarray"}
    }
    assert found == {"support/late.py"}


def test_only_the_explorer_imports_dash():
    found = {
        component_of(path)
        for path, tree in trees().items()
        for node in nodes(tree)
        if isinstance(node, ast.Import | ast.ImportFrom) and packages(node) & {"dash", "flask", "werkzeug"}
    }
    assert found == {"show/explorer"}


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


def test_every_public_name_exists():
    assert [name for name in stickslip.__all__ if getattr(stickslip, name, None) is None] == []


def test_a_wrong_name_is_refused():
    with pytest.raises(AttributeError, match="no attribute 'forced_responce'"):
        stickslip.forced_responce  # noqa: B018
