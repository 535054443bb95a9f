"""Assembly of the page: sections, inlined style and scripts, and a content policy that blocks external resources.

The policy names the scripts of this page by their hashes, so even text that slipped through as HTML could not execute.

Report sections of pictures: a bladed disk with its mode shape, dampers and diagrams; dampers and the deformed shape in
motion at the highest peaks, or the steady cycles of a damper alone.

Sections of the page of an analysis: the answer with its chart, further figures, tables, failures.

An analysis fills them through its `Presentation`.
"""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from stickslip.analyses.damper_alone.cycle import cycle_motion
from stickslip.analyses.motion import has_motion, kept_cases, kept_motion
from stickslip.analyses.nodal_diameters import has_disk
from stickslip.analyses.solved_points import has_shapes, kept_shapes
from stickslip.analyses.stress import has_stress
from stickslip.analyses.variability.bounds import has_bounds
from stickslip.analyses.variability.samples import has_percentiles
from stickslip.results.schema import Certainty, Row, system_of
from stickslip.results.view import level_text, spread
from stickslip.show.plots.animation import Animation
from stickslip.show.plots.deformed_shape import DeformedShape, MovingPicture, step_script
from stickslip.show.plots.disk import damper_ring, disk_mode, mean_normal_load, nodal_diameter_diagram, wave_damping
from stickslip.show.report import sections
from stickslip.show.report.answer import warnings_at_a_glance
from stickslip.show.report.markup import Charts, Choice, framed, packed, picture, presentation_of, section, text
from stickslip.show.report.responses import bounds, percentiles
from stickslip.show.report.stress import stress
from stickslip.support.checks import fault
from stickslip.support.files import write_text
from stickslip.support.late import pd, xr

Datasets = Mapping[str, "xr.Dataset"]

BESIDE = 5
"""Columns that stand beside each other on a narrow screen."""

PREFIX = re.compile(r"^((note|Warning): |warning, )")
"""Before a warning on the console."""

SYMBOL = re.compile(r"\w+_\w+|\w+ (=|≥|×|is not determined)")
"""A line that begins with a symbol."""


def overview(datasets: Datasets, charts: Charts) -> str:
    """What came out: the answer in a sentence or a table, warnings, the first figure, everything else in sentences.

    A table stands for the sentences that are its rows.
    """
    parts = []
    for place, (label, dataset) in enumerate(datasets.items()):
        shown = presentation_of(dataset)
        warned = {line for key in ("warnings", "notes") for line in str(dataset.attrs.get(key, "")).splitlines()}
        warnings, sentences, sure = list[str](), list[str](), list[str]()
        answer = ""
        if (frame := shown.tables(dataset).get(shown.answer)) is not None:
            answer = _framed(place, shown.answer, frame, stacked=len(frame.columns) > BESIDE)
        for line in shown.sentences(dataset):
            sentence = PREFIX.sub("", line.strip())
            if sentence in warned or line.strip().startswith("warning, "):
                warnings.append(sentence)
            elif not (answer and isinstance(line, Row)) and not isinstance(line, Certainty):
                sentences.append(sentence)
            sure += [f'<p class="note">{text(_sentence(sentence))}</p>'] if isinstance(line, Certainty) else []
        first, *rest = sentences
        lines = "".join(f"<li>{text(sentence)}</li>" for sentence in rest)
        seconds = dataset.attrs.get("cpu_seconds")
        note = "" if seconds is None else f'<p class="note">{text(f"{float(seconds):.3g} s of processor time")}.</p>'
        figure = "".join(_figure(charts, place, name, draw, dataset) for name, draw in [*shown.figures(dataset).items()][:1])
        parts.append(
            f'{_head(label, datasets)}<p class="headline">{text(_sentence(first))}</p>{answer}{"".join(sure)}'
            f"{warnings_at_a_glance({'': [_sentence(warning) for warning in warnings]})}{figure}"
            f"<ul>{lines}</ul>{note}"
        )
    return section("overview", "Overview", *parts)


