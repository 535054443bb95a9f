"""Stress at the places of a `StressRecovery`: over one period at a solved point, and along response curves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stickslip.analyses.solved_points import SolvedPoints
from stickslip.model.disks.full import FullDisk
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.problem import Problem
from stickslip.model.structure.stress import COMPONENTS, StressRecovery, critical_plane, joined, principal_size, von_mises
from stickslip.solve.balance.balance import HarmonicBalance, Point
from stickslip.solve.balance.fourier import complex_harmonics, real_harmonics
from stickslip.solve.balance.without_contacts import WithoutContacts
from stickslip.support.checks import Array, fault
from stickslip.support.late import xr
from stickslip.support.outcome import Outcome

SIZES = ("stress_von_mises", "stress_alternating", "stress_principal", "stress_principal_mean")
"""Sizes of the stress at a place over a period, as `with_stress` explains them."""
TURNS = 256
"""Instants of a period of a vibration of one harmonic."""


def stress(dataset: xr.Dataset, problem: Problem, case: int, point: int, recovery: StressRecovery) -> xr.Dataset:
    """`stress` (place, component, harmonic, part), `amplitude` of the first harmonic (place, component), `largest` (place,
    component) in size over the period, and `von_mises` (place), its largest over the period; all with the mean, Pa."""
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
        over_time = np.einsum("pch,nh->pnc", harmonics, points.balance.tables.E)
        largest[case, point] = von_mises(over_time).max(axis=1)
        vibration, still = over_time - harmonics[:, None, :, 0], harmonics[..., 0]
        alternating[case, point] = von_mises(vibration).max(axis=1)
        principal[case, point] = [critical_plane(*each) for each in zip(vibration, still, strict=True)]
        if gauges:
            strains[case, point] = 0.5 * np.ptp(np.einsum("gnc,gc->gn", over_time[gauges], measured), axis=1)
        amplitude[case, point], mean[case, point] = np.hypot(harmonics[..., 1], harmonics[..., 2]), still
    dims = ("case", "point", "place")
    free, free_principal, where = _without_contacts(dataset, points, recovery, here)
    if gauges:
        about = {"units": "1", "long_name": "amplitude of the strain at the gauge"}
        dataset = dataset.assign(strain_amplitude=(("case", "point", "gauge"), strains, about)).assign_coords(
            gauge=("gauge", list(recovery.gauges), {"units": "1", "long_name": "strain gauge"})
        )
    return dataset.assign(
        stress_von_mises=(dims, largest, {"units": "Pa", "long_name": "largest von Mises stress over the period, with the mean"}),
        stress_alternating=(dims, alternating, {"units": "Pa", "long_name": "largest von Mises stress of the vibration"}),
        stress_amplitude=((*dims, "component"), amplitude, {"units": "Pa", "long_name": "first harmonic of the stress"}),
        stress_mean=((*dims, "component"), mean, {"units": "Pa", "long_name": "mean stress"}),
        stress_principal=(dims, principal[..., 0], {"units": "Pa", "long_name": "amplitude of the largest principal stress"}),
        stress_principal_mean=(dims, principal[..., 1], {"units": "Pa", "long_name": "mean stress along the principal axis"}),
        principal_without_contacts=(
            ("place",),
            free_principal,
            {"units": "Pa", "long_name": "principal stress without contacts"},
        ),
        stress_without_contacts=(("place",), free, {"units": "Pa", "long_name": "alternating stress without contacts"}),
        frequency_without_contacts=(("place",), where, {"units": "Hz", "long_name": "resonance of the stress without contacts"}),
    ).assign_coords(
        place=("place", list(recovery.places), {"units": "1", "long_name": "place of stress"}),
        component=("component", list(COMPONENTS), {"units": "1", "long_name": "component of stress in the axes of the body"}),
    )


def _without_contacts(
    dataset: xr.Dataset, points: SolvedPoints, recovery: StressRecovery, here: list[int]
) -> tuple[Array, Array, Array]:
    """The largest von Mises stress of the first harmonic without contacts per unit force level, the largest principal stress
    there, and the frequency [Hz]."""
    largest, principal, where = np.full((3, len(recovery.places)), np.nan)
    if "linear_frequency" not in dataset or points.balance.periods > 1 or not points.problem.C.any():
        return largest, principal, where  # without damping the resonance has no height
    low, high = dataset["linear_frequency"].values[[0, -1]]
    alone = WithoutContacts.of(points.balance)
    problem = points.problem
    rows = recovery.at(problem.engine_order) if isinstance(problem, TunedDisk) else recovery.rows
    turns = np.exp(2j * np.pi * np.arange(TURNS) / TURNS)
    for hertz in dataset["natural_frequency_free"].values:
        if low <= hertz <= high:
            stress = rows @ alone.motion(2.0 * np.pi * hertz)[here]
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
        still = harmonics[..., 0]
        vibration = over_time - still[:, None, :]
        planes = np.array([critical_plane(*each) for each in zip(vibration, still, strict=True)])
        sizes = von_mises(over_time).max(axis=1), von_mises(vibration).max(axis=1), *planes.T
        found.append(np.column_stack([*sizes, still]))
    return np.array(found)


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
