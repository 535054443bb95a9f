"""A split ring in the groove of a labyrinth seal: resonance under a travelling wave, and the energy that the ring takes."""

import stickslip as ss
from stickslip.rigs import ring_damper, ring_energy

seal = ring_damper(nodal_diameter=4, speed=600.0)  # pressed on by its centrifugal load, 600 rad/s
response = ss.forced_response(seal, ss.hertz(550, 590), force=[0.1, 0.5, 1.0, 2.0, 4.0, 8.0], harmonics=7, samples=128)
print(response)
response.plot().savefig("ring_damper.png")

peaks = response.peaks().groupby("force_level").first()
per_force = peaks.amplitude / peaks.index
lowest = float(per_force.min() / per_force.iloc[0])
print(f"slip takes the peak per newton down to {lowest:.3f} of what it is at the lowest force")

# Energy per cycle over the strain of the groove, of a ring with rigid Coulomb friction: 2 x 4 mm of steel on a radius of 244 mm.
radius, stiffness = 0.244, 2e11 * 8e-6
line_load = 7850.0 * 8e-6 * radius * 600.0**2
onset = 0.2 * line_load * radius / (4 * stiffness)
for a in (1.0, 1.5, 2.0, 3.0, 6.0):
    waves = [ring_energy(a * onset, 4, 0.2 * line_load, stiffness, radius, wave) for wave in ("travelling", "standing")]
    print(f"strain {a * onset:.2e}: {waves[0]:.5f} J under a travelling wave, {waves[1]:.5f} J under a standing one")
