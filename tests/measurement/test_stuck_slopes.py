"""Contact stiffness from stuck slopes: the explicit inversion, its condition, where it is refused, and where the stretch is."""

import numpy as np
import pytest

from stickslip.analyses.damper_alone.cycle import CycleModel
from stickslip.laboratory.identification.damper.model import compliance_parts, stiffness_from_slopes, stuck_stretch
from stickslip.model.dampers.between_platforms import BetweenPlatforms
from stickslip.model.dampers.laboratory import ThreePoint
from stickslip.model.rigs.laboratory_damper import laboratory_damper
from stickslip.support.checks import InputError


def stuck_slopes(rig, kt, kn):
    """kH and kV [N/m]: H per horizontal and V per vertical relative motion of the platforms while every contact sticks."""
    A, B = compliance_parts(rig)
    return np.diag(np.linalg.inv(A / kt + B / kn))


def test_stuck_slopes_of_two_geometries():
    """Source: independent derivation of this project, N/µm."""
    for angle, kH, kV in ((45.0, 43.542728636, 25.407796102), (37.0, 40.571150152, 30.235361324)):
        found = stuck_slopes(laboratory_damper(angle), 56e6, 84e6)
        np.testing.assert_allclose(found, (kH * 1e6, kV * 1e6), rtol=1e-10)


def test_the_inversion_recovers_500_random_geometries():
    """From slopes of the package's own stuck damper; where it is refused, the geometry is near a singular one."""
    generator, refused = np.random.default_rng(7), []
    for _ in range(500):
        angle, other = generator.uniform(15.0, 70.0, 2)
        lengths = generator.uniform((4e-3, 6e-3, 8e-3, -3e-3), (10e-3, 16e-3, 20e-3, 3e-3))
        left, right, feet, shift = map(float, lengths)
        shape = ThreePoint(left, right, feet, shift, left_angle=float(angle), right_angle=float(other))
        kt, kn = 10.0 ** generator.uniform(6.7, 8.3, 2)
        rig = BetweenPlatforms.macroslip(shape.damper(pull=80.0), kt, kn, 0.3)
        K = CycleModel.of(rig).stuck_stiffness()
        try:
            found = stiffness_from_slopes(rig, K[0, 0], K[1, 1])
        except InputError as error:
            refused.append(str(error))
            continue
        assert found.kt == pytest.approx(kt, rel=1e-10)
        assert found.kn == pytest.approx(kn, rel=1e-10)
        assert found.condition <= 100.0
    assert len(refused) < 50
    assert all("do not separate kt from kn" in sentence for sentence in refused)


def test_the_condition_number_grows_towards_the_singular_angle():
    """Source: 2.7 at 37 degrees, 4.5 at 45, 20 at 60 and singular at 57.05: independent derivation of this project."""
    rigs = [laboratory_damper(angle) for angle in (37.0, 45.0)]
    condition = [stiffness_from_slopes(rig, *stuck_slopes(rig, 56e6, 84e6)).condition for rig in rigs]
    assert condition == pytest.approx([2.7, 4.5], rel=0.1)
    near = laboratory_damper(57.05)
    with pytest.raises(InputError, match="singular"):
        stiffness_from_slopes(near, *stuck_slopes(near, 56e6, 84e6))


def test_slopes_that_no_stiffness_gives_are_refused():
    with pytest.raises(InputError, match="must lie between"):
        stiffness_from_slopes(laboratory_damper(37.0), 80e6, 10e6)


def test_the_stuck_stretch_of_a_loop():
    u = 5e-6 * np.sin(2.0 * np.pi * np.arange(800) / 800)
    force, tension = np.empty(800), 0.0
    for _ in range(2):
        for n in range(800):
            tension = np.clip(tension + 20e6 * (u[n] - u[n - 1]), -40.0, 40.0)
            force[n] = tension
    stretch = stuck_stretch(u, force)
    assert stretch.slope == pytest.approx(20e6, rel=5e-3)
    assert stretch.share == pytest.approx(0.4, abs=0.03)


def test_a_loop_without_a_stuck_stretch_is_refused():
    angle = 2.0 * np.pi * np.arange(400) / 400
    with pytest.raises(InputError, match="straight rising stretch"):
        stuck_stretch(30e-6 * np.sin(angle), 20.0 * np.cos(angle))
