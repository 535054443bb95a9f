"""Further curves in a study: the tables [isolated] and [branches] of a forced response.

What a study asks of a response beside its curves: the tables [stress], [fatigue], [stability] and [reached].
"""

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from pydantic import Field, Tag

from stickslip.analyses.forced_response import ForcedResponse, ForcedResponseWork
from stickslip.analyses.modes.nonlinear_modes import NonlinearModes, nonlinear_modes
from stickslip.analyses.modes.work import AMPLITUDES, NonlinearModesWork
from stickslip.analyses.settings import ForcedResponseSettings
from stickslip.analyses.stress import own_recovery, with_fatigue
from stickslip.model import rigs
from stickslip.model.disks.tuned import FullDisk, TunedDisk
from stickslip.model.problem.speed import MOST_PERIODS
from stickslip.model.structure.stress import FatigueLimit, StressRecovery
from stickslip.solve.balance.fourier import Harmonics, checked_harmonics, highest
from stickslip.solve.time.period import refuse_waves
from stickslip.study.analysis import Asked
from stickslip.study.fields import LENGTH, PRESSURE, Groups, Number, Positive, Table, Words, by_form, in_si, with_si
from stickslip.study.tables import Ends
from stickslip.support.checks import MOST, InputError, fault, first_of, nearest, unique
from stickslip.support.late import xr

ModeNumber = Annotated[int, Field(ge=1, le=MOST)]
ModeNumbers = Annotated[
    Annotated[ModeNumber, Tag("<single>")] | Annotated[list[ModeNumber], Field(min_length=1), Tag("<list>")], by_form()
]
Amplitudes = Annotated[Ends | None, LENGTH, Field(description=AMPLITUDES)]
"""Ends of the curve of a nonlinear mode."""
Periods = Annotated[int, Field(ge=1, le=MOST_PERIODS)]


def ordered(amplitude: tuple[float, ...] | list[float] | None, mode: int | list[int] | None) -> None:
    """What the models of tables with modes cannot check."""
    if amplitude is not None and amplitude[0] >= amplitude[1]:
        raise fault("amplitude", "must be [smallest, largest] with the smallest first", amplitude)
    if isinstance(mode, list):
        unique("mode", mode)


class IsolatedTable(Table):
    """Isolated curves, which sweeps do not reach: found from nonlinear modes and along the force level."""

    search: bool = True
    """whether to search along the force level; without this table only if a contact has no friction"""
    mode: ModeNumbers | None = None
    """number of a mode of the stuck structure, or a list; default: none"""
    amplitude: Amplitudes = None
    periods: Periods = 1
    """periods of the excitation after which motions may repeat themselves; with several they are subharmonic"""

    def check(self) -> None:
        """The smallest amplitude first, and each mode once."""
        ordered(self.amplitude, self.mode)

    @property
    def ends(self) -> tuple[float, float] | None:
        """The amplitudes as a pair."""
        return None if self.amplitude is None else (self.amplitude[0], self.amplitude[1])


class BranchesTable(Table):
    """Branches at all branch points of the curves."""

    periods: Periods = 1
    """of a curve, after which motions may repeat themselves; 2 for period doublings"""


