"""The plane of tangential forces of a damper with two sides, and its limit lines (Yang and Menq, J. Eng. Gas Turbines Power
120(2), 1998, 410-417): docs/variability.md says where it misleads. `python -m verify.force_plane` draws the figure of this page.

A damper without mass, held by nothing but two contacts and its pull, is in balance at every moment: its normal forces then follow
from the tangential ones, and |T_i| = μ_i N_i are four straight lines. Between them both sides stick.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import stickslip as ss
from stickslip.show.plots.chart import Area, Axis, Chart, Layer, Line, Panel, closed
from stickslip.show.plots.look import Style
from stickslip.show.plots.paper import drawn, write_figure
from stickslip.show.plots.time_response import BOUNDS, Cycles, bound_cycles
from stickslip.support.checks import Array, fault
from stickslip.support.late import xr


@dataclass(frozen=True, eq=False)
class ForcePlane:
    """N = offset + slope T of both sides, (2,) [N] and (2, 2); friction (2,): μ of each; sides: their names."""

    offset: Array
    slope: Array
    friction: Array
    sides: tuple[str, str]

    def normal(self, tangential: Array) -> Array:
        """Normal forces (..., 2) that balance tangential ones (..., 2)."""
        return np.asarray(self.offset + tangential @ self.slope.T)

    def limit(self, side: int, sense: int, along: Array) -> Array:
        """Points (n, 2) of the line T_side = sense μ N, at these forces of the other side [N]."""
        factor = sense * self.friction[side]
        own, other = self.slope[side, side], self.slope[side, 1 - side]
        tangential = factor * (self.offset[side] + other * along) / (1.0 - factor * own)
        return np.stack([tangential, along] if side == 0 else [along, tangential], axis=-1)

    def corners(self) -> Array:
        """Where the lines of the two sides cross, (4, 2), in the order round the region of sticking."""
        found = []
        for first, second in ((1, 1), (1, -1), (-1, -1), (-1, 1)):
            factor = np.array([first, second]) * self.friction
            found.append(np.linalg.solve(np.eye(2) - factor[:, None] * self.slope, factor * self.offset))
        return np.array(found)

    def inside(self, tangential: Array) -> Array:
        """Whether forces (..., 2) lie within all lines, to a millionth of the limits."""
        limits = self.friction * self.normal(tangential)
        return np.asarray(np.all(np.abs(tangential) <= limits + 1e-6 * np.abs(limits).max(), axis=-1))


def force_plane(problem: ss.Problem, damper: Sequence[str], sides: tuple[str, str]) -> ForcePlane:
    """The plane of a damper: damper: its two degrees of freedom in the plane of motion; sides: the contact, or the points
    "NAME 1", "NAME 2", ... , on each side. Inertia, moments, other springs and the second tangential direction are left out.
    """
    dofs = [problem.structure.index(dof) for dof in damper]
    if len(dofs) != 2:
        raise fault("damper", "must name two degrees of freedom", list(damper))
    pull = problem.load(1)[dofs, 0]
    contacts = []
    for side in sides:  # the contact of this name, or the points of a surface of this name
        named = [c for c in problem.contacts if c.name == side or (c.name.rpartition(" ")[0] == side and c.name[-1].isdigit())]
        if not named or any(len(c.direction_names) < 2 or c.normal is None for c in named):
            raise fault("side", "must name contacts with friction and a normal direction", side)
        contacts.append(named)
    tangents, normals = (
        np.array([[group[0].directions[which].get(dof, 0.0) for dof in damper] for group in contacts]).T for which in (0, -1)
    )
    for side, group in zip(sides, contacts, strict=True):
        if group[0].elements.friction[0].bend.size:
            raise fault(f"mu of {side}", "must be a number, for the limit lines to be straight", "one that depends on the load")
    inverse = np.linalg.inv(normals)
    friction = np.array([float(group[0].elements.friction[0].friction[0]) for group in contacts])
    return ForcePlane(inverse @ pull, -inverse @ tangents, friction, sides)


SLIPPING = 1.0 - 1e-6
"""Share of its own limit μN at which a side slips."""


def plane_chart(dataset: xr.Dataset, plane: ForcePlane, case: int, frequency: float) -> Chart:
    """T of one side of a damper against T of the other at both bounds; dots: where a side slips; grey: the limit lines.

    Slip off the lines and forces beyond them are what the static picture leaves out: inertia, other springs, rotation, lift-off.
    """
    cycles = bound_cycles(dataset, case, frequency)
    paths = paths_in(cycles, plane)
    reach = 1.15 * max(float(np.abs(paths).max()), float(np.abs(plane.corners()).max()))
    layers: list[Layer] = []
    for side, sense in ((0, -1), (0, 1), (1, -1), (1, 1)):
        x, y = plane.limit(side, sense, np.array([-reach, reach])).T
        layers.append(Line(x, y, Style("grey", width=0.9), "a side slips, statically"))
    x, y = plane.corners().T
    layers.append(Area(x, y, Style("grey", opacity=0.12), "both stick, statically"))
    for k, (word, style) in enumerate(BOUNDS):
        path, label = paths[k], f"{word} bound"
        layers.append(Line(closed(path[:, 0]), closed(path[:, 1]), style, label))
        slipping, dots = path[slips(cycles, plane, k)], replace(style, dash="none", marker="circle")
        layers.append(Line(slipping[:, 0], slipping[:, 1], dots, label, listed=False))
    left, right = (Axis(f"tangential force of {side}", "N", limits=(-reach, reach)) for side in plane.sides)
    title = f"Tangential forces of both sides, force {float(dataset['force_level'][case]):g}"
    return Chart(title, [Panel(left, right, layers, height=4.0, equal=True)])


def paths_in(cycles: Cycles, plane: ForcePlane) -> Array:
    """Tangential forces of both sides over the period, (curve, sample, 2)."""
    return np.stack([cycles.force[:, cycles.row(f"{side} t1")] for side in plane.sides], axis=-1)


def slips(cycles: Cycles, plane: ForcePlane, curve: int) -> Array:
    """Where a side of a curve has reached its own limit μN, (sample,)."""
    loads = np.stack([cycles.force[curve, cycles.row(f"{side} n")] for side in plane.sides], axis=-1)
    reached = np.abs(paths_in(cycles, plane)[curve]) >= SLIPPING * plane.friction * loads
    return np.asarray(np.any(reached, axis=-1))


if __name__ == "__main__":
    wedge = ss.rigs.three_mass_wedge()
    bounds = ss.response_bounds(wedge, np.linspace(204.0, 234.0, 11)).dataset
    chart = plane_chart(bounds, force_plane(wedge, ("D.x", "D.y"), ("blade 1", "blade 2")), 0, 222.0)
    write_figure(drawn(chart), Path(__file__).parents[1] / "docs" / "figures" / "variability_plane.svg", "svg")
