"""Cycles of a damper while its friction changes, in a study: the table [damper_evolution]."""

from typing import Annotated

from pydantic import Field

from stickslip.analyses.damper_alone.cycle import EvolutionWork
from stickslip.study.analyses.damper_cycle import DamperTable, MotionTable, Steps, rig_and_motion
from stickslip.study.analysis import Asked, Kind, Works
from stickslip.study.fields import NotNegatives, in_si, table_of
from stickslip.support.checks import counted

EvolutionTable = table_of(
    EvolutionWork,
    "Friction as it changes from one set of cycles to the next.",
    friction=Annotated[list[NotNegatives], Field(min_length=1)],
    steps=Steps,
)


def plan(asked: Asked) -> Works:
    """A sequence of cycles while friction changes."""
    work = EvolutionWork(*rig_and_motion(asked), **in_si(asked.tables["damper_evolution"], asked.units))
    sets = counted(len(work.friction), "set")
    words = f"{work.rig.title}, {sets} of friction coefficients, {counted(work.cycles, 'cycle')} each"
    return Works(work, words, lambda work, arrays: work.gathered(arrays[0]).dataset, work.motion.digest)


KIND = Kind(plan, {"damper": DamperTable, "motion": MotionTable, "damper_evolution": EvolutionTable}, on_problem=False)
