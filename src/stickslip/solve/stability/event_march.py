"""The motion of sliders and springs over a period, exact from event to event, with its derivative by the state at the beginning.

Between two events every slider sticks, slips or is open and every normal spring is closed or open: the motion obeys a linear
equation with constant coefficients, x' = A x + (0, a + p(t)), x = (q, v). With its particular solution for the harmonic load p
the rest goes as exp(A t). It is followed in steps of a share of its fastest period, by powers of exp(A h), until a guard turns
negative; the event is a root of the guard's Taylor polynomial within the step. So no step has an error of its own, and the size
of kt limits the number of steps only.

Forces are continuous where a slider yields, sticks or lifts off, so the derivative passes such events as it is, and only what a
slider remembers is new. A slider that lands and sticks remembers where it landed: y = −kt u, δy = −kt (δu − u̇ δz/ż).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.contact.point import ContactTable, contact_table
from stickslip.model.contact.protocol import OPEN, STICK
from stickslip.model.problem import Problem
from stickslip.model.problem.systems import lasting_stiffness
from stickslip.support.checks import Array, Index, InputError

STEP = 0.2
"""Step, in radians of the fastest mode of a contact state."""

TERMS = 16
"""Of Taylor's series over one step, whose remainder 0.2¹⁶/16! is below rounding."""

CHUNK = 1024
"""Most steps that are computed at once."""

MOST_STEPS, MOST_EVENTS = 200_000, 400
"""In a period; beyond them it is given up."""

ROUNDING = 1e-13
"""Of a guard, relative to what it is the difference of; of the instant of an event, relative to the step."""

TOUCHED = 1e-9
"""Share of the limit within which a slider is at it when the period begins."""


class LostMotionError(Exception):
    """A period has too many events or steps."""


@dataclass(frozen=True, eq=False)
class Coordinates:
    """M-orthonormal shapes (n, k), in which the march goes: q = shapes a; M = 1, damping (k, k), stiffness (k, k) without
    contacts, rows B (rows, k), weight = shapesᵀM (k, n), a = weight q."""

    shapes: Array
    weight: Array
    damping: Array
    stiffness: Array
    rows: Array

    @property
    def size(self) -> int:
        return int(self.shapes.shape[1])


def coordinates(problem: Problem, highest: float, most: int, fastest: float = np.inf) -> Coordinates | None:
    """Modes of the stuck structure up to `highest` [rad/s] and the static shapes of the contact rows, with their mass and
    damping. None where they are more than `most`, or one is faster than `fastest` [rad/s], as of rows without mass.

    The static shapes move with the contacts in whatever state they are; modes of the stuck structure alone lose the motion in
    slip where the stuck contact is stiff.
    """
    M, B, lasting = problem.structure.M, problem.B, lasting_stiffness(problem)
    if lasting is None:
        return None
    stuck = problem.stuck_stiffness + lasting
    squares, modes = linalg.eigh(M, stuck)  # 1/ω², with φᵀK'φ = 1
    wanted = squares * highest**2 >= 1.0
    if not np.all(wanted):
        static, kept = np.linalg.solve(stuck, B.T), modes[:, wanted]
        rest = static - kept @ (kept.T @ B.T)
        # Orthogonal to the modes kept; what rounding left of shapes that they hold goes.
        energies, turned = np.linalg.eigh(B @ rest)
        own = energies > len(M) * np.finfo(float).eps * np.abs(B @ static).max(initial=0.0)
        rest = rest @ (turned[:, own] / np.sqrt(energies[own]))
        light, turned = np.linalg.eigh(rest.T @ M @ rest)
        squares, modes = np.concatenate([squares[wanted], light]), np.hstack([kept, rest @ turned])
    if squares.size > most or not np.all(squares > fastest**-2):
        return None
    shapes = modes / np.sqrt(squares)
    K = problem.structure.K + lasting
    return Coordinates(shapes, shapes.T @ M, shapes.T @ problem.C @ shapes, shapes.T @ K @ shapes, B @ shapes)


class State(NamedTuple):
    """x = (a, v) (2k,) and the intercept y = T − kt u of every slider (elements,) [N]."""

    motion: Array
    intercept: Array


@dataclass(eq=False)
class Passage:
    """A marched period: the state at its end; derivative (2k + elements, same) of the state by that at the beginning, None where
    it was not asked for; moved: which sliders slip or open; path (samples, k): the motion at the ends of equal parts."""

    end: State
    derivative: Array | None
    moved: NDArray[np.bool_]
    path: Array


