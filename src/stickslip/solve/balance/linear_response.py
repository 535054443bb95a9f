"""Linear limits of a response curve and their resonance peaks: contacts absent and contacts stuck.

The structure without its contacts: the first harmonic of its motion, a limit of every response curve.
"""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE, Measure
from stickslip.support.checks import Array

Complex = NDArray[np.complex128]

TRIED = 200
"""Frequencies, about, among which those few are chosen that are solved exactly."""

AGREED = 1e-10
"""Relative difference of predicted and exact motion that ends their choice, twice in turn."""


def solutions(matrices: NDArray[Any], right: NDArray[Any]) -> NDArray[Any]:
    """Solutions (k, n) of systems (k, n, n) with right-hand sides (k, n); NaN of those that are singular."""
    try:
        return np.asarray(np.linalg.solve(matrices, right[..., None])[..., 0])
    except np.linalg.LinAlgError:
        if len(matrices) == 1:
            return np.full_like(right, np.nan)
        return np.concatenate([solutions(matrices[k : k + 1], right[k : k + 1]) for k in range(len(matrices))])


@dataclass(frozen=True)
class WithoutContacts:
    """The first harmonic q of the structure without contacts per unit force level, (K + iωC − ω²M) q = Σ_k ω^k loads[k].

    M, C, K (n, n), loads (powers, n); outputs (outputs, n). shapes (dofs, n): the motion of the degrees of freedom.
    """

    M: NDArray[Any]
    C: NDArray[Any]
    K: NDArray[Any]
    loads: Complex
    outputs: NDArray[Any]
    shapes: NDArray[Any] | None

    @classmethod
    def of(cls, balance: HarmonicBalance) -> Self:
        """That of a problem."""
        system = balance.problem.systems.at(1)
        M, C, K = system.M, system.C, system.without_contacts(balance.stiffness)
        powers = balance.problem.load_powers(balance.highest)
        loads = powers[:, :, 1] - 1j * powers[:, :, 2]
        if (kept := balance.problem.systems.kept(1)) is None:
            return cls(M, C, K, loads, system.outputs, None)
        shapes = kept[0]
        M, C, K = (shapes.conj().T @ matrix @ shapes for matrix in (M, C, K))
        return cls(M, C, K, loads @ shapes.conj(), system.outputs @ shapes, shapes)

    def motion(self, omega: float) -> Complex:
        """Motion of the degrees of freedom at ω, m; NaN at an undamped resonance."""
        found = self._at(omega)
        return found if self.shapes is None else np.asarray(self.shapes @ found, dtype=complex)

    def _at(self, omega: float) -> Complex:
        matrix = self.K + 1j * omega * self.C - omega**2 * self.M
        load = omega ** np.arange(len(self.loads)) @ self.loads
        return np.asarray(solutions(matrix[None], load[None])[0], dtype=complex)

    def outputs_at(self, omegas: Array) -> Complex:
        """Motion of the outputs (k, outputs) at frequencies (k,), m.

        By Galerkin's method on V, the solutions at few of the frequencies: VᴴA(ω)V y = Vᴴf(ω), q = V y. Where the residual
        f − A V y is largest the next solution is computed, until two in turn are what was predicted.
        """
        tried = omegas[:: 1 + omegas.size // TRIED]
        basis, agreed, left = np.empty((len(self.K), 0)), 0, np.full(tried.size, True)
        predicted, residual = np.zeros((tried.size, len(self.outputs)), dtype=complex), np.ones(tried.size)
        while agreed < 2 and left.any() and basis.shape[1] < len(basis):
            k = int(np.argmax(np.where(left, residual, -1.0)))
            motion, left[k] = self._at(tried[k]), False
            if np.isfinite(motion).all():
                exact = self.outputs @ motion
                agreed = agreed + 1 if np.abs(exact - predicted[k]).max() <= AGREED * np.abs(exact).max() else 0
                basis = _joined(basis, motion, np.isrealobj(self.M))
                predicted, residual = self._on(basis, tried)
        if not basis.shape[1]:
            return np.full((omegas.size, len(self.outputs)), complex(np.nan, np.nan))
        return self._on(basis, omegas)[0]

    def _on(self, basis: NDArray[Any], omegas: Array) -> tuple[Complex, Array]:
        """Motion of the outputs (k, outputs) by a basis (n, m), and the size (k,) of its residual, each row over its own √K."""
        powers = omegas[:, None] ** np.arange(len(self.loads))
        stiff, damped, heavy = (matrix @ basis for matrix in (self.K, self.C, self.M))
        reduced = [basis.conj().T @ each for each in (stiff, damped, heavy)]
        omega = omegas[:, None, None]
        y = solutions(reduced[0] + 1j * omega * reduced[1] - omega**2 * reduced[2], powers @ (self.loads @ basis.conj()))
        turned = y * omegas[:, None]
        missing = powers @ self.loads - y @ stiff.T - 1j * turned @ damped.T + (turned * omegas[:, None]) @ heavy.T
        own = np.sqrt(np.maximum(np.abs(np.diag(self.K)), np.finfo(float).tiny))
        return y @ (self.outputs @ basis).T, np.nan_to_num(np.linalg.norm(missing / own, axis=1))


def _joined(basis: NDArray[Any], motion: Complex, real: bool) -> NDArray[Any]:
    """A basis of orthonormal columns with one more motion in it; of a real structure, with its real and imaginary part."""
    for column in (motion.real, motion.imag) if real else (motion,):
        length = np.linalg.norm(column)
        for _ in range(2):
            column = column - basis @ (basis.conj().T @ column)
        rest = np.linalg.norm(column)
        if rest > 1e-13 * length:
            basis = np.column_stack([basis, column / rest])
    return basis


POINTS = 400
TOGETHER = 100_000
"""Entries of matrices that are solved together."""
BY_ROWS = 100
"""Contact rows up to which every frequency is solved on them; with more, exact solutions at few frequencies give all others."""
RESOLUTION = np.concatenate([-np.geomspace(30.0, 0.05, 20), [0.0], np.geomspace(0.05, 30.0, 20)])
"""Extra frequencies around each resonance, in half widths ζ f."""


def linear_frequencies(balance: HarmonicBalance, low: float, high: float) -> Array:
    """Frequencies in Hz between low and high, denser around the resonances of the free and of the stuck structure."""
    problem = balance.problem
    natural = np.concatenate([problem.frequencies(stuck=False), problem.frequencies(stuck=True)])
    inside = natural[(natural >= low) & (natural <= high)]
    width = (high - low) / (50.0 * POINTS)
    extra = [f + RESOLUTION * max(5e-4 * f, width) for f in inside]
    grid = np.unique(np.concatenate([np.linspace(low, high, POINTS), *extra]))
    return np.asarray(grid[(grid >= low) & (grid <= high)])


def linear_amplitudes(balance: HarmonicBalance, frequencies: Array) -> tuple[Array, Array]:
    """|X_1| per unit force level of every output, free and stuck: two arrays (frequencies, outputs), m.

    Free means F = λ + K_c w = 0, so w = e' + G'K_c w. With many contact rows the structure's own equation without contacts is
    solved in place of that. NaN at an undamped resonance met exactly.
    """
    rows, omegas = balance.rows, 2.0 * np.pi * frequencies
    by_rows = rows <= BY_ROWS
    contacts = np.arange(rows if by_rows else 0)
    stuck, free = [], []
    for some in np.array_split(omegas, 1 + omegas.size * contacts.size**2 // TOGETHER):
        motion, softened = balance.linear.first_harmonics(some, contacts)
        stuck.append(motion[:, rows:])
        if by_rows:
            softened *= balance.stiffness
            moving = solutions(np.eye(rows) - softened[:, :rows], motion[:, :rows])
            free.append(motion[:, rows:] + (softened[:, rows:] @ moving[..., None])[..., 0])
    if not by_rows:
        free = [WithoutContacts.of(balance).outputs_at(omegas)]
    return np.abs(np.concatenate(free)), np.abs(np.concatenate(stuck))


NEAR = 0.02
"""Share of a natural frequency within which its peak is sought first."""

WIDEST = 0.3
"""The share is doubled where the search ends at it, as with much damping, until it is beyond this."""


@dataclass(frozen=True)
class LinearPeak:
    """frequency [Hz] and size per unit force level of the highest peak of an output; NaN without damping."""

    frequency: float
    amplitude: float


def linear_peak(
    balance: HarmonicBalance,
    output: int,
    stuck: bool,
    measure: Measure = DISPLACEMENT_AMPLITUDE,
    band: tuple[float, float] = (0.0, np.inf),
) -> LinearPeak:
    """The resonance peak of an output without nonlinearity, as a measure of its first harmonic alone, of the mode that has the
    highest displacement: accelerations of higher modes, which no band holds, do not count.

    band: in Hz; of its modes where it holds any, else of all.
    """

    def amplitude(frequency: float) -> float:
        with np.errstate(all="ignore"):
            value = linear_amplitudes(balance, np.array([frequency]))[int(stuck)][0, output]
        return float(value) if np.isfinite(value) else np.inf

    def size(frequency: float) -> float:
        return float(measure.of_harmonic(np.array(amplitude(frequency)), np.array(2.0 * np.pi * frequency)))

    natural = balance.problem.frequencies(stuck=stuck)
    natural = natural[natural > 1e-4 * natural[-1]]
    inside = natural[(natural >= band[0]) & (natural <= band[1])]
    natural = inside if inside.size else natural
    if not balance.problem.damped:
        sizes = [amplitude(1.001 * f) for f in natural]
        return LinearPeak(float(natural[int(np.argmax(sizes))]), np.nan)
    best = float(natural[int(np.argmax([amplitude(f) for f in natural]))])
    near = NEAR
    while True:
        ends = ((1.0 - near) * best, (1.0 + near) * best)
        found = scipy.optimize.minimize_scalar(lambda f: -size(f), bounds=ends, method="bounded", options={"xatol": 1e-7 * best})
        if abs(float(found.x) / best - 1.0) < 0.99 * near or near > WIDEST:
            return LinearPeak(float(found.x), float(-found.fun))
        near *= 2.0
