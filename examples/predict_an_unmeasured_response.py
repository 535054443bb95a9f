"""One mass on a slider, measured at three forces: what a fourth force will give, with intervals, and the test that follows."""

import numpy as np

import stickslip as ss


def blade(kt, limit, damping):
    """The problem of the parameters to identify."""
    return ss.rigs.single_mass(kt=kt, limit=limit, damping=damping)


frequencies, rng = np.linspace(0.14, 0.24, 31), np.random.default_rng(1)


def test(force):
    """In place of a measurement: the truth with 5 % noise."""
    response = ss.forced_response(blade(0.5, 1.0, 0.02), frequencies.tolist(), force).dataset["amplitude"].values[0, :, 0]
    noisy = response * (1.0 + 0.05 * rng.normal(size=frequencies.size))
    return ss.MeasuredResponse(frequencies, noisy, force, quantity="displacement", error=0.05, name=f"{force:g} N")


bounds = {"kt": (1.0, 0.1, 5.0), "limit": (0.5, 0.1, 5.0), "damping": (0.05, 0.002, 0.2)}  # start, low, high
found = ss.identify_response(blade, bounds, [test(force) for force in (0.3, 1.0, 2.0)])

prediction = found.predict([0.6, 1.4])  # before the test
measured = prediction.compare([test(0.6), test(1.4)])  # after it
print(measured)
peak = float(prediction.dataset["peak_amplitude"][0])
measured.plot().savefig("predicted.png")
