"""Steady cycles of a damper from many initial states in a study: the table [steady_cycles]."""

from typing import Annotated

from stickslip.analyses.damper_alone.cycle import SteadyCyclesWork
from stickslip.study.analyses.damper_cycle import DamperTable, MotionTable, Steps, rig_and_motion
from stickslip.study.analysis import Asked, Kind, Works
from stickslip.study.fields import LENGTH, Positive, in_si, table_of
from stickslip.support.checks import counted

SliderStartsTable = table_of(
    SteadyCyclesWork,
    "Initial states: the virgin sliders and random offsets.",
    spread=Annotated[Positive | None, LENGTH],
    same=Positive,
    steps=Steps,
)


def plan(asked: Asked) -> Works:
    """Every steady cycle that the initial states lead to."""
    settings = in_si(asked.tables.get("steady_cycles") or SliderStartsTable(), asked.units)
    work = SteadyCyclesWork(*rig_and_motion(asked), starts=settings.pop("count"), **settings)
    words = f"{work.rig.title}, {counted(work.starts, 'initial state')}, {work.steps} steps a cycle"
    return Works(work, words, content=work.motion.digest)


KIND = Kind(
    plan,
    {"damper": DamperTable, "motion": MotionTable, "steady_cycles": SliderStartsTable},
    optional=("steady_cycles",),
    on_problem=False,
)
