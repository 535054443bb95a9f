"""Where compiled kernels are kept on disk, and those that came with the package.

Each compiled kernel is one file, whose name holds the digest of all sources that it depends on (`sources`), the types that it
takes, the processor and the version of numba: a change anywhere compiles what depends on it, and nothing else; an old result is
never used with new code; processes that compile at the same time do not disturb one another.

A wheel carries kernels compiled for a common processor, `COMMON`. They serve where nothing was compiled on the machine itself.

What is found is unpickled, and so run: a folder that others can write to is not used, wherever it comes from.

What a compiled kernel depends on: a digest of its file and of all files whose kernels and types it holds.

numba compiles a kernel with the kernels that it calls, and does not notice when one of these, in another file, has changed. Here
the imports of each file are followed, as far as kernels, types and constants go into other kernels. A kernel that is compiled by
itself (`separate`) does not: it is called through an address.
"""

import atexit
import hashlib
import os
import pickle
import platform
import re
import shutil
import stat
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import cache, partial
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm  # type: ignore[import-untyped]
import numba
from numba.core import caching, event, serialize
from numba.core.compiler import CompileResult
from numba.core.runtime.nrt import rtsys

from stickslip.support.compilation import NOTICE
from stickslip.support.files import only_own_files, replacing

FOLDERS = (
    *("model/contact", "solve/balance", "solve/continuation", "solve/platforms", "solve/stability", "solve/time"),
    "support/kernels",
)
"""Those with kernels."""

_TAKES_PART = re.compile(r"^@(kernel|inner|inlined|separate|numbered|overload)\b|\(NamedTuple\)", re.MULTILINE)
"""In a file with kernels, or with named tuples, which are the types that kernels take."""

_SEPARATE = re.compile(r"^@(?:separate|numbered)\(.*\)\ndef (\w+)", re.MULTILINE)
_PLAIN = re.compile(r"(?<=\n\n)(?:@singledispatch\n)?def (\w+)")
_OVERLOADED = re.compile(r"^@overload\((\w+)", re.MULTILINE)
_IMPORT = re.compile(r"^ *from (stickslip[\w.]*) import (\([^)]*\)|[^\n(]*)", re.MULTILINE)
_NAME = re.compile(r"(\w+)(?: as \w+)?")


@cache
def digest_of(path: Path) -> str:
    """Digest of what a kernel of this file depends on; of a file outside the package, on all, and on where it lies: a file of the
    same text elsewhere may import others. What such a file imports beside the package is not followed."""
    files = _files()
    own = _module(path) if path.is_relative_to(_PACKAGE) else None
    needed, left = set(files if own is None else ()), [own] if own else []
    while left:
        module = left.pop()
        if module not in needed:
            needed.add(module)
            left += needs(module)
    digest = hashlib.sha256(_makers() + (str(path.absolute()).encode() + path.read_bytes() if own is None else b""))
    for module in sorted(needed):
        digest.update(module.encode() + files[module].encode())
    return digest.hexdigest()


@cache
def needs(module: str) -> list[str]:
    """The files of which a file's kernels hold kernels, types or constants."""
    files = _files()
    text = files[module]
    if not _TAKES_PART.search(text):
        return []
    held: dict[str, list[str]] = {}
    for source, names in _IMPORT.findall(text):
        for name in _NAME.findall(names.strip("()")):
            if (whole := f"{source}.{name}") in files:
                held.setdefault(whole, []).extend(re.findall(rf"\b{name}\.(\w+)", text))
            elif source in files:
                held.setdefault(source, []).append(name)
    return [source for source, names in held.items() if any(_is_held(name, files[source]) for name in names)]


def _is_held(name: str, text: str) -> bool:
    """Whether code that uses a name of a file has a part of that file in it: a kernel that is compiled with those that call it, a
    type or a constant, but neither a kernel that is compiled by itself nor a function for Python."""
    if not _TAKES_PART.search(text):
        return name.isupper()
    return name not in _SEPARATE.findall(text) and (name not in _PLAIN.findall(text) or name in _OVERLOADED.findall(text))


@cache
def _files() -> dict[str, str]:
    """Sources of all files in the folders with kernels, by the names of the modules."""
    return {_module(path): path.read_text("utf-8") for folder in FOLDERS for path in (_PACKAGE / folder).glob("*.py")}


@cache
def _makers() -> bytes:
    """What makes kernels of functions, and so is part of all of them."""
    return b"".join(Path(__file__).with_stem(name).read_bytes() for name in ("decorators", "results", "views"))


def _module(path: Path) -> str:
    return ".".join(("stickslip", *path.relative_to(_PACKAGE).with_suffix("").parts))


_PACKAGE = Path(__file__).parents[2]

