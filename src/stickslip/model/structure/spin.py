"""Centrifugal stress stiffening and spin softening of a rotating body.

Linear about the state of steady rotation about z at Ω: K(Ω) = K + Ω² S. Gyroscopic (Coriolis) terms are left out.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy import linalg, sparse
from scipy.sparse.linalg import LinearOperator, eigsh

from stickslip.model.structure.factor import Factor, Singular
from stickslip.model.structure.solid import Material, ShapeFunctions, Solid, element_mass, shape_functions
from stickslip.support.checks import Array, fault

SMALL, SETTLED = 20, 1e-6
"""Rows up to which all eigenvalues are computed; relative error of one that is sought alone, far below what is printed."""

ACROSS = np.diag([1.0, 1.0, 0.0])
"""What of a place is across the axis of rotation."""


def spinning(body: Solid, mesh: Any, material: Material, rate: float, joined: sparse.csc_array | None = None) -> Solid:
    """The body of this mesh and material at steady rotation about z, `rate` Ω in rad/s: K + Ω² S.

    joined: motion of all degrees of freedom from independent ones, (n, independent), as of a sector of which the whole disk
    spins (nodal diameter 0); none unless given.
    """
    if rate == 0.0:
        return body
    K = sparse.csc_array(body.K + rate**2 * spin_stiffness(body, mesh, material, joined))
    if not holds(K if joined is None else sparse.csc_array(joined.T @ K @ joined)):
        rule = "must leave the body its stiffness"
        raise fault("rotation", rule, rate / (2.0 * np.pi), "Its unit is turns a second; beyond a speed softening wins.")
    return replace(body, K=K)


def holds(K: Any) -> bool:
    """Whether a stiffness has positive eigenvalues alone."""
    try:
        factor = Factor(sparse.csc_array(K))
    except Singular:
        return False
    return factor.negative == 0 and factor.weak == 0


def most_softened(K: Any, M: Any, S: Any) -> tuple[float, float]:
    """The largest κ of S x = κ K x, a share of the stiffness of a motion x, and ω of x, ω² = xᵀK x / xᵀM x [rad/s].

    K − S is positive definite where κ < 1, and has the frequency ω (1 − κ)^½ there. K, M, S: (n, n), symmetric, sparse. κ is
    infinite where K itself is not positive definite.
    """
    size, K = K.shape[0], sparse.csc_array(K)
    try:
        factor = Factor(K)
    except Singular:
        return np.inf, 0.0
    if factor.negative or factor.weak:
        return np.inf, 0.0
    if size < SMALL:
        shares, motions = linalg.eigh(S.toarray(), K.toarray())
    else:
        inverse = LinearOperator((size, size), factor.solve, dtype=float)
        shares, motions = eigsh(S, 1, M=K, Minv=inverse, which="LA", v0=np.ones(size), tol=SETTLED)
    x = motions[:, -1]
    return float(shares[-1]), float(np.sqrt((x @ (K @ x)) / (x @ (M @ x))))


def spin_stiffness(body: Solid, mesh: Any, material: Material, joined: sparse.csc_array | None = None) -> sparse.csc_array:
    """S = ∫ δ_ij ∇N_a·σ ∇N_b − ρ N_a N_b P_ij dV, kg: σ the stress that Ω = 1 rad/s builds up, P the part across the axis.

    The stress is that of the static problem K u = ∫ ρ N_a P x dV at small displacements.
    """
    shapes = shape_functions(mesh)
    free = np.flatnonzero(body.numbers.ravel() >= 0)
    load = _centrifugal_load(shapes, material)[free]
    T: Any = sparse.eye_array(free.size, format="csc") if joined is None else joined
    moved = np.zeros(shapes.size)
    moved[free] = T @ Factor(sparse.csc_array(T.T @ body.K @ T)).solve(T.T @ load)
    stiffening = _geometric(shapes, _stress(shapes, moved, material))
    softening = element_mass(shapes.values, shapes.volumes, material) * np.tile(np.diag(ACROSS), len(shapes.values))
    return sparse.csc_array(shapes.assembled(stiffening - softening)[free][:, free])


def _centrifugal_load(shapes: ShapeFunctions, material: Material) -> Array:
    """∫ ρ N_a P x dV of all nodes, (size,)."""
    mass = shapes.assembled(element_mass(shapes.values, shapes.volumes, material))
    return np.asarray(mass @ (shapes.points @ ACROSS).ravel())


def _stress(shapes: ShapeFunctions, moved: Array, material: Material) -> Array:
    """σ = λ tr ε I + 2µ ε at the quadrature points, (3, 3, cells, q)."""
    gradient = np.einsum("cai,ajcq->ijcq", moved[shapes.rows], shapes.gradients, optimize=True)
    lam, shear = material.lame
    dilatation = np.einsum("iicq->cq", gradient)
    return np.asarray(lam * np.eye(3)[:, :, None, None] * dilatation + shear * (gradient + gradient.swapaxes(0, 1)))


def _geometric(shapes: ShapeFunctions, stress: Array) -> Array:
    """δ_ij ∫ ∇N_a·σ ∇N_b dV of each cell, (cells, 3a, 3a)."""
    count, _, cells, _ = shapes.gradients.shape
    pulled = np.einsum("ijcq,bjcq->bicq", stress, shapes.gradients, optimize=True) * shapes.volumes
    blocks = np.einsum("aicq,bicq->cab", shapes.gradients, pulled, optimize=True)
    whole = np.zeros((cells, count, 3, count, 3))
    for axis in range(3):
        whole[:, :, axis, :, axis] = blocks
    return whole.reshape(cells, 3 * count, 3 * count)
