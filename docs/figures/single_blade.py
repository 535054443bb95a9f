"""The figure of the first pages, the single blade at six force levels: `python docs/figures/single_blade.py`, some seconds."""

from pathlib import Path

import stickslip as ss

HERE = Path(__file__).parent

if __name__ == "__main__":
    levels = [1.0, 5.0, 20.0, 50.0, 80.0, 100.0]
    response = ss.forced_response(ss.rigs.single_blade(preload_mass=4.6), ss.hertz(390, 600), levels, quantity="receptance")
    figure = response.plot()
    figure.savefig(HERE / "single_blade.svg", metadata={"Date": None})
    figure.savefig(HERE.parents[1] / "paper" / "single_blade.png", dpi=150)
