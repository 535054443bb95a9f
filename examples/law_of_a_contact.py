"""From a measured record of one contact to its stiffness, friction and law: a reciprocating friction test."""

import gzip
from pathlib import Path

import stickslip as ss

# A reciprocating test (FrictionModels.jl, MIT licence; here in the folder of the tests, packed).
packed = Path(__file__).parents[1] / "tests" / "data" / "tribometer" / "test_data_2.txt.gz"
Path("record.txt").write_bytes(gzip.decompress(packed.read_bytes()))

found = ss.contact_law("record.txt", normal_load=5.0)  # N; columns and units are in the file
print(found)

# The same slider as a contact law for a forced response, and its energy beside the measured one.
data = found.dataset
slider = ss.Macroslip(kt=found.kt, mu=found.mu, normal_load=5.0)
amplitude = 0.5 * float(data["displacement"].isel(loop=0).max() - data["displacement"].isel(loop=0).min())
energies = slider.loop_energy(amplitude), float(data["energy_measured"].mean())
print("energy per cycle: slider {:.3f} mJ, measured {:.3f} mJ".format(*(1e3 * energy for energy in energies)))

found.plot().savefig("loops.png")
found.plot("cycles").savefig("cycles.png")  # kt, mu and energy against the number of the cycle
friction = found.mu
