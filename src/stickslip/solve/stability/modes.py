"""The stuck structure as blocks of two states, exact over a step of any size; high modes as static compliance.

A perturbation meets the stuck structure and δλ, what its contacts carry beyond their stuck springs:
ẋ = A x − J δλ, δw = R x − S δλ, with A of 2 x 2 blocks, one for each mode or pair of complex poles that is kept.
"""

from typing import NamedTuple

import numpy as np

from stickslip.solve.balance.linear_part import FIRSTS, States
from stickslip.solve.balance.receptance import PAIR_FIRST, REAL_MODE, REAL_POLE
from stickslip.support.checks import Array, Index

FAST = 50.0
"""How many times faster the unused second state of a single real pole decays than the pole itself."""


class BlockModes(NamedTuple):
    """blocks (b, 2, 2): A [1/s]; force (2b, rows): J; motion, velocity (rows, 2b): δw and δẇ of the states; static (rows, rows):
    S [m/N], of the modes that follow at once; real: the states that are there, without the second one of a single real pole;
    dropped: how many modes of `static` would move by themselves; lowest_dropped: the natural frequency of the slowest, rad/s."""

    blocks: Array
    force: Array
    motion: Array
    velocity: Array
    static: Array
    real: Index
    dropped: int
    lowest_dropped: float


def block_modes(states: States, rows: int, highest: float) -> BlockModes | None:
    """Blocks of the states of a real structure (`balance.decoupling`) with natural frequencies up to `highest` [rad/s].

    None for states that drive each other: two critically damped motions of one frequency.
    """
    if states.above.size or not np.all(np.isin(states.kind, (REAL_MODE, PAIR_FIRST, PAIR_FIRST + 1, REAL_POLE))):
        return None
    shape, receiver = states.shape[:rows], states.receiver
    # B K'⁻¹ Bᵀ: every gain at s = 0, that of a pair once for its real and once, with the other sign, for its imaginary part.
    gain = np.ones(states.kind.size)
    gain[states.kind == PAIR_FIRST], gain[states.kind == PAIR_FIRST + 1] = 2.0, -2.0
    compliance = (shape * gain) @ receiver.T
    found, single, dropped = [], [], list[float]()
    for j in np.flatnonzero(~np.isin(states.kind, [kind + 1 for kind in FIRSTS])):
        frequency = _frequency(states, int(j))
        if np.isfinite(frequency) and frequency <= highest:
            found.append(_block(states, int(j), shape, receiver))
            single.append(states.kind[j] == REAL_POLE or (states.kind[j] == REAL_MODE and states.q[j] <= 0.0))
        elif np.isfinite(frequency):
            dropped.append(frequency)
    blocks = np.array([block for block, *_ in found]).reshape(-1, 2, 2)
    force, motion, velocity = (
        np.ascontiguousarray(np.concatenate([each[k] for each in found], axis=axis) if found else np.zeros(empty))
        for k, axis, empty in ((1, 0, (0, rows)), (2, 1, (rows, 0)), (3, 1, (rows, 0)))
    )
    kept = np.zeros((rows, rows))
    for b, block in enumerate(blocks):
        kept -= motion[:, 2 * b : 2 * b + 2] @ np.linalg.solve(block, force[2 * b : 2 * b + 2])
    static = compliance - kept
    static[np.abs(static) <= 1e-12 * np.abs(compliance).max(initial=0.0)] = 0.0
    real = np.flatnonzero([one for alone in single for one in (True, not alone)])
    return BlockModes(
        blocks, force, motion, velocity, np.ascontiguousarray(static), real, len(dropped), min(dropped, default=np.inf)
    )


def _frequency(states: States, j: int) -> float:
    """How fast a state moves by itself, rad/s; infinite for a massless motion without damping."""
    p, q = float(states.p[j]), float(states.q[j])
    if states.kind[j] == REAL_MODE:
        slow = max(np.sqrt(max(q, 0.0)), abs(p) if q <= 0.0 else 0.0)
    else:
        slow = float(np.hypot(p, q)) if states.kind[j] == PAIR_FIRST else abs(p)
    return 1.0 / slow if slow > 0.0 else np.inf


def _block(states: States, j: int, shape: Array, receiver: Array) -> tuple[Array, Array, Array, Array]:
    """A, J, and the rows of δw and δẇ of one mode, pair or pole."""
    p, q, nothing = float(states.p[j]), float(states.q[j]), np.zeros(shape.shape[0])
    if states.kind[j] == REAL_MODE and q > 0.0:
        # The states are η and η̇/ω: q η̈ + p η̇ + η = f, q = 1/ω².
        omega = 1.0 / np.sqrt(q)
        block = np.array([[0.0, omega], [-omega, -p * omega**2]])
        return (
            block,
            np.stack([nothing, omega * receiver[:, j]]),
            np.stack([shape[:, j], nothing], 1),
            np.stack([nothing, omega * shape[:, j]], 1),
        )
    if states.kind[j] == PAIR_FIRST:
        # ξ̇ = σ (ξ − d f), σ = 1/(p + i q), motion 2 Re(o ξ).
        sigma = 1.0 / complex(p, q)
        drive, out = -sigma * (receiver[:, j] + 1j * receiver[:, j + 1]), 2.0 * (shape[:, j] + 1j * shape[:, j + 1])
        block = np.array([[sigma.real, -sigma.imag], [sigma.imag, sigma.real]])
        fast = sigma * out
        return (
            block,
            np.stack([drive.real, drive.imag]),
            np.stack([out.real, -out.imag], 1),
            np.stack([fast.real, -fast.imag], 1),
        )
    sigma = 1.0 / p if states.kind[j] == REAL_POLE else -1.0 / p
    block = np.diag([sigma, -FAST * abs(sigma)])
    return (
        block,
        np.stack([-sigma * receiver[:, j], nothing]),
        np.stack([shape[:, j], nothing], 1),
        np.stack([sigma * shape[:, j], nothing], 1),
    )
