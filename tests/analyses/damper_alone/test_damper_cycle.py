"""A damper between two platforms against its exact values: plateaux, stuck slopes, homogeneity, energies, the cliff.

Closed forms for a roof of slopes α_L, α_R and friction angles φ: sliding out-of-phase H = F_C/(cot(α_R ± φ_R) + cot(α_L ± φ_L)),
in-phase with (α_R + φ_R, α_L − φ_L) and (α_R − φ_R, α_L + φ_L). Geometries G45 and G37 are `laboratory_damper` at 45 and 37
degrees: feet 14 mm apart on a line 6 mm from the mass centre, the cylinder 12 mm from it. Energies at 4000 steps come from an
independent prototype.
"""

from dataclasses import replace

import numpy as np
import pytest
from analyses.damper_alone.harmonic_cycle import harmonic_cycle

from stickslip.analyses.damper_alone.cycle import damper_cycle, damper_evolution, forces_on_platforms, steady_cycles
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.microslip import Iwan, Parabolic
from stickslip.model.dampers import SHAPES, ThreePoint
from stickslip.model.dampers.between_platforms import BetweenPlatforms, elliptic, in_phase, measured, out_of_phase
from stickslip.model.dampers.laboratory import laboratory_damper
from stickslip.solve.platforms.cycle import CycleModel, CycleOutcome, steady_cycle
from stickslip.solve.time.period import GeneralisedAlpha, Newmark
from stickslip.support.checks import InputError

MOTIONS = {"out-of-phase": out_of_phase, "in-phase": in_phase}
KT, KN = 56e6, 84e6


