"""The two dampers of the blade rig designed: the mass and the platform angle that make the worst-case resonance at 80 N least,
whatever friction wears to.
"""

import stickslip as ss
from stickslip.analyses.performance.worst_case import NoJamming


def rig(*, friction: float, mass: float, angle: float) -> ss.Problem:
    """The pull follows the mass: 4.6 kg of dead weight for the 50 g of the damper as built."""
    flat = {"flat_kt": 25e6, "flat_kn": 65e6, "flat_mu": friction}
    cylinder = {"cylinder_kt": 45e6, "cylinder_kn": 260e6, "cylinder_mu": 2 / 3 * friction}
    small = {"modes": 20, "flat_points": 4, "cylinder_elements": 1}  # leave it out for the whole rig, which takes minutes
    return ss.rigs.single_blade(92.0 * mass, damper_mass=mass, platform_angle=angle, **flat, **cylinder, **small)


design = ss.damper_design(
    rig,
    {"mass": (0.02, 0.12), "angle": (15.0, 60.0)},  # kg, degrees
    force=(80.0, 80.0),
    friction=0.6,  # anything from 0.42 to 0.85
    constraints={"no jamming": NoJamming("angle")},
    known=[{"mass": 0.05, "angle": 45.0}],  # as built
    starts=0,  # virgin contacts; each sampled start state beside them costs as much again, and the search of the worst one more
    levels=1,
    designs=8,
    refinements=12,
    samples=64,
)
as_built, best = float(design.dataset.worst_peak[0]), float(design.dataset.optimum_peak)
print(", ".join(f"{name} {value:.3g}" for name, value in design.optimum.items()))
print(f"worst-case peak {1e6 * best:.2f} µm, as built {1e6 * as_built:.2f} µm")
design.plot().savefig("design_space.png")
