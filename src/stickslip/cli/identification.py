"""The commands `contact-law`, from measured loops of one contact to law, stiffness and friction, and `contact-stiffness`, from
geometry.

The command `identify-response`: from measured frequency responses to contact parameters. The command `predict`: from its results
to responses and decays that were not measured.

The command `decay`: frequency and damping over the amplitude of a ring-down test, beside the nonlinear mode of a study.
"""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer import Argument, Option

from stickslip.cli.app import Number, Text, Texts, claimed, free_folder, guarded, pairs
from stickslip.cli.results import refuse_existing
from stickslip.cli.studies import Figures, Overwrite, Resume, Workers, carry_out_one, cores, finish
from stickslip.support.checks import InputError, existing, fault, finite, nearest
from stickslip.support.console import progress_bar, say
from stickslip.support.files import only_own_files
from stickslip.support.late import xr

if TYPE_CHECKING:
    from stickslip.laboratory.measurement.decay import MeasuredDecay
    from stickslip.study.fields import Units


@guarded
def contact_law(
    ctx: typer.Context,
    files: Annotated[
        list[Path], Argument(help="Recorded loops (text or .mat): many cycles in a file, or one file for each cycle.")
    ],
    normal_load: Annotated[Number, Option(help="Normal load in N; required unless the files have a column of it.")] = None,
    law: Annotated[
        Texts, Option(help="jenkins, iwan, dahl, array or valanis; may be repeated. Default: all but valanis.")
    ] = None,
    rig_stiffness: Annotated[
        Number, Option(help="Stiffness of the rig between displacement sensor and contact, in N/µm; kt is corrected for it.")
    ] = None,
    lag: Annotated[Number, Option(help="Share of a period by which the force is recorded later than the displacement.")] = None,
    friction_over: Annotated[
        list[float] | None,
        Option(metavar="LOAD", help="Normal load in N at which the friction coefficient is identified; may be repeated."),
    ] = None,
    column: Annotated[
        Texts, Option(metavar="NAME=COLUMN", help="Title or number of a column: displacement, force, normal, time.")
    ] = None,
    unit: Annotated[Texts, Option(metavar="NAME=UNIT", help="Unit of a column, such as force=kN.")] = None,
    out: Annotated[Path | None, Option(help="Folder of the results; default: results/NAME of the first file.")] = None,
    resume: Resume = False,
    overwrite: Overwrite = False,
    figures: Figures = False,
) -> None:
    """Find law, stiffness and friction of one contact, with intervals, from its measured loops."""
    from stickslip import study
    from stickslip.study.toml_text import toml_text

    existing("FILES", files)
    table: dict[str, Any] = {"files": [str(path.resolve()) for path in files], "normal_load": normal_load, "laws": law or None}
    table |= {"rig_stiffness": None if rig_stiffness is None else 1e6 * rig_stiffness, "lag": lag}
    table |= {"friction_over": friction_over or None, "columns": pairs("--column", column or (), "force=2") or None}
    table |= {"column_units": pairs("--unit", unit or (), "displacement=um") or None}
    about = {"title": f"Law of a contact: {files[0].stem}", "analysis": "contact_law"}
    job = study.job(toml_text({"study": about, "contact_law": table}), Path(), "contact law")
    carry_out_one(job, out or Path("results") / files[0].stem, resume, overwrite, figures)


@guarded
def contact_stiffness(
    ctx: typer.Context,
    length: Annotated[float, Option(help="Length of the line, mm.")],
    radius: Annotated[float, Option(help="Radius of the cylinder, or of the edges of a punch, mm.")],
    load: Annotated[Number, Option(help="Normal load, N.")] = None,
    pull: Annotated[Number, Option(help="Instead of a load: centrifugal force F_C on the damper, N.")] = None,
    platform_angle: Annotated[float, Option(help="With --pull: N = F_C/(2 cos angle), degrees.")] = 0.0,
    flat: Annotated[float, Option(help="Half length of the flat part of a punch, mm; 0 for a cylinder.")] = 0.0,
    young: Annotated[float, Option(help="Young's modulus, GPa.")] = 210.0,
    poisson: Annotated[float, Option(help="Poisson's ratio.")] = 0.3,
    out: Annotated[Path | None, Option(help="Figure of the stiffness against the load, .png or .svg.")] = None,
    overwrite: Annotated[bool, Option("--overwrite", help="Replace an existing figure.")] = False,
) -> None:
    """Stiffness of a line contact from geometry: Harris, Brändlein, Allara; print it and draw it against the load."""
    from stickslip.analyses.hysteresis_loop import contact_stiffness as stiffness_over
    from stickslip.model.contact.stiffness import LineContact, static_normal_load
    from stickslip.show.plots.paper import write_figure
    from stickslip.support.units import mm

    if (load is None) == (pull is None):
        raise fault("--load and --pull", "must be given one without the other", {"load": load, "pull": pull})
    at = static_normal_load(pull, platform_angle) if pull is not None else float(load or 0.0)
    if length < 0.1:
        raise fault("--length", "must be in mm, at least 0.1", length, f"Did you give metres? Then it is {1e3 * length:g} mm.")
    contact = LineContact(length * mm, radius * mm, flat * mm, young * 1e9, poisson)
    here = stiffness_over(contact, [at], at).dataset.isel(load=0)
    say(f"Normal load {at:.6g} N; half width of the contact {float(here.half_width) * 1e6:.4g} um")
    for formula, value in zip(here.formula.values, here.normal_stiffness.values, strict=True):
        say(f"  normal, {formula + ':':<20} {value:.4g} N/m")
    for name, value in (("across the line:", here.tangential_across), ("along the line:", here.tangential_along)):
        say(f"  tangential, {name:<16} {float(value):.4g} N/m (initial, all of it stuck; measured ones are softer)")
    if out is not None:
        refuse_existing([out], overwrite)
        loads = [at * step / 100.0 for step in range(2, 301, 2)]
        if out.suffix not in (".png", ".svg"):
            raise fault("--out", "must end in .png or .svg", str(out))
        write_figure(stiffness_over(contact, loads, at).plot(), out, out.suffix[1:])
        say(f"Wrote {out}")


