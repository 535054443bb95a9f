"""The model of a problem in space: mesh, nodes, bodies, frames of the contacts, forces, outputs.

Where a contact or a force stands, and along which direction, is read from its coefficients of degrees of freedom, so that the
drawing shows what is computed, not what was meant.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.model.contact.point import Contact
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.loads import BaseMotion, Output
from stickslip.model.problem import Problem
from stickslip.model.problem.speed import CentrifugalLoad
from stickslip.model.structure.assembly import arm_of
from stickslip.model.structure.cyclic import CyclicStructure
from stickslip.model.structure.matrices import Structure
from stickslip.results.schema import in_system
from stickslip.show.plots.look import CONTACTS, colour, house_style
from stickslip.support.checks import Array, Index, InputError
from stickslip.support.late import Figure
from stickslip.support.renderers import FIGURES
from stickslip.support.units import UnitSystem

ARROW = 0.08
"""Length of an arrow, as a share of the extent of the model."""

MOST_POINTS = 8000
"""Nodes of the mesh that are drawn; of more, evenly spread ones."""

NEIGHBOURS = (("preceding sector", -1), ("following sector", 1))
SECTIONS = "sections of bodies"
ROUNDING = 1e-9
"""m, by which points of a mesh may lie outside of the box around its surface."""
SHADED = 0.4
"""Opacity of surfaces, through which contacts are seen."""
FAINT = 0.5
"""Opacity of the mesh, before which the rest stands."""

AXES = "xyz"
SIZES = {"mesh": 2.5, "node": 3.0, "output": 6.0, "body": 6.0}
"""Diameter of points in pixels, by what they are."""


def axes_upright(sides: Array) -> list[int]:
    """The axes in the order in which matplotlib draws them, the longest of the sides (3,) last: upright, as a blade stands."""
    return [(int(np.argmax(sides)) + k) % 3 for k in (1, 2, 3)]  # a cyclic one, since another would mirror the model


def in_space(axes: Any, sides: Array, unit: str) -> None:
    """Names, equal scales and a view of matplotlib's axes for a box of these sides (3,) in a unit of length, drawn in the order
    of `axes_upright`."""
    order = axes_upright(sides)
    names = [f"{AXES[k]} in {unit}" for k in order]
    axes.set(xlabel=names[0], ylabel=names[1], zlabel=names[2])
    axes.set_aspect("equal")
    axes.set_proj_type("ortho")
    axes.view_init(azim=-60.0 if sides[order[0]] > sides[order[1]] else 30.0)
    axes.locator_params(nbins=4)


def scene(sides: Array, unit: str, paper: str) -> dict[str, Any]:
    """Axes and camera of plotly for a box of these sides (3,) in a unit of length, the longest upright; paper: the colour behind
    it."""
    axes = {f"{axis}axis": {"title": {"text": f"{axis} in {unit}"}, "backgroundcolor": paper} for axis in AXES}
    up = {axis: float(place == np.argmax(sides)) for place, axis in enumerate(AXES)}
    # Stated in full, as plotly.js compares it with its own, to see whether the reader has turned it.
    camera = {
        "projection": {"type": "orthographic"},
        "up": up,
        "center": dict.fromkeys(AXES, 0.0),
        "eye": dict.fromkeys(AXES, 1.25),
    }
    # In units of plotly, whose camera stands 2.2 of them away: the longest side and the diagonal, as of a wheel, lie inside the
    # picture. A flat model keeps some thickness.
    shown = np.maximum(sides / (sides.max() or 1.0), 0.02)
    shown *= min(1.7, 1.95 / float(np.linalg.norm(shown)))
    return axes | {"aspectmode": "manual", "aspectratio": dict(zip(AXES, shown.tolist(), strict=True)), "camera": camera}


@dataclass(frozen=True, eq=False)
class Points:
    """Points of one kind under one entry of the legend: label, role of their colour, place (n, 3), a text for each."""

    label: str
    role: str
    kind: str
    places: Array
    texts: Sequence[str] = ()


@dataclass(frozen=True, eq=False)
class Arrows:
    """Arrows under one entry of the legend: feet (n, 3), unit directions (n, 3), a text for each."""

    label: str
    role: str
    feet: Array
    directions: Array
    texts: Sequence[str]


@dataclass(frozen=True, eq=False)
class Faces:
    """An outer surface: label, role of its colour, places (n, 3) of its points, triangles (t, 3) between them."""

    label: str
    role: str
    places: Array
    triangles: Index


@dataclass(frozen=True, eq=False)
class ModelView:
    """What there is to draw of a problem, with all lengths in one unit; sections: corners (k, 3) of each rigid body's outline."""

    title: str
    points: tuple[Points, ...]
    arrows: tuple[Arrows, ...]
    unit: str = "m"
    faces: tuple[Faces, ...] = ()
    sections: tuple[Array, ...] = ()

    @cached_property
    def sides(self) -> Array:
        """Sides of the box around all that is drawn, (3,)."""
        places = [*(each.places for each in self.points), *(each.places for each in self.faces), *self.sections]
        return np.asarray(np.ptp(np.concatenate(places), axis=0))

    @property
    def arrow(self) -> float:
        """Length of an arrow."""
        return ARROW * (float(self.sides.max()) or 1.0)

    def plot(self) -> Figure:
        """As a matplotlib figure."""
        from stickslip.show.plots.paper import NotebookFigure

        order = axes_upright(self.sides)
        figure = NotebookFigure(figsize=(8.0, 6.4))
        figure.subplots_adjust(left=0.02, right=0.68, bottom=0.08, top=0.94)
        with house_style():
            axes: Any = figure.add_subplot(projection="3d")
            for faces in self.faces:
                corners, z = [faces.places[:, k] for k in order[:2]], faces.places[:, order[2]]
                look = {"color": colour(faces.role), "alpha": SHADED, "linewidth": 0.0}
                axes.plot_trisurf(*corners, z, triangles=faces.triangles, label=faces.label, **look)
            for number, section in enumerate(self.sections):
                axes.plot(
                    *section[[*range(len(section)), 0]][:, order].T, color=colour("ink"), label=SECTIONS if not number else None
                )
            for points in self.points:
                look = {"s": SIZES[points.kind] ** 2, "c": colour(points.role), "alpha": FAINT if points.kind == "mesh" else 1.0}
                axes.scatter(*points.places[:, order].T, label=points.label, linewidths=0.0, **look)
            for arrows in self.arrows:
                ends = self.arrow * arrows.directions
                shade = colour(arrows.role)
                axes.quiver(*arrows.feet[:, order].T, *ends[:, order].T, color=shade, label=arrows.label, linewidths=1.2)
            in_space(axes, self.sides, self.unit)
            axes.set(title=self.title)
            figure.legend(loc="center right")
        return figure

    def to_plotly(self, dark: bool = False) -> Any:
        """As a plotly figure that can be turned."""
        from plotly.graph_objects import Figure as Interactive
        from plotly.graph_objects import Mesh3d, Scatter3d

        paper, ink = colour("paper", dark), colour("text", dark)
        clouds: list[Any] = []
        for faces in self.faces:
            (x, y, z), (i, j, k) = faces.places.T, faces.triangles.T
            look = {"color": colour(faces.role, dark), "opacity": SHADED, "flatshading": True, "hoverinfo": "skip"}
            clouds.append(Mesh3d(x=x, y=y, z=z, i=i, j=j, k=k, name=_escaped(faces.label), showlegend=True, **look))
        for number, section in enumerate(self.sections):
            x, y, z = section[[*range(len(section)), 0]].T
            entry = {"name": SECTIONS, "legendgroup": SECTIONS, "showlegend": not number}
            clouds.append(Scatter3d(x=x, y=y, z=z, mode="lines", line={"color": ink, "width": 5}, hoverinfo="skip", **entry))
        for points in self.points:
            x, y, z = points.places.T
            marker = {"size": SIZES[points.kind], "color": colour(points.role, dark), "line": {"width": 0}}
            marker["opacity"] = FAINT if points.kind == "mesh" else 1.0
            texts = list(map(_escaped, points.texts)) or None
            hover = {"text": texts, "hoverinfo": "text" if points.texts else "skip"}
            clouds.append(Scatter3d(x=x, y=y, z=z, mode="markers", name=_escaped(points.label), marker=marker, **hover))
        return Interactive([*clouds, *self._shafts(dark)]).update_layout(
            title={"text": _escaped(self.title)},
            paper_bgcolor=paper,
            font={"color": ink},
            scene=scene(self.sides, self.unit, paper),
            legend={"itemsizing": "constant"},
            margin={"l": 0, "r": 0, "t": 48, "b": 0},
        )

    def _shafts(self, dark: bool) -> Iterator[Any]:
        """Each group of arrows as lines with cones at their ends."""
        from plotly.graph_objects import Cone, Scatter3d

        length = self.arrow
        for arrows in self.arrows:
            shade, ends = colour(arrows.role, dark), arrows.feet + length * arrows.directions
            gap = np.full_like(ends, np.nan)
            lines = np.stack([arrows.feet, ends, gap], axis=1).reshape(-1, 3)
            texts = [text for text in map(_escaped, arrows.texts) for _ in range(3)]
            entry = {"name": _escaped(arrows.label), "legendgroup": _escaped(arrows.label)}
            x, y, z = lines.T
            yield Scatter3d(x=x, y=y, z=z, mode="lines", line={"color": shade, "width": 4}, text=texts, hoverinfo="text", **entry)
            x, y, z = ends.T
            u, v, w = 0.35 * length * arrows.directions.T
            yield Cone(
                x=x, y=y, z=z, u=u, v=v, w=w, sizemode="raw", anchor="tip", showscale=False, showlegend=False,
                colorscale=[[0.0, shade], [1.0, shade]], text=list(map(_escaped, arrows.texts)), hoverinfo="text", **entry,
            )  # fmt: skip


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;")


