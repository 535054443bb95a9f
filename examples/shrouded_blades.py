"""Blades with interlocking shrouds: the untwist goes with the square of the speed and decides how the faces rub."""

import stickslip as ss
from stickslip.rigs import shrouded_blades

for speed in (1500.0, 3000.0, 4500.0):
    blades = shrouded_blades(untwist=20.0 * (speed / 3000.0) ** 2)  # 20 N m at 3000 rev/min
    response = ss.forced_response(blades, ss.hertz(215, 266), force=100.0, harmonics=5, samples=160)
    peak = response.peaks().iloc[0]
    print(f"{speed:g} rev/min: {peak.frequency:.1f} Hz, {1e6 * peak.amplitude:.1f} µm, loss factor {peak.loss_factor:.4f}")
    if speed == 3000.0:
        frequency = float(peak.frequency)

response = ss.forced_response(
    shrouded_blades(untwist=20.0), ss.hertz(235, 266), force=[20.0, 50.0, 100.0, 150.0], harmonics=5, samples=160
)
print(response)
response.plot().savefig("shrouded_blades.png")
