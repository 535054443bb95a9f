"""The chart that dampers are designed with: resonance amplitude and frequency against F_C/F_E, for one mass."""

import stickslip as ss

rig = ss.rigs.single_mass(damping=0.01, kt=0.5)  # F_C is the normal load of the contact, 1 N at μ = 1
curve = ss.performance_curve(rig, ss.logspace(0.3, 300, 40), friction=[0.2, 0.5], harmonics=1, samples=1024)

for case, mu in enumerate(curve.dataset.friction.values):
    best = curve.optimum(case)
    print(f"μ = {mu}: lowest resonance at F_C/F_E = {best['optimum_ratio']:.3f}, {best['optimum_amplitude_per_force']:.4f} m/N,")
    print(f"  within 10 % of it from {best['plateau_low']:.2f} to {best['plateau_high']:.2f}")

lowest = curve.optimum(1)["optimum_amplitude_per_force"]  # both the same: one mass depends on μ F_C/F_E alone
curve.plot().savefig("performance_curve.png")
curve.plot(collapsed=True).savefig("performance_curve_collapsed.png")
