"""Loading history: the sliders of each solved point are the start state of the next, along frequency and between levels."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from stickslip.model.contact.period import OFFSET
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance, Point
from stickslip.solve.balance.cycle import contact_cycle
from stickslip.solve.continuation.continuation import first_point
from stickslip.solve.continuation.newton import Correction, correct, fixed
from stickslip.support.checks import Array


def sliders(balance: HarmonicBalance, evaluation: Evaluation) -> Array:
    """Where the slider of every friction element stands at the last sample, s = u_last − T_last/kt, m, (elements,)."""
    return contact_cycle(evaluation.table, balance.tables, evaluation.w, evaluation.point.omega).slider


def march(balance: HarmonicBalance, omegas: Sequence[float], levels: Sequence[float]) -> Iterator[tuple[float, Correction]]:
    """(level, solved point) for every level in order and every frequency in rad/s; sliders carried from point to point.

    A point that does not converge is handed out as it is, and the next one starts from the last converged state.
    """
    last: Evaluation | None = None
    for level in levels:
        for omega in omegas:
            if last is None:
                correction = first_point(balance, omega, level)
            else:
                carried = balance.with_starts(sliders(balance, last), OFFSET)
                start = Point(last.point.forces, omega, level)
                correction = correct(carried, start, fixed("omega", omega), iterations=40, halvings=10)
                if not correction.converged:
                    correction = first_point(carried, omega, level)
            if correction.converged:
                last = correction.evaluation
            yield level, correction