class Guard(NamedTuple):
    """What ends a contact state when it turns negative: slider or normal spring, and what the slider does next;
    `NORMAL` for a normal spring, `BEND` where the limit bends."""

    element: int
    next: int


NORMAL, BEND = 100, 101


class ContactState:
    """All contacts in one state: sliders STICK, +1, −1 or OPEN, normal springs closed or open, bends of limits passed or not."""

    def __init__(self, march: "EventMarch", sliders: Index, closed: NDArray[np.bool_], passed: Index) -> None:
        self.march, self.sliders, self.closed, self.passed = march, sliders, closed, passed
        table, rows = march.table, march.coordinates.rows
        self.slope, self.constant = march.limits(closed, passed)
        stick, slips = sliders == STICK, (sliders != STICK) & (sliders != OPEN)
        # Forces of the rows by their motion, and what of them is constant but for the intercepts.
        springs, self.row_constant = np.zeros((len(rows), len(rows))), np.zeros(len(rows))
        np.add.at(springs, (march.row[stick], march.row[stick]), table.stiffness[stick])
        side = sliders[slips].astype(float)
        np.add.at(springs, (march.row[slips], march.loading[slips]), side * self.slope[slips])
        np.add.at(self.row_constant, march.row[slips], side * self.constant[slips])
        np.add.at(springs, (march.normal[closed], march.normal[closed]), table.normal_stiffness[closed])
        np.add.at(self.row_constant, march.normal[closed], table.normal_constant[closed])
        k = march.coordinates.size
        self.A = np.zeros((2 * k, 2 * k))
        self.A[:k, k:] = np.eye(k)
        self.A[k:, :k] = -(march.coordinates.stiffness + rows.T @ springs @ rows)
        self.A[k:, k:] = -march.coordinates.damping
        fastest = float(np.abs(linalg.eigvals(self.A)).max(initial=0.0))
        self.step = STEP / max(fastest, march.of_load)
        self._guards()

    def _guards(self) -> None:
        """Guards are by_motion @ w + by_rate @ ẇ + constant + by_intercept y, kept as rows over x."""
        march, table = self.march, self.march.table
        count, rows = table.stiffness.size, len(march.coordinates.rows)
        motion, rate, constants, intercepts = list[Array](), list[Array](), list[float](), list[Array]()
        self.guards: list[Guard] = []

        def add(guard: Guard, by_motion: dict[int, float], by_rate: dict[int, float], constant: float, y: float = 0.0) -> None:
            one, two, three = np.zeros(rows), np.zeros(rows), np.zeros(count)
            for r, value in by_motion.items():
                one[r] += value
            for r, value in by_rate.items():
                two[r] += value
            if y:
                three[guard.element] = y
            motion.append(one)
            rate.append(two)
            constants.append(constant)
            intercepts.append(three)
            self.guards.append(guard)

        for e, state in enumerate(self.sliders):
            r, n, kt = int(march.row[e]), int(march.loading[e]), float(table.stiffness[e])
            slope, constant = float(self.slope[e]), float(self.constant[e])
            limit = {n: slope} if slope else {}
            if state == STICK:
                for side in (1, -1):
                    traction = {r: -side * kt}
                    add(Guard(e, side), limit | traction if n != r else traction, {}, constant, -float(side))
            elif state != OPEN:
                side = int(state)
                add(Guard(e, STICK), {}, {r: side * kt} | ({n: -slope} if slope else {}), 0.0)
            for k in range(table.bend_first[e], table.bend_first[e + 1]):
                line, start = march.line(e, self.closed)
                sign = 1.0 if k - table.bend_first[e] < self.passed[e] else -1.0
                add(Guard(e, BEND), {n: sign * line} if line else {}, {}, sign * (start - float(table.bend[k])))
        for i, closed in enumerate(self.closed):
            sign = 1.0 if closed else -1.0
            stiffness, constant = float(table.normal_stiffness[i]), float(table.normal_constant[i])
            add(Guard(i, NORMAL), {int(march.normal[i]): sign * stiffness}, {}, sign * constant)
        by_motion, by_rate = (np.array(parts).reshape(len(self.guards), rows) for parts in (motion, rate))
        self.by_x = np.hstack([by_motion @ march.coordinates.rows, by_rate @ march.coordinates.rows])
        self.by_y = np.array(intercepts).reshape(len(self.guards), count)
        self.guard_constant = np.array(constants)
        self.sizes = np.abs(by_motion), np.abs(by_rate)

    def rounding(self) -> Array:
        """What of each guard is rounding, (guards,)."""
        by_motion, by_rate = self.sizes
        sizes = by_motion @ self.march.motions + by_rate @ self.march.rates + np.abs(self.guard_constant)
        return np.asarray(ROUNDING * sizes)

    @cached_property
    def powers(self) -> list[tuple[Array, Array]]:
        """exp(A h j) and its integral onto constant accelerations (2k, k), for j = 1, 2, 4, ..., filled as they are needed."""
        k = self.march.coordinates.size
        whole = np.zeros((3 * k, 3 * k))
        whole[: 2 * k, : 2 * k] = self.A
        whole[k : 2 * k, 2 * k :] = np.eye(k)
        first = linalg.expm(self.step * whole)
        return [(first[: 2 * k, : 2 * k], first[: 2 * k, 2 * k :])]

    def power(self, j: int) -> tuple[Array, Array]:
        """Those of 2^j steps."""
        while len(self.powers) <= j:
            E, F = self.powers[-1]
            self.powers.append((E @ E, E @ F + F))
        return self.powers[j]

    def constant_acceleration(self, intercept: Array) -> Array:
        """Of the static load, the constant parts of the row forces and the intercepts of sticking sliders, (k,)."""
        held = self.march.coordinates.rows.T @ self.row_constant
        return np.asarray(self.march.static - held - self.by_intercept(intercept))

    def by_intercept(self, intercept: Array) -> Array:
        """What sticking sliders carry of their intercepts (elements, ...), on the coordinates."""
        stick = self.sliders == STICK
        forces = np.zeros((len(self.march.coordinates.rows), *intercept.shape[1:]))
        np.add.at(forces, self.march.row[stick], intercept[stick])
        return self.march.coordinates.rows.T @ forces

    def steps(self, x: Array, acceleration: Array, count: int) -> Array:
        """x after 1, ..., count steps, (2k, count), without harmonic loads."""
        found = np.empty((x.size, count))
        E, F = self.power(0)
        found[:, 0] = E @ x + F @ acceleration
        done, j = 1, 0
        while done < count:
            E, F = self.power(j)
            more = min(done, count - done)
            found[:, done : done + more] = E @ found[:, :more] + (F @ acceleration)[:, None]
            done, j = done + more, j + 1
        return found

    def series(self, x: Array, acceleration: Array) -> Iterator[Array]:
        """Taylor's terms of exp(A t) x and the part of a constant acceleration, (2k, ...) each, for t¹, t², ..."""
        k, term = self.march.coordinates.size, x
        for j in range(1, TERMS):
            term = self.A @ term
            if j == 1:
                term[k:] += acceleration
            term = term / j
            yield term


