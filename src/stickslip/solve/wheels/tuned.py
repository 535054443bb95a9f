"""What all mistuned wheels of a tuned disk share: its stuck modes on few shapes of a sector's contacts, and what they leave out.

z = Uᵀ √K_c w, the motion w of a sector's contacts scaled by their springs, on r shapes U (rows, r), and the outputs follow from
the load and from μ = Uᵀ λ/√K_c. Nodal diameter n of the tuned disk has stuck modes φ_k, φᴴMφ = 1. The first p families of all
nodal diameters are a Ritz basis of the whole wheel; the modes h above follow as in the tuned disk (a Schur complement),

    K̃ = diag ω² + P_bᵀ ΔK P_b − (ΔK P_b)ᵀ G_bb (ΔK P_b),   P̃ = P − G_b (ΔK P_b),   ΔK = S K_bb S − K_bb,   S = diag(1 + blade),

with P_b how the blades bend in the first families, P how contacts, outputs and loads move in them, and G_b, G_bb what a force
that bends the blades moves through the modes above. So p need only hold what resonates. What the modes above add to the
receptance is that of the tuned disk, wave by wave, and linear in ω² over a band far below them. The mean, on its springs, is the
same with ω = 0.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.model.disks.tuned import TunedDisk, blade_motion
from stickslip.model.structure.cyclic import circulant, of_all_sectors
from stickslip.model.structure.matrices import ModalDamping
from stickslip.solve.balance.fourier import complex_harmonics, real_harmonics
from stickslip.support.checks import Array

Complex = NDArray[np.complex128]

NEAR = 0.3
"""A mode is resonant at harmonic h where |1 − (hω/ω_k)²| is smaller: Newton's systems are then solved with it, not after it."""


class Ritz(NamedTuple):
    """Modes of one mistuned wheel: omega (k,) rad/s; contacts (N r, k) and motion (N r + N outputs, k) of unit modal mass; driven
    (k, H+1): modal forces at force level one; static (k,): of the static loads; held (k, k): inverse of K̃ on its mean springs."""

    omega: Array
    contacts: Array
    motion: Array
    driven: Complex
    static: Array
    held: Array


class Residual(NamedTuple):
    """What the modes above the Ritz basis add at one frequency, for nodal diameters 0..N−1: to z and outputs by μ, (H+1, N, r +
    outputs, r), and by the load at level one, (H+1, N, r + outputs)."""

    by_forces: Complex
    by_load: Complex


class _Wave(NamedTuple):
    """A nodal diameter: squares ω_k² (m,); in its modes (.., m): motion of the contacts, scaled by √K_c, and of the outputs;
    loads, mean springs, and how the blade bends; K_bb of the blade; on the mean springs: receptance of this motion to the
    contacts (rows + outputs, rows) and what the static load moves (rows + outputs,)."""

    squares: Array
    motion: Complex
    loads: Complex
    springs: Complex
    bent: Complex
    K_bb: Complex
    static: Complex
    by_static_load: Complex

    @classmethod
    def of(cls, disk: TunedDisk, n: int, blade: Sequence[str], loads: Array) -> "_Wave":
        M, K, B = disk.disk.at(n).M, disk.systems.stuck_stiffness(n), disk.systems.relative_rows(n)
        real = 2 * n in (0, disk.sectors)
        squares, modes = linalg.eigh(K.real, M.real) if real else linalg.eigh(K, M)
        scaled = np.sqrt(disk.contact_stiffness)[:, None] * B
        rows = np.vstack([scaled, disk.output_rows])
        directions = disk.structure.rows([spring.direction for spring in disk.mean_springs]).reshape(-1, len(M))
        springs = np.sqrt([spring.stiffness for spring in disk.mean_springs])[:, None] * directions
        bent, K_bb = blade_motion(disk, n, blade)
        moved = rows @ linalg.solve(K + springs.T @ springs, np.column_stack([scaled.conj().T, loads[0]]))
        motion, load, spring, bend = (np.asarray(part @ modes, dtype=complex) for part in (rows, loads, springs, bent))
        return cls(np.asarray(squares, dtype=float), motion, load, spring, bend, K_bb, moved[:, :-1], moved[:, -1])


