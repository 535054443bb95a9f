"""Floquet's multipliers of one solved point, and whether it is stable."""

from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.contact.law import SLIDERS
from stickslip.model.contact.protocol import STICK
from stickslip.model.problem.systems import lasting_stiffness
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, PathCondition
from stickslip.solve.balance.linear_part import states
from stickslip.solve.stability.contact_path import contact_path
from stickslip.solve.stability.period_map import BlockModes, Path, block_modes, period_map
from stickslip.support.checks import Array, Index, InputError

STEPS = 32
"""Steps of a period to begin with, beside the instants at which contacts change; doubled until the verdict is clear."""

MOST_STEPS = 2048

CLEAR = 0.02
"""A largest multiplier so far from the unit circle, and so many times as far as its estimated error, is on its side."""

TIMES_ERROR = 4.0

ROUNDING = 1e-7
"""Distance from the unit circle that rounding may decide: that of modes without damping, in units of their size."""

UNDECIDED = 1e-3
"""Distance from the unit circle within which a multiplier may be left undecided."""

NEAR = 0.05
"""Distance from the unit circle within which too few harmonics may decide a verdict."""

MERGED = 1e-9
"""Instants closer than this share of a period are one."""


RESOLVED = 2.0
"""Radians of a stuck mode that a step may take where contacts slip."""

PASSAGES = 4.0
"""How many times the passage of a velocity through zero, before and after it, steps are short where its law needs them."""

BESIDE = 1e-9
"""How far from an eigenvalue, relative to it, its vectors are found, so that the matrix can still be factorised."""


class Stability(IntEnum):
    """Whether a periodic motion returns after a small disturbance."""

    UNKNOWN = 0
    STABLE = 1
    UNSTABLE = 2
    UNDECIDED = 3


@dataclass(frozen=True, eq=False)
class Multipliers:
    """values: the eigenvalues of the period map, largest first; error: estimated, of the first; steps: of the period.

    exact_ones: multipliers of exactly 1, of sliders that never slip, which are not among the values: any position of such a
    slider between two limits is a periodic motion. resolved: whether the number of real multipliers beyond 1 is even where the
    determinant of the balance's Jacobian is positive, odd where it is negative; it is not where too few harmonics move the
    multipliers across 1. follows_contacts: whether steps and modes follow the stiffest contact that moves; else the values say
    nothing.
    """

    values: NDArray[np.complex128]
    error: float
    steps: int
    exact_ones: int
    resolved: bool
    follows_contacts: bool = True

    @property
    def leading(self) -> complex:
        """The largest, with positive imaginary part of a pair; 0 where nothing moves by itself."""
        return complex(self.values[0].real, abs(self.values[0].imag)) if self.values.size else 0j

    @property
    def verdict(self) -> Stability:
        """Whether the largest multiplier lies inside the unit circle."""
        size = abs(self.leading)
        if not np.isfinite(size):
            return Stability.UNKNOWN
        if not self.resolved:
            return Stability.UNDECIDED
        if abs(size - 1.0) <= min(max(self.error, ROUNDING), UNDECIDED):
            return Stability.UNDECIDED
        return Stability.UNSTABLE if size > 1.0 else Stability.STABLE


