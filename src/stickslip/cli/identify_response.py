"""The command `identify-response`: from measured frequency responses to contact parameters."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from stickslip.cli.app import guarded
from stickslip.cli.contact_law import pairs
from stickslip.cli.places import free_folder
from stickslip.cli.studies import Figures, Overwrite, Resume, carry_out
from stickslip.support.checks import InputError, existing, fault, finite
from stickslip.support.console import say


@guarded
def identify_response(
    ctx: typer.Context,
    problem: Annotated[str, typer.Argument(help="Study file that states structure and contacts, or the name of a ready rig.")],
    curves: Annotated[
        list[Path],
        typer.Argument(
            help="Measured curves (text, .mat or universal files): frequency, force, and amplitude (with phase) or real and "
            "imaginary parts."
        ),
    ],
    free: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=LOW:HIGH",
            help="Parameter to find: an argument of a rig in SI (NAME=START:LOW:HIGH too), or a factor on the kt, kn, mu, "
            "preload, damping, mass or stiffness of a study. A name alone: from a tenth to ten times its value.",
        ),
    ] = None,
    argument: Annotated[
        list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="Any other argument of the rig, in SI.")
    ] = None,
    setting: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=V1,V2,...", help="Quantity that differs between the curves, one value for each, such as pull=40,60."
        ),
    ] = None,
    each_test: Annotated[list[str] | None, typer.Option(help="Free parameter with a value of its own for every curve.")] = None,
    by: Annotated[
        str | None,
        typer.Option(
            metavar="COLUMN",
            help="Title or number of the column that distinguishes the curves of a file, such as curve; function for universal "
            "files.",
        ),
    ] = None,
    quantity: Annotated[
        str | None, typer.Option(help="displacement, velocity or acceleration; default: what the column titles of the files say.")
    ] = None,
    force: Annotated[
        str | None,
        typer.Option(metavar="F1,F2,...", help="Force in N, of each curve or one for all, for files without a force column."),
    ] = None,
    phase_of: Annotated[
        str | None,
        typer.Option(help="Whose phase the files contain: displacement or quantity; default for responses per force: quantity."),
    ] = None,
    column: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=COLUMN",
            help="Title or number of a column: frequency, amplitude, real, imaginary, phase, force. In universal files the "
            "function of the amplitude, such as 'amplitude=12:+Z / 1:+X', or of the force.",
        ),
    ] = None,
    unit: Annotated[list[str] | None, typer.Option(metavar="NAME=UNIT", help="Unit of a column, such as real=mm/N.")] = None,
    output: Annotated[str | None, typer.Option(help="Name of the measured output; default: the first.")] = None,
    held: Annotated[
        str | None, typer.Option(help="Which measured value is prescribed at each point: force (default) or response.")
    ] = None,
    error: Annotated[float | None, typer.Option(help="Relative standard error of a point; default: 0.01.")] = None,
    of_largest: Annotated[
        bool | None, typer.Option("--of-largest", help="The error is relative to the largest response of a curve.")
    ] = None,
    free_gain: Annotated[bool | None, typer.Option("--free-gain", help="Also identify a constant factor of each curve.")] = None,
    free_phase: Annotated[bool | None, typer.Option("--free-phase", help="Also identify a constant phase of each curve.")] = None,
    start_states: Annotated[
        str | None, typer.Option(help="Start states of the contacts: virgin (default), free or bounds.")
    ] = None,
    joints: Annotated[
        str | None,
        typer.Option(metavar="A,A,B", help="Joint of each curve, by a name: the curves of a joint are left out together."),
    ] = None,
    leave_one_out: Annotated[
        bool | None, typer.Option("--leave-one-out", help="Also predict each curve, or each joint, from the others.")
    ] = None,
    harmonics: Annotated[int | None, typer.Option(help="Highest harmonic H; default: that of the study, else 5.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the results; default: results/NAME of the problem.")] = None,
    resume: Resume = False,
    overwrite: Overwrite = False,
    figures: Figures = False,
) -> None:
    """Find contact parameters, with intervals, from measured frequency responses."""
    from stickslip import study
    from stickslip.study.measured_curves import document_of, with_curves
    from stickslip.study.run import Run
    from stickslip.study.toml_text import toml_text

    existing("CURVES", curves)
    document, folder = document_of(problem)
    if harmonics is not None:
        document["sweep"] = {**document.get("sweep", {}), "harmonics": harmonics}
    table: dict[str, Any] = {"quantity": quantity, "output": output, "held": held, "error": error, "of_largest": of_largest}
    table |= {"free_gain": free_gain, "free_phase": free_phase, "start_states": start_states, "leave_one_out": leave_one_out}
    table |= {"joints": [name.strip() for name in joints.split(",")] if joints else None}
    table |= {"columns": pairs("--column", column or (), "real=3") or None}
    table |= {"column_units": pairs("--unit", unit or (), "real=mm/N") or None}
    table |= {"phase_of": phase_of, "force": [number("--force", one) for one in force.split(",")] if force else None}
    count = len(curves) if by is None else None
    table |= {"by": by, "each_test": each_test or None, "settings": settings_of(setting or (), count)}
    arguments = {name: argument_of(value) for name, value in pairs("--set", argument or (), "kt=2e5").items()}
    text = toml_text(with_curves(document, curves, free or (), arguments, table))
    job = study.job(text, folder, "responses")
    place = free_folder(out or Path("results") / Path(problem).stem, [""], resume, overwrite)
    say(f"{job.title}: {job.plan.summary}.")
    carry_out(Run({"": job}, place, resume, 1), figures)
    say(f"Results: {place}")


def settings_of(given: Sequence[str], count: int | None) -> list[dict[str, float]] | None:
    """For each curve, its own settings by name; None without any. count: of curves, if it is known before files are read."""
    found: list[dict[str, float]] = []
    for name, values in pairs("--setting", given, "pull=40,60").items():
        numbers = [number("--setting", one) for one in values.split(",")]
        count = len(numbers) if count is None else count
        found = found or [{} for _ in range(count)]
        if len(numbers) != count:
            raise fault(f"--setting {name}", f"must have {count} values, one for each curve", values)
        for one, value in zip(found, numbers, strict=True):
            one[name] = value
    return found if given else None


def argument_of(text: str) -> float:
    """The number in a text, whole where it is written so: a rig's count of elements is."""
    value = number("--set", text)
    return int(text) if re.fullmatch(r"\s*[+-]?\d+\s*", text) else value


def number(option: str, text: str) -> float:
    """The number in a text."""
    try:
        return finite(option, float(text))
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise fault(option, "must give numbers", text) from None
