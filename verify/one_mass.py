"""One mass with a Jenkins element: Griffin's optimum with one harmonic, rigid friction as a limit."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi, sqrt

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from stickslip.analyses.forced_response import forced_response
from stickslip.model.rigs import single_mass
from stickslip.support.units import radians_per_second
from verify.row import CLOSED, INDEPENDENT, Row, absolute, at_most, relative

TITLE = "One mass with one friction contact"
ABOUT = (
    "k = m = 1, kd = 0.5, F = 1, ζ = 0.005 (or none), one harmonic, 8192 samples: peaks over frequency against μN. "
    "Rigid Coulomb friction (Den Hartog) as the limit of a stiff contact spring, 61 harmonics."
)
KD = 0.5


def peak(limit: float, damping: float = 0.01) -> tuple[float, float]:
    """Amplitude and ω of the highest peak."""
    response = forced_response(
        single_mass(damping=damping, kt=KD, limit=limit), radians_per_second(0.9, 1.4), harmonics=1, samples=8192
    )
    first = response.peaks().iloc[0]
    return float(first.amplitude), 2.0 * pi * float(first.frequency)


def exact_amplitude(omega: float, limit: float) -> float:
    """|k + k_eq(A) − ω² + i(cω + h(A))| A = F."""

    def gap(a: float) -> float:
        critical = limit / KD
        angle = np.arccos(1.0 - 2.0 * critical / a) if a > critical else pi
        stiffness = KD / pi * (angle - 0.5 * np.sin(2.0 * angle))
        h = 4.0 * limit / (pi * a) * max(1.0 - critical / a, 0.0)
        return abs(1.0 + stiffness - omega**2 + 1j * (0.01 * omega + h)) * a - 1.0

    return float(brentq(gap, 1e-3, 1e4, xtol=1e-14, rtol=1e-14))


def exact_peak(limit: float) -> float:
    """The highest amplitude over ω."""
    coarse = np.linspace(0.95, 1.3, 2000)
    start = coarse[np.argmax([exact_amplitude(w, limit) for w in coarse])]
    best = minimize_scalar(lambda w: -exact_amplitude(w, limit), bounds=(start - 2e-4, start + 2e-4), options={"xatol": 1e-12})
    return float(-best.fun)


def rms_error(samples: int) -> float:
    """Relative error of amplitudes over nine frequencies."""
    omegas = np.linspace(1.0, 1.2, 9)
    problem = single_mass(damping=0.01, kt=KD, limit=1.2)
    found = forced_response(problem, omegas / (2 * pi), harmonics=1, samples=samples).dataset.amplitude.to_numpy().ravel()
    return float(np.sqrt(np.mean([(a / exact_amplitude(w, 1.2) - 1.0) ** 2 for a, w in zip(found, omegas, strict=True)])))


def rigid(beta: float, ratio: float, kt: float) -> float:
    """max|x| k/P with a contact spring kt, undamped."""
    problem = single_mass(damping=0.0, kt=kt, limit=ratio)
    dataset = forced_response(problem, [beta / (2.0 * pi)], harmonics=61, samples=16384).dataset
    return float(dataset.max_abs[0, 0, 0])


def rows() -> Iterator[Row]:
    table = {0.2: 74.6605, 0.8: 11.7613, 1.2: 6.16452, 1.5: 5.87236, 3.0: 7.86732, 10.0: 21.2358, 50.0: 81.6503}
    for limit, printed in table.items():
        found = peak(limit)[0]
        yield relative(
            f"μN/F = {limit:g}: peak amplitude", found, exact_peak(limit), 1e-6, f"{CLOSED} of one harmonic, maximised"
        )
        yield relative(f"μN/F = {limit:g}: the same against six printed digits", found, printed, 6e-6, INDEPENDENT)
    yield relative("μN/F = 1.47424, the optimum: peak amplitude", peak(1.47424)[0], 5.870724, 1e-6, INDEPENDENT)
    limits = np.array([1.44424, 1.47424, 1.50424])
    parabola = np.polyfit(limits - limits[1], [peak(limit)[0] for limit in limits], 2)
    yield absolute("Optimum μN/F", limits[1] - 0.5 * parabola[1] / parabola[0], 1.47424, 2e-3, INDEPENDENT)
    amplitude, omega = peak(pi / 2.0, damping=0.0)
    yield relative("Undamped, μN/F = π/2: peak amplitude πF/kd", amplitude, pi / KD, 1e-6, CLOSED)
    yield relative("Undamped, μN/F = π/2: frequency √(k + kd/2), flat top", omega, sqrt(1.25), 1e-4, CLOSED)
    for ratio in (1.0, 2.0, 5.0):
        exact = ratio**2 / (KD * (ratio - pi / 4.0))
        yield relative(f"Undamped, μN/F = {ratio:g}: Fc²/(kd (Fc − πF/4))", peak(ratio, 0.0)[0], exact, 1e-6, CLOSED)
    errors = {n: rms_error(n) for n in (256, 1024, 4096)}
    yield at_most("Error of amplitudes at 4096 samples", errors[4096], 1e-6, CLOSED)
    yield absolute(
        "Order in the samples, 256 to 4096", np.log(errors[256] / errors[4096]) / np.log(16.0), 2.0, 0.2, "second order"
    )
    for beta, ratio, exact in ((0.6, 0.2, 1.5506028547), (1.3, 0.5, 1.0353280077), (2.0, 0.3, 0.2976761850)):
        gaps = [abs(rigid(beta, ratio, kt) / exact - 1.0) for kt in (1e3, 1e5)]
        name = f"Den Hartog, β = {beta}, Fc/P = {ratio}: error"
        yield at_most(f"{name} with kt = 10⁵ k", gaps[1], 6e-3, "Den Hartog (1931)")
        yield at_most(f"{name}, ratio of kt = 10⁵ k to kt = 10³ k", gaps[1] / gaps[0], 0.5, "converges with 1/√kt")
