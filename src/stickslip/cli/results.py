"""Commands on results: `report` and `export`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stickslip.checks import fault
from stickslip.cli.app import guarded
from stickslip.cli.places import results_in, writable_folder
from stickslip.console import say

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


@guarded
def report(
    ctx: typer.Context, results: Annotated[Path, typer.Argument(help="results.nc, or the folder that a run or the demo wrote.")]
) -> None:
    """Write the report and the figures of results again."""
    from stickslip.results.files import open_results

    files = results_in(results)
    say_several(files, results)
    folder = results if results.is_dir() else results.parent
    write_reports({name: open_results(file) for name, file in files.items()}, writable_folder(folder))


@guarded
def export(
    ctx: typer.Context,
    results: Annotated[Path, typer.Argument(help="results.nc, or the folder that a run or the demo wrote.")],
    out: Annotated[
        Path,
        typer.Option(
            help="NAME.csv, a table of the curves (peaks, bounds, percentiles, stress: NAME_peaks.csv, ...); NAME.mat for MATLAB."
        ),
    ],
    quantity: Annotated[
        str | None,
        typer.Option(
            help="displacement, velocity, acceleration; receptance, mobility, inertance. That of the result's peaks unless given."
        ),
    ] = None,
    per_force: Annotated[bool, typer.Option("--per-force", help="The quantity per force: of a velocity the mobility.")] = False,
) -> None:
    """Write results as tables (CSV) or for MATLAB (.mat), as displacement, velocity or acceleration, absolute or per force."""
    from stickslip.report.presentation import presentation_of
    from stickslip.report.responses import further_tables
    from stickslip.results.files import open_results
    from stickslip.results.quantities import other_peaks, peak_table, quantity_table

    if out.suffix not in (".csv", ".mat"):
        raise fault("--out", "must end in .csv or .mat", str(out))
    files = results_in(results)
    say_several(files, results)
    datasets = {name: open_results(file) for name, file in files.items()}
    if out.suffix == ".mat":
        from stickslip.results.matlab import save_all_mat

        say(f"Wrote {save_all_mat(datasets, out, quantity, per_force)}")
        return
    if not all(presentation_of(dataset).interactive for dataset in datasets.values()):
        write_tables({name: presentation_of(dataset).tables(dataset) for name, dataset in datasets.items()}, out)
        return
    for path, make in ((out, quantity_table), (out.with_name(f"{out.stem}_peaks.csv"), peak_table)):
        write_table({name: make(dataset, quantity, per_force) for name, dataset in datasets.items()}, path)
        say(f"Wrote {path}")
    for sentence in dict.fromkeys(filter(None, (other_peaks(dataset, quantity) for dataset in datasets.values()))):
        say(sentence)
    write_tables({name: further_tables(dataset) for name, dataset in datasets.items()}, out)


def say_several(files: Mapping[str, Path], folder: Path) -> None:
    """That a folder without results of its own stands for those of the folders in it."""
    if "" not in files:
        say(f"{folder} holds no results.nc itself; together, those of its folders: {', '.join(files)}.")


def write_tables(tables: Mapping[str, Mapping[str, pd.DataFrame]], out: Path) -> None:
    """Tables by caption of each result, each caption to NAME_CAPTION.csv."""
    for caption in dict.fromkeys(caption for named in tables.values() for caption in named):
        path = out.with_name(f"{out.stem}_{caption.replace(' ', '_')}.csv")
        write_table({name: named[caption] for name, named in tables.items() if caption in named}, path)
        say(f"Wrote {path}")


def write_table(tables: Mapping[str, pd.DataFrame], path: Path) -> None:
    """One CSV of one table, or of several with a first column `result`."""
    import pandas as pd

    from stickslip.files import write_text

    several = len(tables) > 1
    named = [table.assign(result=name)[["result", *table.columns]] if several else table for name, table in tables.items()]
    write_text(path, pd.concat(named).to_csv(index=False))


def write_reports(datasets: Mapping[str, xr.Dataset], folder: Path) -> None:
    """report.html for all, and the figures of each."""
    from stickslip.plots.files import write_figures
    from stickslip.report import write
    from stickslip.report.presentation import presentation_of

    single = datasets.get("") if len(datasets) == 1 else None
    page = write(datasets if single is None else single, folder / "report.html")
    for name, dataset in datasets.items():
        write_figures(presentation_of(dataset).figures(dataset), dataset, folder / name / "figures")
    say(f"Report: {page}")
