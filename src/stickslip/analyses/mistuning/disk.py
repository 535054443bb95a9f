"""Mistuned disks: the differences between sectors, and the full disk that they make of a tuned one."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import scipy
from numpy.typing import ArrayLike

from stickslip.analyses.performance.work import PRELOADS, with_factors
from stickslip.model.contact.point import Contact
from stickslip.model.disks.tuned import FullDisk, TunedDisk, blade_motion, loose_dofs, sectors_of
from stickslip.model.loads import Output
from stickslip.model.structure.cyclic import circulant, of_all_sectors, sector_name
from stickslip.model.structure.matrices import ModalDamping, Structure
from stickslip.support.checks import Array, InputError, fault, finite, nearest, several, vector

RELATIVE = ("blade", "kt", "kn", "mu", "pull")
"""What may deviate from sector to sector, in the order in which it is drawn."""
LAW_FIELDS = {"kt": ("kt", "kt2"), "kn": ("kn",), "mu": ("mu",), "pull": PRELOADS}
"""Fields of contact laws that a deviation scales."""


@dataclass(frozen=True, eq=False)
class Mistuning:
    """Relative deviations of N sectors from the tuned disk, each (N,) or one number for all; 0 is tuned.

    blade: of the frequency of each blade held where it joins the rest; kt, kn, mu: of all contacts of the damper that follows
    each blade; pull: of that damper's centrifugal force and of preloads in its laws. missing: sectors, from 1, whose damper is
    not there.
    """

    blade: ArrayLike = 0.0
    kt: ArrayLike = 0.0
    kn: ArrayLike = 0.0
    mu: ArrayLike = 0.0
    pull: ArrayLike = 0.0
    missing: Sequence[int] = ()

    def __post_init__(self) -> None:
        for name in RELATIVE:
            vector(f"Mistuning, {name}", getattr(self, name))
        object.__setattr__(self, "missing", tuple(several("Mistuning, missing", self.missing)))

    def of(self, sectors: int) -> "Mistuning":
        """The same as arrays of `sectors` entries; every deviation above −1."""
        for name in RELATIVE:
            if np.ndim(given := self.deviation(name)) and given.size != sectors:
                raise InputError(
                    f"Mistuning, {name} must hold one number for each of the {sectors} sectors, but holds {given.size}. "
                    "A number without brackets counts for all."
                )
        found = {name: vector(f"Mistuning, {name}", getattr(self, name), sectors) for name in RELATIVE}
        for name, deviation in found.items():
            if deviation.size and deviation.min() <= -1.0:
                raise fault(f"Mistuning, {name}", "must be above -1, relative to the tuned disk", float(deviation.min()))
        return Mistuning(**found, missing=tuple(sorted(sectors_of("Mistuning, missing", self.missing, sectors))))

    def on_top_of(self, base: "Mistuning") -> "Mistuning":
        """Both together, of arrays: factors multiply."""
        both = {name: (1.0 + base.deviation(name)) * (1.0 + self.deviation(name)) - 1.0 for name in RELATIVE}
        return Mistuning(**both, missing=tuple(sorted({*base.missing, *self.missing})))

    @property
    def names(self) -> list[str]:
        """What deviates, as of `RELATIVE`, and "missing"."""
        return [name for name in (*RELATIVE, "missing") if np.any(self.deviation(name))]

    def deviation(self, name: str) -> Array:
        """One of the deviations, by its name in `RELATIVE`."""
        return np.asarray(getattr(self, name), dtype=float)


def _random(sectors: int, seed: int, sample: int) -> tuple[Array, Array]:
    """Normal numbers (deviations, sectors), and numbers between 0 and 1 (sectors,)."""
    random = np.random.default_rng((seed, sample))
    return random.standard_normal((len(RELATIVE), sectors)), random.random(sectors)


def _sobol(sectors: int, seed: int, sample: int) -> tuple[Array, Array]:
    """The same from a point of a scrambled Sobol' sequence, whose numbers are multiples of 2⁻³⁰: the middles of these cells."""
    from scipy.stats import qmc  # takes half a second, which only those who draw shall wait for

    sequence = qmc.Sobol((len(RELATIVE) + 1) * sectors, seed=seed)
    if sample:
        sequence.fast_forward(sample)
    even = sequence.random()[0] + 0.5**31
    return scipy.special.ndtri(even[:-sectors]).reshape(len(RELATIVE), sectors), even[-sectors:]


