"""Measured loops from the command line, which replace those of a study."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from stickslip.laboratory.identification.damper.model import LINE_LAWS
from stickslip.study.analyses.identification import IdentificationPlan
from stickslip.study.reading import Job
from stickslip.support.checks import existing, fault, nearest


def with_loops(job: Job, loops: Sequence[Path], laws: Sequence[str] = (), removals: Sequence[Path] = ()) -> Job:
    """A job for other loops than those of its study with their own load removals if there are any, and other laws if named."""
    if not isinstance(job.plan, IdentificationPlan):
        raise fault("--damper", 'must be a study with analysis = "identification"', job.analysis)
    for what, paths in (("LOOPS", loops), ("--load-removal", removals)):
        existing(what, paths)
    for law in laws:
        if law not in LINE_LAWS:
            raise fault("--law", "must be a known one", law, nearest(law, LINE_LAWS))
    note = f"# loops: {', '.join(map(str, loops))}; law: {', '.join(laws) or 'as above'}"
    note += f"; load removals: {', '.join(map(str, removals)) or 'none'}"
    plan = job.plan.with_loops(loops, laws, removals)
    return replace(job, plan=plan, content=plan.content, text=f"{job.text}{note}\n")
