"""Entry points: `read_model` and `read_structure` read any known format, recognised by the file's ending and first bytes.

Whatever a reader meets in a file, the answer is a model or an `InputError`. Nothing in a file is ever run.
"""

import os
import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from stickslip.model.readers import abaqus, ansys, calculix, matlab, matrix_files, nastran_deck, nastran_op4, numpy_archive
from stickslip.model.readers.model import NEEDED, SYNONYMS, Content, Model, chosen, implausible, model_of
from stickslip.model.readers.named_rows import with_names
from stickslip.model.readers.numbers import refuse_packed
from stickslip.model.readers.reduction import Progress, quiet, structure_of
from stickslip.model.readers.stress_places import Keep, StrainGauge, Where, places_of, stress_rows_of
from stickslip.model.structure.centrifugal import AxisLike, RotationAxis
from stickslip.model.structure.matrices import Damping, Structure, square_sparse
from stickslip.support.checks import InputError, fault, not_negative, several, similar_file, truth
from stickslip.support.units import UnitSystem, unit_system

Paths = str | Path | Mapping[str, str | Path]
"""A file, or the files of the matrices by their letters, {"M": ..., "K": ...}."""


@dataclass(frozen=True)
class Format:
    """A file format: its name, its endings, its reader, and for endings that formats share the first bytes."""

    name: str
    endings: tuple[str, ...]
    read: Callable[[Path], Content]
    start: bytes = b""


FORMATS = (
    Format("NumPy archive", (".npz",), numpy_archive.read),
    Format("MATLAB file", (".mat",), matlab.read),
    Format("Abaqus matrix", (".mtx",), abaqus.read),
    Format("Matrix Market", (".mtx", ".mm"), matrix_files.read_matrix_market, matrix_files.START),
    Format("Harwell-Boeing", (".rb", ".rsa", ".rua", ".hb", ".matrix"), matrix_files.read_harwell_boeing),
    Format("Nastran OUTPUT4", (".op4",), nastran_op4.read),
    Format("Nastran DMIG", (".pch", ".dmig", ".bdf"), nastran_deck.read),
    Format("Ansys .full file", (".full",), ansys.read),
    Format("CalculiX run", (".sti", ".mas", ".dof", ".inp"), calculix.read),
)

OUTPUT4 = "Write the matrices with OUTPUT4, or as DMIG with EXTSEOUT, and give the .op4 or the .pch file."
DECK_ALONE = "It is a deck without matrices: give their file, and this one as `names` if it has the nodes."
INSTEAD = {
    ".op2": f"It holds results. {OUTPUT4}",
    ".h5": f"Of Nastran it holds results. {OUTPUT4}",
    ".f06": f"It is a print-out. {OUTPUT4}",
    ".dat": DECK_ALONE,
    ".nas": DECK_ALONE,
    ".cdb": DECK_ALONE,
    ".sub": "Ansys writes the matrices of a superelement from its .sub file by `*SMAT` and `*EXPORT`: give the .mtx or .hb.",
    ".rst": "It holds results. Give the .full file, or matrices that `*EXPORT` writes (.mtx or .hb).",
    ".emat": "It holds matrices of elements. Give the .full file, or matrices that `*EXPORT` writes (.mtx or .hb).",
    ".odb": "It holds results. Write the matrices with `*MATRIX GENERATE` and `*MATRIX OUTPUT`, and give the .mtx files.",
    ".sim": "Write the matrices with `*MATRIX OUTPUT, FORMAT=COORDINATE`, and give the .mtx files.",
    ".frd": "It holds results. Give the .sti and .mas files of `*FREQUENCY, SOLVER=MATRIXSTORAGE`.",
}
"""What to give instead of a file that other programs write beside that of the matrices."""

COUNTERPARTS = (("STIFFNESS", "MASS", "DAMPING"), ("STIF", "MASS", "DMPV"), ("K", "M", "C"))
"""Ends of the names of files that hold stiffness, mass and damping of one model, in capitals or small letters."""
NAME_BOTH = 'Name the files of both: model = { M = "mass.mtx", K = "stiffness.mtx" } in a study, {"M": ..., "K": ...} in Python.'


