"""A wedge under a blade's platform in motion: one period of the resonance peak as a film, and how long each contact slips."""

import numpy as np

import stickslip as ss

problem = ss.rigs.blade_and_wedge(pull=60.0)
response = ss.forced_response(problem, ss.Band(300.0, 370.0), force=10.0, harmonics=5, samples=96)

animation = response.animate()  # in a notebook, this alone shows it
print(animation)
for point in animation.motion.points:
    largest = np.linalg.norm(point.force, axis=1).max()
    print(f"{point.name} slips {np.mean(point.state == 1):.0%} of the period, with up to {largest:.1f} N")
carried = -sum(point.force[:, 1].mean() for point in animation.motion.points)
print(f"On average both contacts carry the pull: {carried:.2f} N")

animation.plot(12).savefig("damper_in_motion.png")
# animation.save("damper_in_motion.gif")
