"""Presentations of nonlinear modes and of limit cycles."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stickslip.analyses.modes.synthesis import SATURATION, saturated
from stickslip.analyses.modes.work import MESH_ERRORS
from stickslip.analyses.truncation import ALLOWED
from stickslip.results.view import length_text, spread
from stickslip.show.plots import nonlinear_modes as plots
from stickslip.show.plots.paper import Figures
from stickslip.show.report.markup import hertz, number, percent, presents
from stickslip.support.checks import in_percent
from stickslip.support.late import pd, xr
from stickslip.support.outcome import Outcome

MOST_LEVELS = 12
"""Force levels of a mode that a summary lists."""

ROUGH = 0.2
"""Damping ratio above which a free decay has little to do with the mode (docs/modes.md, "High damping")."""

HIGH = "Above a damping ratio of 20 % a free motion decays within a few periods: take its frequency and damping as rough."

FIRST = (
    'Damping ratios are computed with extended = "first": the damping that sustains the motion acts on its first harmonic. Codes '
    'in which it acts on all harmonics give other ratios where damping is high. For a comparison, use extended = "all".'
)

VERY_HIGH = "Above a damping ratio of 100 % there is no free vibration: take frequency and damping as those of a forced motion."


def sentences(dataset: xr.Dataset) -> list[str]:
    """Where each mode begins and ends, and the largest damping ratio on the way."""
    lines = []
    for case in range(dataset.sizes["case"]):
        mode = dataset.isel(case=case)
        there = np.flatnonzero(np.isfinite(mode["frequency"].values))
        name = f"mode {int(mode['mode_number'])}"
        if not there.size:
            lines.append(f"{name}: no motion was found")
            continue
        most = int(np.nanargmax(mode["damping_ratio"].values))
        ends = [float(mode["frequency"][int(k)]) for k in (there[0], there[-1])]
        ratio, amplitude = float(mode["damping_ratio"][most]), float(mode["amplitude"][most, 0])
        output = str(dataset["output"].values[0])
        lines.append(
            f"{name}: {hertz(ends[0])} Hz at the smallest amplitude, {hertz(ends[1])} Hz at the largest; most damping "
            f"{percent(ratio)} at {hertz(float(mode['frequency'][most]))} Hz, where {output} moves by "
            f"{length_text(amplitude, dataset)}"
        )
        if ratio > ROUGH:
            lines.append(f"  warning, {name}: {VERY_HIGH if ratio > 1.0 else HIGH}")
        if _has_levels(dataset):
            lines += _level_lines(mode, output)
        if warning := str(mode["synthesis_warning"].item()):
            lines.append(f"  warning, {name}: {warning}")
        lines += [
            f"  {name}: {sentence.rstrip('.')}."
            for sentence in str(mode["case_message"].item()).split(". ")
            if "Internal" in sentence
        ]
    lines += on_mesh(dataset)
    return [*lines, FIRST] if str(dataset.attrs.get("extended", "")) == "first" and lines else lines


def on_mesh(dataset: xr.Dataset) -> list[str]:
    """Of a finite-element model, what its coordinates leave out."""
    if MESH_ERRORS not in dataset.attrs:
        return []
    frequency, damping = dataset.attrs[MESH_ERRORS]
    number = dataset.sizes["dof"]
    if np.isnan(frequency):
        return [f"The error by the {number} coordinates of the mesh is not known: the motion on more of them was not found"]
    found = (
        f"The {number} coordinates of the mesh leave an error of up to about {in_percent(frequency)} in frequencies and "
        f"{in_percent(damping)} of the largest in damping ratios"
    )
    if max(frequency, damping) <= ALLOWED:
        return [found]
    return [f"  warning: {found}. More harmonics bring more modes, and `points` in [[contact]] keeps the rows of its contacts"]


def _level_lines(mode: xr.Dataset, output: str) -> list[str]:
    """The peak of each force level, by one mode."""
    reached = np.flatnonzero(np.isfinite(mode["level_amplitude"].values))
    shown = reached[spread(reached.size, MOST_LEVELS)]
    lines = []
    for k in shown:
        frequency, size = float(mode["level_frequency"][k]), float(mode["level_amplitude"][k])
        solved = float(mode["level_solved_amplitude"][k]) if "level_solved_amplitude" in mode else np.nan
        checked = f", solved {length_text(solved, mode)}" if np.isfinite(solved) else ""
        lines.append(
            f"  force {float(mode['force_level'][k]):g}: {output} peaks at {length_text(size, mode)}, "
            f"{hertz(frequency)} Hz{checked}"
        )
    more = reached.size - shown.size
    return [*lines, *([f"  {shown.size} of {reached.size} force levels; the report shows all"] if more else [])]


def failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for each mode whose curve ended early, and for each that gives no peaks of some force levels."""
    sentences = []
    for case, outcome in enumerate(dataset["case_outcome"].values):
        name = f"mode {int(dataset['mode_number'].values[case])}"
        if outcome != Outcome.CONVERGED:
            sentences.append(f"{name}: {dataset['case_message'].values[case]}")
        if message := str(dataset["synthesis_message"].values[case]):
            sentences.append(f"{name}: no peaks of force levels. {message}")
        elif (
            _has_levels(dataset)
            and (beyond := dataset["force_level"].values[np.isnan(dataset["level_amplitude"].values[case])]).size
        ):
            levels = ", ".join(f"{level:g}" for level in beyond)
            there = np.isfinite(dataset["peak_force_level"].values[case])
            ends = (dataset[each].values[case, there] for each in ("peak_force_level", "modal_amplitude"))
            why = "make more than its largest amplitude; compute it up to a larger one"
            why = f"are more than it needs at any of its amplitudes. {SATURATION}" if saturated(*ends) else why
            sentences.append(f"{name}: force levels {levels} {why}")
    return sentences


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """The peaks of the force levels, and the points of every mode."""
    frames: dict[str, pd.DataFrame] = {}
    number, outputs = dataset["mode_number"].values.astype(int), dataset["output"].values
    if _has_levels(dataset):
        levels = dataset["force_level"].values
        peaks = {"mode": np.repeat(number, levels.size), "force level": np.tile(levels, number.size)}
        for head, name in (("frequency [Hz]", "level_frequency"), (f"{outputs[0]} [m]", "level_amplitude")):
            peaks[head] = dataset[name].values.ravel()
        frames["peaks of force levels"] = pd.DataFrame(peaks)
    there = np.isfinite(dataset["frequency"].values)
    columns = {
        "mode": number[np.nonzero(there)[0]],
        "modal amplitude [m kg^0.5]": dataset["modal_amplitude"].values[there],
        "frequency [Hz]": dataset["frequency"].values[there],
        "damping ratio [%]": 100.0 * dataset["damping_ratio"].values[there],
        **{f"{name} [m]": dataset["amplitude"].values[there][:, k] for k, name in enumerate(outputs)},
        "energy [J]": dataset["energy"].values[there],
        "dissipated in contacts [J]": np.nansum(dataset["dissipated"].values[there], axis=1),
        "dissipated by viscous damping [J]": dataset["viscous_work"].values[there],
        "force level of the peak": dataset["peak_force_level"].values[there],
    }
    return frames | {"nonlinear modes": pd.DataFrame(columns)}


