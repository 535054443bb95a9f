"""A blade with a damper runs up through a resonance, in time, slowly and fast, compared with a quasi-steady sweep."""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import stickslip as ss


def at(speed: float) -> ss.Problem:
    """The blade and its wedge at a speed in rev/min: 60 N pull at 6000 rev/min, the blade stiffened by 15 % there."""
    share = (speed / 6000.0) ** 2
    rig = ss.rigs.blade_and_wedge(pull=60.0 * share)
    K = rig.structure.K.copy()
    K[0, 0] *= 1.0 + 0.15 * share
    return replace(rig, structure=replace(rig.structure, K=K), title="Blade and wedge")


models, ends = {3000.0: at(3000.0), 6000.0: at(6000.0)}, (7000.0, 8200.0)
sweep = ss.speed_sweep(models, ends, [3], force=6.0, harmonics=9).dataset.isel(engine_order=0, case=0, output=0)
figure, axes = plt.subplots()
axes.plot(sweep["speed"], 1e6 * sweep["amplitude"], "k--", label="quasi-steady")
highest = {}
for duration in (10.0, 0.2):
    run = ss.run_up(models, ends, duration, 3, force=6.0).dataset.isel(case=0, output=0)
    highest[duration] = float(run["amplitude"].max())
    top = float(run["speed"][np.argmax(run["amplitude"].values)])
    print(f"{duration:g} s: highest {1e6 * highest[duration]:.1f} µm at {top:.0f} rev/min. {run['message'].item()}")
    axes.plot(run["speed"], 1e6 * run["amplitude"], label=f"in {duration:g} s")
quasi_steady = float(sweep["amplitude"].max())
fast_over_quasi_steady = highest[0.2] / quasi_steady
slow_over_quasi_steady = highest[10.0] / quasi_steady
print(f"of the quasi-steady peak: slow {slow_over_quasi_steady:.3f}, fast {fast_over_quasi_steady:.3f}")
axes.set(xlabel="rotor speed in rev/min", ylabel="amplitude in µm", title="Run-up of a blade with a wedge")
axes.legend()
figure.savefig("run_up.png")
