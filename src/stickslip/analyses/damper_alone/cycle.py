"""Steady cycle of a damper between two platforms with prescribed motion: loops, forces, motion, states and energies.

`damper_cycle` computes one steady cycle; `steady_cycles` and `damper_evolution` several of one damper: all steady cycles for
sampled initial states, and a sequence with changing friction. `cycle_dataset` labels one, with forces, motion, states, energies
and harmonics; `cycle_motion` is one as it is drawn: the section of the damper, both platforms, contact points and loops.
"""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

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
from stickslip.analyses.settings import OfKind, Seed, Setting, Settings, Whole, takes
from stickslip.analyses.time_response import harmonics_of
from stickslip.model.contact.law import LoadDependentFriction
from stickslip.model.contact.protocol import OPEN, SLIP_DOWN, SLIP_UP, STICK
from stickslip.model.dampers.between_platforms import BetweenPlatforms, PlatformMotion, jamming
from stickslip.results.schema import Result, named, tabulated
from stickslip.runs.cases import Arrays, Progress, Report, all_cases, silent
from stickslip.solve.platforms.cycle import QUASI_STATIC, CycleModel, CycleOutcome, Marching, SteadyCycle, steady_cycle
from stickslip.solve.platforms.march import PlatformState, Record
from stickslip.solve.time.period import Method
from stickslip.support.checks import Array, Index, InputError, between, fault, positive, several, vector, whole
from stickslip.support.late import xr
from stickslip.support.renderers import FIGURES

HARMONICS = 15
"""Harmonics of the platform forces that are kept."""


def cycle_dataset(
    rig: BetweenPlatforms, model: CycleModel, march: SteadyCycle, marching: Marching, sentence: str
) -> "xr.Dataset":
    """Everything about the last cycle."""
    variables = _platforms(rig, model, march) | _contact_forces(model, march) | _contact_motions(rig, model, march)
    variables |= _states(model, march) | _energies(model, march) | _section(rig)
    mus = [getattr(law, "mu", np.nan) for law in rig.laws]  # NaN of one that depends on the load
    coords = {
        "contact": [point.name for point in rig.points],
        "side": [point.side for point in rig.points],
        "axis": ["x", "y"],
        "damper": ["x", "y", "rotation"],
        "kind": ["stick", "slip", "open"],
        "platform": ["left", "right"],
        "part": ["re", "im"],
    }
    attrs = {
        "title": rig.title or rig.damper.name,
        "pull": float(np.hypot(*np.asarray(rig.damper.pull)[:2])),
        "method": repr(marching.method) if marching.method else "quasi-static",
        "frequency": marching.frequency,
        "friction": [np.nan if isinstance(mu, LoadDependentFriction) else float(mu) for mu in mus],
        "cycles": march.cycles,
        "outcome": march.outcome.name.lower(),
        "message": sentence,
    }
    return tabulated("damper_cycle", variables, coords, attrs)


def _section(rig: BetweenPlatforms) -> dict[str, Any]:
    """Where the damper is touched, and its outline, from its mass centre: for drawings."""
    return {
        "outline": np.reshape(rig.damper.body.outline, (-1, 3))[:, :2],
        "place": [point.arm for point in rig.points],
        "tangent": [point.tangent for point in rig.points],
        "normal": [point.normal for point in rig.points],
    }


