"""Does a sweep find every resonance? Lightly damped chains and beams with friction, beside an independent answer.

Where all contacts stick, the peaks of the linear structure are exact. Where they slip, the balance is solved by Newton's method
at listed frequencies, from one to the next: 40 to each half-width ζω around every computed resonance, those with each set of
contacts stuck, and their fractions 1/h; and a graded grid between the stuck and the free frequency of each mode.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray
from scipy import linalg
from scipy.optimize import minimize_scalar

from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact, between
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.structure.matrices import ModalDamping, Structure
from stickslip.solve.balance.balance import HarmonicBalance, Point
from stickslip.solve.continuation.continuation import first_point
from stickslip.solve.continuation.newton import correct, fixed
from stickslip.solve.curves.curve import refined, solve_curve
from stickslip.support.checks import Array
from stickslip.support.outcome import Outcome

KINDS = ("chain", "beam", "partly stuck chain")
RATIOS = (1e-2, 1e-3, 1e-4, 1e-5)
HARMONICS, SAMPLES = 5, 512

LEAST, PROMINENT, HEIGHT = 1e-3, 2e-3, 1e-3
"""Peaks of at least the first share of the highest that rise by the second share out of the curve must be found, and right to
the third."""

STUCK = 1e-6
"""Share of the smallest force at which a contact slips."""

STEEL = 2.1e11, 7800.0
"""Young's modulus [Pa] and density [kg/m³]."""


@dataclass(frozen=True, eq=False)
class Case:
    """A problem with its damping ratio, its band in rad/s in the order of travel, and a force level at which contacts slip."""

    name: str
    problem: Problem
    ratio: float
    band: tuple[float, float]
    level: float

    @property
    def ends(self) -> tuple[float, float]:
        """Least and largest frequency of the band, rad/s."""
        return min(self.band), max(self.band)


@dataclass(frozen=True)
class Peak:
    """A peak of an output, m per unit force level; low, high: where the curve turns up again on both sides, rad/s."""

    output: int
    omega: float
    amplitude: float
    low: float
    high: float


@dataclass
class Tally:
    """What sweeps found of the peaks of a reference, added up over cases."""

    cases: int = 0
    peaks: int = 0
    missing: int = 0
    low: int = 0
    points: int = 0
    wrong: list[str] = field(default_factory=list)

    @property
    def words(self) -> str:
        """For the console: peaks compared and what was wrong with them."""
        return f"{self.peaks} peaks, {self.missing} missing, {self.low} of wrong height"

    def add(self, case: Case, level: float, reference: list[Peak], exact: bool) -> None:
        """Sweep a case and compare; `exact`: a linear structure, the curve of which never turns back."""
        balance = HarmonicBalance(case.problem, HARMONICS, SAMPLES)
        curve = refined(balance, solve_curve(balance, case.band, level, exactly=False))
        omegas = np.array([point.point.omega for point in curve.points])
        backwards = exact and bool(np.any(np.diff(omegas) * (case.band[1] - case.band[0]) <= 0.0))
        missing = low = 0
        for peak in reference:
            row = balance.rows + peak.output
            found = [p.evaluation.w[row, 1:3] for p in curve.peaks[peak.output] if peak.low < p.point.omega < peak.high]
            heights = [float(np.hypot(*motion)) / level for motion in found]
            missing += not heights
            low += bool(heights) and not _agrees(max(heights), peak.amplitude, exact)
        self.cases, self.peaks, self.points = self.cases + 1, self.peaks + len(reference), self.points + len(curve.points)
        self.missing, self.low = self.missing + missing, self.low + low
        if missing or low or backwards or curve.outcome != Outcome.CONVERGED:
            reason = "turns back" if backwards else curve.message
            self.wrong.append(f"{case.name}: {missing} missing, {low} of wrong height of {len(reference)}. {reason}")


def _agrees(height: float, reference: float, exact: bool) -> bool:
    """Both ways for exact peaks; a peak among listed frequencies may be below the true one."""
    return height >= (1.0 - HEIGHT) * reference and (not exact or height <= (1.0 + HEIGHT) * reference)


