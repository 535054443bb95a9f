"""Two blades and a wedge damper at three rotor speeds: every part is pulled outward by its own mass."""

import gzip
from pathlib import Path

import matplotlib.pyplot as plt

import stickslip as ss
from stickslip.units import mm

# The deck platform_blade.inp and the files of `ccx platform_blade` (here in the folder of the tests, packed).
run = Path(__file__).parents[1] / "tests" / "data" / "calculix"
for name in ("platform_blade.inp", "platform_blade.dof"):
    Path(name).write_bytes((run / name).read_bytes())
for name in ("platform_blade.sti", "platform_blade.mas"):
    Path(name).write_bytes(gzip.decompress((run / f"{name}.gz").read_bytes()))

keep = {"tip": (0, 122, 0), "PLATL": "PLATL", "PLATR": "PLATR"}
blade = ss.read_structure("platform_blade.inp", units="mm-t-s", keep=keep, modes=6)
damper = ss.dampers.Wedge(width=24 * mm, height=6 * mm, depth=30 * mm, left_angle=35.0, right_angle=35.0).damper(
    centre=(20 * mm, 52 * mm, 0.0)
)
parts = {"left": blade, "right": blade.shifted((40 * mm, 0.0, 0.0)), "damper": damper.structure}
axis = ((20 * mm, -300 * mm, 0.0), (0.0, 0.0, 1.0))  # the axis of the rotor: 300 mm below the feet, along z

law, surfaces = ss.Macroslip(kt=5e6, kn=1e7, mu=0.4), {"L": "left/PLATR", "R": "right/PLATL"}
for speed in (1000.0, 2000.0, 4000.0):  # rev/min
    turning = {name: ss.in_rotation(part, speed, axis, part=name) for name, part in parts.items()}
    structure = ss.assemble({name: part for name, (part, _) in turning.items()}).with_damping(ss.ModalDamping(0.002))
    pull = turning["damper"][1].resultant[1]
    contacts = [
        contact
        for side, nodes in surfaces.items()
        for contact in ss.surface_contacts(
            side, law, ss.NodeSurface.of(structure, nodes).facing(damper.body.centre), damper.at, points=3
        )
    ]
    forces = [ss.Force("left/tip.x", 5.0), ss.Force("right/tip.x", -5.0), *(load for _, load in turning.values())]
    problem = ss.Problem(structure, contacts, forces, ["left/tip.x"])
    response = ss.forced_response(problem, ss.hertz(400, 750), harmonics=1, samples=64)
    peak = response.peaks().iloc[0]
    print(f"{speed:g} rev/min: pull {pull:.1f} N, peak {peak['amplitude'] * 1e6:.1f} um at {peak['frequency']:.1f} Hz")
    data = response.dataset
    plt.semilogy(data["frequency"].values[0], 1e6 * data["amplitude"].values[0, :, 0], label=f"{speed:g} rev/min, {pull:.0f} N")
plt.xlabel("frequency in Hz")
plt.ylabel("amplitude of the left tip in µm")
plt.legend()
plt.savefig("damper_flung_by_the_rotation.png")
