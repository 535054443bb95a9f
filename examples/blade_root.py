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
