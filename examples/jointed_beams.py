"""Two beams joined by friction, from a template: a contact surface between two meshes, and the joint that opens at its edge."""

import subprocess
import sys

import stickslip as ss

# The study with the models of both beams, as `stickslip new jointed_beams` writes it; `stickslip run` would compute it too.
subprocess.run([sys.executable, "-m", "stickslip", "new", "jointed_beams", "--force"], check=True)
problem = ss.read_problem("jointed_beams.toml")
print(problem, "\nstuck", problem.frequencies(stuck=True)[:2], "Hz")

response = ss.forced_response(problem, ss.hertz(115, 130), force=[0.02, 0.06, 0.07, 0.08], harmonics=5)
peaks = response.peaks()
print(peaks[peaks["peak"] == 0][["force_level", "frequency", "amplitude"]])
stuck_frequency = float(problem.frequencies(stuck=True)[0])
response.plot().savefig("jointed_beams.png")