def figures(datasets: Datasets, charts: Charts) -> str:
    """The other figures of every result."""
    parts = []
    for place, (label, dataset) in enumerate(datasets.items()):
        others = [*presentation_of(dataset).figures(dataset).items()][1:]
        parts += [_head(label, datasets), *(_figure(charts, place, name, draw, dataset) for name, draw in others)]
    return section("figures", "Figures", *parts)


def _figure(charts: Charts, place: int, name: str, draw: Callable[[xr.Dataset], Any], dataset: xr.Dataset) -> str:
    return charts.drawn(f"chart-{place}-{name.replace('_', '-')}", draw(dataset), name.replace("_", " "))


def tables(datasets: Datasets, charts: Charts) -> str:
    """The tables of every result that the overview does not show."""
    parts = []
    for place, (label, dataset) in enumerate(datasets.items()):
        shown = presentation_of(dataset)
        parts.append(_head(label, datasets))
        parts += [_framed(place, caption, frame) for caption, frame in shown.tables(dataset).items() if caption != shown.answer]
    return section("tables", "Tables", *parts)


def _framed(place: int, caption: str, frame: pd.DataFrame, stacked: bool = False) -> str:
    return framed(f"table-{place}-{caption.replace(' ', '-')}", caption, frame, stacked)


def failures(datasets: Datasets, charts: Charts) -> str:
    """What failed, and why."""
    parts = []
    for label, dataset in datasets.items():
        causes = "".join(f"<li>{text(sentence)}</li>" for sentence in presentation_of(dataset).failures(dataset))
        parts.append(
            _head(label, datasets)
            + (
                f'<ul class="failed">{causes}</ul>'
                if causes
                else "<p>Every case was computed; the overview says what came out and what to be careful about.</p>"
            )
        )
    return section("failures", "What failed, and why", *parts)


def _head(label: str, datasets: Datasets) -> str:
    return f"<h3>{text(label)}</h3>" if len(datasets) > 1 else ""


def _sentence(line: str) -> str:
    """A line of the console as a sentence; a symbol at its start, `kt = ...`, stays as it is."""
    start = line[:1] if SYMBOL.match(line) else line[:1].upper()
    return start + line[1:] + ("" if line.endswith((".", "!", "?")) else ".")


OF_DISK = (
    '<p class="note">Dampers are shown at the largest amplitude. In a tuned disk all of them behave alike, each later than the '
    "one before. The mean normal load under vibration differs from the static one where slip reduces the part of the centrifugal "
    "load that friction carries.</p>"
)


def disk(datasets: Mapping[str, xr.Dataset], charts: Charts) -> str:
    """All figures of every disk."""
    disks = {label: dataset for label, dataset in datasets.items() if has_disk(dataset)}
    parts = []
    for k, (label, dataset) in enumerate(disks.items()):
        parts += [f"<h3>{text(label)}</h3>"] if len(disks) > 1 else []
        if "disk_shape" in dataset.variables:
            parts.append(picture(disk_mode(dataset), "The disk in its first mode", "png"))
        if dataset.sizes["contact"]:
            parts.append(picture(damper_ring(dataset), "States of the dampers around the disk"))
            parts.append(charts.drawn(f"chart-load-{k}", mean_normal_load(dataset), "Mean normal load over the force level"))
        if "disk_frequency" in dataset.variables:
            description = "Natural frequencies over the nodal diameter"
            parts.append(charts.drawn(f"chart-diameters-{k}", nodal_diameter_diagram(dataset), description))
            if "wave_damping_ratio" in dataset.variables:
                description = "Damping of the waves of the first stuck mode over the nodal diameter"
                parts.append(charts.drawn(f"chart-wave-damping-{k}", wave_damping(dataset), description))
    return section("disk", "Disk", OF_DISK, *parts)


MOST = 4
"""Cases that are shown in motion: 150 kB of the page each."""
NOTE = (
    "One period. Circles are contacts, coloured by what they do; arrows are the forces on the damper, light "
    "bands the faces of the platforms."
)

