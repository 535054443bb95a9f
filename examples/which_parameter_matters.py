"""Which uncertain parameter spreads the resonance: Sobol' indices and a tornado plot."""

import stickslip as ss


def rig(*, kt: float, kn: float, mu: float, preload: float, offset: float) -> ss.Problem:
    problem = ss.rigs.blade_and_wedge(pull=preload, mu=mu, kt=kt, kn=kn)
    return problem.with_start(ss.SliderOffset(offset))


ranges = {"kt": (6e5, 1e6), "kn": (9e5, 1.5e6), "mu": (0.3, 0.5), "preload": (50.0, 70.0), "offset": (-1e-5, 1e-5)}
found = ss.sensitivity_indices(rig, ranges, ss.hertz(300, 380), force=4.0, draws=8, harmonics=3, samples=64)

for name, (amplitude, frequency) in zip(ranges, found.dataset.total.values, strict=True):
    print(f"{name:8s} total index {amplitude:.2f} of the amplitude, {frequency:.2f} of the frequency")
amplitude_at_the_middle = float(found.dataset.middle[0])
found.plot().savefig("tornado.png")
