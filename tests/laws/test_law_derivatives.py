"""Derivatives of the contact forces of every law against differences: off kinks, clipped at the start, and on kinks.

Between two kinks friction is linear in the motion, and so are its limits; normal forces bend a little, as openings grow. Central
differences are exact up to rounding wherever both sides lie on the same piece: forward and backward differences then agree.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from each import each
from laws.conftest import STARTS, every_start
from laws.kernel import answer, forces, random_motion
from laws.marching import marched, reachable, sampled, wanted_traction
from laws.samples import SAMPLES, Element, Sample

from stickslip.model.contact.cubic import Gap
from stickslip.model.contact.macroslip import Macroslip
from stickslip.model.contact.point import MeanTraction, SliderOffset, TractionRatio
from stickslip.model.contact.protocol import HELD, SLIPPING, STATIC

H, NT = 3, 64
STEP = 3e-8


@dataclass(frozen=True)
class Differences:
    """One-sided differences of λ̂ along a direction, (rows, 2H+1), and the derivative that the kernel gives."""

    forward: np.ndarray
    backward: np.ndarray
    derivative: np.ndarray

    def on_one_piece(self) -> bool:
        return bool(np.abs(self.forward - self.backward).max() < 1e-5)


def differences(sample: Sample, start, w: np.ndarray, direction: np.ndarray, samples: int = NT) -> Differences:
    """Along a direction (rows, 2H+1) of the motion."""
    here, ahead, behind = (answer(sample, start, w + s * STEP * direction, samples) for s in (0.0, 1.0, -1.0))
    along = np.einsum("rij,rj->ri", here.own, direction)
    if sample.law.has_normal:
        rubbing = slice(0, sample.tangential)
        along[rubbing] += np.einsum("rij,j->ri", here.normal[rubbing], direction[-1])
    if sample.tangential == 2:
        along[:2] += np.einsum("rij,rj->ri", here.cross[:2], direction[1::-1])
    return Differences((ahead.target - here.target) / STEP, (here.target - behind.target) / STEP, along)


def unit_directions(w: np.ndarray) -> list[np.ndarray]:
    directions = []
    for row in range(w.shape[0]):
        for column in range(w.shape[1]):
            direction = np.zeros_like(w)
            direction[row, column] = 1.0
            directions.append(direction)
    return directions


@each("seed", range(4))
@every_start
def test_derivatives_equal_central_differences(sample, start, seed):
    """All columns, at random motions of every size; a column across a kink within the tiny step would be no fault but is rare."""
    w = random_motion(sample, H, np.random.default_rng(seed), size=(0.05, 0.3, 1.0, 4.0)[seed])
    for direction in unit_directions(w):
        found = differences(sample, start, w, direction)
        assert found.on_one_piece()
        central = 0.5 * (found.forward + found.backward)
        np.testing.assert_allclose(found.derivative, central, atol=1e-6)


def test_the_random_motions_reach_every_state():
    """Held, tied to its limit or slipping: the differences above are taken in all three states, with every start rule."""
    reached = {}
    for name, start in STARTS.items():
        reached[name] = set()
        for sample in SAMPLES:
            for seed in range(4):
                w = random_motion(sample, H, np.random.default_rng(seed), size=(0.05, 0.3, 1.0, 4.0)[seed])
                reached[name] |= set(answer(sample, start, w, NT).unknown[: sample.tangential])
    assert reached["virgin"] >= {HELD, SLIPPING}
    for name in ("far offset", "ratio", "full ratio", "mean", "large mean"):
        assert reached[name] >= {STATIC, SLIPPING}


VARYING = Sample("varying", Macroslip(2.0, 0.5, 1.5, 2.0), 1, (Element(2.0, 0.5, 1.5, preload=2.0),))


def stuck_motion(seed: int) -> np.ndarray:
    """Motion that never leaves the stick range of the steady period: the start alone decides."""
    return random_motion(VARYING, H, np.random.default_rng(seed), size=0.12)


def first_sweep(start, w: np.ndarray) -> tuple[float, float, float, float]:
    """Wanted traction at the last sample, the limit there, and the lowest and highest steady traction there."""
    u, z = sampled(w, NT)
    element = VARYING.elements[0]
    limit = element.limit(z)
    return wanted_traction(start, element.kt, u, limit, 0, 1), limit[-1], *reachable(element.kt, u, limit)


@each("seed", range(6))
@each("sign", [-1.0, 1.0])
@each("rule", [SliderOffset, MeanTraction], ids=lambda rule: rule.key)
def test_clipped_at_the_start(rule, sign, seed):
    """A start beyond the limit at the last sample: the traction there is the bound that one sample of the period sets."""
    w, start = stuck_motion(seed), rule(sign * 50.0)
    wanted, limit, low, high = first_sweep(start, w)
    assert abs(wanted) > limit
    assert low < high
    assert answer(VARYING, start, w, NT).unknown[0] == STATIC
    check_all_columns(start, w)


@each("seed", range(6))
@each("sign", [-1.0, 1.0])
@each("rule", [SliderOffset, TractionRatio, MeanTraction], ids=lambda rule: rule.key)
def test_slipping_in_the_first_sweep_only(rule, sign, seed):
    """A start within the limit at the last sample that slips once on its way round and then sticks for ever."""
    w = stuck_motion(seed)
    start = rule(0.0)
    _, limit, low, high = first_sweep(start, w)
    bound = high if sign > 0.0 else low
    within = bound + 0.5 * (sign * limit - bound)
    value = {"slider_offset": sampled(w, NT)[0][-1] - within / 2.0, "traction_ratio": within / limit}
    u = sampled(w, NT)[0]
    value["mean_traction"] = within + 2.0 * (np.mean(u) - u[-1])
    start = rule(value[rule.key])
    wanted, *_ = first_sweep(start, w)
    assert limit >= abs(wanted) > abs(bound)
    element = VARYING.elements[0]
    sweep = marched(element.kt, u, element.limit(sampled(w, NT)[1]), wanted)
    assert sweep[-1] == pytest.approx(bound, abs=1e-14)
    assert answer(VARYING, start, w, NT).unknown[0] == STATIC
    check_all_columns(start, w)


def check_all_columns(start, w: np.ndarray) -> None:
    for direction in unit_directions(w):
        found = differences(VARYING, start, w, direction)
        assert found.on_one_piece()
        np.testing.assert_allclose(found.derivative, found.forward, atol=1e-6)


def matches_one_side(found: Differences) -> bool:
    errors = [np.abs(found.derivative - side).max(axis=1) for side in (found.forward, found.backward)]
    return bool(np.minimum(*errors).max() < 1e-6)


def check_kink(sample: Sample, start, w: np.ndarray, samples: int = NT) -> None:
    """Along many directions the derivative of each row is that of one side; along some the sides differ, so there is a kink."""
    rng = np.random.default_rng(0)
    directions = [*unit_directions(w), *rng.standard_normal((20, *w.shape))]
    found = [differences(sample, start, w, direction, samples) for direction in directions]
    assert not all(f.on_one_piece() for f in found)
    assert all(matches_one_side(f) for f in found)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_on_a_limit_touched_exactly(sign):
    """kt u(0) = μN exactly, all other samples below: u = (cos θ + ½ cos 2θ)/2 has one highest sample."""
    sample = Sample("touched", Macroslip(2.0, 0.5, normal_load=3.0), 1, (Element(2.0, 0.5, load=3.0),))
    w = sign * np.array([[0.0, 0.5, 0.0, 0.25, 0.0, 0.0, 0.0]])
    assert np.max(np.abs(forces(sample, SliderOffset(), w, NT)[0])) < 1.5
    assert answer(sample, SliderOffset(), w, NT).unknown[0] == HELD
    check_kink(sample, SliderOffset(), w)


def test_on_a_limit_that_varies_touched_exactly():
    sample = Sample("touched", Macroslip(2.0, 0.5, 1.0, 2.0), 1, (Element(2.0, 0.5, 1.0, preload=2.0),))
    w = np.array([[0.0, 0.5, 0.0, 0.25, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]])
    assert answer(sample, SliderOffset(), w, NT).unknown[0] == HELD
    check_kink(sample, SliderOffset(), w)


@pytest.mark.parametrize(
    "sample",
    [
        Sample("gap", Gap(1.0, preload=1.0), 0, (Element(kn=1.0, preload=1.0),)),
        Sample("rubbing", Macroslip(2.0, 0.5, 1.0, 1.0), 1, (Element(2.0, 0.5, 1.0, preload=1.0),)),
    ],
    ids=lambda sample: sample.name,
)
@pytest.mark.parametrize("start", [SliderOffset(0.1), TractionRatio(0.5), MeanTraction(0.2)], ids=lambda start: start.key)
def test_on_a_normal_load_of_zero_exactly(sample, start):
    """z = −cos θ + N0: N falls to zero in one sample and no further."""
    z = np.array([[0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]])
    u = np.array([[0.1, 0.2, -0.1, 0.05, 0.0, 0.02, 0.0]])
    w = np.concatenate([u, z]) if sample.tangential else z
    assert sampled(z, NT).min() == -1.0
    check_kink(sample, start, w)
