"""Free decay in a study: the table [free_decay], and the nonlinear modes in the band of [sweep] beside it."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from stickslip.analyses.controlled_response import phase_resonance
from stickslip.analyses.free_decay import MOST_STEPS, FreeDecayWork, beside_modes, beside_phase_resonance
from stickslip.analyses.modes.work import NonlinearModesWork, with_decays
from stickslip.analyses.settings import ForcedResponseSettings
from stickslip.model.readers.model import ROTATIONS
from stickslip.runs.cases import Arrays, all_cases
from stickslip.study.analyses.forced_response import sweep_of
from stickslip.study.analyses.nonlinear_modes import ModesTable, modes_settings
from stickslip.study.analysis import LEVELS_AND_PEAKS, Asked, Kind, Works
from stickslip.study.fields import FREQUENCY, LENGTH, VELOCITY, Number, Positive, Table
from stickslip.support.checks import counted, fault
from stickslip.support.late import xr
from stickslip.support.units import Band

TABLE = "free_decay"

AMPLITUDES = 25
"""Of a phase resonance test."""

BEYOND = 1.02
"""Share by which a mode goes beyond the amplitudes of the decay on either side."""


class FreeDecayTable(Table):
    """The motion after a release, an impact or a steady motion, without excitation."""

    duration: Annotated[Positive, Field(description="duration of the decay, s in all unit systems")]
    displacement: dict[str, Number] = Field(default_factory=dict)
    """displacement at the release, length or rad by degree of freedom, { tip = 1e-3 }; all others are 0"""
    velocity: dict[str, Number] = Field(default_factory=dict)
    """velocity after an impact, length/time by degree of freedom; all others are 0"""
    frequency: Annotated[Positive | None, FREQUENCY] = None
    """frequency of a steady motion before the decay, in place of both; the excitation then stops"""
    force: Annotated[Positive, Field(description="force level of this steady motion")] = 1.0
    steps: Annotated[int, Field(ge=8, le=MOST_STEPS, description="time steps of the whole duration")] = 20_000
    modes: Annotated[bool, Field(description="also compute the nonlinear modes in the band of [sweep]")] = True

    phase_resonance: bool = False
    """also compute the frequencies of a test with force and displacement at 90°"""

    def check(self) -> None:
        """One kind of beginning."""
        moved = bool(self.displacement) or bool(self.velocity)
        if moved == (self.frequency is not None):
            what = "both" if moved else "neither"
            raise fault("displacement or velocity", "must be given, or frequency of a steady motion", what)
        if self.frequency is None and self.force != 1.0:
            raise fault("force", "needs frequency, the steady motion before the decay", self.force)


def plan(asked: Asked) -> Works:
    """A decay, then the modes over its amplitudes."""
    table, units, sweep = FreeDecayTable.model_validate(asked.tables[TABLE]), asked.units, sweep_of(asked)
    moved: dict[str, Any] = {}
    for key, dimension in (("displacement", LENGTH), ("velocity", VELOCITY)):
        given: dict[str, float] = getattr(table, key)
        if given:
            turned = replace(dimension, length=0)  # rotations are in rad whatever the length
            moved[key] = {
                dof: value * units.factor(turned if dof.rpartition(".")[2] in ROTATIONS else dimension)
                for dof, value in given.items()
            }
    if table.frequency is not None:
        moved |= {"frequency": table.frequency * units.factor(FREQUENCY), "force": table.force}
    work = FreeDecayWork(sweep.problem, table.duration, **moved, steps=table.steps)
    modes = NonlinearModesWork(**modes_settings(asked, ModesTable())) if table.modes else None
    beside = "" if modes is None else f", beside {counted(len(modes.modes), 'nonlinear mode')}"
    summary = f"{work.duration:g} s of free decay in {work.steps} steps{beside}"

    def search(work: FreeDecayWork, arrays: Sequence[Arrays], *how: Any) -> "xr.Dataset":
        """The decay with the modes, and with the phase resonance, over the amplitudes that it passes at the first output."""
        dataset = work.gathered(arrays).dataset
        amplitude = dataset["amplitude"].values[0]
        passed = amplitude[np.isfinite(amplitude) & (amplitude > 0.0)]
        if not passed.size:
            return dataset
        ends = float(passed.min()) / BEYOND, float(passed.max()) * BEYOND
        if modes is not None:
            over = replace(modes, amplitude=ends)
            dataset = beside_modes(dataset, with_decays(over.dataset(all_cases(over, *how)), over.problem))
        return beside_phase_resonance(dataset, _phase_resonance(sweep, ends)) if table.phase_resonance else dataset

    return Works(work, summary, search=search)


def _phase_resonance(sweep: ForcedResponseSettings, ends: tuple[float, float]) -> "xr.Dataset":
    """The test at 90° over amplitudes of the first output."""
    band = Band(min(sweep.frequencies), max(sweep.frequencies))
    fineness: dict[str, Any] = {} if sweep.harmonics == "auto" else {"harmonics": sweep.harmonics, "samples": sweep.samples}
    amplitudes = np.geomspace(*ends, AMPLITUDES).tolist()
    return phase_resonance(sweep.problem, band, amplitudes, quantity="displacement", **fineness).dataset


KIND = Kind(plan, {TABLE: FreeDecayTable}, without=LEVELS_AND_PEAKS)