def random_case(kind: str, ratio: float, seed: int) -> Case:
    """Case number `seed` of a kind: a wide or a narrow band, upwards or downwards, damping on the free or the stuck modes."""
    rng = np.random.default_rng([KINDS.index(kind), seed])
    problem = (_chain, _beam, _partly_stuck)[KINDS.index(kind)](rng, ratio)
    natural = 2.0 * np.pi * problem.frequencies(stuck=True)
    last = min(natural.size - 1, int(rng.integers(2, 6)))
    wide = 0.3 * natural[0], 1.2 * natural[last]
    mode = int(rng.integers(last + 1))
    narrow = float(rng.uniform(0.5, 0.95)) * natural[mode], float(rng.uniform(1.03, 1.5)) * natural[mode]
    low, high = map(float, wide if rng.integers(2) else narrow)
    level = slipping_level(problem, (low, high)) * float(10.0 ** rng.uniform(0.05, 2.0))
    band = (low, high) if rng.integers(2) else (high, low)
    return Case(f"{kind} {seed}, damping ratio {ratio:g}", problem, ratio, band, level)


def _damping(rng: np.random.Generator, ratio: float) -> ModalDamping:
    return ModalDamping(ratio, on=("free", "stuck")[int(rng.integers(2))])


def _chain(rng: np.random.Generator, ratio: float) -> Problem:
    """2 to 6 masses, 1 to 3 sliders between them or to ground, some of the masses as outputs."""
    size = int(rng.integers(2, 7))
    springs = rng.uniform(0.3, 3.0, size + 1) * np.array([1.0] * size + [rng.integers(2)])
    K = np.diag(springs[:-1] + springs[1:]) - np.diag(springs[1:-1], 1) - np.diag(springs[1:-1], -1)
    dofs = tuple(f"{i + 1}.x" for i in range(size))
    structure = Structure(np.diag(rng.uniform(0.5, 2.0, size)), K, dofs, damping=_damping(rng, ratio))
    contacts = []
    for k in range(int(rng.integers(1, 4))):
        one, other = (dofs[int(i)] for i in rng.integers(size, size=2))
        law = Macroslip(kt=float(rng.uniform(0.1, 3.0)), mu=0.5, normal_load=float(rng.uniform(0.5, 2.0)))
        contacts.append(Contact(f"slider {k + 1}", law, (between(one, "ground" if one == other else other),)))
    outputs = tuple(str(dof) for dof in rng.permutation(dofs)[: int(rng.integers(1, size + 1))])
    return Problem(structure, tuple(contacts), (Force(dofs[int(rng.integers(size))], 1.0),), outputs)


def _partly_stuck(rng: np.random.Generator, ratio: float) -> Problem:
    """A chain with one slider more, pressed so strongly that it sticks at every force, where the others slip."""
    problem = _chain(rng, ratio)
    dofs = problem.structure.dofs
    law = Macroslip(kt=float(rng.uniform(0.5, 3.0)), mu=0.5, normal_load=1e6)
    strong = Contact("strong", law, (between(dofs[int(rng.integers(len(dofs)))], "ground"),))
    return replace(problem, contacts=(*problem.contacts, strong))


def _beam(rng: np.random.Generator, ratio: float) -> Problem:
    """A steel cantilever of Euler-Bernoulli elements with one slider; outputs at tip and middle."""
    elements = int(rng.integers(6, 16))
    length, width, height = float(rng.uniform(0.1, 0.4)), 0.02, float(rng.uniform(0.002, 0.01))
    M, K = cantilever(elements, length, width, height)
    dofs = tuple(f"{i + 1}.{d}" for i in range(elements) for d in ("y", "rotz"))
    structure = Structure(M, K, dofs, damping=_damping(rng, ratio))
    bending = STEEL[0] * width * height**3 / 12.0
    kt = float(10.0 ** rng.uniform(-1.0, 2.0)) * 3.0 * bending / length**3
    law = Macroslip(kt=kt, mu=0.5, normal_load=float(rng.uniform(1.0, 20.0)))
    slider = Contact("slider", law, (between(f"{rng.integers(1, elements + 1)}.y", "ground"),))
    force = Force(f"{rng.integers(1, elements + 1)}.y", 1.0)
    return Problem(structure, (slider,), (force,), (f"{elements}.y", f"{elements // 2}.y"))