def stuck_inverse(angle: float) -> np.ndarray:
    """C = t_L t_L'/(2 kt) + n_L n_L'/(2 kn) + 2 a a'/(kn f²) + t_R t_R'/kt + n_R n_R'/kn of the three-contact damper."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    left, right = np.array([[c, s], [-s, c]]), np.array([[c, -s], [s, c]])
    dx, dy = 12e-3 * right[1] - 6e-3 * left[1]
    a = np.array([-dy, dx])
    found = 2.0 * np.outer(a, a) / (KN * 14e-3**2)
    return found + sum(
        np.outer(side[i], side[i]) / (count * k) for side, count in ((left, 2), (right, 1)) for i, k in enumerate((KT, KN))
    )


@pytest.mark.parametrize(("angle", "published"), [(45.0, (43.542728636, 25.407796102, 8.343328336))])
def test_stuck_slopes(angle, published):
    for slope in (angle, 37.0):
        model = CycleModel.of(laboratory_damper(slope))
        np.testing.assert_allclose(model.stuck_stiffness(), np.linalg.inv(stuck_inverse(slope)), rtol=1e-12)
    K = CycleModel.of(laboratory_damper(angle)).stuck_stiffness() / 1e6
    assert (K[0, 0], K[1, 1], abs(K[0, 1])) == pytest.approx(published, rel=1e-9)


@pytest.mark.parametrize("angle", [45.0, 37.0])
def test_a_small_motion_follows_the_stuck_slopes(angle):
    rig = laboratory_damper(angle, 80.0)
    cycle = damper_cycle(rig, elliptic(0.02e-6, 0.03e-6, 70.0), steps=64, tolerance=1e-12)
    motion, force = cycle.dataset.platform_motion.values, cycle.dataset.force_on_right.values
    slopes, *_ = np.linalg.lstsq(motion, force - force.mean(axis=0), rcond=None)
    np.testing.assert_allclose(slopes, np.linalg.inv(stuck_inverse(angle)), rtol=1e-8)
    assert abs(cycle.energy) < 1e-9 * 80.0 * 0.03e-6


@pytest.mark.parametrize("angle", [45.0, 37.0])
@pytest.mark.parametrize("motion", MOTIONS)
def test_sliding_plateaux(angle, motion):
    cycle = damper_cycle(laboratory_damper(angle, 80.0, (0.15, 0.15, 0.25)), MOTIONS[motion](30e-6), steps=400)
    left, right, a = np.degrees(np.arctan(0.15)), np.degrees(np.arctan(0.25)), angle

    def plateau(sign_right: float, sign_left: float) -> float:
        cot = [1.0 / np.tan(np.radians(a + s * phi)) for s, phi in ((sign_right, right), (sign_left, left))]
        return 80.0 / sum(cot)

    pair = (plateau(-1, -1), plateau(1, 1)) if motion == "out-of-phase" else (plateau(-1, 1), plateau(1, -1))
    H = cycle.dataset.force_on_right.values[:, 0]
    assert sorted([H[100], H[300]]) == pytest.approx(sorted(pair), rel=1e-9)


@pytest.mark.parametrize("motion", MOTIONS)
def test_homogeneity(motion):
    rig, make = laboratory_damper(45.0, 50.0, (0.40, 0.22, 0.32)), MOTIONS[motion]
    base = damper_cycle(rig, make(30e-6), steps=200).dataset
    larger = damper_cycle(rig.with_pull(150.0), make(90e-6), steps=200).dataset
    stiffer = damper_cycle(
        laboratory_damper(45.0, 50.0, (0.40, 0.22, 0.32), kt=4 * KT, kn=4 * KN), make(7.5e-6), steps=200
    ).dataset
    np.testing.assert_allclose(larger.normal_force, 3.0 * base.normal_force, atol=1e-6)
    np.testing.assert_allclose(larger.loop_energy, 9.0 * base.loop_energy, rtol=1e-7)
    np.testing.assert_allclose(stiffer.friction_force, base.friction_force, atol=1e-6)
    np.testing.assert_allclose(stiffer.loop_energy, base.loop_energy / 4.0, rtol=1e-7)


@pytest.mark.parametrize(
    ("angle", "friction", "motion", "energy"),
    [
        (45.0, (0.14, 0.13, 0.13), "out-of-phase", 804.3),
        (45.0, (0.14, 0.13, 0.13), "in-phase", 775.1),
        (37.0, (0.14, 0.13, 0.13), "out-of-phase", 626.4),
        (37.0, (0.14, 0.13, 0.13), "in-phase", 807.1),
        (37.0, (0.40, 0.22, 0.32), "out-of-phase", 1516.8),
        (37.0, (0.40, 0.22, 0.32), "in-phase", 1032.5),
    ],
)
def test_energies_of_an_independent_prototype(angle, friction, motion, energy):
    cycle = damper_cycle(laboratory_damper(angle, 50.0, friction), MOTIONS[motion](30e-6), steps=1000)
    assert cycle.outcome == CycleOutcome.STEADY
    assert cycle.energy * 1e6 == pytest.approx(energy, rel=1e-3)
    assert cycle.dataset.energy_error < 1e-3


@pytest.mark.parametrize("shape", SHAPES.values())
@pytest.mark.parametrize("motion", MOTIONS)
def test_every_shape_has_a_balanced_cycle(shape, motion):
    """Forces on platforms and pull sum to nothing, |T| ≤ μN, loop energy = friction work, quasi-static at every sample."""
    rig = BetweenPlatforms.macroslip(shape(left_angle=40.0, right_angle=44.0).damper(pull=60.0), KT, KN, 0.3)
    data = damper_cycle(rig, MOTIONS[motion](20e-6), steps=500).dataset
    assert data.attrs["outcome"] == "steady", data.attrs["message"]
    total = data.force_on_left.values + data.force_on_right.values
    np.testing.assert_allclose(total, np.tile([0.0, 60.0], (500, 1)), atol=1e-6)
    assert np.all(np.abs(data.friction_force) <= 0.3 * data.normal_force + 1e-7)
    assert data.energy_error < 2e-3
    assert data.loop_energy > 0.0


def test_the_crossed_damper_rolls_less_and_takes_more_in_phase():
    """The conclusions of the source: less rotation, no excursion of the load on the flat, a larger loop in phase."""
    plain, crossed = (
        damper_cycle(laboratory_damper(45.0, 50.0, (0.40, 0.22, 0.32), shape), in_phase(30e-6), steps=500).dataset
        for shape in ("three_point", "crossed_curved_flat")
    )
    assert plain.share.sel(contact="L2", kind="open") > 0.3
    assert crossed.share.sel(kind="open").sum() == 0.0
    assert crossed.rotation < 1e-9 * plain.rotation
    excursion = {"plain": plain, "crossed": crossed}
    for name, data in excursion.items():
        lower, upper = data.normal_force.values[:, 0], data.normal_force.values[:, 1]
        excursion[name] = np.ptp(7.0 * (upper - lower) / (upper + lower))
    assert excursion["plain"] > 10.0
    assert excursion["crossed"] < 1e-9
    assert crossed.loop_energy > plain.loop_energy


def test_chains_of_cycles_and_distinct_steady_cycles():
    rig = laboratory_damper(45.0, 50.0, (0.40, 0.22, 0.32))
    small = steady_cycles(rig, out_of_phase(0.3e-6), starts=6, steps=100)
    assert len(small.cycles) > 1
    assert sum(small.counts) + small.failed == 6
    evolved = damper_evolution(rig, out_of_phase(20e-6), [0.3, 0.9, 1.3], steps=200).cycles
    assert evolved[-1].energy < evolved[0].energy
    again = damper_cycle(rig.with_friction(0.15), out_of_phase(20e-6), start=evolved[-1].state, steps=200)
    assert again.energy == pytest.approx(damper_cycle(rig.with_friction(0.15), out_of_phase(20e-6), steps=200).energy, rel=1e-6)


def test_the_energies_of_cycles_that_do_not_close():
    """Friction work is never negative, and platform work is friction work and what is stored: exactly while contacts stay closed,
    with an error of second order in the step where one opens or closes."""
    rig = laboratory_damper(45.0, 50.0, (0.40, 0.22, 0.32))
    for steps in (250, 500):
        cycles = damper_evolution(rig, out_of_phase(20e-6), [0.3, 0.5, 0.7, 0.9, 1.1, 1.2], steps=steps).dataset
        assert np.all(cycles.friction_work >= 0.0)
        left = np.abs(cycles.loop_energy - cycles.friction_work.sum("contact") - cycles.stored_energy) / cycles.loop_energy
        np.testing.assert_allclose(left[:4], 0.0, atol=1e-9)
        assert np.all(np.abs(cycles.stored_energy[2:]) > 0.01 * cycles.loop_energy[2:])
        assert np.all(left[4:] < 25.0 / steps**2)


def test_a_cycle_starts_from_the_state_that_the_one_before_left():
    rig, motion = laboratory_damper(45.0, 50.0, (0.40, 0.22, 0.32)), out_of_phase(20e-6)
    first = damper_cycle(rig, motion, steps=200, cycles=1)
    then = damper_cycle(rig.with_friction(1.1), motion, start=first.state, steps=200, cycles=1)
    model = CycleModel.of(rig)
    for name in ("motion", "w", "force", "intercept"):
        start, end = getattr(then.march.record, name)[0], getattr(first.march.path(model), name)[-1]
        np.testing.assert_allclose(start, end, rtol=1e-9, atol=1e-12)
    steady = damper_cycle(rig, motion, steps=200)
    path = steady.march.path(model)
    for part in (path.motion, path.w, path.force, path.intercept, path.limit):
        np.testing.assert_allclose(part[0], part[-1], atol=1e-7 * np.abs(part).max())


def test_parameters_as_arrays_give_the_same_forces():
    rig, platform = laboratory_damper(37.0, 50.0, 0.2), out_of_phase(20e-6).samples(200)
    model = CycleModel.of(laboratory_damper(37.0, 50.0)).with_parameters(np.full(3, KT), np.full(3, KN), np.full(3, 0.2))
    forces = forces_on_platforms(model, steady_cycle(model, platform))[1]
    np.testing.assert_allclose(forces, damper_cycle(rig, out_of_phase(20e-6), steps=200).dataset.force_on_right, atol=1e-9)


def test_inertia_is_negligible_at_5_hz_and_the_trapezoidal_rule_rings():
    rig, motion = laboratory_damper(45.0, 50.0, (0.40, 0.22, 0.32)), in_phase(30e-6)
    slow = damper_cycle(rig, motion, steps=4000).dataset.force_on_right.values
    settings = {"steps": 4000, "frequency": 5.0, "cycles": 3, "tolerance": 1e-6}
    damped, rings = (
        damper_cycle(rig, motion, method=method, **settings).dataset.force_on_right.values
        for method in (GeneralisedAlpha(), Newmark())
    )
    assert np.sqrt(np.mean((damped - slow) ** 2)) < 0.015
    assert np.max(np.abs(rings - slow)) > 2.0


def test_beyond_the_friction_cone_the_damper_is_jammed():
    cycle = damper_cycle(laboratory_damper(50.0, 50.0, 1.2), out_of_phase(2e-6), steps=200)
    assert cycle.outcome == CycleOutcome.JAMMED
    assert "platform and friction angles add up to 200.4 degrees" in cycle.sentence


def test_a_damper_that_small_motion_does_not_move_is_stuck_not_jammed():
    cycle = damper_cycle(laboratory_damper(45.0, 50.0, 0.5), out_of_phase(0.02e-6), steps=100)
    assert cycle.outcome == CycleOutcome.STEADY
    assert np.all(cycle.dataset.share.sel(kind="stick") == 1.0)


def test_a_measured_cycle_is_smoothed_to_its_harmonics():
    angle = 2.0 * np.pi * np.arange(400) / 400
    noise = np.random.default_rng(0).normal(0.0, 1e-9, 400)
    motion = measured(20e-6 * np.sin(angle) + noise, 5e-6 * np.cos(angle), harmonics=3)
    np.testing.assert_allclose(motion.samples(400), elliptic(20e-6, 5e-6).samples(400), atol=5e-10)


def test_an_elastic_right_platform_gives_way():
    """Energy is still friction work; the stuck slopes are those of damper and rig in series."""
    rig = laboratory_damper(45.0, 50.0, (0.14, 0.13, 0.13), elastic=True)
    series = np.linalg.inv(stuck_inverse(45.0) + np.eye(2) / 30e6)
    np.testing.assert_allclose(CycleModel.of(rig).stuck_stiffness(), series, rtol=1e-12)
    data = damper_cycle(rig, out_of_phase(30e-6), steps=500).dataset
    assert data.energy_error < 1e-3
    np.testing.assert_allclose(data.right_motion * 30e6, data.force_on_right, atol=1e-6)


def test_wrong_input_is_refused():
    rig = laboratory_damper()
    with pytest.raises(InputError, match="frequency must go with a method"):
        damper_cycle(rig, out_of_phase(1e-6), frequency=5.0)
    with pytest.raises(InputError, match="laws must be 3, one for each of L1, L2, R"):
        replace(rig, laws=rig.laws[:2])
    with pytest.raises(InputError, match="pull must press"):
        BetweenPlatforms.macroslip(ThreePoint().damper(), KT, KN, 0.3)
    with pytest.raises(InputError, match="shape must be one of three_point"):
        laboratory_damper(shape="round")
    with pytest.raises(InputError, match="A platform motion must move"):
        elliptic(0.0, 0.0)
    with pytest.raises(InputError, match="steps must be at least 8"):
        damper_cycle(rig, out_of_phase(1e-6), steps=4)


def test_the_cliff_from_sliding_to_rolling():
    """L2 lifts off on opening once the forces of R and L1, each at the edge of its cone, meet on the line of the pull."""
    for angle, limit in ((45.0, 0.450893), (37.0, 0.406928)):
        below, above = (
            damper_cycle(laboratory_damper(angle, 50.0, (0.18, 0.199, limit + shift)), out_of_phase(30e-6), steps=300)
            for shift in (-5e-6, 5e-6)
        )
        assert below.dataset.share.sel(contact="L2", kind="open") == 0.0
        assert above.dataset.share.sel(contact="L2", kind="open") > 0.5
        assert above.energy < 0.5 * below.energy
        if angle == 45.0:
            assert (below.energy * 1e6, above.energy * 1e6) == pytest.approx((2064.0, 453.0), rel=1e-3)


def test_no_cycle_fails():
    """Slopes 30 to 60 degrees, friction 0.05 to 0.8 with tan α < 0.9/μ, both motions, 1 to 100 µm (200 of them in verify)."""
    rng = np.random.default_rng(1)
    for k in range(24):
        rig, motion = random_case(rng, k)
        cycle = damper_cycle(rig, motion, steps=250)
        assert cycle.outcome == CycleOutcome.STEADY, (rig.title, cycle.sentence)


def random_case(rng: np.random.Generator, k: int):
    """A three-point damper and a motion drawn at random."""
    while True:
        left, right = rng.uniform(30.0, 60.0, 2)
        mu = rng.uniform(0.05, 0.8, 3)
        if np.tan(np.radians(max(left, right))) < 0.9 / mu.max():
            break
    damper = ThreePoint(left_angle=left, right_angle=right).damper(pull=10.0 ** rng.uniform(1.0, 2.3))
    make = (out_of_phase, in_phase)[k % 2]
    return BetweenPlatforms.macroslip(damper, KT, KN, mu, None, f"{left} {right} {mu}"), make(10.0 ** rng.uniform(-6.0, -4.0))


@pytest.mark.parametrize(
    ("motion", "amplitude", "forces", "energies"),
    [
        ("out-of-phase", 0.6e-6, (3e-3, 7e-4), (4e-4, 4e-4)),
        pytest.param("out-of-phase", 30e-6, (6e-3, 3e-3), (6e-4, 2e-4), marks=pytest.mark.nightly),
        ("in-phase", 2e-6, (3e-3, 7e-4), (4e-4, 4e-4)),
        pytest.param("in-phase", 30e-6, (3e-3, 3e-3), (7e-4, 2e-4), marks=pytest.mark.nightly),
    ],
)
def test_harmonic_balance_gives_the_same_cycle(motion, amplitude, forces, energies):
    """At 5 Hz, where inertia is negligible, against quasi-static steps: first harmonics and energy with 15 and 31 harmonics."""
    rig, moved = laboratory_damper(45.0, 50.0, (0.14, 0.13, 0.13)), MOTIONS[motion](amplitude)
    steps = damper_cycle(rig, moved, steps=2000)
    first = steps.dataset.force_harmonics.sel(platform="right").values[:, 1] * [1.0, -1.0]
    for harmonics, force, energy in zip((15, 31), forces, energies, strict=True):
        balance = harmonic_cycle(rig, moved, 5.0, harmonics)
        assert balance.energy == pytest.approx(steps.energy, rel=energy)
        np.testing.assert_allclose(balance.force_on_right[:, 1:3], first, atol=force * np.abs(first).max())


@pytest.mark.parametrize("motion", MOTIONS)
def test_contacts_that_slip_piece_by_piece(motion):
    """Iwan's law in the damper: with uniform pressure it is macroslip; else its loop energy is still friction work."""
    shape = ThreePoint().damper(pull=50.0)
    plain, uniform, line = (
        damper_cycle(BetweenPlatforms(shape, (law,) * 3), MOTIONS[motion](2e-6), steps=500)
        for law in (Macroslip(KT, 0.2, KN), Iwan(KT, 0.2, KN, spectrum=Parabolic(1.0)), Iwan(KT, 0.2, KN, count=8))
    )
    assert uniform.energy == pytest.approx(plain.energy, rel=1e-9)
    assert line.outcome == CycleOutcome.STEADY
    assert line.dataset.energy_error < 2e-3
    assert line.energy == pytest.approx(plain.energy, rel=0.1)
    assert line.energy != pytest.approx(plain.energy, rel=1e-4)


def test_a_rotation_beyond_small_motions_is_reported():
    rig = laboratory_damper(45.0, 50.0, (0.40, 0.22, 0.32))
    assert "rad" not in damper_cycle(rig, in_phase(30e-6), steps=100).sentence
    assert "rad, but the theory holds up to 0.1" in damper_cycle(rig, in_phase(1.0), steps=100).sentence
