"""A resonance test at held acceleration: one force at each frequency where the forced response folds, and the phase resonance."""

import numpy as np

import stickslip as ss

structure = ss.Structure(M=np.eye(1), K=np.eye(1), C=0.02 * np.eye(1), dofs=("1.x",))
spring = ss.Contact("spring", ss.CubicSpring(0.3), tangential=(ss.between("1.x", "ground"),))
beam = ss.Problem(structure, contacts=(spring,), forces=(ss.Force("1.x", 1.0),), outputs=("1.x",), title="A hardening beam")

held = ss.controlled_response(beam, ss.hertz(0.14, 0.22), amplitude=[0.2, 0.5, 1.0])  # m/s²
print(held.resonances())  # frequency and force where force and displacement are at 90°
test = ss.phase_resonance(beam, ss.hertz(0.1, 0.2), amplitude=np.geomspace(0.1, 20.0, 30))
print(test.dataset["frequency"].values[[0, -1]])

force = float(held.dataset["resonance_force_level"][2, 0])
forced = ss.forced_response(beam, ss.hertz(0.1, 0.4), force)  # the same oscillator at that force folds
top = float(forced.peaks(quantity="acceleration")["amplitude"].max())
held.plot().savefig("acceleration_held.png")
test.plot().savefig("phase_resonance.png")
