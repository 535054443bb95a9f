"""Stress at the places of a `StressRecovery`: over one period at a solved point, and along response curves.

Fatigue margin along response curves: the stress amplitude that a material stands over that of the vibration.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from stickslip.analyses.solved_points import SolvedPoints
from stickslip.model.disks.tuned import FullDisk, TunedDisk
from stickslip.model.problem import Problem
from stickslip.model.structure.stress import (
    COMPONENTS,
    FatigueLimit,
    StressRecovery,
    critical_plane,
    joined,
    principal_size,
    von_mises,
)
from stickslip.results.schema import described, named
from stickslip.results.view import inside_band
from stickslip.solve.balance.balance import HarmonicBalance, Point
from stickslip.solve.balance.fourier import complex_harmonics, real_harmonics
from stickslip.solve.balance.linear_response import WithoutContacts
from stickslip.support.checks import Array, InputError, among, fault, finite, nearest
from stickslip.support.late import xr
from stickslip.support.outcome import Outcome

SIZES = ("stress_von_mises", "stress_alternating", "stress_principal", "stress_principal_mean")
"""Sizes of the stress at a place over a period, as `with_stress` explains them."""
TURNS = 256
"""Instants of a period of a vibration of one harmonic."""


def stress(dataset: xr.Dataset, problem: Problem, case: int, point: int, recovery: StressRecovery) -> xr.Dataset:
    """`stress` (place, component, harmonic, part), `amplitude` of the first harmonic (place, component), `largest` (place,
    component) in size over the period, and `von_mises` (place), its largest over the period; all with the mean, Pa.

    problem, recovery: on the coordinates of the result (`on_its_coordinates`).
    """
    here, points = degrees_of_freedom(problem, recovery), SolvedPoints(dataset, problem)
    harmonics = stress_harmonics(problem, recovery, points.whole_motion(case, point)[here])
    over_time = np.einsum("pch,nh->pnc", harmonics, points.balance.tables.E)
    complex_stress = complex_harmonics(harmonics)
    pascals = {"units": "Pa"}
    sizes = ("place", "component")
    return xr.Dataset(
        {
            "stress": ((*sizes, "harmonic", "part"), np.stack([complex_stress.real, complex_stress.imag], axis=-1), pascals),
            "amplitude": (sizes, np.abs(complex_stress[..., 1]), pascals),
            "largest": (sizes, np.abs(over_time).max(axis=1), pascals),
            "von_mises": (("place",), von_mises(over_time).max(axis=1), pascals),
        },
        coords={
            "place": list(recovery.places),
            "component": list(COMPONENTS),
            "harmonic": np.arange(complex_stress.shape[2]),
            "part": ["re", "im"],
        },
        attrs={
            "frequency": float(dataset["frequency"].values[case, point]),
            "force_level": float(dataset["force_level"].values[case]),
        },
    )


def with_stress(dataset: xr.Dataset, problem: Problem, recovery: StressRecovery) -> xr.Dataset:
    """A forced response with the stress at every converged point of every curve, Pa.

    `stress_von_mises` (case, point, place), its largest over the period, with the mean; `stress_alternating`, the same without
    the mean; `stress_amplitude` and `stress_mean` (case, point, place, component), first harmonic and mean of each component;
    `stress_principal` and `stress_principal_mean`, amplitude and mean of the normal stress on the `critical_plane`.
    `stress_without_contacts` and `frequency_without_contacts` (place): the largest `stress_alternating` of the structure without
    contacts per unit force level, at its natural frequencies in the band, and that frequency, Hz; NaN if there are none.
    `principal_without_contacts`: its largest principal stress there.
    With strain gauges `strain_amplitude` (case, point, gauge): half the peak-to-peak strain over the period, with all harmonics.

    problem, recovery: on the coordinates of the result (`on_its_coordinates`).
    """
    here, points = degrees_of_freedom(problem, recovery), SolvedPoints(dataset, problem)
    sizes = (*dataset["outcome"].shape, len(recovery.places))
    largest, alternating = np.full((2, *sizes), np.nan)
    principal = np.full((*sizes, 2), np.nan)
    amplitude, mean = np.full((2, *sizes, len(COMPONENTS)), np.nan)
    gauges = [recovery.places.index(name) for name in recovery.gauges]
    measured, strains = np.array(list(recovery.gauges.values())), np.full((*sizes[:2], len(gauges)), np.nan)
    for case, point in np.argwhere(dataset["outcome"].values == Outcome.CONVERGED):
        harmonics = stress_harmonics(problem, recovery, points.whole_motion(case, point)[here])
        over_time, still = np.einsum("pch,nh->pnc", harmonics, points.balance.tables.E), harmonics[..., 0]
        largest[case, point], alternating[case, point], *planes = _sizes(over_time, still)
        principal[case, point] = np.stack(planes, axis=1)
        if gauges:
            strains[case, point] = 0.5 * np.ptp(np.einsum("gnc,gc->gn", over_time[gauges], measured), axis=1)
        amplitude[case, point], mean[case, point] = np.hypot(harmonics[..., 1], harmonics[..., 2]), still
    free, free_principal, where = _without_contacts(dataset, points, recovery, here)
    if gauges:
        dataset = dataset.assign(described("stress", {"strain_amplitude": strains, "gauge": list(recovery.gauges)}))
    found = {
        "stress_von_mises": largest,
        "stress_alternating": alternating,
        "stress_amplitude": amplitude,
        "stress_mean": mean,
        "stress_principal": principal[..., 0],
        "stress_principal_mean": principal[..., 1],
        "principal_without_contacts": free_principal,
        "stress_without_contacts": free,
        "frequency_without_contacts": where,
        "place": list(recovery.places),
        "component": list(COMPONENTS),
    }
    return dataset.assign(described("stress", found))


def _without_contacts(
    dataset: xr.Dataset, points: SolvedPoints, recovery: StressRecovery, here: list[int]
) -> tuple[Array, Array, Array]:
    """The largest von Mises stress of the first harmonic without contacts per unit force level, the largest principal stress
    there, and the frequency [Hz]."""
    largest, principal, where = np.full((3, len(recovery.places)), np.nan)
    if "linear_frequency" not in dataset or points.balance.periods > 1 or not points.problem.damped:
        return largest, principal, where  # without damping the resonance has no height
    low, high = dataset["linear_frequency"].values[[0, -1]]
    alone = WithoutContacts.of(points.balance)
    problem = points.problem
    rows = recovery.at(problem.engine_order) if isinstance(problem, TunedDisk) else recovery.rows
    turns = np.exp(2j * np.pi * np.arange(TURNS) / TURNS)
    for hertz in dataset["natural_frequency_free"].values:
        if low <= hertz <= high:
            vibration: Any = alone.motion(2.0 * np.pi * hertz)
            stress = np.asarray(rows @ problem.structure.motion(vibration)[here])
            over_time = (stress[:, None] * turns[:, None]).real
            size = von_mises(over_time).max(axis=1)
            larger = np.isfinite(size) & ~(size <= largest)
            largest[larger], where[larger] = size[larger], hertz
            principal[larger] = principal_size(over_time[larger]).max(axis=1)
    return largest, principal, where


def stress_harmonics(problem: Problem, recovery: StressRecovery, q: Array) -> Array:
    """Stress (places, 6, 2H+1) [Pa] of the motion q (dofs, 2H+1) [m], both in real storage.

    Of a tuned disk, whose harmonic h travels at nodal diameter h EO: in the first sector. All others have the same later. The
    mean contains the stress of the rotation where it is known.
    """
    if isinstance(problem, TunedDisk):
        motion = complex_harmonics(q)
        waves = [recovery.at(h * problem.engine_order) @ motion[:, h] for h in range(motion.shape[1])]
        found = real_harmonics(np.stack(waves, axis=-1))
    else:
        found = np.asarray(recovery.rows @ q)
    if recovery.rotation is not None:
        found[..., 0] += recovery.rotation
    return found


def own_recovery(problem: Problem) -> StressRecovery | None:
    """The recovery at the places that the models of a problem name, of a full disk "SECTOR/PLACE"; None without any."""
    if isinstance(problem, FullDisk):
        return joined(problem.stresses).of_whole_disk() if problem.stresses else None
    return joined(problem.structure.stresses) if problem.structure.stresses else None


def sector_stresses(balance: HarmonicBalance, points: Sequence[Point]) -> Array:
    """Stress at the places of a sector, at one point of each sector, (sectors, places, `SIZES` and the mean of each component)
    [Pa]; of a tuned disk of its first sector."""
    problem = balance.problem
    given = problem.stresses if isinstance(problem, FullDisk) else problem.structure.stresses
    if not given:
        return np.zeros((len(points), 0, len(SIZES) + len(COMPONENTS)))
    recovery, found = joined(given), []
    for sector, point in enumerate(points, start=1):
        own = recovery.of_whole_disk([sector]) if isinstance(problem, FullDisk) else recovery
        y = balance.linear.whole_motion(point.forces, point.omega, point.level)
        motion = problem.structure.motion(y)[degrees_of_freedom(problem, own)]
        harmonics = stress_harmonics(problem, own, motion)
        over_time = np.einsum("pch,nh->pnc", harmonics, balance.tables.E)
        found.append(np.column_stack([*_sizes(over_time, harmonics[..., 0]), harmonics[..., 0]]))
    return np.array(found)


def _sizes(over_time: Array, still: Array) -> Array:
    """`SIZES` (4, places) of the stress over a period (places, instants, 6) with the mean (places, 6)."""
    vibration = over_time - still[:, None]
    planes = np.array([critical_plane(*each) for each in zip(vibration, still, strict=True)])
    return np.array([von_mises(over_time).max(axis=1), von_mises(vibration).max(axis=1), *planes.T])


def has_gauges(dataset: xr.Dataset) -> bool:
    """Whether a result holds the strain at gauges along its curves."""
    return "strain_amplitude" in dataset.variables


def has_stress(dataset: xr.Dataset) -> bool:
    """Whether a result holds the stress along its curves."""
    return "stress_von_mises" in dataset.variables


def degrees_of_freedom(problem: Problem, recovery: StressRecovery) -> list[int]:
    """Rows of a problem's motion that a recovery goes by."""
    missing = [dof for dof in recovery.dofs if dof not in problem.structure.dofs]
    if missing:
        raise fault("The stress recovery", "must be of a body of this problem", missing[:3], "Give it the body's prefix.")
    return [problem.structure.index(dof) for dof in recovery.dofs]


