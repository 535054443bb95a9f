"""Labelled dataset of a forced response: arrays of each curve, padded and stacked.

The arrays of one curve are what processes send back and what is kept on disk while a run goes on.

Mapping from the contact rows of a problem to labelled arrays, by contact and direction t1, t2, n.

Arrays of the curves of a result, from which one with more curves is made.

Conversion of motions relative to a moving base into absolute ones: X + r X_b, X_b = −A/(hω)² for a base acceleration A.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.model.contact.point import DIRECTION_NAMES
from stickslip.model.loads import BaseMotion, excited_harmonics
from stickslip.model.problem import Problem
from stickslip.results.schema import SCHEMA, Variable, labelled, named, stacked
from stickslip.results.view import periods_of
from stickslip.runs.cases import Arrays
from stickslip.solve.balance.balance import Evaluation, HarmonicBalance
from stickslip.solve.balance.energy import ContactCycle, EnergyBalance, contact_cycle
from stickslip.solve.balance.fourier import complex_harmonics, largest_absolute
from stickslip.solve.balance.linear_response import linear_amplitudes, linear_frequencies
from stickslip.solve.balance.measure import DISPLACEMENT_AMPLITUDE, Measure
from stickslip.solve.continuation.curve_points import CurvePoint
from stickslip.solve.curves.curve import Curve
from stickslip.support.checks import Array, Index
from stickslip.support.late import xr
from stickslip.support.outcome import Outcome


class ContactRows:
    """contact, direction (rows,): the places of each row."""

    def __init__(self, problem: Problem) -> None:
        contacts = enumerate(problem.contacts)
        pairs = [(c, DIRECTION_NAMES.index(name)) for c, contact in contacts for name in contact.direction_names]
        self.contact, self.direction = np.array(pairs, dtype=int).reshape(len(pairs), 2).T
        self.contacts = len(problem.contacts)

    def spread(self, values: NDArray[Any], axis: int = 0) -> NDArray[Any]:
        """Values (..., rows, ...), rows along an axis, as (..., contact, direction, ...), NaN where a contact has no such
        direction."""
        before, after = values.shape[:axis], values.shape[axis + 1 :]
        found = np.full((*before, self.contacts, len(DIRECTION_NAMES), *after), np.nan)
        found[(slice(None),) * axis + (self.contact, self.direction)] = values
        return found

    def summed(self, values: NDArray[Any]) -> NDArray[Any]:
        """Sums over the rows of each contact of values (points, rows): (points, contacts)."""
        found = np.zeros((len(values), self.contacts))
        np.add.at(found.T, self.contact, values.T)
        return found

    def collected(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values (contact, direction, ...) as (rows, ...)."""
        return np.asarray(values[self.contact, self.direction])


ArraysOfCurve = Mapping[str, NDArray[Any]]

_EMPTY: dict[str, Any] = {"float": np.nan, "int8": 0, "str": ""}
_TYPES: dict[str, Any] = {"float": float, "int8": np.int8, "str": np.str_}

BLOCK = 1_000_000
"""Numbers of an array, points x (coordinates or samples) x harmonics, up to which points are taken together."""


def curve_arrays(balance: HarmonicBalance, curve: Curve) -> dict[str, NDArray[Any]]:
    """The variables of the schema for one curve, by name, without the axis `case`."""
    return _CurveTable(balance, curve).filled()


def response_dataset(
    balance: HarmonicBalance,
    levels: Sequence[float],
    curves: Sequence[ArraysOfCurve],
    ends: tuple[float, float],
    attrs: Mapping[str, Any],
    measure: Measure = DISPLACEMENT_AMPLITUDE,
    plain: HarmonicBalance | None = None,
) -> "xr.Dataset":
    """The labelled dataset of the arrays of several curves; ends: of the band in Hz, for the linear curves; measure: what the
    peaks are of; plain: the balance over one period of the excitation, if that of the curves is over several.
    """
    problem = balance.problem
    per_curve = [variable for variable in SCHEMA if variable.name in curves[0]]
    arrays = {variable.name: stacked_curves(variable, [curve[variable.name] for curve in curves]) for variable in per_curve}
    coords: dict[str, Any] = {"force_level": list(levels), **labels_of(problem)}
    if balance.periods > 1:
        coords["harmonic"] = np.arange(balance.highest + 1) / balance.periods
        attrs = {**attrs, "periods": balance.periods}
    dataset = labelled(arrays | _linear(plain or balance, levels, *ends, measure), coords, {**attrs, **measure.attributes})
    newtons = levels_are_newtons(problem)
    if newtons:
        dataset["force_level"].attrs |= {"units": "N", "long_name": "amplitude of the harmonic force"}
    words = {
        "peak_amplitude": f"{measure.words} at the peak",
        "peak_max_abs": f"largest {measure.quantity.name} at the peak",
        "highest_max_abs": f"largest {measure.quantity.name} along the curve, at a peak of its own",
        "highest_max_abs_frequency": f"frequency of the largest {measure.quantity.name}",
    }
    for name, sentence in words.items():
        dataset[name].attrs["long_name"] = sentence
        if not name.endswith("frequency"):
            dataset[name].attrs["units"] = measure.reported_units(newtons)
    areas = [contact.area for contact in problem.contacts]
    if any(areas):
        dataset["contact_area"] = named("contact", areas, "area that the contact stands for, 0: not known", "m2")
    return dataset


