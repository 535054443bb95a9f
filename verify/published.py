"""Cases that other codes and papers publish with all their numbers: decays, friction work, nonlinear modes, a superharmonic."""

from __future__ import annotations

from collections.abc import Iterator
from math import asin, atan2, cos, pi, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

import stickslip as ss
from stickslip.model.structure.cyclic_reduction import craig_bampton
from verify.row import CLOSED, INDEPENDENT, Row, absolute, at_most, relative

TITLE = "Published cases"
ABOUT = (
    "SDND100: 1 kg on a spring of 1e4 N/m with a friction limit of 1 N, released at 0.85 mm; 50 000 steps a second. SDND104: "
    "1 kg on a shaking ground, rigid friction of 1 N; here kt = 1e6 N/m, 1024 samples. sdnd122a: 1 kg on 10 N/m with a stop of "
    "50 N/m at 10 mm. RubBeR: a cantilever of 15 nodes with a Jenkins element, 1e7 N/m and 15 N, at node 6; harmonics 1, 3, 5, "
    "7, 4096 samples. Jenkins oscillator: m = 1, c = 0.01, k = 0.75, kt = 0.25, limit 0.2, harmonics 0 to 3, 1024 samples."
)
ASTER = "validation manual of code_aster, "
RUBBER = f"virtual test of NLvib 1.3; {INDEPENDENT}"
TMDSIMPY = "known solutions of tmdsimpy"


def rows() -> Iterator[Row]:
    yield from released_mass()
    yield from shaken_mass()
    yield from stop()
    yield from cantilever()
    yield from superharmonic()


def one_mass(M: float, C: float, K: float, contact: ss.Contact) -> ss.Problem:
    """A mass on a spring, a dashpot and a contact, under 1 N."""
    structure = ss.Structure(np.array([[M]]), np.array([[K]]), ("1.x",), C=np.array([[C]]))
    return ss.Problem(structure, (contact,), (ss.Force("1.x", 1.0),), ("1.x",))


def released_mass() -> Iterator[Row]:
    """SDND100: each half cycle loses 2 F/k of amplitude, until the spring no longer overcomes friction."""
    exact = [-6.5e-4, 4.5e-4, -2.5e-4, 0.5e-4]
    slider = ss.Contact("slider", ss.Macroslip(1e9, 1.0, normal_load=1.0), ({"1.x": 1.0},))
    along = ss.free_decay(one_mass(1.0, 0.0, 1e4, slider), 0.3, {"1.x": 8.5e-4}, steps=15_000).dataset
    turning = along["turning_point"].values[0]
    source = ASTER + "SDND100"
    for k, point in enumerate(exact, start=1):
        yield absolute(f"SDND100: turning point {k}, m", turning[k], point, 1e-7, source)
    yield absolute("SDND100: where it stays, m", along["displacement"].values[0, -1], exact[-1], 1e-7, source)

    structure = ss.Structure(np.eye(2), 1e4 * np.eye(2), ("1.x", "1.y"))
    disc = ss.Contact("disc", ss.FrictionDisc(1e8, 1.0, normal_load=1.0), ({"1.x": 1.0}, {"1.y": 1.0}))
    plane = ss.Problem(structure, (disc,), (ss.Force("1.x", 1.0),), ("1.x", "1.y"))
    share = cos(pi / 4.0)
    decay = ss.free_decay(plane, 0.3, {"1.x": share * 8.5e-4, "1.y": share * 8.5e-4}, steps=15_000).dataset
    gap = float(np.abs(decay["turning_point"].values[:, 1:5] - share * np.array(exact)).max())
    yield at_most("SDND100 at 45°: turning points of both components, largest error, m", gap, 2e-7, source)


def shaken_mass() -> Iterator[Row]:
    """SDND104: the work of friction per cycle by the closed form of rigid friction, 151 harmonics against a stiff spring."""
    structure = ss.Structure(np.eye(1), np.zeros((1, 1)), ("1.x",))
    ground = ss.Contact("ground", ss.Macroslip(1e6, 0.1, normal_load=10.0), (ss.between("1.x", "ground"),))
    springs = (ss.Spring({"1.x": 1.0}, 1e4),)
    problem = ss.Problem(structure, (ground,), (ss.BaseMotion({"1.x": 1.0}, -1j),), ("1.x",), mean_springs=springs)
    for acceleration, work, error in ((15.0, 1.5114614, 1e-3), (1.5, 0.04090625, 5e-3), (1.01, 2.261641e-5, 0.05)):
        found = ss.forced_response(problem, [1.0], acceleration, harmonics=151, samples=1024).dataset
        name = f"SDND104: work of friction per cycle at {acceleration:g} m/s², J"
        yield relative(name, found["dissipated"].values[0, 0, 0], work, error, ASTER + "SDND104; " + CLOSED)
    stuck = ss.forced_response(problem, [1.0], 0.99, harmonics=151, samples=1024).dataset
    yield at_most(
        "SDND104: work of friction per cycle at 0.99 m/s², J", stuck["dissipated"].values[0, 0, 0], 1e-15, ASTER + "SDND104"
    )


