"""A problem at every rotor speed, from models at some: stiffness and static loads go with the square of the speed, Coriolis
forces with the speed.

The K of a program at speed is that of the deformed shape. A thin blade is soft across its plane and 10⁴ times as stiff in it, so
that a turn of one degree between two models makes K + share (K' − K) stiff where neither is: third frequency of a shrouded wheel
16 % too high. The motions with either K are therefore turned into each other first, as far as one is soft and the other stiff:
K' = W K″ Wᴴ, WᴴMW = M, and K = Wˢ (K + s (K″ − K)) W⁻ˢ. Without turn, W = 1, that is K + s (K' − K); changes of the soft motions
among themselves, as by stress stiffening, remain linear.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.loads import BaseMotion, Force
from stickslip.model.problem import Problem
from stickslip.model.problem.speed import SpeedDependence
from stickslip.model.structure.cyclic import CyclicStructure
from stickslip.model.structure.cyclic_reduction import hermitian
from stickslip.model.structure.matrices import Structure
from stickslip.model.structure.modes import ROUNDING
from stickslip.support.checks import Array, InputError, fault, finite, of_kind

SOFT = 30.0
"""Times the lowest natural frequency up to which a motion is soft: across its plane a thin blade has several modes within 10
times the lowest; in its plane, 10⁴ times as stiff, they begin at 100 times. Stiffer kept rows do not count. Of a shrouded wheel
on 36 and on 216 coordinates, frequencies between two speeds are right to 0.03 %."""


@dataclass(frozen=True, eq=False)
class Turning:
    """back: from the eigenvectors of W to forces, (m, m); first, last: both K between these; angles of its eigenvalues, (m,);
    real: whether M and both K are."""

    back: NDArray[Any]
    first: NDArray[Any]
    last: NDArray[Any]
    angles: Array
    real: bool

    @classmethod
    def between(cls, M: NDArray[Any], first: NDArray[Any], last: NDArray[Any]) -> "Turning":
        """From M, positive definite, and K at both ends.

        S = (K² − c²M²)(K² + c²M²)⁻¹ in coordinates in which M = 1 is −1 for motions much softer than c and 1 for stiffer ones, W
        the unitary factor of 1 + S'S: it takes soft motions into soft ones the shortest way. √c is `SOFT` times the lowest
        frequency of both; a motion of negative stiffness is soft.
        """
        L = linalg.cholesky(M, lower=True)
        one, other = (
            hermitian(linalg.solve_triangular(L, linalg.solve_triangular(L, K, lower=True).conj().T, lower=True))
            for K in (first, last)
        )
        ends = [linalg.eigh(each) for each in (one, other)]
        lowest = [values[values > ROUNDING * abs(values[-1])][:1] for values, _ in ends]
        c = SOFT**2 * min([value for each in lowest for value in each], default=1.0)
        soft, its = (
            (vectors * (1.0 - 2.0 / (1.0 + (np.maximum(values, 0.0) / c) ** 2))) @ vectors.conj().T for values, vectors in ends
        )
        left, _, right = linalg.svd(np.eye(len(L)) + its @ soft)
        W = left @ right
        turned, Q = linalg.eigh(hermitian(1j * linalg.solve(np.eye(len(L)) + W, np.eye(len(L)) - W)))  # tan(angle/2)
        angles = 2.0 * np.arctan(turned)
        phases = np.exp(1j * angles)
        real = not any(np.imag(each).any() for each in (M, first, last))
        return cls(L @ Q, Q.conj().T @ one @ Q, phases.conj()[:, None] * (Q.conj().T @ other @ Q) * phases, angles, real)

    def at(self, share: float) -> NDArray[Any]:
        """K at a share of the way."""
        by = self.back * np.exp(1j * share * self.angles)
        K = hermitian(by @ (self.first + share * (self.last - self.first)) @ by.conj().T)
        return np.asarray(K.real if self.real else K)


UNCHANGED = 1e-12
"""Difference of the stiffness of two models, relative to it, that is none."""

Models = Mapping[float, Problem] | Callable[[float], Problem]
"""Problems by speed in rev/min, or a function that makes the problem of a speed."""


@dataclass(frozen=True, eq=False)
class ProblemAt:
    """The problem of a speed in rev/min.

    Of problems at two speeds K(Ω) = K₀ + Ω² K₁, at any speed; of more, that between neighbours, refused beyond them. K of disks
    that were read at several speeds turns between them (`Turning`). Static loads go with Ω², and Coriolis forces with Ω.
    Mass, damping, contacts and harmonic forces must be the same at all speeds.
    """

    models: Models

    def __post_init__(self) -> None:
        if isinstance(self.models, Mapping):
            object.__setattr__(self, "models", _sorted(self.models))
        elif not callable(self.models):
            raise fault("models", "must be problems by speed, or a function of the speed", self.models)

    def __call__(self, speed: float) -> Problem:
        if isinstance(self.models, Mapping):
            return _at(self.models, speed)
        return of_kind("The problem of a speed", self.models(speed), Problem)

    @property
    def fingerprint(self) -> str:
        """All that problems at any speed depend on, of a function its name alone."""
        if not isinstance(self.models, Mapping):
            return repr(self.models)
        return ", ".join(f"{speed!r} {problem.fingerprint}" for speed, problem in self.models.items())

    @cached_property
    def stiffens(self) -> bool:
        """Whether K or Coriolis forces may go with the speed: without either, natural frequencies are the same at all speeds."""
        if not isinstance(self.models, Mapping):
            return True
        *others, last = (problem.structure for problem in self.models.values())
        return last.coriolis is not None or not all(np.array_equal(last.whole_stiffness, each.whole_stiffness) for each in others)


def problem_at(models: Models | ProblemAt) -> ProblemAt:
    """What makes the problem of a speed in rev/min."""
    return models if isinstance(models, ProblemAt) else ProblemAt(models)


def _sorted(models: Mapping[float, Problem]) -> Mapping[float, Problem]:
    """Problems by speed, ascending, that differ in nothing but what goes with the speed."""
    if len(models) < 2:
        rule = "must hold problems at two speeds at least, which say how K goes with the speed"
        raise fault("models", rule, f"{len(models)} of them", "K(Ω) = K0 + Ω² K1.")
    speeds = sorted(finite("models, a speed", speed) for speed in models)
    if speeds[0] < 0.0:
        raise fault("models, a speed", "must not be negative", speeds[0])
    problems = [of_kind("models, a problem", models[speed], Problem) for speed in speeds]
    for speed, problem in zip(speeds[:-1], problems[:-1], strict=True):
        _refuse_other(problems[-1], problem, speed, speed / speeds[-1])
    return dict(zip(speeds, problems, strict=True))


def _at(models: Mapping[float, Problem], speed: float) -> Problem:
    """The problem of a speed in rev/min between those of its neighbours; of two models, also beyond them."""
    speeds, problems = list(models), list(models.values())
    k, share = _place(speeds, speed)
    found, fastest = _between(problems[k], problems[k + 1], share), problems[-1].structure.coriolis
    if fastest is None:
        return found
    return found.with_structure(replace(found.structure, coriolis=speed / speeds[-1] * fastest))


def _place(speeds: Sequence[float], speed: float) -> tuple[int, float]:
    """The number of the model below a speed, and the share of the way in Ω² to the next one."""
    if len(speeds) > 2 and not speeds[0] <= speed <= speeds[-1]:
        raise fault("speed", f"must lie between {speeds[0]:g} and {speeds[-1]:g} rev/min, where there are models", speed)
    k = int(np.clip(np.searchsorted(speeds, speed) - 1, 0, len(speeds) - 2))
    return k, (speed**2 - speeds[k] ** 2) / (speeds[k + 1] ** 2 - speeds[k] ** 2)


def waves_at(disks: Mapping[float, CyclicStructure], speed: float) -> NDArray[Any]:
    """K of the nodal diameters at a speed, of disks at two speeds or more."""
    speeds = sorted(disks)
    k, share = _place(speeds, speed)
    return _waves_between(disks[speeds[k]], disks[speeds[k + 1]], share)


def _waves_between(one: CyclicStructure, other: CyclicStructure, share: float) -> NDArray[Any]:
    """K of the nodal diameters at a share of the way in Ω²."""
    if one.turns and other.turns and share not in (0.0, 1.0):
        return np.array([turning.at(share) for turning in _turnings(one, other)])
    return np.asarray(one.whole_stiffness + share * (other.whole_stiffness - one.whole_stiffness))


@lru_cache(maxsize=2)
def _turnings(one: CyclicStructure, other: CyclicStructure) -> "list[Turning]":
    """How K turns at each nodal diameter: kept, since a curve asks for many speeds between the same two."""
    assert one.masses is not None
    return [Turning.between(*each) for each in zip(one.masses, one.whole_stiffness, other.whole_stiffness, strict=True)]


def _refuse_other(one: Problem, other: Problem, speed: float, slower: float) -> None:
    """Refuse a problem at a speed, that of `one` times `slower`, that differs in more than what goes with the speed."""
    same = {
        "degrees of freedom": one.structure.dofs == other.structure.dofs,
        "contacts": repr(one.contacts) == repr(other.contacts),
        "harmonic forces": [(f.coefficients, f.factors) for f in one.forces]
        == [(f.coefficients, f.factors) for f in other.forces],
        "damping": repr(one.structure.damping) == repr(other.structure.damping),
    }
    if same["degrees of freedom"]:
        same["mass"] = np.allclose(one.structure.M, other.structure.M, rtol=1e-9, atol=1e-12 * np.abs(one.structure.M).max())
        same["damping"] = same["damping"] and _alike(one.structure.C, other.structure.C)
        turning, own = (0.0 * each.M if each.coriolis is None else each.coriolis for each in (one.structure, other.structure))
        same["Coriolis forces per speed"] = np.allclose(own, slower * turning, rtol=1e-9, atol=1e-12 * np.abs(turning).max())
    different = [name for name, equal in same.items() if not equal]
    if different:
        remedy = " A normal load that is a number does not go with the speed: press the contact by a static force, with kn."
        raise InputError(
            f"models must differ in stiffness and static loads alone, but at {speed:g} rev/min differ in {different[0]}."
            + (remedy if different[0] == "contacts" else "")
        )


def _alike(one: Any, other: Any) -> bool:
    if one is None or other is None:
        return one is other
    return bool(np.allclose(one, other, rtol=1e-9, atol=1e-12 * np.abs(one).max()))


def _between(one: Problem, other: Problem, share: float, straight: bool = False) -> Problem:
    """The problem at a share of the way in Ω²; straight: also of blades that turn."""
    a, b = one.structure, other.structure
    loads = [replace(f, static=f.static + share * (g.static - f.static)) for f, g in zip(one.forces, other.forces, strict=True)]
    found: Structure
    if isinstance(a, CyclicStructure) and isinstance(b, CyclicStructure):
        waves = _waves_between(replace(a, turns=False) if straight else a, b, share)
        found = replace(a, K=waves[0].real, stiffnesses=waves.astype(complex))
    else:
        found = replace(a, K=a.K + share * (b.K - a.K), coriolis=None)
    return replace(one, structure=found, forces=tuple(loads))


def with_waves(problem: Problem, waves: NDArray[Any]) -> Problem:
    """The problem of a disk with another K of its nodal diameters."""
    assert isinstance(problem.structure, CyclicStructure)
    return problem.with_structure(replace(problem.structure, K=waves[0].real, stiffnesses=waves.astype(complex)))


def synchronous(models: Mapping[float, Problem]) -> Problem:
    """The problem of two models by speed in rev/min, with stiffness and static loads that go with Ω² (`SpeedDependence`)."""
    if len(of_kind("models", models, Mapping)) != 2:  # type: ignore[type-abstract]
        raise fault("models", "must be problems at two speeds, {speed in rev/min: problem}", models)
    (slow, one), (fast, other) = _sorted(models).items()
    if other.structure.coriolis is not None:
        raise InputError("models must have no Coriolis forces, which are neglected along an engine order. Leave them out.")
    squares = [(2.0 * np.pi * speed / 60.0) ** 2 for speed in (slow, fast)]
    grown = squares[1] - squares[0]
    rates = [(g.static - f.static) / grown for f, g in zip(one.forces, other.forces, strict=True)]
    added = other.structure.whole_stiffness - one.structure.whole_stiffness
    added = np.where(np.abs(added).max() > UNCHANGED * np.abs(one.structure.K).max(), added / grown, 0.0)
    return _with_speed(_between(one, other, -squares[0] / grown, straight=True), added, rates)


def at_reference_speed(problem: Problem, speed: float, stiffness_at_rest: NDArray[Any] | None = None) -> Problem:
    """A problem that holds at one speed in rad/s, with static forces, and K if that at rest is given, that go with Ω².

    stiffness_at_rest: (n, n), of a cyclic structure one for each nodal diameter as its `stiffnesses`.
    """
    rates = [force.static / speed**2 for force in problem.forces]
    if stiffness_at_rest is None:
        if not any(rates):
            raise InputError(
                "A speed sweep must have something that goes with the speed, but there is neither a static force nor a stiffness "
                "at rest. Without them the response over a band of frequencies says the same."
            )
        added = np.zeros((1, 1))
    else:
        added = (problem.structure.whole_stiffness - stiffness_at_rest) / speed**2
        structure = problem.structure
        if isinstance(structure, CyclicStructure):
            problem = with_waves(problem, stiffness_at_rest)
        else:
            problem = problem.with_structure(replace(structure, K=stiffness_at_rest))
    return _with_speed(problem.with_forces([replace(force, static=0.0) for force in problem.forces]), added, rates)


def _with_speed(at_rest: Problem, added: NDArray[Any], rates: Sequence[float]) -> Problem:
    """The problem at rest with K₁ = added, unless it is zero, and static parts of its forces per Ω²."""
    loads = []
    for force, rate in zip(at_rest.forces, rates, strict=True):
        if rate and isinstance(force, BaseMotion):
            raise fault("The static acceleration of the base", "must be the same at all speeds", "one that goes with the speed")
        loads += [Force(force.coefficients, static=rate)] if rate else []
    return replace(at_rest, speed=SpeedDependence(1, added if added.any() else None, tuple(loads)))
