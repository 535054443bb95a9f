"""What the kernels of a contact law read and fill: one contact over one step of a march, or over a whole period.

A law that is a table of springs and sliders needs none. Any other law has one kernel in its own file,

    step(data: ContactData, motion: StepMotion, forces: StepForces) -> float        friction work of the states in the step, J

which takes the contact from one instant to the next. Its states x are those of its friction elements, so that every march has a
place for them: T [N] of an element with a spring kt, and any number that is 0 where nothing presses of one without (kt = 0).

    x after a step   follows from x before it, the travel, the limits before and after, and the time that passes
    T of a direction is the sum of the states of its springs and of `direct`, which follows from what is there after the step

From the step follow harmonic balance, time integration, damper cycles and stability, with the derivatives that it fills in. A
law whose period has a closed form may bring that as well (`stickslip.model.contact.dahl`),

    period(data: ContactData, motion: PeriodMotion, forces: PeriodForces) -> int    HELD, STATIC, SLIPPING or NOT_PERIODIC

and a law that can stick has to (`friction_disc.py`): its steady force depends on the start. Structures, harmonics
and time integration know neither law nor kernel. The limit L = μ Σ N + L0 is that of the first friction element.

The kernels of a law by the kind of its contacts: a number that follows from the name of its `step`, and stands in the tables.

A law need not be listed here, nor lie in this package: `prepare` of `march.py` says which kernels its number stands for.
A function handed to a kernel would become part of its signature instead, which is compiled anew in every process.

The period of one friction element, by composition of clamp functions, is exact.

The Jenkins step T_n = clamp(T_{n−1} + kt(u_n − u_{n−1}), −L_n, +L_n) in the intercept y = T − kt u (y = −kt × slider
position) is a pure clamp, y_n = clamp(y_{n−1}, −L_n − kt u_n, L_n − kt u_n). Clamps compose to a clamp, so the period map is a
projection onto an interval [LO, HI]: LO = HI means a unique force; LO < HI that the element never slips in the steady
period and that any y in [LO, HI] is a solution, the non-uniqueness of friction forces.

An element that is open at one sample and closed at the next lands between them. Its slider begins where it lands; from the sample
itself the force would be of first order in the samples.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import float64, int64, typeof

from stickslip.model.contact.law import SLIDERS, Law
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import inlined, inner, kernel
from stickslip.support.kernels.decorators import number_of, numbered
from stickslip.support.kernels.views import view, view_of

OFFSET, RATIO, MEAN = 0, 1, 2
"""Codes of the start rules, as `stickslip.model.contact.point` gives them."""

STICK, SLIP_UP, SLIP_DOWN, OPEN = 0, 1, -1, 2
"""What an element does at a sample; the sign of a slip is that of the traction."""

SLIP = SLIP_UP
"""Slip in any direction, where the traction has no sign or none is asked for."""

HELD, STATIC, SLIPPING = 0, 1, 2
"""How much of a row is unknown: nothing (λ known in advance), its harmonic 0, or all harmonics."""


@kernel
def landing_shares(z: Array, limit: Array, slope: Array, landing: Array) -> None:
    """Fill, for each sample where an element is open, the share of the step to the next at which it lands, 0 where it does not:
    z moves straight between samples [m], and the limit L [N] grows from 0 with dL/dz = slope [N/m] of the next; all (Nt,)."""
    open_ = 0
    for n in range(limit.size):
        landing[n] = 0.0
        open_ += limit[n] <= 0.0
    if open_ == 0:
        return
    for n in range(limit.size):
        m = n + 1 if n + 1 < limit.size else 0
        if limit[n] <= 0.0 < limit[m] and slope[m] > 0.0 and z[m] > z[n]:
            landing[n] = max(1.0 - limit[m] / (slope[m] * (z[m] - z[n])), 0.0)


@inlined
def carried(ku: Array, landing: Array, n: int) -> float:
    """kt u at a sample, or where an element that is open there lands before the next."""
    m = n + 1 if n + 1 < ku.size else 0
    return ku[n] + landing[n] * (ku[m] - ku[n])  # type: ignore[no-any-return]


@inner
def _common(ku: Array, limit: Array) -> tuple[float, float]:
    """The y that all samples allow, from the largest −L − ku to the least L − ku; an empty interval where it is open at one.

    Two of each, taken in turn, since a processor need not wait for one to go on with the other.
    """
    low, high, lower, higher, least = -np.inf, np.inf, -np.inf, np.inf, np.inf
    for n in range(0, ku.size - 1, 2):
        low, high = max(low, -limit[n] - ku[n]), min(high, limit[n] - ku[n])
        lower, higher = max(lower, -limit[n + 1] - ku[n + 1]), min(higher, limit[n + 1] - ku[n + 1])
        least = min(least, min(limit[n], limit[n + 1]))
    n = ku.size - 1
    low, high = max(max(low, lower), -limit[n] - ku[n]), min(min(high, higher), limit[n] - ku[n])
    return (low, high) if min(least, limit[n]) > 0.0 else (np.inf, -np.inf)


@kernel
def stick_interval(ku: Array, limit: Array, landing: Array) -> tuple[float, float]:
    """[LO, HI] of the intercept y over samples 0..Nt−1 in this order. ku = kt u [N], limit L [N], `landing_shares`, (Nt,)."""
    low, high = _common(ku, limit)
    if low <= high:
        return low, high
    low, high = -np.inf, np.inf
    for n in range(ku.size):
        place = carried(ku, landing, n)
        bottom, top = -limit[n] - place, limit[n] - place
        low = min(max(low, bottom), top)
        high = min(max(high, bottom), top)
    return low, high


@kernel
def start_intercept(kind: int, value: float, kt: float, ku: Array, limit: Array, mean: float) -> float:
    """y of the start rule, before it is clipped to [LO, HI]: offset −kt s, ratio m L_last − kt u_last, mean T̄ − kt ū."""
    if kind == OFFSET:
        return -kt * value
    if kind == RATIO:
        return float(value * limit[-1] - ku[-1])
    return value - mean


@kernel
def friction_period(
    kind: int, value: float, kt: float, ku: Array, limit: Array, landing: Array, mean: float, y: Array, event: Index
) -> tuple[int, int, float]:
    """Fill the steady period of intercepts y and events (Nt,), and say what it depends on: (state, sample, factor).

    state HELD: y is the start offset, a constant. STATIC: y = factor L_sample − kt u_sample, constant in time (sample = −1:
    y = value − kt ū). SLIPPING: y follows the last event. landing: `landing_shares`; mean: kt times that of u.
    """
    samples = ku.size
    low, high = stick_interval(ku, limit, landing)
    wanted = start_intercept(kind, value, kt, ku, limit, mean)
    y0 = min(max(wanted, low), high)
    events = 0
    for n in range(samples):
        y[n], event[n] = y0, STICK
        events += (limit[n] <= 0.0) | (y0 > limit[n] - ku[n]) | (y0 < -limit[n] - ku[n])
    previous = y0
    for n in range(samples if events > 0 else 0):
        bottom, top = -limit[n] - ku[n], limit[n] - ku[n]
        event[n] = STICK
        if limit[n] <= 0.0:
            event[n] = OPEN
        elif previous > top:
            event[n] = SLIP_UP
        elif previous < bottom:
            event[n] = SLIP_DOWN
        if event[n] == OPEN:
            y[n], previous = -ku[n], -carried(ku, landing, n)
            continue
        if event[n] != STICK:
            previous = min(max(previous, bottom), top)
        y[n] = previous
    if events > 0:
        return SLIPPING, 0, 0.0
    if low < high and low <= wanted <= high:
        if kind == OFFSET:
            return HELD, 0, 0.0
        if kind == RATIO:
            return STATIC, samples - 1, value
        return STATIC, -1, 0.0
    sign = 1.0 if wanted > y0 else -1.0
    nearest = 0
    for n in range(samples):
        if limit[n] - sign * ku[n] < limit[nearest] - sign * ku[nearest]:
            nearest = n
    return STATIC, nearest, sign


NOT_PERIODIC = -1
"""In place of a state: the law found no periodic force."""


class ContactData(NamedTuple):
    """What a contact is. kind: number of its kernels; parameter: the law's own numbers; by tangential direction (d,): kt of its
    stuck spring [N/m], 0 without one, and rule and value of its start; by friction element (k,): spring [N/m] and direction."""

    kind: int
    parameter: Array
    kt: Array
    start_kind: Index
    start_value: Array
    spring: Array
    direction: Index


class StepMotion(NamedTuple):
    """Motion of a contact in a step. state (k,): before; travel (d,): what u changes [m]; u [m] and velocity [m/s] (d,): after;
    limit0, limit: L before and after [N]; time: that the step takes [s], 0 without inertia."""

    state: Array
    travel: Array
    u: Array
    velocity: Array
    limit0: float
    limit: float
    time: float


class StepForces(NamedTuple):
    """The answer after a step, zeros before. state (k,) after it and its derivatives by the state before (k, k), the travel
    (k, d), the limits before and after (k,) and the time (k,); direct (d,) [N], the force beyond the springs, and its derivatives
    by the state after the step (d, k), by u and by the velocity (d, d) and by the limit after it (d,)."""

    state: Array
    by_state: Array
    by_travel: Array
    by_limit0: Array
    by_limit: Array
    by_time: Array
    direct: Array
    direct_by_state: Array
    direct_by_u: Array
    direct_by_velocity: Array
    direct_by_limit: Array


class PeriodMotion(NamedTuple):
    """Motion of a contact over a period of Nt samples.

    u [m] and velocity [m/s] (d, Nt); normal motion z [m], limit L [N], slope dL/dz [N/m] and `landing_shares` (Nt,); omega
    [rad/s]; E, D (Nt, 2H+1) with u = E U, velocity = omega D U and z = E Z. Without columns of E no derivatives are asked for.
    """

    u: Array
    velocity: Array
    z: Array
    limit: Array
    slope: Array
    landing: Array
    omega: float
    E: Array
    D: Array


class PeriodForces(NamedTuple):
    """The answer over a period, zeros before: y = T − kt u [N] (d, Nt); event (Nt,) STICK, OPEN or another number for slip;
    tangents (Nt, d, 3, 2H+1) = dy/d(U1, U2, Z); by_omega (d, Nt) = ∂y/∂ω at fixed harmonics; work (d,): of friction [J];
    intercept (k, Nt): of each friction element, its state − its spring times u, which of a law with springs alone is y."""

    y: Array
    event: Index
    tangents: Array
    by_omega: Array
    work: Array
    intercept: Array


@inner
def no_step(states: int, directions: int) -> StepForces:
    """Zeros to be filled."""
    return StepForces(
        np.zeros(states),
        np.zeros((states, states)),
        np.zeros((states, directions)),
        np.zeros(states),
        np.zeros(states),
        np.zeros(states),
        np.zeros(directions),
        np.zeros((directions, states)),
        np.zeros((directions, directions)),
        np.zeros((directions, directions)),
        np.zeros(directions),
    )


@inner
def clear(forces: StepForces) -> None:
    """Zeros again."""
    k, d = forces.state.size, forces.direct.size
    for i in range(k):
        forces.state[i] = forces.by_limit0[i] = forces.by_limit[i] = forces.by_time[i] = 0.0
        for j in range(k):
            forces.by_state[i, j] = 0.0
        for j in range(d):
            forces.by_travel[i, j] = forces.direct_by_state[j, i] = 0.0
    for i in range(d):
        forces.direct[i] = forces.direct_by_limit[i] = 0.0
        for j in range(d):
            forces.direct_by_u[i, j] = forces.direct_by_velocity[i, j] = 0.0


@inner
def traction(data: ContactData, forces: StepForces, d: int) -> float:
    """T of direction d after a step: the states of its springs, and what is direct."""
    total = forces.direct[d]
    for i in range(data.spring.size):
        if data.direction[i] == d and data.spring[i] > 0.0:
            total += forces.state[i]
    return float(total)


@inner
def traction_by_state(data: ContactData, forces: StepForces, d: int, i: int) -> float:
    """Derivative of T of direction d by state i after a step."""
    own = 1.0 if data.direction[i] == d and data.spring[i] > 0.0 else 0.0
    return float(own + forces.direct_by_state[d, i])


@inner
def no_forces(data: ContactData, samples: int, columns: int) -> PeriodForces:
    """Zeros to be filled for so many samples; columns = 0: without derivatives."""
    directions = data.kt.size
    return PeriodForces(
        np.zeros((directions, samples)),
        np.zeros(samples, dtype=np.int64),
        np.zeros((samples if columns else 0, directions, 3, columns)),
        np.zeros((directions, samples)),
        np.zeros(directions),
        np.zeros((data.spring.size, samples)),
    )


def _data() -> ContactData:
    line, index = np.zeros(0), np.zeros(0, dtype=np.int64)
    return ContactData(0, line, line, index, line, line, index)


def period_signature() -> Any:
    """Types of what the `period` of a law takes and returns."""
    line, table, table3, index = np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0, 0, 0)), np.zeros(0, dtype=np.int64)
    motion = PeriodMotion(table, table, line, line, line, line, 0.0, table, table)
    return int64(typeof(_data()), typeof(motion), typeof(PeriodForces(table, index, table3, table, line, table)))


def step_signature() -> Any:
    """Types of what the `step` of a law takes and returns: it is called so often that it reads its arguments where they lie."""
    line, table = np.zeros(0), np.zeros((0, 0))
    motion = StepMotion(line, line, line, line, 0.0, 0.0, 0.0)
    forces = StepForces(line, table, table, line, line, line, line, table, table, table, line)
    return float64(view_of(_data()), view_of(motion), view_of(forces))


def kind_of(law: type[Law]) -> int:
    """`SLIDERS`, or the number of the law's own kernels, the same in every process."""
    kernels = law.kernels()
    return number_of(kernels[0]) if kernels else SLIDERS


@numbered(period_signature)
def law_period(kind: int, data: ContactData, motion: PeriodMotion, forces: PeriodForces) -> int:
    """Fill the steady period of a contact; HELD, STATIC, SLIPPING or NOT_PERIODIC."""
    raise NotImplementedError


@numbered(step_signature)
def law_step(kind: int, data: ContactData, motion: StepMotion, forces: StepForces) -> float:
    """Fill the states and forces of a contact after a step; the friction work of the states in the step, J. Takes views."""
    raise NotImplementedError


@inner
def take_step(data: ContactData, motion: StepMotion, forces: StepForces) -> float:
    """`law_step` of tuples, which stay alive as long as it runs."""
    return law_step(data.kind, view(data), view(motion), view(forces))
