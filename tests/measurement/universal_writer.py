"""A writer of universal files for the tests, from the definition of the data sets: fields of fixed width, and bytes in 58b."""

import struct

import numpy as np

MARK = "    -1\n"
FREQUENCY, DISPLACEMENT, VELOCITY, ACCELERATION, FORCE = 18, 8, 11, 12, 13


def data_set(number, *lines):
    return (MARK + f"{number:6d}\n" + "".join(line + "\n" for line in lines) + MARK).encode()


def header(program="ANALYSER"):
    """Data set 151."""
    return data_set(
        151,
        "wing",
        "a wing",
        "DB",
        "01-Jan-26 12:00:00         0         0         0",
        "01-Jan-26 12:00:00",
        program,
        "02-Jan-26 13:00:00",
    )


def units(code=1, length=1.0, force=1.0):
    """Data set 164: numbers of the file divided by these factors are in SI."""
    factors = "".join(f"{value:25.17E}".replace("E", "D") for value in (length, force, 1.0, 273.15))
    return data_set(164, f"{code:10d}{'units':<20}{2:10d}", factors[:75], factors[75:])


def nodes(places):
    """Data set 15: {node: (x, y, z)}."""
    return data_set(
        15, *(f"{node:10d}{0:10d}{0:10d}{8:10d}" + "".join(f"{x:13.5E}" for x in place) for node, place in places.items())
    )


def nodes_in_double(places):
    """Data set 2411."""
    lines = []
    for node, place in places.items():
        lines += [f"{node:10d}{1:10d}{1:10d}{8:10d}", "".join(f"{x:25.16E}".replace("E", "D") for x in place)]
    return data_set(2411, *lines)


def function(
    x,
    y,
    kind=4,
    response=(12, 3),
    reference=(1, 1),
    ordinate=(ACCELERATION, "NONE"),
    denominator=(FORCE, "NONE"),
    abscissa=(FREQUENCY, "Hz"),
    double=False,
    even=None,
    ids=("H", "Run 1", "NONE", "NONE", "NONE"),
    entities=("NONE", "NONE"),
    binary="",
):
    """Data set 58, or with binary "<" or ">" 58b: complex or real y over x, evenly spaced unless x is not."""
    y, x = np.asarray(y), np.asarray(x, dtype=float)
    complex_ = np.iscomplexobj(y)
    even = np.allclose(np.diff(x), x[1] - x[0]) if even is None else even
    form = {(False, False): 2, (False, True): 4, (True, False): 5, (True, True): 6}[complex_, double]
    first, step = (x[0], x[1] - x[0]) if even else (0.0, 0.0)
    lines = [f"{text:<80}" for text in ids]
    ends = (
        f" {name:<10}{node:10d}{direction:4d}" for name, (node, direction) in zip(entities, (response, reference), strict=True)
    )
    lines.append(f"{kind:5d}{1:10d}{1:5d}{0:10d}" + "".join(ends))
    lines.append(f"{form:10d}{x.size:10d}{int(even):10d}{first:13.5E}{step:13.5E}{0.0:13.5E}")
    for type_, label in (abscissa, ordinate, denominator, (0, "NONE")):
        lines.append(f"{type_:10d}{0:5d}{0:5d}{0:5d} {'NONE':<20} {label:<20}")
    parts = [y.real, y.imag] if complex_ else [y]
    rows = np.stack(([] if even else [x]) + parts, axis=1)
    if binary:
        kinds = ("" if even else "f") + ("d" if double else "f") * len(parts)
        data = b"".join(struct.pack(binary + kinds, *row) for row in rows)
        first_line = f"{58:6d}b{1 if binary == '<' else 2:6d}{2:6d}{11:12d}{len(data):12d}{0:6d}{0:6d}{0:12d}{0:12d}\n"
        return (MARK + first_line + "\n".join(lines) + "\n").encode() + data + MARK.encode()
    widths = [] if even else ["13.5E"]
    widths += ["20.12E" if double else "13.5E"] * len(parts)
    fields = [f"{value:{width}}" for row in rows for value, width in zip(row, widths, strict=True)]
    a_line = 6 if not double else 4 if even or not complex_ else 3
    lines += ["".join(fields[k : k + a_line]) for k in range(0, len(fields), a_line)]
    return data_set(58, *lines)
