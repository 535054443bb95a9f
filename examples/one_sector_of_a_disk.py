"""A bladed disk with dampers between all blades: one sector gives what all 24 give, and what the dampers do for it."""

import numpy as np

import stickslip as ss

disk = ss.rigs.lumped_blisk("W", engine_order=2)
response = ss.forced_response(disk, ss.hertz(140, 156), force=[0.1, 0.4, 1.6], harmonics=3, samples=96)
for peak in response.peaks().itertuples():
    mobility = peak.amplitude * 2 * np.pi * peak.frequency / peak.force_level
    print(f"{peak.force_level:4g} N: {peak.frequency:.3f} Hz, {mobility:.4f} m/s/N, loss factor {peak.loss_factor:.4f}")
response.plot().savefig("disk.png")

# The whole disk at one frequency, every damper with its own contact states.
frequencies = [147.0, 148.5]
whole = ss.forced_response(disk.full(reported=[1, 7]), frequencies, force=0.4, harmonics=3, samples=96)
one = ss.forced_response(disk, frequencies, force=0.4, harmonics=3, samples=96)
difference = float(np.abs(whole.dataset.amplitude.isel(output=0) / one.dataset.amplitude.isel(output=0) - 1.0).max())
print(f"24 sectors against one: {difference:.1e}")

mobility_at_4_tenths = float(one.dataset.amplitude[0, -1, 0]) * 2 * np.pi * 148.5 / 0.4
