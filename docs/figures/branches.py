"""Draws the figures of docs/branches.md: `python docs/figures/branches.py`."""

import contextlib
import runpy
import tempfile
from pathlib import Path

from stickslip.show.plots.paper import write_figure

HERE = Path(__file__).resolve().parent

if __name__ == "__main__":
    for name, example in (("branch", "branch_of_two_masses"), ("isolated", "isolated_response_of_an_absorber")):
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
            response = runpy.run_path(str(HERE.parents[1] / "examples" / f"{example}.py"))["response"]
        write_figure(response.plot(), HERE / f"{name}.svg", "svg")
