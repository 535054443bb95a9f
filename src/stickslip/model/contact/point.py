"""A contact: a law between two places, with directions as coefficients of named degrees of freedom.

w = frame (q_A − q_B), and f is the force with which A pushes on B along (t1, t2, n): A feels −f, B feels +f, so the
structure's equation is M q̈ + C q̇ + K q + Bᵀ f(B q) = p. n is positive when closing. `ground` is the fixed side.

>>> between("11.x", "ground")
{'11.x': 1.0}

Start states of friction contacts, the explicit input behind non-unique friction forces.

The traction at the last sample is `clip(tau, LO, HI)`, with [LO, HI] the interval of the period map (see
`stickslip.model.contact.protocol`). The three rules say what tau is. A value is a number for all friction elements of a
direction, or a sequence with one number per element.

All contacts of a problem as flat arrays for the compiled kernels.

Rows of w, f and λ are (contact, direction) in the order t1, t2, n of each contact.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.model.contact.law import Elements, Law
from stickslip.model.contact.march import prepare
from stickslip.model.contact.protocol import ContactData, kind_of
from stickslip.support.checks import Array, Index, fault, finite, several, square, storable, vector
from stickslip.support.kernels import inner


@dataclass(frozen=True)
class Start:
    """A rule by which the friction elements of a contact start."""

    value: float | Sequence[float] = 0.0
    code: ClassVar[int]
    key: ClassVar[str]

    def values(self, size: int) -> Array:
        """The value of each of `size` friction elements."""
        return vector(self.key, np.asarray(self.value), size)


@dataclass(frozen=True)
class SliderOffset(Start):
    """tau = kt (u_last − s): the slider rests at `value` = s, in m. s = 0 is the virgin contact."""

    code = 0
    key = "slider_offset"


@dataclass(frozen=True)
class TractionRatio(Start):
    """tau = m μN_last, `value` = m in [−1, 1]. Depends on the phase origin of the force.

    Equation 9 of "An Experimental and Computational Comparison of the Dynamic Response Variability in a Turbine Blade with
    Under-Platform Dampers".
    """

    code = 1
    key = "traction_ratio"

    def values(self, size: int) -> Array:
        """m of each of `size` friction elements."""
        ratios = super().values(size)
        if np.any(np.abs(ratios) > 1.0):
            raise fault("traction_ratio", "must lie in [-1, 1]", ratios.tolist(), "It is T/(mu N).")
        return ratios


@dataclass(frozen=True)
class MeanTraction(Start):
    """tau = T̄ − kt (ū − u_last): the mean traction over the period is `value` = T̄, in N."""

    code = 2
    key = "mean_traction"


STARTS: tuple[type[Start], ...] = (SliderOffset, TractionRatio, MeanTraction)


Direction = Mapping[str, float]
"""A displacement as coefficients of degrees of freedom, {"NODE.DIRECTION": coefficient}."""

Motion = Callable[[Sequence[float]], Direction]
"""A place that can move: gives the displacement along a direction (x, y, z) as coefficients."""

GROUND = "ground"
DIRECTION_NAMES = ("t1", "t2", "n")


def ground(direction: Sequence[float]) -> Direction:
    """The fixed side: no degree of freedom."""
    return {}


def node(name: str) -> Motion:
    """The node `name` of a structure with degrees of freedom name.x, name.y, name.z."""

    def motion(direction: Sequence[float]) -> Direction:
        return {f"{name}.{axis}": float(c) for axis, c in zip("xyz", direction, strict=False) if c != 0.0}

    return motion


def mean(motions: Sequence[Motion], shares: Sequence[float] | Array) -> Motion:
    """The mean motion of several places, each with its share: Σ share_k u_k. A force on it acts on each with its share."""

    def motion(direction: Sequence[float]) -> Direction:
        total: dict[str, float] = {}
        for place, share in zip(motions, shares, strict=True):
            for dof, coefficient in place(direction).items():
                total[dof] = total.get(dof, 0.0) + share * coefficient
        return total

    return motion


def difference(a: Direction, b: Direction) -> dict[str, float]:
    """The coefficients of a − b."""
    total = dict(a)
    for dof, coefficient in b.items():
        total[dof] = total.get(dof, 0.0) - coefficient
    return total


def between(a: str, b: str) -> dict[str, float]:
    """The displacement of degree of freedom `a` relative to `b`; one of them may be "ground"."""
    for name in (a, b):
        if not isinstance(name, str):
            raise fault(
                "A place of a pair", 'must be a name, say "1.x"', name, "A dictionary of coefficients is a direction itself."
            )
    if a == b:
        raise fault("A pair [A, B]", "must join two different places", [a, b])
    sides = [{} if dof == GROUND else {dof: 1.0} for dof in (a, b)]
    return difference(sides[0], sides[1])


class OnSurface(NamedTuple):
    """The part that a contact has in a contact surface: the name of the surface; the share of its law; how much larger the gap is
    than that of this law [m]; the places of its nodes (k, 3) [m], none where they are not known."""

    name: str
    share: float = 1.0
    further: float = 0.0
    places: Array = np.zeros((0, 3))


@dataclass(frozen=True)
class PatchNode:
    """A node of a patch of a contact surface, for which the contact of the patch stands.

    name, tangential, normal: of the contact that it has where each node has its own; share: of the patch, by area; further: how
    much larger its gap is than that of the patch [m]; surface: the part of that contact in the whole.
    """

    name: str
    share: float
    tangential: tuple[Direction, ...]
    normal: Direction | None
    further: float = 0.0
    surface: OnSurface | None = field(default=None, compare=False)


@dataclass(frozen=True)
class Contact:
    """One contact point: law, directions, start state.

    tangential: no, one or two directions t1, t2; normal: the closing direction, if the law has a varying normal load.
    start: one rule for all directions, or one per tangential direction.
    balanced: z is counted from the preloaded equilibrium: the structure feels N − N0 (else the whole N).
    nodes: of a patch of a surface, those whose mean motion it has (`surface_contacts`); area: of the surface that it stands for,
    m², 0 where it is not known; surface: its part in one, None of a contact by itself.
    """

    name: str
    law: Law
    tangential: tuple[Direction, ...] = ()
    normal: Direction | None = None
    start: Start | tuple[Start, ...] = field(default_factory=SliderOffset)
    balanced: bool = False
    nodes: tuple[PatchNode, ...] = field(default=(), repr=False)
    area: float = field(default=0.0, repr=False, compare=False)
    surface: OnSurface | None = field(default=None, repr=False, compare=False)

    def __post_init__(self) -> None:
        storable("The name of a contact", self.name)
        if not isinstance(self.law, Law):
            raise fault(f"Contact {self.name!r}, law", "must be a Law", self.law)
        for start in self.start if isinstance(self.start, tuple) else (self.start,):
            if not isinstance(start, SliderOffset | TractionRatio | MeanTraction):
                raise fault(f"Contact {self.name!r}, start", "must be a SliderOffset, TractionRatio or MeanTraction", start)
        several(f"Contact {self.name!r}, tangential", self.tangential)
        if len(self.tangential) > 2:
            raise fault(f"Contact {self.name!r}", "must have at most two tangential directions", len(self.tangential))
        if not self.tangential and self.normal is None:
            raise fault(f"Contact {self.name!r}", "must have a direction", "none")
        for direction in self.directions:
            if not isinstance(direction, Mapping):
                raise fault(f"Contact {self.name!r}, a direction", "must be coefficients, as `between` gives them", direction)
            for dof, coefficient in direction.items():
                finite(f"Contact {self.name!r}, coefficient of {dof}", coefficient)
            if not any(direction.values()):
                raise fault(f"Contact {self.name!r}", "must join two different places", "a direction without coefficients")
        if isinstance(self.start, tuple) and len(self.start) != len(self.tangential):
            raise fault(
                f"Contact {self.name!r}, start",
                "must be one rule, or one per tangential direction",
                f"{len(self.start)} rules for {len(self.tangential)} directions",
            )
        if self.balanced and self.normal is None:
            raise fault(f"Contact {self.name!r}, balanced", "must go with a normal direction", "none")
        _ = self.start_values  # which refuses wrong ones
        if self.law.couples_directions:
            self._check_disc_start()

    @property
    def has_no_start(self) -> bool:
        """Whether the law has friction that no start state changes."""
        return not self.law.remembers_start and any(group.stiffness.size for group in self.elements.friction)

    def _check_disc_start(self) -> None:
        """A disc starts from a slider position or a ratio inside the disc; a mean traction is not defined for it."""
        keys = {start.key for start in self.starts}
        if len(keys) > 1 or "mean_traction" in keys:
            raise fault(
                f"Contact {self.name!r}, start of a friction disc",
                "must be a slider offset or a traction ratio, of the same kind in both directions",
                sorted(keys),
            )
        size = float(np.hypot(*(start.values(1)[0] for start in self.starts)))
        if keys == {"traction_ratio"} and size > 1.0:
            raise fault(f"Contact {self.name!r}, traction ratio on the friction disc", "must have a size of at most 1", size)

    @property
    def directions(self) -> tuple[Direction, ...]:
        """All directions in the order t1, t2, n."""
        return (*self.tangential, *(() if self.normal is None else (self.normal,)))

    @property
    def direction_names(self) -> tuple[str, ...]:
        """Names of `directions`: some of t1, t2, n."""
        return (*DIRECTION_NAMES[: len(self.tangential)], *(() if self.normal is None else ("n",)))

    @cached_property
    def elements(self) -> Elements:
        """The law's table of springs and sliders for these directions."""
        return self.law.elements(len(self.tangential), self.normal is not None)

    @property
    def starts(self) -> tuple[Start, ...]:
        """The start rule of each tangential direction."""
        return self.start if isinstance(self.start, tuple) else (self.start,) * len(self.tangential)

    @cached_property
    def start_values(self) -> tuple[Array, ...]:
        """The value of the start rule for each friction element of each tangential direction."""
        pairs = zip(self.starts, self.elements.friction, strict=True)
        return tuple(start.values(group.stiffness.size) for start, group in pairs)

    @property
    def at_nodes(self) -> "tuple[Contact, ...]":
        """The contacts of the nodes of a patch, which share its law and mean traction by area; of any other contact itself."""
        contacts = []
        for each in self.nodes:
            law: Any = self.law.share(each.share)
            if each.further:
                law = replace(law, gap=law.gap + each.further)
            starts = tuple(
                replace(start, value=np.multiply(each.share, start.value).tolist()) if isinstance(start, MeanTraction) else start
                for start in self.starts
            )
            parts: dict[str, Any] = {"area": each.share * self.area, "surface": each.surface}
            contacts.append(Contact(each.name, law, each.tangential, each.normal, starts, self.balanced, **parts))
        return tuple(contacts) or (self,)

    def with_start(self, start: Start | tuple[Start, ...]) -> "Contact":
        """A copy with another start state."""
        return replace(self, start=start)

    def with_law(self, law: Law) -> "Contact":
        """A copy with another law."""
        return replace(self, law=law)


