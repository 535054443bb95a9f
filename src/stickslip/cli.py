"""The command line: demo, new, check, info, run, report, export. Everything heavy loads inside the commands: help is quick."""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import stickslip
from stickslip.checks import fault, unique
from stickslip.console import INCOMPLETE, nothing_compiled_yet, progress, say, tell_fault, warn

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

    from stickslip.finished import FinishedFolder
    from stickslip.study import Job
    from stickslip.study.run import Run

app = typer.Typer(
    name="stickslip",
    help="Vibration of blades and bladed disks with friction dampers.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)

DEMO_MASSES = (2.6, 4.6, 6.6)
FAST_MASSES, FAST_LEVELS, FAST_HARMONICS = (4.6,), (1.0, 20.0, 80.0), 3


Resume = Annotated[bool, typer.Option("--resume", help="Go on where an interrupted run of the same study stopped.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace results that DIR holds.")]
Workers = Annotated[int | None, typer.Option(min=1, help="Curves computed side by side; the number of cores unless given.")]


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point; ends with an exit code and never with a traceback, unless asked by --debug."""
    app(args=None if arguments is None else list(arguments), prog_name="stickslip")


def guarded(command: Callable[..., None]) -> Callable[..., None]:
    """A command whose errors become a message and an exit code."""

    @wraps(command)
    def with_messages(ctx: typer.Context, **arguments: Any) -> None:
        try:
            command(ctx, **arguments)
        except (Exception, KeyboardInterrupt) as error:
            if isinstance(error, typer.Exit) or ctx.obj:
                raise
            raise typer.Exit(tell_fault(error)) from None

    return with_messages


def _version(asked: bool) -> None:
    if asked:
        say(f"stickslip {stickslip.__version__}")
        raise typer.Exit


@app.callback()
def _options(
    ctx: typer.Context,
    version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Say the version.")] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False,
) -> None:
    ctx.obj = debug


@app.command()
@guarded
def demo(
    ctx: typer.Context,
    out: Annotated[Path, typer.Option(help="Folder of the results.")] = Path("results/demo"),
    preload_mass: Annotated[list[float] | None, typer.Option(help="kg; may be given several times.")] = None,
    fast: Annotated[bool, typer.Option("--fast", help="One preload, three force levels, three harmonics.")] = False,
    resume: Resume = False,
    overwrite: Overwrite = False,
    workers: Workers = None,
) -> None:
    """Compute a turbine blade with two underplatform dampers, at six force levels and three preloads."""
    from stickslip import study
    from stickslip.study.run import Run
    from stickslip.study.templates import FORCE_LEVELS, single_blade_study

    masses = preload_mass or (FAST_MASSES if fast else DEMO_MASSES)
    names = [f"{mass:g}kg" for mass in masses]
    unique("--preload-mass", names)
    folder = free_folder(out, names, resume, overwrite)
    levels, harmonics = (FAST_LEVELS, FAST_HARMONICS) if fast else (FORCE_LEVELS, 5)
    say(f"Meshing and reducing the blade for {', '.join(f'{mass:g} kg' for mass in masses)}.")
    texts = [single_blade_study(mass, levels, harmonics) for mass in masses]
    jobs = {name: study.job(text, Path(), "demo") for name, text in zip(names, texts, strict=True)}
    carry_out(Run(jobs, folder, resume, workers or cores()))


@app.command()
@guarded
def new(
    ctx: typer.Context,
    kind: Annotated[
        str,
        typer.Argument(
            help="forced_response (a ready rig), lumped (matrices and contacts), model (of another program), blisk (a bladed "
            "disk), bounds or samples (start states), damper-cycle (a damper alone), performance "
            "(damper performance curves), design (of a damper), identification (of contact parameters)."
        ),
    ],
    file: Annotated[Path | None, typer.Argument(help="The study file; KIND.toml when left out.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite.")] = False,
) -> None:
    """Write a commented study file to begin with."""
    from stickslip.study.templates import write_new

    written = write_new(kind, file or Path(f"{kind}.toml"), force)
    say(f"Wrote {' and '.join(map(str, written))}. Next: stickslip run {written[0]} --out results/{written[0].stem}")


@app.command()
@guarded
def check(ctx: typer.Context, study: Annotated[Path, typer.Argument(help="The study file.")]) -> None:
    """Check a study without running it; names all its faults at once."""
    job = read_job(study)
    say(f"{study} is sound: {job.plan.summary}.")


@app.command()
@guarded
def info(
    ctx: typer.Context,
    model: Annotated[Path, typer.Argument(help="A finite-element model; of a pair of files that of the stiffness.")],
    units: Annotated[str, typer.Option(help="Units of the file: SI, mm-t-s, mm-kg-s or mm-kg-ms.")] = "SI",
    names: Annotated[Path | None, typer.Option(help="Mapping file (CSV) of nodes and directions.")] = None,
    modes: Annotated[int, typer.Option(min=1, max=1000, help="How many of the lowest modes.")] = 10,
) -> None:
    """Describe a finite-element model: size, mass, extent, sets, first modes, rigid motions, and what is odd."""
    import warnings

    from stickslip.models.describe import describe
    from stickslip.models.read import read_model

    with progress("Model") as tell, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the description says the same
        tell(0.0, "reading")
        found = read_model(model, units=units, names=names)
        tell(0.3, f"modes of {found.size} rows")
        description = describe(found, modes)
    say(str(description))


@app.command()
@guarded
def run(
    ctx: typer.Context,
    study: Annotated[Path, typer.Argument(help="The study file.")],
    out: Annotated[Path, typer.Option(help="Folder of the results.")],
    resume: Resume = False,
    overwrite: Overwrite = False,
    workers: Workers = None,
) -> None:
    """Compute a study: results.nc, report.html and figures. Ends with code 3 when a curve broke off before its end."""
    from stickslip.study.run import Run

    job = read_job(study)
    folder = free_folder(out, [""], resume, overwrite)
    say(f"{job.title}: {job.plan.summary}.")
    carry_out(Run({"": job}, folder, resume, workers or cores()))


@app.command()
@guarded
def identify(
    ctx: typer.Context,
    loops: Annotated[list[Path], typer.Argument(help="Measured loops (CSV), one file a case.")],
    damper: Annotated[Path, typer.Option(help="Study of an identification; its loops give way to these.")],
    out: Annotated[Path, typer.Option(help="Folder of the results.")],
    overwrite: Overwrite = False,
) -> None:
    """Find contact stiffness and friction of a damper, with intervals, from measured loops."""
    from stickslip.study.loops import with_loops
    from stickslip.study.run import Run

    job = with_loops(read_job(damper), loops)
    folder = free_folder(out, [""], False, overwrite)
    say(f"{job.title}: {job.plan.summary}.")
    carry_out(Run({"": job}, folder, False, 1))


@app.command()
@guarded
def report(
    ctx: typer.Context, results: Annotated[Path, typer.Argument(help="results.nc, or the folder that a run or the demo wrote.")]
) -> None:
    """Write the report and the figures of results again."""
    from stickslip.results import open_results

    files = results_in(results)
    folder = results if results.is_dir() else results.parent
    write_reports({name: open_results(file) for name, file in files.items()}, writable_folder(folder))


@app.command()
@guarded
def export(
    ctx: typer.Context,
    results: Annotated[Path, typer.Argument(help="results.nc, or the folder that a run or the demo wrote.")],
    out: Annotated[
        Path,
        typer.Option(help="NAME.csv, a table of the curves (that of the peaks goes to NAME_peaks.csv); or NAME.mat for MATLAB."),
    ],
    quantity: Annotated[str, typer.Option(help="displacement, velocity or acceleration.")] = "displacement",
    per_force: Annotated[bool, typer.Option("--per-force", help="Receptance, mobility or inertance.")] = False,
) -> None:
    """Write results as tables (CSV) or for MATLAB (.mat), as displacement, velocity or acceleration, absolute or per force."""
    from stickslip.quantities import peak_table, quantity_table
    from stickslip.report.presentation import presentation_of
    from stickslip.results import open_results

    if out.suffix not in (".csv", ".mat"):
        raise fault("--out", "must end in .csv or .mat", str(out))
    datasets = {name: open_results(file) for name, file in results_in(results).items()}
    if out.suffix == ".mat":
        from stickslip.results_matlab import save_all_mat

        say(f"Wrote {save_all_mat(datasets, out, quantity, per_force)}")
        return
    if not all(presentation_of(dataset).interactive for dataset in datasets.values()):
        export_tables(datasets, out)
        return
    for path, make in ((out, quantity_table), (out.with_name(f"{out.stem}_peaks.csv"), peak_table)):
        write_table({name: make(dataset, quantity, per_force) for name, dataset in datasets.items()}, path)
        say(f"Wrote {path}")


def export_tables(datasets: Mapping[str, xr.Dataset], out: Path) -> None:
    """The tables of an analysis other than a response, each to NAME_CAPTION.csv."""
    from stickslip.report.presentation import presentation_of

    tables = {name: presentation_of(dataset).tables(dataset) for name, dataset in datasets.items()}
    for caption in dict.fromkeys(caption for named in tables.values() for caption in named):
        path = out.with_name(f"{out.stem}_{caption.replace(' ', '_')}.csv")
        write_table({name: named[caption] for name, named in tables.items() if caption in named}, path)
        say(f"Wrote {path}")


@app.command(name="contact-stiffness")
@guarded
def contact_stiffness(
    ctx: typer.Context,
    length: Annotated[float, typer.Option(help="Length of the line, mm.")],
    radius: Annotated[float, typer.Option(help="Radius of the cylinder, or of the edges of a punch, mm.")],
    load: Annotated[float | None, typer.Option(help="Normal load, N.")] = None,
    pull: Annotated[float | None, typer.Option(help="Instead of a load: centrifugal force F_C on the damper, N.")] = None,
    platform_angle: Annotated[float, typer.Option(help="With --pull: N = F_C/(2 cos angle), degrees.")] = 0.0,
    flat: Annotated[float, typer.Option(help="Half length of the flat part of a punch, mm; 0 for a cylinder.")] = 0.0,
    young: Annotated[float, typer.Option(help="Young's modulus, GPa.")] = 210.0,
    poisson: Annotated[float, typer.Option(help="Poisson's ratio.")] = 0.3,
    out: Annotated[Path | None, typer.Option(help="Figure of the stiffness against the load, .png or .svg.")] = None,
) -> None:
    """Stiffness of a line contact from geometry: Harris, Brändlein, Allara; print it and draw it against the load."""
    from stickslip.analyses.contact_stiffness import contact_stiffness as stiffness_over
    from stickslip.contact.stiffness import LineContact, static_normal_load
    from stickslip.units import mm

    if (load is None) == (pull is None):
        raise fault("--load and --pull", "must be given one without the other", {"load": load, "pull": pull})
    at = static_normal_load(pull, platform_angle) if pull is not None else float(load or 0.0)
    refuse_metres(length)
    contact = LineContact(length * mm, radius * mm, flat * mm, young * 1e9, poisson)
    here = stiffness_over(contact, [at], at).dataset.isel(load=0)
    say(f"Normal load {at:.6g} N; half width of the contact {float(here.half_width) * 1e6:.4g} um")
    for formula, value in zip(here.formula.values, here.normal_stiffness.values, strict=True):
        say(f"  normal, {formula + ':':<20} {value:.4g} N/m")
    for name, value in (("across the line:", here.tangential_across), ("along the line:", here.tangential_along)):
        say(f"  tangential, {name:<16} {float(value):.4g} N/m (initial, all of it stuck; measured ones are softer)")
    if out is not None:
        say(f"Wrote {drawn_to(out, stiffness_over(contact, range_of_loads(at), at).plot())}")


def refuse_metres(length: float) -> None:
    """Lengths of less than a tenth of a millimetre are metres, given by mistake."""
    if length < 0.1:
        raise fault("--length", "must be in mm, at least 0.1", length, f"Did you give metres? Then it is {1e3 * length:g} mm.")


def range_of_loads(load: float) -> list[float]:
    """Loads round one, for a figure, N."""
    return [load * step / 100.0 for step in range(2, 301, 2)]


def drawn_to(path: Path, figure: Figure) -> Path:
    """The figure in a file, PNG or SVG by its ending."""
    from stickslip.plots.files import write_figure

    if path.suffix not in (".png", ".svg"):
        raise fault("--out", "must end in .png or .svg", str(path))
    path.parent.mkdir(parents=True, exist_ok=True)
    write_figure(figure, path, path.suffix[1:])
    return path


def write_table(tables: Mapping[str, pd.DataFrame], path: Path) -> None:
    """One CSV of one table, or of several with a first column `result`."""
    import pandas as pd

    from stickslip.files import write_text

    several = len(tables) > 1
    named = [table.assign(result=name)[["result", *table.columns]] if several else table for name, table in tables.items()]
    write_text(path, pd.concat(named).to_csv(index=False))


def cores() -> int:
    """Processor cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def writable_folder(folder: Path) -> Path:
    """The folder, made when it is missing; refused when nothing can be written there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError as error:
        raise fault("The output folder", "must be a folder that can be written", str(folder), f"({error.strerror})") from None


def free_folder(folder: Path, names: Sequence[str], resume: bool, overwrite: bool) -> Path:
    """The folder for results of these names; refused when it holds such results already, unless told what to do with them."""
    if resume and overwrite:
        raise fault("--resume and --overwrite", "must not be given together", "both", "Leave one out.")
    written = [folder / name / "results.nc" for name in names] + [folder / "report.html"]
    found = [file for file in written if file.exists()]
    if found and not (resume or overwrite):
        remedy = "Name another folder, or add --overwrite to replace them, or --resume to finish an interrupted run."
        raise fault("--out", "must name a folder without results", f"{found[0]} is there", remedy)
    return writable_folder(folder)


def results_in(place: Path) -> dict[str, Path]:
    """The results file, or those of a folder and of its folders, by name."""
    if not place.is_dir():
        return {"": place}
    if (place / "results.nc").is_file():
        return {"": place / "results.nc"}
    found = {file.parent.name: file for file in sorted(place.glob("*/results.nc"))}
    if not found:
        raise fault(
            "RESULTS", "must be results.nc, or a folder that holds it", str(place), "`stickslip run STUDY --out DIR` writes one."
        )
    return found


def read_job(path: Path) -> Job:
    """The study, with what is to be said of its model."""
    from stickslip.study import read

    with progress("Model") as tell:
        job = read(path, tell)
    for note in job.notes:
        say(note)
    return job


def carry_out(run: Run) -> None:
    """Compute what is missing, write everything, and only then let go of the finished curves."""
    kept = run.kept()
    with hint_at_resuming(kept):
        datasets = run.complete() if run.resume and not len(kept) else None
        if datasets is not None:
            say(f"Nothing is left to compute: the results in {run.folder} are complete.")
        else:
            say_kept(run, len(kept))
            with progress(run.words) as tell:
                datasets = run.computed(kept, tell)
        broken = finish(datasets, run.folder)
    kept.remove(kept.folder)
    if broken:
        raise typer.Exit(INCOMPLETE)


def say_kept(run: Run, count: int) -> None:
    """What an interrupted run left and whether it is used, and why the first run takes longer."""
    if run.resume and count:
        say(f"Going on from {count} finished curves in {run.folder / 'unfinished'}.")
    elif run.resume:
        say(f"No finished curves in {run.folder}: computing from the start.")
    elif count:
        warn(f"An interrupted run left {count} finished curves; they are computed again. Stop, and add --resume to use them.")
    if nothing_compiled_yet():
        warn("First run on this machine: the contact kernels are compiled, which takes up to a minute; they are kept on disk.")


@contextmanager
def hint_at_resuming(kept: FinishedFolder) -> Iterator[None]:
    """Whatever stops the block, say what is kept."""
    try:
        yield
    except (KeyboardInterrupt, OSError, MemoryError):
        if len(kept):
            warn(f"{len(kept)} finished curves are kept in {kept.folder}; the same command with --resume goes on from there.")
        raise


def finish(datasets: Mapping[str, xr.Dataset], folder: Path) -> list[str]:
    """What came out to the screen, report and figures to the folder; returns what failed."""
    from stickslip.report.presentation import presentation_of

    broken = []
    for name, dataset in datasets.items():
        presentation = presentation_of(dataset)
        for number, sentence in enumerate(presentation.sentences(dataset)):
            say(f"{name}: {sentence}" if name and number == 0 else sentence)
        broken += [f"{name} {message}".strip() for message in presentation.failures(dataset)]
    write_reports(datasets, folder)
    for message in broken:
        warn(message)
    return broken


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


if __name__ == "__main__":
    main(sys.argv[1:])
