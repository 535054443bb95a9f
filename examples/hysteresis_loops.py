"""Hysteresis loops of a chain of masses on sliders: their area is the energy that each contact dissipates."""

import numpy as np

import stickslip as ss

chain = ss.rigs.chain(masses=6, sliders=(4, 5, 6), forced=3)
response = ss.forced_response(chain, ss.radians_per_second(0.1, 0.6), force=[1.0, 2.0], harmonics=7)
data = response.dataset

for case, level in enumerate(data["force_level"].values):
    loops = data.isel(case=case).sel(direction="t1")
    u, T = loops["loop_motion"].values, loops["loop_force"].values
    areas = np.abs(np.sum(0.5 * (T + np.roll(T, -1, axis=-1)) * (np.roll(u, -1, axis=-1) - u), axis=-1))
    frequency = float(data["loop_frequency"][case])
    print(f"force {level:g} N, peak at {frequency:.4f} Hz: loop areas " + ", ".join(f"{area:.3f} J" for area in areas))

response.plot("loops").savefig("loops.png")
largest_area = float(areas.max())
