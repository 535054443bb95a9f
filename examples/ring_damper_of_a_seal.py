"""A split ring in the groove of a labyrinth seal: resonance under a travelling wave, and how far the ring damps it."""

import stickslip as ss
from stickslip.rigs import ring_damper

seal = ring_damper(nodal_diameter=4, speed=600.0)  # pressed on by its centrifugal load, 600 rad/s
response = ss.forced_response(seal, ss.hertz(550, 590), force=[0.1, 0.5, 1.0, 2.0, 4.0, 8.0], harmonics=7, samples=128)
print(response)
response.plot().savefig("ring_damper.png")

peaks = response.peaks().groupby("force_level").first()
per_force = peaks.amplitude / peaks.index
lowest = float(per_force.min() / per_force.iloc[0])
print(f"slip takes the peak per newton down to {lowest:.3f} of what it is at the lowest force")
