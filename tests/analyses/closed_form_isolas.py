"""Oscillators with an absorber and a gap or a cubic spring whose detached curves are known in closed form, with one harmonic.

With x1 = A cos(ω t) a spring of force f(x1) acts as κ(A) = (1/πA) ∮ f(A cos τ) cos τ dτ: ¾ k3 A² if f = k3 x³, and
kn (1 − (2/π)(asin r + r √(1 − r²))), r = g/A, behind gaps g on both sides. The level that an amplitude needs is

    F(ω, A) = A |1 + ka − ω² + iω(c + ca) − (ka + iω ca)²/(ka + iω ca − m ω²) + κ(A)|,

and the curves of a level are its contours. With s = ω², F²/A² is P(s)/Q(s), a ratio of polynomials, whose minima over ω are two
ridges φ(A). Where a ridge falls below a level again, and no pass to the other ridge does, a detached curve encloses it.
"""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import polynomial as poly
from scipy.ndimage import label

import stickslip as ss

BAND = (0.6, 1.9)
AMPLITUDE = np.geomspace(0.03, 40.0, 1200)
HIGHER, APART = 1.2, 1.02
"""How many times as high as the swept curve a detached one is at least; the share of a level by which it is away from joining."""


class Isola(NamedTuple):
    """A problem and a level; frequency [rad/s] and amplitude at the top of its detached curve, and the top of the swept one."""

    problem: ss.Problem
    level: float
    omega: float
    top: float
    swept: float


def ratio(numbers, stiffness):
    """P and Q for κ."""
    m, ka, ca, c = (numbers[name] for name in ("m", "ka", "ca", "c"))
    own, joint = [1.0 + ka + stiffness, -1.0], [ka, -m]
    real = poly.polysub(poly.polysub(poly.polymul(own, joint), [0.0, (c + ca) * ca]), [ka**2, -(ca**2)])
    imaginary = poly.polysub(poly.polyadd(poly.polymul(own, [ca]), poly.polymul(joint, [c + ca])), [2.0 * ka * ca])
    P = poly.polyadd(poly.polymul(real, real), poly.polymulx(poly.polymul(imaginary, imaginary)))
    return P, poly.polyadd(poly.polymul(joint, joint), [0.0, ca**2])


def turns(numbers, stiffness):
    """s and F²/A² at the minima and maxima over ω, in turn."""
    P, Q = ratio(numbers, stiffness)
    roots = poly.polyroots(poly.polysub(poly.polymul(poly.polyder(P), Q), poly.polymul(P, poly.polyder(Q))))
    s = np.sort(roots[(abs(roots.imag) < 1e-9) & (roots.real > 0.0)].real)
    return s, poly.polyval(s, P) / poly.polyval(s, Q)


def ridges(numbers, stiffness):
    """F on the lower ridge, the pass between them and the upper one, (3, A), and ω of both ridges, (2, A); where there is one
    minimum over ω it is all three."""
    forces, omegas = np.empty((3, AMPLITUDE.size)), np.empty((2, AMPLITUDE.size))
    for k, each in enumerate(stiffness):
        s, squares = turns(numbers, each)
        forces[:, k] = AMPLITUDE[k] * np.sqrt(squares)
        omegas[:, k] = np.sqrt(s[[0, -1]])
    return forces, omegas


def problem(numbers, contacts):
    m, ka, ca, c = (numbers[name] for name in ("m", "ka", "ca", "c"))
    K, C = np.array([[1.0 + ka, -ka], [-ka, ka]]), np.array([[c + ca, -ca], [-ca, ca]])
    return ss.Problem(ss.Structure(np.diag([1.0, m]), K, ("0.x", "1.x"), C=C), contacts, (ss.Force("0.x", 1.0),), ("0.x",))


def drawn(rng):
    """Numbers, contacts and κ(A) of an oscillator."""
    m = np.exp(rng.uniform(np.log(0.01), np.log(0.1)))
    ka = m * rng.uniform(0.85, 1.4) ** 2
    ca = 2.0 * np.exp(rng.uniform(np.log(3e-3), np.log(0.1))) * np.sqrt(ka * m)
    numbers = {"m": m, "ka": ka, "ca": ca, "c": np.exp(rng.uniform(np.log(5e-4), np.log(1e-2)))}
    if rng.random() < 0.5:
        k3 = np.exp(rng.uniform(np.log(0.1), np.log(3.0)))
        return numbers, (ss.Contact("spring", ss.CubicSpring(k3), ({"0.x": 1.0},)),), 0.75 * k3 * AMPLITUDE**2
    kn, g = rng.uniform(0.3, 2.5), rng.uniform(0.3, 1.0)
    r = np.minimum(g / AMPLITUDE, 1.0)
    stiffness = kn * (1.0 - 2.0 / np.pi * (np.arcsin(r) + r * np.sqrt(1.0 - r**2)))
    contacts = tuple(ss.Contact(n, ss.Gap(kn, gap=g), (), {"0.x": s}) for n, s in (("up", 1.0), ("down", -1.0)))
    return numbers, contacts, stiffness


def parts_of(forces, level):
    """The connected parts of {F < level}, numbered on the ridges and the pass, which A = 0 joins, and how many there are."""
    at_rest = np.ones((3, 1), dtype=bool)
    return label(np.concatenate([at_rest, forces < level], axis=1))


def isolas(seed, count):
    """Drawn problems with a level that has one detached curve, wholly inside the band and above the swept one."""
    rng, found = np.random.default_rng(seed), []
    while len(found) < count:
        numbers, contacts, stiffness = drawn(rng)
        forces, omegas = ridges(numbers, stiffness)
        ends = AMPLITUDE * np.sqrt([[poly.polyval(end**2, P) / poly.polyval(end**2, Q) for P, Q in
                                     (ratio(numbers, each) for each in stiffness)] for end in BAND])  # fmt: skip
        for level in rng.permutation(np.geomspace(0.005, 0.5, 60)):
            if len({parts_of(forces, share * level)[1] for share in (1.0 / APART, 1.0, APART)}) > 1:
                continue
            parts, count_of = parts_of(forces, level)
            if count_of != 2:
                continue
            parts = parts[:, 1:]
            swept, apart = (np.flatnonzero((parts == each).any(axis=0)) for each in (1, 2))
            top = AMPLITUDE[apart[-1]]
            ridge = int(parts[2, apart[-1]] == 2)
            omega = omegas[ridge, apart[-1]]
            if not BAND[0] < omega < BAND[1]:
                continue
            if top > HIGHER * AMPLITUDE[swept[-1]] and apart[-1] < AMPLITUDE.size - 1 and np.all(ends[:, apart] > level):
                swept_top = float(AMPLITUDE[swept[-1]])
                found.append(Isola(problem(numbers, contacts), level, omega, float(top), swept_top))
                break
    return found


def is_found(isola, dataset):
    """Whether an isolated curve of a result has the top of the detached one, to the steps of the amplitude."""
    kinds = dataset.curve_kind.values if "curve_kind" in dataset else np.zeros(dataset.sizes["case"])
    for case in np.flatnonzero(kinds == 2):
        amplitude, omega = dataset.amplitude.values[case, :, 0], 2.0 * np.pi * dataset.frequency.values[case]
        most = int(np.nanargmax(amplitude))
        step = AMPLITUDE[1] / AMPLITUDE[0] - 1.0
        if abs(amplitude[most] / isola.top - 1.0) < 2.0 * step and abs(omega[most] / isola.omega - 1.0) < step:
            return True
    return False
