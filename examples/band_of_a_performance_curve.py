"""One performance curve misleads: the lowest and the highest resonance over all states from which the contacts may start."""

import stickslip as ss

rig = ss.rigs.blade_and_wedge(pull=60.0, platform_angle=35.0)
band = ss.performance_band(rig, [6, 25, 100], band=ss.hertz(280, 390), cloud=6, starts=1, harmonics=1, samples=128)

for ratio, (low, high) in zip(band.dataset.force_ratio.values, 1e6 * band.dataset.amplitude_per_force.values, strict=True):
    print(f"F_C/F_E = {ratio:5.1f}: {low:.3f} to {high:.3f} µm/N, {100 * (high / low - 1):.1f} % apart")
widest = float(band.dataset.amplitude_per_force[-1, 1] / band.dataset.amplitude_per_force[-1, 0])
band.plot().savefig("performance_band.png")
