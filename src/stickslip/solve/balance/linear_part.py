"""The linear part of the balance: motion under loads and λ, receptance columns, the whole structure's motion.

Modal states of the linear structure, decoupled or triangular, decomposed once for all frequencies.

G'(s) = B (K + BᵀK_cB + s C + s² M)⁻¹ Bᵀ, s = iΩ, on the modes φ of the stuck structure, φᵀ(K + BᵀK_cB)φ = 1:

* C diagonal on them: gain 1/(1 + s c + s² m). Massless motions have m = 0 and need no special case; a rigid body on its
  contacts neither.
* C general: with f, η on those modes, η = [0 I](I − s S)⁻¹[0; I] f, S = [[0, √m], [−√m, −c]], nearly normal where damping is
  light. The eigenvectors of S give poles σ, gain 1/(1 − s σ), pairs of which are kept real as 2 x 2 blocks. Where the
  eigenvectors are nearly dependent (critical damping), the real Schur form of S: triangular but for 2 x 2 blocks, solved from
  its end, exact whatever the damping.

Harmonics may see structures of their own, complex Hermitian ones: `wave_states`.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.problem import Problem
from stickslip.model.problem.systems import HarmonicSystems, LinearSystem, Wave, uncoupled_beyond
from stickslip.solve.balance.fourier import Harmonics, highest, orders
from stickslip.solve.balance.receptance import (
    BLOCK,
    BLOCK_FIRST,
    BLOCK_SECOND,
    PAIR_FIRST,
    PAIR_SECOND,
    REAL_MODE,
    REAL_POLE,
    WAVE_FIRST,
    WAVE_SECOND,
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
from stickslip.support.checks import Array, Index, InputError
from stickslip.support.kernels import boxed, compiled, kernel
from stickslip.support.kernels.arrays import empty_table, zero_table
from stickslip.support.kernels.views import view

NEGLIGIBLE, ROUNDED = 1e-8, 1e-10
"""Modal damping off the diagonal that does not couple modes i and j: of √(c_i c_j), and of the largest damping, as it rounds.

Modes as close as those of two equal blades couple by about 1e-9 √(c_i c_j) where their damping is modal. Taken for coupling, that
makes every mode complex: 996 real states become 1992 complex ones, for a tip that differs in the eleventh digit.
"""

ROUNDING = 1e-12
"""Negative squares of 1/ω, relative to the largest, up to which they are rounding."""

ACCURACY = 1e-9
"""To which eigenvectors must reproduce direct solutions across the spectrum."""

CONDITION = 1e5
"""Of a pole, 1/|yᴴx| with its unit eigenvectors x and y (Wilkinson), beyond which eigenvectors count as nearly dependent.

Rounding ε splits a double pole with one eigenvector by √ε, which gives 1e7 to 1e8 whatever the last bits; only a pair of poles
within about 1e-10 of coalescing passes the limit, and below it rounding grows to 1e-11 at most.
"""

STILL = 1e30
"""1/ω² [s²] of a state that follows the mean alone: at 1e-6 rad/s its gain is 1e-18 already."""

FIRSTS, SECONDS = (PAIR_FIRST, BLOCK_FIRST, WAVE_FIRST), (PAIR_SECOND, BLOCK_SECOND, WAVE_SECOND)


class StuckModes(NamedTuple):
    """Real modes of the stuck structure, φᵀK'φ = 1: shapes (n, m) and squares of 1/ω (m,), ascending in frequency."""

    shapes: Array
    inverse_squares: Array


def stuck_modes(M: Array, stiffness: Array) -> StuckModes:
    """Modes of (stiffness, M), stiffness positive definite, M positive semi-definite."""
    inverse_squares, shapes = linalg.eigh(M, stiffness)
    order = np.argsort(-inverse_squares)
    return StuckModes(np.ascontiguousarray(shapes[:, order]), _without_rounding(inverse_squares[order]))


def _without_rounding(inverse_squares: Array) -> Array:
    """Squares of 1/ω without the negative rounding of massless motions; those that a speed stiffens beyond their inertia stay."""
    largest = np.abs(inverse_squares).max(initial=0.0)
    return np.where((inverse_squares < 0.0) & (inverse_squares > -ROUNDING * largest), 0.0, inverse_squares)


