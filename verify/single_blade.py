"""The single blade with two dampers: the rig of the demo, and the numbers of docs/single_blade.md."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy import linalg

from stickslip.analyses.forced_response import ForcedResponse, forced_response
from stickslip.analyses.variability.samples import response_samples
from stickslip.model.dampers.cylinder import FlatCylinder
from stickslip.model.problem import Problem
from stickslip.model.rigs import single_blade
from stickslip.model.rigs.single_blade import PlatformBlade, pads, placed_dampers, reduced_blade
from stickslip.support.outcome import Outcome
from stickslip.support.units import hertz
from verify.row import INDEPENDENT, PAGE, Row, absolute, at_most, relative

TITLE = "Single blade with two dampers"
ABOUT = (
    "Preloads of 2.6, 4.6 and 6.6 kg, force levels of 1, 5, 20, 50, 80 and 100 N, virgin start, 5 harmonics, 256 "
    "samples, 390 to 600 Hz. The paper publishes 410 Hz (free) and 529 Hz (80 N, 4.6 kg); both were used to calibrate "
    "the dimensions."
)
LEVELS = [1.0, 5.0, 20.0, 50.0, 80.0, 100.0]
# Displacement peaks by preload, at each of LEVELS: Hz, µm.
DISPLACEMENT = {
    2.6: ((536.8, 0.526), (534.0, 1.495), (528.9, 2.708), (514.1, 3.436), (474.7, 5.625), (434.9, 8.109)),
    4.6: ((551.7, 0.478), (550.2, 1.461), (543.4, 3.368), (541.5, 4.514), (528.6, 5.162), (518.1, 5.724)),
    6.6: ((552.4, 0.468), (551.9, 1.640), (546.8, 3.747), (539.4, 5.674), (537.7, 6.679), (533.3, 7.118)),
}
# Acceleration peaks at 4.6 kg, at each of LEVELS: Hz, m/s².
ACCELERATION = ((551.7, 5.739), (550.6, 17.47), (544.5, 39.34), (552.1, 53.56), (564.6, 60.93), (569.8, 65.39))
# Displacement peaks at 4.6 kg by number of harmonics, at 20 and at 80 N: Hz, µm.
HARMONICS = {
    3: ((543.5, 3.365), (526.8, 5.174)),
    7: ((543.4, 3.371), (529.7, 5.163)),
    11: ((543.2, 3.306), (531.4, 5.158)),
    21: ((543.6, 3.300), (533.9, 5.148)),
}


def rows() -> Iterator[Row]:
    yield from at_the_page_levels((2.6, 4.6, 6.6))
    rig = single_blade(4.6)
    yield from accelerations(rig)
    for count, expected in HARMONICS.items():
        found = forced_response(rig, hertz(500.0, 580.0), [20.0, 80.0], harmonics=count)
        for level, (frequency, amplitude), peak in zip((20.0, 80.0), expected, highest(found), strict=True):
            yield from stated(f"4.6 kg, {level:g} N, {count} harmonics: displacement peak", peak, frequency, amplitude, "µm")
    finer = forced_response(single_blade(2.6), hertz(390.0, 600.0), 100.0, harmonics=21)
    yield from stated("2.6 kg, 100 N, 21 harmonics: displacement peak", highest(finer)[0], 478.0, 6.718, "µm")
    yield from other_angles()
    yield from drawn_starts(rig)


def one_seed() -> Iterator[Row]:
    """The preload that the paper publishes."""
    yield from at_the_page_levels((4.6,))


def highest(response: ForcedResponse) -> list[tuple[float, float]]:
    """Frequency and height of the highest peak of each force level."""
    peaks = response.peaks()
    top = peaks[peaks.peak == 0]
    return list(zip(top.frequency, top.amplitude, strict=True))


def stated(name: str, peak: tuple[float, float], frequency: float, height: float, unit: str) -> Iterator[Row]:
    """A peak against what the page says."""
    yield relative(f"{name}, Hz", peak[0], frequency, 1e-3, PAGE)
    yield relative(f"{name}, {unit}", peak[1] * (1e6 if unit == "µm" else 1.0), height, 1e-3, PAGE)


def accelerations(rig: Problem) -> Iterator[Row]:
    """What an accelerometer sees, and how far below it the displacement peak lies."""
    response = forced_response(rig, hertz(390.0, 620.0), LEVELS, quantity="acceleration")
    for level, expected, peak in zip(LEVELS, ACCELERATION, highest(response), strict=True):
        yield from stated(f"4.6 kg, {level:g} N: acceleration peak", peak, *expected, "m/s²")
    ((_, top),) = highest(forced_response(rig, hertz(500.0, 600.0), 80.0, quantity="acceleration"))
    ((frequency, amplitude),) = highest(forced_response(rig, hertz(500.0, 600.0), 80.0))
    below = 1.0 - amplitude * (2.0 * np.pi * frequency) ** 2 / top
    yield absolute("4.6 kg, 80 N: acceleration at the displacement peak, below its own peak", below, 0.0655, 2e-3, PAGE)
    ((frequency, _),) = highest(forced_response(rig, hertz(500.0, 600.0), 80.0, harmonics=21, quantity="acceleration"))
    yield relative("4.6 kg, 80 N, 21 harmonics: acceleration peak, Hz", frequency, 568.6, 1e-3, PAGE)


def other_angles() -> Iterator[Row]:
    """The platform angles between which the acceleration peak at 80 N would come to 529 Hz."""
    for angle, accelerated, stuck, at_20 in ((33.0, 521.9, 529.0, 516.0), (35.0, 531.2, 533.0, 521.0)):
        rig = single_blade(4.6, platform_angle=angle)
        ((frequency, _),) = highest(forced_response(rig, hertz(450.0, 600.0), 80.0, quantity="acceleration"))
        yield relative(f"Platform at {angle:g}°, 80 N: acceleration peak, Hz", frequency, accelerated, 1e-3, PAGE)
        yield relative(f"Platform at {angle:g}°: stuck frequency, Hz", rig.frequencies(stuck=True)[0], stuck, 1e-3, PAGE)
        ((frequency, _),) = highest(forced_response(rig, hertz(450.0, 600.0), 20.0, quantity="acceleration"))
        yield relative(f"Platform at {angle:g}°, 20 N: acceleration peak, Hz", frequency, at_20, 1e-3, PAGE)


def drawn_starts(rig: Problem) -> Iterator[Row]:
    """The highest peaks of twenty drawn start states."""
    for level, frequencies, amplitudes in (
        (20.0, (532.9, 548.1), (3.00, 4.33)),
        (80.0, (507.6, 536.7), (4.98, 7.31)),
    ):
        peaks = response_samples(rig, hertz(500.0, 580.0), level, 20).peaks()
        for word, index in (("lowest", 0), ("highest", 1)):
            ends = np.sort(peaks.frequency)[[0, -1]], 1e6 * np.sort(peaks.amplitude)[[0, -1]]
            name = f"4.6 kg, {level:g} N, twenty drawn start states: {word}"
            yield relative(f"{name} peak frequency, Hz", ends[0][index], frequencies[index], 2e-3, PAGE)
            yield relative(f"{name} peak, µm", ends[1][index], amplitudes[index], 5e-3, PAGE)


def at_the_page_levels(preloads: tuple[float, ...]) -> Iterator[Row]:
    """The highest peaks at the preloads [kg] of the page, and its linear frequencies."""
    dampers = placed_dampers(PlatformBlade(), FlatCylinder(), 4.6 * 9.81)
    structure = reduced_blade(PlatformBlade(), tuple(pad for damper in dampers for pad in pads(damper)), 150).structure
    free = np.sqrt(linalg.eigvalsh(structure.K, structure.M)[:2]) / (2.0 * np.pi)
    yield relative("Free blade: first mode (lateral), Hz", free[0], 410.0, 1e-3, "published")
    yield relative("Free blade: second mode (axial), Hz", free[1], 661.92, 1e-3, INDEPENDENT)
    for mass in preloads:
        rig = single_blade(mass)
        response = forced_response(rig, hertz(390.0, 600.0), LEVELS, harmonics=5)
        dataset, peaks = response.dataset, highest(response)
        present = dataset.outcome != Outcome.EMPTY
        unsolved = int(
            ((dataset.outcome != Outcome.CONVERGED) & present).sum() + (dataset.case_outcome != Outcome.CONVERGED).sum()
        )
        yield absolute(f"{mass:g} kg: points not converged, of {int(present.sum())}", unsolved, 0, 0.0, "every point")
        yield at_most(f"{mass:g} kg: largest energy residual", float(dataset.energy_residual.max()), 1e-8, "energy balance")
        yield at_most(f"{mass:g} kg: largest slip work error", float(dataset.slip_work_error.max()), 1e-3, "energy balance")
        if mass == 4.6:
            yield relative("4.6 kg: stuck frequency, Hz", rig.frequencies(stuck=True)[0], 561.1, 2e-3, INDEPENDENT)
            yield relative("4.6 kg, 80 N: peak frequency, Hz", peaks[4][0], 528.7, 3e-3, INDEPENDENT)
        for level, expected, peak in zip(LEVELS, DISPLACEMENT[mass], peaks, strict=True):
            yield from stated(f"{mass:g} kg, {level:g} N: displacement peak", peak, *expected, "µm")
