"""Study files: from TOML to a problem and what to compute of it. `read` is the way in; it finds all faults of a file at once."""

from stickslip.study.read import Job, job, read

__all__ = ["Job", "job", "read"]