def contact_in_space(
    name: str, law: Law, a: Motion, b: Motion, frame: ArrayLike, start: Start | tuple[Start, ...] | None = None
) -> Contact:
    """A contact of place `a` against place `b` with frame rows (t1, t2, n), an orthonormal (3, 3) array."""
    axes = square(f"Contact {name}, frame", frame, 3)
    if float(np.max(np.abs(axes @ axes.T - np.eye(3)))) > 1e-9:
        raise fault(f"Contact {name}, frame", "must have orthonormal rows t1, t2, n", axes.tolist())
    t1, t2, n = (difference(a(axis), b(axis)) for axis in axes)
    tangential = (t1, t2) if law.has_friction else ()
    return Contact(name, law, tangential, n if law.has_normal else None, start or SliderOffset())


class ContactTable(NamedTuple):
    """Flat arrays over contacts, rows, normal elements and friction elements.

    first_row (contacts + 1): rows of contact c are first_row[c] .. first_row[c + 1] − 1.
    normal_row (contacts): the row of the normal direction, −1 without one.
    normal_first (contacts + 1), normal_stiffness, normal_constant: N_e = max(stiffness z + constant, 0).
    friction_first (rows + 1): friction elements of each row (none for a normal row); stiffness kt, friction μ,
    constant_limit; load_first, load_last: the normal elements that load it; start_kind, start_value: the start state.
    bend_first (elements + 1): the bends of each limit, at bend [N] of the limit without them, with the change of slope.
    kind (contacts): the number of its law's kernels (`protocol.py`); parameter_first (contacts + 1), parameter:
    their own numbers.
    loading_row (rows): the row of the normal load of a tangential row, partner_row (rows): the other tangential row where the law
    couples both; −1 without one.
    """

    first_row: Index
    normal_row: Index
    normal_first: Index
    normal_stiffness: Array
    normal_constant: Array
    friction_first: Index
    stiffness: Array
    friction: Array
    constant_limit: Array
    load_first: Index
    load_last: Index
    bend_first: Index
    bend: Array
    change: Array
    start_kind: Index
    start_value: Array
    kind: Index
    parameter_first: Index
    parameter: Array
    loading_row: Index
    partner_row: Index

    @property
    def rows(self) -> int:
        return int(self.first_row[-1])


