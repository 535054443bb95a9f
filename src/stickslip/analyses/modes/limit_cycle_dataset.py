"""Labelled dataset of limit cycles: the roots by aerodynamic damping, the curve on which they lie, and the largest damping."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.contact_rows import ContactRows
from stickslip.analyses.modes.dataset import VARIABLES as MODE_VARIABLES
from stickslip.analyses.modes.dataset import point_values
from stickslip.analyses.performance.work import stacked
from stickslip.model.contact.point import DIRECTION_NAMES
from stickslip.model.problem import Problem
from stickslip.results.view import length_text
from stickslip.runs.work import Arrays
from stickslip.solve.curves.damping_roots import ROUNDING, DampingCurve, is_stable, slope

if TYPE_CHECKING:
    import xarray as xr

_CASE, _POINT, _DAMPING = ("case",), ("case", "point"), ("case", "aerodynamic_damping")
_ROOT = (*_DAMPING, "limit_cycle")
OF_MODE = (
    "modal_amplitude", "frequency", "energy", "viscous_work", "other_modes", "higher_harmonics", "residual", "amplitude",
    "max_abs", "dissipated", "share_stick", "share_slip", "share_open", "mode_shape",
)  # fmt: skip
"""Variables of limit cycles that are those of a nonlinear mode."""

ROOTS: dict[str, tuple[tuple[str, ...], str, str]] = {
    name: ((*_ROOT, *MODE_VARIABLES[name][0][2:]), *MODE_VARIABLES[name][1:]) for name in OF_MODE
} | {
    "damping_slope": (_ROOT, "1", "change of the damping ratio with the logarithm of the amplitude"),
    "stable": (_ROOT, "1", "1 where vibration of another amplitude nearby comes to the limit cycle, 0 where it leaves it"),
}
CURVE: dict[str, tuple[tuple[str, ...], str, str]] = {
    "curve_damping": (_POINT, "1", "damping ratio of the mode"),
    "curve_slope": (_POINT, "1", "change of the damping ratio with the logarithm of the amplitude"),
    "curve_stable": (
        _POINT,
        "1",
        "1 where a limit cycle there is stable, 0 where it is unstable, NaN at an extreme or in full stick",
    ),
    "curve_frequency": (_POINT, "Hz", "natural frequency of the mode"),
    "curve_energy": (_POINT, "J", "mechanical energy of the mode"),
    "curve_amplitude": ((*_POINT, "output"), "m", "amplitude of the first harmonic"),
    "held_damping": (_CASE, "1", "largest damping ratio over the amplitude: the largest negative damping that is held"),
    "held_frequency": (_CASE, "Hz", "natural frequency where the damping ratio is largest"),
    "held_amplitude": (("case", "output"), "m", "amplitude where the damping ratio is largest"),
    "held_inside": (_CASE, "1", "1 where the damping ratio is largest between the ends of the curve, 0 at an end"),
}
OTHERS: dict[str, tuple[tuple[str, ...], str, str]] = {
    "limit_cycle_message": (_DAMPING, "1", "what the vibration does"),
    **{
        name: MODE_VARIABLES[name] for name in ("mode_number", "case_outcome", "case_message", "stuck_frequency", "stuck_damping")
    },
}
VARIABLES = {**ROOTS, **CURVE, **OTHERS}


def curve_arrays(damping: DampingCurve) -> dict[str, NDArray[Any]]:
    """The variables of the curve of one mode."""
    balance, rows = damping.balance, ContactRows(damping.balance.problem)
    values = [point_values(balance, rows, point.evaluation)[0] for point in damping.points]
    outputs = len(balance.problem.outputs)
    found = {
        f"curve_{name}": np.array([value[key] for value in values], dtype=float)
        for name, key in (("damping", "damping_ratio"), ("frequency", "frequency"), ("energy", "energy"))
    }
    found["curve_slope"] = np.array([damping.slope(k) for k in range(len(values))])
    found["curve_stable"] = np.array([float(is_stable(point)) for point in damping.points])
    neutral = np.abs(found["curve_slope"]) <= ROUNDING * np.max(np.abs(found["curve_damping"]), initial=0.0)
    found["curve_stable"][neutral] = np.nan
    found["curve_amplitude"] = np.array([value["amplitude"] for value in values], dtype=float).reshape(len(values), outputs)
    if not values:
        nothing = {name: np.array(np.nan) for name in ("held_damping", "held_frequency", "held_inside")}
        return found | nothing | {"held_amplitude": np.full(outputs, np.nan)}
    most = damping.largest
    held = {f"held_{name}": found[f"curve_{name}"][most] for name in ("damping", "frequency", "amplitude")}
    return found | held | {"held_inside": np.array(float(0 < most < len(values) - 1))}


def root_arrays(damping: DampingCurve, ratios: Sequence[float]) -> dict[str, NDArray[Any]]:
    """The variables of the limit cycles of one mode, (aerodynamic_damping, limit_cycle, ...)."""
    balance, problem = damping.balance, damping.balance.problem
    rows, sizes = ContactRows(problem), {"output": len(problem.outputs), "contact": len(problem.contacts), "direction": 3}
    sizes |= {"dof": problem.structure.size, "part": 2}
    by_name: dict[str, list[NDArray[Any]]] = {name: [] for name in ROOTS}
    messages = []
    for ratio in ratios:
        values = []
        for root in damping.roots(-ratio):
            value = point_values(balance, rows, root.evaluation)[0]
            values.append(value | {"damping_slope": slope(root), "stable": float(is_stable(root))})
        for name in ROOTS:
            empty = np.empty((0, *(sizes[dim] for dim in ROOTS[name][0][3:])))
            by_name[name].append(np.array([value[name] for value in values], dtype=float) if values else empty)
        messages.append(_words(damping, ratio, values))
    return {name: stacked(pieces) for name, pieces in by_name.items()} | {"limit_cycle_message": np.array(messages)}


def _words(damping: DampingCurve, ratio: float, values: Sequence[dict[str, Any]]) -> str:
    """What vibration does at an aerodynamic damping ratio, in words."""
    if not damping.points:
        return "No motion of the mode was found."
    first, last = damping.ratios[0] + ratio, damping.ratios[-1] + ratio
    name = damping.balance.problem.output_names[0]
    if not values:
        if first < 0.0:
            return f"Vibration grows at all amplitudes; {-100.0 * (max(damping.ratios) + ratio):.3g} % of damping is missing."
        return "Vibration decays at all amplitudes, or stays as small as it is."
    words = ["Vibration grows from rest." if first < 0.0 else "Small vibration decays or stays as it is."]
    for value in values:
        kind = "Stable" if value["stable"] else "Unstable"
        words.append(f"{kind} limit cycle: {length_text(value['amplitude'][0])} of {name} at {value['frequency']:.6g} Hz.")
    if last < 0.0:
        words.append("Beyond the largest it grows without bound.")
    return " ".join(words)


def limit_cycles_dataset(
    problem: Problem, results: Sequence[Arrays], ratios: Sequence[float], attrs: dict[str, Any]
) -> xr.Dataset:
    """The limit cycles of all modes as one labelled dataset."""
    import xarray as xr

    data = {
        name: (dims, stacked([np.asarray(result[name]) for result in results]), {"units": units, "long_name": words})
        for name, (dims, units, words) in VARIABLES.items()
    }
    labels: dict[str, tuple[Any, str]] = {
        "aerodynamic_damping": (list(ratios), "aerodynamic damping ratio, added to that of the mode"),
        "output": (list(problem.output_names), "output"),
        "contact": ([contact.name for contact in problem.contacts], "contact"),
        "direction": (list(DIRECTION_NAMES), "direction of a contact"),
        "part": (["re", "im"], "real or imaginary part"),
        "dof": (list(problem.structure.dofs), "degree of freedom"),
    }
    coords = {name: (name, values, {"units": "1", "long_name": words}) for name, (values, words) in labels.items()}
    return xr.Dataset(data, coords, {"title": problem.heading, "study": "", **attrs})
