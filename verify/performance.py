"""Performance curves: one mass against closed forms, the peak following against full sweeps, and what following costs."""

from __future__ import annotations

from collections.abc import Iterator
from math import pi, sqrt

import numpy as np
from scipy.optimize import brentq

from stickslip.analyses.forced_response import forced_response
from stickslip.analyses.performance.curve import performance_curve
from stickslip.analyses.performance.sensitivity_indices import sensitivity_indices
from stickslip.model.problem import Problem
from stickslip.model.rigs import single_blade, single_mass
from stickslip.model.rigs.single_blade import DRY, OILED, two_semi_cylinders
from stickslip.support.units import hertz, logspace, radians_per_second
from verify.counting import counted
from verify.one_mass import KD, exact_peak
from verify.row import CLOSED, INDEPENDENT, PAGE, Row, absolute, at_most, relative

TITLE = "Performance curves"
ABOUT = (
    "One mass with one Jenkins element, one harmonic, 8192 samples unless said, its peaks followed over F_C/F_E. Single blade, "
    "4.6 kg, H 5, 256 samples, 60 values of F_C/F_E from 0.4 to 100: the highest peak against full sweeps, and calls of Newton's "
    "method against those of a forced response with solved peaks over the same band. Blade with two semi-cylinders, dry (0.5) "
    "and oiled (0.2), 3 harmonics: optima over 25 values of F_C/F_E from 0.3 to 10, spreads over 40 from 0.3 to 100."
)


def rows() -> Iterator[Row]:
    yield from damped()
    yield from undamped()
    yield from rig()
    yield from slopes()
    yield from dry_and_oiled()


def one_seed() -> Iterator[Row]:
    """The closed forms."""
    yield from undamped()
    yield from slopes()


def damped() -> Iterator[Row]:
    ratios, maximised = (0.2, 0.8, 1.2, 1.5, 3.0, 10.0, 50.0), f"{CLOSED} of one harmonic, maximised"
    coarse, fine = (performance_curve(single_mass(damping=0.01, kt=KD), ratios, harmonics=1, samples=n) for n in (4096, 8192))
    exact = np.array([exact_peak(ratio) for ratio in ratios])
    for ratio, found, height in zip(ratios, fine.dataset.amplitude_per_force.values[0], exact, strict=True):
        yield relative(f"μF_C/F_E = {ratio:g}: followed peak", found, height, 1e-6, maximised)
    largest = np.max(np.abs(coarse.dataset.amplitude_per_force.values[0] / exact - 1.0))
    yield at_most("The same with 4096 samples: largest error", largest, 1e-6, maximised)
    best = performance_curve(single_mass(damping=0.01, kt=KD), logspace(0.5, 5.0, 15), harmonics=1, samples=8192).optimum()
    yield relative("Lowest peak", best["optimum_amplitude_per_force"], 5.870724, 1e-6, INDEPENDENT)
    yield absolute("Optimum μF_C/F_E", best["optimum_ratio"], 1.47424, 2e-3, INDEPENDENT)
    ends = [brentq(lambda ratio: exact_peak(ratio) - 1.1 * 5.870724, *bracket, xtol=1e-6) for bracket in ((0.9, 1.4), (1.6, 3.0))]
    for words, end in zip(("low", "high"), ends, strict=True):
        yield relative(f"Plateau within 10 % of it, {words} end", best[f"plateau_{words}"], end, 1e-3, maximised)
    scaled = np.array([0.9, 1.5, 4.0])
    pair = [performance_curve(single_mass(damping=0.01, kt=KD), scaled / mu, mu, harmonics=1, samples=8192) for mu in (0.3, 0.6)]
    gap = np.max(np.abs(pair[0].dataset.amplitude_per_force.values / pair[1].dataset.amplitude_per_force.values - 1.0))
    yield at_most("Spread of two friction coefficients over μF_C/F_E", float(gap), 1e-6, "one mass depends on μF_C/F_E alone")


def undamped() -> Iterator[Row]:
    ratios = np.array([0.9, 1.0, pi / 2.0, 2.0, 5.0])
    exact = ratios**2 / (KD * (ratios - pi / 4.0))
    band, counts = radians_per_second(0.8, 1.35), (1024, 4096, 8192, 16384)
    curves = {n: performance_curve(single_mass(damping=0.0, kt=KD), ratios, harmonics=1, samples=n, band=band) for n in counts}
    heights = {n: curve.dataset.amplitude_per_force.values[0] for n, curve in curves.items()}
    for ratio, found, height in zip(ratios, heights[8192], exact, strict=True):
        yield relative(f"Undamped, μF_C/F_E = {ratio:.5g}: Fc²/(kd (Fc − πF/4))", found, height, 1e-6, CLOSED)
    errors = {n: np.abs(found / exact - 1.0) for n, found in heights.items()}
    yield at_most("Undamped, 4096 samples: largest error from μF_C/F_E = 1 on", errors[4096][1:].max(), 2e-6, CLOSED)
    order = np.log(errors[1024].max() / errors[16384].max()) / np.log(16.0)
    yield absolute("Undamped: order of the largest error in the samples, 1024 to 16384", order, 2.0, 0.2, "second order")
    frequency = 2.0 * pi * float(curves[8192].dataset.frequency[0, 2])
    yield relative("Undamped optimum: frequency √(k + kd/2)", frequency, sqrt(1.25), 1e-3, CLOSED)


