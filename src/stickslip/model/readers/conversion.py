"""Unit conversion of a model to SI: matrices by row, coordinates by length."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy import sparse

from stickslip.model.structure.sparse import Sparse
from stickslip.support.checks import Array
from stickslip.support.units import UnitSystem

ROTATIONS = ("rx", "ry", "rz")


def levers(dofs: Sequence[str], units: UnitSystem) -> Array:
    """The factor of each degree of freedom: 1 for displacements, one length unit for rotations NODE.rx, ry, rz (in rad), (n,)."""
    return np.array([units.metres if dof.rpartition(".")[2] in ROTATIONS else 1.0 for dof in dofs])


def matrices_in_si(matrices: Mapping[str, Sparse], dofs: Sequence[str], units: UnitSystem) -> dict[str, Sparse]:
    """The matrices in SI. Rows of rotations carry a length more than those of displacements."""
    force_per_length = units.newtons / units.metres
    factors = {"M": units.kilograms, "K": force_per_length, "C": force_per_length * units.seconds}
    lever = sparse.diags_array(levers(dofs, units))
    return {name: sparse.csc_array(factors[name] * (lever @ matrix @ lever)) for name, matrix in matrices.items()}
