"""Two equal masses that cease to vibrate alike: the branch from where their symmetric motion becomes unstable."""

import numpy as np

import stickslip as ss

coupling = 0.05  # N/m, between masses of 1 kg on springs of 1 N/m and 1 N/m³
K = np.array([[1.0 + coupling, -coupling], [-coupling, 1.0 + coupling]])
structure = ss.Structure(np.eye(2), K, ("1.x", "2.x"), C=0.02 * np.eye(2))
springs = [ss.Contact(f"spring {n}", ss.CubicSpring(1.0), (ss.between(f"{n}.x", "ground"),)) for n in (1, 2)]
force = ss.Force({"1.x": 1.0, "2.x": -1.0}, 0.03)
problem = ss.Problem(structure, springs, (force,), ("1.x", "2.x"), "Two equal masses")

swept = ss.forced_response(problem, ss.radians_per_second(0.7, 1.6), samples=64)
print(swept.branch_points())

branch = swept.branch()
response = swept.with_curves(branch).with_stability()
print(response)
response.plot().savefig("branch.png")

amplitude = branch.dataset.amplitude.values[0]
one_sided = float(np.nanmax(amplitude[:, 0] / amplitude[:, 1]))
print(f"On the branch one mass moves up to {one_sided:.1f} times as far as the other.")
