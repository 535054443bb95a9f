"""A user's case from file to report: two finite-element blades and a wedge between them, with hundreds of contact nodes.

The blades are files as CalculiX writes them (matrices, names of rows, deck with sets of nodes), of quadratic hexahedra: 160 mm
long, 6 mm thick, with platforms whose undersides rise at 40°. Each row is the command `stickslip run` in a process of its own,
from reading to the report, after one run that compiles the kernels.
"""

from __future__ import annotations

import os
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from channel import Side
from environment import BUILD, ONE_THREAD
from scipy import sparse

from stickslip.analyses.forced_response import forced_response
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact, between
from stickslip.model.loads import BaseMotion
from stickslip.model.problem import Problem
from stickslip.model.structure.assembly import Spring
from stickslip.model.structure.matrices import Structure
from stickslip.model.structure.solid import Material, Solid, box_mesh, solid

STEEL = Material(young=200e9, poisson=0.3, density=7800.0)
SLOPE = np.tan(np.radians(40.0))
TOP, EDGE, OUTER, ROOT = 50e-3, 3e-3, 17e-3, 20e-3
"""Height of the platforms, where they begin and end beside the middle of the blade, and height of its thicker root [m]."""

BAND = "frequency = [260.0, 340.0]\nforce_levels = [0.5, 2.0, 8.0]"
STUCK = "at = [220.0]\nforce_levels = [0.001]"

ROWS = {
    "three levels, H 5": ((6, 7), BAND, "harmonics = 5", ""),
    "three levels, H 5, 24 points a side": ((6, 7), BAND, "harmonics = 5", "points = 24"),
    "one frequency, all stuck": ((6, 7), STUCK, "harmonics = 5", ""),
    "finer mesh, three levels, H 3": ((10, 12), BAND, "harmonics = 3", ""),
}
"""Elements of a contact face, frequencies and levels, harmonics, and contact points."""

STUDY = """units = "mm-t-s"

[study]
title = "Two finite-element blades and a wedge"
analysis = "forced_response"

[[structure]]
name = "left"
model = "blade.inp"
keep = {{ tip = [0.0, 160.0, 0.0] }}
modes = 15

[[structure]]
name = "right"
model = "blade.inp"
keep = {{ tip = [0.0, 160.0, 0.0] }}
modes = 15
shift = [40.0, 0.0, 0.0]

[[body]]
name = "damper"
shape = "wedge"
dimensions = {{ width = {width}, height = {height}, depth = {depth}, left_angle = 40.0, right_angle = 40.0 }}
centre = [20.0, 43.0, 0.0]
pull = [0.0, 500.0, 0.0]

[damping]
modal = 0.002

[[contact]]
name = "L"
law = "macroslip"
surface = "left/PLATR"
against = "damper"
kt = 2e4
kn = 4e4
mu = 0.3
{points}

[[contact]]
name = "R"
law = "macroslip"
surface = "right/PLATL"
against = "damper"
kt = 2e4
kn = 4e4
mu = 0.3
{points}

[[force]]
direction = "left/tip.x"
amplitude = 1.0

[[force]]
direction = "right/tip.x"
amplitude = -1.0

[sweep]
{where}
{harmonics}
outputs = ["left/tip.x"]
"""


def fe_blades(stickslip: Side) -> dict[str, Any]:
    """CPU seconds and peak memory of each row, of one mass on many harmonics, and of B2a in the same run."""
    rows = []
    for name, (cells, where, harmonics, points) in ROWS.items():
        folder = BUILD / f"blade-{cells[0]}x{cells[1]}"
        size = write_blade(folder, *cells)
        text = STUDY.format(width=24.0, height=8.0, depth=36.0, where=where, harmonics=harmonics, points=points)
        (folder / "study.toml").write_text(text)
        if not rows:
            _run(folder)
        contacts = 24 if points else (2 * cells[0] + 1) * (2 * cells[1] + 1) - cells[0] * cells[1]
        rows.append({"name": name, "rows": size, "contacts": 2 * contacts, **_run(folder)})
    mass = {"name": "one mass, H 121", "rows": 1, "contacts": 1, "cpu": _one_mass(), "peak_memory_MiB": None}
    request = {"case": "B2a", "settings": {"peaks": True}}
    stickslip.ask("sweep", **request)
    return {"rows": [*rows, mass], "B2a": stickslip.ask("sweep", **request)["cpu"]}


