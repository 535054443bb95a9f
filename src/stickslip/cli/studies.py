"""Commands on studies: `demo`, `new`, `check`, `run` and `identify`.

The command `info`: description of a finite-element model.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from typer import Argument, Option

from stickslip.cli.app import Text, Texts, claimed, free_folder, guarded, pairs, refuse_other_than_folder
from stickslip.cli.results import FIGURES, Json, of_model, of_study, say_json, write_reports
from stickslip.support.checks import Faults, InputError, counted, fault, listed, positive, unique
from stickslip.support.console import INCOMPLETE, WRONG_INPUT, progress_bar, say, warn
from stickslip.support.files import left_sentence, only_own_files, write_text
from stickslip.support.late import xr

if TYPE_CHECKING:
    from stickslip.runs.cases import CheckpointFolder
    from stickslip.runs.dask_cluster import DaskCluster
    from stickslip.study import Job
    from stickslip.study.run import Run

DEMO_MASSES = (2.6, 4.6, 6.6)
FAST_MASSES, FAST_LEVELS, FAST_HARMONICS = (4.6,), (1.0, 20.0, 80.0), 3


Resume = Annotated[bool, Option("--resume", help="Resume an interrupted run of the same study.")]
Overwrite = Annotated[bool, Option("--overwrite", help="Replace existing results.")]
Figures = Annotated[bool, Option("--figures", help="Write the figures as files too; `stickslip plot` can do so later.")]
Workers = Annotated[
    int | None, Option(min=1, help="Curves computed at the same time; default: the number of cores, or one for short studies.")
]
Scheduler = Annotated[
    str | None, Option(metavar="ADDRESS", help='Compute on the workers of this Dask scheduler, such as "tcp://10.0.0.1:8786".')
]


@guarded
def demo(
    ctx: typer.Context,
    out: Annotated[Path, Option(help="Folder of the results.")] = Path("results/demo"),
    preload_mass: Annotated[list[float] | None, Option(help="Preload mass in kg; may be repeated.")] = None,
    fast: Annotated[bool, Option("--fast", help="One preload, three force levels, three harmonics.")] = False,
    resume: Resume = False,
    overwrite: Overwrite = False,
    figures: Figures = False,
    workers: Workers = None,
) -> None:
    """Compute a turbine blade with two underplatform dampers, at six force levels and three preloads."""
    from stickslip import study
    from stickslip.study.run import Run
    from stickslip.study.templates import FORCE_LEVELS, single_blade_study

    masses = preload_mass or (FAST_MASSES if fast else DEMO_MASSES)
    names = [f"{published(mass):g}kg" for mass in masses]
    unique("--preload-mass", names)
    folder = free_folder(out, names, resume, overwrite)
    levels, harmonics = (FAST_LEVELS, FAST_HARMONICS) if fast else (FORCE_LEVELS, None)
    say(f"Meshing and reducing the blade for {', '.join(f'{mass:g} kg' for mass in masses)}.")
    texts = [single_blade_study(mass, levels, harmonics) for mass in masses]
    jobs = {name: study.job(text, Path(), "demo") for name, text in zip(names, texts, strict=True)}
    carry_out(Run(jobs, folder, resume, workers or cores()), figures)


def published(mass: float) -> float:
    """A preload mass of the demo, which has contact parameters."""
    if positive("--preload-mass", mass) not in DEMO_MASSES:
        remedy = "`stickslip new forced_response` writes a study for contact parameters of your own."
        raise fault("--preload-mass", "must be 2.6, 4.6 or 6.6, the masses with published contact parameters", mass, remedy)
    return mass


@guarded
def new(
    ctx: typer.Context,
    kind: Annotated[Text, Argument(help="Kind of study; without it, all kinds are listed.")] = None,
    file: Annotated[Path | None, Argument(help="Study file; default: KIND.toml.")] = None,
    force: Annotated[bool, Option("--force", help="Replace an existing file.")] = False,
) -> None:
    """Write a commented study file to begin with, or list the kinds of studies."""
    from stickslip.study.templates import kinds, write_new

    if kind is None:
        for name, purpose in kinds().items():
            say(f"{name:<25}{purpose}")
        return
    written = write_new(kind, file or Path(f"{kind}.toml"), force)
    say(f"Wrote {listed([str(path) for path in written])}. Next: stickslip run {written[0]} --out results/{written[0].stem}")


@guarded
def check(
    ctx: typer.Context,
    study: Annotated[Path, Argument(help="Study file.")],
    show: Annotated[bool, Option("--show", help="Draw the model into STUDY_model.html: mesh, contacts, forces.")] = False,
    as_json: Json = False,
) -> None:
    """Check a study without computing its curves, and list all its errors. Exit code 2 if there are any."""
    from stickslip.study.run_time import estimated_seconds, model_summary, run_memory, run_time

    if as_json:
        check_as_json(study, show)
        return
    job = prepared(read_job(study))
    say(f"{study} is valid: {job.plan.summary}.")
    for sentence in model_summary(job.sweep, job.plan.condition, job.units) if job.sweep else []:
        say(sentence)
    if time := run_time(job, estimated_seconds(job)):
        say(time)
    if memory := run_memory(job):
        say(memory)
    if show:
        say(f"Wrote {written_model(job, study)}: open it in a browser.")


def check_as_json(study: Path, show: bool) -> None:
    """The check as one JSON object, of a study with errors too; other lines go to the error stream."""
    from stickslip.study.run_time import estimated_seconds

    try:
        job = prepared(read_job(study, warn), warn)
        values = of_study(study, job, estimated_seconds(job))
        if show:
            values["model"] = str(written_model(job, study))
        say_json(values)
    except InputError as error:
        errors = error.faults if isinstance(error, Faults) else [str(error)]
        say_json({"study": str(study), "valid": False, "errors": errors})
        raise typer.Exit(WRONG_INPUT) from None


def written_model(job: Job, study: Path) -> Path:
    """A page with the model of a study, in its units, in the folder where the command runs."""
    from stickslip.show.plots.model_view import model_view

    if job.sweep is None:
        raise InputError(f"--show draws a structure with contacts, but {study} has none: its analysis takes a damper or records.")
    page: str = model_view(job.sweep.problem, job.units).to_plotly().to_html(include_plotlyjs=True)
    with only_own_files():
        return write_text(Path(f"{study.stem}_model.html"), page)


@guarded
def run(
    ctx: typer.Context,
    studies: Annotated[list[Path], Argument(metavar="STUDY...", help="One or more study files.")],
    out: Annotated[Path, Option(help="Folder of the results; each of several studies has its own folder in it.")],
    resume: Resume = False,
    overwrite: Overwrite = False,
    figures: Figures = False,
    workers: Workers = None,
    scheduler: Scheduler = None,
) -> None:
    """Compute a study, or several side by side, and write results.nc of each and one report.html. All are checked before the
    first is computed. Exit code 3 if a curve is incomplete."""
    from stickslip.runs.cases import Processes
    from stickslip.study.run import Run
    from stickslip.study.run_time import BRIEF, WORTH_SAYING, estimated_seconds, run_memory, run_time, stays_long

    jobs = read_jobs(studies)
    times = {name: estimated_seconds(job) for name, job in jobs.items()}
    brief = all(seconds is not None for seconds in times.values()) and sum(filter(None, times.values())) < BRIEF
    at_once = workers or (1 if brief else cores())
    executor = Processes(at_once, apart=any(map(stays_long, jobs.values()))) if scheduler is None else cluster(scheduler, workers)
    folder = free_folder(out, list(jobs), resume, overwrite, [file for job in jobs.values() for file in job.plan.reads])
    for name, job in jobs.items():
        say(f"{name + ': ' if name else ''}{job.title}: {job.plan.summary}.")
        seconds = times[name]
        if seconds is not None and seconds > WORTH_SAYING:
            say(run_time(job, seconds))
        if memory := run_memory(job, at_once):
            say(memory)
    carry_out(Run(jobs, folder, resume, executor), figures)


@guarded
def identify(
    ctx: typer.Context,
    loops: Annotated[list[Path], Argument(help="Measured loops (CSV), one file for each loop.")],
    damper: Annotated[Path, Option(help="Study of an identification; these loops replace its own.")],
    out: Annotated[Path, Option(help="Folder of the results.")],
    law: Annotated[
        Texts,
        Option(
            help="macroslip, iwan or microslip, instead of that of the study; of several, the errors on loops held out choose."
        ),
    ] = None,
    load_removal: Annotated[
        list[Path] | None,
        Option(
            metavar="FILE",
            help="Readings while the load is removed (CSV), which give the zeros: one file for all loops or one for each.",
        ),
    ] = None,
    resume: Resume = False,
    overwrite: Overwrite = False,
    figures: Figures = False,
) -> None:
    """Find contact stiffness and friction of a damper, with intervals, from measured loops."""
    from stickslip.study.measured_curves import with_loops

    carry_out_one(with_loops(damper, loops, law or (), load_removal or ()), out, resume, overwrite, figures)


def cluster(address: str, workers: int | None) -> DaskCluster:
    """Connect to the cluster at an address, and report its workers."""
    from stickslip.runs.dask_cluster import DaskCluster

    if workers is not None:
        raise fault("--workers", "must be left out with --scheduler, whose workers are used", workers)
    found = DaskCluster(address)
    say(f"{counted(found.workers(), 'worker')} at {address}. More may join at any time.")
    return found


def cores() -> int:
    """Processor cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def read_jobs(paths: Sequence[Path]) -> dict[str, Job]:
    """The studies by the names of their files, one study by an empty name; the errors of all of them are reported at once."""
    if len(paths) == 1:
        return {"": prepared(read_job(paths[0]))}
    unique("Names of study files", [path.stem for path in paths])
    jobs, errors = {}, []
    for path in paths:
        say(f"{path}:")
        try:
            jobs[path.stem] = prepared(read_job(path))
        except InputError as error:
            errors += [f"{path}: {message}" for message in (error.faults if isinstance(error, Faults) else [str(error)])]
    if errors:
        raise Faults(errors)
    return jobs