class EventMarch:
    """Periods of one problem at constant speed. of_load: rad/s that no harmonic of its load exceeds."""

    def __init__(self, problem: Problem, highest: float, most: int, of_load: float) -> None:
        found = coordinates(problem, highest, most, of_load * STEP * MOST_STEPS / (2.0 * np.pi))
        if found is None:
            raise InputError(f"The motion must have at most {most} coordinates with mass to be followed from event to event.")
        self.problem, self.coordinates, self.table = problem, found, contact_table(problem.contacts)
        table: ContactTable = self.table
        self.row = np.repeat(np.arange(table.rows), np.diff(table.friction_first))
        self.loading = np.where(table.loading_row[self.row] >= 0, table.loading_row[self.row], self.row)
        self.normal = np.repeat(table.normal_row, np.diff(table.normal_first))
        self.static = self.coordinates.shapes.T @ problem.static_load
        self.of_load, self.known = of_load, dict[tuple[bytes, bytes, bytes], ContactState]()
        self.motions = self.rates = np.zeros(table.rows)

    @property
    def dropped(self) -> int:
        """How many coordinates the problem has more."""
        return self.problem.structure.size - self.coordinates.size

    def at(self, omega: float, level: float, motions: Array) -> "EventMarch":
        """Set frequency [rad/s], force level and the sizes of the rows' motion (rows,) [m]."""
        highest = max(harmonic for force in self.problem.forces for harmonic in force.amplitudes)
        load = self.coordinates.shapes.T @ self.problem.load(highest, level, omega)
        self.omega, self.period = omega, 2.0 * np.pi / omega
        self.harmonics = [h for h in range(1, highest + 1) if np.any(load[:, 2 * h - 1 : 2 * h + 1])]
        self.loads = [load[:, 2 * h - 1] - 1j * load[:, 2 * h] for h in self.harmonics]
        self.motions, self.rates = motions, omega * motions
        self.forced: dict[int, list[NDArray[np.complex128]]] = {}
        return self

    def line(self, e: int, closed: NDArray[np.bool_]) -> tuple[float, float]:
        """Slope and constant over z of the limit of slider e without its bends."""
        loads = slice(self.table.load_first[e], self.table.load_last[e])
        on = closed[loads]
        mu = float(self.table.friction[e])
        return (
            mu * float(self.table.normal_stiffness[loads] @ on),
            mu * float(self.table.normal_constant[loads] @ on) + float(self.table.constant_limit[e]),
        )

    def limits(self, closed: NDArray[np.bool_], passed: Index) -> tuple[Array, Array]:
        """L = slope z + constant of every slider, (elements,) each."""
        slopes, constants = np.zeros(self.row.size), np.zeros(self.row.size)
        for e in range(self.row.size):
            slopes[e], constants[e] = self.line(e, closed)
            first = self.table.bend_first[e]
            change = self.table.change[first : first + passed[e]]
            bend = self.table.bend[first : first + passed[e]]
            constants[e] += change.sum() * constants[e] - change @ bend
            slopes[e] *= 1.0 + change.sum()
        return slopes, constants

    def state(self, sliders: Index, closed: NDArray[np.bool_], passed: Index) -> ContactState:
        """A contact state, made once."""
        key = sliders.tobytes(), closed.tobytes(), passed.tobytes()
        if key not in self.known:
            self.known[key] = ContactState(self, sliders.copy(), closed.copy(), passed.copy())
        return self.known[key]

    def particular(self, state: ContactState) -> list[NDArray[np.complex128]]:
        """x_p of each harmonic in a contact state, (2k,): (i h ω − A)⁻¹ (0, load)."""
        if id(state) not in self.forced:
            k = self.coordinates.size
            nothing = np.zeros(k)
            self.forced[id(state)] = [
                np.linalg.solve(1j * h * self.omega * np.eye(2 * k) - state.A, np.concatenate([nothing, load])).astype(complex)
                for h, load in zip(self.harmonics, self.loads, strict=True)
            ]
        return self.forced[id(state)]

    def forced_motion(self, state: ContactState, t: Array) -> Array:
        """x_p(t), (2k, ...)."""
        parts = self.particular(state)
        phases = (np.exp(1j * h * self.omega * t) for h in self.harmonics)
        found = np.zeros((2 * self.coordinates.size, *t.shape))
        for part, phase in zip(parts, phases, strict=True):
            found += np.real(np.multiply.outer(part, phase))
        return found

    def contact_motion(self, x: Array) -> tuple[Array, Array]:
        """w and ẇ of the contact rows, (rows, ...)."""
        k = self.coordinates.size
        return self.coordinates.rows @ x[:k], self.coordinates.rows @ x[k:]

    def entry(self, begin: State) -> tuple[ContactState, Array]:
        """The contact state in which a period begins, and the intercepts (elements,) that limits allow."""
        table, y = self.table, begin.intercept.copy()
        u, v = self.contact_motion(begin.motion)
        closed = table.normal_stiffness * u[self.normal] + table.normal_constant > 0.0
        passed = np.zeros(self.row.size, dtype=np.int64)
        for e in range(self.row.size):
            slope, constant = self.line(e, closed)
            bends = table.bend[table.bend_first[e] : table.bend_first[e + 1]]
            passed[e] = np.count_nonzero(slope * u[self.loading[e]] + constant > bends)
        slopes, constants = self.limits(closed, passed)
        limit, rate = slopes * u[self.loading] + constants, slopes * v[self.loading]
        spring = table.stiffness * u[self.row]
        traction, sliders = y + spring, np.full(self.row.size, STICK, dtype=np.int64)
        at_limit = np.abs(traction) >= (1.0 - TOUCHED) * limit
        side = np.where(traction >= 0.0, 1, -1)
        sliders[at_limit & (side * table.stiffness * v[self.row] > rate)] = 1
        sliders *= side
        y[at_limit] = (side * limit - spring)[at_limit]
        none = limit <= 0.0
        sliders[none], y[none] = OPEN, -spring[none]
        return self.state(sliders, closed, passed), y

    def travel(self, begin: State, derivative: bool = False, samples: int = 1) -> Passage:
        """The state a period later; samples: parts of the period at whose ends the motion is wanted."""
        state, y = self.entry(begin)
        x, t, events = begin.motion, 0.0, 0
        tangent = _Tangent(self, state) if derivative else None
        moved, self._steps_left = state.sliders != STICK, MOST_STEPS
        path = list[Array]()
        while len(path) < samples:
            x, span, guard = self._until_event(state, y, x, t, (len(path) + 1) / samples * self.period)
            if tangent:
                tangent.go(state, span)
            t += span
            if guard is None:
                path.append(x[: self.coordinates.size])
                continue
            events += 1
            if events > MOST_EVENTS:
                raise LostMotionError
            state, y = self._passed(state, guard, x, y, tangent)
            moved |= state.sliders != STICK
        # Intercepts of slipping and open sliders follow from the motion.
        u, side = self.contact_motion(x)[0], np.where((state.sliders == STICK) | (state.sliders == OPEN), 0, state.sliders)
        slaved = side * (state.slope * u[self.loading] + state.constant) - self.table.stiffness * u[self.row]
        end = State(x, np.where(state.sliders == STICK, y, slaved))
        return Passage(end, None if tangent is None else tangent.whole(state), moved, np.array(path))

    def _until_event(self, state: ContactState, y: Array, x: Array, t: float, end: float) -> tuple[Array, float, Guard | None]:
        """x at the next event or at a given instant, the time until then, and the guard that turned negative."""
        left, elapsed, count = end - t, 0.0, 32
        acceleration, constant, rounding = state.constant_acceleration(y), state.guard_constant + state.by_y @ y, state.rounding()
        rest, guard = x - self.forced_motion(state, np.array(t)), None
        while guard is None and left - elapsed > ROUNDING * self.period:
            span = min(state.step, left - elapsed)
            if span == state.step:
                count = min(2 * count, CHUNK, int((left - elapsed) / state.step))
                self._steps_left -= count
                if self._steps_left < 0:
                    raise LostMotionError
                path = state.steps(rest, acceleration, count)
                times = t + elapsed + state.step * np.arange(1.0, count + 1.0)
                values = state.by_x @ (path + self.forced_motion(state, times)) + constant[:, None]
                broken = np.flatnonzero(np.any(values < -rounding[:, None], axis=0))
                sound = int(broken[0]) if broken.size else count
                if sound:
                    rest, elapsed = path[:, sound - 1], elapsed + sound * state.step
                if not broken.size:
                    continue
            share, guard, rest = self._within(state, rest, t + elapsed, span, acceleration, constant)
            elapsed += share
        return rest + self.forced_motion(state, np.array(t + elapsed)), elapsed, guard

    def _within(
        self, state: ContactState, rest: Array, t: float, span: float, acceleration: Array, constant: Array
    ) -> tuple[float, Guard | None, Array]:
        """How far a step is gone until the first guard turns negative, that guard, and x without its harmonic part there."""
        terms = [rest, *state.series(rest, acceleration)]
        moving = np.array([state.by_x @ term for term in terms])
        for h, part in zip(self.harmonics, self.particular(state), strict=True):
            turning = (state.by_x @ part) * np.exp(1j * h * self.omega * t)
            for j in range(TERMS):
                moving[j] += turning.real
                turning = turning * (1j * h * self.omega / (j + 1))
        moving[0] += constant
        ends, rounding = span ** np.arange(TERMS) @ moving, state.rounding()
        broken = np.flatnonzero(ends < -rounding)
        share, guard = span, None
        for g in broken:
            root = _root(moving[:, g], span, rounding[g])
            if root < share or guard is None:
                share, guard = root, state.guards[g]
        where = rest.copy()
        for j, term in enumerate(terms[1:], 1):
            where += share**j * term
        return share, guard, where

    def _passed(
        self, state: ContactState, guard: Guard, x: Array, y: Array, tangent: "_Tangent | None"
    ) -> tuple[ContactState, Array]:
        """The contact state and the intercepts behind an event."""
        sliders, closed, passed, y = state.sliders.copy(), state.closed.copy(), state.passed.copy(), y.copy()
        u, v = self.contact_motion(x)
        if guard.next == NORMAL:
            closed[guard.element] = not closed[guard.element]
            slopes, _ = self.limits(closed, passed)
            loads = (self.table.load_first <= guard.element) & (guard.element < self.table.load_last)
            for e in np.flatnonzero(loads).tolist():
                r, n, kt = self.row[e], self.loading[e], self.table.stiffness[e]
                on = (
                    bool(np.any(closed[self.table.load_first[e] : self.table.load_last[e]])) or self.table.constant_limit[e] > 0.0
                )
                if not on:
                    sliders[e] = OPEN
                elif state.sliders[e] == OPEN:
                    if kt * abs(v[r]) > slopes[e] * v[n]:
                        sliders[e] = int(np.sign(v[r]))
                    else:
                        sliders[e], y[e] = STICK, -kt * u[r]
                        if tangent:
                            tangent.land(e, v[r] / v[n] if v[n] != 0.0 else 0.0)
        elif guard.next == BEND:
            e = guard.element
            first = self.table.bend_first[e]
            line, start = self.line(e, closed)
            passed[e] = np.count_nonzero(
                line * u[self.loading[e]] + start > self.table.bend[first : self.table.bend_first[e + 1]]
            )
            if passed[e] == state.passed[e]:  # on the bend to rounding: across it, in the direction of the load
                passed[e] += 1 if line * v[self.loading[e]] > 0.0 else -1
        else:
            e = guard.element
            if guard.next == STICK:
                side = float(sliders[e])
                limit = state.slope[e] * u[self.loading[e]] + state.constant[e]
                y[e] = side * limit - self.table.stiffness[e] * u[self.row[e]]
                if tangent:
                    tangent.stick(state, e)
            sliders[e] = guard.next
        return self.state(sliders, closed, passed), y


