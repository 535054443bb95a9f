"""The linear part of the balance: motion under loads and λ, receptance columns, the whole structure's motion."""

from __future__ import annotations

from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np

from stickslip.model.problem import Problem
from stickslip.model.problem.systems import HarmonicSystems, Wave
from stickslip.solve.balance.decoupling import States, mean_states, partners, states, wave_states
from stickslip.solve.balance.orders import Harmonics, highest, orders
from stickslip.solve.balance.receptance import (
    Complex,
    Modes,
    change,
    driven_states,
    frequency_gains,
    modal_states,
    motion,
    motion_slope,
    pulled,
    receptance,
)
from stickslip.solve.balance.resonances import Resonances
from stickslip.support.checks import Array, Index
from stickslip.support.kernels import boxed, compiled, kernel
from stickslip.support.kernels.arrays import zero_table
from stickslip.support.kernels.views import view


class LinearPart:
    """The structure on its stuck contacts as `Modes`: one set of states, or one for each wave that the harmonics see."""

    def __init__(self, problem: Problem, harmonics: Harmonics) -> None:
        H, held = highest(harmonics), orders(harmonics)
        powers = problem.static_powers
        static = np.zeros((*powers.shape, 2 * H + 1))
        static[:, :, 0] = powers
        systems = problem.systems
        groups = _states(systems, held)
        joined = _joined([part for _, part in groups])
        first, last, end = np.zeros(H + 1, dtype=np.int64), np.zeros(H + 1, dtype=np.int64), 0
        for sharing, part in groups:
            first[sharing], end = end, end + part.kind.size
            last[sharing] = end
        kind = joined.kind
        self.problem, self.harmonics, self.highest = problem, harmonics, H
        self.modes = Modes(
            shape=joined.shape,
            receiver=joined.receiver,
            static=np.ascontiguousarray(joined.input.T @ static),
            dynamic=np.ascontiguousarray(joined.input.T @ problem.load_powers(H)),
            kind=kind,
            p=joined.p,
            q=joined.q,
            r=joined.r,
            partner=partners(kind),
            above=joined.above,
            first=first,
            last=last,
            order=np.array([systems.order(h) for h in range(H + 1)], dtype=np.int64),
            **_coordinates(systems, joined),
        )
        compiled(modal_states)
        self._whole = self.modes._replace(shape=joined.output)

    @cached_property
    def resonances(self) -> Resonances:
        """Where the harmonics may meet a resonance."""
        return Resonances(self.problem, self.harmonics)

    def motion(self, forces: Array, omega: float, level: float) -> Array:
        """Motion (rows, 2H+1) of contact rows and outputs; forces λ (contact rows, 2H+1)."""
        return _motion(self.modes, self.highest, forces, omega, level)

    def slope(self, forces: Array, omega: float, level: float, by_level: bool) -> Array:
        """Derivative of the motion by the force level, or by ω, at fixed λ."""
        return _slope(self.modes, self.highest, forces, omega, level, by_level)

    def change(self, forces: Array, omega: float) -> Array:
        """Change of motion −G'δλ (rows, 2H+1) for a change of forces δλ."""
        return _change(self.modes, self.highest, np.ascontiguousarray(forces), omega)

    def receptance(self, omega: float, harmonics: int, rows: Index, columns: Index) -> Array:
        """G' (2, H+1, rows, columns), real and imaginary part."""
        return np.ascontiguousarray(_receptance(self.modes, omega, harmonics, rows, columns).transpose(1, 2, 0, 3))

    def first_harmonics(self, omegas: Array, columns: Index) -> tuple[Complex, Complex]:
        """X_1 of the motion per unit force level (k, rows), and G' of harmonic 1 to all rows (k, rows, columns), at frequencies
        (k,)."""
        return _first_harmonics(self.modes, omegas, columns)

    def pulled(self, omega: float, weighted: Array, columns: Index) -> Array:
        """−weightedᵀ G' (columns, 2H+1) for weights on the motion (rows, 2H+1)."""
        return _pulled(self.modes, omega, weighted, columns)

    def whole_motion(self, forces: Array, omega: float, level: float) -> Array:
        """Motion of every coordinate of the structure (n, 2H+1), m: of every degree of freedom, unless these are more."""
        return _motion(self._whole, self.highest, forces, omega, level)

    def whole_change(self, forces: Array, omega: float) -> Array:
        """Change of q (n, 2H+1) for a change of forces δλ."""
        return _change(self._whole, self.highest, np.ascontiguousarray(forces), omega)