def rig() -> Iterator[Row]:
    problem, ratios = single_blade(), logspace(0.4, 100.0, 60)
    with counted() as following:
        curve = performance_curve(problem, ratios, band=hertz(380.0, 600.0)).dataset
    pull, spent, gaps = float(curve.pull[0]), [], []
    for k in range(0, 60, 6):
        with counted() as sweep:
            peaks = forced_response(problem, hertz(380.0, 600.0), pull / ratios[k]).peaks()
        spent.append(sweep())
        gaps.append(float(curve.amplitude[0, k]) / float(peaks.amplitude.max()) - 1.0)
    each = float(np.mean(spent))
    yield at_most("Single blade: largest gap to ten forced responses", float(np.max(np.abs(gaps))), 1e-3, "cusps of 256 samples")
    share = float(curve.solves[0]) / 60.0 / each
    yield at_most("Single blade: solutions of following, per one of sweeping", share, 1.0 / 20.0, "twenty times fewer")
    whole = following() / 60.0 / each
    yield at_most("The same with the optimum and the sweeps that check it", whole, 1.0 / 8.0, "measured")


def slopes() -> Iterator[Row]:
    """A = 1/(c √(k/m − (c/2m)²)) of a linear mass."""
    ranges, share = {"damping": (0.018, 0.022), "stiffness": (0.9, 1.1), "mass": (0.9, 1.1)}, 1e-4

    def linear(**values: float) -> Problem:
        return single_mass(**values, kt=1e-9)

    found = sensitivity_indices(linear, ranges, radians_per_second(0.85, 1.15), draws=2, harmonics=1).dataset
    exact = (-0.2 * (1.0 - share), -0.1 * (1.0 + share), 0.1 * (1.0 - share))
    for name, slope, value in zip(ranges, found.slope.values, exact, strict=True):
        yield relative(f"What matters, linear mass: slope of ln A by the {name} over its range", slope, value, 2e-4, CLOSED)


def dry_and_oiled() -> Iterator[Row]:
    """What docs/performance.md says of the rig with two semi-cylinders."""
    optima = {(56.0, "inertance"): 0.75, (56.0, "receptance"): 0.89, (206.0, "inertance"): 0.66, (206.0, "receptance"): 0.81}
    for (pull, quantity), ratio in optima.items():
        rig = two_semi_cylinders(pull)
        best = performance_curve(rig, logspace(0.3, 10.0, 25), OILED, harmonics=3, quantity=quantity).optimum()
        yield relative(f"Oiled rig, {pull:g} N: optimum of the {quantity}, F_C/F_E", best["optimum_ratio"], ratio, 2e-2, PAGE)
    for pull, amplitude, frequency in ((56.0, 0.302, 0.0328), (206.0, 0.586, 0.0420)):
        spread = performance_curve(two_semi_cylinders(pull), logspace(0.3, 100.0, 40), [DRY, OILED], harmonics=3).collapse()
        name = f"{pull:g} N: spread of the dry and the oiled curve over μ F_C/F_E, "
        yield absolute(f"{name}logarithm of the amplitude", spread[0], amplitude, 5e-3, PAGE)
        yield absolute(f"{name}logarithm of the frequency", spread[1], frequency, 5e-4, PAGE)
    ratios = logspace(30.0, 180.0, 20)
    pair = performance_curve(two_semi_cylinders(206.0), ratios, [DRY, OILED], harmonics=3, quantity="inertance").dataset
    above = pair.amplitude_per_force.values[1] / pair.amplitude_per_force.values[0] - 1.0
    k = int(np.argmax(above > 0.0))
    start = np.exp(np.interp(0.0, above[k - 1 : k + 1], np.log(ratios[k - 1 : k + 1])))
    yield relative("206 N: F_C/F_E from which the oiled inertance is above the dry one", start, 41.6, 1e-2, PAGE)
    yield absolute("206 N: oiled inertance above the dry one, largest share", above.max(), 0.0231, 1e-3, PAGE)
