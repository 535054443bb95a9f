"""Interface of contact laws. Most are a table of parallel springs and sliders, and their author only fills the table.

Normal elements:      N_e = max(k_e z + c_e, 0), summed to the normal force N of the contact.
Friction elements:    Jenkins, a spring kt in series with a slider of limit L = μ (sum of some N_e) + L0, which may bend
                      with the load (below).
One compiled kernel (`friction_period` of `protocol.py`) carries every such law round a period, with its derivatives. A law that
is no such table brings its own step (also there) and says what it has not in common with sliders.

A coefficient of friction that depends on the normal load: numbers that a law turns into bends of its slip limit.

The slip limit μ(N)N is straight between the loads of a table. Its bends lie at these loads, so that kernels evaluate it and its
derivative exactly, and a law with a constant coefficient has none.

Laws under one normal load, constant or following the motion of a normal direction: its parameters, checks and table.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import MISSING, dataclass, field, fields, replace
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.support.checks import Array, Index, fault, finite, not_negative, positive, vector

DECADES = 2.0
"""A power law is tabulated over so many decades of the load below and above the one at which its coefficient is given."""

A_DECADE = 10
"""Loads of a power law a decade: the slip limit is then exact to 0.2 % for every exponent from −1 to 0."""


ROUNDING = 1e-12
"""Relative fall of the slip limit that is none: a constant one, from a table or a power of exponent −1."""


@dataclass(frozen=True)
class LoadDependentFriction:
    """A coefficient of friction μ(N), from a table: values μ_k at normal loads N_k [N] of the whole contact, ascending.

    The slip limit L(N) = μ(N) N is straight between its values μ_k N_k, so that μ = L/N lies between μ_k and μ_k+1, and
    dL/dN = (μ_k+1 N_k+1 − μ_k N_k)/(N_k+1 − N_k). Below the first and above the last load μ is constant. L may not fall as N
    grows. A contact that stands for a share of a surface has the coefficient of its share of the loads.

    In place of `mu` of a law: Macroslip(kt=2e7, mu=LoadDependentFriction((10.0, 100.0), (0.6, 0.4)), kn=3e7). For a coefficient
    that a law gives as it likes, tabulate it: LoadDependentFriction(loads, [f(N) for N in loads]).
    """

    over: Sequence[float]
    values: Sequence[float]

    __array_ufunc__ = None
    """A NumPy number times it is left to `__rmul__`."""

    def __post_init__(self) -> None:
        loads, values = vector("mu, over", self.over), vector("mu, values", self.values)
        if loads.size < 2:
            raise fault("mu, over", "must be at least two loads", loads.tolist(), "A constant coefficient is a number.")
        if loads.size != values.size:
            raise fault("mu, values", f"must be one for each of the {loads.size} loads in `over`", values.size)
        for load in loads:
            positive("mu, a load in over", load)
        for value in values:
            positive("mu, one of the values", value)
        if np.any(np.diff(loads) <= 0.0):
            raise fault("mu, over", "must ascend", loads.tolist())
        limits = loads * values
        if np.any(fallen := np.diff(limits) < -ROUNDING * limits[:-1]):
            k = int(np.argmax(fallen))
            raise fault(
                "mu",
                "must not fall faster than 1/N, for the friction force mu N would fall as the load grows",
                f"{values[k]:g} at {loads[k]:g} N and {values[k + 1]:g} at {loads[k + 1]:g} N",
                f"At least {limits[k] / loads[k + 1]:.4g} is possible there.",
            )
        object.__setattr__(self, "over", tuple(map(float, loads)))
        object.__setattr__(self, "values", tuple(map(float, values)))

    @classmethod
    def power(cls, value: float, at: float, exponent: float, over: Sequence[float] | None = None) -> "LoadDependentFriction":
        """μ = value (N/at)^exponent, tabulated; exponent −1/3 for a sphere of which the contact area alone decides.

        value: of the coefficient at the normal load `at` [N]; exponent: from −1, a constant friction force, to 1; over: the loads
        (low, high) [N] between which it holds, from at/100 to 100 at unless given. Beyond them the coefficient is constant.
        """
        positive("mu, value", value)
        positive("mu, at", at)
        if not -1.0 <= finite("mu, exponent", exponent) <= 1.0 or exponent == 0.0:
            raise fault("mu, exponent", "must lie between -1 and 1 and not be 0", exponent, "A constant coefficient is a number.")
        low, high = (at * 10.0**-DECADES, at * 10.0**DECADES) if over is None else map(float, vector("mu, over", over, 2))
        if not 0.0 < low < high:
            raise fault("mu, over", "must be two positive loads, the lower one first", [low, high])
        loads = np.geomspace(low, high, 1 + max(1, round(A_DECADE * float(np.log10(high / low)))))
        return cls(tuple(loads), tuple(value * (loads / at) ** exponent))

    def __mul__(self, factor: float) -> "LoadDependentFriction":
        """The same with every coefficient times a factor."""
        return LoadDependentFriction(self.over, tuple(factor * value for value in self.values))

    __rmul__ = __mul__

    def share(self, fraction: float) -> "LoadDependentFriction":
        """That of a contact which carries this fraction of the load."""
        return LoadDependentFriction(tuple(fraction * load for load in self.over), self.values)

    def limit(self, load: ArrayLike) -> Array:
        """Slip limit L(N) = μ(N) N at normal loads [N], N."""
        N, (first, loads, changes) = np.asarray(load, dtype=float), _line(self)
        beyond = np.maximum(N[..., None] - loads, 0.0)
        return np.asarray(first * (np.maximum(N, 0.0) + beyond @ changes))

    def coefficient(self, load: ArrayLike) -> Array:
        """μ(N) = L(N)/N at normal loads [N]."""
        N = np.maximum(np.asarray(load, dtype=float), self.over[0])
        return np.asarray(self.limit(N) / N)


class Line(NamedTuple):
    """A slip limit L = slope (N + Σ change_k max(N − load_k, 0)): slope [-], loads [N] and changes [-] (k,)."""

    slope: float
    loads: Array
    changes: Array


def _line(friction: LoadDependentFriction) -> Line:
    """Slopes μ_1 up to the first load, between the loads by the limits there, μ_n from the last on; bends where they differ."""
    loads, values = np.asarray(friction.over), np.asarray(friction.values)
    slopes = np.concatenate([values[:1], np.diff(values * loads) / np.diff(loads), values[-1:]])
    return Line(float(values[0]), loads, np.diff(slopes) / values[0])


Friction = float | LoadDependentFriction
"""What `mu` of a law may be."""


def checked_friction(mu: Friction, name: str = "mu") -> None:
    """Refuse what is no coefficient of friction."""
    if not isinstance(mu, LoadDependentFriction):
        not_negative(name, mu)


def line_of(mu: Friction) -> Line:
    """The slip limit of a coefficient over the normal load."""
    return _line(mu) if isinstance(mu, LoadDependentFriction) else Line(float(mu), np.zeros(0), np.zeros(0))


def limit_at(mu: Friction, load: float) -> float:
    """μ(N) N of a coefficient at a normal load [N]."""
    return float(mu.limit(load)) if isinstance(mu, LoadDependentFriction) else mu * load


def share_of(mu: Friction, fraction: float) -> Friction:
    """The coefficient of a contact that carries a fraction of the load."""
    return mu.share(fraction) if isinstance(mu, LoadDependentFriction) else mu


def largest_friction(mu: Friction) -> float:
    """The largest coefficient at any load."""
    return max(mu.values) if isinstance(mu, LoadDependentFriction) else float(mu)


@dataclass(frozen=True)
class NormalElements:
    """N_e = max(stiffness_e z + constant_e, 0): arrays (e,), N/m and N. constant = N0 − kn δ."""

    stiffness: Array
    constant: Array

    def forces(self, z: float) -> Array:
        """N_e at normal displacement z, N."""
        return np.maximum(self.stiffness * z + self.constant, 0.0)


@dataclass(frozen=True)
class FrictionElements:
    """Jenkins elements of one direction: arrays (e,).

    stiffness [N/m]; friction μ; constant_limit L0 [N]; first, last: the normal elements first..last−1 whose load the limit
    follows, L = ℓ + Σ_k change_k max(ℓ − bend_k, 0) with ℓ = μ Σ N_e + L0.
    bend [N], change [-], (k, e): where the limit bends, of a coefficient that depends on the load; none of a constant one.
    """

    stiffness: Array
    friction: Array
    constant_limit: Array
    first: Index
    last: Index
    bend: Array = field(default_factory=lambda: np.zeros((0, 1)))
    change: Array = field(default_factory=lambda: np.zeros((0, 1)))

    def line(self, normal_forces: Array) -> Array:
        """ℓ of each element for given normal element forces, N."""
        sums = np.concatenate([[0.0], np.cumsum(normal_forces)])
        shared = sums[self.last] - sums[self.first]
        return np.asarray(self.friction * shared + self.constant_limit)

    def passed(self, normal_forces: Array) -> NDArray[np.bool_]:
        """Which bends lie below the limit for given normal element forces, (k, e)."""
        return np.asarray(self.line(normal_forces) > self.bend)

    def limits(self, normal_forces: Array, passed: NDArray[np.bool_] | None = None) -> Array:
        """L of each element for given normal element forces, N; with the bends that are `passed` in place of those that are, it
        is linear in the forces."""
        line = self.line(normal_forces)
        beyond = self.change * (line - self.bend)
        return np.asarray(line + np.where(self.passed(normal_forces) if passed is None else passed, beyond, 0.0).sum(axis=0))

    def bounds(self) -> list[tuple[Array, Array]]:
        """Lines that no limit exceeds, L ≤ slope ℓ + constant, (e,) each: those of the least concave curve above it."""
        lines = [_concave(*ends) for ends in zip(self.constant_limit, self.bend.T, self.change.T, strict=False)]
        if not self.bend.size:
            return [(np.ones(self.stiffness.size), np.zeros(self.stiffness.size))]
        count = max(map(len, lines))
        padded = np.array([[*each, *[each[-1]] * (count - len(each))] for each in lines])
        return [(padded[:, k, 0], padded[:, k, 1]) for k in range(count)]


def _concave(start: float, bend: Array, change: Array) -> list[tuple[float, float]]:
    """Slope and constant of each line of the least concave curve over the limit of one element from ℓ = start on."""
    at = np.append(start, bend)
    limit = at + (change * np.maximum(at[:, None] - bend, 0.0)).sum(axis=1)
    last, lines, k = 1.0 + float(change.sum()), [], 0
    while True:
        slopes = (limit[k + 1 :] - limit[k]) / (at[k + 1 :] - at[k])
        steepest = max(float(slopes.max(initial=last)), last)
        lines.append((steepest, float(limit[k] - steepest * at[k])))
        if steepest <= last:
            return lines
        k += 1 + int(np.flatnonzero(slopes >= steepest)[-1])


@dataclass(frozen=True)
class Elements:
    """The whole table of a contact: one set of friction elements per tangential direction, and the normal elements.

    parameters: the numbers that the law's own kernels read; none for a table of sliders. Elements without stiffness are places
    for further states of such a law.
    """

    friction: tuple[FrictionElements, ...]
    normal: NormalElements | None
    parameters: tuple[float, ...] = ()


SLIDERS = 0
"""Kind of a contact whose law is a table of springs and sliders."""


class Law(ABC):
    """A contact law. A member gives its table for a contact with so many tangential directions and a normal or none.

    extensive: parameters that are shared out where one law stands for a whole surface; the others are the same at each point.
    couples_directions: the force along one tangential direction depends on the motion along the other.
    rate_independent: forces depend on the path of the motion, not on how fast it is passed.
    sticks: a motion small enough is that of the stuck spring kt, and its loop holds no energy.
    remembers_start: where it sticks, the steady force depends on the start state.
    rubs: it dissipates energy; a gap and a cubic spring do not.
    incrementally_passive: of a law with kernels of its own, whether under a constant load the difference of two motions gains no
    energy from it, ∫ ΔT Δu̇ dt ≥ V(end) − V(begin) with V ≥ 0; of a table of sliders the table says so (`problem/contraction.py`).
    """

    extensive: ClassVar[tuple[str, ...]] = ("kt", "kn", "preload", "normal_load")
    couples_directions: ClassVar[bool] = False
    rate_independent: ClassVar[bool] = True
    sticks: ClassVar[bool] = True
    remembers_start: ClassVar[bool] = True
    rubs: ClassVar[bool] = True
    incrementally_passive: ClassVar[bool] = False

    def share(self, fraction: float) -> Self:
        """The law of a point that carries this fraction of the surface: stiffnesses and loads times it, all else as it is."""
        whole = {name: getattr(self, name) for name in self.extensive if hasattr(self, name)}
        changed = {
            name: tuple(fraction * each for each in value) if np.ndim(value) else fraction * value
            for name, value in whole.items()
            if value is not None
        }
        if hasattr(self, "mu"):
            changed["mu"] = share_of(self.mu, fraction)
        return replace(self, **changed)  # type: ignore[type-var]

    @classmethod
    def kernels(cls) -> tuple[Callable[..., Any], ...]:
        """The law's own kernels, `step` or `step, period` of its file (`stickslip.model.contact.protocol`); none of sliders."""
        return ()

    @abstractmethod
    def elements(self, tangential: int, normal: bool) -> Elements:
        """The table of springs and sliders; refuses a number of directions that the law does not suit."""

    @property
    def has_friction(self) -> bool:
        """Whether the law acts along tangential directions."""
        return True

    def parameter_scales(self, force: float, width: float) -> Array:
        """What a whole change of each of the law's `Elements.parameters` is, for forces [N] and motions [m] of a size."""
        return np.zeros(0)

    def passage(self, velocity: float) -> float:
        """Share of a period in which the velocity alone takes the force from one limit to the other, for a harmonic motion of a
        velocity amplitude [m/s]; infinite where the force follows the path of the motion."""
        return float("inf")

    def loop_energy(self, amplitude: float, z: float = 0.0) -> float:
        """Energy per cycle of u = A cos ωt at constant z, one direction: Σ 4 L (A − L/kt) over the elements with A > L/kt, J."""
        table, forces = self._at(z)
        limits = table.limits(forces)
        return float(np.sum(4.0 * limits * np.maximum(amplitude - limits / table.stiffness, 0.0)))

    def virgin_curve(self, u: float, z: float = 0.0) -> float:
        """Traction on first loading at constant z, one direction: T(u) = Σ min(kt_e u, L_e), N."""
        table, forces = self._at(z)
        return float(np.sign(u) * np.sum(np.minimum(table.stiffness * abs(u), table.limits(forces))))

    def _at(self, z: float) -> tuple[FrictionElements, Array]:
        varying = self.has_normal
        elements = self.elements(1, varying)
        if not elements.friction:
            raise fault(type(self).__name__, "must have a tangential direction here", "a law without friction")
        return elements.friction[0], elements.normal.forces(z) if elements.normal is not None else np.zeros(0)

    @property
    def has_normal(self) -> bool:
        """Whether the law needs a normal direction (a varying normal load): where it has a normal stiffness kn."""
        return getattr(self, "kn", None) is not None


