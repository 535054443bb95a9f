"""The solved points of a nonlinear mode again, from its dataset."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.contact_rows import ContactRows
from stickslip.solve.balance.balance import Point
from stickslip.solve.balance.fourier import real_harmonics
from stickslip.solve.balance.mode_balance import ModeBalance
from stickslip.solve.continuation.curve_points import CurvePoint, Tangent, moving_sizes, relative_metric
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.curves.mode_refine import directed
from stickslip.support.checks import InputError

if TYPE_CHECKING:
    import xarray as xr

STEP = 0.1
"""Scale of ln a in arc length."""


def restored(balance: ModeBalance, mode: xr.Dataset) -> Iterator[CurvePoint]:
    """The points of one mode with their tangents, `mode` without the axis `case`.

    Refused where they do not solve the equations of the problem.
    """
    before: CurvePoint | None = None
    for k in range(int(np.count_nonzero(np.isfinite(mode["frequency"].values)))):
        start = _start(balance, mode.isel(point=k))
        found = correct(balance, start, fixed("level", start.level), iterations=20, halvings=8)
        if not found.converged:
            raise InputError("The nonlinear mode must be that of its problem, but its points do not solve the equations.")
        w = found.evaluation.w
        metric = relative_metric(w, balance.rows, moving_sizes(w, balance.rows), STEP)
        tangent = Tangent(np.zeros_like(found.evaluation.point.forces), np.zeros_like(w), 1.0)
        point = CurvePoint(found.evaluation, tangent, metric, found.iterations, 0, 0.0)
        before = directed(balance, before or point, point)
        yield before


def _start(balance: ModeBalance, point: xr.Dataset) -> Point:
    """λ, ω and ζ of a point; the phase is turned back to that of the followed stuck mode."""
    rows = ContactRows(balance.problem)
    force, motion = (rows.collected(_complex(point[name].values)) for name in ("contact_force", "contact_motion"))
    # The followed coordinate φᴴMq of the first harmonic becomes real and positive.
    system = balance.problem.systems.at(1)
    whole = balance.structures.whole[balance.structures.key[1]][:, balance.followed]
    coordinate = complex(whole.conj() @ system.M @ _complex(point["mode_shape"].values))
    turn = (coordinate.conjugate() / abs(coordinate)) ** np.arange(force.shape[1])
    forces = np.zeros((balance.rows + 1, balance.columns))
    forces[:-1] = real_harmonics((force - balance.stiffness[:, None] * motion) * turn)
    forces[-1, 1] = 2.0 * np.pi * float(point["frequency"]) / balance.linear_omega
    forces[-1, 2] = float(point["damping_ratio"])
    return Point(forces, balance.linear_omega, balance.level_of(float(point["modal_amplitude"])))


def _complex(values: NDArray[np.float64]) -> NDArray[np.complex128]:
    return np.asarray(values[..., 0] + 1j * values[..., 1])
