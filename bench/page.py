"""The benchmark's table for the terminal and its page for the documentation, both from the measured numbers alone."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from datetime import date
from pathlib import Path
from typing import Any

import figures

TARGETS = {"B1": 20, "B2a": 50, "B2b": 100}
BLADE_NAME = "single blade, 80 N"
LIMIT_NAMES = {"contact_sweep": "contact laws", "motion": "motion", "receptance": "receptance", "factorisation": "factorisation"}


def table(found: dict[str, Any]) -> str:
    """The headline in plain text."""
    rows = [_headline_row(case, result) for case, result in found.get("headline", {}).items()]
    widths = [max(len(row[i]) for row in [HEADLINE, *rows]) for i in range(len(HEADLINE))]
    return "\n".join("  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in [HEADLINE, *rows])


HEADLINE = (
    "case",
    "stickslip CPU s",
    "pyHarm CPU s",
    "times less",
    "points",
    "points pyHarm",
    "ms/point",
    "ms/point pyHarm",
    "difference",
)


def _headline_row(case: str, result: dict[str, Any]) -> list[str]:
    ours, theirs = result["stickslip"], result["pyHarm"]
    note = "" if result["both_right"] else " *"
    return [
        case,
        f"{ours['cpu']:.4f}",
        f"{theirs['cpu']:.3f}",
        f"{result['ratio_of_sweeps']:.1f}{note}",
        str(ours["points"]),
        str(theirs["points"]),
        f"{1e3 * ours['cpu_per_point']:.3f}",
        f"{1e3 * theirs['cpu_per_point']:.2f}",
        f"{theirs['difference'].get('largest', float('nan')):.1e}",
    ]


def write(found: dict[str, Any], docs: Path) -> None:
    """docs/benchmarks.md and its figures, from whatever has been measured."""
    folder = docs / "figures"
    folder.mkdir(exist_ok=True)
    parts = [_opening(found)]
    if "headline" in found:
        figures.curves(found["headline"], folder / "benchmark_curves.svg")
        parts += [_headline(found["headline"]), _accuracy(found["headline"])]
    parts += [_startup(found["startup"])] if "startup" in found else []
    parts += [_limit(found["limit"])] if "limit" in found else []
    if "growth" in found:
        figures.growth(found["growth"], folder / "benchmark_growth.svg")
        parts.append(_growth(found["growth"]))
    parts += [_blade(found["blade"], found.get("pyharm_blade"))] if "blade" in found else []
    parts += [_memory(found["memory"])] if "memory" in found else []
    parts.append(METHOD)
    (docs / "benchmarks.md").write_text("\n\n".join(part.strip() for part in parts) + "\n")


def _markdown(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + " --- |" + " ---: |" * (len(head) - 1)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def _opening(found: dict[str, Any]) -> str:
    machine, versions = found["machine"], found["versions"]
    day = date.fromisoformat(found["date"])
    ours, theirs = versions["stickslip"], versions["pyHarm"]
    return f"""
# Benchmarks

