"""Commented study files to start from, KIND.toml in this folder; $words stand for inserted values.

`beside.py` writes the models that some of them need beside them, `measured` holds the measurements that others read.
"""

import json
import os
import re
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import resources
from pathlib import Path
from string import Template

from stickslip.model.dampers import SHAPES
from stickslip.study.templates import beside
from stickslip.support.checks import fault, similar
from stickslip.support.files import replacing, write_text

FORCE_LEVELS = (1.0, 5.0, 20.0, 50.0, 80.0, 100.0)
"""Force levels of the published experiment on the single blade, N."""

FOLDER = resources.files(__name__)
KINDS = tuple(sorted(Path(file.name).stem for file in FOLDER.iterdir() if file.name.endswith(".toml")))

BESIDE: dict[str, Callable[[Path], tuple[dict[str, str], list[Path]]]] = {
    "lumped": beside.wedge_matrices,
    "model": beside.blade_model,
    "bladed_disk": beside.bladed_disk_sector,
    "two_blades": beside.blade_with_a_platform,
    "jointed_beams": beside.two_jointed_beams,
    "beams_with_a_gap": beside.two_beams_with_a_gap,
}
"""What writes the models beside a study at a path: the words that it puts into the study, and the files."""

SINES = ("_0.5_N.csv", "_6_N.csv", "_15_N.csv")
MEASURED: dict[str, dict[str, tuple[str, ...]]] = {
    "identification": {"loops": ("_out_of_phase.csv", "_in_phase.csv")},
    "contact_law": {"files": (".csv",)},
    "response_identification": {"files": SINES},
    "response_prediction": {"files": SINES, "compared": ("_10_N.csv",)},
    "decay_prediction": {"files": SINES, "compared": ("_ring_down.csv",)},
}
"""Measurements beside a study: the words that are lists of them in the study, and how their names end after that of the study.
They are synthetic (`tools/measured_files.py`)."""


def kinds() -> dict[str, str]:
    """What each kind of study is for: the first sentence of its file."""
    return {kind: _first_sentence(_raw(kind)) for kind in KINDS}


def _first_sentence(template: str) -> str:
    """The comment at the top of a file up to its first full stop, colon or question."""
    lines = []
    for line in template.splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.removeprefix("#").strip())
    return re.split(r"(?<=[.?])\s|:\s", " ".join(lines), maxsplit=1)[0].removesuffix(".")


def write_new(kind: str, path: Path, overwrite: bool = False) -> list[Path]:
    """Write a study of a kind to `path`; returns the paths of all files written."""
    if kind not in KINDS:
        raise fault("KIND", "must be a known one", kind, f"{similar(kind, KINDS)} Known: {', '.join(KINDS)}.".strip())
    if path.suffix != ".toml":
        raise fault("FILE", "must end in .toml", str(path))
    refuse_existing([path], overwrite)
    if kind == "forced_response":
        return [write_text(path, single_blade_study())]
    with tempfile.TemporaryDirectory() as folder:
        words, made = BESIDE[kind](Path(folder, path.name)) if kind in BESIDE else ({}, [])
        contents = {path.with_name(file.name): file.read_bytes() for file in made}
    for word, endings in MEASURED.get(kind, {}).items():
        files = {path.with_name(path.stem + ending): FOLDER / "measured" / f"record{ending}" for ending in endings}
        words |= {word: json.dumps([file.name for file in files], ensure_ascii=False)}
        contents |= {file: data.read_bytes() for file, data in files.items()}
    refuse_existing(contents, overwrite)
    for file, content in contents.items():
        with replacing(file) as temporary:
            temporary.write_bytes(content)
    return [write_text(path, _text(kind, words)), *contents]


def refuse_existing(files: Iterable[Path], overwrite: bool) -> None:
    """Refuse to replace a study or a file beside it without `overwrite`."""
    for file in files:
        if os.path.lexists(file) and not overwrite:
            raise fault("FILE", "must not exist yet", str(file), "Name another, or add --force.")


def single_blade_study(
    preload_mass: float = 4.6, force_levels: Sequence[float] = FORCE_LEVELS, harmonics: int | None = None
) -> str:
    """The study of the single-blade rig, as text; as many harmonics as its peaks need unless their number is given."""
    words = {
        "preload_mass": float(preload_mass),
        "force_levels": [float(level) for level in force_levels],
        "harmonics": '"auto"' if harmonics is None else harmonics,
    }
    return _text("forced_response", words)


def _raw(kind: str) -> str:
    return (FOLDER / f"{kind}.toml").read_text(encoding="utf-8")


def _text(kind: str, words: Mapping[str, object]) -> str:
    return Template(_raw(kind)).substitute({"shapes": ", ".join(SHAPES), **words})
