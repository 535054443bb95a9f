"""The command-line application: global options and exit codes. Heavy imports stay inside the commands, so help is fast."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from typing import TYPE_CHECKING, Annotated, Any

import typer

import stickslip
from stickslip.support.console import INTERRUPTED, TERMINATED, plain_warnings, report_fault, say
from stickslip.support.interrupts import termination_as_interrupt

if TYPE_CHECKING:
    pass


app = typer.Typer(
    name="stickslip",
    help="Vibration of blades and bladed disks with friction dampers.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


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


def _version(asked: bool) -> None:
    if asked:
        say(f"stickslip {stickslip.__version__}")
        raise typer.Exit


@app.callback()
def _options(
    ctx: typer.Context,
    version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False,
) -> None:
    ctx.obj = debug
