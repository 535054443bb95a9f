"""How far the peaks of two blades and a wedge with fewer contacts than nodes are from those with all nodes."""

import gzip
from pathlib import Path

import numpy as np
import pytest

import stickslip as ss

DATA = Path(__file__).parents[1] / "data" / "calculix"
PAGE = Path(__file__).parents[2] / "docs" / "calculix.md"

CHANGES = {4: (-0.021, 0.029, 0.14), 8: (0.005, 0.012, 0.056), 12: (-0.014, 0.002, 0.013)}
"""By points of each side: the change of the peak at 5, 20 and 60 N when it is solved with all nodes."""


@pytest.mark.nightly
def test_the_table_of_the_tutorial(tmp_path):
    """Against curves traced with all nodes, which `patch_error` is to predict."""
    for name in ("inp", "dof"):
        (tmp_path / f"platform_blade.{name}").write_bytes((DATA / f"platform_blade.{name}").read_bytes())
    for name in ("sti", "mas"):
        packed = DATA / f"platform_blade.{name}.gz"
        (tmp_path / f"platform_blade.{name}").write_bytes(gzip.decompress(packed.read_bytes()))
    text = PAGE.read_text().partition("Two such blades stand")[2].partition("```toml\n")[2].partition("```")[0]

    def response(points):
        (tmp_path / "study.toml").write_text(text.replace("mu = 0.4", f"mu = 0.4\n{points}"))
        problem = ss.read_problem(tmp_path / "study.toml")
        return ss.forced_response(problem, ss.hertz(400.0, 750.0), [5.0, 20.0, 60.0], harmonics=5, samples=256).dataset

    traced = response("")["peak_amplitude"].values[:, 0, 0]
    for points, changes in CHANGES.items():
        found = response(f"points = {points}")
        errors = found["patch_error"].values[:, 0]
        np.testing.assert_allclose(errors, changes, atol=6e-4, rtol=0.04)
        np.testing.assert_allclose(errors, traced / found["peak_amplitude"].values[:, 0, 0] - 1.0, atol=5e-4)
