"""The command `predict`: from the results of `identify-response` to responses and decays that were not measured."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer import Argument, Option

from stickslip.cli.app import Text, Texts, guarded, pairs
from stickslip.cli.identification import low_and_high, number
from stickslip.cli.studies import Figures, Overwrite, Resume, Workers, carry_out_one, cores
from stickslip.support.checks import InputError, existing, fault
from stickslip.support.late import xr

if TYPE_CHECKING:
    from stickslip.study.fields import Units

RESPONSES, DECAY, IDENTIFICATION = "response_prediction", "decay_prediction", "response_identification"

OPTIONS = {"compare_force": "--compare-force", "columns": "--column", "column_units": "--unit"}
"""Options whose names are not those of the keys that they fill."""


@guarded
def predict(
    ctx: typer.Context,
    *,
    identification: Annotated[Path, Argument(help="results.nc written by identify-response, or its folder.")],
    force: Annotated[Texts, Option(metavar="F", help="Force levels in N: --force 1 --force 5, or --force 1,5.")] = None,
    amplitude: Annotated[
        Texts, Option(metavar="A", help="Held amplitudes of the measured quantity in place of force levels, in m/s², m/s or m.")
    ] = None,
    acceleration: Annotated[Texts, Option(metavar="A", help="Held amplitudes in m/s², if accelerations were measured.")] = None,
    velocity: Annotated[Texts, Option(metavar="V", help="Held amplitudes in m/s, if velocities were measured.")] = None,
    displacement: Annotated[Texts, Option(metavar="U", help="Held amplitudes in m, if displacements were measured.")] = None,
    decay: Annotated[
        Texts,
        Option(
            metavar="LOW:HIGH|FILE",
            help="Free decay in place of responses: its amplitudes in m, or a measured decay to compare with (results of "
            "`stickslip decay`, or a recorded signal); may be repeated.",
        ),
    ] = None,
    mode: Annotated[
        int | None,
        Option(
            min=1, help="Mode of the stuck structure that decays, 1 the lowest; default: that of the measured decay or peaks."
        ),
    ] = None,
    setting: Annotated[
        Texts,
        Option(metavar="NAME=VALUE", help="Value of a quantity that differed between the measured curves, such as pull=50."),
    ] = None,
    band: Annotated[Text, Option(metavar="LOW:HIGH", help="Frequency band in Hz; default: that of the identification.")] = None,
    start_states: Annotated[
        Text, Option(help="Start states of the contacts: identified (default), virgin, or any (random, new for each draw).")
    ] = None,
    draws: Annotated[
        int | None, Option(help="Number of parameter sets drawn from the covariance of the fit; default: 40.")
    ] = None,
    seed: Annotated[int | None, Option(help="Seed of the random draws.")] = None,
    compare: Annotated[
        list[Path] | None, Option(help="File of measured curves to compare with (text, .mat, universal file); may be repeated.")
    ] = None,
    compare_force: Annotated[
        Text, Option(metavar="F1,F2,...", help="Force of each of these curves in N, for files without a force column.")
    ] = None,
    column: Annotated[
        Texts, Option(metavar="NAME=COLUMN", help="Column of a quantity, as in identify-response; default: its columns.")
    ] = None,
    unit: Annotated[Texts, Option(metavar="NAME=UNIT", help="Unit of a column of these files, such as real=mm/N.")] = None,
    by: Annotated[Text, Option(metavar="COLUMN", help="Column that distinguishes the curves of a file.")] = None,
    folder: Annotated[Path, Option(help="Folder that relative paths in the study of the identification start from.")] = Path(),
    out: Annotated[
        Path | None, Option(help="Folder of the results; default: FOLDER_prediction beside that of the identification.")
    ] = None,
    workers: Workers = None,
    resume: Resume = False,
    overwrite: Overwrite = False,
    figures: Figures = False,
) -> None:
    """Predict responses or a decay that were not measured, with intervals, from parameters found by `identify-response`."""
    from stickslip import study
    from stickslip.results.files import open_results
    from stickslip.study.reading import units_of
    from stickslip.study.toml_text import toml_text

    existing("--compare", compare or [])
    dataset = open_results(identification)
    document = document_in(dataset)
    motions = {"amplitude": amplitude, "acceleration": acceleration, "velocity": velocity, "displacement": displacement}
    options = {f"--{name}": given for name, given in {"force": force, **motions}.items() if given}
    values = pairs("--setting", setting or (), "pull=50")
    table: dict[str, Any] = {"identification": str(identification.resolve()), "draws": draws, "seed": seed}
    table |= {"settings": {name: number("--setting", value) for name, value in values.items()}, "start_states": start_states}
    curves: dict[str, Any] = {"compare_force": levels("--compare-force", [compare_force] if compare_force else None), "by": by}
    curves |= {"columns": pairs("--column", column or (), "real=3"), "column_units": pairs("--unit", unit or (), "real=mm/N")}
    curves |= {"compare": [str(path.resolve()) for path in compare or ()]}
    if decay:
        if beside := [*options, *(OPTIONS.get(key, f"--{key}") for key, value in curves.items() if value)]:
            raise InputError(
                f"--decay and {', '.join(beside)} must not be given together: --decay predicts a decay instead of "
                "responses; give a measured decay as its value, --decay FILE."
            )
        table |= of_decay(decay, units_of(document.get("units", {}))) | {"mode": mode}
    else:
        if mode is not None:
            raise InputError(f"--mode {mode} needs --decay.")
        one_kind_of_level(options, bool(compare), str(dataset["quantity"].values[0]))
        given = [level for option, texts in options.items() for level in levels(option, texts)]
        table |= {"force" if force else "amplitude": given} | curves
    table = {key: value for key, value in table.items() if value not in (None, [], {})}
    document = with_prediction(document, DECAY if decay else RESPONSES, table, band)
    job = study.job(toml_text(document), folder, "prediction")
    own = identification if identification.is_dir() else identification.parent
    own = own if own.name not in ("", "..") else own.resolve()
    place = out or own.with_name(f"{own.name}_prediction")
    carry_out_one(job, place, resume, overwrite, figures, cores() if workers is None else workers)


def one_kind_of_level(options: Mapping[str, list[str]], compared: bool, measured: str) -> None:
    """Refuse levels of several options, of another quantity than the measured one, and none without curves that state them."""
    if len(options) > 1:
        given = " and ".join(", ".join(texts) for texts in options.values())
        raise InputError(f"{' and '.join(options)} must not be given together, but are: {given}. Give one of them.")
    if not options and not compared:
        raise fault("--force", f"must be given, or --{measured} for held amplitudes, --compare or --decay", "none")
    from stickslip.solve.balance.measure import quantity_named

    for option in options:
        if option not in ("--force", "--amplitude", f"--{measured}"):
            remedy = f"Give --{measured}, in {quantity_named(measured)[0].units}."
            raise fault(option, f"must be the quantity that was measured, --{measured}", ", ".join(options[option]), remedy)


def of_decay(given: list[str], units: Units) -> dict[str, Any]:
    """The amplitudes, m, and the measured decays that --decay says, in the units of a study."""
    from stickslip.study.fields import LENGTH

    files = [text for text in given if Path(text).exists()]
    ranges = [text for text in given if text not in files]
    existing("--decay", [Path(text) for text in ranges if ":" not in text])
    if len(ranges) > 1:
        raise fault("--decay", "must give one range of amplitudes at most", ", ".join(ranges))
    ends = [end for text in ranges for end in low_and_high("--decay", text, "m, or a file")]
    return {"amplitude": [end / units.factor(LENGTH) for end in ends], "compare": [str(Path(text).resolve()) for text in files]}


def levels(option: str, given: Texts) -> list[float]:
    """The numbers of an option that may be given several times, or hold several between commas."""
    return [number(option, one) for text in given or () for one in text.split(",")]


def document_in(dataset: xr.Dataset) -> dict[str, Any]:
    """The study that made an identification; results without one are refused."""
    from stickslip.results.schema import analysis_of
    from stickslip.study.reading import toml

    if analysis_of(dataset) != IDENTIFICATION:
        rule = "must be the results of `stickslip identify-response`, or of a study of response_identification"
        raise fault("IDENTIFICATION", rule, analysis_of(dataset))
    text = str(dataset.attrs.get("study", ""))
    if not text:
        raise InputError(
            "IDENTIFICATION must contain the study that made it, but was made in Python, where the problem is a function. Use "
            "found.predict(force) there, with the result of identify_response, or write a study of the problem and run "
            "`stickslip identify-response STUDY CURVES`."
        )
    return toml(text)


def with_prediction(document: Mapping[str, Any], analysis: str, table: Mapping[str, Any], band: str | None) -> dict[str, Any]:
    """The study of the identification with the table of the prediction, and its band."""
    title = document["study"].get("title") or "Parameters from responses"
    found = {**document, "study": {**document["study"], "analysis": analysis, "title": f"{title}: prediction"}}
    found[analysis] = dict(table)
    if band is not None:
        sweep = {key: value for key, value in document["sweep"].items() if key != "at"}
        found["sweep"] = {**sweep, "frequency": [*low_and_high("--band", band, "Hz")]}
    return found
