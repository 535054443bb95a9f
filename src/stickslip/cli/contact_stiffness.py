"""The command `contact-stiffness`: contact stiffness from geometry."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stickslip.cli.app import guarded
from stickslip.cli.results import refuse_existing
from stickslip.support.checks import fault
from stickslip.support.console import say

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
