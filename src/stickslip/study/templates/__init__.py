"""Commented study files to start from, KIND.toml in this folder; $words stand for inserted values.

beside/KIND holds the models and measurements that lie beside some of them, named as those of study.toml: models as other programs
export them, measurements with noise. `tools/template_files.py` makes them.
"""

import json
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from importlib import resources
from pathlib import Path
from string import Template

from stickslip.model.dampers import SHAPES
from stickslip.support.checks import fault, similar
from stickslip.support.files import replacing, write_text

FORCE_LEVELS = (1.0, 5.0, 20.0, 50.0, 80.0, 100.0)
"""Force levels of the published experiment on the single blade, N."""

FOLDER = resources.files(__name__)
KINDS = tuple(sorted(Path(file.name).stem for file in FOLDER.iterdir() if file.name.endswith(".toml")))


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
    beside = FOLDER / "beside" / kind
    files = beside.iterdir() if beside.is_dir() else ()
    contents = {path.with_name(file.name.replace("study", path.stem, 1)): file.read_bytes() for file in files}
    refuse_existing(contents, overwrite)
    for file, content in contents.items():
        with replacing(file) as temporary:
            temporary.write_bytes(content)
    text = _text(kind, {"study": json.dumps(path.stem, ensure_ascii=False)[1:-1]})
    return [write_text(path, text), *sorted(contents, key=lambda file: text.find(file.name))]


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