`make bench` measures stickslip beside [pyHarm](https://gitlab.com/drti/pyharm), an open harmonic balance code, on the same
problems in one run, and writes this page. All times are CPU times of one core, with one BLAS thread.

Measured on {day.day} {day:%B %Y} on {machine["cores"]} cores of a {machine["processor"]} ({machine["system"]},
{machine["architecture"]}).

* stickslip {ours["stickslip"]}, {_versions(ours)}
* pyHarm {theirs["pyHarm-os"]}, {_versions(theirs)}, JAX {theirs["jax"]}

The problems: **B1**, one mass with a friction slider to ground, at four force levels; **B2a**, a chain of 20 masses with ten
sliders of constant load; **B2b**, the same chain with a second direction that loads and unloads the friction. Harmonics 0 to 7,
256 samples in a period.
"""


def _versions(versions: dict[str, str]) -> str:
    return ", ".join(f"{name} {versions[name.lower()]}" for name in ("Python", "NumPy", "SciPy", "Numba"))


def _headline(found: dict[str, Any]) -> str:
    head = (
        "case",
        "stickslip, CPU s",
        "pyHarm, CPU s",
        "times less",
        "points",
        "pyHarm",
        "ms a point",
        "pyHarm",
        "times less a point",
    )
    rows = []
    for case, result in found.items():
        row = _headline_row(case, result)
        rows.append([*row[:8], f"{result['ratio_per_point']:.0f}"])
    return f"""
## A sweep that is right

CPU seconds of a sweep of the whole band whose highest point is within 1e-3 of the true peak and whose points, joined by
monotone cubic interpolation, lie within 1e-2 of the peak's height of the true curve everywhere. Each code runs at the best of
the settings that were tried (see [below](#how-it-is-measured)); import and compilation come [apart](#before-the-first-point).

{_markdown(head, rows)}

{_verdict(found)}

Points of the chosen sweeps on the true curve (grey):

![The curves with the points of both codes](figures/benchmark_curves.svg)
"""


def _verdict(found: dict[str, Any]) -> str:
    """Targets against what was measured, B1 as the sum over its force levels."""
    sentences = []
    for problem, target in TARGETS.items():
        results = [result for case, result in found.items() if case.split()[0] == problem]
        ratio = sum(r["pyHarm"]["cpu"] for r in results) / sum(r["stickslip"]["cpu"] for r in results)
        reached = "reached" if ratio >= target else "missed"
        sentences.append(f"{problem} {ratio:.0f} times less (target {target}: {reached})")
    starred = [case for case, result in found.items() if not result["both_right"]]
    note = f" A star marks cases where one code was not right at any setting tried: {', '.join(starred)}." if starred else ""
    return "Over all force levels: " + "; ".join(sentences) + "." + note


def _accuracy(found: dict[str, Any]) -> str:
    head = (
        "case",
        "peak error",
        "pyHarm",
        "curve error",
        "pyHarm",
        "fewest points for the peak",
        "pyHarm",
        "Newton steps a point",
        "Jacobians a point, pyHarm",
    )
    rows, answers = [], []
    for case, result in found.items():
        ours, theirs = result["stickslip"], result["pyHarm"]
        rows.append(
            [
                case,
                *(f"{side[key]:.1e}" for key in ("peak_error", "curve_error") for side in (ours, theirs)),
                *(str(side["points_for_peak"]) for side in (ours, theirs)),
                f"{ours['iterations']:.2f}",
                f"{theirs['iterations']:.2f}",
            ]
        )
        difference, whole = theirs["difference"], ours["whole_analysis"]
        answers.append(
            [
                case,
                f"{result['peak']:.6g} at {result['peak_omega']:.6g}",
                str(difference.get("frequencies")),
                f"{difference.get('largest', float('nan')):.1e}",
                f"{difference.get('median', float('nan')):.1e}",
                f"{whole.get('cpu', float('nan')):.3f}",
            ]
        )
    answers_head = (
        "case",
        "peak of the first harmonic, at rad/s",
        "frequencies compared",
        "largest difference",
        "median",
        "`forced_response`, CPU s",
    )
    return f"""
### Errors and effort of these sweeps

{_markdown(head, rows)}

"Fewest points" is the smallest sweep of those tried with the peak right to 1e-3, whatever its curve.

### The answers agree

At frequencies that pyHarm chose, stickslip solves exactly there; the difference is the largest of any harmonic, relative to the
largest harmonic. The last column is the whole analysis as a user calls it: the sweep at default steps, every peak solved to
1e-8, energies, contact states, loops and the labelled dataset.

{_markdown(answers_head, answers)}
"""


def _startup(found: dict[str, Any]) -> str:
    rows = []
    for name, states in found.items():
        for state, label in (("first_process", "first run ever"), ("next_process", "next process")):
            measured = states[state]
            compiled = [measured["compile_cpu"][case] for case in ("B1 F=1", "B2a", "B2b")]
            cells = ["–" if value is None else f"{value:.2f}" for value in compiled]
            rows.append(
                [f"{name}, {label}", f"{measured['import_cpu']:.2f}", *cells, f"{measured['wall_until_first_sweep']:.1f}"]
            )
    head = ("process", "import, CPU s", "compile B1", "then B2a", "then B2b", "wall s until B1 is solved")
    return f"""
## Before the first point

Import and compilation, each in a process of its own: once with an empty cache of compiled kernels, once with the cache that the
first left behind.

{_markdown(head, rows)}
"""


def _limit(found: dict[str, Any]) -> str:
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
unknown rows as LAPACK does it here. Beside it the whole iteration (evaluate, assemble, factorise, solve) and the ratio of it
to the sum of the parts.

{_markdown(head, rows)}

The aim is a ratio below 2 where more than 100 rows are unknown, and below 0.2 ms a point for B1.
"""


def _growth(found: dict[str, Any]) -> str:
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
        sections.append(f"{_markdown(head, rows)}\n\n{text}")
    return """
## How cost grows

A row of masses with sliders to ground, all pushed alike so that every slider slips near resonance. Contacts and structure size:
400 masses, 4 contacts, H 3, 128 samples unless varied; harmonics and samples: 20 masses, 10 contacts, H 7, 256 samples unless
varied. Dashed: the slope that the dominating part should give in the end.

![CPU time of a point against contacts, harmonics, samples and structure size](figures/benchmark_growth.svg)

""" + "\n\n".join(sections)


def _blade(found: dict[str, Any], attempt: dict[str, Any] | None) -> str:
    text = f"""
## The single blade with two dampers

{found["size"]} degrees of freedom after reduction, {found["rows"]} contact directions, H 5, 256 samples, 480 to 600 Hz at 80 N:
{found["points"]} points in {found["cpu"]:.3f} s of CPU, {1e3 * found["cpu"] / found["points"]:.2f} ms a point,
{found["iterations"]:.2f} Newton steps a point, at most {found["active"]} unknowns.
"""
    return text + (attempt or {}).get("sentence", "")


def _memory(found: dict[str, Any]) -> str:
    cases = list(found["stickslip"])

    def cell(value: float | None) -> str:
        return "–" if value is None else f"{value:.0f}"

    names = [BLADE_NAME if case == "blade" else case for case in cases]
    rows = [[name, *(cell(values.get(case)) for case in cases)] for name, values in found.items()]
    return f"""
## Peak memory

Peak resident memory, in MiB, of a process that imports the code and does one sweep at the chosen settings. The blade's
includes meshing and reducing it.

{_markdown(("code", *names), rows)}
"""


METHOD = """
## How it is measured

* Both codes run in processes of their own, warm, in turn in the same run; the time of a sweep is the least of three, from
  building the problem to the last solved point. CPU time, not wall time.
* stickslip's settings: step sizes and error aims of its continuation. pyHarm's: largest step, arc-length and pseudo-arc-length
  corrector, characteristic length, then on the best of these its Newton solver instead of SciPy's, the secant predictor and the
  reduction to nonlinear degrees of freedom. Each code keeps the cheapest setting that is right. The tolerances of both are their
  defaults; stickslip's, 1e-11 of the contact forces, is the tighter one.
* The true curve: stickslip at about 1600 given frequencies, solved exactly at each; the peak is solved, not interpolated. That
  pyHarm agrees at its own frequencies is the independent check.
* Monotone cubic interpolation of |X₁| over frequency joins the points of both codes.
* pyHarm runs in double precision (JAX's default is single). In B2b its contact wants three directions; naming the tangential one
  twice, with half the stiffness and μ/√2, gives the same law on two degrees of freedom a node and is cheaper than a third.
* "Jacobians a point" counts pyHarm's evaluations of the system's Jacobian; the solver of SciPy updates it between.

Earlier figures of another open code, tmdsimpy, on the same problems and two cores of another machine: 4.7 ms a point on B1,
130 ms on B2a, 880 ms on B2b.
"""
