"""The command-line application: global options and exit codes. Heavy imports stay inside the commands, so help is fast.

Output folders, and checks before anything in them is overwritten.
"""

import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import wraps
from pathlib import Path
from typing import Annotated, Any, TypeAlias

import typer
from typer import Option

import stickslip
from stickslip.support.checks import InputError, counted, fault
from stickslip.support.console import INTERRUPTED, TERMINATED, plain_warnings, report_fault, say
from stickslip.support.files import WrittenFiles, refuse_linked_folder, refuse_obstacle
from stickslip.support.interrupts import termination_as_interrupt

app = typer.Typer(
    name="stickslip",
    help="Vibration of blades and bladed disks with friction dampers.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


# Options without a default, the last one repeated.
Number: TypeAlias = float | None
Text: TypeAlias = str | None
Texts: TypeAlias = list[str] | None


def main(arguments: Sequence[str] | None = None) -> None:
    """Entry point; ends with an exit code and never with a traceback, unless asked by --debug."""
    app(args=None if arguments is None else list(arguments), prog_name="stickslip")


def guarded(command: Callable[..., None]) -> Callable[..., None]:
    """A command whose errors become a message and an exit code."""

    @wraps(command)
    def with_messages(ctx: typer.Context, **arguments: Any) -> None:
        with plain_warnings(), termination_as_interrupt() as terminated:
            try:
                command(ctx, **arguments)
            except (Exception, KeyboardInterrupt) as error:
                if isinstance(error, typer.Exit) or ctx.obj:
                    raise
                code = report_fault(error)
                raise typer.Exit(TERMINATED if code == INTERRUPTED and terminated.is_set() else code) from None

    return with_messages


def pairs(option: str, given: Sequence[str], example: str) -> dict[str, str]:
    """Names and values of NAME=VALUE, such as the example."""
    found = {}
    for text in given:
        name, sign, value = text.partition("=")
        if not sign or not name.strip() or not value.strip():
            raise fault(option, f"must be NAME=VALUE, such as {example}", text)
        if name.strip() in found:
            raise fault(option, f"must give {name.strip()} once", list(given))
        found[name.strip()] = value.strip()
    return found


def _version(asked: bool) -> None:
    if asked:
        say(f"stickslip {stickslip.__version__}")
        raise typer.Exit


@app.callback()
def _options(
    ctx: typer.Context,
    version: Annotated[bool, Option("--version", callback=_version, is_eager=True, help="Show the version.")] = False,
    debug: Annotated[bool, Option("--debug", help="Show the traceback of an error.")] = False,
) -> None:
    ctx.obj = debug


def writable_folder(folder: Path) -> Path:
    """The folder; refused when it is a link or nothing can be written there. What is made to find out is removed again."""
    refuse_linked_folder(folder)
    try:
        with made(folder), tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError as error:
        raise fault("The output folder", "must be a folder that can be written", str(folder), f"({error.strerror})") from None


@contextmanager
def made(folder: Path) -> Iterator[None]:
    """Make a folder and those above it; of what was made, remove at the end of the block what holds nothing."""
    missing = [each for each in (folder, *folder.parents) if not each.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    try:
        yield
    finally:
        with suppress(OSError):  # of a folder that holds something this fails
            for each in missing:
                WrittenFiles(each).remove_list_alone()
                each.rmdir()


def free_folder(folder: Path, names: Sequence[str], resume: bool, overwrite: bool, reads: Sequence[Path] = ()) -> Path:
    """The folder for results of these names; refused if it already holds some and neither `resume` nor `overwrite` is given, and
    always where they would replace what stickslip did not write, or results that are read."""
    if resume and overwrite:
        raise fault("--resume and --overwrite", "must not be given together", "both", "Leave one out.")
    writable_folder(folder)
    for name in names:
        refuse_other_than_folder(folder / name)
    written = [folder / name / "results.nc" for name in names] + [folder / "report.html"]
    found = [file for file in written if os.path.lexists(file)]
    for file in found:
        if any(one.exists() and file.exists() and one.samefile(file) for one in reads):
            raise fault("--out", "must not be the folder of the results that are read", str(folder), "Name another folder.")
    if found and not (resume or overwrite):
        remedy = "Name another folder, or add --overwrite to replace them, or --resume to finish an interrupted run."
        held = found[0].relative_to(folder)
        raise InputError(f"--out must name a folder without results, but {str(folder)!r} holds {str(held)!r}. {remedy}")
    for file in found:
        refuse_obstacle(file)
        WrittenFiles(file.parent).refuse_others(file)
    finished = _finished(folder, names)
    if finished and not (resume or overwrite):
        raise InputError(
            f"--out must name a folder without results, but {str(folder)!r} holds {counted(finished, 'finished curve')} of an "
            "interrupted run. Add --resume to go on with the same study, --overwrite to discard them, or name another folder."
        )
    return folder


def refuse_other_than_folder(folder: Path) -> None:
    """Refuse a link or a file where a folder will be written."""
    refuse_linked_folder(folder)
    if folder.exists() and not folder.is_dir():
        raise fault("The output folder", "must be a folder", str(folder), "It is a file: move it, or name another folder.")


def _finished(folder: Path, names: Sequence[str]) -> int:
    """How many cases of an interrupted run a folder keeps; refused where something else has the name of the checkpoint."""
    from stickslip.runs.cases import ABOUT, CheckpointFolder
    from stickslip.study.run import UNFINISHED

    kept = folder / UNFINISHED
    for name in ("", *names):
        refuse_other_than_folder(kept / name)
    if kept.exists() and not WrittenFiles(kept).exists:
        remedy = "It has no list of what stickslip wrote into it. Move it, or name another folder for the results."
        raise fault("The folder of an interrupted run", "must be made by stickslip", str(kept), remedy)
    WrittenFiles(kept).refuse_others(kept / ABOUT)
    return CheckpointFolder.count(kept)


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


@contextmanager
def claimed(folder: Path) -> Iterator[None]:
    """Keep other runs out of a folder while the block runs. The claim ends with the process, whatever ends it.

    Without locks of files in the system (Windows) nothing is claimed.
    """
    try:
        import fcntl
    except ImportError:
        yield
        return
    with made(folder):
        claim = os.open(folder, os.O_RDONLY)
        try:
            try:
                fcntl.flock(claim, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                remedy = "Wait for it, or name another folder."
                raise fault("--out", "must not be in use by another run", str(folder), remedy) from None
            yield
        finally:
            os.close(claim)
