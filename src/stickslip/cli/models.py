"""The command `info`: description of a finite-element model."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stickslip.cli.app import guarded
from stickslip.cli.results import Json, of_model, say_json
from stickslip.support.console import progress_bar, say


@guarded
def info(
    ctx: typer.Context,
    model: Annotated[Path, typer.Argument(help="Finite-element model; of two files, that of the stiffness matrix.")],
    units: Annotated[str, typer.Option(help="Units of the file: SI, mm-t-s, mm-kg-s or mm-kg-ms.")] = "SI",
    names: Annotated[Path | None, typer.Option(help="Names, coordinates, sets: a deck or a table (CSV).")] = None,
    variables: Annotated[
        list[str] | None,
        typer.Option(metavar="LETTER=NAME", help="Name of a matrix in the file, such as K=KELAST or M=rom.M; may be repeated."),
    ] = None,
    no_damping: Annotated[bool, typer.Option("--no-damping", help="Ignore the matrix C of the file.")] = False,
    modes: Annotated[int, typer.Option(min=1, max=1000, help="Number of lowest modes to print.")] = 10,
    as_json: Json = False,
) -> None:
    """Describe a finite-element model: size, mass, extent, sets, first modes, rigid motions, and what is odd."""
    import warnings

    from stickslip.model.readers.describe import describe
    from stickslip.model.readers.read import read_model
    from stickslip.support.checks import fault

    named = {}
    for text in variables or ():
        letter, equals, name = text.partition("=")
        if not equals:
            raise fault("--variables", "must be LETTER=NAME, such as K=KELAST", text)
        named[letter.strip()] = name.strip()
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
