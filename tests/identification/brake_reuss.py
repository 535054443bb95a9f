"""The measured Brake-Reuss beam: eight response-controlled curves of its first bending mode, and the fit of one mode to a curve.

Measurement of M. Cenedese, J. Axås, H. Yang, M. Eriten and G. Haller, Mechanical Systems and Signal Processing (2021),
DOI 10.1016/j.ymssp.2021.108401. The curves are not shipped; they are read where they lie beside the repository.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

import stickslip as ss
from stickslip.laboratory.identification.response.fit import FittedTest

PLACES = [
    parent / "shared" / "data" / "measured" / "brake_reuss_response_controlled.csv" for parent in Path(__file__).resolve().parents
]
FILE = next((place for place in PLACES if place.is_file()), None)

FREE = {
    "damping": (1e-3, 1e-4, 1e-2),
    "slip_force": (60.0, 5.0, 1000.0),
    "chi": (0.5, -0.5, 1.5),
    "frequency": ss.FreeParameter(80.3, 79.0, 81.5, each_test=True),
}
"""One linear damping and one set of friction parameters; the linear frequency is each curve's own."""


ELEMENTS = 160
"""Of the joint. With the 114 that keep its loop energy within 0.2 % the sum of squares has minima 0.03 in χ apart; with 400 the
result is that of 160."""


def beam(**values):
    """The mode with its joint, resolved finely."""
    return ss.rigs.jointed_mode(**values, count=ELEMENTS)


def curves(of_largest=False):
    """The eight curves: each point at its measured acceleration, gain and phase of the chain free.

    Errors are relative to each point, so that response per force and force per response are fitted alike: the response is held,
    and the force is what is computed; or to the largest response of a curve, as in `one_mode`.
    """
    data = np.genfromtxt(FILE, delimiter=",", names=True)
    found = []
    for number in range(1, 9):
        one = data[data["curve"] == number]
        columns = (one[name] for name in ("frequency_hz", "acceleration_m_s2", "force_n", "phase_rad"))
        name = f"{np.median(one['acceleration_m_s2']):.1f} m/s²"
        chain = {"held": "response", "free_gain": True, "free_phase": True, "of_largest": of_largest}
        found.append(ss.MeasuredResponse(*columns, name=name, **chain))
    return found


def one_mode(frequency, H):
    """Modal gain, frequency [Hz], damping ratio and constant phase by least squares in H = a/F with the phase of displacement."""
    omega, size = 2.0 * np.pi * np.asarray(frequency), np.abs(H).max()
    begin = np.array([0.5, frequency[int(np.argmax(np.abs(H)))], 3e-3, 0.1])

    def apart(scaled):
        gain, f, zeta, phase = scaled * begin
        own = 2.0 * np.pi * f
        difference = gain * omega**2 * np.exp(1j * phase) / (own**2 - omega**2 + 2j * zeta * own * omega) - H
        return np.concatenate([difference.real, difference.imag]) / size

    return least_squares(apart, np.array([1.0, 1.0, 1.0, 0.0]), x_scale=[1.0, 1e-3, 1.0, 1.0], xtol=1e-13, ftol=1e-13).x * begin


def near_resonance(test):
    """The points of a curve within its half-power band."""
    size = np.abs(test.per_force)
    kept = size > size.max() / np.sqrt(2.0)
    columns = {name: np.asarray(getattr(test, name))[kept] for name in ("frequency", "amplitude", "force", "phase")}
    return replace(test, **columns)


def deviations(found):
    """Computed over measured damping ratio less one, of each curve, by the same fit of one mode at all of its points."""
    apart = []
    for k, test in enumerate(curves()):
        values = found.values | {"frequency": float(found.dataset["own_value"].sel(own="frequency")[k])}
        shown = FittedTest.of(test, beam, 1, 256).computed(values, np.zeros(0), []).per_force
        apart.append(one_mode(test.frequency, shown)[2] / one_mode(test.frequency, test.per_force)[2] - 1.0)
    return np.array(apart)


def per_force(dataset, which):
    """Measured or computed response per force of every test, complex."""
    return dataset[which].values * np.exp(1j * np.radians(dataset[f"{which}_phase"].values))


def linear_frequency(dataset, acceleration):
    """Linear frequency [Hz] at an acceleration, between those of the curves; friction does not explain it."""
    known = [float(np.nanmedian(one)) for one in dataset["response"].values]
    return float(np.interp(acceleration, known, dataset["own_value"].sel(own="frequency").values))


def constant_force(found, force, points=30):
    """A prediction that no curve was fitted to: the response at a constant force [N].

    At each acceleration the problem has the linear frequency of that acceleration, and the controlled response says at which
    frequencies it takes this force; gain and phase of the measuring chain are left out. Returns frequencies [Hz] and
    accelerations [m/s²], (2, n), up one side of the resonance and down the other; no further than the curves reach.
    """
    highest = float(np.nanmax(found.dataset["response"].values))
    known = np.geomspace(1.0, highest, 25)
    least = ss.phase_resonance(found.problem(frequency=80.3), ss.hertz(70.0, 90.0), known, harmonics=1).dataset["force_level"]
    top = float(np.interp(force, least.values, known))
    sides = [], []
    for a in top * (1.0 - np.linspace(0.97, 0.02, points) ** 2):
        problem = found.problem(frequency=linear_frequency(found.dataset, a))
        at_90 = float(ss.phase_resonance(problem, ss.hertz(70.0, 90.0), [a], harmonics=1).dataset["frequency"][0])
        for sign, kept in zip((-1.0, 1.0), sides, strict=True):
            frequencies = at_90 + sign * np.concatenate([[0.0], np.geomspace(0.005, 6.0, 30)])
            levels = ss.controlled_response(problem, frequencies.tolist(), float(a), harmonics=1).dataset["force_level"].values[0]
            if levels[0] < force < levels[-1]:
                kept.append((float(np.interp(force, levels, frequencies)), float(a)))
    return np.array(sides[0] + sides[1][::-1]).T


def by_damping(found):
    """Linear damping, slip force and χ by the least sum of the fourth powers of ln(computed ζ/measured ζ), which keeps the
    largest deviation small, with the linear frequencies of `found`.

    Returns these parameters and computed over measured damping ratio of each curve, by the same fit of one mode.
    """
    tests = curves()
    models = [FittedTest.of(test, beam, 1, 256) for test in tests]
    measured = np.array([one_mode(test.frequency, test.per_force)[2] for test in tests])
    own = found.dataset["own_value"].sel(own="frequency").values
    names = ("damping", "slip_force", "chi")

    def ratios(scaled):
        values = {name: found.values[name] * float(s) for name, s in zip(names, scaled, strict=True)}
        shown = [
            m.computed(values | {"frequency": float(f)}, np.zeros(0), []).per_force for m, f in zip(models, own, strict=True)
        ]
        return np.array([one_mode(test.frequency, H)[2] for test, H in zip(tests, shown, strict=True)]) / measured

    def squares(scaled):
        apart = np.log(ratios(scaled))
        return 100.0 * apart * np.abs(apart)

    best = least_squares(squares, np.array([0.995, 1.0, 1.0]), diff_step=1e-3, xtol=1e-5, max_nfev=12).x
    return {name: found.values[name] * float(s) for name, s in zip(names, best, strict=True)}, ratios(best)
