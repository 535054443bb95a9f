"""A damper designed: mass and platform angle that make the worst resonance least, whatever friction wears to."""

import stickslip as ss
from stickslip.analyses.performance.design_constraints import NoJamming, NoLiftOff


def blade_and_damper(*, friction: float, mass: float, angle: float) -> ss.Problem:
    return ss.rigs.blade_and_wedge(pull=3000.0 * mass, damper_mass=mass, platform_angle=angle, mu=friction)


design = ss.design_damper(
    blade_and_damper,
    {"mass": (0.02, 0.1), "angle": (15.0, 60.0)},  # kg, degrees
    force=(20.0, 20.0),
    friction=0.4,  # anything from 0.28 to 0.57
    constraints={"no jamming": NoJamming("angle"), "no lift-off": NoLiftOff()},
    designs=6,
    refinements=8,
    levels=1,
    starts=1,
    samples=64,
)
print({name: round(value, 3) for name, value in design.optimum.items()}, "worst peak", float(design.dataset.optimum_peak), "m")
best_of_the_first = float(design.dataset.worst_peak[:6].where(design.dataset.allowed[:6] == 1).min())
gain = best_of_the_first / float(design.dataset.optimum_peak)
design.plot().savefig("design_space.png")
