"""Kernels are compiled once on a machine, and a warning says that it takes time; what they pass on by address is safe."""

import os
import re
import subprocess
import sys
from copy import deepcopy
from hashlib import sha256
from pathlib import Path
from types import SimpleNamespace
from typing import NamedTuple

import numba
import numpy as np
import pytest

import stickslip
from stickslip import forced_response, nonlinear_modes, radians_per_second
from stickslip.model.readers.reduction import to_cache
from stickslip.model.rigs import single_mass
from stickslip.solve.balance.balance import HarmonicBalance, Point
from stickslip.support.files import only_own_files, write_arrays
from stickslip.support.kernels import cache, compiled, kernel, separate
from stickslip.support.kernels.cache import FOLDERS
from stickslip.support.kernels.decorators import hold, number_of, numbered
from stickslip.support.kernels.results import Boxed
from stickslip.support.kernels.views import view, view_of

COMPILES = """
import numpy as np
from stickslip.solve.continuation.curve_points import moving_sizes
print(moving_sizes(np.ones((2, 3)), 1), moving_sizes(np.ones((3, 2)).T, 1))  # two layouts, compiled one after the other
"""


def ended(folder):
    """A process that calls a kernel of two layouts, with its kernels in a folder."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder)}
    return subprocess.run([sys.executable, "-c", COMPILES], env=environment, capture_output=True, text=True, check=True)


def test_the_first_process_says_that_it_compiles_and_the_next_one_has_no_need(tmp_path):
    """Nor has one that finds the kernels that another holds but not that itself, or whose disk was full when they were kept."""
    first, second = ended(tmp_path), ended(tmp_path)
    assert first.stderr.count("stickslip compiles its kernels") == 1
    assert second.stderr == ""
    outer, *_ = (tmp_path / "stickslip").glob("continuation.curve_points.moving_sizes-*")
    outer.unlink()
    third = ended(tmp_path)
    for path in (tmp_path / "stickslip").iterdir():
        content = path.read_bytes()
        path.write_bytes(content[: len(content) // 2] + bytes(len(content) - len(content) // 2))
    damaged, mended = ended(tmp_path), ended(tmp_path)
    for path in (tmp_path / "stickslip").iterdir():
        content = b"cstickslip.model.gone\nTable\n."  # a kernel of an older version, one of whose types has moved
        path.write_bytes(sha256(content).digest() + content)
    moved = ended(tmp_path)
    assert [each.stderr.count("stickslip compiles its kernels") for each in (third, damaged, mended, moved)] == [1, 1, 0, 1]
    assert {each.stdout for each in (second, third, damaged, mended, moved)} == {first.stdout}


@pytest.mark.slow
def test_kernels_of_another_processor_stand_beside_those_of_this_one(tmp_path):
    """In one folder each processor has its own, and none takes those of the other: `make test-rounding` compiles for two."""
    own = {key: value for key, value in os.environ.items() if key != "NUMBA_CPU_NAME"} | {"NUMBA_CACHE_DIR": str(tmp_path)}
    other = own | {"NUMBA_CPU_NAME": "generic"}
    compiled = []
    for environment in (own, other, own, other):
        ended = subprocess.run([sys.executable, "-c", COMPILES], env=environment, capture_output=True, text=True, check=True)
        compiled.append("stickslip compiles its kernels" in ended.stderr)
    assert compiled == [True, True, False, False]


def test_a_change_of_any_kernel_compiles_anew():
    """Digests cover every folder with kernels, and the constants that kernels take come from there too."""
    package = Path(stickslip.__file__).parent
    made = re.compile(r"^@(kernel|inner|inlined|separate)\b", re.MULTILINE)
    folders = {path.parent.relative_to(package).as_posix() for path in package.rglob("*.py") if made.search(path.read_text())}
    assert folders == set(FOLDERS)
    for folder in FOLDERS:
        for source in [text for path in (package / folder).glob("*.py") if made.search(text := path.read_text())]:
            for module, names in re.findall(r"^from stickslip\.([\w.]+) import (\([^)]*\)|.*)$", source, re.MULTILINE):
                if module.rpartition(".")[0].replace(".", "/") not in FOLDERS:
                    assert not re.search(r"\b[A-Z][A-Z_]+\b", names), f"a constant of {module}"


def changed_by(monkeypatch, module, old, new):
    """Modules whose kernels compile anew after a change of one file."""
    before, files = digests(), cache._files()
    assert old in files[module]
    monkeypatch.setattr(cache, "_files", lambda: files | {module: files[module].replace(old, new)})
    forget()
    after = digests()
    monkeypatch.undo()
    forget()
    return {name for name in before if before[name] != after[name]}


def forget():
    cache.digest_of.cache_clear()
    cache.needs.cache_clear()


def digests():
    package = Path(stickslip.__file__).parent
    paths = {module: package.parent / f"{module.replace('.', '/')}.py" for module in cache._files()}
    return {module.removeprefix("stickslip."): cache.digest_of(path) for module, path in paths.items()}


def test_a_change_compiles_what_holds_it_and_nothing_else(monkeypatch):
    """Laws are called through an address, and so are contact forces and the parts of an iteration by Newton's method."""
    assert changed_by(monkeypatch, "stickslip.model.contact.cubic", "def step(", "def step (") == {"model.contact.cubic"}
    dahl = changed_by(monkeypatch, "stickslip.model.contact.dahl", "def dahl_step(", "def dahl_step (")
    assert "model.contact.valanis" in dahl
    assert all(name.startswith("model.contact.") for name in dahl)
    forces = changed_by(monkeypatch, "stickslip.solve.balance.contact_forces", "def contact_forces(", "def contact_forces (")
    assert forces == {"solve.balance.contact_forces", "solve.balance.energy"}
    newton = changed_by(monkeypatch, "stickslip.solve.continuation.newton", "halvings + 1", "halvings + 2")
    # A file with a NamedTuple, which may be a type of kernels, counts as one that holds types and constants.
    assert newton == {"solve.continuation.newton", "solve.continuation.steps", "solve.continuation.truncation"}
    types = changed_by(monkeypatch, "stickslip.solve.balance.system", "class State", "class  State")
    assert {"solve.balance.system", "solve.balance.iteration", "solve.continuation.newton"} <= types
    constant = changed_by(monkeypatch, "stickslip.model.contact.law", "SLIDERS", "SLIDERS ")
    assert "solve.balance.contact_forces" in constant
    maker = changed_by(monkeypatch, "stickslip.support.kernels.arrays", "def ", "def  ")
    assert "solve.continuation.newton" in maker


