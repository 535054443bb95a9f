"""Commands on results: `report`, `peaks`, `plot`, `export` and `explore`.

What `info`, `check` and `peaks` print with `--json`: one JSON object, for scripts.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer
from typer import Argument, Option

from stickslip.cli.app import Text, Texts, guarded, results_in, writable_folder
from stickslip.support.checks import InputError, fault, nearest
from stickslip.support.console import say
from stickslip.support.files import WrittenFiles, only_own_files, refuse_obstacle, write_text
from stickslip.support.late import pd, xr

if TYPE_CHECKING:
    from stickslip.model.readers.model import Description
    from stickslip.show.report.markup import Presentation
    from stickslip.study import Job

Json = Annotated[bool, Option("--json", help="Print one JSON object for scripts, instead of text.")]
UNIT = re.compile(r"(.*) \[([^\]]+)\]")
"""The head of a column with its unit, "amplitude [mm]"."""


def say_json(values: dict[str, Any]) -> None:
    """Print an object; NaN and infinite numbers, which JSON lacks, become null."""
    say(json.dumps(plain(values), ensure_ascii=False, indent=1, allow_nan=False))


def plain(value: Any) -> Any:
    """Arrays as lists, NumPy's numbers as Python's, numbers that are not finite as None."""
    if isinstance(value, dict):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    return None if isinstance(value, float) and not np.isfinite(value) else value


def of_model(found: Description) -> dict[str, Any]:
    """The description of a model, in SI and Hz."""
    model, modes = found.model, found.modes
    matrices = {"M": model.M, "K": model.K} | ({} if model.C is None else {"C": model.C})
    return {
        "format": model.format,
        "rows": model.size,
        "entries": {name: matrix.nnz for name, matrix in matrices.items()},
        "nodes": len(model.directions),
        "located_nodes": len(model.located[0]),
        "sets": {name: len(nodes) for name, nodes in model.sets.items()},
        "box": found.box,
        "mass": dict(zip("xyz", found.mass, strict=True)),
        "rigid_motions": None if modes is None else modes.rigid,
        "negative_motions": None if modes is None else modes.negative,
        "frequencies": None if modes is None else modes.frequencies,
        "modes_there": None if modes is None else modes.count.there,
        "there_below": None if modes is None else modes.count.hertz,
        "units": {"box": "m", "mass": "kg", "frequencies": "Hz", "there_below": "Hz"},
        "warnings": found.odd,
    }


def of_study(study: Path, job: Job, seconds: float | None) -> dict[str, Any]:
    """A study without errors: its notes, the numbers of its model in the units of the study, the estimated time of a run."""
    from stickslip.analyses.static_load import by_surface, rest_of
    from stickslip.results.schema import in_system
    from stickslip.study.faults import WARNING

    values = {
        "study": str(study),
        "valid": True,
        "errors": [],
        "analysis": job.analysis,
        "title": job.title,
        "summary": job.plan.summary,
        "notes": [note for note in job.notes if not note.startswith(WARNING)],
        "warnings": [note.removeprefix(WARNING) for note in job.notes if note.startswith(WARNING)],
        "estimated_seconds": seconds,
    }
    if job.sweep is None:
        return values
    problem, (newtons, force) = job.sweep.problem, in_system("N", job.units)
    limits, at_rest = {"no_contacts": False, "contacts_stuck": True}, rest_of(problem)
    loads = zip(problem.contacts, at_rest.get("rest_load", ()), strict=False)
    return values | {
        "frequencies": {name: problem.frequencies(stuck=stuck) for name, stuck in limits.items()},
        "normal_loads": {contact.name: newtons * float(load) for contact, load in loads if contact.normal is not None},
        "contacts_at_rest": by_surface(at_rest, job.units) if at_rest else [],
        "units": {"frequencies": "Hz", "normal_loads": force, "estimated_seconds": "s"},
    }


def of_peaks(name: str, dataset: xr.Dataset, table: pd.DataFrame, outside: pd.DataFrame) -> dict[str, Any]:
    """The peaks of one result, a record each, those outside the band apart, with the units of their columns and everything that
    was warned of."""
    from stickslip.results.schema import analysis_of
    from stickslip.show.report.answer import failures_of, further_curves_sentence, warnings_of

    heads = {str(head): UNIT.fullmatch(str(head)) for head in (*table, *outside)}
    names = {head: match[1] if match else head for head, match in heads.items()}
    return {
        "name": name,
        "title": str(dataset.attrs.get("title", "")),
        "analysis": analysis_of(dataset),
        "further_curves": further_curves_sentence(dataset) or None,
        "peaks": table.rename(columns=names).to_dict("records"),
        "peaks_outside_the_band": outside.rename(columns=names).to_dict("records"),
        "units": {match[1]: match[2] for match in heads.values() if match},
        "failures": failures_of(dataset),
        "warnings": warnings_of(dataset),
    }


FORMULA = re.compile(r"^(?![+-]?[\d.]+(e[+-]?\d+)?\Z)(?=[=+\-@\t\r\n＝＋－＠])|(?<=[;\t\r\n])(?=[=+\-@＝＋－＠])", re.IGNORECASE)
"""Where a spreadsheet may see a formula begin: at the start of a text that is no number, or behind what it may take for the end
of a cell, as it does with semicolons where commas are decimal. The last four signs are wide ones."""
FIGURES = "figures"
"""Where figures go beside results."""
FORMATS, OF_FIGURES, OF_MOTION = ("png", "svg", "gif"), ("png", "svg", "pdf"), ("gif", "mp4", "webp", "html")
"""As what figures and moving pictures are written unless a format is given, and what they can be written as."""


@guarded
def report(
    ctx: typer.Context, results: Annotated[Path, Argument(help="results.nc, or the folder that a run or the demo wrote.")]
) -> None:
    """Write the report of results again."""
    from stickslip.results.files import open_results

    files = results_in(results)
    say_several(files, results)
    folder = results if results.is_dir() else results.parent
    write_reports({name: open_results(file) for name, file in files.items()}, writable_folder(folder))


@guarded
def peaks(
    ctx: typer.Context,
    results: Annotated[Path, Argument(help="results.nc, or the folder that a run or the demo wrote.")],
    as_json: Json = False,
) -> None:
    """Print the peaks of response curves in the units of the study, with the estimates of their errors and all warnings."""
    from stickslip.results.files import open_results
    from stickslip.results.quantities import outside_table, peak_table
    from stickslip.results.schema import shown_table
    from stickslip.show.report.answer import OUTSIDE, failures_of, further_curves_sentence, warnings_of
    from stickslip.show.report.markup import presentation_of

    datasets = {name: open_results(file) for name, file in results_in(results).items()}
    for dataset in datasets.values():
        kind = presentation_of(dataset)
        if not kind.responses:
            remedy = f"`stickslip export` writes the tables of these results: {', '.join(kind.exported(dataset))}."
            raise fault("RESULTS", "must be response curves, which have peaks", kind.title, remedy)
    tables = {name: shown_table(peak_table(dataset), dataset) for name, dataset in datasets.items()}
    outside = {name: shown_table(outside_table(dataset), dataset) for name, dataset in datasets.items()}
    if as_json:
        say_json({"results": [of_peaks(name, dataset, tables[name], outside[name]) for name, dataset in datasets.items()]})
        return
    for name, dataset in datasets.items():
        say(f"{name}: {dataset.attrs.get('title', '')}" if name else str(dataset.attrs.get("title", "")))
        if sentence := further_curves_sentence(dataset):
            say(sentence)
        say(_lines_of(tables[name]) if len(tables[name]) else "No peak inside the band.")
        if len(outside[name]):
            say(f"{OUTSIDE}\n{_lines_of(outside[name])}")
        for sentence in (*failures_of(dataset), *warnings_of(dataset)):
            say(f"warning: {sentence}")


def _lines_of(table: pd.DataFrame) -> str:
    """A table as lines."""
    return str(table.to_string(index=False, na_rep="", float_format=lambda value: f"{value:.6g}"))


@guarded
def plot(
    ctx: typer.Context,
    results: Annotated[Path, Argument(help="results.nc, or the folder that a run or the demo wrote.")],
    figure: Annotated[
        Texts,
        Option(help="Name of a figure; also motion and deformed_shape, if available; may be repeated. Default: all figures."),
    ] = None,
    format: Annotated[
        Texts, Option(help="png, svg, pdf; for motion gif, mp4, webp, html; may be repeated. Default: png and svg, or gif.")
    ] = None,
    out: Annotated[Path | None, Option(help="Folder of the figures; default: `figures` beside the results.")] = None,
) -> None:
    """Draw the figures of results as files for papers and slides, and what moves as films or pages."""
    from stickslip.results.files import open_results

    files = results_in(results)
    say_several(files, results)
    folder = out or (results if results.is_dir() else results.parent)
    for name, file in files.items():
        place = folder / name if out else folder / name / FIGURES
        for path in drawn(open_results(file), writable_folder(place), figure or (), format or ()):
            say(f"Wrote {path}")


@guarded
def export(
    ctx: typer.Context,
    results: Annotated[Path, Argument(help="results.nc, or the folder that a run or the demo wrote.")],
    out: Annotated[
        Path,
        Option(
            help="NAME.csv, a table of the curves (peaks, bounds, percentiles, stress: NAME_peaks.csv, ...); NAME.mat for "
            "MATLAB; NAME.vtu, the deformed shapes at the highest peaks for ParaView, contacts at rest: NAME_contacts.vtu."
        ),
    ],
    quantity: Annotated[
        Text,
        Option(
            help="displacement, velocity, acceleration; receptance, mobility, inertance. Default: that of the result's peaks."
        ),
    ] = None,
    per_force: Annotated[
        bool, Option("--per-force", help="Divide the quantity by the force, which makes a velocity a mobility.")
    ] = False,
    overwrite: Annotated[bool, Option("--overwrite", help="Replace existing files.")] = False,
) -> None:
    """Write results as tables (CSV) or for MATLAB (.mat), as displacement, velocity or acceleration, absolute or per force, or
    the deformed shapes for VTK (.vtu), in the units of the study."""
    from stickslip.results.files import open_results
    from stickslip.results.quantities import other_peaks, peak_table, quantity_table
    from stickslip.results.schema import shown_table
    from stickslip.show.report.markup import presentation_of
    from stickslip.show.report.responses import further_tables

    if out.suffix not in (".csv", ".mat", ".vtu"):
        raise fault("--out", "must end in .csv, .mat or .vtu", str(out))
    sources = results_in(results)
    say_several(sources, results)
    datasets = {name: open_results(file) for name, file in sources.items()}
    for dataset in datasets.values() if quantity is not None or per_force else ():
        refuse_quantity(presentation_of(dataset), dataset, quantity)
    if out.suffix == ".vtu":
        export_shapes(datasets, out, overwrite)
        return
    if out.suffix == ".mat":
        from stickslip.results.files import save_mat

        refuse_existing([out], overwrite)
        say(f"Wrote {save_mat(datasets, out, quantity, per_force)}")
        return
    if all(presentation_of(dataset).responses for dataset in datasets.values()):
        files = {
            path: table_of({name: shown_table(make(dataset, quantity, per_force), dataset) for name, dataset in datasets.items()})
            for path, make in ((out, quantity_table), (out.with_name(f"{out.stem}_peaks.csv"), peak_table))
        }
        further = {
            name: {caption: shown_table(table, dataset) for caption, table in further_tables(dataset).items()}
            for name, dataset in datasets.items()
        }
        files |= captioned(further, out)
        notes = dict.fromkeys(filter(None, (other_peaks(dataset, quantity) for dataset in datasets.values())))
    else:
        tables = {name: presentation_of(dataset).exported(dataset) for name, dataset in datasets.items()}
        files, notes = captioned(tables, out), {}
    refuse_existing(files, overwrite)
    for path, table in files.items():
        write_text(path, without_formulas(table).to_csv(index=False))
        say(f"Wrote {path}")
    for sentence in notes:
        say(sentence)


def export_shapes(datasets: Mapping[str, xr.Dataset], out: Path, overwrite: bool) -> None:
    """Write the deformed shapes of each result, and the nodes of its contact surfaces; of several results NAME_RESULT.vtu."""
    from stickslip.analyses.solved_points import has_shapes, kept_shapes
    from stickslip.show.plots.deformed_shape import save_contacts_vtu, save_vtu

    files = {out.with_name(f"{out.stem}_{name}.vtu") if len(datasets) > 1 else out: each for name, each in datasets.items()}
    nodes = {path.with_name(f"{path.stem}_contacts.vtu"): each for path, each in files.items() if each.sizes.get("contact_node")}
    files = {path: each for path, each in files.items() if has_shapes(each) or not each.sizes.get("contact_node")}
    refuse_existing([*files, *nodes], overwrite)
    for path, dataset in files.items():
        say(f"Wrote {save_vtu(kept_shapes(dataset) if has_shapes(dataset) else {}, path)}")
    for path, dataset in nodes.items():
        say(f"Wrote {save_contacts_vtu(dataset, path)}")


def refuse_quantity(presentation: Presentation, dataset: xr.Dataset, quantity: str | None) -> None:
    """Refuse a quantity for results that are no response curves, whose tables have columns of their own."""
    if presentation.responses:
        return
    option, value = ("--per-force", True) if quantity is None else ("--quantity", quantity)
    tables = ", ".join(presentation.exported(dataset))
    remedy = f"Leave it out: {presentation.title} results are exported as they are, {tables}."
    raise fault(option, "must stand with response curves, of which alone other quantities are made", value, remedy)


def say_several(files: Mapping[str, Path], folder: Path) -> None:
    """That a folder without results of its own stands for those of the folders in it."""
    if "" not in files:
        say(f"{folder} holds no results.nc itself; together, those of its folders: {', '.join(files)}.")


def captioned(tables: Mapping[str, Mapping[str, pd.DataFrame]], out: Path) -> dict[Path, pd.DataFrame]:
    """Tables by caption of each result, each caption for NAME_CAPTION.csv."""
    return {
        out.with_name(f"{out.stem}_{caption.replace(' ', '_')}.csv"): table_of(
            {name: named[caption] for name, named in tables.items() if caption in named}
        )
        for caption in dict.fromkeys(caption for named in tables.values() for caption in named)
    }


def table_of(tables: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """One table, or several as one with a first column `result`."""
    several = len(tables) > 1
    return pd.concat(
        table.assign(result=name)[["result", *table.columns]] if several else table for name, table in tables.items()
    )


def without_formulas(table: pd.DataFrame) -> pd.DataFrame:
    """The table with an apostrophe before each text that a spreadsheet would take for a formula, in cells and titles; numbers
    stay. Source: OWASP, CSV Injection."""

    def plain(value: Any) -> Any:
        return FORMULA.sub("'", value) if isinstance(value, str) else value

    return table.map(plain).rename(columns=plain)


def refuse_existing(files: Iterable[Path], overwrite: bool) -> None:
    """Refuse to replace files without `overwrite`, and always what is no plain file."""
    for file in files:
        refuse_obstacle(file)
    existing = [str(file) for file in files if file.exists()]
    if existing and not overwrite:
        raise fault("--out", "must name files that do not exist", ", ".join(existing), "Name another, or add --overwrite.")


@only_own_files()
def write_reports(datasets: Mapping[str, xr.Dataset], folder: Path, figures: bool = False) -> None:
    """report.html for all; the figures of each where they are wanted, or lie there from an earlier time."""
    from stickslip.show.report import write

    single = datasets.get("") if len(datasets) == 1 else None
    page = write(datasets if single is None else single, folder / "report.html")
    for name, dataset in datasets.items():
        place = folder / name / FIGURES
        if figures or WrittenFiles(place).exists:
            drawn(dataset, place)
    say(f"Report: {page}")


@only_own_files()
def drawn(dataset: xr.Dataset, folder: Path, names: Sequence[str] = (), formats: Sequence[str] = ()) -> list[Path]:
    """Figures of a result as files, all without names, moving pictures where they or their formats are asked for; the paths."""
    from stickslip.show.plots.paper import write_figures
    from stickslip.show.report.markup import presentation_of
    from stickslip.show.report.page import moving_pictures

    figures, moving = presentation_of(dataset).figures(dataset), moving_pictures(dataset)
    known = (*OF_FIGURES, *(OF_MOTION if moving else ()))
    unknown = [each for each in formats if each not in known]
    if unknown:
        raise fault("--format", f"must be {', '.join(known[:-1])} or {known[-1]}", unknown[0])
    asked = {name: [key for key in moving if key == name or key.startswith(f"{name}_")] for name in names if name not in figures}
    missing, films = [name for name in asked if not asked[name]], [key for keys in asked.values() for key in keys]
    if missing:
        raise fault("--figure", "must be a figure of these results", missing[0], nearest(missing[0], [*figures, *moving]))
    as_figures, as_films = ([each for each in formats or FORMATS if each in own] for own in (OF_FIGURES, OF_MOTION))
    if films and not as_films:
        raise fault("--format", f"must be {', '.join(OF_MOTION)} for {films[0]}", formats[0])
    drawings = {name: figures[name] for name in (names or figures) if name in figures}
    if names and drawings and not as_figures:
        raise fault("--format", f"must be {', '.join(OF_FIGURES)} for {next(iter(drawings))}", formats[0])
    chosen = films if names else moving if formats else ()
    pictures = {folder / f"{key}.{suffix}": moving[key] for key in chosen for suffix in as_films}
    for path in (*(folder / f"{name}.{suffix}" for name in drawings for suffix in as_figures), *pictures):
        refuse_obstacle(path)
        WrittenFiles(folder).refuse_others(path)
    paths = write_figures(drawings, dataset, folder, tuple(as_figures))
    return paths + [picture.save(path) for path, picture in pictures.items()]


@guarded
def explore(
    ctx: typer.Context,
    study: Annotated[Path, Argument(help="Study file of a forced response, or of any analysis with a [sweep].")],
    port: Annotated[int, Option(help="Port on this computer; default: any free one.")] = 0,
    browser: Annotated[bool, Option(help="Open the page in the browser.")] = True,
) -> None:
    """Change a study with sliders on a local page and watch its response. Needs `pip install 'stickslip[explore]'`."""
    try:
        from stickslip.show.explorer.page import explore as serve
    except ModuleNotFoundError:
        remedy = "`pip install 'stickslip[explore]'` installs it."
        raise InputError(f"The explorer needs Dash, which is not installed. {remedy}") from None
    serve(study, port, browser)
