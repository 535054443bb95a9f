"""Results are labelled arrays: save them, open them anywhere, select by name, convert to accelerations, write a table."""

import stickslip as ss

response = ss.forced_response(ss.rigs.three_mass_wedge(), ss.hertz(150, 175), force=[0.5, 1.0])
response.save("wedge.nc")

data = ss.open_results("wedge.nc")
print(data.attrs["title"], data.attrs["stickslip_version"], dict(data.sizes))
print(data["amplitude"].attrs)

converged = data["outcome"] == ss.Outcome.CONVERGED
tip = data["amplitude"].sel(output="2.y").where(converged)
highest = tip.max("point")
print("Largest computed amplitude per force level in µm:", (1e6 * highest).values.round(3))

curves = ss.quantity_table(data, "acceleration", per_force=True)
curves.to_csv("wedge_inertance.csv", index=False)
print(curves.head(3))

peaks = response.peaks()
peak_frequency = float(peaks[peaks["output"] == "2.y"]["frequency"].iloc[-1])
