"""Derivatives of contact forces against differences, on many random motions; forces against plain marching and quadrature."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np
from laws.kernel import forces, motion_of, random_motion
from laws.marching import harmonics_of

from verify.row import Row, at_most

TITLE = "Contact forces and their derivatives"
ABOUT = (
    "Every law, with all its start rules, on random motions of four harmonics and all sizes: friction against a "
    "predictor-corrector march in plain Python, normal forces against quadrature between the openings, derivatives along random "
    "directions against central differences. A direction that crosses a kink within the step, or bends, is left out and counted."
)
MOTIONS, SAMPLED = 60, 64
Referee = Callable[[Any, Any, np.ndarray], np.ndarray]
"""Harmonics of the forces (rows, 2H+1) of a law sample from a start, for motion (rows, 2H+1)."""


def rows() -> Iterator[Row]:
    from laws import test_friction_disc as disc
    from laws.conftest import STARTS
    from laws.marching import steady_forces
    from laws.quadrature import normal_harmonics
    from laws.samples import DISC_SAMPLES, SAMPLES

    def marched(sample: Any, start: Any, w: np.ndarray) -> np.ndarray:
        found = harmonics_of(steady_forces(sample, motion_of(sample, w, SAMPLED), start), 4)
        if sample.law.has_normal:
            found[-1] = sum(normal_harmonics(element, w[-1]) for element in sample.elements)
        return found

    def marched_disc(sample: Any, start: Any, w: np.ndarray) -> np.ndarray:
        return harmonics_of(disc.marched(sample, start, w, SAMPLED), 4)

    crossed = []
    for sample in SAMPLES:
        yield from of_one(sample, STARTS.values(), marched, MOTIONS, 1e-12, crossed)
    for sample in DISC_SAMPLES:
        yield from of_one(sample, disc.STARTS.values(), marched_disc, MOTIONS // 5, 1e-10, crossed)
    yield at_most("Share of directions that crossed a kink or bent", float(np.mean(crossed)), 0.03, "count")


def of_one(
    sample: Any, starts: Iterable[Any], referee: Referee, motions: int, close: float, crossed: list[bool]
) -> Iterator[Row]:
    """Both rows of one law sample; `crossed` collects whether a direction met a kink."""
    from laws.test_law_derivatives import differences

    force_error = slope_error = 0.0
    for seed in range(motions):
        rng = np.random.default_rng(1000 + seed)
        w = random_motion(sample, 4, rng, size=10.0 ** rng.uniform(-1.5, 1.0))
        direction = rng.standard_normal(w.shape)
        for start in starts:
            expected = referee(sample, start, w)
            gap = forces(sample, start, w, SAMPLED)[: len(expected)] - expected
            force_error = max(force_error, np.abs(gap).max() / (1.0 + np.abs(expected).max()))
            found = differences(sample, start, w, direction, SAMPLED)
            crossed.append(not found.on_one_piece())
            if found.on_one_piece():
                central = 0.5 * (found.forward + found.backward)
                slope_error = max(slope_error, np.abs(found.derivative - central).max() / (1.0 + np.abs(central).max()))
    yield at_most(f"{sample.name}: forces", force_error, close, "plain marching, quadrature")
    yield at_most(f"{sample.name}: derivatives", slope_error, 1e-6, "central differences")
