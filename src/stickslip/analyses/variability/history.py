"""Loading history: a sequence of force levels that carries the sliders from point to point, as in a test campaign."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stickslip.model.problem import Problem
from stickslip.results.schema import Result, described, named
from stickslip.runs.work import Progress, checked_progress
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.balance.energy import contact_cycle
from stickslip.solve.balance.fourier import attribute, complex_harmonics
from stickslip.solve.continuation.newton import Correction
from stickslip.solve.starts.states import march
from stickslip.support.checks import Array, InputError, between, fault, numbers, of_kind, positive
from stickslip.support.late import xr
from stickslip.support.machine import one_blas_thread
from stickslip.support.outcome import Outcome
from stickslip.support.units import Band, in_order

UP_AND_DOWN = (1.0, 5.0, 20.0, 50.0, 80.0, 100.0, 80.0, 50.0, 20.0, 5.0, 1.0)
"""The history of the published experiment, N: from 1 to 100 N and back."""


@dataclass(frozen=True, eq=False, repr=False)
class ResponseHistory(Result):
    """`dataset`: one run per force level in the order of time: amplitude, response and contact cycles of every point by
    (run, frequency, ...), the frequency and amplitude of each run's largest point, slider positions at its end.
    """

    dataset: xr.Dataset
    problem: Problem

    def runs_at(self, level: float) -> list[int]:
        """The runs at a force level, in order of time."""
        found = np.flatnonzero(np.isclose(self.dataset["force_level"].values, level))
        if not found.size:
            raise fault("level", f"must be one of {sorted(set(self.dataset['force_level'].values.tolist()))}", level)
        return [int(run) for run in found]

    def change(self, level: float, output: int = 0) -> dict[str, float]:
        """What a history does to a level: relative change of its largest amplitude, change of its frequency [Hz], and largest
        change of a mean tangential contact force [N], from the first run at that level to the last.
        """
        first, *_, last = self.runs_at(level) * (1 if len(self.runs_at(level)) > 1 else 2)
        d = self.dataset
        amplitudes, hertz = d["largest_amplitude"].values[:, output], d["largest_frequency"].values[:, output]
        mean = d["largest_contact_force"].values.mean(axis=-1)
        return {
            "amplitude": float(amplitudes[last] / amplitudes[first] - 1.0),
            "frequency": float(hertz[last] - hertz[first]),
            "mean_force": float(np.nanmax(np.abs(mean[last] - mean[first]))),
        }


def response_history(
    problem: Problem,
    band: Band | Sequence[float],
    force: Sequence[float] = UP_AND_DOWN,
    *,
    points: int = 61,
    harmonics: int | Sequence[int] = 5,
    samples: int = 256,
    progress: Progress = lambda fraction, text: None,
) -> ResponseHistory:
    """Sweeps over frequency at force levels in the order of time; sliders are carried from point to point and run to run.

    band: a `Band`, in `points` equal steps from its start to its stop in every run; or frequencies in Hz in the order of the
    sweep. A point that does not converge is marked and leaves the sliders as they were.
    """
    of_kind("problem", problem, Problem)
    levels = [positive("force", level) for level in np.atleast_1d(numbers("force", force))]
    if isinstance(band, Band):
        frequencies = np.linspace(band.start, band.stop, between("points", points, 1))
    else:
        frequencies = np.array(in_order(band))
    if not levels:
        raise InputError("force must hold at least one level, but is empty.")
    checked_progress(progress)
    started = time.process_time()
    with one_blas_thread():
        balance = HarmonicBalance(problem, harmonics, samples)
        table = _Table(balance, levels, frequencies)
        for k, (level, correction) in enumerate(march(balance, (2.0 * np.pi * frequencies).tolist(), levels)):
            progress(k / (len(levels) * frequencies.size), f"force {level:g}, {frequencies[k % frequencies.size]:.4g} Hz")
            table.fill(*divmod(k, frequencies.size), correction)
    attrs = {"harmonics": attribute(balance.harmonics), "samples": samples, "cpu_seconds": time.process_time() - started}
    return ResponseHistory(table.dataset({"title": problem.heading} | attrs), problem)


class _Table:
    """The arrays of a history, filled point by point; contact cycles are kept at the largest point of each run only."""

    def __init__(self, balance: HarmonicBalance, levels: Sequence[float], frequencies: Array) -> None:
        self.balance, self.levels, self.frequencies = balance, levels, frequencies
        outputs, samples = balance.problem.output_rows.shape[0], balance.tables.E.shape[0]
        runs, steps = len(levels), frequencies.size
        self.outcome = np.full((runs, steps), Outcome.NOT_CONVERGED, dtype=np.int8)
        self.response = np.full((runs, steps, outputs, balance.highest + 1, 2), np.nan)
        self.amplitude = np.full((runs, steps, outputs), np.nan)
        self.slider = np.full((runs, balance.table.stiffness.size), np.nan)
        self.force, self.motion = (np.full((runs, balance.rows, samples), np.nan) for _ in range(2))
        self.largest: dict[int, float] = {}

    def fill(self, run: int, step: int, correction: Correction) -> None:
        """Note a point."""
        if not correction.converged:
            return
        evaluation, rows = correction.evaluation, self.balance.rows
        self.outcome[run, step] = Outcome.CONVERGED
        values = complex_harmonics(evaluation.w[rows:])
        self.response[run, step] = np.stack([values.real, values.imag], axis=-1)
        self.amplitude[run, step] = np.hypot(evaluation.w[rows:, 1], evaluation.w[rows:, 2])
        size = float(self.amplitude[run, step, 0])
        cycle = contact_cycle(evaluation.table, self.balance.tables, evaluation.w, evaluation.point.omega)
        self.slider[run] = cycle.slider
        if size > self.largest.get(run, -1.0):
            self.largest[run] = size
            self.force[run], self.motion[run] = cycle.force, cycle.displacement

    def dataset(self, attrs: dict[str, Any]) -> xr.Dataset:
        """The labelled dataset."""
        problem = self.balance.problem
        names = [f"{contact.name} {d}" for contact in problem.contacts for d in contact.direction_names]
        where = np.nanargmax(np.where(np.isnan(self.amplitude), -1.0, self.amplitude), axis=1)
        top = np.take_along_axis(self.amplitude, where[:, None, :], axis=1)[:, 0]
        return xr.Dataset(
            described(
                "load_history",
                {
                    "outcome": self.outcome,
                    "amplitude": self.amplitude,
                    "response": self.response,
                    "largest_amplitude": top,
                    "largest_frequency": self.frequencies[where],
                    "largest_contact_force": self.force,
                    "largest_contact_motion": self.motion,
                    "slider": self.slider,
                },
            ),
            {
                "force_level": ("run", list(self.levels)),
                "frequency": named("frequency", self.frequencies, "frequency", "Hz"),
                "output": list(problem.output_names),
                "row": names,
                "part": ["re", "im"],
            },
            attrs,
        )
