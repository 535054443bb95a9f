"""Output folders, and checks before anything in them is overwritten."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from stickslip.support.checks import InputError, counted, fault


def writable_folder(folder: Path) -> Path:
    """The folder, made when it is missing; refused when nothing can be written there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError as error:
        raise fault("The output folder", "must be a folder that can be written", str(folder), f"({error.strerror})") from None


def remove_if_empty(folder: Path) -> None:
    """Leave no folder behind in which nothing was written."""
    with suppress(OSError):
        folder.rmdir()  # of a folder that holds something this fails


def free_folder(folder: Path, names: Sequence[str], resume: bool, overwrite: bool, reads: Sequence[Path] = ()) -> Path:
    """The folder for results of these names; refused if it already holds some and neither `resume` nor `overwrite` is given, and
    always where they would replace results that are read."""
    if resume and overwrite:
        raise fault("--resume and --overwrite", "must not be given together", "both", "Leave one out.")
    written = [folder / name / "results.nc" for name in names] + [folder / "report.html"]
    found = [file for file in written if file.exists()]
    for file in found:
        if any(one.exists() and one.samefile(file) for one in reads):
            raise fault("--out", "must not be the folder of the results that are read", str(folder), "Name another folder.")
    if found and not (resume or overwrite):
        remedy = "Name another folder, or add --overwrite to replace them, or --resume to finish an interrupted run."
        held = found[0].relative_to(folder)
        raise InputError(f"--out must name a folder without results, but {str(folder)!r} holds {str(held)!r}. {remedy}")
    finished = 0 if resume or overwrite else _finished(folder)
    if finished:
        raise InputError(
            f"--out must name a folder without results, but {str(folder)!r} holds {counted(finished, 'finished curve')} of an "
            "interrupted run. Add --resume to go on with the same study, --overwrite to discard them, or name another folder."
        )
    return writable_folder(folder)


def _finished(folder: Path) -> int:
    """How many cases of an interrupted run a folder keeps."""
    from stickslip.runs.checkpoint import CheckpointFolder
    from stickslip.study.run import UNFINISHED

    return CheckpointFolder.count(folder / UNFINISHED)


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
    claim = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(claim, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(claim)
        raise fault("--out", "must not be in use by another run", str(folder), "Wait for it, or name another folder.") from None
    try:
        yield
    finally:
        os.close(claim)