class PeriodMap:
    """The period maps of the solved points of one balance. highest: rad/s, up to which natural frequency modes move by
    themselves; those above follow at once."""

    def __init__(self, balance: HarmonicBalance, highest: float = np.inf) -> None:
        self.balance, self.highest = balance, highest
        self.modes = self._modes_at(0.0)

    def _modes_at(self, omega: float) -> BlockModes:
        """The modes of the structure, of a problem with `speed` at that of a frequency."""
        problem = self.balance.problem.at_frequency(omega)
        lasting = lasting_stiffness(problem)
        if not problem.systems.alike or lasting is None:
            raise InputError(
                "Stability can be computed only for a structure that all harmonics share, but stiff mean springs act on harmonic "
                "0 alone, and aerodynamic forces of a disk act on harmonics above 0 alone."
            )
        system = problem.systems.at(1)
        modes = block_modes(states(system._replace(K=system.K + lasting)), self.balance.rows, self.highest)
        if modes is None:
            raise InputError("Stability must be asked for damping that decouples, but two modes are critically damped together.")
        return modes

    def multipliers(self, evaluation: Evaluation, steps: int = STEPS, most: int = MOST_STEPS) -> Multipliers:
        """The multipliers of a point, with twice `steps` or as many more, up to `most`, as its verdict needs."""
        contacts, modes = ContactPeriod(evaluation, self.balance), self._modes_of(evaluation)
        coarse = _map(contacts, modes, steps)
        before = None
        while True:
            steps *= 2
            fine = _map(contacts, modes, steps)
            # The error falls with the square of the step: a third of the difference is left, and is taken off. What then
            # remains is no more than a third of what the next halving of the steps changes.
            left = (fine - coarse) / 3.0
            better = fine + left
            change = left if before is None else (better - before) / 3.0
            values = np.linalg.eigvals(better).astype(complex)
            values = values[np.argsort(-np.abs(values), kind="stable")]
            error = _size_change(better, values[0], change) if values.size and values[0] != 0.0 else 0.0
            distance = abs(abs(values[0]) - 1.0) if values.size else 1.0
            follows = self._follows(contacts, modes, steps)
            if steps >= most or (follows and (distance > TIMES_ERROR * error or not error > 0.1 * ROUNDING)):
                return Multipliers(values, float(error), steps, contacts.exact_ones, self._resolved(evaluation, values), follows)
            coarse, before = fine, better

    def _follows(self, contacts: "ContactPeriod", modes: BlockModes, steps: int) -> bool:
        """Whether so many steps follow the contacts that slip, and no mode that they free is among those that follow at once.

        δλ goes linearly over a step h of the stuck modes: in slip −kt δu cancels the stuck spring, and the scheme amplifies what
        it should not from ω h = π on. A mode of compliance g without its spring has ω²(1 − kc g).
        """
        stiff = contacts.used[self.balance.stiffness[contacts.used] > 0.0]
        if not stiff.size:
            return True
        moving = np.any(modes.motion[stiff].reshape(stiff.size, -1, 2) != 0.0, axis=(0, 2))
        fastest = np.abs(np.linalg.eigvals(modes.blocks[moving])).max(initial=0.0)
        freed = 1.0 - self.balance.stiffness[stiff] * np.diag(modes.static)[stiff]
        slowest = modes.lowest_dropped * np.sqrt(freed.min().clip(min=0.0))
        return bool(fastest * contacts.period <= RESOLVED * steps and slowest >= 0.5 * self.highest)

    def _resolved(self, evaluation: Evaluation, values: NDArray[np.complex128]) -> bool:
        """Whether the sign of the product of all 1 − μ is that of the determinant of the balance's Jacobian.

        Too few harmonics move multipliers a little. Where the largest is not near the unit circle, the sign of the Jacobian is
        not to be believed: of sampled friction it may change where a slider just slips.
        """
        if not values.size or abs(abs(values[0]) - 1.0) > NEAR:
            return True
        beyond = int(np.count_nonzero((values.imag == 0.0) & (values.real > 1.0)))
        held = PathCondition("omega", None, 1.0, evaluation.point.omega)
        sign = self.balance.factorise(evaluation, held).orientation
        return bool(sign * (-1) ** beyond >= 0.0)

    def _modes_of(self, evaluation: Evaluation) -> BlockModes:
        return self._modes_at(evaluation.point.omega) if self.balance.problem.systems.stiffens else self.modes

    def matrix(self, evaluation: Evaluation, steps: int) -> Array:
        """The period map with so many steps, beside the instants at which contacts change."""
        return _map(ContactPeriod(evaluation, self.balance), self._modes_of(evaluation), steps)


def _map(contacts: "ContactPeriod", modes: BlockModes, steps: int) -> Array:
    path, columns = contacts.path(steps)
    whole = period_map(contacts.table, modes, path, columns)
    size = modes.force.shape[0]
    kept = np.concatenate([modes.real, np.arange(size, size + columns.size)])
    return np.asarray(whole[np.ix_(kept, kept)])


