"""The single blade with two dampers: the rig of the demo."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy import linalg

from stickslip.analyses.forced_response import forced_response
from stickslip.dampers.flat_cylinder import FlatCylinder
from stickslip.outcome import Outcome
from stickslip.rigs import single_blade
from stickslip.rigs.platform_blade import PlatformBlade, reduced_blade
from stickslip.rigs.single_blade import pads, placed_dampers
from stickslip.units import hertz
from verify.row import INDEPENDENT, Row, absolute, at_most, relative

TITLE = "Single blade with two dampers"
ABOUT = (
    "Preloads of 2.6, 4.6 and 6.6 kg, force levels of 1, 5, 20, 50, 80 and 100 N, virgin start, 5 harmonics, 256 "
    "samples, 390 to 600 Hz. The paper publishes 410 Hz (free) and 529 Hz (80 N, 4.6 kg); both were used to calibrate "
    "the dimensions."
)
LEVELS = [1.0, 5.0, 20.0, 50.0, 80.0, 100.0]


def rows() -> Iterator[Row]:
    dampers = placed_dampers(PlatformBlade(), FlatCylinder(), 4.6 * 9.81)
    structure = reduced_blade(PlatformBlade(), tuple(pad for damper in dampers for pad in pads(damper)), 150).structure
    free = np.sqrt(linalg.eigvalsh(structure.K, structure.M)[:2]) / (2.0 * np.pi)
    yield relative("Free blade: first mode (lateral), Hz", free[0], 410.0, 1e-3, "published")
    yield relative("Free blade: second mode (axial), Hz", free[1], 661.92, 1e-3, INDEPENDENT)
    for mass in (2.6, 4.6, 6.6):
        rig = single_blade(mass)
        response = forced_response(rig, hertz(390.0, 600.0), LEVELS, harmonics=5)
        dataset, peaks = response.dataset, response.peaks()
        present = dataset.outcome != Outcome.EMPTY
        unsolved = int(
            ((dataset.outcome != Outcome.CONVERGED) & present).sum() + (dataset.case_outcome != Outcome.CONVERGED).sum()
        )
        yield absolute(f"{mass:g} kg: points not converged, of {int(present.sum())}", unsolved, 0, 0.0, "every point")
        yield at_most(f"{mass:g} kg: largest energy residual", float(dataset.energy_residual.max()), 1e-8, "energy balance")
        yield at_most(f"{mass:g} kg: largest slip work error", float(dataset.slip_work_error.max()), 1e-3, "energy balance")
        if mass == 4.6:
            yield relative("4.6 kg: stuck frequency, Hz", rig.frequencies(stuck=True)[0], 561.1, 2e-3, INDEPENDENT)
            peak = peaks[(peaks.force_level == 80.0) & (peaks.peak == 0)].iloc[0]
            yield relative("4.6 kg, 80 N: peak frequency, Hz", peak.frequency, 528.7, 3e-3, INDEPENDENT)