@dataclass(frozen=True, eq=False)
class FurtherCurves:
    """What a study asks for beyond its sweeps."""

    isolated: IsolatedTable | None
    branches: BranchesTable | None

    @classmethod
    def of(cls, asked: Asked) -> "FurtherCurves":
        """The tables of a study; refused for listed frequencies, which no curve joins."""
        isolated, branches = asked.table(IsolatedTable), asked.table(BranchesTable)
        for name, table in (("isolated", isolated), ("branches", branches)):
            if table is not None and asked.sweep is not None and asked.sweep.listed:
                raise fault(f"[{name}]", "needs a band, [sweep] frequency", "listed frequencies, [sweep] at")
        found = cls(None if isolated is None else with_si(isolated, asked.units), branches)
        if found.isolated is not None and found.isolated.mode is not None and asked.sweep is not None:
            found._refuse_modes(found.isolated, asked.sweep)
        return found

    def _refuse_modes(self, table: IsolatedTable, sweep: ForcedResponseSettings) -> None:
        """What would stop the modes when all sweeps are done: a number beyond the structure's, contacts at a node, amplitudes."""
        loaded = max((h for force in sweep.problem.forces for h in force.factors), default=1)
        harmonics = max(loaded, 1) if sweep.harmonics == "auto" else sweep.harmonics
        NonlinearModesWork(sweep.problem, table.mode, table.ends, harmonics, sweep.samples).refuse_amplitudes()

    @property
    def periods(self) -> int:
        """Over how many periods of the excitation the sweeps are to be expanded."""
        return 1 if self.isolated is None else self.isolated.periods

    @property
    def search(self) -> bool | None:
        """Whether detached curves are sought along the force level; None: where there may be some."""
        return None if self.isolated is None else self.isolated.search

    def added(self, response: ForcedResponse, work: ForcedResponseWork) -> ForcedResponse:
        """The response with the curves that are asked for."""
        if self.isolated is not None:
            modes = self._modes(self.isolated, work)
            response = response.with_isolated(*modes) if modes else response
        return response if self.branches is None else response.with_branches(self.branches.periods)

    def _modes(self, table: IsolatedTable, work: ForcedResponseWork) -> list[NonlinearModes]:
        if table.mode is None:
            return []
        harmonics = work.harmonics if isinstance(work.harmonics, int) else list(work.harmonics)
        return [nonlinear_modes(work.problem, table.mode, table.ends, harmonics, work.samples)]


Point = Annotated[list[Number], Field(min_length=3, max_length=3), Words("list of three numbers")]


class StressTable(Table):
    """Stress along the curves at places of a rig's finite elements."""

    places: Annotated[dict[str, Point], Field(min_length=1), Words("table of places")]
    """NAME = [x, y, z], in m and in the axes of the rig's body"""


def recovery_of(asked: Asked) -> StressRecovery | None:
    """The recovery at the places of the models, or of [stress] from the elements of a rig; None where no stress is asked for."""
    table = asked.table(StressTable)
    if table is None:
        return None if asked.sweep is None else own_recovery(asked.sweep.problem)
    rig, parameters = asked.rig
    maker = rigs.STRESS.get(rig)
    if maker is None:
        known = " or ".join(rigs.STRESS)
        raise InputError(
            f"[stress] must go with a rig whose finite elements are known ({known}), but stands beside {rig or 'matrices'!r}. "
            "Places of a model are named in [structure] stress."
        )
    shared = inspect.signature(maker).parameters
    return maker(table.places, **{name: value for name, value in parameters.items() if name in shared})


Pair = Annotated[list[Number], Field(min_length=2, max_length=2), Words("pair of numbers")]


NO_STRESS = "[fatigue] must go with places of stress, but there are none. Name them in [structure] stress."


class FatigueTable(Table):
    """The fatigue limit of the material at the places of stress, and mean stresses that the study does not hold."""

    exactly_one: ClassVar[Groups] = (("fatigue_strength", "points"),)

    fatigue_strength: Annotated[Positive | None, PRESSURE] = None
    """amplitude of stress that the material stands without mean stress"""
    ultimate_strength: Annotated[Positive | None, Field(description="ultimate tensile strength"), PRESSURE] = None
    yield_strength: Annotated[Positive | None, PRESSURE] = None
    """yield strength; given, amplitude and mean together stay below it"""
    criterion: Literal["goodman", "gerber", "soderberg"] = "goodman"
    """how a mean stress lowers the amplitude"""
    equivalent: Literal["sines", "von_mises", "principal"] = "sines"
    """stress in tension that replaces a stress of several components"""
    points: Annotated[list[Pair] | None, Field(min_length=2), PRESSURE, Words("list of pairs")] = None
    """pairs of mean stress and amplitude, a measured Haigh diagram in place of the strengths"""
    mean: Annotated[dict[str, Number] | None, PRESSURE, Words("table of stresses")] = None
    """PLACE = mean stress that the study does not hold, such as that of the rotation; added to its own"""


