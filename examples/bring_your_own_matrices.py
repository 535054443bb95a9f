"""Matrices from another program: name their degrees of freedom, add contacts and loads by name, compute."""

from pathlib import Path

import numpy as np

import stickslip as ss

# What a finite-element program exports: M and K of a cantilever with its tip and middle kept, here a small stand-in.
np.savez("blade.npz", M=np.diag([0.4, 0.2]), K=[[6e5, -2.5e5], [-2.5e5, 1.5e5]])

# In a study file, for the command line: stickslip run blade.toml --out results/blade
Path("blade.toml").write_text("""
[study]
analysis = "forced_response"
[structure]
matrices = "blade.npz"
dofs = ["middle.x", "tip.x"]
[damping]
modal = 0.002
[[contact]]
law = "macroslip"
between = ["middle.x", "ground"]
kt = 2e5
mu = 0.3
normal_load = 20.0
[[force]]
direction = "tip.x"
amplitude = 1.0
[sweep]
frequency = [60.0, 160.0]
force_levels = [0.1, 1.0, 5.0]
outputs = ["tip.x"]
""")

# The same in Python.
exported = np.load("blade.npz")
structure = ss.Structure(exported["M"], exported["K"], ("middle.x", "tip.x"), damping=ss.ModalDamping(0.002))
damper = ss.Contact("damper", ss.Macroslip(kt=2e5, mu=0.3, normal_load=20.0), (ss.between("middle.x", "ground"),))
blade = ss.Problem(structure, (damper,), (ss.Force("tip.x", 1.0),), ("tip.x",), "Blade from matrices")
peaks = ss.forced_response(blade, ss.hertz(60, 160), force=[0.1, 1.0, 5.0]).peaks()
print(peaks[["force_level", "frequency", "amplitude", "loss_factor"]])

highest = peaks[peaks["peak"] == 0].set_index("force_level")
best_loss_factor = float(highest["loss_factor"].max())
