"""What every contact law must do, whatever its start state and motion: limits, energy, uniqueness, scaling, brute force."""

from dataclasses import replace

import numpy as np
import pytest
from each import each
from hypothesis import given, settings
from hypothesis import strategies as st
from laws.conftest import STARTS, every_start
from laws.kernel import answer, cycle, forces, motion_of, random_motion
from laws.marching import harmonics_of, steady_forces
from laws.quadrature import normal_harmonics
from laws.samples import LUGRE_SAMPLES, SAMPLES, SMOOTH_SAMPLES, every_law, samples_of

from stickslip.model.contact.cubic import Gap
from stickslip.model.contact.law import LoadDependentFriction
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.microslip import MicroslipArray
from stickslip.model.contact.point import MeanTraction, SliderOffset, TractionRatio
from stickslip.model.contact.protocol import HELD, SLIPPING
from stickslip.solve.balance.energy import cycle_work

H, NT = 4, 96


@each("law", every_law(), ids=lambda law: law.__name__)
def test_every_law_has_samples(law):
    assert samples_of(law), f"{law.__name__} has no sample: add one to tests/laws/samples.py (SAMPLES: tables of sliders)"


def test_the_listing_finds_the_laws():
    assert {Gap, Macroslip, MicroslipArray} <= set(every_law())


@each("seed", range(4))
@every_start
def test_forces_equal_brute_force_marching(sample, start, seed):
    """F = λ̂ + K_c w in every regime of amplitude: friction against the Fourier analysis of a plain predictor-corrector march,
    normal forces against quadrature."""
    rng = np.random.default_rng(seed)
    w = random_motion(sample, H, rng, size=(0.05, 0.4, 1.0, 4.0)[seed])
    expected = harmonics_of(steady_forces(sample, motion_of(sample, w, NT), start), H)
    if sample.law.has_normal:
        expected[-1] = sum(normal_harmonics(each, w[-1]) for each in sample.elements)
    np.testing.assert_allclose(forces(sample, start, w, NT), expected, atol=1e-12 * (1.0 + np.abs(expected).max()))


@settings(deadline=None, max_examples=60)
@given(
    k=st.integers(0, len(SAMPLES) - 1),
    name=st.sampled_from(sorted(STARTS)),
    seed=st.integers(0, 2**31),
    size=st.floats(1e-3, 20.0),
)
def test_samples_of_the_cycle_equal_brute_force_marching(k, name, seed, size):
    sample, start = SAMPLES[k], STARTS[name]
    w = random_motion(sample, 3, np.random.default_rng(seed), size)
    expected = steady_forces(sample, motion_of(sample, w, 32), start)
    found = cycle(sample, start, w, 32).force
    np.testing.assert_allclose(found, expected, atol=1e-12 * (1.0 + np.abs(expected).max()))


@each("seed", range(6))
@every_start
def test_friction_stays_below_its_limit_and_contacts_only_push(any_sample, start, seed):
    sample = any_sample
    w = random_motion(sample, H, np.random.default_rng(100 + seed), size=10.0 ** (-1.5 + 0.5 * seed))
    found, motion = cycle(sample, start, w, NT), motion_of(sample, w, NT)
    limit = sum(e.limit(motion.normal) for e in sample.elements)
    assert np.all(np.abs(found.force[: sample.tangential]) <= limit + 1e-12 * (1.0 + limit.max())) or sample in LUGRE_SAMPLES
    if sample.law.has_normal:
        assert np.all(found.force[-1] >= 0.0)
        open_everywhere = sum(e.normal(motion.normal) for e in sample.elements) == 0.0
        np.testing.assert_array_equal(found.force[:, open_everywhere], 0.0)


def work_errors(sample, start, samples: int) -> tuple[float, float]:
    """Root mean square over motions of (loop work − slip work), and of the loop work; rows t1, t2 together."""
    errors, works = [], []
    for seed in range(12):
        w = random_motion(sample, 3, np.random.default_rng(200 + seed))
        work = cycle_work(forces(sample, start, w, samples), w)[: sample.tangential].sum()
        errors.append(work - cycle(sample, start, w, samples).slip_work.sum())
        works.append(work)
    return float(np.sqrt(np.mean(np.square(errors)))), float(np.sqrt(np.mean(np.square(works))))


@every_start
def test_energy_in_is_energy_out_with_second_order(rubbing, start):
    """The work of the contact forces over a period is the work of the sliders Σ μN|Δs|, up to an error of second order in Nt."""
    (coarse, _), (fine, work) = work_errors(rubbing, start, 256), work_errors(rubbing, start, 4096)
    assert work > 0.1
    assert fine < 2e-5 * work
    assert np.log2(coarse / fine) / 4.0 == pytest.approx(2.0, abs=0.35)


@pytest.mark.parametrize("smooth", SMOOTH_SAMPLES, ids=lambda sample: sample.name)
def test_energy_in_is_energy_out_of_laws_with_kernels_of_their_own(smooth):
    """The same of friction without sliders: of second order, or better where nothing has a kink."""
    (coarse, _), (fine, work) = (work_errors(smooth, SliderOffset(), samples) for samples in (256, 4096))
    assert work > 0.1
    assert fine < 2e-5 * work
    assert np.log2(coarse / fine) / 4.0 > 1.65


@every_start
def test_normal_forces_do_no_work(touching, start):
    """∮ N dz = 0, whatever the samples."""
    for seed in range(12):
        w = random_motion(touching, 3, np.random.default_rng(300 + seed))
        assert abs(cycle_work(forces(touching, start, w, 16), w)[-1]) < 1e-12