def _size_change(matrix: Array, value: complex, change: Array) -> float:
    """How a change of a matrix changes the size of one of its eigenvalues, δμ = yᴴ δΦ x/(yᴴ x), y and x by inverse iteration."""
    factors = linalg.lu_factor(matrix - value * (1.0 + BESIDE) * np.eye(matrix.shape[0]), check_finite=False)
    right = left = np.ones(matrix.shape[0], dtype=complex)
    for _ in range(2):
        right, left = linalg.lu_solve(factors, right), linalg.lu_solve(factors, left, trans=2)
        right, left = right / np.linalg.norm(right), left / np.linalg.norm(left)
    moved = np.vdot(left, change @ right) / np.vdot(left, right)
    return float(abs((moved * np.conj(value)).real)) / abs(value)


class ContactPeriod:
    """What the contacts do over the period of a solved point, for any number of steps."""

    def __init__(self, evaluation: Evaluation, balance: HarmonicBalance) -> None:
        self.table, self.period = evaluation.table, 2.0 * np.pi / evaluation.point.omega
        table, tables = self.table, balance.tables
        self.samples = tables.E.shape[0]
        w = evaluation.w[: balance.rows]
        self.u = np.ascontiguousarray(w @ tables.E.T)
        self.v = np.ascontiguousarray(w @ tables.D.T) * (2.0 * np.pi / self.samples)
        most = 4 * self.samples * (table.stiffness.size + table.normal_stiffness.size + table.bend.size + balance.rows)
        instants, elements, new = np.empty(most), np.empty(most, dtype=np.int64), np.empty(most, dtype=np.int64)
        self.intercept = np.zeros((table.stiffness.size, self.samples))
        count, still, self.last = contact_path(
            table, self.u, self.v, np.ascontiguousarray(w[:, 0]), evaluation.point.omega, instants, elements, new, self.intercept
        )
        order = np.argsort(instants[:count] % self.samples, kind="stable")
        self.instants, self.elements, self.new = instants[order] % self.samples, elements[order], new[order]
        self.moving = (still == 0.0).astype(np.int64)
        self.exact_ones = int(still.sum())
        self.contacts = balance.problem.contacts
        self.laws = np.repeat(table.kind != SLIDERS, np.diff(table.first_row))  # the tangential rows of laws with kernels
        self.laws[table.normal_row[table.normal_row >= 0]] = False
        self.start, self.used = self._start(), self._used()

    def _start(self) -> float:
        """In the middle of the longest time without a change; at a sample, where laws have kernels of their own."""
        if not self.instants.size:
            return 0.0
        gaps = np.diff(np.append(self.instants, self.instants[0] + self.samples))
        widest = int(np.argmax(gaps))
        middle = self.instants[widest] + 0.5 * gaps[widest]
        return float(np.floor(middle) if self.laws.any() else middle)

    def _used(self) -> Index:
        """The rows whose contacts slip, open or have a law with kernels of its own."""
        table = self.table
        used = self.laws.copy()
        used[np.repeat(np.arange(used.size), np.diff(table.friction_first))[self.moving == 1]] = True
        for c in np.flatnonzero(table.normal_row >= 0):
            springs = slice(table.normal_first[c], table.normal_first[c + 1])
            least = table.normal_stiffness[springs] * self.u[table.normal_row[c]].min() + table.normal_constant[springs]
            used[table.normal_row[c]] = bool(np.any(least <= 0.0))
        return np.flatnonzero(used)

    @cached_property
    def lifts_off(self) -> bool:
        """Whether any normal spring opens and closes."""
        table = self.table
        z = self.u[np.repeat(table.normal_row, np.diff(table.normal_first))]
        forces = table.normal_stiffness[:, None] * z + table.normal_constant[:, None]
        return bool(np.any((forces.min(axis=1) <= 0.0) & (forces.max(axis=1) > 0.0)))

    def path(self, steps: int) -> tuple[Path, Index]:
        """The path on that many steps and the instants of change; the columns of the period map that are contact states."""
        table, samples = self.table, self.samples
        shifted = (self.instants - self.start) % samples
        reversals = (self._reversals(steps) - self.start) % samples
        grid = np.unique(np.concatenate([np.arange(steps + 1) * (samples / steps), shifted, reversals]))
        grid = grid[np.append(np.diff(grid) > MERGED * samples, True)]
        state = self._states(shifted, 0.5 * (grid[1:] + grid[:-1]))
        u, v = self._motion(grid + self.start)
        path = Path(
            grid * (self.period / samples),
            u,
            v * (samples / self.period),
            state,
            self.moving,
            self._known(shifted, grid),
            self.used,
        )
        rows = np.repeat(np.arange(table.friction_first.size - 1), np.diff(table.friction_first))
        remembering = np.flatnonzero((self.moving == 1) & (self.laws[rows] | (state[0] == STICK)))
        stuck = np.isin(np.arange(self.laws.size), rows[self.moving == 0])
        return path, np.concatenate([remembering, table.stiffness.size + np.flatnonzero(self.laws & ~stuck)]).astype(np.int64)

    def _reversals(self, steps: int) -> Array:
        """Instants around the reversals of laws whose force the velocity takes from one limit to the other within few steps."""
        found = [np.empty(0)]
        for c, contact in enumerate(self.contacts):
            if contact.law.passage(1.0) == np.inf:
                continue
            for r in range(self.table.first_row[c], self.table.first_row[c] + len(contact.tangential)):
                v, after = self.v[r], np.roll(self.v[r], -1)
                for n in np.flatnonzero(v * after < 0.0):
                    # The amplitude of a harmonic motion with the same acceleration: passages of other motions are alike.
                    amplitude = abs(after[n] - v[n]) * self.samples**2 / (2.0 * np.pi * self.period)
                    width = self.samples * contact.law.passage(float(amplitude))
                    if width * steps < 2.0 * PASSAGES * self.samples:
                        found.append(n + v[n] / (v[n] - after[n]) + PASSAGES * width * np.linspace(-1.0, 1.0, steps + 1))
        return np.concatenate(found)

    def _states(self, shifted: Array, middles: Array) -> Index:
        """State of every slider in each interval (K, elements)."""
        state = np.empty((middles.size, self.last.size), dtype=np.int64)
        for e in range(self.last.size):
            own = np.flatnonzero(self.elements == e)
            if not own.size:
                state[:, e] = self.last[e]
                continue
            order = own[np.argsort(shifted[own], kind="stable")]
            state[:, e] = self.new[order][np.searchsorted(shifted[order], middles) - 1]
        return state

    def _motion(self, at: Array) -> tuple[Array, Array]:
        """Motion of the rows and its rate per sample, by the cubic between samples."""
        n = np.floor(at).astype(int)
        x, n, m = at - n, n % self.samples, (n + 1) % self.samples
        u0, u1, v0, v1 = self.u[:, n], self.u[:, m], self.v[:, n], self.v[:, m]
        c2, c3 = 3.0 * (u1 - u0) - 2.0 * v0 - v1, 2.0 * (u0 - u1) + v0 + v1
        return np.ascontiguousarray(u0 + x * (v0 + x * (c2 + x * c3))), np.ascontiguousarray(v0 + x * (2.0 * c2 + 3.0 * x * c3))

    def _known(self, shifted: Array, grid: Array) -> Array:
        """Intercepts of laws with kernels of their own (K, elements) where they are known, else NaN."""
        known = np.full((grid.size - 1, self.table.stiffness.size), np.nan)
        known[0] = self.intercept[:, int(self.start) % self.samples]
        for k in np.flatnonzero(self.elements <= -2):
            a, b = self.table.friction_first[self.table.first_row[[-2 - self.elements[k], -1 - self.elements[k]]]]
            place = min(np.searchsorted(grid, shifted[k] - MERGED * self.samples), grid.size - 2)
            known[place, a:b] = self.intercept[a:b, self.new[k]]
        return known
