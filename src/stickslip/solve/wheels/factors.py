"""Newton's systems of a wheel: GMRES with a preconditioner of one block a sector and the resonant modes.

J = I + D R with D = ∂λ̂/∂z block diagonal by sector, R the receptance. M has of R what a sector does to itself and the modes of
the wheel that resonate, Σ P_k g_k P_kᵀ: blocks I + D R_own, and a small system (Woodbury's formula). Neighbours beyond these
modes hardly couple, so that GMRES takes five products to 1e-3, each of which meets the path condition exactly. D and M are kept
in single precision: neither is in the residual.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from stickslip.solve.balance.balance import Evaluation, PathCondition
from stickslip.support.checks import Array

if TYPE_CHECKING:
    from stickslip.solve.wheels.balance import WheelBalance

Single = NDArray[np.float32]

MOST = 60
"""Most products of GMRES."""


class Change(NamedTuple):
    """A change of μ (N r, 2H+1), of the motion (N r + outputs, 2H+1) and of ω."""

    forces: Array
    motion: Array
    omega: float


class Preconditioner(NamedTuple):
    """M⁻¹ v = x − spread (small (Pᵀ x)), x = inverse v; inverse (N, r (2H+1), r (2H+1)), spread (N r (2H+1), k), small (k, k)."""

    inverse: Single
    spread: Single
    small: Single

    @classmethod
    def of(cls, balance: WheelBalance, D: Single, omega: float) -> Preconditioner:
        """D: ∂λ̂/∂z of each sector, (N, r (2H+1), r (2H+1)); ω in rad/s."""
        N, size, r = len(D), D.shape[1], balance.shapes.size
        inverse: Single = np.linalg.inv(np.eye(size, dtype=np.float32) + D @ balance.shapes.block).astype(np.float32)
        by_column = D.reshape(N, size, r, -1)
        pushed = [by_column[..., part] @ shapes.reshape(N, r, -1) for part, shapes in balance.resonant]
        spread: Single = (inverse @ np.concatenate(pushed, axis=2)).reshape(N * size, -1)
        stiffness = []
        for h, near in balance.near:
            own = balance.modes.omega[near]
            real, imaginary = np.diag(own**2 - (h * omega) ** 2), np.diag(2.0 * balance.wheel.ratio * own * h * omega)
            stiffness.append(np.block([[real, imaginary], [-imaginary, real]]))
        columns = spread.reshape(balance.rows, balance.columns, -1)
        met = np.concatenate([shapes.T @ columns[:, part] for part, shapes in balance.resonant])
        return cls(inverse, spread, np.linalg.inv(linalg.block_diag(*stiffness) + met).astype(np.float32))


class WheelFactors:
    """Newton's system of an evaluation with its path condition, ready to be solved; products: of the last solution."""

    def __init__(
        self, balance: WheelBalance, evaluation: Evaluation, condition: PathCondition, D: Single, M: Preconditioner
    ) -> None:
        self.balance, self.evaluation, self.condition, self.D, self.preconditioner = balance, evaluation, condition, D, M
        by_omega, self.products = balance.slope(evaluation.point), 0
        self.along = self._inverted(self._pushed(by_omega) + evaluation.state.by_omega)
        self.moved = by_omega + balance.change(self.along, evaluation.point.omega)
        self.rate = condition.rate(self.moved, 1.0)

    @classmethod
    def of(cls, balance: WheelBalance, evaluation: Evaluation, condition: PathCondition) -> WheelFactors:
        """Those of an evaluation itself."""
        D = balance.derivative(evaluation)
        return cls(balance, evaluation, condition, D, Preconditioner.of(balance, D, evaluation.point.omega))

    def at(self, evaluation: Evaluation) -> WheelFactors:
        """Those of another evaluation, with the same M."""
        return WheelFactors(self.balance, evaluation, self.condition, self.balance.derivative(evaluation), self.preconditioner)

    @property
    def orientation(self) -> float:
        """Sign of the determinant of the system with its path condition, that of J times that of dω as the condition grows; 1
        where the curve goes on as its planes are numbered."""
        balance, (N, size, _) = self.balance, self.D.shape
        if not balance.oriented:
            return 1.0
        pushed = self.D @ balance.receptance(self.evaluation.point.omega).reshape(N, size, -1)
        J = np.eye(N * size, dtype=np.float32) + pushed.reshape(N * size, -1)
        return float(np.linalg.slogdet(J)[0] * np.sign(balance.tangent(self.evaluation, "omega", self).rate))

    @property
    def size(self) -> int:
        """How many contact rows slip or open."""
        return int(np.count_nonzero(self.evaluation.unknown))

    def _pushed(self, motion: Array) -> Array:
        """∂λ̂/∂z dz, (N r, 2H+1)."""
        size = float(np.abs(motion).max()) or 1.0
        z = (motion[: self.balance.rows] / size).astype(np.float32).reshape(*self.D.shape[:2], 1)
        return np.asarray(size * (self.D @ z).reshape(self.balance.rows, -1), dtype=float)

    def _inverted(self, v: Array) -> Array:
        """M⁻¹ v, (N r, 2H+1)."""
        inverse, spread, small = self.preconditioner
        size = float(np.abs(v).max()) or 1.0
        x = (inverse @ (v / size).astype(np.float32).reshape(*inverse.shape[:2], 1)).reshape(v.shape)
        modal = small @ np.concatenate([shapes.T @ x[:, part] for part, shapes in self.balance.resonant])
        return np.asarray(size * (x - (spread @ modal).reshape(v.shape)), dtype=float)

    def estimate(self, v: Array, short: float) -> Change:
        """The solution with M in place of J, of the path condition exactly."""
        x = self._inverted(v)
        dx = self.balance.change(x, self.evaluation.point.omega)
        amount = (short - self.condition.rate(dx, 0.0)) / self.rate
        return Change(x + amount * self.along, dx + amount * self.moved, amount)

    def _applied(self, x: Change) -> Array:
        """J δμ + ∂R/∂ω δω."""
        return np.asarray(x.forces - self._pushed(x.motion) - x.omega * self.evaluation.state.by_omega)

    def solve(self, v: Array, short: float, tolerance: float) -> Change:
        """The change for which J δμ + ∂R/∂ω δω = v to a tolerance, and the path condition changes by `short`.

        The tolerance is relative to the smaller of v and δμ. Near a fold δμ is much larger than v: to a share of it alone no
        step would reduce the residual.
        """
        first = self.estimate(v, short)
        missed = v - self._applied(first)
        size, changed, given = (float(np.linalg.norm(each)) for each in (missed, first.forces, v))
        goal = tolerance * (min(changed, given) if given else changed)
        if not size > goal:
            return first
        basis, found, products = np.empty((MOST + 1, v.size)), [first], np.zeros((MOST + 1, MOST))
        basis[0] = missed.ravel() / size
        for k in range(MOST):
            found.append(self.estimate(basis[k].reshape(v.shape), 0.0))
            following, column = self._applied(found[-1]).ravel(), products[:, k]
            column[: k + 1] = basis[: k + 1] @ following
            following -= column[: k + 1] @ basis[: k + 1]
            column[k + 1] = np.linalg.norm(following)
            basis[k + 1] = following / max(column[k + 1], np.finfo(float).tiny)  # nothing is left where it is solved exactly
            right, matrix = size * np.eye(k + 2)[0], products[: k + 2, : k + 1]
            shares = linalg.lstsq(matrix, right, check_finite=False)[0]
            self.products = k + 1
            if not np.linalg.norm(right - matrix @ shares) > goal:
                break
        return Change(*(sum(a * each[n] for a, each in zip((1.0, *shares), found, strict=True)) for n in range(3)))
