"""A bolted joint, shaken at three forces: how its vibration will decay, with intervals, and the ring-down test that follows."""

import numpy as np

import stickslip as ss


def beam(slip_force, damping):
    """The first bending mode of a beam with a joint, of the parameters to identify."""
    return ss.rigs.jointed_mode(slip_force=slip_force, damping=damping, count=20)


truth = beam(46.0, 1.4e-3)
frequencies, rng = np.linspace(78.0, 81.5, 41), np.random.default_rng(0)


def test(force):
    """In place of a measurement: the truth with 1 % noise."""
    response = ss.forced_response(truth, frequencies.tolist(), force, harmonics=3).dataset["amplitude"].values[0, :, 0]
    noisy = response * (1.0 + 0.01 * rng.normal(size=frequencies.size))
    return ss.MeasuredResponse(frequencies, noisy, force, quantity="displacement", name=f"{force:g} N")


bounds = {"slip_force": (30.0, 5.0, 500.0), "damping": (1e-3, 1e-4, 1e-2)}  # start, low, high
found = ss.identify_response(beam, bounds, [test(force) for force in (0.3, 1.0, 3.0)], harmonics=3)

prediction = found.predict_decay((5e-5, 4e-4))  # before the test
decay = ss.free_decay(truth, 3.0, displacement={"1.x": 4.5e-4}, steps=120_000).dataset  # the test
signal = decay["displacement"].values[0] + 2e-7 * rng.normal(size=120_001)
measured = prediction.compare(ss.measured_decay(decay["time"].values, signal, name="ring-down"))
print(measured)
damping = float(np.interp(2e-4, prediction.dataset["amplitude"], prediction.dataset["damping_ratio"]))
measured.plot().savefig("predicted_decay.png")