@kernel
def _motion(given: Modes, harmonics: int, forces: Array, omega: float, level: float) -> Array:
    modes = view(given)
    return boxed(motion(modes, frequency_gains(modes, omega, harmonics), forces, omega, level))


@kernel
def _slope(given: Modes, harmonics: int, forces: Array, omega: float, level: float, by_level: bool) -> Array:
    modes = view(given)
    return boxed(motion_slope(modes, frequency_gains(modes, omega, harmonics), forces, omega, level, by_level))


@kernel
def _change(given: Modes, harmonics: int, forces: Array, omega: float) -> Array:
    modes = view(given)
    return boxed(change(modes, frequency_gains(modes, omega, harmonics), forces, omega))


@kernel
def _receptance(given: Modes, omega: float, harmonics: int, rows: Index, columns: Index) -> Array:
    modes = view(given)
    return boxed(receptance(modes, driven_states(modes, frequency_gains(modes, omega, harmonics), omega, columns), rows))


@kernel
def _first_harmonics(given: Modes, omegas: Array, columns: Index) -> tuple[Complex, Complex]:
    modes = view(given)
    rows = np.arange(modes.shape.shape[0])
    found = np.empty((omegas.size, rows.size), dtype=np.complex128)
    response = np.empty((omegas.size, rows.size, columns.size), dtype=np.complex128)
    none = zero_table(modes.receiver.shape[0], modes.dynamic.shape[2])
    for k in range(omegas.size):
        gains = frequency_gains(modes, omegas[k], 1)
        by_level = motion_slope(modes, gains, none, omegas[k], 0.0, True)
        driven = receptance(modes, driven_states(modes, gains, omegas[k], columns), rows)
        for r in range(rows.size):
            found[k, r] = complex(by_level[r, 1], -by_level[r, 2])
            for c in range(columns.size):
                response[k, r, c] = complex(driven[r, 0, 1, c], driven[r, 1, 1, c])
    return boxed((found, response))


@kernel
def _pulled(given: Modes, omega: float, weighted: Array, columns: Index) -> Array:
    modes, harmonics = view(given), (weighted.shape[1] - 1) // 2
    return boxed(pulled(modes, driven_states(modes, frequency_gains(modes, omega, harmonics), omega, columns), weighted))


_SHARED: WeakKeyDictionary[HarmonicSystems, States] = WeakKeyDictionary()
"""States that all harmonics of a problem share, as long as the problem is there: balances of other harmonics have the same."""


def _states(systems: HarmonicSystems, harmonics: tuple[int, ...]) -> list[tuple[list[int], States]]:
    """The harmonics that share states, and these."""
    if systems.alike:
        if (shared := _SHARED.get(systems)) is None:
            own = wave_states(systems.waves(1)) if systems.uncoupled else states(systems.at(1))
            springs = mean_states(systems.problem)
            shared = _SHARED[systems] = own if springs is None else _joined([own, springs])
        return [(list(harmonics), shared)]
    keys = [systems.key(h) for h in harmonics]
    sharing = {key: [h for h, own in zip(harmonics, keys, strict=True) if own == key] for key in reversed(keys)}
    return [(those, wave_states(_waves(systems, those), systems.kept(those[0]))) for those in sharing.values()]


def _coordinates(systems: HarmonicSystems, joined: States) -> dict[str, Array]:
    """The degrees of freedom as a basis of the motion, where they are fewer than the states of one structure."""
    none = np.empty((0, 0))
    size = joined.kind.size - len(systems.problem.mean_springs)
    if not systems.alike or systems.uncoupled or joined.output.shape[0] >= size:
        return {"basis": none, "output": none, "input": none}
    system = systems.at(0)
    basis = np.ascontiguousarray(np.vstack([system.B, system.outputs]), dtype=float)
    return {"basis": basis, "output": joined.output, "input": joined.input}


def _waves(systems: HarmonicSystems, harmonics: list[int]) -> list[Wave]:
    """The waves that some harmonics share; the mean alone meets no damping, which might couple what else decouples."""
    waves = systems.waves(harmonics[0])
    if harmonics != [0]:
        return list(waves)
    return [Wave(shares, system._replace(C=np.zeros_like(system.C))) for shares, system in waves]


def _joined(parts: list[States]) -> States:
    """The states of all parts, one after the other; only those of the first may drive each other."""
    names = States._fields[:-1]
    joined = {name: np.ascontiguousarray(np.hstack([getattr(part, name) for part in parts])) for name in names}
    above, size = parts[0].above, joined["kind"].size
    return States(**joined, above=np.pad(above, (0, size - len(above))) if above.size else above)
