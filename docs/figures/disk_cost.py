"""Measures and draws the cost of a mistuned disk for docs/disks.md: `python docs/figures/disk_cost.py`, some minutes.

The lumped disk, case W, 0.3 % scatter of the blade frequencies, 1.6 N, all dampers in slip: CPU time of a solved point.
"""

from dataclasses import replace
from pathlib import Path
from time import process_time

import numpy as np
from matplotlib.figure import Figure
from threadpoolctl import threadpool_limits

import stickslip as ss
from stickslip.show.plots.look import CONTACTS, house_style
from stickslip.show.plots.paper import write_figure
from stickslip.solve.balance.balance import HarmonicBalance
from stickslip.solve.continuation.continuation import first_point, trace

HERE = Path(__file__).parent
BASE = {"sectors": 12, "contact nodes a line": 1, "harmonics": 3}
VALUES = {"sectors": (6, 12, 24, 48), "contact nodes a line": (1, 2, 4, 8), "harmonics": (1, 3, 5, 9)}
SECONDS = 20.0


def with_nodes(disk, count):
    """Each contact shared by `count` equal ones."""
    shared = [replace(c.law, kt=c.law.kt / count, kn=c.law.kn / count) for c in disk.contacts]
    contacts = [
        replace(c, law=law, name=f"{c.name}.{k}") for c, law in zip(disk.contacts, shared, strict=True) for k in range(count)
    ]
    return replace(disk, contacts=tuple(contacts))


def cost(chosen):
    """CPU time of a point [s], of the preparation [s], and the most unknowns of a point."""
    sectors, nodes, harmonics = chosen.values()
    disk = with_nodes(ss.rigs.lumped_blisk("W", sectors=sectors), nodes)
    middle = float(disk.frequencies(stuck=True)[0])
    began = process_time()
    mistuned = ss.mistuned_disk(disk, ss.Scatter(blade=0.003).draw(sectors, 0, 0))
    balance = HarmonicBalance(mistuned, harmonics, 96)
    first = first_point(balance, 2 * np.pi * (middle - 2.0), 1.6)
    prepared, began = process_time() - began, process_time()
    unknowns = []
    for point in trace(balance, first, "omega", 2 * np.pi * (middle + 2.0)):
        unknowns.append(point.active)
        if process_time() - began > SECONDS:
            break
    return (process_time() - began) / max(len(unknowns) - 1, 1), prepared, max(unknowns)


def drawn(found):
    """A panel for each variable, logarithmic axes."""
    with house_style():
        figure = Figure(figsize=(9.0, 3.2), layout="constrained")
        for axes, (name, rows) in zip(figure.subplots(1, 3, sharey=True), found.items(), strict=True):
            axes.loglog(VALUES[name], [1e3 * row[0] for row in rows], "o-", ms=4, color=CONTACTS[0])
            axes.set(xlabel=name)
            axes.set_xticks(VALUES[name], [str(value) for value in VALUES[name]])
            axes.minorticks_off()
        figure.axes[0].set(ylabel="CPU time of a point in ms")
    return figure


if __name__ == "__main__":
    with threadpool_limits(1, user_api="blas"):
        cost(BASE)
        found = {name: [cost(BASE | {name: value}) for value in values] for name, values in VALUES.items()}
    for name, rows in found.items():
        for value, (per_point, prepared, unknowns) in zip(VALUES[name], rows, strict=True):
            print(f"| {name} {value} | {1e3 * per_point:.2f} | {prepared:.2f} | {unknowns} |")
    write_figure(drawn(found), HERE / "disk_cost.svg", "svg")
