"""A blade in its dovetail: the less the centrifugal load presses the flanks, the sooner they slip and part as the blade rocks."""

import stickslip as ss
from stickslip.rigs import blade_root

response = ss.forced_response(blade_root(pull=5e3), ss.hertz(112, 125), force=[0.2, 1.0, 3.0, 10.0], harmonics=5, samples=128)
print(response)
response.plot().savefig("blade_root.png")

for pull in (2e3, 5e3, 20e3):
    blade = blade_root(pull=pull)
    peak = ss.forced_response(blade, ss.hertz(105, 125), force=3.0, harmonics=5, samples=128).peaks().iloc[0]
    print(f"{pull:5g} N: {peak.frequency:.2f} Hz, loss factor {peak.loss_factor:.4f}")
    if pull == 5e3:
        loss_factor = float(peak.loss_factor)

for factor in (1.0, 1.44):  # a run at 1.2 times the speed before leaves less friction, and more load on the flanks
    blade = ss.after_load_steps(blade_root(pull=5e3), [factor])
    data = ss.forced_response(blade, [118.0], force=0.2, harmonics=5, samples=128).dataset
    rest = data[["rest_load", "rest_friction", "rest_slip"]].isel(contact=(data["contact_surface"] == "left").values)
    load, friction, slip = float(rest.rest_load.sum()), float(rest.rest_friction.sum()), 1e6 * float(rest.rest_slip.max())
    print(f"after {factor:g} times the pull: {load:.0f} N and {friction:.0f} N of friction on a flank, {slip:.2f} µm of slip")
