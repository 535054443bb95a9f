"""The sections of the benchmark page that set stickslip beside pyHarm, and the table for the terminal."""

from __future__ import annotations

from typing import Any

from tables import markdown

TARGETS = {"B1": 20, "B2a": 50, "B2b": 100}
BLADE_NAME = "single blade, 80 N"


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


def headline(found: dict[str, Any]) -> str:
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

{markdown(head, rows)}

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
        single = sorted(result["pyHarm"]["cpu"] / result["stickslip"]["cpu"] for result in results)
        levels = f"; single levels {single[0]:.0f} to {single[-1]:.0f}" if len(single) > 1 else ""
        sentences.append(f"{problem} {ratio:.0f} times less (target {target}: {reached}{levels})")
    starred = [case for case, result in found.items() if not result["both_right"]]
    note = f" A star marks cases where one code was not right at any setting tried: {', '.join(starred)}." if starred else ""
    return "Over all force levels: " + "; ".join(sentences) + "." + note


def accuracy(found: dict[str, Any]) -> str:
    head = (
        "case",
        "peak error",
        "pyHarm",
        "curve error",
        "pyHarm",
        "fewest points for the peak",
        "pyHarm",
        "Newton steps a point",
        "evaluations a point",
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
                f"{ours['evaluations']:.2f}",
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

{markdown(head, rows)}

"Fewest points" is the smallest sweep of those tried with the peak right to 1e-3, whatever its curve. Newton steps count
accepted points; evaluations and Jacobians count everything, refused steps and the search of the step length included.

### The answers agree

At frequencies that pyHarm chose, stickslip solves exactly there; the difference is the largest of any harmonic, relative to the
largest harmonic. The last column is the whole analysis as a user calls it: the sweep at default steps, every peak solved to
1e-8, energies, contact states, loops and the labelled dataset.

{markdown(answers_head, answers)}
"""


def startup(found: dict[str, Any]) -> str:
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

{markdown(head, rows)}
"""


def blade(found: dict[str, Any]) -> str:
    ours, theirs = found["stickslip"], found["pyHarm"]
    return f"""
## The single blade with two dampers

{ours["size"]} degrees of freedom after reduction, {ours["rows"]} contact directions, H 5, 256 samples, 480 to 600 Hz at 80 N:
{ours["points"]} points in {ours["cpu"]:.3f} s of CPU, {1e3 * ours["cpu"] / ours["points"]:.2f} ms a point, after
{ours["modes_cpu"]:.3f} s for damping and modes; {ours["iterations"]:.2f} Newton steps a point, at most {ours["active"]} unknowns.

{_attempt(theirs)}
"""


def _attempt(theirs: dict[str, Any]) -> str:
    """What pyHarm did with the rig in a bounded time."""
    if "failed" in theirs:
        return f"pyHarm did not complete it: {theirs['failed']}."
    solved = f"{theirs['points']} point{'' if theirs['points'] == 1 else 's'}"
    return f"""pyHarm takes the matrices, but its contact element couples the two tangential directions where the rig's do
not: its cost can be set beside stickslip's, its answer cannot. With {theirs["size"]} unknowns and a start from the stuck state
it solved {solved} of the band in {theirs["cpu"]:.0f} s of CPU (bound: {theirs["seconds"]} s), with
{theirs["jacobians"]} Jacobians. From rest its contact element divides 0 by 0."""


def memory(found: dict[str, Any]) -> str:
    cases = list(found["stickslip"])

    def cell(value: float | None) -> str:
        return "–" if value is None else f"{value:.0f}"

    names = [BLADE_NAME if case == "blade" else case for case in cases]
    rows = [[name, *(cell(values.get(case)) for case in cases)] for name, values in found.items()]
    return f"""
## Peak memory

Peak resident memory, in MiB, of a process that imports the code and does one sweep at the chosen settings. The blade's
includes meshing and reducing it.

{markdown(("code", *names), rows)}
"""