def _platforms(rig: BetweenPlatforms, model: CycleModel, march: SteadyCycle) -> dict[str, Any]:
    """Motion of platforms and damper, and the forces on the platforms, with their harmonics."""
    steps, motion = march.drive.shape[0], march.record.motion
    on_left, on_right = forces_on_platforms(model, march)
    spectrum = harmonics_of(np.stack([on_left.T, on_right.T]), min(HARMONICS, steps // 4))
    return {
        "phase": np.arange(steps) / steps,
        "platform_motion": platform_motion(model, march),
        "right_motion": motion[:, 3:5] if rig.right else np.zeros((steps, 2)),
        "force_on_left": on_left,
        "force_on_right": on_right,
        "force_harmonics": np.stack([spectrum.real, spectrum.imag], axis=-1),
        "damper_motion": motion[:, :3],
        "rotation": float(np.ptp(motion[:, 2])),
    }


def _contact_forces(model: CycleModel, march: SteadyCycle) -> dict[str, Any]:
    tangential, normal_rows = _rows(model)
    friction, normal = march.record.force[:, tangential], march.record.force[:, normal_rows]
    with np.errstate(invalid="ignore", divide="ignore"):
        ratio = np.where(normal > 0.0, friction / normal, np.nan)
    # The slip limit of a contact is the sum of those of its elements.
    table = model.table
    first, last = table.friction_first[table.first_row[:-1]], table.friction_first[table.first_row[1:]]
    limits = [march.record.limit[:, a:b].sum(axis=1) for a, b in zip(first, last, strict=True)]
    return {
        "friction_force": friction,
        "normal_force": normal,
        "force_ratio": ratio,
        "slip_limit": np.stack(limits, axis=1),
    }


def _contact_motions(rig: BetweenPlatforms, model: CycleModel, march: SteadyCycle) -> dict[str, Any]:
    """Motion at every contact, parted into elastic and slip, and the rolling."""
    tangential, normal_rows = _rows(model)
    u, z = march.record.w[:, tangential], march.record.w[:, normal_rows]
    elastic = _sprung(march.record.force[:, tangential], model.stiffness[tangential])
    return {
        "tangential_motion": u,
        "approach": z,
        "elastic_motion": elastic,
        "slip_motion": u - elastic,
        "rolling": march.record.motion[:, 2:3] * np.array([point.radius for point in rig.points]),
    }


def _states(model: CycleModel, march: SteadyCycle) -> dict[str, Any]:
    states = contact_states(model, march)
    kinds = (states == STICK, np.abs(states) == 1, states == OPEN)
    return {
        "state": states,
        "share": np.stack([kind.mean(axis=0) for kind in kinds], axis=1),
        "iterations": march.record.iterations,
    }


def _energies(model: CycleModel, march: SteadyCycle) -> dict[str, Any]:
    """Loop energy ∫ F dx on the platforms: friction work and, where the cycle does not close, what is stored in the end."""
    path, work = march.path(model), slip_work(model, march)
    motion = platform_motion(model, march)
    force = path.force @ model.left
    # by trapezes
    loop = float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(np.append(motion, motion[:1], axis=0), axis=0)))
    stored = float(np.diff(stored_energy(model, path)[[0, -1]])[0])
    error = abs(loop - work.sum() - stored)
    return {
        "friction_work": work,
        "loop_energy": loop,
        "stored_energy": stored,
        "energy_error": error / abs(loop) if loop else error,
    }


def _rows(model: CycleModel) -> tuple[Index, Index]:
    """Tangential and normal rows, one of each a contact."""
    normal = model.table.normal_row
    return np.setdiff1d(np.arange(model.B.shape[0]), normal), normal


def platform_motion(model: CycleModel, march: SteadyCycle) -> Array:
    """x and y of the left platform, (steps, 2) [m]."""
    return np.asarray(march.drive @ np.linalg.pinv(model.left.T))


def forces_on_platforms(model: CycleModel, march: SteadyCycle) -> tuple[Array, Array]:
    """x and y of the damper's force on the left and on the right platform, (steps, 2) each [N]."""
    return -march.record.force @ model.left, -march.record.force @ model.right


def slip_work(model: CycleModel, march: SteadyCycle) -> Array:
    """Friction work of each contact over the cycle, Σ T δ(slip) over its elements and Σ T δu of what no spring carries, both
    trapezoidal, (contacts,) [J]."""
    path, table, rows = march.path(model), model.table, _rows(model)[0]
    traction = _tractions(model, path)
    slid = _sprung(-np.diff(path.intercept, axis=0), table.stiffness)
    work = np.sum(0.5 * (traction[1:] + traction[:-1]) * slid, axis=0)
    elements = _elements(model)
    direct = path.force[:, rows] - np.stack([traction[:, own].sum(axis=1) for own in elements], axis=1)
    further = np.sum(0.5 * (direct[1:] + direct[:-1]) * np.diff(path.w[:, rows], axis=0), axis=0)
    return np.asarray(further + np.array([work[own].sum() for own in elements]))


