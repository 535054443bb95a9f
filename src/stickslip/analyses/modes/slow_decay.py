"""What a free decay along a nonlinear mode shows: how far its outputs swing, and with which damping ratio their swing falls.

A decay loses between two turning points what the contacts and the dashpots take. With the energy of the structure E, kinetic and
½ qᵀK q − pᵀq, at the turning points of the cycle of amplitude A,

    E(A₀) − E(A₁) = work of the contacts on the way from A₀ to A₁ + viscous work.

The work of the contacts is that of their law along a motion whose amplitude falls. It differs from half of the work W of a
steady cycle by what springs give back, and by what friction takes more or less since its limits fall with the motion; both count
in dE/d ln A of structure and contacts together. Slowly, with the viscous work in W,

    ζ = W/(2π dE/d ln A).

Where the amplitude falls by much within a cycle, the half cycles follow one after the other: each loses by friction what the
balance says, and by dashpots exp(−πζ_v/√(1 − ζ_v²)), half of it before and half after. Their damping ratio is that of the half
cycles of a `FreeDecay`.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from stickslip.model.contact.protocol import OFFSET, SLIPPING
from stickslip.solve.balance.balance import Evaluation, Point
from stickslip.solve.balance.energy import contact_cycle
from stickslip.solve.balance.fourier import Fourier, complex_harmonics, fourier
from stickslip.solve.balance.mode_balance import ModeBalance, mode_energy
from stickslip.solve.continuation.curve_points import CurvePoint, Tangent
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.curves.mode_curve import arc_tangent, directed
from stickslip.solve.time.contact_law import contact_work
from stickslip.support.checks import Array

HEAVY = 0.05
"""Damping ratio above which half cycles are followed one after the other: below, they differ from the slow decay by less than
0.3 %, as far as rigid friction goes."""

SETTLING = 2
"""Cycles of a falling motion before the half cycle whose work counts: sliders that slip have forgotten their start."""

SAMPLES = 20
"""Samples of a cycle for each harmonic, at most, along which the contacts are taken."""

ENOUGH, STEPS = 1e-2, 12
"""Relative change at which what a half cycle loses is found, which changes what is stored far less, and steps until then."""

BISECTIONS = 52
"""Halvings to the last digit of a number."""

PROBE = 1e-3
"""What a half cycle loses of ln A at least to see what the contacts store: far above rounding, far below what bends a curve."""


LAGGING = 2e-3
"""Change of the mean motion of the contacts within a cycle, relative to their vibration, from which a decay no longer follows the
mode: up to a third off for wedges that lose 2 to 3 % and sink as they begin to slip, 1 % where they lose a tenth of that."""

SHARED = 0.03
"""Share of other modes in the motion of an output from which a decay is not that of one mode: two masses of which one rubs, near
a veering, have up to a tenth more or less damping below it, and a sixth to many times as much above 0.1."""

SAME = 1e-6
"""Share of the vibration up to which sliders stand at the same place."""


class SlowDecay(NamedTuple):
    """Of the points of a mode: swing (points, outputs), half the distance of the turning points of each output, m;
    damping_ratio (points, outputs) of a decay, NaN where there is none; others (points, outputs), how much other modes move
    there, relative to this one, because they follow too slowly as its shape changes; (points,): sticks, whether none is there
    since friction stops the motion within two half cycles; lags, whether the static forces of the contacts change faster with
    the amplitude than a decay follows."""

    swing: Array
    damping_ratio: Array
    others: Array
    sticks: NDArray[np.bool_]
    lags: NDArray[np.bool_]


class Losses(NamedTuple):
    """What a decay loses at a point: work of the contacts and of the dashpots in a cycle, J; stored, dE/dx of structure and
    contacts, J; friction, by how much a half cycle makes x smaller by friction, ∞ where it does not end; x, the arc length of
    the mode in ln A, ln ω and ζ; swing [m] and its derivative by x (outputs,); drift, the change of the mean motion of the
    contacts by x relative to their vibration; others (outputs,) as of `SlowDecay`."""

    work: float
    viscous: float
    stored: float
    friction: float
    swing: Array
    rise: Array
    drift: float
    others: Array


def slow_decay(balance: ModeBalance, points: Sequence[CurvePoint]) -> SlowDecay:
    """Swings and damping ratios of decays along the solved points of a mode."""
    losses = [_losses(*each) for each in _descending(balance, points)]
    swing = np.array([each.swing for each in losses])
    ratio, sticks = np.full(swing.shape, np.nan), np.zeros(len(points), dtype=bool)
    for output in range(swing.shape[1] if points else 0):
        ratio[:, output], stuck = _damping(losses, output)
        sticks |= stuck
    lost = 2.0 * np.pi * np.array([balance.damping_of(point.point) for point in points])
    others = np.array([each.others for each in losses]).reshape(swing.shape)
    return SlowDecay(swing, ratio, others, sticks, lost * np.array([each.drift for each in losses]) > LAGGING)


def _descending(balance: ModeBalance, points: Sequence[CurvePoint]) -> list[tuple[ModeBalance, CurvePoint]]:
    """The points as a decay meets them: sliders that stick stand where a larger amplitude left them, not where a virgin contact
    has them, which changes the static forces; each with its balance."""
    found: list[tuple[ModeBalance, CurvePoint]] = []
    for point in reversed(points):
        own = balance, point
        if found and balance.rows and balance.kept[0] == 0:
            own = _with_past(balance, *found[-1], point)
        found.append(own)
    return found[::-1]


def _with_past(
    balance: ModeBalance, before: ModeBalance, larger: CurvePoint, point: CurvePoint
) -> tuple[ModeBalance, CurvePoint]:
    """A point with the sliders that the next larger amplitude left; as it is, where they stand there anyway."""
    left, own = (
        contact_cycle(each.evaluation.table, balance.tables, each.evaluation.w, balance.omega_of(each.point)).mean_slider
        for each in (larger, point)
    )
    stuck = np.repeat(point.evaluation.unknown != SLIPPING, np.diff(balance.table.friction_first))
    if np.allclose(left[stuck], own[stuck], rtol=0.0, atol=SAME * np.abs(point.evaluation.w[: balance.rows]).max()):
        return balance, point
    past = balance.with_starts(left, OFFSET)
    assert isinstance(past, ModeBalance)
    for start in (larger.point.forces, point.point.forces):
        at = Point(start, point.point.omega, point.point.level)
        solved = correct(past, at, fixed("level", at.level), iterations=40, halvings=12)
        if solved.converged:
            moved = directed(past, larger, replace(point, evaluation=solved.evaluation))
            forces, motion, parameter, level = moved.tangent
            return past, replace(moved, tangent=Tangent(-forces, -motion, -parameter, -level))
    return balance, point


def _losses(balance: ModeBalance, point: CurvePoint) -> Losses:
    evaluation, energy = point.evaluation, mode_energy(balance, point.evaluation)
    forces, motion, rate = arc_tangent(point)
    swing, rise = _swing(evaluation.w[balance.rows :], motion[balance.rows :])
    falling = _Falling(balance, evaluation, motion)
    structure = _structure_slope(balance, evaluation, forces, motion, rate)
    stored, friction = falling.half_cycle(structure, float(energy.dissipated.sum()), abs(balance.damping_of(point.point)))
    vibration, work = np.linalg.norm(evaluation.w[: balance.rows, 1:3]), float(energy.dissipated.sum())
    drift = float(np.linalg.norm(motion[: balance.rows, 0]) / vibration) if vibration > 0.0 else 0.0
    slope = balance.coordinates_slope(evaluation, forces, rate)[:, 1]
    others = _others(balance, evaluation, slope, (work + energy.viscous) / (2.0 * np.pi * stored) if stored > 0.0 else 0.0)
    return Losses(work, energy.viscous, stored, friction, swing, rise, drift, others)


def _others(balance: ModeBalance, evaluation: Evaluation, slope: NDArray[np.complex128], pace: float) -> Array:
    """How much other modes move at the outputs (outputs,), relative to this one, where x falls by `pace` a radian.

    The first harmonic η exp(iθ) of a mode solves Z η = 0, with what its contacts do to it and with 2ζωM that feeds it. A motion
    that falls along the mode needs 2iω²M dη/dθ in its place, which moves what is orthogonal to the mode.
    """
    structures, rows = balance.structures, balance.rows
    key, omega, zeta = structures.key[1], balance.omega_of(evaluation.point), balance.damping_of(evaluation.point)
    state, damping = balance.modal_coordinates(evaluation)[:, 1], structures.damping[key]
    shapes, mass = structures.shapes[key], structures.squares[key]
    beyond_springs = complex_harmonics((evaluation.point.forces - evaluation.residual)[:rows])[:, 1]
    moved = complex_harmonics(evaluation.w[:rows])[:, 1]
    stiffness = np.divide(beyond_springs, moved, out=np.zeros_like(moved), where=moved != 0.0)
    viscous = np.diag(damping[0]) if damping.shape[0] == 1 else damping
    Z = shapes[:rows].conj().T @ (stiffness[:, None] * shapes[:rows]) + 1j * omega * viscous
    Z += np.diag(1.0 - omega**2 * (1.0 + 2j * zeta) * mass)
    needed = -2j * omega**2 * pace * mass * slope
    border = mass * state / np.linalg.norm(mass * state)
    bordered = np.block([[Z, border[:, None]], [border.conj()[None], np.zeros((1, 1))]])
    found = np.linalg.solve(bordered, np.append(-needed, 0.0))[:-1]
    size = np.abs(shapes[rows:] @ state)
    return np.asarray(np.abs(shapes[rows:] @ found) / np.where(size > 0.0, size, np.nan))


def _swing(motion: Array, slope: Array) -> tuple[Array, Array]:
    """Half the distance between the turning points of motions (outputs, 2H+1), and its derivative (outputs,)."""
    highest = (motion.shape[1] - 1) // 2
    tables = _tables(highest, 64 * highest)
    time, change, each = motion @ tables.E.T, slope @ tables.E.T, np.arange(len(motion))
    high, low = np.argmax(time, axis=1), np.argmin(time, axis=1)
    halves = [0.5 * (values[each, high] - values[each, low]) for values in (time, change)]
    return halves[0], halves[1]


def _tables(highest: int, samples: int) -> Fourier:
    """Of an even number of samples, so that half a cycle is one of them."""
    return fourier(highest, samples + samples % 2)


def _structure_slope(balance: ModeBalance, evaluation: Evaluation, forces: Array, motion: Array, rate: float) -> float:
    """Derivative along the mode of the energy of the structure at both turning points together, of the constant loads too, J.

    The turning points are those of the followed mode's coordinate; where harmonics move different structures, as those of a
    travelling wave, the mean over the cycle stands for them, that of all sectors at any instant.
    """
    structure, state = balance.mode_system.structure, balance.modal_coordinates(evaluation)
    slope, order = balance.coordinates_slope(evaluation, forces, rate), np.arange(balance.highest + 1)
    omega = balance.omega_of(evaluation.point)
    faster = float(forces[-1, 1]) / float(evaluation.point.forces[-1, 1])
    speed, faster_speed = 1j * order * omega * state, 1j * order * omega * (slope + faster * state)
    squares = structure.squares[structure.key].T
    stiffness, static = balance.stiffness[:, None], structure.static.conj()
    contacts, moved = (complex_harmonics(values[: balance.rows]) for values in (evaluation.w, motion))
    if balance.problem.systems.alike and not balance.problem.mean_springs:
        total = 0.0
        for turn in (np.ones(order.size), (-1.0) ** order):
            at = [np.real(values @ turn) for values in (speed, faster_speed, state, slope, contacts, moved)]
            moved_by = (at[2] - np.real(static)) @ at[3] - stiffness[:, 0] @ (at[4] * at[5])
            total += float(squares[:, -1] @ (at[0] * at[1]) + moved_by)
        return total
    share = np.where(order == 0, 2.0, 1.0)
    products = squares * np.conj(speed) * faster_speed + np.conj(state) * slope
    mean = share @ (products.sum(axis=0) - (stiffness * np.conj(contacts) * moved).sum(axis=0))
    return float(np.real(mean - 2.0 * static @ slope[:, 0]))


class _Falling:
    """The contacts along a motion whose place x on the mode falls evenly with the phase."""

    def __init__(self, balance: ModeBalance, evaluation: Evaluation, motion: Array) -> None:
        self.table, self.stiffness = evaluation.table, balance.stiffness
        self.omega, rows = balance.omega_of(evaluation.point), balance.rows
        tables = _tables(balance.highest, min(balance.tables.E.shape[0], SAMPLES * balance.highest))
        self.samples = tables.E.shape[0]
        self.intercept = contact_cycle(self.table, tables, evaluation.w, self.omega).intercept
        self.w, self.speed = (table @ evaluation.w[:rows].T for table in (tables.E, self.omega * tables.D))
        self.change, self.change_speed = (table @ motion[:rows].T for table in (tables.E, self.omega * tables.D))

    def work(self, lost: float) -> float:
        """Work of the contacts over both half cycles, J, each of which makes x smaller by `lost`, around this point."""
        return self._half(lost, 0) + self._half(lost, self.samples // 2)

    def _half(self, lost: float, first: int) -> float:
        before = SETTLING * self.samples + 1  # the intercepts are those of the sample before the first
        number = np.arange(-before, first + self.samples // 2 + 1)
        # Both half cycles fall for one cycle before, from the same size: what sticks has the same past in both.
        beyond = lost * np.minimum(2.0 * (first - number) / self.samples + 0.5, 2.5)[:, None]
        at = number % self.samples
        path, velocity = self.w[at] + beyond * self.change[at], self.speed[at] + beyond * self.change_speed[at]
        step = 2.0 * np.pi / (self.omega * self.samples)
        place = before + first
        return float(contact_work(self.table, self.stiffness, self.intercept, path, velocity, step, place))

    def half_cycle(self, structure: float, work: float, ratio: float) -> tuple[float, float]:
        """dE/dx of structure and contacts at a turning point, J, and by how much friction makes x smaller in a half cycle."""
        if not self.w.shape[1]:
            return 0.5 * structure, 0.0
        steady, trial = self.work(0.0), max(np.pi * ratio, PROBE)
        for _ in range(STEPS):
            stored = structure - (self.work(trial) - steady) / trial
            lost = work / stored if stored > 0.0 else np.nan
            if not lost > PROBE or abs(lost / trial - 1.0) <= ENOUGH:
                return 0.5 * stored, max(lost, 0.0)
            trial = lost
        return 0.5 * stored, np.inf


def _damping(losses: Sequence[Losses], output: int) -> tuple[Array, NDArray[np.bool_]]:
    """Damping ratios of decays at the points, as an output shows them, and whether friction stops the motion there."""
    swing = np.array([each.swing[output] for each in losses])
    growth = np.array([each.rise[output] for each in losses]) / np.where(swing > 0.0, swing, np.nan)  # d ln A/dx
    stored = np.array([each.stored for each in losses]) / growth
    work, viscous = (np.array([getattr(each, key) for each in losses]) for key in ("work", "viscous"))
    with np.errstate(invalid="ignore"):
        stored = np.where(stored > 0.0, stored, np.nan)
        dashpots = viscous / (2.0 * np.pi * stored)
        ratio = work / (2.0 * np.pi * stored) + dashpots
        loss = 0.5 * swing * growth * np.array([each.friction for each in losses])
        heavy, sticks = ratio > HEAVY, np.isposinf(loss)
    known = np.isfinite(loss) & np.isfinite(dashpots) & (dashpots < 1.0)
    ratio = np.where(heavy, np.nan, ratio)
    if np.count_nonzero(known) < 3 or not np.all(np.diff(swing[known]) > 0.0):
        return ratio, sticks
    half = _HalfCycles(swing[known], loss[known], dashpots[known], swing[sticks].max(initial=0.0))
    sticks[known] = half.sticks(swing[known])
    ratio[sticks] = np.nan
    found = heavy & known & ~sticks
    ratio[found] = half.ratio(swing[found])
    return ratio, sticks


class _HalfCycles:
    """Half cycles that follow each other: around a size A of its middle, friction takes a half cycle from A + loss to A − loss.

    Beyond the ends of the curve, where the neighbours of half cycles at its ends may lie, the loss goes on along its tangents.
    """

    def __init__(self, size: Array, loss: Array, dashpots: Array, ends: float) -> None:
        """ends: the largest size at which a half cycle does not end."""
        self.ends, self.loss = size[[0, -1]], PchipInterpolator(size, loss)
        self.slopes = self.loss(self.ends, 1)
        self.fade = PchipInterpolator(size, np.exp(0.5 * np.pi * dashpots / np.sqrt(1.0 - dashpots**2)))
        stuck = int(np.argmax(loss > 0.0)) - 1
        begins = size[0] - loss[0] / self.slopes[0] if stuck < 0 and self.slopes[0] > 0.0 else 0.0
        self.onset, self.endless = size[stuck] if stuck >= 0 else max(begins, 0.0), ends

    def turning(self, size: Array, side: float, dashpots: bool = True) -> Array:
        """The turning point before (side = 1) or after (−1) the half cycle around a size."""
        inside = np.clip(size, *self.ends)
        loss = self.loss(inside) + np.where(size < inside, *self.slopes) * (size - inside)
        fade = self.fade(inside) if dashpots else 1.0
        return np.asarray((size + side * np.maximum(loss, 0.0)) * fade**side)

    def neighbour(self, size: Array, side: float, dashpots: bool = True) -> Array:
        """The size of the half cycle before or after that around a size, which meets it at a turning point; 0 where there is
        none."""
        shared = self.turning(size, side, dashpots)
        low, high = (size, 4.0 * shared) if side > 0.0 else (np.zeros(size.size), size)
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            beyond = self.turning(middle, -side, dashpots) > shared
            low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
        return np.asarray(0.5 * (low + high))

    def sticks(self, size: Array) -> NDArray[np.bool_]:
        """Whether friction alone ends the half cycle around a size, or the next one, where nothing slips any more."""
        following = self.neighbour(size, -1.0, dashpots=False)
        stuck = (self.turning(following, -1.0, dashpots=False) < self.onset) | (following < self.endless)
        return np.asarray((self.turning(size, -1.0, dashpots=False) < size) & stuck)

    def ratio(self, size: Array) -> Array:
        """The damping ratio of the half cycles, as `half_cycles` of a free decay has it."""
        before, after = (self.turning(self.neighbour(size, side), side) for side in (1.0, -1.0))
        first, last = self.turning(size, 1.0), self.turning(size, -1.0)
        decrement = np.log((before + 2.0 * first + last) / (first + 2.0 * last + after))
        return np.asarray(decrement / np.sqrt(np.pi**2 + decrement**2))
