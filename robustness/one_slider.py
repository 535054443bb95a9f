"""Is the highest response of a band found? One slider on up to forty modes, undamped or nearly so, beside a closed form.

With one harmonic, the motion of a slider of stiffness kt and limit μN is A cos ωt and its force k(A) A, so that

    A |1 + k(A) H_cc(ω)| = F |H_cf(ω)|,   X_o = F (H_of − H_oc k(A) H_cf / (1 + k(A) H_cc)),

which holds at every frequency and every amplitude, whatever a sweep does.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import brentq

from stickslip.analyses.forced_response import ForcedResponse, forced_response
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact
from stickslip.model.loads import Force, Output
from stickslip.model.problem import Problem
from stickslip.model.structure.matrices import Structure
from stickslip.support.checks import Array
from stickslip.support.outcome import Outcome
from stickslip.support.units import radians_per_second

TOLERANCE = 2e-3
"""Relative height to which the highest response must be found."""
RATIOS = (0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2)
SAMPLES = 1024

AMPLITUDES, BESIDE = 100, np.array([-2.0, -1.0, -0.3, 0.0, 0.3, 1.0, 2.0])
"""Amplitudes whose resonances are tried, and frequencies beside each, in half-widths."""
KEPT, ZOOMS, CLOSER, TRIED = 20, 6, 6.0, 25
"""Highest places that are looked at closely: how often, how much closer each time, and at how many frequencies."""


@dataclass(frozen=True, eq=False)
class Modes:
    """Modes of unit mass with a slider (kt, limit μN) at `contact`, a force at `force`, an output at `output`, each (modes,)."""

    omega: Array
    ratio: float
    contact: Array
    force: Array
    output: Array
    kt: float
    limit: float
    level: float
    band: tuple[float, float]

    def problem(self) -> Problem:
        names = tuple(f"{k}.x" for k in range(1, self.omega.size + 1))
        damping = np.diag(2.0 * self.ratio * self.omega)
        structure = Structure(np.eye(self.omega.size), np.diag(self.omega**2), names, C=damping)
        contact, force, output = (
            dict(zip(names, each.tolist(), strict=True)) for each in (self.contact, self.force, self.output)
        )
        slider = Contact("slider", Macroslip(kt=self.kt, mu=0.3, normal_load=self.limit / 0.3), (contact,))
        return Problem(structure, (slider,), (Force(force, 1.0),), (Output("o", output),))

    def sweep(self) -> ForcedResponse:
        return forced_response(self.problem(), radians_per_second(*self.band), self.level, harmonics=1, samples=SAMPLES)

    def amplitudes(self, omega: float) -> list[float]:
        """|X| of the output, once for every amplitude of the slider that solves the equation at a frequency in rad/s."""
        tried = np.geomspace(1e-9, 1e9, 20001) * self.limit / self.kt
        values = self._missing(tried, omega)
        ends = (tried[k : k + 2] for k in np.flatnonzero(values[:-1] * values[1:] < 0.0))
        found = [brentq(lambda size: self._missing(np.array(size), omega).item(), *two, xtol=1e-30) for two in ends]
        return [self._output(size, omega) for size in found]

    def highest(self, found: float) -> float:
        """The highest |X| of the band: around the resonances that every amplitude of the slider makes, and around `found`, where
        a sweep has its highest, rad/s.
        """
        places, widths = self._resonances()
        sizes = np.concatenate([self._coarse(places[k : k + 1000]) for k in range(0, places.size, 1000)])
        near = np.argsort(sizes)[::-1][:KEPT]
        best = max(near, key=lambda k: max(self.amplitudes(float(places[k])), default=0.0))
        looked_at = (places[best], widths[best]), (found, widths[np.argmin(np.abs(places - found))])
        return max(self._zoomed(float(place), 4.0 * float(width)) for place, width in looked_at)

    def _zoomed(self, omega: float, reach: float) -> float:
        """The highest |X| near a frequency."""
        best = 0.0
        for _ in range(ZOOMS):
            places = np.clip(np.linspace(omega - reach, omega + reach, TRIED), *self.band)
            sizes = [max(self.amplitudes(place), default=0.0) for place in places.tolist()]
            best, omega, reach = max(best, *sizes), float(places[np.argmax(sizes)]), reach / CLOSER
        return best

    def _coarse(self, omega: Array) -> Array:
        """About the highest |X| at many frequencies, (m,)."""
        tried = np.geomspace(1e-9, 1e9, 1001) * self.limit / self.kt
        k = self.stiffness(tried)
        cc, cf, oc, of = (each[:, None] for each in self._receptances(omega))
        values = np.log(tried * np.abs(1.0 + k * cc) / (self.level * np.abs(cf)))
        place, at = np.nonzero(values[:, :-1] * values[:, 1:] <= 0.0)
        first, last = values[place, at], values[place, at + 1]
        k = self.stiffness(tried[at] * (tried[1] / tried[0]) ** (first / (first - last)))
        sizes = np.zeros(omega.size)
        cc, cf, oc, of = (each[place, 0] for each in (cc, cf, oc, of))
        np.maximum.at(sizes, place, np.abs(of - oc * k * cf / (1.0 + k * cc)) * self.level)
        return sizes

    def _resonances(self) -> tuple[Array, Array]:
        """Frequencies in the band around the resonances with the slider's stiffness at many amplitudes, and half-widths there."""
        places, widths = [], []
        x = self.limit / self.kt
        for size in np.append(0.5, 1.0 + np.geomspace(1e-3, 1e9, AMPLITUDES)) * x:
            k = self.stiffness(np.array(size))
            squares, shapes = np.linalg.eigh(np.diag(self.omega**2) + k.real * np.outer(self.contact, self.contact))
            omega = np.sqrt(squares)
            width = omega * (self.ratio + 0.5 * k.imag * (self.contact @ shapes) ** 2 / squares)
            places.append((omega + np.outer(BESIDE, width)).ravel())
            widths.append(np.tile(width, BESIDE.size))
        omega, width = np.concatenate(places), np.concatenate(widths)
        inside = (omega >= self.band[0]) & (omega <= self.band[1])
        return omega[inside], width[inside]

    def stiffness(self, size: Array) -> Array:
        """k(A): kt below the limit x = μN/kt; above it kt/π (θ − sin 2θ / 2) + 4i μN (A − x)/(π A²) with cos θ = 1 − 2x/A."""
        x = self.limit / self.kt
        slipping = np.maximum(size, x)
        angle = np.arccos(1.0 - 2.0 * x / slipping)
        lost = 4.0 * self.limit * (slipping - x) / (np.pi * slipping**2)
        return np.where(size <= x, self.kt, self.kt / np.pi * (angle - 0.5 * np.sin(2.0 * angle)) + 1j * lost)

    def _missing(self, size: Array, omega: float) -> Array:
        cc, cf, _, _ = self._receptances(np.array([omega]))
        return np.asarray(size * np.abs(1.0 + self.stiffness(size) * cc) - self.level * np.abs(cf))

    def _output(self, size: float, omega: float) -> float:
        k, (cc, cf, oc, of) = self.stiffness(np.array(size)), self._receptances(np.array([omega]))
        return (np.abs(of - oc * k * cf / (1.0 + k * cc)) * self.level).item()

    def _receptances(self, omega: Array) -> list[Array]:
        """H_cc, H_cf, H_oc, H_of at frequencies in rad/s; beside resonances of undamped modes, where they are infinite."""
        dynamic = self.omega**2 - omega[:, None] ** 2 + 2j * self.ratio * self.omega * omega[:, None]
        gain = 1.0 / np.where(dynamic == 0.0, 1e-16 * self.omega**2, dynamic)
        return [gain @ (a * b) for a, b in self._pairs]

    @property
    def _pairs(self) -> tuple[tuple[Array, Array], ...]:
        return (self.contact, self.contact), (self.contact, self.force), (self.output, self.contact), (self.output, self.force)


