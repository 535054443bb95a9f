"""Derived quantities of a response: velocity, acceleration, and per force receptance, mobility, inertance.

In a stored result these are X_h (i h ω)^k, so nothing is computed again. Figures, the report and CSV tables read them here.

What a result says of the stability of its points, in words.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from stickslip.results import view
from stickslip.results.schema import kinds_in
from stickslip.results.view import sizes
from stickslip.solve.balance.measure import Measure, Quantity, quantity_named
from stickslip.support.checks import counted, first_of
from stickslip.support.late import pd, xr

UNSTABLE = 2
"""The flag of an unstable point."""

NOT_JUDGED = "The stability of the highest peaks was not judged; [stability] or `with_stability()` judges all points."

ONE_MOTION = "Friction under constant loads and damping leave one periodic motion at each frequency, and it is stable."


def has_stability(dataset: xr.Dataset) -> bool:
    """Whether a result holds the stability of its points."""
    return "stability" in dataset.variables


def is_unstable(dataset: xr.Dataset, case: int, point: int) -> bool:
    """Whether the stability of a point is known, and it is unstable."""
    return has_stability(dataset) and int(dataset["stability"].values[case, point]) == UNSTABLE


def peak_is_unstable(dataset: xr.Dataset, case: int, output: int, point: int) -> bool:
    """Whether the highest peak of an output, a point of its curve, is known to be unstable: by the stability of all points, or by
    that of the highest peaks alone.
    """
    if has_stability(dataset):
        return is_unstable(dataset, case, point)
    return "highest_stability" in dataset and int(dataset["highest_stability"].values[case, output]) == UNSTABLE


def peak_unjudged(dataset: xr.Dataset, case: int, output: int) -> str:
    """Why a result that judges its highest peaks does not say whether one is stable, in two words; empty where it does."""
    if has_stability(dataset) or "highest_stability" not in dataset:
        return ""
    return {0: "not judged", 3: "undecided"}.get(int(dataset["highest_stability"].values[case, output]), "")


def peak_verdict(dataset: xr.Dataset, case: int, output: int, point: int) -> str:
    """What is known of the stability of the highest peak of an output, a point of its curve, in two words."""
    known = "stability" if has_stability(dataset) else "highest_stability"
    flag = int(dataset[known].values[case, point if known == "stability" else output]) if known in dataset else 0
    return ("stability not judged", "stable", "unstable", "stability undecided")[flag]


def none_is_judged(dataset: xr.Dataset) -> bool:
    """Whether the stability of no highest peak was asked for, as where that takes too long; one sentence then says it for all."""
    return not has_stability(dataset) and "highest_stability" in dataset and not dataset["highest_stability"].values.any()


def about_all(dataset: xr.Dataset) -> str:
    """The sentence on the stability of all highest peaks: that there is one motion only, or that none was judged."""
    if dataset.attrs.get("one_motion"):
        return ONE_MOTION
    return NOT_JUDGED if none_is_judged(dataset) else ""


def verdicts(dataset: xr.Dataset) -> dict[str, list[str]]:
    """What is known of the stability of the highest peaks of the first output, each with the names of its curves."""
    found: dict[str, list[str]] = {}
    for case in range(dataset.sizes["case"]):
        if (peak := view.highest_peak(dataset, case)) is not None:
            found.setdefault(peak_verdict(dataset, case, 0, peak.point), []).append(view.level_text(dataset, case))
    return found


def peaks_stability(dataset: xr.Dataset) -> str:
    """The same in a sentence."""
    if (said := about_all(dataset)) or not (has_stability(dataset) or "highest_stability" in dataset):
        return said
    words = [f"{verdict} at {first_of(of)}" for verdict, of in verdicts(dataset).items()]
    return f"Highest peaks: {'; '.join(words)}." + (" [stability] judges all points." if "not judged" in str(words) else "")


def words_of_flags(variable: xr.DataArray, flags: np.ndarray) -> list[str]:
    """The meanings of flags of a variable, "branch point" for branch_point."""
    attributes = variable.attrs
    names = dict(zip(np.atleast_1d(attributes["flag_values"]).tolist(), str(attributes["flag_meanings"]).split(), strict=True))
    return [names[int(flag)].replace("_", " ").replace("neimark sacker", "Neimark-Sacker") for flag in flags]


def unstable_steps(dataset: xr.Dataset, case: int) -> np.ndarray:
    """Which steps from one of `points` to the next have an unstable point at an end, (points − 1,)."""
    unstable = dataset["stability"].values[case, view.points(dataset, case)] == UNSTABLE
    return np.asarray(unstable[1:] | unstable[:-1])


def stability_sentences(dataset: xr.Dataset) -> list[str]:
    """How many points of each force level are unstable or undecided, and where and how stability changes."""
    lines, flags = ["stability"], dataset["stability"].values
    changes, frequencies = dataset["stability_change"], dataset["stability_change_frequency"].values
    for case in range(dataset.sizes["case"]):
        inside, (low, high) = view.in_band(dataset, case, np.arange(flags.shape[1])), view.band_of(dataset)
        counts = [int(np.count_nonzero(flags[case, inside] == flag)) for flag in (1, UNSTABLE, 3)]
        found = (frequencies[case] >= low) & (frequencies[case] <= high)
        kinds = words_of_flags(changes, changes.values[case, found])
        each = [f"{kind} at {hertz:.6g} Hz" for kind, hertz in zip(kinds, frequencies[case, found], strict=True)]
        places = first_of(each)
        undecided = f", {counts[2]} undecided" if counts[2] else ""
        where = f"; {places}" if places else ""
        lines.append(f"  {view.level_text(dataset, case)}: {counts[0]} points stable, {counts[1]} unstable{undecided}{where}")
    if unresolved := int(np.count_nonzero(dataset["multiplier_resolved"].values == 0)):
        lines.append(
            f"  {counted(unresolved, 'point')} undecided, because the true motion is far from the solution or was not found: "
            "take more harmonics"
        )
    stuck, dropped = int(np.nanmax(dataset["stuck_sliders"].values, initial=0)), int(dataset.attrs["stability_dropped_modes"])
    if stuck:
        lines.append(
            f"  up to {counted(stuck, 'slider')} that never slip: multipliers of 1 say that forces are not unique, no more"
        )
    if dropped:
        error = float(dataset.attrs["stability_mode_error"])
        lines.append(
            f"  {dropped} high modes follow at once, which changes the largest multiplier by {error:.1g} where it matters most"
        )
    return lines


ERRORS = ("truncation_error", "sampling_error", "work_error", "modal_error", "patch_error")
"""Estimates of errors at the highest peak of an output, (case, output), of those that a result holds."""


def as_quantity(dataset: xr.Dataset, name: str, per_force: bool = False) -> xr.Dataset:
    """The response of a result as another quantity: `response` (case, point, output, harmonic, part), `amplitude` and `rms`.

    name: displacement, velocity or acceleration; per_force divides by the force level. Or the name of what that makes, receptance
    (compliance), mobility, inertance (accelerance).
    """
    quantity, per_force = quantity_named(name, per_force)
    rate = 2.0 * np.pi * dataset["frequency"] * dataset["harmonic"]
    complex_response = dataset["response"].isel(part=0) + 1j * dataset["response"].isel(part=1)
    values = complex_response * (1j * rate) ** quantity.order
    if per_force:
        values = values / dataset["force_level"]
    units = _units(dataset, quantity, per_force)
    sizes = abs(values)
    mean = sizes.isel(harmonic=0, drop=True) ** 2
    parts: dict[str, Any] = {
        "response": xr.concat([values.real, values.imag], dim="part").transpose(*dataset["response"].dims),
        "amplitude": sizes.isel(harmonic=view.periods_of(dataset), drop=True),
        "rms": (mean + 0.5 * (sizes.isel(harmonic=slice(1, None)) ** 2).sum("harmonic")) ** 0.5,
    }
    words = quantity.name_per_force if per_force else quantity.name
    found = xr.Dataset(parts, attrs=dataset.attrs).assign_coords(part=dataset["part"])
    for variable in found.data_vars.values():
        variable.attrs = {"units": units, "long_name": words}
    converged = dataset["outcome"] == 1
    return found.where(converged).assign(frequency=dataset["frequency"], outcome=dataset["outcome"])


def quantity_table(dataset: xr.Dataset, name: str | None = None, per_force: bool = False) -> pd.DataFrame:
    """Every converged point of every curve as a row; amplitudes are of the first harmonic, units stand in the column names.

    name: the quantity; that of the result's peaks unless given. Samples have a column `start` with their start states
    apart. point_truncation_error: how far the curve with more harmonics passes from a point, of the result's own quantity.
    """
    converted = as_quantity(dataset, name or view.measure_in(dataset).name, per_force)
    units = converted["amplitude"].attrs["units"]
    first = converted["response"].isel(harmonic=view.periods_of(dataset)).values
    measure, count = view.measure_in(dataset), dataset.sizes["output"]
    case, point = (np.repeat(index, count) for index in np.nonzero(dataset["outcome"].values == 1))
    output = np.tile(np.arange(count), case.size // max(count, 1))
    table: dict[str, Any] = {"force_level": dataset["force_level"].values[case]}
    table |= {"curve": [kinds_in(dataset)[k].name.lower() for k in case]} if "curve_kind" in dataset else {}
    table |= {"start": dataset["start"].values[case]} if "start" in dataset.coords else {}
    table |= {
        "output": dataset["output"].values.astype(object)[output],
        "point": point,
        "frequency [Hz]": dataset["frequency"].values[case, point],
        f"amplitude [{units}]": converted["amplitude"].values[case, point, output],
        "phase [deg]": np.degrees(np.arctan2(first[..., 1], first[..., 0]))[case, point, output],
        f"rms [{units}]": converted["rms"].values[case, point, output],
        **{name: dataset[name].values[case, point] for name in ("loss_factor", "residual")},
    }
    own = quantity_named(name or measure.name, per_force)[0] == measure.quantity
    if own and "point_truncation_error" in dataset:
        table["point_truncation_error"] = dataset["point_truncation_error"].values[case, point, output]
    return pd.DataFrame(table)


def peak_table(dataset: xr.Dataset, name: str | None = None, per_force: bool = False) -> pd.DataFrame:
    """Every peak as a row: frequency, its size, loss factor, and at the highest peak of each curve the estimates of its errors:
    relative changes of the size with more harmonics, with more samples, on all coordinates of the structure and with a contact at
    each node of a patch, and of the work of the contacts. name: the quantity; that of the result's peaks unless given.

    Peaks of another quantity are elsewhere: they are not in the result. The column of the size then says whose peaks these are,
    "acceleration at the displacement peak [m/s2]"; for the others ask the analysis for that quantity,
    or `ForcedResponse.peaks("acceleration")`, which has the problem to solve them.
    """
    own = view.measure_in(dataset)
    quantity, per_force = quantity_named(name or own.name, per_force)
    judged = ["peak_stability"] if has_stability(dataset) else []
    table = dataset[["peak_frequency", "peak_amplitude", "peak_loss_factor", *judged]].to_dataframe().reset_index()
    table = table.dropna(subset=["peak_frequency"])
    if own.per_force:
        table["peak_amplitude"] = table["peak_amplitude"] * table["force_level"]
    if quantity != own.quantity:
        wanted = Measure(quantity, own.kind)
        outputs = [str(label) for label in dataset["output"].values]
        places = [
            (int(row.case), outputs.index(str(row.output)), row.peak_frequency, row.peak_amplitude) for row in table.itertuples()
        ]
        table["peak_amplitude"] = [
            float(sizes(dataset, place[0], place[1], wanted, np.array([view.nearest_point(dataset, *place)]))[0])
            for place in places
        ]
    if per_force:
        table["peak_amplitude"] = table["peak_amplitude"] / table["force_level"]
    words = quantity.name_per_force if per_force else quantity.name
    what = own.kind if quantity == own.quantity else f"{words} at the {own.quantity.name} peak"
    size = f"{what} [{_units(dataset, quantity, per_force)}]"
    names = {"peak_frequency": "frequency [Hz]", "peak_amplitude": size, "peak_loss_factor": "loss_factor"}
    if "curve_kind" in dataset:
        table["curve"] = words_of_flags(dataset["curve_kind"], dataset["curve_kind"].to_numpy()[table["case"]])
    if has_stability(dataset):
        names["stability"] = "stability"
        table["stability"] = words_of_flags(dataset["peak_stability"], table["peak_stability"].to_numpy())
    for key in (each for each in ERRORS if each in dataset):
        columns = {str(label): k for k, label in enumerate(dataset["output"].values)}
        at = table["case"].to_numpy(dtype=int), table["output"].astype(str).map(columns).to_numpy(dtype=int)
        table[key] = np.where(table["peak"] == 0, dataset[key].values[at], np.nan)
        names[key] = key
    table = table.rename(columns=names)
    curve = ["curve"] if "curve_kind" in dataset else []
    which = ["force_level", *curve, *(["start"] if "start" in dataset.coords else []), "output", "peak"]
    return table[[*which, *names.values()]].sort_values(which, ignore_index=True)


def reached_table(dataset: xr.Dataset) -> pd.DataFrame:
    """Of the highest peak of every curve, whether each way leads to it, the largest motion below it, and what is not known."""
    columns: dict[str, Any] = {"force_level": dataset["force_level"].values}
    columns |= {"curve": words_of_flags(dataset["curve_kind"], dataset["curve_kind"].values)} if "curve_kind" in dataset else {}
    for way, flags in zip(dataset["question"].values, dataset["reached"].values.T, strict=True):
        columns[str(way)] = words_of_flags(dataset["reached"], flags)
    lower = dataset["next_lower"]
    return pd.DataFrame(columns | {f"next_lower [{lower.attrs['units']}]": lower, "unknown": dataset["reached_unknown"]})


def outside_table(dataset: xr.Dataset) -> pd.DataFrame:
    """The peaks outside the band, which do not count, as rows: frequency, size and loss factor; highest first."""
    measure, rows = view.measure_in(dataset), []
    size = f"{measure.kind} [{_units(dataset, measure.quantity, measure.per_force)}]"
    for case, level in enumerate(dataset["force_level"].values.tolist()):
        kind = {"curve": kinds_in(dataset)[case].name.lower()} if "curve_kind" in dataset else {}
        for output, label in enumerate(dataset["output"].values):
            for peak in view.peaks_outside(dataset, case, output):
                rows.append(
                    {"force_level": level, **kind, "output": str(label), "frequency [Hz]": peak.frequency}
                    | {size: peak.amplitude / measure.per(level), "loss_factor": peak.loss_factor}
                )
    return pd.DataFrame(rows)


def other_peaks(dataset: xr.Dataset, name: str | None) -> str:
    """A sentence where the peaks of a result are not of the quantity that is asked for; else ""."""
    own = view.measure_in(dataset)
    asked = name or own.name
    quantity = quantity_named(asked)[0]
    if quantity == own.quantity or not dataset["peak_frequency"].notnull().any():
        return ""
    return (
        f"The peaks are those of the {own.quantity.name}, with the {asked} there, which is highest elsewhere: "
        f'for its own peaks run the study with quantity = "{asked}" in [sweep].'
    )


def _units(dataset: xr.Dataset, quantity: Quantity, per_force: bool) -> str:
    return Measure(quantity, per_force=per_force).reported_units(view.levels_in_newtons(dataset))