def is_diagonal(damping: NDArray[Any]) -> bool:
    """Whether the modal damping φᴴCφ (m, m) leaves the modes uncoupled but for rounding."""
    diagonal = np.abs(np.diag(damping))
    limits = NEGLIGIBLE * np.sqrt(np.outer(diagonal, diagonal)) + ROUNDED * diagonal.max(initial=1e-290)
    return bool(np.all(np.abs(damping - np.diag(np.diag(damping))) <= limits))


class States(NamedTuple):
    """States of a structure: q = output (n, m) · Γ · (inputᵀ p), input (n, m), motion = shape (rows, m) · Γ · (receiverᵀ λ),
    receiver (contact rows, m); kind, p, q, r, above as in `Modes`."""

    output: Array
    input: Array
    shape: Array
    receiver: Array
    kind: Index
    p: Array
    q: Array
    r: Array
    above: Array


def states(system: LinearSystem) -> States:
    """Decouple M q̈ + C q̇ + K q = p of one real structure as far as it can be done accurately."""
    modes, C = stuck_modes(system.M, system.K), system.C
    damping = modes.shapes.T @ C @ modes.shapes
    diagonal = np.diag(damping)
    if is_diagonal(damping):
        kind = np.full(modes.inverse_squares.size, REAL_MODE)
        return _real_states(system, modes.shapes, modes.shapes, kind, diagonal.copy(), modes.inverse_squares)
    return _complex_states(system, modes, damping) or schur_states(system, modes, damping)


def _real_states(
    system: LinearSystem, output: Array, source: Array, kind: Index, p: Array, q: Array, above: Array | None = None
) -> States:
    shape, receiver = np.vstack([system.B, system.outputs]) @ output, system.B @ source
    output, source, shape, receiver = (np.ascontiguousarray(part) for part in (output, source, shape, receiver))
    above = np.empty((0, 0)) if above is None else np.ascontiguousarray(above)
    return States(output, source, shape, receiver, kind.astype(np.int64), p, q, np.zeros(p.size), above)


def mean_states(problem: Problem) -> States | None:
    """States that springs on the mean add to those of the vibration; None without such springs.

    With compliance G₀ of the stuck structure and springs of stiffness k along D, the mean follows the loads by

        (K' + D k Dᵀ)⁻¹ = G₀ − g (k⁻¹ + Dᵀg)⁻¹ gᵀ,  g = G₀ D  (Woodbury).

    The second part is a state for each spring with a gain of 1 at harmonic 0 and of nothing at the others: a mode of an inertia
    beyond all others (`STILL`). So every harmonic shares the states of the vibration, which stay real.
    """
    if not problem.mean_springs:
        return None
    D = problem.structure.rows([spring.direction for spring in problem.mean_springs]).T
    g = linalg.cho_solve(linalg.cho_factor(problem.stuck_stiffness), D)
    compliance = np.diag([1.0 / spring.stiffness for spring in problem.mean_springs]) + D.T @ g
    source = -linalg.solve(compliance, g.T, assume_a="pos").T
    system, kind = problem.systems.at(1), np.full(len(D.T), REAL_MODE)
    return _real_states(system, g, source, kind, np.zeros(kind.size), np.full(kind.size, STILL))


def _first_order(inverse_squares: Array, damping: NDArray[Any]) -> NDArray[Any]:
    """S = [[0, √|m|], [∓√|m|, −c]], (2m, 2m), the lower sign of motions that the speed stiffens beyond their inertia, m < 0."""
    root = np.diag(np.sqrt(np.abs(inverse_squares)))
    return np.block([[np.zeros_like(root), root], [-np.sign(inverse_squares)[:, None] * root, -damping]])


def _eigenvectors(S: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]] | None:
    """Poles (2m,), unit right and matching left eigenvectors of S, left S right = diag(poles); None where nearly dependent."""
    poles, right = linalg.eig(S)
    try:
        left = np.linalg.inv(right)
    except np.linalg.LinAlgError:
        return None
    conditions = np.linalg.norm(left, axis=1)
    return (poles, right, left) if np.all(conditions <= CONDITION) else None