SAMPLING = {"random": _random, "sobol": _sobol}
"""Ways to draw, by name."""


@dataclass(frozen=True)
class Scatter:
    """Random deviations: standard deviations of the blade frequency (normal) and of ln kt, ln kn, ln mu and ln pull (normal, so
    that none turns negative), independent from sector to sector; missing: probability that a damper is not there.

    sampling: "random", or "sobol", a scrambled Sobol' sequence (quasi-Monte Carlo): samples spread evenly, so that means of
    smooth results settle faster; best in powers of two.
    """

    blade: float = 0.0
    kt: float = 0.0
    kn: float = 0.0
    mu: float = 0.0
    pull: float = 0.0
    missing: float = 0.0
    sampling: Literal["random", "sobol"] = "random"

    def __post_init__(self) -> None:
        for name in (*RELATIVE, "missing"):
            value = finite(f"Scatter, {name}", getattr(self, name))
            if not 0.0 <= value < 1.0:
                raise fault(f"Scatter, {name}", "must lie between 0 and 1", value)
        if self.sampling not in SAMPLING:
            raise fault("Scatter, sampling", "must be a known one", self.sampling, nearest(str(self.sampling), SAMPLING))

    @property
    def names(self) -> list[str]:
        """What is drawn."""
        return [name for name in (*RELATIVE, "missing") if getattr(self, name)]

    def draw(self, sectors: int, seed: int, sample: int) -> Mistuning:
        """The deviations of one sample. They depend on the seed and its number alone, and one scatter does not move another."""
        normal, even = SAMPLING[self.sampling](sectors, seed, sample)
        lost = np.flatnonzero(even < self.missing) + 1
        blade, *others = normal
        logarithmic = {name: np.expm1(getattr(self, name) * row) for name, row in zip(RELATIVE[1:], others, strict=True)}
        return Mistuning(blade=self.blade * blade, **logarithmic, missing=tuple(lost.tolist()))


