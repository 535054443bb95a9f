"""Frequencies of possible resonances, known before a curve is traced.

They are the natural frequencies of the structure with all contacts stuck and without contacts, and their fractions 1/h, which
harmonic h of a friction force excites. A lightly damped peak is so narrow that a step of the continuation can pass over it and
both its ends look right; so each of these frequencies inside a step is solved. Where some contacts stick and others slip, so are
those of the structure on the contacts that stick at the ends of the step. With friction, a resonance lies between the frequencies
with the slipping contacts stuck and free, and friction makes it the wider the farther it lies from both.
"""

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.model.contact.protocol import HELD, SLIPPING
from stickslip.model.problem import Problem
from stickslip.model.problem.systems import BARELY, LinearSystem
from stickslip.model.structure.modes import definite_modes, gyroscopic_modes, natural_modes
from stickslip.solve.balance.fourier import Harmonics, highest, orders
from stickslip.support.checks import Array, Index

LARGEST = 400
"""Degrees of freedom up to which the structure is decomposed anew for each set of sticking contacts that a curve meets."""

UNDAMPED = 1e-8
"""A mode with a smaller damping ratio is looked at beside its frequency, where the balance has a solution."""

REMEMBERED = 16
"""States of contacts whose resonances are kept: those of the last steps. All of a blade root took 0.7 GB."""

BESIDE = 1e-6
"""How far beside, and the ratio that stands for its own: friction makes its peak wider than that."""


class Limit(NamedTuple):
    """Modes of one linear structure: held (contact rows,): those that stick; omega (m,) rad/s; damping ratios (m,); shapes
    (contact rows, m) of unit modal mass; sizes (1 + outputs, m) of the motion of all contact rows and of each output; load
    (powers, m, 2H+1): modal forces of the harmonic loads."""

    held: NDArray[np.bool_]
    omega: Array
    ratios: Array
    shapes: NDArray[Any]
    sizes: Array
    load: NDArray[Any]


