"""Derivatives of contact forces against differences, on many random motions; the forces against plain marching."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from verify.row import Row, at_most

TITLE = "Contact forces and their derivatives"
ABOUT = (
    "Every law, with seven start states, on random motions of four harmonics and all sizes: forces against a "
    "predictor-corrector march in plain Python, derivatives along random directions against central differences. A "
    "direction that crosses a kink within the step is left out and counted."
)
MOTIONS = 60


def rows() -> Iterator[Row]:
    from laws.conftest import STARTS
    from laws.kernel import forces, motion_of, random_motion
    from laws.marching import harmonics_of, steady_forces
    from laws.samples import SAMPLES
    from laws.test_law_derivatives import differences

    crossed = total = 0
    for sample in SAMPLES:
        force_error = slope_error = 0.0
        for seed in range(MOTIONS):
            rng = np.random.default_rng(1000 + seed)
            w = random_motion(sample, 4, rng, size=10.0 ** rng.uniform(-1.5, 1.0))
            direction = rng.standard_normal(w.shape)
            for start in STARTS.values():
                expected = harmonics_of(steady_forces(sample, motion_of(sample, w, 64), start), 4)
                gap = np.abs(forces(sample, start, w, 64) - expected).max() / (1.0 + np.abs(expected).max())
                found = differences(sample, start, w, direction, 64)
                force_error, total = max(force_error, gap), total + 1
                if found.on_one_piece():
                    central = 0.5 * (found.forward + found.backward)
                    slope_error = max(slope_error, np.abs(found.derivative - central).max() / (1.0 + np.abs(central).max()))
                else:
                    crossed += 1
        yield at_most(f"{sample.name}: forces", force_error, 1e-12, "plain marching")
        yield at_most(f"{sample.name}: derivatives", slope_error, 1e-6, "central differences")
    yield at_most("Share of directions that crossed a kink", crossed / total, 0.01, "count")
