"""Presentation of controlled responses."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stickslip.results.shown_units import in_system, system_of
from stickslip.results.view import size_text
from stickslip.show.plots.paper import Figures
from stickslip.show.plots.response_curves import controlled_response, resonances
from stickslip.show.report.markup import Presentation, hertz, presents
from stickslip.support.checks import counted
from stickslip.support.late import pd, xr
from stickslip.support.outcome import Outcome

MOST = 12
"""Amplitudes with a sentence each."""


def _name(dataset: xr.Dataset, case: int) -> str:
    return size_text(float(dataset["held_amplitude"].values[case]), dataset["held_amplitude"].attrs["units"], dataset)


def sentences(dataset: xr.Dataset) -> list[str]:
    """Where force and displacement are at 90°, for each amplitude: the lowest force."""
    lines, count, held = [], dataset.sizes["case"], f"{dataset.attrs['quantity']} of {dataset.attrs['output_held']} held"
    factor, unit = in_system("N", system_of(dataset))
    for case in range(min(count, MOST)):
        resonances_of_case = dataset["resonance_frequency"].values[case]
        if not (resonances_of_case.size and np.isfinite(resonances_of_case[0])):
            lines.append(f"{held} at {_name(dataset, case)}: force and displacement are nowhere at 90° in the band")
            continue
        force, loss = (float(dataset[f"resonance_{name}"].values[case, 0]) for name in ("force_level", "loss_factor"))
        size = f"{factor * force:.4g} {unit}" if dataset["force_level"].attrs["units"] == "N" else f"force level {force:.4g}"
        at = f"{size} at {hertz(float(resonances_of_case[0]))} Hz"
        lines.append(f"{held} at {_name(dataset, case)}: phase resonance with {at}, loss factor {loss:.4g}")
    if count > MOST:
        lines.append(f"{MOST} of {count} amplitudes; all stand in the report")
    return lines


def failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for each amplitude whose curve did not arrive or misses frequencies."""
    sentences = []
    for case in range(dataset.sizes["case"]):
        missing = int(np.count_nonzero(dataset["outcome"].values[case] > Outcome.CONVERGED))
        if int(dataset["case_outcome"].values[case]) != Outcome.CONVERGED:
            sentences.append(f"{_name(dataset, case)}: {dataset['case_message'].values[case]}")
        elif missing:
            sentences.append(f"{_name(dataset, case)}: {counted(missing, 'frequency', 'frequencies')} could not be solved")
    return sentences


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Phase resonances, and every point of every curve."""
    units, level = dataset["held_amplitude"].attrs["units"], dataset["force_level"].attrs["units"]
    force, held = f"force level [{level}]", f"{dataset.attrs['quantity']} [{units}]"
    rows, points = [], []
    for case, amplitude in enumerate(dataset["held_amplitude"].values.tolist()):
        for k in np.flatnonzero(np.isfinite(dataset["resonance_frequency"].values[case])):
            values = [float(dataset[f"resonance_{name}"].values[case, k]) for name in ("frequency", "force_level", "loss_factor")]
            rows.append((amplitude, *values))
        for k in np.flatnonzero(dataset["outcome"].values[case] == Outcome.CONVERGED):
            columns = ("frequency", "force_level", "phase", "loss_factor")
            points.append((amplitude, *(float(dataset[name].values[case, k]) for name in columns)))
    at_90 = pd.DataFrame(rows, columns=[held, "frequency [Hz]", force, "loss factor"])
    curves = pd.DataFrame(points, columns=[held, "frequency [Hz]", force, "phase [degree]", "loss factor"])
    return {"force and displacement at 90 degrees": at_90, "controlled response": curves}


def figures(dataset: xr.Dataset) -> Figures:
    """The curves, and the phase resonances of several amplitudes."""
    found: Figures = {"controlled_response": controlled_response}
    known = int(np.isfinite(dataset["resonance_frequency"].values).any(axis=1).sum())
    return {**found, "phase_resonances": resonances} if known > 1 else found


PRESENTATION = presents("controlled_response", Presentation("Controlled response", sentences, failures, figures, tables))
