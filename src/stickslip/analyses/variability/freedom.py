"""Freedom of friction forces along a curve: the interval of each stuck element and its effect on the response."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stickslip.analyses.response_dataset import as_given
from stickslip.analyses.settings import output_of
from stickslip.model.contact.period import OFFSET
from stickslip.model.problem import Problem
from stickslip.results.result import Result
from stickslip.runs.work import Progress, checked_progress
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance
from stickslip.solve.continuation.sensitivity import respond, solved_factors, start_slopes
from stickslip.solve.curves.curve import solve_curve
from stickslip.solve.starts.states import element_states, refuse_forgetful
from stickslip.support.checks import InputError, fault, positive
from stickslip.support.late import xr
from stickslip.support.machine import one_blas_thread
from stickslip.support.units import Band, in_order


@dataclass(frozen=True, eq=False, repr=False)
class FrictionFreedom(Result):
    """`dataset`, by (point, element): mean traction and its admissible interval [N]; `slope`, the change of |X_1| with the
    traction that a moved slider puts on, −d|X_1|/(kt ds) [m/N]; `carried`, slope times the length of the interval [m]: what the
    slider of this element alone could change, to first order.
    """

    dataset: xr.Dataset
    problem: Problem

    def ranking(self, frequency: float | None = None) -> list[tuple[str, float]]:
        """Rows of contacts and the variability they carry, largest first: at the point nearest to a frequency in Hz, relative to
        the amplitude there; else the most they carry anywhere, relative to the largest amplitude.
        """
        d = self.dataset
        amplitude, carried, rows = d["amplitude"].values, np.abs(d["carried"].values), d["element_row"].values
        if frequency is not None:
            k = int(np.argmin(np.abs(d["frequency"].values - frequency)))
            amplitude, carried = amplitude[k : k + 1], carried[k : k + 1]
        most = float(np.max(amplitude))
        sums = {name: float(carried[:, rows == name].sum(axis=1).max()) / most for name in dict.fromkeys(rows.tolist())}
        return sorted(sums.items(), key=lambda item: -item[1])


def friction_freedom(
    problem: Problem,
    band: Band | Sequence[float],
    force: float = 1.0,
    *,
    output: int = 0,
    harmonics: int | Sequence[int] = 5,
    samples: int = 256,
    progress: Progress = lambda fraction, text: None,
) -> FrictionFreedom:
    """The admissible interval of every stuck friction element along a curve, from the problem's own start states.

    A stuck element may carry any mean traction in [LO + kt ū, HI + kt ū], with [LO, HI] the interval of its period map; one that
    slips has no choice, and its interval has no length. The motion is held while an interval is found: neighbours shift it.
    band: a `Band` to continue over, or frequencies in Hz.
    """
    output, force = output_of(problem, output), positive("force", force)
    refuse_forgetful(problem)
    checked_progress(progress)
    if isinstance(band, Band):
        listed, exactly = [band.start, band.stop], False
    else:
        listed, exactly = sorted(set(in_order(band))), True
    with one_blas_thread():
        balance = HarmonicBalance(problem, harmonics, samples)
        if any(contact.law.couples_directions for contact in problem.contacts):
            raise InputError("Intervals must be of one direction each, but a friction disc couples two. Use macroslip.")
        omegas = [2.0 * np.pi * f for f in listed]
        curve = solve_curve(balance, omegas, force, exactly, lambda fraction: progress(fraction, f"force {force:g}"))
        if not curve.points:
            raise fault("The curve", "must be solvable", curve.message)
        arrays = _arrays(balance, [point.evaluation for point in curve.points], output)
        arrays["frequency"] = as_given(arrays["frequency"], listed)
    return FrictionFreedom(_dataset(problem, arrays, {"title": problem.heading, "force": force}), problem)


def _arrays(balance: HarmonicBalance, evaluations: Sequence[Evaluation], output: int) -> dict[str, Any]:
    size, row = balance.table.stiffness.size, balance.rows + output
    shape = (len(evaluations), size)
    arrays: dict[str, Any] = {name: np.zeros(shape) for name in ("mean", "low", "high", "slope")}
    arrays["frequency"] = np.array([evaluation.point.omega / (2.0 * np.pi) for evaluation in evaluations])
    arrays["amplitude"] = np.array([float(np.hypot(*evaluation.w[row, 1:3])) for evaluation in evaluations])
    for k, evaluation in enumerate(evaluations):
        states = element_states(balance, evaluation)
        arrays["mean"][k], arrays["low"][k], arrays["high"][k] = states.mean, states.low, states.high
        resting = balance.with_starts(states.slider, OFFSET)
        evaluation = resting.evaluate(evaluation.point)
        elements, slopes = start_slopes(resting, evaluation)
        if elements.size:
            unit = -slopes / resting.table.stiffness[elements, None, None]
            motion = respond(resting, evaluation, solved_factors(resting, evaluation), unit).motion[:, row, 1:3]
            arrays["slope"][k, elements] = motion @ evaluation.w[row, 1:3] / arrays["amplitude"][k]
    arrays["carried"] = arrays["slope"] * (arrays["high"] - arrays["low"])
    return arrays


def _dataset(problem: Problem, arrays: dict[str, Any], attrs: dict[str, Any]) -> xr.Dataset:
    names: list[str] = []
    for contact in problem.contacts:
        for d, group in zip(contact.direction_names, contact.elements.friction, strict=False):
            names += [f"{contact.name} {d}"] * group.stiffness.size
    by = ("point", "element")
    words = {
        "mean": ("N", "mean traction"),
        "low": ("N", "lowest admissible mean traction"),
        "high": ("N", "highest admissible mean traction"),
        "slope": ("m/N", "change of the amplitude with the traction put on by the slider"),
        "carried": ("m", "change of the amplitude over the interval, to first order"),
    }
    data: dict[str, Any] = {name: (by, arrays[name], {"units": unit, "long_name": text}) for name, (unit, text) in words.items()}
    data["amplitude"] = (("point",), arrays["amplitude"], {"units": "m", "long_name": "amplitude of the first harmonic"})
    coords = {"frequency": ("point", arrays["frequency"], {"units": "Hz"}), "element_row": ("element", names)}
    return xr.Dataset(data, coords, attrs)
