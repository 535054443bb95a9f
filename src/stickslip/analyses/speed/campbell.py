"""Campbell diagram with friction: natural frequencies, stuck and free, and the nonlinear resonance over the rotor speed.

Interference diagram (SAFE, ZZENF) of a bladed disk: which modes the engine orders excite at one rotor speed, and how near.
"""

from collections.abc import Callable, Sequence
from dataclasses import KW_ONLY, dataclass
from functools import cache, cached_property, partial
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from stickslip.analyses.modes.nonlinear_modes import nonlinear_modes
from stickslip.analyses.modes.work import AMPLITUDES, ends_of, listed_modes
from stickslip.analyses.nodal_diameters import MODES, OF_DISK, nodal_diameters
from stickslip.analyses.settings import Execution, HarmonicNumbers, Samples, Setting, Whole, takes
from stickslip.analyses.speed.models import Models, ProblemAt, problem_at
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.problem import Problem
from stickslip.model.structure.modes import gyroscopic_modes, natural_modes
from stickslip.results.schema import Result, described, tabulated
from stickslip.runs.cases import Arrays, Report, all_cases
from stickslip.support.checks import MOST, Array, Index, InputError, between, fault, of_kind, positive, several, unique, vector
from stickslip.support.late import pd, xr

STATES = ("free", "stuck", "nonlinear")
LINEAR = STATES[:2]


@dataclass(frozen=True, eq=False, repr=False)
class Campbell(Result):
    """`dataset`: frequency (state, mode, engine_order, speed) [Hz], state free, stuck or nonlinear; amplitude (mode,
    engine_order, speed) of the first output at the nonlinear resonance [m]; crossing_speed [rev/min] and crossing_frequency [Hz]
    (state, mode, engine_order), the lowest in the range, NaN without one; margin, f/(EO Ω) − 1, and speed_margin,
    crossing_speed/Ω − 1, at the operating speed Ω (state, mode, engine_order); message (mode, engine_order, speed).

    With Coriolis forces whirl (state, mode, engine_order, speed): 1 for forward whirl, −1 for backward whirl, 0 if they have no
    effect. Frequencies are those in the rotating frame. For a tuned disk excited_diameter (engine_order).
    """

    dataset: "xr.Dataset"

    def table(self) -> "pd.DataFrame":
        """Crossings and margins, a row for each state, mode and engine order."""
        wanted = ("crossing_speed", "crossing_frequency", "margin", "speed_margin")
        return self.dataset[[name for name in wanted if name in self.dataset]].to_dataframe().reset_index()


def _models(name: str, models: Any) -> ProblemAt:
    return problem_at(models)


def _speeds(name: str, speed: Any) -> tuple[float, float]:
    low, high = vector(name, speed, 2).tolist()
    if not 0.0 <= low < high:
        raise fault(name, "must be (lowest, highest) in rev/min, not negative", speed)
    return low, high


def engine_orders_of(name: str, orders: Any) -> tuple[int, ...]:
    """Engine orders, checked: at least one, each once."""
    found = tuple(between(name, order, 1) for order in several(name, np.atleast_1d(orders).tolist()))
    unique(name, found)
    if not found:
        raise fault(name, "must hold at least one", "none")
    return found


