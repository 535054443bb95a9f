"""A damper alone between two platforms: hysteresis, forces and states of one cycle, and how friction and shape change it."""

import stickslip as ss
from stickslip.dampers import in_phase, out_of_phase
from stickslip.rigs import laboratory_damper

# Two platforms at 37 degrees, 50 N on the damper, friction of the two feet L1, L2 and of the cylinder R.
rig = laboratory_damper(platform_angle=37.0, pull=50.0, friction=(0.40, 0.22, 0.32))
cycle = ss.damper_cycle(rig, out_of_phase(30e-6))
print(cycle.sentence)
energy = 1e6 * cycle.energy
print(f"{energy:.1f} uJ a cycle, of which each contact takes {(1e6 * cycle.dataset.friction_work.values).round(1)}")

print("\nshare of the cycle        stick   slip   open")
for contact in cycle.dataset.contact.values:
    print(f"{contact:>22}   ", "  ".join(f"{share:5.2f}" for share in cycle.dataset.share.sel(contact=contact).values))

# In phase the three-point damper rolls and lifts a foot; with both contacts in one place it cannot.
print("\nin phase, 45 degrees      energy    rotation   L2 open")
for shape in ("three_point", "crossed_curved_flat"):
    other = ss.damper_cycle(laboratory_damper(45.0, 50.0, (0.40, 0.22, 0.32), shape), in_phase(30e-6)).dataset
    lifted = float(other.share.sel(contact="L2", kind="open"))
    print(f"{shape:>22} {1e6 * float(other.loop_energy):8.1f} uJ {1e3 * float(other.rotation):6.3f} mrad {lifted:8.2f}")

cycle.plot().savefig("cycle_of_a_damper.png")