def stored_energy(model: CycleModel, path: Record) -> Array:
    """½ Σ T²/kt + ½ Σ N²/kn over the elements, ½ qᵀKq of the platform's rig, less the work of the pull, (samples,) [J]."""
    table, size = model.table, np.ones(model.load.size)
    size[2] = model.length
    motion = path.motion * size
    press = np.repeat(path.w[:, table.normal_row], np.diff(table.normal_first), axis=1)
    normal = np.maximum(table.normal_stiffness * press + table.normal_constant, 0.0)
    elastic = _sprung(_tractions(model, path) ** 2, table.stiffness).sum(axis=1)
    elastic = elastic + (normal**2 / table.normal_stiffness).sum(axis=1)
    return np.asarray(0.5 * (elastic + np.sum(motion @ model.matrices[2] * motion, axis=1)) - motion @ model.load)


def contact_states(model: CycleModel, march: SteadyCycle) -> Index:
    """What each contact does at each sample, (steps, contacts): open where no element carries load, slip where one slides; at
    sample 0 in the step that ends the cycle."""
    path, table = march.path(model), model.table
    force, slid = path.force[1:], -np.diff(path.intercept, axis=0)
    found = np.full((slid.shape[0], table.normal_row.size), STICK)
    for c, (normal, elements) in enumerate(zip(table.normal_row, _elements(model), strict=True)):
        moved = np.any((slid[:, elements] != 0.0) | (table.stiffness[elements] == 0.0), axis=1)
        row = next(row for row in range(table.first_row[c], table.first_row[c + 1]) if row != normal)
        found[moved, c] = np.where(force[moved, row] >= 0.0, SLIP_UP, SLIP_DOWN)
        found[force[:, normal] <= 0.0, c] = OPEN
    return np.roll(found, 1, axis=0)


def _sprung(values: Array, stiffness: Array) -> Array:
    """values/kt, and 0 without a spring, (samples, elements)."""
    return np.divide(values, stiffness, out=np.zeros_like(values), where=stiffness > 0.0)


def _tractions(model: CycleModel, path: Record) -> Array:
    """Force of the spring of each friction element, 0 without one, (samples, elements) [N]."""
    table = model.table
    stretched = table.stiffness * np.repeat(path.w, np.diff(table.friction_first), axis=1)
    return np.where(table.stiffness > 0.0, path.intercept + stretched, 0.0)


def _elements(model: CycleModel) -> list[slice]:
    """The friction elements of each contact."""
    table = model.table
    return [slice(table.friction_first[a], table.friction_first[b]) for a, b in pairwise(table.first_row)]


def cycle_motion(dataset: "xr.Dataset") -> PeriodOfMotion:
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


def _point(dataset: "xr.Dataset", k: int, motion: Array, frames: Index) -> PointMotion:
    """A line of contact. Its friction and normal force act on the damper along t1 and n, since w = platform − damper."""
    place = dataset["place"].values[k]
    x, y = place
    moved = motion[:, :2] + motion[:, 2:] * np.array([-y, x])
    along = np.stack([dataset[name].values[k] for name in ("tangent", "normal")])
    forces = np.stack([dataset[name].values[frames, k] for name in ("friction_force", "normal_force")], axis=1)
    states = point_states(dataset["state"].values[None, frames, k])
    return PointMotion(str(dataset["contact"].values[k]), place, moved, states, forces @ along)


def _face(dataset: "xr.Dataset", side: str, frames: Index) -> FaceMotion:
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

    dataset: "xr.Dataset"
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


REPEATING = (CycleOutcome.STEADY, CycleOutcome.JAMMED)


