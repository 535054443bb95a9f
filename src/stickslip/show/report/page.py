"""Assembly of the page: sections, inlined style and scripts, and a content policy that blocks external resources.

The policy names the scripts of this page by their hashes, so even text that slipped through as HTML could not execute.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path

from stickslip.analyses.nodal_diameters import has_disk
from stickslip.analyses.stress import has_stress
from stickslip.analyses.variability.bounds import has_bounds
from stickslip.analyses.variability.samples import has_percentiles
from stickslip.results.shown_units import system_of
from stickslip.show.plots.moving_picture import step_script
from stickslip.show.report import plain, sections
from stickslip.show.report.bounds import bounds, percentiles
from stickslip.show.report.charts import Charts
from stickslip.show.report.markup import packed, text
from stickslip.show.report.motion import disk, motions, moves
from stickslip.show.report.presentation import presentation_of
from stickslip.show.report.stress import stress
from stickslip.support.checks import fault
from stickslip.support.files import write_text
from stickslip.support.late import xr

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
    "figures": plain.has_more_figures,
    "motion": moves,
}
"""Sections that only some results fill; every result fills the others."""


PLAIN_SECTIONS: tuple[Section, ...] = (
    ("overview", "Overview", plain.overview),
    ("figures", "Figures", plain.figures),
    ("motion", "Motion", motions),
    ("tables", "Tables", plain.tables),
    ("failures", "Failures", plain.failures),
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


def sections_of(datasets: Mapping[str, xr.Dataset]) -> tuple[Section, ...]:
    """The sections that these results fill."""
    entries = SECTIONS if _of_responses(datasets) else PLAIN_SECTIONS
    return tuple(entry for entry in entries if entry[0] not in NEEDS or any(map(NEEDS[entry[0]], datasets.values())))


def _of_responses(datasets: Mapping[str, xr.Dataset]) -> bool:
    return all(presentation_of(dataset).responses for dataset in datasets.values())


def page(datasets: Mapping[str, xr.Dataset]) -> str:
    """The whole page as a string."""
    title = common_title(list(dict.fromkeys(str(d.attrs.get("title") or label) for label, d in datasets.items())))
    kinds = [kind for d in datasets.values() if (kind := presentation_of(d).title) != title]
    about = f"{' and '.join(dict.fromkeys(kinds))}, computed with stickslip" if kinds else "Computed with stickslip"
    charts, shown = Charts(list(datasets), system_of(*datasets.values())), sections_of(datasets)
    body = "".join(build(datasets, charts) for _, _, build in shown)
    links = "".join(f'<a href="#{identifier}">{word}</a>' for identifier, word, _ in shown)
    several = len(datasets) > 1 and _of_responses(datasets)
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
