"""The command `contact-law`: from measured loops of one contact to law, stiffness and friction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated

import typer

from stickslip.cli.app import guarded
from stickslip.cli.places import free_folder
from stickslip.cli.studies import Figures, Overwrite, Resume, carry_out
from stickslip.support.checks import existing, fault
from stickslip.support.console import say


@guarded
def contact_law(
    ctx: typer.Context,
    files: Annotated[
        list[Path], typer.Argument(help="Recorded loops (text or .mat): many cycles in a file, or one file for each cycle.")
    ],
    normal_load: Annotated[
        float | None, typer.Option(help="Normal load in N; required unless the files have a column of it.")
    ] = None,
    law: Annotated[
        list[str] | None,
        typer.Option(help="jenkins, iwan, dahl, array or valanis; may be repeated. Default: all but valanis."),
    ] = None,
    rig_stiffness: Annotated[
        float | None,
        typer.Option(help="Stiffness of the rig between displacement sensor and contact, in N/µm; kt is corrected for it."),
    ] = None,
    lag: Annotated[
        float | None, typer.Option(help="Share of a period by which the force is recorded later than the displacement.")
    ] = None,
    friction_over: Annotated[
        list[float] | None,
        typer.Option(metavar="LOAD", help="Normal load in N at which the friction coefficient is identified; may be repeated."),
    ] = None,
    column: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=COLUMN", help="Title or number of a column: displacement, force, normal, time."),
    ] = None,
    unit: Annotated[list[str] | None, typer.Option(metavar="NAME=UNIT", help="Unit of a column, such as force=kN.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder of the results; default: results/NAME of the first file.")] = None,
    resume: Resume = False,
    overwrite: Overwrite = False,
    figures: Figures = False,
) -> None:
    """Find law, stiffness and friction of one contact, with intervals, from its measured loops."""
    from stickslip import study
    from stickslip.study.run import Run

    existing("FILES", files)
    named = {
        "columns": pairs("--column", column or (), "force=2"),
        "column_units": pairs("--unit", unit or (), "displacement=um"),
    }
    stiffness = None if rig_stiffness is None else 1e6 * rig_stiffness
    given = {"normal_load": normal_load, "rig_stiffness": stiffness, "laws": law or None, "lag": lag}
    text = study_text(files, given | {"friction_over": friction_over or None}, named)
    job = study.job(text, Path(), "contact law")
    folder = free_folder(out or Path("results") / files[0].stem, [""], resume, overwrite)
    carry_out(Run({"": job}, folder, resume, 1), figures)
    say(f"Results: {folder}")


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


def study_text(files: Sequence[Path], settings: Mapping[str, object], named: Mapping[str, Mapping[str, str]]) -> str:
    """The study that the command stands for; the results keep it."""
    from stickslip.study.toml_text import toml_text

    table = {
        "files": [str(path.resolve()) for path in files],
        **settings,
        **{key: values for key, values in named.items() if values},
    }
    study = {"title": f"Law of a contact: {files[0].stem}", "analysis": "contact_law"}
    return toml_text({"study": study, "contact_law": table})