def _has_levels(dataset: xr.Dataset) -> bool:
    return "force_level" in dataset.dims


def figures(dataset: xr.Dataset) -> Figures:
    """Frequency and damping over amplitude and over energy, peaks of all force levels, the change of shape, what contacts do."""
    shown: Figures = {"modes_over_amplitude": plots.over_amplitude, "modes_over_energy": plots.over_energy}
    if np.isfinite(dataset["peak_force_level"].values).any():
        shown = {**shown, "peaks_over_force": plots.peaks_over_force}
    shown = {**shown, "mode_shape": plots.shape}
    return {**shown, "contact_states": plots.contact_states} if dataset.sizes["contact"] else shown


PRESENTATION = presents("nonlinear_modes", "Nonlinear modes", sentences, figures, tables, failures=failures)


def cycle_sentences(dataset: xr.Dataset) -> list[str]:
    """The largest negative damping that each mode holds, and what vibration does at every aerodynamic damping."""
    lines, output = [], str(dataset["output"].values[0])
    for case in range(dataset.sizes["case"]):
        mode = dataset.isel(case=case)
        name, most = f"mode {int(mode['mode_number'])}", float(mode["held_damping"])
        if not np.isfinite(most):
            lines.append(f"{name}: no motion was found")
            continue
        size = length_text(float(mode["held_amplitude"][0]), dataset)
        where = f"{size} of {output} and {hertz(float(mode['held_frequency']))} Hz"
        edge = "" if float(mode["held_inside"]) else ", an end of the computed amplitudes"
        if most > 0.0:
            lines.append(
                f"{name}: friction balances an aerodynamic damping of down to {number(-100.0 * most, 3)} %, at {where}{edge}"
            )
        else:
            lines.append(f"{name}: vibration grows at all amplitudes, least at {where}{edge}")
        for ratio in dataset["aerodynamic_damping"].values:
            what = str(mode["limit_cycle_message"].sel(aerodynamic_damping=ratio).item())
            lines.append(f"  {name}, aerodynamic damping {number(100.0 * float(ratio), 3)} %: {what}")
    return lines + on_mesh(dataset)


def cycle_failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for each mode whose curve ended early."""
    outcomes = dataset["case_outcome"].values
    return [
        f"mode {int(dataset['mode_number'].values[case])}: {dataset['case_message'].values[case]}"
        for case in np.flatnonzero(outcomes != Outcome.CONVERGED)
    ]


def cycle_tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Every limit cycle, and the curve on which they lie."""
    number, outputs = dataset["mode_number"].values.astype(int), dataset["output"].values
    found, there = np.isfinite(dataset["frequency"].values), np.isfinite(dataset["curve_damping"].values)
    case, damping, _ = np.nonzero(found)
    cycles = {
        "mode": number[case],
        "aerodynamic damping ratio [%]": 100.0 * dataset["aerodynamic_damping"].values[damping],
        "stable": np.where(dataset["stable"].values[found] != 0.0, "yes", "no"),
        "frequency [Hz]": dataset["frequency"].values[found],
        **{f"{name} [m]": dataset["amplitude"].values[found][:, k] for k, name in enumerate(outputs)},
        "energy [J]": dataset["energy"].values[found],
        "dissipated in contacts [J]": np.nansum(dataset["dissipated"].values[found], axis=1),
    }
    curves = {
        "mode": number[np.nonzero(there)[0]],
        "aerodynamic damping ratio [%]": -100.0 * dataset["curve_damping"].values[there],
        "dζ/d ln A [%]": 100.0 * dataset["curve_slope"].values[there],
        "frequency [Hz]": dataset["curve_frequency"].values[there],
        **{f"{name} [m]": dataset["curve_amplitude"].values[there][:, k] for k, name in enumerate(outputs)},
        "energy [J]": dataset["curve_energy"].values[there],
    }
    return {"limit cycles": pd.DataFrame(cycles), "limit cycles by aerodynamic damping": pd.DataFrame(curves)}


presents(
    "limit_cycles",
    "Limit cycles",
    cycle_sentences,
    {"limit_cycles": plots.over_damping, "limit_cycle_frequency": plots.frequency_over_damping},
    cycle_tables,
    failures=cycle_failures,
)
