"""Contact stiffness of a cylindrical damper from its geometry: three formulas at the static load, and the tangential curve."""

import stickslip as ss

damper = ss.LineContact(length=27.6e-3, radius=5e-3)
load = ss.static_normal_load(pull=147.0, platform_angle=45.0)

result = ss.contact_stiffness(damper, [10.0 * k for k in range(1, 31)], at=load)
result.plot().savefig("contact_stiffness.png")

here = ss.contact_stiffness(damper, [load]).dataset.isel(load=0)
for formula, value in zip(here.formula.values, here.normal_stiffness.values, strict=True):
    print(f"{formula:10} {value:.4g} N/m")

# Partial slip: the traction falls behind its initial stiffness long before the whole line slides at mu N.
mu = 0.6
for share in (0.1, 0.5, 0.9):
    traction = share * mu * load
    displacement = float(damper.tangential_displacement(traction, load, mu))
    print(f"T = {share:.1f} mu N: {displacement * 1e9:6.1f} nm, secant stiffness {traction / displacement:.3g} N/m")

normal_stiffness = float(here.normal_stiffness.sel(formula="Brändlein"))
