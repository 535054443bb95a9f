"""What Python and study files say of one setting: equal defaults, and a wrong value in a file is refused where it stands."""

import inspect
import re
import tomllib
from contextlib import suppress
from dataclasses import fields, replace
from functools import partial

import pytest
from each import each

import stickslip as ss
from stickslip.analyses.settings import EXECUTION, Settings
from stickslip.laboratory.identification.contact_law.work import ContactLawWork
from stickslip.study import job
from stickslip.study.analysis import KINDS
from stickslip.study.tables import SweepTable
from stickslip.study.templates import KINDS as TEMPLATES
from stickslip.study.templates import write_new
from stickslip.study.toml_text import toml_text, with_line
from stickslip.support.checks import Faults, InputError
from stickslip.support.units import Band

FUNCTIONS = {
    "identification": "identify",
    "response_identification": "identify_response",
    "response_prediction": "predict_response",
    "decay_prediction": "predict_decay",
}
"""Analyses that have another name in Python."""

DIFFERENT_MEANING = {
    (
        "mistuned_population",
        "blade",
    ): "in Python the nodes of a blade (`blade_nodes` in a file), in a file the pattern of the blades",
    ("mistuned_population", "count"): "one disk, the default of a file, is `mistuned_disk` in Python",
    ("decay_prediction", "identification"): "in Python what was identified, in a file results to read it from, if any",
    ("decay_prediction", "amplitude"): "decays to compare with give it in a file; in Python they are compared afterwards",
    ("response_prediction", "identification"): "in Python what was identified, in a file results to read it from, if any",
    ("campbell", "harmonics"): "three suffice for a diagram; a file has those of [sweep]",
    ("run_up", "engine_orders"): "in Python a problem may hold its engine order",
    ("speed_sweep", "engine_orders"): "in Python a problem may hold its engine order",
}
"""Keys that mean something else in a file than the argument of that name, or have their default for a reason."""

NOTHING = (None, {}, (), "")


def defaults_in_files(analysis):
    """The default of every key of the tables of an analysis; its own tables go before [sweep]."""
    kind = KINDS[analysis]
    tables = [*([SweepTable] if kind.on_problem else []), *kind.tables.values()]
    fields = {key: field for table in tables for key, field in table.model_fields.items()}
    return {
        key: inspect.Parameter.empty if field.is_required() else field.get_default(call_default_factory=True, validated_data={})
        for key, field in fields.items()
    }


def plain(key, default):
    """A default as both sides mean it: one of a list is it alone, and the first output has the number 0 or no name."""
    if isinstance(default, list | tuple):
        default = default[0] if len(default) == 1 else tuple(default)
    return None if default in NOTHING or (key == "output" and default == 0) else default


@each("analysis", KINDS)
def test_a_setting_has_one_default_in_python_and_in_files(analysis):
    parameters = inspect.signature(getattr(ss, FUNCTIONS.get(analysis, analysis))).parameters
    differ = {
        key: (parameters[key].default, default)
        for key, default in defaults_in_files(analysis).items()
        if key in parameters and plain(key, parameters[key].default) != plain(key, default)
    }
    assert set(differ) == {key for name, key in DIFFERENT_MEANING if name == analysis}, differ


WRONG = ("1e50", "1e-50", "-1.0", '"text"')
"""Values too large and too small for any quantity, of the wrong sign, and of the wrong type."""

NUMBER = re.compile(r"(\w+) = (\[*)(-?[\d.]+(?:e-?\d+)?)\b(.*)")
"""A line of a study that gives a number, or a list that begins with one."""

PLACED = re.compile(r"Line \d+[,:] \[+\w+\]+")
SLOW = ("jointed_beams", "beams_with_a_gap", "bladed_disk", "two_blades")
"""Templates with finite-element models, whose tables others have too."""


def faults_of(text, folder):
    try:
        for work in job(text, folder, "study").plan.works.values():
            assert work.names
    except Faults as error:
        document = tomllib.loads(text)
        return [with_line(message, text, document) for message in error.faults]
    except InputError as error:
        return [str(error)]
    return []


@pytest.mark.parametrize("kind", [kind for kind in TEMPLATES if kind not in SLOW])
def test_a_wrong_value_is_refused_with_its_line_and_table(kind, tmp_path):
    path = tmp_path / f"{kind}.toml"
    write_new(kind, path)
    lines, refused, elsewhere = path.read_text().splitlines(), 0, []
    for k, line in enumerate(lines):
        if not (found := NUMBER.match(line)):
            continue
        key, opening, _, rest = found.groups()
        for value in WRONG:
            faults = faults_of("\n".join([*lines[:k], f"{key} = {opening}{value}{rest}", *lines[k + 1 :]]) + "\n", tmp_path)
            refused += bool(faults)
            elsewhere += [f"{key} = {value}: {fault}" for fault in faults if not PLACED.match(fault)]
    assert elsewhere == []
    assert refused > 0


LEFT_OUT = ("1e50", "1e-50", "-1.0", "1000000000", "[1e50]", "[1e50, 2e50]")
"""Values for keys that a template does not give, of which some have no number."""

WITH_A_FILE = {
    ("identification", "frequency"): "how many cycles the loops hold at that frequency",
    ("response_identification", "by"): "which columns the file of curves has",
    ("response_prediction", "by"): "which columns the file of curves to compare with has",
}
"""Keys whose wrong values a measured file shows; the message names that file."""