def cantilever(elements: int, length: float, width: float, height: float) -> tuple[Array, Array]:
    """M and K of a steel cantilever, two degrees of freedom (deflection, rotation) a node, clamped at the first."""
    modulus, density = STEEL
    bending, mass, step = modulus * width * height**3 / 12.0, density * width * height, length / elements
    s = step
    stiffness = [[12, 6 * s, -12, 6 * s], [6 * s, 4 * s**2, -6 * s, 2 * s**2]]
    stiffness += [[-12, -6 * s, 12, -6 * s], [6 * s, 2 * s**2, -6 * s, 4 * s**2]]
    inertia = [[156, 22 * s, 54, -13 * s], [22 * s, 4 * s**2, 13 * s, -3 * s**2]]
    inertia += [[54, 13 * s, 156, -22 * s], [-13 * s, -3 * s**2, -22 * s, 4 * s**2]]
    M, K = np.zeros((2, 2 * elements + 2, 2 * elements + 2))
    for e in range(elements):
        place = slice(2 * e, 2 * e + 4)
        K[place, place] += bending / s**3 * np.array(stiffness)
        M[place, place] += mass * s / 420.0 * np.array(inertia)
    return M[2:, 2:], K[2:, 2:]


def receptance(problem: Problem) -> Callable[[Array], NDArray[np.complex128]]:
    """Motion of the stuck structure per unit force level at frequencies in rad/s: (frequencies, n)."""
    M, C, K, load = problem.structure.M, problem.C, problem.stuck_stiffness, problem.load(1)[:, 1]
    return lambda omegas: np.array([np.linalg.solve(K + 1j * w * C - w * w * M, load) for w in np.atleast_1d(omegas)])


def slipping_level(problem: Problem, band: tuple[float, float]) -> float:
    """The least force level at which a contact slips at a stuck resonance inside the band; 1 where none lies inside."""
    natural = 2.0 * np.pi * problem.frequencies(stuck=True)
    inside = natural[(natural > band[0]) & (natural < band[1])]
    if not inside.size:
        return 1.0
    motion = np.abs(receptance(problem)(inside) @ problem.B.T)
    limits = np.array([float(np.sum(c.law.mu * c.law.normal_load)) for c in problem.contacts])  # type: ignore[attr-defined]
    return float(np.min(limits / np.maximum(problem.contact_stiffness * motion, 1e-300)))


def linear_peaks(case: Case) -> list[Peak]:
    """The exact peaks of |X_1| of the stuck structure: a grid graded towards its resonances, each maximum refined."""
    motion, (low, high) = receptance(case.problem), case.ends
    rows = case.problem.output_rows
    away = np.geomspace(0.02, 1e4, 140)
    natural = np.sqrt(np.maximum(linalg.eigvalsh(case.problem.stuck_stiffness, case.problem.structure.M), 0.0))
    graded = [w * (1.0 + case.ratio * np.concatenate([-away, [0.0], away])) for w in natural]
    omegas = _inside(np.concatenate([np.linspace(low, high, 4000), *graded]), low, high)
    sizes = np.abs(motion(omegas) @ rows.T)
    found = []
    for peak in _peaks(omegas, sizes):
        k = int(np.searchsorted(omegas, peak.omega))
        row = rows[peak.output]
        best = minimize_scalar(
            lambda w, row=row: -abs(motion(w)[0] @ row),
            bounds=(omegas[k - 1], omegas[k + 1]),
            method="bounded",
            options={"xatol": 1e-12 * omegas[k]},
        )
        found.append(replace(peak, omega=float(best.x), amplitude=float(-best.fun)))
    return found


def solved_peaks(case: Case) -> list[Peak]:
    """The peaks among solutions at listed frequencies, in two rounds: the second is finer around the peaks of the first."""
    balance = HarmonicBalance(case.problem, HARMONICS, SAMPLES)
    omegas = _listed(case)
    first = _peaks(omegas, _solved(balance, omegas, case.level))
    finer = np.array([*omegas, *_narrow_band([peak.omega for peak in first], case.ratio), *_between(omegas, first)])
    omegas = _inside(finer, *case.ends)
    return _peaks(omegas, _solved(balance, omegas, case.level))


