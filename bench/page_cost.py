"""The sections of the benchmark page on the cost itself: near the limit, and how it grows."""

from __future__ import annotations

from typing import Any

import figures
from page_comparison import BLADE_NAME
from tables import markdown

LIMIT_NAMES = {"contact_sweep": "contact laws", "motion": "motion", "receptance": "receptance", "factorisation": "factorisation"}


def limit(found: dict[str, Any]) -> str:
    rows = []
    for case, part in found.items():
        if "failed" in part:
            continue
        cells = [f"{1e6 * part[key]:.1f}" for key in LIMIT_NAMES]
        name = BLADE_NAME if case == "blade" else case
        rows.append(
            [
                name,
                str(part["active"]),
                *cells,
                f"{1e6 * part['iteration']:.1f}",
                f"{part['ratio']:.2f}",
                f"{1e3 * part['per_point']:.3f}",
            ]
        )
    head = (
        "case",
        "unknown rows",
        *(f"{name}, µs" for name in LIMIT_NAMES.values()),
        "whole iteration, µs",
        "ratio",
        "ms a point",
    )
    return f"""
## Near the limit

What a Newton iteration cannot do without, at the point of a sweep with the most unknowns: one sweep of the contact laws with
its derivative, the motion of contacts and outputs, their receptance at every harmonic, and one dense factorisation of the
unknown rows as LAPACK does it here; each repeated in a compiled loop, so that no call from Python is counted. Beside it the
whole iteration (evaluate, assemble, factorise, solve) and the ratio of it to the sum of the parts.

{markdown(head, rows)}

The aim is a ratio below 2 where more than 100 rows are unknown, and below 0.2 ms a point for B1. Here a point is one of a curve
traced at the default steps, all refused steps counted; in the first table it is that of the whole sweep from building the
problem on, at the setting that makes the curve right with the fewest seconds.
"""


def scaling(found: list[dict[str, Any]]) -> str:
    """Wall time of each kind of work by several processes."""
    counts = [int(count) for count in found[0]["processes"]]
    rows = []
    for row in found:
        runs = {int(count): run for count, run in row["processes"].items()}
        most = max(counts)
        possible = most * runs[1]["wall"] / row["apart"]
        walls = [f"{runs[count]['wall']:.1f}" for count in counts]
        before = runs[1]["before"]
        faster = f"{runs[1]['wall'] / runs[most]['wall']:.2f}"
        alone = f"{(runs[1]['wall'] - before) / (runs[most]['wall'] - runs[most]['before']):.2f}"
        extra = f"{runs[most]['cpu'] - runs[1]['cpu']:.1f}"
        rows.append([row["kind"], str(row["cases"]), f"{before:.1f}", *walls, faster, alone, f"{possible:.2f}", extra])
    names = [f"wall s, {count} process{'es' if count > 1 else ''}" for count in counts]
    head = ("work", "cases", "import and model, s", *names, "times faster", "the analysis", "possible here", "more CPU s")
    return f"""
## Many cases on several cores

Wall time of a script with one call, kernels compiled, the start of worker processes included; and how much faster the call
itself is, without import and model, which no process can share. "Possible here": as many
separate runs of one process at once as there are cores, and what they get done together compared with one alone; where cores
share their caches and clock, it is less than their number.

{markdown(head, rows)}
"""


def growth(found: dict[str, Any]) -> str:
    sections = []
    for kind, label in figures.AXES.items():
        measured = found[kind]
        rows = [
            [
                str(row["value"]),
                f"{1e3 * row['per_point']:.3f}",
                f"{row['iterations']:.2f}",
                str(row["most_active"]),
                f"{row['setup']:.3f}",
            ]
            for row in measured["rows"]
            if "per_point" in row
        ]
        head = (label, "ms a point", "Newton steps a point", "most unknowns", "set-up, s")
        text = (
            f"Observed slope at the end {measured['observed_slope_at_the_end']:.2f}, "
            f"expected {measured['expected_slope']:g}: {measured['because']}."
        )
        sections.append(f"{markdown(head, rows)}\n\n{text}")
    return """
## How cost grows

A row of masses with sliders to ground, all pushed alike so that every slider slips near resonance. Contacts and structure size:
400 masses, 4 contacts, H 3, 128 samples unless varied; harmonics and samples: 20 masses, 10 contacts, H 7, 256 samples unless
varied. Dashed: the slope that the dominating part should give in the end.

![CPU time of a point against contacts, harmonics, samples and structure size](figures/benchmark_growth.svg)

""" + "\n\n".join(sections)


def fe_blades(found: dict[str, Any]) -> str:
    """Time and memory of the command on two finite-element blades."""
    rows = [
        [
            row["name"],
            str(row["rows"]),
            str(row["contacts"]),
            f"{row['cpu']:.1f}",
            f"{row['cpu'] / found['B2a']:.0f}",
            f"{row['peak_memory_MiB']:.0f}" if row["peak_memory_MiB"] else "",
        ]
        for row in found["rows"]
    ]
    head = ("problem", "rows of a blade", "contacts", "CPU s", "sweeps of B2a", "peak memory, MiB")
    return f"""
## Two finite-element blades

Two blades of quadratic elements with a wedge between their platforms, with a contact at each node of both undersides or at 24
points a side. The time is that of the whole command `stickslip run`: it reads and reduces the files of the finite-element
program, traces three force levels with their peaks, and writes results and report. Each row is a process of its own with compiled
kernels. The last row is one frequency of a mass on rigid friction. For comparison with other machines, the time is also given in
sweeps of B2a with peaks, {1e3 * found["B2a"]:.0f} CPU ms in the same run.

{markdown(head, rows)}
"""


def many_contacts(found: dict[str, Any]) -> str:
    """Time and memory of a point against the number of contact nodes."""
    rows = [
        [
            row["law"],
            str(row["nodes"]),
            str(row["unknowns"]),
            f"{row['iterations']:.2f}",
            f"{row['factorisations']:.2f}",
            f"{1e-9 * row['multiplications']:.1f}",
            f"{row['cpu']:.2f}",
            f"{row['wall']:.2f}",
            f"{row['threaded_wall']:.2f}",
            f"{row['peak_memory_MiB']:.0f}",
        ]
        for row in found["rows"]
    ]
    head = (
        "law",
        "nodes",
        "most unknowns",
        "Newton steps a point",
        "factorisations a point",
        "10⁹ multiplications each",
        "CPU s a point",
        "wall s a point",
        f"wall s, {found['cores']} BLAS threads",
        "peak memory, MiB",
    )
    return f"""
## Many contacts

A plate on {found["modes"]} modes, pressed on the ground over many nodes with a normal and two tangential directions each, most of
which slip; H 3, 128 samples. Contact stiffness and preload are shared by the nodes, so that the motion hardly depends on their
number. Each row is a process of its own; the points are the first of a curve at default steps.

{markdown(head, rows)}

Where slipping directions outnumber the modes, Newton's linear system is solved on the modes: its matrix has
{found["modes"]} (2H + 1) = {found["modes"] * 7} rows however many nodes slip, and the contacts enter it by sums over the nodes.
With fewer nodes, here 100, the matrix of the slipping directions takes less work. The choice is made at every iteration.
"""
