"""A line contact that slips piece by piece: elements with growing gaps carry less load and slip first."""

import numpy as np

import stickslip as ss

line = ss.MicroslipArray.from_totals(kt=45e6, kn=260e6, mu=0.4, largest_gap=0.4e-6, elements=5)
closed = 0.45e-6  # normal displacement, m: all five elements are closed

for amplitude in np.array([0.1, 0.2, 0.3, 0.5, 1.0]) * 1e-6:
    energy, traction = line.loop_energy(amplitude, closed), line.virgin_curve(amplitude, closed)
    print(f"amplitude {1e6 * amplitude:4.2f} µm: traction {traction:6.2f} N, energy {1e6 * energy:8.4f} µJ per cycle")

one = ss.Macroslip(kt=45e6, mu=0.4, kn=260e6)
energy_in_microslip = 1e6 * line.loop_energy(0.2e-6, closed)
energy_of_one = 1e6 * one.loop_energy(0.2e-6, closed)
print(f"At 0.2 µm one element of the same stiffness gives {energy_of_one:g} µJ, the array {energy_in_microslip:.3f} µJ.")