@dataclass(frozen=True, eq=False, repr=False)
class SteadyCycles(Result):
    """The distinct steady cycles that were found, the most frequent first, and how many of the starts led to each; starts that
    led to none: `failed`."""

    cycles: tuple[DamperCycle, ...]
    counts: tuple[int, ...]
    failed: int

    @property
    def dataset(self) -> "xr.Dataset":
        """All cycles along the dimension `cycle`, with `starts`, the number of starts that led to each."""
        if not self.cycles:
            raise InputError(f"None of {self.failed} starts led to a steady cycle. Take more steps, or other slider offsets.")
        starts = named("cycle", list(self.counts), "initial states that lead to the cycle")
        return together(self.cycles).assign(starts=starts).assign_attrs(failed=self.failed)

    def animate(self, cycle: int = 1) -> Any:
        """One of the steady cycles in moving pictures, counted from 1 as in the figures; the first is that of most starts."""
        return _animated(self.cycles, cycle)


@dataclass(frozen=True, eq=False, repr=False)
class DamperEvolution(Result):
    """The last cycle with each set of friction coefficients, in their order."""

    cycles: tuple[DamperCycle, ...]

    @property
    def dataset(self) -> "xr.Dataset":
        """All cycles along the dimension `cycle`, with `friction` (cycle, contact)."""
        mu = np.array([cycle.dataset.attrs["friction"] for cycle in self.cycles])
        return together(self.cycles).assign(friction=named(("cycle", "contact"), mu, "friction coefficient"))

    def animate(self, cycle: int = 1) -> Any:
        """The cycle with one of the sets of friction coefficients in moving pictures, counted from 1."""
        return _animated(self.cycles, cycle)


def _animated(cycles: Sequence[DamperCycle], cycle: int) -> Any:
    if not cycles:
        raise InputError("There is no steady cycle to animate.")
    return cycles[between("cycle", cycle, 1, len(cycles)) - 1].animate()


def together(cycles: Sequence[DamperCycle]) -> "xr.Dataset":
    """Cycles of one damper under one motion as one dataset; their outcomes and sentences as variables."""
    found = xr.concat([cycle.dataset for cycle in cycles], "cycle", combine_attrs="drop_conflicts")
    for key, words in (("outcome", "how the search ended"), ("message", "the outcome in words")):
        found[key] = named("cycle", [str(cycle.dataset.attrs[key]) for cycle in cycles], words)
        found.attrs.pop(key, None)
    found.attrs.pop("friction", None)
    return found.assign_coords(cycle=named("cycle", np.arange(1, len(cycles) + 1), "number of the cycle"))


def _sets(name: str, value: Any) -> tuple[Any, ...]:
    found = several(name, value)
    if not found:
        raise fault(name, "must hold at least one set of coefficients", [])
    return found