@each("seed", range(5))
def test_the_start_matters_only_where_an_element_sticks(rubbing, seed):
    """Large motion: every friction element slips or opens, and all starts give one force. Small: only harmonic 0 differs."""
    w = random_motion(rubbing, H, np.random.default_rng(400 + seed), size=30.0)
    if rubbing.law.has_normal:
        w[-1, 0] = 0.0
    found = [forces(rubbing, start, w, NT) for start in STARTS.values()]
    for other in found[1:]:
        np.testing.assert_allclose(other, found[0], atol=1e-12 * np.abs(found[0]).max())
    w[:, 1:] *= 1e-6
    w[-1, 0] = 2.0
    small = [answer(rubbing, start, w, NT) for start in STARTS.values()]
    assert all(np.all(a.unknown < SLIPPING) for a in small)
    assert all(np.all(a.target[:, 1:] == 0.0) for a in small)
    assert np.ptp([a.target[0, 0] for a in small]) > 0.05


@each("holding", [s for s in SAMPLES if all(e.mu or not e.kt for e in s.elements)], ids=lambda s: s.name)
def test_a_held_row_is_constant_and_known(holding):
    """Closed and stuck: λ̂ is −Σ kt s in each tangential direction and the sum of the springs' constants in the normal one."""
    offset = 0.01
    w = random_motion(holding, H, np.random.default_rng(7), size=1e-3)
    w[-1, 0] = 2.0 if holding.law.has_normal else 0.0
    found = answer(holding, SliderOffset(offset), w, NT)
    expected = [-offset * sum(e.kt for e in holding.elements)] * holding.tangential
    expected += [sum(e.preload - e.kn * e.gap for e in holding.elements)] if holding.law.has_normal else []
    assert np.all(found.unknown == HELD)
    np.testing.assert_allclose(found.target[:, 0], expected, atol=1e-14)
    assert not found.target[:, 1:].any()
    assert not found.own.any()
    assert not found.normal.any()


def turned(w: np.ndarray, shift: int, samples: int) -> np.ndarray:
    """Real storage of the signal delayed by whole samples: x(t − shift)."""
    order = np.arange(1, (w.shape[1] + 1) // 2)
    angle = 2.0 * np.pi * ((order * shift) % samples) / samples
    a, b = w[:, 1::2], w[:, 2::2]
    result = w.copy()
    result[:, 1::2], result[:, 2::2] = a * np.cos(angle) - b * np.sin(angle), b * np.cos(angle) + a * np.sin(angle)
    return result


@each("start", [SliderOffset(), SliderOffset(0.2), MeanTraction(0.1)], ids=str)
@each("shift", [1, 17, 50])
@each("size", [0.1, 1.0, 5.0])
def test_forces_follow_a_shift_of_time(any_sample, start, shift, size):
    """A delay by whole samples delays the forces; the harmonic 0 of a contact clipped at the last sample excepted."""
    sample = any_sample
    w = random_motion(sample, H, np.random.default_rng(shift), size)
    plain, delayed = answer(sample, start, w, NT), answer(sample, start, turned(w, shift, NT), NT)
    moving = (plain.unknown == SLIPPING) | (plain.unknown == HELD)
    compared = moving & (plain.unknown == delayed.unknown)
    assert compared.any() or size < 5.0
    scale = 1e-12 * (1.0 + np.abs(plain.target).max())
    np.testing.assert_allclose(delayed.target[compared, 1:], turned(plain.target, shift, NT)[compared, 1:], atol=scale)


def test_forces_change_sign_with_the_tangential_motion(any_rubbing):
    """Friction has no preferred direction: motion, start and force along t1 turn round together."""
    rubbing = any_rubbing
    for value in (0.0, 0.3):
        w = random_motion(rubbing, H, np.random.default_rng(11))
        mirrored = w.copy()
        mirrored[: rubbing.tangential] *= -1.0
        for rule in (SliderOffset, TractionRatio, MeanTraction):
            plain, turned_round = forces(rubbing, rule(value), w, NT), forces(rubbing, rule(-value), mirrored, NT)
            np.testing.assert_allclose(turned_round[: rubbing.tangential], -plain[: rubbing.tangential], atol=1e-13)


def scaled(law, stiffness: float, force: float):
    """The law with its stiffness and its forces multiplied; lengths change by force/stiffness."""
    lengths, paces = {"gap", "gaps", "v0", "stribeck"}, {"damping", "viscosity"}
    changes = {}
    for name, value in vars(law).items():
        factor = {"kt": stiffness, "kn": stiffness, "preload": force, "normal_load": force}.get(name)
        factor = force / stiffness if name in lengths else stiffness / force if name in paces else factor
        if factor is not None and value is not None:
            changes[name] = tuple(factor * np.asarray(value)) if np.ndim(value) else factor * value
        if isinstance(value, LoadDependentFriction):
            changes[name] = value.share(force)
    return replace(law, **changes)


@each(("stiffness", "force"), [(1.0, 3.0), (4.0, 1.0), (0.5, 7.0)])
def test_forces_scale(any_sample, stiffness, force):
    """Forces times s and stiffness times k: motion times s/k gives forces times s."""
    sample = any_sample
    w = random_motion(sample, H, np.random.default_rng(5))
    length = force / stiffness
    larger = replace(sample, law=scaled(sample.law, stiffness, force))
    elements = tuple(replace(e, kt=stiffness * e.kt, kn=stiffness * e.kn) for e in sample.elements)
    larger = replace(larger, elements=elements)
    plain = forces(sample, SliderOffset(0.3), w, NT)
    np.testing.assert_allclose(forces(larger, SliderOffset(0.3 * length), length * w, NT), force * plain, rtol=1e-12, atol=1e-12)