def with_key(text, table, key, value):
    """A study whose table begins with one more key; the table comes last where it is not there yet."""
    there = re.search(rf"(?m)^\[{table}\].*$", text)
    end = there.end() if there else len(text)
    return f"{text[:end]}{'' if there else f'{chr(10)}[{table}]'}\n{key} = {value}\n{text[end:]}"


@pytest.mark.parametrize("kind", [kind for kind in TEMPLATES if kind not in SLOW])
def test_a_wrong_value_of_a_key_that_a_template_leaves_out_is_refused_with_its_line(kind, tmp_path):
    path = tmp_path / f"{kind}.toml"
    write_new(kind, path)
    text = path.read_text()
    document, elsewhere = tomllib.loads(text), {}
    for table, model in KINDS[document["study"]["analysis"]].tables.items():
        for key in model.model_fields.keys() - document.get(table, {}):
            for value in LEFT_OUT:
                faults = faults_of(with_key(text, table, key, value), tmp_path)
                wrong = [fault for fault in faults if not PLACED.match(fault)]
                elsewhere |= {(table, key): [value, *wrong]} if wrong else {}
    assert elsewhere.keys() == {known for known in WITH_A_FILE if known[0] in KINDS[document["study"]["analysis"]].tables}, (
        elsewhere
    )


@each("value", ["1e50", "1e-50"])
def test_a_size_out_of_range_is_refused_with_a_remedy(value, tmp_path):
    path = tmp_path / "study.toml"
    write_new("damper_cycle", path, overwrite=True)
    (told,) = faults_of(re.sub(r"pull = [\d.]+", f"pull = {value}", path.read_text()), tmp_path)
    assert re.fullmatch(r"Line \d+, \[damper\]: pull must .*, but is 1e[+-]50\. Check its unit\.", told), told


OTHERS = {"force_levels": [0.3], "harmonics": 2, "samples": 384, "peak_tolerance": 1e-3, "quantity": "velocity", "measure": "rms"}
"""Keys of [sweep] with values that no template has."""

SHOWN_ONLY = {
    ("nonlinear_modes", "force_levels"): "where resonances of these levels lie on a mode, computed when all is solved",
    **dict.fromkeys(
        [("free_decay", "harmonics"), ("free_decay", "samples")],
        "of the modes, computed over the amplitudes of the decay after it",
    ),
}


@pytest.mark.parametrize("kind", [name for name, kind in KINDS.items() if kind.on_problem])
def test_a_key_of_the_sweep_acts_or_is_refused(kind, tmp_path):
    path = tmp_path / f"{kind}.toml"
    write_new(kind, path)
    document = tomllib.loads(path.read_text())

    def names(**changes):
        text = toml_text(document | {"sweep": document["sweep"] | changes})
        return [name for work in job(text, tmp_path, kind).plan.works.values() for name in work.names]

    before, ignored = names(), set()
    for key, value in OTHERS.items():
        try:
            unchanged = names(**{key: value}) == before
        except InputError as error:
            unchanged = "has no effect" not in str(error) or key not in str(error)
        ignored |= {(kind, key)} if unchanged else set()
    assert ignored == {known for known in SHOWN_ONLY if known[0] == kind}


NOT_IN_NAMES = {
    ("ForcedResponseWork", "choice"): "a sentence that tells how the harmonics were chosen",
    **dict.fromkeys(
        [("ForcedResponseSettings", field) for field in ("force", "harmonics", "samples", "tolerance")],
        "the work has levels, harmonics and samples as they are solved",
    ),
    ("DesignWork", "known"): "how many of the points were asked for, of which each is a case",
}
"""Fields of works on which no result of a case depends."""


def another(value):
    """A value of the same form; None where a form has no other."""
    match value:
        case bool():
            return not value
        case int():
            return 2 * value + 1
        case float():
            return 0.5 * value or 1.0
        case str():
            return {"displacement": "velocity", "amplitude": "rms"}.get(value, f"{value} and more")
        case Band():
            return Band(value.start, 2 * value.stop)
        case (bool() | int() | float() | str() | tuple() as first, *rest):
            return (another(first), *rest)
    return None


def forgotten(work):
    """Fields of a work and of its settings that its names do not tell apart; that of a contact law is made with the work."""
    found = set()
    if isinstance(work, ContactLawWork):
        return found
    for owner, changed in parts_of(work):
        for field in fields(owner):
            other = None if field.name in EXECUTION else another(getattr(owner, field.name))
            with suppress(InputError):
                if other is not None and tuple(changed(**{field.name: other}).names) == tuple(work.names):
                    found.add((type(owner).__name__, field.name))
    return found


def parts_of(work):
    """A work and the settings that it holds, each with a function that returns the work with fields of it changed."""
    yield work, partial(replace, work)
    if isinstance(getattr(work, "settings", None), Settings):
        yield work.settings, lambda **change: replace(work, settings=replace(work.settings, **change))


@pytest.mark.parametrize("kind", [kind for kind in TEMPLATES if kind not in SLOW])
def test_a_case_is_named_by_everything_that_its_result_depends_on(kind, tmp_path):
    path = tmp_path / f"{kind}.toml"
    write_new(kind, path)
    text = path.read_text().replace('harmonics = "auto"', "harmonics = 5")
    for work in job(text, tmp_path, kind).plan.works.values():
        owners = {type(owner).__name__ for owner, _ in parts_of(work)}
        assert forgotten(work) == {known for known in NOT_IN_NAMES if known[0] in owners}
