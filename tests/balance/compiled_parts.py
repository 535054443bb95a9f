"""Receptances and their transpose of a modal part, as the kernels of Newton's method compute them."""

import numpy as np

from stickslip.solve.balance.linear_part import LinearPart
from stickslip.solve.balance.receptance import driven_states, frequency_gains, pulled, receptance
from stickslip.support.kernels import boxed, kernel
from stickslip.support.kernels.views import view


def receptance_of(part: LinearPart, omega: float, harmonics: int, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """G' (2, H+1, rows, columns), real and imaginary part."""
    return np.ascontiguousarray(_receptance(part.modes, omega, harmonics, rows, columns).transpose(1, 2, 0, 3))


def pulled_of(part: LinearPart, omega: float, weighted: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """−weightedᵀ G' (columns, 2H+1) for weights on the motion (rows, 2H+1)."""
    return _pulled(part.modes, omega, weighted, columns)


@kernel
def _receptance(given, omega, harmonics, rows, columns):
    modes = view(given)
    return boxed(receptance(modes, driven_states(modes, frequency_gains(modes, omega, harmonics), omega, columns), rows))


@kernel
def _pulled(given, omega, weighted, columns):
    modes, harmonics = view(given), (weighted.shape[1] - 1) // 2
    return boxed(pulled(modes, driven_states(modes, frequency_gains(modes, omega, harmonics), omega, columns), weighted))
