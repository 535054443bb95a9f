"""One blade between two semi-cylindrical dampers, dry or oiled: the rig of "Effect of Variation in Contact Friction on the
Performance of the Under-Platform Dampers".

The paper publishes its loads (26, 56 and 206 N on each damper) and measured trends, but neither the blade nor the dampers nor
contact parameters. All dimensions here are this project's choice: a straight steel blade and half cylinders of 8 mm radius, flat
side on the blade, round side on a fixed platform, pulled (by wires, as there) midway between the two contacts, so that both sides
carry the same load; contact stiffness after the published values of the same laboratory.
"""

from __future__ import annotations

from math import pi

from stickslip.model.contact.start import Start
from stickslip.model.contact.stiffness import static_normal_load
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.rigs.platform_blade import PlatformBlade
from stickslip.model.rigs.single_blade import (
    PUBLISHED,
    ContactParameters,
    all_contacts,
    assembled,
    damper_shape,
    placed_dampers,
    rig_problem,
)
from stickslip.model.structure.damping import ModalDamping
from stickslip.model.structure.solid import STEEL
from stickslip.support.checks import not_negative, positive
from stickslip.support.units import STANDARD_GRAVITY

DRY, OILED = 0.5, 0.2
"""Friction coefficients that stand for the dry and the oiled contacts: ours, the paper gives none."""

RADIUS, DEPTH = 8e-3, 40e-3
HALF_CYLINDER_MASS = 0.5 * pi * RADIUS**2 * DEPTH * STEEL.density

GROWTH = {"flat_kt": 0.60, "flat_kn": 0.44, "cylinder_kn": 0.075}
"""Exponents with which stiffness grows with the normal load: of a power law through the flats of 2.6 and 6.6 kg (Table 1 of the
paper on response variability), and Brändlein's for a line contact. The tangential stiffness of the line stays.
"""


def two_semi_cylinders(
    pull: float = 56.0,
    friction: float = DRY,
    *,
    platform_angle: float = 45.0,
    damper_mass: float = HALF_CYLINDER_MASS,
    stiffness_factor: float = 1.0,
    damping: float = 0.003,
    force: float = 1.0,
    gap_factor: float = 0.7,
    length: float = 240e-3,
    modes: int = 40,
    start: Start | None = None,
) -> Problem:
    """The blade, clamped at its root, with a semi-cylinder under each side of its platform; output is the tip, laterally.

    pull: static load F_C on each damper [N], published 26, 56, 206; friction: of all contacts, say DRY 0.5 or OILED 0.2;
    platform_angle [degrees]; damper_mass [kg]; stiffness_factor: on all contact stiffnesses, which follow the normal load
    F_C/(2 cos α) as `GROWTH` says; damping: ratio of every stuck mode; force: amplitude near the root along x [N]; gap_factor:
    as of `single_blade`; length of the blade [m]; modes: fixed-interface modes kept; start: one start rule for all contacts.
    """
    blade = PlatformBlade(length=length, platform_angle=platform_angle)
    offsets = {"centre_offset": RADIUS / 2.0**0.5, "cylinder_offset": RADIUS * 2.0**0.5, "radius": RADIUS}
    shape = damper_shape(blade, **offsets, depth=DEPTH, mass=damper_mass, sides=(2.0 * RADIUS, RADIUS, DEPTH))
    load = static_normal_load(positive("pull", pull), platform_angle)
    parameters, dampers = contact_stiffness(load, friction, stiffness_factor), placed_dampers(blade, shape, pull)
    contacts = all_contacts(dampers, parameters, 2.0 * gap_factor * load / parameters.cylinder_kn, start)
    structure = assembled(blade, dampers, modes).with_damping(ModalDamping(damping, on="stuck"))
    title = f"Blade with two semi-cylinders, {pull:g} N, friction {friction:g}"
    return rig_problem(structure, contacts, dampers, Force("blade/force.x", force), title)


def contact_stiffness(load: float, friction: float, factor: float = 1.0) -> ContactParameters:
    """Totals of one damper at a normal load [N] on each side, scaled from those of 4.6 kg at 45 degrees."""
    mass = 4.6
    published = PUBLISHED[mass]
    share = load / (mass * STANDARD_GRAVITY / 2.0**0.5)
    mu = not_negative("friction", friction)
    positive("stiffness_factor", factor)
    grown = {name: factor * getattr(published, name) * share**exponent for name, exponent in GROWTH.items()}
    return ContactParameters(**grown, cylinder_kt=factor * published.cylinder_kt, flat_mu=mu, cylinder_mu=mu)