def write_blade(folder: Path, along: int, across: int) -> int:
    """The blade as blade.sti, .mas, .dof and .inp (mm, t, s), with so many elements over each contact face; returns the rows."""
    folder.mkdir(parents=True, exist_ok=True)
    body = _body(along, across)
    kept = body.clamp(lambda points: points[:, 1] < 1e-9)
    places = sparse.triu(kept.K).tocoo()
    for ending, matrix in ((".sti", 1e-3 * kept.K), (".mas", 1e-3 * kept.M)):
        table = np.column_stack([places.row + 1, places.col + 1, matrix[places.row, places.col]])
        np.savetxt(folder / f"blade{ending}", table, fmt=("%d", "%d", "%.13e"))
    named = sorted((row, f"{node + 1}.{axis + 1}") for (node, axis), row in np.ndenumerate(kept.numbers) if row >= 0)
    (folder / "blade.dof").write_text("".join(f"{name}\n" for _, name in named))
    nodes = "".join(f"{k + 1}, {x:.9g}, {y:.9g}, {z:.9g}\n" for k, (x, y, z) in enumerate(1e3 * body.points))
    sets = ""
    x, y, _ = body.points.T
    for name, side in (("PLATR", 1.0), ("PLATL", -1.0)):
        face = np.flatnonzero((side * x > EDGE - 1e-9) & (np.abs(y - _underside(np.abs(x))) < 1e-9))
        sets += f"*NSET, NSET={name}\n" + "".join(f"{node + 1},\n" for node in face)
    (folder / "blade.inp").write_text(f"*NODE\n{nodes}{sets}")
    return kept.size


def _body(along: int, across: int) -> Solid:
    """Blade and platforms, free."""
    below, inside = _underside(EDGE), max(2, along // 3)
    x = np.concatenate([np.linspace(-OUTER, -EDGE, along + 1), [0.0], np.linspace(EDGE, OUTER, along + 1)])
    y = np.concatenate([np.linspace(0.0, below, 10)[:-1], np.linspace(below, TOP, inside + 1), np.linspace(TOP, 0.16, 25)[1:]])
    mesh = box_mesh(x, y, np.linspace(-20e-3, 20e-3, across + 1))
    centre = mesh.p[:, mesh.t].mean(axis=1)
    mesh = mesh.restrict(np.flatnonzero((np.abs(centre[0]) < EDGE) | ((centre[1] > below) & (centre[1] < TOP))))
    places = mesh.p.copy()
    outside = np.abs(places[0]) > EDGE
    share = (TOP - places[1, outside]) / (TOP - below)
    places[1, outside] = TOP - share * (TOP - _underside(np.abs(places[0, outside])))
    places[0, places[1] < ROOT] *= 8.0 / 3.0
    return solid(replace(mesh, doflocs=places), STEEL)


def _underside(x: Any) -> Any:
    """Height of the underside of a platform over the distance from the middle of the blade [m]."""
    return TOP - 3e-3 - SLOPE * (OUTER - x)


def _run(folder: Path) -> dict[str, float]:
    """CPU seconds and peak memory of `stickslip run` in a process of its own."""
    command = [sys.executable, "-m", "stickslip", "run", "study.toml", "--out", "run", "--workers", "1", "--overwrite"]
    began = time.monotonic()
    with open(folder / "run.log", "w", encoding="utf-8") as log:
        actions = [(os.POSIX_SPAWN_DUP2, log.fileno(), 1), (os.POSIX_SPAWN_DUP2, log.fileno(), 2)]
        here = Path.cwd()
        os.chdir(folder)
        child = os.posix_spawn(command[0], command, os.environ | ONE_THREAD, file_actions=actions)
        os.chdir(here)
        _, status, used = os.wait4(child, 0)
    if status:
        raise RuntimeError(f"{folder.name}: {(folder / 'run.log').read_text()[-400:]}")
    cpu, memory = used.ru_utime + used.ru_stime, used.ru_maxrss / 1024.0
    return {"cpu": cpu, "wall": time.monotonic() - began, "peak_memory_MiB": memory}


def _one_mass() -> float:
    """CPU seconds of 1 kg that slips on a shaking ground, kt 1e6 N/m, 121 harmonics, one frequency, kernels loaded."""
    structure = Structure(np.eye(1), np.zeros((1, 1)), ("1.x",))
    ground = Contact("ground", Macroslip(1e6, 0.1, normal_load=10.0), (between("1.x", "ground"),))
    held = (Spring({"1.x": 1.0}, 1e4),)
    problem = Problem(structure, (ground,), (BaseMotion({"1.x": 1.0}, -1j),), ("1.x",), mean_springs=held)
    forced_response(problem, [1.0], 1.5, harmonics=3, samples=1024)
    began = time.process_time()
    forced_response(problem, [1.0], 1.5, harmonics=121, samples=1024)
    return time.process_time() - began
