"""The study that `identify-response` stands for: the problem of a study file, or a rig, and measured curves.

Measured loops from the command line, which replace those of a study.
"""

import inspect
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stickslip.model.rigs import RIGS
from stickslip.study.analyses.response_identification import (
    FACTORS,
    KIND,
    TABLE,
    ResponseIdentificationTable,
    measured_curves,
    start_between,
)
from stickslip.study.analysis import COMMON_KEYS
from stickslip.study.faults import parsed
from stickslip.study.reading import Job, job, text_of, toml
from stickslip.study.toml_text import toml_text
from stickslip.support.checks import existing, fault, nearest, similar_file

LOOPS = "identification"
"""The analysis of measured loops, and its table."""

UNSTATED = 10.0
"""Factor to either side of its value between which a parameter is searched that has no bounds."""

BESIDE = 1e-3
"""By which the band is wider than the curves on either side, relative."""


def document_of(problem: str) -> tuple[dict[str, Any], Path]:
    """The document of a study file, without the tables of another analysis than this one, and its folder; or that of a rig."""
    path = Path(problem)
    if path.is_file():
        document = toml(text_of(path))
        return {key: value for key, value in document.items() if key in (*COMMON_KEYS, TABLE)}, path.parent
    if problem not in RIGS:
        raise fault(
            "PROBLEM", "must be a study file that exists, or a ready rig", problem, similar_file(path) or nearest(problem, RIGS)
        )
    return {"structure": {"rig": problem}}, Path()


def with_curves(
    document: Mapping[str, Any],
    curves: Sequence[Path],
    free: Sequence[str],
    arguments: Mapping[str, float],
    settings: Mapping[str, Any],
) -> dict[str, Any]:
    """The document with these curves and free parameters in place of its own; arguments: of its rig; settings: of the table."""
    structure = dict(document.get("structure", {})) if isinstance(document.get("structure"), Mapping) else {}
    if arguments:
        if "rig" not in structure:
            raise fault("--set", "must go with a ready rig", list(arguments), "Write it into the study.")
        structure["parameters"] = {**structure.get("parameters", {}), **arguments}
    found = {**document, "study": {"title": "Parameters from responses", **document.get("study", {}), "analysis": TABLE}}
    found["structure"] = structure or document.get("structure")
    table = {
        key: value for key, value in document.get(TABLE, {}).items() if not free or key not in (*FACTORS, "rig", "each_test")
    }
    table |= {key: value for key, value in settings.items() if value is not None}
    table["files"] = [str(path.resolve()) for path in curves]
    found[TABLE] = {**table, **_free(free, structure)}
    if not {*FACTORS, "rig"} & {*found[TABLE]}:
        raise fault("--free", "must name a parameter at least", list(free), "Such as --free kt=1e5:1e7 --free mu.")
    found["sweep"] = _sweep(document.get("sweep", {}), found[TABLE])
    return found


def _sweep(given: Mapping[str, Any], table: Mapping[str, Any]) -> dict[str, Any]:
    """The [sweep] with a band, that of the curves unless it has one, with harmonics that an identification takes and without what
    has no effect on it: the study only states the problem, and its own analysis may have used the rest."""
    found = {key: value for key, value in given.items() if key not in KIND.without}
    if "frequency" not in found and "at" not in found:
        checked: Any = parsed(ResponseIdentificationTable, dict(table))
        all_of_them = [np.asarray(curve.frequency) for curve in measured_curves(checked, Path())]
        ends = min(map(np.min, all_of_them)), max(map(np.max, all_of_them))
        found["frequency"] = [float(ends[0]) * (1.0 - BESIDE), float(ends[1]) * (1.0 + BESIDE)]
    if found.get("harmonics") == "auto":
        del found["harmonics"]
    return found


def _free(free: Sequence[str], structure: Mapping[str, Any]) -> dict[str, Any]:
    """What is free, as the table has it: arguments of the rig, [start, low, high], or factors, [low, high]."""
    known = inspect.signature(RIGS[structure["rig"]]).parameters if structure.get("rig") in RIGS else {}
    of_rig: dict[str, list[float]] = {}
    factors: dict[str, list[float]] = {}
    names = [text.partition("=")[0].strip() for text in free]
    if len({*names}) < len(names):
        raise fault("--free", "must give each parameter once", list(free))
    for text in free:
        name, _, numbers = (part.strip() for part in text.partition("="))
        values = _numbers(text, numbers)
        if name in known:
            of_rig[name] = _of_rig(name, values, structure.get("parameters", {}).get(name, known[name].default))
        elif name in FACTORS:
            if len(values) == 3:
                raise fault("--free", f"must be {name}=LOW:HIGH, factors on the problem's own value", text)
            factors[name] = values or [1.0 / UNSTATED, UNSTATED]
        else:
            every = (*known, *FACTORS)
            raise fault("--free", f"must name one of {', '.join(dict.fromkeys(every))}", name, nearest(name, every))
    return factors | ({"rig": of_rig} if of_rig else {})


def _numbers(text: str, numbers: str) -> list[float]:
    """None, two or three numbers between colons."""
    try:
        values = [float(one) for one in numbers.split(":")] if numbers else []
    except ValueError:
        values = [np.nan]
    if len(values) not in (0, 2, 3) or not np.all(np.isfinite(values)):
        raise fault("--free", "must be NAME, NAME=LOW:HIGH or NAME=START:LOW:HIGH, such as kt=1e5:1e7", text)
    return values


def _of_rig(name: str, values: Sequence[float], present: Any) -> list[float]:
    """Start, low and high of an argument of a rig: it starts at its present value where the bounds hold that."""
    if len(values) == 3:
        return list(values)
    number = float(present) if isinstance(present, int | float) and not isinstance(present, bool) else float("nan")
    if not values:
        if not number > 0.0:
            raise fault("--free", f"must be {name}=LOW:HIGH for an argument without a positive value", name)
        return [number, number / UNSTATED, number * UNSTATED]
    low, high = values
    return [start_between(number, low, high), low, high]


def with_loops(study: Path, loops: Sequence[Path], laws: Sequence[str], removals: Sequence[Path]) -> Job:
    """The job of a study for other loops than its own, which count from the working folder, and other laws if named.

    Load removals belong to their loops: those of the study do not go with others.
    """
    document = toml(text_of(study))
    if (analysis := document.get("study", {}).get("analysis")) != LOOPS:
        raise fault("--damper", f'must be a study with analysis = "{LOOPS}"', analysis)
    for what, paths in (("LOOPS", loops), ("--load-removal", removals)):
        existing(what, paths)
    table = {**document.get(LOOPS, {}), "loops": [str(path.resolve()) for path in loops]}
    table["load_removal"] = [str(path.resolve()) for path in removals] or None
    table |= {"law": list(laws)} if laws else {}
    return job(toml_text({**document, LOOPS: table}), study.parent, study.stem)
