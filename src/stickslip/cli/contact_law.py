"""The commands `contact-law`, from measured loops of one contact to law, stiffness and friction, and `contact-stiffness`, from
geometry."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stickslip.cli.app import guarded
from stickslip.cli.places import free_folder
from stickslip.cli.results import refuse_existing
from stickslip.cli.studies import Figures, Overwrite, Resume, carry_out
from stickslip.support.checks import existing, fault
from stickslip.support.console import say

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace an existing figure.")] = False,
) -> None:
    """Stiffness of a line contact from geometry: Harris, Brändlein, Allara; print it and draw it against the load."""
    from stickslip.analyses.contact_stiffness import contact_stiffness as stiffness_over
    from stickslip.model.contact.stiffness import LineContact, static_normal_load
    from stickslip.support.units import mm

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
        refuse_existing([out], overwrite)
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
    from stickslip.show.plots.files import write_figure

    if path.suffix not in (".png", ".svg"):
        raise fault("--out", "must end in .png or .svg", str(path))
    write_figure(figure, path, path.suffix[1:])
    return path
