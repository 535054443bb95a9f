"""Friction that falls with the normal load: the cycle of a damper compared with those of constant coefficients."""

import numpy as np

import stickslip as ss
from stickslip.dampers import BetweenPlatforms, Cylinder, out_of_phase

# The friction coefficient of a line of contact over its normal load in N; the friction force mu N is linear between these.
falling = ss.LoadDependentFriction(over=(20.0, 45.0, 90.0), values=(0.5, 0.3, 0.2))
damper = Cylinder(left_angle=40.0, right_angle=40.0).damper(pull=80.0)  # N

cycles = {}
for name, mu in (("0.5", 0.5), ("0.2", 0.2), ("falling", falling)):
    rig = BetweenPlatforms.macroslip(damper, kt=40e6, kn=60e6, mu=mu)  # N/m
    cycles[name] = ss.damper_cycle(rig, out_of_phase(60e-6), steps=400)  # m
    data = cycles[name].dataset
    normal, ratio = data.normal_force.values[:, 0], np.abs(data.force_ratio.values[:, 0])
    opening, closing = int(np.argmin(normal)), int(np.argmax(normal))
    print(
        f"mu = {name}: N {normal[opening]:.2f} to {normal[closing]:.2f} N, |T/N| {ratio[opening]:.3f} and {ratio[closing]:.3f} "
        f"there, energy of a cycle {1e6 * cycles[name].energy:.0f} uJ"
    )

cycles["falling"].plot().savefig("falling.png")
largest_load = float(cycles["falling"].dataset.normal_force.max())
