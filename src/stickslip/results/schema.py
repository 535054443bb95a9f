"""What the results of all analyses have in common: their sentences and figures, and the names, dimensions, units and meaning of
the variables in their datasets.

Complex amplitudes are stored with a last axis `part` (re, im), x(t) = Re Σ X_h exp(i h ω t). Cases with fewer points, and
contacts without a direction, are padded with NaN; `outcome` 0 marks a point that is not there.

What kind of curve a case of a forced response is: of a sweep, a branch, or isolated.

The units that results are shown in: those that the study states, or SI with a prefix by size where it states none.

Datasets are in SI, whatever the study states. Its lengths and forces stand in the attribute `unit_system` of the results, and
console, report, figures and exported files convert by `in_system` when they show a number. Times and frequencies stay
in s and Hz.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cache
from importlib.resources import files
from math import log10
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.support.checks import Faults, InputError, fault, nearest
from stickslip.support.late import Figure, pd, xr
from stickslip.support.outcome import Outcome
from stickslip.support.renderers import FIGURES, SENTENCES
from stickslip.support.units import FORCES, LENGTHS, MASSES, UnitSystem


class Result:
    """A result with figures: those that `show/plots` registers for the name of its class, `@FIGURES.of("Curve", "loops")`.

    That without a name is the figure of `plot()`. Functions get the `dataset` of a result, or a result without one, and return a
    chart, or a matplotlib figure that is a drawing.
    """

    def __repr__(self) -> str:
        return "\n".join(SENTENCES.known("Result")[""](self))

    def _repr_html_(self) -> str:
        """What a notebook shows: what came out in sentences, and the figure of `plot()`."""
        page: str = SENTENCES.known("Result")["page"](self)
        return page

    @property
    def figures(self) -> tuple[str, ...]:
        """The names that `plot` takes; "" is the usual figure."""
        return tuple(FIGURES.known(type(self).__name__))

    def plot(self, figure: str = "", **options: Any) -> Figure:
        """The figure of the result, or another one by its name in `figures`; options are those of its function."""
        found = self._figure(figure, options)
        drawn: Figure = found.plot() if hasattr(found, "plot") else found
        return drawn

    def to_plotly(self, figure: str = "", *, dark: bool = False, **options: Any) -> Any:
        """The same as an interactive plotly figure: `.show()` or `.write_html(path)`; dark: for a dark background."""
        found = self._figure(figure, options)
        if not hasattr(found, "to_plotly"):
            raise InputError(f"The figure {figure or 'of this result'} is a drawing without curves: plot() draws it.")
        return found.to_plotly(dark)

    def _figure(self, figure: str, options: Mapping[str, Any]) -> Any:
        """The chart of a figure, or the drawing."""
        known = FIGURES.known(type(self).__name__)
        if figure not in known:
            raise fault("figure", "must be a known one", figure, nearest(str(figure), filter(None, known)))
        drawn = known[figure](getattr(self, "dataset", self), **options)
        return FIGURES.known("Result")["in the units of the study"](drawn, self)


class Row(str):
    """A sentence that says a row of the table of the answer: a page shows the table in its stead."""


class Certainty(str):
    """A sentence on the error of what a result shows: a page shows it below the answer."""


FILE_FORMAT = 1
COMMON_ATTRIBUTES = ("title", "study", "stickslip_version", "file_format")
"""What the results of every analysis carry."""
REQUIRED_ATTRIBUTES = (*COMMON_ATTRIBUTES, "harmonics", "samples", "cpu_seconds")
RESPONSES = ("forced_response", "response_bounds", "response_samples")
"""The analyses whose results are curves of the forced response, with the variables of `SCHEMA`; others name their own."""


@dataclass(frozen=True)
class Variable:
    """One variable: dimensions in order, units ("1" for a pure number), meaning, kind (float, int8 or str)."""

    name: str
    dims: tuple[str, ...]
    units: str
    long_name: str
    kind: str = "float"


@cache
def _tables() -> dict[str, dict[str, tuple[str, ...]]]:
    """The tables of `variables.toml`."""
    return tomllib.loads(files("stickslip.results").joinpath("variables.toml").read_text(encoding="utf-8"))


def named(dims: Any, values: Any, words: str, units: str = "1") -> tuple[Any, Any, dict[str, Any]]:
    """A variable or coordinate as xarray takes it, with its meaning and its units, "1" of a pure number."""
    return dims, values, {"units": units, "long_name": words}


def stacked(pieces: Sequence[ArrayLike], empty: Any = np.nan, kind: Any = float) -> NDArray[Any]:
    """Arrays of one number of axes as one with a first axis, the shorter ones filled up with what means "not there"."""
    arrays = [np.asarray(piece) for piece in pieces]
    if arrays[0].dtype.kind == "U":
        empty, kind = "", object
    whole = np.full((len(arrays), *np.max([array.shape for array in arrays], axis=0).astype(int)), empty, dtype=kind)
    for row, array in zip(whole, arrays, strict=True) if whole.ndim > 1 else ():
        row[tuple(map(slice, array.shape))] = array
    if whole.ndim == 1:
        whole[:] = arrays
    return whole.astype(np.str_) if kind is object else whole


def variables_in(table: str) -> dict[str, tuple[tuple[str, ...], str, str]]:
    """Dimensions, units and meaning of the variables that a table of `variables.toml` lists, by name."""
    return {name: (tuple(dims.split()), units, words) for name, (dims, units, words) in _tables()[table].items()}


def described(table: str, values: Mapping[str, Any], measured: str = "") -> dict[str, tuple[Any, Any, dict[str, Any]]]:
    """Values by name as xarray takes them, with the dimensions, units and meaning that a table of `variables.toml` lists;
    measured: the units of those that are listed with none."""
    known = {name: variables_in(table)[name] for name in values}
    return {name: named(dims, values[name], words, units or measured) for name, (dims, units, words) in known.items()}


def tabulated(
    table: str, variables: Mapping[str, Any], coords: Mapping[str, Any], attrs: Mapping[str, Any], measured: str = ""
) -> xr.Dataset:
    """The dataset of values that a table of `variables.toml` lists, as `described` takes them."""
    return xr.Dataset(described(table, variables, measured), described(table, coords, measured), dict(attrs))


def _with_kinds(table: str) -> tuple[Variable, ...]:
    """The variables that a table lists with their kinds."""
    return tuple(Variable(name, tuple(dims.split()), *rest) for name, (dims, *rest) in _tables()[table].items())


COORDINATES, SCHEMA = _with_kinds("coordinates"), _with_kinds("forced_response")


def labelled(variables: Mapping[str, Any], coords: Mapping[str, Any], attrs: Mapping[str, Any]) -> xr.Dataset:
    """The dataset of the schema: variables in its order, with units and long names. xarray refuses axes that do not fit.

    variables: an array for each name of SCHEMA; coords: for each name of COORDINATES (`part` and `harmonic` may be left out);
    attrs: title, study, harmonics, samples, cpu_seconds and what else is to be kept; version and file format are added.
    """
    shape = np.shape(variables.get("response", ()))
    coords = {"part": ["re", "im"], "harmonic": np.arange(shape[3] if len(shape) == 5 else 0), **coords}
    if unknown := {*variables, *coords} - {v.name for v in (*COORDINATES, *SCHEMA)}:
        raise KeyError(f"variables that are not in the schema: {', '.join(sorted(unknown))}")
    arrays = {v: _typed(v, coords if v in COORDINATES else variables) for v in (*COORDINATES, *SCHEMA)}
    dataset = xr.Dataset(
        {v.name: (v.dims, arrays[v], _attributes(v)) for v in SCHEMA},
        {v.name: (v.dims, arrays[v], _attributes(v)) for v in COORDINATES},
        dict(attrs),
    )
    dataset = with_frequency(stamped(dataset))
    check_schema(dataset)
    return dataset


def with_frequency(dataset: xr.Dataset) -> xr.Dataset:
    """Curves with the frequency of their points as a coordinate, as xarray's own plots need it: `.plot.line(x="frequency")`."""
    return dataset.set_coords("frequency") if "frequency" in dataset.data_vars else dataset


