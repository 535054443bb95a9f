"""Fatigue margin of a blade at its resonance: the stress amplitude that the material stands over that of the vibration."""

import stickslip as ss

rig = ss.rigs.single_blade(preload_mass=4.6)
recovery = ss.rigs.single_blade_stress({"20 mm above the root": (12e-3, 20e-3, 0.0), "above the platform": (12e-3, 120e-3, 0.0)})

# A titanium alloy; at the root the rotation adds a mean stress of 350 MPa, which this model does not hold.
titanium = ss.FatigueLimit(fatigue_strength=400e6, ultimate_strength=950e6, yield_strength=870e6, criterion="goodman")
mean = {"20 mm above the root": 350e6, "above the platform": 180e6}

response = ss.forced_response(rig, ss.hertz(500.0, 560.0), force=[20.0, 80.0], harmonics=7)
response = response.with_stress(recovery).with_fatigue(titanium, mean)
print(response)

data = response.dataset
margin = float((data["fatigue_limit"] / data["stress_alternating"]).min())
print(f"The vibration on this rig may grow {margin:.0f} times before the blade fails.")
response.plot("haigh").savefig("fatigue_margin.png")
