"""What is seen as a study file, and as Python code."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stickslip.show.explorer.sliders import varied
from stickslip.show.explorer.solving import Solver, Values

SAVED = "explored.toml"


def python_of(solver: Solver, values: Values) -> str:
    """Code that computes the response that is seen: with the rig where there is one, else from the study as a file."""
    document = varied(solver.document, solver.sliders, values)
    sweep = document["sweep"]
    lines = ["import stickslip as ss", ""]
    structure = document["structure"]
    simple = isinstance(structure, Mapping) and "rig" in structure and "start" not in structure.get("parameters", {})
    if simple and "outputs" not in sweep and "units" not in document:
        arguments = ", ".join(f"{key}={value!r}" for key, value in structure.get("parameters", {}).items())
        lines.append(f"problem = ss.rigs.{structure['rig']}({arguments})")
        where = f"ss.Band({', '.join(map(repr, sweep['frequency']))})" if "frequency" in sweep else repr(sweep["at"])
        settings = "".join(f", {key}={sweep[key]!r}" for key in _SETTINGS if key in sweep)
        lines.append(f"response = ss.forced_response(problem, {where}, {sweep['force_levels'][0]!r}{settings})")
    else:
        lines += [
            f"# {SAVED}: the study as saved, in the folder of {solver.name}.toml",
            f'problem = ss.read_problem("{SAVED}")',
            *_read_sweep(solver, values),
        ]
    return "\n".join([*lines, "print(response.peaks())", ""])


_SETTINGS = ("harmonics", "samples", "tolerance", "peak_tolerance", "quantity", "measure")


def _read_sweep(solver: Solver, values: Values) -> list[str]:
    """The call for a problem of a study: its frequencies in Hz."""
    sweep: Any = solver.job(values).sweep
    where = (
        f"ss.Band({sweep.frequencies.start!r}, {sweep.frequencies.stop!r})"
        if hasattr(sweep.frequencies, "start")
        else repr(list(sweep.frequencies))
    )
    more = f"quantity={sweep.measure.name!r}, measure={sweep.measure.kind!r}"
    how = f"harmonics={sweep.harmonics!r}, samples={sweep.samples}, tolerance={sweep.tolerance!r}"
    how = f"{how}, peak_tolerance={sweep.peak_tolerance!r}, {more}"
    return [f"response = ss.forced_response(problem, {where}, {sweep.force_levels[0]!r}, {how})"]