def _complex_states(system: LinearSystem, modes: StuckModes, damping: Array) -> States | None:
    """Complex modes; None where the eigenvectors of S are nearly dependent."""
    shapes, size = modes.shapes, modes.inverse_squares.size
    found = _eigenvectors(_first_order(modes.inverse_squares, damping))
    if found is None:
        return None
    poles, right, left = found[0], found[1], found[2][:, size:]
    if not _accurate(poles, right[size:], left, modes.inverse_squares, damping):
        return None
    output, source = shapes @ right[size:], shapes @ left.T
    real = np.flatnonzero(poles.imag == 0.0)
    upper = np.flatnonzero(poles.imag > 0.0)
    pairs = np.repeat(upper, 2)
    first = np.tile([True, False], upper.size)

    def interleaved(columns: NDArray[Any]) -> Array:
        chosen = columns[:, pairs]
        return np.hstack([np.where(first, chosen.real, chosen.imag), columns[:, real].real])

    kind = np.concatenate([np.tile([PAIR_FIRST, PAIR_SECOND], upper.size), np.full(real.size, REAL_POLE)])
    p, q = (np.concatenate([part[pairs], part[real]]) for part in (poles.real, poles.imag))
    return _real_states(system, interleaved(output), interleaved(source), kind, p, q)


def _accurate(poles: NDArray[Any], output: NDArray[Any], drive: NDArray[Any], squares: Array, damping: Array) -> bool:
    """Whether η = output (1 − s pole)⁻¹ drive f solves η + s c η + s² m η = f across the spectrum.

    Asked at |s| = ω, halfway between the imaginary axis, where an undamped motion has its pole, and the real one.
    """
    load = np.linspace(1.0, 2.0, squares.size)
    moving = squares[squares > 1e-12 * squares.max(initial=1e-300)]
    for frequency in 1.0 / np.sqrt(np.quantile(moving, [0.0, 0.3, 0.6, 1.0])):
        s = np.exp(0.25j * np.pi) * frequency
        motion = output @ ((drive @ load) / (1.0 - s * poles))
        error = motion + s * damping @ motion + s * s * squares * motion - load
        if not float(np.max(np.abs(error))) <= ACCURACY * float(np.max(np.abs(s * s * squares * motion)) + 2.0):
            return False
    return True


def schur_states(system: LinearSystem, modes: StuckModes, damping: Array) -> States:
    """States of the real Schur form S = U T Uᵀ, the first depending on the second and so on."""
    T, U = linalg.schur(_first_order(modes.inverse_squares, damping))
    size = T.shape[0]
    kind, p, q = np.full(size, REAL_POLE), np.diag(T).copy(), np.zeros(size)
    for j in np.flatnonzero(np.diag(T, -1)):
        kind[j : j + 2] = BLOCK_FIRST, BLOCK_SECOND
        q[j : j + 2] = T[j, j + 1], T[j + 1, j]
        T[j, j + 1] = 0.0
    shapes = modes.shapes @ U[modes.inverse_squares.size :]
    return _real_states(system, shapes, shapes, kind, p, q, np.triu(T, 1))


def wave_states(waves: Sequence[Wave], kept: tuple[NDArray[Any], int] | None = None) -> States:
    """States of the uncoupled complex Hermitian waves of a structure: motion shares ⊗ z of the sectors for motion z of a wave.

    kept: the shapes on which the waves are projected, and how many of these are modes, as `HarmonicSystems.kept` gives them.
    """
    parts = [(shares[:, None], _wave(system) if kept is None else _few(system, *kept)) for shares, system in waves]
    output = np.hstack([np.kron(shares, output) for shares, (output, *_) in parts])
    source = np.hstack([np.kron(shares, drive.conj().T) for shares, (_, drive, *_) in parts]).conj()
    shape, receiver, p, q = ([part[k] for _, part in parts] for k in range(2, 6))
    return _as_real(output, source, np.hstack(shape), np.hstack(receiver), np.concatenate(p), np.concatenate(q))


def _wave(system: LinearSystem) -> tuple[NDArray[Any], ...]:
    """q = output Γ drive p, motion = shape Γ receiverᵀ λ, p and q of the gains; refused where damping does not decouple well."""
    inverse_squares, shapes = linalg.eigh(system.M, system.K)
    squares = _without_rounding(inverse_squares)
    damping = shapes.conj().T @ system.C @ shapes
    diagonal = np.diag(damping)
    if is_diagonal(damping):
        output, drive, p, q = shapes, shapes.conj().T, diagonal, squares
    else:
        poles, drive, output = _poles(squares, damping)
        output, drive, p, q = shapes @ output, drive @ shapes.conj().T, -poles, np.zeros(poles.size)
    return output, drive, np.vstack([system.B, system.outputs]) @ output, (drive @ system.B.conj().T).T, p, q


