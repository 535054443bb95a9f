"""The benchmark's page for the documentation, written from the measured numbers alone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import explorer
import figures
from page_comparison import accuracy, blade, headline, memory, startup
from page_cost import fe_blades, growth, limit, many_contacts, scaling

PARTS: dict[str, Callable[[Any], str]] = {
    "headline": lambda found: headline(found) + "\n\n" + accuracy(found),
    "startup": startup,
    "limit": limit,
    "growth": growth,
    "many_contacts": many_contacts,
    "fe_blades": fe_blades,
    "blade": blade,
    "memory": memory,
    "scaling": scaling,
    "explorer": explorer.table,
}
"""The section of each part."""

FIGURES = {"headline": ("benchmark_curves.svg", figures.curves), "growth": ("benchmark_growth.svg", figures.growth)}
"""File and drawing of the parts that have one."""

TITLES = (
    "A sweep that is right",
    "Before the first point",
    "Near the limit",
    "How cost grows",
    "Many contacts",
    "Two finite-element blades",
    "The single blade with two dampers",
    "Peak memory",
    "Many cases on several cores",
    "A slider that moves",
    "What was tried, and what is left",
    "How it is measured",
)
"""Sections in their order."""

MEASURED = "Measured"
"""How the first sentence of a measured section begins."""


def write(found: dict[str, Any], docs: Path) -> None:
    """docs/benchmarks.md and its figures: the sections of what has been measured are replaced, the others stay as they are.

    found: by part, its numbers, with "measured" (date and commit) of each in found["measured"].
    """
    page, folder = docs / "benchmarks.md", docs / "figures"
    folder.mkdir(exist_ok=True)
    sections = _sections(page.read_text()) if page.exists() else {}
    for part in [part for part in PARTS if part in found]:
        if part in FIGURES:
            name, draw = FIGURES[part]
            draw(found[part], folder / name)
        title, body = _section(PARTS[part](found[part]))
        sections[title] = f"{MEASURED} {found['measured'][part]}.\n\n{body}"
    sections |= dict(_section(text) for text in ((Path(__file__).parent / "findings.md").read_text(), METHOD))
    texts = [f"## {title}\n\n{sections[title]}" for title in TITLES if title in sections]
    page.write_text("\n\n".join([_opening(found).strip(), *texts]) + "\n")


def _sections(page: str) -> dict[str, str]:
    """The sections of a page by their titles; what stands before the first is not among them."""
    return dict(_section(text) for text in ("\n" + page).split("\n## ")[1:])


def _section(text: str) -> tuple[str, str]:
    title, body = text.strip().removeprefix("## ").split("\n", 1)
    return title.strip(), body.strip()


def _opening(found: dict[str, Any]) -> str:
    machine, versions = found["machine"], found["versions"]
    ours, theirs = versions["stickslip"], versions["pyHarm"]
    return f"""
# Benchmarks

`make bench` measures stickslip beside [pyHarm](https://gitlab.com/drti/pyharm), an open harmonic balance code, on the same
problems in one run, and writes this page; `python bench --only startup` renews one section. Each says when it was measured, and
with which commit. All times are CPU times of one core, with one BLAS thread.

The latest on a machine of {machine["cores"]} cores, processor {machine["processor"]}, {machine["system"]}, with

* stickslip {ours["stickslip"]}, {_versions(ours)}
* pyHarm {theirs["pyHarm-os"]}, {_versions(theirs)}, JAX {theirs["jax"]}

The problems: **B1**, one mass with a friction slider to ground, at four force levels; **B2a**, a chain of 20 masses with ten
sliders of constant load; **B2b**, the same chain with a second direction that loads and unloads the friction. Harmonics 0 to 7,
256 samples in a period.
"""


def _versions(versions: dict[str, str]) -> str:
    return ", ".join(f"{name} {versions[name.lower()]}" for name in ("Python", "NumPy", "SciPy", "Numba"))


METHOD = """
## How it is measured

* Both codes run in processes of their own, warm, in turn in the same run; the time of a sweep is the least of three, from
  building the problem to the last solved point; pyHarm's sweeps of more than 20 s are timed once. CPU time, not wall time.
* stickslip's settings: largest step, error aim and sharpest turn of its continuation. pyHarm's: largest step, arc-length and
  pseudo-arc-length corrector, characteristic length, then on the best of these its Newton solver instead of SciPy's, the secant
  predictor and the reduction to nonlinear degrees of freedom. Each code keeps the cheapest setting that is right. The tolerances
  of both are their defaults; stickslip's, 1e-11 of the contact forces, is the tighter one.
* The true curve: stickslip at about 1600 given frequencies, solved exactly at each; the peak is solved, not interpolated. That
  pyHarm agrees at its own frequencies is the independent check.
* Monotone cubic interpolation of |X₁| over frequency joins the points of both codes.
* pyHarm runs in double precision (JAX's default is single). In B2b its contact wants three directions; naming the tangential one
  twice, with half the stiffness and μ/√2, gives the same law on two degrees of freedom a node and is cheaper than a third.
* "Jacobians a point" counts pyHarm's evaluations of the system's Jacobian; the solver of SciPy updates it between.

Earlier figures of another open code, tmdsimpy, on the same problems and two cores of another machine: 4.7 ms a point on B1,
130 ms on B2a, 880 ms on B2b.
"""
