"""A solved curve at frequencies of one's own choice, to compare with a measurement or another code: checked interpolation."""

import numpy as np

import stickslip as ss

wedge = ss.rigs.three_mass_wedge()
response = ss.forced_response(wedge, ss.hertz(145, 235), force=0.5)

frequencies = np.linspace(150.0, 230.0, 161)
curve = response.at(frequencies, tolerance=1e-3).sel(case=0, output="1.y")
there = curve["outcome"].values == 1  # (branch, frequency); the curve overhangs where there is more than one branch
print(f"{there.sum()} values: {int(curve.solved.sum())} solved, the others within {float(curve.error.max()):.1e} of the curve")

solved = ss.forced_response(wedge, list(frequencies), force=0.5).dataset["amplitude"].sel(case=0, output="1.y")
off = float(np.max(np.abs(curve["amplitude"].max("branch").values / solved.values - 1.0)))
print(f"Largest difference to 161 solved points: {off:.1e}")

amplitude = float(curve["amplitude"].max("branch").sel(frequency=163.0))
print(f"Amplitude at 163 Hz: {amplitude:.4e} m")