NORMAL = ("xx", "yy", "zz")

DRAWN = 61
"""Points of the line of the limit that a figure is drawn from."""


Equivalent = Literal["sines", "von_mises", "principal"]
EQUIVALENTS = {
    "sines": "The amplitude is the largest von Mises stress of the vibration, and the mean is the sum of the mean normal "
    "stresses (Sines)",
    "von_mises": "The amplitude is the largest von Mises stress of the vibration, and the mean is the von Mises stress of the "
    "mean stresses, negative in compression",
    "principal": "Amplitude and mean are those of the normal stress on the plane where its amplitude is largest",
}
"""Of each equivalent stress in tension, how it is made."""


def with_fatigue(
    dataset: xr.Dataset, limit: FatigueLimit, mean: Mapping[str, float] | None = None, equivalent: Equivalent = "sines"
) -> xr.Dataset:
    """A response with stress (`with_stress`), or blades of mistuned disks with theirs, and the fatigue margin.

    equivalent: the stress in tension that replaces a stress of several components.

    "sines": amplitude σ_a, the largest von Mises stress of the vibration over the period (`stress_alternating`); mean σ_m, the
    sum of the mean normal stresses. Source: G. Sines (1959), see `FatigueLimit`.
    "von_mises": the same σ_a; σ_m, the von Mises stress of the mean stresses with the sign of their sum of normal stresses.
    Source: R. G. Budynas and J. K. Nisbett, Shigley's Mechanical Engineering Design, chapter 6 (combinations of loading modes).
    "principal": σ_a and σ_m of the normal stress on the plane where its amplitude is largest
    (`stress_principal`, `stress_principal_mean`), for brittle materials. Source: see `critical_plane`.

    In tension all three equal the stress itself. `fatigue_amplitude` (case, point, place): σ_a [Pa]; `fatigue_mean`: σ_m;
    `fatigue_limit`: the amplitude that the material withstands at this mean. The margin `fatigue_limit` / `fatigue_amplitude` is
    the factor by which the vibration may grow at the same mean stress.
    mean: stress that the response does not contain, such as that due to rotation, in Pa by place or by the name of a set of
    places; it is added to σ_m.
    """
    among("equivalent", equivalent, EQUIVALENTS)
    if not has_stress(dataset):
        raise InputError("A fatigue margin needs stress along the curves: take it of `response.with_stress()`.")
    places = [str(place) for place in dataset["place"].values]
    added = np.zeros(len(places))
    for name, size in (mean or {}).items():
        here = [k for k, place in enumerate(places) if place == name or place.startswith(f"{name}/")]
        if not here:
            raise fault("mean", "must name places of stress", name, nearest(name, places))
        added[here] = finite(f"mean of {name}", size)
    amplitude, sizes = _in_tension(dataset, equivalent)
    sizes = sizes + added
    allowed = np.where(np.isfinite(sizes), limit.amplitude(np.nan_to_num(sizes)), np.nan)
    dims = dataset["stress_alternating"].dims
    drawn = np.linspace(min(0.0, float(np.nanmin(sizes, initial=0.0))), limit.largest_mean, DRAWN)
    return dataset.assign(
        fatigue_amplitude=named(dims, amplitude, "equivalent stress amplitude", "Pa"),
        fatigue_mean=named(dims, sizes, "equivalent mean stress", "Pa"),
        fatigue_limit=named(dims, allowed, "stress amplitude that the material stands", "Pa"),
        haigh_mean=named("haigh", drawn, "mean stress of the Haigh diagram", "Pa"),
        haigh_limit=named("haigh", limit.amplitude(drawn), "stress amplitude of the Haigh diagram", "Pa"),
    ).assign_attrs(fatigue_criterion=limit.words, fatigue_equivalent=equivalent)


