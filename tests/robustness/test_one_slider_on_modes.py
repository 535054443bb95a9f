"""Sweeps of one slider on many modes, undamped or nearly so, beside the closed form of one harmonic."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import brentq

import stickslip as ss


@dataclass
class Modes:
    """Modes of unit mass with a slider (kt, limit μN) at `contact`, a force at `force`, an output at `output`, each (modes,)."""

    omega: np.ndarray
    ratio: float
    contact: np.ndarray
    force: np.ndarray
    output: np.ndarray
    kt: float
    limit: float
    level: float
    band: tuple[float, float]

    def problem(self) -> ss.Problem:
        names = tuple(f"{k}.x" for k in range(1, self.omega.size + 1))
        damping = np.diag(2.0 * self.ratio * self.omega)
        structure = ss.Structure(np.eye(self.omega.size), np.diag(self.omega**2), names, C=damping)
        contact, force, output = (
            dict(zip(names, each.tolist(), strict=True)) for each in (self.contact, self.force, self.output)
        )
        slider = ss.Contact("slider", ss.Macroslip(kt=self.kt, mu=0.3, normal_load=self.limit / 0.3), (contact,))
        return ss.Problem(structure, (slider,), (ss.Force(force, 1.0),), (ss.Output("o", output),))

    def sweep(self) -> ss.ForcedResponse:
        return ss.forced_response(self.problem(), ss.radians_per_second(*self.band), self.level, harmonics=1, samples=1024)

    def amplitudes(self, omega: float) -> list[float]:
        """|X| of the output, once for every amplitude A of the slider with A |1 + k(A) H_cc| = F |H_cf|.

        k(A) = kt below the limit x = μN/kt; above it kt/π (θ − sin 2θ / 2) + 4i μN (A − x)/(π A²) with cos θ = 1 − 2x/A.
        """
        gain = 1.0 / (self.omega**2 - omega**2 + 2j * self.ratio * self.omega * omega)
        cc, cf, oc, of = (np.sum(gain * a * b) for a, b in self._pairs())
        x = self.limit / self.kt

        def stiffness(size: float) -> complex:
            if size <= x:
                return self.kt
            angle = np.arccos(1.0 - 2.0 * x / size)
            lost = 4.0 * self.limit * (size - x) / (np.pi * size * size)
            return self.kt / np.pi * (angle - 0.5 * np.sin(2.0 * angle)) + 1j * lost

        def missing(size: float) -> float:
            return float(size * abs(1.0 + stiffness(size) * cc) - self.level * abs(cf))

        tried = np.geomspace(1e-9 * x, 1e9 * x, 20001)
        values = np.array([missing(size) for size in tried])
        found = [brentq(missing, *tried[k : k + 2], xtol=1e-30) for k in np.flatnonzero(values[:-1] * values[1:] < 0.0)]
        return [float(abs(of - oc * stiffness(A) * cf / (1.0 + stiffness(A) * cc)) * self.level) for A in found]

    def _pairs(self):
        return (self.contact, self.contact), (self.contact, self.force), (self.output, self.contact), (self.output, self.force)


def drawn(seed: int) -> Modes:
    """One of 1 to 40 modes, with stiffness and limit of the slider and the force over many decades."""
    draw = np.random.default_rng(seed)
    size = int(draw.choice([1, 2, 3, 5, 10, 20, 40]))
    ratio = float(draw.choice([0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2]))
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


@pytest.mark.parametrize(
    ("seed", "omega", "ratio"),
    [(3, 1.568405765, 0.0), (25, 3272.393984, 0.0), (12, 3768.8095, 1e-6)],
    ids=["undamped", "undamped, in rad/s of a blade", "slip begins beside a resonance"],
)
def test_a_peak_that_friction_makes_is_found(seed, omega, ratio):
    """Without damping the linear resonance is infinite and friction makes the peak; where slip begins on a resonance's flank,
    the peak is a corner, here 600 times lower than the highest of the curve."""
    modes = drawn(seed)
    assert modes.ratio == ratio
    (expected,) = modes.amplitudes(omega)
    peaks = modes.sweep().peaks()
    near = peaks.amplitude[(2.0 * np.pi * peaks.frequency / omega - 1.0).abs() < 1e-3]
    assert near.max() == pytest.approx(expected, rel=2e-3)


def test_where_nothing_slips_a_curve_never_turns_back():
    """A linear response has one motion at each frequency; ratios of 1e-6, forty modes."""
    modes = drawn(20)
    assert modes.ratio == 1e-6
    data = modes.sweep().dataset
    frequency, active = data.frequency.values[0], data.active_rows.values[0]
    kept = np.isfinite(frequency)
    frequency, stuck = frequency[kept], active[kept] == 0
    assert stuck.sum() > 1000
    assert np.all(np.diff(frequency)[stuck[:-1] & stuck[1:]] > 0.0)
