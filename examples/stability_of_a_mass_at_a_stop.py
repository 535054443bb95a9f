"""Which points of a curve a machine can run at: a mass that strikes a spring, with the parts of its curve that are unstable."""

import numpy as np

import stickslip as ss

structure = ss.Structure(np.eye(1), np.eye(1), ("1.x",), C=np.array([[0.04]]))  # kg, N/m, N s/m
stop = ss.Contact("stop", ss.Gap(3.0, gap=1.0), normal=ss.between("1.x", "ground"))  # N/m, m
problem = ss.Problem(structure, (stop,), (ss.Force("1.x", 0.2),), ("1.x",), "Mass at a stop")

response = ss.forced_response(problem, ss.radians_per_second(0.7, 1.6), harmonics=15, samples=1024).with_stability()

print(response)
print(response.peaks()[["frequency", "amplitude", "stability"]])
response.plot().savefig("stability.svg")  # unstable parts are dashed
folds = response.dataset.stability_change_frequency.values[0]
upper_fold = 2 * np.pi * folds.max()
