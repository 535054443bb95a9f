"""Flutter of a bladed disk held by its dampers: which wave gas feeds, how far it grows, and how much friction holds."""

import stickslip as ss

# Force on a blade per motion of itself, of the blade after it and of that before it, N/m, at 152.7 Hz.
influence = {0: 2400j, 1: -6000 - 2000j, -1: 6000 - 2000j}
gas = ss.Aerodynamics(influence=influence, frequency=152.7, direction="tip.t")
disk = ss.rigs.lumped_blisk("W").with_aerodynamics(gas)  # 24 sectors, a wedge between all neighbours

waves = ss.damping_by_nodal_diameter(disk)
worst = waves.table().iloc[0]
n, least_damping = int(worst["nodal_diameter"]), float(worst["damping_ratio"])
print(f"least damped: nodal diameter {n}, {100 * least_damping:.3f} % at {worst['frequency']:.2f} Hz with contacts stuck")

flutter = disk.with_engine_order(n % 24)  # one sector, moving in this wave
cycles = ss.limit_cycles(flutter, [0.0, -0.01, -0.02], amplitude=(1e-5, 3e-2), harmonics=3, samples=96)
print(cycles)
cycles.plot().savefig("limit_cycles.png")
waves.plot().savefig("damping_by_nodal_diameter.png")