def _in_tension(dataset: xr.Dataset, equivalent: Equivalent) -> tuple[Array, Array]:
    """Amplitude and mean of the equivalent stress, at each place, Pa."""
    if equivalent == "principal":
        if "stress_principal" not in dataset:
            raise InputError("The response of an older version has no principal stresses. Compute its stress again.")
        return dataset["stress_principal"].values, dataset["stress_principal_mean"].values
    tension = dataset["stress_mean"].sel(component=list(NORMAL)).values.sum(axis=-1)
    if equivalent == "von_mises":
        tension = np.where(tension < 0.0, -1.0, 1.0) * von_mises(dataset["stress_mean"].values)
    return dataset["stress_alternating"].values, tension


def has_fatigue(dataset: xr.Dataset) -> bool:
    """Whether a result holds fatigue margins."""
    return "fatigue_limit" in dataset.variables


class Margin(NamedTuple):
    """The smallest margin of one curve at one place: where, Hz; amplitude and mean of the stress, the amplitude that the material
    stands, and the amplitude at the resonance without contacts at the same force level, NaN where there is none, Pa."""

    case: int
    place: str
    point: int
    frequency: float
    alternating: float
    mean: float
    allowed: float
    without_contacts: float

    @property
    def size(self) -> float:
        """By how much the vibration may grow; infinite where nothing vibrates."""
        return self.allowed / self.alternating if self.alternating > 0.0 else np.inf

    @property
    def size_without_contacts(self) -> float:
        """The margin at the resonance without contacts, at the same mean stress; NaN where there is none."""
        return self.allowed / self.without_contacts if self.without_contacts > 0.0 else np.nan