SHAPE_NOTE = (
    "The deformed shape is the first harmonic of the displacement at the highest peak, from the instant of the largest "
    "deflection on. Drag it to turn it. Grey: at rest. Dampers are not part of it."
)


def moves(dataset: xr.Dataset) -> bool:
    """Whether a result has motion to show."""
    return has_motion(dataset) or "damper_motion" in dataset or has_shapes(dataset)


def motions(datasets: Mapping[str, xr.Dataset], charts: Charts) -> str:
    """Animations with the choice of the force level or the cycle."""
    places, notes = [], []
    for number, (label, dataset) in enumerate(datasets.items()):
        if has_shapes(dataset):
            shapes = {level: DeformedShape(shape) for level, shape in kept_shapes(dataset).items()}
            choice = Choice("Force level", list(shapes))
            places.append(charts.place("chart-shape", shapes.__getitem__, [choice], result=label))
            notes.append(SHAPE_NOTE)
        if not has_motion(dataset) and "damper_motion" not in dataset:
            continue
        notes.append(NOTE)
        shown = _animations(dataset)
        name = "Force level" if has_motion(dataset) else "Cycle"
        several = len(datasets) > 1 and not all(map(has_motion, datasets.values()))
        place = f"chart-motion-{number}" if several else "chart-motion"
        places.append(charts.place(place, shown.__getitem__, [Choice(name, list(shown))], result="" if several else label))
    note = " ".join(dict.fromkeys(notes))
    return section("motion", "Motion", *places, f'<p class="note">{text(note)}</p>')


def moving_pictures(dataset: xr.Dataset) -> dict[str, MovingPicture]:
    """By the name of a file each: motion and deformed_shape, with the force level or the number of the cycle where several are
    kept."""
    found: dict[str, MovingPicture] = {}
    shapes = {level: DeformedShape(shape) for level, shape in kept_shapes(dataset).items()} if has_shapes(dataset) else {}
    animations = _animations(dataset) if has_motion(dataset) or "damper_motion" in dataset else {}
    for name, pictures in (("motion", animations), ("deformed_shape", shapes)):
        for words, moving in pictures.items():
            ending = re.sub(r"[^\w.]+", "_", words).strip("_")
            found[f"{name}_{ending}" if len(pictures) > 1 else name] = moving
    return found


def _animations(dataset: xr.Dataset) -> dict[str, Animation]:
    """By the words of the reader's choice."""
    if has_motion(dataset):
        kept = kept_cases(dataset)
        return {level_text(dataset, kept[k]): Animation(kept_motion(dataset, kept[k])) for k in spread(len(kept), MOST)}
    cycles = [dataset] if "cycle" not in dataset.dims else [dataset.isel(cycle=k) for k in range(dataset.sizes["cycle"])]
    return {str(k + 1): Animation(cycle_motion(cycles[k])) for k in spread(len(cycles), MOST)}


Section = tuple[str, str, Callable[[Mapping[str, xr.Dataset], Charts], str]]

SECTIONS: tuple[Section, ...] = (
    ("overview", "Overview", sections.overview),
    ("bounds", "Bounds", bounds),
    ("percentiles", "Percentiles", percentiles),
    ("curves", "Curves", sections.curves),
    ("peaks-section", "Peaks", sections.peaks),
    ("loops", "Loops", sections.loops),
    ("states", "States", sections.states),
    ("motion", "Motion", motions),
    ("energy", "Energy", sections.energies),
    ("disk", "Disk", disk),
    ("stress", "Stress", stress),
    ("failures", "Failures", sections.failures),
    ("study", "Study", sections.study),
    ("versions", "Versions", sections.versions),
)
NEEDS: dict[str, Callable[[xr.Dataset], bool]] = {
    "bounds": has_bounds,
    "percentiles": has_percentiles,
    "disk": has_disk,
    "stress": has_stress,
    "figures": lambda dataset: len(presentation_of(dataset).figures(dataset)) > 1,  # beside that of the overview
    "motion": moves,
}
"""Sections that only some results fill; every result fills the others."""


