"""A blade that CalculiX meshed and wrote: contacts by coordinates, reduction, damped forced response."""

import gzip
from pathlib import Path

import stickslip as ss

# The deck blade.inp and what `ccx blade` left: blade.sti, blade.mas, blade.dof (here in the folder of the tests, packed).
run = Path(__file__).parents[1] / "tests" / "data" / "calculix"
for name in ("blade.inp", "blade.dof"):
    Path(name).write_bytes((run / name).read_bytes())
for name in ("blade.sti", "blade.mas"):
    Path(name).write_bytes(gzip.decompress((run / f"{name}.gz").read_bytes()))

# Two friction pads press on the edges at half height, the excitation acts at the tip. Coordinates in mm, as in the deck.
places = {"left": (0, 60, -15), "right": (0, 60, 15), "tip": (0, 120, 15)}
blade = ss.read_structure(
    "blade.inp",
    units="mm-t-s",
    keep=places,
    modes=10,
    damping=ss.ModalDamping(0.002),
    progress=lambda share, text: print(f"{share:4.0%} {text}"),
)
pad = ss.Macroslip(kt=1e6, kn=1e6, mu=0.4, preload=20.0)
contacts = [
    ss.Contact(side, pad, ({f"{side}.x": 1.0}, {f"{side}.y": 1.0}), {f"{side}.z": closing})
    for side, closing in (("left", -1.0), ("right", 1.0))
]
problem = ss.Problem(blade, contacts, [ss.Force("tip.x", 1.0)], ["tip.x"], "Blade from CalculiX")
print("free", problem.frequencies(stuck=False)[:2], "stuck", problem.frequencies(stuck=True)[:2])

peaks = ss.forced_response(problem, ss.hertz(440, 640), force=[0.5, 5.0, 20.0, 100.0], harmonics=3).peaks()
print(peaks[["force_level", "frequency", "amplitude", "loss_factor"]])

highest = peaks[peaks["peak"] == 0].set_index("force_level")
best_loss_factor = float(highest["loss_factor"].max())
