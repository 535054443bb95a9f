"""Sampling of start variables in [−1, 1]: Latin hypercube, random, corners, or a user's distribution."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, Protocol, get_args

import numpy as np

from stickslip.support.checks import Array, among, between, fault, nearest, numbers, seed_of

Method = Literal["latin", "random", "corners"]
MOST_CORNERS = 12
"""Up to so many variables all 2ⁿ corners are taken; beyond, a seeded subset."""


class Law(Protocol):
    """A distribution, as scipy.stats freezes them: a finite support is mapped onto [−1, 1], of others the part there counts."""

    def cdf(self, x: float) -> float:
        """The distribution function."""

    def ppf(self, q: Array) -> Array:
        """The inverse of the distribution function."""

    def support(self) -> tuple[float, float]:
        """Between which values it lies."""


def draw(size: int, starts: int | Array, method: Method = "latin", seed: int = 0, law: Law | None = None) -> Array:
    """Start variables (samples, size) in [−1, 1]; a number draws them, without a law the first one zero (virgin)."""
    among("method", method, get_args(Method))
    rng = np.random.default_rng(seed_of(seed))
    if not isinstance(starts, int | str) and isinstance(starts, np.ndarray | Sequence):
        given = numbers("starts", starts)
        if given.ndim != 2 or given.shape[1] != size or not len(given):
            raise fault("starts", f"must have shape (samples, {size}), with one sample at least", given.shape)
        outside = np.argwhere(~(np.abs(given) <= 1.0))
        if len(outside):
            row, column = outside[0].tolist()
            raise fault(f"starts[{row}, {column}]", "must lie in [-1, 1]", float(given[row, column]))
        return given
    starts = between("starts", starts, 1)
    if law is not None:
        if method == "corners":
            raise fault("method", "must be latin or random with a distribution", method)
        return _by_law(law, _shares(rng, size, starts, method))
    count = starts - 1
    drawn = _corners(rng, size, count) if method == "corners" else 2.0 * _shares(rng, size, count, method) - 1.0
    return np.vstack([np.zeros((1, size)), drawn])


def search_cloud(size: int, count: int, seed: int = 0) -> Array:
    """Start variables that a search may begin from (count + 1, size): virgin, half of them spread evenly, half at corners, where
    extremes often are.
    """
    corners = draw(size, count // 2 + 1, "corners", seed)[1:]
    return np.vstack([draw(size, count - len(corners) + 1, "latin", seed), corners])


def _shares(rng: np.random.Generator, size: int, count: int, method: Method) -> Array:
    """Numbers in [0, 1), (count, size): random ones, or a Latin hypercube, which has one of each column in each of `count` equal
    parts: McKay, Beckman and Conover, Technometrics 21 (1979) 239. scipy.stats has one too, but takes half a second to import.
    """
    if method != "latin":
        return rng.random((count, size))
    (own,) = rng.spawn(1)
    shares, parts = own.random((count, size)), np.tile(np.arange(1, count + 1), (size, 1))
    for column in parts:
        own.shuffle(column)
    return np.asarray((parts.T - shares) / count)


def _by_law(law: Law, shares: Array) -> Array:
    """Values in [−1, 1] at shares of a distribution."""
    if not all(callable(getattr(law, name, None)) for name in ("cdf", "ppf", "support")):
        raise fault("distribution", "must be a law as scipy.stats freezes them, say stats.beta(0.5, 0.5)", law)
    low, high = (float(end) for end in law.support())
    if not low < high:
        raise fault("distribution", "must have valid parameters and a support", (low, high))
    if np.isfinite(low) and np.isfinite(high):
        return np.asarray(np.clip(2.0 * (law.ppf(shares) - low) / (high - low) - 1.0, -1.0, 1.0))
    below, above = law.cdf(-1.0), law.cdf(1.0)
    if not above > below:
        raise fault("distribution", "must have weight between -1 and 1", f"one from {low:g} to {high:g} with none there")
    return np.asarray(np.clip(law.ppf(below + (above - below) * shares), -1.0, 1.0))


def named_law(name: str, parameters: Mapping[str, float]) -> Law:
    """A continuous distribution of scipy.stats by its name and its parameters there: "beta", {"a": 0.5, "b": 0.5}."""
    from scipy import stats

    known = [key for key, value in vars(stats).items() if isinstance(value, stats.rv_continuous)]
    if name not in known:
        raise fault("law", "must be a continuous distribution of scipy.stats", name, nearest(name, known))
    maker = getattr(stats, name)
    shapes = [shape.strip() for shape in (maker.shapes or "").split(",") if shape.strip()]
    missing, unknown = set(shapes) - set(parameters), set(parameters) - {*shapes, "loc", "scale"}
    if missing or unknown:
        raise fault("parameters", f"must be {', '.join([*shapes, 'loc, scale (with defaults)'])}", dict(parameters))
    law: Law = maker(**parameters)
    _by_law(law, np.array([0.5]))
    return law


def _corners(rng: np.random.Generator, size: int, count: int) -> Array:
    """All corners of the cube where they fit into `count`, else a seeded subset without repetition."""
    if size <= MOST_CORNERS:
        numbers = np.arange(2**size)
        numbers = numbers if len(numbers) <= count else np.sort(rng.choice(numbers, count, replace=False))
        return np.asarray(2.0 * ((numbers[:, None] >> np.arange(size)) & 1) - 1.0)
    return np.asarray(np.unique(rng.choice([-1.0, 1.0], (count, size)), axis=0))
