"""Code on the pages runs, and computes what the page says."""

import re
from pathlib import Path

import numpy as np

import stickslip as ss

DOCS = Path(__file__).parents[2] / "docs"


def test_the_problem_of_another_code_is_the_same_here():
    """The three masses of docs/other_codes.md are the rig that is compared with the other code's curves."""
    (block,) = re.findall(r"```python\n(.*?)```", (DOCS / "other_codes.md").read_text(), re.S)
    names = {}
    exec(block, names)
    peaks = names["response"].peaks()
    rig = ss.forced_response(ss.rigs.chain_of_three(), ss.radians_per_second(0.5, 2.0), harmonics=7, samples=1024).peaks()
    for column in ("frequency", "amplitude"):
        np.testing.assert_allclose(peaks[column], rig[column], rtol=1e-6)


def test_the_pages_of_analyses_end_with_what_to_read_next():
    """All pages in the contents but references, which nobody reads from the start to the end."""
    listed = re.findall(r"^[a-z_]+$", (DOCS / "index.md").read_text(), re.M)
    references = {"examples", "glossary", "verification", "robustness", "benchmarks", "api"}
    ends = {name: (DOCS / f"{name}.md").read_text().rstrip().rpartition("\n\n")[2] for name in listed if name not in references}
    assert len(ends) > 20
    assert not [name for name, end in ends.items() if not re.match(r"Next: .*\]\([a-z_]+\.md\)", end, re.S)]
