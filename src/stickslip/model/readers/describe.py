"""Description of a model for `stickslip info`: size, mass, extent, first modes, rigid motions and warnings."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from stickslip.model.readers.deck import ALONG
from stickslip.model.readers.model import Model
from stickslip.model.structure.complete_modes import DENSE_SIZE, LowestModes, lowest_modes
from stickslip.model.structure.factor import Factor, Singular
from stickslip.model.structure.matrices import Sparse
from stickslip.model.structure.modes import rigid_motions
from stickslip.support.checks import SMALLEST, Array, counted

LIGHTEST, DENSEST = 20.0, 25e3
"""kg/m³ of the box round a body: a slender part in a wide box, osmium."""
SLOWEST, FASTEST = 0.05, 3e4
"""m/s, first elastic frequency times the length of the body: a thin whip, faster than sound in diamond."""
SMALLEST_FREQUENCY, LARGEST_FREQUENCY = 1e-3, 1e7
"""Hz; a node of a fine mesh alone may have a thousand times the largest."""


@dataclass(frozen=True, eq=False)
class Description:
    """mass: along x, y, z of unit translations, kg (nan without such directions); box: lengths along x, y, z, m, or none;
    modes: the lowest; odd: sentences on what to look at."""

    model: Model
    mass: Array
    box: Array | None
    modes: LowestModes | None
    odd: tuple[str, ...]

    def __str__(self) -> str:
        return "\n".join(lines(self))


def describe(model: Model, number: int = 10) -> Description:
    """Mass, extent and the lowest `number` modes of a model, and what is odd about it."""
    mass, box = translation_mass(model), extent(model)
    odd = list(model.notes)
    if box is not None and box.max() == 0.0:
        odd.append(f"All {len(model.nodes)} nodes lie at one point: coordinates are missing in the file, or cut off.")
    odd += [*_density(mass, box), *_spectrum(model), *_rows(model), *_viscous(model)]
    if indefinite_mass(model.M):
        odd.insert(0, "M has negative eigenvalues: check the sign and the export of the mass.")
        return Description(model, mass, box, None, tuple(odd))
    # Nodes without coordinates may be what seems to hold the body: the energy of the modes then decides what is rigid.
    rigid = rigid_motions(model.K, model.dofs, model.nodes)
    by_coordinates = rigid.shape[1] or all(node in model.nodes for node in model.directions)
    if model.turned:  # a deck gives axes to six digits: what K resists by less may be free
        by_coordinates = rigid.shape[1] == rigid_motions(model.K, model.dofs, model.nodes, ALONG).shape[1]
    modes = lowest_modes(model.M, model.K, number, rigid if by_coordinates else None)
    odd += _odd_modes(box, modes)
    return Description(model, mass, box, modes, tuple(odd))


def translation_mass(model: Model) -> Array:
    """rᵀMr of unit translations along x, y, z, kg, (3,); nodes that the file leaves out, as fixed ones, do not count.

    Nodes with negative numbers are internal ones of Abaqus, and those without a place beside others that have one the
    incompatible modes of CalculiX: they move relative to the others.
    """
    masses = []
    internal = {node for node in model.directions if node.startswith("-") or (model.nodes and node not in model.nodes)}
    for axis in "xyz":
        pairs = (name.rpartition(".") for name in model.dofs)
        r = np.array([float(direction == axis and node not in internal) for node, _, direction in pairs])
        masses.append(float(r @ (model.M @ r)) if r.any() else np.nan)
    return np.array(masses)


def extent(model: Model) -> Array | None:
    """The lengths of the box round all nodes along x, y, z, m, (3,)."""
    if len(model.nodes) < 2:
        return None
    return np.asarray(np.ptp(np.array(list(model.nodes.values())), axis=0))


def indefinite_mass(M: Sparse) -> bool:
    """Whether M has a negative eigenvalue."""
    scale = float(np.abs(M.diagonal()).max(initial=0.0))
    if np.any(M.diagonal() < -1e-12 * scale):
        return True
    if M.shape[0] <= DENSE_SIZE:
        return float(np.linalg.eigvalsh(M.toarray())[0]) < -1e-9 * scale * M.shape[0]
    heavy = np.flatnonzero(M.diagonal() > 1e-12 * scale)
    raised = M[heavy][:, heavy] + sparse.diags_array(1e-9 * M.diagonal()[heavy])  # so that rounding of zeros does not count
    try:
        return Factor(sparse.csc_array(raised)).negative > 0
    except Singular:
        return False


def implausible(model: Model) -> tuple[str, ...]:
    """What reading a model warns of: a density or a stiffness that no body has."""
    return tuple(_density(translation_mass(model), extent(model))) + tuple(_spectrum(model))


def _odd_modes(box: Array | None, modes: LowestModes | None) -> Iterator[str]:
    """A stiffness that has no modes, or negative ones, or one that no body of this extent has."""
    if modes is None:
        yield "K could not be factorised: rows without stiffness, or an export cut short."
        return
    if modes.negative:
        yield f"K has {counted(modes.negative, 'motion')} of negative stiffness: check its sign, or a prestress beyond buckling."
    elastic = modes.frequencies[modes.rigid :]
    if box is not None and box.max() > 0.0 and elastic.size and not SLOWEST <= elastic[0] * box.max() <= FASTEST:
        yield f"The first elastic mode at {elastic[0]:.4g} Hz of a body of {box.max():.4g} m is implausible: check the units."


def _rows(model: Model) -> Iterator[str]:
    """Rows without entries or mass, and nodes without coordinates where others have them."""
    stiff, heavy = (matrix.diagonal() != 0.0 for matrix in (model.K, model.M))
    if not np.all(stiff | heavy):
        yield f"{_some(model, ~(stiff | heavy))} neither mass nor stiffness: left out of the export, or fixed?"
    if np.any(stiff & ~heavy):
        yield f"{_some(model, stiff & ~heavy)} no mass: they follow the others, and give no mode."
    placed = (node for node, axes in model.directions.items() if not node.startswith("-") and not axes[0].startswith("q"))
    missing = [node for node in placed if node not in model.nodes]
    if model.nodes and missing:
        yield (
            f"{counted(len(missing), 'node')} without coordinates, {missing[0]} first: inner rows of elements, as the three "
            "of each C3D8I, or nodes that the file of coordinates lacks. Places are not looked for there."
        )


def _some(model: Model, chosen: Array) -> str:
    rows = np.flatnonzero(chosen)
    return f"{counted(rows.size, 'row')}, {model.dofs[rows[0]]} first, with"


def _viscous(model: Model) -> Iterator[str]:
    """A viscous damper takes energy out, and between two motions it acts both ways alike."""
    if model.C is None:
        return
    skew = model.C - model.C.T
    if skew.nnz and np.abs(skew.data).max() > 1e-8 * np.abs(model.C.data).max():
        yield "C is not symmetric: gyroscopic or circulatory terms, or an export cut short."
    if indefinite_mass(sparse.csc_array(0.5 * (model.C + model.C.T))):
        yield "C feeds energy in (its symmetric part has negative eigenvalues): check its sign."


def _density(mass: Array, box: Array | None) -> Iterator[str]:
    heaviest = float(np.nanmax(mass)) if not np.all(np.isnan(mass)) else 0.0
    if box is None or box.min() <= 0.0 or heaviest <= 0.0:
        return
    density = heaviest / float(np.prod(box))
    if not LIGHTEST <= density <= DENSEST:
        yield (
            f"{heaviest:.4g} kg in a box of {' x '.join(f'{length:.4g}' for length in box)} m is {density:.3g} kg/m³: "
            "implausible, check the units of the file."
        )


def _spectrum(model: Model) -> Iterator[str]:
    """√(K_ii/M_ii) bounds the frequencies of single nodes: far outside of what bodies have, the units are wrong."""
    mass, stiffness = model.M.diagonal(), model.K.diagonal()
    both = (mass > SMALLEST) & (stiffness > 0.0)
    if not both.any():
        return
    highest = float(np.sqrt(np.max(stiffness[both] / mass[both]))) / (2.0 * np.pi)
    if not SMALLEST_FREQUENCY <= highest <= 1e3 * LARGEST_FREQUENCY:
        yield f"The stiffest node has {highest:.3g} Hz on its own: the stiffness is implausible, check the units of the file."


def lines(description: Description) -> Iterator[str]:
    """The description as text."""
    model = description.model
    yield f"format            {model.format}"
    damping = "" if model.C is None else f", C {model.C.nnz}"
    yield f"rows              {model.size} (M {model.M.nnz}, K {model.K.nnz}{damping} entries)"
    yield f"nodes             {len(model.directions)}, {len(model.located[0])} with coordinates; rows {', '.join(model.dofs[:4])}"
    for name, nodes in model.sets.items():
        yield f"set               {name}: {counted(len(nodes), 'node')}"
    if description.box is not None:
        yield f"box               {' x '.join(f'{length:.6g}' for length in description.box)} m"
    if not np.all(np.isnan(description.mass)):
        masses = {axis: value for axis, value in zip("xyz", description.mass, strict=True) if not np.isnan(value)}
        label = f"mass along {' '.join(masses)}"
        yield f"{label:18s}{', '.join(f'{value:.6g}' for value in masses.values())} kg (without fixed nodes)"
    # M and K are made exactly symmetric as they are read.
    symmetric_damping = model.C is not None and not np.any((model.C - model.C.T).data)
    yield f"symmetric         {'M, K and C' if symmetric_damping else 'M and K'}"
    if description.modes is not None:
        definite = "positive semidefinite (rigid motions)" if description.modes.rigid else "positive definite"
        if description.modes.negative:
            definite = f"{counted(description.modes.negative, 'motion')} of negative stiffness"
        yield f"rigid motions     {description.modes.rigid}"
        yield f"K                 {definite}"
        yield f"first modes       {', '.join(f'{value:.7g}' for value in description.modes.frequencies)} Hz"
        yield f"modes             {description.modes.count}"
    for sentence in description.odd:
        yield f"note              {sentence}"
