"""Presentation of Campbell diagrams, with the interference diagram of a disk."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from stickslip.analyses.speed.campbell import UNSOLVED, interference_of
from stickslip.results.schema import Row
from stickslip.show.plots.chart import Chart
from stickslip.show.plots.paper import Figures
from stickslip.show.plots.speed_sweep import interference, resonances
from stickslip.show.report.markup import Presentation, hertz, presents
from stickslip.support.checks import counted, first_of
from stickslip.support.late import pd, xr

MOST = 12
"""Crossings with a sentence each, and in the first table."""
NO_ERROR = (
    "Natural frequencies and crossings are exact for the matrices of the study: errors of the mesh and of its reduction are not "
    "in them. Modes are numbered by frequency at each speed"
)
NO_ERROR_OF_RESONANCES = "The error that {} leave in resonances at a force level is not estimated: raise both to see it"
ALWAYS = (
    "  warning, natural frequencies: they are the same at all speeds, since the study states K at one speed only. Rotation "
    "stiffens blades: state K at rest or at another speed too (`stiffness_at_rest`, `at_speeds`, [rotation])."
)
ROTATING = (
    "Coriolis forces act, and frequencies are those in the rotating frame. Whirl is 1 where the motion goes in circles with the "
    "rotation, −1 where it goes against it, and 0 where they do not act"
)
ANSWER, ALL, CURVES = "nearest crossings", "all crossings", "natural frequencies over the speed"


def contacts_in(dataset: xr.Dataset, state: str) -> str:
    """What the contacts do in a state."""
    level = dataset.attrs.get("force_level", np.nan)
    return {"free": "without contacts", "stuck": "stuck contacts", "nonlinear": f"force level {level:g}"}[state]


def sentences(dataset: xr.Dataset) -> list[str]:
    """The smallest margin or the crossings, each crossing, what holds of all numbers, and warnings."""
    crossings = _crossings(dataset)
    lines = [_first(dataset, len(crossings)), *(_line(dataset, row) for _, row in crossings.head(MOST).iterrows())]
    lines += [f"{MOST} of {len(crossings)} crossings; the report shows all"] if len(crossings) > MOST else []
    if (diagram := interference_of(dataset)) is not None:
        lines.append(_disk(diagram))
    lines += [ROTATING] if "whirl" in dataset else []
    lines.append(NO_ERROR)
    if "force_level" in dataset.attrs:
        fineness = f"harmonics = {dataset.attrs['harmonics']} and samples = {dataset.attrs['samples']}"
        lines.append(NO_ERROR_OF_RESONANCES.format(fineness))
    linear = dataset["frequency"].sel(state=["free", "stuck"]).values
    lines += [ALWAYS] if np.nanmax(np.ptp(linear, axis=-1)) == 0.0 else []
    return [*lines, *_unsolved(dataset)]


def _crossings(dataset: xr.Dataset) -> pd.DataFrame:
    """Every place where an engine order meets a mode, the nearest to the operating speed first, else the slowest."""
    table = dataset[[name for name in ("crossing_speed", "crossing_frequency", "speed_margin") if name in dataset]]
    met = table.to_dataframe().reset_index().dropna(subset=["crossing_speed"])
    order = met["speed_margin"].abs() if "speed_margin" in met else met["crossing_speed"]
    return met.loc[order.sort_values(kind="stable").index]


def _first(dataset: xr.Dataset, count: int) -> str:
    """The smallest margin at the operating speed, of resonances with friction where these are known; else how many crossings."""
    speeds, orders, frequency = (dataset[name].values for name in ("speed", "engine_order", "frequency"))
    between = f"from {speeds[0]:g} to {speeds[-1]:g} rev/min"
    if "margin" not in dataset:
        if count:
            return f"{counted(count, 'crossing')} of engine orders and modes {between}, by speed"
        ends = f"{hertz(orders.min() * speeds[0] / 60.0)} to {hertz(orders.max() * speeds[-1] / 60.0)} Hz"
        lowest = hertz(float(np.nanmin(frequency)))
        return f"no engine order meets a mode {between}: they excite at {ends}, and the lowest mode is at {lowest} Hz"
    solved = np.isfinite(dataset["margin"].sel(state="nonlinear")).any()
    margins = dataset["margin"].sel(state=["nonlinear"] if solved else ["free", "stuck"])
    place = np.unravel_index(int(np.nanargmin(np.abs(margins.values))), margins.shape)
    one = margins.isel(dict(zip(margins.dims, place, strict=True)))
    operating, order, mode = float(dataset.attrs["operating_speed"]), int(one["engine_order"]), int(one["mode"])
    frequency, margin = (1.0 + float(one)) * order * operating / 60.0, 100.0 * float(one)
    return (
        f"smallest margin at {operating:g} rev/min: mode {mode} ({contacts_in(dataset, str(one['state'].values))}) lies at "
        f"{hertz(frequency)} Hz, {abs(margin):.2g} % {'above' if margin >= 0.0 else 'below'} engine order {order}"
    )


def _line(dataset: xr.Dataset, row: pd.Series) -> Row:
    """One crossing."""
    where = f"{row['crossing_speed']:.5g} rev/min, {hertz(row['crossing_frequency'])} Hz"
    margin = f", {100.0 * row['speed_margin']:+.2g} % from the operating speed" if "speed_margin" in row else ""
    name = f"engine order {row['engine_order']}, mode {row['mode']} ({contacts_in(dataset, row['state'])})"
    return Row(f"{name}: they meet at {where}{margin}")


def _disk(diagram: xr.Dataset) -> str:
    """The nearest mode of the nodal diameters that the engine orders excite."""
    stuck = diagram.sel(state="stuck")
    order = stuck.isel(engine_order=int(np.nanargmin(np.abs(stuck["margin"].values))))
    return (
        f"interference diagram at {float(diagram.attrs['speed']):g} rev/min: engine order {int(order['engine_order'])} excites "
        f"nodal diameter {int(order['excited_diameter'])} ({order['wave'].item()} wave), whose mode {int(order['nearest_mode'])} "
        f"with stuck contacts lies {100.0 * float(order['margin']):+.2g} % from it, the nearest of all"
    )


def _messages(dataset: xr.Dataset) -> Iterator[tuple[str, str, str]]:
    """What is said of resonances: name of the curve, message, and the speeds that it is about; without a disk a curve is the same
    for all engine orders."""
    of = dataset if "excited_diameter" in dataset else dataset.isel(engine_order=[0])
    for m, o in np.ndindex(of["message"].shape[:2]):
        said, speeds = of["message"].values[m, o], of["speed"].values
        order = f", engine order {int(of['engine_order'][o])}" if of is dataset else ""
        for message in dict.fromkeys(said[said != ""].tolist()):
            yield (
                f"mode {int(of['mode'][m])}{order}",
                str(message),
                first_of([f"{speed:.5g}" for speed in speeds[said == message]]),
            )


def _unsolved(dataset: xr.Dataset) -> list[str]:
    return [f"  warning, {name}: at {speeds} rev/min {said}" for name, said, speeds in _messages(dataset) if said == UNSOLVED]


def failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for each mode without a resonance at some speeds."""
    return [f"{name}: no resonance at {speeds} rev/min. {said}" for name, said, speeds in _messages(dataset) if said != UNSOLVED]


