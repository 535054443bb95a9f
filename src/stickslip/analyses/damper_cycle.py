"""The cycle of a damper alone between two platforms that move as prescribed: loops, contact forces, motion, states, energies.

`damper_cycle` computes one steady cycle, `steady_cycles` all those that seeded initial states lead to, `damper_evolution` a
sequence of cycles while friction changes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip.analyses.cases import Arrays, Tell
from stickslip.analyses.damper_cycle_dataset import contact_states, cycle_dataset
from stickslip.checks import Array, fault, positive, vector
from stickslip.contact.period import STICK
from stickslip.dampers.between_platforms import BetweenPlatforms
from stickslip.dampers.jamming import jamming
from stickslip.dampers.platform_motion import PlatformMotion
from stickslip.solve.platform_cycle import QUASI_STATIC, CycleModel, CycleOutcome, Marching, SteadyCycle, steady_cycle
from stickslip.solve.platform_march import PlatformState, Record
from stickslip.time.methods import Method

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False)
class DamperCycle:
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

    @property
    def state(self) -> PlatformState:
        """The state at the end of the cycle, from which another can start."""
        return self.march.state

    def plot(self, **options: Any) -> Any:
        """The figure of the cycle."""
        from stickslip.plots import plot

        return plot(self, **options)


def damper_cycle(
    rig: BetweenPlatforms,
    motion: PlatformMotion,
    *,
    steps: int = 1000,
    method: Method | None = None,
    frequency: float | None = None,
    start: PlatformState | ArrayLike = 0.0,
    tolerance: float = 1e-9,
    cycles: int = 100,
) -> DamperCycle:
    """The steady cycle of a damper under a prescribed motion of the left platform.

    The pull is laid on first, with the platforms at rest, then cycles follow until the forces repeat to `tolerance` of the
    largest, at most `cycles`. Quasi-static unless a `method` in time (`GeneralisedAlpha`, `Newmark`) is given with the
    `frequency` [Hz]. steps: of a cycle. start: slider offsets [m], a number or one per friction element, or the state of another
    cycle (`DamperCycle.state`): a loading history is a chain of cycles.
    """
    marching = _marching(method, frequency, tolerance, cycles)
    model = CycleModel.of(rig)
    state = start if isinstance(start, PlatformState) else model.virgin(vector("start", start, model.table.stiffness.size))
    march = steady_cycle(model, motion.samples(steps), marching, state)
    return _labelled(rig, motion, model, march, marching)


def _marching(method: Method | None, frequency: float | None, tolerance: float, cycles: int) -> Marching:
    if (method is None) != (frequency is None):
        rule = "must go with a method in time, and a method with a frequency"
        raise fault("frequency", rule, frequency, "A quasi-static cycle needs neither.")
    if cycles < 1:
        raise fault("cycles", "must be at least 1", cycles)
    return Marching(
        positive("tolerance", tolerance), cycles, method, 0.0 if frequency is None else positive("frequency", frequency)
    )


def _labelled(
    rig: BetweenPlatforms, motion: PlatformMotion, model: CycleModel, march: SteadyCycle, marching: Marching
) -> DamperCycle:
    cause = jamming(rig)
    if cause and (march.outcome == CycleOutcome.NOT_CONVERGED or _held(model, march)):
        march = replace(march, outcome=CycleOutcome.JAMMED)
    return DamperCycle(cycle_dataset(rig, model, march, marching, _sentence(march, cause)), rig, motion, march)


def _held(model: CycleModel, march: SteadyCycle) -> bool:
    """Whether there is no sample at which every closed contact slips: the damper never slides out."""
    return bool(np.all(np.any(contact_states(model, march) == STICK, axis=1)))


def _sentence(march: SteadyCycle, cause: str) -> str:
    words = {
        CycleOutcome.STEADY: f"The cycle repeats after {march.cycles} cycles.",
        CycleOutcome.NOT_STEADY: f"The forces still change by {march.change:.1e} of the largest after {march.cycles} cycles.",
        CycleOutcome.JAMMED: f"The damper is jammed: {cause}",
        CycleOutcome.NOT_CONVERGED: f"Newton's method failed in cycle {march.cycles}; more steps a cycle may help.",
    }
    return words[march.outcome]


@dataclass(frozen=True, eq=False)
class CycleWork:
    """One steady cycle as work of a study: what `damper_cycle` takes, and its march as plain arrays."""

    rig: BetweenPlatforms
    motion: PlatformMotion
    steps: int = 1000
    method: Method | None = None
    frequency: float | None = None
    tolerance: float = 1e-9
    most: int = 100

    @property
    def names(self) -> Sequence[str]:
        return ("cycle",)

    @property
    def words(self) -> Sequence[str]:
        return (self.rig.title,)

    def prepare(self) -> None:
        """One case needs no preparation."""

    def solve(self, case: int, tell: Tell) -> Arrays:
        """The march of the cycle."""
        march = damper_cycle(
            self.rig,
            self.motion,
            steps=self.steps,
            method=self.method,
            frequency=self.frequency,
            tolerance=self.tolerance,
            cycles=self.most,
        ).march
        end = np.array([march.cycles, march.outcome, march.change])
        return {
            "end": end,
            "drive": march.drive,
            **march.record._asdict(),
            **{f"state_{k}": v for k, v in march.state._asdict().items()},
        }

    def gathered(self, arrays: Arrays) -> DamperCycle:
        """The cycle from its arrays."""
        record = Record(*(np.asarray(arrays[name]) for name in Record._fields))
        state = PlatformState(*(np.asarray(arrays[f"state_{name}"]) for name in PlatformState._fields))
        cycles, outcome, change = arrays["end"]
        march = SteadyCycle(record, arrays["drive"], state, int(cycles), CycleOutcome(int(outcome)), float(change))
        marching = _marching(self.method, self.frequency, self.tolerance, self.most)
        return _labelled(self.rig, self.motion, CycleModel.of(self.rig), march, marching)


@dataclass(frozen=True, eq=False)
class SteadyCycles:
    """The distinct steady cycles that were found, the most frequent first, and how many of the starts led to each; starts that
    led to none: `failed`."""

    cycles: tuple[DamperCycle, ...]
    counts: tuple[int, ...]
    failed: int


def steady_cycles(
    rig: BetweenPlatforms,
    motion: PlatformMotion,
    *,
    starts: int = 20,
    spread: float | None = None,
    seed: int = 0,
    same: float = 1e-6,
    steps: int = 1000,
) -> SteadyCycles:
    """Steady quasi-static cycles from the virgin and from seeded random slider offsets, uniform in ±spread [m].

    spread: twice the pull over the softest tangential stiffness unless given. Cycles whose contact forces differ by less than
    `same` of the largest count as one.
    """
    model, generator = CycleModel.of(rig), np.random.default_rng(seed)
    elements = model.table.stiffness.size
    width = 2.0 * float(np.hypot(*model.load[:2]) / model.table.stiffness.min()) if spread is None else positive("spread", spread)
    offsets = np.vstack([np.zeros(elements), generator.uniform(-width, width, (max(starts - 1, 0), elements))])
    found: list[DamperCycle] = []
    counts: list[int] = []
    failed = 0
    for offset in offsets:
        cycle = damper_cycle(rig, motion, start=offset, steps=steps)
        if cycle.outcome not in (CycleOutcome.STEADY, CycleOutcome.JAMMED):
            failed += 1
            continue
        match = next((i for i, other in enumerate(found) if _difference(cycle, other) <= same), None)
        if match is None:
            found.append(cycle)
            counts.append(1)
        else:
            counts[match] += 1
    order = sorted(range(len(found)), key=lambda i: -counts[i])
    return SteadyCycles(tuple(found[i] for i in order), tuple(counts[i] for i in order), failed)


def _difference(a: DamperCycle, b: DamperCycle) -> float:
    """Largest difference of contact forces relative to the largest force."""
    one, other = a.march.record.force, b.march.record.force
    return float(np.max(np.abs(one - other)) / np.max(np.abs(one)))


def damper_evolution(
    rig: BetweenPlatforms, motion: PlatformMotion, friction: Sequence[ArrayLike], *, steps: int = 1000, cycles: int = 1
) -> tuple[DamperCycle, ...]:
    """Cycles while friction changes: for each set of coefficients (a number, or one per line of contact) the last of so many
    cycles, which starts from the state that the set before left."""
    found: list[DamperCycle] = []
    for mu in friction:
        start: PlatformState | float = found[-1].state if found else 0.0
        found.append(damper_cycle(rig.with_friction(mu), motion, start=start, steps=steps, cycles=cycles))
    return tuple(found)


def cycle_forces(model: CycleModel, platform: Array, marching: Marching = QUASI_STATIC) -> tuple[Array, SteadyCycle]:
    """H, V on the right platform (steps, 2) [N] and the march, without labels: the quick way for fits.

    model: `CycleModel.of(rig)`, changed with `with_parameters`; platform: `motion.samples(steps)`.
    """
    march = steady_cycle(model, platform, marching)
    return -march.record.force @ model.right, march
