"""One curve in place of many sweeps: the nonlinear mode of a blade with two dampers, and the peaks of all force levels."""

import stickslip as ss

rig = ss.rigs.single_blade(4.6)
modes = ss.nonlinear_modes(rig, mode=1, amplitude=(2e-8, 2e-5))  # amplitudes of the tip in the shape of the stuck mode, m

curve = modes.dataset.isel(case=0)
for k in range(0, curve.sizes["point"], 8):
    at = curve.isel(point=k)
    tip = 1e6 * float(at["amplitude"][0])
    print(f"{tip:8.3f} µm: {float(at['frequency']):6.1f} Hz, damping ratio {100 * float(at['damping_ratio']):5.2f} %")

peaks = modes.peaks([1, 5, 20, 50, 80, 100])  # N
print(peaks[["force_level", "frequency", "amplitude"]].to_string(index=False))
peak_at_80_newton = 1e6 * peaks["amplitude"][4]  # µm; a sweep gives 5.162
modes.plot().savefig("nonlinear_mode.png")
modes.plot("peaks").savefig("peaks_over_force.png")
