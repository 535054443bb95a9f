"""A commented study of a finite-element model, with a small model beside it that stands in for one of another program."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stickslip.files import replacing, write_text
from stickslip.structure.solid import box_mesh, solid

MODEL = """\
# Forced response of a finite-element model with friction: `stickslip info {file} --units mm-t-s` describes the model,
# `stickslip check FILE` validates this file and says which nodes were found, `stickslip run FILE --out DIR` computes it.

units = "mm-t-s"                  # of every number in this file and of the model: mm, t, s, N; SI when left out

[study]
title = "Blade between two pads"
analysis = "forced_response"

[structure]
model = "{file}"{pad}# of MATLAB, CalculiX, Abaqus, Nastran, Ansys, ...: see "Bring your own model" in the documentation
# names = "rows.csv"              # nodes and directions of the rows, where the file does not name them
keep = {{ left = [0.0, 60.0, 0.0], right = [0.0, 60.0, 30.0], tip = [0.0, 120.0, 0.0] }}  # mm; or a node, or a set by its name
modes = 10                        # everything else becomes so many modes

[damping]
modal = 0.002

[[contact]]
law = "macroslip"
tangential = [{{ "left.x" = 1.0 }}, {{ "left.y" = 1.0 }}]
normal = {{ "left.z" = -1.0 }}      # closes towards the pad outside
kt = 1000.0                       # N/mm
kn = 1000.0
mu = 0.4
preload = 20.0                    # N

[[contact]]
law = "macroslip"
tangential = [{{ "right.x" = 1.0 }}, {{ "right.y" = 1.0 }}]
normal = {{ "right.z" = 1.0 }}
kt = 1000.0
kn = 1000.0
mu = 0.4
preload = 20.0

[[force]]
at = "tip.x"
amplitude = 1.0                   # N

[sweep]
frequency = [440.0, 640.0]        # Hz
force_levels = [0.5, 5.0, 20.0, 100.0]
harmonics = 3
outputs = ["tip.x"]
"""

SIZES = (8.0, 120.0, 30.0)
"""Thickness, height and width of the blade, mm."""


def write_model(path: Path) -> list[Path]:
    """A clamped blade as another program would export it: matrices in mm, t, s with names and coordinates of its nodes."""
    file = path.with_suffix(".npz")
    with replacing(file) as temporary:
        np.savez_compressed(temporary, **_blade())  # type: ignore[arg-type]
    return [write_text(path, MODEL.format(file=file.name, pad=" " * max(1, 24 - len(file.name)))), file]


def _blade() -> dict[str, object]:
    thickness, height, width = (1e-3 * size for size in SIZES)
    lines = (np.array([0.0, thickness]), np.linspace(0.0, height, 9), np.linspace(0.0, width, 3))
    blade = solid(box_mesh(*lines)).clamp(lambda points: points[:, 1] < 1e-9)
    names = {
        int(row): f"{node}.{axis}"
        for node, rows in enumerate(blade.numbers, start=1)
        for axis, row in zip("xyz", rows, strict=True)
        if row >= 0
    }
    nodes = np.column_stack([np.arange(1, len(blade.points) + 1), 1e3 * blade.points])
    dofs = [names[row] for row in range(blade.size)]
    return {"M": 1e-3 * blade.M.toarray(), "K": 1e-3 * blade.K.toarray(), "dofs": dofs, "nodes": nodes}