@dataclass(frozen=True, eq=False)
class CampbellWork(Execution):
    """The arguments of `campbell`, and its curves as cases.

    Engine orders that excite the same nodal diameter share their cases; without a disk all do. The first case has the natural
    frequencies, and each other one the resonance of a mode at the force level.
    """

    models: Annotated[Models, Setting(_models)]
    speed: Annotated[tuple[float, float], Setting(_speeds)]
    engine_orders: Annotated[Sequence[int], Setting(engine_orders_of)]
    mode: Annotated[
        int | Sequence[int] | None,
        Setting(listed_modes, f"number of a mode, or a list, without rigid motions; default: the lowest {MODES}"),
    ] = None
    _: KW_ONLY
    force_level: Annotated[
        float | None, Setting(positive, "force level at which resonances with friction are computed; default: none")
    ] = None
    operating_speed: Annotated[float | None, Setting(positive, "rotor speed for which margins are stated, rev/min")] = None
    points: Annotated[int, Setting(Whole(2, MOST), "number of speeds of the curves, equally spaced")] = 11
    amplitude: Annotated[float | tuple[float, float] | None, Setting(ends_of, AMPLITUDES)] = None
    harmonics: HarmonicNumbers = 3
    samples: Samples = 256

    @property
    def speeds(self) -> list[float]:
        """Of the curves, then the operating speed, rev/min."""
        curves: list[float] = np.linspace(*self.speed, self.points).tolist()
        return curves if self.operating_speed is None else [*curves, self.operating_speed]

    def problem(self, speed: float, order: int) -> Problem:
        """The problem of a speed under an engine order."""
        assert isinstance(self.models, ProblemAt)
        found = self.models(speed)
        return found.with_engine_order(order % found.sectors) if isinstance(found, TunedDisk) else found

    @cached_property
    def first(self) -> Problem:
        """The problem at the lowest speed."""
        return self.problem(self.speed[0], self.engine_orders[0])

    @cached_property
    def modes(self) -> tuple[int, ...]:
        """The numbers of the modes, of those that there are at the lowest speed."""
        there = max(_natural(self.first, state == "stuck", self.speed[0])[0].size for state in LINEAR)
        modes = range(1, min(MODES, there) + 1) if self.mode is None else listed_modes("mode", self.mode)
        between("mode", max(modes), 1, there)
        return tuple(modes)

    @cached_property
    def places(self) -> list[tuple[tuple[int, ...], int]]:
        """Engine orders and mode of each case, mode 0 for the natural frequencies of all modes."""
        waves: dict[int, list[int]] = {}
        for order in self.engine_orders:
            waves.setdefault(order % self.first.sectors if isinstance(self.first, TunedDisk) else 0, []).append(order)
        modes = (0, *self.modes) if self.force_level is not None else (0,)
        return [(tuple(orders), mode) for orders in waves.values() for mode in modes]

    @property
    def words(self) -> list[str]:
        kinds = {0: "natural frequencies"} | {mode: f"resonance of mode {mode}" for mode in self.modes}
        return [f"{kinds[mode]}, engine order {', '.join(map(str, orders))}" for orders, mode in self.places]

    def prepare(self) -> None:
        """Refuse what the problem does not have."""
        _ = self.modes, self.problem(self.speed[1], self.engine_orders[0])

    def solve(self, case: int, report: Report) -> Arrays:
        """Frequency, whirl and amplitude (3, curve, speed), and where the engine orders meet the curves (curve, order)."""
        orders, mode = self.places[case]
        solved = cache(partial(self._resonance, orders[0], mode) if mode else partial(self._natural_modes, orders[0]))
        assert isinstance(self.models, ProblemAt)
        moves = mode or self.models.stiffens

        def at(speed: float) -> tuple[Array, str]:
            return solved(speed if moves else self.speed[0])

        def frequency(curve: int, speed: float) -> float:
            return float(at(speed)[0][0, curve])

        found: list[tuple[Array, str]] = []
        for speed in self.speeds:
            report(0.5 * len(found) / len(self.speeds))
            found.append(at(speed))
        values = np.stack([each for each, _ in found], axis=-1)
        crossings = np.full((values.shape[1], len(orders)), np.nan)
        for done, (curve, k) in enumerate(np.ndindex(crossings.shape)):
            report(0.5 + 0.5 * done / crossings.size)
            crossings[curve, k] = _crossing(partial(frequency, curve), orders[k], self.speeds[: self.points])
        return {"values": values, "crossing": crossings, "message": np.array([message for _, message in found], dtype=np.str_)}

    def _natural_modes(self, order: int, speed: float) -> tuple[Array, str]:
        """The modes without contacts, then the stuck ones; NaN of modes that a state does not have."""
        problem, numbers = self.problem(speed, order), np.array(self.modes) - 1
        found = np.full((3, len(LINEAR), numbers.size), np.nan)
        for s, state in enumerate(LINEAR):
            both = np.array(_natural(problem, state == "stuck", speed))
            there = numbers < both.shape[1]
            found[:2, s, there] = both[:, numbers[there]]
        return found.reshape(3, -1), ""

    def _resonance(self, order: int, mode: int, speed: float) -> tuple[Array, str]:
        """The resonance of a mode with friction, and what is to be known of it."""
        settings: dict[str, Any] = {"amplitude": self.amplitude, "harmonics": self.harmonics, "samples": self.samples}
        try:
            peaks = nonlinear_modes(self.problem(speed, order), mode, **settings).peaks([self.force_level or 0.0])
        except InputError as reason:
            return np.full((3, 1), np.nan), str(reason)
        solved = "solved_" if np.isfinite(peaks["solved_amplitude"][0]) else ""
        found = [peaks[f"{solved}frequency"][0], np.nan, peaks[f"{solved}amplitude"][0]]
        return np.reshape(found, (3, 1)), "" if solved else UNSOLVED

    def gathered(self, results: Sequence[Arrays]) -> Campbell:
        """The diagram."""
        shape = len(STATES), len(self.modes), len(self.engine_orders)
        values, crossing = np.full((3, *shape, len(self.speeds)), np.nan), np.full(shape, np.nan)
        message = np.full((*shape[1:], self.points), "", dtype=object)
        for (orders, mode), arrays in zip(self.places, results, strict=True):
            for k, order in enumerate(orders):
                m, o = self.modes.index(mode) if mode else 0, self.engine_orders.index(order)
                curves = (2, slice(m, m + 1), o) if mode else (slice(0, 2), slice(None), o)
                values[:, *curves] = arrays["values"].reshape(values[:, *curves].shape)
                crossing[curves] = arrays["crossing"][:, k].reshape(crossing[curves].shape)
                if mode:
                    message[m, o] = arrays["message"][: self.points]
        return Campbell(self._dataset(values, crossing, message))

    def _dataset(self, values: Array, crossing: Array, message: NDArray[Any]) -> "xr.Dataset":
        orders, (frequency, whirls, amplitude) = np.array(self.engine_orders), values[..., : self.points]
        found = {"frequency": frequency, "amplitude": amplitude[2], "message": message.astype(np.str_)}
        found |= {"crossing_speed": crossing, "crossing_frequency": orders * crossing / 60.0}
        found |= {"whirl": whirls} if np.isfinite(whirls).any() else {}
        attrs: dict[str, Any] = {"title": self.first.title, "harmonics": str(self.harmonics), "samples": self.samples}
        attrs |= {} if self.force_level is None else {"force_level": self.force_level}
        if (operating := self.operating_speed) is not None:
            there = values[0, ..., -1]
            found |= {"operating_frequency": there, "margin": there / (orders * operating / 60.0) - 1.0}
            found |= {"speed_margin": crossing / operating - 1.0}
            attrs["operating_speed"] = operating
        coords = {"state": list(STATES), "mode": list(self.modes), "engine_order": orders, "speed": self.speeds[: self.points]}
        dataset = tabulated("campbell", found, coords, attrs)
        if not isinstance(self.first, TunedDisk):
            return dataset
        if operating is None or not self.first.disk.diameters.complete:
            excited = _excited_diameters(orders, self.first.sectors)
            return dataset.assign(described(OF_DISK, {"excited_diameter": excited}))
        diagram = interference_diagram(self.models, operating, self.engine_orders).dataset
        return dataset.assign(diagram.variables).assign_attrs(sectors=self.first.sectors)


