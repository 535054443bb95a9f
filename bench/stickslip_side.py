"""stickslip's side of the benchmark: sweeps, exact solutions at given frequencies, and the time of the parts of an iteration.

Sweeps are timed the way a user runs them, from the problem to the solved points. Run as a script.
"""

from __future__ import annotations

import sys
import time
from importlib import metadata

import numpy as np
from cases import BY_NAME, HARMONICS, SAMPLES, Case
from channel import Answer, serve
from problems import problem_of

import stickslip
from stickslip.analyses.forced_response import forced_response
from stickslip.model import rigs
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.continuation import first_point, trace
from stickslip.solve.continuation.curve_points import CurvePoint
from stickslip.solve.continuation.steps import StepControl
from stickslip.solve.curves.curve import solve_curve
from stickslip.support.units import Band

IMPORT_SECONDS = time.process_time()


def sweep(request: dict) -> Answer:
    """Sweep a case with settings of `StepControl`; "peaks": also solve the peaks, as `forced_response` does."""
    case = BY_NAME[request["case"]]
    settings = dict(request["settings"])
    solved_peaks = settings.pop("peaks", False)
    control = StepControl(**settings)
    began = time.process_time()
    balance = HarmonicBalance(problem_of(case), HARMONICS, SAMPLES)
    points, reached = _trace(balance, case, control, solved_peaks)
    cpu = time.process_time() - began
    points = sorted(points, key=lambda point: point.point.omega)
    row = balance.rows
    return {
        "cpu": cpu,
        "points": len(points),
        "iterations": float(np.mean([point.iterations for point in points])),
        "evaluations": int(balance.system.effort[0]) / len(points),
        "factorisations": int(balance.system.effort[1]) / len(points),
        "active": max(point.active for point in points),
        "omega": [point.point.omega for point in points],
        "motion": [point.evaluation.w[row].tolist() for point in points],
        "reached": reached,
    }


def _trace(balance: HarmonicBalance, case: Case, control: StepControl, solved_peaks: bool) -> tuple[list[CurvePoint], bool]:
    """The points of a sweep; the solved peaks join them."""
    if solved_peaks:
        curve = solve_curve(balance, case.band, case.level, False, control=control)
        return [*curve.points, *(point for found in curve.peaks for point in found)], curve.lost_at is None
    first = first_point(balance, case.band[0], case.level)
    return list(trace(balance, first, "omega", case.band[1], control)), True


def exact(request: dict) -> Answer:
    """The motion of the output, harmonics as mean, cosine, sine, ..., solved exactly at frequencies in rad/s."""
    case = BY_NAME[request["case"]]
    balance = HarmonicBalance(problem_of(case), HARMONICS, SAMPLES)
    curve = solve_curve(balance, sorted(request["omega"]), case.level, True, control=StepControl(largest=0.1))
    return {
        "omega": [point.point.omega for point in curve.points],
        "motion": [point.evaluation.w[balance.rows].tolist() for point in curve.points],
    }


def reference(request: dict) -> Answer:
    """Exact points over the band, dense around the peak, and the highest peak of the first harmonic, solved."""
    case = BY_NAME[request["case"]]
    balance = HarmonicBalance(problem_of(case), HARMONICS, SAMPLES)
    curve = solve_curve(balance, case.band, case.level, False, control=StepControl(largest=0.1))
    row = balance.rows

    def amplitude(point: CurvePoint) -> float:
        return float(np.hypot(*point.evaluation.w[row, 1:3]))

    peak = max(curve.peaks[0], key=amplitude)
    omegas = np.array([point.point.omega for point in curve.points])
    lengths = np.cumsum([point.length for point in curve.points])
    along = np.interp(np.linspace(0.0, lengths[-1], request["count"]), lengths, omegas)
    grid = sorted({*along.tolist(), *np.linspace(*case.band, request["count"]).tolist()})
    solved = solve_curve(balance, grid, case.level, True, control=StepControl(largest=0.1))
    return {
        "omega": [point.point.omega for point in solved.points],
        "amplitude": [amplitude(point) for point in solved.points],
        "peak": amplitude(peak),
        "peak_omega": peak.point.omega,
    }


def whole_analysis(request: dict) -> Answer:
    """`forced_response` over the band, with solved peaks, energies, loops and the labelled dataset."""
    case = BY_NAME[request["case"]]
    problem = problem_of(case)
    began = time.process_time()
    low, high = (omega / (2.0 * np.pi) for omega in case.band)
    response = forced_response(problem, Band(low, high), case.level, HARMONICS, SAMPLES)
    return {"cpu": time.process_time() - began, "points": int(response.dataset.sizes["point"])}


def blade(request: dict) -> Answer:
    """The single-blade rig at 4.6 kg: time to mesh and reduce, then a sweep of one force level."""
    began = time.process_time()
    problem = rigs.single_blade(preload_mass=4.6)
    built = time.process_time()
    balance = HarmonicBalance(problem, request["harmonics"], SAMPLES)
    prepared = time.process_time()
    low, high = (2.0 * np.pi * frequency for frequency in request["band"])
    points = list(trace(balance, first_point(balance, low, request["force"]), "omega", high, StepControl()))
    cpu = time.process_time() - prepared
    return {
        "build_cpu": built - began,
        "modes_cpu": prepared - built,
        "cpu": cpu,
        "points": len(points),
        "iterations": float(np.mean([point.iterations for point in points])),
        "evaluations": int(balance.system.effort[0]) / len(points),
        "active": max(point.active for point in points),
        "rows": balance.rows,
        "size": problem.structure.size,
        "peak": max(float(np.hypot(*point.evaluation.w[balance.rows, 1:3])) for point in points),
        "reached": points[-1].point.omega == high,
    }


if __name__ == "__main__":
    from blade_export import export_blade
    from contacts_side import contacts
    from growth_side import growth
    from limit_side import parts

    handlers = {
        "sweep": sweep,
        "exact": exact,
        "reference": reference,
        "whole": whole_analysis,
        "blade": blade,
        "export_blade": export_blade,
        "parts": parts,
        "growth": growth,
        "contacts": contacts,
    }
    versions = {name: metadata.version(name) for name in ("numpy", "scipy", "numba")}
    versions |= {"python": sys.version.split()[0], "stickslip": stickslip.__version__}
    serve(handlers, {"import_seconds": IMPORT_SECONDS, "versions": versions})
