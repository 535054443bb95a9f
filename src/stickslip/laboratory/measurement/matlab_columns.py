"""Vectors of a MATLAB file as columns of a response, also those in structs, as Testlab and scripts write them."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from stickslip.laboratory.measurement.number_table import FEWEST_ROWS, UNITS, NumberTable, bare, response_unit, stated_unit
from stickslip.support.checks import fault, first_of, nearest

COLUMN = "(:,"
TIMES = tuple(unit for unit, (kind, _) in UNITS.items() if kind == "s")
AXIS = ("start_value", "increment", "number_of_values")
"""Fields of a struct that stands for evenly spaced values."""


def response_columns(
    name: str, arrays: Mapping[str, Any], named: Mapping[str, str | int], what: str = "amplitude"
) -> tuple[NumberTable, dict[str, str | int]]:
    """The table of the vectors of one length in one struct, or beside all structs, and `named` with the titles in it.

    arrays: those of the file by name, "FRF.f". named: vectors by what they hold; one may be given by its struct alone.
    what: of these names the one that a message asks for. A complex vector becomes two columns, real and imaginary part.
    """
    vectors = dict(_vectors(arrays))
    chosen = {
        key: which if isinstance(which, int) or which.isdigit() else _meant(name, vectors, which) for key, which in named.items()
    }
    groups: dict[tuple[str, int], list[str]] = {}
    for key, values in vectors.items():
        groups.setdefault((key.partition(".")[0] if "." in key else "", values.size), []).append(key)
    if own := [vector for vector in chosen.values() if isinstance(vector, str) and vector in vectors]:
        sizes = {vectors[vector].size for vector in own}
        if len(sizes) > 1:
            raise fault(f"The vectors of {name}", "must have one length", {vector: vectors[vector].size for vector in own})
        places = {place for place, keys in groups.items() if {*keys} & {*own}}
        used = [key for place in places for key in groups[place]]
    else:
        several = [keys for keys in groups.values() if len(keys) > 1]
        if len(several) != 1:
            shown = first_of([f"{key} ({values.size})" for key, values in vectors.items()]) or "no vectors of numbers"
            example = next(iter(vectors), "FRF.H")
            remedy = f"Say which it is, such as columns={{'{what}': '{example}'}} (--column '{what}={example}')."
            raise fault(f"The vectors of {name}", "must be those of one response, of one length", shown, remedy)
        used = several[0]
    columns: dict[str, tuple[Any, str | None]] = {}
    for key in used:
        title, unit = _title(key, arrays), _unit(key, arrays)
        title = key if title in columns else title
        parts = (("_real", "real"), ("_imag", "imag")) if np.iscomplexobj(vectors[key]) else (("", "real"),)
        columns |= {f"{title}{end}": (getattr(vectors[key], part), unit) for end, part in parts}
        for quantity in [quantity for quantity, vector in chosen.items() if vector == key]:
            del chosen[quantity]
            if len(parts) == 1:
                chosen[quantity] = title
            else:
                chosen |= {"real": f"{title}_real", "imaginary": f"{title}_imag"}
    numbers = np.stack([np.asarray(values, dtype=float) for values, _ in columns.values()], axis=1)
    return NumberTable(name, numbers, tuple(columns), tuple(unit for _, unit in columns.values())), chosen


def _vectors(arrays: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Vectors of numbers by name; columns of matrices as H(:,2); evenly spaced ones of the length of another."""
    sizes = set()
    for key, value in arrays.items():
        values = np.atleast_2d(np.asarray(value))
        if values.dtype.kind not in "fiubc" or values.ndim != 2:
            continue
        values = values.T if values.shape[0] < values.shape[1] else values
        if values.shape[0] < FEWEST_ROWS:
            continue
        sizes.add(values.shape[0])
        for k in range(values.shape[1]):
            yield key if values.shape[1] == 1 else f"{key}{COLUMN}{k + 1})", values[:, k]
    for key in [key.removesuffix(f".{AXIS[0]}") for key in arrays if key.endswith(f".{AXIS[0]}")]:
        fields = [np.ravel(arrays.get(f"{key}.{field}", ())) for field in AXIS]
        if all(field.size == 1 and field.dtype.kind in "fiu" for field in fields) and float(fields[2][0]) in sizes:
            yield key, float(fields[0][0]) + float(fields[1][0]) * np.arange(int(fields[2][0]))


def _meant(name: str, vectors: Mapping[str, Any], which: str) -> str:
    """The vector of a name, or the only one in the struct of a name beside evenly spaced ones."""
    if which in vectors:
        return which
    inside = [key for key in vectors if key.startswith(f"{which}.") and not key.endswith(".x_values")]
    if len(inside) == 1:
        return inside[0]
    remedy = f"It holds {first_of(inside)}." if inside else nearest(which, vectors)
    raise fault(f"The vector that is named in {name}", "must be one of the file", which, remedy)


def _title(key: str, arrays: Mapping[str, Any]) -> str:
    """What a vector is called: without its struct, unless the rest says nothing; evenly spaced frequencies by their unit."""
    if f"{key}.{AXIS[0]}" in arrays:
        label = _label(key, arrays)
        unit = response_unit(label)
        kind = "frequency" if unit is not None and unit.kind == "frequency" else "time" if label in TIMES else ""
        return kind or key
    whole, _, column = key.removesuffix(")").partition(COLUMN)
    struct, _, rest = whole.partition(".")
    return f"{bare(rest if rest and not rest.endswith('values') else f'{struct} {rest}'.strip())} {column}".strip()


def _unit(key: str, arrays: Mapping[str, Any]) -> str | None:
    """Its unit: at the end of its name, or the label of a struct y_values or x_values that nothing scales."""
    owner = key if f"{key}.{AXIS[0]}" in arrays else key.rpartition(".")[0]
    label = _label(owner, arrays)
    factor = np.ravel(arrays.get(f"{owner}.quantity.unit_transformation.factor", (1.0,)))
    known = response_unit(label) is not None or label in TIMES
    return label if known and np.all(factor == 1.0) else stated_unit(key.partition(COLUMN)[0])


def _label(owner: str, arrays: Mapping[str, Any]) -> str:
    """The text of a field quantity.label; files of version 7.3 hold its characters as numbers."""
    value = np.asarray(arrays.get(f"{owner}.quantity.label", ""))
    if value.dtype.kind == "u":
        return "".join(chr(int(code)) for code in value.ravel()[:80])
    return "".join(map(str, value.ravel()[:80])).strip() if value.dtype.kind == "U" else ""