@guarded
def identify_response(
    ctx: typer.Context,
    problem: Annotated[str, Argument(help="Study file that states structure and contacts, or the name of a ready rig.")],
    curves: Annotated[
        list[Path],
        Argument(
            help="Measured curves (text, .mat or universal files): frequency, force, and amplitude (with phase) or real and "
            "imaginary parts."
        ),
    ],
    free: Annotated[
        Texts,
        Option(
            metavar="NAME=LOW:HIGH",
            help="Parameter to find: an argument of a rig in SI (NAME=START:LOW:HIGH too), or a factor on the kt, kn, mu, "
            "preload, damping, mass or stiffness of a study. A name alone: from a tenth to ten times its value.",
        ),
    ] = None,
    argument: Annotated[Texts, Option("--set", metavar="NAME=VALUE", help="Any other argument of the rig, in SI.")] = None,
    setting: Annotated[
        Texts,
        Option(
            metavar="NAME=V1,V2,...", help="Quantity that differs between the curves, one value for each, such as pull=40,60."
        ),
    ] = None,
    each_test: Annotated[Texts, Option(help="Free parameter with a value of its own for every curve.")] = None,
    by: Annotated[
        Text,
        Option(
            metavar="COLUMN",
            help="Title or number of the column that distinguishes the curves of a file, such as curve; function for universal "
            "files.",
        ),
    ] = None,
    quantity: Annotated[
        Text, Option(help="displacement, velocity or acceleration; default: what the column titles of the files say.")
    ] = None,
    force: Annotated[
        Text, Option(metavar="F1,F2,...", help="Force in N, of each curve or one for all, for files without a force column.")
    ] = None,
    phase_of: Annotated[
        Text, Option(help="Whose phase the files contain: displacement or quantity; default for responses per force: quantity.")
    ] = None,
    column: Annotated[
        Texts,
        Option(
            metavar="NAME=COLUMN",
            help="Title or number of a column: frequency, amplitude, real, imaginary, phase, force. In universal files the "
            "function of the amplitude, such as 'amplitude=12:+Z / 1:+X', or of the force.",
        ),
    ] = None,
    unit: Annotated[Texts, Option(metavar="NAME=UNIT", help="Unit of a column, such as real=mm/N.")] = None,
    output: Annotated[Text, Option(help="Name of the measured output; default: the first.")] = None,
    held: Annotated[Text, Option(help="Which measured value is prescribed at each point: force (default) or response.")] = None,
    error: Annotated[Number, Option(help="Relative standard error of a point; default: 0.01.")] = None,
    of_largest: Annotated[
        bool | None, Option("--of-largest", help="The error is relative to the largest response of a curve.")
    ] = None,
    free_gain: Annotated[bool | None, Option("--free-gain", help="Also identify a constant factor of each curve.")] = None,
    free_phase: Annotated[bool | None, Option("--free-phase", help="Also identify a constant phase of each curve.")] = None,
    start_states: Annotated[Text, Option(help="Start states of the contacts: virgin (default) or free.")] = None,
    joints: Annotated[
        Text, Option(metavar="A,A,B", help="Joint of each curve, by a name: the curves of a joint are left out together.")
    ] = None,
    leave_one_out: Annotated[
        bool | None, Option("--leave-one-out", help="Also predict each curve, or each joint, from the others.")
    ] = None,
    harmonics: Annotated[int | None, Option(help="Highest harmonic H; default: that of the study, else 5.")] = None,
    out: Annotated[Path | None, Option(help="Folder of the results; default: results/NAME of the problem.")] = None,
    resume: Resume = False,
    overwrite: Overwrite = False,
    figures: Figures = False,
) -> None:
    """Find contact parameters, with intervals, from measured frequency responses."""
    from stickslip import study
    from stickslip.study.measured_curves import document_of, with_curves
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
    carry_out_one(job, out or Path("results") / Path(problem).stem, resume, overwrite, figures)


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