def times(factor):
    @kernel
    def product(value):
        return factor * value

    return product


def test_kernels_that_differ_in_what_they_hold_are_not_taken_for_one_another():
    """Both have the same file, name, code and types."""
    assert times(2.0)(3.0) == 6.0
    assert times(5.0)(3.0) == 15.0
    assert times(2.0)(3.0) == 6.0


class Inner(NamedTuple):
    factor: float
    values: np.ndarray


class Outer(NamedTuple):
    count: int
    inner: Inner


EXAMPLE = Outer(2, Inner(3.0, np.array([1.0, 10.0])))


def weighted_signature():
    return numba.float64(view_of(EXAMPLE), numba.float64)


@separate(weighted_signature)
def weighted(outer, more):
    return outer.count * outer.inner.factor * outer.inner.values[1] + more


@separate(weighted_signature)
def never_compiled(outer, more):
    return more


@numba.njit
def called(outer, more):
    return weighted(view(outer), more)


@numba.njit
def called_before_it_is_compiled(outer, more):
    return never_compiled(view(outer), more)


@numba.njit
def called_with_other_types(outer):
    return weighted(view(outer), "more")


def test_a_kernel_compiled_by_itself_sees_the_tuple_of_its_caller():
    compiled(weighted)
    assert called(EXAMPLE, 0.5) == 2 * 3.0 * 10.0 + 0.5
    assert called(Outer(1, Inner(1.0, np.array([0.0, 7.0]))), 0.0) == 7.0


def test_a_kernel_that_is_not_compiled_or_called_with_other_types_says_so():
    with pytest.raises(RuntimeError, match="never_compiled is not compiled"):
        called_before_it_is_compiled(EXAMPLE, 0.5)
    with pytest.raises(numba.TypingError, match="weighted takes"):
        called_with_other_types(EXAMPLE)


def scaled_signature():
    return numba.float64(numba.float64)


@separate(scaled_signature)
def doubled(value):
    return 2.0 * value