PACKED = _PACKAGE / "compiled_kernels"
"""The kernels in a wheel."""

COMMON = {"x86_64": "x86-64-v3", "AMD64": "x86-64-v3"}.get(platform.machine(), "generic")
"""The processor of the kernels in a wheel, by its name in LLVM: of its instructions the newer ones change the speed by some
percent. Others than those of x86-64 take the basis of their kind."""

_COMMON_NEEDS = ("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe")

DIGEST = 32
"""Bytes before the content of a kernel, by which a damaged one is known and compiled anew."""

UNUSED_SECONDS = 3 * 86400.0
"""Age from which kernels of other sources are removed; younger ones may belong to a process that still runs."""


class KernelCache(caching._Cache):
    """What numba asks for a compiled kernel before it compiles one, and gives it to afterwards."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function
        path = Path(function.__code__.co_filename)
        self._name, self._sources = f"{path.parent.name}.{path.stem}.{function.__qualname__}", digest_of(path)

    @property
    def cache_path(self) -> str:
        return str(FOLDER)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled kernel for a signature, of this processor or else from the wheel; None where it is to be compiled."""
        triple, *processor = target_context.codegen().magic_tuple()
        places = [(FOLDER, (triple, *processor))] + [(PACKED, (triple, COMMON, ""))] * (_takes_packed() and _packed_is_closed())
        for folder, target in places:
            with suppress(OSError, ImportError, AttributeError):  # of an older version, whose types have moved since
                content = _read(folder / self._file(sig, target))
                if content.startswith(_digest(content[DIGEST:])):  # a full disk or a power cut may have damaged it
                    return _loaded(content[DIGEST:], target_context)
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled kernel; those of older sources go."""
        if data.library.has_dynamic_globals:
            raise TypeError(f"{self._name} holds an address of this process, and cannot be kept.")
        path = FOLDER / self._file(sig, data.codegen.magic_tuple())
        with suppress(OSError):
            with only_own_files(False), replacing(path) as temporary:
                temporary.touch(mode=0o600)  # what lies here is run: others must not write to it
                content = serialize.dumps(data._reduce())
                temporary.write_bytes(_digest(content) + content)
            for old in FOLDER.glob(f"{self._name}-*.kernel"):
                if self._sources[:16] not in old.name and time.time() - old.stat().st_mtime > UNUSED_SECONDS:
                    old.unlink()

    def _file(self, sig: Any, target: tuple[Any, ...]) -> str:
        code = self._function.__code__.co_code
        python = *sys.version_info[:2], getattr(sys, "abiflags", "")
        given = repr((str(sig), target, numba.__version__, python, hashlib.sha256(code).hexdigest()))
        return f"{self._name}-{self._sources[:16]}-{hashlib.sha256(given.encode()).hexdigest()[:16]}.kernel"

    def enable(self) -> None:
        """It is always in use."""

    def disable(self) -> None:
        """It is always in use."""

    def flush(self) -> None:
        """Each change of the sources does so."""


def _read(path: Path) -> bytes:
    """The content of a file that others cannot have written."""
    with path.open("rb") as file:
        about = os.fstat(file.fileno())
        mine = not hasattr(os, "geteuid") or about.st_uid in (os.geteuid(), 0, _PACKAGE.stat().st_uid)
        if mine and (os.name == "nt" or not about.st_mode & stat.S_IWOTH):
            return file.read()
    return b""


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).digest()


def _loaded(content: bytes, target_context: Any) -> Any:
    """A compiled kernel from what was kept of it.

    numba would prepare itself to compile and read the kernel's intermediate code, which takes as long as all else. It prepares
    itself before it compiles in any case, and the intermediate code is read once a kernel is compiled that holds this one.
    """
    rtsys.initialize(target_context)
    (name, kind, (code, intermediate)), description, *rest = pickle.loads(content)  # noqa: S301
    entries = (description.llvm_func_name, description.llvm_cpython_wrapper_name)
    stubs = llvm.parse_assembly("\n".join(f'define void @"{entry}"() {{ ret void }}' for entry in entries)).as_bitcode()
    found = CompileResult._rebuild(target_context, (name, kind, (code, stubs)), description, *rest)
    found.library._get_module_for_linking = cache(partial(llvm.parse_bitcode, intermediate))
    return found


def kept(dispatcher: Any) -> Any:
    """A function of numba whose compiled code is kept for later processes, unless it was typed in and has no file, or was made in
    another function: its code may hold values of that, which no source shows."""
    function = dispatcher.py_func
    if "<locals>" not in function.__qualname__ and Path(function.__code__.co_filename).is_file():
        dispatcher._cache = KernelCache(dispatcher.py_func)
    return dispatcher


def nothing_is_kept() -> bool:
    """Whether a first problem has all its kernels to compile."""
    return not any(any(folder.glob("*.kernel")) for folder in (FOLDER, PACKED))


def _takes_packed() -> bool:
    """Whether this processor runs the kernels of the wheel, and nobody asked for another's (numba's setting)."""
    features = llvm.get_host_cpu_features()
    runs = COMMON == "generic" or all(features.get(each, False) for each in _COMMON_NEEDS)
    return runs and numba.config.CPU_NAME is None and not OWN_ONLY  # type: ignore[attr-defined]


@cache
def _packed_is_closed() -> bool:
    """Whether others cannot have changed the kernels of the wheel."""
    return PACKED.is_dir() and is_closed_to_others(PACKED)


OWN_ONLY = False
"""True: kernels are compiled for this processor although the wheel has others that run on it."""


def _folder() -> Path:
    """The one that NUMBA_CACHE_DIR names, or a writable one: beside the package, else the user's cache, else a temporary one of
    the user alone."""
    home = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"), "stickslip", "kernels")
    places = [_PACKAGE / "__pycache__" / "kernels", home]
    if chosen := os.environ.get("NUMBA_CACHE_DIR"):
        places = [Path(chosen).absolute() / "stickslip"]
    for place in places:
        if not place.is_absolute():
            continue  # a user without a home; the working folder may be that of a model
        with suppress(OSError):
            place.parent.mkdir(parents=True, exist_ok=True)
            place.mkdir(mode=0o700, exist_ok=True)
            if is_closed_to_others(place):
                with tempfile.TemporaryFile(dir=place):
                    return place
    if chosen:
        remedy = (
            "Compiled kernels are kept in a folder of the user alone instead. Let nobody else write to it or to what holds it."
        )
        message = f"NUMBA_CACHE_DIR must name a folder that only you can write to, but is {chosen!r}. {remedy}"
        warnings.warn(message, RuntimeWarning, stacklevel=2)
    return _temporary_folder() / "kernels"


def _temporary_folder() -> Path:
    """The user's own folder among the temporary ones, which later processes find again; where another took its name, one that
    ends with this process."""
    if not hasattr(os, "geteuid"):
        return Path(tempfile.gettempdir()) / "stickslip"  # on Windows temporary folders are the user's own
    folder = Path(tempfile.gettempdir()) / f"stickslip-{os.geteuid()}"
    with suppress(OSError):
        folder.mkdir(mode=0o700, exist_ok=True)
        own = folder.lstat()
        shut = stat.S_ISDIR(own.st_mode) and own.st_uid == os.geteuid() and not own.st_mode & (stat.S_IRWXG | stat.S_IRWXO)
        if shut and is_closed_to_others(folder) and folder.parent != Path.cwd():  # which is the last place for temporary files
            return folder
    passing = Path(tempfile.mkdtemp(prefix="stickslip-"))
    atexit.register(shutil.rmtree, passing, ignore_errors=True)
    return passing


def is_closed_to_others(folder: Path) -> bool:
    """Whether only this user, the system and the owner of the package can write to a folder and exchange it.

    Each folder above it must be one of theirs, too, and others must not be able to write there or, by its sticky bit, to move
    what is not theirs.
    """
    if not hasattr(os, "geteuid"):
        return True
    real = folder.resolve(strict=True)
    known = {os.geteuid(), 0, _PACKAGE.stat().st_uid}
    places = [(each, each.stat()) for each in (real, *real.parents)]
    owned = all(place.st_uid in known for _, place in places)
    open_above = any(_others_write(place) and not place.st_mode & stat.S_ISVTX for _, place in places[1:])
    return owned and not open_above and not places[0][1].st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def _others_write(place: os.stat_result) -> bool:
    """Whether others than the owner can write to a folder; a group of the owner's name without other members is the owner's."""
    if place.st_mode & stat.S_IWOTH:
        return True
    if not place.st_mode & stat.S_IWGRP:
        return False
    import grp
    import pwd

    try:
        group, owner = grp.getgrgid(place.st_gid), pwd.getpwuid(place.st_uid)
    except KeyError:
        return True
    return group.gr_name != owner.pw_name or bool({*group.gr_mem} - {owner.pw_name})


FOLDER = _folder()
"""Where this process keeps kernels."""


class _Compilations(event.Listener):
    """Passes on which kernels are compiled; numba's own functions inside them do not count."""

    def on_start(self, what: event.Event) -> None:
        if _of_this_package(what):
            NOTICE.begin()

    def on_end(self, what: event.Event) -> None:
        if _of_this_package(what):
            NOTICE.end()


def _of_this_package(what: event.Event) -> bool:
    return bool(what.data["dispatcher"].py_func.__module__.startswith("stickslip."))


event.register("numba:compile", _Compilations())
