"""The one place that knows which kernels a law has: from the kind of a contact to the `period` and `step` of the law's file.

Plain branches: a function handed to a kernel would become part of its signature, which is compiled anew in every process.
"""

from __future__ import annotations

from stickslip.contact import cubic, dahl, friction_disc, tanh_coulomb
from stickslip.contact.law import Law
from stickslip.contact.protocol import ContactData, PeriodForces, PeriodMotion, StepForces, StepMotion
from stickslip.kernels import compiled, inlined, kernel

NO_SUCH_LAW = -2


@inlined
def law_period(kind: int, data: ContactData, motion: PeriodMotion, forces: PeriodForces) -> int:
    """Fill the steady period of a contact; HELD, STATIC, SLIPPING or NOT_PERIODIC."""
    if kind == friction_disc.KIND:
        return friction_disc.period(data, motion, forces)
    if kind == cubic.KIND:
        return cubic.period(data, motion, forces)
    if kind == dahl.KIND:
        return dahl.period(data, motion, forces)
    if kind == tanh_coulomb.KIND:
        return tanh_coulomb.period(data, motion, forces)
    return NO_SUCH_LAW


@inlined
def law_step(kind: int, data: ContactData, motion: StepMotion, forces: StepForces) -> float:
    """Fill the forces of a contact after a step; the friction work of the step, J."""
    if kind == friction_disc.KIND:
        return friction_disc.step(data, motion, forces)
    if kind == cubic.KIND:
        return cubic.step(data, motion, forces)
    if kind == dahl.KIND:
        return dahl.step(data, motion, forces)
    if kind == tanh_coulomb.KIND:
        return tanh_coulomb.step(data, motion, forces)
    return 0.0


def steady_period(law: Law, data: ContactData, motion: PeriodMotion, forces: PeriodForces) -> int:
    """`law_period` for calls from Python, of a law with kernels of its own."""
    compiled(*law.kernels)
    return _period(law.kind, data, motion, forces)


@kernel
def _period(kind: int, data: ContactData, motion: PeriodMotion, forces: PeriodForces) -> int:
    return law_period(kind, data, motion, forces)