@separate(scaled_signature)
def tripled(value):
    return 3.0 * value


@numbered(scaled_signature)
def scaled(number, value):
    raise NotImplementedError


@numba.njit
def by_number(number, value):
    return scaled(number, value)


def test_a_kernel_is_called_by_its_number():
    """Which one a number stands for may be said after its caller was compiled; a number stands for one kernel alone."""
    with pytest.raises(RuntimeError, match="scaled is not compiled"):
        by_number(number_of(doubled), 5.0)
    for each, expected in ((doubled, 10.0), (tripled, 15.0)):
        hold(scaled, number_of(each), each)
        assert by_number(number_of(each), 5.0) == expected
    with pytest.raises(RuntimeError, match=r"has the number \d+ of another kernel"):
        hold(scaled, number_of(doubled), tripled)


def python_would_run(kind):
    """Whether numba runs Python code to make an object of a type."""
    if isinstance(kind, numba.types.BaseTuple):
        return isinstance(kind, numba.types.BaseNamedTuple) or any(python_would_run(each) for each in kind)
    return isinstance(kind, numba.types.Array)


def test_results_for_python_are_boxed():
    """Ctrl-C would end the process where numba makes the result; this reads the types of all kernels compiled so far."""
    response = forced_response(single_mass(), radians_per_second(0.8, 1.6), 1.0, harmonics=3)
    response.with_stability()
    response.verify_in_time(0, 0, steps_per_period=64)
    nonlinear_modes(single_mass(), amplitude=(0.5, 2.0), harmonics=3)
    seen = 0
    for module in [module for name, module in sys.modules.items() if name.startswith("stickslip.")]:
        for name, found in vars(module).items():
            if isinstance(found, numba.core.dispatcher.Dispatcher) and not found.targetoptions.get("no_cpython_wrapper"):
                for signature in found.nopython_signatures:
                    assert not python_would_run(signature.return_type), f"{module.__name__}.{name}: return boxed(...)"
                    seen += isinstance(signature.return_type, Boxed)
    assert seen > 5


def arrays_in(value):
    if isinstance(value, np.ndarray):
        yield value
    for each in value if isinstance(value, tuple) else ():
        yield from arrays_in(each)


def test_results_own_what_they_hold():
    """Arrays read through a view belong to the caller's tuple, and nothing keeps them alive; a result must hold none of them."""
    balance = HarmonicBalance(single_mass(), 3, 64)
    found = list(arrays_in(balance.evaluate(Point(np.zeros((1, 7)), 1.1, 1.0)).state))
    assert len(found) > 3
    assert all(array.flags.owndata or array.base is not None for array in found)


def test_a_balance_that_travels_lies_at_an_address_of_its_own():
    """As to another process: the address of the first would lead nowhere."""
    balance = HarmonicBalance(single_mass(), 3, 64)
    before = balance.evaluate(balance.stuck_point(1.0, 0.5))
    copied = deepcopy(balance)
    assert copied.placed_system != balance.placed_system
    np.testing.assert_array_equal(copied.evaluate(copied.stuck_point(1.0, 0.5)).w, before.w)
    held = balance.with_starts(balance.table.start_value)
    assert held.placed_system != balance.placed_system


def test_what_another_process_has_kept_first_is_replaced_by_a_command_too(tmp_path, monkeypatch):
    """A command replaces only files on its list; of two that compiled the same kernel at once the slower one was refused."""
    found = tmp_path / "reduced.npz"
    write_arrays(found, {"K": np.eye(2)})
    with only_own_files():
        to_cache(found, {"K": 2.0 * np.eye(2)})
    assert np.load(found)["K"][0, 0] == 2.0
    overload = numba.njit(lambda x: x + 1.0)
    overload(1.0)
    ((signature, compiled_once),) = overload.overloads.items()
    monkeypatch.setattr(cache, "FOLDER", tmp_path)
    kept = cache.KernelCache(number_of)
    path = tmp_path / kept._file(signature, compiled_once.library.codegen.magic_tuple())
    path.write_bytes(b"of another process")
    library = SimpleNamespace(has_dynamic_globals=False)
    data = SimpleNamespace(library=library, codegen=compiled_once.library.codegen, _reduce=lambda: 1)
    with only_own_files():
        kept.save_overload(signature, data)
    assert path.read_bytes() != b"of another process"
