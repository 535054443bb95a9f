"""The problem: structure, contacts, loads and outputs, checked once. Immutable; `with_...` returns a changed copy."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.contact.point import Contact, Start, contact_table, stuck_stiffness
from stickslip.model.loads import BaseMotion, Force, Output
from stickslip.model.problem.speed import SpeedDependence, inertia_along
from stickslip.model.problem.systems import HarmonicSystems, loose_motions, truncated
from stickslip.model.problem.warnings import warnings_of
from stickslip.model.structure.assembly import Spring
from stickslip.model.structure.matrices import AerodynamicDamping, Damping, Dashpot, ModalDamping, RayleighDamping, Structure
from stickslip.model.structure.modes import Modes, natural_modes
from stickslip.model.structure.stuck_mesh import Coordinates, StuckMesh
from stickslip.support.checks import SMALLEST, Array, InputError, counted, fault, is_definite, of_kind, several, storable, unique
from stickslip.support.renderers import FIGURES

HELD_ALONE = 1e-10
"""Share of the stiffness at a contact that others have, below which it is rounding: the contact alone holds what it joins."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """What a problem on few coordinates of a finite-element model is made from: the structure with stuck contacts, the degrees of
    freedom whose motion it knows, the contact forces (rows, k) whose shapes it has, and its coordinates. solved: whether forces
    of solutions are among these."""

    stuck: StuckMesh
    named: tuple[str, ...]
    forces: Array
    coordinates: Coordinates
    solved: bool = False


@dataclass(frozen=True, eq=False, repr=False)
class Problem:
    """M q̈ + C q̇ + K q + Bᵀ f(B q) = p(t).

    structure: M, C, K with names; contacts: laws with directions, whose rows make up B; forces: loads;
    outputs: names of degrees of freedom, or `Output`s. mean_springs: springs that act on the mean (harmonic 0) alone, for
    motions that only friction restrains: once the contacts slip, their mean could be anything. dashpots: viscous dampers, and gas
    forces that feed the motion (`AerodynamicDamping`). speed: how stiffness and constant loads go with the rotor speed, which an
    engine order excites along; the frequency of the excitation then stands for the speed. modes_to: natural frequency [Hz] up to
    which the structure has the modes of the stuck structure, where it is on few coordinates (`truncated`). mesh: what these
    were made from, where no contact row of a finite-element model was kept (`meshed_problem`).
    """

    structure: Structure
    contacts: tuple[Contact, ...]
    forces: tuple[Force, ...]
    outputs: tuple[str | Output, ...]
    title: str = ""
    mean_springs: tuple[Spring, ...] = ()
    dashpots: tuple[Dashpot | AerodynamicDamping, ...] = field(default=(), kw_only=True)
    speed: SpeedDependence | None = field(default=None, kw_only=True)
    modes_to: float | None = field(default=None, kw_only=True)
    mesh: Mesh | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        for key in ("contacts", "forces", "outputs", "mean_springs", "dashpots"):
            object.__setattr__(self, key, several(key, getattr(self, key)))
        of_kind("structure", self.structure, Structure)
        for what, values, kind in (("A contact", self.contacts, Contact), ("A force", self.forces, Force)):
            for value in values:
                of_kind(what, value, kind)
        unique("Names of contacts", [contact.name for contact in self.contacts])
        unique("Names of outputs", self.output_names)
        storable("The title", self.title)
        if not self.outputs:
            raise fault("outputs", "must name at least one degree of freedom", "none")
        if not any(amplitude for force in self.forces for amplitude in force.amplitudes.values()):
            raise fault("forces", "must contain a harmonic force", "none", "Give a force a non-zero amplitude.")
        if self.structure.coriolis is not None and (self.speed or any(isinstance(force, BaseMotion) for force in self.forces)):
            raise InputError("Coriolis forces hold for one speed only and cannot be combined with `speed` or a moving base.")
        if self.speed is not None:
            of_kind("speed", self.speed, SpeedDependence)
            self.speed.check(self.structure.whole_stiffness.shape)
        # Every degree of freedom that a contact, a load or an output names must exist; resolving the rows raises otherwise.
        _ = (self.B, self.output_rows, [self.structure.row(force.coefficients) for force in self.forces], self.mean_stiffness)
        _ = self.static_powers
        self.structure.rows([dashpot.direction for dashpot in self.dashpots])
        self._check_held()

    def __repr__(self) -> str:
        sizes = (
            counted(self.structure.size, "degree of freedom", "degrees of freedom"),
            f"{counted(len(self.contacts), 'contact')} ({counted(len(self.B), 'row')})",
            counted(len(self.forces), "force"),
            f"outputs {', '.join(self.output_names[:4])}{', ...' if len(self.outputs) > 4 else ''}",
        )
        return f"{type(self).__name__} {self.title!r}: {', '.join(sizes)}"

    @property
    def freedoms(self) -> int:
        """How many degrees of freedom its structure has, of a mesh all of them."""
        return self.structure.size if self.mesh is None else self.mesh.stuck.structure.size

    @property
    def heading(self) -> str:
        """The title of results: the title, of a tuned disk with its engine orders."""
        return self.title

    def plot(self) -> Any:
        """A drawing of the model in space, a matplotlib figure: mesh, nodes, bodies, frames of the contacts, forces, outputs."""
        return self._view().plot()

    def to_plotly(self, *, dark: bool = False) -> Any:
        """The same as an interactive plotly figure that can be turned: `.show()` or `.write_html(path)`."""
        return self._view().to_plotly(dark)

    def _view(self) -> Any:
        return FIGURES.known("Problem")[""](self)

    def _check_held(self) -> None:
        """Refuse a structure that its contacts, all stuck, do not hold, or that they hide."""
        # The largest eigenvalue is at most the largest sum of sizes in a row.
        bound = float(np.abs(self.stuck_stiffness).sum(axis=1).max(initial=0.0))
        if is_definite(self.stuck_stiffness, -1e-13 * bound):
            return
        eigenvalues, vectors = linalg.eigh(self.stuck_stiffness)
        low, high = float(eigenvalues[0]), float(eigenvalues[-1])
        scale = max(abs(low), high, SMALLEST)
        if low < 1e-13 * scale:
            self._refuse_hiding_contacts()
            dof = self.structure.dofs[int(np.argmax(np.abs(vectors[:, 0])))]
            what = "held by nothing" if abs(low) < 1e-9 * scale else "of negative stiffness"
            everywhere = high <= -1e-9 * scale
            remedy = "Add a support or a contact with stiffness, or check the signs in K and the speed of its spin softening."
            if any(contact.nodes for contact in self.contacts):
                remedy = f"More points of a surface hold rotations that few do not. {remedy}"
            raise InputError(
                "The structure with all contacts stuck must have a positive definite stiffness, but a motion led by "
                f"{dof!r} is {what} (eigenvalues from {low:.3g} to {high:.3g} N/m). "
                + ("Turn the sign of K." if everywhere else remedy)
            )

    def _refuse_hiding_contacts(self) -> None:
        """Refuse contacts so stiff that rounding hides a structure which softer ones hold as well."""
        largest = float(np.max(np.abs(self.structure.K), initial=0.0))
        softened = np.minimum(self.contact_stiffness, 1e3 * largest)
        values = linalg.eigvalsh(self.structure.K + self.B.T @ (softened[:, None] * self.B))
        if values[0] < 1e-13 * max(abs(values[0]), values[-1], SMALLEST):
            return
        raise fault(
            "Contacts",
            "must not be so stiff that rounding hides the structure",
            f"{self.contact_stiffness.max():.3g} N/m against {largest:.3g} N/m at most in K",
            "Lower kt and kn: stuck contacts 1e4 times as stiff as the parts let these move 1e-4 as far as without them.",
        )

    @cached_property
    def stiffness_ratios(self) -> Array:
        """How many times stiffer each contact row is than all that it joins, kc g / (1 − kc' g) with g = b K⁻¹ bᴴ, (rows,).

        In K contacts count with kc' = min(kc, largest |K| of the structure): two rigid ones side by side do not pass for soft.
        Where those do not hold the structure, whose own K then has a negative eigenvalue, they count with kc.
        Infinite where nothing but the contact holds what it joins.
        """
        _, _, stuck, B, _ = self.systems.at(1)
        largest = float(np.max(np.abs(self.structure.K), initial=0.0))
        softened = np.minimum(self.contact_stiffness, largest or np.inf)
        K = stuck - B.conj().T @ ((self.contact_stiffness - softened)[:, None] * B)
        try:
            factor = linalg.cho_factor(K)
        except linalg.LinAlgError:
            softened, factor = self.contact_stiffness, linalg.cho_factor(stuck)
        compliance = np.einsum("ij,ji->i", B, linalg.cho_solve(factor, B.conj().T)).real
        share = 1.0 - softened * compliance
        ratios = np.full(share.size, np.inf)
        np.divide(self.contact_stiffness * compliance, share, out=ratios, where=share > HELD_ALONE)
        return ratios

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about a problem that can be computed, but is hardly what was meant, or may defeat Newton's method."""
        if self.speed is None:
            return warnings_of(self)
        return warnings_of(self.at_frequency(self.first_omega_at_rest))

    @cached_property
    def B(self) -> Array:
        """Relative contact displacements w = B q, rows (contact, direction), (rows, n)."""
        return self.structure.rows([d for contact in self.contacts for d in contact.directions])

    @cached_property
    def output_rows(self) -> Array:
        """Outputs as rows over the degrees of freedom, (outputs, n)."""
        return self.structure.rows([Output.of(output).direction for output in self.outputs])

    @property
    def output_names(self) -> tuple[str, ...]:
        return tuple(Output.of(output).name for output in self.outputs)

    @cached_property
    def contact_stiffness(self) -> Array:
        """K_c of each row: kt and kn of every element closed, N/m, (rows,)."""
        return stuck_stiffness(self.contacts)

    @cached_property
    def stuck_stiffness(self) -> Array:
        """K + BᵀK_cB, (n, n)."""
        return np.asarray(self.structure.K + self.B.T @ (self.contact_stiffness[:, None] * self.B))

    @cached_property
    def C(self) -> Array:
        """The matrix of all forces that go with the velocity, of damping rule, dashpots and rotation, (n, n)."""
        rows = self.structure.rows([dashpot.direction for dashpot in self.dashpots])
        sizes = np.array([dashpot.c for dashpot in self.dashpots])
        coriolis = 0.0 if self.structure.coriolis is None else self.structure.coriolis
        return np.asarray(self.structural_damping + coriolis + rows.T @ (sizes[:, None] * rows))

    @property
    def damped(self) -> bool:
        """Whether a force that goes with the velocity takes or gives energy."""
        return bool(np.any(self.C + self.C.conj().T))

    @cached_property
    def structural_damping(self) -> Array:
        """The damping matrix of the structure without dashpots and Coriolis forces, (n, n)."""
        structure = self.structure
        if structure.C is not None:
            return structure.C
        match structure.damping:
            case None:
                return np.zeros_like(structure.M)
            case RayleighDamping(mass_factor=a, stiffness_factor=b):
                return np.asarray(a * structure.M + b * structure.K)
            case ModalDamping() as rule:
                modes = self.systems.stuck_modes if rule.on == "stuck" else natural_modes(structure.M, structure.K)
                return modal_damping_matrix(structure.M, modes, rule)

    @cached_property
    def mean_stiffness(self) -> Array:
        """What the mean springs add to K at harmonic 0, (n, n)."""
        rows = self.structure.rows([spring.direction for spring in self.mean_springs])
        return np.asarray(rows.T @ (np.array([spring.stiffness for spring in self.mean_springs])[:, None] * rows))

    @cached_property
    def known_few(self) -> dict[float, Problem]:
        """What `on_few_coordinates` made of the problem, by the frequency of truncation."""
        return {}

    @cached_property
    def loose_motions(self) -> Array:
        """Motions that only friction restrains, (motions, n), orthonormal."""
        return loose_motions(self)

    @cached_property
    def systems(self) -> HarmonicSystems:
        """The linear structures that the harmonics of the motion see, with all contacts stuck."""
        return HarmonicSystems(self)

    @cached_property
    def fingerprint(self) -> str:
        """Sixteen hexadecimal digits that identify matrices, contacts, loads and outputs bit by bit."""
        structure, digest = self.structure, sha256()
        damping = np.zeros(0) if structure.C is None else structure.C
        coriolis = np.zeros(0) if structure.coriolis is None else structure.coriolis
        for array in (structure.M, structure.K, damping, coriolis, self.B, self.output_rows, *contact_table(self.contacts)):
            digest.update(np.ascontiguousarray(array).tobytes())
        rest = (structure.damping, self.forces, [contact.balanced for contact in self.contacts], self.mean_springs, self.dashpots)
        digest.update(repr(rest).encode())
        if self.speed is not None:
            digest.update(repr((self.speed.engine_order, self.speed.loads)).encode())
            digest.update(b"" if self.speed.stiffness is None else np.ascontiguousarray(self.speed.stiffness).tobytes())
        return digest.hexdigest()[:16]

    def load(self, harmonics: int, level: float = 1.0, omega: float | None = None) -> Array:
        """Loads in real storage (n, 2H+1): static (with the counter-force of balanced contacts), then a_h, b_h.

        omega [rad/s] must be given where `load_powers` or `static_powers` go beyond ω⁰.
        """
        powers = self.load_powers(harmonics)
        if omega is None and max(len(powers), len(self.static_powers)) > 1:
            raise fault("omega", "must be given, since a load goes by the frequency", omega)
        load = level * np.einsum("k,knh->nh", (omega or 0.0) ** np.arange(len(powers)), powers)
        load[:, 0] = (omega or 0.0) ** np.arange(len(self.static_powers)) @ self.static_powers
        return np.asarray(load)

    @cached_property
    def static_load(self) -> Array:
        """The constant loads, with the counter-force of balanced contacts, (n,)."""
        load = np.zeros(self.structure.size)
        for force in self.forces:
            load += force.static * self._row_of_load(force)
        for contact in self.contacts:
            normal = contact.elements.normal
            if contact.balanced and contact.normal is not None and normal is not None:
                load += float(normal.forces(0.0).sum()) * self.structure.row(contact.normal)
        return load

    @cached_property
    def static_powers(self) -> Array:
        """The constant loads as a polynomial in ω, Σ_k ω^k powers[k], (powers, n): of `speed` those of Ω² = (ω/EO)²."""
        if self.speed is None or not self.speed.loads:
            return self.static_load[None]
        rate = sum(load.static * self.structure.row(load.coefficients) for load in self.speed.loads)
        return np.array([self.static_load, np.zeros(self.structure.size), rate / self.speed.engine_order**2])

    def at_speed(self, speed: float) -> Problem:
        """The problem at one rotor speed, rad/s, without `speed`: that of a point at ω = EO Ω."""
        if self.speed is None:
            raise InputError("The problem must have `speed` to be asked for that at one speed.")
        loads = tuple(replace(load, static=speed**2 * load.static) for load in self.speed.loads)
        structure = self._stiffened(speed**2 * self.speed.stiffness) if self.speed.stiffness is not None else self.structure
        return replace(self, structure=structure, forces=(*self.forces, *loads), speed=None)

    @property
    def first_omega_at_rest(self) -> float:
        """Of the stuck structure at rest, rad/s: a frequency at which loads that go with the speed have their usual size."""
        at_rest = (self if self.speed is None else self.at_speed(0.0)).frequencies(stuck=True)
        moving = at_rest[at_rest > 0.0]
        return 2.0 * np.pi * float(moving[0]) if moving.size else 0.0

    def at_frequency(self, omega: float) -> Problem:
        """The problem that a point at a frequency of the excitation, rad/s, is of: `at_speed`, or itself without `speed`."""
        return self if self.speed is None else self.at_speed(self.speed.at(omega))

    def _stiffened(self, added: NDArray[Any]) -> Structure:
        """The structure with a part added to K; its damping is that of the structure without it."""
        return replace(self.structure, K=self.structure.K + added, C=self.structural_damping, damping=None)

    def load_powers(self, harmonics: int) -> Array:
        """Harmonic loads at force level one as a polynomial in ω, Σ_k ω^k powers[k]: (powers, n, 2H+1) in real storage."""
        highest = max((force.power for force in self.forces), default=0)
        powers = np.zeros((highest + 1, self.structure.size, 2 * harmonics + 1))
        for force in self.forces:
            row = self._row_of_load(force)
            for harmonic, factor in force.factors.items():
                if harmonic > harmonics:
                    raise fault("harmonics", f"must reach the load's harmonic {harmonic}", harmonics)
                powers[force.power, :, 2 * harmonic - 1] += factor.real * row
                powers[force.power, :, 2 * harmonic] -= factor.imag * row
        return powers

    def _row_of_load(self, force: Force) -> Array:
        """The load per unit amplitude, (n,): the direction of a force, −M r of a moving base."""
        row = self.structure.row(force.coefficients)
        return -inertia_along(self.structure, row) if isinstance(force, BaseMotion) else row

    def frequencies(self, stuck: bool) -> Array:
        """Natural frequencies in Hz, ascending: of the stuck structure, or of the free one (contacts absent).

        Of a tuned disk those of every nodal diameter that its engine orders excite.
        """
        return self.systems.frequencies(stuck)

    def with_structure(self, structure: Structure) -> Problem:
        """A copy with another structure."""
        return replace(self, structure=structure)

    def with_contacts(self, change: Callable[[Contact], Contact]) -> Problem:
        """A copy with every contact changed: `problem.with_contacts(lambda c: c.with_law(law))`."""
        return replace(self, contacts=tuple(change(contact) for contact in self.contacts))

    @property
    def at_nodes(self) -> Problem:
        """The problem with a contact at each node of its patches (`surface_contacts`), or itself where it has none."""
        if not any(contact.nodes for contact in self.contacts):
            return self
        return replace(self, contacts=tuple(each for contact in self.contacts for each in contact.at_nodes))

    def with_start(self, start: Start) -> Problem:
        """A copy with one start rule at every contact."""
        return self.with_contacts(lambda contact: contact.with_start(start))

    def with_forces(self, forces: Sequence[Force]) -> Problem:
        """A copy with other loads."""
        return replace(self, forces=tuple(forces))

    def truncated(self, modes_to: float) -> Problem:
        """The problem on few coordinates: the modes of the stuck structure up to a natural frequency [Hz], and of those above the
        shapes that contacts, loads and outputs feel. All contacts stay.

        `forced_response` does so by itself where contacts are many. Source: R. H. MacNeal, Comput. Struct. 1 (1971) 581-601, for
        residual flexibility; the choice of the shapes is ours (`model/problem/systems.py`).
        """
        return truncated(self, modes_to)

    def with_damping(self, damping: Damping | Array | None) -> Problem:
        """A copy with another damping."""
        return self.with_structure(self.structure.with_damping(damping))


def modal_damping_matrix(M: Array, modes: Modes, rule: ModalDamping) -> Array:
    """C = Σ 2 ζ_r ω_r (M φ_r)(M φ_r)ᵀ over modes, φᵀMφ = 1; rigid and massless motions stay undamped."""
    ratios = np.zeros(modes.squares.size)
    given = np.atleast_1d(np.asarray(rule.ratio, dtype=float))
    if given.size > ratios.size:
        raise fault("damping ratio", f"must have at most {ratios.size} entries, the number of modes", given.size)
    ratios[: given.size] = given
    if np.ndim(rule.ratio) == 0:
        ratios[:] = given[0]
    weighted = M @ modes.shapes
    return np.asarray((weighted * (2.0 * ratios * np.sqrt(np.maximum(modes.squares, 0.0)))) @ weighted.conj().T)