def low_and_high(option: str, text: str, rule: str) -> tuple[float, float]:
    """The two numbers of LOW:HIGH; rule: their unit, and what else may be given."""
    ends = [number(option, end) for end in text.split(":")]
    if len(ends) != 2:
        raise fault(option, f"must be LOW:HIGH in {rule}", text)
    return ends[0], ends[1]


@guarded
def decay(
    ctx: typer.Context,
    file: Annotated[Path, Argument(help="Recorded ring-down (text, .mat or universal file): time and motion.")],
    study: Annotated[
        Path | None, Option(help="Study file of the structure; its nonlinear mode is computed for comparison.")
    ] = None,
    output: Annotated[Text, Option(help="Output of this study that was measured; default: the first.")] = None,
    band: Annotated[
        Text, Option(metavar="LOW:HIGH", help="Band in Hz that contains the frequency; default: around the largest motion.")
    ] = None,
    cycles: Annotated[
        Number, Option(help="Length of the windows to which a damped sine is fitted, in cycles; default: the best.")
    ] = None,
    begin: Annotated[Number, Option(help="Time in s before which the record is ignored, such as a blow.")] = None,
    quantity: Annotated[Text, Option(help="displacement, velocity or acceleration; default: as the file states.")] = None,
    column: Annotated[
        Texts,
        Option(
            metavar="NAME=COLUMN",
            help="Title or number of the column of time or signal; in .mat and universal files, of the vector or function. Give "
            "signal several times for several sensors, which are evaluated together.",
        ),
    ] = None,
    unit: Annotated[Texts, Option(metavar="NAME=UNIT", help="Unit of a column, such as signal=g.")] = None,
    out: Annotated[Path | None, Option(help="Folder of the results; default: results/NAME of the file.")] = None,
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
    settings |= {} if band is None else {"band": low_and_high("--band", band, "Hz")}
    signals = [text for text in column or () if text.partition("=")[0].strip() == "signal"]
    others = [text for text in column or () if text not in signals]
    columns: dict[str, Any] = pairs("--column", [*others, *signals[:1]], "signal=2")
    if len(signals) > 1:
        columns["signal"] = [pairs("--column", [text], "signal=2")["signal"] for text in signals]
    units = pairs("--unit", unit or (), "signal=g")
    decay = read_decay(file, columns=columns, units=units, quantity=quantity, **settings)
    folder = free_folder(out or Path("results") / file.stem, [""], False, overwrite)
    with claimed(folder), only_own_files():
        dataset = stamped((decay if study is None else beside_modes(decay, study, output)).dataset, "measured_decay")
        save(dataset, folder / "results.nc")
        say_windows(dataset)
        finish({"": dataset}, folder, figures)
    say(f"Results: {folder}")


def say_windows(dataset: "xr.Dataset") -> None:
    """Amplitude, frequency and damping with their standard errors, a line a window."""
    from stickslip.results.view import length_text
    from stickslip.show.report.free_decay import ANSWER, measured_tables

    for _, (amplitude, frequency, hertz, ratio, percent) in measured_tables(dataset)[ANSWER].iterrows():
        where = length_text(float(amplitude), dataset)
        say(f"{where:>12}  {frequency:10.5g} ± {hertz:<8.2g} Hz  damping {ratio:8.4g} ± {percent:<8.2g} %")


def beside_modes(decay: "MeasuredDecay", study: Path, output: str | None) -> "MeasuredDecay":
    """The decay with the nonlinear mode of a study whose stuck frequency is nearest to that of the smallest amplitude."""
    from dataclasses import replace

    import numpy as np

    from stickslip.analyses.modes.nonlinear_modes import nonlinear_modes
    from stickslip.results.schema import attributes_of
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
        Texts,
        Option(
            metavar="A",
            help="Held amplitudes of the measured quantity in place of force levels, in m/s², m/s or m: their phase resonances.",
        ),
    ] = None,
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
    options = {option: given for option, given in (("--force", force), ("--amplitude", amplitude)) if given}
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
        one_kind_of_level(options, bool(compare))
        given = [level for option, texts in options.items() for level in levels(option, texts)]
        table |= {"force" if force else "amplitude": given} | curves
    table = {key: value for key, value in table.items() if value not in (None, [], {})}
    document = with_prediction(document, DECAY if decay else RESPONSES, table, band)
    job = study.job(toml_text(document), folder, "prediction")
    own = identification if identification.is_dir() else identification.parent
    own = own if own.name not in ("", "..") else own.resolve()
    place = out or own.with_name(f"{own.name}_prediction")
    carry_out_one(job, place, resume, overwrite, figures, cores() if workers is None else workers)


def one_kind_of_level(options: Mapping[str, list[str]], compared: bool) -> None:
    """Refuse levels of both options, and none without curves that state them."""
    if len(options) > 1:
        given = " and ".join(", ".join(texts) for texts in options.values())
        raise InputError(f"{' and '.join(options)} must not be given together, but are: {given}. Give one of them.")
    if not options and not compared:
        raise fault("--force", "must be given, or --amplitude for held amplitudes, --compare or --decay", "none")


def of_decay(given: list[str], units: "Units") -> dict[str, Any]:
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


def document_in(dataset: "xr.Dataset") -> dict[str, Any]:
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
