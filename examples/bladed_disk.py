"""A finite-element disk of 24 blades with cylinders between them: what the choice of contact stiffness does to its resonance."""

import numpy as np

import stickslip as ss
from stickslip.show.plots.disk import disk_mode

measured, analytic = (ss.rigs.octopus_blisk(contact) for contact in ("measured", "analytic"))
for name, disk in (("measured", measured), ("analytic", analytic)):
    print(f"{name}: stuck at {disk.frequencies(stuck=True)[0]:.2f} Hz")

ss.nodal_diameters(measured).plot().savefig("nodal_diameters.png")

response = ss.forced_response(measured, ss.hertz(143, 146), force=[0.4], harmonics=1, samples=48)
disk_mode(response.dataset).savefig("disk_mode.png")
peak = response.peaks().iloc[0]
mobility = peak.amplitude * 2 * np.pi * peak.frequency / 0.4
print(f"0.4 N: {peak.frequency:.2f} Hz, {mobility:.4f} m/s/N")

stuck_frequency_ratio = float(analytic.frequencies(stuck=True)[0] / measured.frequencies(stuck=True)[0])
