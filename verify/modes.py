"""Nonlinear modes: one mass against its closed form, peaks from modes against sweeps, and what they cost."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from stickslip.analyses.forced_response import forced_response
from stickslip.analyses.modes.nonlinear_modes import NonlinearModes, nonlinear_modes
from stickslip.model.problem import Problem
from stickslip.model.rigs import chain, chain_varying_load, single_blade, single_mass
from stickslip.support.units import Band, hertz
from verify.row import CLOSED, Row, absolute, at_most, relative

TITLE = "Nonlinear modes"
ABOUT = (
    "Benchmarks of one mass (B1), the chain of 20 masses with constant (B2a) and with varying normal load (B2b), 7 harmonics, "
    "256 samples; single blade, 4.6 kg, 5 harmonics. Peaks of the first harmonic from the mode against those of forced "
    "responses; costs in CPU time, of 100 force levels from a mode that is computed anew against 100 forced responses over a "
    "band."
)
SWEEPS = "forced responses of this program"
LEVELS = {"B1": (0.1, 0.5, 1.0, 2.0), "chain": (0.02, 0.05, 0.1, 0.2, 0.5), "blade": (1.0, 5.0, 20.0, 50.0, 80.0, 100.0)}


def rows() -> Iterator[Row]:
    yield from describing_function()
    yield from compared("B1", single_mass(), hertz(0.1, 0.3), LEVELS["B1"], 7, 5e-4)
    yield from compared("B2a, mode 1", chain(), hertz(0.03, 0.05), LEVELS["chain"], 7, 1e-2)
    yield from compared("B2b, mode 1", chain_varying_load(), hertz(0.03, 0.05), LEVELS["chain"], 7, 1e-2)
    yield from compared("Single blade", single_blade(4.6), hertz(390.0, 600.0), LEVELS["blade"], 5, 0.03)
    yield from costs()


def one_seed() -> Iterator[Row]:
    """The closed form, and a force level of the single blade."""
    yield from describing_function()
    yield from compared("Single blade", single_blade(4.6), hertz(390.0, 600.0), LEVELS["blade"][2:3], 5, 0.03)


def exact(amplitude: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """ω and ζ of m = k = kd = Fc = 1, c = 0.02: ω² = k + k_eq, 2ζω = c_eq + c."""
    slip = np.maximum(amplitude, 1.0)
    t = np.arccos(1.0 - 2.0 / slip)
    omega = np.sqrt(1.0 + (t - 0.5 * np.sin(2.0 * t)) / np.pi)
    return omega, 0.5 * (4.0 / (np.pi * slip) * (1.0 - 1.0 / slip) / omega + 0.02) / omega


def describing_function() -> Iterator[Row]:
    errors = {}
    for samples in (64, 256, 1024, 65536):
        data = nonlinear_modes(single_mass(), amplitude=(0.5, 50.0), harmonics=1, samples=samples).dataset
        omega, zeta = exact(data["modal_amplitude"].values[0])
        gaps = 2.0 * np.pi * data["frequency"].values[0] / omega, data["damping_ratio"].values[0] / zeta
        errors[samples] = max(float(np.max(np.abs(gap - 1.0))) for gap in gaps)
    yield at_most("One mass, 65536 samples: ω and ζ, largest error", errors[65536], 1e-8, CLOSED)
    yield at_most("One mass, 256 samples: ω and ζ, largest error", errors[256], 1e-4, CLOSED)
    order = np.log(errors[64] / errors[1024]) / np.log(16.0)
    yield absolute("One mass: order of that error in the samples, 64 to 1024", order, 2.0, 0.2, "second order")


def mode_of(name: str, problem: Problem, harmonics: int) -> NonlinearModes:
    """The first mode, up to amplitudes that the force levels reach."""
    ends = (2e-8, 2e-5) if name == "Single blade" else None
    return nonlinear_modes(problem, 1, ends, harmonics)


def compared(name: str, problem: Problem, band: Band, levels: Sequence[float], harmonics: int, tolerance: float) -> Iterator[Row]:
    """The highest peak of each force level."""
    swept = forced_response(problem, band, list(levels), harmonics).peaks()
    heights = swept[swept["peak"] == 0]["amplitude"].to_numpy()
    found = mode_of(name, problem, harmonics).peaks(list(levels)).drop_duplicates("force_level")["amplitude"].to_numpy()
    for level, height, amplitude in zip(levels, heights, found, strict=True):
        yield relative(f"{name}, force level {level:g}: peak from the mode", amplitude, height, tolerance, SWEEPS)


def seconds(run: Callable[[], Any]) -> float:
    """CPU time of a call, after kernels are loaded."""
    started = time.process_time()
    run()
    return time.process_time() - started


def costs() -> Iterator[Row]:
    """How many times as long sweeping takes; of the blade from 10 sweeps."""
    blade = single_blade(4.6)
    cases = (
        ("B1", single_mass(), hertz(0.1, 0.3), np.geomspace(0.1, 2.0, 100), 7),
        ("B2b", chain_varying_load(), hertz(0.03, 0.05), np.geomspace(0.02, 0.5, 100), 7),
        ("Single blade", blade, hertz(390.0, 600.0), np.geomspace(1.0, 100.0, 10), 5),
    )
    for name, problem, band, levels, harmonics in cases:
        hundred = np.geomspace(levels[0], levels[-1], 100)
        mode = seconds(lambda name=name, problem=problem, h=harmonics, at=hundred: mode_of(name, problem, h).peaks(at))
        sweeping = 100.0 / levels.size * seconds(lambda p=problem, b=band, at=levels, h=harmonics: forced_response(p, b, at, h))
        yield at_most(f"{name}, 100 force levels: time from the mode over that of sweeping", mode / sweeping, 1.0 / 20.0, SWEEPS)
