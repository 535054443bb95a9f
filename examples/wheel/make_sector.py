"""Writes sector.inp, the CalculiX deck of one of 18 sectors of a bladed disk, in mm, t, s and N. Then run `ccx sector`.

The mesh is a grid in radius, angle and length without the cells outside disk, shank, platform and blade. The first step computes
the prestress at speed with the cyclic tie, the second writes K and M with both faces free.
"""

from itertools import pairwise
from pathlib import Path

import numpy as np

SECTORS, SPEED = 18, 9000.0  # rev/min
RADII = np.array([50.0, 72.0, 95.0, 114.0, 124.0, 134.0, 165.0, 200.0])
WIDTHS = np.array([-1.0, -0.92, -0.3, -0.12, 0.12, 0.3, 0.92, 1.0])  # relative to half a pitch
LENGTHS = np.array([-11.0, 0.0, 11.0])  # along the axis z
RIM, UNDERSIDE, TOP, FOOT = 95.0, 114.0, 124.0, 134.0
SHANK, PLATFORM, BLADE = 0.3, 0.92, 0.12
SLOPE = np.radians(28.0)  # of the undersides of the platform
HALF = np.pi / SECTORS

CORNERS = np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]])
EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
PLACES = np.vstack([CORNERS, [(CORNERS[i] + CORNERS[k]) // 2 for i, k in EDGES]])


def allowed(radius):
    """Half width of the part at a radius, relative to half a pitch."""
    return [1.0, SHANK, PLATFORM, BLADE][np.searchsorted([RIM, UNDERSIDE, TOP], radius)]


def point(radius, width, z):
    """Coordinates of a place of the grid: undersides rise to the gap, and the foot of the blade is twice as wide."""
    if radius == UNDERSIDE:
        radius += np.tan(SLOPE) * UNDERSIDE * HALF * max(abs(width) - SHANK, 0.0)
    if abs(width) <= BLADE and TOP <= radius < FOOT:
        width *= 1.0 + (FOOT - radius) / (FOOT - TOP)
    return radius * np.cos(width * HALF), radius * np.sin(width * HALF), z


def mesh():
    """Places of the grid and coordinates by node number, and the 20 nodes of each element; edges are straight."""
    numbers, points, elements = {}, {}, []
    for r in pairwise(RADII):
        for w in pairwise(WIDTHS):
            if max(map(abs, w)) <= allowed(np.mean(r)) + 1e-9:
                for z in pairwise(LENGTHS):
                    at = [
                        tuple(float(np.mean(s) + 0.5 * d * (s[1] - s[0])) for s, d in zip((r, w, z), p, strict=True))
                        for p in PLACES
                    ]
                    own = [numbers.setdefault(tuple(np.round(place, 9)), len(numbers) + 1) for place in at]
                    corners = [np.array(point(*place)) for place in at[:8]]
                    points |= dict(zip(own, [*corners, *((corners[i] + corners[k]) / 2 for i, k in EDGES)], strict=True))
                    elements.append(own)
    return {node: place for place, node in numbers.items()}, points, elements


def lines(numbers):
    return "".join(f"{node},\n" for node in numbers)


nodes, points, elements = mesh()
sets = {
    "BORE": [n for n, (r, w, z) in nodes.items() if r == RADII[0]],
    "LOW": [n for n, (r, w, z) in nodes.items() if w == -1.0],
    "HIGH": [n for n, (r, w, z) in nodes.items() if w == 1.0],
    "PLATFORM_LEFT": [n for n, (r, w, z) in nodes.items() if r == UNDERSIDE and w <= -SHANK],
    "PLATFORM_RIGHT": [n for n, (r, w, z) in nodes.items() if r == UNDERSIDE and w >= SHANK],
    "TIP": [n for n, place in nodes.items() if place == (RADII[-1], -BLADE, 0.0)],
    "FILLET": [n for n, (r, w, z) in nodes.items() if r == FOOT and abs(w) == BLADE and z in LENGTHS],
}
sets["HELD"] = sorted(set(sets["BORE"]) - set(sets["LOW"]))  # ccx refuses supports on the dependent face of the tie
high = [e for e, own in enumerate(elements, 1) if {own[i] for i in (2, 3, 6, 7)} <= set(sets["HIGH"])]

deck = ["*NODE, NSET=ALL\n", *(f"{n},{x:.9f},{y:.9f},{z:.9f}\n" for n, (x, y, z) in points.items())]
deck.append("*ELEMENT, TYPE=C3D20R, ELSET=ALL\n")
for number, own in enumerate(elements, 1):
    deck.append(f"{number}," + ",".join(map(str, own[:15])) + ",\n" + ",".join(map(str, own[15:])) + "\n")
for name, members in sets.items():
    deck.append(f"*NSET, NSET={name}\n{lines(members)}")
deck.append(f"""*SURFACE, NAME=DEPENDENT, TYPE=NODE
LOW
*SURFACE, NAME=INDEPENDENT, TYPE=ELEMENT
{"".join(f"{e},S5" + chr(10) for e in high)}*MATERIAL, NAME=STEEL
*ELASTIC
206000.,0.3
*DENSITY
7.8E-9
*SOLID SECTION, ELSET=ALL, MATERIAL=STEEL
*BOUNDARY
HELD,1,3
*TIE, CYCLIC SYMMETRY, NAME=CYCLIC, POSITION TOLERANCE=0.1
DEPENDENT,INDEPENDENT
*CYCLIC SYMMETRY MODEL, N={SECTORS}, NGRAPH=1, TIE=CYCLIC
0.,0.,0.,0.,0.,1.
*STEP, NLGEOM
*STATIC
*DLOAD
ALL,CENTRIF,{(2.0 * np.pi * SPEED / 60.0) ** 2:.10g},0.,0.,0.,0.,0.,1.
*NODE FILE
U
*EL FILE
S
*END STEP
*STEP, PERTURBATION
*FREQUENCY, SOLVER=MATRIXSTORAGE, CYCMPC=INACTIVE
8
*END STEP
""")
Path("sector.inp").write_text("".join(deck))
print(f"{len(nodes)} nodes, {len(elements)} elements;", ", ".join(f"{name} {len(members)}" for name, members in sets.items()))
