"""Two dampers, dry and oiled: less friction shifts the performance curve to more pull, and lowers it on the stick side."""

import stickslip as ss
from stickslip.model.rigs.single_blade import DRY, OILED

rig = ss.rigs.two_semi_cylinders(pull=56.0)
curve = ss.performance_curve(rig, ss.logspace(1, 40, 12), friction=[DRY, OILED], harmonics=3, quantity="inertance")
dry, oiled = curve.dataset.normalised_amplitude.values[:, 8]
print(f"at F_C/F_E = {float(curve.dataset.force_ratio[8]):.1f} the inertance peak is {dry:.4f} dry and {oiled:.4f} oiled")
amplitude, frequency = curve.collapse()
print(f"over μ F_C/F_E the two curves differ by up to {100 * amplitude:.0f} % in amplitude, {100 * frequency:.1f} % in frequency")
curve.plot().savefig("dry_and_oiled.png")

for mu in (DRY, OILED):
    rig = ss.rigs.two_semi_cylinders(26.0, mu)
    response = ss.forced_response(rig, ss.hertz(400, 520), force=5, harmonics=3, quantity="inertance")
    response.plot().savefig(f"inertance_{mu:g}.png")
