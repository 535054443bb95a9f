"""A strip under the platforms of neighbouring blades: how heavy must it be? Slip spreads from the gap, or takes all of it."""

import stickslip as ss
from stickslip.rigs import strip_damper

forces = [0.03, 0.3, 1.0, 3.0]
response = ss.forced_response(strip_damper(pull=600.0), ss.hertz(484, 503), force=forces, harmonics=9, samples=256)
print(response)
response.plot().savefig("strip_damper.png")

for pull in (150.0, 600.0, 2400.0):
    strip = strip_damper(pull=pull)
    peak = ss.forced_response(strip, ss.hertz(484, 503), force=1.0, harmonics=9, samples=256).peaks().iloc[0]
    print(f"{pull:g} N: {1e6 * peak.amplitude:.0f} µm at {peak.frequency:.1f} Hz, loss factor {peak.loss_factor:.4f}")
    if pull == 600.0:
        amplitude = float(peak.amplitude)