def _excited_diameters(orders: Index, sectors: int) -> Index:
    """The nodal diameter that each engine order excites."""
    return np.asarray(np.minimum(orders % sectors, -orders % sectors))


UNSOLVED = "By the mode alone: no forced motion was found at this peak."


@takes(CampbellWork)
def campbell(settings: CampbellWork) -> Campbell:
    """Natural frequencies over the rotor speed with engine-order lines EO Ω, where they cross, and margins at a speed.

    models: {speed in rev/min: problem} at two speeds or more, K(Ω) = K₀ + Ω² K₁ between them and static loads likewise; or a
    function of the speed. Coriolis forces are proportional to Ω. speed: (lowest, highest), rev/min. mode: numbers of modes from 1
    on, with stuck contacts and without contacts, rigid motions omitted; default: the lowest six; for a `TunedDisk` at the nodal
    diameter of each engine order. force_level: adds the resonance peak at that level and its amplitude, found along the nonlinear
    mode (amplitude, harmonics and samples: as for `nonlinear_modes`) and solved as a forced motion. operating_speed: for margins,
    rev/min. points: number of speeds of the curves. Crossings are solved at their own speed, not interpolated. workers,
    checkpoint, progress: as for `forced_response`.
    """
    settings.prepare()
    return settings.gathered(all_cases(settings, settings.checkpoint, settings.workers, settings.progress))


def _natural(problem: Problem, stuck: bool, speed: float) -> tuple[Array, Array]:
    """Natural frequencies in Hz, rigid motions left out, and the whirl of each mode, NaN without Coriolis forces."""
    skew = problem.structure.coriolis
    if skew is None:
        frequencies = problem.frequencies(stuck=stuck)
        moving = frequencies[frequencies > 0.0]
        return moving, np.full(moving.size, np.nan)
    M, K = problem.structure.M, problem.stuck_stiffness if stuck else problem.structure.K
    modes = gyroscopic_modes(natural_modes(M, K), skew)
    elastic = modes.frequencies > np.finfo(float).eps * modes.squares.size * modes.frequencies[-1]  # less is rounding of zero
    return modes.frequencies[elastic], whirl(modes.shapes[:, elastic], M, skew, 2.0 * np.pi * speed / 60.0)


