"""A stepped sine that dwells too short at each frequency: what is recorded upwards and downwards, and the steady response."""

import numpy as np

import stickslip as ss

# A mass of 1 kg at 15.9 Hz, damping ratio 0.2 %, on a slider that slips from 1 N on.
structure = ss.Structure(np.eye(1), np.array([[1e4]]), ("1.x",), C=np.array([[0.4]]))
slider = ss.Contact("slider", ss.Macroslip(kt=2e3, mu=1.0, normal_load=1.0), ({"1.x": 1.0},))
mass = ss.Problem(structure, (slider,), (ss.Force("1.x", 1.0),), ("1.x",), "Mass on a slider")

frequencies, force = np.linspace(15.4, 17.6, 12), 1.5  # N
upwards = ss.stepped_sine(mass, frequencies, force, dwell=15, steps_per_period=400)
downwards = ss.stepped_sine(mass, frequencies[::-1], force, dwell=15, steps_per_period=400, start=upwards.end)
upwards = upwards.with_response(ss.forced_response(mass, frequencies.tolist(), force, harmonics=7))
steady = upwards.dataset["balance_amplitude"].values[:, 0]

for k in range(0, frequencies.size, 3):
    up, down = (1e3 * float(sweep.dataset["amplitude"][j, 0]) for sweep, j in ((upwards, k), (downwards, -1 - k)))
    print(f"{frequencies[k]:.1f} Hz: upwards {up:.3f} mm, downwards {down:.3f} mm, steady {1e3 * steady[k]:.3f} mm")

peak = 1e3 * float(upwards.dataset["amplitude"].max())
upwards.plot().savefig("stepped_sine_with_dwell.png")