@FIGURES.of("Problem")
def model_view(problem: Problem, system: UnitSystem | None = None) -> ModelView:
    """The drawing of a problem whose nodes have coordinates, in SI or in a system of units."""
    structure = problem.structure
    if not structure.nodes:
        remedy = "Models that are read from files have them; give `nodes` to a Structure of your own."
        raise InputError(f"A drawing of the model needs the coordinates of its nodes, but none are known. {remedy}")
    factor, unit = in_system("m", system)
    points = tuple(replace(each, places=factor * each.places) for each in _points(problem))
    arrows = tuple(replace(each, feet=factor * each.feet) for each in (*_frames(problem), *_forces(problem, system)))
    faces = tuple(replace(each, places=factor * each.places) for each in _faces(problem))
    sections = tuple(factor * np.asarray(corners) for corners in structure.outlines.values())
    return ModelView(problem.heading, points, arrows, unit, faces, sections)


def _faces(problem: Problem) -> Iterator[Faces]:
    """The outer surfaces of blades, and of a sector with both neighbours, where the elements are known."""
    structure = problem.structure
    for number, surface in enumerate(structure.surfaces, start=1):
        label = "surface" if len(structure.surfaces) == 1 else f"surface {number}"
        yield Faces(label, "grey", surface.points, surface.triangles)
    points, triangles = _sector(problem)
    if triangles.size:
        yield Faces("sector", "grey", points, triangles)
        if isinstance(structure, CyclicStructure):
            for name, steps in NEIGHBOURS:
                yield Faces(name, "pale", structure.axis.turned(points, structure.sectors, steps), triangles)


