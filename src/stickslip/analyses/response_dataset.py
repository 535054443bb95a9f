"""From solved curves to the labelled dataset of a forced response: the schema's variables, padded to equal length."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.checks import Array
from stickslip.contact.point import DIRECTION_NAMES
from stickslip.harmonic.balance import Evaluation, HarmonicBalance
from stickslip.harmonic.cycle import ContactCycle, contact_cycle
from stickslip.harmonic.energy import EnergyBalance
from stickslip.harmonic.fourier import complex_harmonics
from stickslip.harmonic.linear_response import linear_amplitudes, linear_frequencies
from stickslip.harmonic.trigonometric import largest_absolute
from stickslip.outcome import Outcome
from stickslip.results_schema import SCHEMA, labelled
from stickslip.solve.continuation import CurvePoint
from stickslip.solve.curve import Curve

if TYPE_CHECKING:
    import xarray as xr


class ResponseTable:
    """Fills the arrays of the schema point by point."""

    def __init__(self, balance: HarmonicBalance, curves: Sequence[Curve]) -> None:
        self.balance, self.curves = balance, curves
        self.energy = EnergyBalance(balance)
        self.contact_of_row, self.direction_of_row = _places(balance)
        peaks = [len(found) for curve in curves for found in curve.peaks]
        self.sizes = {
            "case": len(curves),
            "point": max([len(curve.points) + (curve.lost_at is not None) for curve in curves], default=0),
            "output": balance.problem.output_rows.shape[0],
            "harmonic": balance.harmonics + 1,
            "part": 2,
            "contact": len(balance.problem.contacts),
            "direction": 3,
            "peak": max(peaks, default=0),
            "sample": balance.tables.E.shape[0],
        }
        self.arrays: dict[str, Any] = {}
        for variable in SCHEMA:
            if all(dim in self.sizes for dim in variable.dims):
                shape = tuple(self.sizes[dim] for dim in variable.dims)
                empty = {"float": np.nan, "int8": 0, "str": ""}[variable.kind]
                kind = {"float": float, "int8": np.int8, "str": object}[variable.kind]
                self.arrays[variable.name] = np.full(shape, empty, dtype=kind)

    def dataset(self, frequencies: tuple[float, float], attrs: dict[str, Any]) -> xr.Dataset:
        """The whole dataset; frequencies: the ends of the band in Hz."""
        for case, curve in enumerate(self.curves):
            self._fill_case(case, curve)
        self._fill_linear(*frequencies)
        problem = self.balance.problem
        coords = {
            "force_level": [curve.level for curve in self.curves],
            "output": list(problem.output_names),
            "contact": [contact.name for contact in problem.contacts],
            "direction": list(DIRECTION_NAMES),
        }
        return labelled(self.arrays, coords, attrs)

    def _fill_case(self, case: int, curve: Curve) -> None:
        arrays = self.arrays
        arrays["case_outcome"][case], arrays["case_message"][case] = curve.outcome, curve.message
        for k, point in enumerate(curve.points):
            self._fill_point((case, k), point)
        if curve.lost_at is not None:
            place = (case, len(curve.points))
            arrays["frequency"][place] = curve.lost_at / (2.0 * np.pi)
            arrays["outcome"][place] = curve.outcome
        for output, found in enumerate(curve.peaks):
            ranked = sorted(found, key=lambda p: -self._amplitude(p, output))
            for k, point in enumerate(ranked):
                self._fill_peak((case, k, output), point)
            if output == 0 and ranked:
                self._fill_loops(case, ranked[0])
        for output, extreme in enumerate(curve.largest):
            if extreme is not None:
                size = largest_absolute(extreme.evaluation.w[self.balance.rows + output])[0]
                arrays["highest_max_abs"][case, output] = size
                arrays["highest_max_abs_frequency"][case, output] = extreme.point.omega / (2.0 * np.pi)

    def _fill_point(self, place: tuple[int, int], point: CurvePoint) -> None:
        arrays, evaluation = self.arrays, point.evaluation
        cycle = self._cycle(evaluation)
        energy = self.energy.at(evaluation, cycle)
        arrays["frequency"][place] = evaluation.point.omega / (2.0 * np.pi)
        arrays["outcome"][place] = Outcome.CONVERGED
        arrays["residual"][place] = evaluation.error
        arrays["iterations"][place] = point.iterations
        arrays["active_rows"][place] = point.active
        arrays["loss_factor"][place] = energy.loss_factor
        arrays["energy_residual"][place] = energy.energy_residual
        arrays["slip_work_error"][place] = energy.slip_work_error
        rows = self.balance.rows
        self._fill_response(place, evaluation.w[rows:])
        self._by_row("contact_motion", place, _parts(evaluation.w[:rows]))
        self._by_row("contact_force", place, _parts(self.balance.carried_forces(evaluation)))
        for name, share in zip(("share_stick", "share_slip", "share_open"), cycle.shares(), strict=True):
            self._by_row(name, place, share)
        dissipated = np.bincount(self.contact_of_row, energy.dissipated, minlength=self.sizes["contact"])
        arrays["dissipated"][place] = dissipated

    def _fill_response(self, place: tuple[int, int], motion: Array) -> None:
        arrays = self.arrays
        arrays["response"][place] = _parts(motion)
        arrays["amplitude"][place] = np.hypot(motion[:, 1], motion[:, 2])
        arrays["rms"][place] = np.sqrt(motion[:, 0] ** 2 + 0.5 * np.sum(motion[:, 1:] ** 2, axis=1))
        arrays["max_abs"][place] = [largest_absolute(row)[0] for row in motion]

    def _fill_peak(self, place: tuple[int, int, int], point: CurvePoint) -> None:
        arrays, output = self.arrays, place[2]
        arrays["peak_frequency"][place] = point.point.omega / (2.0 * np.pi)
        arrays["peak_amplitude"][place] = self._amplitude(point, output)
        arrays["peak_max_abs"][place] = largest_absolute(point.evaluation.w[self.balance.rows + output])[0]
        energy = self.energy.at(point.evaluation, self._cycle(point.evaluation))
        arrays["peak_loss_factor"][place] = energy.loss_factor

    def _fill_loops(self, case: int, point: CurvePoint) -> None:
        cycle = self._cycle(point.evaluation)
        self.arrays["loop_frequency"][case] = point.point.omega / (2.0 * np.pi)
        self._by_row("loop_motion", (case,), cycle.displacement)
        self._by_row("loop_force", (case,), cycle.force)

    def _fill_linear(self, low: float, high: float) -> None:
        frequencies = linear_frequencies(self.balance, low, high)
        free, stuck = linear_amplitudes(self.balance, frequencies)
        levels = np.array([curve.level for curve in self.curves])[:, None, None]
        problem = self.balance.problem
        natural = [problem.frequencies(stuck=which) for which in (False, True)]
        longest = max(values.size for values in natural)
        padded = [np.pad(values, (0, longest - values.size), constant_values=np.nan) for values in natural]
        self.arrays |= {
            "linear_frequency": frequencies,
            "free_amplitude": levels * free,
            "stuck_amplitude": levels * stuck,
            "natural_frequency_free": padded[0],
            "natural_frequency_stuck": padded[1],
        }

    def _cycle(self, evaluation: Evaluation) -> ContactCycle:
        return contact_cycle(self.balance.table, self.balance.tables, evaluation.w)

    def _amplitude(self, point: CurvePoint, output: int) -> float:
        return float(np.hypot(*point.evaluation.w[self.balance.rows + output, 1:3]))

    def _by_row(self, name: str, place: tuple[int, ...], values: Array) -> None:
        """Values (rows, ...) into (contact, direction, ...)."""
        self.arrays[name][place][self.contact_of_row, self.direction_of_row] = values


def _places(balance: HarmonicBalance) -> tuple[np.ndarray, np.ndarray]:
    """Contact and direction (0, 1, 2 for t1, t2, n) of each row."""
    contacts = balance.problem.contacts
    pairs = [(c, DIRECTION_NAMES.index(name)) for c, contact in enumerate(contacts) for name in contact.direction_names]
    table = np.array(pairs, dtype=int).reshape(len(pairs), 2)
    return table[:, 0], table[:, 1]


def _parts(motion: Array) -> Array:
    """Complex harmonics as (..., H+1, 2): real and imaginary part."""
    values = complex_harmonics(motion)
    return np.stack([values.real, values.imag], axis=-1)
