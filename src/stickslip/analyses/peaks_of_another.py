"""Peaks of a quantity other than the computed one, searched and solved between the points of a forced response."""

from __future__ import annotations

from typing import Any

from stickslip.analyses.solved_points import SolvedPoints
from stickslip.model.loads import excited_harmonics
from stickslip.model.problem import Problem
from stickslip.results.view import band_of
from stickslip.solve.balance.energy import EnergyBalance
from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.interpolation import Interpolation
from stickslip.solve.peaks.search import PeakSearch
from stickslip.support.checks import InputError
from stickslip.support.late import pd, xr
from stickslip.support.machine import one_blas_thread


def refuse_unexcited(problem: Problem, measure: Measure) -> None:
    """Refuse peaks of the first harmonic where the load excites others."""
    excited = excited_harmonics(problem.forces)
    if excited and measure.kind == "amplitude" and 1 not in excited:
        raise InputError(
            "The peaks of a band must be of what the load excites, but they are of the amplitude of the first harmonic, and "
            f'the load excites {", ".join(f"harmonic {h}" for h in sorted(excited))}. Take measure="max_abs" or "rms".'
        )


def peaks_of_another(dataset: xr.Dataset, problem: Problem, measure: Measure) -> pd.DataFrame:
    """The peaks of a measure along every curve inside its band, as the table of `ForcedResponse.peaks`."""
    points = SolvedPoints(dataset, problem)
    balance = points.balance
    measure = measure.over(balance.periods)
    largest = measure.with_kind("max_abs")
    rows: list[dict[str, Any]] = []
    band = band_of(dataset)
    with one_blas_thread():
        energy = EnergyBalance(balance)
        for case, level in enumerate(dataset["force_level"].values.tolist()):
            solved = points.converged(case)
            search = PeakSearch(balance, Interpolation(balance, solved, 1e-3).curve() if solved else [])
            for output, name in enumerate(problem.output_names):
                found: list[dict[str, Any]] = []
                for point in search.peaks(output, measure).points:
                    evaluation, omega = point.evaluation, point.point.omega
                    if not band[0] <= balance.hertz(omega) <= band[1]:
                        continue
                    row = evaluation.w[balance.rows + output]
                    sizes = {str(one.kind): one.size(row, omega) / one.per(level) for one in (measure, largest)}
                    found.append({"frequency": balance.hertz(omega), **sizes, "loss_factor": energy.loss_factor(evaluation)})
                found.sort(key=lambda peak: -peak[measure.kind])
                rows += [{"force_level": level, "output": name, "peak": k} | peak for k, peak in enumerate(found)]
    sizes_of = list(dict.fromkeys([str(measure.kind), "max_abs"]))
    table = pd.DataFrame(rows, columns=["force_level", "output", "peak", "frequency", *sizes_of, "loss_factor"])
    return table.sort_values(["force_level", "output", "peak"], ignore_index=True)
