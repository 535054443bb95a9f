"""A damper between two platforms, in the plane, and the periodic motion that drives it: the model of a damper rig.

Unknowns are the damper's x, y and rotation, and those of the right platform where it is not rigid. The left platform moves as
prescribed, relative to the foundation of the right one.

Jamming: the condition under which friction locks a damper between its platforms at any force.

While the platforms close, the force at each side leans to its friction cone's edge. The damper slides out only while
cot(α_R + φ_R) + cot(α_L + φ_L) > 0, that is α_L + φ_L + α_R + φ_R < 180°: H = F_C/(that sum). Beyond, it is locked.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import sha256
from math import atan, degrees
from typing import Self, cast

import numpy as np
from numpy.typing import ArrayLike

from stickslip.model.contact.dahl import Dahl
from stickslip.model.contact.law import Friction, Law, LoadDependentFriction
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.microslip import Iwan, MicroslipArray
from stickslip.model.contact.point import Contact, ContactTable, Direction, contact_table
from stickslip.model.dampers.damper import ContactSurface, Damper
from stickslip.support import checks
from stickslip.support.checks import Array, fault


@dataclass(frozen=True, eq=False)
class PlatformMotion:
    """x and y of the left platform as real harmonics (2, 2H+1) [m]: rows a0, a1, b1, a2, b2, ...

    Platforms of neighbouring blades that move against each other close and open horizontally: `out_of_phase`. Blades in phase
    move the platforms past each other vertically: `in_phase`.
    """

    harmonics: ArrayLike

    def __post_init__(self) -> None:
        values = np.asarray(self.harmonics, dtype=float)
        if values.ndim != 2 or values.shape[0] != 2 or values.shape[1] % 2 == 0 or not np.all(np.isfinite(values)):
            raise fault("Harmonics of a platform motion", "must be finite, of shape (2, 2H+1)", np.shape(values))
        if not np.any(values[:, 1:]):
            raise fault("A platform motion", "must move", "all harmonics are zero", "Give a horizontal or a vertical amplitude.")
        object.__setattr__(self, "harmonics", values)

    @property
    def digest(self) -> str:
        """Identifies the motion."""
        return sha256(np.asarray(self.harmonics).tobytes()).hexdigest()[:12]

    def samples(self, steps: int) -> Array:
        """The motion at t_n = 2πn/(steps ω), (steps, 2) [m]."""
        values = np.asarray(self.harmonics)
        highest = (values.shape[1] - 1) // 2
        if checks.whole("steps", steps) < max(8, 4 * highest):
            raise fault("steps", f"must be at least {max(8, 4 * highest)} for this motion", steps)
        angles = 2.0 * np.pi * ((np.arange(steps)[:, None] * np.arange(1, highest + 1)) % steps) / steps
        return np.asarray(values[:, 0] + np.cos(angles) @ values[:, 1::2].T + np.sin(angles) @ values[:, 2::2].T)


def out_of_phase(amplitude: float) -> PlatformMotion:
    """x = amplitude sin ωt: the gap between the platforms opens and closes. amplitude [m]."""
    return elliptic(checks.positive("amplitude", amplitude), 0.0)


def in_phase(amplitude: float) -> PlatformMotion:
    """y = amplitude sin ωt: the platforms move past each other. amplitude [m]."""
    return elliptic(0.0, checks.positive("amplitude", amplitude))


def elliptic(horizontal: float, vertical: float, phase: float = 90.0) -> PlatformMotion:
    """x = horizontal sin ωt, y = vertical sin(ωt + phase); amplitudes in m, phase in degrees."""
    angle = np.radians(checks.finite("phase", phase)) if horizontal else 0.0
    x, y = checks.finite("horizontal", horizontal), checks.finite("vertical", vertical)
    return PlatformMotion([[0.0, 0.0, x], [0.0, y * np.sin(angle), y * np.cos(angle)]])


def measured(x: ArrayLike, y: ArrayLike, harmonics: int = 30) -> PlatformMotion:
    """The motion of one recorded cycle in equal time steps, x and y (n,) [m], smoothed to so many harmonics."""
    checks.between("harmonics", harmonics, 1)
    across, up = checks.numbers("x", x), checks.numbers("y", y)
    if across.shape != up.shape:
        raise fault("x and y of a measured cycle", "must have equal length", f"of shapes {across.shape} and {up.shape}")
    signals = np.array([across, up])
    if signals.ndim != 2 or signals.shape[1] <= 2 * harmonics or not np.all(np.isfinite(signals)):
        raise fault("A measured cycle", f"must be finite and have more than {2 * harmonics} samples of x and y", signals.shape)
    spectrum = np.fft.rfft(signals, axis=1)[:, : harmonics + 1] / signals.shape[1]
    values = np.empty((2, 2 * harmonics + 1))
    values[:, 0] = spectrum[:, 0].real
    values[:, 1::2], values[:, 2::2] = 2.0 * spectrum[:, 1:].real, -2.0 * spectrum[:, 1:].imag
    return PlatformMotion(values)


LAWS = ("macroslip", "iwan", "microslip", "dahl")
"""The laws that lines of contact may follow in a study; those of an identification among them."""

PLAIN: dict[str, Callable[[float, Friction, float], Law]] = {"iwan": Iwan, "dahl": Dahl}
"""Those that kt, mu and kn define."""

Frictions = ArrayLike | LoadDependentFriction | Sequence[Friction]
"""Coefficients of friction: one for all lines of contact, or one each."""

DAMPER, LEFT, RIGHT = ("damper.x", "damper.y", "damper.rz"), ("left.x", "left.y"), ("right.x", "right.y")


@dataclass(frozen=True, eq=False)
class ElasticPlatform:
    """The right platform on the stiffness of its rig: stiffness (2, 2) [N/m] in x, y, mass [kg]; damping (2, 2) [N s/m]."""

    stiffness: ArrayLike
    mass: float = 0.0
    damping: ArrayLike = ((0.0, 0.0), (0.0, 0.0))

    def __post_init__(self) -> None:
        stiffness = checks.symmetric("Stiffness of the right platform", self.stiffness, 2)
        if np.linalg.eigvalsh(stiffness)[0] <= 0.0:
            raise fault("Stiffness of the right platform", "must be positive definite", stiffness.tolist())
        checks.not_negative("Mass of the right platform", self.mass)
        object.__setattr__(self, "stiffness", stiffness)
        object.__setattr__(self, "damping", checks.symmetric("Damping of the right platform", self.damping, 2))


@dataclass(frozen=True)
class PlanePoint:
    """A line of contact seen along z: its name (L1, L2, ..., R), place from the mass centre (2,), directions t1 and n (2,), the
    side it is on, its share of the stiffness of that side, and the radius on which it rolls."""

    name: str
    arm: tuple[float, float]
    tangent: tuple[float, float]
    normal: tuple[float, float]
    side: str
    share: float
    radius: float

    def direction(self, along: tuple[float, float]) -> Direction:
        """w along a direction: platform minus damper, as coefficients of degrees of freedom."""
        (x, y), (a, b) = along, self.arm
        platform = LEFT if self.side == "left" else RIGHT
        values = (-x, -y, -(a * y - b * x), x, y)
        return {dof: float(value) for dof, value in zip((*DAMPER, *platform), values, strict=True) if value != 0.0}


def plane_points(damper: Damper) -> tuple[PlanePoint, ...]:
    """The lines of contact of a damper with surfaces "left" and "right", the lowest first at each side."""
    points = [_points_of(damper, damper.surface(side)) for side in ("left", "right")]
    return tuple(point for side in points for point in side)


def _points_of(damper: Damper, surface: ContactSurface) -> list[PlanePoint]:
    """Points of one surface with equal x, y as one, named by the first letter of the surface."""
    frame, centre = np.asarray(surface.frame), np.asarray(damper.body.centre)
    if abs(frame[0, 2]) > 1e-9 or abs(frame[2, 2]) > 1e-9:
        raise fault(f"Surface {surface.name!r} of a damper between platforms", "must have t1 and n in the plane", frame.tolist())
    arms = np.asarray(surface.points) - centre
    sites, index = np.unique(np.round(arms[:, :2], 12), axis=0, return_inverse=True)
    order = np.argsort(sites @ np.array([1e-3, 1.0]), kind="stable")  # by height; of equal heights the left one first
    letter = surface.name[0].upper()
    points = []
    for number, site in enumerate(order, start=1):
        members = index.ravel() == site
        x, y = arms[members][0, :2]
        share = float(np.asarray(surface.weights)[members].sum())
        name = f"{letter}{number}" if len(order) > 1 else letter
        tangent, normal = ((float(row[0]), float(row[1])) for row in (frame[0], frame[2]))
        points.append(PlanePoint(name, (float(x), float(y)), tangent, normal, surface.name, share, surface.radius))
    return points


@dataclass(frozen=True, eq=False)
class BetweenPlatforms:
    """A damper, the law of each line of contact in the order of `points` (lowest left first, right last), and the right
    platform: rigid unless given. `title`: of reports."""

    damper: Damper
    laws: tuple[Law, ...]
    right: ElasticPlatform | None = None
    title: str = ""

    def __post_init__(self) -> None:
        _damper(self.damper)
        object.__setattr__(self, "laws", checks.several("laws", self.laws))
        if len(self.laws) != len(self.points):
            names = ", ".join(point.name for point in self.points)
            raise fault("laws", f"must be {len(self.points)}, one for each of {names}", len(self.laws))
        if not any(np.asarray(self.damper.pull)[:2]):
            raise fault("pull", "must press the damper against the platforms", np.asarray(self.damper.pull).tolist())
        for law, point in zip(self.laws, self.points, strict=True):
            checks.of_kind(f"The law of {point.name}", law, Law)  # type: ignore[type-abstract]
            if not law.has_normal:
                raise fault(f"The law of {point.name}", "must have a normal stiffness", repr(law), "Give it kn.")

    @classmethod
    def macroslip(
        cls, damper: Damper, kt: ArrayLike, kn: ArrayLike, mu: Frictions, right: ElasticPlatform | None = None, title: str = ""
    ) -> Self:
        """One macroslip law a line of contact: kt, kn [N/m], mu, each a number or one entry per line; mu may be a
        `LoadDependentFriction`, over the load of one line."""
        count = len(plane_points(_damper(damper)))
        stiffnesses = [checks.vector(name, value, count) for name, value in (("kt", kt), ("kn", kn))]
        laws = tuple(Macroslip(float(t), m, float(n)) for t, n, m in zip(*stiffnesses, _frictions(mu, count), strict=True))
        return cls(damper, laws, right, title)

    @classmethod
    def of_law(
        cls,
        law: str,
        damper: Damper,
        kt: ArrayLike,
        kn: ArrayLike,
        mu: Frictions,
        gaps: float = 0.0,
        right: ElasticPlatform | None = None,
        title: str = "",
    ) -> Self:
        """One law for every line of contact: "macroslip"; "iwan", the half ellipse of a cylinder on a flat; "microslip", five
        elements whose gaps reach 2 g N/kn, g = `gaps` and N the pull shared over the lines; "dahl".

        kt, kn [N/m], mu: each a number or one entry per line; mu may be a `LoadDependentFriction`, over the load of one line.
        """
        if law not in LAWS:
            raise fault("law", "must be a known one", law, checks.nearest(law, LAWS))
        suitable_gaps(law, gaps)
        frame = cls.macroslip(damper, kt, kn, mu, right, title)
        if law == "macroslip":
            return frame
        laws: list[Law] = []
        for one in frame.laws:
            assert isinstance(one, Macroslip)
            assert one.kn is not None
            if law in PLAIN:
                laws.append(PLAIN[law](one.kt, one.mu, one.kn))
            else:
                # Gaps spread evenly from nothing to `reach`, twice their mean: `gaps` as a share of N/kn, N the pull of one line.
                reach = 2.0 * gaps * float(frame.pull[1]) / (len(frame.laws) * one.kn)
                laws.append(MicroslipArray.from_totals(one.kt, one.kn, one.mu, reach))
        return replace(frame, laws=tuple(laws))

    @cached_property
    def points(self) -> tuple[PlanePoint, ...]:
        """The lines of contact."""
        return plane_points(self.damper)

    @cached_property
    def contacts(self) -> tuple[Contact, ...]:
        """One contact a line, with one tangential direction and a normal, w = platform − damper."""
        return tuple(
            Contact(point.name, law, (point.direction(point.tangent),), point.direction(point.normal))
            for point, law in zip(self.points, self.laws, strict=True)
        )

    @cached_property
    def table(self) -> ContactTable:
        """The contacts as flat arrays."""
        return contact_table(self.contacts)

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the unknowns."""
        return DAMPER if self.right is None else (*DAMPER, *RIGHT)

    def rows(self, dofs: Sequence[str]) -> Array:
        """Coefficients of some degrees of freedom in every contact row, (rows, dofs)."""
        directions = [direction for contact in self.contacts for direction in contact.directions]
        return np.array([[direction.get(dof, 0.0) for dof in dofs] for direction in directions])

    @cached_property
    def matrices(self) -> tuple[Array, Array, Array]:
        """M, C, K of the unknowns, without contacts."""
        M, C, K = (np.zeros((len(self.free), len(self.free))) for _ in range(3))
        inertia = np.asarray(self.damper.body.inertia)[2, 2]
        M[:3, :3] = np.diag([self.damper.body.mass, self.damper.body.mass, inertia])
        if self.right is not None:
            M[3:, 3:] = self.right.mass * np.eye(2)
            C[3:, 3:], K[3:, 3:] = np.asarray(self.right.damping), np.asarray(self.right.stiffness)
        return M, C, K

    @property
    def pull(self) -> Array:
        """Static load on the unknowns, N."""
        load = np.zeros(len(self.free))
        load[:2] = np.asarray(self.damper.pull)[:2]
        return load

    def with_friction(self, mu: ArrayLike) -> Self:
        """A copy of macroslip laws with other friction coefficients, a number or one a line."""
        values = checks.vector("mu", mu, len(self.laws))
        for law in self.laws:
            if not hasattr(law, "mu"):
                raise fault("The law", "must have a friction coefficient mu", type(law).__name__)
        laws = tuple(replace(law, mu=float(m)) for law, m in zip(self.laws, values, strict=True))  # type: ignore[type-var]
        return replace(self, laws=laws)

    def with_pull(self, pull: float) -> Self:
        """A copy with another pull, N, along y."""
        return replace(self, damper=replace(self.damper, pull=(0.0, pull, 0.0)))


