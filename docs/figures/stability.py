"""Draws the figure of docs/stability.md: `python docs/figures/stability.py`."""

import runpy
from pathlib import Path

from stickslip.show.plots.paper import write_figure

HERE = Path(__file__).parent

if __name__ == "__main__":
    response = runpy.run_path(str(HERE.parents[1] / "examples" / "stability_of_a_mass_at_a_stop.py"))["response"]
    write_figure(response.plot(), HERE / "stability.svg", "svg")