def whirl(shapes: NDArray[Any], M: Array, skew: Array, rate: float) -> Array:
    """How a motion Re(φ exp iωt) circles about the axis at a rotor speed Ω in rad/s, (modes,): −iφᴴGφ / (2Ω φᴴMφ), −1 to 1.

    Where M q̈ + G q̇ + K q = 0, ω² φᴴMφ − ω iφᴴGφ = φᴴKφ: in the rotating frame, Coriolis forces lower the frequency of what
    circles with the rotation and raise that of what circles against it.
    """
    circling = np.einsum("ik,ij,jk->k", shapes.conj(), -1j * skew, shapes).real
    energy = np.einsum("ik,ij,jk->k", shapes.conj(), M, shapes).real
    return np.asarray(circling / (2.0 * rate * energy) if rate else 0.0 * energy)


def _crossing(at: Callable[[float], float], order: int, speeds: Sequence[float]) -> float:
    """Speed in rev/min of the first crossing with the line of an engine order, NaN without one."""

    def miss(speed: float) -> float:
        return at(speed) - order * speed / 60.0

    misses = np.array([miss(speed) for speed in speeds])
    for k in np.flatnonzero(misses[:-1] * misses[1:] <= 0.0).tolist():
        return float(brentq(miss, speeds[k], speeds[k + 1], rtol=1e-9))
    return np.nan


WAVES = ("standing", "backward", "forward")
"""How the wave that a pattern at rest excites travels in the disk: neither way (0 and N/2), against the rotation, or with it."""


@dataclass(frozen=True, eq=False, repr=False)
class InterferenceDiagram(Result):
    """`dataset`: disk_frequency (disk_state, nodal_diameter, disk_mode) [Hz]; of each engine order excited_diameter, wave and
    excitation_frequency EO Ω [Hz]; mode of the nearest frequency at that diameter and its margin f/(EO Ω) − 1, nearest_mode and
    disk_margin (disk_state, engine_order)."""

    dataset: "xr.Dataset"

    def table(self) -> "pd.DataFrame":
        """Nearest modes and margins, a row for each engine order and state."""
        names = ["excited_diameter", "wave", "excitation_frequency", "nearest_mode", "disk_margin"]
        return self.dataset[names].to_dataframe().reset_index()


def interference_diagram(
    disk: TunedDisk | Models | ProblemAt, speed: float, engine_orders: Sequence[int] | None = None, modes: int = 6
) -> InterferenceDiagram:
    """Natural frequencies over the nodal diameter, and the engine orders that excite them at a rotor speed.

    Of N sectors, engine order EO excites nodal diameter EO mod N, or N less that where it is above N/2, with frequency EO Ω. A
    mode is in resonance if the line of frequency over diameter, folded at 0 and N/2, passes through it. The pattern is fixed in
    space; its wave travels backward in the disk, forward where the diameter is folded.
    disk: a tuned disk, or its models by speed as `campbell` takes them. speed: rev/min. engine_orders: default 1 to N. modes:
    number for each nodal diameter; rigid motions of free dampers are omitted. Coriolis terms are neglected.
    """
    positive("speed", speed)
    problem = disk if isinstance(disk, TunedDisk) else problem_at(disk)(speed)
    of_kind("disk", problem, TunedDisk)
    assert isinstance(problem, TunedDisk)
    given = range(1, problem.sectors + 1) if engine_orders is None else several("engine_orders", engine_orders)
    orders = np.array(engine_orders_of("engine_orders", given))
    diagram, sectors = nodal_diameters(problem, modes).dataset, problem.sectors
    diameters, excitation = _excited_diameters(orders, sectors), orders * speed / 60.0
    # Where a diameter has fewer modes than others, NaN stands in their place.
    off = diagram["disk_frequency"].values[:, diameters] / excitation[:, None] - 1.0
    nearest = np.argmin(np.where(np.isfinite(off), np.abs(off), np.inf), axis=2)
    folded = orders % sectors
    kinds = np.where(2 * folded < sectors, 1, 2)
    kinds[(folded == 0) | (2 * folded == sectors)] = 0
    found: dict[str, Any] = {"excited_diameter": diameters, "wave": np.asarray(WAVES)[kinds], "excitation_frequency": excitation}
    found |= {"nearest_mode": nearest + 1, "disk_margin": np.take_along_axis(off, nearest[..., None], axis=2)[..., 0]}
    both = diagram.assign(described(OF_DISK, found)).assign_coords(described(OF_DISK, {"engine_order": orders}))
    return InterferenceDiagram(both.assign_attrs(speed=float(speed)))
