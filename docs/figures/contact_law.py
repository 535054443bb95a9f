"""Draws the measured record of docs/contact_law.md: `python docs/figures/contact_law.py`, some seconds."""

import gzip
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import stickslip as ss
from stickslip.show.plots.look import CONTACTS, house_style
from stickslip.show.plots.paper import write_figure

HERE = Path(__file__).parent
RECORD = HERE.parents[1] / "tests" / "data" / "tribometer" / "test_data_2.txt.gz"
EVERY = 4
"""Samples of a loop from one drawn point to the next."""


def loops_and_friction():
    """Three of the mean loops with the fit, and kt, friction and energy over the cycles."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "record.txt").write_bytes(gzip.decompress(RECORD.read_bytes()))
        data = ss.contact_law(Path(folder) / "record.txt", normal_load=5.0).dataset
    with house_style():
        figure = Figure(figsize=(8.4, 4.2), layout="constrained")
        left, right = figure.subfigures(1, 2)
        axes = left.subplots()
        for place, colour in ((0, CONTACTS[4]), (-1, CONTACTS[0])):
            one = data.isel(loop=place, sample=slice(None, None, EVERY))
            axes.plot(
                1e6 * one["displacement"], one["force_measured"], color=colour, linewidth=2.2, label=str(one["loop"].values)
            )
        axes.plot(1e6 * one["displacement"], one["force_fitted"], color=CONTACTS[1], linewidth=1.2, label="one slider")
        axes.set(xlabel="displacement in µm", ylabel="friction force in N")
        axes.legend(loc="lower right", fontsize=7)
        number = data["cycle_number"].values
        for axes, name, factor, words in zip(
            right.subplots(3, 1, sharex=True),
            ("cycle_kt", "cycle_mu", "energy_measured"),
            (1e-6, 1.0, 1e3),
            ("kt in N/µm", "µ", "energy in mJ"),
            strict=True,
        ):
            axes.plot(number, factor * data[name].values, ".-", color=CONTACTS[0], linewidth=1.0, markersize=3)
            axes.set(ylabel=words, xlabel="cycle" if name == "energy_measured" else "")
        axes.plot(number, 1e3 * data["energy_fitted"].values, color=CONTACTS[1], linewidth=1.0)
        assert np.all(np.diff(number) == 1)
    return figure


if __name__ == "__main__":
    write_figure(loops_and_friction(), HERE / "contact_law.svg", "svg")
