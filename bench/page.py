"""The benchmark's page for the documentation, written from the measured numbers alone."""

from __future__ import annotations

from datetime import date
from pathlib import Path
from typing import Any

import explorer
import figures
from page_comparison import accuracy, blade, headline, memory, startup
from page_cost import growth, limit, scaling


def write(found: dict[str, Any], docs: Path) -> None:
    """docs/benchmarks.md and its figures, from whatever has been measured."""
    folder = docs / "figures"
    folder.mkdir(exist_ok=True)
    parts = [_opening(found)]
    if "headline" in found:
        figures.curves(found["headline"], folder / "benchmark_curves.svg")
        parts += [headline(found["headline"]), accuracy(found["headline"])]
    parts += [startup(found["startup"])] if "startup" in found else []
    parts += [limit(found["limit"])] if "limit" in found else []
    if "growth" in found:
        figures.growth(found["growth"], folder / "benchmark_growth.svg")
        parts.append(growth(found["growth"]))
    parts += [blade(found["blade"])] if "blade" in found else []
    parts += [memory(found["memory"])] if "memory" in found else []
    parts += [scaling(found["scaling"])] if "scaling" in found else []
    parts += [explorer.table(found["explorer"])] if "explorer" in found else []
    parts += [(Path(__file__).parent / "findings.md").read_text(), METHOD]
    (docs / "benchmarks.md").write_text("\n\n".join(part.strip() for part in parts) + "\n")


def _opening(found: dict[str, Any]) -> str:
    machine, versions = found["machine"], found["versions"]
    day = date.fromisoformat(found["date"])
    ours, theirs = versions["stickslip"], versions["pyHarm"]
    return f"""
# Benchmarks

`make bench` measures stickslip beside [pyHarm](https://gitlab.com/drti/pyharm), an open harmonic balance code, on the same
problems in one run, and writes this page. All times are CPU times of one core, with one BLAS thread.

Measured on {day.day} {day:%B %Y} on a machine of {machine["cores"]} cores, processor {machine["processor"]}, {machine["system"]}.

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
