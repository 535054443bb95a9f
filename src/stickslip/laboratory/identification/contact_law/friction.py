"""The coefficient of friction over the normal load from loops of one contact at several loads, or under a load that varies.

A law is fitted once more with a coefficient at each of some loads, between which the slip limit is straight, as the contacts of a
model have it (`stickslip.model.contact.friction`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from stickslip.laboratory.identification.contact_law.fit import first_guess
from stickslip.laboratory.identification.contact_law.intervals import LoopErrors, errors_of_scatter
from stickslip.laboratory.identification.contact_law.model import LAWS, ContactLoop, force_of
from stickslip.laboratory.identification.least_squares import LeastSquares
from stickslip.support.checks import Array, fault

BESIDE = 0.1
"""How far a load may lie beyond those of the loops, relative to it."""

BLIND = 1e-3
"""Share of what the best known coefficient moves the forces by below which loops do not show one."""


class FrictionOverLoad(NamedTuple):
    """Coefficients (loads,) at the loads (loads,) [N] and their relative standard errors, those of gains and zeros included;
    exponent: of the power of the load that they follow best, and its standard error."""

    load: Array
    friction: Array
    errors: Array
    exponent: float
    exponent_error: float


@dataclass(frozen=True, eq=False)
class FrictionFit(LeastSquares):
    """A law along loops with a coefficient at each of the loads `over` (k,) [N]. Variables: ln kt, ln μ (k,), shape.

    about: variables about which the bounds lie.
    """

    loops: Sequence[ContactLoop]
    law: str
    over: Array
    about: Array

    @property
    def bounds(self) -> tuple[Array, Array]:
        shape, wide = LAWS[self.law][1], np.full(self.over.size, 3.0)
        first = self.about[: 1 + self.over.size]
        low, high = first - np.append(4.0, wide), first + np.append(5.0, wide)
        return np.append(low, [0.0] * shape), np.append(high, [0.999] * shape)

    def residuals(self, x: Array) -> Array:
        """Measured less computed force of all loops, one after the other, without the unknown zero of each."""
        values, reference = np.exp(x[1 : 1 + self.over.size]), float(np.max(x[1 : 1 + self.over.size]))
        theta = np.concatenate([x[:1], [reference], x[1 + self.over.size :]])
        left = []
        for loop in self.loops:
            scaled = under_friction(loop, self.over, values / np.exp(reference))
            force = np.asarray(loop.force)
            left.append(force - force.mean() - force_of(scaled, self.law, theta))
        return np.concatenate(left)


def under_friction(loop: ContactLoop, over: Array, values: Array) -> ContactLoop:
    """The loop with μ(N) N of coefficients at some loads as its load: then one coefficient of 1 stands for all."""
    load = np.asarray(loop.normal)
    inside = np.interp(load, np.append(0.0, over), np.append(0.0, over * values))
    return replace(loop, normal=np.where(load > over[-1], values[-1] * load, inside))


def friction_over_load(loops: Sequence[ContactLoop], law: str, over: Array, errors: LoopErrors) -> FrictionOverLoad:
    """The coefficients at some loads that fit loops best with a law; see `contact_law`."""
    lowest, highest = (end(np.concatenate([np.asarray(loop.normal) for loop in loops])) for end in (np.min, np.max))
    if over[0] < (1.0 - BESIDE) * lowest or over[-1] > (1.0 + BESIDE) * highest:
        raise fault("friction_over", f"must lie within the loads of the loops, {lowest:.4g} to {highest:.4g} N", over.tolist())
    order = np.argsort([loop.load for loop in loops])
    loads, ratios = np.array([(loops[k].load, loops[k].friction / loops[k].load) for k in order]).T
    guess = first_guess(loops, law)
    start = np.concatenate([guess[:1], np.log(np.interp(over, loads, ratios)), guess[2:]])
    found = FrictionFit(loops, law, over, start).solved(start)
    mu = slice(1, 1 + over.size)
    seen = np.linalg.norm(found.jacobian[:, mu], axis=0)
    if seen.min() < BLIND * seen.max():
        blind = float(over[int(np.argmin(seen))])
        raise fault("friction_over", "must be loads at which loops slip", f"{blind:g} N", "Leave that load out.")
    friction, scatter = np.exp(found.x[mu]), errors_of_scatter(found, loops)[mu]
    limits = over * friction
    if np.any(np.diff(limits) < 0.0):
        k = int(np.argmin(np.diff(limits)))
        raise fault(
            "The friction force mu N",
            "must not fall as the load grows",
            f"{limits[k]:.4g} N at {over[k]:g} N and {limits[k + 1]:.4g} N at {over[k + 1]:g} N",
            "Give fewer loads in friction_over, further apart.",
        )
    exponent = _power(np.log(over), found.x[mu], scatter)
    zero = errors.normal_zero / over
    whole = np.sqrt(scatter**2 + errors.force_gain**2 + errors.normal_gain**2 + zero**2)
    return FrictionOverLoad(over, friction, whole, *exponent)


def _power(x: Array, y: Array, scatter: Array) -> tuple[float, float]:
    """Slope of y over x (k,) and its standard error, by the scatter of y, by what the line misses where it is more."""
    weights = scatter**-2.0
    about = x - np.average(x, weights=weights)
    slope = float(np.sum(weights * about * y) / np.sum(weights * about**2))
    missed = np.sum(weights * (y - np.average(y, weights=weights) - slope * about) ** 2) / max(x.size - 2, 1)
    return slope, float(np.sqrt(max(missed, 1.0) / np.sum(weights * about**2)))
