"""Damper design in a study: the table [damper_design], with a rig whose parameters are the variables."""

import inspect
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

from pydantic import Field

from stickslip.analyses.performance.design import DesignSettings, finished_design
from stickslip.analyses.performance.work import with_friction
from stickslip.analyses.performance.worst_case import Constraint, LargestForce, NoJamming, NoLiftOff
from stickslip.analyses.settings import made
from stickslip.model.problem import Problem
from stickslip.model.rigs import RIGS
from stickslip.runs.cases import Arrays, Work
from stickslip.study.analysis import Asked, Kind, Works
from stickslip.study.fields import Harmonics, Number, Positive, QuantityName, Table, Words, table_of, values_of
from stickslip.study.tables import Ends
from stickslip.support.checks import fault, nearest
from stickslip.support.late import xr
from stickslip.support.units import STANDARD_GRAVITY


class RigTable(Table):
    """The rig whose variables are sought, and what no design may do."""

    rig: Annotated[str, Field(description="name of a ready problem")]
    parameters: Annotated[dict[str, Any], Field(description="fixed arguments of the rig, in SI")] = Field(default_factory=dict)
    acceleration: Positive | None = None
    """m/s²: the pull on a damper (`pull`, or `preload_mass` times 9.81) is `damper_mass` times this"""
    no_jamming: str | None = None
    """the argument that holds the platform angle in degrees: 1 − μ tan α stays positive"""
    no_lift_off: Annotated[bool, Field(description="no contact point may open")] = False
    largest_force: Annotated[Positive | None, Field(description="of a contact point, N")] = None

    def check(self: Any) -> None:
        """The rig and its arguments exist, and ends of variables are in order."""
        if self.rig not in RIGS:
            raise fault("rig", "must be a known one", self.rig, nearest(self.rig, RIGS))
        arguments = inspect.signature(RIGS[self.rig]).parameters
        for name in (*self.parameters, *self.variables):
            if name not in arguments:
                raise fault("An argument of the rig", "must be a known one", name, nearest(name, arguments))
        for name, (low, high) in self.variables.items():
            if name in self.parameters:
                raise fault(f"variables, {name}", "must not be among the parameters, which stay", self.parameters[name])
            if low >= high:
                raise fault(f"variables, {name}", "must be [low, high] with low below high", [low, high])
        given = {**self.parameters, **self.variables}
        optional = [name for name in given if arguments[name].default is not inspect.Parameter.empty]
        overruled = {name: "friction, which every contact gets" for name in optional if name.rpartition("_")[2] in FRICTIONS}
        if self.acceleration is not None:
            overruled |= {name: "acceleration, from which it follows" for name in given if name == pull_of(self.rig)}
        for name, key in overruled.items():
            raise fault(f"{name} of the rig", f"must be left to {key}", given[name])
        if self.acceleration is not None and ("damper_mass" not in given or pull_of(self.rig) is None):
            remedy = f"An argument {' or '.join(PULLS)} says how dampers are pulled."
            raise fault("acceleration", "must go with damper_mass and a rig whose dampers are pulled", self.acceleration, remedy)
        angles = [name for name in self.variables if name.endswith("angle")]
        if self.no_jamming is not None and self.no_jamming not in angles:
            raise fault("no_jamming", "must name an angle among the variables", self.no_jamming, nearest(self.no_jamming, angles))
        make = RigDesign(self.rig, self.parameters, self.acceleration)
        middle = {name: 0.5 * (low + high) for name, (low, high) in self.variables.items()}
        for name, ends in self.variables.items():  # the rig can be made at both, the others in the middle
            for value in ends:
                made(make, friction=self.friction, **(middle | {name: value}))

    @property
    def constraints(self) -> dict[str, Constraint]:
        """The constraints by name."""
        found: dict[str, Constraint] = {}
        if self.no_jamming is not None:
            found["no jamming"] = NoJamming(self.no_jamming)
        if self.no_lift_off:
            found["no lift-off"] = NoLiftOff()
        if self.largest_force is not None:
            found["largest force"] = LargestForce(self.largest_force)
        return found


DesignTable = table_of(
    DesignSettings,
    "The variables of a rig that make its worst-case resonance least.",
    RigTable,
    variables=Annotated[dict[str, Ends], Field(min_length=1), Words("table of pairs of numbers")],
    known=(Annotated[list[dict[str, float]], Words("list of tables of numbers")], []),
    force=Ends,
    friction=Positive,
    friction_factor=Annotated[Number, Field(ge=1.0)],
    objective=Literal["amplitude", "amplitude_per_force"],
    quantity=QuantityName,
    measure=Literal["amplitude", "rms", "max_abs"],
    harmonics=Harmonics,
)

PULLS = {"pull": 1.0, "preload_mass": STANDARD_GRAVITY}
"""Arguments of rigs that say how dampers are pulled, and how many newtons one unit of them is."""


FRICTIONS = ("mu", "friction")
"""How arguments of rigs that are friction coefficients end."""


def pull_of(rig: str) -> str | None:
    """The argument of a rig that says how its dampers are pulled, if any."""
    return next((name for name in PULLS if name in inspect.signature(RIGS[rig]).parameters), None)


@dataclass(frozen=True)
class RigDesign:
    """The problem of a design: a rig with some arguments fixed and its friction set."""

    rig: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    acceleration: float | None = None

    def __call__(self, *, friction: float, **variables: float) -> Problem:
        given = {**self.parameters, **variables}
        pull = pull_of(self.rig)
        if self.acceleration is not None and pull is not None:
            given[pull] = self.acceleration * given["damper_mass"] / PULLS[pull]
        return with_friction(RIGS[self.rig](**given), friction)


def plan(asked: Asked) -> Works:
    """The design space, then the search from its best designs."""
    table: Any = DesignTable.model_validate(asked.tables["damper_design"])
    maker = RigDesign(table.rig, table.parameters, table.acceleration)
    given = values_of(DesignSettings, table) | {"variables": {name: (low, high) for name, (low, high) in table.variables.items()}}
    settings = DesignSettings(maker, constraints=table.constraints, **given)
    _ = settings.work.conditions
    summary = f"{table.designs} designs of {', '.join(table.variables)}, then up to {table.refinements} more"

    def finished(work: Work, arrays: Sequence[Arrays], *search: Any) -> "xr.Dataset":
        return finished_design(settings, arrays, *search)

    return Works(settings.work, summary, finished, search=finished)


KIND = Kind(plan, {"damper_design": DesignTable}, on_problem=False)
