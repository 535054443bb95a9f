"""A ring-down test: frequency and damping of a measured decay with errors, compared with the nonlinear mode of the model."""

import numpy as np

import stickslip as ss

# One bending mode of a blade, 0.4 kg at 180 Hz without its damper, and an underplatform damper that sticks or slips.
mass, free_frequency, damping_ratio = 0.4, 180.0, 0.001
omega = 2.0 * np.pi * free_frequency
structure = ss.Structure(
    np.array([[mass]]), np.array([[mass * omega**2]]), ("tip.y",), C=np.array([[2.0 * damping_ratio * mass * omega]])
)
damper = ss.Contact("damper", ss.Macroslip(kt=2e5, mu=0.3, normal_load=20.0), ({"tip.y": 1.0},))
blade = ss.Problem(structure, (damper,), (ss.Force("tip.y", 1.0),), ("tip.y",), "Blade with a damper")

# In place of a measurement: the decay after an impact, sampled 20 000 times a second, with noise, in a text file.
decay = ss.free_decay(blade, duration=0.15, velocity={"tip.y": 0.5}, steps=30_000).dataset.isel(time=slice(0, None, 10))
signal = decay["displacement"].values[0] + 1e-6 * np.random.default_rng(0).normal(size=decay.sizes["time"])
rows = np.column_stack([decay["time"], 1e6 * signal])
np.savetxt("ring_down.csv", rows, "%.8g", ",", header="time [s],displacement [um]", comments="")

measured = ss.read_decay("ring_down.csv")
print(measured)
mode = ss.nonlinear_modes(blade, amplitude=(2.5e-5, 4.5e-4))  # m
measured.with_modes(mode).plot().savefig("measured_decay.png")
stuck_frequency = float(measured.dataset["frequency"][-10:].mean())  # of the last windows
