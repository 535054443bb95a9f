"""Forced responses from one nonlinear mode: curves, the peaks of all force levels, phase resonance.

At modal amplitude a the motion of the mode, Q₁ at the first harmonic, obeys its equation at ω with the force 2iζω² M Q₁. Forced at
Ω with the same motion, projected on Q₁ (m = Q₁ᴴMQ₁, c = Q₁ᴴCQ₁, f = Q₁ᴴP):

    m (ω² − Ω²) + i (2ζω² m + c (Ω − ω)) = F f e^(−iθ),

since friction does not change with the frequency and viscous damping goes with it. The size of both sides gives Ω for each a, their
angle the phase θ. The other modes of the stuck structure add their linear response to F P (W. Szemplińska-Stupnicka, 1979).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from stickslip.checks import Array, fault
from stickslip.harmonic.extended_structure import extended_gains
from stickslip.harmonic.mode_balance import ModalStructures
from stickslip.loads import Force
from stickslip.outcome import Outcome
from stickslip.problem import Problem

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

ForcePattern = Sequence[Force]

FINER = 8
"""Places on a synthesised curve for each interval between two points of the mode."""

Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class _Mode:
    """What the synthesis reads of a mode at places along its curve: ω, ζ, modal mass m, viscous c, modal force f, a, and the
    first harmonic of the outputs, each (places,) or (places, outputs)."""

    omega: Array
    zeta: Array
    mass: Array
    viscous: Array
    force: Complex
    amplitude: Array
    outputs: Complex

    @property
    def quadrature(self) -> Array:
        """Force level of phase resonance: 2ζω² m/|f|."""
        return np.asarray(2.0 * self.zeta * self.omega**2 * self.mass / np.abs(self.force))

    def dynamic(self, omega: Array) -> Complex:
        """Left side of the projected equation."""
        lag = 2.0 * self.zeta * self.omega**2 * self.mass + self.viscous * (omega - self.omega)
        return np.asarray(self.mass * (self.omega**2 - omega**2) + 1j * lag)

    def easiest(self) -> Array:
        """The frequency at which the smallest force makes the amplitude, rad/s: that of the peak of a force level."""
        omega, rest = self.omega.copy(), 2.0 * self.zeta * self.omega**2 * self.mass - self.viscous * self.omega
        for _ in range(30):
            slope = -4.0 * self.mass**2 * (self.omega**2 - omega**2) * omega + 2.0 * (rest + self.viscous * omega) * self.viscous
            bend = self.mass**2 * (12.0 * omega**2 - 4.0 * self.omega**2) + 2.0 * self.viscous**2
            change = np.where(bend > 0.0, slope / np.where(bend > 0.0, bend, 1.0), 0.0)
            omega = np.maximum(omega - change, 1e-3 * self.omega)
        return np.asarray(omega)


@dataclass(frozen=True, eq=False)
class Synthesis:
    """The forced responses of one mode under one pattern of forces."""

    mode: _Mode
    rest: _Rest

    @classmethod
    def of(cls, dataset: xr.Dataset, problem: Problem, case: int, forces: ForcePattern | None) -> Synthesis:
        """Of a case of a dataset; forces: other ones than those of the problem, whose harmonic parts at harmonic 1 count."""
        loaded = problem if forces is None else replace(problem, forces=tuple(forces))
        chosen = dataset.isel(case=case, point=np.flatnonzero(np.isfinite(dataset["frequency"][case].to_numpy())))
        if chosen.sizes["point"] < 2:
            raise fault("The curve of the mode", "must have two or more points", str(dataset["case_message"][case].item()))
        load = _first_harmonic(loaded)
        shape = _complex(chosen["mode_shape"])
        force = shape.conj() @ load
        if not np.all(np.abs(force) > 1e-12 * np.linalg.norm(shape, axis=1) * np.linalg.norm(load)):
            raise fault("The forces", "must excite the mode", "ones that do no work on its motion")
        omega = 2.0 * np.pi * chosen["frequency"].to_numpy()
        names = "damping_ratio", "modal_mass", "modal_damping"
        numbers = [chosen[name].to_numpy() for name in names]
        outputs = _complex(chosen["response"].isel(harmonic=1))
        mode = _Mode(omega, *numbers, force, chosen["modal_amplitude"].to_numpy(), outputs)
        return cls(mode, _Rest.of(loaded, int(dataset["mode_number"][case]) - 1, load))

    def peaks(self, levels: Array, output: int) -> pd.DataFrame:
        """The peaks of force levels at an output."""
        import pandas as pd

        frequencies = self.mode.easiest()
        forces = np.abs(self.mode.dynamic(frequencies)) / np.abs(self.mode.force)
        rows = [row for level in levels for row in self._peaks_of(float(level), forces, frequencies, output)]
        names = ["force_level", "frequency", "amplitude", "modal_amplitude", "damping_ratio"]
        return pd.DataFrame(rows, columns=names)

    def _peaks_of(self, level: float, forces: Array, frequencies: Array, output: int) -> list[tuple[float, ...]]:
        """Rows of one force level, the highest peak first."""
        if not 0.0 < level <= forces.max():
            rule = f"must be positive and at most {forces.max():.4g}, that of the largest amplitude of the mode"
            raise fault("force_levels", rule, level, "Compute the mode up to a larger amplitude.")
        places = _crossings(np.log(forces), np.log(level))
        share = 1.0
        if level < forces[0]:
            places, share = np.append(places, 0.0), level / forces[0]
        rows = []
        for place in places:
            mode = _at(self.mode, np.array([place]))
            linear = share if place == 0.0 else 1.0
            omega = _interpolated(frequencies, np.array([place]))
            moved = linear * self._moved(mode, omega, level / linear, output)[0]
            numbers = (abs(moved), linear * mode.amplitude[0], mode.zeta[0])
            rows.append((level, omega[0] / (2.0 * np.pi), *map(float, numbers)))
        return sorted(rows, key=lambda row: -row[2])

    def _moved(self, mode: _Mode, omega: Array, level: float, output: int) -> Complex:
        """First harmonic of an output: of the mode with its phase, and the linear response of the others."""
        turned = level * mode.force / mode.dynamic(omega)
        turned = turned / np.abs(turned)
        return np.asarray(mode.outputs[:, output] * turned + level * self.rest.at(omega)[:, output])

    def response(self, level: float, output: int) -> pd.DataFrame:
        """The curve of a force level."""
        import pandas as pd

        fine = _at(self.mode, np.linspace(0.0, self.mode.omega.size - 1.0, FINER * (self.mode.omega.size - 1) + 1))
        low, high = _sides(fine, level)
        sides = [(np.flatnonzero(np.isfinite(low)), low), (np.flatnonzero(np.isfinite(high))[::-1], high)]
        where = np.concatenate([places for places, _ in sides])
        if not where.size:
            raise fault("force_level", "must reach an amplitude of the mode", level, "Compute the mode down to a smaller amplitude.")
        omega = np.concatenate([values[places] for places, values in sides])
        mode = _taken(fine, where)
        moved = self._moved(mode, omega, level, output)
        columns = {"frequency": omega / (2.0 * np.pi), "amplitude": np.abs(moved), "phase": np.angle(moved)}
        columns |= {"modal_amplitude": mode.amplitude, "mode_alone": np.abs(mode.outputs[:, output])}
        return pd.DataFrame(columns)

    def phase_resonance(self, output: int) -> pd.DataFrame:
        """Force level, frequency and amplitude of phase resonance at every point."""
        import pandas as pd

        mode = self.mode
        columns = {"force_level": mode.quadrature, "frequency": mode.omega / (2.0 * np.pi)}
        return pd.DataFrame(columns | {"amplitude": np.abs(mode.outputs[:, output]), "damping_ratio": mode.zeta})


@dataclass(frozen=True, eq=False)
class _Rest:
    """The stuck structure without the followed mode, under the first harmonic of the forces."""

    structures: ModalStructures
    followed: int
    load: Complex

    @classmethod
    def of(cls, problem: Problem, followed: int, load: Complex) -> _Rest:
        structures = ModalStructures(problem, (1,), 1)
        return cls(structures, followed, structures.whole[structures.key[1]].conj().T @ load)

    def at(self, omega: Array) -> Complex:
        """First harmonic of the outputs per force level, (places, outputs)."""
        structure, k = self.structures.extended(self.followed, 1), self.structures.key[1]
        load = self.load.astype(complex)
        load[self.followed] = 0.0
        rows = self.structures.shapes[k]
        found = []
        for each in omega:
            gains = extended_gains(structure, float(each), 0.0)[1]
            found.append(rows @ (gains[0] * load if gains.shape[0] == 1 else gains @ load))
        return np.array(found, dtype=complex)


def _first_harmonic(problem: Problem) -> Complex:
    """The harmonic load at level one as P₁, (n,); refused where it goes by the frequency."""
    powers = problem.load_powers(max((h for force in problem.forces for h in force.factors), default=1))
    if len(powers) > 1:
        raise fault("The forces", "must not go by the frequency in a synthesis from modes", "base motion or unbalance")
    return np.asarray(powers[0][:, 1] - 1j * powers[0][:, 2])


def _complex(array: xr.DataArray) -> Complex:
    parts = array.transpose(..., "part").to_numpy()
    return np.asarray(parts[..., 0] + 1j * parts[..., 1])


def _sides(mode: _Mode, level: float) -> tuple[Array, Array]:
    """Frequencies below and above resonance at which a force level makes each amplitude, rad/s; NaN where none does."""
    peak, rest = mode.easiest(), 2.0 * mode.zeta * mode.omega**2 * mode.mass - mode.viscous * mode.omega
    m, w, c = mode.mass, mode.omega, mode.viscous
    constant = m**2 * w**4 + rest**2 - (level * np.abs(mode.force)) ** 2
    sides = np.full((2, w.size), np.nan)
    for k in range(w.size):
        roots = np.roots([m[k] ** 2, 0.0, c[k] ** 2 - 2.0 * (m[k] * w[k]) ** 2, 2.0 * c[k] * rest[k], constant[k]])
        real = roots.real[(np.abs(roots.imag) <= 1e-9 * w[k]) & (roots.real > 0.0)]
        if real.size and np.abs(mode.dynamic(peak)[k]) <= level * abs(mode.force[k]):
            sides[:, k] = real.min() if real.size > 1 else np.nan, real.max()
    return sides[0], sides[1]


def _interpolated(values: NDArray, places: Array) -> NDArray:
    """Values (points, ...) at places along the curve, between points by monotonic cubics."""
    steps = np.arange(len(values))
    if np.iscomplexobj(values):
        return np.asarray(PchipInterpolator(steps, values.real)(places) + 1j * PchipInterpolator(steps, values.imag)(places))
    return np.asarray(PchipInterpolator(steps, values)(places))


def _crossings(values: Array, wanted: float) -> Array:
    """Places along the curve at which the interpolated values are `wanted`."""
    found = PchipInterpolator(np.arange(values.size), values).solve(wanted, extrapolate=False)
    return np.asarray(found[np.isfinite(found)])


_LOGARITHMIC = ("omega", "mass", "amplitude")


def _at(mode: _Mode, places: Array) -> _Mode:
    """The mode at places along its curve."""
    values = {}
    for name, given in vars_of(mode).items():
        if name in _LOGARITHMIC:
            values[name] = np.exp(_interpolated(np.log(given), places))
        else:
            values[name] = _interpolated(given, places)
    return _Mode(**values)


def _taken(mode: _Mode, places: NDArray[np.intp]) -> _Mode:
    return _Mode(**{name: values[places] for name, values in vars_of(mode).items()})


def vars_of(mode: _Mode) -> dict[str, NDArray]:
    """The arrays of a mode by name."""
    return {name: getattr(mode, name) for name in _Mode.__dataclass_fields__}
