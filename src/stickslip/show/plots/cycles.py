"""Contact motion and forces over a cycle, from bounds, samples or histories, per contact or summed over a surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stickslip.support.checks import Array, Index, fault, nearest

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False)
class Cycles:
    """Curves over one period: motion [m] and force [N], (curve, row, sample), of rows "CONTACT DIRECTION"."""

    rows: tuple[str, ...]
    motion: Array
    force: Array

    @property
    def phase(self) -> Array:
        """Share of the period of each sample."""
        return np.asarray(np.arange(self.force.shape[-1]) / self.force.shape[-1])

    @property
    def contacts(self) -> tuple[str, ...]:
        """Contacts that have both a first tangential and a normal direction."""
        return tuple(row[:-3] for row in self.rows if row.endswith(" t1") and f"{row[:-3]} n" in self.rows)

    def row(self, name: str) -> int:
        """The place of a row."""
        if name not in self.rows:
            raise fault("row", "must be a known one", name, nearest(name, self.rows))
        return self.rows.index(name)

    def summed(self) -> Cycles:
        """Forces summed and motions averaged over points of one surface, "left flat 1", "left flat 2", ...: "left flat"."""
        surfaces = tuple(dict.fromkeys(_surface(row) for row in self.rows))
        share = np.array([[float(_surface(row) == surface) for row in self.rows] for surface in surfaces])
        mean = share / share.sum(axis=1, keepdims=True)
        return Cycles(surfaces, *(np.einsum("sr,crt->cst", m, x) for m, x in ((mean, self.motion), (share, self.force))))


def bound_cycles(dataset: xr.Dataset, case: int = 0, frequency: float | None = None, summed: bool = False) -> Cycles:
    """The lower and the upper bound of one force level, at the frequency nearest to the given one."""
    k = 0 if frequency is None else int(np.nanargmin(np.abs(dataset["frequency"].values - frequency)))
    rows = tuple(str(name) for name in dataset["row"].values)
    cycles = Cycles(rows, dataset["contact_motion"].values[case, :, k], dataset["contact_force"].values[case, :, k])
    return cycles.summed() if summed else cycles


def sample_cycles(dataset: xr.Dataset, level: float, summed: bool = False) -> Cycles:
    """All samples of one force level at their highest peak, or at the one frequency that they were solved at."""
    cases = np.flatnonzero(np.isclose(dataset["force_level"].values, level))
    motion, force = dataset["loop_motion"].values[cases], dataset["loop_force"].values[cases]
    names = [f"{contact} {direction}" for contact in dataset["contact"].values for direction in dataset["direction"].values]
    flat = (motion.shape[0], len(names), motion.shape[-1])
    there = np.any(np.isfinite(force), axis=(0, 3)).ravel()
    rows = tuple(name for name, used in zip(names, there, strict=True) if used)
    cycles = Cycles(rows, motion.reshape(flat)[:, there], force.reshape(flat)[:, there])
    return cycles.summed() if summed else cycles


def run_cycles(dataset: xr.Dataset, runs: Index, summed: bool = False) -> Cycles:
    """Some runs of a history, each at its largest point."""
    rows = tuple(str(name) for name in dataset["row"].values)
    cycles = Cycles(rows, dataset["largest_contact_motion"].values[runs], dataset["largest_contact_force"].values[runs])
    return cycles.summed() if summed else cycles


def _surface(row: str) -> str:
    """The row without the number of its point."""
    contact, _, direction = row.rpartition(" ")
    surface, _, number = contact.rpartition(" ")
    return f"{surface} {direction}" if surface and number.isdigit() else row
