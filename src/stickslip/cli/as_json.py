"""What `info`, `check` and `peaks` print with `--json`: one JSON object, for scripts."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from stickslip.support.console import say
from stickslip.support.late import pd, xr

if TYPE_CHECKING:
    from stickslip.model.readers.describe import Description
    from stickslip.study import Job

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object for scripts, instead of text.")]
UNIT = re.compile(r"(.*) \[([^\]]+)\]")
"""The head of a column with its unit, "amplitude [mm]"."""


def say_json(values: dict[str, Any]) -> None:
    """Print an object; NaN and infinite numbers, which JSON lacks, become null."""
    say(json.dumps(plain(values), ensure_ascii=False, indent=1, allow_nan=False))


def plain(value: Any) -> Any:
    """Arrays as lists, NumPy's numbers as Python's, numbers that are not finite as None."""
    if isinstance(value, dict):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    return None if isinstance(value, float) and not np.isfinite(value) else value


def of_model(found: Description) -> dict[str, Any]:
    """The description of a model, in SI and Hz."""
    model, modes = found.model, found.modes
    matrices = {"M": model.M, "K": model.K} | ({} if model.C is None else {"C": model.C})
    return {
        "format": model.format,
        "rows": model.size,
        "entries": {name: matrix.nnz for name, matrix in matrices.items()},
        "nodes": len(model.directions),
        "located_nodes": len(model.located[0]),
        "sets": {name: len(nodes) for name, nodes in model.sets.items()},
        "box": found.box,
        "mass": dict(zip("xyz", found.mass, strict=True)),
        "rigid_motions": None if modes is None else modes.rigid,
        "negative_motions": None if modes is None else modes.negative,
        "frequencies": None if modes is None else modes.frequencies,
        "modes_there": None if modes is None else modes.count.there,
        "there_below": None if modes is None else modes.count.hertz,
        "units": {"box": "m", "mass": "kg", "frequencies": "Hz", "there_below": "Hz"},
        "warnings": found.odd,
    }


def of_study(study: Path, job: Job, seconds: float | None) -> dict[str, Any]:
    """A study without errors: its notes, the numbers of its model in the units of the study, the estimated time of a run."""
    from stickslip.model.problem.at_rest import normal_loads_at_rest
    from stickslip.results.shown_units import in_system
    from stickslip.study.run import WARNING

    values = {
        "study": str(study),
        "valid": True,
        "errors": [],
        "analysis": job.analysis,
        "title": job.title,
        "summary": job.plan.summary,
        "notes": [note for note in job.notes if not note.startswith(WARNING)],
        "warnings": [note.removeprefix(WARNING) for note in job.notes if note.startswith(WARNING)],
        "estimated_seconds": seconds,
    }
    if job.sweep is None:
        return values
    problem, (newtons, force) = job.sweep.problem, in_system("N", job.units)
    limits = {"no_contacts": False, "contacts_stuck": True}
    return values | {
        "frequencies": {name: problem.frequencies(stuck=stuck) for name, stuck in limits.items()},
        "normal_loads": {name: newtons * load for name, load in normal_loads_at_rest(problem).items()},
        "units": {"frequencies": "Hz", "normal_loads": force, "estimated_seconds": "s"},
    }


def of_peaks(name: str, dataset: xr.Dataset, table: pd.DataFrame) -> dict[str, Any]:
    """The peaks of one result, a record each, with the units of their columns and everything that was warned of."""
    from stickslip.results.schema import analysis_of
    from stickslip.show.report.conclusions import failures_of, warnings_of

    heads = {str(head): UNIT.fullmatch(str(head)) for head in table}
    names = {head: match[1] if match else head for head, match in heads.items()}
    return {
        "name": name,
        "title": str(dataset.attrs.get("title", "")),
        "analysis": analysis_of(dataset),
        "peaks": table.rename(columns=names).to_dict("records"),
        "units": {match[1]: match[2] for match in heads.values() if match},
        "failures": failures_of(dataset),
        "warnings": warnings_of(dataset),
    }