@dataclass(frozen=True)
class Own:
    """A number that a law has of its own: what it is in a study file, its unit, and its range; `least` may be reached, `above`
    and `below` may not."""

    description: str
    unit: str = "-"
    least: float | None = None
    above: float | None = None
    below: float | None = None

    def check(self, name: str, value: float) -> None:
        """Refuse a value outside the range."""
        finite(name, value)
        if self.above is not None and value <= self.above:
            raise fault(name, "must be positive" if self.above == 0.0 else f"must be above {self.above:g}", value)
        if self.least is not None and value < self.least:
            raise fault(name, f"must be at least {self.least:g}", value)
        if self.below is not None and value >= self.below:
            raise fault(name, f"must be below {self.below:g}", value)


def own(description: str, unit: str = "-", *, default: Any = MISSING, **limits: float) -> Any:
    """A field of a law for a number of its own (`Own`): its check, its key in study files and the reference follow."""
    return field(default=default, metadata={"own": Own(description, unit, **limits)})


def own_numbers(law: type[Law] | Law) -> dict[str, Own]:
    """The numbers of its own that a law declares, by name."""
    return {each.name: each.metadata["own"] for each in fields(law) if "own" in each.metadata}  # type: ignore[arg-type]


class SingleLoad(Law):
    """A law whose friction limit is μN, with one N for all its tangential directions.

    With kn: N = max(kn (z − gap) + preload, 0), from the motion z of a normal direction (positive closes).
    Without kn: N = normal_load, constant. name: of the law in messages, as study files call it; about: what it is, for the
    reference of study files.
    """

    name: ClassVar[str]
    about: ClassVar[str]

    mu: Friction
    kn: float | None
    preload: float
    gap: float
    normal_load: float | None

    def check_load(self) -> None:
        """Refuse what is no friction coefficient and no normal load, and numbers of its own outside their range."""
        for name, number in own_numbers(self).items():
            number.check(name, getattr(self, name))
        checked_friction(self.mu)
        finite("preload", self.preload)
        finite("gap", self.gap)
        if self.kn is not None:
            positive("kn", self.kn)
        if self.normal_load is not None:
            not_negative("normal_load", self.normal_load)
        if (self.kn is None) == (self.normal_load is None):
            raise fault(
                f"A {self.name} contact",
                "must have either kn (varying normal load) or normal_load (constant)",
                {"kn": self.kn, "normal_load": self.normal_load},
                "Give exactly one of the two.",
            )

    def under_load(self, stiffness: Sequence[float], normal: bool, parameters: tuple[float, ...] = ()) -> Elements:
        """The table with one friction element of a stiffness [N/m] for each tangential direction, under the load."""
        if normal != self.has_normal:
            words = f"kn = {self.kn}, normal direction {'given' if normal else 'missing'}"
            raise fault(f"A {self.name} contact", "must have a normal direction exactly when kn is given", words)
        one, limit = np.ones(1), 0.0 if self.normal_load is None else limit_at(self.mu, self.normal_load)
        slope, loads, changes = line_of(self.mu)
        follows = (slope * one, limit * one, np.array([0]), np.array([int(normal)]))
        bends = (slope * loads[:, None], changes[:, None]) if normal else ()
        friction = tuple(FrictionElements(kt * one, *follows, *bends) for kt in stiffness)
        if self.kn is None:
            return Elements(friction, None, parameters)
        return Elements(friction, NormalElements(self.kn * one, (self.preload - self.kn * self.gap) * one), parameters)


class Yielding(SingleLoad):
    """A law of a spring kt that yields from the smallest motion on: it dissipates at every amplitude, and the steady force does
    not depend on the start."""

    kt: float

    sticks: ClassVar[bool] = False
    remembers_start: ClassVar[bool] = False

    def __post_init__(self) -> None:
        positive("kt", self.kt)
        self.check_load()

    def _limit(self, z: float) -> float:
        """μN at a constant normal displacement z, N."""
        table, forces = self._at(z)
        return float(table.limits(forces)[0])
