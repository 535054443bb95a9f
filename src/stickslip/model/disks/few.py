"""A whole disk on few coordinates of each nodal diameter, for mistuned finite-element disks: every contact and blade stays.

A disk of N sectors with m degrees of freedom each has matrices of N m rows, the third power of which a mode analysis takes. The
motion of the mistuned disk lies, but for little, in that of the tuned one at all nodal diameters n, q_n = T_n y_n, T_n (m, k):
its stuck modes up to a frequency, and what the modes above add to the deformation of contacts, blades, loads and outputs
(`problem/truncation.py` has the equations). The coordinates y of all sectors stand for a real structure again, whose
matrices Tᴴ A T are circulant until sectors deviate (Ritz). Dampers keep their own degrees of freedom, so that one may be missing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.loads import Output
from stickslip.model.structure.cyclic import Waves
from stickslip.support.checks import Array

if TYPE_CHECKING:
    from stickslip.model.disks.tuned import TunedDisk

LEAST_SHARE = 1e-4
"""Share of the energy of a shape that deforms contacts and blades, or of a load's compliance, down to which it is kept."""

REACH = 6.0
"""How far beyond the highest harmonic of the highest frequency modes are kept whole. With 3 the amplitudes of a wheel of 1836
degrees of freedom are 8e-7 off those on all of them, with 6 by 2e-7."""

LARGE = 2000
"""Degrees of freedom of a whole disk from which on it is put on few coordinates."""


def few_waves(disk: TunedDisk, modes_to: float, blade: Sequence[str] = (), deviation: float = 0.0) -> Waves:
    """T_n of each nodal diameter, (N//2 + 1, m, k), with k the same for all.

    modes_to [Hz]: natural frequency up to which the modes of every nodal diameter are kept whole; blade: degrees of freedom of a
    sector that make up its blade, whose frequency deviates by about `deviation`, relative.
    """
    waves = [_StuckWave.of(disk, n, blade, deviation) for n in range(disk.sectors // 2 + 1)]
    low = max(int(np.count_nonzero(wave.squares >= (2.0 * np.pi * modes_to) ** -2)) for wave in waves)
    above = [wave.above(low) for wave in waves]
    more = max(int(np.count_nonzero(shares > LEAST_SHARE)) for _, shares in above)
    few = [np.hstack([wave.modes[:, :low], shapes[:, :more]]) for wave, (shapes, _) in zip(waves, above, strict=True)]
    return np.array([_with_damper(disk, shapes) for shapes in few], dtype=complex)


def most_coordinates(disk: TunedDisk, modes_to: float, blade: Sequence[str]) -> int:
    """An upper bound of k of `few_waves`, from the nodal diameter that is excited."""
    modes = int(np.count_nonzero(disk.frequencies(stuck=True) <= modes_to))
    return modes + len(disk.contact_stiffness) + len(disk.forces) + len(disk.outputs) + len(blade) + len(loose_dofs(disk))


@dataclass(frozen=True, eq=False)
class _StuckWave:
    """A nodal diameter with all contacts stuck: squares 1/ω² (m,), descending, and modes with φᴴK'φ = 1 (m, m); rows (rows, m)
    whose squared product with a shape is what it adds, as a share, to the energy of contacts and blades or to a compliance."""

    squares: Array
    modes: NDArray[Any]
    rows: NDArray[Any]

    @classmethod
    def of(cls, disk: TunedDisk, n: int, blade: Sequence[str], deviation: float) -> _StuckWave:
        M: NDArray[Any] = disk.disk.at(n).M
        stuck: NDArray[Any] = disk.systems.stuck_stiffness(n)
        B: NDArray[Any] = disk.systems.relative_rows(n)
        if not (M.imag.any() or stuck.imag.any()):  # of nodal diameters 0 and N/2 the shapes are real
            M, stuck, B = M.real, stuck.real, B.real
        squares, modes = linalg.eigh(M, stuck)
        squares, modes = squares[::-1], modes[:, ::-1]
        loads = [force.coefficients for force in disk.forces] + [Output.of(output).direction for output in disk.outputs]
        directions = disk.structure.rows(loads)
        rows = [np.sqrt(disk.contact_stiffness)[:, None] * B, directions / np.linalg.norm(directions @ modes, axis=1)[:, None]]
        if blade and deviation:
            bent, K_bb = (part if np.iscomplexobj(M) else part.real for part in blade_motion(disk, n, blade))
            rows.append(np.sqrt(2.0 * deviation) * linalg.cholesky(K_bb) @ bent)
        return cls(np.asarray(squares, dtype=float), modes, np.vstack(rows))

    def above(self, low: int) -> tuple[NDArray[Any], Array]:
        """The shapes of all modes above the first `low`, those that matter most first, and their shares."""
        vectors, sizes, _ = linalg.svd((self.rows @ self.modes[:, low:]).conj().T)
        return self.modes[:, low:] @ vectors, np.pad(sizes**2, (0, len(vectors) - sizes.size))


def blade_motion(disk: TunedDisk, n: int, blade: Sequence[str]) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """How a blade b moves relative to the rest, [I −Ψ] = K_bb⁻¹ K_b of nodal diameter n, (b, m), and K_bb."""
    K, b = disk.disk.at(n).K, [disk.structure.index(dof) for dof in blade]
    K_bb = K[np.ix_(b, b)]
    return np.asarray(linalg.solve(K_bb, K[b], assume_a="pos")), K_bb


def loose_dofs(disk: TunedDisk) -> list[str]:
    """Degrees of freedom of a sector that no stiffness holds but that of contacts: its damper."""
    held = np.abs(np.asarray(disk.disk.stiffnesses)).max(axis=(0, 2))
    return [dof for dof, stiffness in zip(disk.structure.dofs, held, strict=True) if stiffness == 0.0]


def _with_damper(disk: TunedDisk, shapes: NDArray[Any]) -> NDArray[Any]:
    """Shapes (m, k + d) whose span holds those given (m, k) and every motion of the d degrees of freedom of the damper alone."""
    loose = [disk.structure.index(dof) for dof in loose_dofs(disk)]
    held = np.setdiff1d(np.arange(len(shapes)), loose)
    scales = np.sqrt(np.diag(disk.disk.at(0).K).real[held])[:, None]
    spanned = linalg.svd(scales * shapes[held], full_matrices=False)[0] / scales
    whole = np.zeros((len(shapes), spanned.shape[1] + len(loose)), dtype=shapes.dtype)
    whole[held, : spanned.shape[1]] = spanned
    whole[loose, spanned.shape[1] + np.arange(len(loose))] = 1.0
    return whole