class Resonances:
    """Natural frequencies over h; omega (k,): rad/s, ascending; harmonic (k,): h; width (k,): half-width ζω of the peak, rad/s.

    holds: for each structure, which contact rows (rows,) stick; the others are free. Of the structure with all contacts stuck
    and without contacts, if not given.
    """

    def __init__(self, problem: Problem, harmonics: Harmonics, holds: Sequence[NDArray[np.bool_]] = ()) -> None:
        powers = problem.load_powers(highest(harmonics))
        stiffness = problem.contact_stiffness
        every = np.ones(stiffness.size, dtype=bool)
        self.problem, self.harmonics = problem, harmonics
        self.limits: list[Limit] = []
        self._stuck: dict[bytes, Resonances | None] = {}
        known: dict[int, list[int]] = {}
        rows: list[tuple[Array, ...]] = []
        for h in filter(None, orders(harmonics)):
            key = problem.systems.key(h)
            if key not in known:
                known[key] = []
                for turn, system in problem.systems.waves(h):
                    for held in holds or (every, ~every):
                        known[key].append(len(self.limits))
                        self.limits.append(_limit(problem, system, turn, powers, held))
            for number in known[key]:
                omega, ratios = self.limits[number].omega, self.limits[number].ratios
                chosen = np.flatnonzero(omega > 0.0)
                at, same = omega[chosen] / h, np.ones(chosen.size)
                at = np.where(ratios[chosen] > UNDAMPED, at, (1.0 - BESIDE) * at)
                rows.append((at, h * same, _looked_at(ratios[chosen]) * at, number * same, chosen.astype(float)))
        self._arrange(*np.concatenate([np.array(part) for part in rows], axis=1))

    def _arrange(self, omega: Array, harmonic: Array, width: Array, number: Array, mode: Array) -> None:
        """Keep the resonances in ascending order: harmonic, half-width, and which mode of which structure each is, all (k,)."""
        joined = np.array([omega, harmonic, width, number, mode])
        joined = joined[:, np.argsort(joined[0], kind="stable")]
        self.omega, self.width = joined[0], joined[2]
        # Lists, for a search at each step of a curve, which arrays would slow.
        self._ascending, self._widths = self.omega.tolist(), self.width.tolist()
        self.harmonic, self._number, self._mode = (joined[k].astype(np.int64) for k in (1, 3, 4))
        self._drive, self._compliance = self._driven()

    def _driven(self) -> tuple[NDArray[np.complex128], Array]:
        """Of each resonance (k,): modal force at level one, and modal amplitude per modal force."""
        drive, compliance = np.zeros(self.omega.size, dtype=complex), np.zeros(self.omega.size)
        for number, limit in enumerate(self.limits):
            of = self._number == number
            mode, h, omega = self._mode[of], self.harmonic[of], self.omega[of]
            cosine, sine = (limit.load[:, mode, column] for column in (2 * h - 1, 2 * h))
            drive[of] = np.sum(omega ** np.arange(limit.load.shape[0])[:, None] * (cosine - 1j * sine), axis=0)
            compliance[of] = 1.0 / (2.0 * _looked_at(limit.ratios[mode]) * limit.omega[mode] ** 2)
        return drive, compliance

    def where_stuck(self, unknown: Index) -> "Resonances | None":
        """Those of the structure on the contacts that stick in a state, remembered for steps that follow; None where all or none
        do, or where the structure is too large to be decomposed for each of its contact states. unknown (rows,): as
        `contact.protocol` counts."""
        key = unknown.tobytes()
        while len(self._stuck) > REMEMBERED:
            del self._stuck[next(iter(self._stuck))]
        if key not in self._stuck:
            held = unknown != SLIPPING
            if held.all() or not held.any() or self.problem.structure.size > LARGEST:
                self._stuck[key] = None
            else:
                same = np.where(held, HELD, SLIPPING).astype(unknown.dtype).tobytes()
                if same not in self._stuck:
                    self._stuck[same] = Resonances(self.problem, self.harmonics, (held,))
                self._stuck[key] = self._stuck[same]
        return self._stuck[key]

    def between(self, low: float, high: float) -> list[int]:
        """Numbers of the resonances with low < ω < high whose half-width is less than high − low, ascending."""
        inside = range(bisect_right(self._ascending, low), bisect_left(self._ascending, high))
        return [k for k in inside if self._widths[k] < high - low]

    def columns(self, k: int) -> slice:
        """Where cosine and sine of harmonic h of resonance k stand among the 2H+1 numbers of a row."""
        h = int(self.harmonic[k])
        return slice(2 * h - 1, 2 * h + 1)

    def motion(self, k: int, level: float, forces: Array, carried: Array) -> Array:
        """About the largest motion [m] that resonance k could add in harmonic h, of all contact rows and of each output
        (1 + outputs,).

        forces λ and carried F = λ + K_c w, (contact rows, 2) [N] of harmonic h, drive the modes of the stuck and of the free
        structure.
        """
        limit, mode = self.limits[self._number[k]], self._mode[k]
        given = np.where(limit.held[:, None], forces, carried)
        pull = limit.shapes[:, mode].conj() @ given
        force = level * self._drive[k] - (pull[0] - 1j * pull[1])
        return np.asarray(limit.sizes[:, mode] * (abs(force) * self._compliance[k]))


def contacts_and_outputs(squares: Array, rows: int) -> Array:
    """From squares of the motion of contact rows, first, and outputs, its size of all contact rows and of each output."""
    return np.asarray(np.sqrt(np.concatenate([squares[:rows].sum(axis=0, keepdims=True), squares[rows:]])))


def _looked_at(ratios: Array) -> Array:
    """Damping ratios, that which stands for its own where a mode is undamped."""
    return np.where(ratios > UNDAMPED, ratios, BESIDE)


def _limit(problem: Problem, system: LinearSystem, turn: NDArray[Any], powers: Array, held: NDArray[np.bool_]) -> Limit:
    stiffness, coriolis = problem.contact_stiffness, problem.structure.coriolis
    released = system.B.conj().T @ (np.where(held, 0.0, stiffness)[:, None] * system.B)
    if problem.systems.stiffens:
        modes = definite_modes(system.M, np.asarray(system.K - (1.0 - BARELY) * released))
    else:
        modes = natural_modes(system.M, np.asarray(system.K - released))
        modes = modes if coriolis is None else gyroscopic_modes(modes, coriolis)
    omega = np.sqrt(np.maximum(modes.squares, 0.0))
    losses = np.sum(modes.shapes.conj() * (system.C @ modes.shapes), axis=0).real
    ratios = np.divide(losses, 2.0 * omega, out=np.zeros_like(omega), where=omega > 0.0)
    parts = powers.reshape(powers.shape[0], turn.size, -1, powers.shape[2])
    load = modes.shapes.conj().T @ np.tensordot(parts, turn.conj(), (1, 0))
    shapes = np.vstack([system.B, system.outputs]) @ modes.shapes
    sizes = contacts_and_outputs(np.abs(shapes) ** 2, held.size)
    return Limit(held, omega, ratios, shapes[: held.size], sizes, load)
