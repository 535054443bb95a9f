"""What the compiled parts of a Newton iteration read and return."""

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.model.contact.point import ContactTable, contact_table
from stickslip.solve.balance.fourier import Fourier, fourier
from stickslip.solve.balance.receptance import NO_MODES, Complex, Modes
from stickslip.support.checks import Array, Index
from stickslip.support.kernels.views import placed_as


class Control(NamedTuple):
    """ω^order |X_1| of a row of motion, held at an amplitude by the force level, an unknown then; row −1: nothing is held."""

    row: int
    order: int
    amplitude: float


FREE = Control(-1, 0, 1.0)
"""No amplitude is held: the force level is given."""

SMALLER, ON_FORCES, ON_STATES = range(3)
"""What Newton's linear system is solved for: the unknowns of λ, the states of the structure, or whichever takes less work."""


class System(NamedTuple):
    """A harmonic balance as the kernels read it.

    stiffness (rows,): springs of the stuck contacts; kept, dropped: the columns of balanced and of left-out harmonics; load_size
    (powers of ω,), least_scale: of residuals; effort (3,): evaluations, factorisations and their multiplications, counted on;
    control: the amplitude that the force level holds, if any; form: SMALLER, ON_FORCES or ON_STATES.
    """

    table: ContactTable
    tables: Fourier
    modes: Modes
    stiffness: Array
    kept: Index
    dropped: Index
    load_size: Array
    least_scale: float
    effort: Index
    control: Control
    form: int


class State(NamedTuple):
    """Everything at a point: forces λ (rows, 2H+1); gains of the modes; motion w (rows and outputs, 2H+1); residual λ − λ̂;
    unknown (rows,) and the derivatives own, coupling, cross, by_omega of λ̂, as `contact_forces` fills them; error: ‖residual‖
    relative to the contact forces or the harmonic load, whichever is larger."""

    forces: Array
    gains: Complex
    w: Array
    residual: Array
    unknown: Index
    own: Array
    coupling: Array
    cross: Array
    by_omega: Array
    error: float


class Bordered(NamedTuple):
    """The factorised bordered matrix: factors and pivots; where the unknowns of each row start; which entries of λ they are;
    sign of the determinant, 0 when singular. Behind the unknowns of λ stand the path parameter, and a level that is unknown.

    Where columns is not empty, the factors are those of the smaller matrix on the states of the structure (`modal_matrix`), with
    what leads from there to the unknowns of λ: columns (1 or 2, N) of the parameter and the unknown level; blocks (3 rows, 2H+1,
    2H+1), the derivatives own, coupling and cross of λ̂, and omega [rad/s] of the point.
    """

    lu: Array
    pivots: NDArray[np.int32]
    offsets: Index
    mask: NDArray[np.bool_]
    sign: float
    columns: Array
    blocks: Array
    omega: float


class Border(NamedTuple):
    """A path condition, weight · w + slope p = target; weight (rows, 2H+1), or (0, 0) for none; p: the level, or ω."""

    weight: Array
    slope: float
    target: float
    by_level: bool


class Direction(NamedTuple):
    """Along the curve, the path condition growing at rate one: dλ (rows, 2H+1), dw (rows and outputs, 2H+1), dp of the path
    parameter; level: that of the force level where it holds an amplitude, else 0."""

    forces: Array
    motion: Array
    rate: float
    level: float


_LINE, _SQUARE, _BLOCKS, _PLACES = np.empty(0), np.empty((0, 0)), np.empty((0, 0, 0)), np.empty(0, dtype=np.int64)
_GAINS, _PIVOTS, _MASK = np.empty((0, 0, 0), dtype=np.complex128), np.empty(0, dtype=np.int32), np.empty((0, 0), dtype=np.bool_)

STATE = State(_SQUARE, _GAINS, _SQUARE, _SQUARE, _PLACES, _BLOCKS, _BLOCKS, _BLOCKS, _SQUARE, 0.0)
BORDER = Border(_SQUARE, 0.0, 0.0, False)
BORDERED = Bordered(_SQUARE, _PIVOTS, _PLACES, _MASK, 0.0, _SQUARE, _BLOCKS, 0.0)
DIRECTION = Direction(_SQUARE, _SQUARE, 0.0, 0.0)
"""Empty ones, whose types are those of all."""


@cache
def empty_system() -> System:
    """A system without anything, whose types are those of all."""
    numbers = _LINE, 0.0, _PLACES, FREE, SMALLER
    return System(contact_table(()), fourier(1, 6), NO_MODES, _LINE, _PLACES, _PLACES, *numbers)


@placed_as(empty_system)
class SystemAddress(NamedTuple):
    """Where a `System` lies in memory, for kernels that are called often."""

    address: int
