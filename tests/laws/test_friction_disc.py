"""The friction disc against brute-force marching, differences, energy, and the laws it must agree with."""

import numpy as np
import pytest
from each import each
from laws.kernel import answer, cycle, forces, motion_of, random_motion
from laws.marching import harmonics_of
from laws.samples import DISC_SAMPLES
from scipy.integrate import quad
from scipy.optimize import brentq

from stickslip.model.contact.friction_disc import FrictionDisc, disc_step
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import Contact, MeanTraction, SliderOffset, TractionRatio, between
from stickslip.model.contact.protocol import HELD, SLIPPING, STATIC
from stickslip.solve.balance.energy import cycle_work
from stickslip.support.checks import InputError

H, NT = 3, 64
STARTS = {
    "virgin": SliderOffset(),
    "offset": (SliderOffset(0.4), SliderOffset(-0.9)),
    "far offset": (SliderOffset(5.0), SliderOffset(3.0)),
    "ratio": (TractionRatio(0.3), TractionRatio(-0.6)),
}


@pytest.fixture(params=DISC_SAMPLES, ids=lambda sample: sample.name)
def sample(request):
    return request.param


every_start = each("start", STARTS.values(), ids=STARTS)


def stepped(traction, change, before, after):
    """One step in plain Python, with complex numbers: stuck to the edge, then tan(ψ/2) falls by exp(−∫ |change|/L)."""
    if abs(traction + change) <= after:
        return traction + change
    if after <= 0.0:
        return 0.0 * traction

    def outside(share):
        return abs(traction + share * change) - (before + share * (after - before))

    def limit(share):
        return before + share * (after - before)

    grid = np.linspace(0.0, 1.0, 201)
    inside = [share for share in grid if outside(share) <= 1e-13]
    onset = 0.0
    if inside:
        onset = brentq(outside, inside[-1], min(inside[-1] + 0.005, 1.0), xtol=1e-15) if outside(inside[-1]) < 0.0 else inside[-1]
    if limit(onset) <= 0.0:
        return after * change / abs(change)
    edge = traction + onset * change
    exponent = quad(lambda share: abs(change) / limit(share), onset, 1.0, epsabs=1e-14, epsrel=1e-13)[0]
    motion = np.angle(change) if change else np.angle(edge)
    psi = np.angle(np.exp(1j * (motion - np.angle(edge))))
    return after * np.exp(1j * (motion - 2.0 * np.arctan(np.tan(0.5 * psi) * np.exp(-exponent))))


def marched(sample, start, w, samples, periods=400):
    """Tractions (2, Nt) step by step in plain Python, period after period until they repeat."""
    element, motion = sample.elements[0], motion_of(sample, w, samples)
    limit, u = element.limit(motion.normal), motion.tangential
    starts = start if isinstance(start, tuple) else (start, start)
    ratio = isinstance(starts[0], TractionRatio)
    values = np.array([rule.value for rule in starts])
    pair = values * limit[-1] if ratio else element.kt * (u[:, -1] - values)
    pair = pair * min(1.0, limit[-1] / max(np.hypot(*pair), 1e-300))
    traction, position, landings = complex(*pair), element.kt * (u[0] + 1j * u[1]), element.landings(motion.normal)
    found = np.empty(samples, dtype=complex)
    for _ in range(periods):
        last = traction
        for n in range(samples):
            moved = (1.0 - landings[n]) * (position[n] - position[n - 1])
            traction = stepped(traction, moved, limit[n - 1], limit[n])
            found[n] = traction
        if abs(traction - last) < 1e-14:
            break
    return np.array([found.real, found.imag])


