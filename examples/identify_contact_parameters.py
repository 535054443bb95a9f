"""From measured loops of a damper rig to contact stiffness and friction, on synthetic records whose truth is known."""

import numpy as np

import stickslip as ss
from stickslip.dampers import in_phase, out_of_phase
from stickslip.laboratory.measurement.reconstruction import synthetic_record, true_cycle

# The rig, with the friction and stiffness that are to be found again: 56 and 84 N/µm; 0.18, 0.199 and 0.45 at L1, L2 and R.
truth = ss.rigs.laboratory_damper(platform_angle=37.0, pull=80.0)
errors = ss.RigErrors()
cells = errors.draw(np.random.default_rng(1))
loops = [
    synthetic_record(true_cycle(truth, motion), errors, seed=seed, systematic=cells, name=name)
    for seed, (name, motion) in enumerate({"out of phase": out_of_phase(30e-6), "in phase": in_phase(30e-6)}.items())
]
# From a file: loops = [ss.read_record("out_of_phase.csv"), ss.read_record("in_phase.csv")]

# What the loops say without a model: forces at the left, where they act, T/N, each with its error.
forces = ss.reconstruct(ss.whole_cycles(loops[0]), truth)
print(f"largest T/N at the right: {float(np.nanmax(np.abs(forces.right_ratio))):.3f}")

# And with one: geometry and pull are known, contact parameters are not.
damper = ss.rigs.laboratory_damper(platform_angle=37.0, pull=80.0, friction=0.3, kt=30e6, kn=30e6)
found = ss.identify(loops, damper, unknown=["kt", "kn", "mu_L1", "mu_L2", "mu_R"], errors=errors, resamples=10)
print(found)
found.plot().savefig("loops.png")
found.plot(figure="posterior").savefig("posterior.png")
friction_right = found.values["mu_R"]