@inner
def bent(table: ContactTable, e: int, line: float) -> tuple[float, float]:
    """L = ℓ + Σ change max(ℓ − bend, 0) of friction element e for ℓ = μ Σ N + L0, and dL/dℓ; bends ascend."""
    limit, slope = line, 1.0
    for k in range(table.bend_first[e], table.bend_first[e + 1]):
        beyond = line - table.bend[k]
        if beyond <= 0.0:
            break
        limit += table.change[k] * beyond
        slope += table.change[k]
    return limit, slope


@inner
def contact_data(table: ContactTable, c: int) -> ContactData:
    """Contact c of a table whose law has kernels of its own."""
    first, last = table.first_row[c], table.first_row[c + 1]
    if table.normal_row[c] >= 0:
        last -= 1
    kt, value, kind = np.zeros(last - first), np.zeros(last - first), np.zeros(last - first, dtype=np.int64)
    a, b = table.friction_first[first], table.friction_first[last]
    spring, direction = table.stiffness[a:b].copy(), np.zeros(b - a, dtype=np.int64)
    for r in range(first, last):
        for e in range(table.friction_first[r], table.friction_first[r + 1]):
            direction[e - a] = r - first
            kt[r - first] += table.stiffness[e]
            if e == table.friction_first[r]:
                kind[r - first], value[r - first] = table.start_kind[e], table.start_value[e]
    parameter = table.parameter[table.parameter_first[c] : table.parameter_first[c + 1]]
    return ContactData(table.kind[c], parameter, kt, kind, value, spring, direction)