class TunedWheel:
    """A tuned disk for harmonics 0..H over a band in rad/s; modes_to [Hz]: up to where families are in the Ritz basis."""

    def __init__(self, disk: TunedDisk, blade: Sequence[str], harmonics: int, band: tuple[float, float], modes_to: float) -> None:
        self.disk, self.highest, self.band = disk, harmonics, band
        self.sectors, self.stiffness, self.outputs = disk.sectors, disk.contact_stiffness, len(disk.outputs)
        self.ratio = float(np.asarray(damping_of(disk).ratio))
        self.middle = 0.5 * sum(band)
        loads = np.array([disk.static_load, *disk.load_powers(harmonics)[0].T[1:]])
        waves = [_Wave.of(disk, n, blade, loads) for n in range(self.sectors // 2 + 1)]
        self.families = p = max(int(np.count_nonzero(wave.squares <= (2.0 * np.pi * modes_to) ** 2)) for wave in waves)
        self.waves = _Wave(*(_every(np.array(parts), self.sectors) for parts in zip(*waves, strict=True)))
        self.K_bb = circulant(np.array([wave.K_bb for wave in waves]), self.sectors)
        self.bend = self._real([wave.bent for wave in waves]).reshape(len(self.K_bb), -1)
        everything = [np.vstack([wave.motion, wave.loads, wave.springs]) for wave in waves]
        self.basis = self._real(everything)
        self.squares = np.concatenate([np.tile(wave.squares[:p], self._of_a_pair(n)) for n, wave in enumerate(waves)])
        above = [wave.bent[:, p:].conj().T / (wave.squares[p:] - self.middle**2)[:, None] for wave in waves]
        moved, bent = zip(
            *((rows[:, p:] @ G, w.bent[:, p:] @ G) for rows, w, G in zip(everything, waves, above, strict=True)), strict=True
        )
        self.by_bending, self.bending = of_all_sectors(np.array(moved), self.sectors), circulant(np.array(bent), self.sectors)

    def _of_a_pair(self, n: int) -> int:
        """How many real modes a mode of a nodal diameter stands for."""
        return 1 if 2 * n in (0, self.sectors) else 2

    def _real(self, waves: Sequence[Complex]) -> Array:
        """Rows of the whole wheel (N, rows, k) in the real modes of its first families, from those of each nodal diameter."""
        N, columns = self.sectors, []
        for n, rows in enumerate(waves):
            turned = np.exp(-2j * np.pi * n * np.arange(N) / N)[:, None, None] * rows[:, : self.families]
            pair = self._of_a_pair(n)
            columns += [np.sqrt(pair / N) * part for part in (turned.real, turned.imag)[:pair]]
        return np.concatenate(columns, axis=2)

    def ritz(self, blade: Array, pull: Array, U: Array) -> Ritz:
        """Modes of a wheel on shapes U; blade, pull: deviations of blade frequencies and factors of static loads, (N,)."""
        S = 1.0 + np.repeat(blade, len(self.K_bb) // self.sectors)
        drive = ((S[:, None] * S - 1.0) * self.K_bb) @ self.bend
        K = np.diag(self.squares) + self.bend.T @ drive - drive.T @ self.bending @ drive
        squares, V = linalg.eigh(0.5 * (K + K.T))
        moved = (self.basis - (self.by_bending @ drive).reshape(self.basis.shape)) @ V
        N, rows, (contacts, end) = self.sectors, len(U), (len(U), len(U) + self.outputs)
        loads, springs = moved[:, end : end + 2 * self.highest + 1], moved[:, end + 2 * self.highest + 1 :]
        motion = np.vstack([(U.T @ moved[:, :contacts]).reshape(-1, squares.size), moved[:, rows:end].reshape(-1, squares.size)])
        driven = np.zeros((squares.size, self.highest + 1), dtype=complex)
        for h in range(1, self.highest + 1):
            driven[:, h] = self.turns(h) @ (loads[:, 2 * h - 1] - 1j * loads[:, 2 * h])
        springs = springs.reshape(-1, squares.size)
        held = linalg.inv(np.diag(squares) + springs.T @ springs)
        on_contacts = np.ascontiguousarray(motion[: N * U.shape[1]])
        return Ritz(np.sqrt(squares), on_contacts, motion, driven, pull @ loads[:, 0], held)

    def turns(self, harmonic: int) -> Complex:
        """exp(−2πi h EO j/N) of the sectors, (N,)."""
        return np.asarray(np.exp(-2j * np.pi * harmonic * self.disk.engine_order * np.arange(self.sectors) / self.sectors))

    def wave(self, forces: Array, U: Array) -> Array:
        """μ of all sectors (N r, 2H+1) of a tuned disk with contact forces λ of its first sector (rows, 2H+1)."""
        first = complex_harmonics(U.T @ (forces / np.sqrt(self.stiffness)[:, None]))
        turns = np.array([self.turns(h) for h in range(self.highest + 1)]).T
        return real_harmonics(turns[:, None] * first).reshape(-1, 2 * self.highest + 1)

    def on_shapes(self, U: Array) -> Complex:
        """z and outputs in all modes of each nodal diameter, (N, r + outputs, m)."""
        return np.concatenate([U.T @ self.waves.motion[:, : len(U)], self.waves.motion[:, len(U) :]], axis=1)

    def gains(self, harmonic: int, omega: float) -> Complex:
        """1/(ω_k² − Ω² + 2iζω_kΩ), Ω = hω, of all modes of each nodal diameter, (N, m)."""
        squares = self.waves.squares
        return np.asarray(1.0 / (squares - (harmonic * omega) ** 2 + 2j * self.ratio * np.sqrt(squares) * harmonic * omega))

    def resonant(self, harmonic: int) -> NDArray[np.bool_]:
        """Which modes of the Ritz basis resonate in the middle of the band, (N, m)."""
        near = np.abs(1.0 - (harmonic * self.middle) ** 2 / self.waves.squares) < NEAR
        near[:, self.families :] = False
        return near

    def residual(self, U: Array, omega: float) -> Residual:
        """What the modes above the Ritz basis add at ω; at harmonic 0 what the disk on its mean springs has beyond that basis."""
        A, loads, p, r = self.on_shapes(U), self.waves.loads, self.families, U.shape[1]
        by_forces = np.zeros((self.highest + 1, self.sectors, A.shape[1], r), dtype=complex)
        by_load = np.zeros(by_forces.shape[:3], dtype=complex)
        springs = self.waves.springs[:, :, :p]
        between = springs.conj().swapaxes(1, 2) @ springs
        held = A[:, :, :p] @ np.linalg.inv(between + self.waves.squares[:, :p, None] * np.eye(p))
        by_forces[0] = self.static(U) - held @ A[:, :r, :p].conj().swapaxes(1, 2)
        moved = self.waves.by_static_load
        whole = np.concatenate([moved[:, : len(U)] @ U, moved[:, len(U) :]], axis=1)
        by_load[0] = whole - (held @ loads[:, 0, :p, None].conj())[..., 0]
        for h in range(1, self.highest + 1):
            above = A[:, :, p:] * self.gains(h, omega)[:, None, p:]
            by_forces[h] = above @ A[:, :r, p:].conj().swapaxes(1, 2)
            load = loads[:, 2 * h - 1].conj() - 1j * loads[:, 2 * h].conj()
            by_load[h] = (above @ load[:, p:, None])[..., 0]
        return Residual(by_forces, by_load)

    def static(self, U: Array) -> Complex:
        """Static receptance of z and outputs to μ on the mean springs, (N, r + outputs, r)."""
        right = self.waves.static @ U
        return np.concatenate([U.T @ right[:, : len(U)], right[:, len(U) :]], axis=1)

    def shapes(self, least: float) -> Array:
        """U (rows, r): what moves a sector's contacts most under their own forces, down to a share of the largest.

        The weights are those of a sector in the tuned disk: the static receptance, with the mean springs and without, and the
        resonances at their height, 1/(2ζω_k²).
        """
        rows = self.stiffness.size
        motion, squares = self.waves.motion[:, :rows], self.waves.squares
        gains = 1.0 / squares + self.resonant(1) / (2.0 * self.ratio * squares)
        weights = (motion * gains[:, None]) @ motion.conj().swapaxes(1, 2) + self.waves.static[:, :rows]
        sizes, vectors = linalg.eigh(weights.real.mean(axis=0))
        return np.ascontiguousarray(vectors[:, ::-1][:, : int(np.count_nonzero(sizes > least * sizes[-1]))])


class Shapes:
    """Shapes U of a sector's contacts with what the modes above the Ritz basis do on them, at both ends of the band, and the
    receptance of a sector to itself without its resonant modes, (r (2H+1),) squared."""

    def __init__(self, wheel: TunedWheel, U: Array) -> None:
        self.U, self.size = U, U.shape[1]
        self.ends = [wheel.residual(U, omega) for omega in wheel.band]
        r, c = self.size, 2 * wheel.highest + 1
        block = np.zeros((r, c, r, c), dtype=np.float32)
        block[:, 0, :, 0] = wheel.static(U)[:, :r].real.mean(axis=0)
        A = wheel.on_shapes(U)[:, :r]
        for h in range(1, wheel.highest + 1):
            gains = np.where(wheel.resonant(h), 0.0, wheel.gains(h, wheel.middle))
            own = ((A * gains[:, None]) @ A.conj().swapaxes(1, 2)).mean(axis=0)
            a, b = 2 * h - 1, 2 * h
            block[:, a, :, a] = block[:, b, :, b] = own.real
            block[:, a, :, b], block[:, b, :, a] = own.imag, -own.imag
        self.block = block.reshape(r * c, r * c)


def damping_of(disk: TunedDisk) -> ModalDamping:
    """The damping rule of a disk whose modes all have one ratio."""
    rule = disk.structure.damping
    assert isinstance(rule, ModalDamping)
    return rule


def _every(waves: NDArray[Any], sectors: int) -> NDArray[Any]:
    """Of nodal diameters 0..N−1, from those to N/2: N − n has the conjugates of n."""
    return np.array([waves[n] if 2 * n <= sectors else waves[sectors - n].conj() for n in range(sectors)])
