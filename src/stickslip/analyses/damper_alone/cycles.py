"""Several cycles of one damper: all steady cycles for sampled initial states, and a sequence with changing friction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cached_property
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.analyses.damper_alone.cycle import DamperCycle, Driven, damper_cycle, gathered, march_arrays, march_of
from stickslip.analyses.settings import Seed, Setting, Whole, takes
from stickslip.model.dampers.between_platforms import BetweenPlatforms
from stickslip.results.result import Result
from stickslip.runs.cases import all_cases
from stickslip.runs.work import Arrays, Progress, Report, silent
from stickslip.solve.platforms.cycle import CycleModel, CycleOutcome
from stickslip.solve.platforms.march import PlatformState
from stickslip.support.checks import Array, InputError, between, fault, positive, several, vector, whole
from stickslip.support.late import xr

REPEATING = (CycleOutcome.STEADY, CycleOutcome.JAMMED)


@dataclass(frozen=True, eq=False, repr=False)
class SteadyCycles(Result):
    """The distinct steady cycles that were found, the most frequent first, and how many of the starts led to each; starts that
    led to none: `failed`."""

    cycles: tuple[DamperCycle, ...]
    counts: tuple[int, ...]
    failed: int

    @property
    def dataset(self) -> xr.Dataset:
        """All cycles along the dimension `cycle`, with `starts`, the number of starts that led to each."""
        if not self.cycles:
            raise InputError(f"None of {self.failed} starts led to a steady cycle. Take more steps, or other slider offsets.")
        words = {"units": "1", "long_name": "initial states that lead to the cycle"}
        return together(self.cycles).assign(starts=("cycle", list(self.counts), words)).assign_attrs(failed=self.failed)

    def animate(self, cycle: int = 1) -> Any:
        """One of the steady cycles in moving pictures, counted from 1 as in the figures; the first is that of most starts."""
        return _animated(self.cycles, cycle)


@dataclass(frozen=True, eq=False, repr=False)
class DamperEvolution(Result):
    """The last cycle with each set of friction coefficients, in their order."""

    cycles: tuple[DamperCycle, ...]

    @property
    def dataset(self) -> xr.Dataset:
        """All cycles along the dimension `cycle`, with `friction` (cycle, contact)."""
        mu = np.array([cycle.dataset.attrs["friction"] for cycle in self.cycles])
        words = {"units": "1", "long_name": "friction coefficient"}
        return together(self.cycles).assign(friction=(("cycle", "contact"), mu, words))

    def animate(self, cycle: int = 1) -> Any:
        """The cycle with one of the sets of friction coefficients in moving pictures, counted from 1."""
        return _animated(self.cycles, cycle)


def _animated(cycles: Sequence[DamperCycle], cycle: int) -> Any:
    if not cycles:
        raise InputError("There is no steady cycle to animate.")
    return cycles[between("cycle", cycle, 1, len(cycles)) - 1].animate()


def together(cycles: Sequence[DamperCycle]) -> xr.Dataset:
    """Cycles of one damper under one motion as one dataset; their outcomes and sentences as variables."""
    found = xr.concat([cycle.dataset for cycle in cycles], "cycle", combine_attrs="drop_conflicts")
    labels = {key: [str(cycle.dataset.attrs[key]) for cycle in cycles] for key in ("outcome", "message")}
    words = {"outcome": "how the search ended", "message": "the outcome in words"}
    for key, values in labels.items():
        found[key] = ("cycle", values, {"units": "1", "long_name": words[key]})
        found.attrs.pop(key, None)
    found.attrs.pop("friction", None)
    number = {"units": "1", "long_name": "number of the cycle"}
    return found.assign_coords(cycle=("cycle", np.arange(1, len(cycles) + 1), number))


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
            match = next((i for i, other in enumerate(found) if _difference(cycle, other) <= self.same), len(found))
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


def _difference(a: DamperCycle, b: DamperCycle) -> float:
    """Largest difference of contact forces relative to the largest force."""
    one, other = a.march.record.force, b.march.record.force
    return float(np.max(np.abs(one - other)) / np.max(np.abs(one)))


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

    def prepare(self) -> None:
        """One case needs no preparation."""

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