def read_job(path: Path, say: Callable[[str], None] = say) -> Job:
    """Read the study, and report the notes on its model."""
    from stickslip.study import read

    with progress_bar("Model") as report:
        job = read(path, report)
    for note in job.notes:
        say(note)
    return job


def prepared(job: Job, say: Callable[[str], None] = say) -> Job:
    """A job whose work is made: it reads the files that the study names, and chooses harmonics where this is left to it."""
    from stickslip.analyses.forced_response import ForcedResponseWork
    from stickslip.analyses.harmonic_choice import watched
    from stickslip.solve.balance.fourier import in_words

    if job.sweep is not None and job.sweep.harmonics == "auto":
        say("Choosing the harmonics and samples that the highest peaks need; this computes curves with few harmonics.")
        with progress_bar("Choosing harmonics", "to skip this step, give `harmonics` as a number") as report, watched(report):
            _ = job.plan.works
    for work in job.plan.works.values():
        if isinstance(work, ForcedResponseWork) and work.choice:
            say(f"Chosen: {in_words(work.harmonics)}, {work.samples} samples.")
    return job


def carry_out_one(job: Job, folder: Path, resume: bool, overwrite: bool, figures: bool, workers: int = 1) -> None:
    """Compute the study that a command stands for, and say where its results are."""
    from stickslip.study.run import Run

    place = free_folder(folder, [""], resume, overwrite, job.plan.reads)
    say(f"{job.title}: {job.plan.summary}.")
    carry_out(Run({"": job}, place, resume, workers), figures)
    say(f"Results: {place}")


