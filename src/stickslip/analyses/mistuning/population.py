"""Response of one mistuned disk or of a random population of them, compared with the tuned disk.

Labelled dataset of mistuned disks, from the arrays of the tuned disk and of all samples.

Fatigue margins of the blades of mistuned disks, each at its largest amplitude.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from stickslip.analyses.mistuning.disk import RELATIVE, Mistuning, Scatter
from stickslip.analyses.mistuning.work import PopulationWork
from stickslip.analyses.response_dataset import levels_are_newtons
from stickslip.analyses.settings import takes
from stickslip.analyses.stress import SIZES, Equivalent, has_fatigue, with_fatigue
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.structure.stress import COMPONENTS, FatigueLimit
from stickslip.results.schema import Result, stacked, tabulated
from stickslip.runs.cases import Arrays, all_cases
from stickslip.solve.balance.fourier import attribute
from stickslip.support.checks import InputError
from stickslip.support.late import xr
from stickslip.support.units import Band

NO_WORK = 1e-18
"""J per period: a damper that sticks works less than this, by rounding."""


def population_dataset(work: PopulationWork, results: Sequence[Arrays]) -> xr.Dataset:
    """Axes sample, point (padded with NaN), blade (from 1); the tuned disk beside them."""
    tuned, samples = results[0], results[1:]
    N, measure = work.disk.sectors, work.sweep.measure
    coords: dict[str, Any] = {"blade": np.arange(1, N + 1)}
    data = _samples(samples) | _tuned(tuned) | _amplification(samples, tuned) | _deviations(work)
    if work.places:
        data |= _stresses(samples, tuned)
        coords |= {"place": list(work.places), "component": list(COMPONENTS)}
    attrs: dict[str, Any] = {"title": work.disk.heading, "study": "", "analysis": "mistuned_population"}
    attrs |= {"sectors": N, "engine_order": work.disk.engine_order, "seed": work.seed, "force_level": work.sweep.levels[0]}
    attrs |= {"harmonics": attribute(work.sweep.harmonics), "samples": work.sweep.samples, "whitehead": 0.5 * (1.0 + np.sqrt(N))}
    attrs |= measure.attributes
    attrs["cpu_seconds"] = sum(float(arrays["cpu_seconds"]) for arrays in results)
    found = tabulated("mistuned_population", data, coords, attrs, measure.reported_units(levels_are_newtons(work.disk)))
    found["amplitude"].attrs["long_name"] = f"{measure.words} of each blade"
    return found


def _samples(samples: Sequence[Arrays]) -> dict[str, Any]:
    """Curves, maxima and outcomes."""
    frequency, amplitude = (stacked([arrays[name] for arrays in samples]) for name in ("frequency", "amplitude"))
    peak, place, work = (np.array([arrays[name] for arrays in samples]) for name in ("peak", "peak_frequency", "damper_work"))
    busiest = np.where(np.nan_to_num(work).max(axis=1) > NO_WORK, np.nan_to_num(work).argmax(axis=1) + 1, 0)
    return {
        "frequency": frequency,
        "amplitude": amplitude,
        "envelope": amplitude.max(axis=2),
        "blade_peak": peak,
        "blade_peak_frequency": place,
        "damper_work": work,
        "busiest_damper": busiest,
        "sample_outcome": np.array([int(arrays["outcome"]) for arrays in samples], dtype=np.int8),
        "sample_message": [str(arrays["message"]) for arrays in samples],
        "cpu_time": [float(arrays["cpu_seconds"]) for arrays in samples],
    }


def _stresses(samples: Sequence[Arrays], tuned: Arrays) -> dict[str, Any]:
    """Of each blade at its largest amplitude, and of the tuned disk."""
    data: dict[str, Any] = {}
    for prefix, values in (("", np.array([arrays["stress"] for arrays in samples])), (TUNED, tuned["stress"][0])):
        data |= {prefix + name: values[..., k] for k, name in enumerate(SIZES)}
        data[f"{prefix}stress_mean"] = values[..., len(SIZES) :]
    return data


def _tuned(tuned: Arrays) -> dict[str, Any]:
    single = {f"tuned_{name}": float(tuned[name][0]) for name in ("damper_work", "peak", "peak_frequency")}
    return {"tuned_frequency": tuned["frequency"], "tuned_amplitude": tuned["amplitude"][:, 0]} | single


def _amplification(samples: Sequence[Arrays], tuned: Arrays) -> dict[str, Any]:
    """Largest over all blades against the tuned disk, and the blade that has it; NaN and 0 where a sample failed."""
    largest = np.array([arrays["peak"].max() for arrays in samples])
    worst = [0 if np.isnan(arrays["peak"]).any() else int(arrays["peak"].argmax()) + 1 for arrays in samples]
    return {"amplification": largest / float(tuned["peak"][0]), "worst_blade": worst}


def _deviations(work: PopulationWork) -> dict[str, Any]:
    drawn = [work.deviations(sample) for sample in range(work.count)]
    data: dict[str, Any] = {f"{name}_deviation": np.array([each.deviation(name) for each in drawn]) for name in RELATIVE}
    missing = [np.isin(np.arange(1, work.disk.sectors + 1), each.missing) for each in drawn]
    return data | {"damper_missing": np.array(missing, dtype=np.int8)}


TUNED = "tuned_"
KEPT = ("fatigue_amplitude", "fatigue_mean", "fatigue_limit")


class BladeMargin(NamedTuple):
    """The smallest margin of a population: sample and blade, from 1; the place and Hz; amplitude and mean of the stress there and
    the amplitude that the material stands, Pa; the smallest margin of the tuned disk."""

    sample: int
    blade: int
    place: str
    frequency: float
    alternating: float
    mean: float
    allowed: float
    tuned: float

    @property
    def size(self) -> float:
        """By how much the vibration may grow; infinite where nothing vibrates."""
        return self.allowed / self.alternating if self.alternating > 0.0 else np.inf


def with_blade_fatigue(
    dataset: xr.Dataset, limit: FatigueLimit, mean: Mapping[str, float] | None = None, equivalent: Equivalent = "sines"
) -> xr.Dataset:
    """A population with stress and its fatigue margins: `fatigue_amplitude`, `fatigue_mean` and `fatigue_limit` (sample, blade,
    place) as of `with_fatigue`, each blade at its largest amplitude, and those of the tuned disk, `tuned_fatigue_amplitude`, ...

    Where several modes are excited, stress may be larger at another frequency than that of the largest amplitude.
    """
    if "stress_mean" not in dataset:
        raise InputError(
            "A fatigue margin of mistuned disks needs the stress of their blades. Name places of stress with the model of the "
            "sector (stress = ...), and compute results of an older version again."
        )
    found = with_fatigue(dataset, limit, mean, equivalent)
    own_names = {TUNED + name: name for name in (*SIZES, "stress_mean")}
    tuned = with_fatigue(dataset[list(own_names)].rename(own_names), limit, mean, equivalent)
    return found.assign({TUNED + name: tuned[name] for name in KEPT})


def blade_margins(dataset: xr.Dataset, prefix: str = "") -> xr.DataArray:
    """The margin of each blade at each place, (sample, blade, place), or of the tuned disk (place,); NaN where it failed."""
    allowed, alternating = dataset[f"{prefix}fatigue_limit"], dataset[f"{prefix}fatigue_amplitude"]
    with np.errstate(divide="ignore", invalid="ignore"):
        return (allowed / alternating).where(alternating != 0.0, np.inf).where(np.isfinite(alternating))


def smallest_blade_margin(dataset: xr.Dataset) -> BladeMargin | None:
    """The smallest margin of all blades, samples and places; None without a fatigue limit or where every sample failed."""
    if not has_fatigue(dataset):
        return None
    sizes = blade_margins(dataset)
    if not sizes.notnull().any():
        return None
    sample, blade, place = np.unravel_index(int(np.nanargmin(sizes.values)), sizes.shape)
    here = dataset.isel(sample=int(sample), blade=int(blade), place=int(place))
    alternating, mean, allowed = (float(here[name]) for name in KEPT)
    where = int(sample) + 1, int(here["blade"]), str(here["place"].values), float(here["blade_peak_frequency"])
    return BladeMargin(*where, alternating, mean, allowed, float(blade_margins(dataset, TUNED).min()))


@dataclass(frozen=True, eq=False, repr=False)
class MistunedPopulation(Result):
    """One mistuned disk or many: `dataset` has an axis `sample`, and for each of them the amplitudes of all blades over the
    frequency, the envelope, the maximum of each blade, the worst blade, the amplification and the deviations drawn.
    """

    dataset: xr.Dataset
    disk: TunedDisk

    def with_fatigue(
        self, limit: FatigueLimit, mean: Mapping[str, float] | None = None, equivalent: Equivalent = "sines"
    ) -> MistunedPopulation:
        """A copy whose dataset also holds the fatigue margin of each blade at its largest amplitude, for report and tables.

        The sector must have places of stress. Arguments: `ForcedResponse.with_fatigue`.
        """
        return replace(self, dataset=with_blade_fatigue(self.dataset, limit, mean, equivalent))


def mistuned_response(
    disk: TunedDisk,
    band: Band | Sequence[float],
    mistuning: Mistuning,
    force: float = 1.0,
    harmonics: int | Sequence[int] = 5,
    samples: int = 256,
    **options: Any,
) -> MistunedPopulation:
    """The response of all blades of one mistuned disk; arguments and options as of `mistuned_population`."""
    return mistuned_population(disk, band, 1, Scatter(), mistuning, force, harmonics, samples, **options)


@takes(PopulationWork)
def mistuned_population(work: PopulationWork) -> MistunedPopulation:
    """Responses of `count` disks whose sectors deviate at random, all under one engine order and one force level.

    mistuning: deviations that all samples share; with a pattern of the blades there and scatter of contacts alone, the samples
    are one disk mounted again and again. blade: what makes up a blade, see `mistuned_disk`. output: which output of a sector
    is the amplitude of its blade. band, force, harmonics, samples, workers, checkpoint, progress: see `forced_response`; at a
    list of frequencies, maxima are the largest values there. peak_tolerance: by how much maxima over a band may be too low.
    run_in: all start from the sliders of the tuned disk at its highest point (`stickslip.run_in`).
    quantity, measure: what amplitudes and their maxima are of, as for `forced_response`.

    Amplification is the highest amplitude of any blade over the band, divided by that of the tuned disk with the same dampers and
    force. Sample k depends on the seed and k alone, whatever the number of samples and workers. One that fails is marked.
    """
    results = all_cases(work, work.checkpoint, work.workers, work.progress)
    return MistunedPopulation(population_dataset(work, results), work.disk)
