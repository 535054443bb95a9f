"""Detection of resonances that a continuation step passes over: the balance is solved at the known ones inside it."""

import itertools

import numpy as np

from stickslip.solve.balance.balance import HarmonicBalance, Point
from stickslip.solve.balance.resonances import Resonances, contacts_and_outputs
from stickslip.solve.continuation.curve_points import ROUNDING, CurvePoint, hermite_shares
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.support.checks import Array

NEGLIGIBLE = 1e-3
"""A resonance that could add no more than this share to the motion of any output is not looked at."""

TOLERANCE = 0.02
"""Relative difference between the motion at a resonance and the cubic through both ends, above which the step is too long."""

SAME = 0.1
"""Resonances of two contact states nearer than this share of the half-width are one."""

SHORT = 1e-3
"""Arc length below which Newton's method may fail at a resonance: it does at kinks, and the curve has to go on."""


def hidden_resonance(balance: HarmonicBalance, current: CurvePoint, following: CurvePoint, middle: bool) -> float | None:
    """The fraction of the step from one point to the next where it passes over a resonance, None where it does not.

    middle: the balance is solved in the middle of the step too. Where slip begins beside a resonance, the peak is a corner whose
    frequency is not known before.

    Motion and ω in between are cubics through both ends and their tangents. Where ω turns, the step is near a fold and short;
    where nothing slips at both ends it does not turn.
    """
    start, end = current.point.omega, following.point.omega
    inside = _inside(balance, current, following)
    if not inside and not middle:
        return None
    step = following.length
    stretch = step * following.metric.length(current.tangent.motion, current.tangent.parameter)
    slopes = step * current.tangent.parameter, stretch * following.tangent.parameter
    controls = start, start + slopes[0] / 3.0, end - slopes[1] / 3.0, end
    way = 1.0 if end > start else -1.0
    if not all(way * (after - before) > 0.0 for before, after in itertools.pairwise(controls)):
        if current.active or following.active:
            return None
        controls = start, (2.0 * start + end) / 3.0, (start + 2.0 * end) / 3.0, end
    rows, level, tangents = balance.rows, current.point.level, (current.tangent, following.tangent)
    ends = current.evaluation, following.evaluation
    motions = _knots(ends[0].w, step * tangents[0].motion, ends[1].w, stretch * tangents[1].motion)
    forces = _knots(ends[0].point.forces, step * tangents[0].forces, ends[1].point.forces, stretch * tangents[1].forces)
    carried = [balance.carried_forces(each) for each in ends]
    places: list[tuple[float, float, Resonances | None, int]] = [
        (_fraction(controls, omega), omega, one, k) for omega, one, k in (inside if end > start else inside[::-1])
    ]
    if middle:
        places.append((0.5, float(hermite_shares(0.5) @ np.array([start, slopes[0], end, slopes[1]])), None, 0))
    for fraction, omega, resonances, k in places:
        shares = hermite_shares(fraction)
        expected, applied = (shares @ motions).reshape(ends[0].w.shape), (shares @ forces).reshape(carried[0].shape)
        sizes = _sizes(expected, rows)
        if resonances is not None:
            part = resonances.columns(k)
            drive = (1.0 - fraction) * carried[0][:, part] + fraction * carried[1][:, part]
            if (resonances.motion(k, level, applied[:, part], drive) <= NEGLIGIBLE * sizes).all():
                continue
        correction = correct(balance, Point(applied, omega, level), fixed("omega", omega), 12, 6)
        if not correction.converged:
            if following.length >= SHORT:
                return fraction
            continue
        found = correction.evaluation.w
        if (_sizes(found - expected, rows) > TOLERANCE * np.maximum(sizes, _sizes(found, rows))).any():
            return fraction
    return None


def _inside(balance: HarmonicBalance, current: CurvePoint, following: CurvePoint) -> list[tuple[float, Resonances, int]]:
    """The resonances inside a step that is longer than their half-width: ω, ascending, where they are known from, and number."""
    low, high = sorted((current.point.omega, following.point.omega))
    limits = balance.linear.resonances
    known = {id(one): one for one in (limits, *(limits.where_stuck(point.evaluation.unknown) for point in (current, following)))}
    found = [(float(one.omega[k]), one, k) for one in known.values() if one is not None for k in one.between(low, high)]
    if not found:
        return []
    found.sort(key=lambda each: each[0])
    kept: list[tuple[float, Resonances, int]] = []
    for omega, one, k in found:
        nearer = omega - SAME * one.width[k]
        if not any(w > nearer and other.harmonic[m] == one.harmonic[k] for w, other, m in kept[-4:]):
            kept.append((omega, one, k))
    return kept


def _fraction(controls: tuple[float, float, float, float], omega: float) -> float:
    """Where the monotonic cubic with these control points passes a value, by Newton's method inside a bracket."""
    a, b, c, d = controls
    low, high, fraction = 0.0, 1.0, (omega - a) / (d - a)
    for _ in range(60):
        rest = 1.0 - fraction
        beyond = rest**3 * a + 3.0 * rest**2 * fraction * b + 3.0 * rest * fraction**2 * c + fraction**3 * d - omega
        if abs(beyond) <= 1e-6 * abs(d - a):
            break
        low, high = (low, fraction) if (beyond > 0.0) == (d > a) else (fraction, high)
        rate = 3.0 * (rest**2 * (b - a) + 2.0 * rest * fraction * (c - b) + fraction**2 * (d - c))
        fraction -= beyond / rate if rate else 0.0
        if not low < fraction < high:
            fraction = 0.5 * (low + high)
    return fraction


def _knots(*values: Array) -> Array:
    """Values and slopes at both ends, as `hermite_shares` counts them (4, ...), each flat."""
    return np.array([each.ravel() for each in values])


def _sizes(w: Array, rows: int) -> Array:
    """Dynamic motion of the contacts together and of each output, (1 + outputs,)."""
    moving = w[:, 1:]
    sizes = contacts_and_outputs(np.einsum("ri,ri->r", moving, moving), rows)
    return np.asarray(np.maximum(sizes, ROUNDING * sizes.max()))