def test_a_step_is_the_limit_of_many_small_projections():
    """The law itself: the spring's force projected onto the disc, over and over in small steps, extrapolated to none."""
    rng, turn = np.random.default_rng(3), np.empty(6)

    def projected(traction, change, before, after, pieces):
        for k in range(1, pieces + 1):
            limit = before + k / pieces * (after - before)
            traction = traction + change / pieces
            traction *= min(1.0, limit / max(abs(traction), 1e-300))
        return traction

    slipped = 0
    for _ in range(60):
        before, after = rng.uniform(0.05, 1.5, 2)
        traction = before * rng.uniform(0.0, 1.0) ** 0.3 * np.exp(2j * np.pi * rng.uniform())
        change = rng.uniform(0.0, 3.0) * np.exp(2j * np.pi * rng.uniform())
        coarse, fine = (projected(traction, change, before, after, pieces) for pieces in (20000, 40000))
        numbers = (traction.real, traction.imag, change.real, change.imag, before, after)
        slips, c, s = disc_step(*numbers, turn)
        found = after * complex(c, s) if slips else traction + change
        assert abs(found - (2.0 * fine - coarse)) < 2e-7
        slipped += slips
    assert slipped > 30


@pytest.mark.parametrize("limits", ["apart", "nearly equal", "equal"])
def test_derivatives_of_a_step(limits):
    """By both tractions, both changes and both limits, against central differences."""
    rng, turn = np.random.default_rng(5), np.empty(6)

    def traction_of(numbers):
        slips, c, s = disc_step(*numbers, np.empty(6))
        return numbers[5] * np.array([c, s]) if slips else np.array(numbers[:2]) + numbers[2:4]

    for _ in range(200):
        before, after = rng.uniform(0.05, 1.5, 2)
        if limits != "apart":
            after = before * (1.0 + (limits == "nearly equal") * 1.9e-3 * rng.choice([-1.0, 1.0]))
        traction = 0.999 * before * rng.uniform() * np.exp(2j * np.pi * rng.uniform())
        change = rng.uniform(0.3, 3.0) * np.exp(2j * np.pi * rng.uniform())
        numbers = np.array([traction.real, traction.imag, change.real, change.imag, before, after])
        slips, c, s = disc_step(*numbers, turn)
        if slips:
            for i, step in enumerate(1e-6 * np.eye(6)):
                expected = (traction_of(numbers + step) - traction_of(numbers - step)) / 2e-6
                found = after * turn[i] * np.array([-s, c]) + (i == 5) * np.array([c, s])
                np.testing.assert_allclose(found, expected, atol=1e-7 * (1.0 + np.abs(expected).max()) / min(before, 1.0) ** 2)


@each("seed", range(4))
@every_start
def test_forces_equal_brute_force_marching(sample, start, seed):
    w = random_motion(sample, H, np.random.default_rng(seed), size=(0.05, 0.4, 1.0, 4.0)[seed])
    expected = harmonics_of(marched(sample, start, w, NT), H)
    np.testing.assert_allclose(forces(sample, start, w, NT)[:2], expected, atol=1e-10)
    np.testing.assert_allclose(cycle(sample, start, w, NT).force[:2], marched(sample, start, w, NT), atol=1e-10)


@each("seed", range(4))
@every_start
def test_derivatives_equal_central_differences(sample, start, seed):
    """Own, other and normal direction; the edge of the disc is curved, so differences are exact to the square of the step."""
    w = random_motion(sample, H, np.random.default_rng(seed), size=(0.05, 0.3, 1.0, 4.0)[seed])
    here, step = answer(sample, start, w, NT), 1e-6
    for row in range(w.shape[0]):
        for column in range(w.shape[1]):
            ahead, behind = w.copy(), w.copy()
            ahead[row, column] += step
            behind[row, column] -= step
            difference = (answer(sample, start, ahead, NT).target - answer(sample, start, behind, NT).target) / (2.0 * step)
            for d in range(2):
                block = here.own[d] if row == d else here.normal[d] if row == 2 else here.cross[d]
                np.testing.assert_allclose(block[:, column], difference[d], atol=1e-6)


def test_every_state_is_met():
    states = set()
    for sample in DISC_SAMPLES:
        for start in STARTS.values():
            for seed in range(4):
                w = random_motion(sample, H, np.random.default_rng(seed), size=(0.05, 0.3, 1.0, 4.0)[seed])
                states |= set(answer(sample, start, w, NT).unknown[:2])
    assert states == {HELD, STATIC, SLIPPING}


