"""Forced response: steady vibration under harmonic forces over a frequency band, at one or several force levels."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from threadpoolctl import threadpool_limits

from stickslip.analyses.response_dataset import ResponseTable
from stickslip.checks import InputError, fault, finite, positive
from stickslip.harmonic.balance import HarmonicBalance
from stickslip.harmonic.cycle import ContactCycle, contact_cycle
from stickslip.harmonic.linear_part import real_harmonics
from stickslip.problem import Problem
from stickslip.results import save
from stickslip.solve.curve import Curve, solve_curve
from stickslip.units import Band

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

Progress = Callable[[float, str], None]


@dataclass(frozen=True, eq=False)
class ForcedResponse:
    """Curves for every force level: `dataset` (labelled, with units) and the problem that made them."""

    dataset: xr.Dataset
    problem: Problem

    def peaks(self) -> pd.DataFrame:
        """All peaks: force level, output, frequency [Hz], amplitude [m], largest |x| [m], loss factor; highest first."""
        names = ("peak_frequency", "peak_amplitude", "peak_max_abs", "peak_loss_factor")
        table = self.dataset[list(names)].to_dataframe().reset_index().dropna(subset=["peak_frequency"])
        table = table.rename(columns={name: name.removeprefix("peak_") for name in names})
        columns = ["force_level", "output", "peak", *(name.removeprefix("peak_") for name in names)]
        return table[columns].sort_values(["force_level", "output", "peak"], ignore_index=True)

    def cycle(self, case: int, point: int) -> ContactCycle:
        """Motion, force and state of every contact row over the period of one point."""
        parts = self.dataset["contact_motion"].isel(case=case, point=point).to_numpy()
        present = [
            (c, ("t1", "t2", "n").index(name))
            for c, contact in enumerate(self.problem.contacts)
            for name in contact.direction_names
        ]
        w = np.array([real_harmonics(parts[c, d, :, 0] + 1j * parts[c, d, :, 1]) for c, d in present])
        balance = HarmonicBalance(self.problem, int(self.dataset.attrs["harmonics"]), int(self.dataset.attrs["samples"]))
        return contact_cycle(balance.table, balance.tables, w)

    def plot(self, **options: Any) -> Any:
        """The figure of the curves."""
        from stickslip.plots import plot

        return plot(self, **options)

    def save(self, path: str | Path) -> Path:
        """Write the dataset as NetCDF."""
        return save(self.dataset, path)


def forced_response(
    problem: Problem,
    band: Band | Sequence[float],
    force: float | Sequence[float] = 1.0,
    harmonics: int = 5,
    samples: int = 256,
    *,
    progress: Progress = lambda fraction, text: None,
) -> ForcedResponse:
    """Steady response X_h(ω) of M q̈ + C q̇ + K q + Bᵀ f(B q) = p over a band, by harmonic balance.

    band: a `Band` in Hz, continued from start to stop; or frequencies in Hz, solved exactly there and reached by continuation.
    force: level or levels that multiply every harmonic force. harmonics H: 0..H are kept. samples: per period, at least 4H + 2.
    progress(fraction, text) is called as the work goes on.

    Returns a `ForcedResponse`; its dataset has axes (case, point, ...), one case per force level.
    """
    frequencies, exactly = _frequencies(band)
    levels = _levels(force)
    started = time.process_time()
    progress(0.0, "preparing (the first run on a machine compiles the kernels)")
    with threadpool_limits(1, user_api="blas"):
        balance = HarmonicBalance(problem, _whole("harmonics", harmonics), _whole("samples", samples))
        curves: list[Curve] = []
        for k, level in enumerate(levels):
            text = f"force level {level:g}"

            def part(fraction: float, k: int = k, text: str = text) -> None:
                progress((k + min(max(fraction, 0.0), 1.0)) / len(levels), text)

            omegas = [2.0 * np.pi * frequency for frequency in frequencies]
            curves.append(solve_curve(balance, omegas, level, exactly, part))
        solved = time.process_time() - started
        progress(1.0, "energies, states and linear curves")
        attrs = {
            "title": problem.title,
            "study": "",
            "harmonics": harmonics,
            "samples": samples,
            "cpu_seconds": solved,
        }
        ends = (min(frequencies), max(frequencies)) if len(set(frequencies)) > 1 else _around(frequencies[0])
        dataset = ResponseTable(balance, curves).dataset(ends, attrs)
    return ForcedResponse(dataset, problem)


def _frequencies(band: Band | Sequence[float]) -> tuple[list[float], bool]:
    """Frequencies in Hz in the order of travel, and whether only these are wanted."""
    if isinstance(band, Band):
        return [band.start, band.stop], False
    listed = [positive("A frequency", frequency) for frequency in band]
    if not listed:
        raise InputError("The frequencies must hold at least one value, but are empty. Give a Band or a list in Hz.")
    return sorted(set(listed)), True


def _levels(force: float | Sequence[float]) -> list[float]:
    levels = [finite("force", level) for level in np.atleast_1d(np.asarray(force, dtype=float))]
    if not levels:
        raise InputError("force must hold at least one level, but is empty.")
    for level in levels:
        if level <= 0.0:
            raise fault("force", "must be positive", level, "Turn a force round by its phase.")
    return levels


def _whole(name: str, value: int) -> int:
    if isinstance(value, bool) or int(value) != value:
        raise fault(name, "must be a whole number", value)
    return int(value)


def _around(frequency: float) -> tuple[float, float]:
    return 0.9 * frequency, 1.1 * frequency
