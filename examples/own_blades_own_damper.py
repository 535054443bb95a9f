"""Two blades from CalculiX with a wedge damper between their platforms: contact surfaces from node sets, forced response."""

import gzip
from pathlib import Path

import stickslip as ss
from stickslip.units import mm

# The deck platform_blade.inp and what `ccx platform_blade` left (here in the folder of the tests, packed).
run = Path(__file__).parents[1] / "tests" / "data" / "calculix"
for name in ("platform_blade.inp", "platform_blade.dof"):
    Path(name).write_bytes((run / name).read_bytes())
for name in ("platform_blade.sti", "platform_blade.mas"):
    Path(name).write_bytes(gzip.decompress((run / f"{name}.gz").read_bytes()))

# One blade, read once and set up twice. PLATL and PLATR are the node sets of the undersides of its platforms.
keep = {"tip": (0, 122, 0), "PLATL": "PLATL", "PLATR": "PLATR"}
blade = ss.read_structure("platform_blade.inp", units="mm-t-s", keep=keep, modes=10)
wedge = ss.dampers.Wedge(width=24 * mm, height=6 * mm, depth=30 * mm, left_angle=35.0, right_angle=35.0)
damper = wedge.damper(centre=(20 * mm, 52 * mm, 0.0), pull=600.0)
bodies = {"left": blade, "right": blade.shifted((40 * mm, 0.0, 0.0)), "damper": damper.structure}
structure = ss.assemble(bodies).with_damping(ss.ModalDamping(0.002))

# The law of a whole surface is shared over its nodes by area; normals come from the mesh, on the damper's side.
law = ss.Macroslip(kt=5e6, kn=1e7, mu=0.4)
surfaces = {"L": "left/PLATR", "R": "right/PLATL"}
contacts = [
    contact
    for side, nodes in surfaces.items()
    for contact in ss.surface_contacts(side, law, ss.NodeSurface.of(structure, nodes).facing(damper.body.centre), damper.at)
]
forces = [ss.Force("left/tip.x", 1.0), ss.Force("right/tip.x", -1.0), *damper.forces()]
problem = ss.Problem(structure, contacts, forces, ["left/tip.x"], "Two blades and a wedge damper")
problem.plot().savefig("own_blades_model.png")  # or problem.to_plotly().show(), which can be turned
print(problem, "\nstuck", problem.frequencies(stuck=True)[:2], "Hz")

response = ss.forced_response(problem, ss.hertz(400, 750), force=[1.0, 5.0, 20.0, 60.0], harmonics=5)
peaks = response.peaks()
print(peaks[["force_level", "frequency", "amplitude", "loss_factor"]])

highest = peaks[peaks["peak"] == 0].set_index("force_level")
frequency_at_5_newton = float(highest.loc[5.0, "frequency"])
response.plot().savefig("own_blades_own_damper.png")
