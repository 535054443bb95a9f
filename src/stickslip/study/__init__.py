"""Study files: from TOML to a problem and its analysis. `read` is the entry point; it reports all faults of a file at once."""

from stickslip.study.read import Job, job, read

__all__ = ["Job", "job", "read"]
