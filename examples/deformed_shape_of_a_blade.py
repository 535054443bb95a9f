"""The deformed shape of a blade at its peaks: pads at half height hold it at a small force, and slip at a large one."""

import gzip
from pathlib import Path

import numpy as np

import stickslip as ss

# The deck blade.inp has nodes and elements, so that the surface of the mesh is known (here in the folder of the tests, packed).
run = Path(__file__).parents[1] / "tests" / "data" / "calculix"
for name in ("blade.inp", "blade.dof"):
    Path(name).write_bytes((run / name).read_bytes())
for name in ("blade.sti", "blade.mas"):
    Path(name).write_bytes(gzip.decompress((run / f"{name}.gz").read_bytes()))

places = {"left": (0, 60, -15), "right": (0, 60, 15), "tip": (0, 120, 15)}
blade = ss.read_structure("blade.inp", units="mm-t-s", keep=places, modes=20, damping=ss.ModalDamping(0.002))
pad = ss.Macroslip(kt=2e7, kn=2e7, mu=0.4, preload=20.0)
contacts = [
    ss.Contact(side, pad, ({f"{side}.x": 1.0}, {f"{side}.y": 1.0}), {f"{side}.z": closing})
    for side, closing in (("left", -1.0), ("right", 1.0))
]
problem = ss.Problem(blade, contacts, [ss.Force("tip.x", 1.0)], ["tip.x"], "Blade from CalculiX")
response = ss.forced_response(problem, ss.hertz(400, 1100), force=[0.5, 10.0], harmonics=3)

shares = []
for case in (0, 1):
    shape = response.deformed_shape(case)  # in a notebook, this alone shows it
    height, amplitude = shape.motion.points[:, 1], shape.motion.amplitude
    shares.append(amplitude[np.isclose(height, 0.06)].max() / amplitude.max())
    print(f"{shape}\nAt half height it moves by {shares[-1]:.1%} of the largest amplitude.\n")
held, slipping = shares

# shape.to_plotly().show() opens it in a browser, to be turned and played
response.deformed_shape(0).plot().savefig("deformed_shape_of_a_blade.png", dpi=90)
