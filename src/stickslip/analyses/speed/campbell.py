"""Campbell diagram with friction: natural frequencies, stuck and free, and the nonlinear resonance over the rotor speed.

Interference diagram (SAFE, ZZENF) of a bladed disk: which modes the engine orders excite at one rotor speed, and how near.

A problem at every rotor speed, from models at some speeds: stiffness and static loads go with the square of the speed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from stickslip.analyses.modes.nonlinear_modes import nonlinear_modes
from stickslip.analyses.nodal_diameters import nodal_diameters
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.loads import BaseMotion, Force
from stickslip.model.problem import Problem
from stickslip.model.problem.speed import SpeedDependence
from stickslip.model.structure.cyclic import CyclicStructure
from stickslip.model.structure.matrices import Structure
from stickslip.results.schema import Result, named
from stickslip.runs.work import Progress, checked_progress
from stickslip.support.checks import Array, InputError, between, fault, finite, of_kind, positive, several, unique, vector
from stickslip.support.late import pd, xr
from stickslip.support.machine import one_blas_thread

ProblemAt = Callable[[float], Problem]
ROUNDING = 1e-12
"""Difference of the stiffness of two models, relative to it, that is none."""

Models = Mapping[float, Problem] | ProblemAt
"""Problems by speed in rev/min, or a function that makes the problem of a speed."""


def problem_at(models: Models) -> ProblemAt:
    """The problem of a speed in rev/min.

    Of two speeds K(Ω) = K₀ + Ω² K₁, at any speed; of more, that between neighbours, refused beyond them. Static loads go with Ω²
    likewise. Mass, damping, contacts and harmonic forces must be the same at all speeds.
    """
    if isinstance(models, Mapping):
        return _table(models)
    if not callable(models):
        raise fault("models", "must be problems by speed, or a function of the speed", models)
    return lambda speed: of_kind("The problem of a speed", models(speed), Problem)


def _table(models: Mapping[float, Problem]) -> ProblemAt:
    if len(models) < 2:
        rule = "must hold problems at two speeds at least, which say how K goes with the speed"
        raise fault("models", rule, f"{len(models)} of them", "K(Ω) = K0 + Ω² K1.")
    speeds = sorted(finite("models, a speed", speed) for speed in models)
    if speeds[0] < 0.0:
        raise fault("models, a speed", "must not be negative", speeds[0])
    problems = [of_kind("models, a problem", models[speed], Problem) for speed in speeds]
    for speed, problem in zip(speeds[1:], problems[1:], strict=True):
        _refuse_other(problems[0], problem, speed)

    def at(speed: float) -> Problem:
        if len(speeds) > 2 and not speeds[0] <= speed <= speeds[-1]:
            raise fault("speed", f"must lie between {speeds[0]:g} and {speeds[-1]:g} rev/min, where there are models", speed)
        k = int(np.clip(np.searchsorted(speeds, speed) - 1, 0, len(speeds) - 2))
        share = (speed**2 - speeds[k] ** 2) / (speeds[k + 1] ** 2 - speeds[k] ** 2)
        return _between(problems[k], problems[k + 1], share)

    return at


def _refuse_other(one: Problem, other: Problem, speed: float) -> None:
    if one.structure.coriolis is not None or other.structure.coriolis is not None:
        raise InputError("models must have no Coriolis forces, which are neglected over the speed. Leave them out.")
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


def _between(one: Problem, other: Problem, share: float) -> Problem:
    """The problem at a share of the way in Ω²."""
    a, b = one.structure, other.structure
    structure = replace(a, K=a.K + share * (b.K - a.K))
    if isinstance(a, CyclicStructure) and isinstance(b, CyclicStructure):
        assert a.stiffnesses is not None
        assert b.stiffnesses is not None
        structure = replace(structure, stiffnesses=a.stiffnesses + share * (b.stiffnesses - a.stiffnesses))  # type: ignore[call-arg]
    loads = [replace(f, static=f.static + share * (g.static - f.static)) for f, g in zip(one.forces, other.forces, strict=True)]
    return replace(one, structure=structure, forces=tuple(loads))


def synchronous(models: Mapping[float, Problem]) -> Problem:
    """The problem of two models by speed in rev/min, with stiffness and static loads that go with Ω² (`SpeedDependence`)."""
    if len(of_kind("models", models, Mapping)) != 2:  # type: ignore[type-abstract]
        raise fault("models", "must be problems at two speeds, {speed in rev/min: problem}", models)
    (slow, one), (fast, other) = sorted((finite("models, a speed", speed), problem) for speed, problem in models.items())
    if slow < 0.0:
        raise fault("models, a speed", "must not be negative", slow)
    _refuse_other(of_kind("models, a problem", one, Problem), of_kind("models, a problem", other, Problem), fast)
    squares = [(2.0 * np.pi * speed / 60.0) ** 2 for speed in (slow, fast)]
    grown = squares[1] - squares[0]
    rates = [(g.static - f.static) / grown for f, g in zip(one.forces, other.forces, strict=True)]
    added = _stiffness(other.structure) - _stiffness(one.structure)
    added = np.where(np.abs(added).max() > ROUNDING * np.abs(one.structure.K).max(), added / grown, 0.0)
    return _with_speed(_between(one, other, -squares[0] / grown), added, rates)


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
        added = (_stiffness(problem.structure) - stiffness_at_rest) / speed**2
        structure = problem.structure
        problem = problem.with_structure(
            replace(structure, K=stiffness_at_rest[0].real, stiffnesses=stiffness_at_rest.astype(complex))
            if isinstance(structure, CyclicStructure)
            else replace(structure, K=stiffness_at_rest)
        )
    return _with_speed(problem.with_forces([replace(force, static=0.0) for force in problem.forces]), added, rates)


def _with_speed(at_rest: Problem, added: NDArray[Any], rates: Sequence[float]) -> Problem:
    """The problem at rest with K₁ = added, unless it is zero, and static parts of its forces per Ω²."""
    loads = []
    for force, rate in zip(at_rest.forces, rates, strict=True):
        if rate and isinstance(force, BaseMotion):
            raise fault("The static acceleration of the base", "must be the same at all speeds", "one that goes with the speed")
        loads += [Force(force.coefficients, static=rate)] if rate else []
    return replace(at_rest, speed=SpeedDependence(1, added if added.any() else None, tuple(loads)))


def _stiffness(structure: Structure) -> NDArray[Any]:
    """K, of a cyclic structure that of each nodal diameter."""
    if isinstance(structure, CyclicStructure):
        assert structure.stiffnesses is not None
        return structure.stiffnesses
    return structure.K


STATES = ("free", "stuck", "nonlinear")


@dataclass(frozen=True, eq=False, repr=False)
class Campbell(Result):
    """`dataset`: frequency (state, engine_order, speed) [Hz], state free, stuck or nonlinear; amplitude (engine_order, speed) of
    the nonlinear resonance [m]; crossing_speed [rev/min] and crossing_frequency [Hz] (state, engine_order), NaN without one;
    margin (state, engine_order) at the operating speed, f/(EO Ω) − 1; message (engine_order, speed)."""

    dataset: xr.Dataset

    def table(self) -> pd.DataFrame:
        """Crossings and margins, a row for each engine order and state."""
        names = [name for name in ("crossing_speed", "crossing_frequency", "margin") if name in self.dataset]
        return self.dataset[names].to_dataframe().reset_index()


def campbell(
    models: Models,
    speed: tuple[float, float],
    engine_orders: Sequence[int],
    mode: int = 1,
    *,
    force_level: float | None = None,
    operating_speed: float | None = None,
    points: int = 11,
    amplitude: float | tuple[float, float] | None = None,
    harmonics: int | Sequence[int] = 3,
    samples: int = 256,
    progress: Progress = lambda fraction, text: None,
) -> Campbell:
    """Natural frequencies over the rotor speed with engine-order lines EO Ω, where they cross, and margins at a speed.

    models: {speed in rev/min: problem} at two speeds or more, K(Ω) = K₀ + Ω² K₁ between them and static loads likewise, or a
    function of the speed. speed: (lowest, highest), rev/min. mode: number of the stuck mode, and of the free one among those that
    are not rigid; of a `TunedDisk` at the nodal diameter of each engine order. force_level: with it the resonance peak of that
    level from the nonlinear mode (`nonlinear_modes`, whose arguments amplitude, harmonics and samples are), and its amplitude.
    operating_speed: for margins, rev/min. points: speeds of the curves. Crossings are solved at their own speed, not
    interpolated. Coriolis terms are neglected. progress: called with the share done and what is computed.
    """
    low, high = vector("speed", speed, 2).tolist()
    if not 0.0 <= low < high:
        raise fault("speed", "must be (lowest, highest), not negative", speed)
    orders = tuple(between("engine_orders", order, 1) for order in several("engine_orders", engine_orders))
    unique("engine_orders", orders)
    if not orders:
        raise fault("engine_orders", "must hold at least one", "none")
    if force_level is not None:
        positive("force_level", force_level)
    if operating_speed is not None:
        positive("operating_speed", operating_speed)
    speeds = np.linspace(low, high, between("points", points, 2))
    resonance = _Resonance(
        problem_at(models), mode, force_level, {"amplitude": amplitude, "harmonics": harmonics, "samples": samples}
    )
    checked_progress(progress)
    with one_blas_thread():
        return Campbell(_dataset(resonance, speeds, orders, operating_speed, progress))


@dataclass(frozen=True, eq=False)
class _Resonance:
    """Frequencies of one mode at a speed and engine order."""

    problem_at: Callable[[float], Problem]
    mode: int
    force_level: float | None
    arguments: dict[str, Any]

    def at(self, state: str, order: int, speed: float) -> tuple[float, float, str]:
        """Frequency in Hz, amplitude of the nonlinear resonance in m, and why there is none."""
        problem = self.problem_at(speed)
        if isinstance(problem, TunedDisk):
            problem = problem.with_engine_order(order % problem.sectors)
        if state == "nonlinear":
            if self.force_level is None:
                return np.nan, np.nan, ""
            try:
                peaks = nonlinear_modes(problem, self.mode, **self.arguments).peaks([self.force_level])
            except InputError as reason:
                return np.nan, np.nan, str(reason)
            return float(peaks["frequency"][0]), float(peaks["amplitude"][0]), ""
        found = problem.frequencies(stuck=state == "stuck")
        elastic = found[found > 0.0] if state == "free" else found
        return float(elastic[between("mode", self.mode, 1, elastic.size) - 1]), np.nan, ""

    def crossing(self, state: str, order: int, speeds: Array, frequencies: Array) -> tuple[float, float]:
        """Speed in rev/min and frequency in Hz of the first crossing with the line of an engine order."""
        misses = frequencies - order * speeds / 60.0
        for k in np.flatnonzero(misses[:-1] * misses[1:] <= 0.0):
            ends = float(speeds[k]), float(speeds[k + 1])
            found = float(brentq(lambda speed: self.at(state, order, speed)[0] - order * speed / 60.0, *ends, rtol=1e-9))
            return found, order * found / 60.0
        return np.nan, np.nan


def _dataset(
    resonance: _Resonance, speeds: Array, orders: tuple[int, ...], operating: float | None, progress: Progress
) -> xr.Dataset:
    shape = len(STATES), len(orders), speeds.size
    frequencies, amplitudes, messages = np.full(shape, np.nan), np.full(shape[1:], np.nan), np.full(shape[1:], "", dtype=object)
    crossings, margins = np.full((2, *shape[:2]), np.nan), np.full(shape[:2], np.nan)
    for done, (s, o, k) in enumerate(np.ndindex(shape)):
        speed = float(speeds[k])
        progress(done / frequencies.size, f"{STATES[s]}, engine order {orders[o]}, {speed:.5g} rev/min")
        frequencies[s, o, k], size, message = resonance.at(STATES[s], orders[o], speed)
        if STATES[s] == "nonlinear":
            amplitudes[o, k], messages[o, k] = size, message
    for s, o in np.ndindex(shape[:2]):
        state, order = STATES[s], orders[o]
        crossings[:, s, o] = resonance.crossing(state, order, speeds, frequencies[s, o])
        if operating is not None:
            margins[s, o] = resonance.at(state, order, operating)[0] / (order * operating / 60.0) - 1.0
    both, curve = ("state", "engine_order"), ("engine_order", "speed")
    data: dict[str, Any] = {
        "frequency": named(("state", *curve), frequencies, "natural frequency, or that of the resonance", "Hz"),
        "amplitude": named(curve, amplitudes, "amplitude of the nonlinear resonance", "m"),
        "crossing_speed": named(both, crossings[0], "speed at which an engine order meets it", "rev/min"),
        "crossing_frequency": named(both, crossings[1], "frequency at the crossing", "Hz"),
        "message": named(curve, messages.astype(np.str_), "why there is no nonlinear resonance"),
    }
    attrs: dict[str, Any] = {"title": resonance.problem_at(float(speeds[0])).title, "mode": resonance.mode}
    if operating is not None:
        data["margin"] = named(both, margins, "frequency over that of the engine order, less 1")
        attrs["operating_speed"] = finite("operating_speed", operating)
    if resonance.force_level is not None:
        attrs["force_level"] = resonance.force_level
    coords: dict[str, Any] = {"state": list(STATES), "engine_order": list(orders)}
    coords["speed"] = named("speed", speeds, "rotor speed", "rev/min")
    return xr.Dataset(data, coords, attrs)


WAVES = ("standing", "backward", "forward")
"""How the wave that a pattern at rest excites travels in the disk: neither way (0 and N/2), against the rotation, or with it."""


@dataclass(frozen=True, eq=False, repr=False)
class InterferenceDiagram(Result):
    """`dataset`: disk_frequency (state, nodal_diameter, mode) [Hz]; of each engine order excited_diameter, wave and
    excitation_frequency EO Ω [Hz]; mode of the nearest frequency at that diameter and its margin f/(EO Ω) − 1, both
    (state, engine_order)."""

    dataset: xr.Dataset

    def table(self) -> pd.DataFrame:
        """Nearest modes and margins, a row for each engine order and state."""
        names = ["excited_diameter", "wave", "excitation_frequency", "nearest_mode", "margin"]
        return self.dataset[names].to_dataframe().reset_index()


def interference_diagram(
    disk: TunedDisk | Models, speed: float, engine_orders: Sequence[int] | None = None, modes: int = 6
) -> InterferenceDiagram:
    """Natural frequencies over the nodal diameter, and where the engine orders meet them at a rotor speed.

    Of N sectors, engine order EO excites nodal diameter EO mod N, or N less that where it is above N/2, with frequency EO Ω. A
    mode is in resonance where the line of frequency over diameter, folded at 0 and N/2, passes through it. The pattern stands
    still in space; its wave travels backward in the disk, forward where the diameter is folded.
    disk: a tuned disk, or its models by speed as `campbell` takes them. speed: rev/min. engine_orders: 1 to N unless given.
    modes: of each nodal diameter; rigid motions of free dampers are left out. Coriolis terms are neglected.
    """
    positive("speed", speed)
    problem = disk if isinstance(disk, TunedDisk) else problem_at(disk)(speed)
    of_kind("disk", problem, TunedDisk)
    assert isinstance(problem, TunedDisk)
    given = range(1, problem.sectors + 1) if engine_orders is None else several("engine_orders", engine_orders)
    orders = np.array([between("engine_orders", order, 1) for order in given])
    unique("engine_orders", orders.tolist())
    if not orders.size:
        raise fault("engine_orders", "must hold at least one", "none")
    found, sectors = nodal_diameters(problem, modes).dataset, problem.sectors
    diameters = np.minimum(orders % sectors, -orders % sectors)
    excitation = orders * speed / 60.0
    # Where a diameter has fewer modes than others, NaN stands in their place.
    off = found["disk_frequency"].values[:, diameters] / excitation[:, None] - 1.0
    nearest = np.argmin(np.where(np.isfinite(off), np.abs(off), np.inf), axis=2)
    margins = np.take_along_axis(off, nearest[..., None], axis=2)[..., 0]
    own, both = "engine_order", ("state", "engine_order")
    folded = orders % sectors
    kinds = np.where(2 * folded < sectors, 1, 2)
    kinds[(folded == 0) | (2 * folded == sectors)] = 0
    data: dict[str, Any] = {
        "excited_diameter": named(own, diameters, "nodal diameter that an engine order excites"),
        "wave": named(own, np.asarray(WAVES)[kinds], "how the excited wave travels"),
        "excitation_frequency": named(own, excitation, "frequency of the excitation", "Hz"),
        "nearest_mode": named(both, nearest + 1, "mode of that nodal diameter nearest in frequency"),
        "margin": named(both, margins, "its frequency over that of the excitation, less 1"),
    }
    return InterferenceDiagram(found.assign(data).assign_coords(engine_order=orders).assign_attrs(speed=float(speed)))
