"""Forced responses from one nonlinear mode: curves, the peaks of all force levels, phase resonance.

At modal amplitude a the mode moves by aΦ at the first harmonic. Free, this obeys the equation of motion at ω with the force
2iζω² M aΦ; forced at Ω with the same motion, projected on Φ (m = ΦᴴMΦ, c = ΦᴴCΦ, f = ΦᴴP),

    a (m (ω² − Ω²) + i (2ζω² m + c (Ω − ω))) = F f e^(−iθ),

since friction does not change with the frequency and viscous damping goes with it. The sizes of both sides give Ω for each a,
their angle the phase θ of the motion. The other modes of the stuck structure add their linear response to F P, as in the
single-mode method of W. Szemplińska-Stupnicka (Journal of Sound and Vibration 63, 1979).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.analyses.response_dataset import of_parts
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.solve.balance.mode_balance import ModalStructures
from stickslip.solve.balance.mode_iteration import extended_gains_called
from stickslip.support.checks import Array, fault, several
from stickslip.support.late import pd, xr
from stickslip.support.outcome import Outcome

ForcePattern = Sequence[Force]
Complex = NDArray[np.complex128]

FINER = 8
"""Places on a synthesised curve for each interval between two points of the mode."""

SATURATED, LAST = 0.05, 1.2
"""Growth of ln of the force with ln of the amplitude below which the force is saturated at the end of a curve, and the ratio of
amplitudes over which it is measured there."""

SATURATION = (
    "At the end of the curve the force no longer grows with the amplitude: contacts hold no more, and where nothing else damps "
    "the mode a larger force has no finite peak. Give the structure damping."
)

CLOSEST = 1e-12
"""The least arc length between neighbouring points."""

BISECTIONS = 45
"""Halvings of the interval between two points that holds a peak: to rounding."""


@dataclass(frozen=True, eq=False)
class ModePath:
    """A mode at places along its curve: ω, ζ, m, c, f, a and Φ at the outputs, each (places,) or (places, outputs).

    force, outputs and the masses belong to unit modal amplitude.
    """

    omega: Array
    zeta: Array
    mass: Array
    viscous: Array
    amplitude: Array
    force: Complex
    outputs: Complex

    @classmethod
    def of_points(cls, chosen: xr.Dataset, problem: Problem, followed: Complex, load: Complex) -> tuple[ModePath, Array]:
        """The points of one case of a dataset, and the derivatives of `columns` by the arc length; followed: stuck shape (n,).

        The phase is that of the followed mode, whose coordinate is real.
        """
        system, amplitude = problem.systems.at(1), chosen["modal_amplitude"].to_numpy()
        shape, slope = (of_parts(chosen[name].values) / amplitude[:, None] for name in ("mode_shape", "shape_slope"))
        coordinate = shape @ (system.M @ followed).conj()
        turn = (coordinate.conj() / np.abs(coordinate))[:, None]
        rise, bend, damped = (chosen[f"{name}_slope"].to_numpy() for name in ("amplitude", "frequency", "damping"))
        shape = turn * shape
        slope = turn * slope - rise[:, None] * shape
        mass, viscous = (chosen[name].to_numpy() / amplitude**2 for name in ("modal_mass", "modal_damping"))
        slopes = [2.0 * np.real(np.sum((shape.conj() @ matrix) * slope, axis=1)) for matrix in (system.M, system.C)]
        omega, zeta = 2.0 * np.pi * chosen["frequency"].to_numpy(), chosen["damping_ratio"].to_numpy()
        outputs = (shape @ system.outputs.T, slope @ system.outputs.T)
        mode = cls(omega, zeta, mass, viscous, amplitude, shape.conj() @ load, outputs[0])
        force = slope.conj() @ load
        rest = np.stack([bend, slopes[0] / mass, rise, damped, slopes[1], force.real, force.imag], axis=1)
        return mode, np.concatenate([rest, outputs[1].real, outputs[1].imag], axis=1)

    @classmethod
    def of_columns(cls, columns: Array) -> ModePath:
        """From `columns`."""
        logarithms, rest = np.exp(columns[:, :3]), columns[:, 3:]
        outputs = (rest.shape[1] - 4) // 2
        parts = rest[:, 4 : 4 + outputs] + 1j * rest[:, 4 + outputs :]
        omega, mass, amplitude = logarithms.T
        return cls(omega, rest[:, 0], mass, rest[:, 1], amplitude, rest[:, 2] + 1j * rest[:, 3], parts)

    @property
    def columns(self) -> Array:
        """What is interpolated along the curve: ln ω, ln m, ln a, ζ, c, f, Φ, (places, columns)."""
        logarithms = np.log(np.stack([self.omega, self.mass, self.amplitude], axis=1))
        rest = np.stack([self.zeta, self.viscous, self.force.real, self.force.imag], axis=1)
        return np.concatenate([logarithms, rest, self.outputs.real, self.outputs.imag], axis=1)

    @property
    def own_lag(self) -> Array:
        """2ζω² m − c ω: the quadrature part of the projected equation at Ω = 0."""
        return np.asarray(2.0 * self.zeta * self.omega**2 * self.mass - self.viscous * self.omega)

    @property
    def quadrature(self) -> Array:
        """Force level of phase resonance, 2ζω² m a/|f|."""
        return np.asarray(2.0 * self.zeta * self.omega**2 * self.mass * self.amplitude / np.abs(self.force))

    def dynamic(self, omega: Array) -> Complex:
        """Left side of the projected equation at Ω."""
        return np.asarray(self.amplitude * (self.mass * (self.omega**2 - omega**2) + 1j * (self.own_lag + self.viscous * omega)))

    def easiest(self) -> Array:
        """The frequency at which the smallest force makes the amplitude, rad/s: that of the peak of this force."""
        omega, m, c = self.omega.copy(), self.mass, self.viscous
        for _ in range(30):
            slope = -4.0 * m**2 * (self.omega**2 - omega**2) * omega + 2.0 * (self.own_lag + c * omega) * c
            bend = m**2 * (12.0 * omega**2 - 4.0 * self.omega**2) + 2.0 * c**2
            change = np.where(bend > 0.0, slope / np.where(bend > 0.0, bend, 1.0), 0.0)
            omega = np.maximum(omega - change, 1e-3 * self.omega)
        return np.asarray(omega)

    def level_of_peak(self) -> Array:
        """The force level whose peak has the amplitude."""
        return np.asarray(np.abs(self.dynamic(self.easiest())) / np.abs(self.force))


@dataclass(frozen=True, eq=False)
class OtherModes:
    """The stuck structure without the followed mode, under the first harmonic of the forces."""

    structures: ModalStructures
    followed: int
    load: Complex

    @classmethod
    def of(cls, problem: Problem, followed: int, load: Complex) -> OtherModes:
        """Load: P₁ of the degrees of freedom."""
        structures = ModalStructures(problem, (1,), 1)
        driven = structures.whole[structures.key[1]].conj().T @ load
        driven[followed] = 0.0
        return cls(structures, followed, np.asarray(driven, dtype=complex))

    def coordinates(self, omega: Array) -> Iterator[Complex]:
        """First harmonic of the coordinates of the stuck modes per force level, (modes,) at each frequency."""
        structure = self.structures.extended(self.followed, 1)
        for each in omega:
            gains = extended_gains_called(structure, float(each), 0.0)[1]
            yield gains[0] * self.load if gains.shape[0] == 1 else gains @ self.load

    def at(self, omega: Array) -> Complex:
        """First harmonic of the outputs per force level, (places, outputs)."""
        rows = self.structures.shapes[self.structures.key[1]][-self.outputs :]
        return np.array([rows @ each for each in self.coordinates(omega)], dtype=complex).reshape(omega.size, self.outputs)

    def size(self, omega: Array) -> Array:
        """√(2 × largest elastic energy) of the first harmonic per force level, √J, (places,)."""
        return np.array([np.linalg.norm(each) for each in self.coordinates(omega)], dtype=float)

    @property
    def stuck_shape(self) -> Complex:
        """Of the followed mode, stuck, at every degree of freedom."""
        return np.asarray(self.structures.whole[self.structures.key[1]][:, self.followed], dtype=complex)

    @property
    def frequency(self) -> float:
        """Of the followed mode, stuck, rad/s."""
        return float(1.0 / np.sqrt(self.structures.squares[self.structures.key[1]][self.followed]))

    @property
    def outputs(self) -> int:
        return self.structures.outputs


@dataclass(frozen=True, eq=False)
class Synthesis:
    """The forced responses of one mode under one pattern of forces; slopes: of the columns of the mode by the arc length; lost:
    how its curve ended before the largest amplitude, empty where it did not."""

    mode: ModePath
    slopes: Array
    others: OtherModes
    lost: str

    @classmethod
    def of(cls, dataset: xr.Dataset, problem: Problem, case: int, forces: ForcePattern | None) -> Synthesis:
        """Of a case of a dataset; forces: other ones than those of the problem, whose parts at harmonic 1 count."""
        loaded = problem if forces is None else problem.with_forces(several("forces", forces))
        chosen = dataset.isel(case=case, point=np.flatnonzero(np.isfinite(dataset["frequency"][case].to_numpy())))
        if chosen.sizes["point"] < 2:
            raise fault("The curve of the mode", "must have two or more points", str(dataset["case_message"][case].item()))
        powers = loaded.load_powers(max((h for force in loaded.forces for h in force.factors), default=1))
        if len(powers) > 1:
            raise fault("The forces", "must not go by the frequency in a synthesis from modes", "a moving base or an unbalance")
        load = np.asarray(powers[0][:, 1] - 1j * powers[0][:, 2])
        others = OtherModes.of(loaded, int(dataset["mode_number"][case]) - 1, load)
        mode, slopes = ModePath.of_points(chosen, loaded, others.stuck_shape, load)
        shape = of_parts(chosen["mode_shape"].values) / mode.amplitude[:, None]
        if not np.all(np.abs(mode.force) > 1e-12 * np.linalg.norm(shape, axis=1) * np.linalg.norm(load)):
            raise fault("The forces", "must excite the mode", "ones that do no work on its motion")
        ended = int(dataset["case_outcome"][case]) == Outcome.CONVERGED
        return cls(mode, slopes, others, "" if ended else str(dataset["case_message"][case].item()))

    @cached_property
    def _places(self) -> Array:
        """Where the points are along the curve: arc length in ln a, ln ω and ζ, by chords."""
        mode = self.mode
        steps = np.diff(np.stack([np.log(mode.amplitude), np.log(mode.omega), mode.zeta]), axis=1)
        return np.concatenate([[0.0], np.cumsum(np.maximum(np.linalg.norm(steps, axis=0), CLOSEST))])

    @cached_property
    def _along(self) -> scipy.interpolate.CubicHermiteSpline:
        """The columns of the mode between its points, by the cubics that `mode_refine` has made right."""
        return scipy.interpolate.CubicHermiteSpline(self._places, self.mode.columns, self.slopes)

    @cached_property
    def _levels(self) -> Array:
        return self.mode.level_of_peak()

    def _refuse_beyond(self, levels: Array) -> None:
        """Refuse force levels whose peaks lie beyond the curve of the mode."""
        most = self._levels.max()
        if levels.size == 0 or not (levels.min() > 0.0 and levels.max() <= most):
            whose, remedy = "that of the largest amplitude of the mode", self.lost or "Compute the mode up to a larger amplitude."
            if saturated(self._levels, self.mode.amplitude):
                whose, remedy = "the most that the mode needs at any of its amplitudes", SATURATION
            raise fault("force_levels", f"must be positive and at most {most:.4g}, {whose}", levels.tolist(), remedy)

    def peaks(self, levels: Array, output: int) -> pd.DataFrame:
        """The peaks of force levels at an output, the highest of each level first."""
        self._refuse_beyond(levels)
        least = self._levels[0]
        # Which levels lie in which intervals between neighbouring ones of the mode.
        lower, upper = np.minimum(self._levels[:-1], self._levels[1:]), np.maximum(self._levels[:-1], self._levels[1:])
        which, intervals = np.nonzero((levels[:, None] > lower) & (levels[:, None] <= upper))
        places = self._solved(levels[which], intervals)
        low = np.flatnonzero(levels < least)
        share = np.concatenate([np.ones(which.size), levels[low] / least])
        which, places = np.concatenate([which, low]), np.concatenate([places, np.zeros(low.size)])
        mode = ModePath.of_columns(self._along(places))
        mode = replace(mode, amplitude=share * mode.amplitude)
        omega = mode.easiest()
        columns = {"force_level": levels[which], "frequency": omega / (2.0 * np.pi)}
        moved = self.moved(mode, omega, levels[which], output)
        columns["amplitude"] = np.abs(moved)
        columns |= {"modal_amplitude": mode.amplitude, "damping_ratio": mode.zeta}
        columns["other_modes"] = self.other_modes(mode, omega, levels[which])
        columns["phase"] = np.angle(moved)
        table = pd.DataFrame(columns)
        return table.iloc[np.lexsort((-table["amplitude"], which))].reset_index(drop=True)

    def _solved(self, levels: Array, intervals: NDArray[np.intp]) -> Array:
        """Places inside intervals, each from a point to the next one, whose peaks belong to force levels."""
        low, high = self._places[intervals], self._places[intervals + 1]
        rising = self._levels[intervals + 1] > self._levels[intervals]
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            below = (ModePath.of_columns(self._along(middle)).level_of_peak() < levels) == rising
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        return np.asarray(0.5 * (low + high))

    def other_modes(self, mode: ModePath, omega: Array, levels: Array) -> Array:
        """Size of the linear response of the other stuck modes relative to that of the mode, by their elastic energies."""
        return np.asarray(levels * self.others.size(omega) / (self.others.frequency * mode.amplitude))

    def moved(self, mode: ModePath, omega: Array, levels: Array | float, output: int) -> Complex:
        """First harmonic of an output: of the mode with its phase, and the linear response of the others."""
        dynamic = mode.dynamic(omega)
        # Without any damping a resonance needs no force: what is left of it is in quadrature.
        turned = mode.force / np.where(dynamic == 0.0, 1j, dynamic)
        moved = mode.amplitude * mode.outputs[:, output] * turned / np.abs(turned)
        return np.asarray(moved + levels * self.others.at(omega)[:, output])

    def response(self, level: float, output: int) -> pd.DataFrame:
        """The curve of a force level."""
        self._refuse_beyond(np.array([level]))
        count = self.mode.omega.size
        numbers = np.linspace(0.0, count - 1.0, FINER * (count - 1) + 1)
        fine = self._along(np.interp(numbers, np.arange(count), self._places))
        low, high = _sides(ModePath.of_columns(fine), level)
        below, above = np.flatnonzero(np.isfinite(low)), np.flatnonzero(np.isfinite(high))[::-1]
        where = np.concatenate([below, above])
        if not where.size:
            remedy = "Compute the mode down to a smaller amplitude."
            raise fault("force_level", "must move the mode by one of its amplitudes", level, remedy)
        omega, mode = np.concatenate([low[below], high[above]]), ModePath.of_columns(fine[where])
        moved = self.moved(mode, omega, level, output)
        columns = {"frequency": omega / (2.0 * np.pi), "amplitude": np.abs(moved), "phase": np.angle(moved)}
        alone = mode.amplitude * np.abs(mode.outputs[:, output])
        return pd.DataFrame(columns | {"modal_amplitude": mode.amplitude, "mode_alone": alone})

    def phase_resonance(self, output: int) -> pd.DataFrame:
        """Force level, frequency and amplitude of phase resonance at every point."""
        mode = self.mode
        columns = {"force_level": mode.quadrature, "frequency": mode.omega / (2.0 * np.pi)}
        columns["amplitude"] = mode.amplitude * np.abs(mode.outputs[:, output])
        return pd.DataFrame(columns | {"damping_ratio": mode.zeta})


def saturated(levels: Array, amplitudes: Array) -> bool:
    """Whether the force of the peak no longer grows with the amplitude at the end of a curve; both of its points."""
    before = np.flatnonzero(amplitudes * LAST <= amplitudes[-1])
    if not before.size or levels[before[-1]] <= 0.0 or levels[-1] <= 0.0:
        return False
    k = before[-1]
    return bool(np.log(levels[-1] / levels[k]) < SATURATED * np.log(amplitudes[-1] / amplitudes[k]))


def _sides(mode: ModePath, level: float) -> tuple[Array, Array]:
    """Frequencies below and above resonance at which a force level makes each amplitude, rad/s; NaN where none does."""
    m, w, c, rest = mode.mass, mode.omega, mode.viscous, mode.own_lag
    constant = m**2 * w**4 + rest**2 - (level * np.abs(mode.force) / mode.amplitude) ** 2
    reached = mode.level_of_peak() <= level
    sides = np.full((2, w.size), np.nan)
    for k in np.flatnonzero(reached):
        roots = np.roots([m[k] ** 2, 0.0, c[k] ** 2 - 2.0 * (m[k] * w[k]) ** 2, 2.0 * c[k] * rest[k], constant[k]])
        real = roots.real[(np.abs(roots.imag) <= 1e-9 * w[k]) & (roots.real > 0.0)]
        if real.size:
            sides[:, k] = real.min() if real.size > 1 else np.nan, real.max()
    return sides[0], sides[1]
