"""Response of one mistuned disk or of a random population of them, compared with the tuned disk."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from stickslip.analyses.fatigue import Equivalent
from stickslip.analyses.mistuning.dataset import population_dataset, with_blade_fatigue
from stickslip.analyses.mistuning.disk import Mistuning, Scatter
from stickslip.analyses.mistuning.work import PopulationWork
from stickslip.analyses.settings import takes
from stickslip.model.disks.tuned import TunedDisk
from stickslip.model.structure.fatigue import FatigueLimit
from stickslip.results.result import Result
from stickslip.runs.cases import all_cases
from stickslip.support.late import xr
from stickslip.support.renamed import renamed_arguments
from stickslip.support.units import Band


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


@renamed_arguments(finished="checkpoint")
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