def mistuned_disk(
    disk: TunedDisk, mistuning: Mistuning, blade: Sequence[str] | None = None, whole: FullDisk | None = None
) -> FullDisk:
    """The whole disk with its sectors mistuned; without any deviation it is `disk.full()`, bit by bit.

    blade: nodes or degrees of freedom of a sector that make up its blade, those of the outputs and all modal coordinates unless
    given. With b the blades and r the rest, Ψ = −K_bb⁻¹K_br, S = diag(1 + blade): the elastic energy of the blades relative to
    what carries them is scaled, K + [I −Ψ]ᵀ(S K_bb S − K_bb)[I −Ψ]. A blade held at r has its frequencies times 1 + blade, and a
    motion that does not bend it meets no other stiffness than before. Masses stay those of the tuned disk, and so does the
    damping matrix; only where all modes have one damping ratio, the modes of the mistuned disk have it. whole: `disk.full()`
    where it is known, also on few coordinates (`few_waves`).
    """
    given = mistuning.of(disk.sectors)
    refuse_unmet(disk, given.names)
    full = disk.full() if whole is None else whole
    parts = len(disk.contacts), len(disk.forces), len(disk.mean_springs)
    contacts = deviating_contacts(full.contacts, given)
    pull = 1.0 + given.deviation("pull")
    forces = [replace(f, static=f.static * pull[k // parts[1]]) for k, f in enumerate(full.forces)]
    blades = _with_blades(disk, full.structure, given.deviation("blade"), blade)
    structure = _with_own_damping(disk, blades, given)
    if not given.missing:
        return replace(full, structure=structure, contacts=tuple(contacts), forces=tuple(forces))
    springs = [spring for k, spring in enumerate(full.mean_springs) if k // parts[2] + 1 not in given.missing]
    kept = [c for k, c in enumerate(contacts) if k // parts[0] + 1 not in given.missing]
    lost = {sector_name(sector, dof) for sector in given.missing for dof in loose_dofs(disk)}
    loads = [force for force in forces if not lost & force.coefficients.keys()]
    return replace(
        full, structure=_without(structure, lost), contacts=tuple(kept), forces=tuple(loads), mean_springs=tuple(springs)
    )


def refuse_unmet(disk: TunedDisk, names: Sequence[str]) -> None:
    """Refuse deviations, by their names in `RELATIVE` or "missing", of what the disk does not have."""
    for name in names:
        fields = LAW_FIELDS.get(name, ())
        met = any(np.any(getattr(contact.law, field, None)) for contact in disk.contacts for field in fields)
        if name == "pull" and not (met or np.any(disk.static_load)):
            raise InputError("Mistuning, pull must meet a static load or a preload, but the disk has none.")
        if name in ("kt", "kn", "mu") and not met:
            raise InputError(f"Mistuning, {name} must meet a contact law that has it, but none does.")
        if name == "missing" and not loose_dofs(disk):
            raise InputError("Mistuning, missing must meet dampers that only their contacts hold, but the sector has none such.")


def deviating_contacts(contacts: Sequence[Contact], given: Mistuning) -> list[Contact]:
    """The contacts of all sectors, one sector after the other, with the deviations of their laws."""
    found, each = [], len(contacts) // given.deviation("mu").size
    names = [(field, name) for name, fields in LAW_FIELDS.items() for field in fields]
    for k, contact in enumerate(contacts):
        factors = {field: 1.0 + given.deviation(name)[k // each] for field, name in names}
        found.append(with_factors(contact, {field: factor for field, factor in factors.items() if factor != 1.0}))
    return found


def _with_blades(disk: TunedDisk, structure: Structure, deviation: Array, blade: Sequence[str] | None) -> Structure:
    """The structure with the elastic energy of each blade scaled; [I −Ψ] and K_bb are those of each nodal diameter."""
    if not deviation.any():
        return structure
    own = blade_dofs(disk, blade)
    bent, K_bb = map(np.array, zip(*(blade_motion(disk, n, own) for n in range(disk.sectors // 2 + 1)), strict=True))
    relative = of_all_sectors(bent, disk.sectors)
    relative = relative if structure.shapes is None else relative @ structure.shapes
    S = 1.0 + np.repeat(deviation, len(own))
    K = structure.K + relative.T @ ((S[:, None] * S - 1.0) * circulant(K_bb, disk.sectors)) @ relative
    return replace(structure, K=0.5 * (K + K.T))


def _with_own_damping(disk: TunedDisk, structure: Structure, given: Mistuning) -> Structure:
    """One damping ratio of all modes is that of the mistuned disk's own modes; anything else stays the matrix of the tuned disk.

    The two differ by as much as the frequencies do, but the matrix would couple all modes of the mistuned disk: four times the
    states, and general complex eigenvectors to find them.
    """
    rule = disk.structure.damping
    if not ({*given.names} & {"blade", "kt", "kn", "missing"} and isinstance(rule, ModalDamping) and np.ndim(rule.ratio) == 0):
        return structure
    return structure.with_damping(rule)


def blade_dofs(disk: TunedDisk, blade: Sequence[str] | None = None) -> list[str]:
    """The degrees of freedom of a sector that make up its blade, by nodes or degrees of freedom, or as they are by default."""
    names = disk.structure.dofs
    if blade is None:
        outputs = {dof for output in disk.outputs for dof in Output.of(output).direction}
        blade = [*{dof.rsplit(".", 1)[0]: None for dof in names if dof in outputs or dof.startswith("mode/")}]
    nodes = {dof.rsplit(".", 1)[0] for dof in names}
    for name in several("blade", blade):
        if name not in nodes and name not in names:
            raise fault("blade", "must name nodes or degrees of freedom of a sector", name, nearest(name, [*nodes, *names]))
    found = [dof for dof in names if dof in blade or dof.rsplit(".", 1)[0] in blade]
    loose = set(found) & set(loose_dofs(disk))
    if loose or not found:
        raise fault("blade", "must name what stiffness holds", sorted(loose))
    return found


def _without(structure: Structure, lost: set[str]) -> Structure:
    """The structure without some degrees of freedom; on few coordinates dampers keep theirs, which go with them."""
    stays = np.array([dof not in lost for dof in structure.dofs])
    dofs, shapes, kept = tuple(dof for dof in structure.dofs if dof not in lost), structure.shapes, np.flatnonzero(stays)
    if shapes is not None:
        kept = np.flatnonzero(np.any(shapes[stays] != 0.0, axis=0))
        shapes = shapes[np.ix_(stays, kept)]
    M, K = (matrix[np.ix_(kept, kept)] for matrix in (structure.M, structure.K))
    C = None if structure.C is None else structure.C[np.ix_(kept, kept)]
    return replace(structure, M=M, K=K, C=C, dofs=dofs, shapes=shapes)