def _listed(case: Case) -> Array:
    low, high = case.ends
    limits = _limits(case.problem)
    stuck, free = limits[-1], limits[0]
    shares = np.geomspace(1e-4, 0.5, 80)
    graded = [np.concatenate([a + (b - a) * shares, b - (b - a) * shares]) for a, b in zip(free, stuck, strict=True)]
    listed = [np.linspace(low, high, 1500), *graded, np.array([*_narrow_band(np.unique(np.concatenate(limits)), case.ratio)])]
    return _inside(np.concatenate(listed), low, high)


def _limits(problem: Problem) -> list[Array]:
    """Natural frequencies in rad/s with each set of contacts stuck: first with none of them, last with all."""
    B, stiffness = problem.B, problem.contact_stiffness
    sets = product((0.0, 1.0), repeat=stiffness.size)
    stiff = (problem.structure.K + B.T @ ((np.array(held) * stiffness)[:, None] * B) for held in sets)
    return [np.sqrt(np.maximum(linalg.eigvalsh(K, problem.structure.M), 0.0)) for K in stiff]


def _narrow_band(resonances: list[float] | Array, ratio: float) -> Iterator[float]:
    """40 frequencies to a half-width up to two of them away, farther ones up to a thousand, around fractions 1/h as well."""
    away = np.concatenate([np.arange(1, 81) / 40.0, np.geomspace(2.0, 1e3, 60)])
    for omega in resonances:
        for h in range(1, HARMONICS + 1):
            yield from omega / h * (1.0 + ratio * np.concatenate([-away, [0.0], away]))


def _between(omegas: Array, peaks: list[Peak]) -> Iterator[float]:
    for peak in peaks:
        k = int(np.clip(np.searchsorted(omegas, peak.omega), 2, omegas.size - 3))
        yield from np.linspace(omegas[k - 2], omegas[k + 2], 50)


def _inside(omegas: Array, low: float, high: float) -> Array:
    unique = np.unique(omegas)
    return unique[(unique > low) & (unique < high)]


def _solved(balance: HarmonicBalance, omegas: Array, level: float) -> Array:
    """|X_1| of the outputs per unit level at each frequency (frequencies, outputs), each solved from the one before."""
    sizes = np.full((omegas.size, balance.problem.output_rows.shape[0]), np.nan)
    before: list[Point] = []
    for k, omega in enumerate(omegas):
        starts = [Point(forces, float(omega), level) for forces in _extrapolated(before, float(omega))]
        settings = ({"iterations": 15, "halvings": 8}, {"iterations": 40, "patience": 20})
        trials = (correct(balance, start, fixed("omega", float(omega)), **how) for start in starts for how in settings)
        found = next((trial for trial in trials if trial.converged), None) or first_point(balance, float(omega), level)
        if found.converged:
            before = [*before[-1:], found.evaluation.point]
            sizes[k] = np.hypot(*found.evaluation.w[balance.rows :, 1:3].T) / level
    return sizes


def _extrapolated(before: list[Point], omega: float) -> Iterator[Array]:
    """λ on the straight line through the last two points, then that of the last."""
    if len(before) == 2:
        a, b = before
        yield b.forces + (b.forces - a.forces) * (omega - b.omega) / (b.omega - a.omega)
    if before:
        yield before[-1].forces


def _peaks(omegas: Array, sizes: Array) -> list[Peak]:
    """Prominent maxima of each output and the troughs beside them."""
    return [peak for output in range(sizes.shape[1]) for peak in _of_output(output, omegas, sizes[:, output])]


def _of_output(output: int, omegas: Array, sizes: Array) -> list[Peak]:
    solved = np.isfinite(sizes)
    x, a = omegas[solved], sizes[solved]
    tops = [int(k) + 1 for k in np.flatnonzero((a[1:-1] > a[:-2]) & (a[1:-1] >= a[2:]))]
    while True:
        troughs = [0, *(int(i + np.argmin(a[i : j + 1])) for i, j in pairwise(tops)), a.size - 1]
        rises = [1.0 - max(a[troughs[i]], a[troughs[i + 1]]) / a[top] for i, top in enumerate(tops)]
        if not tops or min(rises) >= PROMINENT:
            break
        del tops[int(np.argmin(rises))]
    least = LEAST * float(a.max(initial=0.0))
    places = [(top, troughs[i], troughs[i + 1]) for i, top in enumerate(tops) if a[top] >= least]
    return [Peak(output, float(x[top]), float(a[top]), float(x[low]), float(x[high])) for top, low, high in places]
