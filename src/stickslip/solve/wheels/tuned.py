"""What all mistuned wheels of a tuned disk share: its stuck modes on the shapes of a sector's contacts, and what they leave out.

The motion z = Uᵀ √K_c B q of the contacts of a sector, scaled by their springs, on r shapes U (rows, r), and that of the outputs
follow from the load and from μ = Uᵀ λ/√K_c. Nodal diameter n of the tuned disk has stuck modes φ_k, φᴴMφ = 1, with A_n the rows
of z and outputs times the modes. The first p families of all nodal diameters are a Ritz basis of the whole wheel,

    K̃ = diag ω² + P_bᵀ (S K_bb S − K_bb) P_b,      S = diag(1 + blade),

P_b how the blades move relative to what carries them in these modes. All higher families respond as in the tuned disk: wave by
wave, from their receptance, which varies linearly with ω² over a band far below them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.disks.tuned import TunedDisk, blade_motion
from stickslip.model.structure.cyclic import circulant
from stickslip.support.checks import Array

Complex = NDArray[np.complex128]

NEAR = 0.3
"""A family is resonant at harmonic h where 1 − (hω/ω_k)² is smaller than this at some nodal diameter."""


class Ritz(NamedTuple):
    """Modes of one mistuned wheel: ω (k,), shapes of contacts and outputs (N, r + outputs, k); driven (H+1, k): modal forces at
    level one; static (k,) and held (k, k): static modal forces, and the inverse of K̃ with the mean springs."""

    omega: Array
    shapes: Array
    driven: Complex
    static: Array
    held: Array


@dataclass(frozen=True)
class Residual:
    """What the higher families add at one frequency: to z and outputs by μ (H+1, N, r + outputs, r), by the load (H+1, N, r +
    outputs), each for nodal diameters 0..N−1."""

    by_forces: Complex
    by_load: Complex


class TunedWheel:
    """A tuned disk with the modes of its wheel up to `modes_to` [Hz], for harmonics 0..H over a band in rad/s."""

    def __init__(
        self, disk: TunedDisk, blade: Sequence[str], harmonics: int, band: tuple[float, float], modes_to: float
    ) -> None:
        self.disk, self.highest, self.band = disk, harmonics, band
        N = self.sectors = disk.sectors
        self.stiffness = disk.contact_stiffness
        self.rows, self.outputs = self.stiffness.size, len(disk.outputs)
        self.ratio = float(disk.structure.damping.ratio)  # type: ignore[union-attr]
        powers = disk.load_powers(harmonics)[0]
        loads = np.array([disk.static_load, *powers.T[1:]])
        waves = [_Wave.of(disk, n, blade, loads) for n in range(N // 2 + 1)]
        self.families = max(int(np.count_nonzero(wave.squares <= (2.0 * np.pi * modes_to) ** 2)) for wave in waves)
        self.squares = _every(np.array([wave.squares for wave in waves]), N)
        self.motion = _every(np.array([wave.motion for wave in waves]), N)
        self.loads = _every(np.array([wave.loads for wave in waves]), N)
        self.mean = _every(np.array([wave.mean for wave in waves]), N)
        self.static_motion = _every(np.array([wave.static for wave in waves]), N)
        self.static_by_load = _every(np.array([wave.static_load for wave in waves]), N)
        self.bent = np.array([wave.bent[:, : self.families] for wave in waves])
        self.K_bb = circulant(np.array([wave.K_bb for wave in waves]), N)
        self.bend = self._real([wave.bent for wave in waves]).reshape(self.K_bb.shape[0], -1)
        self.basis = self._real([np.vstack([wave.motion, wave.loads, wave.springs]) for wave in waves])
        self.basis_squares = self._squares([wave.squares for wave in waves])
        self.bent_tuned = self.bend.T @ self.K_bb @ self.bend
        self.turn = np.exp(-2j * np.pi * disk.engine_order * np.arange(N) / N)

    def _real(self, waves: Sequence[Complex]) -> Array:
        """Rows of the whole wheel (N, rows, k) in the real modes of its first families, from those of each nodal diameter."""
        N, angles = self.sectors, 2.0 * np.pi * np.arange(self.sectors) / self.sectors
        columns = []
        for n, rows in enumerate(waves):
            travelling = np.exp(-1j * n * angles)[:, None, None] * rows[:, : self.families]
            if n in (0, N / 2):
                columns.append(travelling.real / np.sqrt(N))
            else:
                columns += [np.sqrt(2.0 / N) * travelling.real, np.sqrt(2.0 / N) * travelling.imag]
        return np.concatenate(columns, axis=2)

    def _squares(self, waves: Sequence[Array]) -> Array:
        N = self.sectors
        return np.concatenate([np.tile(w[: self.families], 1 if n in (0, N / 2) else 2) for n, w in enumerate(waves)])


    def ritz(self, blade: Array, shapes: Array, pull: Array) -> Ritz:
        """Modes of the wheel whose blades deviate by `blade` (N,); pull: factors of the static loads (N,)."""
        S = (1.0 + np.repeat(blade, self.K_bb.shape[0] // self.sectors))[:, None] * self.bend
        K = np.diag(self.basis_squares) + S.T @ (self.K_bb @ S) - self.bent_tuned
        squares, V = linalg.eigh(0.5 * (K + K.T))
        rows, o, H = self.rows, self.outputs, self.highest
        modal = self.basis @ V
        motion = np.concatenate([np.einsum("ri,jrk->jik", shapes, modal[:, :rows]), modal[:, rows : rows + o]], axis=1)
        load = modal[:, rows + o : rows + o + 2 * H + 1]
        springs = modal[:, rows + o + 2 * H + 1 :].reshape(-1, squares.size)
        driven = np.zeros((H + 1, squares.size), dtype=complex)
        for h in range(1, H + 1):
            driven[h] = self.turn**h @ (load[:, 2 * h - 1] - 1j * load[:, 2 * h])
        held = linalg.inv(np.diag(squares) + springs.T @ springs)
        return Ritz(np.sqrt(squares), np.ascontiguousarray(motion), driven, pull @ load[:, 0], held)

    def on_shapes(self, shapes: Array) -> Complex:
        """Rows of z and of the outputs in all modes of each nodal diameter, (N, r + outputs, m)."""
        rows = self.rows
        return np.concatenate([shapes.T @ self.motion[:, :rows], self.motion[:, rows:]], axis=1)

    def residual(self, shapes: Array, omega: float) -> Residual:
        """What the families above the first p add at ω, and at harmonic 0 what the disk on its mean springs has beyond them."""
        N, H, r, p = self.sectors, self.highest, shapes.shape[1], self.families
        A = self.on_shapes(shapes)
        by_forces = np.zeros((H + 1, N, r + self.outputs, r), dtype=complex)
        by_load = np.zeros((H + 1, N, r + self.outputs), dtype=complex)
        low, back = A[:, :, :p], A[:, :r, :p].conj().swapaxes(1, 2)
        held = np.array([linalg.inv(np.diag(s[:p]) + mean[:p, :p]) for s, mean in zip(self.squares, self.mean, strict=True)])
        by_forces[0] = self._projected(self.static_motion, shapes) - low @ held @ back
        static = self.static_by_load
        known = np.concatenate([np.einsum("ri,nr->ni", shapes, static[:, : self.rows]), static[:, self.rows :]], axis=1)
        by_load[0] = known - (low @ held @ self.loads[:, 0, :p, None].conj())[..., 0]
        for h in range(1, H + 1):
            g = _gains(np.sqrt(self.squares), self.ratio, h * omega)
            g[:, :p] = 0.0
            by_forces[h] = (A * g[:, None]) @ A[:, :r].conj().swapaxes(1, 2)
            load = self.loads[:, 2 * h - 1] - 1j * self.loads[:, 2 * h]
            conjugate = self.loads[:, 2 * h - 1].conj() - 1j * self.loads[:, 2 * h].conj()
            by_load[h] = np.einsum("nik,nk,nk->ni", A, g, conjugate)
        return Residual(by_forces, by_load)

    def _projected(self, static: Complex, shapes: Array) -> Complex:
        rows = self.rows
        right = static @ shapes
        return np.concatenate([shapes.T @ right[:, :rows], right[:, rows:]], axis=1)

    def local(self, shapes: Array, omega: float) -> Complex:
        """The receptance of a sector's contacts to their own forces (H+1, r, r) without the resonant families, and these as
        (harmonic, family)."""
        A, H, r = self.on_shapes(shapes)[:, : shapes.shape[1]], self.highest, shapes.shape[1]
        found = np.zeros((H + 1, r, r), dtype=complex)
        found[0] = self._projected(self.static_motion, shapes)[:, :r].mean(axis=0).real
        for h in range(1, H + 1):
            g = _gains(np.sqrt(self.squares), self.ratio, h * omega)
            near = np.abs(1.0 - (h * omega) ** 2 / self.squares) < NEAR
            near[:, self.families :] = False
            g[near] = 0.0
            found[h] = ((A * g[:, None]) @ A.conj().swapaxes(1, 2)).mean(axis=0)
        return found


def _gains(omega: Array, ratio: float, at: float) -> Complex:
    """1/(ω_k² − Ω² + 2iζω_kΩ)."""
    return 1.0 / (omega**2 - at**2 + 2j * ratio * omega * at)


def _every(waves: NDArray[Any], sectors: int) -> NDArray[Any]:
    """Of nodal diameters 0..N−1, from those to N/2."""
    return np.array([waves[n] if 2 * n <= sectors else waves[sectors - n].conj() for n in range(sectors)])


class _Wave(NamedTuple):
    """A nodal diameter: squares ω_k² (m,); contacts scaled by √K_c and outputs, loads, mean springs and blades in its modes; the
    mean springs between modes; static receptance with them to contacts and to the static load."""

    squares: Array
    motion: Complex
    loads: Complex
    springs: Complex
    bent: Complex
    K_bb: Complex
    mean: Complex
    static: Complex
    static_load: Complex

    @classmethod
    def of(cls, disk: TunedDisk, n: int, blade: Sequence[str], loads: Array) -> "_Wave":
        M, K, B = disk.disk.at(n).M, disk.systems.stuck_stiffness(n), disk.systems.relative_rows(n)
        real = 2 * n in (0, disk.sectors)
        squares, modes = linalg.eigh(K.real, M.real) if real else linalg.eigh(K, M)
        scaled = np.sqrt(disk.contact_stiffness)[:, None] * B
        rows = np.vstack([scaled, disk.output_rows])
        springs = disk.structure.rows([spring.direction for spring in disk.mean_springs])
        springs = np.sqrt([spring.stiffness for spring in disk.mean_springs])[:, None] * springs.reshape(-1, len(M))
        bent, K_bb = blade_motion(disk, n, blade)
        back = linalg.solve(K + springs.T @ springs, np.column_stack([scaled.conj().T, loads[0]]))
        static = rows @ back
        mean = (springs @ modes).conj().T @ (springs @ modes)
        parts = (np.asarray(x @ modes, dtype=complex) for x in (rows, loads, springs, bent))
        return cls(np.asarray(squares), *parts, K_bb, mean, static[:, :-1], static[:, -1])
