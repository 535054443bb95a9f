"""The report: one self-contained HTML page per run that opens offline, `write(dataset, path)`.

`page` lays it out, `sections` or, of most analyses, `plain` fill it; `markup` gathers the charts that report.js draws.
"""

from stickslip.show.report.page import write

__all__ = ["write"]