def read_structure(
    path: Paths,
    *,
    units: str | UnitSystem = "SI",
    keep: Keep | None = None,
    modes: int | None = None,
    damping: Damping | None = None,
    names: str | Path | None = None,
    dofs: Sequence[str] = (),
    variables: Mapping[str, str] | None = None,
    own_damping: bool = True,
    stress: Mapping[str, Where | StrainGauge] | None = None,
    speed: float | None = None,
    axis: AxisLike = "z",
    progress: Progress = quiet,
) -> Structure:
    """A finite-element model of another program as a `Structure`, in SI.

    path: a file, or {"M": file, "K": file}; units: those of the file, "SI", "mm-t-s", ...; keep: places that stay, {name: id of
    a node, name of a set or coordinates (x, y, z) in the file's unit}, or a list of ids and sets; all else becomes `modes`
    fixed-interface modes (30), and without `keep` the model is taken whole. names: a deck (.cdb, .inp, .bdf) or a table (CSV)
    with names of rows, coordinates and sets; dofs: the names themselves; variables: {"K": "KELAST"} where the matrices have
    unusual names; damping: a rule where the file has no C, or own_damping=False leaves that out;
    stress: places {name: node, set, coordinates or `StrainGauge`} whose stress `ForcedResponse.with_stress()` gives, from the
    elements of a deck; speed: rotor speed in rev/min, so that the mean stress contains the stress due to rotation about axis,
    which is "x", "y" or "z" through the origin, or (point, direction) in the units of the model;
    progress(share, text) is called during long work, and with the places found.
    """
    system = unit_system(units)
    model = read_model(path, units=system, names=names, dofs=dofs, variables=variables, own_damping=own_damping)
    places = None if keep is None else places_of(model, keep, system.metres)
    for place in places or ():
        progress(0.0, str(place))
    recovered = None if stress is None else stress_rows_of(model, stress, system.metres)
    for note in recovered.notes if recovered else ():
        progress(0.0, note)
    rotation = None if speed is None else (not_negative("speed", speed), RotationAxis.of(axis).scaled(system.metres))
    made, notes = structure_of(model, places, modes, damping, progress, recovered, rotation)
    for note in notes:
        progress(1.0, note)
    return made


def read_model(
    path: Paths,
    *,
    units: str | UnitSystem = "SI",
    names: str | Path | None = None,
    dofs: Sequence[str] = (),
    variables: Mapping[str, str] | None = None,
    own_damping: bool = True,
) -> Model:
    """A finite-element model with sparse matrices, names, coordinates and sets, in SI, not reduced. Arguments: `read_structure`.

    Warns of a density or stiffness that no body has: the units are wrong then.
    """
    if not isinstance(variables, Mapping | None):
        raise fault("variables", 'must be a table such as {"K": "KELAST"}', variables)
    truth("own_damping", own_damping)
    chosen_names = dict(variables or {})
    content, file = read_content(path, chosen_names)
    if names is not None:
        content = with_names(content, _path("The file of names", names))
    model = model_of(content, unit_system(units), chosen_names, several("dofs", dofs), file, own_damping)
    for sentence in implausible(model):
        warnings.warn(f"{file}: {sentence}", stacklevel=2)
    return model


def read_content(path: Paths, variables: Mapping[Any, str]) -> tuple[Content, str]:
    """What the file holds, together with the file of the other matrix where a format has one matrix a file; and its name."""
    if isinstance(path, Mapping):
        files = {letter: _path(f"The file of {letter}", file) for letter, file in path.items()}
        return _together(files, variables), " and ".join(dict.fromkeys(file.name for file in files.values()))
    file = _path("A model", path)
    content = _read_one(file)
    if set(content.matrices) == {""}:
        return _together(_counterparts(file), variables), file.name
    punch = file.with_suffix(".pch")
    if not content.dofs and file.suffix.lower() == ".op4" and punch.is_file():
        with punch.open("rb") as lines:  # the punch file of a superelement names the rows of its OUTPUT4 file
            lists_rows = b"EXTRN" in lines.read(1 << 20)
        content = with_names(content, punch) if lists_rows else content
    return content, file.name


def _path(what: str, path: Any) -> Path:
    """The path, unless it is something else."""
    if not isinstance(path, str | os.PathLike):
        raise fault(what, "must be the path of a file", path)
    return Path(path)


def _read_one(path: Path) -> Content:
    """One file by its reader; whatever that raises becomes an `InputError`."""
    try:
        form = format_of(path)
    except OSError as error:
        raise _refused(error) from None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return form.read(path)
    except InputError as error:
        raise InputError(f"{path.name}: {error}") from None
    except MemoryError:
        raise fault(path.name, "must fit into the memory", "larger") from None
    except Exception as error:  # the readers of other packages raise whatever damaged files lead them to
        if isinstance(error, OSError) and error.filename is not None:
            raise _refused(error) from None
        reason = str(error).splitlines()[0][:200] if str(error) else type(error).__name__
        raise fault("A model file", "must be readable", path.name, f"Read as {form.name}, it is damaged ({reason}).") from None


