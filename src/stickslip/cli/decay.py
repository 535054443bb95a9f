"""The command `decay`: frequency and damping over the amplitude of a ring-down test, beside the nonlinear mode of a study."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stickslip.cli.app import guarded
from stickslip.cli.contact_law import pairs
from stickslip.cli.identify_response import number
from stickslip.cli.places import claimed, free_folder
from stickslip.cli.studies import Figures, Overwrite, finish
from stickslip.support.checks import existing, fault, nearest
from stickslip.support.console import progress_bar, say
from stickslip.support.files import only_own_files
from stickslip.support.late import xr

if TYPE_CHECKING:
    from stickslip.laboratory.measurement.decay import MeasuredDecay


@guarded
def decay(
    ctx: typer.Context,
    file: Annotated[Path, typer.Argument(help="Recorded ring-down (text, .mat or universal file): time and motion.")],
    study: Annotated[
        Path | None, typer.Option(help="Study file of the structure; its nonlinear mode is computed for comparison.")
    ] = None,
    output: Annotated[str | None, typer.Option(help="Output of this study that was measured; default: the first.")] = None,
    band: Annotated[
        str | None,
        typer.Option(metavar="LOW:HIGH", help="Band in Hz that contains the frequency; default: around the largest motion."),
    ] = None,
    cycles: Annotated[
        float | None,
        typer.Option(help="Length of the windows to which a damped sine is fitted, in cycles; default: the best."),
    ] = None,
    begin: Annotated[float | None, typer.Option(help="Time in s before which the record is ignored, such as a blow.")] = None,
    quantity: Annotated[
        str | None, typer.Option(help="displacement, velocity or acceleration; default: as the file states.")
    ] = None,
    column: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=COLUMN",
            help="Title or number of the column of time or signal; in .mat and universal files, of the vector or function.",
        ),
    ] = None,
    unit: Annotated[list[str] | None, typer.Option(metavar="NAME=UNIT", help="Unit of a column, such as signal=g.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the results; default: results/NAME of the file.")] = None,
    overwrite: Overwrite = False,
    figures: Figures = False,
) -> None:
    """Find frequency and damping over the amplitude, with standard errors, from a measured free decay."""
    from stickslip.laboratory.measurement.decay import read_decay
    from stickslip.results.files import save
    from stickslip.results.schema import stamped

    existing("FILE", [file])
    if study is None and output is not None:
        raise fault("--output", "must go with --study, which names the outputs", output)
    settings: dict[str, Any] = {"cycles": cycles, "begin": begin}
    if band is not None:
        ends = [number("--band", end) for end in band.split(":")]
        if len(ends) != 2:
            raise fault("--band", "must be LOW:HIGH in Hz", band)
        settings["band"] = (ends[0], ends[1])
    columns, units = pairs("--column", column or (), "signal=2"), pairs("--unit", unit or (), "signal=g")
    decay = read_decay(file, columns=columns, units=units, quantity=quantity, **settings)
    folder = free_folder(out or Path("results") / file.stem, [""], False, overwrite)
    with claimed(folder), only_own_files():
        dataset = stamped((decay if study is None else beside_modes(decay, study, output)).dataset, "measured_decay")
        save(dataset, folder / "results.nc")
        say_windows(dataset)
        finish({"": dataset}, folder, figures)
    say(f"Results: {folder}")


def say_windows(dataset: xr.Dataset) -> None:
    """Amplitude, frequency and damping with their standard errors, a line a window."""
    from stickslip.results.view import length_text
    from stickslip.show.report.free_decay import ANSWER, measured_tables

    for _, (amplitude, frequency, hertz, ratio, percent) in measured_tables(dataset)[ANSWER].iterrows():
        where = length_text(float(amplitude), dataset)
        say(f"{where:>12}  {frequency:10.5g} ± {hertz:<8.2g} Hz  damping {ratio:8.4g} ± {percent:<8.2g} %")


def beside_modes(decay: MeasuredDecay, study: Path, output: str | None) -> MeasuredDecay:
    """The decay with the nonlinear mode of a study whose stuck frequency is nearest to that of the smallest amplitude."""
    from dataclasses import replace

    import numpy as np

    from stickslip.analyses.modes.nonlinear_modes import nonlinear_modes
    from stickslip.results.shown_units import attributes_of
    from stickslip.study import read
    from stickslip.study.analyses.free_decay import BEYOND

    existing("--study", [study])
    with progress_bar("Model") as report:
        job = read(study, report)
    for remark in job.remarks:
        say(remark)
    if job.sweep is None:
        raise fault("--study", "must be a study of a structure with contacts", job.analysis)
    names = list(job.sweep.problem.output_names)
    if output not in (None, *names):
        raise fault("--output", f"must be one of {', '.join(names)}", output, nearest(str(output), names))
    place = 0 if output is None else names.index(output)
    amplitude, frequency = (decay.dataset[key].values for key in ("amplitude", "frequency"))
    fineness: dict[str, Any] = {} if job.sweep.harmonics == "auto" else {"harmonics": job.sweep.harmonics}
    with progress_bar("Nonlinear mode") as report:
        modes = nonlinear_modes(
            job.sweep.problem,
            amplitude=(float(amplitude.min()) / BEYOND, float(amplitude.max()) * BEYOND),
            frequency=float(frequency[int(np.argmin(amplitude))]),
            output=place,
            samples=job.sweep.samples,
            progress=report,
            **fineness,
        )
    beside = decay.with_modes(modes, place)
    return replace(beside, dataset=beside.dataset.assign_attrs({"study": job.text, **attributes_of(job.units)}))
