"""Labelled dataset of nonlinear modes: arrays of each curve, padded and stacked.

Labelled dataset of limit cycles: the roots by aerodynamic damping, the curve on which they lie, and the largest damping.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.analyses.modes.slow_decay import SlowDecay, slow_decay
from stickslip.analyses.response_dataset import ContactRows, of_parts, parts
from stickslip.model.contact.point import DIRECTION_NAMES
from stickslip.model.problem import Problem
from stickslip.results.schema import named, stacked, variables_in
from stickslip.results.view import length_text
from stickslip.runs.work import Arrays
from stickslip.solve.balance.balance import Evaluation
from stickslip.solve.balance.energy import contact_cycle
from stickslip.solve.balance.fourier import complex_harmonics, largest_absolute
from stickslip.solve.balance.mode_balance import ModeBalance, mode_energy
from stickslip.solve.curves.mode_curve import ROUNDING, DampingCurve, ModeCurve, first_harmonic_pace, is_stable, pace, slope
from stickslip.support.late import xr

VARIABLES = variables_in("nonlinear_modes")

OF_DECAYS = variables_in("free_decay_of_a_mode")
"""The variables of decays, which take longer than a mode."""

INTERNAL = 0.05
"""Share of the energy in one stuck mode at one harmonic above the first from which this is called an internal resonance."""


def mode_arrays(balance: ModeBalance, curve: ModeCurve) -> dict[str, NDArray[Any]]:
    """The variables of one curve by name, without the axis `case`."""
    rows, met, places = ContactRows(balance.problem), dict[tuple[int, int], float](), []
    for point in curve.points:
        values, strongest = point_values(balance, rows, point.evaluation)
        values |= {"iterations": point.iterations, "active_rows": point.active}
        values |= dict(zip(("amplitude_slope", "frequency_slope", "damping_slope"), pace(point), strict=True))
        values["shape_slope"] = parts(first_harmonic_pace(balance, point))
        places.append(values)
        if strongest is not None:
            met.setdefault(strongest, balance.amplitude_of(point.point))
    sizes = {"output": len(balance.problem.outputs), "harmonic": balance.highest + 1, "part": 2}
    sizes |= {"contact": len(balance.problem.contacts), "direction": 3, "dof": balance.problem.structure.size}
    arrays: dict[str, NDArray[Any]] = {}
    for name, (dims, _, _) in VARIABLES.items():
        if dims[:2] == ("case", "point"):
            empty = np.empty((0, *(sizes[dim] for dim in dims[2:])))
            arrays[name] = np.array([values[name] for values in places], dtype=float) if places else empty
    resonances = [
        f"Internal resonance: from the modal amplitude {amplitude:.3g} m kg^0.5 on, harmonic {harmonic} excites mode {mode} of "
        f"the stuck structure with at least {100.0 * INTERNAL:g} % of the energy."
        for (harmonic, mode), amplitude in met.items()
    ]
    return arrays | {
        "mode_number": np.array(float(balance.followed + 1)),
        "case_outcome": np.array(float(curve.outcome)),
        "case_message": np.array(" ".join([curve.message, *resonances])),
        "stuck_frequency": np.array(balance.linear_omega / (2.0 * np.pi)),
        "stuck_damping": np.array(balance.linear_damping),
    }


def decay_arrays(balance: ModeBalance, curve: ModeCurve) -> dict[str, NDArray[Any]]:
    """The variables of decays of one curve by name, without the axis `case`."""
    decay, energies = slow_decay(balance, curve.points), [mode_energy(balance, point.evaluation) for point in curve.points]
    shared = np.array([energy.resonant > INTERNAL for energy in energies], dtype=bool)
    return {
        "swing": decay.swing,
        "decay_damping_ratio": decay.damping_ratio,
        "decay_message": np.array(decay_message(balance.problem.output_names[0], decay, shared)),
    }


def decay_message(output: str, decay: SlowDecay, shared: NDArray[np.bool_]) -> str:
    """Where along the swing of the first output a decay has no damping ratio, or is not that of one mode; shared (points,): where
    harmonics excite another mode."""
    known = np.isfinite(decay.damping_ratio[:, 0]) if decay.swing.size else np.zeros(0, dtype=bool)
    sentences = []
    lagging = (
        "the static forces of the contacts change with the amplitude faster than a decay follows, whose damping is uncertain"
    )
    beyond = "a decay has no damping ratio: it leaves the computed amplitudes, or a larger motion stores no more energy"
    for where, sentence in (
        (decay.sticks, "friction stops a decay within two half cycles, so that it has no damping ratio"),
        (decay.lags, lagging),
        (shared, "another mode takes part, so that a decay is not that of one mode"),
        (~known & ~decay.sticks, beyond),
    ):
        if where.any():
            size = decay.swing[where, 0]
            sentences.append(f"Where {output} moves {size.min():.3g} m to {size.max():.3g} m, {sentence}.")
    return " ".join(sentences)


def point_values(
    balance: ModeBalance, rows: ContactRows, evaluation: Evaluation
) -> tuple[dict[str, Any], tuple[int, int] | None]:
    """The variables of a point; the harmonic and the mode of an internal resonance, or None."""
    point, omega = evaluation.point, balance.omega_of(evaluation.point)
    motion, outputs = evaluation.w[: balance.rows], evaluation.w[balance.rows :]
    energy = mode_energy(balance, evaluation)
    cycle = contact_cycle(evaluation.table, balance.tables, evaluation.w, omega)
    values: dict[str, Any] = {
        "modal_amplitude": balance.amplitude_of(point),
        "frequency": omega / (2.0 * np.pi),
        "damping_ratio": balance.damping_of(point),
        "energy": energy.mechanical,
        "viscous_work": energy.viscous,
        "energy_residual": energy.residual,
        "other_modes": energy.others,
        "higher_harmonics": energy.harmonics,
        "modal_mass": energy.modal_mass,
        "modal_damping": energy.modal_damping,
        "residual": evaluation.error,
        "amplitude": np.hypot(outputs[:, 1], outputs[:, 2]),
        "max_abs": np.array([largest_absolute(row)[0] for row in outputs]),
        "response": parts(complex_harmonics(outputs)),
        "dissipated": np.bincount(rows.contact, energy.dissipated, minlength=rows.contacts),
        "contact_motion": rows.spread(parts(complex_harmonics(motion))),
        "contact_force": rows.spread(parts(complex_harmonics(balance.carried_forces(evaluation)))),
        "mode_shape": parts(complex_harmonics(balance.whole_motion(evaluation))[:, 1]),
    }
    for name, share in zip(("share_stick", "share_slip", "share_open"), cycle.shares(), strict=True):
        values[name] = rows.spread(share)
    return values, energy.strongest if energy.resonant > INTERNAL else None


def modes_dataset(problem: Problem, results: Sequence[Arrays], attrs: dict[str, Any]) -> xr.Dataset:
    """All curves as one labelled dataset."""
    data = {
        name: named(dims, stacked([result[name] for result in results]), words, units)
        for name, (dims, units, words) in (VARIABLES | OF_DECAYS).items()
        if name in results[0]
    }
    harmonics = data["response"][1].shape[3]
    coords = _labels(problem) | {"harmonic": named("harmonic", np.arange(harmonics), "harmonic")}
    return xr.Dataset(data, coords, {"title": problem.heading, "study": "", **attrs})


def _labels(problem: Problem) -> dict[str, Any]:
    """The coordinates of modes and limit cycles that the problem gives."""
    return {
        "output": named("output", list(problem.output_names), "output"),
        "contact": named("contact", [contact.name for contact in problem.contacts], "contact"),
        "direction": named("direction", list(DIRECTION_NAMES), "direction of a contact"),
        "part": named("part", ["re", "im"], "real or imaginary part"),
        "dof": named("dof", list(problem.structure.dofs), "degree of freedom"),
    }


TURNED = ("response", "contact_force", "contact_motion", "mode_shape", "shape_slope")
"""The variables with a phase; a slope is turned as its motion is, and remains that of the unturned one."""


def with_phase_at(dataset: xr.Dataset, output: int) -> xr.Dataset:
    """The dataset with every motion moved in time so that the first harmonic of an output is real and positive."""
    first = dataset["response"].values[:, :, output, 1]
    angle = -np.angle(of_parts(first))
    turned = {}
    for name in TURNED:
        variable = dataset[name]
        values = of_parts(variable.values)
        orders = dataset["harmonic"].values if "harmonic" in variable.dims else np.ones(1)
        turn = np.exp(1j * angle.reshape(*angle.shape, *[1] * (values.ndim - 2)) * orders)
        turned[name] = variable.copy(data=parts(values * turn))
    return dataset.assign(turned)


_DAMPING = ("case", "aerodynamic_damping")
_ROOT = (*_DAMPING, "limit_cycle")
OF_MODE = (
    "modal_amplitude", "frequency", "energy", "viscous_work", "other_modes", "higher_harmonics", "residual", "amplitude",
    "max_abs", "dissipated", "share_stick", "share_slip", "share_open", "mode_shape",
)  # fmt: skip
"""Variables of limit cycles that are those of a nonlinear mode."""

ROOTS: dict[str, tuple[tuple[str, ...], str, str]] = {
    name: ((*_ROOT, *VARIABLES[name][0][2:]), *VARIABLES[name][1:]) for name in OF_MODE
} | {
    "damping_slope": (_ROOT, "1", "change of the damping ratio with the logarithm of the amplitude"),
    "stable": (_ROOT, "1", "1 where vibration of another amplitude nearby comes to the limit cycle, 0 where it leaves it"),
}
CURVE = variables_in("limit_cycle_curve")
OTHERS: dict[str, tuple[tuple[str, ...], str, str]] = {
    "limit_cycle_message": (_DAMPING, "1", "what the vibration does"),
    **{name: VARIABLES[name] for name in ("mode_number", "case_outcome", "case_message", "stuck_frequency", "stuck_damping")},
}
CYCLE_VARIABLES = {**ROOTS, **CURVE, **OTHERS}


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
        words.append(f"{kind} limit cycle: {length_text(value['amplitude'][0])} of {name} at {value['frequency']:.5g} Hz.")
    if last < 0.0:
        words.append("Beyond the largest it grows without bound.")
    return " ".join(words)


def limit_cycles_dataset(
    problem: Problem, results: Sequence[Arrays], ratios: Sequence[float], attrs: dict[str, Any]
) -> xr.Dataset:
    """The limit cycles of all modes as one labelled dataset."""
    data = {
        name: named(dims, stacked([result[name] for result in results]), words, units)
        for name, (dims, units, words) in CYCLE_VARIABLES.items()
    }
    ratio = named("aerodynamic_damping", list(ratios), "aerodynamic damping ratio, added to that of the mode")
    coords = _labels(problem) | {"aerodynamic_damping": ratio}
    return xr.Dataset(data, coords, {"title": problem.heading, "study": "", **attrs})