def _sector(problem: Problem) -> tuple[Array, Index]:
    """Points (n, 3) and triangles (t, 3) of the outer surface of a sector from a file, or of a ready disk."""
    structure = problem.structure
    if isinstance(problem, TunedDisk) and problem.surface is not None:
        quads = problem.surface.quads
        return problem.surface.points, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return structure.mesh_points, structure.mesh_triangles


def _dots(problem: Problem) -> Array:
    """The points of the mesh that no surface shows, those of bodies without elements, (n, 3)."""
    structure = problem.structure
    dots = structure.mesh_points if not _sector(problem)[1].size else np.zeros((0, 3))
    for surface in structure.surfaces:
        low, high = surface.points.min(axis=0) - ROUNDING, surface.points.max(axis=0) + ROUNDING
        dots = dots[~np.all((low <= dots) & (dots <= high), axis=1)]
    return dots


def _points(problem: Problem) -> Iterator[Points]:
    """The mesh, of a disk with both neighbours, nodes, bodies and outputs."""
    structure = problem.structure
    mesh, dots = structure.mesh_points, _dots(problem)
    if dots.shape[0]:
        drawn = dots[:: -(-dots.shape[0] // MOST_POINTS)]
        yield Points("mesh", "grey", "mesh", drawn)
        if isinstance(structure, CyclicStructure):
            for name, steps in NEIGHBOURS:
                yield Points(name, "pale", "mesh", structure.axis.turned(drawn, structure.sectors, steps))
    bodies = _bodies(structure.dofs)
    for label, role, kind, names in (
        ("kept nodes" if mesh.shape[0] else "nodes", "grey", "node", [name for name in structure.nodes if name not in bodies]),
        ("mass centres of bodies", "ink", "body", [name for name in structure.nodes if name in bodies]),
    ):
        if names:
            yield Points(label, role, kind, np.array([structure.nodes[name] for name in names]), names)
    outputs = [
        (Output.of(output).name, arrow) for output in problem.outputs for arrow in _placed(structure, Output.of(output).direction)
    ]
    if outputs:
        yield Points("outputs", "failed", "output", np.array([foot for _, (foot, _) in outputs]), [name for name, _ in outputs])


def _frames(problem: Problem) -> Iterator[Arrows]:
    """The motion that closes each contact, and its first tangent; a colour for each surface, or for each contact."""
    groups: dict[str, list[tuple[str, str, Array, Array]]] = {}
    for each in problem.contacts:
        surface = each.surface.name if each.surface else each.name.rpartition(" ")[0] or each.name
        for name, (foot, along) in _contact_arrows(problem.structure, each).items():
            groups.setdefault(surface, []).append((f"{each.name}, {name}: {each.law}", name, foot, along))
    for number, (surface, arrows) in enumerate(groups.items()):
        for name, direction in (("n", "closing motion"), ("t1", "t1")):
            rows = [row for row in arrows if row[1] == name]
            if rows:
                feet, along = (np.array([row[k] for row in rows]) for k in (2, 3))
                role = f"contact {(number if name == 'n' else number + 4) % len(CONTACTS)}"
                yield Arrows(f"{surface}, {direction}", role, feet, along, [row[0] for row in rows])


def _contact_arrows(structure: Structure, contact: Contact) -> dict[str, tuple[Array, Array]]:
    """Place and direction of n and t1 of a contact: at its node, which of the side A moves by the whole direction, of B one of
    those between which it lies; else at the point of the rigid body.
    """
    named = dict(zip(contact.direction_names, contact.directions, strict=True))
    bodies = _bodies(dof for direction in contact.directions for dof in direction)
    arrows = {}
    for name in named.keys() & {"n", "t1"}:
        own = {dof: c for dof, c in named[name].items() if dof.rpartition(".")[0] not in bodies}
        placed = _placed(structure, own)
        if not placed:
            placed = _placed(structure, named[name])
            body = next((node for node in structure.nodes if node in bodies), None)
            if body is not None:
                # The point of the rigid body that moves by these directions, not its mass centre.
                point = np.asarray(structure.nodes[body] + arm_of(contact.directions, body))
                placed = [(point, along) for _, along in placed]
        if placed:
            arrows[name] = placed[0]
    return arrows


def _forces(problem: Problem, system: UnitSystem | None) -> Iterator[Arrows]:
    """Static and harmonic forces along their directions."""
    factor, unit = in_system("N", system)
    for label, role, static in (("static forces", "stick", True), ("exciting forces", "slip", False)):
        rows = []
        for force in problem.forces:
            size: complex = force.static if static else max(force.amplitudes.values(), key=abs, default=0.0)
            if not size or isinstance(force, BaseMotion):
                continue
            placed = _placed(problem.structure, force.coefficients)
            if isinstance(force, CentrifugalLoad):
                placed, size = placed * (len(placed) == 1), float(np.linalg.norm(force.resultant))  # of meshes it acts everywhere
            sign = -1.0 if (size.real or size.imag) < 0.0 else 1.0
            text = f"{force.name or force.direction}: {f'{abs(size):g}' if force.power else f'{factor * abs(size):g} {unit}'}"
            rows += [(foot, sign * along, text) for foot, along in placed]
        if rows:
            yield Arrows(
                label, role, np.array([row[0] for row in rows]), np.array([row[1] for row in rows]), [row[2] for row in rows]
            )


def _placed(structure: Structure, direction: Mapping[str, float]) -> list[tuple[Array, Array]]:
    """Place and unit direction of each node with coordinates that a direction moves."""
    moved: dict[str, NDArray[Any]] = {}
    for dof, coefficient in direction.items():
        node, _, axis = dof.rpartition(".")
        if node in structure.nodes and axis in AXES and coefficient:
            moved.setdefault(node, np.zeros(3))[AXES.index(axis)] += coefficient
    sizes = {node: float(np.linalg.norm(vector)) for node, vector in moved.items()}
    return [(np.array(structure.nodes[node]), moved[node] / sizes[node]) for node in moved if sizes[node]]


def _bodies(dofs: Iterable[str]) -> set[str]:
    """Nodes that can turn: the mass centres of rigid bodies."""
    return {dof.rpartition(".")[0] for dof in dofs if dof.rpartition(".")[2] in ("rx", "ry", "rz")}