PLAIN_SECTIONS: tuple[Section, ...] = (
    ("overview", "Overview", overview),
    ("figures", "Figures", figures),
    ("motion", "Motion", motions),
    ("tables", "Tables", tables),
    ("failures", "Failures", failures),
    ("study", "Study", sections.study),
    ("versions", "Versions", sections.versions),
)
"""Of all analyses but responses."""


def write(datasets: xr.Dataset | Mapping[str, xr.Dataset], path: str | Path) -> Path:
    """Write the report of one dataset, or of several by name, to `path`, whole or not at all; returns the path."""
    if isinstance(datasets, xr.Dataset):
        datasets = {str(datasets.attrs.get("title") or "Forced response"): datasets}
    if not datasets:
        raise fault("datasets", "must hold at least one result", "none")
    return write_text(path, page(datasets))


def page(datasets: Mapping[str, xr.Dataset]) -> str:
    """The whole page as a string."""
    title = common_title(list(dict.fromkeys(str(d.attrs.get("title") or label) for label, d in datasets.items())))
    kinds = [kind for d in datasets.values() if (kind := presentation_of(d).title) != title]
    about = f"{' and '.join(dict.fromkeys(kinds))}, computed with stickslip" if kinds else "Computed with stickslip"
    charts = Charts(list(datasets), system_of(*datasets.values()))
    responses = all(presentation_of(dataset).responses for dataset in datasets.values())
    entries = SECTIONS if responses else PLAIN_SECTIONS
    shown = [entry for entry in entries if entry[0] not in NEEDS or any(map(NEEDS[entry[0]], datasets.values()))]
    body = "".join(build(datasets, charts) for _, _, build in shown)
    links = "".join(f'<a href="#{identifier}">{word}</a>' for identifier, word, _ in shown)
    several = len(datasets) > 1 and responses
    choice = '<label class="select">Charts show <select id="result"></select></label>' if several else ""
    library, packed_library = _library()
    scripts = step_script(), _resource("report.js")
    data = json.dumps(charts.data(), allow_nan=False, separators=(",", ":"))
    need = "<noscript><p>The charts need JavaScript; the tables below do not.</p></noscript>"
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{_policy((library, *scripts))}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1"><meta name="color-scheme" content="light dark">'
        f"<title>{text(title)} – stickslip</title><style>{_resource('report.css')}</style></head>\n<body>"
        f"<header><h1>{text(title)}</h1><p>{text(about)}</p></header>"
        f'<nav aria-label="Sections">{links}{choice}</nav>'
        f"{need}\n<main>{body}</main>\n"
        f"{packed('data', data)}\n{packed_library}\n"
        + "\n".join(f"<script>{script}</script>" for script in scripts)
        + "</body></html>\n"
    )


def common_title(titles: Sequence[str]) -> str:
    """One title of several results: the words that all begin with, then what distinguishes each; else all titles."""
    split_titles = [title.split() for title in titles]
    common = next((k for k, at in enumerate(zip(*split_titles, strict=False)) if len(set(at)) > 1), min(map(len, split_titles)))
    if len(titles) == 1 or common == 0 or common == min(map(len, split_titles)):
        return " · ".join(titles)
    rest = ", ".join(" ".join(own[common:]) for own in split_titles)
    return f"{' '.join(split_titles[0][:common]).rstrip(',:;')}: {rest}"


@cache
def _library() -> tuple[str, str]:
    """plotly.js as text, with the line ends that a browser hashes, and packed; the same for every page of a process."""
    from plotly.offline import get_plotlyjs

    library = str(get_plotlyjs()).replace("\r\n", "\n").replace("\r", "\n")
    return library, packed("library", library)


def _policy(scripts: Sequence[str]) -> str:
    """Nothing is loaded; only these scripts run. Styles are free, since plotly.js writes them; images are its exports."""
    digests = (base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts)
    allowed = " ".join(f"'sha256-{digest}'" for digest in digests) or "'none'"
    rest = "style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'"
    return f"default-src 'none'; script-src {allowed}; {rest}"


def _resource(name: str) -> str:
    return files("stickslip.show.report").joinpath(name).read_text(encoding="utf-8")