def _frictions(mu: Frictions, count: int) -> list[Friction]:
    """The coefficient of each line of contact."""
    if isinstance(mu, LoadDependentFriction):
        return [mu] * count
    if isinstance(mu, Sequence) and any(isinstance(each, LoadDependentFriction) for each in mu):
        if len(mu) != count:
            raise fault("mu", f"must have {checks.counted(count, 'entry', 'entries')}", len(mu))
        return list(mu)
    return list(map(float, checks.vector("mu", cast(ArrayLike, mu), count)))


def _damper(damper: Damper) -> Damper:
    """The damper, unless it is something else, such as its shape."""
    if not isinstance(damper, Damper):
        raise fault("damper", "must be a Damper", damper, "A shape becomes one by shape.damper(pull=...).")
    return damper


def suitable_gaps(law: str, gaps: float) -> None:
    """Refuse gaps that a law does not have, and a law without the gaps that it needs."""
    if (law == "microslip") != (checks.not_negative("gaps", gaps) > 0.0):
        raise fault("gaps", "must be above 0 with the law microslip, and 0 with others", gaps)


def jamming(rig: BetweenPlatforms) -> str:
    """The cause why the damper can jam, "" where it cannot."""
    (left, left_cone), (right, right_cone) = (_slope_and_cone(rig, side) for side in ("left", "right"))
    total = left + left_cone + right + right_cone
    if total < 180.0:
        return ""
    return (
        f"friction holds it against any closing force, since platform and friction angles add up to {total:.1f} degrees, "
        f"180 or more (left {left:.1f} + {left_cone:.1f}, right {right:.1f} + {right_cone:.1f}). "
        "Less friction or flatter platforms free it."
    )


def _slope_and_cone(rig: BetweenPlatforms, side: str) -> tuple[float, float]:
    """Slope of the platform and the friction angle of its line of least friction, degrees: the damper leaves where it can."""
    points = [(point, law) for point, law in zip(rig.points, rig.laws, strict=True) if point.side == side]
    normal = points[0][0].normal
    slope = degrees(np.arctan2(abs(normal[0]), abs(normal[1])))
    mus = [getattr(law, "mu", 0.0) for _, law in points]  # under a load as large as it takes to jam
    return slope, degrees(atan(min(mu.values[-1] if isinstance(mu, LoadDependentFriction) else float(mu) for mu in mus)))
