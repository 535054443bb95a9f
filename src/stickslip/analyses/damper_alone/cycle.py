"""Steady cycle of a damper between two platforms with prescribed motion: loops, forces, motion, states and energies.

`damper_cycle` computes one steady cycle; `cycles.py` several of them. `cycle_motion` is one as it is drawn: the section of the
damper, both platforms, contact points and loops, from its dataset.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.analyses.damper_alone.cycle_dataset import contact_states, cycle_dataset, forces_on_platforms
from stickslip.analyses.motion import (
    OVERLAP,
    BodyMotion,
    FaceMotion,
    LoopMotion,
    PeriodOfMotion,
    PointMotion,
    frames_of,
    point_states,
)
from stickslip.analyses.settings import OfKind, Setting, Settings, Whole, takes
from stickslip.model.contact.law import LoadDependentFriction
from stickslip.model.contact.period import STICK
from stickslip.model.dampers.between_platforms import BetweenPlatforms, jamming
from stickslip.model.dampers.platform_motion import PlatformMotion
from stickslip.results.result import Result
from stickslip.runs.work import Arrays, Report
from stickslip.solve.platforms.cycle import QUASI_STATIC, CycleModel, CycleOutcome, Marching, SteadyCycle, steady_cycle
from stickslip.solve.platforms.march import PlatformState, Record
from stickslip.solve.time.model import Method
from stickslip.support.checks import Array, Index, fault, positive, vector, whole
from stickslip.support.late import xr
from stickslip.support.renderers import FIGURES


def cycle_motion(dataset: xr.Dataset) -> PeriodOfMotion:
    """The motion of the last cycle."""
    loops = tuple(
        LoopMotion(
            str(name),
            dataset["tangential_motion"].values[:, k],
            dataset["friction_force"].values[:, k],
            point_states(dataset["state"].values[None, :, k]),
        )
        for k, name in enumerate(dataset["contact"].values)
    )
    title = str(dataset.attrs["title"])
    if not dataset.sizes.get("corner"):
        return PeriodOfMotion(title, loops)
    frames = frames_of(dataset.sizes["sample"])
    motion = _about_mean(dataset["damper_motion"].values)[frames]
    body = BodyMotion("damper", dataset["outline"].values, np.zeros(2), motion)
    points = tuple(_point(dataset, k, motion, frames) for k in range(len(loops)))
    return PeriodOfMotion(title, loops, (body,), tuple(_face(dataset, side, frames) for side in ("left", "right")), points)


def _about_mean(values: Array) -> Array:
    return np.asarray(values - values.mean(axis=0))


def _point(dataset: xr.Dataset, k: int, motion: Array, frames: Index) -> PointMotion:
    """A line of contact. Its friction and normal force act on the damper along t1 and n, since w = platform − damper."""
    place = dataset["place"].values[k]
    x, y = place
    moved = motion[:, :2] + motion[:, 2:] * np.array([-y, x])
    along = np.stack([dataset[name].values[k] for name in ("tangent", "normal")])
    forces = np.stack([dataset[name].values[frames, k] for name in ("friction_force", "normal_force")], axis=1)
    states = point_states(dataset["state"].values[None, frames, k])
    return PointMotion(str(dataset["contact"].values[k]), place, moved, states, forces @ along)


def _face(dataset: xr.Dataset, side: str, frames: Index) -> FaceMotion:
    """The face of one platform, which shifts without turning."""
    own = np.flatnonzero(dataset["side"].values == side)
    places = dataset["place"].values[own]
    tangent, into = dataset["tangent"].values[own[0]], -dataset["normal"].values[own[0]]
    reach = OVERLAP * float(np.ptp(dataset["outline"].values, axis=0).max())
    s = places @ tangent
    ends = (places @ into).mean() * into + np.array([s.min() - reach, s.max() + reach])[:, None] * tangent
    moved = _about_mean(dataset["platform_motion" if side == "left" else "right_motion"].values)[frames]
    return FaceMotion(ends, into, np.repeat(moved[:, None], 2, axis=1))


Rig = Annotated[BetweenPlatforms, Setting(OfKind(BetweenPlatforms))]
Motion = Annotated[PlatformMotion, Setting(OfKind(PlatformMotion))]

LARGEST_ROTATION = 0.1
"""Rotation of the damper, peak to peak [rad], up to which directions and arms may be those at rest: arms change by 0.5 %."""


@dataclass(frozen=True, eq=False, repr=False)
class DamperCycle(Result):
    """One cycle: `dataset` (labelled, with units), the rig, the motion, the march that made it."""

    dataset: xr.Dataset
    rig: BetweenPlatforms
    motion: PlatformMotion
    march: SteadyCycle

    @property
    def outcome(self) -> CycleOutcome:
        """How the search ended."""
        return self.march.outcome

    @property
    def sentence(self) -> str:
        """The outcome in words, with its cause."""
        return str(self.dataset.attrs["message"])

    @property
    def energy(self) -> float:
        """Energy that the damper takes from the platforms in a cycle, J."""
        return float(self.dataset.loop_energy)

    def animate(self) -> Any:
        """The last cycle in moving pictures, an `Animation` as of `ForcedResponse.animate`: the damper in its section, both
        platforms, contact states, forces on the damper, friction loops."""
        return FIGURES.known("PeriodOfMotion")[""](cycle_motion(self.dataset))

    @property
    def state(self) -> PlatformState:
        """The state at the end of the cycle, from which another can start."""
        return self.march.state


def _sentence(march: SteadyCycle, cause: str) -> str:
    words = {
        CycleOutcome.STEADY: f"The cycle repeats after {march.cycles} cycles.",
        CycleOutcome.NOT_STEADY: f"The forces still change by {march.change:.1e} of the largest after {march.cycles} cycles.",
        CycleOutcome.JAMMED: f"The damper is jammed: {cause}",
        CycleOutcome.NOT_CONVERGED: f"Newton's method failed in cycle {march.cycles}; more steps a cycle may help.",
    }
    rotation = float(np.ptp(march.record.motion[:, 2]))
    if rotation <= LARGEST_ROTATION:  # a theory of small motions holds
        return words[march.outcome]
    too_far = f"It turns by {rotation:.3g} rad, but the theory holds up to {LARGEST_ROTATION:g}: check the motion's unit (m)."
    return f"{words[march.outcome]} {too_far}"


def march_arrays(march: SteadyCycle) -> Arrays:
    """A march as plain arrays, which travel and are kept."""
    end = np.array([march.cycles, march.outcome, march.change])
    state = {f"state_{key}": value for key, value in march.state._asdict().items()}
    return {"end": end, "drive": march.drive, **march.record._asdict(), **state}


def march_of(arrays: Arrays) -> SteadyCycle:
    """The march of its arrays."""
    record = Record(*(np.asarray(arrays[name]) for name in Record._fields))
    state = PlatformState(*(np.asarray(arrays[f"state_{name}"]) for name in PlatformState._fields))
    cycles, outcome, change = arrays["end"]
    return SteadyCycle(record, arrays["drive"], state, int(cycles), CycleOutcome(int(outcome)), float(change))


def gathered(rig: BetweenPlatforms, motion: PlatformMotion, march: SteadyCycle, marching: Marching = QUASI_STATIC) -> DamperCycle:
    """The labelled cycle of a march."""
    model, cause = CycleModel.of(rig), jamming(rig)
    # Where there is no sample at which every closed contact slips, the damper never slides out.
    if cause and (march.outcome == CycleOutcome.NOT_CONVERGED or np.all(np.any(contact_states(model, march) == STICK, axis=1))):
        march = replace(march, outcome=CycleOutcome.JAMMED)
    dataset = cycle_dataset(rig, model, march, marching, _sentence(march, cause))
    dataset.attrs["message"] += _beyond_friction(rig, dataset["normal_force"].values)
    return DamperCycle(dataset, rig, motion, march)


def _beyond_friction(rig: BetweenPlatforms, loads: Array) -> str:
    """A sentence on a contact whose normal loads (samples, contacts) all lie beyond those of its coefficient of friction."""
    for point, law, load in zip(rig.points, rig.laws, loads.T, strict=True):
        mu = getattr(law, "mu", None)
        if isinstance(mu, LoadDependentFriction) and (load.max() < mu.over[0] or load.min() > mu.over[-1]):
            return (
                f" The normal load of {point.name}, {load.min():.4g} to {load.max():.4g} N, lies outside the range for which mu "
                f"is given, {mu.over[0]:.4g} to {mu.over[-1]:.4g} N: mu is constant there, "
                f"{float(mu.coefficient(load.max())):.4g}."
            )
    return ""


@dataclass(frozen=True, eq=False)
class Driven(Settings):
    """A damper and the motion of its platform."""

    rig: Rig
    motion: Motion


@dataclass(frozen=True, eq=False, kw_only=True)
class CycleWork(Driven):
    """One steady cycle, as work of a study: its march as plain arrays."""

    steps: Annotated[int, Setting(whole)] = 1000
    method: Method | None = None
    frequency: Annotated[float | None, Setting(positive)] = None
    start: PlatformState | ArrayLike = 0.0
    tolerance: Annotated[float, Setting(positive)] = 1e-9
    cycles: Annotated[int, Setting(Whole(1))] = 100

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.method is None) != (self.frequency is None):
            rule = "must go with a method in time, and a method with a frequency"
            raise fault("frequency", rule, self.frequency, "A quasi-static cycle needs neither.")
        self.motion.samples(self.steps)

    @property
    def marching(self) -> Marching:
        """How the cycle is looked for."""
        return Marching(self.tolerance, self.cycles, self.method, self.frequency or 0.0)

    @property
    def march(self) -> SteadyCycle:
        """The cycles up to the steady one."""
        model, start = CycleModel.of(self.rig), self.start
        state = start if isinstance(start, PlatformState) else model.virgin(vector("start", start, model.table.stiffness.size))
        return steady_cycle(model, self.motion.samples(self.steps), self.marching, state)

    @property
    def names(self) -> Sequence[str]:
        return (f"steady cycle, {self.identity('rig', 'motion')}, motion {self.motion.digest}",)

    @property
    def words(self) -> Sequence[str]:
        return (self.rig.title,)

    def prepare(self) -> None:
        """One case needs no preparation."""

    def solve(self, case: int, report: Report) -> Arrays:
        """The march of the cycle."""
        return march_arrays(self.march)

    def gathered(self, arrays: Arrays) -> DamperCycle:
        """The cycle from its arrays."""
        return gathered(self.rig, self.motion, march_of(arrays), self.marching)


@takes(CycleWork)
def damper_cycle(work: CycleWork) -> DamperCycle:
    """Steady cycle of a damper under a prescribed motion of the left platform.

    The pull is applied first, with the platforms at rest. Cycles then follow until the forces repeat within `tolerance` of the
    largest force, at most `cycles` of them. The motion is quasi-static unless a `method` in time (`GeneralisedAlpha`, `Newmark`)
    is given with the `frequency` [Hz]. steps: per cycle. start: slider offsets [m], a number or one per friction element, or the
    state of another cycle (`DamperCycle.state`), so that cycles can be chained to a loading history.
    """
    return gathered(work.rig, work.motion, work.march, work.marching)


def cycle_forces(model: CycleModel, platform: Array, marching: Marching = QUASI_STATIC) -> tuple[Array, SteadyCycle]:
    """H, V on the right platform (steps, 2) [N] and the march, without labels: the quick way for fits.

    model: `CycleModel.of(rig)`, changed with `with_parameters`; platform: `motion.samples(steps)`.
    """
    march = steady_cycle(model, platform, marching)
    return forces_on_platforms(model, march)[1], march
