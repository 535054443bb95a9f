"""The models and measurements beside templates of studies: `python tools/template_files.py` renews study/templates/beside.

They are kept as files, so that `stickslip new` has nothing to mesh or solve and writes the same numbers on every machine; the
results on the pages start from these. Models stand as another program would export them: matrices with names of rows, and a
table of nodes with sets.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.analyses.forced_response import forced_response
from stickslip.analyses.free_decay import free_decay
from stickslip.laboratory.measurement.reconstruction import RigErrors
from stickslip.model.dampers.between_platforms import in_phase, out_of_phase
from stickslip.model.dampers.laboratory import laboratory_damper
from stickslip.model.rigs import blade_and_wedge, three_mass_wedge
from stickslip.model.structure.solid import Solid, box_mesh, solid
from stickslip.support.checks import Array
from stickslip.support.files import write_arrays, write_text
from verify.identification import loop_of
from verify.synthetic_records import synthetic_record, true_cycle, write_record

FOLDER = Path(__file__).parents[1] / "src" / "stickslip" / "study" / "templates" / "beside"


def wedge_matrices(folder: Path) -> None:
    """lumped: M, K and C of the three-mass wedge."""
    structure = three_mass_wedge().structure
    write_arrays(folder / "lumped" / "study.npz", {"M": structure.M, "K": structure.K, "C": np.asarray(structure.C)})


def loops(folder: Path) -> None:
    """identification: two loops of the laboratory damper, measured with the errors of a rig."""
    rig, errors = laboratory_damper(37.0), RigErrors()
    systematic = errors.draw(np.random.default_rng(0))
    for seed, (name, motion) in enumerate({"out_of_phase": out_of_phase(30e-6), "in_phase": in_phase(30e-6)}.items()):
        record = synthetic_record(true_cycle(rig, motion), errors, seed=seed, systematic=systematic, cycles=10, name=name)
        write_record(record, folder / "identification" / f"study_{name}.csv")


def stepped_sines(folder: Path) -> None:
    """Stepped sines of the blade on a wedge at four forces with 1 % noise, amplitude and phase."""
    rng = np.random.default_rng(0)
    frequencies = 350.35 + np.array([-40.0, -30, -22, -15, -10, -6, -4, -2.5, -1.5, -0.7, 0, 0.7, 1.5, 2.5, 4, 6, 10, 15, 20])
    for force in (0.5, 6.0, 15.0, 10.0):
        data = forced_response(blade_and_wedge(pull=60.0), frequencies.tolist(), force, harmonics=9).dataset
        X = data["response"].values[0, :, 0, 1] @ np.array([1.0, 1j]) * (2.0 * np.pi * frequencies) ** 2
        X = X * (1.0 + 0.01 * (rng.normal(size=X.size) + 1j * rng.normal(size=X.size)))
        rows = [f"{f:.6g},{abs(x):.6g},{force:g},{np.angle(x):.6g}" for f, x in zip(frequencies, X, strict=True)]
        text = "\n".join(["frequency [Hz],acceleration [m/s2],force [N],phase [rad]", *rows]) + "\n"
        for kind in ("response_identification", "response_prediction", "decay_prediction"):
            if force != 10.0 or kind == "response_prediction":
                write_text(folder / kind / f"study_{force:g}_N.csv", text)


def ring_down(folder: Path) -> None:
    """The displacement with 0.2 % noise while the motion decays after the excitation at 15 N has stopped."""
    problem, rng = blade_and_wedge(pull=60.0), np.random.default_rng(1)
    decay = free_decay(problem, 0.5, frequency=333.0, force=15.0, steps=32_000).dataset
    time, motion = decay["time"].values[::8], decay["displacement"].values[0, ::8]
    motion = motion + 2e-3 * np.abs(motion).max() * rng.normal(size=motion.size)
    rows = [f"{t:.6g},{u:.6g}" for t, u in zip(time, motion, strict=True)]
    write_text(folder / "decay_prediction" / "study_ring_down.csv", "\n".join(["time [s],displacement [m]", *rows]) + "\n")


def contact_record(folder: Path) -> None:
    """Twenty cycles of one slider as a rig would record them."""
    generator, cycles, samples = np.random.default_rng(0), 20, 400
    u, force = (np.tile(signal, cycles) for signal in loop_of([1.0], 20e6, 0.4, 100.0, 10e-6, samples))
    time = np.arange(u.size) / (10.0 * samples)
    drift = np.linspace(0.0, 1e-6, u.size)
    u = 1.004 * u + drift + 0.08e-6 * generator.standard_normal(u.size)
    force = 0.995 * force + 0.7 + 0.1 * generator.standard_normal(u.size)
    rows = [f"{t:.6g},{1e6 * x:.6g},{f:.6g}" for t, x, f in zip(time, u, force, strict=True)]
    write_text(folder / "contact_law" / "study.csv", "\n".join(["time [s],displacement [um],friction force [N]", *rows]) + "\n")


MM = 1e-3
Where = Callable[[Array], bool]
"""Whether a point [mm] belongs to a set of nodes."""

BLADE = (8.0, 120.0, 30.0)
"""Thickness, height and width of the blade, mm."""


def blade_model(folder: Path) -> None:
    """A clamped blade: matrices in mm, t, s with names and coordinates of its nodes."""
    thickness, height, width = BLADE
    blade = _block([0.0, thickness], np.linspace(0.0, height, 9), np.linspace(0.0, width, 3))
    _write_matrices(folder / "model" / "study.npz", blade.clamp(lambda points: points[:, 1] < 1e-9))


def two_jointed_beams(folder: Path) -> None:
    """Beams of 40 x 20 x 5 and 140 x 20 x 5 mm that overlap by 20 mm, the short one clamped; 3 x 5 nodes each in the joint."""
    x, y = [20.0, 30.0, 40.0], [0.0, 5.0, 10.0, 15.0, 20.0]
    upper = _block(np.arange(0.0, 41.0, 10.0), y, [0.0, 5.0]).clamp(lambda points: points[:, 0] < 1e-9)
    lower = _block(np.arange(20.0, 161.0, 10.0), y, [-5.0, 0.0])
    joint = _on(x, y, [0.0])
    _write(folder / "jointed_beams", {"upper": (upper, {"JOINT": joint}), "lower": (lower, {"JOINT": joint})})


def two_beams_with_a_gap(folder: Path) -> None:
    """Clamped beams of 160 x 20 x 3.344 mm, 0.01 mm apart; 5 x 3 nodes on each side of the last quarter of both."""
    x, y, thickness, gap = np.linspace(0.0, 160.0, 17), [0.0, 10.0, 20.0], 3.344, 0.01
    end = x[x >= 120.0].tolist()
    beams = {}
    for name, bottom in (("upper", gap), ("lower", -thickness)):
        beam = _block(x, y, [bottom, bottom + thickness]).clamp(lambda points: points[:, 0] < 1e-9)
        inside, outside = (bottom, bottom + thickness) if name == "upper" else (0.0, bottom)
        beams[name] = (beam, {"INSIDE": _on(end, y, [inside]), "OUTSIDE": _on(end, y, [outside])})
    _write(folder / "beams_with_a_gap", beams)


STALK, PLATFORM_EDGE, PLATFORM_FOOT, PLATFORM_TOP, RISE = 4.0, 18.0, 46.0, 58.0, 30.0
"""Of a blade with a platform, mm: half widths of the stalk and the platform, heights of the foot and top of the platform; and the
slope of its underside, degrees."""


def blade_with_a_platform(folder: Path) -> None:
    """A clamped blade of 160 mm with a platform whose undersides rise to both sides."""
    side = np.linspace(STALK, PLATFORM_EDGE, 3)
    heights = [0.0, 0.5 * PLATFORM_FOOT, PLATFORM_FOOT, PLATFORM_TOP, 92.0, 126.0, 160.0]
    mesh = box_mesh([*-side[::-1], *side], heights, [-15.0, 0.0, 15.0])
    x, y, _ = mesh.p[:, mesh.t].mean(axis=1)
    mesh = mesh.remove_elements(np.flatnonzero((np.abs(x) > STALK) & ((y < PLATFORM_FOOT) | (y > PLATFORM_TOP))))
    points = mesh.p.copy()
    points[1] = np.where(np.isclose(points[1], PLATFORM_FOOT), _foot(points[0]), points[1])
    blade = solid(type(mesh)(MM * points, mesh.t)).clamp(lambda points: points[:, 1] < 1e-9)

    def underside(side: float) -> Where:
        return lambda point: side * point[0] > STALK - 1e-6 and abs(point[1] - _foot(point[0])) < 1e-6

    _write(folder / "two_blades", {"blade": (blade, {"PLATFORM_RIGHT": underside(1.0), "PLATFORM_LEFT": underside(-1.0)})})


def _foot(x: Any) -> Any:
    """Height of the underside of a platform, mm."""
    return PLATFORM_FOOT + np.tan(np.radians(RISE)) * np.maximum(np.abs(x) - STALK, 0.0)


SECTORS = 12
RADII = {"bore": 60.0, "rim": 100.0, "underside": 120.0, "top": 132.0, "tip": 200.0}
"""Of a sector of a bladed disk, mm."""
SHANK, PLATFORM, BLADE_WIDTH = 0.3, 0.92, 0.1
"""Half widths of the parts of a sector, relative to half a pitch."""
SLOPE = 25.0
"""Of the undersides of the platforms, which rise towards the gap, degrees."""
HALF_LENGTH = 12.0
"""Of a sector along the axis, mm."""


def bladed_disk_sector(folder: Path) -> None:
    """One of 12 sectors of a disk with blades and platforms; dampers lie under the platforms of neighbours."""
    bore = MM * RADII["bore"]
    body = solid(sector_mesh()).clamp(lambda points: np.hypot(points[:, 0], points[:, 1]) < bore + 1e-9)
    _write(folder / "bladed_disk", {"sector": (body, sector_sets())})


def sector_sets() -> dict[str, Where]:
    """The faces of the sector and the undersides of its platforms."""
    half = np.pi / SECTORS

    def face(side: float) -> Where:
        along = np.array([np.cos(side * half), np.sin(side * half)])
        return lambda point: bool(
            abs(along[0] * point[1] - along[1] * point[0]) < 1e-6 and along @ point[:2] < RADII["rim"] + 1e-6
        )

    def underside(side: float) -> Where:
        ends = np.array([_polar(_underside(width), side * width * half) for width in (SHANK, PLATFORM)])
        along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])

        def on(point: Array) -> bool:
            away = point[:2] - ends[0]
            length = float(np.linalg.norm(ends[1] - ends[0]))
            return bool(abs(along[0] * away[1] - along[1] * away[0]) < 1e-6 and -1e-6 < along @ away < length + 1e-6)

        return on

    return {
        "LOW": face(-1.0),
        "HIGH": face(1.0),
        "PLATFORM_RIGHT": underside(1.0),
        "PLATFORM_LEFT": underside(-1.0),
    }


def sector_mesh(cells: int = 2) -> Any:
    """Hexahedra of a sector in m, `cells` along the axis: a grid of radius, angle and length within the parts."""
    radii = np.array([60.0, 80.0, 100.0, 120.0, 132.0, 166.0, 200.0])
    widths = np.array([-1.0, -PLATFORM, -SHANK, -BLADE_WIDTH, BLADE_WIDTH, SHANK, PLATFORM, 1.0])
    grid = box_mesh(radii, widths, np.linspace(-HALF_LENGTH, HALF_LENGTH, cells + 1))
    radius, width, _ = np.abs(grid.p[:, grid.t].mean(axis=1))
    limits = [1.0, SHANK, PLATFORM, BLADE_WIDTH]
    allowed = np.array(limits)[np.searchsorted([RADII["rim"], RADII["underside"], RADII["top"]], radius)]
    mesh = grid.remove_elements(np.flatnonzero(width > allowed))
    r, w, z = mesh.p
    r = np.where(np.isclose(r, RADII["underside"]), [_underside(abs(each)) for each in w], r)
    x, y = _polar(r, w * np.pi / SECTORS)
    return type(mesh)(MM * np.array([x, y, z]), mesh.t)


def _underside(width: float) -> float:
    """Radius of the underside of a platform at a width relative to half a pitch, mm."""
    rise = np.tan(np.radians(SLOPE)) * RADII["underside"] * np.pi / SECTORS
    return float(RADII["underside"] + rise * max(width - SHANK, 0.0))


def _polar(radius: Any, angle: Any) -> Array:
    return np.array([radius * np.cos(angle), radius * np.sin(angle)])


def _block(x: ArrayLike, y: ArrayLike, z: ArrayLike) -> Solid:
    """A free block of steel between grid lines in mm."""
    return solid(box_mesh(*(MM * np.asarray(lines, dtype=float) for lines in (x, y, z))))


def _on(x: Sequence[float], y: Sequence[float], z: Sequence[float]) -> Where:
    """Whether a point lies on grid lines, all three [mm]: mid-edge nodes do not."""
    lines = [np.asarray(each) for each in (x, y, z)]
    return lambda point: all(np.abs(line - c).min() < 1e-6 for line, c in zip(lines, point, strict=True))


def _write(folder: Path, bodies: Mapping[str, tuple[Solid, Mapping[str, Where]]]) -> None:
    """Matrices and nodes of several bodies, study_NAME.npz and study_NAME.csv."""
    for name, (body, sets) in bodies.items():
        _write_matrices(folder / f"study_{name}.npz", body)
        _write_nodes(folder / f"study_{name}.csv", body, sets)


def _write_matrices(file: Path, body: Solid) -> Path:
    """M and K in mm, t, s with the names of their rows and, for models without a table of nodes, their coordinates."""
    names = {
        int(row): f"{node}.{axis}"
        for node, rows in enumerate(body.numbers, start=1)
        for axis, row in zip("xyz", rows, strict=True)
        if row >= 0
    }
    nodes = np.column_stack([np.arange(1, len(body.points) + 1), body.points / MM])
    dofs = [names[row] for row in range(body.size)]
    matrices = {"M": 1e-3 * body.M.toarray(), "K": 1e-3 * body.K.toarray(), "dofs": dofs, "nodes": nodes}
    return write_arrays(file, matrices, compressed=True)


def _write_nodes(file: Path, body: Solid, sets: Mapping[str, Where]) -> Path:
    """A table of nodes with coordinates [mm] and sets."""
    points = body.points / MM
    rows = [
        ",".join([str(node), *(f"{c:.9g}" for c in point), _sets_at(point, sets)]) for node, point in enumerate(points, start=1)
    ]
    return write_text(file, "\n".join(["node,x,y,z,set", *rows]) + "\n")


def _sets_at(point: Array, sets: Mapping[str, Where]) -> str:
    return " ".join(name for name, holds in sets.items() if holds(point))


MODELS = (wedge_matrices, blade_model, two_jointed_beams, two_beams_with_a_gap, blade_with_a_platform, bladed_disk_sector)
MEASUREMENTS = (loops, stepped_sines, ring_down, contact_record)

if __name__ == "__main__":
    for write in (*MODELS, *MEASUREMENTS):
        write(FOLDER)