def margins(dataset: xr.Dataset) -> Iterator[Margin]:
    """Of every curve and place where a point was solved, the smallest along the curve inside the band."""
    alternating = inside_band(dataset, "fatigue_amplitude" if "fatigue_amplitude" in dataset else "stress_alternating")
    allowed = dataset["fatigue_limit"].values
    none = np.full(dataset.sizes["place"], np.nan)  # in results of before
    by_plane = dataset.attrs.get("fatigue_equivalent") == "principal"
    free_stress = dataset.get("principal_without_contacts" if by_plane else "stress_without_contacts", none)
    free = np.outer(dataset["force_level"].values, free_stress)
    with np.errstate(divide="ignore", invalid="ignore"):
        size = np.where(alternating > 0.0, allowed / alternating, np.where(np.isfinite(alternating), np.inf, np.nan))
    for case in range(size.shape[0]):
        for k, place in enumerate(dataset["place"].values):
            if np.isfinite(alternating[case, :, k]).any():
                point = int(np.nanargmin(size[case, :, k]))
                found = alternating[case, point, k], dataset["fatigue_mean"].values[case, point, k], allowed[case, point, k]
                frequency = float(dataset["frequency"].values[case, point])
                yield Margin(case, str(place), point, frequency, *map(float, (*found, free[case, k])))


def smallest_margin(dataset: xr.Dataset) -> Margin | None:
    """The smallest of all curves and places; None without a point."""
    return min(margins(dataset), key=lambda margin: margin.size, default=None)


def smallest_margins(dataset: xr.Dataset) -> dict[int, Margin]:
    """The smallest of each curve, by its case; a curve without a point has none."""
    smallest: dict[int, Margin] = {}
    for margin in margins(dataset):
        smallest[margin.case] = min(smallest.get(margin.case, margin), margin, key=lambda each: each.size)
    return smallest
