"""A blade with a damper over the rotor speed: the pull on the damper and the stiffness of the blade go with its square."""

from dataclasses import replace

import numpy as np

import stickslip as ss


def at(speed: float) -> ss.Problem:
    """The blade and its wedge at a speed in rev/min: 60 N pull at 6000 rev/min, the blade stiffened by 15 % there."""
    share = (speed / 6000.0) ** 2
    rig = ss.rigs.blade_and_wedge(pull=60.0 * share)
    K = rig.structure.K.copy()
    K[0, 0] *= 1.0 + 0.15 * share
    return replace(rig, structure=replace(rig.structure, K=K), title="Blade and wedge")


models = {3000.0: at(3000.0), 6000.0: at(6000.0)}  # two models say how everything goes with the speed
sweep = ss.speed_sweep(models, (4800.0, 8400.0), [3, 4], force=6.0, harmonics=3)
print(sweep)
print(sweep.peaks().round(9).to_string(index=False))
top = sweep.peaks().iloc[0]
resonance_speed = float(top["speed"])
assert np.isclose(top["frequency"], top["engine_order"] * resonance_speed / 60.0)

diagram = ss.campbell(models, (4800.0, 8400.0), [3, 4])  # where the lines of the engine orders meet stuck and free frequencies
print(diagram.table().dropna().round(2).to_string(index=False))
sweep.plot().savefig("speed_sweep.png")
diagram.plot().savefig("campbell.png")