def carry_out(run: Run, figures: bool = False) -> None:
    """Compute the missing cases and write everything; the checkpoint goes as soon as the results are on the disk."""
    for name in run.jobs if figures else ():
        refuse_other_than_folder(run.folder / name / FIGURES)
    with claimed(run.folder):
        broken = computed_and_written(run, figures)
    if broken:
        raise typer.Exit(INCOMPLETE)


def computed_and_written(run: Run, figures: bool) -> list[str]:
    """The work of `carry_out`; returns what failed."""
    kept = run.kept()
    with hint_at_resuming(kept):
        datasets = run.complete() if run.resume and not len(kept) else None
        if datasets is not None:
            say(f"Nothing to compute: the results in {run.folder} are complete.")
        else:
            say_kept(run, len(kept))
            datasets = computed(run, kept)
    if left := kept.remove(kept.folder):
        warn(left_sentence(left))
    with hint_at_the_report(run.folder):
        return finish(datasets, run.folder, figures)


def computed(run: Run, kept: CheckpointFolder) -> dict[str, xr.Dataset]:
    """The results; a study that turns out to be wrong before a curve is completed leaves nothing behind."""
    try:
        with progress_bar(run.words, "Ctrl-C stops it and keeps what is finished") as report:
            return run.computed(kept, report)
    except InputError:
        if len(kept):
            raise
        kept.remove(kept.folder)
        raise