def fatigue_of(
    asked: Asked, recovery: StressRecovery | None, add: "Callable[..., xr.Dataset]" = with_fatigue
) -> "Callable[[xr.Dataset], xr.Dataset] | None":
    """What adds the fatigue margin to a result with stress, by `with_fatigue` or its like; None where it is not asked for."""
    table = asked.table(FatigueTable)
    if table is None:
        return None
    if recovery is None:
        raise InputError(NO_STRESS)
    given = in_si(table, asked.units)
    mean = {name: asked.units.factor(PRESSURE) * size for name, size in (table.mean or {}).items()}
    for name in mean:
        if not any(place == name or place.startswith(f"{name}/") for place in recovery.places):
            raise fault("[fatigue]: mean", "must name places of stress", name, nearest(name, recovery.places))
    if mean and recovery.rotation is not None:
        raise InputError(
            "[fatigue]: mean must not be given together with the speed of the model, since the mean stress then already contains "
            "that due to rotation. Leave out one of them."
        )
    strengths = {key: given[key] for key in ("fatigue_strength", "ultimate_strength", "yield_strength", "criterion")}
    try:
        limit = FatigueLimit(**strengths, points=given["points"] or ())
    except InputError as error:
        raise InputError(f"[fatigue]: {error}") from None
    return lambda dataset: add(dataset, limit, mean, table.equivalent)


def resting_fatigue(asked: Asked) -> list[str]:
    """A warning on fatigue margins of a bladed disk whose mean stress has nothing of its rotation."""
    table, problem = asked.table(FatigueTable), None if asked.sweep is None else asked.sweep.problem
    if table is None or not isinstance(problem, TunedDisk | FullDisk) or asked.disks:
        return []
    recovery = recovery_of(asked)
    if recovery is None or recovery.rotation is not None:
        return []
    bodies = {dof.rpartition(".")[0] for dof in problem.structure.dofs if dof.endswith(".rx")}
    pulled = (force.coefficients for force in problem.forces if force.static)
    if any(dof.rpartition(".")[0] not in bodies for coefficients in pulled for dof in coefficients):
        return []
    given = tuple(table.mean or ())
    lacking = [place for place in recovery.places if not any(place == name or place.startswith(f"{name}/") for name in given)]
    if not lacking:
        return []
    return [
        f"Warning: [fatigue]: the mean stress at {first_of(lacking)} has nothing of the rotation of the disk: the margin "
        "is that at rest, and too large. Write `speed` in [structure.sector], 0 for a test at rest, or [rotation], or state the "
        "stress of the rotation as `mean` in [fatigue]."
    ]


class StabilityTable(Table):
    """Stability of every point of the curves."""

    highest: Number | None = Field(
        default=None,
        gt=0.0,
        description="highest natural frequency in Hz of modes with inertia; default: eight times the highest harmonic",
    )


class ReachedTable(Table):
    """Which motions a machine shows: whether the highest peak of each curve is reached from rest, and by slow sweeps."""

    output: str | None = None
    """name of the output whose peaks are examined; default: the first"""
    steps_per_period: Annotated[int, Field(ge=8, le=MOST)] = 500
    """time steps per period of the excitation"""
    periods: Annotated[int, Field(ge=2, le=MOST)] = 2000
    """number of periods after which a motion that is not yet periodic is given up"""

    def refuse_few_steps(self, harmonics: Harmonics) -> None:
        """Refuse steps that cannot show the harmonics of the curves."""
        if self.steps_per_period <= 2 * highest(harmonics):
            rule = f"must be more than twice the {highest(harmonics)} harmonics"
            raise fault("[reached]: steps_per_period", rule, self.steps_per_period)


def reached_of(asked: Asked) -> ReachedTable | None:
    """The table [reached]; refused where no sweep can be followed or motions cannot be integrated in time."""
    table = asked.table(ReachedTable)
    if table is None or asked.sweep is None:
        return None
    if asked.sweep.listed:
        raise fault("[reached]", "needs a band, [sweep] frequency", "listed frequencies, [sweep] at")
    for name, beside in (("isolated", asked.table(IsolatedTable)), ("branches", asked.table(BranchesTable))):
        if beside is not None and beside.periods > 1:
            raise fault(f"[{name}] periods", "must be 1 beside [reached]", beside.periods)
    if asked.sweep.harmonics != "auto":
        table.refuse_few_steps(checked_harmonics(asked.sweep.harmonics))
    try:
        refuse_waves(asked.sweep.problem)
    except InputError as error:
        raise InputError(f"[reached]: {error}") from None
    names = asked.sweep.problem.output_names
    if table.output is not None and table.output not in names:
        raise fault("[reached]: output", "must be an output", table.output, nearest(table.output, names))
    return table
