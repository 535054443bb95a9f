"""One mode of a blade with a damper that presses on it: friction damps best between sticking and sliding freely."""

import numpy as np

import stickslip as ss

structure = ss.Structure(M=np.array([[0.1]]), K=np.array([[2.5e5]]), C=np.array([[1.6]]), dofs=("blade.x",))  # kg, N/m, N s/m
law = ss.Macroslip(kt=2e5, mu=0.4, normal_load=50.0)  # N/m, -, N
damper = ss.Contact("damper", law, tangential=(ss.between("blade.x", "ground"),))
problem = ss.Problem(structure, contacts=(damper,), forces=(ss.Force("blade.x", 1.0),), outputs=("blade.x",))

force_levels = [1.0, 5.0, 10.0, 20.0]  # N
response = ss.forced_response(problem, ss.Band(200.0, 400.0), force_levels, harmonics=7)
peaks = response.peaks()
print(peaks)

per_newton = peaks.groupby("force_level")["amplitude"].max() / force_levels
best_level = per_newton.idxmin()
smallest_amplitude_per_newton = per_newton.min()
print(f"The damper is best at {best_level:g} N: {1e6 * smallest_amplitude_per_newton:.1f} µm/N at the peak.")
