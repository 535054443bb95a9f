"""Mistuned disks in a study: the table [mistuned_population]."""

import re
from typing import Annotated, Any, Literal

from pydantic import Field, Tag

from stickslip.analyses.mistuning.disk import RELATIVE, Mistuning, Scatter
from stickslip.analyses.mistuning.work import LARGEST_DRAW, PEAK_TOLERANCE, PopulationWork, population_dataset, with_blade_fatigue
from stickslip.model.disks.tuned import TunedDisk
from stickslip.study.analyses.forced_response import sweep_of
from stickslip.study.analysis import Asked, Kind, Works, summary_of
from stickslip.study.fields import NotHuge, Positive, Seed, Table, by_form
from stickslip.study.further_curves import FatigueTable, fatigue_of, recovery_of
from stickslip.support.checks import Faults, InputError, counted

PLACE = re.compile(r"^Mistuning, (\w+)")

Share = Annotated[float, Field(ge=0, lt=1, allow_inf_nan=False)]
Deviation = Annotated[float, Field(gt=-1, allow_inf_nan=False), NotHuge]
BladeDeviation = Annotated[float, Field(gt=-1, lt=1, allow_inf_nan=False)]
BladePattern = Annotated[Annotated[BladeDeviation, Tag("<single>")] | Annotated[list[BladeDeviation], Tag("<list>")], by_form()]
BladeShare = Annotated[float, Field(ge=0, lt=1.0 / LARGEST_DRAW, allow_inf_nan=False)]
"""So that hardly a blade is drawn without stiffness, or with less."""
Pattern = Annotated[Annotated[Deviation, Tag("<single>")] | Annotated[list[Deviation], Tag("<list>")], by_form()]


class MistuningTable(Table):
    """What differs from sector to sector. A pattern is one number for all sectors or one for each, relative to the tuned disk."""

    count: Annotated[int, Field(ge=1, le=100_000, description="disks, each with scatter of its own")] = 1
    seed: Annotated[Seed, Field(description="of the random draws; disk k depends on it and on k alone")] = 0
    sampling: Literal["random", "sobol"] = "random"
    """random draws, or a Sobol' sequence that spreads them evenly"""
    blade_scatter: Annotated[BladeShare, Field(description="standard deviation of the blade frequencies, relative")] = 0.0
    kt_scatter: Annotated[Share, Field(description="standard deviation of ln kt from damper to damper")] = 0.0
    kn_scatter: Annotated[Share, Field(description="of ln kn")] = 0.0
    mu_scatter: Annotated[Share, Field(description="of ln mu")] = 0.0
    pull_scatter: Annotated[Share, Field(description="of ln pull")] = 0.0
    missing_probability: Annotated[Share, Field(description="that a damper is not there")] = 0.0
    blade: Annotated[BladePattern, Field(description="pattern of the blade frequencies, shared by all disks")] = 0.0
    kt: Annotated[Pattern, Field(description="pattern of the tangential stiffness of the dampers")] = 0.0
    kn: Annotated[Pattern, Field(description="pattern of the normal stiffness")] = 0.0
    mu: Annotated[Pattern, Field(description="pattern of the friction coefficient")] = 0.0
    pull: Annotated[Pattern, Field(description="pattern of the centrifugal pull on the dampers")] = 0.0
    missing: list[int] = Field(default_factory=list)
    """sectors, from 1, whose damper is missing in all disks"""
    blade_nodes: Annotated[list[str] | None, Field(min_length=1)] = None
    """nodes of a sector that are its blade; default: nodes of outputs, and modes"""
    peak_tolerance: Annotated[Positive, Field(lt=0.1, description="relative, of the maximum of a blade")] = PEAK_TOLERANCE
    run_in: Annotated[bool | None, Field(description="start from where slip has brought the tuned disk's sliders")] = None
    """by default finite-element disks do"""

    def check(self) -> None:
        """Something must deviate, if only by zero as at the end of a scan."""
        scatters = {f"{name}_scatter" for name in RELATIVE} | {"missing_probability"}
        if not self.model_fields_set & {*RELATIVE, "missing", *scatters}:
            raise InputError("a deviation must be given, such as blade_scatter = 0.003, but none is.")

    def pattern(self) -> Mistuning:
        """What all disks share."""
        return Mistuning(self.blade, self.kt, self.kn, self.mu, self.pull, tuple(self.missing))

    def key_of(self, name: str) -> str:
        """The key that says how something deviates: its pattern, or its scatter."""
        return name if name in self.model_fields_set else "missing_probability" if name == "missing" else f"{name}_scatter"

    def scatter(self) -> Scatter:
        """What differs from disk to disk."""
        kept: dict[str, Any] = {name: getattr(self, f"{name}_scatter") for name in RELATIVE}
        return Scatter(**kept, missing=self.missing_probability, sampling=self.sampling)


def checked_sweep(table: Any) -> None:
    """What [sweep] must say for a population."""
    faults = []
    if len(table.force_levels) != 1:
        faults.append("mistuning must have one force level, but has several. Write a study for each.")
    if table.harmonics == "auto":
        faults.append('mistuning must have a number of harmonics, but has "auto".')
    if faults:
        raise Faults(faults)


def plan(asked: Asked) -> Works:
    """One mistuned disk, or a population."""
    sweep, table = sweep_of(asked), MistuningTable.model_validate(asked.tables["mistuned_population"])
    disk = sweep.problem
    if not isinstance(disk, TunedDisk):
        raise InputError('[structure]: mistuning must have a tuned disk, such as rig = "lumped_blisk", but has another problem.')
    assert sweep.harmonics != "auto", "refused when the study was read"
    given = {name: getattr(table, name) for name in ("count", "seed", "peak_tolerance", "run_in")}
    given |= {name: getattr(sweep, name) for name in ("harmonics", "samples", "quantity", "measure")}
    pattern, scatter, force = table.pattern(), table.scatter(), sweep.levels[0]
    try:
        work = PopulationWork(disk, sweep.band, scatter=scatter, mistuning=pattern, force=force, blade=table.blade_nodes, **given)
    except InputError as error:
        raise InputError(PLACE.sub(lambda found: f"[mistuned_population]: {table.key_of(found[1])}", str(error))) from None
    summary = f"{summary_of(sweep)} a sector; {counted(work.count, 'mistuned disk')} of {disk.sectors} sectors"
    if not scatter.names:
        summary += ", all alike" if pattern.names else ", all as the tuned one, since every deviation is zero"
    fatigue = fatigue_of(asked, recovery_of(asked), with_blade_fatigue)
    if fatigue is None:
        return Works(work, summary, population_dataset)
    return Works(work, summary, lambda work, results: fatigue(population_dataset(work, results)))


KIND = Kind(
    plan,
    {"mistuned_population": MistuningTable, "fatigue": FatigueTable},
    optional=("fatigue",),
    without=("tolerance", "peak_tolerance"),
    check_of_sweep=checked_sweep,
    whole_disk=True,
)