class _Tangent:
    """The derivative of the motion (2k, w) and of the intercepts (elements, w) by the state at the beginning of the period."""

    def __init__(self, march: EventMarch, state: ContactState) -> None:
        self.march, size, count = march, 2 * march.coordinates.size, march.row.size
        self.motion, self.intercept = np.eye(size, size + count), np.zeros((count, size + count))
        stick = np.flatnonzero(state.sliders == STICK)
        self.intercept[stick, size + stick] = 1.0

    def go(self, state: ContactState, span: float) -> None:
        """Carry it over a time in one contact state."""
        acceleration = -state.by_intercept(self.intercept)
        count = int(span / state.step)
        for j in range(count.bit_length()):
            if count >> j & 1:
                E, F = state.power(j)
                self.motion = E @ self.motion + F @ acceleration
        rest, power, motion = span - count * state.step, 1.0, self.motion.copy()
        for term in state.series(self.motion, acceleration):
            power *= rest
            motion += power * term
        self.motion = motion

    def slaved(self, state: ContactState, e: int) -> Array:
        """δy of a slider that slips or is open, s δL − kt δu."""
        u, _ = self.march.contact_motion(self.motion)
        found = -self.march.table.stiffness[e] * u[self.march.row[e]]
        if state.sliders[e] != OPEN:
            found = found + float(state.sliders[e]) * state.slope[e] * u[self.march.loading[e]]
        return np.asarray(found)

    def stick(self, state: ContactState, e: int) -> None:
        """Slider e sticks where it slipped."""
        self.intercept[e] = self.slaved(state, e)

    def land(self, e: int, ratio: float) -> None:
        """Slider e lands and sticks; ratio: u̇/ż, as the disturbance moves the instant by −δz/ż."""
        u, _ = self.march.contact_motion(self.motion)
        kt = self.march.table.stiffness[e]
        self.intercept[e] = -kt * (u[self.march.row[e]] - ratio * u[self.march.loading[e]])

    def whole(self, state: ContactState) -> Array:
        """At the end of the period, (2k + elements, 2k + elements)."""
        for e in np.flatnonzero(state.sliders != STICK).tolist():
            self.intercept[e] = self.slaved(state, e)
        return np.vstack([self.motion, self.intercept])


def _root(polynomial: Array, span: float, rounding: float) -> float:
    """Where a polynomial in t (terms,) that is negative at `span` turns negative: 0 where it begins there and falls.

    Behind an event a guard begins at zero but for rounding, and may rise before it falls: that root is taken out.
    """
    if polynomial[0] <= rounding:
        polynomial = polynomial[1:]
        if polynomial[0] <= 0.0:
            return 0.0
    falling = polynomial[::-1].tolist()
    low, high, t = 0.0, span, 0.5 * span
    while True:
        value = slope = 0.0
        for coefficient in falling:
            slope = slope * t + value
            value = value * t + coefficient
        low, high = (t, high) if value > 0.0 else (low, t)
        # Newton's method, kept between points of either sign.
        following = t - value / slope if slope != 0.0 else low
        following = following if low < following < high else 0.5 * (low + high)
        if abs(following - t) <= ROUNDING * span or high - low <= ROUNDING * span:
            return following
        t = following
