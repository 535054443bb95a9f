"""A mass on a spring that rubs against the ground: the friction that damps best lies between sticking and sliding freely."""

import numpy as np

import stickslip as ss

structure = ss.Structure(M=np.eye(1), K=np.eye(1), C=0.02 * np.eye(1), dofs=("1.x",))
slider = ss.Contact("slider", ss.Macroslip(kt=1.0, mu=1.0, normal_load=1.0), tangential=(ss.between("1.x", "ground"),))
problem = ss.Problem(structure, contacts=(slider,), forces=(ss.Force("1.x", 1.0),), outputs=("1.x",))

response = ss.forced_response(problem, ss.radians_per_second(0.5, 2.0), force=[0.1, 0.5, 1.0, 2.0], harmonics=7)
peaks = response.peaks()
print(peaks)

per_newton = peaks.groupby("force_level")["amplitude"].max() / [0.1, 0.5, 1.0, 2.0]
best_level = per_newton.idxmin()
smallest_amplitude_per_newton = per_newton.min()
print(f"The slider damps best at {best_level} N: {smallest_amplitude_per_newton:.3f} m/N at the peak.")