def remembering(contacts: Sequence[Contact]) -> NDArray[np.bool_]:
    """Friction elements whose law remembers its start state, (elements,)."""
    sizes = [sum(group.stiffness.size for group in contact.elements.friction) for contact in contacts]
    return np.repeat(np.array([contact.law.remembers_start for contact in contacts], dtype=bool), sizes)


def stuck_stiffness(contacts: Sequence[Contact]) -> Array:
    """K_c of each row of contacts: kt and kn of every element closed, N/m, (rows,)."""
    rows: list[float] = []
    for contact in contacts:
        elements = contact.elements
        rows += [float(friction.stiffness.sum()) for friction in elements.friction]
        rows += [] if elements.normal is None else [float(elements.normal.stiffness.sum())]
    return np.array(rows)


def contact_table(contacts: Sequence[Contact]) -> ContactTable:
    """The table of a sequence of contacts; the kernels of their laws are ready with it."""
    prepare(*{type(contact.law) for contact in contacts})
    first_row, normal_row, normal_first, friction_first = [0], [], [0], [0]
    normal: list[tuple[float, float]] = []
    friction: list[tuple[float, float, float, int, int, int, float]] = []
    bends: list[tuple[float, float]] = []
    bend_first: list[int] = [0]
    parameter_first: list[int] = [0]
    parameter: list[float] = []
    loading_row: list[int] = []
    partner_row: list[int] = []
    for contact in contacts:
        elements = contact.elements
        base = len(normal)
        if elements.normal is not None:
            normal += zip(elements.normal.stiffness, elements.normal.constant, strict=True)
        for group, start, values in zip(elements.friction, contact.starts, contact.start_values, strict=True):
            for e in range(group.stiffness.size):
                loads = (base + int(group.first[e]), base + int(group.last[e]))
                parameters = (group.stiffness[e], group.friction[e], group.constant_limit[e])
                friction.append((*parameters, *loads, start.code, values[e]))
                bends += zip(group.bend[:, e], group.change[:, e], strict=True) if group.bend.size else ()
                bend_first.append(len(bends))
            friction_first.append(len(friction))
        row, both = first_row[-1], contact.law.couples_directions
        normal_row.append(row + len(elements.friction) if elements.normal is not None else -1)
        if elements.normal is not None:
            friction_first.append(len(friction))
        first_row.append(first_row[-1] + len(contact.directions))
        alone = [-1] * (elements.normal is not None)
        loading_row += [normal_row[-1]] * len(elements.friction) + alone
        partner_row += ([row + 1, row] if both else [-1] * len(elements.friction)) + alone
        parameter += elements.parameters
        parameter_first.append(len(parameter))
        normal_first.append(len(normal))
    springs = np.array(normal, dtype=float).reshape(len(normal), 2)
    bent_at = np.array(bends, dtype=float).reshape(len(bends), 2)
    sliders = np.array(friction, dtype=float).reshape(len(friction), 7)

    def integers(values: object) -> Index:
        return np.ascontiguousarray(values, dtype=np.int64)

    def floats(values: Array) -> Array:
        return np.ascontiguousarray(values, dtype=float)

    return ContactTable(
        first_row=integers(first_row),
        normal_row=integers(normal_row),
        normal_first=integers(normal_first),
        normal_stiffness=floats(springs[:, 0]),
        normal_constant=floats(springs[:, 1]),
        friction_first=integers(friction_first),
        stiffness=floats(sliders[:, 0]),
        friction=floats(sliders[:, 1]),
        constant_limit=floats(sliders[:, 2]),
        load_first=integers(sliders[:, 3]),
        load_last=integers(sliders[:, 4]),
        bend_first=integers(bend_first),
        bend=floats(bent_at[:, 0]),
        change=floats(bent_at[:, 1]),
        start_kind=integers(sliders[:, 5]),
        start_value=floats(sliders[:, 6]),
        kind=integers([kind_of(type(contact.law)) for contact in contacts]),
        parameter_first=integers(parameter_first),
        parameter=floats(np.array(parameter)),
        loading_row=integers(loading_row),
        partner_row=integers(partner_row),
    )