def stop() -> Iterator[Row]:
    """sdnd122a: the mode of a mass that meets a stop, half a cycle on either spring."""
    gap = 0.01
    problem = one_mass(1.0, 0.0, 10.0, ss.Contact("stop", ss.Gap(50.0, gap), (), {"1.x": 1.0}))
    for harmonics, error in ((15, 1e-5), (63, 1e-7)):
        mode = ss.nonlinear_modes(problem, amplitude=(0.005, 0.1), harmonics=harmonics, samples=2048).dataset
        turns = np.exp(2j * np.pi * np.outer(np.arange(harmonics + 1), np.arange(4096) / 4096))
        excursion = -np.real(parts(mode["response"].values[0, :, 0]) @ turns).min(axis=1)
        meets = excursion > 1.02 * gap
        gaps = [f * period(A, gap) - 1.0 for f, A in zip(mode["frequency"].values[0, meets], excursion[meets], strict=True)]
        name = f"sdnd122a: frequencies over the amplitude, {harmonics} harmonics, largest error"
        yield at_most(name, np.abs(gaps).max(), error, ASTER + "SDND122; " + CLOSED)


def period(A: float, gap: float) -> float:
    """Period, s, with the excursion A to the free side: 10 N/m up to the gap, 60 N/m beyond it."""
    speed = sqrt(10.0 * (A**2 - gap**2))
    return 2.0 / sqrt(10.0) * (pi / 2.0 + asin(gap / A)) + 2.0 * atan2(speed / sqrt(60.0), gap / 6.0) / sqrt(60.0)


def parts(values: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Complex numbers of real and imaginary parts on the last axis."""
    return np.asarray(values[..., 0] + 1j * values[..., 1])


def cantilever() -> Iterator[Row]:
    """RubBeR: 14 Euler–Bernoulli elements, the motion across at node 6 kept, three fixed-interface modes."""
    length, E, inertia, mass = 0.71 / 14, 210e9 * 0.6725, 0.06 * 0.05**3 / 12, 7850 * 0.06 * 0.05
    L = length
    k = np.array(
        [
            [12, 6 * L, -12, 6 * L],
            [6 * L, 4 * L**2, -6 * L, 2 * L**2],
            [-12, -6 * L, 12, -6 * L],
            [6 * L, 2 * L**2, -6 * L, 4 * L**2],
        ]
    )
    m = np.array(
        [
            [156, 22 * L, 54, -13 * L],
            [22 * L, 4 * L**2, 13 * L, -3 * L**2],
            [54, 13 * L, 156, -22 * L],
            [-13 * L, -3 * L**2, -22 * L, 4 * L**2],
        ]
    )
    K, M = np.zeros((2, 30, 30))
    for e in range(14):
        own = slice(2 * e, 2 * e + 4)
        K[own, own] += E * inertia / L**3 * k
        M[own, own] += mass * L / 420 * m
    reduced = craig_bampton(M[2:, 2:], K[2:, 2:], {"6.y": 8}, modes=3).structure
    structure = ss.Structure(reduced.M, reduced.K, reduced.dofs, damping=ss.ModalDamping(0.01))
    joint = ss.Contact("joint", ss.Macroslip(1e7, 1.0, normal_load=15.0), ({"6.y": 1.0},))
    problem = ss.Problem(structure, (joint,), (ss.Force("6.y", 1.0),), ("6.y",))
    yield relative("RubBeR: first stuck frequency, Hz", problem.frequencies(stuck=True)[0], 80.36779981, 1e-9, RUBBER)
    yield relative("RubBeR: first frequency without friction, Hz", problem.frequencies(stuck=False)[0], 67.96045356, 1e-9, RUBBER)

    shape = abs(float(problem.systems.stuck_modes.shapes[0, 0]))
    published = ((-4.5, 76.055567, 0.05773377), (-3.9, 69.258349, 0.04269152), (-3.3, 68.123342, 0.02107411))
    for logarithm, frequency, damping in published:
        around = tuple(share * 10.0**logarithm * shape for share in (0.9, 1.1))
        mode = ss.nonlinear_modes(problem, amplitude=around, harmonics=[1, 3, 5, 7], samples=4096, extended="all").dataset
        first = parts(mode["mode_shape"].values[0])
        sizes = 0.5 * np.log10(np.einsum("pi,ij,pj->p", first.conj(), structure.M, first).real)
        for name, values, reference, error in (
            ("frequency, Hz", "frequency", frequency, 1e-6),
            ("damping ratio", "damping_ratio", damping, 1e-5),
        ):
            found = float(CubicSpline(sizes, mode[values].values[0])(logarithm))
            yield relative(f"RubBeR: log₁₀ a = {logarithm:g}, {name}", found, reference, error, RUBBER)


def superharmonic() -> Iterator[Row]:
    """The first harmonic near resonance 3:1; its phase is that of exp(+iωt). The published third harmonic is of fewer samples."""
    joint = ss.Contact("joint", ss.Macroslip(0.25, 1.0, normal_load=0.2), ({"1.x": 1.0},))
    problem = one_mass(1.0, 0.01, 0.75, joint)
    published = (
        (1.0, 0.3115958, {1: 1.284973 - 0.284202j}, 1e-5),
        (100.0, 0.28892166, {1: 150.0106 - 1.03144j, 3: -9.20507502 + 2.65110885j}, 1e-3),
    )
    for force, omega, harmonics, error in published:
        found = parts(
            ss.forced_response(problem, [omega / (2.0 * pi)], force, harmonics=3, samples=1024).dataset["response"].values
        )
        for h, exact in harmonics.items():
            for part, value, reference in (("real", found.real, exact.real), ("imaginary", found.imag, exact.imag)):
                name = f"Jenkins oscillator, {force:g} N: {part} part of harmonic {h}"
                yield relative(name, value[0, 0, 0, h], reference, error, TMDSIMPY)
