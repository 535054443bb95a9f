"""A blade rings after an impact: its frequency and damping ratio depend on the amplitude."""

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

decay = ss.free_decay(blade, duration=0.15, velocity={"tip.y": 0.5}, steps=30_000)  # m/s
half = decay.dataset.isel(output=0)
for k in (1, 8, 16, 20, 24):
    amplitude, damping = 1e6 * half.amplitude[k], 100.0 * half.damping_ratio[k]
    print(f"{amplitude:6.1f} µm: {half.frequency[k]:6.1f} Hz, damping ratio {damping:.2f} %")

largest_damping = 100.0 * float(half.damping_ratio.max())
mode = ss.nonlinear_modes(blade, amplitude=(2.5e-5, 4.5e-4))  # m
decay.with_modes(mode).plot().savefig("decay_after_an_impact.png")