def _few(system: LinearSystem, shapes: NDArray[Any], modes: int) -> tuple[NDArray[Any], ...]:
    """As `_wave`, of the system projected on shapes (n, kept), the first of which are modes."""
    adjoint = shapes.conj().T
    M, C, K = (adjoint @ matrix @ shapes for matrix in system[:3])
    output, drive, *rest = _wave(LinearSystem(M, uncoupled_beyond(modes, C), K, system.B @ shapes, system.outputs @ shapes))
    return shapes @ output, drive @ adjoint, *rest


def _poles(squares: Array, damping: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """η = output (1 − s pole)⁻¹ drive f of η + s c η + s² m η = f."""
    size = squares.size
    found = _eigenvectors(_first_order(squares, damping))
    if found is None:
        raise InputError(
            "The damping of a disk must decouple into modes, but two of them are critically damped together. "
            "Use modal damping, or change C a little."
        )
    poles, right, left = found
    return poles, left[:, size:], right[size:]


def _as_real(*given: NDArray[Any]) -> States:
    """Complex output, source, shape, receiver, p and q as real states: x and i x for each, x alone where all is real."""
    parts, p, q = given[:4], given[4].astype(complex), given[5]
    if not any(np.iscomplexobj(part) and part.imag.any() for part in (*parts, p)):
        output, source, shape, receiver = (np.ascontiguousarray(part.real) for part in parts)
        return States(
            output, source, shape, receiver, np.full(q.size, REAL_MODE), p.real.copy(), q, np.zeros(q.size), np.empty((0, 0))
        )
    output, source, shape, receiver = (np.stack([x.real, x.imag], axis=2).reshape(x.shape[0], 2 * x.shape[1]) for x in parts)
    kind, real, squares, imaginary = np.tile([WAVE_FIRST, WAVE_SECOND], q.size), *(np.repeat(x, 2) for x in (p.real, q, p.imag))
    return States(output, source, shape, receiver, kind, real, squares, imaginary, np.empty((0, 0)))


def partners(kind: Index) -> Index:
    """The state that shares a 2 x 2 block with each state; itself when alone."""
    own = np.arange(kind.size)
    return own + np.isin(kind, FIRSTS).astype(np.int64) - np.isin(kind, SECONDS)


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

    def weights_of_change(self, weights: Array, omega: float) -> Array:
        """Weights of forces δλ (contact rows, 2H+1) in the sum of the motions that they change, each with its weight (rows,
        2H+1): −G'ᵀ times these."""
        return _weights_of_change(self.modes, np.ascontiguousarray(weights), omega)

    def first_harmonics(self, omegas: Array, columns: Index) -> tuple[Complex, Complex]:
        """X_1 of the motion per unit force level (k, rows), and G' of harmonic 1 to all rows (k, rows, columns), at frequencies
        (k,)."""
        return _first_harmonics(self.modes, omegas, columns)

    def whole_motion(self, forces: Array, omega: float, level: float) -> Array:
        """Motion of every coordinate of the structure (n, 2H+1), m: of every degree of freedom, unless these are more."""
        return _motion(self._whole, self.highest, forces, omega, level)

    def weights_of_whole_change(self, weights: Array, omega: float) -> Array:
        """The same with weights of q (n, 2H+1)."""
        return _weights_of_change(self._whole, np.ascontiguousarray(weights), omega)


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
def _weights_of_change(given: Modes, weights: Array, omega: float) -> Array:
    modes = view(given)
    rows, gains = modes.receiver.shape[0], frequency_gains(modes, omega, (weights.shape[1] - 1) // 2)
    found = empty_table(rows, weights.shape[1])
    for first in range(0, rows, BLOCK):
        some = np.arange(first, min(first + BLOCK, rows))
        found[first : first + some.size] = pulled(modes, driven_states(modes, gains, omega, some), weights)
    return boxed(found)


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
