"""From measured loops of a damper rig to contact stiffness and friction, on synthetic records whose truth is known."""

from importlib.resources import files

import numpy as np

import stickslip as ss

# The loops that `stickslip new identification` writes. Their truth is 56 and 84 N/µm, and 0.18, 0.199 and 0.45 at L1, L2 and R.
folder = files("stickslip.study.templates") / "beside" / "identification"
loops = [ss.read_record(str(folder / f"study_{name}.csv")) for name in ("out_of_phase", "in_phase")]

# What the loops say without a model: forces at the left, where they act, T/N, each with its error.
damper = ss.rigs.laboratory_damper(platform_angle=37.0, pull=80.0, friction=0.3, kt=30e6, kn=30e6)
forces = ss.reconstruct(ss.whole_cycles(loops[0]), damper)
print(f"largest T/N at the right: {float(np.nanmax(np.abs(forces.right_ratio))):.3f}")

# And with one: geometry and pull are known, contact parameters are not.
found = ss.identify(loops, damper, unknown=["kt", "kn", "mu_L1", "mu_L2", "mu_R"], errors=ss.RigErrors(), resamples=10)
print(found)
found.plot().savefig("loops.png")
found.plot(figure="posterior").savefig("posterior.png")
friction_right = found.values["mu_R"]
