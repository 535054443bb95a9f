"""Execution of jobs up to saved results; completed cases stay in the checkpoint until everything is written.

`remaining` says what an earlier run left; `computed` goes on from there.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import stickslip
from stickslip.results.files import open_results, save, stamped
from stickslip.results.schema import attributes_of
from stickslip.runs import cases
from stickslip.study.faults import WARNING
from stickslip.study.reading import Job
from stickslip.support.checks import InputError
from stickslip.support.files import WrittenFiles, only_own_files
from stickslip.support.late import xr

UNFINISHED = "unfinished"
"""Folder of the checkpoint inside the folder of the results; removed when everything is written."""


@dataclass(frozen=True, eq=False)
class Run:
    """Jobs by name with the folder they are written to; `resume`: what an interrupted run finished is used."""

    jobs: Mapping[str, Job]
    folder: Path
    resume: bool = False
    workers: cases.Workers = 1

    @property
    def words(self) -> str:
        """What is computed, for messages."""
        return ", ".join(dict.fromkeys(job.analysis.replace("_", " ").capitalize() for job in self.jobs.values()))

    @property
    def about(self) -> dict[str, str]:
        """What the results depend on, as texts."""
        matrices = " ".join(job.content for job in self.jobs.values()).strip()
        return {
            **{f"study {name}".strip(): job.text for name, job in self.jobs.items()},
            "content of the matrices": matrices,
            "version of stickslip": stickslip.__version__,
        }

    @property
    def key(self) -> str:
        """`about` in one word, kept in the results."""
        return sha256(repr(sorted(self.about.items())).encode()).hexdigest()

    def kept(self) -> cases.CheckpointFolder:
        """The checkpoint. That of something else are refused by a run that resumes, and removed by any other."""
        place = self.folder / UNFINISHED
        for folder in (self.folder, place):
            for name in ("", *self.jobs):
                WrittenFiles(folder / name).remove_temporary()
        try:
            return cases.CheckpointFolder(place, self.about)
        except InputError:
            if self.resume:
                raise
            cases.CheckpointFolder.remove(place)
            return cases.CheckpointFolder(place, self.about)

    def complete(self) -> "dict[str, xr.Dataset] | None":
        """The results of this very run where they are all there, else None; those of another are refused."""
        files = {name: self.folder / name / "results.nc" for name in self.jobs}
        try:
            datasets = {name: open_results(file) for name, file in files.items() if file.is_file()}
        except InputError:
            return None
        if any(dataset.attrs.get("input_key") != self.key for dataset in datasets.values()):
            studies = ((str(dataset.attrs.get("study", "")), self.jobs[name].text) for name, dataset in datasets.items())
            line = next(filter(None, (cases.changed_line(before, now) for before, now in studies)), "")
            raise InputError(
                f"The results in {str(self.folder)!r} must belong to this run, but come from another study or version{line}. "
                "Add --overwrite instead of --resume to replace them, or name another folder."
            )
        return datasets if len(datasets) == len(files) else None

    @only_own_files()
    def computed(self, kept: cases.CheckpointFolder, progress: cases.Progress) -> "dict[str, xr.Dataset]":
        """The results of all jobs, each saved."""
        for job in self.jobs.values():
            job.plan.begin(progress)
        works = {name: job.plan.works for name, job in self.jobs.items()}
        together = cases.Together(
            {f"{name} {kind}".strip(): work for name, kinds in works.items() for kind, work in kinds.items()}
        )
        checkpoint = kept if self.resume else _Anew(kept)
        try:
            results = cases.all_cases(together, checkpoint, self.workers, progress)
        except cases.Stopped as stop:
            self._save_so_far(together.parted(stop.results), works)
            raise
        progress(1.0, "linear curves and results.nc")
        parts, datasets = together.parted(dict(enumerate(results))), {}
        for name, job in self.jobs.items():
            own = {kind: list(parts[f"{name} {kind}".strip()].values()) for kind in works[name]}
            attributes = {"title": job.title, **_about(job), "input_key": self.key}
            dataset = job.plan.searched(own, checkpoint, self.workers, progress)
            datasets[name] = stamped(dataset).assign_attrs(attributes)
            WrittenFiles(self.folder).remove("report.html")  # an interrupted run leaves no report of other results
            save(datasets[name], self.folder / name / "results.nc")
        return datasets

    def _save_so_far(
        self, parts: Mapping[str, Mapping[int, cases.Arrays]], works: Mapping[str, Mapping[str, cases.Work]]
    ) -> None:
        """Save what a stopped run has, beside the checkpoint, where it is of use without the rest."""
        for name, job in self.jobs.items():
            own = {kind: parts[f"{name} {kind}".strip()] for kind in works[name]}
            work = works[name].get("")
            if not isinstance(work, cases.StoppableWork) or not own[""]:
                continue
            attributes = {"title": f"{job.title} (stopped)", **_about(job)}
            save(stamped(work.so_far(own[""])).assign_attrs(attributes), self.folder / UNFINISHED / name / "results.nc")


def _about(job: Job) -> dict[str, Any]:
    """What results keep of their study: its text, its units and what was warned of."""
    warned = [note.removeprefix(WARNING) for note in job.notes if note.startswith(WARNING)]
    kept = {"study": job.text, "analysis": job.analysis, **attributes_of(job.units)}
    return kept | ({"study_warnings": warned} if warned else {})


class _Anew:
    """Keeps, but does not give back: everything is computed."""

    def __init__(self, kept: cases.CheckpointFolder) -> None:
        self.save = kept.save

    def load(self, name: str) -> None:
        return None
