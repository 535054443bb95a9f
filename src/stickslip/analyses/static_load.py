"""The static load: the contacts at rest under it, and what its history changes at the highest peaks of a curve.

A result keeps each contact at rest; a table has a row for each contact surface.

Where a contact sticks, its friction depends on where its slider stood when the vibration began. Two histories are limits of what
may have been before:

* dragged: sliders are there before the static load p₀, s = 0. It drags them, and contacts carry friction at rest. Curves are
  computed so;
* seated: p₀ acts before there is friction, as when parts are lubricated, shaken or tapped in. Contacts carry normal forces alone,
  and the sliders begin there, s = u₀ of K q₀ + B_nᵀ N(B_n q₀) = p₀ (`model/problem/at_rest.py`).

A steady motion follows from the places of the sliders by the rule of the start states, T = kt (u − s) within the limits. So the
other history is another offset of each slider, and a peak is followed while all sliders go from 0 to u₀ together. The two are no
bounds: between and beyond them lie all other start states (`response_bounds`).
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from stickslip.analyses.response_dataset import levels_are_newtons
from stickslip.analyses.truncation import SEATED, highest_points, same_motion
from stickslip.model.problem import Problem
from stickslip.model.problem.at_rest import at_rest, begins, open_stiffness, rest_variables, seated
from stickslip.model.problem.meshed import resting
from stickslip.model.structure.modes import Modes, natural_modes
from stickslip.results.schema import in_system, system_of
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance
from stickslip.solve.balance.measure import Measure
from stickslip.solve.continuation.curve_points import CurvePoint
from stickslip.solve.continuation.finer_peak import finer_peak
from stickslip.solve.continuation.newton import TOLERANCE
from stickslip.solve.curves.curve import Curve
from stickslip.solve.peaks.climb import PeakSolver, followed, settled
from stickslip.support.checks import Array, first_of
from stickslip.support.late import xr
from stickslip.support.units import UnitSystem

MOST = 60
"""Rows of a table on the screen: six surfaces at each of ten loads."""


def rest_of(problem: Problem) -> dict[str, Any]:
    """The variables of a problem under its static load; none without contacts or a state of rest, or with one at each speed."""
    if not problem.contacts or problem.speed is not None:
        return {}
    loaded, rest = resting(problem, at_rest)
    return {} if rest is None else rest_variables(loaded, rest)


def by_surface(found: "Mapping[str, Any] | xr.Dataset", system: UnitSystem | None = None) -> list[dict[str, Any]]:
    """A record for each contact surface, and for each contact by itself, by heads with their units; sums, and largest values."""
    (newton, force), (metre, length) = in_system("N", system), in_system("m", system)
    load, friction, gap, slip, state = (np.asarray(found[f"rest_{key}"]) for key in ("load", "friction", "gap", "slip", "state"))
    names = np.asarray(found["contact_surface"])
    return [
        {
            "surface": name,
            "contacts": int(own.sum()),
            "open": int(np.sum(state[own] == 0)),
            "at friction limit": int(np.sum(state[own] == 2)),
            f"normal load [{force}]": newton * float(load[own].sum()),
            f"least [{force}]": newton * float(load[own].min()),
            f"largest [{force}]": newton * float(load[own].max()),
            f"friction [{force}]": newton * float(friction[own].max()),
            f"slip [{length}]": metre * float(slip[own].max()),
            f"gap [{length}]": metre * float(gap[own].max()),
        }
        for name in dict.fromkeys(names[np.isfinite(load)].tolist())
        for own in [names == name]
    ]


def as_lines(records: Sequence[Mapping[str, Any]]) -> list[str]:
    """Records as the lines of a table, the first of many."""
    cells = [[each if isinstance(each, str) else f"{each:.4g}" for each in record.values()] for record in records[:MOST]]
    shown = [*map(list, records[:1]), *cells]
    widths = [max(map(len, column)) for column in zip(*shown, strict=True)]
    lines = ["  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True)) for line in shown]
    return [*lines, f"... ({len(records)} in all)"] if len(records) > MOST else lines


def fields_at_rest(dataset: "xr.Dataset") -> dict[str, Array]:
    """The contacts at rest at each contact node, by names with the units of the study; the pressure where areas are known."""
    of_node, fields = dataset["contact_of_node"].values, {}
    known = {str(name): values[of_node] for name, values in dataset.data_vars.items() if str(name).startswith("rest_")}
    if "contact_area" in dataset and dataset["contact_area"][of_node].all():
        known["rest_pressure"] = (known["rest_load"] / dataset["contact_area"][of_node]).assign_attrs(units="Pa")
    for name, values in known.items():
        factor, unit = in_system(values.attrs["units"], system_of(dataset))
        fields[f"{name.removeprefix('rest_')} at rest{'' if unit == '1' else f' [{unit}]'}"] = factor * values.values
    return fields


SEEN = 1e-3
"""Relative difference of two natural frequencies from which on it is seen in tables and figures, and share of the excitation of a
mode in that of the most driven one."""

ROUNDING = 1e-9
"""Friction kt |u₀| over the forces of the contacts at rest, below which it is rounding."""

UNMOVED = "The history of the static load does not matter: the load moves no slider."
UNSEATED = (
    "The effect of the history of the static load is not known: no equilibrium without friction was found, in which the load "
    "seats the contacts before friction acts."
)


def modes_at_rest(problem: Problem) -> tuple[str, list[tuple[int, Modes, Modes]]]:
    """The contacts or parts of them that are open at rest, in words, and by excited harmonic the modes with all contacts stuck,
    and those of small vibrations, of K without the stiffness that is open; nothing where none is."""
    problem = problem.at_frequency(problem.first_omega_at_rest)
    rest = at_rest(problem)
    if rest is None or not (released := open_stiffness(problem, rest)).any():
        return "", []
    owners = [contact.name for contact in problem.contacts for _ in contact.directions]
    names = first_of(list(dict.fromkeys(owners[row] for row in np.flatnonzero(released))))
    modes = []
    for harmonic in problem.systems.excited:
        M, _, K, B, _ = problem.systems.at(harmonic)
        modes.append((harmonic, natural_modes(M, K), natural_modes(M, K - B.conj().T @ (released[:, None] * B))))
    return names, modes


def opened(problem: Problem, low: float, high: float) -> str:
    """A sentence where parts of contacts are open at rest, so that small vibrations between two frequencies [Hz], of a mode that
    the excitation drives, have another natural frequency than those of contacts that are stuck as a whole."""
    names, modes = modes_at_rest(problem)
    if not modes:
        return ""
    powers = problem.load_powers(max(harmonic for harmonic, _, _ in modes))
    systems = problem.at_frequency(problem.first_omega_at_rest).systems
    for harmonic, stuck, small in modes:
        alike = np.argmax(np.abs(stuck.shapes.conj().T @ systems.at(harmonic).M @ small.shapes), axis=0)
        load = powers[:, :, [2 * harmonic - 1, 2 * harmonic]] @ np.array([1.0, -1.0j])
        driven = np.abs(load @ small.shapes.conj()).max(axis=0)
        seen = driven > SEEN * driven.max(initial=0.0)
        for one, other in zip(stuck.frequencies[alike[seen]] / harmonic, small.frequencies[seen] / harmonic, strict=True):
            if (low <= one <= high or low <= other <= high) and other < (1.0 - SEEN) * one:
                return (
                    f"Contacts, or parts of them, are open at rest ({names}): small vibrations have the natural frequency "
                    f"{other:.5g} Hz instead of {one:.5g} Hz with all contacts closed and stuck."
                )
    return ""


Seated = tuple[HarmonicBalance, Array, Array] | str
"""What `seated_balance` finds."""


def history_change(
    balance: HarmonicBalance, curve: Curve, measure: Measure, seated_at: Callable[[float], Seated]
) -> tuple[Array, str, str]:
    """The relative change of each output (outputs,) at its highest peak in the other history; a warning where one is large; why
    none is known. Both sentences are empty where there is nothing to say.

    seated_at: `seated_balance` at a frequency, rad/s. NaN for outputs without a peak, and where the histories do not differ or
    the other one is not known.
    """
    names, rows = balance.problem.output_names, balance.rows
    changes, words = np.full(len(names), np.nan), [""] * len(names)
    found: list[tuple[CurvePoint, Evaluation | None]] = []
    for output, peak in highest_points(balance, curve, measure).items():
        if not (curve.peaks and curve.peaks[output]):
            continue
        if not any(same_motion(peak, known) for known, _ in found):
            other = seated_at(peak.point.omega)
            if isinstance(other, str):
                return changes, "", other
            found.append((peak, _peak(balance, *other, output, peak, measure)))
        solution = next(each for known, each in found if same_motion(peak, known))
        if solution is None:
            words[output] = f"The effect of the history of the static load on the highest peak of {names[output]} is not known: "
            words[output] += "the peak could not be followed to contacts that are seated without friction."
            continue
        points = peak.evaluation, solution
        sizes = [measure.size(e.w[rows + output], e.point.omega) / measure.per(peak.point.level) for e in points]
        changes[output] = sizes[1] / sizes[0] - 1.0
        if abs(changes[output]) > SEATED.allowed:
            unit = measure.reported_units(levels_are_newtons(balance.problem))
            dragged, other = (
                f"{s:.4g} {unit} at {balance.hertz(e.point.omega):.5g} Hz" for s, e in zip(sizes, points, strict=True)
            )
            other_starts = "bounds with `response_bounds`" if balance.problem.mesh is None else "others with `response_samples`"
            words[output] = (
                f"The history of the static load changes {names[output]} at its highest peak: {dragged} if the load drags "
                f"the sliders (as computed), {other} ({100.0 * changes[output]:+.1f} %) if it seats the contacts before friction "
                f"acts. These are not bounds of the response; compute {other_starts}."
            )
    worst = int(np.argmax(np.nan_to_num(np.abs(changes), nan=-1.0)))
    return changes, words[worst] or next(filter(None, words), ""), ""


def seated_balance(balance: HarmonicBalance, omega: float) -> Seated:
    """The balance, on coordinates of a mesh that show it, and of all friction elements whether their sliders begin at rest, and
    where the static load at a frequency seats them, u₀ [m]; or why there is none.
    """
    problem = balance.problem
    free = [each for contact in problem.contacts for each in begins(contact)]
    if balance.kept[0] != 0 or not any(free):
        return ""
    problem, rest = resting(problem, lambda each: seated(each.at_frequency(omega)))
    if rest is None:
        return UNSEATED
    table = balance.table
    row = np.repeat(np.arange(table.rows), np.diff(table.friction_first))
    begin = np.array(free)[row]
    friction = table.stiffness * np.abs(rest.motion[row]) * begin
    if friction.max() <= ROUNDING * float(np.linalg.norm(rest.forces)):
        return UNMOVED if np.any(rest.forces) else ""
    if problem is not balance.problem:
        balance = HarmonicBalance(problem, balance.harmonics, balance.tables.E.shape[0], balance.periods)
    return balance, begin, rest.motion[row]


def _peak(
    few: HarmonicBalance, balance: HarmonicBalance, begin: Array, places: Array, output: int, peak: CurvePoint, measure: Measure
) -> Evaluation | None:
    """The peak of an output with sliders at `places`: climbed to, else solved at the phase that it had; None where it is lost."""

    def solver_at(share: float) -> PeakSolver:
        start = np.where(begin, share * places, balance.table.start_value)
        return PeakSolver(balance.with_starts(start), output, measure)

    other = solver_at(1.0).balance
    if few.problem is balance.problem and other.evaluate(peak.point).error <= TOLERANCE:
        return peak.evaluation  # every contact slips: its start is forgotten
    found = followed(solver_at, PeakSolver(few, output, measure).from_top(peak.evaluation))
    if found is not None:
        return settled(solver_at(1.0), found)[0].evaluation
    return finer_peak(other, other, peak.point, output, peak.evaluation.w[few.rows + output, few.first])
