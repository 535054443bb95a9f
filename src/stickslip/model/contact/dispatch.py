"""The kernels of a law by the kind of its contacts: a number that follows from the name of its `step`, and stands in the tables.

A law need not be listed here, nor lie in this package: `prepare` of `march.py` says which kernels its number stands for.
A function handed to a kernel would become part of its signature instead, which is compiled anew in every process.
"""

from __future__ import annotations

from stickslip.model.contact.law import SLIDERS, Law
from stickslip.model.contact.protocol import (
    ContactData,
    PeriodForces,
    PeriodMotion,
    StepForces,
    StepMotion,
    period_signature,
    step_signature,
)
from stickslip.support.kernels import inner
from stickslip.support.kernels.separate import number_of, numbered
from stickslip.support.kernels.views import view


def kind_of(law: type[Law]) -> int:
    """`SLIDERS`, or the number of the law's own kernels, the same in every process."""
    kernels = law.kernels()
    return number_of(kernels[0]) if kernels else SLIDERS


@numbered(period_signature)
def law_period(kind: int, data: ContactData, motion: PeriodMotion, forces: PeriodForces) -> int:
    """Fill the steady period of a contact; HELD, STATIC, SLIPPING or NOT_PERIODIC."""
    raise NotImplementedError


@numbered(step_signature)
def law_step(kind: int, data: ContactData, motion: StepMotion, forces: StepForces) -> float:
    """Fill the states and forces of a contact after a step; the friction work of the states in the step, J. Takes views."""
    raise NotImplementedError


@inner
def take_step(data: ContactData, motion: StepMotion, forces: StepForces) -> float:
    """`law_step` of tuples, which stay alive as long as it runs."""
    return law_step(data.kind, view(data), view(motion), view(forces))
