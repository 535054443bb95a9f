"""The table [aerodynamics] of a study file: gas forces of a bladed disk that go with its motion."""

from __future__ import annotations

from typing import Annotated, ClassVar

from pydantic import Field

from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.problem import Problem
from stickslip.model.structure.aerodynamics import Aerodynamics
from stickslip.study.fields import Groups, Number, Place, Positive, Table, Words
from stickslip.study.units import FREQUENCY, MASS, STIFFNESS, Units, in_si
from stickslip.support.checks import MOST, fault

Complex = Annotated[list[Number], Field(min_length=2, max_length=2), Words("pair of numbers")]
Influence = Annotated[list[Number], Field(min_length=3, max_length=3), Words("list of three numbers")]


class AerodynamicsTable(Table):
    """Gas forces on the blades of a tuned disk, or of the mistuned ones made of it, that are proportional to their motion.

    Lists by nodal diameter have one entry for each wave, n = 0, 1, ..., N − 1; n = N − 1 is −1,
    against the numbering of the sectors.
    """

    exactly_one: ClassVar[Groups] = (("influence", "stiffness", "damping_ratio"),)

    influence: Annotated[
        list[Influence] | None,
        STIFFNESS,
        Field(
            min_length=1,
            description="[k, Re L, Im L]: force on a blade per motion of the k-th blade after it; blades left out: 0",
        ),
    ] = None
    stiffness: Annotated[
        list[Complex] | None, STIFFNESS, Field(min_length=1, description="[Re A, Im A] of every nodal diameter")
    ] = None
    damping_ratio: Annotated[
        list[Number] | None,
        Field(min_length=1, description="of the blade alone, for every nodal diameter; negative where gas feeds the vibration"),
    ] = None
    frequency_shift: Annotated[
        list[Number] | None, Field(min_length=1, description="of the blade alone, relative, for every nodal diameter; else none")
    ] = None
    frequency: Annotated[Positive | None, FREQUENCY, Field(description="at which the coefficients hold")] = None
    direction: Annotated[
        Place | None,
        Field(description="of the sector, on which they act; default: the coordinate of the blade-alone mode `mode`"),
    ] = None
    modal_mass: Annotated[Positive | None, MASS, Field(description="of damping ratios along a direction")] = None
    mode: Annotated[int, Field(ge=1, le=MOST, description="number of the blade-alone mode, where no direction is given")] = 1


def with_aerodynamics(problem: Problem, table: AerodynamicsTable, units: Units) -> TunedDisk:
    """A tuned disk with the gas forces of a table."""
    if not isinstance(problem, TunedDisk):
        raise fault("[structure]", 'must be a tuned disk, such as rig = "lumped_blisk"', type(problem).__name__)
    given = in_si(table, units)
    influence = None if table.influence is None else _numbered(table.influence)
    stiffness = None if table.stiffness is None else [complex(*pair) for pair in table.stiffness]
    return problem.with_aerodynamics(
        Aerodynamics(
            influence=influence,
            stiffness=stiffness,
            damping_ratio=table.damping_ratio,
            frequency_shift=table.frequency_shift,
            frequency=given["frequency"],
            direction=table.direction,
            modal_mass=given["modal_mass"],
            mode=table.mode,
        )
    )


def _numbered(rows: list[list[float]]) -> dict[int, complex]:
    """Coefficients by blade."""
    found: dict[int, complex] = {}
    for number, real, imaginary in rows:
        if number != int(number):
            raise fault("influence, k", "must be a whole number", number)
        if int(number) in found:
            raise fault("influence", "must hold every blade once", int(number))
        found[int(number)] = complex(real, imaginary)
    return found
