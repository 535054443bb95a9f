"""Forced response in a study: its sweeps, and the stresses, stability and further curves that its tables ask for."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from stickslip.analyses.forced_response import ForcedResponseWork
from stickslip.analyses.settings import ForcedResponseSettings
from stickslip.model.structure.stress import StressRecovery
from stickslip.runs.cases import Arrays, Checkpoint, Progress, Workers, silent
from stickslip.solve.time.period import refuse_waves
from stickslip.study import further_curves
from stickslip.study.analysis import Asked, Kind, Plan, summary_of
from stickslip.study.fields import Table
from stickslip.support.late import xr


@dataclass(frozen=True, eq=False)
class ForcedResponsePlan(Plan):
    """Curves over the band for every force level, those that no sweep meets, and what is asked along all of them."""

    sweep: ForcedResponseSettings
    further: further_curves.FurtherCurves
    recovery: StressRecovery | None = None
    fatigue: "Callable[[xr.Dataset], xr.Dataset] | None" = None
    stability: further_curves.StabilityTable | None = None
    reached: further_curves.ReachedTable | None = None

    @classmethod
    def of(cls, asked: Asked) -> "ForcedResponsePlan":
        """The plan of a study."""
        recovery, further = further_curves.recovery_of(asked), further_curves.FurtherCurves.of(asked)
        fatigue, stability = further_curves.fatigue_of(asked, recovery), asked.table(further_curves.StabilityTable)
        plan = cls(sweep_of(asked), further, recovery, fatigue, stability, further_curves.reached_of(asked))
        if plan.further.periods > 1 and plan.sweep.harmonics != "auto":
            _ = plan.works
        return plan

    @property
    def summary(self) -> str:
        return summary_of(self.sweep) + (", then what is reached by time integration" if self.reached is not None else "")

    @cached_property
    def works(self) -> Mapping[str, ForcedResponseWork]:
        return {"": ForcedResponseWork.of(replace(self.sweep, periods=self.further.periods, isolated=self.further.search))}

    def begin(self, progress: Progress) -> None:
        """Of a finite-element model, the coordinates that its highest peaks need."""
        self.__dict__["works"] = {name: work.with_shapes(progress) for name, work in self.works.items()}
        if self.reached is not None:
            refuse_waves(self.works[""].problem)  # few coordinates may have springs that hold mean positions
            self.reached.refuse_few_steps(self.works[""].harmonics)

    def searched(
        self, results: Mapping[str, Sequence[Arrays]], checkpoint: Checkpoint, workers: Workers, progress: Progress
    ) -> "xr.Dataset":
        work, curves = self.works[""].settled(list(results[""]), checkpoint, workers, progress)
        self.__dict__["works"] = {"": work}
        return self.dataset({"": curves}, progress)

    def dataset(self, results: Mapping[str, Sequence[Arrays]], progress: Progress = silent) -> "xr.Dataset":
        work = self.works[""]
        response = self.further.added(work.gathered(results[""]), work)
        response = response if self.stability is None else response.with_stability(self.stability.highest)
        if self.reached is not None:
            output = 0 if self.reached.output is None else work.problem.output_names.index(self.reached.output)
            how = self.reached.model_dump(include={"steps_per_period", "periods"})
            response = response.with_reached(output, **how, progress=progress)
        if self.recovery is not None:  # on few coordinates of a mesh it is that of the response
            response = response.with_stress(self.recovery if response.problem.mesh is None else None)
        found = response.with_motion().dataset
        return found if self.fatigue is None else self.fatigue(found)


def sweep_of(asked: Asked) -> ForcedResponseSettings:
    """The sweep of an analysis that has one."""
    if asked.sweep is None:
        raise AssertionError("an analysis of a problem has a sweep")
    return asked.sweep


OPTIONAL: dict[str, type[Table]] = {
    "stress": further_curves.StressTable,
    "fatigue": further_curves.FatigueTable,
    "stability": further_curves.StabilityTable,
    "reached": further_curves.ReachedTable,
    "isolated": further_curves.IsolatedTable,
    "branches": further_curves.BranchesTable,
}
KIND = Kind(ForcedResponsePlan.of, OPTIONAL, optional=OPTIONAL, repeats=True, from_mesh=True)
