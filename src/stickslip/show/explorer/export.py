"""What is seen as a study file, and as Python code."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from stickslip.analyses.response_settings import ForcedResponseSettings
from stickslip.analyses.settings import marks
from stickslip.show.explorer.sliders import varied
from stickslip.show.explorer.solving import Solver, Values

SAVED = "explored.toml"
HOW = [name for name, mark in marks(ForcedResponseSettings).items() if mark.means and not mark.key]
"""Settings of [sweep] whose keys are arguments of `forced_response`."""


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
        settings = "".join(f", {key}={sweep[key]!r}" for key in HOW if key in sweep)
        lines.append(f"response = ss.forced_response(problem, {where}, {sweep['force_levels'][0]!r}{settings})")
    else:
        lines += [
            f"# {SAVED}: the study as saved, in the folder of {solver.name}.toml",
            f'problem = ss.read_problem("{SAVED}")',
        ]
        checked: Any = solver.job(values).sweep  # its frequencies are in Hz, whatever the units of the study
        where = repr(list(checked.band)) if checked.listed else f"ss.Band({checked.band.start!r}, {checked.band.stop!r})"
        settings = "".join(f", {key}={getattr(checked, key)!r}" for key in HOW)
        lines.append(f"response = ss.forced_response(problem, {where}, {checked.levels[0]!r}{settings})")
    return "\n".join([*lines, "print(response.peaks())", ""])
