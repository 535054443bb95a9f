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
        keys = ("harmonics", "samples", "tolerance", "peak_tolerance", "quantity", "measure")
        settings = "".join(f", {key}={sweep[key]!r}" for key in keys if key in sweep)
        lines.append(f"response = ss.forced_response(problem, {where}, {sweep['force_levels'][0]!r}{settings})")
    else:
        lines += [
            f"# {SAVED}: the study as saved, in the folder of {solver.name}.toml",
            f'problem = ss.read_problem("{SAVED}")',
        ]
        checked: Any = solver.job(values).sweep  # its frequencies are in Hz, whatever the units of the study
        band = checked.frequencies
        where = f"ss.Band({band.start!r}, {band.stop!r})" if hasattr(band, "start") else repr(list(band))
        settings = f"harmonics={checked.harmonics!r}, samples={checked.samples}, tolerance={checked.tolerance!r}"
        settings += f", peak_tolerance={checked.peak_tolerance!r}"
        settings += f", quantity={checked.measure.name!r}, measure={checked.measure.kind!r}"
        lines.append(f"response = ss.forced_response(problem, {where}, {checked.force_levels[0]!r}, {settings})")
    return "\n".join([*lines, "print(response.peaks())", ""])
