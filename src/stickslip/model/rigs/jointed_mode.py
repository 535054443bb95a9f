"""One mode of a jointed structure, such as a bolted beam, with a joint by Segalman's four parameters."""

from __future__ import annotations

import numpy as np

from stickslip.model.contact.iwan import Iwan
from stickslip.model.contact.point import Contact, between
from stickslip.model.contact.spectrum import FourParameter
from stickslip.model.loads import Force
from stickslip.model.problem import Problem
from stickslip.model.structure.matrices import Structure
from stickslip.support.checks import fault, positive


def jointed_mode(
    frequency: float = 80.3,
    damping: float = 1.4e-3,
    mass: float = 2.0,
    kt: float = 1e5,
    slip_force: float = 46.0,
    chi: float = 0.66,
    beta: float = 0.0,
    *,
    count: int | None = None,
) -> Problem:
    """m q̈ + 2 ζ m ω0 q̇ + (m ω0² − kt) q + T(q) = F cos ωt, T an Iwan law: ω0 = 2π frequency with the joint stuck.

    frequency [Hz], damping ζ and mass [kg] of the mode where nothing slips, as seen at the output; kt [N/m] of the joint, its
    force in full slip [N], chi and beta of `FourParameter`; count: number of its elements, as for `Iwan`. The force is 1 N.
    Far from full slip the joint dissipates 4 R A^(χ+3)/((χ+2)(χ+3)), so that its damping ratio goes by A^(χ+1).
    """
    whole = positive("mass", mass) * (2.0 * np.pi * positive("frequency", frequency)) ** 2
    if positive("kt", kt) > whole:
        raise fault("kt", f"must not exceed the stiffness of the mode, {whole:.4g} N/m", kt)
    C = 2.0 * positive("damping", damping) * np.sqrt(whole * mass)
    structure = Structure(np.array([[mass]]), np.array([[whole - kt]]), ("1.x",), C=np.array([[C]]))
    law = Iwan(kt, 1.0, normal_load=positive("slip_force", slip_force), spectrum=FourParameter(chi, beta), count=count)
    joint = Contact("joint", law, (between("1.x", "ground"),))
    return Problem(structure, (joint,), (Force("1.x", 1.0),), ("1.x",), "One mode with a joint")
