"""Figures of docs/flutter.md: damping of travelling waves of the lumped disk, and the limit cycles of the least damped one."""

from pathlib import Path

import stickslip as ss

HERE = Path(__file__).parent

gas = ss.Aerodynamics(influence={0: 2400j, 1: -6000 - 2000j, -1: 6000 - 2000j}, frequency=152.7, direction="tip.t")
disk = ss.rigs.lumped_blisk("W").with_aerodynamics(gas)
ss.damping_by_nodal_diameter(disk).plot().savefig(HERE / "flutter_waves.svg", metadata={"Date": None})
cycles = ss.limit_cycles(disk.with_engine_order(-5 % 24), [0, -0.01], amplitude=(1e-5, 3e-2), harmonics=3, samples=96)
cycles.plot().savefig(HERE / "flutter_limit_cycles.svg", metadata={"Date": None})
