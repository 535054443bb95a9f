"""Nonlinear modes in a study: [nonlinear_modes]."""

from typing import Annotated, Any

import numpy as np

from stickslip.analyses.modes.work import Modes, NonlinearModesWork
from stickslip.model.problem import Problem
from stickslip.solve.balance.fourier import in_words
from stickslip.study.analyses.forced_response import sweep_of
from stickslip.study.analysis import PEAKS, Asked, Kind, Works
from stickslip.study.fields import LENGTH, Table, in_si, table_of
from stickslip.study.further_curves import ModeNumbers
from stickslip.study.tables import Ends
from stickslip.support.checks import InputError, counted, fault
from stickslip.support.units import Band

TABLE = "nonlinear_modes"
FORMS: dict[str, Any] = {"mode": ModeNumbers | None, "amplitude": Annotated[Ends | None, LENGTH]}
"""How files write the settings of modes."""

ModesTable = table_of(
    NonlinearModesWork,
    "Natural frequency and damping over the amplitude; the peaks at the force levels of [sweep] are derived from them.",
    checked=True,
    **FORMS,
)


def plan(asked: Asked) -> Works:
    """The nonlinear modes of a problem."""
    work, levels = NonlinearModesWork(**modes_settings(asked, asked.tables.get(TABLE, ModesTable()))), sweep_of(asked).levels
    work.refuse_amplitudes()
    return Works(work, modes_summary(work), lambda work, arrays: work.dataset(arrays, levels), on_mesh=work.with_shapes)


def modes_settings(asked: Asked, table: Table) -> dict[str, Any]:
    """The settings that a study gives to modes: of a table, of [sweep], and the modes in its band unless some are named."""
    sweep, settings = sweep_of(asked), in_si(table, asked.units)
    if sweep.harmonics == "auto":
        raise fault("harmonics", "must be a number or a list for nonlinear modes", "auto")
    where = sweep.band
    if settings["mode"] is None:
        ends = (where.low, where.high) if isinstance(where, Band) else (min(where), max(where))
        settings["mode"] = modes_between(sweep.problem, *ends)
    return settings | {"problem": sweep.problem, "harmonics": sweep.harmonics, "samples": sweep.samples}


def modes_summary(work: Modes) -> str:
    """What is computed of modes."""
    size = counted(work.problem.structure.size, "degree of freedom", "degrees of freedom")
    modes = ", ".join(map(str, work.modes))
    named = f"nonlinear mode{'s' if len(work.modes) > 1 else ''} {modes}"
    how = f"{in_words(work.kept_harmonics)}, {work.samples} samples"
    return f"{size}, {counted(len(work.problem.contacts), 'contact')}; {named}, {how}"


def modes_between(problem: Problem, low: float, high: float) -> tuple[int, ...]:
    """Numbers of the modes of the stuck structure within a band in Hz, at least one."""
    frequencies = problem.frequencies(stuck=True)
    inside = np.flatnonzero((frequencies >= low) & (frequencies <= high))
    if not inside.size:
        near = ", ".join(f"{value:.5g}" for value in frequencies[:6]) + (", ..." if frequencies.size > 6 else "")
        raise InputError(
            f"[sweep]: the band must hold a natural frequency of the stuck structure, but {low:g} to {high:g} Hz holds none"
            f"{f' of {near} Hz' if near else ''}. Widen it, or give the number of a mode."
        )
    return tuple(int(k) + 1 for k in inside)


KIND = Kind(plan, {TABLE: ModesTable}, optional=(TABLE,), without=PEAKS, from_mesh=True)
