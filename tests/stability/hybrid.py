"""Masses on contacts integrated by SciPy from event to event: the period map by differences of initial states."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.integrate import solve_ivp

from stickslip.model.contact.law import LoadDependentFriction

STICK, UP, DOWN, OPEN = 0, 1, -1, 2
EXACT = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-15}  # events are found by it to 1e-12, differences of them to 1e-5


@dataclass
class Slider:
    """T = y + kt u stuck, ±L slipping, 0 open; L = mu max(load + kn z, 0); u, z (n,) rows, z None: constant load."""

    u: np.ndarray
    kt: float
    mu: float
    load: float
    z: np.ndarray | None = None
    kn: float = 0.0

    def normal(self, q):
        return self.load if self.z is None else self.load + self.kn * (self.z @ q)

    table: tuple = ((), ())
    """Loads and coefficients, between which the limit goes straight."""

    def limit(self, q):
        load, (over, values) = max(self.normal(q), 0.0), map(np.array, self.table)
        if over.size and load <= over[-1]:
            return float(np.interp(load, np.append(0.0, over), np.append(0.0, over * values)))
        return (values[-1] if over.size else self.mu) * load

    def limit_rate(self, q, v):
        over, values = map(np.array, self.table)
        slopes = np.concatenate([values[:1], np.diff(over * values) / np.diff(over), values[-1:]]) if over.size else [self.mu]
        slope = slopes[np.searchsorted(over, self.normal(q))]
        return 0.0 if self.z is None else slope * self.kn * (self.z @ v)


@dataclass
class Hybrid:
    """M q̈ + C q̇ + K q + contact forces = static + Re(force exp(iωt)); the state is q, v, then y of every slider."""

    M: np.ndarray
    C: np.ndarray
    K: np.ndarray
    static: np.ndarray
    force: np.ndarray
    sliders: list[Slider]

    def rate(self, t, x, omega, y, modes):
        n = self.force.size
        q, v = x[:n], x[n:]
        load = self.static + np.real(self.force * np.exp(1j * omega * t)) - self.C @ v - self.K @ q
        for s, kept, mode in zip(self.sliders, y, modes, strict=True):
            if s.z is not None:
                load = load - s.z * max(s.normal(q), 0.0)
            if mode == STICK:
                load = load - s.u * (kept + s.kt * (s.u @ q))
            elif mode != OPEN:
                load = load - s.u * mode * s.limit(q)
        return np.concatenate([v, np.linalg.solve(self.M, load)])

    def events(self, y, modes):
        """(function that rises through zero where a slider changes, which one, to what)."""
        n, found = self.force.size, []
        for c, (s, mode) in enumerate(zip(self.sliders, modes, strict=True)):
            if s.z is not None:
                sign = 1.0 if mode == OPEN else -1.0
                found.append((lambda t, x, s=s, sign=sign: sign * s.normal(x[:n]), c, "closing" if mode == OPEN else OPEN))
            if mode == STICK:
                for side in (UP, DOWN):
                    found.append(
                        (lambda t, x, s=s, c=c, side=side: side * (y[c] + s.kt * (s.u @ x[:n])) - s.limit(x[:n]), c, side)
                    )
            elif mode != OPEN:
                found.append(
                    (lambda t, x, s=s, side=mode: side * (side * s.limit_rate(x[:n], x[n:]) - s.kt * (s.u @ x[n:])), c, STICK)
                )
        return found

    def intercept(self, c, x, mode, y):
        s, q = self.sliders[c], x[: self.force.size]
        if mode == STICK:
            return y
        return (0.0 if mode == OPEN else mode * s.limit(q)) - s.kt * (s.u @ q)

    def travel(self, state, modes, omega, pieces=None):
        """The state a period later, from the modes of the sliders at its beginning; pieces: a list that takes the motion."""
        n = self.force.size
        t, x, y, modes = 0.0, state[: 2 * n].copy(), state[2 * n :].copy(), list(modes)
        while True:
            found = self.events(y, modes)
            for function, *_ in found:
                function.terminal, function.direction = True, 1.0
            rate, ends = partial(self.rate, omega=omega, y=y, modes=modes), (t, 2.0 * np.pi / omega)
            dense = pieces is not None
            done = solve_ivp(rate, ends, x, events=[function for function, *_ in found], dense_output=dense, **EXACT)
            if dense:
                pieces.append((t, done.t[-1], done.sol))
            t, x = done.t[-1], done.y[:, -1]
            for k, times in enumerate(done.t_events):
                if done.status == 1 and times.size:
                    self.change(x, y, modes, *found[k][1:])
            if done.status == 0:
                return np.concatenate([x, [self.intercept(c, x, mode, y[c]) for c, mode in enumerate(modes)]])

    def change(self, x, y, modes, c, to):
        s, n = self.sliders[c], self.force.size
        y[c] = self.intercept(c, x, modes[c], y[c])
        if to == "closing":
            speed = s.u @ x[n:]
            to = STICK if s.kt * abs(speed) <= s.limit_rate(x[:n], x[n:]) else int(np.sign(speed))
        modes[c] = to

    def period_map(self, state, modes, omega, change=3e-6):
        """Differences of the state a period later by motion, velocity and what stuck sliders remember."""
        n = self.force.size
        sizes = [np.abs(part).max(initial=1e-3) for part in (state[:n], state[n : 2 * n], state[2 * n :])]
        steps = change * np.repeat(sizes, (n, n, len(modes)))
        columns = []
        for i in self.free(modes):
            moved = steps[i] * np.eye(state.size)[i]
            columns.append(
                (self.travel(state + moved, modes, omega) - self.travel(state - moved, modes, omega)) / (2.0 * steps[i])
            )
        return np.array(columns).T[self.free(modes)]

    def free(self, modes):
        n = 2 * self.force.size
        return [*range(n), *(n + c for c, mode in enumerate(modes) if mode == STICK)]

    def motion(self, state, modes, omega, count):
        """q (n, count) at equal instants of a period."""
        pieces = []
        self.travel(state, modes, omega, pieces)
        times = 2.0 * np.pi / omega * np.arange(count) / count
        found = np.empty((self.force.size, count))
        for first, last, piece in pieces:
            inside = (times >= first) & (times <= last)
            found[:, inside] = piece(times[inside])[: self.force.size]
        return found

    def periodic(self, state, modes, omega):
        """The period map of the periodic motion near a state, by Newton's method."""
        return self.settled(state, modes, omega)[0]

    def settled(self, state, modes, omega):
        """The period map of the periodic motion near a state, and the state at its beginning."""
        free = self.free(modes)
        for _ in range(8):
            derivative = self.period_map(state, modes, omega)
            missed = (self.travel(state, modes, omega) - state)[free]
            if np.abs(missed).max() < 1e-9 * np.abs(state).max():
                return derivative, state
            state = state.copy()
            state[free] += np.linalg.lstsq(np.eye(len(free)) - derivative, missed, rcond=1e-9)[0]
        raise AssertionError("no periodic motion found")


def of_problem(problem, level):
    """The same masses and sliders as those of a problem under a force of harmonic one."""
    sliders, row = [], 0
    for contact in problem.contacts:
        law, count = contact.law, len(contact.tangential)
        z = None if contact.normal is None else problem.B[row + count]
        load = law.normal_load if z is None else law.preload - law.kn * law.gap
        table = (law.mu.over, law.mu.values) if isinstance(law.mu, LoadDependentFriction) else ((), ())
        sliders += [Slider(problem.B[row + d], law.kt, law.mu, load, z, law.kn or 0.0, table) for d in range(count)]
        row += count + (z is not None)
    power = problem.load_powers(1)[0]
    structure = problem.structure
    return Hybrid(structure.M, problem.C, structure.K, problem.static_load, level * (power[:, 1] - 1j * power[:, 2]), sliders)
