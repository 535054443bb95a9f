"""Stress in the blade at resonance: a peak of the response becomes a question of fatigue."""

import stickslip as ss

rig = ss.rigs.single_blade(preload_mass=4.6)
response = ss.forced_response(rig, [528.7], force=[20.0, 80.0], harmonics=3)

# Places in m: x lateral, y from the clamped root, z depth. At the clamp itself and in sharp corners stress is singular.
places = {
    "20 mm above the root": (12e-3, 20e-3, 0.0),
    "below the platform": (12e-3, 60e-3, 0.0),
    "above it": (12e-3, 120e-3, 0.0),
}
recovery = ss.rigs.single_blade_stress(places)

for case, force in enumerate((20, 80)):
    stress = response.stress(case, 0, recovery)
    table = (stress[["von_mises"]] / 1e6).to_dataframe()
    table["mean, radial"] = stress["stress"].sel(component="yy", harmonic=0, part="re").values / 1e6
    table["vibrating, radial"] = stress["amplitude"].sel(component="yy").values / 1e6
    print(f"{force} N at 528.7 Hz, MPa:\n{table.round(4)}\n")
largest = float(stress["von_mises"].max()) / 1e6

curves = ss.forced_response(rig, ss.hertz(500.0, 560.0), force=[20.0, 80.0], harmonics=3).with_stress(recovery)
curves.plot("stress").savefig("stress_of_a_blade.png")
