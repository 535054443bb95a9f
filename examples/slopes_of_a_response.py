"""Which parameter moves a response, and how much: exact derivatives at one point, in percent per percent."""

from functools import partial

import stickslip as ss


def rig(name: str, value: float) -> ss.Problem:
    return ss.rigs.blade_and_wedge(**{name: value})


values = {"kt": 8e5, "kn": 1.2e6, "mu": 0.4, "pull": 60.0, "damper_mass": 0.02, "platform_angle": 35.0}
parameters = {name: ss.Parameter(value, partial(rig, name)) for name, value in values.items()}
found = ss.sensitivity(ss.rigs.blade_and_wedge(), 330.0, parameters, force=30.0)

amplitude = abs(found.response[0, 1])
for name, slope in found.amplitude_slopes().items():
    print(f"{name:15s} {slope[0] * values[name] / amplitude:8.4f} % per %")
by_friction = float(found.amplitude_slopes()["mu"][0]) * values["mu"] / amplitude