def _refused(error: OSError) -> InputError:
    """The fault of a file that the system does not open."""
    return fault("A model file", "must be readable", str(error.filename), f"({error.strerror})")


def format_of(path: Path) -> Format:
    """The format of a file, by its ending and first bytes."""
    endings = sorted({ending for form in FORMATS for ending in form.endings})
    fitting = [form for form in FORMATS if path.suffix.lower() in form.endings]
    if path.exists() and not path.is_file():
        raise fault("A model", "must be a file", f"{path}, a {'folder' if path.is_dir() else 'device or pipe'}")
    if not path.is_file():
        raise fault("A model", "must be a file that exists", str(path), similar_file(path))
    refuse_packed("A model", path)
    if not fitting:
        rule = f"must be a file ending in {', '.join(endings[:-1])} or {endings[-1]}"
        raise fault("A model", rule, path.name, INSTEAD.get(path.suffix.lower(), ""))
    with path.open("rb") as file:
        start = file.read(64)
    return next((form for form in fitting if form.start and start.startswith(form.start)), fitting[0])


def _counterparts(path: Path) -> dict[str, Path]:
    """M, K and C beside a file that holds one of them: blade_K.mtx goes with blade_M.mtx."""
    for ends in COUNTERPARTS:
        for case in (str.upper, str.lower):
            match = re.fullmatch(rf"(.*(?:[^A-Za-z]|^))(?:{'|'.join(map(case, ends))})(\d*)", path.stem)
            if match:
                beside = [path.with_stem(f"{match[1]}{case(end)}{match[2]}") for end in ends]
                for packed in (file.with_name(f"{file.name}.gz") for file in beside if not file.is_file()):
                    if packed.is_file():
                        refuse_packed("A matrix of the model", packed)
                return {letter: file for letter, file in zip("KMC", beside, strict=True) if file.is_file()}
    raise fault(
        path.name,
        "must be one of a pair of files of stiffness and mass",
        path.stem,
        f"Names as blade_K and blade_M make a pair. {NAME_BOTH}",
    )


def _together(paths: Mapping[str, Path], variables: Mapping[Any, str]) -> Content:
    """One content of the files of the matrices, under the names by which `variables` or their letters call for them."""
    for letter in paths:
        if letter not in SYNONYMS:
            raise fault("A table of files", "must name M, K or C", letter)
    for letter in NEEDED:
        if letter not in paths:
            raise fault(f"The file of {letter}", "must be given", sorted(path.name for path in paths.values()), NAME_BOTH)
    read = {path: _read_one(path) for path in dict.fromkeys(paths.values())}
    parts = {letter: read[path] for letter, path in paths.items()}
    aligned = {}
    for letter, part in parts.items():
        if "" in part.matrices or (len(part.matrices) == 1 and letter not in variables):  # the only one is the one meant
            aligned[letter] = next(iter(part.matrices.values()))
        else:
            own = {key: name for key, name in variables.items() if key == letter}
            aligned[letter] = chosen(part, own, paths[letter].name, (letter,))[letter]
    dofs = parts["K"].dofs
    if any(part.dofs != dofs for part in parts.values()) and all(part.dofs for part in parts.values()):
        dofs = tuple(dict.fromkeys(name for letter in ("K", *parts) for name in parts[letter].dofs))
        aligned = {letter: _spread(matrix, parts[letter].dofs, dofs) for letter, matrix in aligned.items()}
    notes = dict.fromkeys(note for part in parts.values() for note in part.notes)
    if dofs and parts["K"].format == abaqus.FORMAT:
        aligned, dofs, held = abaqus.without_held(aligned, dofs)
        notes |= dict.fromkeys(held)
    named = {variables.get(letter, letter): matrix for letter, matrix in aligned.items()}
    return replace(parts["K"], matrices=named, dofs=dofs, notes=tuple(notes))


def _spread(matrix: Any, own: Sequence[str], dofs: Sequence[str]) -> Any:
    """A matrix whose rows have the names `own`, over the rows `dofs`, which hold these and others."""
    row = {name: index for index, name in enumerate(dofs)}
    numbers = np.array([row[name] for name in own])
    entries = sparse.coo_array(square_sparse("matrix", matrix))
    return sparse.coo_array((entries.data, (numbers[entries.coords[0]], numbers[entries.coords[1]])), (len(dofs), len(dofs)))