@dataclass(frozen=True, eq=False, kw_only=True)
class SteadyCyclesWork(Driven):
    """Cycles from several initial states, a case each."""

    starts: Annotated[int, Setting(Whole(1), "number of initial states", key="count")] = 20
    spread: Annotated[float | None, Setting(positive, "largest slider offset; default: twice the pull over the softest kt")] = (
        None
    )
    seed: Seed = 0
    same: Annotated[
        float, Setting(positive, "difference of forces, relative to the largest, below which cycles count as equal")
    ] = 1e-6
    steps: Annotated[int, Setting(whole, "steps per cycle")] = 1000
    workers: int = 1
    progress: Progress = silent

    def __post_init__(self) -> None:
        super().__post_init__()
        self.motion.samples(self.steps), self.offsets

    @property
    def names(self) -> Sequence[str]:
        how = f"{self.identity('rig', 'motion')}, motion {self.motion.digest}"
        return [f"start {number + 1}, {how}" for number in range(self.starts)]

    @property
    def words(self) -> Sequence[str]:
        return [f"initial state {number + 1}" for number in range(self.starts)]

    @cached_property
    def offsets(self) -> Array:
        """Slider offsets of every start, the virgin first, (starts, elements) [m]."""
        model, generator = CycleModel.of(self.rig), np.random.default_rng(self.seed)
        stiffness = model.table.stiffness
        usual = 2.0 * float(np.hypot(*model.load[:2]) / stiffness.min())
        width = usual if self.spread is None else self.spread
        drawn = generator.uniform(-width, width, (self.starts - 1, stiffness.size))
        return np.vstack([np.zeros(stiffness.size), drawn])

    def prepare(self) -> None:
        """Compile the march."""
        damper_cycle(self.rig, self.motion, steps=max(8, self.steps // 10), cycles=1)

    def solve(self, case: int, report: Report) -> Arrays:
        """The march from one initial state."""
        return march_arrays(damper_cycle(self.rig, self.motion, start=self.offsets[case], steps=self.steps).march)

    def gathered(self, results: Sequence[Arrays]) -> SteadyCycles:
        """Equal cycles as one."""
        found: list[DamperCycle] = []
        counts: list[int] = []
        for cycle in (gathered(self.rig, self.motion, march_of(arrays)) for arrays in results):
            if cycle.outcome not in REPEATING:
                continue
            force = cycle.march.record.force
            apart = (np.max(np.abs(force - other.march.record.force)) for other in found)
            match = next((i for i, each in enumerate(apart) if each <= self.same * np.max(np.abs(force))), len(found))
            if match == len(found):
                found, counts = [*found, cycle], [*counts, 0]
            counts[match] += 1
        order = sorted(range(len(found)), key=lambda i: -counts[i])
        failed = len(results) - sum(counts)
        return SteadyCycles(tuple(found[i] for i in order), tuple(counts[i] for i in order), failed)


@takes(SteadyCyclesWork)
def steady_cycles(work: SteadyCyclesWork) -> SteadyCycles:
    """Steady quasi-static cycles that start from the virgin state and from random slider offsets, uniform in ±spread [m].

    spread: default twice the pull over the softest tangential stiffness. Cycles whose contact forces differ by less than `same`
    of the largest force count as equal. workers: number of processes; progress(share, text) is called after each start.
    """
    return work.gathered(all_cases(work, None, work.workers, work.progress))


@dataclass(frozen=True, eq=False)
class EvolutionWork(Driven):
    """A sequence of cycles, each from the state that the one before left: one case, since none can be computed alone."""

    friction: Annotated[
        Sequence[ArrayLike], Setting(_sets, "sets of coefficients: a number each, or one for each line of contact")
    ]
    _: KW_ONLY
    cycles: Annotated[int, Setting(Whole(1), "cycles with each set of coefficients; the last one is saved")] = 1
    steps: Annotated[int, Setting(whole, "steps per cycle")] = 1000
    progress: Progress = silent

    def __post_init__(self) -> None:
        super().__post_init__()
        for mu in self.friction:
            vector("friction", mu, len(self.rig.laws))
        self.rigs, self.motion.samples(self.steps)

    @property
    def names(self) -> Sequence[str]:
        return (f"evolution, {self.identity('rig', 'motion')}, motion {self.motion.digest}",)

    @property
    def words(self) -> Sequence[str]:
        return (f"{len(self.friction)} sets of friction coefficients",)

    @cached_property
    def rigs(self) -> tuple[BetweenPlatforms, ...]:
        """The damper with every set."""
        return tuple(self.rig.with_friction(mu) for mu in self.friction)

    def solve(self, case: int, report: Report) -> Arrays:
        """The marches of all sets, by number."""
        start: PlatformState | float = 0.0
        found: dict[str, Any] = {}
        for number, rig in enumerate(self.rigs):
            march = damper_cycle(rig, self.motion, start=start, steps=self.steps, cycles=self.cycles).march
            start = march.state
            found |= {f"{number} {key}": value for key, value in march_arrays(march).items()}
            report((number + 1) / len(self.rigs))
        return found

    def gathered(self, arrays: Arrays) -> DamperEvolution:
        """The cycles from their arrays."""
        parts = [
            {key.partition(" ")[2]: a for key, a in arrays.items() if key.startswith(f"{n} ")} for n in range(len(self.rigs))
        ]
        return DamperEvolution(
            tuple(gathered(rig, self.motion, march_of(part)) for rig, part in zip(self.rigs, parts, strict=True))
        )


@takes(EvolutionWork)
def damper_evolution(work: EvolutionWork) -> DamperEvolution:
    """Cycles while friction changes: the last of `cycles` cycles with each set of coefficients (a number, or one per line of
    contact). Each set starts from the final state of the previous one. progress(share, text) is called after each set."""
    return work.gathered(all_cases(work, None, 1, work.progress)[0])
