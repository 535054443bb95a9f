"""The command line. `app` is the application, `COMMANDS` lists its commands in the order of the help."""

from stickslip.cli.app import app, main
from stickslip.cli.compile_kernels import compile_kernels
from stickslip.cli.identification import contact_law, contact_stiffness, decay, identify_response, predict
from stickslip.cli.results import explore, export, peaks, plot, report
from stickslip.cli.studies import check, demo, identify, info, new, run

__all__ = ["COMMANDS", "app", "main"]

COMMANDS = (
    demo,
    new,
    check,
    info,
    run,
    explore,
    identify,
    contact_law,
    decay,
    identify_response,
    predict,
    report,
    peaks,
    plot,
    export,
    contact_stiffness,
)
for command in COMMANDS:
    app.command()(command)
app.command("compile")(compile_kernels)
