"""OUTPUT4 and DMIG files, written from the description of the formats."""

import struct

import numpy as np

STYLES = ("dense", "strings", "big")


def strings_of(column):
    """First row (from 1) and values of each run of entries that are not zero."""
    filled = np.flatnonzero(column)
    breaks = np.split(filled, np.flatnonzero(np.diff(filled) > 1) + 1)
    return [(int(run[0]) + 1, column[run]) for run in breaks if run.size]


def form_of(matrix):
    """Symmetric or square."""
    return 6 if np.array_equal(matrix, matrix.T) else 1


def op4_text(matrices, style, width=8):
    """Formatted OUTPUT4, 1P,3E23.16. The length of a dense column is in numbers, as Nastran writes it, or, wide, in words."""
    lines = []
    for name, matrix in matrices.items():
        size = len(matrix)
        head = (size, -size if style == "big" else size, form_of(matrix), 2)
        lines.append("".join(f"{n:{width}d}" for n in head) + f"{name:8s}1P,3E23.16")
        for number, column in enumerate(matrix.T, start=1):
            runs = strings_of(column)
            if not runs:
                continue
            if style == "dense":
                first, last = runs[0][0], runs[-1][0] + len(runs[-1][1]) - 1
                lines.append(f"{number:{width}d}{first:{width}d}{(last - first + 1) * width // 8:{width}d}")
                lines += values_in_lines(column[first - 1 : last])
                continue
            heads = 2 if style == "big" else 1
            words = sum(heads + 2 * len(values) for _, values in runs)
            lines.append(f"{number:{width}d}{0:{width}d}{words:{width}d}")
            for first, values in runs:
                size_and_one = 2 * len(values) + 1
                big = f"{size_and_one:{width}d}{first:{width}d}"
                lines.append(big if style == "big" else f"{first + 65536 * size_and_one:12d}")
                lines += values_in_lines(values)
        lines += [f"{size + 1:{width}d}{1:{width}d}{1:{width}d}", f"{2.0**0.5:23.16E}"]
    return "\n".join(lines) + "\n"


def values_in_lines(values):
    return ["".join(f"{value:23.16E}" for value in values[k : k + 3]) for k in range(0, len(values), 3)]


def op4_binary(matrices, style, order="<", word=4):
    """Unformatted OUTPUT4 in double precision, of either byte order and length of words.

    As Nastran writes it: the last record says one word but holds one number, and words of eight bytes hold four letters.
    """
    integer = "i" if word == 4 else "q"
    per_value = 8 // word

    def record(*numbers, data=b""):
        content = struct.pack(f"{order}{len(numbers)}{integer}", *numbers) + data
        mark = struct.pack(f"{order}i", len(content))
        return mark + content + mark

    parts = []
    for name, matrix in matrices.items():
        size = len(matrix)
        letters = (name.ljust(8)[:4].ljust(word) + name.ljust(8)[4:].ljust(word)).encode()
        parts.append(record(size, -size if style == "big" else size, form_of(matrix), 2, data=letters))
        for number, column in enumerate(matrix.T, start=1):
            runs = strings_of(column)
            if not runs:
                continue
            if style == "dense":
                first, last = runs[0][0], runs[-1][0] + len(runs[-1][1]) - 1
                data = column[first - 1 : last].astype(f"{order}f8").tobytes()
                parts.append(record(number, first, len(data) // word, data=data))
                continue
            data = b""
            for first, values in runs:
                size_and_one = per_value * len(values) + 1
                heads = (size_and_one, first) if style == "big" else (first + 65536 * size_and_one,)
                data += struct.pack(f"{order}{len(heads)}{integer}", *heads) + values.astype(f"{order}f8").tobytes()
            parts.append(record(number, 0, len(data) // word, data=data))
        parts.append(record(size + 1, 1, 1, data=struct.pack(f"{order}d", 2.0**0.5)))
    return b"".join(parts)


def dmig(matrices, style, places=None):
    """DMIG entries with one triangle: large fields, small fields (few digits) or commas; the grid points are 1, 2, ...

    places: grid point and component of each row, unless these are 1, 2, ... and 1.
    """
    lines = ["$ a comment"]
    for name, matrix in matrices.items():
        form = form_of(matrix)
        points = places or [(row, 1) for row in range(1, len(matrix) + 1)]
        fields = ("DMIG", name, 0, form, 2, 0, "", "", len(matrix))
        lines.append(",".join(map(str, fields)) if style == "free" else "".join(f"{field!s:<8}" for field in fields))
        for column in range(len(matrix)):
            rows = range(column if form == 6 else 0, len(matrix))
            terms = [(*points[row], matrix[row, column]) for row in rows if matrix[row, column]]
            if terms:
                lines += {"large": large, "small": small, "free": free}[style](name, points[column], terms)
    return "\n".join(lines) + "\n"


def large(name, column, terms):
    head = f"DMIG*   {name:<16}{column[0]:16d}{column[1]:16d}"
    return [head, *(f"*       {point:16d}{axis:16d}{value:16.9E}".replace("E", "D") for point, axis, value in terms)]


def small(name, column, terms):
    lines = [f"DMIG    {name:<8}{column[0]:8d}{column[1]:8d}        "]
    for place, (point, axis, value) in enumerate(terms):
        text = f"{value:.2E}".replace("E+0", "+").replace("E-0", "-")
        lines[-1] += f"{point:8d}{axis:8d}{text:>8}{'':8}"
        if place % 2 == 0 and place + 1 < len(terms):
            lines.append("        ")
    return lines


def free(name, column, terms):
    (point, axis, value), *more = terms
    head = f"DMIG,{name},{column[0]},{column[1]},,{point},{axis},{float(value)!r}"
    return [head, *(f",{point},{axis},{float(value)!r}" for point, axis, value in more)]