def tables(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Crossings and margins, frequencies over the speed, and the interference diagram of a disk."""
    table = dataset[["crossing_speed", "crossing_frequency"]].to_dataframe().reset_index()
    disk = "excited_diameter" in dataset
    rows: dict[str, object] = {"engine order": table["engine_order"].astype(int)}
    if disk:
        rows["nodal diameter"] = [int(dataset["excited_diameter"].sel(engine_order=order)) for order in table["engine_order"]]
    rows |= {"mode": table["mode"].astype(int), "contacts": [contacts_in(dataset, state) for state in table["state"]]}
    rows |= {"crossing [rev/min]": table["crossing_speed"], "frequency there [Hz]": table["crossing_frequency"]}
    nearness = table["crossing_speed"]
    if "margin" in dataset:
        at = f"at {dataset.attrs['operating_speed']:g} rev/min"
        own = dataset[["speed_margin", "operating_frequency", "margin"]].to_dataframe().reset_index()
        rows |= {
            "speed to the operating one [%]": 100.0 * own["speed_margin"],
            f"frequency {at} [Hz]": own["operating_frequency"],
        }
        rows[f"frequency to engine order {at} [%]"] = 100.0 * own["margin"]
        nearness = own["margin"].abs()
    found = pd.DataFrame(rows).loc[nearness.sort_values(kind="stable").index]
    known = found.dropna(subset=[found.columns[-1]])
    shown = {ANSWER: known.head(MOST)}
    shown |= {ALL: known} if len(known) > MOST else {}
    shown[CURVES] = _curves(dataset, disk)
    return shown | _interference_table(dataset)


def _curves(dataset: xr.Dataset, disk: bool) -> pd.DataFrame:
    """Frequencies over the speed; without a disk they are the same for all engine orders."""
    of = dataset if disk else dataset.isel(engine_order=[0])
    names = ["frequency", *(["whirl"] if "whirl" in of else [])]
    table = of[names].to_dataframe().reset_index().dropna(subset=["frequency"])
    rows: dict[str, object] = {"engine order": table["engine_order"].astype(int)} if disk else {}
    rows |= {"mode": table["mode"].astype(int), "contacts": [contacts_in(dataset, state) for state in table["state"]]}
    rows |= {"speed [rev/min]": table["speed"], "frequency [Hz]": table["frequency"]}
    rows |= {"whirl": table["whirl"]} if "whirl" in of else {}
    if "force_level" in dataset.attrs:
        sizes = of["amplitude"].to_dataframe().reset_index().assign(state="nonlinear")
        keys = ["state", "mode", "engine_order", "speed"]
        rows["amplitude [m]"] = table[keys].merge(sizes, how="left", on=keys)["amplitude"].to_numpy()
    return pd.DataFrame(rows)


def _interference_table(dataset: xr.Dataset) -> Mapping[str, pd.DataFrame]:
    """Of each engine order the nearest mode of the nodal diameter that it excites."""
    diagram = interference_of(dataset)
    if diagram is None:
        return {}
    names = ["excited_diameter", "wave", "excitation_frequency", "nearest_mode", "margin"]
    table = diagram[names].to_dataframe().reset_index()
    rows = {"engine order": table["engine_order"], "nodal diameter": table["excited_diameter"], "wave": table["wave"]}
    rows |= {"excitation [Hz]": table["excitation_frequency"], "contacts": [contacts_in(dataset, s) for s in table["state"]]}
    rows |= {"nearest mode": table["nearest_mode"], "its frequency to the excitation [%]": 100.0 * table["margin"]}
    return {f"interference diagram at {diagram.attrs['speed']:g} rev per min": pd.DataFrame(rows)}


def figures(dataset: xr.Dataset) -> Figures:
    """The Campbell diagram, and the interference diagram of a disk."""
    found: Figures = {"campbell": resonances}
    return found if interference_of(dataset) is None else {**found, "interference": _interference}


def _interference(dataset: xr.Dataset) -> Chart:
    diagram = interference_of(dataset)
    assert diagram is not None
    return interference(diagram)


PRESENTATION = presents("campbell", Presentation("Campbell diagram", sentences, failures, figures, tables, answer=ANSWER))
