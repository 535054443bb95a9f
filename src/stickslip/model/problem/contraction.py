"""Whether friction and damping let two motions under one force only approach each other: the one place that decides it.

Of sliders whose limit is constant, T = kt (u − s) with |T| ≤ L, the difference Δ of any two motions has the energy

    E = ½ Δq̇ᵀ M Δq̇ + ½ Δqᵀ K Δq + Σ ΔT²/(2 kt) ≥ 0,    dE/dt = −Δq̇ᵀ C Δq̇ − Σ ΔT Δṡ ≤ 0,

for M, K and the symmetric part of C without negative eigenvalues: ΔT Δṡ ≥ 0, since a slider that moves is at the limit towards
which it moves, and the other traction is not beyond it. So no Floquet multiplier lies outside the unit circle. With a positive
definite ½(C + Cᵀ) a difference that repeats itself has Δq̇ = 0: two periodic motions differ by constant offsets of sliders at
most, with a singular K also of what only friction holds, and the curve of a forced response has no fold and no isolated part.

The energy argument is the same for a disc whose two directions have one kt (|T| ≤ L is convex), for friction that grows with the
velocity alone, and for the harmonic balance, where Δq̇ᵀ times the equations is summed over a period. Normal loads that vary, gaps
and cubic springs are outside of it, as are gas forces that go with the displacement. A mean spring acts on constant offsets
alone, which do no work.
"""

from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.model.contact.law import SLIDERS
from stickslip.model.contact.point import contact_table
from stickslip.model.problem.problem import HELD_ALONE, Problem
from stickslip.support.checks import SMALLEST, is_definite


class Contraction(IntEnum):
    """What becomes of the distance of two motions under one force."""

    UNKNOWN = 0
    NEVER_GROWS = 1
    VANISHES = 2


def contracts(problem: Problem) -> bool:
    """Whether a problem has one periodic motion, which attracts all others, up to constant offsets of its sliders."""
    return contraction(problem) == Contraction.VANISHES


def contraction(problem: Problem) -> Contraction:
    """What friction under constant loads and the damping matrix say of any two motions of a problem, at one rotor speed."""
    if problem.systems.gas or problem.systems.stiffens or not _constant_limits(problem):
        return Contraction.UNKNOWN
    found = Contraction.VANISHES
    for M, K, C in problem.systems.without_contacts():
        damping = 0.5 * (C + C.conj().T)
        if not (_definite(K, -1.0) and _definite(M, -1.0)):
            return Contraction.UNKNOWN
        if not _definite(damping, 1.0):
            if not _definite(damping, -1.0):
                return Contraction.UNKNOWN
            found = Contraction.NEVER_GROWS
    return found


def _constant_limits(problem: Problem) -> bool:
    """Whether all contacts are sliders of constant limits, or laws that two motions lead no energy into either."""
    table = contact_table(problem.contacts)
    laws = [
        contact.law.incrementally_passive for contact, kind in zip(problem.contacts, table.kind, strict=True) if kind != SLIDERS
    ]
    return all(laws) and not table.normal_stiffness.size


def _definite(matrix: NDArray[Any], sign: float) -> bool:
    """Whether a Hermitian matrix has positive eigenvalues, or with sign −1 none that is negative, beyond rounding.

    With ones on its diagonal, the units of its rows do not matter.
    """
    diagonal = np.real(np.diag(matrix))
    if np.any(diagonal < 0.0):
        return False
    scale = np.sqrt(np.where(diagonal > 0.0, diagonal, max(float(diagonal.max(initial=0.0)), SMALLEST)))
    return is_definite(matrix / np.outer(scale, scale), -sign * HELD_ALONE)