@each("seed", range(4))
@every_start
def test_the_traction_stays_on_its_disc(sample, start, seed):
    w = random_motion(sample, H, np.random.default_rng(seed), size=2.0)
    element = sample.elements[0]
    limit = element.limit(motion_of(sample, w, NT).normal)
    force = cycle(sample, start, w, NT).force
    assert np.all(np.hypot(force[0], force[1]) <= limit + 1e-12)


def test_energy_in_is_energy_out_with_second_order(sample):
    """Work of the tractions over a period against Σ μN|Δs|."""
    errors = []
    for samples in (256, 2048):
        gaps = []
        for seed in range(30):
            w = random_motion(sample, 3, np.random.default_rng(seed))
            work = cycle_work(forces(sample, SliderOffset(), w, samples), w)[:2].sum()
            gaps.append(work - cycle(sample, SliderOffset(), w, samples).slip_work.sum())
        errors.append(np.sqrt(np.mean(np.square(gaps))))
    assert errors[1] < 2e-4
    assert np.log2(errors[0] / errors[1]) / 3.0 == pytest.approx(2.0, abs=0.4)


@pytest.mark.parametrize("size", [0.3, 1.0, 4.0])
def test_motion_along_one_direction_is_macroslip(size):
    """Along t1 alone, and turned by any angle, the disc is the law of one direction."""
    disc, line = DISC_SAMPLES[0], Macroslip(2.0, 0.4, normal_load=1.5)
    u = random_motion(disc, H, np.random.default_rng(1), size)[:1]
    angle = 0.7
    turned = np.vstack([np.cos(angle) * u, np.sin(angle) * u])
    single = type(disc)("line", line, 1, disc.elements)
    expected = forces(single, SliderOffset(), u, NT)
    found = forces(disc, SliderOffset(), turned, NT)
    np.testing.assert_allclose(found, np.vstack([np.cos(angle) * expected, np.sin(angle) * expected]), atol=1e-12)


def test_circular_motion_has_the_traction_of_closed_form():
    """u = A (cos θ, sin θ), gross slip: |T| = μN, the slider on a circle of radius √(A² − (μN/kt)²); of second order."""
    kt, limit, radius = 2.0, 0.6, 1.0
    w = np.array([[0.0, radius, 0.0], [0.0, 0.0, radius]])
    slider = np.sqrt(radius**2 - (limit / kt) ** 2)
    errors = []
    for samples in (256, 2048):
        found = forces(DISC_SAMPLES[0], SliderOffset(), w, samples)
        assert np.hypot(found[0, 1], found[0, 2]) == pytest.approx(limit, rel=1e-9)
        errors.append(abs(cycle_work(found, w).sum() / (2.0 * np.pi * limit * slider) - 1.0))
    assert errors[0] < 3e-4
    assert np.log2(errors[0] / errors[1]) / 3.0 == pytest.approx(2.0, abs=0.05)


def test_a_slow_creep_ends():
    """Nearly straight motion creeps to its steady state at a rate of 0.94 a period; the limit is found all the same."""
    rng = np.random.default_rng(0)
    for _ in range(40):
        w = random_motion(DISC_SAMPLES[0], 5, rng, size=0.3)
        w[1] *= 0.3
        assert np.all(np.isfinite(answer(DISC_SAMPLES[0], (TractionRatio(0.4), TractionRatio(0.4)), w, 256).target))


def contact(start, law=None):
    directions = (between("1.x", "ground"), between("1.y", "ground"))
    return Contact("disc", law or FrictionDisc(1.0, 0.5, normal_load=1.0), directions, None, start)


def test_faulty_starts_and_directions_are_refused():
    with pytest.raises(InputError, match="slider offset or a traction ratio"):
        contact(MeanTraction(0.1))
    with pytest.raises(InputError, match="size of at most 1"):
        contact((TractionRatio(0.8), TractionRatio(0.8)))
    with pytest.raises(InputError, match="two tangential directions"):
        Contact("disc", FrictionDisc(1.0, 0.5, normal_load=1.0), (between("1.x", "ground"),))
    with pytest.raises(InputError, match="exactly one of the two"):
        FrictionDisc(1.0, 0.5)
