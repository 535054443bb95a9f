"""kt, friction limit and damping of one mass from noisy responses at three force levels, and which level predicts which."""

import numpy as np

import stickslip as ss


def blade(kt, limit, damping):
    """The problem of the parameters to identify."""
    return ss.rigs.single_mass(kt=kt, limit=limit, damping=damping)


frequencies, tests, rng = np.linspace(0.14, 0.24, 21), [], np.random.default_rng(1)
for force in (0.3, 1.0, 2.0):  # in place of a measurement: the truth with 1 % noise
    response = ss.forced_response(blade(0.5, 1.0, 0.02), frequencies.tolist(), force).dataset["amplitude"].values[0, :, 0]
    noisy = response * (1.0 + 0.01 * rng.normal(size=frequencies.size))
    tests.append(ss.MeasuredResponse(frequencies, noisy, force, quantity="displacement", name=f"{force:g} N"))

bounds = {"kt": (1.0, 0.1, 5.0), "limit": (0.5, 0.1, 5.0), "damping": (0.05, 0.002, 0.2)}  # start, low, high
found = ss.identify_response(blade, bounds, tests, leave_one_out=True)
print(found)
kt = found.values["kt"]
found.plot().savefig("measured_and_computed.png")
found.plot("misfits").savefig("misfits.png")
