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