def stamped(dataset: xr.Dataset, analysis: str = RESPONSES[0]) -> xr.Dataset:
    """The dataset with what every results file says of itself; what it already says stays."""
    attributes = {"title": "", "study": "", "analysis": analysis, "stickslip_version": _version(), "file_format": FILE_FORMAT}
    return dataset.assign_attrs(attributes | dataset.attrs)


def analysis_of(dataset: xr.Dataset) -> str:
    """The analysis that a dataset came of."""
    return str(dataset.attrs.get("analysis", RESPONSES[0]))


def analysis_named(kind: str) -> str:
    """The analysis of a class of results, which is named after it: response_bounds of ResponseBounds."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", kind).lower()


def check_results(dataset: xr.Dataset) -> None:
    """Refuse a dataset that is not what its analysis writes: the schema of responses, or variables with units and meaning."""
    if analysis_of(dataset) in RESPONSES:
        check_schema(dataset)
        return
    faults = [f"The attribute {name!r} must be there, but is missing." for name in COMMON_ATTRIBUTES if name not in dataset.attrs]
    for name, variable in dataset.variables.items():
        faults += [
            f"The variable {name!r} must have the attribute {key!r}, but has none."
            for key in ("units", "long_name")
            if key not in variable.attrs
        ]
    if faults:
        raise Faults(faults)


def check_schema(dataset: xr.Dataset) -> None:
    """Refuse a dataset that lacks an attribute or variable of the schema, or has one with other dimensions or kind."""
    missing = [name for name in REQUIRED_ATTRIBUTES if name not in dataset.attrs]
    faults = [f"The attribute {name!r} must be there, but is missing." for name in missing]
    for variable in (*COORDINATES, *SCHEMA):
        if variable.name not in dataset.variables:
            faults.append(f"The variable {variable.name!r} must be there, but is missing.")
            continue
        found = dataset.variables[variable.name]
        if found.dims != variable.dims:
            faults.append(f"The variable {variable.name!r} must have dimensions {variable.dims}, but has {found.dims}.")
        if found.dtype.kind not in _KINDS[variable.kind]:
            faults.append(f"The variable {variable.name!r} must hold {variable.kind}, but holds {found.dtype}.")
    if faults:
        raise Faults(faults)


_KINDS = {"float": "fiu", "int8": "iu", "str": "UOT"}


def _typed(variable: Variable, given: Mapping[str, Any]) -> np.ndarray[Any, Any]:
    kinds: dict[str, Any] = {"float": np.float64, "int8": np.int8, "str": np.str_}
    if variable.name == "harmonic":
        orders = np.asarray(given[variable.name])
        return orders.astype(np.int64 if orders.dtype.kind in "iu" else np.float64)
    return np.asarray(given[variable.name], dtype=kinds[variable.kind])


def _attributes(variable: Variable) -> dict[str, Any]:
    attributes: dict[str, Any] = {"units": variable.units, "long_name": variable.long_name}
    if variable.kind == "int8":
        attributes["flag_values"] = np.array([int(outcome) for outcome in Outcome], dtype=np.int8)
        attributes["flag_meanings"] = " ".join(outcome.name.lower() for outcome in Outcome)
    return attributes


@cache
def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("stickslip")
    except PackageNotFoundError:
        return "unknown"


class CurveKind(IntEnum):
    """How a curve was found."""

    SWEEP = 0
    BRANCH = 1
    ISOLATED = 2


def with_kinds(dataset: xr.Dataset, kinds: list[CurveKind]) -> xr.Dataset:
    """A forced response that says of every case what kind of curve it is; as it is where all are of sweeps."""
    if not any(kinds):
        return dataset
    attributes: dict[str, Any] = {
        "units": "1",
        "long_name": "kind of the curve",
        "flag_values": np.array([int(kind) for kind in CurveKind], dtype=np.int8),
        "flag_meanings": " ".join(kind.name.lower() for kind in CurveKind),
    }
    return dataset.assign(curve_kind=("case", np.array(kinds, dtype=np.int8), attributes))


def kinds_in(dataset: xr.Dataset) -> list[CurveKind]:
    """The kind of every case."""
    if "curve_kind" not in dataset.variables:
        return [CurveKind.SWEEP] * dataset.sizes["case"]
    return [CurveKind(int(kind)) for kind in dataset["curve_kind"].values]


def kind_words(dataset: xr.Dataset, case: int) -> str:
    """ "branch" or "isolated"; "" for a sweep."""
    kind = kinds_in(dataset)[case]
    return "" if kind == CurveKind.SWEEP else kind.name.lower()


ATTRIBUTE = "unit_system"
"""Of a dataset: the units of length, force, mass and time of its study; absent for SI."""
PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}
PREFIXED = {"Pa": (1, -2), "J": (1, 1)}
"""Units that are shown with a prefix, and their powers of force and length."""
OWN = {
    **{name: ("length", size) for name, size in {**LENGTHS, "µm": 1e-6, "nm": 1e-9}.items()},
    **{name: ("force", size) for name, size in FORCES.items()},
    **{name: ("mass", size) for name, size in MASSES.items()},
    **{f"{prefix}{name}": (name, 10.0**power) for name in PREFIXED for power, prefix in PREFIXES.items()},
}
"""What each unit that results use is of, and its size in SI."""
FACTOR = re.compile(r"([A-Za-zµ]+)(\^?-?[\d.]+|²|³)?")
"""A unit with its power inside of a compound one, as in m/(s2 N)."""
HEAD = re.compile(r"(.* \[)([^\]]+)(\])|(.* in )(\S+)()")
"""The head of a column with its unit, "amplitude [m]" or "kt in N/µm"."""
UNITS = r"m kg\^0\.5|N/m|m/\(s[2²]? N\)|m/s[2²]?|m/N|[µn]?m|N(?! m\b)"
SIZE = re.compile(rf"(?<![\w.])(?:(\d[\d.]*(?:e[+-]?\d+)?) to )?(\d[\d.]*(?:e[+-]?\d+)?) ({UNITS})(?![\w/^²])")
"""A length, a motion, also per force, a modal amplitude, a force or a stiffness in a sentence, or a range of them whose unit
stands after its upper end."""


def attributes_of(system: UnitSystem) -> dict[str, str]:
    """What a result keeps of the units of its study; nothing for SI."""
    names = (system.length, system.force, system.mass, system.time)
    return {} if system == UnitSystem() else {ATTRIBUTE: " ".join(names)}


def system_of(*datasets: xr.Dataset) -> UnitSystem | None:
    """The units of the study that computed results; None for SI, and for results of different units."""
    names = {str(dataset.attrs.get(ATTRIBUTE, "")) for dataset in datasets}
    only = names.pop() if len(names) == 1 else ""
    return UnitSystem(*only.split()) if only else None


def in_system(unit: str, system: UnitSystem | None) -> tuple[float, str]:
    """The factor from a unit to that of a system for the same quantity, and its name; without a system 1 and the unit.

    >>> in_system("m/(s2 N)", UnitSystem("mm", "kN", "kg", "ms"))
    (1000000.0, 'mm/(s2 kN)')
    """
    if system is None:
        return 1.0, unit
    above, slash, below = unit.partition("/")
    total, names = 1.0, []
    for part, sign in ((above, 1), (below, -1)):
        name = part
        for match in reversed(list(FACTOR.finditer(part))):
            factor, own = _single(match[1], system)
            total *= factor ** (sign * _power(match[2]))
            name = name[: match.start(1)] + own + name[match.end(1) :]
        names.append(name)
    return total, slash.join(names) if slash else names[0]


def _single(unit: str, system: UnitSystem) -> tuple[float, str]:
    """The same of a unit by itself; seconds, hertz and words stay."""
    if unit not in OWN:
        return 1.0, unit
    quantity, size = OWN[unit]
    if quantity in PREFIXED:
        force, length = PREFIXED[quantity]
        own = system.newtons**force * system.metres**length
        return size / own, f"{PREFIXES[round(log10(own))]}{quantity}"
    own = {"length": system.metres, "force": system.newtons, "mass": system.kilograms}[quantity]
    return size / own, {"length": system.length.replace("um", "µm"), "force": system.force, "mass": system.mass}[quantity]


def _power(text: str | None) -> float:
    return 1.0 if not text else {"²": 2.0, "³": 3.0}.get(text) or float(text.removeprefix("^"))


def shown_table(table: pd.DataFrame, dataset: xr.Dataset) -> pd.DataFrame:
    """A table whose heads name SI units, "amplitude [m]", in the units of the study."""
    system = system_of(dataset)
    columns = {}
    for head, column in table.items():
        match = HEAD.fullmatch(str(head))
        words, unit, end = (part for part in match.groups() if part is not None) if match else (str(head), "", "")
        factor, own = in_system(unit, system)
        columns[head] = (f"{words}{own}{end}", column * factor) if factor != 1.0 else (head, column)
    return table.assign(**{str(head): column for head, (_, column) in columns.items()}).rename(
        columns={head: name for head, (name, _) in columns.items()}
    )


def shown_sentence(sentence: str, *datasets: xr.Dataset) -> str:
    """A sentence that a result keeps, with its sizes in the units of the study; those that are in them already stay."""
    return sentence_in(sentence, system_of(*datasets))


def sentence_in(sentence: str, system: UnitSystem | None) -> str:
    """A sentence in SI with its sizes in a system of units."""

    def converted(size: re.Match[str]) -> str:
        factor, unit = in_system(size[3], system)
        if system is None and unit in ("m", "m/N") and 0.0 < float(size[2]) < 1e-4:  # "g" writes an exponent
            factor, unit = 1e6, f"µ{unit}"
        ends = [f"{factor * float(end):.4g}" for end in size.group(1, 2) if end]
        return size[0] if factor == 1.0 else f"{' to '.join(ends)} {unit.replace('s2', 's²')}"

    return SIZE.sub(converted, sentence)


def shown_dataset(dataset: xr.Dataset) -> xr.Dataset:
    """A dataset with every variable in the units of its study, for files of other programs."""
    system, found = system_of(dataset), dataset.copy()
    for name, variable in dataset.variables.items():
        if str(name).endswith(("_message", "_warning")):
            sentences = [shown_sentence(str(each), dataset) for each in variable.values.flat]
            found[name] = (variable.dims, np.reshape(np.array(sentences), variable.shape), variable.attrs)
            continue
        factor, unit = in_system(str(variable.attrs.get("units", "1")), system)
        if factor != 1.0 and np.issubdtype(variable.dtype, np.floating):
            found[name] = (variable.dims, variable.values * factor, {**variable.attrs, "units": unit})
    return found