def say_kept(run: Run, count: int) -> None:
    """What an interrupted run left and whether it is used."""
    if run.resume and count:
        say(f"Resuming from {counted(count, 'completed curve')} in {run.folder / 'unfinished'}.")
    elif run.resume:
        say(f"No interrupted run was found in {run.folder}: starting from the beginning.")
    elif count:
        warn(f"Not used: {counted(count, 'completed curve')} of an interrupted run. Stop and add --resume to use what is kept.")


@contextmanager
def hint_at_resuming(kept: CheckpointFolder) -> Iterator[None]:
    """Whatever stops the block, say what is kept."""
    try:
        yield
    except (KeyboardInterrupt, OSError, MemoryError, InputError) as error:
        so_far = [
            file.parent for file in (kept.folder / "results.nc", *sorted(kept.folder.glob("*/results.nc"))) if file.is_file()
        ]
        if isinstance(error, KeyboardInterrupt) and not so_far and not len(kept):
            warn("Nothing was kept yet: no part of the work was completed.")
        for folder in so_far:
            warn(f"Saved what was computed so far, unfinished curves too: `stickslip report {folder}` shows it.")
        if len(kept):
            curves = counted(len(kept), "completed curve")
            warn(f"Kept {curves} in {kept.folder}; run the same command with --resume to continue.")
        raise


@contextmanager
def hint_at_the_report(folder: Path) -> Iterator[None]:
    """Whatever stops the block, say that only the report may be missing."""
    try:
        yield
    except (KeyboardInterrupt, OSError, MemoryError):
        warn(f"The results in {folder} are complete; `stickslip report {folder}` writes the report.")
        raise


def finish(datasets: Mapping[str, xr.Dataset], folder: Path, figures: bool) -> list[str]:
    """What came out to the screen, the report to the folder; returns what failed."""
    from stickslip.show.report.markup import presentation_of

    broken = []
    for name, dataset in datasets.items():
        presentation = presentation_of(dataset)
        for number, sentence in enumerate(presentation.sentences(dataset)):
            say(f"{name}: {sentence}" if name and number == 0 else sentence)
        broken += [f"{name} {message}".strip() for message in presentation.failures(dataset)]
    write_reports(datasets, folder, figures)
    for message in broken:
        warn(message)
    return broken


@guarded
def info(
    ctx: typer.Context,
    model: Annotated[Path, Argument(help="Finite-element model; of two files, that of the stiffness matrix.")],
    units: Annotated[str, Option(help="Units of the file: SI, mm-t-s, mm-kg-s or mm-kg-ms.")] = "SI",
    names: Annotated[Path | None, Option(help="Names, coordinates, sets: a deck or a table (CSV).")] = None,
    variables: Annotated[
        Texts, Option(metavar="LETTER=NAME", help="Name of a matrix in the file, such as K=KELAST or M=rom.M; may be repeated.")
    ] = None,
    no_damping: Annotated[bool, Option("--no-damping", help="Ignore the matrix C of the file.")] = False,
    modes: Annotated[int, Option(min=1, max=1000, help="Number of lowest modes to print.")] = 10,
    as_json: Json = False,
) -> None:
    """Describe a finite-element model: size, mass, extent, sets, first modes, rigid motions, and what is odd."""
    import warnings

    from stickslip.model.readers.model import describe
    from stickslip.model.readers.read import read_model

    named = pairs("--variables", variables or (), "K=KELAST")
    with progress_bar("Model") as report, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the description says the same
        report(0.0, "reading")
        found = read_model(model, units=units, names=names, variables=named, own_damping=not no_damping)
        report(0.3, f"modes of {found.size} rows")
        description = describe(found, modes)
    if as_json:
        say_json(of_model(description))
    else:
        say(str(description))
