"""Measured loops named on the command line, in place of those of a study."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from stickslip.checks import fault
from stickslip.study.identification import IdentificationPlan
from stickslip.study.read import Job


def with_loops(job: Job, loops: Sequence[Path]) -> Job:
    """A job for other loops than those of its study."""
    if not isinstance(job.plan, IdentificationPlan):
        raise fault("--damper", 'must be a study with analysis = "identification"', job.analysis)
    missing = [str(path) for path in loops if not path.is_file()]
    if missing:
        raise fault("LOOPS", "must be files", ", ".join(missing))
    return replace(job, plan=job.plan.with_loops(loops), text=f"{job.text}# loops: {', '.join(map(str, loops))}\n")