def labels_of(problem: Problem) -> dict[str, list[str]]:
    """The coordinates of datasets that a problem gives: its outputs and contacts, and the directions of contacts."""
    contacts = [contact.name for contact in problem.contacts]
    return {"output": list(problem.output_names), "contact": contacts, "direction": list(DIRECTION_NAMES)}


def levels_are_newtons(problem: Problem) -> bool:
    """Whether the only harmonic force has amplitude 1 N along one degree of freedom, so that a level is that force in N."""
    newtons = newtons_a_level(problem)
    return newtons is not None and abs(newtons - 1.0) < 1e-12


def newtons_a_level(problem: Problem) -> float | None:
    """The amplitude at force level 1 of the only harmonic force, along one degree of freedom, N; None for other excitations."""
    harmonic = [force for force in problem.forces if any(force.amplitudes.values())]
    if len(harmonic) != 1 or isinstance(harmonic[0], BaseMotion) or harmonic[0].power:
        return None
    sizes = [abs(amplitude) for amplitude in harmonic[0].amplitudes.values() if amplitude]
    along = [abs(coefficient) for coefficient in harmonic[0].coefficients.values() if coefficient]
    return sizes[0] * along[0] if len(sizes) == len(along) == 1 else None


def stacked_curves(variable: Variable, pieces: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """ArraysOfCurve of different length as one with a first axis `case`, padded with what means "not there"."""
    return stacked(pieces, _EMPTY[variable.kind], object if variable.kind == "str" else _TYPES[variable.kind])


def _linear(
    balance: HarmonicBalance, levels: Sequence[float], low: float, high: float, measure: Measure
) -> dict[str, NDArray[Any]]:
    """The curves and natural frequencies of the free and of the stuck structure; the curves are of the first harmonic, and NaN
    where this is not what the peaks are of: where no load excites it, or loads excite others and a measure counts all.
    """
    frequencies = linear_frequencies(balance, low, high)
    free, stuck = linear_amplitudes(balance, frequencies)
    excited = excited_harmonics(balance.problem.forces)
    if 1 not in excited or (len(excited) > 1 and measure.kind != "amplitude"):
        free, stuck = np.full_like(free, np.nan), np.full_like(stuck, np.nan)
    factors = np.array(levels)[:, None, None]
    natural = [balance.problem.frequencies(stuck=which) for which in (False, True)]
    padded = stacked(natural)
    return {
        "linear_frequency": frequencies,
        "free_amplitude": factors * free,
        "stuck_amplitude": factors * stuck,
        "natural_frequency_free": padded[0],
        "natural_frequency_stuck": padded[1],
    }


def as_given(found: Array, frequencies: Sequence[float], periods: int = 1) -> Array:
    """Frequencies in Hz that have been in rad/s, over a number of periods: those that were given, a list or the ends of a
    band, to the last bit."""
    given = {periods * (2.0 * np.pi * frequency / periods / (2.0 * np.pi)): frequency for frequency in frequencies}
    return np.array([given.get(float(frequency), float(frequency)) for frequency in found])


class _CurveTable:
    """Fills the arrays of one curve point by point."""

    def __init__(self, balance: HarmonicBalance, curve: Curve) -> None:
        self.balance, self.curve = balance, curve
        self.largest = curve.measure.with_kind("max_abs")
        self.energy = EnergyBalance(balance)
        self.rows = ContactRows(balance.problem)
        sizes = {
            "point": len(curve.points) + len(curve.missing) + (curve.lost_at is not None),
            "output": balance.problem.output_rows.shape[0],
            "harmonic": balance.highest + 1,
            "part": 2,
            "contact": len(balance.problem.contacts),
            "direction": 3,
            "peak": max((len(found) for found in curve.peaks), default=0),
            "sample": balance.tables.E.shape[0],
        }
        self.arrays: dict[str, NDArray[Any]] = {}
        for variable in SCHEMA:
            if variable.dims[0] == "case" and all(dim in sizes for dim in variable.dims[1:]):
                shape = tuple(sizes[dim] for dim in variable.dims[1:])
                self.arrays[variable.name] = np.full(shape, _EMPTY[variable.kind], dtype=_TYPES[variable.kind])

    def filled(self) -> dict[str, NDArray[Any]]:
        """All arrays of the curve."""
        arrays, curve = self.arrays, self.curve
        arrays["case_outcome"], arrays["case_message"] = np.array(curve.outcome, dtype=np.int8), np.array(curve.message)
        for k, omega in curve.missing:
            arrays["frequency"][k], arrays["outcome"][k] = self.balance.hertz(omega), Outcome.NOT_CONVERGED
        places = np.setdiff1d(np.arange(len(curve.points) + len(curve.missing)), [k for k, _ in curve.missing])
        longest = max(self.balance.problem.structure.size, self.balance.tables.E.shape[0])
        size = max(1, BLOCK // (self.balance.columns * longest))
        for first in range(0, len(places), size):
            self._fill_points(places[first : first + size], curve.points[first : first + size])
        if curve.lost_at is not None:
            arrays["frequency"][-1] = self.balance.hertz(curve.lost_at)
            arrays["outcome"][-1] = curve.outcome
        for output, found in enumerate(curve.peaks):
            ranked = sorted(found, key=lambda p: -self._size(curve.measure, p, output))
            for k, point in enumerate(ranked):
                place = k, output
                arrays["peak_frequency"][place] = self.balance.hertz(point.point.omega)
                arrays["peak_amplitude"][place] = self._size(curve.measure, point, output)
                arrays["peak_max_abs"][place] = self._size(self.largest, point, output)
                arrays["peak_loss_factor"][place] = self.energy.loss_factor(point.evaluation)
        if curve.inside:
            top = max(curve.tops(0), key=lambda p: self._size(curve.measure, p, 0))
            cycle = self._cycle(top.evaluation)
            arrays["loop_frequency"] = np.array(self.balance.hertz(top.point.omega))
            arrays["loop_motion"] = self.rows.spread(cycle.displacement)
            arrays["loop_force"] = self.rows.spread(cycle.force)
        for output, extreme in enumerate(curve.largest):
            if extreme is not None:
                arrays["highest_max_abs"][output] = self._size(self.largest, extreme, output)
                arrays["highest_max_abs_frequency"][output] = self.balance.hertz(extreme.point.omega)
        return arrays

    def _fill_points(self, places: Index, points: Sequence[CurvePoint]) -> None:
        arrays, evaluations = self.arrays, [point.evaluation for point in points]
        cycles = map(self._cycle, evaluations)
        shares, slip_work = map(np.array, zip(*((cycle.shares(), cycle.slip_work.sum()) for cycle in cycles), strict=True))
        energy = self.energy.along(evaluations)
        values = {
            "frequency": [self.balance.hertz(point.point.omega) for point in points],
            "outcome": Outcome.CONVERGED,
            "residual": [each.error for each in evaluations],
            "iterations": [point.iterations for point in points],
            "active_rows": [point.active for point in points],
            "loss_factor": energy.loss_factor,
            "energy_residual": energy.energy_residual,
            "slip_work_error": energy.slip_work_error(slip_work),
            "dissipated": self.rows.summed(energy.dissipated),
            **point_values(self.balance, self.rows, evaluations),
        }
        for k, name in enumerate(("share_stick", "share_slip", "share_open")):
            values[name] = self.rows.spread(shares[:, k], axis=1)
        for name, value in values.items():
            arrays[name][places] = value

    def _cycle(self, evaluation: Evaluation) -> ContactCycle:
        return contact_cycle(evaluation.table, self.balance.tables, evaluation.w, evaluation.point.omega)

    def _size(self, measure: Measure, point: CurvePoint, output: int) -> float:
        return measure.size(point.evaluation.w[self.balance.rows + output], point.point.omega) / measure.per(self.curve.level)


def point_values(balance: HarmonicBalance, rows: ContactRows, evaluations: Sequence[Evaluation]) -> dict[str, Array]:
    """The variables of the schema that say how outputs and contacts move at points, without the axis `case`."""
    motion, outputs = np.split(np.array([each.w for each in evaluations]), [balance.rows], axis=1)
    forces = np.array([balance.carried_forces(each) for each in evaluations])
    return {
        "response": parts(complex_harmonics(outputs)),
        "amplitude": np.hypot(*np.moveaxis(outputs[..., balance.first], -1, 0)),
        "rms": np.sqrt(outputs[..., 0] ** 2 + 0.5 * np.sum(outputs[..., 1:] ** 2, axis=-1)),
        "max_abs": np.array([[largest_absolute(row)[0] for row in each] for each in outputs]),
        "contact_motion": rows.spread(parts(complex_harmonics(motion)), axis=1),
        "contact_force": rows.spread(parts(complex_harmonics(forces)), axis=1),
    }


def parts(values: NDArray[np.complex128]) -> Array:
    """Complex values as (..., 2): real and imaginary part."""
    return np.stack([values.real, values.imag], axis=-1)


def of_parts(values: Array) -> NDArray[np.complex128]:
    """The complex values of real and imaginary parts (..., 2)."""
    return np.asarray(values[..., 0] + 1j * values[..., 1])


KEPT = (
    "truncation_error", "sampling_error", "work_error", "modal_error", "patch_error", "point_truncation_error",
    "highest_stability", "end_stability",
)  # fmt: skip
"""What a curve has beside the variables of the schema."""


def arrays_of(dataset: "xr.Dataset", case: int, longer: int = 1) -> dict[str, NDArray[Any]]:
    """What `curve_arrays` gives of a curve, from its dataset; longer: by how many times the expansion is."""
    found: dict[str, NDArray[Any]] = {}
    for variable in SCHEMA:
        if variable.dims[0] == "case" and "linear_point" not in variable.dims:
            values = dataset[variable.name].transpose(*variable.dims).values[case]
            found[variable.name] = _longer(values, variable.dims[1:], longer) if longer > 1 else np.asarray(values)
    for name in KEPT:
        if name in dataset:
            found[name] = dataset[name].values[case]
    return found


APART = "isolated {} "
"""What stands before the names of the arrays of a curve that lies apart from the swept one, with its number."""


def beside(curves: Sequence[Arrays]) -> dict[str, NDArray[Any]]:
    """The arrays of curves apart from a swept one, under names that stand beside its own."""
    return {APART.format(k) + name: values for k, each in enumerate(curves) for name, values in each.items()}


def apart_of(arrays: Arrays) -> list[Arrays]:
    """The arrays of the curves that `beside` put there."""
    found: list[Arrays] = []
    while own := {name: values for name, values in arrays.items() if name.startswith(APART.format(len(found)))}:
        begin = len(APART.format(len(found)))
        found.append({name[begin:]: values for name, values in own.items()})
    return found


def _longer(values: NDArray[Any], dims: tuple[str, ...], longer: int) -> NDArray[Any]:
    """Over several times the period: harmonics with zeros between them, samples repeated."""
    if "harmonic" in dims:
        axis = dims.index("harmonic")
        shape = list(values.shape)
        shape[axis] = longer * (shape[axis] - 1) + 1
        spread = np.where(np.isnan(np.take(values, [0], axis)), np.nan, np.zeros(shape))
        place: list[Any] = [slice(None)] * values.ndim
        place[axis] = slice(None, None, longer)
        spread[tuple(place)] = values
        return spread
    return np.tile(values, [longer if dim == "sample" else 1 for dim in dims]) if "sample" in dims else np.asarray(values)


def absolute(dataset: "xr.Dataset", problem: Problem) -> "xr.Dataset":
    """`response` and `amplitude` of a result as absolute motions, m: those of the result, which are relative, and the base."""
    found = dataset[["frequency", "outcome", "response", "amplitude"]].copy(deep=True)
    omega, level = 2.0 * np.pi * dataset["frequency"].values, dataset["force_level"].values[:, None]
    values, periods = found["response"].values, periods_of(dataset)
    for base in (force for force in problem.forces if isinstance(force, BaseMotion)):
        along = problem.output_rows @ problem.structure.row(base.coefficients)
        for harmonic, factor in base.factors.items():
            acceleration = level * factor * omega**base.power
            moved = (-acceleration / (harmonic * omega) ** 2)[..., None] * along
            values[:, :, :, periods * harmonic, 0] += moved.real
            values[:, :, :, periods * harmonic, 1] += moved.imag
    found["amplitude"].values[:] = np.hypot(values[:, :, :, periods, 0], values[:, :, :, periods, 1])
    found["response"].attrs["long_name"] = "absolute response"
    found["amplitude"].attrs["long_name"] = "amplitude of the first harmonic of the absolute response"
    return found
