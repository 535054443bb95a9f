"""Deformed shapes as a file of VTK (.vtu, XML in text), for ParaView and other programs.

Written here and not by meshio, which would be one more dependency for forty lines and has had no release since January 2024.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from stickslip.analyses.deformed_shape import SurfaceMotion
from stickslip.results.shown_units import in_system
from stickslip.support.checks import InputError
from stickslip.support.files import write_text


def save_vtu(shapes: Mapping[str, SurfaceMotion], path: str | Path) -> Path:
    """Write deformed shapes {name: shape} of one surface to a .vtu file, in the units of their study, and return its path.

    The file contains the points and triangles of the surface at rest, and for each shape NAME three fields: "NAME, real part" and
    "NAME, imaginary part" (p, 3), u(t) = Re cos ωt − Im sin ωt, and "NAME, amplitude" (p,), the largest displacement in the
    period.
    """
    if not shapes:
        raise InputError("A .vtu file must contain deformed shapes, but these results have none: no body has a surface mesh.")
    first = next(iter(shapes.values()))
    metre, unit = in_system("m", first.system)
    fields: dict[str, Any] = {}
    for name, shape in shapes.items():
        fields[f"{name}, real part [{unit}]"] = metre * shape.displacement.real
        fields[f"{name}, imaginary part [{unit}]"] = metre * shape.displacement.imag
        fields[f"{name}, amplitude [{unit}]"] = metre * shape.amplitude
    count = len(first.triangles)
    cells = [
        _array("connectivity", first.triangles.ravel(), "Int32"),
        _array("offsets", 3 * np.arange(1, count + 1), "Int32"),
        _array("types", np.full(count, 5), "UInt8"),  # the number of the triangle among the cells of VTK
    ]
    text = (
        '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">\n<UnstructuredGrid>\n'
        f'<Piece NumberOfPoints="{len(first.points)}" NumberOfCells="{count}">\n'
        f"<Points>\n{_array('points', metre * first.points)}</Points>\n<Cells>\n{''.join(cells)}</Cells>\n"
        f"<PointData>\n{''.join(_array(name, values) for name, values in fields.items())}</PointData>\n"
        "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n"
    )
    return write_text(path, text)


def _array(name: str, values: Any, kind: str = "Float32") -> str:
    """One array in text, a row a line."""
    table = np.reshape(values, (len(values), -1))
    form = "%.7g" if kind.startswith("Float") else "%d"
    rows = "".join(" ".join(form % value for value in row) + "\n" for row in table.tolist())
    head = f'<DataArray type="{kind}" Name={quoteattr(name)} NumberOfComponents="{table.shape[1]}" format="ascii">'
    return f"{head}\n{rows}</DataArray>\n"