def drawn(seed: int) -> Modes:
    """One of 1 to 40 modes, with stiffness and limit of the slider and the force over many decades."""
    draw = np.random.default_rng(seed)
    size = int(draw.choice([1, 2, 3, 5, 10, 20, 40]))
    ratio = float(draw.choice(RATIOS))
    scale = float(draw.choice([1, 2.0 * np.pi * 300]))
    omega = np.sort(draw.uniform(1, 3, size)) * scale
    if size > 1 and draw.random() < 0.4:
        omega[1] = omega[0] * (1 + 1e-4)
    omega = np.sort(omega)
    contact, force, output = (draw.normal(size=size) / np.sqrt(size) for _ in range(3))
    if draw.random() < 0.3:
        output = contact
    kt = float(scale**2 * draw.choice([1e-3, 0.03, 0.3, 3, 30]))
    limit = kt * 10.0 ** draw.uniform(-9, -3)
    band = 0.6 * scale, (omega[-1] / scale * 1.5 + (2 if kt > scale**2 else 0.5)) * scale
    return Modes(omega, ratio, contact, force, output, kt, limit, limit * 10.0 ** draw.uniform(-5, 1.5), band)


@dataclass
class HighestResult:
    """Sweeps of one damping ratio: how many, how many arrived, and those whose highest response is not the closed form's."""

    ratio: float
    cases: int = 0
    arrived: int = 0
    wrong: list[str] = field(default_factory=list)

    def add(self, seed: int) -> None:
        """Sweep a case and compare; a curve that ends before the end of its band says so, and is not compared."""
        modes = drawn(seed)
        data = modes.sweep().dataset
        self.cases += 1
        if data["case_outcome"].values[0] != Outcome.CONVERGED:
            return
        self.arrived += 1
        sizes = np.append(data["peak_amplitude"].values[0, :, 0], data["amplitude"].values[0, :, 0])
        hertz = np.append(data["peak_frequency"].values[0, :, 0], data["frequency"].values[0])
        found, expected = float(np.nanmax(sizes)), modes.highest(2.0 * np.pi * float(hertz[np.nanargmax(sizes)]))
        if abs(found - expected) > TOLERANCE * expected:
            self.wrong.append(f"one slider {seed}, damping ratio {self.ratio:g}: {found:.5g} m instead of {expected:.5g} m")

    @property
    def row(self) -> str:
        """A row of the table."""
        return f"| {self.ratio:g} | {self.cases} | {self.arrived} | {self.arrived - len(self.wrong)} |"
