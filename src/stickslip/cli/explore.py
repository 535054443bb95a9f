"""The command `explore`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from stickslip.cli.app import guarded


@guarded
def explore(
    ctx: typer.Context,
    study: Annotated[Path, typer.Argument(help="Study file of a forced response, or of any analysis with a [sweep].")],
    port: Annotated[int, typer.Option(help="Port on this computer; default: any free one.")] = 0,
    browser: Annotated[bool, typer.Option(help="Open the page in the browser.")] = True,
) -> None:
    """Change a study with sliders on a local page and watch its response. Needs `pip install 'stickslip[explore]'`."""
    from stickslip.show.explorer.server import explore as serve

    serve(study, port, browser)
